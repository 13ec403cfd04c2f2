"""A = L^T D L of symmetric matrices, in exact numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.factorization import by_minimum_degree, factorization, solution

Rows = dict[int, dict[int, Fraction]]


def symmetric(size: int, entries: Sequence[tuple[int, int, int]]) -> Rows:
    """20 on the diagonal, and given entries beside it."""
    A = {i: {j: Fraction(20 if i == j else 0) for j in range(1, size + 1)} for i in range(1, size + 1)}
    for i, j, x in entries:
        A[i][j] = A[j][i] = Fraction(x)
    return A


def varying(*numbers: int) -> Callable[[Scalar], bool]:
    """Which diagonal entries are constant: those that are not these numbers."""
    return lambda x: x not in numbers


def entries(A: Rows, order: Sequence[int]) -> int:
    return sum(len(row) for row in factorization(order, A).L.values())


ARROW = symmetric(5, [(1, 5, 2), (2, 5, 3), (3, 5, 1), (4, 5, 4)])
"""5 meets all others, which do not meet each other."""


def test_no_zero_of_an_arrow_is_lost() -> None:
    order = by_minimum_degree((5, 4, 3, 2, 1), ARROW, varying())
    assert entries(ARROW, order) == 4 and entries(ARROW, (5, 4, 3, 2, 1)) == 10


def test_of_rows_alike_those_with_constant_pivots_come_first() -> None:
    full = symmetric(3, [(1, 2, 1), (1, 3, 2), (2, 3, 3)])
    full[3][3] = Fraction(21)
    assert by_minimum_degree((3, 2, 1), full, varying()) == (3, 2, 1)
    assert by_minimum_degree((3, 2, 1), full, varying(21))[0] == 2


def test_the_solution_is_the_same_in_any_order() -> None:
    wanted = {j: Fraction(j, 7) for j in ARROW}
    right: dict[int, Scalar] = {i: sum(ARROW[i][j] * wanted[j] for j in ARROW) for i in ARROW}
    for order in ((5, 4, 3, 2, 1), by_minimum_degree((5, 4, 3, 2, 1), ARROW, varying())):
        assert solution(factorization(order, ARROW), right) == wanted
