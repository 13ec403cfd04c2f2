"""What compiled C costs a processor: stack, code and instructions, read from what the compiler wrote."""
