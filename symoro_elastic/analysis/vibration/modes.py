"""Natural frequencies and mode shapes of a linearization: K phi = lambda M phi, the poles with damping, sensitivities.

Motions without any stiffness are found in the structure of K and are exactly at 0 Hz; other eigenvalues below
the rounding errors of the computation are set to zero. Derivatives by a parameter p are

    d lambda / dp = phi^T (dK/dp - lambda dM/dp) phi,    phi^T M phi = 1

with dK/dp along the equilibrium, which moves with p: dq/dp = -K^-1 dr/dp. Of a repeated frequency the slopes are
the eigenvalues of Phi^T (dK/dp - lambda dM/dp) Phi, since p may split it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.vibration.linearization import (
    Linearization,
    chosen_parameters,
    linear_slopes,
    pole_slopes,
    ratio_slopes,
)
from symoro_elastic.foundation.array_types import Array, ComplexArray, IndexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.results import Result
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.numerics.motion.inertia import MATRIX_ROUNDING, refuse_singular

LEAST_DAMPING = 1e-12
"""Damping ratios up to here are rounding."""
ALIKE = 1e-7
"""Eigenvalues closer than this, relative, belong to one repeated frequency."""
GRAVITY_AND_LOADS = "gravity and loads"


@dataclass(frozen=True)
class Sensitivity:
    """df/dp (parameters, modes), Hz by the unit of the parameter; zero for modes at 0 Hz.

    `relative` is p/f df/dp: per cent of frequency by per cent of the parameter. `repeated` are the modes of each
    frequency that comes more than once: a parameter splits it, and their slopes are in ascending order for each
    parameter, not by mode.
    """

    parameters: tuple[str, ...]
    values: Array
    slopes: Array
    frequencies: Array
    repeated: tuple[tuple[int, ...], ...] = ()

    @property
    def relative(self) -> Array:
        """p/f df/dp (parameters, modes); zero for modes at 0 Hz."""
        over = np.where(self.frequencies > 0, self.frequencies, np.inf)
        return np.asarray(self.values[:, None] * self.slopes / over)

    def sharing(self, mode: int) -> tuple[int, ...]:
        """Return the modes of the same frequency, including this one."""
        return next((modes for modes in self.repeated if mode in modes), (mode,))

    def strongest(self, mode: int, count: int) -> list[tuple[str, float, float]]:
        """Return the most influential parameters, with the least and the largest of their relative derivatives."""
        relative = self.relative[:, list(self.sharing(mode))]
        order = np.argsort(-np.abs(relative).max(axis=1), kind="stable")[:count]
        rows = [(self.parameters[k], relative[k]) for k in order if relative[k].any()]
        return [(name, float(row.min()), float(row.max())) for name, row in rows]


@dataclass(frozen=True, repr=False)
class Modes(Result):
    """Modes by ascending frequency; `shapes` (n, m) are columns phi with phi^T M phi = 1 in coordinates of q.

    `eigenvalues` (m,) are omega^2, rad2/s2, negative where the state is unstable; `damping_ratios` (m,) are NaN at
    0 Hz; `poles` (2n,) rad/s, `paired` (m,) the index of the one of each mode, -1 without one. The first `rigid` modes
    at 0 Hz move freely.
    """

    linear: Linearization
    eigenvalues: Array
    shapes: Array
    damping_ratios: Array
    poles: ComplexArray
    paired: IndexArray

    @property
    def frequencies(self) -> Array:
        """sqrt(omega^2) / 2 pi, Hz; 0 for motions without oscillation."""
        return np.asarray(np.sqrt(np.maximum(self.eigenvalues, 0.0)) / (2 * np.pi))

    @cached_property
    def sensitivity(self) -> Sensitivity:
        """Derivatives of the frequencies by stiffnesses, inertias and other parameters."""
        return sensitivity(self)

    @cached_property
    def damping_sensitivity(self) -> DampingSensitivity:
        """Derivatives of the damping ratios by all parameters."""
        slopes, there = linear_slopes(self.linear), np.flatnonzero(self.paired >= 0)
        poles = self.poles[self.paired[there]]
        slopes_of_ratios = np.full((len(slopes.names), len(self.eigenvalues)), np.nan)
        slopes_of_ratios[:, there] = ratio_slopes(poles, pole_slopes(slopes, poles))[1]
        values = np.array([self.linear.motion.parameters[name] for name in slopes.names])
        return DampingSensitivity(slopes.names, values, slopes_of_ratios, self.damping_ratios)

    @property
    def growth(self) -> Array:
        """Rate 1/s of unstable motions exp(growth t); 0 for all others."""
        return np.asarray(np.sqrt(np.maximum(-self.eigenvalues, 0.0)))

    @property
    def rigid(self) -> int:
        """Number of modes at exactly 0 Hz."""
        return int(np.sum(self.eigenvalues == 0.0))

    @property
    def headline(self) -> str:
        """Machine, modes and the lowest frequency."""
        moving = self.frequencies[self.frequencies > 0]
        first = f", first {moving.min():.4g} Hz" if len(moving) else ""
        return f"Modes of {self.linear.motion.machine.name}: {len(self.eigenvalues)}{first}"


def modes(linear: Linearization) -> Modes:
    """Return the modes of M dqdd + D dqd + K dq = 0.

    Raises `InputError` where K is not symmetric, or M not positive definite.
    """
    motion = linear.motion
    if not linear.is_symmetric:
        why = "K is not symmetric, because wrenches turn with their bodies or the state moves, so modes are not real"
        way_out = "linearize gives A and its poles, and --hover supports a base by forces of constant direction"
        raise InputError(motion.source, "modes", f"{why}: {way_out}")
    refuse_singular(motion, linear.M, linear.kept)
    eigenvalues, shapes = _eigen(linear.M, (linear.K + linear.K.T) / 2)
    shapes = shapes * np.where(np.sum(shapes * np.abs(shapes) ** 7, axis=0) < 0, -1.0, 1.0)
    poles, vectors = damped_poles(linear)
    paired = _paired_poles(linear, eigenvalues, shapes, poles, vectors)
    ratios = _damping_ratios(linear, eigenvalues, shapes, poles, paired)
    return Modes(linear, eigenvalues, shapes, ratios, poles, paired)


def refuse_rigid(linear: Linearization) -> None:
    """Raise `InputError` without a coordinate that can vibrate."""
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
    if len(free):
        shapes[free, : len(free)] = np.linalg.inv(np.linalg.cholesky(M[np.ix_(free, free)])).T  # X^T M X = 1
    values = np.zeros(n)
    if len(stiff):
        elastic, vectors = for_vibrations("scipy.linalg").eigh(K[np.ix_(stiff, stiff)], (reduced + reduced.T) / 2)
        elastic[np.abs(elastic) <= MATRIX_ROUNDING * n * np.abs(elastic).max()] = 0.0
        values[len(free) :] = elastic
        shapes[stiff, len(free) :] = vectors
        shapes[free, len(free) :] = -carried @ vectors
    order = np.argsort(values, kind="stable")
    return values[order], scale[:, None] * shapes[:, order]


def damped_poles(linear: Linearization) -> tuple[ComplexArray, ComplexArray]:
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
    active = np.arange(2 * n)
    while len(active) and (idle := ~A[np.ix_(active, active)].any(axis=0)).any():
        active = active[~idle]
    poles, shapes = np.zeros(2 * n, dtype=complex), np.zeros((n, 2 * n), dtype=complex)
    if len(active):
        roots, vectors = np.linalg.eig(A[np.ix_(active, active)])
        roots[np.abs(roots) ** 2 <= MATRIX_ROUNDING * n] = 0.0
        full = np.zeros((2 * n, len(active)), dtype=complex)
        full[active] = vectors
        poles[: len(active)], shapes[:, : len(active)] = roots * rate, scale[:, None] * full[:n]
    if not linear.D.any() and linear.is_symmetric:
        poles = np.where(np.abs(poles.real) < np.abs(poles.imag), 1j * poles.imag, poles.real)
    order = np.lexsort((poles.imag, np.abs(poles)))
    return poles[order], shapes[:, order]


def _paired_poles(
    linear: Linearization, eigenvalues: Array, shapes: Array, poles: ComplexArray, vectors: ComplexArray
) -> IndexArray:
    """Return for each mode the index of the pole with the most similar shape and frequency, -1 without one."""
    paired, swings = np.full(len(eigenvalues), -1), np.flatnonzero(eigenvalues > 0)
    pairs = np.flatnonzero(poles.imag > 0)
    if not linear.D.any() or not len(pairs):
        return paired
    projected = np.abs(shapes[:, swings].T @ linear.M @ vectors[:, pairs]) ** 2
    norms = np.einsum("ik,ij,jk->k", vectors[:, pairs].conj(), linear.M, vectors[:, pairs]).real
    apart = np.abs(np.log(np.abs(poles[pairs]) / np.sqrt(eigenvalues[swings])[:, None]))
    cost = apart - projected / np.maximum(norms, np.finfo(float).tiny)
    rows, columns = for_vibrations("scipy.optimize").linear_sum_assignment(cost)
    paired[swings[rows]] = pairs[columns]
    return paired


def _damping_ratios(
    linear: Linearization, eigenvalues: Array, shapes: Array, poles: ComplexArray, paired: IndexArray
) -> Array:
    """Return the damping ratios -Re p / |p| of the modes' poles; phi^T D phi / (2 omega) for modes without a pole."""
    ratios = np.full(len(eigenvalues), np.nan)
    swings = np.flatnonzero(eigenvalues > 0)
    own = shapes[:, swings]
    ratios[swings] = np.sum(own * (linear.D @ own), axis=0) / (2 * np.sqrt(eigenvalues[swings]))
    there = np.flatnonzero(paired >= 0)
    ratios[there] = -poles[paired[there]].real / np.abs(poles[paired[there]])
    ratios[np.abs(ratios) <= LEAST_DAMPING] = 0.0
    return ratios


