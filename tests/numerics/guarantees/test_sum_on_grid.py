"""Sums of magnitudes of polynomials: bounds on a grid hold between its points, whatever the grid."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.axes import Axis, axis_of
from symoro_elastic.numerics.guarantees.polynomial_rounding import SumOnGrid, best_ratios, coefficients_of, heaviest
from symoro_elastic.numerics.guarantees.polynomials import Polynomial

AXES = (
    axis_of("turn", 2, Range(-4.0, 4.0), angle=True),
    axis_of("arc", 1, Range(-0.4, 1.0), angle=True),
    axis_of("slide", 3, Range(0.1, 0.5), angle=False),
    axis_of("other", 3, Range(-math.pi, math.pi), angle=True),
)


def drawn(seed: int, axes: tuple[Axis, ...] = AXES, count: int = 12) -> list[tuple[float, np.ndarray]]:
    """Weights, and coefficients of polynomials of all axes or without the second one."""
    rng = np.random.default_rng(seed)
    full = tuple(len(axis.orders) for axis in axes)
    flat = (full[0], 1, *full[2:])
    shapes = [full if rng.random() < 0.7 else flat for _ in range(count)]
    return [(float(rng.uniform(0, 2)), rng.normal(size=(2, *s)) * 10 ** rng.uniform(-3, 0)) for s in shapes]


@cache
def largest_sum(points: int, seed: int) -> float:
    """The largest sum of |c_1| + |c_2|, of two coefficients of the motion, at random positions."""
    rng = np.random.default_rng(seed)
    bases = [axis.basis(axis.phases(rng.uniform(axis.low, axis.high, points))) for axis in AXES]
    total = np.zeros(points)
    for weight, coefficients in drawn(seed):
        ones = [base if n > 1 else np.ones((points, 1)) for base, n in zip(bases, coefficients.shape[1:], strict=True)]
        left, right = (np.einsum("pa,pb->pab", *pair).reshape(points, -1) for pair in (ones[:2], ones[2:]))
        by_right = left @ coefficients.reshape(2, left.shape[1], right.shape[1])
        total += weight * np.abs((by_right * right).sum(axis=-1)).sum(axis=0)
    return float(total.max())


@pytest.mark.sampled(30)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("gridded", [(), (0,), (1,), (2, 3), (0, 1, 3), (0, 1, 2, 3)])
def test_no_sum_is_above_the_bound(gridded: tuple[int, ...], seed: int) -> None:
    grid = SumOnGrid(AXES, dict.fromkeys(gridded, 12))
    for weight, coefficients in drawn(seed):
        grid.add(weight, coefficients)
    worst = largest_sum(30_000, seed)
    assert worst <= grid.bound
    if len(gridded) == len(AXES):
        assert grid.bound <= 1.6 * worst  # the factors of four axes are 1.15, and few states meet the largest one


def test_tiny_and_zero_polynomials() -> None:
    axes = AXES[:1]
    grid = SumOnGrid(axes, {0: 8})
    grid.add(1.0, np.zeros((1, 5)))
    assert grid.bound == 0
    grid.add(1e200, np.array([[0.0, 1e-220, 0, 0, 0]]))
    assert 1e-20 <= grid.bound <= 1.1e-20


def test_coefficients_from_values_at_nodes() -> None:
    rng = np.random.default_rng(5)
    nodes = np.ix_(*(axis.nodes for axis in AXES))
    values = np.sin(nodes[0] + 2 * nodes[3]) * np.cos(nodes[1]) + nodes[2] ** 3
    found = [*coefficients_of(Polynomial({(): values, (0,): 3.0 * nodes[2] ** 2}, 1, 0), AXES)]
    at = [rng.uniform(axis.low, axis.high) for axis in AXES]
    bases = [axis.basis(axis.phases(np.array(x))) for axis, x in zip(AXES, at, strict=True)]
    wanted = [math.sin(at[0] + 2 * at[3]) * math.cos(at[1]) + at[2] ** 3, 3 * at[2] ** 2]
    for coefficients, value in zip(found, wanted, strict=True):
        ones = [base if n > 1 else np.ones(1) for base, n in zip(bases, coefficients.shape[1:], strict=True)]
        assert np.einsum("mabcd,a,b,c,d->m", coefficients, *ones) == pytest.approx([value])


def test_the_grid_that_is_chosen_is_the_better_one() -> None:
    """One axis on which all peaks are elsewhere: the sum is much less than that of the largest values."""
    axis = AXES[3]
    bumps = [(1.0, axis.from_values[None, :, k]) for k in range(len(axis.nodes))]
    sample = [(weight, [coefficients]) for weight, coefficients in bumps]
    ratios = best_ratios((axis,), sample, {(7,): 7})
    assert ratios.keys() == {0}
    bounds = []
    for chosen in ({}, ratios):
        grid = SumOnGrid((axis,), chosen)
        for weight, coefficients in bumps:
            grid.add(weight, coefficients)
        bounds.append(grid.bound)
    assert bounds[1] < 0.6 * bounds[0]
    assert best_ratios((axis,), sample, {(7,): 10**12}) == {}


def test_the_heaviest() -> None:
    assert heaviest([1.0, 5.0, 2.0, 2.0], 0.6) == [1, 2]
    assert heaviest([], 0.9) == []
