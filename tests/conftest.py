"""Options and settings of all tests."""

from __future__ import annotations

import gc
import os
import subprocess
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.compiled_once import CompiledOnce, delete_unused
from tests.processor_times import OPTION, ProcessorTimes

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # numpy reads them at its import; threads only wait at matrices of this size

SLOW = [HealthCheck.too_slow]
settings.register_profile("tests", deadline=None, suppress_health_check=SLOW)
settings.register_profile("ci", deadline=None, suppress_health_check=SLOW, derandomize=True)
# The same examples in every run of continuous integration; new ones at every other run.
settings.load_profile("ci" if os.environ.get("CI") else "tests")

gc.set_threshold(2_000_000, 3, 20)
"""Expressions are many small objects that stay: collections as often as usual take a sixth of the time of the tests."""

IS_QUICK = pytest.StashKey[dict[str, bool]]()
"""Whether tests, by file and name, have a case in the test command."""
GOLDEN_RATIO = (5**0.5 - 1) / 2


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate", action="store_true", help="accept what the examples generate now into generated/")
    parser.addoption(OPTION, type=Path, metavar="FILE", help="append the processor seconds of each test to a file")


def pytest_configure(config: pytest.Config) -> None:
    file = config.getoption(OPTION)
    if file and (hasattr(config, "workerinput") or not config.getoption("numprocesses", 0)):
        config.pluginmanager.register(ProcessorTimes(file.resolve()))
    if hasattr(config, "cache"):
        folder = config.cache.mkdir("compiled")
        if hasattr(config, "workerinput") or not config.getoption("numprocesses", 0):
            subprocess.run = CompiledOnce(folder)
        else:
            delete_unused(folder)


def pytest_unconfigure() -> None:
    if isinstance(subprocess.run, CompiledOnce):
        subprocess.run = subprocess.run.run


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: Sequence[pytest.Item]) -> None:
    """Mark the cases of `sampled` tests that are thorough, the same ones in every run; note which tests are quick."""
    is_quick = config.stash[IS_QUICK] = {}
    before: Counter[str] = Counter()
    for item in items:
        test, sampled = _test_of(item), item.get_closest_marker("sampled")
        if sampled and not _is_chosen(before[test], *sampled.args):
            item.add_marker(pytest.mark.thorough)
        before[test] += 1
        is_quick[test] = is_quick.get(test, False) or not item.get_closest_marker("thorough")


def _test_of(item: pytest.Item) -> str:
    return item.nodeid.split("[")[0]


def _is_chosen(case: int, one_in: int) -> bool:
    """By multiples of the golden ratio, modulo 1: the first one, then evenly, whatever the period of the parameters."""
    return (case * GOLDEN_RATIO) % 1 < 1 / one_in


@pytest.fixture(autouse=True)
def _compiled_quickly(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Code is compiled once, without optimising it, in half the time, but for tests marked otherwise."""
    if not request.node.get_closest_marker("optimised"):
        from symoro_elastic.codegen import compile as compiling

        monkeypatch.setattr(compiling, "optimisation", lambda package: "-O0")
    if request.node.get_closest_marker("compiled_anew") and isinstance(subprocess.run, CompiledOnce):
        monkeypatch.setattr(subprocess, "run", subprocess.run.run)