@dataclass(frozen=True)
class DampingSensitivity:
    """d zeta/dp (parameters, modes) of damping ratios, by the unit of the parameter.

    NaN for modes without a pole of their own, as those of rigid or overdamped motions, and for repeated poles.
    """

    parameters: tuple[str, ...]
    values: Array
    slopes: Array
    ratios: Array


def sensitivity(modal: Modes, parameters: Sequence[str] = ()) -> Sensitivity:
    """Return the derivatives of all frequencies by parameters, all that have an influence unless some are named.

    Numbers of the table are called `<joint>.<quantity>`, `ram.mass`. Raises `InputError` for unknown names.
    """
    motion = modal.linear.motion
    names = chosen_parameters(motion, parameters)
    slopes = _eigenvalue_slopes(modal, names)
    frequencies = modal.frequencies
    rate = np.divide(1, 8 * np.pi**2 * frequencies, out=np.zeros_like(frequencies), where=frequencies > 0)
    slopes *= rate
    influential = [k for k in range(len(names)) if parameters or slopes[k].any()]
    values = np.array([motion.parameters[names[k]] for k in influential])
    swinging = [c for c in clusters(modal.eigenvalues) if modal.eigenvalues[c.start] > 0]
    repeated = tuple(tuple(range(c.start, c.stop)) for c in swinging if c.stop - c.start > 1)
    return Sensitivity(tuple(names[k] for k in influential), values, slopes[influential], frequencies, repeated)


