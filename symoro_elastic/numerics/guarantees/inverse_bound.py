"""Lemma 7, a direct model from a reduced inverse model: error bounds of accelerations from those of torques.

A_S and the right side r_S come from an inverse model with dropped terms, whose residual has the error
d(q, qd, tau, qdd) = (A_S - A) qdd - (r_S - r). The accelerations of both solve A qdd = r and A_S qdd_S = r_S, so that

    qdd_S - qdd = -A_S^-1 d(q, qd, tau, qdd)

exactly: with |d_i| <= e_i for all qdd in their range, |qdd_S - qdd| is at most the largest |x| of A_S x = d.

All solutions for |d| <= e at once: let A be in [M - R, M + R] entrywise, and C any matrix, such as one near M^-1. Then
x = C d + (1 - C A) x, so |x| <= |C| e + G |x| with G = |1 - C M| + |C| R. A vector y > 0 with

    y - G y >= |C| e

proves that |x| <= y, for 1 - G is then an M-matrix, whose inverse has no entry below zero; and that A is not singular.
With C = diag(1/M_ii) this is the theorem of Ostrowski on matrices with a dominant diagonal (A. Ostrowski, Ueber die
Determinanten mit ueberwiegender Hauptdiagonale, 1937). A symmetric A with positive diagonal is positive definite then.

A_S differs from A by |A_S - A|_ik <= e_i / Q_k where |d_i| <= e_i holds for all |qdd_k| <= Q_k: the difference of d at
both ends of the range is 2 Q_k (A_S - A)_ik.
"""

from __future__ import annotations

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.inverse_on_cells import ROUNDING, SLACK, near_inverses, verified_bounds


def largest_solutions(A: Interval, e: Array) -> Array:
    """A bound of |x_i| for all A x = d with |d| <= e, by sub-box (n, sub-boxes); infinite where nothing is proven.

    `A` (n, n, sub-boxes) holds the matrix, `e` (n,) the bounds of the right side.
    """
    low, high = (np.moveaxis(end, -1, 0) for end in A)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        radius = np.maximum(high - middle, middle - low) * (1 + ROUNDING)
        diagonal = np.einsum("bii->bi", middle)
        by_diagonal = np.where(diagonal > 0, 1 / diagonal, np.inf)[..., None] * np.eye(len(e))
        bounds = [_by(C, middle, radius, e) for C in (by_diagonal, near_inverses(middle))]
    return np.asarray(np.minimum(*bounds).T)


def widened(A: Interval, by: Array) -> Interval:
    """The interval matrix A extended by `by` (n, n) in its entries."""
    more = by[..., None] * (1 + ROUNDING)
    return Interval(np.nextafter(A.low - more, -np.inf), np.nextafter(A.high + more, np.inf))


def allowed_right_sides(A: Interval, most: Array) -> Array:
    """The largest right sides e (n,) for which the |x_i| of A x = d, |d| <= e, stay below `most`.

    Zero where nothing is proven. The components of x get equal shares of their bounds.
    """
    unit = np.array([largest_solutions(A, column).max(axis=1) for column in np.eye(len(most))]).T
    if not np.isfinite(unit).all():
        return np.zeros(len(most))
    share = most / unit.sum(axis=1)
    right_sides: Array = share * float((most / largest_solutions(A, share).max(axis=1)).min()) * (1 - SLACK)
    return right_sides


def _by(C: Array, middle: Array, radius: Array, e: Array) -> Array:
    """y (sub-boxes, n) with y - G y >= |C| e, infinite where none is found."""
    magnitude = np.abs(C)
    G = (np.abs(np.eye(len(e)) - C @ middle) + magnitude @ radius) * (1 + ROUNDING)
    G += ROUNDING * magnitude @ np.abs(middle)
    if not e.any():
        return np.where(np.isfinite(G).all(axis=2), 0.0, np.inf)
    return verified_bounds(C, G, (magnitude @ e * (1 + ROUNDING))[..., None])[..., 0]
