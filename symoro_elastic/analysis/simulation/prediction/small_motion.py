"""Small motions about a motion: M(t) d'' + D(t) d' + K(t) d = R(t) from d(0) = d'(0) = 0.

The two-stage Gauss method of order 4: with the eigenvalue z = 1/4 + i sqrt(3)/12 of its matrix, a step takes one
complex system,

    (M + z h D + (z h)^2 K) k = right side,

no inverse of M and no state but d and d'. It neither damps nor amplifies, and a vibration of w rad/s is late by
(w h)^5 / 720 rad a step. M, D and K are those of the middle of a step, R is cubic through the four nearest samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array

_c = 0.5 + np.sqrt(3) / 6 * np.array([-1.0, 1.0])
_A = np.array([[0.25, 0.25 - np.sqrt(3) / 6], [0.25 + np.sqrt(3) / 6, 0.25]])
_eigenvalues, _S = np.linalg.eig(_A)
Z = complex(_eigenvalues[0])
"""An eigenvalue of the matrix of the method; the other is its conjugate."""
CONSTANT, LINEAR = (complex(x) for x in np.linalg.solve(_S, np.stack([np.ones(2), _c - 0.5], axis=1))[0])
"""Components along the eigenvector of Z: of a rate that is 1 at both stages, of a rate that is linear in a step."""
WEIGHT = complex(0.5 * _S[:, 0].sum())
"""Weight of this component at the end of a step; the conjugate adds as much."""


@dataclass(frozen=True)
class LinearMotion:
    """M, D, K (N, ..., n, n) and R (N, ..., n) at times h apart, the first at the start; SI units.

    Axes between the first and the last are different systems; where those of R alone are long, one under many forces.
    """

    h: float
    M: Array
    D: Array
    K: Array
    R: Array


@dataclass(frozen=True)
class SmallMotion:
    """Small deviations d, d' and d'' (N, ..., n) from a motion at the times of its model, rad or m."""

    d: Array
    dd: Array
    ddd: Array


def small_motion(model: LinearMotion) -> SmallMotion:
    """Return the solution of a linear model from rest; d'' is from the equations of motion, so M must be regular."""
    n, steps = model.R.shape[-1], len(model.R) - 1
    states = np.zeros((steps + 1, *model.R.shape[1:-1], 2 * n, 1))
    for k, (transition, push) in enumerate(zip(*_steps(model), strict=True)):
        states[k + 1] = transition @ states[k] + push
    d, dd = states[..., :n, 0], states[..., n:, 0]
    residual = model.R - _times(model.K, d) - _times(model.D, dd)
    ddd = np.linalg.solve(model.M, residual[..., None])[..., 0]
    return SmallMotion(d, dd, np.asarray(ddd, dtype=float))


def _steps(model: LinearMotion) -> tuple[Array, Array]:
    """Return transition matrices (steps, ..., 2n, 2n) of the state and increments by forces (steps, ..., 2n, 1)."""
    M, D, K = (_middle(x) for x in (model.M, model.D, model.K))
    even, odd = _at_stages(model.R)
    h, n = model.h, model.R.shape[-1]
    zh = Z * h
    inverse = np.linalg.inv(M + zh * D + zh**2 * K)
    by_position = -CONSTANT * (inverse @ K)
    by_velocity = -CONSTANT * (inverse @ (D + zh * K))
    forced = _times(inverse, CONSTANT * even + LINEAR * odd)
    gained = 2 * h * WEIGHT
    transition = np.zeros((*inverse.shape[:-2], 2 * n, 2 * n))
    transition[..., :n, :n] = (gained * zh * by_position).real
    transition[..., :n, n:] = (gained * zh * by_velocity).real + h * np.eye(n)
    transition[..., n:, :n] = (gained * by_position).real
    transition[..., n:, n:] = (gained * by_velocity).real
    push = np.concatenate([(gained * zh * forced).real, (gained * forced).real], axis=-1)[..., None]
    return transition + np.eye(2 * n), push


def _at_stages(R: Array) -> tuple[Array, Array]:
    """Return the mean of the forces R at both stages of a step, and their change over the step.

    At the stages, s^2 = 1/12, the cubic through samples at -3/2, -1/2, 1/2, 3/2 is 13/12 of the mean of the inner two
    less 1/12 of that of the outer two; likewise its slope.
    """
    before, after = 3 * (R[:1] - R[1:2]) + R[2:3], 3 * (R[-1:] - R[-2:-1]) + R[-3:-2]
    padded = np.concatenate([before, R, after])
    even = (13 * _middle(R) - (padded[3:] + padded[:-3]) / 2) / 12
    odd = (13 * np.diff(R, axis=0) - (padded[3:] - padded[:-3]) / 3) / 12
    return even, odd


def _middle(x: Array) -> Array:
    return (x[:-1] + x[1:]) / 2


def _times(matrices: AnyArray, vectors: AnyArray) -> AnyArray:
    return (matrices @ vectors[..., None])[..., 0]
