"""Models of a machine: the one place where the machine, the equations and the symbols meet."""
