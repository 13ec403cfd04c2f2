"""FMUs of the tests, made once in a process."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tests.fmu.machines import unit


@pytest.fixture(scope="session")
def folder() -> Iterator[Path]:
    with TemporaryDirectory() as path:
        yield Path(path)


@pytest.fixture(scope="session")
def arm(folder: Path) -> Path:
    """The elastic arm, FMI 2.0."""
    return _written(folder, "springs", 2)


@pytest.fixture(scope="session")
def linkage(folder: Path) -> Path:
    """The four-bar linkage, FMI 3.0."""
    return _written(folder, "loop", 3)


@cache
def _written(folder: Path, case: str, version: int) -> Path:
    path = folder / f"{case}{version}.fmu"
    path.write_bytes(unit(case, version).archive)
    return path
