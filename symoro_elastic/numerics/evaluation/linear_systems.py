"""Linear algebra over any numbers: products, inverse placements, linear systems, how far results are from others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

REFERENCE_ZERO = 1e-30  # what is smaller is rounding of the reference

Numbers = list[Any]
NumberMatrix = list[Numbers]


class Singular(ArithmeticError):
    """The linear system of a model has no solution at this state."""


def dot(row: Sequence[Any], column: Sequence[Any]) -> Any:
    """Return the sum of products."""
    return sum(x * y for x, y in zip(row, column, strict=True))


def product(first: NumberMatrix, second: NumberMatrix) -> NumberMatrix:
    """Return the matrix product."""
    columns = list(zip(*second, strict=True))
    return [[dot(row, column) for column in columns] for row in first]


def inverse(placement: NumberMatrix) -> NumberMatrix:
    """Return the inverse of a 4x4 placement: A^T, -A^T P."""
    rotation = [[placement[n][m] for n in range(3)] for m in range(3)]
    position = [placement[m][3] for m in range(3)]
    return [*([*row, -dot(row, position)] for row in rotation), placement[3]]


def solve(matrix: NumberMatrix, right: Numbers) -> Numbers:
    """Solve a linear system by Gaussian elimination with partial pivoting; raises `Singular`."""
    rows = [[*row, x] for row, x in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        if rows[k][k] == 0:
            raise Singular("the inertia matrix is singular here")
        for row in rows[k + 1 :]:
            factor = row[k] / rows[k][k]
            if factor:
                row[k + 1 :] = [x - factor * y for x, y in zip(row[k + 1 :], rows[k][k + 1 :], strict=True)]
    solution: Numbers = []
    for k in reversed(range(n)):
        solution.insert(0, (rows[k][n] - dot(rows[k][k + 1 : n], solution)) / rows[k][k])
    return solution


def distance(computed: Sequence[Any], wanted: Sequence[Any]) -> float:
    """Return the largest difference over the largest expected entry, or over 1 where all expected entries are zero."""
    difference = max((abs(x - y) for x, y in zip(computed, wanted, strict=True)), default=0)
    scale = max((abs(y) for y in wanted), default=0)
    return float(difference / (scale if scale > REFERENCE_ZERO else 1))


Screw: TypeAlias = tuple[Any, Any, Any]
"""Cosine and sine of the angle, and the shift."""


# Placements in any numbers, turned about and moved along one of their own axes.
def screwed_about_z(placement: NumberMatrix, c: Any, s: Any, shift: Any) -> NumberMatrix:
    """Return T Rot(z) Trans(z), by the columns of T."""
    return [*([x * c + y * s, y * c - x * s, z, p + z * shift] for x, y, z, p in placement[:3]), placement[3]]


def screwed_about_x(placement: NumberMatrix, c: Any, s: Any, shift: Any) -> NumberMatrix:
    """Return T Rot(x) Trans(x), by the columns of T."""
    return [*([x, y * c + z * s, z * c - y * s, p + x * shift] for x, y, z, p in placement[:3]), placement[3]]
