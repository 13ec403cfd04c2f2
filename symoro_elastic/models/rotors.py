"""Rotors behind gears: from which speed on their gyroscopic moments, which Ia leaves out, matter.

A balanced rotor of inertia Z about its axis e, on bearings of body i, turns at s = c . ud relative to it. In motion
body i exerts the moment Z s (w_i x e) on it (L7), of which its inertia as the joint feels it, Ia = c^2 Z, has no part.
Where joints turn at rates in proportion to v it changes accelerations by A^-1 J_i^T Z s (w_i x e) = v^2 g. The result
is an acceleration of 1 rad/s2 or 1 m/s2 and what the speeds cause, v^2 h with h = A^-1 H: the change is 1 % of it at
v^2 = 0.01 / (|g| - 0.01 |h|), and never where that is negative.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.arguments import arguments
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.machine import Body, Kind, Machine
from symoro_elastic.mechanics.coordinates import combination
from symoro_elastic.mechanics.kinematics import frame_set, jacobian
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia, coordinate_velocity_forces
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

CHANGE = 0.01
"""Of an acceleration: of 1 rad/s2 or 1 m/s2, and what the speeds cause."""
NONE = 1e-12
POSITIONS, SEED = 8, 20264


@dataclass(frozen=True)
class Rotor:
    """A rotor behind a gear: the joint of its row, and whether it has a body there.

    From `speed` on, rad/s or m/s of the two joints `turning`, its gyroscopic moment changes an acceleration by 1 %, in
    the worst of some positions. It is infinite where it never does in any of them, NaN where parameters have no value.
    """

    joint: str
    has_body: bool
    speed: float
    turning: tuple[str, ...]


def rotors(machine: Machine, position: Mapping[str, float]) -> list[Rotor]:
    """The rotors of a machine, at a position by joint and at some others; none on a base that moves freely.

    Of all pairs of joints at one speed, one of which the rotor follows, or follows the rotor, the worst one counts.
    """
    rows = [j for j in machine.articulated if _is_rotor(machine, j)]
    if not rows or machine.degrees_of_base:
        return []
    numbers = _Numbers(machine)
    numbers.move(_by_variable(machine, position))
    rows = [j for j in rows if not numbers.is_driven_side(j)]
    worst = {j: Rotor(machine.joint(j).name, _has_body(machine, j), math.inf, ()) for j in rows}
    for known in (_by_variable(machine, position), *_others(machine, position)):
        numbers.move(known)
        for j in rows:
            found = _rotor(machine, numbers, j)
            if not found.speed >= worst[j].speed:
                worst[j] = found
    return list(worst.values())


def _by_variable(machine: Machine, position: Mapping[str, float]) -> dict[str, float]:
    return {str(machine.joint(j).variable): position[machine.joint(j).name] for j in machine.with_variable}


def _others(machine: Machine, position: Mapping[str, float]) -> Iterator[dict[str, float]]:
    """Positions with joints that turn somewhere, those of loops near their start."""
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
    """Whether the body of a row is a rotor: of a joint that follows others, or of a last one that others follow."""
    joint = machine.joint(j)
    if joint.sigma != 0 or not _is_balanced(joint.body):
        return False
    if joint.kind is Kind.COUPLED:
        return True
    return joint.ratio.is_zero and j not in machine.antecedents and _follower(machine, j) is not None


def _follower(machine: Machine, j: int) -> int | None:
    """The first joint whose cell holds the variable of another; None where there is none."""
    name = machine.joint(j).variable
    return next((k for k in machine.articulated if name in machine.joint(k).selected.names), None)


def _is_balanced(body: Body) -> bool:
    """Whether the angle of a body about z changes nothing, by its expressions."""
    XX, XY, XZ, YY, YZ, ZZ = body.inertia
    off_axis = (XY, XZ, YZ, *body.moments[:2])
    return XX == YY and not ZZ.is_zero and all(x.is_zero for x in off_axis)


class _Numbers:
    """A machine bound to the equations, in numbers at one position after another."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.bound = machine, Bound(machine)
        self._values = {parameter.name: math.nan for parameter in machine.parameters} | parameter_values(machine)
        self._seen = frame_set(self.bound.mechanism, 0)
        self._inertia = coordinate_inertia(self.bound).A
        forces = coordinate_velocity_forces(self.bound)
        self._velocity_forces = [forces[k] for k in machine.independent]
        self._rates = arguments(machine)["qd"]
        self._bearings: dict[int, list[Any]] = {}
        self.move({})

    def move(self, position: Mapping[str, float]) -> None:
        """Go to a position by variable."""
        self._known = {**self._values, **position}
        self._A: Array | None = None

    @property
    def A(self) -> Array:
        """The inertia matrix over the independent variables, computed once at a position."""
        if self._A is None:
            k = self.machine.independent
            self._A = self.array([[self._inertia[i][j] for j in k] for i in k])
        return self._A

    def velocity_forces(self, rates: Array) -> Array:
        """Coriolis and centrifugal forces, a column for each row of rates of the independent variables."""
        known: dict[str, Any] = {**self._known, **dict(zip(self._rates, rates.T, strict=True))}
        value: Any = evaluate(self._velocity_forces, known, FLOATS)
        return np.array([value(x) + np.zeros(len(rates)) for x in self._velocity_forces])

    def array(self, cells: list[Any]) -> Array:
        """The numbers of nested lists of expressions."""
        leaves = np.array(cells, dtype=object)
        value = evaluate(list(leaves.ravel()), self._known, FLOATS)
        return np.array([float(value(x)) for x in leaves.ravel()]).reshape(leaves.shape)

    def turning(self, i: int) -> Array:
        """Angular velocity of body i for a unit of each independent rate, in frame 0: 3 x k."""
        if i not in self._bearings:
            columns = jacobian(self.bound.mechanism, self._seen, i) if i else {}
            S = self.bound.coordinates.S
            rows = [combination((x.angular[n], S[j]) for j, x in columns.items() if j in S) for n in range(3)]
            self._bearings[i] = [[row.get(k, 0) for k in self.machine.independent] for row in rows]
        return self.array(self._bearings[i])

    def axis(self, j: int) -> Array:
        """z_j in frame 0."""
        return self.array(list(self._seen.frames[j].z))

    def spin(self, j: int) -> tuple[Array, float]:
        """Rates of a rotor for a unit of each independent rate, and its inertia."""
        joint, row = self.machine.joint(j), self.bound.coordinates.S[j]
        turns: Scalar = 1 if joint.ratio.is_zero else self.bound.cell(joint.ratio)
        of_body = _has_body(self.machine, j)
        inertia = self.bound.cell(joint.body.inertia[5] if of_body else joint.rotor_inertia)
        *c, Z = self.array([*((1 if of_body else turns) * row.get(k, 0) for k in self.machine.independent), inertia])
        return np.array(c), float(Z)

    def driven(self, j: int) -> tuple[int, float]:
        """The joint that a rotor drives, and the rate of its coordinate for a unit of that joint's rate.

        The joint itself and 1 unless the rotor is a body with an independent variable that another joint follows.
        """
        leads = j in self.machine.independent and _has_body(self.machine, j)
        follower = _follower(self.machine, j) if leads else None
        rate = 0.0 if follower is None else float(self.array([self.bound.coordinates.S[follower].get(j, 0)])[0])
        return (j, 1.0) if follower is None or rate == 0 else (follower, 1 / abs(rate))

    def is_driven_side(self, j: int) -> bool:
        """Whether the joint that follows a joint turns as fast or faster: the rotor is there, if anywhere."""
        driven, ahead = self.driven(j)
        return driven != j and ahead <= 1


