"""Diagnosis of loops that do not close near their start: the loop, its error, and the missing length of links."""

from __future__ import annotations

import math
import random

import numpy as np

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.loops.planar import close_circuit
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.loops.assembly import SEED, STEPS, Assembly, Position
from symoro_elastic.models.loops.closed_forms import is_planar, loop_circuit
from symoro_elastic.models.loops.continuation import CLOSED
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

SAMPLES = 4
FLAT = 1e-6
"""Smallest singular value of W_d, columns scaled to length 1, below which a position is singular."""
SINGULAR_START = "start is at a singular position, where branches meet: move it to the intended side"


def open_positions(machine: Machine) -> list[Position]:
    """Random positions with open loops."""
    source = random.Random(SEED)
    return [{j: source.uniform(-math.pi, math.pi) for j in machine.with_variable} for _ in range(SAMPLES)]


def not_closed(machine: Machine, assembly: Assembly, start: Position) -> InputError:
    """The error for the first loop that does not close near the start together with the earlier ones."""
    for k, loop in enumerate(machine.loops):
        closest, error = assembly.of_loops(machine.loops[: k + 1]).assembled_position(start, machine.dependent)
        if not error < CLOSED:
            return machine.error(f"loop {loop.name}", _why(machine, assembly, k, start, closest))
    raise AssertionError("all loops close")


def _why(machine: Machine, assembly: Assembly, k: int, start: Position, closest: Position) -> str:
    """Message: why loop k does not close, and the way out."""
    loop, together = machine.loops[k], assembly.of_loops(machine.loops[: k + 1])
    alone = assembly.of_loops([loop])
    errors = np.abs(together.numbers(closest)[0])
    worst = int(np.argmax(errors))
    unit, cells = (
        ("m", "lengths b, d and r") if together.equations[worst].row < 3 else ("rad", "angles gamma and alpha")
    )
    gap = f"{errors[worst]:.2g} {unit} stay open"
    if all(np.max(np.abs(together.numbers(x)[1][worst])) < CLOSED for x in open_positions(machine)):
        return f"no position near start: {gap} that no joint of the loop changes: check the {cells} around it"
    gap += f" after {STEPS} steps of Newton's method"
    if k and alone.assembled_position(start, machine.dependent)[1] < CLOSED:
        return (
            f"it closes near start, but not together with {_sharing(machine, k)}: {gap}; check the {cells} around them"
        )
    return f"no position near start: {gap}: {_way_out(alone, loop, start, closest, cells)}"


def _way_out(alone: Assembly, loop: Loop, start: Position, closest: Position, cells: str) -> str:
    if not loop.start:
        return "write start = { ... }"
    links, length = _lacking(alone, loop, start) or ("", 0.0)
    if length > 0:
        return f"{links} would need {length:.2g} m more, or give another start"
    if _is_flat(alone, loop, closest):
        return SINGULAR_START
    return f"check the {cells} around it, or give another start"


def _sharing(machine: Machine, k: int) -> str:
    """The loops before loop k whose joints it shares."""
    around = {*machine.around(machine.loops[k])}
    names = [f"loop {loop.name}" for loop in machine.loops[:k] if not around.isdisjoint(machine.around(loop))]
    return f"{' and '.join(names) or 'the loops before it'}, whose joints it shares"


def _is_flat(alone: Assembly, loop: Loop, position: Position) -> bool:
    """Whether the rates of the dependent joints of a loop are not determined at a position."""
    W = alone.numbers(position)[1][:, alone.columns(alone.machine.dependent_in(loop))]
    lengths = np.linalg.norm(W, axis=0)
    return bool(np.linalg.svd(W / np.where(lengths > 0, lengths, 1.0), compute_uv=False)[-1] < FLAT)


def _lacking(alone: Assembly, loop: Loop, start: Position) -> tuple[str, float] | None:
    """Links of a planar loop, and the length, m, by which they are too short, negative if not; None for other loops."""
    machine = alone.machine
    around = loop_circuit(alone.tree, loop, machine.dependent_in(loop))
    turns = [joint for joint in around.unknown if joint.axis is Axis.REVOLUTE]
    if len(around.unknown) != 3 or len(turns) < 2 or not is_planar(alone, loop):
        return None
    circuit = close_circuit(
        around, lambda radicand: radicand, dict.fromkeys((joint.joint for joint in around.unknown), 1)
    )
    names = [machine.joint(j or loop.cut).name for j in circuit.sides]
    leaves = [*(x for side in circuit.sides.values() for x in side), *circuit.roots.values()]
    value = evaluate(leaves, alone.symbols(start), FLOATS)
    lengths = [math.hypot(*map(value, side)) for side in circuit.sides.values()]
    if len(turns) == 2:
        (radicand,) = map(value, circuit.roots.values())
        return f"the link {names[0]} to {names[1]}", math.sqrt(lengths[0] ** 2 - radicand) - lengths[0]
    k = int(np.argmax(lengths))
    here, between = names[k], names[k - 1]
    return f"the links {names[k - 2]} to {between} and {between} to {here}", 2 * lengths[k] - sum(lengths)
