"""Ordinary names of a machine: generated code avoids a clash with its own, and users see their names."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.local_names import with_local_names
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.codegen.targets import TARGETS
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.generation.pipeline import programs, verify
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import free_name, why_reserved
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS
from tests.generated_code import imported

VARIABLES = ("c", "p", "b", "T", "angle")
PARAMETERS = (
    *("x", "t", "k", "n", "i", "s", "A", "H", "M", "D", "K", "E", "V", "f", "h", "P", "J", "X", "Y", "sine", "cosine"),
    *("sign", "stride", "live", "spill", "states", "numbers", "angles", "LOAD", "STORE", "JOINTS", "PARAMETERS"),
    *("parameters", "model", "program", "constants", "first", "load_lanes", "c_", "p_", "arm_sincos", "ARM_JOINTS"),
    *("ARM_P_x", "np", "math", "values"),
)
SOME = (
    "direct_dynamics",
    "inverse_dynamics",
    "inertia_matrix",
    "geometric_model",
    "jacobian",
    "energy",
    "linearization",
)


def arm(variables: tuple[str, ...], parameters: tuple[str, ...]) -> Machine:
    """Five joints with friction, a spring and a parameter in every cell, drawn from the names in turn."""
    names = iter([*parameters, *(f"other{k}" for k in range(100))])
    rows, bodies = [], []
    for j, variable in enumerate(variables, start=1):
        kind, cell = ("elastic" if j == 3 else "motor"), ("r" if j == 4 else "theta")
        rows.append(
            f'{{ name = "{variable}", kind = "{kind}", sigma = {int(j == 4)}, alpha = "pi/{j + 1}", '
            f'd = "{next(names)}", {cell} = "{variable}" }}'
        )
        body = ", ".join(f'"{next(names)}"' for _ in range(3))
        inertia = ", ".join(f'"{next(names)}"' for _ in range(3))
        bodies.append(f'{variable} = {{ mass = "{next(names)}", center_of_mass = [{body}], inertia = [{inertia}] }}')
    used = [*parameters, *(f"other{k}" for k in range(100))]
    text = "\n".join(
        [
            *('name = "arm"', 'gravity = [0, 0, "-g"]', "joints = [", ",\n".join(rows), "]", "[parameters]"),
            *(f"{name} = {1 + 0.1 * (k % 7)}" for k, name in enumerate([*used, "g", "stiff"])),
            *("[bodies]", *bodies, "[springs]", f'{variables[2]} = {{ stiffness = "stiff", damping = 2 }}'),
            *("[friction]", f"{variables[0]} = {{ viscous = 1, coulomb = 0.5 }}"),
        ]
    )
    machine = toml.read(text, "arm.toml")
    check(machine, reserved_words(), MODELS)
    return machine


@pytest.fixture(scope="module")
def hostile() -> Machine:
    return arm(VARIABLES, PARAMETERS)


@pytest.fixture(scope="module")
def plain() -> Machine:
    return arm(("q1", "q2", "q3", "q4", "q5"), tuple(f"v{k}" for k in range(len(PARAMETERS))))


def test_ordinary_names_are_free() -> None:
    words = reserved_words()
    assert [name for name in (*VARIABLES, *PARAMETERS) if why_reserved(name, words)] == []


@pytest.mark.thorough
def test_code_with_these_names_is_right(hostile: Machine) -> None:
    assert verify(hostile, Scene(models=SOME)).ok


@pytest.mark.sampled(1000)
@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
@pytest.mark.parametrize("precision", PRECISIONS)
def test_c_with_these_names_compiles_without_a_warning(hostile: Machine, precision: str, tmp_path: Path) -> None:
    package = programs(hostile, Scene(models=("direct_dynamics", "jacobian", "linearization"))).package
    files = TARGETS["c-batch"].render(package, [PRECISIONS[precision]])
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    strict = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror", "-fsyntax-only"]
    sources = [name for name in files if name.endswith(".c")]
    run = subprocess.run(["gcc", *strict, *sources], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[:2000]


def test_numpy_gives_the_numbers_of_plain_names(hostile: Machine, plain: Machine, tmp_path: Path) -> None:
    q, qd, tau = np.random.default_rng(0).uniform(-1, 1, (3, 5))
    found = []
    for machine, folder in ((hostile, tmp_path / "hostile"), (plain, tmp_path / "plain")):
        folder.mkdir()
        package = programs(machine, Scene(models=("direct_dynamics",))).package
        for name, text in TARGETS["numpy"].render(package, ()).items():
            (folder / name).write_text(text)
        found.append(imported(folder))
    ours, theirs = (module.direct_dynamics(q, qd, tau[:4]) for module in found)
    assert np.allclose(ours, theirs, rtol=1e-12, atol=0)
    assert {"c", "p"} <= {*found[0].JOINTS} and {*PARAMETERS} <= {*found[0].PARAMETERS}
    assert found[0].parameters(x=7.0)[found[0].PARAMETERS.index("x")] == 7.0


def test_a_package_without_a_clash_stays_as_it_is(plain: Machine) -> None:
    package = programs(plain, Scene()).package
    assert with_local_names(package, {"c", "p"}) is package


@pytest.mark.parametrize(
    "word", ["int", "lambda", "NULL", "M_PI", "H5", "sin", "direct_dynamics", "a__b", "my-name", "1a"]
)
def test_words_of_languages_stay_refused_with_a_name_that_is_free(word: str) -> None:
    words = reserved_words()
    assert why_reserved(word, words) is not None
    free = free_name(word, words)
    assert why_reserved(free, words) is None and word.strip("_")[1] in free
