"""FMUs of the tests, made once in a process."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest import mock

import pytest

from symoro_elastic.generation.fmu import Options
from symoro_elastic.generation.fmu.mock_up_unit import unit_of
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.scene import INERTIA, Scene
from tests.generation.fmu.machines import UNDER_A_WRENCH, elastic_arm, unit


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


@pytest.fixture(scope="session")
def short_of_steps(folder: Path) -> Path:
    """The elastic arm through its inertia matrix, with 50 steps at most in a communication step."""
    path = folder / "short_of_steps.fmu"
    with mock.patch("symoro_elastic.generation.fmu.sources.MOST_STEPS", 50):
        path.write_bytes(unit_of(elastic_arm(), replace(UNDER_A_WRENCH, form=INERTIA), Options()).archive)
    return path


@pytest.fixture(scope="session")
def stiff(folder: Path) -> Path:
    """The elastic arm with a vibration 20 000 times as fast as the slowest."""
    path = folder / "stiff.fmu"
    arm, rod = elastic_arm().joints[1:3]
    springs = {arm.name: Formula.parse(20), rod.name: Formula.parse(1e9)}
    joints = [
        replace(one, spring=replace(one.spring, stiffness=springs[one.name], damping=Formula.parse(0)))
        if one.name in springs
        else one
        for one in elastic_arm().joints
    ]
    path.write_bytes(unit_of(replace(elastic_arm(), joints=tuple(joints)), Scene(), Options()).archive)
    return path


@cache
def _written(folder: Path, case: str, version: int) -> Path:
    path = folder / f"{case}{version}.fmu"
    path.write_bytes(unit(case, version).archive)
    return path
