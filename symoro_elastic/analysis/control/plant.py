"""A linearized machine around its drives: responses of positions and velocities to motor torques, and their slopes.

    Z(s) = s^2 M + s D + K + sum_j v_j^T C_j(s) (Kv_j p_j + s v_j) + sum_j s Y_j(s) v_j^T v_j

v_j is the row of the velocity of motor j (its torque acts along v_j^T), p_j that of the position that its drive
controls, over what it changes with the motor; the sums are over the loops that are closed. Y_j is what the back-EMF
does to the torque behind a current controller.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.vibration.linearization import Linearization, LinearSlopes, linear_slopes, moved_by
from symoro_elastic.analysis.vibration.responses import with_modal_damping_slopes
from symoro_elastic.foundation.array_types import AnyArray, Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import outputs

BLOCK = 256
Ends = tuple[AnyArray, AnyArray]
"""The right sides (n,) of a response and of its adjoint."""


@dataclass(frozen=True)
class Axis:
    """The rows (n,) of a motor: of its velocity, and of the position that its drive controls, by the signal `measured`.

    It is that of the motor itself where `measured` is empty.
    """

    motor: str
    velocity: Array
    position: Array
    measured: str = ""


class Row(NamedTuple):
    """A row (n,) that maps q to a signal or a force to the coordinates, and its derivatives (p, n) by parameters."""

    values: Array | ComplexArray
    slopes: Array | ComplexArray


@dataclass(frozen=True)
class Plant:
    """A machine at one position: `linear` with a ratio `damping` in every mode, the axes of its motors by name.

    Motors that are `held` do not move. `place` are positions of joints, for messages.
    """

    linear: Linearization
    axes: Mapping[str, Axis]
    damping: float = 0.0
    held: tuple[str, ...] = ()
    place: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def free(self) -> Array:
        """A basis N (n, free) of the motions with locked motors: q = N x."""
        n = len(self.linear.M)
        if not self.held:
            return np.eye(n)
        rows = np.array([self.axes[name].velocity for name in self.held])
        _, sizes, basis = np.linalg.svd(rows)
        return np.asarray(basis[int(np.count_nonzero(sizes > 1e-12 * sizes[0])) :].T)

    @cached_property
    def slopes(self) -> LinearSlopes:
        """Derivatives of M, D, K by all parameters."""
        return with_modal_damping_slopes(linear_slopes(self.linear), self.damping)

    @cached_property
    def of_inverse_model(self) -> tuple[Array, Array, Array]:
        """M, D, K (m, m) at the motors with rigid springs, in order of `axes`, without modal damping."""
        linear, state = self.linear, self.linear.state
        V = np.array([axis.velocity for axis in self.axes.values()])
        if not np.array_equal(V @ V.T, np.eye(len(V))):
            what = "torque = true is for motors whose variables are independent: leave it out"
            raise InputError(linear.motion.source, "drives, feed_forward", what)
        matrices = linear.motion.matrices(("M", "D", "K"), state.q, state.qd, state.qdd, state.torques)
        M, D, K = (V @ matrix @ V.T for matrix in matrices)
        return M, D, K

    def needed_torque(self, s: ComplexArray, motor: str, by: str) -> ComplexArray:
        """Return the torque (frequencies,) of a motor that the inverse model requires per position of another motor."""
        names = [*self.axes]
        m, d, k = (matrix[names.index(motor), names.index(by)] for matrix in self.of_inverse_model)
        return np.asarray(s * s * m + s * d + k)

    def signal(self, name: str) -> Row:
        """Return the row of a position output with its slopes by parameters, through geometry and sag."""
        k = _output(self.linear, name)
        return Row(self.linear.Cq[k], self.slopes.C[0][:, k])

    def rows(self, motor: str) -> tuple[Row, Row]:
        """Return the rows of the velocity of a motor, and of the position that its drive controls."""
        axis, k = self.axes[motor], self.linear.motion.motor_names.index(motor)
        own = Row(axis.velocity, self.slopes.motors[:, k])
        if not axis.measured:
            return own, own
        row, square = self.signal(axis.measured), float(own.values @ own.values)
        ratio = row.values @ own.values / square
        changed = (row.slopes @ own.values + own.slopes @ (row.values - 2 * ratio * own.values)) / square
        return own, Row(axis.position, (row.slopes - np.outer(changed, axis.position)) / ratio)

    def stiffness_at(self, s: ComplexArray, closed: Sequence[Cascade]) -> ComplexArray:
        """Return N^T Z N (frequencies, free, free) with some loops closed."""
        return self._stiffness(s, closed, self.free)

    def _stiffness(self, s: ComplexArray, closed: Sequence[Cascade], N: Array) -> ComplexArray:
        """Return N^T Z N with some loops closed, as one product of coefficients and matrices."""
        linear = self.linear
        coefficients, matrices = [s * s, s, np.ones_like(s)], [linear.M, linear.D, linear.K]
        for drive in closed:
            axis = self.axes[drive.motor]
            coefficients += drive.feedback(s)
            matrices += [np.outer(axis.velocity, axis.position), np.outer(axis.velocity, axis.velocity)]
        flat = (N.T @ np.array(matrices) @ N).reshape(len(matrices), N.shape[1] ** 2).astype(complex)
        return np.asarray((np.stack(coefficients, axis=1) @ flat).reshape(len(s), N.shape[1], N.shape[1]))

    def work_slopes(
        self, s: complex, closed: Sequence[Cascade], adjoint: ComplexArray, x: ComplexArray, ends: Ends
    ) -> dict[str, complex]:
        """Return p left^T dZ/dp x by name p; `ends` are row and force (n,) of Z^T left = row, Z x = force.

        They hold up to what held motors do. Parameters change masses, springs and dampers, positions of springs, rows
        of motors, and numbers of drives.
        """
        at, slopes, values = np.array([s]), self.slopes, self.linear.motion.parameters
        by = adjoint @ (s * s * slopes.M + s * slopes.D + slopes.K) @ x
        totals: dict[str, complex] = {}
        for drive in closed:
            velocity, position = self.rows(drive.motor)
            gains = np.concatenate(drive.feedback(at))
            moved, pushed = np.array([position.values @ x, velocity.values @ x]), adjoint @ velocity.values
            by = by + (velocity.slopes @ adjoint) * (gains @ moved)
            by = by + pushed * (gains[0] * (position.slopes @ x) + gains[1] * (velocity.slopes @ x))
            for name, change in drive.slopes(lambda c: np.concatenate(c.feedback(at))).items():
                totals[name] = totals.get(name, 0) + complex(pushed * (change @ moved))
        if self.held:
            by = by + self._of_held(self._stiffness(at, closed, np.eye(len(x)))[0], adjoint, x, ends)
        for name, change in zip(slopes.names, by.tolist(), strict=True):
            totals[name] = totals.get(name, 0) + values[name] * change
        return totals

    def _of_held(self, Z: ComplexArray, adjoint: ComplexArray, x: ComplexArray, ends: Ends) -> ComplexArray:
        """Return the contribution of the locked motors' rows V, for which V x = 0, to the slopes by parameter.

        V^T a = force - Z x are their torques, V^T b = row - Z^T left those of the adjoint problem.
        """
        motors, (row, force) = [self.rows(name)[0] for name in self.held], ends
        V = np.array([motor.values for motor in motors]).T.astype(complex)
        a, b = np.linalg.lstsq(V, np.stack([force - Z @ x, row - Z.T @ adjoint], axis=1), rcond=None)[0].T
        terms = [motor.slopes @ (a[k] * adjoint + b[k] * x) for k, motor in enumerate(motors)]
        return np.asarray(np.sum(terms, axis=0), dtype=complex)

    def displacements(self, s: ComplexArray, closed: Sequence[Cascade], forces: AnyArray) -> ComplexArray:
        """Return the displacements Z^-1 F (frequencies, n, forces) with some loops closed."""
        N = self.free
        parts = [s[first : first + BLOCK] for first in range(0, len(s), BLOCK)]
        moved = [moved_by(lambda s: self.stiffness_at(s, closed), part, N.T @ forces) for part in parts]
        solution: ComplexArray = np.concatenate(moved or [np.zeros((0, N.shape[1], forces.shape[1]), dtype=complex)])
        return N @ solution if self.held else solution

    def response(self, s: ComplexArray, closed: Sequence[Cascade], row: Array, force: Array) -> ComplexArray:
        """Return row Z^-1 force (frequencies,) with some loops closed."""
        return np.asarray(self.displacements(s, closed, force[:, None])[:, :, 0] @ row)

    def axis_responses(
        self, s: ComplexArray, motor: str, closed: Sequence[Cascade]
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return the controlled position and the motor's own (frequencies,) by the torque of a motor."""
        axis = self.axes[motor]
        moved = self.displacements(s, closed, axis.velocity[:, None])[:, :, 0]
        return moved @ axis.position, moved @ axis.velocity


