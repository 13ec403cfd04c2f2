"""What generated code says of its guarantees, and the functions that tell whether arguments are in the box."""

from __future__ import annotations

import ctypes
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.codegen.compile import compile_library
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.verification.implementations import import_package
from tests.command_line import run

PENDULUM = {
    "name": "pendulum",
    "gravity": [0, "-g", 0],
    "joints": [{"name": "hinge", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}],
    "parameters": {"m": {"value": 2, "tolerance": "10 %"}, "g": 9.81},
    "bodies": {"hinge": {"mass": "m", "center_of_mass": [0.5, 0, 0], "inertia": [0.1, 0.1, 0.1]}},
    "limits": {"hinge": {"velocity": 1, "acceleration": 1, "torque": 1}},
}
INSIDE = {"q": [3.0], "qd": [1.0], "tau": [-1.0], "p": [1.9, 9.81]}


def changed(**values: list[float]) -> dict[str, list[float]]:
    return INSIDE | values


CALLS = {
    "at its ends": (INSIDE, True),
    "beyond a turn": (changed(q=[3.2]), False),
    "a velocity counts only where a result depends on it": (changed(qd=[2.0]), True),
    "too large a torque": (changed(tau=[np.nextafter(1.0, 2)]), False),
    "too heavy": (changed(p=[2.3, 9.81]), False),
    "another weight": (changed(p=[2.0, 9.8]), False),
    "no number": (changed(q=[np.nan]), False),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("guaranteed")
    se.generate(PENDULUM, "direct_dynamics", out=out, certify=True, precisions=["double", "single"])
    return out / "pendulum"


@pytest.fixture(scope="module")
def module(folder: Path) -> ModuleType:
    texts = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.py")}
    return import_package(texts, folder.parent / "numpy")


@pytest.mark.sampled(5)
@pytest.mark.parametrize(("call", "inside"), CALLS.values(), ids=CALLS)
def test_numpy_tells_what_is_in_the_box(module: ModuleType, call: dict[str, list[float]], inside: bool) -> None:
    assert bool(module.direct_dynamics_in_box(**call)) is inside


def test_states_are_stacked(module: ModuleType) -> None:
    q = np.array([[0.0], [4.0], [1.0]])
    assert list(module.direct_dynamics_in_box(q, [0.0], [0.5])) == [True, False, True]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(("call", "inside"), CALLS.values(), ids=CALLS)
def test_c_tells_the_same(
    folder: Path, tmp_path: Path, precision: str, call: dict[str, list[float]], inside: bool
) -> None:
    """In single precision parameters are what arrays hold: 9.81 as a float."""
    end, real = ("", ctypes.c_double) if precision == "double" else ("_single", ctypes.c_float)
    files = {f"pendulum{end}.{kind}": (folder / f"pendulum{end}.{kind}").read_text(encoding="utf-8") for kind in "ch"}
    library = compile_library(files, tmp_path)
    function = getattr(ctypes.CDLL(str(library)), f"pendulum_direct_dynamics{'_f32' if end else ''}_in_box")
    rounded = call == CALLS["too large a torque"][0] and precision == "single"
    arrays = [(real * len(call[name]))(*call[name]) for name in ("q", "qd", "tau", "p")]
    assert function(*arrays) == int(inside or rounded)


def test_the_header_says_what_is_guaranteed_and_what_it_rests_on(folder: Path) -> None:
    text = " ".join((folder / "pendulum.h").read_text(encoding="utf-8").replace("*", " ").split())
    (certificate,) = se.certify(PENDULUM, "direct_dynamics").certificates
    for said in (
        f"Guarantees in box {certificate.box.digest}, double precision",
        "m: 1.8 to 2.2",
        "qdd[hinge]: -",
        "proven",
        "o divisor" if certificate.pivots else "It divides by nothing that moves",
        "not with -ffast-math. Outside of the box nothing is claimed.",
    ):
        assert said in text, said


def test_without_a_box_nothing_is_said(tmp_path: Path) -> None:
    se.generate(PENDULUM, "direct_dynamics", out=tmp_path)
    for path in (tmp_path / "pendulum").iterdir():
        text = path.read_text(encoding="utf-8")
        assert "in_box" not in text and "uarantee" not in text


def test_nothing_is_written_without_limits(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="limits, hinge: has no torque"):
        se.generate({**PENDULUM, "limits": {}}, "direct_dynamics", out=tmp_path / "new", certify=True)
    assert not (tmp_path / "new").exists()


def test_the_command_writes_it(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.toml"
    se.write(se.read(PENDULUM), path)
    run("generate", path, "--model", "inverse_dynamics", "--certify", "--out", tmp_path / "out")
    assert "inverse_dynamics_in_box" in (tmp_path / "out" / "pendulum" / "pendulum.h").read_text(encoding="utf-8")
