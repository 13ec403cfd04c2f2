"""The assembled position of a machine at the start of its loops, and others near it."""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Mapping, Sequence

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.assembly import SEED, Assembly, Position
from symoro_elastic.models.loops.closed_forms import Angles, agrees, mapped
from symoro_elastic.models.loops.continuation import CLOSED
from symoro_elastic.models.loops.independent_rows import (
    independent,
    independent_rows,
    refuse_singular,
    refuse_wrong_number,
)
from symoro_elastic.models.loops.open_loops import not_closed, open_positions
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

SAMPLES, DRAWS, REACH, GUESSES = 4, 16, 0.3, 12
ROUGH = 0.2
"""How far a start may be off, rad or m."""


def assembled_start(machine: Machine, assembly: Assembly) -> Position:
    """The position where the loops close, near the start of the file; raises `InputError` where there is none."""
    parallelograms = _parallelograms(machine, assembly)
    rough = _mapped_start(machine, assembly, parallelograms)
    _refuse_doubt(machine, assembly, rough, parallelograms)
    found, error = assembly.assembled(rough, machine.dependent)
    if not error < CLOSED:
        found, error = assembly.assembled(rough, machine.owners)
        if error < CLOSED:
            kept = independent_rows(assembly, [found])
            refuse_wrong_number(machine, assembly, kept)
            refuse_singular(machine, assembly, kept, [found])
        error = error if all(abs(found[j] - rough[j]) < ROUGH for j in machine.moving) else math.inf
    if not error < CLOSED:
        _refuse_singular_anywhere(machine, assembly)
        raise not_closed(machine, assembly, rough)
    return found


def _refuse_singular_anywhere(machine: Machine, assembly: Assembly) -> None:
    """Refuse dependent variables that depend on each other wherever joints stand, closed or not.

    Where loops close the rank of W is at most what it is elsewhere.
    """
    positions = open_positions(machine)
    columns = independent([assembly.numbers(position)[1].T for position in positions])
    if len(columns) >= len(machine.dependent):
        refuse_singular(machine, assembly, range(len(assembly.equations)), positions)


def positions_near(machine: Machine, assembly: Assembly, start: Position) -> list[Position]:
    """Other assembled positions on the branch of the start, nearer to it where others are not reached.

    A parallelogram that holds at the start holds at each of them: where it is flat another branch begins.
    """
    source, found, reach = random.Random(SEED), list[Position](), REACH
    holding = [x for x in _parallelograms(machine, assembly).values() if _hold(assembly, x, start)]
    mapped_joints = {j for angles in holding for j in angles}
    for _ in range(DRAWS):
        target = {j: start[j] + source.uniform(-reach, reach) for j in machine.moving}
        if mapped_joints.issuperset(machine.dependent):
            found.append(_mapped(assembly, holding, start | target))
        elif moved := assembly.moved(start, target):
            found += [moved] if all(_hold(assembly, x, moved) for x in holding) else []
        else:
            reach /= 2
        if len(found) == SAMPLES:
            break
    return found


def _hold(assembly: Assembly, angles: Angles, position: Position) -> bool:
    """Whether a loop is a parallelogram at a position, not crossed."""
    return all(agrees(assembly.bound, assembly, j, x, [position]) for j, x in angles.items())


def _mapped(assembly: Assembly, parallelograms: Sequence[Angles], position: Position) -> Position:
    """A position with the dependent joints of parallelograms where their angles are, those first that others need."""
    for angles in parallelograms:
        offsets = {j: assembly.bound.offset(j) for j in angles}
        value = evaluate([*angles.values(), *offsets.values()], assembly.symbols(position), FLOATS)
        position = position | {j: float(value(x) - value(offsets[j])) for j, x in angles.items()}
    return position


def _refuse_doubt(machine: Machine, assembly: Assembly, rough: Position, parallelograms: Collection[str]) -> None:
    """Refuse a loop that may be closed in several positions and has no start; parallelograms have one."""
    for loop in machine.loops:
        dependent = machine.dependent_in(loop)
        if loop.start or not dependent or loop.name in parallelograms:
            continue
        found = _other_positions(machine, assembly, rough, dependent)
        if len(found) > 1:
            joint = machine.joint(dependent[0])
            values = " or ".join(f"{x[dependent[0]]:.2f}" for x in found)
            count = {2: "two"}.get(len(found), str(len(found)))
            what = f"{count} positions ({joint.variable} = {values}): write start = {{ ... }}"
            raise machine.error(f"loop {loop.name}", what)


def _other_positions(machine: Machine, assembly: Assembly, rough: Position, dependent: Sequence[int]) -> list[Position]:
    """Positions of the dependent joints in which the loops close, found from random guesses."""
    source = random.Random(SEED)
    found: list[Position] = []
    for _ in range(GUESSES):
        guess = rough | {j: source.uniform(-math.pi, math.pi) for j in machine.dependent}
        position, error = assembly.assembled(guess, machine.dependent)
        if error < CLOSED and not any(_same(machine, position, other, dependent) for other in found):
            found.append(position)
    return sorted(found, key=lambda x: -x[dependent[0]])


def _same(machine: Machine, one: Position, other: Position, joints: Sequence[int]) -> bool:
    """Whether joints stand alike, up to full turns."""
    return all(
        abs(math.remainder(one[j] - other[j], 2 * math.pi) if machine.joint(j).sigma == 0 else one[j] - other[j]) < 1e-4
        for j in joints
    )


def _mapped_start(machine: Machine, assembly: Assembly, parallelograms: Mapping[str, Angles]) -> Position:
    """The start that the file gives; parallelograms without one stand apart from their flat position."""
    position = assembly.start()
    unstarted = {loop.name for loop in machine.loops if not loop.start}
    for name, angles in parallelograms.items():
        if name not in unstarted:
            continue
        if len(unstarted) == len(machine.loops):
            position |= {j: position[j] + 0.5 * (k + 1) for k, j in enumerate(machine.moving) if not position[j]}
        position = _mapped(assembly, [angles], position)
    return position


def _parallelograms(machine: Machine, assembly: Assembly) -> dict[str, Angles]:
    """Angles of the dependent joints of each parallelogram, those first through which others run."""
    found: dict[str, Angles] = {}
    waiting = list(machine.loops)
    while waiting:
        taken = {j for angles in found.values() for j in angles}
        for loop in waiting:
            own = [j for j in machine.dependent_in(loop) if j not in taken]
            angles = mapped(assembly.bound, loop, own)
            if angles is not None:
                found[loop.name] = angles
                waiting.remove(loop)
                break
        else:
            break
    return found
