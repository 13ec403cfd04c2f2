"""Steps that messages offer are whole parts of the period and no longer than what is allowed."""

from __future__ import annotations

import pytest

from symoro_elastic.analysis.simulation.periods import is_whole, part_from, part_of, rounded_down


@pytest.mark.parametrize("period", [1e-3, 0.05, 1 / 3, 0.007])
@pytest.mark.parametrize("largest", [4.06e-4, 1e-4, 3.3e-7, 1.0])
def test_a_part_is_whole_and_allowed(period: float, largest: float) -> None:
    step = float(part_of(period, largest))
    assert is_whole(period / step) and step <= largest


@pytest.mark.parametrize("least", [4e-4, 1e-3, 3.3e-7])
def test_a_part_from_the_least_is_whole(least: float) -> None:
    step = float(part_from(1e-3, least))
    assert is_whole(1e-3 / step) and least <= step <= 1e-3


def test_few_digits_are_preferred() -> None:
    assert part_of(1e-3, 4.06e-4) == "0.00025"


@pytest.mark.parametrize("x", [1.006, 4.067e-4, 9.996, 0.25])
def test_rounded_down_is_never_above(x: float) -> None:
    assert 0.98 * x < float(rounded_down(x)) <= x
