"""Names of the entries of arguments of generated functions, and of the variables of derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symoro_elastic.machine.machine import KnownOfBase, Machine
from symoro_elastic.quantities import QUANTITIES, Quantity, Role

PARAMETERS = "p"
"""Stands for the parameters, where derivatives are taken by them."""


def arguments(machine: Machine) -> dict[str, tuple[str, ...]]:
    """Names of the entries of the arguments."""
    numbers = {"n": machine.independent, "m": machine.motors, "d": machine.dependent, "": ()}
    numbers |= {"b": machine.bristles, "l": machine.loaded}
    of = {letter: {j: str(machine.joint(j).variable) for j in joints} for letter, joints in numbers.items()}
    of["s"] = {j: str(joint.variable) for j, joint in machine.static_springs.items()}
    of["w"] = {k: str(wrench) for k, wrench in enumerate(machine.forces, start=1)}
    inputs = [row for row in QUANTITIES.values() if {Role.ARGUMENT, Role.COLUMN} & {*row.roles}]
    rows = [row for row in inputs if row.entries or row.follows]
    return {row.name: _entries(row, of[row.follows]) for row in rows}


def _entries(row: Quantity, variables: Mapping[int, str]) -> tuple[str, ...]:
    if not row.entries:
        return tuple(variables.values())
    entries = row.entries if isinstance(row.entries, tuple) else (row.entries,)
    return tuple(entry.replace("@", str(j)) for j in variables for entry in entries) if row.follows else entries


def column_names(machine: Machine, columns: Sequence[str]) -> tuple[str, ...]:
    """Names that the columns of derivatives may be chosen by: parameters, or arguments and their entries.

    `columns` are the arguments that derivatives are taken by, those of the base left out.
    """
    if PARAMETERS in columns:
        return tuple(parameter.name for parameter in machine.parameters)
    if not columns:
        return ()
    entries = arguments(machine)
    return tuple(name for argument in (*columns, *columns_of_base(machine)) for name in (argument, *entries[argument]))


def columns_of_base(machine: Machine) -> tuple[str, ...]:
    """Arguments of derivatives that a freely moving base adds."""
    return tuple(name for fixed in known_of_base(machine) for name in ("pose", "V0", fixed))


def known_of_base(machine: Machine) -> tuple[str, ...]:
    """The base's prescribed quantity, V0d or f0, as an argument of functions; nothing for a fixed base."""
    if machine.floating is None:
        return ()
    return ("V0d",) if machine.floating.known is KnownOfBase.ACCELERATION else ("f0",)
