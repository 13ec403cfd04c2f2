"""The public functions of the package, as the command line and `import symoro_elastic` offer them.

Machines are given as files, tables of Python or machines already read; scenes likewise.
"""
