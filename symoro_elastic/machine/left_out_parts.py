"""A machine without rotors or springs, for formats that have none."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from symoro_elastic.machine.columns import Cell, with_cells
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.joints import Joint, Kind
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import with_held_joints

ROTORS, SPRINGS = "rotors", "springs"
PARTS = (ROTORS, SPRINGS)
"""Parts that a machine may be written without."""
SECTIONS = {ROTORS: "motors", SPRINGS: "springs"}


def without(machine: DescribedMachine, parts: Collection[str]) -> tuple[DescribedMachine, tuple[str, ...]]:
    """Return the machine without these parts, and a remark for each that names the joints; others stay as they are.

    Without springs elastic joints are held where these are neutral; without rotors their inertia is lost. Raises
    `InputError` for elastic joints that cannot be held.
    """
    remarks = []
    if SPRINGS in parts:
        machine, remark = _without_springs(machine)
        remarks += remark
    if ROTORS in parts:
        names = _with_cells_of(machine, ROTORS)
        machine = replace(machine, joints=tuple(_cleared(joint, ROTORS) for joint in machine.joints))
        remarks += [f"left out: the rotors of {', '.join(names)}, whose inertia is lost"] if names else []
    return machine, tuple(remarks)


def _without_springs(machine: DescribedMachine) -> tuple[DescribedMachine, list[str]]:
    elastic = {joint.name: joint.spring.neutral for joint in machine.joints if joint.kind is Kind.ELASTIC}
    names = dict.fromkeys((*elastic, *_with_cells_of(machine, SPRINGS)))
    held = with_held_joints(machine, elastic, "locked")
    held = replace(held, joints=tuple(_cleared(joint, SPRINGS) for joint in held.joints))
    what = f"left out: the springs of {', '.join(names)}; elastic joints are fixed where these are neutral"
    return held, [what] if names else []


def _with_cells_of(machine: Machine, part: str) -> list[str]:
    """Names of joints that have numbers of a part."""
    return [joint.name for joint in machine.joints if _cleared(joint, part) != joint]


def _cleared(joint: Joint, part: str) -> Joint:
    def change(cell: Cell, formula: Formula) -> Formula:
        return ZERO if cell.column.section == SECTIONS[part] else formula

    return with_cells(joint, change)
