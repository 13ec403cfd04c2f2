"""Derivatives by parameters of M, D, K, F and C, and through them of responses, poles and damping ratios.

    dG/dp = C Z^-1 (dF - dZ Z^-1 F) + dC Z^-1 F,    dZ = s^2 dM + s dD + dK,    Z = s^2 M + s D + K
    d lambda/dp = -psi^T dZ(lambda) phi / psi^T (2 lambda M + D) phi,    Z phi = 0, Z^T psi = 0

All are total: an equilibrium that was solved for moves with p, dq/dp = -K^-1 dr/dp, and M, D, K, F, C with it. They are
exact, by dual numbers over the equations of motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.vibration.linearization import Linearization, root_of
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.mechanics.coordinates import product
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.signals import inputs, outputs

BLOCK = 256
REPEATED = 1e-7
"""Of the largest singular value of Z at a pole, below which the second smallest is that of another pole there."""


@dataclass(frozen=True)
class LinearSlopes:
    """Derivatives of the matrices of a linearization by parameters `names`, which are their first axis.

    M, D, K (p, n, n), F (p, n, inputs), C (3, p, outputs, n) of Cq, Cv, Ca; SI units by the unit of the parameter.
    """

    linear: Linearization
    names: tuple[str, ...]
    M: Array
    D: Array
    K: Array
    F: Array
    C: Array


def linear_slopes(linear: Linearization, names: Sequence[str] = ()) -> LinearSlopes:
    """Return the derivatives of M, D, K, F, Cq, Cv, Ca by parameters, all of them unless some are named.

    Controllers of motors are in D and K; a damping ratio that was added to every mode is not. Raises `InputError` for
    unknown names, and for a state that moves: how a parameter changes its accelerations is not followed.
    """
    motion, k, n = linear.motion, len(linear.kept), len(linear.motion.joints)
    if linear.unrest:
        what = f"derivatives by parameters are those of equilibria, and this state is {linear.unrest[0]}"
        raise InputError(motion.source, "sensitivity", what)
    chosen = chosen_parameters(motion, names)
    roots = _velocities(linear)
    rows, kept = len(roots), np.eye(n)[:, list(linear.kept)]
    # Columns: M, D and K, the changes of r along qdd, qd and q; then those of velocities along qd, their Jacobian.
    left = np.zeros((n + rows, 3 * k * k + rows * k))
    left[:n, : 3 * k * k] = np.tile(np.repeat(kept, k, axis=1), 3)
    left[n:, 3 * k * k :] = np.repeat(np.eye(rows), k, axis=1)
    along, none = np.tile(kept, k), np.zeros((n, k * k))
    nothing, jacobian = np.zeros((n, rows * k)), np.tile(kept, rows)
    dq, dqd, dqdd = (
        np.hstack([*(along if block == one else none for block in range(3)), jacobian if one == 1 else nothing])
        for one in range(3)
    )
    by_name = motion.parameter_slopes(linear.state, left, dq, dqd, dqdd, [*motion.residual, *roots])
    found = np.array([by_name[name] for name in chosen]).reshape(len(chosen), left.shape[1])
    K, D, M = found[:, : 3 * k * k].reshape(len(chosen), 3, k, k).transpose(1, 0, 2, 3)
    F, C, motors = _row_slopes(linear, found[:, 3 * k * k :].reshape(len(chosen), rows, k))
    for row, slopes, (kp, kd) in zip(linear.motors, motors.transpose(1, 0, 2), linear.gains, strict=True):
        if kp or kd:
            both = slopes[:, :, None] * row
            both += both.transpose(0, 2, 1)
            K, D = K + kp * both, D + kd * both
    return LinearSlopes(linear, chosen, (M + M.transpose(0, 2, 1)) / 2, D, K, F, C)


def chosen_parameters(motion: EquationsOfMotion, names: Sequence[str]) -> tuple[str, ...]:
    """Return parameters by name, all unless some are named; raises `InputError` for unknown names."""
    for name in names:
        if name not in motion.parameters:
            what = f"no parameter {quote(name)}{did_you_mean(name, motion.parameters)}"
            raise InputError(motion.source, "sensitivity", what)
    return tuple(names or motion.parameters)


def _driven(linear: Linearization) -> list[int]:
    """Return the motors that a controller drives."""
    return [m for m, gains in enumerate(linear.gains) if gains.any()]


def _velocities(linear: Linearization) -> list[Scalar]:
    """Return the expressions of velocities behind inputs and outputs, and of motors with a controller."""
    motion = linear.motion
    signals = (*inputs(motion.given, linear.inputs), *outputs(motion.given, linear.outputs))
    return [root_of(motion, s, at_rest=True) for s in signals] + [_motor_rate(motion, m) for m in _driven(linear)]


def _row_slopes(linear: Linearization, found: Array) -> tuple[Array, Array, Array]:
    """Return the derivatives of F, of C, and of the rows of motors (p, m, n), from those of velocities (p, rows, n)."""
    p, _, k = found.shape
    ins, outs = len(linear.inputs), outputs(linear.motion.given, linear.outputs)
    C, motors = np.zeros((3, p, len(outs), k)), np.zeros((p, len(linear.motors), k))
    for o, s in enumerate(outs):
        C[s.order, :, o] = found[:, ins + o]
    motors[:, _driven(linear)] = found[:, ins + len(outs) :]
    return found[:, :ins].transpose(0, 2, 1), C, motors


def _motor_rate(motion: EquationsOfMotion, m: int) -> Scalar:
    """Return the expression of the rate of a motor."""
    j, coordinates = motion.machine.motors[m], motion.bound.coordinates
    return product(coordinates.S_x[j] if j in motion.machine.with_variable else coordinates.S[j], motion.bound.qd)


def response_slopes(slopes: LinearSlopes, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return G (f, outputs, inputs) and its derivatives (p, f, outputs, inputs) at frequencies in Hz, SI units.

    Frequencies f - i a/(2 pi) are s = 2 pi i f + a. Both are infinite or NaN on an undamped resonance. One solve with
    Z and one with Z^T a frequency.
    """
    s = np.asarray(2j * np.pi * np.asarray(frequencies), dtype=complex)
    parts = [_response_slopes(slopes, s[first : first + BLOCK]) for first in range(0, len(s), BLOCK)]
    return np.concatenate([G for G, _ in parts]), np.concatenate([dG for _, dG in parts], axis=1)


