"""A linearized machine as its drives meet it: responses of positions and velocities to motor torques, and their slopes.

    Z(s) = s^2 M + s D + K + sum_j v_j^T C_j(s) (Kv_j p_j + s v_j) + sum_j s Y_j(s) v_j^T v_j

v_j is the row of the velocity of motor j (its torque acts along v_j^T), p_j that of the position that its drive
controls, over what it changes with the motor; the sums are over the loops that are closed. Y_j is what the back-EMF
does to the torque behind a current controller.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.responses import with_modal_damping_slopes
from symoro_elastic.analysis.vibration.slopes import LinearSlopes, linear_slopes
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import outputs

BLOCK = 256


@dataclass(frozen=True)
class Axis:
    """The rows (n,) of a motor: of its velocity, and of the position that its drive controls."""

    motor: str
    velocity: Array
    position: Array


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
        """A basis N (n, free) of the motions that held motors leave: q = N x."""
        n = len(self.linear.M)
        if not self.held:
            return np.eye(n)
        rows = np.array([self.axes[name].velocity for name in self.held])
        _, sizes, basis = np.linalg.svd(rows)
        basis_of_free: Array = basis[int(np.count_nonzero(sizes > 1e-12 * sizes[0])) :].T
        return basis_of_free

    @cached_property
    def slopes(self) -> LinearSlopes:
        """Derivatives of M, D, K by all parameters."""
        return with_modal_damping_slopes(linear_slopes(self.linear), self.damping)

    @cached_property
    def of_inverse_model(self) -> tuple[Array, Array, Array]:
        """M, D, K (m, m) that motors feel where springs do not deflect, in order of `axes`, damping ratios left out."""
        linear, state = self.linear, self.linear.state
        V = np.array([axis.velocity for axis in self.axes.values()])
        if not np.array_equal(V @ V.T, np.eye(len(V))):
            what = "torque = true is for motors whose variables are independent: leave it out"
            raise InputError(linear.motion.source, "drives, feed_forward", what)
        found = linear.motion.matrices(("M", "D", "K"), state.q, state.qd, state.qdd, state.torques)
        M, D, K = (V @ matrix @ V.T for matrix in found)
        return M, D, K

    def needed_torque(self, s: ComplexArray, motor: str, by: str) -> ComplexArray:
        """Return the torque (frequencies,) of a motor that the inverse model asks for by the position of another."""
        names = [*self.axes]
        m, d, k = (matrix[names.index(motor), names.index(by)] for matrix in self.of_inverse_model)
        found: ComplexArray = s * s * m + s * d + k
        return found

    def stiffness_at(self, s: ComplexArray, closed: Sequence[Cascade]) -> ComplexArray:
        """Return N^T Z N (frequencies, free, free) with some loops closed: one product of coefficients and matrices."""
        N, linear = self.free, self.linear
        coefficients, matrices = [s * s, s, np.ones_like(s)], [linear.M, linear.D, linear.K]
        for one in closed:
            axis, C = self.axes[one.motor], one.controller(s)
            braked = C + one.current.dragged(s) if one.current else C
            coefficients += [one.Kv * C, s * braked]
            matrices += [np.outer(axis.velocity, axis.position), np.outer(axis.velocity, axis.velocity)]
        flat = (N.T @ np.array(matrices) @ N).reshape(len(matrices), N.shape[1] ** 2).astype(complex)
        found: ComplexArray = (np.stack(coefficients, axis=1) @ flat).reshape(len(s), N.shape[1], N.shape[1])
        return found

    def moved(self, s: ComplexArray, closed: Sequence[Cascade], forces: Array) -> ComplexArray:
        """Return Z^-1 F (frequencies, n, forces) with some loops closed."""
        found = np.empty((len(s), *forces.shape), dtype=complex)
        N = self.free
        pushed = (N.T @ forces).astype(complex)[None]
        for first in range(0, len(s), BLOCK):
            part = slice(first, first + BLOCK)
            moved = np.linalg.solve(self.stiffness_at(s[part], closed), pushed)
            found[part] = N @ moved if self.held else moved
        return found

    def response(self, s: ComplexArray, closed: Sequence[Cascade], row: Array, force: Array) -> ComplexArray:
        """Return row Z^-1 force (frequencies,) with some loops closed."""
        found: ComplexArray = self.moved(s, closed, force[:, None])[:, :, 0] @ row
        return found

    def axis_responses(
        self, s: ComplexArray, motor: str, closed: Sequence[Cascade]
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return the controlled position and the motor's own (frequencies,) by the torque of a motor."""
        axis = self.axes[motor]
        moved = self.moved(s, closed, axis.velocity[:, None])[:, :, 0]
        return moved @ axis.position, moved @ axis.velocity


def position_row(linear: Linearization, name: str) -> Array:
    """Return the row (n,) of an output that is a position, by its name."""
    (signal,) = outputs(linear.motion.given, [name])
    row: Array = linear.Cq[linear.outputs.index(signal.name)]
    return row


def response_slopes(
    plant: Plant, s: complex, closed: Sequence[Cascade], row: Array, force: Array
) -> dict[str, complex]:
    """Return the derivatives of row Z^-1 force by parameters, by name: - lambda^T dZ x with Z x = force.

    lambda solves Z^T lambda = row. Positions of springs follow their loads. Parameters of the geometry, on which rows
    depend, are left out.
    """
    N, slopes = plant.free, plant.slopes
    Z = plant.stiffness_at(np.array([s]), closed)[0]
    x, left = N @ np.linalg.solve(Z, N.T @ force), N @ np.linalg.solve(Z.T, N.T @ row)
    found = -(left @ (s * s * slopes.M + s * slopes.D + slopes.K) @ x)
    return dict(zip(slopes.names, found.tolist(), strict=True))