def _eigenvalue_slopes(modal: Modes, names: Sequence[str]) -> Array:
    """Return d lambda / dp (names, modes); zero for modes at 0 Hz."""
    motion, state = modal.linear.motion, modal.linear.state
    swinging = [cluster for cluster in clusters(modal.eigenvalues) if modal.eigenvalues[cluster.start] > 0]
    modes = [range(cluster.start, cluster.stop) for cluster in swinging]
    pairs = [(a, b) for cluster in modes for a in cluster for b in cluster]
    slopes = np.zeros((len(names), len(modal.eigenvalues)))
    if not pairs:
        return slopes
    squared = np.concatenate([np.full(len(c) ** 2, modal.eigenvalues[list(c)].mean()) for c in modes])
    if modal.linear.gains.any() and not modal.linear.unrest:  # rows of motors under a controller change, too
        changed = linear_slopes(modal.linear, names)
        phi_a, phi_b = modal.shapes[:, [a for a, _ in pairs]], modal.shapes[:, [b for _, b in pairs]]
        total = np.sum(phi_a * (changed.K @ phi_b - squared * (changed.M @ phi_b)), axis=1)
    else:
        shapes = np.zeros((len(motion.joints), len(modal.eigenvalues)))
        shapes[list(modal.linear.kept)] = modal.shapes
        phi_a, phi_b = shapes[:, [a for a, _ in pairs]], shapes[:, [b for _, b in pairs]]
        by_name = motion.parameter_slopes(state, phi_a, phi_b, np.zeros_like(phi_b), -squared * phi_b)
        total = np.array([by_name[name] for name in names])
    first = 0
    for cluster, size in zip(swinging, map(len, modes), strict=True):
        split = total[:, first : first + size**2].reshape(-1, size, size)
        slopes[:, cluster] = np.linalg.eigvalsh((split + split.transpose(0, 2, 1)) / 2)
        first += size**2
    return slopes


