"""No text for C, C++, CUDA or an FMU divides whole numbers by whole numbers: 193/500 is 0 there."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from unittest import mock

import pytest

import symoro_elastic as se
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.precision import PRECISIONS, SINGLE
from symoro_elastic.codegen.targets import TARGETS, render_targets
from symoro_elastic.codegen.templates import environment
from symoro_elastic.codegen.time_steps import Literals
from symoro_elastic.generation import fmu
from symoro_elastic.generation.fmu.mock_up_unit import unit_of
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import ALL, Scene

EXAMPLES = Path(__file__).parents[2] / "examples"
APART = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"', re.DOTALL)
"""Comments and texts."""
WHOLE = r"\(*-?(?<![\w.])\d+[uUlL]*\)*"
DIVISION = re.compile(rf"{WHOLE}\s*/\s*{WHOLE}(?![\w.])")
COMPILED = (".c", ".h", ".hpp", ".cuh", ".cu")


def divisions(text: str) -> list[str]:
    return DIVISION.findall(APART.sub(" ", text))


@pytest.mark.parametrize("text", ["{ 0, 193/500 };", "x = (1) / 2U;", "x*(-3/4L)"])
def test_a_division_is_found(text: str) -> None:
    assert divisions(text)


@pytest.mark.parametrize("text", ["1.0/2.0", "x/2", "1/2.0", "1e-3/4.0", "/* 1/2 */ // 1/2", '"1/2"', "a1/2.5f"])
def test_others_are_left(text: str) -> None:
    assert not divisions(text)


def texts(name: str) -> Iterator[tuple[str, str]]:
    """Files of every target that is compiled, with all time steps that the machine has."""
    machine = se.read(EXAMPLES / name)
    for fold in ((), ALL):
        package = programs(machine, Scene(models=("direct_dynamics", "inverse_dynamics"), fold=fold)).package
        yield from render_targets(package, tuple(TARGETS), tuple(PRECISIONS.values())).items()
    for method in METHODS:
        stepped = programs(machine, Scene(models=("direct_dynamics",), steps=(method,))).package
        yield from render_targets(stepped, ("c", "cpp", "cuda")).items()


MACHINES = [
    "planar_2r.toml",
    *(pytest.param(name, marks=pytest.mark.thorough) for name in ("ball_screw.toml", "sr400.par")),
]


@pytest.mark.parametrize("name", MACHINES)
def test_no_target_divides_whole_numbers(name: str) -> None:
    compiled = [(file, text) for file, text in texts(name) if file.endswith(COMPILED)]
    assert {Path(file).suffix for file, _ in compiled} >= {".c", ".h", ".hpp", ".cuh", ".cu"}
    assert {file: divisions(text) for file, text in compiled if divisions(text)} == {}


@pytest.mark.parametrize("version", [2, 3])
def test_no_fmu_divides_whole_numbers(version: int) -> None:
    machine = se.read(EXAMPLES / "ball_screw.toml")
    with mock.patch("symoro_elastic.generation.fmu.mock_up_unit.shared_library", return_value=None):
        archive = unit_of(machine, Scene(), fmu.Options(version=version)).archive
    with zipfile.ZipFile(io.BytesIO(archive)) as unit:
        compiled = {file: unit.read(file).decode() for file in unit.namelist() if file.endswith(COMPILED)}
    assert compiled and {file: divisions(text) for file, text in compiled.items() if divisions(text)} == {}


@pytest.mark.parametrize("template", ["{{ x }}", "{{ [x]|join(', ') }}", "{{ [x, 1]|join }}"])
def test_a_template_refuses_a_fraction(template: str) -> None:
    with pytest.raises(TypeError, match="193/500 is a fraction"):
        environment().from_string(template).render(x=Fraction(193, 500))
    assert Literals(SINGLE).number(Fraction(-1, 4)) == "-0.25f"
