"""A bound machine in numbers at one position: S, inertia and velocity forces over the independent variables.

Formulas for all pairs of variables are long, and nobody reads them where only numbers are asked for. The recursions run
on rows of numbers instead, one number for each variable or state, so that steps are as many as joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.coordinates import Row
from symoro_elastic.mechanics.dynamics import AccelerationKnown, Rule, dynamics
from symoro_elastic.mechanics.kinematics import frames, velocities
from symoro_elastic.mechanics.mechanism import without_loads
from symoro_elastic.mechanics.spatial import RigidInertia, Twist, Vector
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate


class Position:
    """S, inertia and velocity forces of a bound machine at a position; columns follow the independent variables."""

    def __init__(self, bound: Bound, symbols: Mapping[str, float]) -> None:
        """Evaluate the mechanism; raises `ZeroDivisionError` where a formula has no value."""
        self.bound, self.symbols = bound, symbols
        mechanism, S = without_loads(bound.without_tip_angles), bound.coordinates.S
        entries = [x for row in S.values() for x in row.values()]
        value: Any = evaluate([*mechanism.scalars(), *entries], symbols, FLOATS)
        self.mechanism = mechanism.map(value)
        self.frames = frames(self.mechanism)
        self._columns = {k: column for column, k in enumerate(bound.machine.independent)}
        self.S = np.zeros((len(self.mechanism.links) + 1, len(self._columns)))
        for j, row in S.items():
            for k, x in row.items():
                self.S[j, self._columns[k]] = float(value(x))
        self._velocities = self._unit_velocities()

    def rows(self, rows: Sequence[Row]) -> Array:
        """Numeric matrix of the given rows of S (L1)."""
        value: Any = evaluate([x for row in rows for x in row.values()], self.symbols, FLOATS)
        matrix = np.zeros((len(rows), len(self._columns)))
        for number, row in enumerate(rows):
            for k, x in row.items():
                matrix[number, self._columns[k]] = float(value(x))
        return matrix

    def number(self, x: Scalar) -> float:
        """The numeric value of an expression at this position."""
        value: Any = evaluate([x], self.symbols, FLOATS)
        return float(value(x))

    def inertia(self) -> Array:
        """A = sum of V_j^T JJ_j V_j + Ia_j S_j^T S_j, six rows and columns of a floating base first (L21).

        Modes of flexible bodies add S_k^T Mee S_k + S_k^T U_k^T V_j and its transpose (L55).
        """
        bodies = [self.mechanism.body or RigidInertia(), *(link.body for link in self.mechanism.links)]
        size = self.S.shape[1] + self._of_base
        V = np.array([_stack(twist.entries, size) for twist in self._velocities])
        F = np.array(
            [_stack((body.spatial * twist).entries, size) for body, twist in zip(bodies, self._velocities, strict=True)]
        )
        rotors = np.array([0.0, *(_float(link.rotor_inertia) for link in self.mechanism.links)])
        S = np.pad(self.S, ((0, 0), (self._of_base, 0)))
        A: Array = V.reshape(-1, size).T @ F.reshape(-1, size) + S.T @ (rotors[:, None] * S)
        for j, link in self.mechanism.from_base():
            if link.modes is not None:
                rows, masses = S[list(link.modes.numbers)], np.array(link.modes.Mee, dtype=float)
                U = np.array([[*map(_float, wrench.entries)] for wrench in link.modes.wrenches().values()])
                A = A + rows.T @ (masses @ rows + 2 * U @ V[j])
        return (A + A.T) / 2

    def turning(self, j: int) -> Array:
        """Angular velocity of body j per unit of the independent rates, in frame 0: 3 x n."""
        angular = _stack(self._velocities[j].angular, self.S.shape[1])
        velocity: Array = np.array([[*map(_float, row)] for row in self.frames[j].rotation]) @ angular
        return velocity

    def axis(self, j: int) -> Array:
        """Axis z of joint j's frame, in frame 0."""
        return np.array([_float(c) for c in self.frames[j].z])

    def velocity_forces(self, rates: Array) -> Array:
        """Coriolis and centrifugal forces H (n, states) for rows of rates (states, n), on a base at rest (L20)."""
        names = dict(zip(self.bound.arguments()["qd"], rates.T, strict=True))
        bias = self.bound.bias_accelerations()
        value: Any = evaluate(bias, {**self.symbols, **names}, FLOATS)
        rules: list[Rule | None] = [None] * len(self.S)
        for j in self.bound.machine.articulated:
            rules[j] = AccelerationKnown(value(bias[j]))
        torques = dynamics(self.mechanism, list(self.S @ rates.T), rules).Gamma
        forces = _stack([torques.get(j, 0.0) for j in range(len(self.S))], len(rates))
        H: Array = self.S.T @ forces
        return H

    @property
    def _of_base(self) -> int:
        return self.bound.machine.degrees_of_base

    def _unit_velocities(self) -> list[Twist]:
        """V_j [3] per unit of the velocities of a floating base and of the rates: components are rows of numbers."""
        rates, mechanism = np.pad(self.S, ((0, 0), (self._of_base, 0))), self.mechanism
        if self._of_base:
            unit = np.eye(6, rates.shape[1])
            mechanism = replace(mechanism, velocity=Twist(Vector(*unit[:3]), Vector(*unit[3:])))
        return velocities(mechanism, list(rates))


def _float(x: Any) -> float:
    return float(x)


def _stack(rows: Iterable[Any], size: int) -> Array:
    """Matrix of rows, scalars being broadcast to the given size."""
    return np.array([np.broadcast_to(x, size) for x in rows], dtype=float)
