"""Lemma 6, pivots from bounds of the inertia matrix.

Over a sub-box each entry of the inertia matrix A is in an interval of the middle M and the radius R. With s_i > 0 and
D = diag(sum_k R_ik s_k / s_i),

    M - D <= A <= M + D

in the sense of Loewner, for x'(A - M)x <= sum R_ik |x_i||x_k| <= sum D_ii x_i^2 by the inequality of means,
|x_i||x_k| <= (x_i^2 s_k/s_i + x_k^2 s_i/s_k)/2. Schur complements are monotone in this sense, so H_j is between those
of M - D and of M + D where M - D is positive definite. The scales s_i = M_ii^(-1/2) make D small.

The lower bound h is proven: M - D - h e_j e_j' is positive definite, as its Cholesky decomposition shows with a margin
for rounding (S. Rump, Verification of positive definiteness, BIT 46, 2006). The upper one is x'(M + D)x of some x with
x_j = 1, of which the Schur complement is the least.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.intervals import Interval

SHRUNK = 1 - 2.0**-30
"""Of a computed Schur complement: what is left of it is proven."""
U = 2.0**-53


def schur_complements(A: Interval, joints: Sequence[int], entry: int) -> Interval:
    """The interval of the Schur complement of an `entry` over all `joints`, by sub-box.

    `A` (n, n, sub-boxes) holds the inertia matrix, `joints` are indices into it, `entry` among them. The lower end is
    0 where nothing is proven, the upper one infinite.
    """
    rows = np.ix_(joints, joints)
    low, high = (np.moveaxis(end[rows], -1, 0) for end in (A.low, A.high))
    k = list(joints).index(entry)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        radius = np.maximum(high - middle, middle - low) * (1 + 4 * U)
        scale = 1 / np.sqrt(np.diagonal(middle, axis1=1, axis2=2))
        spread = np.einsum("bik,bk->bi", radius, scale) / scale * (1 + 8 * len(joints) * U)
        found = [_bounds(middle[b], spread[b], scale[b], k) for b in range(len(middle))]
    return Interval(np.array([least for least, _ in found]), np.array([most for _, most in found]))


def _bounds(middle: Array, spread: Array, scale: Array, k: int) -> tuple[float, float]:
    """The bounds in one sub-box."""
    if not (np.isfinite(middle).all() and np.isfinite(spread).all() and np.isfinite(scale).all()):
        return 0.0, np.inf
    return _least(middle - np.diag(spread), scale, k), _most(middle + np.diag(spread), k)


def _least(matrix: Array, scale: Array, k: int) -> float:
    """A proven lower bound of the Schur complement of a matrix; 0 where it is not positive definite."""
    try:
        bound = SHRUNK / float(np.linalg.inv(matrix)[k, k])
    except np.linalg.LinAlgError:
        return 0.0
    if not bound > 0:
        return 0.0
    reduced = matrix.copy()
    reduced[k, k] -= bound
    return bound if _is_positive_definite(reduced, scale) else 0.0


def _is_positive_definite(matrix: Array, scale: Array) -> bool:
    """Whether a symmetric matrix is, entries being off by some roundings of its diagonal."""
    size = len(matrix)
    powers = np.exp2(np.round(np.log2(scale)))  # exact scaling
    scaled = matrix * powers[:, None] * powers
    margin = 64 * size**2 * U * max(1.0, float(np.abs(np.diagonal(scaled)).max()))
    try:
        np.linalg.cholesky(scaled - margin * np.eye(size))
    except np.linalg.LinAlgError:
        return False
    return True


def _most(matrix: Array, k: int) -> float:
    """x' B x of the x with x_k = 1 that is nearly the best."""
    try:
        x = np.linalg.inv(matrix)[:, k]
    except np.linalg.LinAlgError:
        return float(matrix[k, k]) * (1 + 4 * U)
    x = x / x[k]
    x[k] = 1.0
    terms = matrix * x[:, None] * x
    return float(terms.sum() + 4 * len(matrix) ** 2 * U * np.abs(terms).sum())
