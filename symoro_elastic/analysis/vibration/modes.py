"""Natural frequencies and mode shapes of a linearization: K phi = lambda M phi, and the poles with damping.

Motions without any stiffness are found in the structure of K and are exactly at 0 Hz; other eigenvalues below
the rounding errors of the computation are set to zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from symoro_elastic.array_types import AnyArray, Array, ComplexArray
from symoro_elastic.errors import InputError
from symoro_elastic.packages import for_vibrations
from symoro_elastic.results import Part, Result, Titled
from symoro_elastic.vibration.inertia import MATRIX_ROUNDING, refuse_singular
from symoro_elastic.vibration.linearization import Linearization

if TYPE_CHECKING:
    from symoro_elastic.vibration.sensitivity import Sensitivity

LEAST_DAMPING = 1e-12
"""Damping ratios up to here are rounding."""
ALIKE = 1e-7
"""Eigenvalues closer than this, relative, belong to one repeated frequency."""


@dataclass(frozen=True, repr=False)
class Modes(Result):
    """Modes by ascending frequency; `shapes` (n, m) are columns phi with phi^T M phi = 1 in coordinates of q.

    `eigenvalues` (m,) are omega^2, rad2/s2, negative where the state is unstable; `damping_ratios` (m,) are NaN at
    0 Hz; `poles` (2n,) rad/s. The first `rigid` modes at 0 Hz move freely.
    """

    linear: Linearization
    eigenvalues: Array
    shapes: Array
    damping_ratios: Array
    poles: ComplexArray

    @property
    def frequencies(self) -> Array:
        """sqrt(omega^2) / 2 pi, Hz; 0 where the motion does not oscillate."""
        hertz: Array = np.sqrt(np.maximum(self.eigenvalues, 0.0)) / (2 * np.pi)
        return hertz

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Derivatives of the frequencies by stiffnesses, inertias and other parameters."""
        from symoro_elastic.vibration.sensitivity import sensitivity

        return sensitivity(self)

    @property
    def growth(self) -> Array:
        """Rate 1/s of unstable motions exp(growth t); 0 for all others."""
        rates: Array = np.sqrt(np.maximum(-self.eigenvalues, 0.0))
        return rates

    @property
    def rigid(self) -> int:
        """Number of modes at exactly 0 Hz."""
        return int(np.sum(self.eigenvalues == 0.0))

    def clusters(self) -> list[slice]:
        """Return the modes of each repeated frequency, a slice each."""
        return clusters(self.eigenvalues)

    @property
    def headline(self) -> str:
        """Machine, modes and the lowest frequency."""
        moving = self.frequencies[self.frequencies > 0]
        first = f", first {moving.min():.4g} Hz" if len(moving) else ""
        return f"Modes of {self.linear.motion.machine.name}: {len(self.eigenvalues)}{first}"

    def parts(self) -> list[Part]:
        """Return the state, the table of modes, and the spring that limits the first."""
        from symoro_elastic.vibration.tables import modes_conclusion, modes_table, state_lines

        slopes = self.sensitivity
        table = Titled(modes_table(self, slopes), self.linear.motion.machine.name)
        return [*state_lines(self.linear), *self.linear.doubts, table, modes_conclusion(self, slopes)]

    def as_json(self) -> dict[str, Any]:
        """Return frequencies, shapes, energies and sensitivities as plain data."""
        from symoro_elastic.vibration.tables import modes_json

        return modes_json(self, self.sensitivity)

    def arrays(self) -> dict[str, AnyArray]:
        """Return frequencies, damping, poles, shapes and sensitivities by name."""
        from symoro_elastic.vibration.export import modes_arrays

        return modes_arrays(self, self.sensitivity)

    def columns(self) -> dict[str, Any]:
        """Return a row for each mode: Hz, damping ratio, 1/s of growth, share of the strain energy by spring."""
        from symoro_elastic.vibration.energies import strain_shares

        strain = strain_shares(self)
        shares = {f"strain in {name}": row for name, row in zip(strain.names, strain.shares, strict=True)}
        figures = {"frequency": self.frequencies, "damping_ratio": self.damping_ratios, "growth": self.growth}
        return {**figures, **shares}


def modes(linear: Linearization) -> Modes:
    """Return the modes of M dqdd + D dqd + K dq = 0.

    Raises `InputError` where K is not symmetric, or M not positive definite.
    """
    motion = linear.motion
    if not linear.is_symmetric:
        what = (
            "K is not symmetric, since wrenches turn with their bodies or the state moves, so modes are not real: "
            "linearize gives A and its poles, and --hover carries a base by forces of constant direction"
        )
        raise InputError(motion.source, "modes", what)
    refuse_singular(motion, linear.M, linear.kept)
    eigenvalues, shapes = _eigen(linear.M, (linear.K + linear.K.T) / 2)
    shapes = shapes * np.where(np.sum(shapes * np.abs(shapes) ** 7, axis=0) < 0, -1.0, 1.0)
    poles, vectors = damped(linear)
    return Modes(linear, eigenvalues, shapes, _damping_ratios(linear, eigenvalues, shapes, poles, vectors), poles)


def refuse_rigid(linear: Linearization) -> None:
    """Raise `InputError` where no coordinate is left to vibrate."""
    if not linear.kept:
        why = "all motors are held and no other joint moves" if linear.motion.motors else "no joint moves"
        raise InputError(linear.motion.source, "modes", f"nothing can vibrate: {why}")


