"""What is swept, as text and as numbers, and the points that follow."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import pytest

from symoro_elastic.analysis.sweeps.design import design
from symoro_elastic.analysis.sweeps.ranges import AxisLike, Listed, Spread, axis
from symoro_elastic.foundation.errors import InputError


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ("0:1:5", [0.0, 0.25, 0.5, 0.75, 1.0]),
        ("1e2:1e4:3,log", [1e2, 1e3, 1e4]),
        ("3, 1/2 ,2", [3.0, 0.5, 2.0]),
        ("pi", [np.pi]),
        ("2:2:1", [2.0]),
        (7, [7.0]),
        ([1, 2.5], [1.0, 2.5]),
        (np.array([1.0, 4.0]), [1.0, 4.0]),
    ],
)
def test_values_of_a_grid(given: AxisLike, values: list[float]) -> None:
    found = axis("k", given)
    assert isinstance(found, Listed)
    assert found.count == len(values) and found.values() == pytest.approx(values, rel=1e-15)


@pytest.mark.parametrize(
    ("given", "share", "value"),
    [
        ("2:4", 0.25, 2.5),
        ("1e2:1e4,log", 0.5, 1e3),
        ("normal:5:2", 0.975, NormalDist(5, 2).inv_cdf(0.975)),
        ("lognormal:5:0.1", 0.1, 5 * np.exp(NormalDist(0, 0.1).inv_cdf(0.1))),
    ],
)
def test_quantiles_of_a_distribution(given: str, share: float, value: float) -> None:
    found = axis("k", given)
    assert isinstance(found, Spread)
    assert found.quantiles(np.array([share]))[0] == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("", "is not a number"),
        ("a:b:3", "'a' is not a number"),
        ("1,nan", "'nan' is not a number"),
        ("1:inf:3", "'inf' is not a number"),
        ("0:1:0", "a count from 1"),
        ("0:1:-4", "a count from 1"),
        ("0:1:2.5", "a count from 1"),
        ("1:0:3", "LOW first"),
        ("1:1:3", "LOW first"),
        ("0:1:3,log", "0 has no logarithm"),
        ("1,2,2", "given twice"),
        ("1,2,log", "give LOW:HIGH:COUNT"),
        ("normal:1:0", "not a standard deviation"),
        ("normal:1", "give normal:MEAN:DEVIATION"),
        ("lognormal:-1:2", "-1 has no logarithm"),
        ("1e300,2", "out of range"),
        ("1:2:3:4", "give LOW:HIGH:COUNT"),
        ([], "the list is empty"),
        ([1.0, float("nan")], "nan is not finite"),
        (["a"], "'a' is not a number"),
        ([True], "True is not a number"),
        (np.array([]), "the list is empty"),
        ({"a": 1}, "is not a list of numbers"),
        (None, "is not a list of numbers"),
    ],
)
def test_what_is_no_axis_is_refused_in_one_line(given: AxisLike, said: str) -> None:
    with pytest.raises(InputError) as error:
        axis("ram.k", given)
    assert said in str(error.value) and "ram.k" in str(error.value) and "\n" not in str(error.value)


def test_the_last_quantity_of_a_grid_varies_fastest() -> None:
    found = design({"a": axis("a", [1, 2]), "b": axis("b", "0:2:3")})
    assert found.points.tolist() == [[1, 0], [1, 1], [1, 2], [2, 0], [2, 1], [2, 2]]
    assert found.lengths == (2, 3)
    assert (found.along(0).tolist(), found.along(1).tolist()) == ([1, 2], [0, 1, 2])


def test_a_latin_hypercube_has_a_point_in_each_part_of_each_range() -> None:
    found = design({"a": axis("a", "0:1"), "b": axis("b", "normal:3:0.5")}, 50)
    parts = np.sort((found.points[:, 0] * 50).astype(int))
    assert parts.tolist() == list(range(50))
    shares = np.sort([NormalDist(3, 0.5).cdf(x) for x in found.points[:, 1]])
    assert np.abs(shares - (np.arange(50) + 0.5) / 50).max() < 0.5 / 50 + 1e-12


@pytest.mark.parametrize("sampling", ["latin", "random", "sobol"])
def test_a_sample_is_that_of_its_seed(sampling: str) -> None:
    axes = {"a": axis("a", "0:1"), "b": axis("b", "1:10,log")}
    first, again, other = (design(axes, 16, sampling, seed).points for seed in (3, 3, 4))
    assert (first == again).all() and (first != other).any()
    assert ((first >= [0, 1]) & (first <= [1, 10])).all()


@pytest.mark.parametrize(
    ("given", "samples", "sampling", "seed", "said"),
    [
        ({}, None, None, None, "nothing to sweep"),
        ({"a": "0:1"}, None, None, None, "give the number of points by --samples"),
        ({"a": "0:1:3"}, 5, None, None, "cannot be sampled"),
        ({"a": "0:1"}, 0, None, None, "--samples: 0: give a whole number from 1"),
        ({"a": "0:1"}, -5, None, None, "--samples: -5"),
        ({"a": "0:1"}, 5, "best", None, "--sampling: unknown 'best'"),
        ({"a": "0:1"}, 5, "random", -1, "--seed: -1"),
        ({"a": "0:1"}, 5, "sobol", None, "give 8, a power of 2"),
        ({"a": "0:1:3"}, None, None, 1, "--seed: a grid is not random"),
        ({"a": "0:1:100000", "b": "0:1:100000"}, None, None, None, "make 1e+10 numbers"),
        ({"a": "0:1"}, 10**9, None, None, "make 1e+09 numbers"),
    ],
)
def test_designs_that_cannot_be_made(
    given: dict[str, str], samples: int | None, sampling: str | None, seed: int | None, said: str
) -> None:
    with pytest.raises(InputError) as error:
        design({name: axis(name, text) for name, text in given.items()}, samples, sampling, seed)
    assert said in str(error.value)