def _response_slopes(slopes: LinearSlopes, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    linear, s_ = slopes.linear, s[:, None, None]
    Z = s_ * s_ * linear.M + s_ * linear.D + linear.K
    C = linear.Cq + s_ * linear.Cv + s_ * s_ * linear.Ca
    moved = np.linalg.solve(Z, linear.F.astype(complex)[None])
    G: ComplexArray = C @ moved
    if not slopes.names:
        return G, np.zeros((0, *G.shape), dtype=complex)
    left = np.linalg.solve(Z.transpose(0, 2, 1), C.transpose(0, 2, 1)).transpose(0, 2, 1)
    dG = np.zeros((len(slopes.names), *G.shape), dtype=complex)
    for power, changed in enumerate((slopes.K, slopes.D, slopes.M)):
        for k, rows in ((k, np.flatnonzero(one.any(axis=1))) for k, one in enumerate(changed)):
            columns = np.flatnonzero(changed[k].any(axis=0))
            if len(rows):
                inner = changed[k][np.ix_(rows, columns)] @ moved[:, columns]
                dG[k] -= s_**power * (left[:, :, rows] @ inner)
    for k in np.flatnonzero(slopes.F.any(axis=(1, 2))).tolist():
        dG[k] += left @ slopes.F[k]
    for power, changed in enumerate(slopes.C):
        for k in np.flatnonzero(changed.any(axis=(1, 2))).tolist():
            dG[k] += s_**power * (changed[k] @ moved)
    return G, dG


def pole_slopes(slopes: LinearSlopes, poles: ComplexArray) -> ComplexArray:
    """Return the derivatives (p, k) of simple poles (k,), rad/s; NaN for poles that come more than once.

    phi and psi are singular vectors of Z, scaled so that M has a diagonal of ones.
    """
    linear, lam = slopes.linear, np.asarray(poles, dtype=complex)[:, None, None]
    scale = 1 / np.sqrt(np.diag(linear.M))
    Z = (lam * lam * linear.M + lam * linear.D + linear.K) * np.outer(scale, scale)
    U, sizes, Vh = np.linalg.svd(Z)
    phi, psi = scale * Vh[:, -1].conj(), scale * U[:, :, -1].conj()
    changed = [np.einsum("ka,pab,kb->pk", psi, one, phi, optimize=True) for one in (slopes.K, slopes.D, slopes.M)]
    below = np.einsum("ka,kab,kb->k", psi, 2 * lam * linear.M + linear.D, phi)
    if sizes.shape[1] > 1:
        below = np.where(sizes[:, -2] > REPEATED * sizes[:, 0], below, np.nan)
    lam = lam[:, 0, 0]
    found: ComplexArray = -(changed[0] + lam * changed[1] + lam * lam * changed[2]) / below
    return found


def ratio_slopes(poles: ComplexArray, slopes: ComplexArray) -> tuple[Array, Array]:
    """Return the derivatives of frequencies |lambda| / 2 pi, Hz, and of damping ratios -Re lambda / |lambda|."""
    size = np.abs(poles)
    grown = (poles.conj() * slopes).real / size
    return grown / (2 * np.pi), -(slopes.real - poles.real * grown / size) / size
