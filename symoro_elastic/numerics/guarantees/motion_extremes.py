"""The largest value of a polynomial of the motion, exactly in the signs: from its coefficients at many positions.

f = g + sum a_k s_k + sum c_kl s_k s_l + ..., all s in [-1, 1]. Variables that occur alone only (accelerations) take
either sign freely: sum |a_k|. For the others, f without squares is linear in each, so its largest value is at a corner
of signs. A square c s^2 adds at most max(c, 0) to f, and max(-c, 0) to -f. All else adds |c|.

**Lemma.** The bound so found is, at each position, the largest of a family of fixed linear combinations of the
coefficients, with factors of at most 1, and their negatives: the lemma of `axes.py` holds for it.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.numerics.guarantees.coefficients import Monomial

MOST_SIGNED = 9
AT_ONCE = 2048


@dataclass(frozen=True)
class Signs:
    """How coefficients are added: rows that add with free signs, rows of corners, rows of squares, the constant row.

    `corners` are the values of the `signed` rows at each corner, one of each pair of opposite corners left out where
    that changes no product; `at` are the corners, (corners, variables).
    """

    free: Array
    signed: Array
    squares: Array
    constant: Array
    corners: AnyArray
    at: Array
    variables: tuple[int, ...]

    def simple(self, values: AnyArray) -> AnyArray:
        """Return sums of magnitudes: never below `largest`, and fast."""
        sums, ones = np.empty(values.shape[1], values.dtype), np.ones(len(values), values.dtype)
        for start in range(0, len(sums), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            np.matmul(ones, np.abs(values[:, part]), out=sums[part])
        return sums

    def largest(self, values: AnyArray) -> AnyArray:
        """Return the largest |f| at each position, for coefficients (rows, positions)."""
        free = np.abs(values[self.free]).sum(axis=0)
        constant = values[self.constant].sum(axis=0)
        squares = values[self.squares]
        mixed = self.corners @ values[self.signed] if len(self.signed) else np.zeros((1, values.shape[1]), values.dtype)
        above = constant + mixed.max(axis=0) + np.maximum(squares, 0).sum(axis=0)
        below = -constant - mixed.min(axis=0) + np.maximum(-squares, 0).sum(axis=0)
        found: AnyArray = free + np.maximum(above, below)
        return found

    def above(self, values: AnyArray, least: float) -> tuple[float, int]:
        """Return the largest value, or `least` if none is above it, and its position, -1 for none."""
        simple = self.simple(values)
        found = np.flatnonzero(simple > least)
        found = found[np.argsort(-simple[found])]
        best, where = least, -1
        for start in range(0, len(found), AT_ONCE):
            chunk = found[start : start + AT_ONCE]
            if simple[chunk[0]] <= best:
                break
            exact = self.largest(values[:, chunk])
            k = int(exact.argmax())
            if exact[k] > best:
                best, where = float(exact[k]), int(chunk[k])
        return best, where

    def worst(self, values: Array, monomials: Sequence[Monomial], motion: int) -> Array:
        """Return s, of each variable, at which |f| is largest, or nearly so, for coefficients of one position."""
        best, found = -1.0, np.ones(motion)
        mixed = self.corners @ values[self.signed] if len(self.signed) else np.zeros(1)
        constant = float(values[self.constant].sum())
        for sense in (1.0, -1.0):
            s = np.ones(motion)
            s[list(self.variables)] = self.at[int((sense * mixed).argmax())]
            for row in self.free:
                if len(monomials[row]) == 1:
                    s[monomials[row][0]] = sense if values[row] >= 0 else -sense
            total = abs(constant + sum(values[k] * np.prod(s[list(m)]) for k, m in enumerate(monomials) if m))
            if total > best:
                best, found = float(total), s
        return found


def signs_of(monomials: Sequence[Monomial]) -> Signs:
    """Return how coefficients of these products are added."""
    together = Counter(k for m in monomials if len(m) > 1 for k in set(m))
    variables = tuple(sorted(together)) if len(together) <= MOST_SIGNED else ()
    rows: dict[str, list[int]] = {"free": [], "signed": [], "squares": [], "constant": []}
    for row, m in enumerate(monomials):
        rows[_kind(m, variables)].append(row)
    signed = [monomials[row] for row in rows["signed"]]
    even = all(len(m) % 2 == 0 for m in signed)
    first = [(1.0,)] if even and variables else []
    choices = [*first, *([(1.0, -1.0)] * (len(variables) - len(first)))]
    corners_of = list(itertools.product(*choices))
    at = np.array(corners_of, dtype=np.float64).reshape(len(corners_of), len(variables))
    place = {k: j for j, k in enumerate(variables)}
    columns = [np.prod(at[:, [place[k] for k in m]], axis=1) for m in signed]
    corners = np.stack(columns, axis=1).astype(np.float32) if columns else np.zeros((len(at), 0), np.float32)
    indices = {name: np.array(found, dtype=np.intp) for name, found in rows.items()}
    return Signs(**indices, corners=corners, at=at, variables=variables)  # type: ignore[arg-type]


def _kind(m: Monomial, variables: Sequence[int]) -> str:
    if not m:
        return "constant"
    if any(k not in variables for k in m):
        return "free"
    if len(set(m)) == len(m):
        return "signed"
    return "squares" if len(m) == 2 else "free"
