"""The fitting core by itself: verdicts, undetermined directions, evidence of other data, the search for corrections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from symoro_elastic.foundation.results import json_of, table_of
from symoro_elastic.measured.fitting.corrections import (
    MOST_NAMED,
    MOST_REFITTED,
    VERY_STRONG,
    Correction,
    Refit,
    explanations,
    names_of,
)
from symoro_elastic.measured.fitting.estimates import (
    Estimate,
    Unknown,
    Verdict,
    directions,
    estimates_of_logarithms,
    is_identified,
    largest_of_chance,
    undetermined_directions,
)
from symoro_elastic.measured.fitting.evidence import Evidence, information_root, largest_chi2


def unknowns(*labels: str) -> list[Unknown]:
    return [Unknown(label, "N/m") for label in labels]


def test_estimates_of_logarithms_have_values_and_verdicts_by_the_prior() -> None:
    """Standard deviations of 0.05, 0.3 and 0.6 of a prior of a factor of 10; relative ones are those of logarithms."""
    std = math.log(10) * np.array([0.05, 0.3, 0.6])
    found = estimates_of_logarithms(unknowns("a", "b", "c"), np.log([2.0, 300.0, 5e6]), std, 10.0)
    assert [x.value for x in found] == pytest.approx([2.0, 300.0, 5e6])
    assert [x.relative for x in found] == pytest.approx(std)
    assert [x.std for x in found] == pytest.approx(std * [2.0, 300.0, 5e6])
    assert [x.verdict for x in found] == [Verdict.IDENTIFIED, Verdict.POOR, Verdict.NOT]
    assert [x.unknown.label for x in found] == ["a", "b", "c"]


def test_estimates_are_shown_with_the_value_of_the_file_unless_that_is_a_guess() -> None:
    group = Unknown("IA1", "kg m2", nominal=0.25, formula="IA1 + ZZ1")
    guess = Unknown("k", "N/m", nominal=3.0, of_file=False)
    rows = [Estimate(group, 0.5, 0.015625, Verdict.IDENTIFIED), Estimate(guess, -8.0, 4.0, Verdict.POOR, "why")]
    assert table_of(Estimate, rows).rows == [
        ("IA1", "0.25", "0.5", "3.1", "kg m2", "identified"),
        ("k", "-", "-8", "50", "N/m", "poorly identified"),
    ]
    first, second = map(json_of, rows)
    assert first == {
        "formula": "IA1 + ZZ1", "file": 0.25, "value": 0.5, "std": 0.015625, "relative_std": 0.03125, "unit": "kg m2",
        "verdict": "identified", "reason": "",
    }  # fmt: skip
    assert second["formula"] == "k" and second["file"] is None and second["reason"] == "why"


def test_an_estimate_of_zero_is_never_identified() -> None:
    assert math.isinf(Estimate(Unknown("m", "kg"), 0.0, 1e-9, Verdict.POOR).relative)
    assert Estimate(Unknown("m", "kg"), -4.0, 1.0, Verdict.POOR).relative == 0.25
    assert is_identified(-1.0, 0.09) and not is_identified(-1.0, 0.11) and not is_identified(0.0, 1e-9)


@pytest.mark.parametrize("count", [1, 7, 300])
def test_no_estimate_is_beyond_the_largest_of_chance_but_once_in_a_thousand(count: int) -> None:
    inside = stats.norm.cdf(largest_of_chance(count)) ** count
    assert 1 - inside == pytest.approx(1e-3, rel=1e-3)


@pytest.mark.parametrize("freedom", [1, 2.5, 30, 1000])
def test_right_data_exceed_the_largest_chi2_once_in_a_thousand(freedom: float) -> None:
    assert stats.chi2.sf(freedom * largest_chi2(freedom), freedom) == pytest.approx(1e-3)
    assert largest_chi2(0.2) == largest_chi2(1)


KNOWN = 1e-4
"""Variance of ln p in directions that the data determine."""


def covariance_along(*free: tuple[float, ...]) -> np.ndarray:
    """Covariance of ln p with large variances along some directions."""
    size = len(free[0])
    return KNOWN * np.eye(size) + sum(4.0 * np.outer(v, v) / np.dot(v, v) for v in map(np.array, free))


@pytest.mark.parametrize(
    ("direction", "sentence"),
    [
        # d(1/p1 + 1/p2) = -(d ln p1)/p1 - (d ln p2)/p2 = 0, with p1 = 2, p2 = 5
        ((2.0, -5.0), "in series: these tests determine only 1/k2 + 1/k1"),
        ((2.0, -4.6), "in series: these tests determine only 1/k2 + 1/k1"),  # nearly
        # d(p1 + p2) = p1 d ln p1 + p2 d ln p2 = 0
        ((5.0, -2.0), "in parallel: these tests determine only k1 + k2"),
        ((1.0, 1.0), "together: these tests determine only k"),
        ((1.0, -2.0), "are not distinguishable: "),  # the slope of springs in series is -0.4, not -0.5
        ((0.0, 1.0), "these tests do not determine k2: its value is close to the initial"),
    ],
)
def test_a_free_direction_of_two_springs_is_said(direction: tuple[float, float], sentence: str) -> None:
    x = np.log([2.0, 5.0])
    (said,) = undetermined_directions(unknowns("k1", "k2"), x, covariance_along(direction), 10.0)
    assert sentence in said


@pytest.mark.parametrize(("std", "said"), [(0.45, 0), (0.52, 1)])
def test_a_direction_is_undetermined_beyond_half_of_the_prior(std: float, said: int) -> None:
    covariance = np.diag([(std * math.log(10.0)) ** 2, KNOWN])
    assert len(undetermined_directions(unknowns("k1", "k2"), np.zeros(2), covariance, 10.0)) == said


def test_single_parameters_are_said_before_pairs() -> None:
    covariance = covariance_along((1.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    first, second = undetermined_directions(unknowns("k1", "k2", "k3", "k4"), np.zeros(4), covariance, 10.0)
    assert first == "these tests do not determine k3: its value is close to the initial"
    assert second.startswith("k1 and k2 together") or second.startswith("k2 and k1 together")


def test_changes_of_three_parameters_that_data_do_not_show_have_their_ratios() -> None:
    """10 % of the first one, and powers of that factor for the others; small parts and nuisances are left out."""
    several = [*unknowns("k1", "k2", "k3", "m"), Unknown("gain", "1", is_nuisance=True)]
    (said,) = undetermined_directions(several, np.zeros(5), covariance_along((1.0, -2.0, 1.5, 0.05, 0.0)), 10.0)
    assert "m" not in said.split(" are not ")[0].replace("k", "").split()
    by = {"k1": -0.5, "k2": 1.0, "k3": -0.75}  # of the largest part
    for label, power in by.items():
        assert f"{100 * (1.1**power - 1):+.2g} % {label}" in said


def test_directions_are_a_basis_with_a_parameter_of_its_own_each() -> None:
    null = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 3)))[0]
    basis = np.array(directions(null))
    assert np.abs(basis - basis @ null @ null.T).max() < 1e-12
    assert sum(np.allclose(sorted(np.abs(column)), [0, 0, 1]) for column in basis.T) >= 3
    assert directions(np.zeros((6, 0))) == []


def test_the_root_of_information_is_that_of_the_covariance() -> None:
    """An estimated covariance that is not positive has no smaller standard deviations than its own."""
    rng = np.random.default_rng(1)
    A = rng.normal(size=(4, 4)) * [1.0, 1e3, 1e-6, 1.0]
    C = A.T @ A
    R = information_root(C)
    assert np.abs(R @ C @ R.T - np.eye(4)).max() < 1e-9
    indefinite = np.array([[1.0, 1.02, 0.0], [1.02, 1.0, 0.0], [0.0, 0.0, 4.0]])
    R = information_root(indefinite)
    used = np.linalg.inv(R.T @ R)
    assert np.diag(used) == pytest.approx(1.04 * np.diag(indefinite))
    assert used[0, 1] == pytest.approx(1.02)


def test_residuals_of_evidence_have_slopes_and_contradict_once_in_a_thousand() -> None:
    covariance = np.array([[4.0, 1.0], [1.0, 2.0]])
    evidence = Evidence.of(lambda x: np.array([x[0] * x[1], x[2] ** 3]), np.array([6.0, 8.0]), covariance)
    at = np.array([1.5, 3.0, 2.1])
    r, slopes = evidence.residuals(at)
    apart = np.array([1.5 * 3.0 - 6.0, 2.1**3 - 8.0])
    assert r @ r == pytest.approx(apart @ np.linalg.solve(covariance, apart))
    expected = np.array([[3.0, 0.0], [1.5, 0.0], [0.0, 3 * 2.1**2]]) @ evidence.root.T
    assert np.abs(slopes - expected).max() < 1e-8
    two = Evidence.of(lambda x: x, np.zeros(2), 4.0 * np.eye(2))
    border = 2.0 * math.sqrt(2 * largest_chi2(2)) * np.array([0.6, 0.8])
    assert two.contradicts(1.001 * border) and not two.contradicts(0.999 * border)


def row(name: str, family: str = "") -> Correction[float]:
    return Correction(name, 0.0, family=family)


class Search:
    """A search whose rows have given distances and costs; it notes which are refitted."""

    def __init__(self, distances: dict[str, float], costs: dict[str, float]) -> None:
        self.distances, self.costs, self.refitted = distances, costs, []

    def refit(self, correction: Correction[float]) -> Refit[float] | None:
        self.refitted.append(correction.name)
        cost = self.costs.get(correction.name)
        return None if cost is None else Refit(correction, cost, 100.0)

    def found(self, rows: list[Correction[float]], bound: float = 1.0) -> list[str]:
        return [x.name for x in explanations(rows, lambda one: self.distances[one.name], self.refit, bound)]


def test_rows_that_explain_the_data_as_well_as_the_best_are_named_the_best_first() -> None:
    costs = {"a": 50.0, "b": 49.0, "c": 49.0 + VERY_STRONG, "d": 49.1 + VERY_STRONG}
    search = Search({"a": 0.4, "b": 0.5, "c": 0.3, "d": 0.2, "far": 1.0, "wrong": 0.1}, costs)
    assert search.found([row(name) for name in search.distances]) == ["b", "a", "c"]
    assert search.refitted == ["wrong", "d", "c", "a", "b"]


def test_a_row_explains_the_data_if_it_is_far_better_than_none() -> None:
    search = Search({"a": 0.1, "b": 0.2}, {"a": 100.0 - VERY_STRONG, "b": 99.9 - VERY_STRONG})
    assert search.found([row("a"), row("b")]) == ["b"]
    assert Search({"a": 0.1}, {}).found([row("a")]) == []


def test_of_a_family_the_nearest_row_is_refitted_and_of_all_the_nearest_few() -> None:
    rows = [row("g at 1", "g"), row("g at 2", "g"), row("g at 3", "g"), *(row(f"r{k}") for k in range(9))]
    distances = {"g at 1": 0.3, "g at 2": 0.01, "g at 3": 0.2} | {f"r{k}": 0.9 - 0.05 * k for k in range(9)}
    search = Search(distances, dict.fromkeys(distances, 1.0))
    search.found(rows)
    assert search.refitted == ["g at 2", "r8", "r7", "r6", "r5", "r4"] and len(search.refitted) == MOST_REFITTED


def test_names_of_corrections_are_said_once_and_not_too_many() -> None:
    assert names_of(row(name) for name in ("a", "b", "a")) == "a, or b"
    assert names_of(row(name) for name in "abcdef").count("or") == MOST_NAMED - 1
