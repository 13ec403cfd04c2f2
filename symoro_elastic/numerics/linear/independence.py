"""Independent columns of a stacked regressor, and how the others join them (Gautier 1991).

If W_dropped = W_kept beta, then W X = W_kept (X_kept + beta X_dropped): only these sums can be found.
Columns are compared at length one. A QR factorization with column pivoting gives the rank.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array

VANISHING = 1e-12  # length of a column without effect, of the longest one
NEGLIGIBLE = 10  # tolerances: coefficients of columns of length one that are rounding
EXACT = 1e-13  # distance from a short decimal that is rounding


@dataclass(frozen=True)
class IndependentColumns:
    """Columns of W: independent `kept` ones, `dropped` ones W_dropped = W_kept beta, and `vanishing` ones."""

    kept: tuple[int, ...]
    dropped: tuple[int, ...]
    vanishing: tuple[int, ...]
    beta: Array

    def terms(self, k: int) -> list[tuple[int, float]]:
        """Return the dependent columns that contain the k-th independent one, with their coefficients."""
        return [(c, float(b)) for c, b in zip(self.dropped, self.beta[k], strict=True) if b]

    def apply(self, X: Array) -> Array:
        """Return X_kept + beta X_dropped; where beta is zero an unknown (NaN) entry of X does not matter."""
        joined = np.where(self.beta != 0.0, self.beta * X[list(self.dropped)], 0.0)
        return np.asarray(X[list(self.kept)] + joined.sum(axis=1))


def independent_columns(
    W: Array, tolerance: float, vanishing: float = VANISHING, first: Iterable[int] = (), negligible: float | None = None
) -> IndependentColumns:
    """Return independent columns of W (rows, columns), and beta of the dependent ones, W_dropped = W_kept beta.

    A column is kept where it is independent of the columns before it, so that parameters join bodies nearer to the base
    as in Gautier and Khalil's rules; the columns `first` come before all others. Where their count is not the rank,
    the pivoted choice is taken. Coefficients below `negligible` (10 times `tolerance` by default) are zero.
    """
    scaled, lengths = unit_columns(W, vanishing)
    there = [c for c in dict.fromkeys((*first, *range(W.shape[1]))) if lengths[c] > 0]
    R = triangle(scaled[:, there])
    pivoted = _pivoted_columns(R, tolerance)
    selected = _in_order(R, tolerance)
    selected = sorted(selected if len(selected) == len(pivoted) else pivoted, key=lambda k: there[k])
    dropped = sorted(set(range(len(there))) - set(selected), key=lambda k: there[k])
    own, dependent = [there[k] for k in selected], [there[k] for k in dropped]
    beta = _coefficients(R, selected, dropped, NEGLIGIBLE * tolerance if negligible is None else negligible)
    beta *= lengths[dependent] / lengths[own][:, None]
    without = tuple(int(c) for c in np.flatnonzero(lengths == 0))
    return IndependentColumns(tuple(own), tuple(dependent), without, _short(beta))


def rank(W: Array, tolerance: float, vanishing: float = VANISHING) -> int:
    """Return the number of independent columns."""
    return len(_pivoted_columns(triangle(unit_columns(W, vanishing)[0]), tolerance))


def unit_columns(W: Array, vanishing: float = VANISHING) -> tuple[Array, Array]:
    """Return columns scaled to length one, and their lengths; columns that vanish relative to the longest are zero."""
    lengths = np.linalg.norm(W, axis=0)
    lengths = np.where(lengths > vanishing * lengths.max(initial=0.0), lengths, 0.0)
    return W * np.where(lengths > 0, 1 / np.where(lengths > 0, lengths, 1.0), 0.0), lengths


def triangle(W: Array) -> Array:
    """Return R of W = Q R."""
    return np.asarray(np.linalg.qr(W, mode="r"), dtype=float)


def pivoted_qr(W: Array) -> tuple[Array, list[int]]:
    """Return (R, order): W[:, order] = Q R by Householder reflections, the longest remaining column first."""
    R: Array = triangle(W)
    order = list(range(R.shape[1]))
    for k in range(min(R.shape)):
        lengths = np.linalg.norm(R[k:, k:], axis=0)
        best = k + int(np.argmax(lengths))
        order[k], order[best] = order[best], order[k]
        R[:, [k, best]] = R[:, [best, k]]
        v = R[k:, k].copy()
        v[0] += math.copysign(float(np.linalg.norm(v)), v[0])
        square = float(v @ v)
        if square > 0:
            R[k:, k:] -= np.outer(v, (2 / square) * (v @ R[k:, k:]))
    return R, order


def _pivoted_columns(W: Array, tolerance: float) -> list[int]:
    """Return independent columns in pivoting order."""
    R, order = pivoted_qr(W)
    diagonal = np.abs(np.diag(R))
    return order[: int((diagonal > tolerance * diagonal.max(initial=0.0)).sum())]


def _in_order(R: Array, tolerance: float) -> list[int]:
    """Return the columns that are independent of their predecessors (Gram-Schmidt, twice)."""
    basis = np.zeros((len(R), 0))
    selected = []
    for c in range(R.shape[1]):
        residual = R[:, c] - basis @ (basis.T @ R[:, c])
        residual -= basis @ (basis.T @ residual)
        if (length := float(np.linalg.norm(residual))) > tolerance:
            selected.append(c)
            basis = np.hstack([basis, residual[:, None] / length])
    return selected


def _coefficients(R: Array, kept: Sequence[int], dropped: Sequence[int], negligible: float) -> Array:
    """Return beta of R_dropped = R_kept beta, solved again without negligible columns."""
    own, others = R[:, kept], R[:, dropped]
    beta = _least_squares(own, others)
    beta[np.abs(beta) < negligible] = 0.0
    for k in range(len(dropped)):
        used = beta[:, k] != 0.0
        beta[used, k] = _least_squares(own[:, used], others[:, k])
    return beta


def _least_squares(A: Array, B: Array) -> Array:
    """Return X of A X = B, where the columns of A are independent."""
    Q, R = np.linalg.qr(A)
    return np.asarray(np.linalg.solve(R, Q.T @ B), dtype=float)


def _short(beta: Array) -> Array:
    """Return coefficients as 1.0 or 0.35 where they differ by rounding only."""
    rounded = np.round(beta, 6)
    return np.where(np.abs(beta - rounded) < EXACT * np.maximum(1.0, np.abs(beta)), rounded, beta)