def _rotor(machine: Machine, numbers: _Numbers, j: int) -> Rotor:
    joint, (driven, ahead) = machine.joint(j), numbers.driven(j)
    G, e, (c, Z) = numbers.turning(joint.antecedent), numbers.axis(j), numbers.spin(j)
    unit = np.diag([ahead if k == j else 1.0 for k in machine.independent])
    pairs = np.array([*_pairs(c, unit)]).reshape(-1, len(c))
    moments = Z * (pairs @ c)[:, None] * np.cross(pairs @ G.T, e)
    try:
        g, h = np.abs(np.linalg.solve(numbers.A, np.array([(moments @ G).T, numbers.velocity_forces(pairs)])))
    except np.linalg.LinAlgError:
        g = h = np.full(pairs.T.shape, math.nan)
    excess = np.max(np.where(g < NONE, 0.0, g - CHANGE * h), axis=0, initial=0.0)
    worst = int(np.argmax(np.nan_to_num(excess, nan=math.inf))) if len(pairs) else 0
    if not len(pairs) or excess[worst] <= 0:
        return Rotor(joint.name, _has_body(machine, j), math.inf, ())
    turning = (machine.independent[k] for k in np.flatnonzero(pairs[worst]))
    names = tuple(machine.joint(driven if k == j else k).name for k in turning)
    return Rotor(joint.name, _has_body(machine, j), math.sqrt(CHANGE / excess[worst]), names)


def _pairs(c: Array, unit: Array) -> Iterator[Array]:
    """Unit rates of a joint that the rotor follows and of one more, in both senses."""
    for v in np.flatnonzero(np.nan_to_num(c, nan=1.0)):
        yield unit[v]
        yield from (unit[v] + sign * unit[k] for k in range(len(c)) if k != v for sign in (1, -1))
