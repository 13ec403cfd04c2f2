"""Assembled positions of machines with loops, for test states: near the start of the loops, on its branch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.loops.assembly import Position
from symoro_elastic.models.loops.plan import Plan, plan_of
from symoro_elastic.numerics.closure import closed_variables

TURN, SLIDE, DEFLECTION = 0.4, 0.1, 0.02
"""How far independent variables of loops go from the start, rad or m."""
DIFFERENT = 64
"""Positions; more states use them again, in turn."""
SHARES = (1.0, 0.5, 0.25, 0.125)
"""Of a way that is gone where the loops do not close at its end."""


@dataclass(frozen=True)
class Start:
    """One position at which the loops of a machine are closed: independent and dependent variables."""

    machine: Machine
    q: Array
    q_dep: Array

    @property
    def by_variable(self) -> dict[str, float]:
        """Values of all own variables, by name."""
        owners, values = (*self.machine.moving, *self.machine.dependent), (*self.q.tolist(), *self.q_dep.tolist())
        return self.machine.by_variable(dict(zip(owners, values, strict=True)))


def start_of(machine: Machine) -> Start:
    """Return the position near the start of the file; zeros without loops."""
    if not machine.loops:
        return Start(machine, np.zeros(len(machine.moving)), np.zeros(0))
    position = plan_of(machine, Bound).positions[0]
    q, q_dep = (np.array([position[j] for j in joints]) for joints in (machine.moving, machine.dependent))
    return Start(machine, q, q_dep)


def assembled_states(machine: Machine, count: int, seed: int, values: Mapping[str, float]) -> tuple[Array, Array]:
    """q and q_dep of states at which the loops close: q_dep is rounded from many digits.

    Parameters that place frames have the values of `parameter_values`.
    """
    plan, rng = plan_of(machine, Bound), np.random.default_rng([seed, 7])
    found = [_near(machine, plan, rng) for _ in range(min(count, DIFFERENT))]
    rows = [closed_variables(machine, plan, position, values) for position in found]
    q = np.array([[row[j] for j in machine.moving] for row in rows], dtype=float)
    q_dep = np.array([[row[j] for j in machine.dependent] for row in rows], dtype=float)
    order = np.arange(count) % max(1, len(rows))
    return q.reshape(len(rows), -1)[order], q_dep.reshape(len(rows), -1)[order]


def _near(machine: Machine, plan: Plan, rng: np.random.Generator) -> Position:
    """An assembled position near the start, reached by continuation, on the branch of the start."""
    start = plan.positions[0]
    away = rng.uniform(-1, 1, len(machine.moving)) * _reach(machine, machine.moving)
    for share in SHARES:
        target = {j: start[j] + share * float(x) for j, x in zip(machine.moving, away, strict=True)}
        found = plan.assembly.moved(start, target)
        if found is not None:
            return found
    return start


def _reach(machine: Machine, joints: Sequence[int]) -> Array:
    rows = [machine.joint(j) for j in joints]
    return np.array([DEFLECTION if x.kind is Kind.ELASTIC else SLIDE if x.sigma == 1 else TURN for x in rows])
