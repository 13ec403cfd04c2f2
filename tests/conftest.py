"""Options and settings of all tests."""

from __future__ import annotations

import gc
import os
from collections import Counter
from collections.abc import Sequence

import pytest
from hypothesis import HealthCheck, settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # numpy reads them at its import; threads only wait at matrices of this size

SLOW = [HealthCheck.too_slow]
settings.register_profile("tests", deadline=None, suppress_health_check=SLOW)
settings.register_profile("ci", deadline=None, suppress_health_check=SLOW, derandomize=True)
# The same examples in every run of continuous integration; new ones at every other run.
settings.load_profile("ci" if os.environ.get("CI") else "tests")

gc.set_threshold(2_000_000, 3, 20)
"""Expressions are many small objects that stay: collections as often as usual take a sixth of the time of the tests."""

FEW = 2
"""Tests of so many cases are not sampled."""
GOLDEN_RATIO = (5**0.5 - 1) / 2


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate", action="store_true", help="accept what the examples generate now into generated/")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: Sequence[pytest.Item]) -> None:
    """Mark the cases of `sampled` tests that are thorough; the same ones in every run."""
    cases = Counter(map(_test_of, items))
    before: Counter[str] = Counter()
    for item in items:
        test, sampled = _test_of(item), item.get_closest_marker("sampled")
        if sampled and cases[test] > FEW and not _is_chosen(before[test], *sampled.args):
            item.add_marker(pytest.mark.thorough)
        before[test] += 1


def _test_of(item: pytest.Item) -> str:
    return item.nodeid.split("[")[0]


def _is_chosen(case: int, one_in: int) -> bool:
    """By multiples of the golden ratio, modulo 1: evenly spread, whatever the period of the parameters."""
    return (case * GOLDEN_RATIO) % 1 < 1 / one_in


@pytest.fixture(autouse=True)
def _compiled_quickly(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Code is compiled to be checked without optimising it, in half the time, but for tests marked `optimised`."""
    if not request.node.get_closest_marker("optimised"):
        from symoro_elastic.codegen import compile as compiling

        monkeypatch.setattr(compiling, "optimisation", lambda package: "-O0")
