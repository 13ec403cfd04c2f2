"""Angles that files hold as rounded decimals of parts of a turn are these parts."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.generation.pipeline import operation_counts
from symoro_elastic.machine.scene import Scene
from tests.command_line import refused, run

EXAMPLES = Path(__file__).parents[2] / "examples"
LINE = "angles are read as multiples of pi/12, off which rounding left them by"


def arm(alpha: object, theta: str = "q2") -> dict[str, object]:
    rows = [
        {"name": "a", "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "b", "kind": "motor", "sigma": 0, "alpha": alpha, "theta": theta, "d": "L", "variable": "q2"},
    ]
    return {"name": "arm", "gravity": [0, 0, -9.81], "joints": rows, "parameters": {"L": 1.5707963268}}


def cells(machine: se.Machine) -> tuple[str, str, float | None]:
    row = machine.joint(2)
    return str(row.alpha), str(row.theta), row.d.known_value({"L": 1.5707963268})


@pytest.mark.parametrize("ending", ["par", "toml"])
def test_models_are_those_of_exact_angles(ending: str, tmp_path: Path) -> None:
    """The robot that SYMORO writes with fourteen decimals costs what it costs with pi/2, and one line says so."""
    exact, rounded = tmp_path / f"puma560.{ending}", tmp_path / f"rounded.{ending}"
    run("convert", str(EXAMPLES / "puma560.par"), str(exact))
    text = exact.read_text(encoding="utf-8")
    rounded.write_text(text.replace('"-pi/2"', '"-1.57079632679000"').replace("pi/2", "1.57079632679000"))
    warned: list[str] = []
    machine, other = se.read(exact, base=True), se.read(rounded, base=True, warn=warned.append)
    assert len(warned) == 1 and LINE in warned[0] and "4.9e-12 rad" in warned[0]
    counts = [operation_counts(x, Scene(("inverse_dynamics",))) for x in (machine, other)]
    assert counts[0] == counts[1] and other.joints == machine.joints


def test_tables_of_robots_are_read_likewise(tmp_path: Path) -> None:
    table = "type,theta,d,a,alpha\nR,0,0.3,0.1,{0}\nR,-{0},0,0.2,0\nR,0.5,0,0.1,0\n"
    joints, lines = [], []
    for name, angle in (("exact", "pi/2"), ("rounded", "1.5707963268")):
        file = tmp_path / f"{name}.csv"
        file.write_text(table.format(angle), encoding="utf-8")
        machine = se.read(file, warn=lines.append)
        joints.append([(row.alpha, row.theta, row.d, row.r) for row in machine.joints])
    assert joints[0] == joints[1] and sum("2 angles are read as multiples" in line for line in lines) == 1


@given(st.integers(-48, 48), st.integers(9, 15), st.floats(-1.0, 1.0))
def test_decimals_of_parts_of_a_turn_are_these_parts(twelfths: int, digits: int, beside: float) -> None:
    """Alone, and added to a variable; what stands elsewhere, and what is farther off, is as it is written."""
    angle = twelfths * math.pi / 12
    text = f"{angle:.{digits}f}"
    machine = se.read(arm(text, f"q2 - {text.removeprefix('-')}"), warn=lambda _: None)
    alpha, theta, d = cells(machine)
    known = {"q2": 0.0}
    assert machine.joint(2).alpha.known_value(known) == pytest.approx(angle, abs=4e-15)
    assert machine.joint(2).theta.known_value(known) == pytest.approx(-abs(angle), abs=4e-15)
    is_decimal = twelfths and abs(float(text) - angle) > math.ulp(angle)
    assert not is_decimal or ("pi" in alpha and "pi" in theta)
    assert d == 1.5707963268
    off = angle + math.copysign(1.1e-9 + abs(beside) * 0.1, beside)
    assert se.read(arm(off), warn=lambda _: None).joint(2).alpha.known_value({}) == off


def test_only_what_is_added_is_an_angle() -> None:
    assert str(se.read(arm(0, "1.5707963268*q1 + q2"), warn=lambda _: None).joint(2).theta) == "1.5707963268*q1"


def test_snap_is_for_all_files(tmp_path: Path) -> None:
    file, target = tmp_path / "arm.toml", tmp_path / "snapped.toml"
    se.write(se.read(arm(1.5708), warn=lambda _: None), file)
    assert "taken as written; write pi/2 if meant" in run("show", str(file)).stderr
    run("convert", str(file), str(target), "--snap", "1e-4")
    assert 'alpha = "pi/2"' in target.read_text(encoding="utf-8")
    assert "is not a tolerance" in refused("convert", str(file), str(target), "--snap", "0.1", "--force")
