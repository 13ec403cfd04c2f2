"""Rotors behind gears: from which speed on their gyroscopic moments, which Ia leaves out, matter.

A balanced rotor of inertia Z about its axis e, on bearings of body i, turns at s = c . ud relative to it. Its inertia
as the joint feels it, Ia = c^2 Z, is exact at rest. In motion a moment Z s (w_i x e) acts on body i (L7), so that
accelerations change by A^-1 J_i^T Z s (w_i x e), which grows with the square of the speed.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.machine import Body, Kind, Machine
from symoro_elastic.mechanics.coordinates import combination
from symoro_elastic.mechanics.kinematics import frame_set, jacobian
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

CHANGE = 0.01
"""Of an acceleration of 1 rad/s2 or 1 m/s2."""
NONE = 1e-12
POSITIONS, SEED = 8, 20264


@dataclass(frozen=True)
class Rotor:
    """A rotor behind a gear: the joint of its row, and whether it has a body there.

    From `speed` on, rad/s or m/s of the two joints `turning`, its gyroscopic moment changes an acceleration by 0.01
    rad/s2 or m/s2, in the worst of some positions. It is infinite where the moment does nothing in any of them, NaN
    where parameters have no value.
    """

    joint: str
    has_body: bool
    speed: float
    turning: tuple[str, ...]


def rotors(machine: Machine, position: Mapping[str, float]) -> list[Rotor]:
    """The rotors of a machine, at a position by joint and at some others; none on a floating base.

    Of all pairs of joints at one speed, one of which the rotor follows, the worst one counts.
    """
    rows = {j: machine.joint(j).kind is Kind.COUPLED for j in machine.articulated if _is_rotor(machine, j)}
    if not rows or machine.floating:
        return []
    numbers = _Numbers(machine)
    worst = {j: Rotor(machine.joint(j).name, has_body, math.inf, ()) for j, has_body in rows.items()}
    for known in (_by_variable(machine, position), *_others(machine, position)):
        numbers.move(known)
        for j, has_body in rows.items():
            found = _rotor(machine, numbers, j, has_body)
            if not found.speed >= worst[j].speed:
                worst[j] = found
    return list(worst.values())


def _by_variable(machine: Machine, position: Mapping[str, float]) -> dict[str, float]:
    return {str(machine.joint(j).variable): position[machine.joint(j).name] for j in machine.owners}


def _others(machine: Machine, position: Mapping[str, float]) -> Iterator[dict[str, float]]:
    """Positions with joints that turn somewhere, those of loops near their start."""
    source, here = random.Random(SEED), _by_variable(machine, position)
    free = [machine.joint(j) for j in machine.moving if j not in machine.in_loops and machine.joint(j).sigma == 0]
    plan = plan_of(machine, Bound) if machine.loops else None
    for k in range(POSITIONS):
        near = plan.positions[k % len(plan.positions)] if plan else {}
        closed = machine.by_variable({j: near[j] for j in machine.in_loops})
        yield here | closed | {str(joint.variable): source.uniform(-math.pi, math.pi) for joint in free}


def _is_rotor(machine: Machine, j: int) -> bool:
    joint = machine.joint(j)
    if joint.kind is Kind.COUPLED:
        return joint.sigma == 0 and _is_balanced(joint.body)
    return not (joint.ratio.is_zero or joint.rotor_inertia.is_zero)


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
        self._bearings: dict[int, list[Any]] = {}
        self.move({})

    def move(self, position: Mapping[str, float]) -> None:
        """Go to a position by variable."""
        self._known = {**self._values, **position}

    @property
    def A(self) -> Array:
        """The inertia matrix over the independent variables."""
        k = self.machine.moving
        return self.array([[self._inertia[i][j] for j in k] for i in k])

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
            self._bearings[i] = [[row.get(k, 0) for k in self.machine.moving] for row in rows]
        return self.array(self._bearings[i])

    def axis(self, j: int) -> Array:
        """z_j in frame 0."""
        return self.array(list(self._seen.frames[j].z))

    def spin(self, j: int) -> tuple[Array, float]:
        """Rates of a rotor for a unit of each independent rate, and its inertia."""
        joint, row = self.machine.joint(j), self.bound.coordinates.S[j]
        coupled = joint.kind is Kind.COUPLED
        turns: Scalar = 1 if coupled else self.bound.cell(joint.ratio)
        inertia = self.bound.cell(joint.body.inertia[5] if coupled else joint.rotor_inertia)
        *c, Z = self.array([*(turns * row.get(k, 0) for k in self.machine.moving), inertia])
        return np.array(c), float(Z)


def _rotor(machine: Machine, numbers: _Numbers, j: int, has_body: bool) -> Rotor:
    joint = machine.joint(j)
    G, e, (c, Z) = numbers.turning(joint.antecedent), numbers.axis(j), numbers.spin(j)
    largest, turning = 0.0, tuple[int, ...]()
    for rates in _pairs(c):
        moment = Z * (c @ rates) * np.cross(G @ rates, e)
        try:
            change = float(np.max(np.abs(np.linalg.solve(numbers.A, G.T @ moment)), initial=0.0))
        except np.linalg.LinAlgError:
            change = math.nan
        if math.isnan(change) or change > largest:
            largest, turning = change, tuple(int(k) for k in np.flatnonzero(rates))
        if math.isnan(change):
            break
    speed = math.inf if largest < NONE else math.sqrt(CHANGE / largest)
    names = () if math.isinf(speed) else tuple(machine.moving_joints[k].name for k in turning)
    return Rotor(joint.name, has_body, speed, names)


def _pairs(c: Array) -> Iterator[Array]:
    """Unit rates of a joint that the rotor follows and of one more, in both senses."""
    unit = np.eye(len(c))
    for v in np.flatnonzero(np.nan_to_num(c, nan=1.0)):
        yield unit[v]
        yield from (unit[v] + sign * unit[k] for k in range(len(c)) if k != v for sign in (1, -1))
