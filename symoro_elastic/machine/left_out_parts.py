"""A machine without some of its parts, for formats that cannot hold them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

from symoro_elastic.machine.columns import Cell, Dimension, with_cells
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint, Kind
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import with_held_joints

ROTORS, SPRINGS, LOOPS = "rotors", "springs", "loops"
WRENCHES, BACKLASH, CREEP, SHARING, COGGING = "wrenches", "backlash", "creep", "sharing", "cogging"
BALL = "ball"
PARTS = (ROTORS, SPRINGS, LOOPS, WRENCHES, BACKLASH, CREEP, SHARING, COGGING, BALL)
"""Parts that a machine may be written without."""
CELLS: dict[str, Callable[[Cell], bool]] = {
    ROTORS: lambda cell: cell.column.section == "motors",
    SPRINGS: lambda cell: cell.column.section == "springs",
    WRENCHES: lambda cell: cell.column.section == "wrenches",
    BACKLASH: lambda cell: cell.column.dimension is Dimension.BACKLASH,
    CREEP: lambda cell: cell.column.section == "friction" and cell.column.key not in ("viscous", "coulomb"),
    SHARING: lambda cell: cell.column.key == "sharing",
    COGGING: lambda cell: cell.column.key.startswith("cogging"),
    BALL: lambda cell: cell.column.key == BALL,
}
"""Whether a cell is one of a part."""
LOST = {
    ROTORS: "the rotors of {}, whose inertia is lost",
    WRENCHES: "the wrenches on the bodies {}",
    BACKLASH: "the backlash of {}, whose springs are straight",
    CREEP: "what makes dry friction of {} smooth: it jumps at rest",
    SHARING: "the weights by which {} share torques",
    COGGING: "the cogging of {}",
    BALL: "the damping of the ball joints that end with {}",
}


def without(machine: DescribedMachine, parts: Collection[str]) -> tuple[DescribedMachine, tuple[str, ...]]:
    """Return the machine without these parts, and a remark with the joints of each; other parts stay.

    Without loops their ends are frames, and their passive joints are driven as others are; without springs elastic
    joints are held where these are neutral; without rotors their inertia is lost. Raises `InputError` for elastic
    joints that cannot be held.
    """
    remarks: list[str] = []
    if LOOPS in parts:
        machine, remark = _without_loops(machine)
        remarks += remark
    if SPRINGS in parts:
        machine, remark = _without_springs(machine)
        remarks += remark
    for part, what in LOST.items():
        names = _with_cells_of(machine, part) if part in parts else []
        if names:
            machine = replace(machine, joints=tuple(_without_part(joint, part) for joint in machine.joints))
            remarks.append(f"left out: {what.format(', '.join(names))}")
    return machine, tuple(remarks)


def _without_loops(machine: DescribedMachine) -> tuple[DescribedMachine, list[str]]:
    """The tree without loops: a cut joint becomes the frame that meets the other end of its loop."""
    ends = [
        f"{loop.name} ({machine.joint(loop.cut).name} and {machine.joint(loop.meets).name})" for loop in machine.loops
    ]
    following = {j for j in machine.in_loops if machine.joint(j).kind is Kind.PASSIVE}
    passive = [machine.joint(j).name for j in sorted(following)]
    rows = enumerate(machine.joints, start=1)
    tree = replace(machine, joints=tuple(_row_of_tree(joint, j in following) for j, joint in rows), loops=())
    if not ends:
        return machine, []
    remarks = [f"left out: the loops {', '.join(ends)}, which are open: the frames in brackets should meet"]
    driven = f"joints of the loops without motors are driven like others: {', '.join(passive)}"
    return tree, [*remarks, *([driven] if passive else [])]


def _row_of_tree(joint: Joint, was_passive: bool) -> Joint:
    """A joint after the loops are opened: a cut joint becomes fixed, one that `was_passive` driven by a motor."""
    if joint.kind is Kind.CUT:
        return replace(joint, kind=Kind.FIXED, sigma=2, variable=None)
    return replace(joint, kind=Kind.MOTOR) if was_passive else joint


def _without_springs(machine: DescribedMachine) -> tuple[DescribedMachine, list[str]]:
    elastic = {joint.name: joint.spring.neutral for joint in machine.joints if joint.kind is Kind.ELASTIC}
    names = [*dict.fromkeys((*elastic, *_with_cells_of(machine, SPRINGS)))]
    locked = with_held_joints(machine, elastic, "locked")
    locked = replace(locked, joints=tuple(_without_part(joint, SPRINGS) for joint in locked.joints))
    what = f"left out: the springs of {', '.join(names)}; elastic joints are fixed where these are neutral"
    return locked, [what] if names else []


def _with_cells_of(machine: Machine, part: str) -> list[str]:
    """Names of joints with a number of a part."""
    return [joint.name for joint in machine.joints if _without_part(joint, part) != joint]


def _without_part(joint: Joint, part: str) -> Joint:
    def change(cell: Cell, formula: Formula) -> Formula:
        return cell.column.default if CELLS[part](cell) else formula

    return with_cells(joint, change)
