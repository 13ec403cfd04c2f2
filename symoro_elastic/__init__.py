"""Symbolic models of robots and machine tools with elastic joints, as numpy and C code.

A machine is a tree of bodies on revolute, prismatic and fixed joints that are driven by motors, elastic or passive,
described by the geometric parameters of Khalil and Kleinfinger. The recursions of Khalil and Gautier, *Modeling of
high speed machines using robotics formulation*, run on the symbols of its table; what remains is pruned, scheduled
and written as functions without dependencies, or as equations. `symoro-elastic --help` lists what else is computed:
modes, frequency responses, feed-forward torques, identification.

from symoro_elastic.machine.formats import read_machine

machine, warnings = read_machine("examples/two_axis.toml")

In Python, each command's work is a function of the room named as in `--help`: see the docstrings of
`symoro_elastic.pipeline` (models and code), `vibration`, `identification` and `trade`.
"""

__version__ = "0.1.0"
