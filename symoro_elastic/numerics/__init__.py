"""Models in numbers: the `motion` of a machine, `verification` by references in many digits, `guarantees` on a box of
arguments, and programs with fewer operations `within` a tolerance; here what they share: states, ranks, values.
"""
