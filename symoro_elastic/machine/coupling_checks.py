"""What is wrong with joints that follow the variables of others, and with ratios and shares of motors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import quoted

Fault = tuple[str, str]
"""Key of a joint, and what is wrong with it."""


def row_faults(joint: Joint) -> Iterator[Fault]:
    """Faults of one row: a coupled joint with a spring or a motor, a share or a ratio without its motor."""
    if joint.kind == Kind.COUPLED:
        for what, key in _on_coupled(joint):
            advice = f"add one to the cell, or move the {what} to a joint that has"
            yield key, f"a coupled joint has no variable of its own: {advice}"
    if not joint.sharing.is_zero and joint.kind not in (Kind.MOTOR, Kind.CUT):
        yield "sharing", f"the joint is {joint.kind.value}: only motors share a torque"
    if not joint.ratio.is_zero and joint.rotor_inertia.is_zero:
        yield "ratio", "a ratio needs a rotor_inertia, that of the rotor about its own axis"


def _on_coupled(joint: Joint) -> Iterator[tuple[str, str]]:
    """What stands on a coupled joint and belongs to a variable, with its key."""
    yield from (("spring", cell.label) for cell, formula in cells(joint.spring) if not formula.is_zero)
    if not joint.sharing.is_zero:
        yield "motor", "sharing"


def cell_faults(machine: Machine) -> Iterator[tuple[int, Fault]]:
    """Faults of cells that hold the variables of other joints, with the number of the joint.

    Doubled own variables, coupled joints that follow nothing, and cycles.
    """
    for j in machine.articulated:
        joint = machine.joint(j)
        key, names = SELECTED[joint.sigma], joint.selected.names
        if joint.variable in names:
            yield j, (key, f"{joint.variable!r} stands in the cell twice: a joint is its variable plus those of others")
        if joint.kind == Kind.COUPLED and names.isdisjoint(machine.variables):
            what = f"{quoted(joint.selected)} holds no variable of another joint"
            yield j, (key, f"{what}: a joint that does not move is fixed, with sigma = 2")
    yield from _cycle(machine)


def _cycle(machine: Machine) -> Iterator[tuple[int, Fault]]:
    """The first cycle of cells that need each other's variables."""
    needs = {
        j: [machine.variables[name] for name in sorted(machine.joint(j).selected.names) if name in machine.variables]
        for j in machine.articulated
    }
    try:
        TopologicalSorter(needs).prepare()
    except CycleError as error:
        around: list[int] = error.args[1][:0:-1]
        first = around.index(min(around))
        j, *others = around[first:] + around[:first]
        cell = SELECTED[machine.joint(j).sigma]
        needed = [*(str(machine.joint(other).variable) for other in others), cell]
        if others:
            yield j, (cell, f"{cell} needs {', which needs '.join(needed)}: break the cycle")


def share_faults(machine: Machine, values: Mapping[str, float]) -> Iterator[tuple[int, Fault]]:
    """Shares of torque that are negative, with the number of the joint."""
    for j, joint in enumerate(machine.joints, start=1):
        share: Formula = joint.sharing
        if share.names <= values.keys() and share.value(values) < 0:
            yield j, ("sharing", f"{quoted(share)} is negative: {share.value(values):g}")


def share_warnings(machine: Machine) -> list[str]:
    """Warnings about shares of motors that turn and of motors that slide."""
    sharing = [machine.joint(j) for j in machine.motors if not machine.joint(j).sharing.is_zero]
    turning, sliding = ([joint.name for joint in sharing if joint.sigma == sigma] for sigma in (0, 1))
    if not turning or not sliding:
        return []
    return [f"sharing: {turning[0]} turns and {sliding[0]} slides: N m and N are weighed alike"]
