"""Columns that are independent, and relations of the others to them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.parameters.base_parameters import KEPT, base_grouping, numeric_grouping
from symoro_elastic.numerics.linear.independence import independent_columns, pivoted_qr, rank
from symoro_elastic.numerics.linear.rank import cross_check, numerical_relations
from tests.references.random_machines import random_machine, two_children

Array = NDArray[np.float64]


def dependent(rows: int = 12, columns: int = 7, rank: int = 4) -> Array:
    """A random matrix of this rank."""
    draw = np.random.default_rng(0).normal
    return np.asarray(draw(size=(rows, rank)) @ draw(size=(rank, columns)))


def test_pivoted_qr() -> None:
    W = dependent()
    triangle, order = pivoted_qr(W)
    assert np.allclose(triangle.T @ triangle, W[:, order].T @ W[:, order])
    assert np.allclose(np.tril(triangle[:7], -1), 0)
    sizes = np.abs(np.diag(triangle))
    assert (np.diff(sizes) < 1e-12).all() and sizes[4] < 1e-12 < sizes[3]


def test_columns_are_kept_in_order_unless_others_come_first() -> None:
    W = np.insert(dependent(), 2, 0.0, axis=1) * 10.0 ** np.arange(-4, 4)
    found = independent_columns(W, 1e-9)
    assert (found.kept, found.dropped, found.vanishing) == ((0, 1, 3, 4), (5, 6, 7), (2,))
    other = independent_columns(W, 1e-9, first=(7, 4, 2))
    assert other.kept == (0, 1, 4, 7)
    for each in (found, other):
        kept, dropped = W[:, list(each.kept)], W[:, list(each.dropped)]
        lengths = np.linalg.norm(dropped, axis=0)
        assert np.abs((kept @ each.beta - dropped) / lengths).max() < 1e-13
    X = np.arange(1.0, 9.0)
    assert W[:, list(found.kept)] @ found.apply(X) == pytest.approx(W @ X, rel=1e-12)


def test_short_coefficients_are_found_exactly() -> None:
    a, b, c = np.random.default_rng(2).normal(size=(3, 9))
    found = independent_columns(np.stack([a, b, c, a + 0.35 * c], axis=1), 1e-9)
    assert found.terms(0) == [(3, 1.0)] and found.terms(1) == [] and found.terms(2) == [(3, 0.35)]


@pytest.mark.parametrize("W", [np.zeros((5, 0)), np.zeros((5, 3))])
def test_nothing_is_independent(W: Array) -> None:
    found = independent_columns(W, 1e-9)
    assert (found.kept, found.dropped, found.vanishing) == ((), (), tuple(range(W.shape[1])))
    assert rank(W, 1e-9) == 0


@pytest.mark.sampled(5)
@pytest.mark.parametrize("machine", [two_children(), *(random_machine(k, joints=4 + k) for k in range(4))])
def test_relations_found_by_numbers_are_those_of_the_rules(machine: Machine) -> None:
    """The same base set, the same effects and, as the columns kept are independent, the same sums."""
    rules = base_grouping(machine)
    found = numeric_grouping(machine, numerical_relations(machine, rules.kept))
    assert {x for x, effect in found.effects.items() if effect == KEPT} == set(rules.kept)
    assert cross_check(machine, found, seed=1).agrees
    one, other = ({(p.joint, p.entry): p.formula.value() for p in each.parameters} for each in (rules, found))
    for label in {*one, *other}:
        assert other.get(label, 0.0) == pytest.approx(one.get(label, 0.0), rel=1e-12, abs=1e-12)