def _output(linear: Linearization, name: str) -> int:
    (signal,) = outputs(linear.motion.given, [name])
    return linear.outputs.index(signal.name)


def position_row(linear: Linearization, name: str) -> Array:
    """Return the row (n,) of an output that is a position, by its name."""
    return np.asarray(linear.Cq[_output(linear, name)])


def response_slopes(plant: Plant, s: complex, closed: Sequence[Cascade], row: Row, force: Row) -> dict[str, complex]:
    """Return p d(row Z^-1 force)/dp by name p: - lambda^T dZ x + drow x + lambda^T dforce with Z x = force.

    lambda solves Z^T lambda = row. Positions of springs follow their loads.
    """
    N, values, at = plant.free, plant.linear.motion.parameters, np.array([s])
    x = plant.displacements(at, closed, force.values[:, None])[0, :, 0]
    back = moved_by(lambda s: plant.stiffness_at(s, closed).transpose(0, 2, 1), at, N.T @ row.values[:, None])
    adjoint = N @ back[0, :, 0]
    work = plant.work_slopes(s, closed, adjoint, x, (row.values, force.values))
    totals = {name: -change for name, change in work.items()}
    for name, change in zip(plant.slopes.names, (row.slopes @ x + force.slopes @ adjoint).tolist(), strict=True):
        totals[name] += values[name] * change
    return totals
