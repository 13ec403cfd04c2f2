"""Butcher tableaus against the order conditions, in exact rationals; one step against the exact solution."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import exp, prod

import numpy as np
import pytest

from symoro_elastic.codegen.integration import tableaus
from symoro_elastic.codegen.integration.tableaus import RK4, Tableau, step
from symoro_elastic.foundation.array_types import Array

TABLEAUS = {name: found for name, found in vars(tableaus).items() if isinstance(found, Tableau)}
Tree = tuple["Tree", ...]
"""A rooted tree: those that hang on its root."""


def trees(order: int) -> Iterator[Tree]:
    """Rooted trees with so many nodes, each once: as sorted forests on a root."""
    yield from forests(order - 1, order - 1)


def forests(nodes: int, largest: int) -> Iterator[Tree]:
    """Forests of so many nodes, trees of at most `largest` nodes, no forest twice."""
    if nodes == 0:
        yield ()
    for first in range(min(nodes, largest), 0, -1):
        for tree in trees(first):
            for rest in forests(nodes - first, first):
                if not rest or size(rest[0]) < first or tree >= rest[0]:
                    yield (tree, *rest)


def size(tree: Tree) -> int:
    return 1 + sum(map(size, tree))


def density(tree: Tree) -> int:
    return size(tree) * prod(map(density, tree))


def elementary_weights(tableau: Tableau, tree: Tree) -> list[Fraction]:
    """By stage, the product over the branches of sum_j a_ij of the weights of the branch."""
    branches = [elementary_weights(tableau, branch) for branch in tree]
    return [
        prod(
            (sum((a * x for a, x in zip(row, branch, strict=False)), Fraction(0)) for branch in branches),
            start=Fraction(1),
        )
        for row in tableau.A
    ]


def error(tableau: Tableau, tree: Tree) -> Fraction:
    """sum_i b_i Phi_i(tree) - 1 / density(tree)."""
    weights = elementary_weights(tableau, tree)
    return sum((b * x for b, x in zip(tableau.b, weights, strict=True)), Fraction(0)) - Fraction(1, density(tree))


def test_there_are_as_many_conditions_as_rooted_trees() -> None:
    assert [len(list(trees(order))) for order in range(1, 7)] == [1, 1, 2, 4, 9, 20]


@pytest.mark.parametrize("name", TABLEAUS)
def test_order_conditions(name: str) -> None:
    """All up to the order of the method hold, and not all of the next order: Butcher 1963."""
    tableau = TABLEAUS[name]
    assert [len(row) for row in tableau.A] == list(range(len(tableau.b)))
    assert tableau.c == tuple(sum(row, Fraction(0)) for row in tableau.A)
    assert not any(error(tableau, tree) for order in range(1, tableau.order + 1) for tree in trees(order))
    assert any(error(tableau, tree) for tree in trees(tableau.order + 1))


def test_a_step_of_rk4_against_the_exact_solution() -> None:
    """y' = (1 + t) y, an array of two axes: the error of a step is C h^5 (1 + O(h)), 32 times less at half the step."""

    def rate(t: float, y: Array) -> Array:
        return (1 + t) * y

    errors, start = [], np.array([[2.0, -1.0]])
    for h in (0.02, 0.01):
        exact = start * exp((1 + 0.3) * h + h * h / 2)
        errors.append(np.abs(step(RK4, rate, 0.3, start, h) - exact).max())
    assert errors[0] / errors[1] == pytest.approx(32, rel=0.1)
