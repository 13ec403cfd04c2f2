"""Cells of six elastic degrees whose stiffness K or damping C couples directions: rows of springs that do not.

Both are diagonal in coordinates e with x = T e, for any damping, since K is positive. Each e is an elastic row without
geometry; coupled rows follow them along x, y, z and about z, y, x. The potential is x^T K x/2 = sum k_i e_i^2/2, and
dampers take xd^T C xd = sum c_i ed_i^2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.names import quote

SIX = 6
UNITS = {"stiffness": ("N/m", "N", "N m/rad"), "damping": ("N s/m", "N s", "N m s/rad"), "neutral": ("m", "", "rad")}
"""Of entries of two slides, of a slide and a turn, and of two turns."""
SYMMETRIC = 1e-9
"""Difference of entries across the diagonal that is rounding, in a matrix with diagonal entries 1."""
NEGATIVE = 1e-12
"""Eigenvalues and entries that are rounding, in a matrix with diagonal entries 1."""
SMALLEST = 1e-9
"""Eigenvalue of a stiffness with diagonal entries 1, below which a direction has none."""


@dataclass(frozen=True, eq=False)
class CoupledCell:
    """Spring cell by decoupled coordinates e: `free` are its elastic directions among x to rz, x[free] = T e.

    `stiffness`, `damping` and `neutral` are those of e; `leading` the direction whose unit each has.
    """

    free: tuple[int, ...]
    T: Array
    stiffness: Array
    damping: Array
    neutral: Array
    leading: tuple[int, ...]

    @classmethod
    def of(cls, entry: Table, lists: Mapping[str, list[Any]]) -> CoupledCell:
        """Decouple a spring with matrices of stiffness and damping, as written; raises `InputError`."""
        own = [row[i] if isinstance(row, list) else row for i, row in enumerate(lists["stiffness"])]
        held = [isinstance(x, Number) and "inf" in x for x in own]
        free = tuple(i for i in range(SIX) if not held[i])
        K, C = (_matrix(entry, key, lists[key], free) for key in ("stiffness", "damping"))
        scale = 1 / np.sqrt(np.diag(K))
        if np.linalg.eigvalsh(K * np.outer(scale, scale))[0] < SMALLEST:
            raise entry.fail("stiffness", "leaves a direction without stiffness: add a row of kind passive for it")
        root = np.linalg.inv(np.linalg.cholesky(K * np.outer(scale, scale))) * scale
        T = root.T @ np.linalg.eigh(root @ C @ root.T)[1] if C.any() else root.T
        sizes = np.abs(T) / scale[:, None]
        leading = sizes.argmax(axis=0)
        T = np.where(sizes > NEGATIVE * sizes.max(axis=0), T / T[leading, range(len(free))], 0.0)
        neutral = np.asarray(np.linalg.solve(T, [_number(entry, "neutral", lists["neutral"][i], (i, i)) for i in free]))
        stiffness, damping = np.einsum("ik,aij,jk->ak", T, np.array([K, C]), T)
        damping = np.where(damping > NEGATIVE * (np.diag(C) @ T**2), damping, 0.0)
        return cls(free, T, stiffness, damping, neutral, tuple(free[i] for i in leading))

    def springs(self, labels: Sequence[str]) -> dict[str, dict[str, str]]:
        """Spring entries (stiffness, damping, neutral position) of the coordinates by label."""
        columns = zip(labels, self.stiffness, self.damping, self.neutral, strict=True)
        return {
            label: {"stiffness": repr(float(k)), "damping": repr(float(c)), "neutral": repr(float(n))}
            for label, k, c, n in columns
        }

    def motion(self, direction: int, labels: Sequence[str]) -> str:
        """Formula of a direction's displacement in the coordinates."""
        factors = self.T[self.free.index(direction)].tolist()
        return " + ".join(f"({x!r})*{label}" for x, label in zip(factors, labels, strict=True) if x)


def without_zeros(entry: Table, key: str, written: list[Any]) -> list[Any]:
    """Six entries for a diagonal matrix, else the matrix as written; raises `InputError` for invalid rows."""
    if not any(isinstance(row, list) for row in written):
        return written
    if not all(isinstance(row, list) and len(row) == SIX for row in written):
        raise entry.fail(key, "must be six numbers, or six rows of six: along x, y, z, about x, y, z")
    off_diagonal = (x for i, row in enumerate(written) for k, x in enumerate(row) if i != k)
    is_diagonal = all(isinstance(x, int | Number) and float(x) == 0 for x in off_diagonal)
    return [row[i] for i, row in enumerate(written)] if is_diagonal else written


def is_coupled(lists: Mapping[str, list[Any]]) -> bool:
    """Whether a stiffness or damping is a matrix."""
    return any(isinstance(x, list) for values in lists.values() for x in values)


def _matrix(entry: Table, key: str, written: list[Any], free: Sequence[int]) -> Array:
    """Symmetric positive semidefinite matrix of the free directions, from a matrix or a list of its diagonal."""
    rows = [x if isinstance(x, list) else [x if k == i else 0 for k in range(SIX)] for i, x in enumerate(written)]
    pairs = ((i, k) for i in range(SIX) for k in range(SIX) if i != k and not {i, k} <= {*free})
    if any(_number(entry, key, rows[i][k], (i, k)) for i, k in pairs):
        raise entry.fail(key, "couples a direction that is held: the other entries of its row and column must be 0")
    A = np.array([[_number(entry, key, rows[i][k], (i, k)) for k in free] for i in free])
    diagonal = np.diag(A)
    if np.any(diagonal < 0) or (key == "stiffness" and not diagonal.all()):
        what = "must be above 0" if key == "stiffness" else "must not be negative"
        raise entry.fail(key, f"entries of the diagonal {what}")
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = A / np.outer(size, size)
    if np.abs(scaled - scaled.T).max(initial=0.0) > SYMMETRIC:
        raise entry.fail(key, "is not symmetric")
    if np.linalg.eigvalsh(scaled)[0] < -SYMMETRIC:
        raise entry.fail(key, "has a negative eigenvalue: no springs and dampers have that")
    return np.asarray((A + A.T) / 2)


def _number(entry: Table, key: str, x: Any, directions: tuple[int, int]) -> float:
    """The value of a number; raises `InputError` for a name."""
    cell = replace(entry, units=UNITS[key][sum(i > 2 for i in directions)]).cell(x, key)
    for name in sorted(cell.names):
        raise entry.fail(key, f"{quote(name)} is a name, and matrices are numbers: write its value")
    return cell.value()
