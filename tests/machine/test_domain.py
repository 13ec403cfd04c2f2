"""Cells that have a value at some positions only: other positions are drawn, or the cell is named."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.checks.degenerate import degeneracies
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import given_state
from symoro_elastic.numerics.verification.states import extreme_states, moderate_states
from symoro_elastic.symbolic.arithmetic import FLOATS, multiprecision
from tests.command_line import run

CAM = """name = "cam"
joints = [
  { name = "a", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" },
  { name = "b", antecedent = 0, kind = "coupled", sigma = 0, theta = "FORMULA" },
]
[bodies]
a = { mass = 1, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.1, 0.1] }
b = { mass = 1, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.1, 0.1] }
"""
INSIDE = {
    "sqrt(q1)": lambda q: q > 0,
    "sqrt(1 - q1^2)": lambda q: abs(q) < 1,
    "sqrt(q1 - 2)": lambda q: q > 2,
    "1/q1": lambda q: q != 0,
}


def cam(formula: str) -> Machine:
    return toml.read(CAM.replace("FORMULA", formula), "cam.toml")


@pytest.mark.parametrize("formula", INSIDE)
def test_states_are_where_cells_have_values(formula: str) -> None:
    machine = cam(formula)
    assert degeneracies(machine, False) == []
    for states in (moderate_states(machine, 20), extreme_states(machine, 20)):
        assert all(INSIDE[formula](float(q)) for q in states.q[:, 0])


@pytest.mark.sampled(2)
@pytest.mark.parametrize("formula", ["sqrt(q1)", "sqrt(1 - q1^2)"])
def test_such_machines_are_generated_and_checked(formula: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("cam.toml").write_text(CAM.replace("FORMULA", formula))
    assert "every error is within its bound" in run("check", "cam.toml").output
    run("show", "cam.toml")
    run("generate", "cam.toml", "--out", "generated")


def test_a_cell_that_has_a_value_nowhere_is_refused_by_joint_and_key() -> None:
    said = r"joint 2 \(b\), theta: 'sqrt\(-2 - q1\^2\)' has no value and slope at any of 200 random positions"
    with pytest.raises(InputError, match=said):
        degeneracies(cam("sqrt(-2 - q1^2)"), False)


def test_a_position_without_value_or_slope_is_refused_by_joint_and_key() -> None:
    motion = EquationsOfMotion(cam("sqrt(q1)"))
    for at in ({"a": -1.0}, {}):
        with pytest.raises(InputError, match=r"joint 2 \(b\), theta: 'sqrt\(q1\)' has no value and slope at a=.*--at"):
            given_state(motion, at)


def test_the_root_of_a_negative_number_is_nan_in_any_digits() -> None:
    for arithmetic in (FLOATS, multiprecision(50)):
        root = arithmetic.operations["sqrt"]
        assert math.isnan(float(root(arithmetic.number(-1))))
        assert root(arithmetic.number(4)) == 2
