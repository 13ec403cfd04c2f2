"""Another choice of the independent joints of loops, in which given joints are independent: motors, springs.

No result of a machine depends on the choice, but motors are held and driven, and springs are locked, by coordinates of
their own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.loops.plan import lacks_closed_form, plan_of
from symoro_elastic.models.once import once_for_each_machine

MOVES = 1e-9
"""Share of the largest derivative of a dependent variable below which another does not move it."""
DIGITS = 6
"""Of derivatives that are compared: those alike rank in table order."""


@once_for_each_machine
def with_independent_motors(machine: Machine) -> Machine:
    """Return the machine with all motors independent, but those that move with other motors alone."""
    return with_independent(machine, machine.motors)


def with_independent(machine: Machine, wanted: Collection[int]) -> Machine:
    """Return the machine with joints, by number, independent in place of others, as far as loops leave them free.

    Others than motors give way first, and of these one with which the loops have a closed form.
    """
    for j in wanted:
        if j in machine.dependent:
            machine = next(_exchanged(machine, j, wanted), machine)
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


def _exchanged(machine: Machine, j: int, wanted: Collection[int]) -> Iterator[Machine]:
    """Machines with joint j independent in place of another, those with closed forms first."""
    moving = {k: x for k, x in moved_by(machine, j).items() if k not in wanted}
    assembled = []
    for k in _ranked(machine, moving):
        changed = _with_dependent(machine, {*machine.dependent} - {j} | {k})
        try:
            is_assembled = lacks_closed_form(changed)
        except InputError:
            continue
        if is_assembled:
            assembled.append(changed)
        else:
            yield changed
    yield from assembled


def _ranked(machine: Machine, row: Mapping[int, float]) -> list[int]:
    """Joints but motors first, then those that move the other joint most, then the last of the table."""
    largest = max(map(abs, row.values()), default=1.0)
    return sorted(row, key=lambda k: (machine.joint(k).kind is Kind.MOTOR, -round(abs(row[k]) / largest, DIGITS), -k))


def _with_dependent(machine: Machine, dependent: Collection[int]) -> Machine:
    def changed(loop: Loop) -> Loop:
        own = tuple(j for j in machine.with_variable_in(loop) if j in dependent)
        return loop if own == machine.dependent_in(loop) else replace(loop, dependent=_names(machine, own))

    return replace(machine, loops=tuple(map(changed, machine.loops)))


def _names(machine: Machine, joints: Collection[int]) -> tuple[str, ...]:
    return tuple(machine.joint(j).name for j in joints)
