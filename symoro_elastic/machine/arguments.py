"""Names of the entries of arguments of generated functions, and of the variables of derivatives."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.machine.machine import Given, Machine
from symoro_elastic.quantities import QUANTITIES, Quantity, Role

PARAMETERS = "p"
"""Stands for the parameters, where derivatives are taken by them."""


def arguments(machine: Machine) -> dict[str, tuple[str, ...]]:
    """Names of the entries of each argument."""
    of = {"n": machine.moving, "m": machine.motors, "d": machine.dependent, "": ()}
    inputs = [row for row in QUANTITIES.values() if {Role.ARGUMENT, Role.COLUMN} & {*row.roles}]
    rows = [row for row in inputs if row.entries or row.follows]
    return {row.name: _entries(machine, row, of[row.follows]) for row in rows}


def _entries(machine: Machine, row: Quantity, joints: Sequence[int]) -> tuple[str, ...]:
    if isinstance(row.entries, tuple):
        return row.entries
    if not row.entries:
        return tuple(str(machine.joint(j).variable) for j in joints)
    return tuple(row.entries.replace("@", str(j)) for j in joints)


def column_names(machine: Machine, columns: Sequence[str]) -> tuple[str, ...]:
    """Names that the columns of derivatives may be chosen by: parameters, or arguments and their entries.

    `columns` are the arguments that derivatives are taken by, those of a floating base left out.
    """
    if PARAMETERS in columns:
        return tuple(parameter.name for parameter in machine.parameters)
    if not columns:
        return ()
    entries = arguments(machine)
    return tuple(name for argument in (*columns, *columns_of_base(machine)) for name in (argument, *entries[argument]))


def columns_of_base(machine: Machine) -> tuple[str, ...]:
    """What derivatives are taken by on a floating base, in addition."""
    if machine.floating is None:
        return ()
    return "pose", "V0", "V0d" if machine.floating.known is Given.ACCELERATION else "f0"
