"""Which columns of a stacked regressor are independent, and how the others join them (Gautier 1991).

If Y_dropped = Y_kept beta, then Y X = Y_kept (X_kept + beta X_dropped): only these sums can be found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.identification.optional import optional

Array = NDArray[np.float64]

STRUCTURAL = 1e-8  # independence at random states, of columns of length 1
FROM_DATA = 1e-6
VANISHING = 1e-12  # length of a column without effect, of the longest one
NEGLIGIBLE = 1e-7  # coefficients that are rounding


@dataclass(frozen=True)
class Grouping:
    """Columns kept, columns that join them with coefficients beta (kept x dropped), columns without effect."""

    kept: tuple[int, ...]
    dropped: tuple[int, ...]
    vanishing: tuple[int, ...]
    beta: Array

    def terms(self, k: int) -> list[tuple[int, float]]:
        """Columns that join the k-th kept one, with their coefficients."""
        return [(c, float(b)) for c, b in zip(self.dropped, self.beta[k], strict=True) if b]

    def apply(self, X: Array) -> Array:
        """X_kept + beta X_dropped; where beta is zero an unknown (NaN) entry of X does not matter."""
        joined = np.where(self.beta != 0.0, self.beta * X[list(self.dropped)], 0.0)
        grouped: Array = X[list(self.kept)] + joined.sum(axis=1)
        return grouped


def group(W: Array, tolerance: float) -> Grouping:
    """Group the columns of a stacked regressor W (rows, columns), scaled to length 1.

    The rank is that of a QR decomposition with column pivoting; columns are kept in their order as long as
    they are independent of those before them, so that parameters join bodies nearer to the base, as in
    Gautier and Khalil's rules. Where the two counts differ, the pivoted choice is taken.
    """
    lengths = np.linalg.norm(W, axis=0)
    there = np.flatnonzero(lengths > VANISHING * lengths.max(initial=0.0))
    vanishing = tuple(int(c) for c in np.setdiff1d(np.arange(W.shape[1]), there))
    if not len(there):
        return Grouping((), (), vanishing, np.zeros((0, 0)))
    R: Array = np.asarray(np.linalg.qr(W[:, there] / lengths[there], mode="r"))
    pivoted = _pivoted(R, tolerance)
    kept = _in_order(R, tolerance)
    kept = kept if len(kept) == len(pivoted) else sorted(pivoted)
    dropped = [c for c in range(len(there)) if c not in set(kept)]
    beta = np.linalg.lstsq(R[:, kept], R[:, dropped], rcond=None)[0].astype(np.float64)
    beta[np.abs(beta) < max(NEGLIGIBLE, 10 * tolerance)] = 0.0
    beta *= lengths[there[dropped]] / lengths[there[kept]][:, None]
    return Grouping(tuple(map(int, there[kept])), tuple(map(int, there[dropped])), vanishing, _round(beta))


def _pivoted(R: Array, tolerance: float) -> list[int]:
    found, order = optional("scipy.linalg").qr(R, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(found))
    return [int(c) for c in order[: int((diagonal > tolerance * diagonal[0]).sum())]]


def _in_order(R: Array, tolerance: float) -> list[int]:
    """Columns that are independent of those before them (Gram and Schmidt, twice)."""
    basis = np.zeros((len(R), 0))
    kept = []
    for c in range(R.shape[1]):
        rest = R[:, c] - basis @ (basis.T @ R[:, c])
        rest -= basis @ (basis.T @ rest)
        if (length := float(np.linalg.norm(rest))) > tolerance:
            kept.append(c)
            basis = np.hstack([basis, rest[:, None] / length])
    return kept


def _round(beta: Array) -> Array:
    """Coefficients as 1.0 or 0.35 where rounding made them nearly so."""
    rounded = np.round(beta, 6)
    near = np.abs(beta - rounded) < 1e-9 * np.maximum(1.0, np.abs(beta))
    return np.where(near, rounded, beta)


def formula(label: str, terms: Sequence[tuple[str, float]]) -> str:
    """A group as text: `ZZ1 + Ia1 + 0.25 M3`."""
    text = label
    for other, b in terms:
        size = "" if abs(abs(b) - 1.0) < 1e-12 else f"{abs(b):.6g} "
        text += f" {'+' if b > 0 else '-'} {size}{other}"
    return text
