"""Linear systems of loops, in which no pivot is chosen: cofactors up to three unknowns, orthogonal columns beyond."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from symoro_elastic.foundation.scalar import quotient, sum_of
from symoro_elastic.mechanics.spatial import Scalar, is_zero

Column: TypeAlias = list[Scalar]
BY_COFACTORS = 3
"""Most unknowns of a system that is solved by its determinant."""


def solve(W: Sequence[Column], right: Sequence[Column]) -> list[Column]:
    """x of W x = right for each right side; matrices are lists of columns.

    Raises `ZeroDivisionError` where W is exactly singular.
    """
    return _by_cofactors(W, right) if len(W) <= BY_COFACTORS else _by_orthogonal_columns(W, right)


def _by_cofactors(W: Sequence[Column], right: Sequence[Column]) -> list[Column]:
    inverse = quotient(1, determinant(W))
    solutions: list[Column] = []
    for column in right:
        if all(map(is_zero, column)):
            solutions.append(_zeros(len(W)))
            continue
        replaced = ([*W[:k], column, *W[k + 1 :]] for k in range(len(W)))
        solutions.append([determinant(matrix) * inverse for matrix in replaced])
    return solutions


def determinant(columns: Sequence[Column]) -> Scalar:
    """Determinant, expanded along the first column; 1 without columns."""
    if not columns:
        return 1
    if len(columns) == 1:
        return columns[0][0]
    first, *others = columns
    total: Scalar = 0
    for row, x in enumerate(first):
        if not is_zero(x):
            minor = x * determinant([[*column[:row], *column[row + 1 :]] for column in others])
            total = total - minor if row % 2 else total + minor
    return total


def _by_orthogonal_columns(W: Sequence[Column], right: Sequence[Column]) -> list[Column]:
    """Modified Gram-Schmidt without roots: columns and right sides lose their parts along each column in turn."""
    n = len(W)
    columns, sides = [list(column) for column in W], [list(column) for column in right]
    along = [_zeros(n) for _ in range(n)]
    solutions = [_zeros(n) for _ in sides]
    for k in range(n):
        inverse = quotient(1, _dot(columns[k], columns[k]))
        for j in range(k + 1, n):
            along[k][j] = part = _dot(columns[k], columns[j]) * inverse
            columns[j] = _without(columns[j], part, columns[k])
        for m, side in enumerate(sides):
            solutions[m][k] = part = _dot(columns[k], side) * inverse
            sides[m] = _without(side, part, columns[k])
    for x in solutions:
        for k in reversed(range(n)):
            for j in range(k + 1, n):
                x[k] = x[k] - along[k][j] * x[j]
    return solutions


def _zeros(n: int) -> Column:
    return [0] * n


def _dot(u: Column, v: Column) -> Scalar:
    return sum_of(x * y for x, y in zip(u, v, strict=True))


def _without(u: Column, factor: Scalar, v: Column) -> Column:
    return [x - factor * y for x, y in zip(u, v, strict=True)]
