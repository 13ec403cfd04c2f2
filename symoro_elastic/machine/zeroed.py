"""Numbers of bodies and rotors that a scene leaves out: they are zero.

A number is named by its joint and its column, as in cart_y.mass, ram.XX, ram.center_of_mass.z, motor_y.rotor_inertia.
Whole numbers keep the structure of a machine: its inertia matrix is symmetric, and nothing is made from nothing.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Cell, Dimension, cells, with_cells
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.names import did_you_mean, quote

BODIES = "bodies"
"""The table whose numbers may be left out, beside rotor inertias."""


def numbers_of(machine: Machine) -> dict[str, Formula]:
    """The numbers of bodies and rotors that are not zero, by name."""
    named = ((name_of(joint, cell), x) for joint in machine.joints for cell, x in cells(joint) if _is_inertia(cell))
    return {name: x for name, x in named if not x.is_zero}


def name_of(joint: Joint, cell: Cell) -> str:
    """The name of a number of a joint."""
    return f"{joint.name}.{cell.name}"


def with_zeros(machine: AnyMachine, names: Collection[str]) -> AnyMachine:
    """The machine in which these numbers are zero."""
    if not names:
        return machine
    joints = tuple(_zeroed(joint, names) for joint in machine.joints)
    return replace(machine, joints=joints, static={j: _zeroed(row, names) for j, row in machine.static.items()})


def refuse_unknown(machine: Machine, names: Collection[str], source: str) -> None:
    """Raise `InputError` for what is no number of a body or a rotor, or is zero."""
    known = numbers_of(machine)
    for name in names:
        if name not in known:
            what = f"no body or rotor has a number {quote(name)}{did_you_mean(name, known)}"
            raise InputError(source, "scene, zero", what)


def _zeroed(joint: Joint, names: Collection[str]) -> Joint:
    return with_cells(joint, lambda cell, x: ZERO if _is_inertia(cell) and name_of(joint, cell) in names else x)


def _is_inertia(cell: Cell) -> bool:
    return cell.column.section == BODIES or cell.column.dimension is Dimension.ROTOR_INERTIA
