"""A = L^T D L of a symmetric matrix whose rows belong to joints, from the tips to the base."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from symoro_elastic.mechanics.elimination import SingularPivot
from symoro_elastic.mechanics.spatial import Scalar, is_zero

Rows: TypeAlias = Sequence[Sequence[Scalar]] | Mapping[int, Mapping[int, Scalar]]


@dataclass(frozen=True)
class Factorization:
    """A = L^T D L by joint number: rows of L below its diagonal of ones, pivots D_j, their inverses.

    L_ji is zero where joint i does not carry joint j. D_j is H_j [28] of the backward recursion.
    """

    L: dict[int, dict[int, Scalar]]
    pivots: dict[int, Scalar]
    inverses: dict[int, Scalar]


Share: TypeAlias = Callable[[Scalar, Scalar, Scalar], Scalar]
"""L_ji from A_ji, the pivot D_j and its inverse."""


def share(entry: Scalar, pivot: Scalar, inverse: Scalar) -> Scalar:
    """Entry A_ji / D_j of the factor L, by the inverse of the pivot."""
    return entry * inverse


def share_or_one(entry: Scalar, pivot: Scalar, inverse: Scalar) -> Scalar:
    """Entry A_ji / D_j of L, exactly 1 where both are one expression, as for coordinates that move the same bodies."""
    return 1 if entry is pivot else entry * inverse


def by_minimum_degree(order: Sequence[int], A: Rows, is_constant: Callable[[Scalar], bool]) -> tuple[int, ...]:
    """The rows by minimum degree: each time the next one that meets the fewest others, so that most zeros stay.

    Of several the first whose pivot is constant, so that its inverse is found once, else the first of `order`.
    """
    met = {j: {i for i in order if i != j and not is_zero(A[i][j])} for j in order}
    waiting, found = [*order], list[int]()
    while waiting:
        j = min(waiting, key=lambda j: (len(met[j]), not is_constant(A[j][j])))
        waiting.remove(j)
        found.append(j)
        for i in met[j]:
            met[i] = (met[i] | met[j]) - {i, j}
    return tuple(found)


def factorization(order: Sequence[int], A: Rows, by: Share = share) -> Factorization:
    """Factors of A = L^T D L, rows eliminated in this order; zeros of structure stay. Raises `SingularPivot`."""
    reduced = {i: {j: A[i][j] for j in order} for i in order}
    factors = Factorization({}, {}, {})
    for m, j in enumerate(order):
        carrying = [i for i in reversed(order[m + 1 :]) if not is_zero(reduced[j][i])]
        try:
            inverse = 1 / reduced[j][j]
        except ZeroDivisionError:
            raise SingularPivot(j) from None
        factors.pivots[j], factors.inverses[j] = reduced[j][j], inverse
        factors.L[j] = {i: by(reduced[j][i], reduced[j][j], inverse) for i in carrying}
        for i in carrying:
            for k in carrying[: carrying.index(i) + 1]:
                reduced[i][k] = reduced[k][i] = reduced[i][k] - factors.L[j][i] * reduced[j][k]
    return factors


def solution(factors: Factorization, right: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """x of A x = right, by joint number."""
    x = dict(right)  # (10): L^T D L x = right
    for j, row in factors.L.items():
        for i, entry in row.items():
            x[i] = x[i] - entry * x[j]
    for j, row in reversed(factors.L.items()):
        x[j] = x[j] * factors.inverses[j]
        for i, entry in row.items():
            x[j] = x[j] - entry * x[i]
    return x
