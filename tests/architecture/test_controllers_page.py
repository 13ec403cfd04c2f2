"""Commands and examples of docs/controllers.md: Structured Text is run, pins of HAL are those of the component."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.targets.linuxcnc import render_linuxcnc
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.codegen.targets.st import render_st
from symoro_elastic.formats import read_machine
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import import_package, numpy_model
from tests.documented_pages import beside_examples, wrong_blocks
from tests.golden import ROOT
from tests.references.controlled import controlled
from tests.structured_text import Array, Runs, by_matiec, by_strucpp, interpreted, needs_matiec, needs_strucpp

PAGE = (ROOT / "docs" / "controllers.md").read_text(encoding="utf-8")
SET = {"x": 300.0, "vx": 500.0, "ax": 2000.0}


def block(language: str, number: int = 0) -> str:
    found = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert len(found) == (2 if language == "iecst" else 1)
    return str(found[number])


def example_of_st() -> str:
    """The generated file, and the program of the page as a block whose set points are inputs."""
    package = programs(read_machine(ROOT / "examples/two_axis.toml")[0], Scene(models=("inverse_dynamics",))).package
    body = block("iecst").replace("PROGRAM", "FUNCTION_BLOCK")
    body = body.replace("    x, vx, ax, force_x : LREAL;", "")
    inputs = (
        "  VAR_INPUT\n    x, vx, ax : LREAL;\n  END_VAR\n  VAR_OUTPUT\n    force : two_axis_motors;\n  END_VAR\n  VAR\n"
    )
    body = body.replace("  VAR\n", inputs, 1).replace("force_x", "force[0]")
    return render_st(package)["two_axis.st"] + "\n" + body


def wanted(folder: Path) -> Array:
    package = programs(read_machine(ROOT / "examples/two_axis.toml")[0], Scene(models=("inverse_dynamics",))).package
    module = import_package(render_numpy(package), folder)
    q, qd = np.zeros(12), np.zeros(12)
    q[4], qd[4] = 0.001 * SET["x"], 0.001 * SET["vx"]
    return np.asarray(module.inverse_dynamics(q, qd, np.array([0.001 * SET["ax"], 0.0]))[0])


def states() -> dict[str, Array]:
    return {name: np.array([[value]]) for name, value in SET.items()}


@pytest.mark.thorough
def test_commands_print_what_is_shown(tmp_path: Path) -> None:
    with beside_examples(tmp_path):
        assert wrong_blocks(PAGE) == {}


def test_examples_have_about_ten_lines() -> None:
    assert max(len(block("iecst", k).splitlines()) for k in (0, 1)) <= 14
    assert len(block("hal").splitlines()) <= 10


def test_the_program_finds_the_force_of_the_motor(tmp_path: Path) -> None:
    found = interpreted(example_of_st(), "feed_forward", states())["force"]
    assert found[0, 0] == wanted(tmp_path)[0] != 0


@pytest.mark.thorough
@pytest.mark.parametrize(
    "compiler", [pytest.param(by_strucpp, marks=needs_strucpp), pytest.param(by_matiec, marks=needs_matiec)]
)
def test_compilers_take_the_program(compiler: object, tmp_path: Path) -> None:
    run = compiler(example_of_st(), tmp_path / "st")  # type: ignore[operator]
    assert run("feed_forward", states())["force"][0, 0] == wanted(tmp_path)[0]


def controller_of_st() -> str:
    """The generated controller, and the program of the page as a block with inputs and a result."""
    package = programs(controlled(), Scene(models=("control",))).package
    body = block("iecst", 1).replace("PROGRAM", "FUNCTION_BLOCK").replace("q, qd, r, rd, rdd, hold, torque", "hold")
    given = "  VAR_INPUT\n    q, qd, r, rd, rdd : ball_screw_motors;\n  END_VAR\n"
    given += "  VAR_OUTPUT\n    torque : ball_screw_motors;\n  END_VAR\n"
    return render_st(package)["ball_screw.st"] + "\n" + body.replace("  VAR\n", f"{given}  VAR\n", 1)


@pytest.mark.parametrize(
    "run",
    [
        pytest.param(lambda made, _: partial(interpreted, made), id="interpreter"),
        pytest.param(by_strucpp, marks=[needs_strucpp, pytest.mark.thorough], id="strucpp"),
        pytest.param(by_matiec, marks=[needs_matiec, pytest.mark.thorough], id="matiec"),
    ],
)
def test_the_program_of_an_axis_is_the_controller(run: Callable[[str, Path], Runs], tmp_path: Path) -> None:
    code = numpy_model(controlled(), ("control", "control_start"))
    drawn = np.random.default_rng(3).normal(size=(20, 5, 1))
    zc = code.control_start(*drawn[0, 2:], [0.0])
    given = dict(zip(("q", "qd", "r", "rd", "rdd"), drawn.transpose(1, 0, 2), strict=True))
    found = run(controller_of_st(), tmp_path)("drive_axis", given)["torque"]
    for k, row in enumerate(drawn):
        u, zc = code.control(*row, [0.0], zc)
        assert np.array_equal(found[k], u)


def test_pins_and_joints_are_those_of_the_components() -> None:
    models = ("inverse_dynamics", "geometric_model", "inverse_geometric_model")
    package = programs(read_machine(ROOT / "examples/puma560_measured.toml")[0], Scene(models=models)).package
    files = render_linuxcnc(package)
    pins = {}
    for name, text in files.items():
        component = name.removesuffix(".comp").replace("_", "-")
        for pin, size in re.findall(r"^pin \w+ \w+ ([\w-]+)#?(?:\[(\d+)\])?", text, re.MULTILINE):
            pins |= {f"{component}.{pin}{k}": None for k in range(int(size))} if size else {f"{component}.{pin}": None}
    used = re.findall(r"puma560-measured-\w+\.[\w-]+", block("hal"))
    assert len(used) >= 5
    assert [pin for pin in used if pin not in pins] == []
    assert f"loadrt {next(iter(files)).removesuffix('.comp')}" in block("hal")
    assert "KINEMATICS = puma560_measured_kins\nJOINTS = 6" in block("ini")
    assert block("ini").startswith("[KINS]")
