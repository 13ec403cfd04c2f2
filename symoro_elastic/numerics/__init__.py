"""Models in numbers: `evaluation` at states, what is `linear` in parameters, the `motion` of a machine, `verification`
by references in many digits, `guarantees` on a box of arguments, and fewer operations `within` a tolerance.
"""
