"""Joint velocities and accelerations from those of a frame: J qd = V solved in closed form.

A straight-line program cannot choose pivots. So a square system is split into blocks that are solved one after the
other, each by its adjugate: the only divisor is the determinant of a block, which vanishes where the machine is
singular and nowhere else. With more joints than components, the solution of least norm comes from J W^-1 J^T, which is
positive definite, by its factors L D L^T, which need no pivots. (Khalil and Dombre 2002, chapter 6)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations
from typing import NamedTuple, TypeAlias

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.spatial import Scalar, is_zero

Rows: TypeAlias = Sequence[Sequence[Scalar]]


class Block(NamedTuple):
    """Rows and columns of a square block; the rows are zero in the columns of later blocks."""

    rows: tuple[int, ...]
    columns: tuple[int, ...]


class DependentRows(ArithmeticError):
    """Rows of a matrix depend on each other whatever the values of its entries."""

    def __init__(self, rows: Sequence[int]) -> None:
        super().__init__(f"rows {[*rows]} depend on each other")
        self.rows = tuple(rows)


def blocks(matrix: Rows) -> Iterator[Block]:
    """Yield the blocks of a square matrix in the order in which they are solved, the smallest first.

    A block is a set of rows that have entries in as many columns, those of earlier blocks left out. Raises
    `DependentRows` where rows have entries in fewer columns.
    """
    remaining, done = [*range(len(matrix))], set[int]()
    while remaining:
        block = _next_block(matrix, remaining, done)
        yield block
        remaining = [k for k in remaining if k not in block.rows]
        done.update(block.columns)


def _next_block(matrix: Rows, left: Sequence[int], done: set[int]) -> Block:
    for size in range(1, len(left) + 1):
        for rows in combinations(left, size):
            columns = tuple(
                j for j in range(len(matrix[0])) if j not in done and any(not is_zero(matrix[k][j]) for k in rows)
            )
            if len(columns) < size:
                raise DependentRows(rows)
            if len(columns) == size:
                return Block(rows, columns)
    raise ValueError("the matrix has more columns than rows")


def determinant_factors(matrix: Rows) -> list[Scalar]:
    """The determinants of the blocks of a square matrix; their product is its determinant, whose sign the first has."""
    parts = [*blocks(matrix)]
    rows = [k for block in parts for k in block.rows]
    columns = [j for block in parts for j in block.columns]
    first, *others = (determinant([[matrix[k][j] for j in b.columns] for k in b.rows]) for b in parts)
    return [first * (_sign(rows) * _sign(columns)), *others]


def _sign(order: Sequence[int]) -> int:
    """1 for an even permutation, -1 for an odd one."""
    swaps = sum(a > b for a, b in combinations(order, 2))
    return -1 if swaps % 2 else 1


def determinant(matrix: Rows) -> Scalar:
    """The determinant of a square matrix: Laplace's expansion by the first row, each minor once."""
    size = len(matrix)

    @cache
    def minor(columns: tuple[int, ...]) -> Scalar:
        """The minor of the last rows and these columns."""
        if not columns:
            return 1
        total: Scalar = 0
        row = matrix[size - len(columns)]
        for place, j in enumerate(columns):
            if not is_zero(row[j]):
                term = row[j] * minor(columns[:place] + columns[place + 1 :])
                total = total - term if place % 2 else total + term
        return total

    return minor(tuple(range(size)))


def adjugate(matrix: Rows) -> list[list[Scalar]]:
    """The adjugate of a square matrix: its inverse times its determinant."""
    size = range(len(matrix))

    def cofactor(k: int, j: int) -> Scalar:
        minor = determinant([[x for m, x in enumerate(row) if m != j] for n, row in enumerate(matrix) if n != k])
        return -minor if (k + j) % 2 else minor

    return [[cofactor(k, j) for k in size] for j in size]


def solve_square(matrix: Rows, V: Sequence[Scalar]) -> list[Scalar]:
    """x of matrix x = V, block by block: the columns of a block from its rows minus the known columns."""
    x: dict[int, Scalar] = {}
    for rows, columns in blocks(matrix):
        block = [[matrix[k][j] for j in columns] for k in rows]
        rhs = [V[k] - _product(matrix[k], x) for k in rows]
        reciprocal = 1 / determinant(block)
        for j, row in zip(columns, adjugate(block), strict=True):
            x[j] = sum_of(a * b for a, b in zip(row, rhs, strict=True) if not is_zero(a)) * reciprocal
    return [x[j] for j in range(len(V))]


def least_norm(matrix: Rows, weights: Sequence[Scalar], V: Sequence[Scalar]) -> list[Scalar]:
    """x of matrix x = V with the least sum of w_j x_j^2: W^-1 J^T (J W^-1 J^T)^-1 V.

    The rows must be independent, and the weights positive.
    """
    inverse = [1 / w for w in weights]
    scaled = [[x * w for x, w in zip(row, inverse, strict=True)] for row in matrix]
    normal = [[_dot(row, other) for other in scaled[: k + 1]] for k, row in enumerate(matrix)]
    forces = _solve_positive(normal, V)
    return [_dot([row[j] for row in scaled], forces) for j in range(len(weights))]


def _solve_positive(lower: Rows, V: Sequence[Scalar]) -> list[Scalar]:
    """Solve N x = V by L D L^T, N symmetric and positive definite, given by its lower triangle."""
    size = len(V)
    L: list[list[Scalar]] = [[] for _ in range(size)]
    pivots: list[Scalar] = []
    y: list[Scalar] = []
    for k in range(size):
        scaled: list[Scalar] = []
        for j in range(k):
            scaled.append(lower[k][j] - _dot(scaled, L[j]))
        L[k] = [a * pivots[j] for j, a in enumerate(scaled)]
        pivots.append(1 / (lower[k][k] - _dot(scaled, L[k])))
        y.append(V[k] - _dot(L[k], y))
    x: list[Scalar] = [0] * size
    for k in reversed(range(size)):
        x[k] = y[k] * pivots[k] - sum_of(L[i][k] * x[i] for i in range(k + 1, size))
    return x


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    return sum_of(x * y for x, y in zip(a, b, strict=True) if not (is_zero(x) or is_zero(y)))


def _product(row: Sequence[Scalar], x: dict[int, Scalar]) -> Scalar:
    return sum_of(row[j] * value for j, value in x.items() if not is_zero(row[j]))
