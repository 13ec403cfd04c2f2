"""Geared rotors: speed above which their gyroscopic moments, which Ia neglects, are significant.

A balanced rotor of inertia Z about its axis e, on bearings of body i, turns at s = c . ud relative to it. In motion
body i exerts the moment Z s (w_i x e) on it (L7), of which its inertia as the joint feels it, Ia = c^2 Z, has no part.
Where joints turn at rates in proportion to v it changes accelerations by A^-1 J_i^T Z s (w_i x e) = v^2 g. The result
is an acceleration of 1 rad/s2 or 1 m/s2 and what the speeds cause, v^2 h with h = A^-1 H: the change is 1 % of it at
v^2 = 0.01 / (|g| - 0.01 |h|), and never where that is negative.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.position import Position
from symoro_elastic.models.loops.plan import plan_of

CHANGE = 0.01
"""Relative change that counts, of an acceleration of 1 rad/s2 or 1 m/s2 plus that of the speeds."""
NONE = 1e-12
ALONE, MOST_STATES = -1, 4096
POSITIONS, SEED = 8, 20264
MOST_MOVED = 12_000_000
"""Limit of velocities of bodies at positions after the first: large machines are checked at fewer positions."""


@dataclass(frozen=True)
class Rotor:
    """A geared rotor: the joint of its row, and whether that row has a body.

    From `speed` on, rad/s or m/s of the two joints `turning`, its gyroscopic moment changes an acceleration by 1 %, in
    the worst of some positions. It is infinite where it never does in any of them, NaN where parameters have no value.
    """

    joint: str
    has_body: bool
    speed: float
    turning: tuple[str, ...]


def rotors(machine: Machine, position: Mapping[str, float]) -> list[Rotor]:
    """The rotors of a machine, at a position by joint and at 2 to 8 others; none on a base that moves freely.

    The worst pair of joints at equal speed counts; the rotor follows a joint of the pair, or drives it.
    """
    rows = [j for j in machine.articulated if _is_rotor(machine, j)]
    if not rows or machine.degrees_of_base:
        return []
    numbers = _Numbers(machine, rows)
    numbers.move(_by_variable(machine, position))
    rows = [j for j in rows if not numbers.is_driven_side(j)]
    worst = {j: Rotor(machine.joint(j).name, _has_body(machine, j), math.inf, ()) for j in rows}
    moved = len(rows) * len(machine.independent) * len(machine.joints)
    positions = islice(_other_positions(machine, position), max(2, MOST_MOVED // max(1, moved)))
    for coordinates in (_by_variable(machine, position), *positions):
        numbers.move(coordinates)
        for j in rows:
            rotor = _rotor(machine, numbers, j)
            if not rotor.speed >= worst[j].speed:
                worst[j] = rotor
    return list(worst.values())


def _by_variable(machine: Machine, position: Mapping[str, float]) -> dict[str, float]:
    return {str(machine.joint(j).variable): position[machine.joint(j).name] for j in machine.with_variable}


def _other_positions(machine: Machine, position: Mapping[str, float]) -> Iterator[dict[str, float]]:
    """Positions with random angles of revolute joints, loops near their start."""
    source, here = random.Random(SEED), _by_variable(machine, position)
    free = [machine.joint(j) for j in machine.independent if j not in machine.in_loops and machine.joint(j).sigma == 0]
    plan = plan_of(machine) if machine.loops else None
    for k in range(POSITIONS):
        near = plan.positions[k % len(plan.positions)] if plan else {}
        closed = machine.by_variable({j: near[j] for j in machine.in_loops})
        yield here | closed | {str(joint.variable): source.uniform(-math.pi, math.pi) for joint in free}


def _is_rotor(machine: Machine, j: int) -> bool:
    """Whether a joint may have the inertia of a rotor behind a gear: as a body, or as that of its motor."""
    joint = machine.joint(j)
    with_ratio = not joint.ratio.is_zero or joint.kind is Kind.COUPLED
    return _has_body(machine, j) or (with_ratio and not joint.rotor_inertia.is_zero)


def _has_body(machine: Machine, j: int) -> bool:
    """Whether the body of row j is a geared rotor: of a coupled joint, or of a terminal joint that others follow."""
    joint = machine.joint(j)
    if joint.sigma != 0 or joint.body.inertia[5].is_zero or not joint.body.is_balanced:
        return False
    if joint.kind is Kind.COUPLED:
        return True
    return joint.ratio.is_zero and j not in machine.antecedents and _follower(machine, j) is not None


def _follower(machine: Machine, j: int) -> int | None:
    """The first joint whose cell holds the variable of another; None where there is none."""
    name = machine.joint(j).variable
    return next((k for k in machine.articulated if name in machine.joint(k).selected.names), None)


class _Numbers:
    """Numeric inertia and velocity forces of a machine, at one position at a time."""

    def __init__(self, machine: Machine, rows: Sequence[int]) -> None:
        self.machine, self.bound, self.rows = machine, Bound(machine), rows
        self._values = {parameter.name: math.nan for parameter in machine.parameters} | parameter_values(machine)

    def move(self, position: Mapping[str, float]) -> None:
        """Set the position, values by variable, and discard the results of the former one."""
        self.here = Position(self.bound, {**self._values, **position})
        self._A: Array | None = None
        self._of_pairs: dict[int, Array] = {}

    @property
    def A(self) -> Array:
        """The inertia matrix over the independent variables, computed once at a position."""
        if self._A is None:
            self._A = self.here.inertia()
        return self._A

    def velocity_forces(self, v: int, rates: Array) -> Array:
        """Coriolis and centrifugal forces: columns for rate v alone, and paired with each other rate in both senses.

        They are quadratic: H(x e_v + y e_k) = x^2 H(e_v) + y^2 H(e_k) + x y (H(e_v + e_k) - H(e_v) - H(e_k)).
        """
        if not self._of_pairs:
            self._of_pairs = self._unit_pairs()
        alone, together = self._of_pairs[ALONE], self._of_pairs[v]
        x, y = rates[v], np.delete(rates, v)
        own, other_rates = alone[:, [v]], np.delete(alone, v, axis=1)
        mixed = x * y * (np.delete(together, v, axis=1) - own - other_rates)
        return _interleave(x**2 * own, x**2 * own + y**2 * other_rates, mixed)

    def _unit_pairs(self) -> dict[int, Array]:
        """Velocity forces H for unit rates (columns), and for their pairs with each rate that a rotor follows."""
        leads = sorted({v for j in self.rows for v in _leads(self.spin(j)[0])})
        unit = np.eye(len(self.machine.independent))
        rates = np.concatenate([unit, *(unit + unit[v] for v in leads)])
        blocks = np.array_split(rates, 1 + len(rates) // MOST_STATES)
        H = np.concatenate([self.here.velocity_forces(block) for block in blocks], axis=1)
        return dict(zip((ALONE, *leads), np.split(H, 1 + len(leads), axis=1), strict=True))

    def spin(self, j: int) -> tuple[Array, float]:
        """Rates of a rotor per unit of the independent rates, and its inertia."""
        joint = self.machine.joint(j)
        of_body = _has_body(self.machine, j)
        turns = 1.0 if of_body or joint.ratio.is_zero else self.here.number(self.bound.cell(joint.ratio))
        inertia = self.bound.cell(joint.body.inertia[5] if of_body else joint.rotor_inertia)
        return turns * self.here.S[j], self.here.number(inertia)

    def driven(self, j: int) -> tuple[int, float]:
        """The joint that a rotor drives, and the rate of its coordinate for a unit of that joint's rate.

        The joint itself and 1 unless the rotor is a body with an independent variable that another joint follows.
        """
        leads = j in self.machine.independent and _has_body(self.machine, j)
        follower = _follower(self.machine, j) if leads else None
        rate = 0.0 if follower is None else float(self.here.S[follower, self.machine.independent.index(j)])
        return (j, 1.0) if follower is None or rate == 0 else (follower, 1 / abs(rate))

    def is_driven_side(self, j: int) -> bool:
        """Whether the joint that follows joint j turns as fast or faster, so that j is the driven side of the gear."""
        driven, ahead = self.driven(j)
        return driven != j and ahead <= 1


def _rotor(machine: Machine, numbers: _Numbers, j: int) -> Rotor:
    joint, (driven, ahead) = machine.joint(j), numbers.driven(j)
    here, (c, Z) = numbers.here, numbers.spin(j)
    G, e = here.turning(joint.antecedent), here.axis(j)
    rates = np.array([ahead if k == j else 1.0 for k in machine.independent])
    leads = _leads(c)
    if not leads:
        return Rotor(joint.name, _has_body(machine, j), math.inf, ())
    pairs = np.concatenate([_pairs(v, rates) for v in leads])
    moments = Z * (pairs @ c)[:, None] * np.cross(pairs @ G.T, e)
    forces = np.concatenate([numbers.velocity_forces(v, rates) for v in leads], axis=1)
    try:
        g, h = np.abs(np.linalg.solve(numbers.A, np.array([(moments @ G).T, forces])))
    except np.linalg.LinAlgError:
        g = h = np.full(pairs.T.shape, math.nan)
    excess = np.max(np.where(g < NONE, 0.0, g - CHANGE * h), axis=0, initial=0.0)
    worst = int(np.argmax(np.nan_to_num(excess, nan=math.inf)))
    if excess[worst] <= 0:
        return Rotor(joint.name, _has_body(machine, j), math.inf, ())
    turning = (machine.independent[k] for k in np.flatnonzero(pairs[worst]))
    names = tuple(machine.joint(driven if k == j else k).name for k in turning)
    return Rotor(joint.name, _has_body(machine, j), math.sqrt(CHANGE / excess[worst]), names)


def _leads(c: Array) -> list[int]:
    """Indices of the independent rates that rotate a rotor, from its coefficients c."""
    return [int(v) for v in np.flatnonzero(np.nan_to_num(c, nan=1.0))]


def _pairs(v: int, rates: Array) -> Array:
    """Rows of rates: rate v alone, then paired with every other rate, in both senses."""
    diagonal = np.diag(rates)
    own, other_rates = diagonal[:, [v]], np.delete(diagonal, v, axis=1)
    pairs: Array = _interleave(own, np.repeat(own, len(rates) - 1, axis=1), other_rates).T
    return pairs


def _interleave(first: Array, sums: Array, changes: Array) -> Array:
    """Matrix of a first column, then each column of `sums` with its change added and subtracted."""
    both = np.stack([sums + changes, sums - changes], axis=-1)
    return np.hstack([first, both.reshape(len(first), -1)])
