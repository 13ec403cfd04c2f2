"""Functions of a program as Structured Text of IEC 61131-3."""
