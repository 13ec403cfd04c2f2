"""Exchange of the independent joints of loops, so that motors or springs are independent.

No result of a machine depends on the choice, but motors are held and driven, and springs are locked, by coordinates of
their own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.loops.plan import lacks_closed_form, plan_of
from symoro_elastic.models.tree.once import once_for_each_machine

MOVES = 1e-9
"""Share of the largest derivative of a dependent variable below which another does not move it."""
DIGITS = 6
"""Digits of compared derivatives: joints with equal digits are ranked in table order."""


@once_for_each_machine
def with_independent_motors(machine: Machine) -> Machine:
    """Return the machine with all motors independent, except motors that only follow other motors."""
    return with_independent(machine, machine.motors)


def with_independent(machine: Machine, wanted: Collection[int]) -> Machine:
    """Return the machine with these joints (numbers) independent instead of others, as far as its loops allow.

    Joints without a motor become dependent first, and among them a joint with which the loops have a closed form.
    """
    for j in wanted:
        if j in machine.dependent:
            machine = next(_exchanges(machine, j, wanted), machine)
    return machine


def moved_by(machine: Machine, j: int) -> dict[int, float]:
    """Return dx/du of a dependent joint at the start of the loops by the independent joints that move it (L10)."""
    plan = plan_of(machine)
    _, W = plan.assembly.numbers(plan.positions[0])
    owners = machine.with_variable
    unknown, known = ([owners.index(k) for k in joints] for joints in (machine.dependent, machine.independent))
    slopes = -np.linalg.lstsq(W[:, unknown], W[:, known], rcond=MOVES)[0]
    row = dict(zip(machine.independent, slopes[machine.dependent.index(j)].tolist(), strict=True))
    largest = max(map(abs, row.values()), default=0.0)
    return {k: x for k, x in row.items() if abs(x) > MOVES * largest}


def _exchanges(machine: Machine, j: int, wanted: Collection[int]) -> Iterator[Machine]:
    """Yield machines with joint j independent instead of another, those with closed forms first.

    Joints without a motor come first, then those that move the joint most, then the last table rows.
    """
    moving = {k: abs(x) for k, x in moved_by(machine, j).items() if k not in wanted}
    largest, assembled = max(moving.values(), default=1.0), []
    is_motor = {k: machine.joint(k).kind is Kind.MOTOR for k in moving}
    for k in sorted(moving, key=lambda k: (is_motor[k], -round(moving[k] / largest, DIGITS), -k)):
        with_dependent = _with_dependent(machine, {*machine.dependent} - {j} | {k})
        try:
            is_assembled = lacks_closed_form(with_dependent)
        except InputError:
            continue
        if is_assembled:
            assembled.append(with_dependent)
        else:
            yield with_dependent
    yield from assembled


def _with_dependent(machine: Machine, dependent: Collection[int]) -> Machine:
    def with_dependent(loop: Loop) -> Loop:
        own = tuple(j for j in machine.with_variable_in(loop) if j in dependent)
        names = tuple(machine.joint(j).name for j in own)
        return loop if own == machine.dependent_in(loop) else replace(loop, dependent=names)

    return replace(machine, loops=tuple(map(with_dependent, machine.loops)))


def followers(machine: Machine) -> dict[int, tuple[int, ...]]:
    """Return the motors that move with others, each with these, by number; raises `InputError` for other ones.

    The motors of the machine are independent as far as can be (`with_independent_motors`).
    """
    leaders = {j: tuple(moved_by(machine, j)) for j in machine.motors if j in machine.dependent}
    for j, moving in leaders.items():
        free = [machine.joint(k).name for k in moving if k not in machine.motors]
        if free:
            what = f"its motor cannot be held by itself, for {', '.join(free)} moves it too: choose other joints "
            raise machine.error(f"joint {machine.joint(j).name}", what + "(dependent = [...])")
    return leaders


def share_torques(S_m: Array, forces: Array, shares: Array) -> Array:
    """Return torques (m,) with S_m^T tau = forces (n,), in the least sum of tau^2 / share (L31)."""
    gram = S_m.T @ (shares[:, None] * S_m)
    return np.asarray(shares * (S_m @ np.linalg.lstsq(gram, forces, rcond=None)[0]))


def shares(machine: Machine, values: Mapping[str, float]) -> Array:
    """Return the shares of the motors (m,), 1 without a share in the file."""
    cells = [joint.sharing for joint in machine.motor_joints]
    return np.array([1.0 if x.is_zero else x.value(values) for x in cells])


def line_on_undetermined(machine: Machine, joined: Mapping[int, tuple[int, ...]]) -> list[str]:
    """Return a line on motors whose individual torques are undetermined, if the file does not share them out."""
    if not all(joint.sharing.is_zero for joint in machine.motor_joints):
        return []
    names = [machine.joint(j).name for j in sorted({*joined, *(k for moving in joined.values() for k in moving)})]
    what = "move each other, so only what their torques do together is determined: they are those of the least sum of "
    return [f"{', '.join(names)} {what}squares; sharing in [motors] weights them"] if names else []
