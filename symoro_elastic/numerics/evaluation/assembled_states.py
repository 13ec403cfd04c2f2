"""Assembled positions of machines with loops, for test states: near the start of the loops, on its branch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.loops.assembly import Position
from symoro_elastic.models.loops.plan import Plan, plan_of
from symoro_elastic.numerics.evaluation.linear_systems import solve
from symoro_elastic.symbolic.arithmetic import multiprecision
from symoro_elastic.symbolic.tape import Tape

DIGITS, STEPS = 50, 4
"""Digits of assembled positions, and the Newton steps they need: from an error of 1e-11, two steps give 44 digits."""

TURN, SLIDE, DEFLECTION = 0.4, 0.1, 0.02
"""Largest distance of the independent variables of loops from the start, rad or m."""
DIFFERENT = 64
"""Positions; more states use them again, in turn."""
SHARES = (1.0, 0.5, 0.25, 0.125)
"""Shares of a path that are tried in turn, where the loops do not close at its end."""


@dataclass(frozen=True)
class Start:
    """A position at which the loops of a machine are closed: independent and dependent variables."""

    machine: Machine
    q: Array
    q_dep: Array

    @property
    def by_variable(self) -> dict[str, float]:
        """Values of all joint coordinates, by name."""
        owners, values = (*self.machine.independent, *self.machine.dependent), (*self.q.tolist(), *self.q_dep.tolist())
        return self.machine.by_variable(dict(zip(owners, values, strict=True)))


def start_of(machine: Machine) -> Start:
    """Return the position near the start of the file; zeros without loops."""
    if not machine.loops:
        return Start(machine, np.zeros(len(machine.independent)), np.zeros(0))
    position = plan_of(machine).positions[0]
    q, q_dep = (np.array([position[j] for j in joints]) for joints in (machine.independent, machine.dependent))
    return Start(machine, q, q_dep)


def assembled_states(machine: Machine, count: int, seed: int, values: Mapping[str, float]) -> tuple[Array, Array]:
    """q and q_dep of states at which the loops close: q_dep is rounded from many digits.

    Parameters that place frames have the values of `parameter_values`.
    """
    plan, rng = plan_of(machine), np.random.default_rng([seed, 7])
    positions = [_near(machine, plan, rng) for _ in range(min(count, DIFFERENT))]
    rows = [closed_variables(machine, plan, position, values) for position in positions]
    q = np.array([[row[j] for j in machine.independent] for row in rows], dtype=float)
    q_dep = np.array([[row[j] for j in machine.dependent] for row in rows], dtype=float)
    order = np.arange(count) % max(1, len(rows))
    return q.reshape(len(rows), -1)[order], q_dep.reshape(len(rows), -1)[order]


def _near(machine: Machine, plan: Plan, rng: np.random.Generator) -> Position:
    """An assembled position near the start, reached by continuation, on the branch of the start."""
    start, joints = plan.positions[0], machine.independent_joints
    reach = [DEFLECTION if x.kind is Kind.ELASTIC else SLIDE if x.sigma == 1 else TURN for x in joints]
    away = rng.uniform(-1, 1, len(joints)) * np.array(reach)
    for share in SHARES:
        target = {j: start[j] + share * float(x) for j, x in zip(machine.independent, away, strict=True)}
        position = plan.assembly.position_at(start, target)
        if position is not None:
            return position
    return start


# Dependent variables of closed loops in many digits, by Newton's method on the equations of the loops.
def closed_variables(machine: Machine, plan: Plan, near: Position, values: Mapping[str, float]) -> dict[int, Any]:
    """Return the joint coordinates of a position: independent ones as they are, dependent ones in many digits.

    `values` are those of the parameters, which are exact as they are.
    """
    arithmetic = multiprecision(DIGITS)
    equations = [e for x in plan.loops for e in plan.assembly.equations if e.loop == x.loop.name and e.row in x.kept]
    leaves = [x for e in equations for x in (e.error, *(e.columns.get(j, 0) for j in machine.dependent))]
    tape, width = Tape(leaves, arithmetic), 1 + len(machine.dependent)
    position = {j: arithmetic.number(Fraction(x)) for j, x in near.items()}
    symbols = {name: arithmetic.number(Fraction(x)) for name, x in values.items()}
    for _ in range(STEPS):
        numbers = tape.values(symbols | machine.by_variable(position))
        rows = [numbers[k : k + width] for k in range(0, len(numbers), width)]
        steps = solve([W for _, *W in rows], [error for error, *_ in rows])
        for j, step in zip(machine.dependent, steps, strict=True):
            position[j] -= step
    return position
