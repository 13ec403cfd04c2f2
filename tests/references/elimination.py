"""Gaussian elimination on arrays of mpf."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpmath import mpf

Array = np.ndarray[Any, Any]

NOTHING = mpf(10) ** -25
"""What an elimination leaves of a row that depends on others is below this, relative to the largest entry of all."""


def zeros(*shape: int) -> Array:
    return np.full(shape, mpf(0), dtype=object)


def identity(size: int) -> Array:
    matrix = zeros(size, size)
    np.fill_diagonal(matrix, mpf(1))
    return matrix


def solve(matrix: Array, right: Array) -> Array:
    """Solution of a square system, by rows of largest pivots; `ZeroDivisionError` where it is singular."""
    size = len(matrix)
    if not size:
        return right.copy()
    columns = right.reshape(size, -1)
    rows = np.concatenate([matrix, columns], axis=1)
    for k in range(size):
        pivot = max(range(k, size), key=lambda i: abs(rows[i, k]))
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k, k:] = rows[k, k:] / rows[k, k]
        for i in range(size):
            if i != k and rows[i, k]:
                rows[i, k:] = rows[i, k:] - rows[k, k:] * rows[i, k]
    return rows[:, size:].reshape(right.shape)


def least_squares(matrix: Array, right: Array) -> Array:
    """Solution of more equations than unknowns, by the normal equations."""
    return solve(matrix.T @ matrix, matrix.T @ right)


def independent_rows(matrix: Array) -> list[int]:
    """Rows that do not depend on rows before them."""
    kept: list[int] = []
    scale = max(map(abs, matrix.ravel()), default=mpf(0))
    reduced: list[tuple[int, Array]] = []
    for i, row in enumerate(matrix):
        rest = row.copy()
        for column, other in reduced:
            rest = rest - other * rest[column]
        column = max(range(len(rest)), key=lambda k: abs(rest[k]), default=0)
        if len(rest) and abs(rest[column]) > scale * NOTHING:
            reduced.append((column, rest / rest[column]))
            kept.append(i)
    return kept
