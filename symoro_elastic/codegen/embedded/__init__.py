"""Costs of compiled C on a processor: stack, code size and instructions, from the compiler's output."""
