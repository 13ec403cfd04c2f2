"""Options and settings of all tests."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # numpy reads them at its import; threads only wait at matrices of this size

SLOW = [HealthCheck.too_slow]
settings.register_profile("tests", deadline=None, suppress_health_check=SLOW)
settings.register_profile("ci", deadline=None, suppress_health_check=SLOW, derandomize=True)
# The same examples in every run of continuous integration; new ones at every other run.
settings.load_profile("ci" if os.environ.get("CI") else "tests")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate", action="store_true", help="accept what the examples generate now into generated/")