@dataclass(frozen=True)
class Shares:
    """Fractions of energy, rows by `names`, columns by mode; a column sums to 1, or is zero without energy."""

    names: tuple[str, ...]
    shares: Array

    @property
    def by_name(self) -> dict[str, Array]:
        """Energy fractions (modes,) by name."""
        return dict(zip(self.names, self.shares, strict=True))

    def largest(self, mode: int) -> tuple[str, float]:
        """Return the name with the largest energy fraction in a mode, and this fraction."""
        k = int(self.shares[:, mode].argmax())
        return self.names[k], float(self.shares[k, mode])


def frame_shapes(modal: Modes) -> Array:
    """Return J phi (frames, 6, modes): displacement and small rotation of every frame, in axes of frame 0."""
    motion = modal.linear.motion
    moved = _drift(modal, motion.frame_motions[0])
    frames = moved.reshape(len(moved) // 6, 6, moved.shape[1])
    return frames[1 : 1 + len(motion.machine.joints)]


def kinetic_shares(modal: Modes) -> Shares:
    """Return shares of kinetic energy: (V_j^T JJ_j V_j) / 2 of bodies and Ia qd_j^2 / 2 of rotors [13]."""
    motion = modal.linear.motion
    moved = _drift(modal, motion.body_velocities)
    screws = moved.reshape(len(moved) // 6, 6, modal.shapes.shape[1])
    bodies = motion.body_inertias(modal.linear.state.q)
    energies = np.einsum("jkm,jkl,jlm->jm", screws[1 : 1 + len(bodies)], bodies, screws[1 : 1 + len(bodies)])
    for j, (numbers, U, masses) in motion.modal_inertias(modal.linear.state.q).items():
        rates = _drift(modal, [motion.bound.rate(k) for k in numbers])
        energies[j - 1] += (rates * (masses @ rates + 2 * U @ screws[j])).sum(axis=0)
    inertias = motion.values(inertia for inertia, _ in motion.rotors.values())
    turning = inertias[:, None] * _drift(modal, [rate for _, rate in motion.rotors.values()]) ** 2
    massive, driven = np.flatnonzero(bodies.any(axis=(1, 2))), np.flatnonzero(inertias)
    rotors = list(motion.rotors)
    names = [motion.machine.joints[j].name for j in massive] + [f"{rotors[k]} (rotor)" for k in driven]
    return _shares(names, np.vstack([energies[massive], turning[driven]]))


def strain_shares(modal: Modes) -> Shares:
    """Return shares of strain energy: k dx^2 / 2 of springs and controllers [9], and the remaining potential energy.

    All are zero for motions at 0 Hz. Gravity's part may be negative.
    """
    linear, shapes = modal.linear, modal.shapes
    motion = linear.motion
    deflections = _drift(modal, [rate for _, _, rate in motion.springs.values()])
    springs = motion.spring_stiffnesses(linear.state.q)[:, None] * deflections**2
    controllers = linear.gains[:, :1] * (linear.motors @ shapes) ** 2
    total = np.einsum("im,ij,jm->m", shapes, linear.K, shapes)
    driven = np.flatnonzero(linear.gains[:, 0])
    remainder = total - springs.sum(axis=0) - controllers.sum(axis=0)
    names = [*motion.springs, *(f"{motion.motor_names[m]} (controller)" for m in driven)]
    energies = np.vstack([springs, controllers[driven], remainder])
    return _shares([*names, GRAVITY_AND_LOADS], np.where(modal.eigenvalues > 0, energies, 0.0))


def _shares(names: list[str], energies: Array) -> Shares:
    total = energies.sum(axis=0)
    return Shares(tuple(names), np.divide(energies, total, out=np.zeros_like(energies), where=total > 0))


def _drift(modal: Modes, rates: Sequence[Scalar]) -> Array:
    """Return the changes (rates, modes), in each mode, of quantities with these rates per coordinate velocity."""
    linear = modal.linear
    _, by_qd, _ = linear.motion.jacobians(rates, linear.state)
    return np.asarray(by_qd[:, list(linear.kept)] @ modal.shapes)
