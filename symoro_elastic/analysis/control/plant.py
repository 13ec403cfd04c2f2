"""A linearized machine as its drives meet it: responses of positions and velocities to motor torques, and their slopes.

    Z(s) = s^2 M + s D + K + sum_j v_j^T C_j(s) (Kv_j p_j + s v_j)

v_j is the row of the velocity of motor j (its torque acts along v_j^T), p_j that of the position that its drive
controls, over what it changes with the motor; the sum is over the loops that are closed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.foundation.array_types import Array, ComplexArray

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

    def stiffness_at(self, s: ComplexArray, closed: Sequence[Cascade]) -> ComplexArray:
        """Return Z (frequencies, n, n) with some loops closed."""
        linear, s_ = self.linear, s[:, None, None]
        Z = s_ * s_ * linear.M + s_ * linear.D + linear.K
        for one in closed:
            axis = self.axes[one.motor]
            seen = one.Kv * axis.position + s[:, None] * axis.velocity
            Z = Z + one.controller(s)[:, None, None] * axis.velocity[:, None] * seen[:, None, :]
        return Z

    def moved(self, s: ComplexArray, closed: Sequence[Cascade], forces: Array) -> ComplexArray:
        """Return Z^-1 F (frequencies, n, forces) with some loops closed."""
        found = np.empty((len(s), *forces.shape), dtype=complex)
        N = self.free
        for first in range(0, len(s), BLOCK):
            part = slice(first, first + BLOCK)
            Z = N.T @ self.stiffness_at(s[part], closed) @ N
            found[part] = N @ np.linalg.solve(Z, (N.T @ forces).astype(complex)[None])
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
    row: Array = linear.Cq[linear.outputs.index(" ".join(name.split()))]
    return row


def response_slopes(
    plant: Plant, s: complex, closed: Sequence[Cascade], row: Array, force: Array
) -> dict[str, complex]:
    """Return the derivatives of row Z^-1 force by parameters, by name: - lambda^T dZ x with Z x = force.

    lambda solves Z^T lambda = row. Positions of springs follow their loads. Parameters of the geometry, on which rows
    depend, are left out.
    """
    N = plant.free
    Z = N.T @ plant.stiffness_at(np.array([s]), closed)[0] @ N
    x = (N @ np.linalg.solve(Z, N.T @ force)).astype(complex)
    left = (N @ np.linalg.solve(Z.T, N.T @ row)).astype(complex)
    change = _Changes(plant)
    change.add(left, x, s)
    if plant.damping:
        change.add_modal(left, x, s)
    return {name: -total for name, total in change.totals().items()}


class _Changes:
    """Columns of which lambda^T dZ x is the sum: left^T (dM xdd + dD xd + dK x), each with a factor."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self.left: list[Array] = []
        self.columns: list[tuple[Array, Array, Array]] = []
        self.factors: list[complex] = []

    def add(self, left: ComplexArray, x: ComplexArray, s: complex, only_mass: bool = False) -> None:
        """Add lambda^T (s^2 dM + s dD + dK) x: four products of real and imaginary parts."""
        nothing = np.zeros(len(x))
        for a, side in ((1.0, left.real), (1j, left.imag)):
            for b, part in ((1.0, np.real), (1j, np.imag)):
                moved = [nothing, nothing, part(x)] if only_mass else [part(x), part(s * x), part(s * s * x)]
                self._column(side, (moved[0], moved[1], moved[2]), a * b)

    def add_modal(self, left: ComplexArray, x: ComplexArray, s: complex) -> None:
        """Add s lambda^T dD x of damping in every mode, D = 2 zeta M R with R = (M^-1 K)^(1/2).

        In modal coordinates R is diag(w), and R dR + dR R = M^-1 (dK - dM R^2) gives
        dR_ij = phi_i^T (dK - w_j^2 dM) phi_j/(w_i + w_j). So lambda^T dD x = 2 zeta (lambda^T dM R x + sum_ij a_i dR_ij
        b_j), a = Phi^T M lambda, b = Phi^T M x. Both are zero where both modes are rigid.
        """
        linear, factor = self.plant.linear, 2 * self.plant.damping * s
        modal = modes(linear)
        w = np.sqrt(np.maximum(modal.eigenvalues, 0.0))
        a, b = modal.shapes.T @ linear.M @ left, modal.shapes.T @ linear.M @ x
        self.add(factor * left, modal.shapes @ (w * b), 0.0, only_mass=True)
        sums = w[:, None] + w
        weights = np.divide(a[:, None] * b, sums, out=np.zeros((len(a), len(b)), complex), where=sums > 0)
        for j, shape in enumerate(modal.shapes.T):
            side = factor * (modal.shapes @ weights[:, j])
            moved = (shape, np.zeros_like(shape), -(w[j] ** 2) * shape)
            self._column(side.real, moved, 1.0)
            self._column(side.imag, moved, 1j)

    def _column(self, left: Array, moved: tuple[Array, Array, Array], factor: complex) -> None:
        if left.any() and any(part.any() for part in moved):
            self.left.append(left)
            self.columns.append(moved)
            self.factors.append(factor)

    def totals(self) -> dict[str, complex]:
        """Return the sums by parameter."""
        linear = self.plant.linear
        columns = [np.stack(parts, axis=1) for parts in zip(*self.columns, strict=True)]
        left = np.stack(self.left, axis=1)
        slopes = linear.motion.parameter_slopes(linear.state, *(_spread(linear, x) for x in (left, *columns)))
        factors = np.array(self.factors)
        return {name: complex(row @ factors) for name, row in slopes.items()}


def _spread(linear: Linearization, columns: Array) -> Array:
    """Return columns over all joints that move, from those over the ones that are kept."""
    found = np.zeros((len(linear.motion.joints), columns.shape[1]))
    found[list(linear.kept)] = columns
    return found
