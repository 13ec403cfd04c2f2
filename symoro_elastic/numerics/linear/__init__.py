"""Linear properties of a machine's motions: independent columns, and base parameters by rank."""
