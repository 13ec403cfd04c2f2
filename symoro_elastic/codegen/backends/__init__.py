"""Models as functions of other libraries: array libraries such as JAX, CasADi, SymPy."""
