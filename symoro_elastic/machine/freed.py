"""Numbers of the table as parameters of generated code, so that they can be changed without generating again."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from symoro_elastic.machine.columns import Cell, with_cells
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Parameter
from symoro_elastic.machine.names import IN_USE, NONE, Reasons, why_reserved

SECTIONS = ("bodies", "springs", "motors", "friction", "wrenches")
"""Tables whose numbers may become parameters; lengths and angles are the structure of a machine."""
STEMS = {"center_of_mass": "c", "damping": "d", "neutral": "n"}
"""Of the names of columns that have no symbol of their own in .par files."""


def with_free_numbers(machine: AnyMachine, sections: Collection[str], taken: Reasons = NONE) -> AnyMachine:
    """Return the machine with the numbers of these tables as parameters: M3, XX3, k13, IA1 ... with their values.

    The number is that of the joint. Zeros stay: they are structure. Where a name is used already, or `taken`, or one
    of generated code, it is free_M3 instead.
    """
    own = {p.name for p in machine.parameters}.union(joint.variable or "" for joint in machine.joints)
    used = {**taken, **dict.fromkeys({machine.name, *own, *(joint.name for joint in machine.joints)}, IN_USE)}
    named: list[Parameter] = []
    joints = tuple(_freed(joint, j, sections, used, named) for j, joint in enumerate(machine.joints, start=1))
    return replace(machine, joints=joints, parameters=(*machine.parameters, *named))


def _freed(joint: Joint, j: int, sections: Collection[str], used: dict[str, str], named: list[Parameter]) -> Joint:
    def free(cell: Cell, formula: Formula) -> Formula:
        left_out = formula.is_zero or formula == cell.column.default
        if formula.names or left_out or cell.column.section not in sections:
            return formula
        name = unused_name(f"{_stem(cell)}{j}", used)
        used[name] = IN_USE
        named.append(Parameter(name, formula, joint.unit_of(cell)))
        return Formula.parse(name)

    return with_cells(joint, free)


def _stem(cell: Cell) -> str:
    """Return the name of a column in a parameter: that of .par files, such as XX, or a letter and an axis."""
    stem = STEMS.get(cell.column.key)
    if stem is None:
        return cell.par
    return stem + (cell.column.parts[cell.index] if cell.column.parts else "")


def unused_name(name: str, used: Reasons) -> str:
    """The name of a parameter, or one like it where it is used or cannot be one."""
    candidates: Sequence[str] = (name, f"free_{name}", *(f"free_{name}_{k}" for k in range(1, len(used) + 1)))
    return next(one for one in candidates if why_reserved(one, used) is None)
