"""The assembled position of a machine at the start of its loops, and others near it."""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.assembly import CLOSED, SEED, STEPS, Assembly, Position
from symoro_elastic.models.loops.closed_forms import Angles, mapped
from symoro_elastic.models.loops.independent_rows import (
    independent,
    independent_rows,
    refuse_singular,
    refuse_wrong_number,
)
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

SAMPLES, DRAWS, REACH, GUESSES = 4, 40, 0.3, 12
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
        _refuse_open(machine, assembly, rough)
    return found


def _refuse_open(machine: Machine, assembly: Assembly, rough: Position) -> None:
    """Raise `InputError` for the loop that is open most: by how much, and what to check."""
    found, _ = assembly.assembled(rough, machine.dependent)
    errors, _ = assembly.numbers(found)
    row = int(np.argmax(np.abs(errors)))
    worst = assembly.equations[row]
    unit, cells = ("m", "lengths b, d and r") if worst.row < 3 else ("rad", "angles gamma and alpha")
    what = f"no position near start: {abs(errors[row]):.2g} {unit} stay open"
    if all(np.max(np.abs(W[row])) < CLOSED for W in _anywhere(machine, assembly)):
        what += f" that no joint of the loop changes: check the {cells} around it"
        raise machine.error(f"loop {worst.loop}", what)
    started = any(loop.start for loop in machine.loops if loop.name == worst.loop)
    check = f"check the {cells} around it, or give another start" if started else "write start = { ... }"
    raise machine.error(f"loop {worst.loop}", f"{what} after {STEPS} steps of Newton's method: {check}")


def _refuse_singular_anywhere(machine: Machine, assembly: Assembly) -> None:
    """Refuse dependent variables that depend on each other wherever joints stand, closed or not.

    Where loops close the rank of W is at most what it is elsewhere.
    """
    columns = independent([W.T for W in _anywhere(machine, assembly)])
    if len(columns) >= len(machine.dependent):
        refuse_singular(machine, assembly, range(len(assembly.equations)), _open_positions(machine))


def _anywhere(machine: Machine, assembly: Assembly) -> list[Array]:
    """W at some positions, the loops open."""
    return [assembly.numbers(position)[1] for position in _open_positions(machine)]


def _open_positions(machine: Machine) -> list[Position]:
    source = random.Random(SEED)
    return [{j: source.uniform(-math.pi, math.pi) for j in machine.owners} for _ in range(SAMPLES)]


def positions_near(machine: Machine, assembly: Assembly, start: Position) -> list[Position]:
    """Other assembled positions near the start, by continuation."""
    source, found = random.Random(SEED), []
    position = start
    for _ in range(DRAWS):
        target = {j: start[j] + source.uniform(-REACH, REACH) for j in machine.moving}
        moved = assembly.moved(position, target, machine.dependent)
        if moved is not None:
            found.append(moved)
            position = moved
        if len(found) == SAMPLES:
            break
    return found


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
        offsets = {j: assembly.bound.offset(j) for j in angles}
        value = evaluate([*angles.values(), *offsets.values()], assembly.symbols(position), FLOATS)
        position |= {j: float(value(x) - value(offsets[j])) for j, x in angles.items()}
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