def clusters(eigenvalues: Array) -> list[slice]:
    """Return runs of eigenvalues that agree to a relative 1e-7, all zeros together."""
    runs: list[slice] = []
    for k, x in enumerate(eigenvalues):
        before = eigenvalues[runs[-1].start] if runs else 0.0
        if runs and abs(x - before) <= ALIKE * max(abs(x), abs(before)):
            runs[-1] = slice(runs[-1].start, k + 1)
        else:
            runs.append(slice(k, k + 1))
    return runs


def _eigen(M: Array, K: Array) -> tuple[Array, Array]:
    """Return eigenvalues in ascending order and mass-normalised shapes.

    Coordinates r without stiffness are eliminated first: phi_r = -Mrr^-1 Mre phi_e, and they move freely alone.
    """
    n = len(M)
    scale = 1 / np.sqrt(np.diag(M))
    M, K = M * np.outer(scale, scale), K * np.outer(scale, scale)
    free = np.flatnonzero(~K.any(axis=0))
    stiff = np.flatnonzero(K.any(axis=0))
    carried = np.linalg.solve(M[np.ix_(free, free)], M[np.ix_(free, stiff)])
    reduced = M[np.ix_(stiff, stiff)] - M[np.ix_(stiff, free)] @ carried
    shapes = np.zeros((n, n))
    shapes[free, : len(free)] = _normal_basis(M[np.ix_(free, free)])
    values = np.zeros(n)
    if len(stiff):
        elastic, vectors = for_vibrations("scipy.linalg").eigh(K[np.ix_(stiff, stiff)], (reduced + reduced.T) / 2)
        elastic[np.abs(elastic) <= MATRIX_ROUNDING * n * np.abs(elastic).max()] = 0.0
        values[len(free) :] = elastic
        shapes[stiff, len(free) :] = vectors
        shapes[free, len(free) :] = -carried @ vectors
    order = np.argsort(values, kind="stable")
    return values[order], scale[:, None] * shapes[:, order]


def _normal_basis(M: Array) -> Array:
    """Return columns X with X^T M X = 1."""
    return np.linalg.inv(np.linalg.cholesky(M)).T if len(M) else M


def damped(linear: Linearization) -> tuple[ComplexArray, ComplexArray]:
    """Return poles (2n,), rad/s, and shapes (n, 2n) of the damped motions, zero for rigid-body poles.

    Coordinates on which nothing depends give poles at exactly 0. Raises `InputError` where M is not positive definite.
    """
    refuse_singular(linear.motion, linear.M, linear.kept)
    n = len(linear.K)
    scale = 1 / np.sqrt(np.diag(linear.M))
    both = np.outer(scale, scale)
    rate = max(1.0, np.sqrt(np.abs(linear.K * both).max(initial=0.0)))
    solved = np.linalg.solve(linear.M * both, -np.hstack([linear.K * both / rate**2, linear.D * both / rate]))
    A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), solved])
    kept = np.arange(2 * n)
    while len(kept) and (idle := ~A[np.ix_(kept, kept)].any(axis=0)).any():
        kept = kept[~idle]
    poles, shapes = np.zeros(2 * n, dtype=complex), np.zeros((n, 2 * n), dtype=complex)
    if len(kept):
        roots, vectors = np.linalg.eig(A[np.ix_(kept, kept)])
        roots[np.abs(roots) ** 2 <= MATRIX_ROUNDING * n] = 0.0
        whole = np.zeros((2 * n, len(kept)), dtype=complex)
        whole[kept] = vectors
        poles[: len(kept)], shapes[:, : len(kept)] = roots * rate, scale[:, None] * whole[:n]
    if not linear.D.any() and linear.is_symmetric:
        poles = np.where(np.abs(poles.real) < np.abs(poles.imag), 1j * poles.imag, poles.real)
    order = np.lexsort((poles.imag, np.abs(poles)))
    return poles[order], shapes[:, order]


def _damping_ratios(
    linear: Linearization,
    eigenvalues: Array,
    shapes: Array,
    poles: ComplexArray,
    vectors: ComplexArray,
) -> Array:
    """Return -Re p / |p| of the pole pair with the most similar shape; phi^T D phi / (2 omega) without one."""
    ratios = np.full(len(eigenvalues), np.nan)
    swings = np.flatnonzero(eigenvalues > 0)
    omega = np.sqrt(eigenvalues[swings])
    ratios[swings] = np.sum(shapes[:, swings] * (linear.D @ shapes[:, swings]), axis=0) / (2 * omega)
    pairs = np.flatnonzero(poles.imag > 0)
    if not linear.D.any() or not len(pairs):
        return ratios
    projected = np.abs(shapes[:, swings].T @ linear.M @ vectors[:, pairs]) ** 2
    norms = np.einsum("ik,ij,jk->k", vectors[:, pairs].conj(), linear.M, vectors[:, pairs]).real
    cost = -projected / np.maximum(norms, np.finfo(float).tiny) + np.abs(np.log(np.abs(poles[pairs]) / omega[:, None]))
    rows, columns = for_vibrations("scipy.optimize").linear_sum_assignment(cost)
    paired = poles[pairs[columns]]
    ratios[swings[rows]] = -paired.real / np.abs(paired)
    ratios[np.abs(ratios) <= LEAST_DAMPING] = 0.0
    return ratios
