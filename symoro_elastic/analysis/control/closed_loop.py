"""All closed loops as one linear system, x' = A x + B_0 r + B_1 rd + B_2 rdd + E f, with x = [q; qd; drives].

Dead times are approximations of Pade of order 2 here, a hold is half a period more; frequency responses have them
exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.control.drive_laws import RD, RDD, TAU, XD, DriveLaw, R, law_of
from symoro_elastic.analysis.control.plant import Plant
from symoro_elastic.foundation.array_types import Array, ComplexArray

NOTHING = 1e-13
"""Growth, of the fastest pole or in a period, that is rounding: of a mode without damping that no drive feels."""


@dataclass(frozen=True)
class ClosedLoop:
    """A plant with closed loops as a linear system: A, and the input columns of set points and of forces.

    `by_set_point` are B_0, B_1, B_2 (states, axes), of the set point and its two rates, `by_force` M^-1 (states, n).
    Coordinates are those of the `free` motions of the plant; set points are those behind their filters.
    """

    A: Array
    by_set_point: tuple[Array, Array, Array]
    by_force: Array
    motors: tuple[str, ...]
    free: Array

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of A, 1/s."""
        return np.asarray(np.linalg.eigvals(self.A).astype(complex))

    def is_stable(self, slow: float = 0.0) -> bool:
        """Whether no pole grows; poles slower than `slow`, 1/s, do not count."""
        sizes, poles = np.abs(self.poles), self.poles
        return bool((poles.real[sizes > slow] < NOTHING * sizes.max(initial=1.0)).all())

    @property
    def growth(self) -> float:
        """Largest real part of a pole, 1/s: negative if all decay, 0 within rounding."""
        poles = self.poles
        growth = float(poles.real.max())
        return growth if abs(growth) > NOTHING * np.abs(poles).max() else 0.0

    def velocity_error(self, motor: str, position: Array) -> float:
        """Return the following error of a position (n,) per velocity of a motor's set point, s: -dT/ds at 0."""
        axis, row = self.motors.index(motor), self._row(position)
        first, second = (columns[:, axis] for columns in self.by_set_point[:2])
        once = np.linalg.solve(self.A, first)
        return float(row @ (np.linalg.solve(self.A, once) + np.linalg.solve(self.A, second)))

    def static_compliance(self, row: Array, force: Array) -> float:
        """Return the static displacement row q by a force (n,)."""
        return float(-self._row(row) @ np.linalg.solve(self.A, self.by_force @ force))

    def _row(self, row: Array) -> Array:
        """Return a row over all states, from a row over q."""
        own = row @ self.free
        return np.concatenate([own, np.zeros(len(self.A) - len(own))])


def closed_loop(plant: Plant, cascades: Sequence[Cascade], of_delay: int = 1) -> ClosedLoop:
    """Return the system of a plant with the loops of drives closed; `of_delay` Pade elements per dead time."""
    linear, N = plant.linear, plant.free
    n, laws = N.shape[1], [linear_law(cascade, of_delay) for cascade in cascades]
    total = 2 * n + sum(len(law.A) for law in laws)
    inverse = np.linalg.inv(N.T @ linear.M @ N)
    A = np.zeros((total, total))
    A[:n, n : 2 * n] = np.eye(n)
    A[n : 2 * n, : 2 * n] = -inverse @ np.hstack([N.T @ linear.K @ N, N.T @ linear.D @ N])
    columns = tuple(np.zeros((total, len(cascades))) for _ in range(3))
    by_force = np.vstack([np.zeros((n, len(N))), inverse @ N.T, np.zeros((total - 2 * n, len(N)))])
    first = 2 * n
    for k, (drive, law) in enumerate(zip(cascades, laws, strict=True)):
        axis, own, B, D = plant.axes[drive.motor], slice(first, first + len(law.A)), law.B, law.D
        position, velocity = axis.position @ N, axis.velocity @ N
        push = inverse @ velocity
        A[own, own] = law.A
        A[own, : 2 * n] -= np.hstack([np.outer(B[:, R], position), -np.outer(B[:, XD], velocity)])
        A[n : 2 * n, own] = np.outer(push, law.C)
        A[n : 2 * n, : 2 * n] -= np.outer(push, np.concatenate([D[R] * position, -D[XD] * velocity]))
        for column, u in zip(columns, (R, RD, RDD), strict=True):
            column[own, k] += B[:, u]
            column[n : 2 * n, k] += push * D[u]
        if drive.torque_forward:
            rows = [[*plant.axes].index(name) for name in (drive.motor, *(x.motor for x in cascades))]
            for column, needed in zip(columns, reversed(plant.of_inverse_model), strict=True):
                by = needed[rows[0], rows[1:]]
                column[own] += np.outer(B[:, TAU], by)
                column[n : 2 * n] += np.outer(push * D[TAU], by)
        first = own.stop
    motors = tuple(drive.motor for drive in cascades)
    return ClosedLoop(A, (columns[0], columns[1], columns[2]), by_force, motors, N)


def linear_law(drive: Cascade, of_delay: int = 1) -> DriveLaw:
    """Return the linear law of a drive, which omits its limits and the filter of its set point."""
    return law_of(replace(drive, set_point=None, torque_limit=np.inf, voltage_limit=np.inf), of_delay)
