"""Limits of joints and tolerances of parameters: read as they stand, written so that they are read back, or refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.limits import LIMITED, JointLimits, Limits, Range
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene

ROWS = """name = "m"
joints = [
  { name = "rail",   kind = "motor",   sigma = 1, r = "q1" },
  { name = "gear",   kind = "elastic", sigma = 0, theta = "q2 + pi/2" },
  { name = "follow", kind = "coupled", sigma = 0, theta = "2*q2" },
  { name = "swing",  kind = "passive", sigma = 0, theta = "q4" },
  { name = "tool",   kind = "fixed" },
]
[springs]
gear = { stiffness = "k" }
"""
GIVEN = """
[parameters]
k = { value = 1e6, tolerance = "10 %" }
L = { value = "350 mm", tolerance = "2 mm" }
n = { value = -4, tolerance = 0.5 }
plain = 3
[limits]
rail  = { position = [-0.4, "400 mm"], velocity = 2, acceleration = "20 m/s2", torque = ["-2 kN", 3000] }
gear  = { position = "90 deg", torque = 15 }
swing = { velocity = [-1, "pi/2"] }
"""
K = "[parameters]\nk = 1\n"


def machine(tables: str = GIVEN) -> DescribedMachine:
    return toml.read(ROWS + tables, "m.toml")


def test_numbers_stand_for_both_ways_and_units_for_si_units() -> None:
    half_turn = np.pi / 2
    assert machine().limits == Limits(
        {
            "rail": JointLimits(Range(-0.4, 0.4), Range(-2, 2), Range(-20, 20), Range(-2000, 3000)),
            "gear": JointLimits(position=Range(-half_turn, half_turn), torque=Range(-15, 15)),
            "swing": JointLimits(velocity=Range(-1, half_turn)),
        },
        {"k": Range(0.9e6, 1.1e6), "L": Range(0.35 - 0.002, 0.35 + 0.002), "n": Range(-4.5, -3.5)},
    )


@pytest.mark.parametrize("form", [toml, par])
def test_what_is_written_is_read_back(form: object) -> None:
    written = form.write(machine())  # type: ignore[attr-defined]
    assert form.read(written, "m.par").limits == machine().limits  # type: ignore[attr-defined]


NUMBERS = st.floats(-1e20, 1e20).filter(lambda x: x == 0 or abs(x) > 1e-20)
RANGES = st.tuples(NUMBERS, NUMBERS).map(lambda ends: Range(*sorted(ends)))


@pytest.mark.thorough
@given(st.fixed_dictionaries({}, optional=dict.fromkeys(LIMITED, RANGES)))
@settings(max_examples=100)
def test_all_ranges_of_joints_survive(ranges: dict[str, Range]) -> None:
    limits = Limits({"rail": JointLimits(**ranges)} if ranges else {})
    written = toml.write(replace(machine(K), limits=limits))
    assert toml.read(written, "m.toml").limits == limits


@pytest.mark.thorough
@given(st.floats(1e-9, 1e9), st.floats(1e-3, 200), st.booleans(), st.booleans())
@settings(max_examples=200)
def test_all_tolerances_survive(value: float, tolerance: float, in_percent: bool, negative: bool) -> None:
    value = -value if negative else value
    given = f'"{tolerance!r} %"' if in_percent else repr(tolerance * abs(value))
    first = machine(f"[parameters]\nk = {{ value = {value!r}, tolerance = {given} }}\n")
    before, after = (one.limits.parameters["k"] for one in (first, toml.read(toml.write(first), "m.toml")))
    ulp = math.ulp(max(abs(before.low), abs(before.high)))  # a width is one rounding away from both ends
    assert abs(after.low - before.low) <= ulp and abs(after.high - before.high) <= ulp


def test_percentages_are_written_as_they_stand() -> None:
    written = toml.write(machine())
    assert 'k     = { value = 1e6, tolerance = "10 %" }' in written
    assert 'L     = { value = 0.35, unit = "m", tolerance = 0.002 }' in written
    assert "plain = 3\n" in written


def test_dictionaries_give_the_same_machine() -> None:
    limits = {"rail": {"position": (-0.4, 0.4), "velocity": 2, "torque": np.array([-1.0, 2.0])}}
    rows = [{"name": "rail", "kind": "motor", "sigma": 1, "r": "q1"}]
    parameters = {"L": {"value": 2.0, "tolerance": "5 %"}}
    body = {"rail": {"mass": "L", "center_of_mass": [0, 0, 0]}}
    of = se.read({"name": "m", "joints": rows, "bodies": body, "parameters": parameters, "limits": limits})
    assert of.limits.joints["rail"] == JointLimits(Range(-0.4, 0.4), Range(-2, 2), None, Range(-1, 2))
    assert of.limits.parameters == {"L": Range(1.9, 2.1)}


REFUSED = {
    "joint": ("rial = { velocity = 2 }", "limits: no joint 'rial'; did you mean 'rail'?"),
    "key": ("rail = { speed = 2 }", "limits, rail, speed: no such key here; there are: acceleration, position, torque"),
    "reversed": ("rail = { position = [2, -1] }", "limits, rail, position: the low end, 2, is above the high one, -1"),
    "one-sided": ("rail = { position = [-1] }", "limits, rail, position: has 1 entries, expected 2"),
    "negative": (
        "rail = { velocity = -2 }",
        "limits, rail, velocity: -2 is negative: give the largest value both ways",
    ),
    "infinite": ("rail = { velocity = inf }", "limits, rail, velocity: inf is not finite"),
    "half infinite": ("rail = { position = [0, inf] }", "limits, rail, position: inf is not finite"),
    "nan": ("rail = { torque = nan }", "limits, rail, torque: nan is not finite"),
    "huge": ("rail = { torque = 1e60 }", "limits, rail, torque: 1e+60 is out of range"),
    "text": ('rail = { torque = "k" }', "limits, rail, torque: 'k' is a name: only numbers"),
    "truth": ("rail = { torque = true }", "limits, rail, torque: must be a number"),
    "unit": ('rail = { position = "3 deg" }', "limits, rail, position: '3 deg' is in rad, where m is needed"),
    "unit of a rate": ('gear = { velocity = "3 m/s" }', "limits, gear, velocity: '3 m/s' is in m/s, where rad/s is"),
    "fixed": ("tool = { velocity = 1 }", "limits, tool, velocity: a fixed frame does not move: leave it out"),
    "coupled": (
        "follow = { position = 1 }",
        "limits, follow, position: a coupled joint has no variable of its own: lim",
    ),
    "passive": ("swing = { torque = 1 }", "limits, swing, torque: a passive joint has neither a motor nor a spring"),
    "no table": ("rail = 3", "limits, rail: must be a table"),
}
WRONG = {
    "no value": ('k = { tolerance = "1 %" }', "parameters, k, tolerance: it has no value, so no tolerance"),
    "zero": ("k = { value = 2, tolerance = 0 }", "parameters, k, tolerance: 0.0 of 2 is not above zero"),
    "of zero": ('k = { value = 0, tolerance = "5 %" }', "parameters, k, tolerance: 5 % of 0 is not above zero"),
    "negative": ("k = { value = 2, tolerance = -1 }", "parameters, k, tolerance: -1.0 of 2 is not above zero"),
    "infinite": ("k = { value = 2, tolerance = inf }", "parameters, k, tolerance: inf is not finite"),
    "text": ('k = { value = 2, tolerance = "few %" }', "parameters, k, tolerance: 'few %' is not a percentage"),
    "nothing": ('k = { value = 2, tolerance = "%" }', "parameters, k, tolerance: '%' is not a percentage"),
    "unit": (
        'k = { value = 2, unit = "m", tolerance = "1 deg" }',
        "parameters, k, tolerance: '1 deg' is in rad, where m",
    ),
    "key": (
        'k = { value = 2, tolerence = "1 %" }',
        "parameters, k, tolerence: no such key here; did you mean 'toleranc",
    ),
}


@pytest.mark.parametrize(("line", "why"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_limit_is_refused_by_its_key(line: str, why: str) -> None:
    with pytest.raises(InputError) as error:
        machine(f"{K}[limits]\n{line}\n")
    assert str(error.value).startswith(f"m.toml: {why}") and "\n" not in str(error.value)


@pytest.mark.parametrize(("line", "why"), WRONG.values(), ids=WRONG)
def test_what_is_no_tolerance_is_refused_by_its_key(line: str, why: str) -> None:
    with pytest.raises(InputError) as error:
        machine(f"[parameters]\n{line}\n")
    assert str(error.value).startswith(f"m.toml: {why}") and "\n" not in str(error.value)


def test_what_holds_a_coupled_joint_is_named() -> None:
    with pytest.raises(InputError, match=r"limit gear$"):
        machine(f"{K}[limits]\nfollow = {{ velocity = 1 }}\n")


def test_joints_of_loops_have_limits_and_cut_joints_have_none() -> None:
    """Also those whose variables follow from the loop: they move by a variable of the file."""
    text = toml.write(se.read("examples/four_bar.par"))
    of = toml.read(text, "m.toml")
    assert of.dependent
    for j in of.dependent:
        limited = f"{text}\n[limits]\n{of.joint(j).name} = {{ position = 1 }}\n"
        assert toml.read(limited, "m.toml").limits.of(of.joint(j).name).position == Range(-1, 1)
    cut = of.joint(of.loops[0].cut).name
    with pytest.raises(InputError, match=f"limits, {cut}, velocity: it closes a loop"):
        toml.read(f"{text}\n[limits]\n{cut} = {{ velocity = 1 }}\n", "m.toml")


def test_what_does_not_move_any_more_is_not_written() -> None:
    """Limits of a joint that a scene holds: the machine is written without them, and is read."""
    from symoro_elastic.machine.formula import ZERO

    held = restrict(machine(), Scene(locked={"rail": ZERO}))
    assert {*toml.read(toml.write(held), "m.toml").limits.joints} == {"gear", "swing"}


@pytest.mark.parametrize("ends", [(1.0, 0.0), (0.0, np.inf), (np.nan, 1.0)])
def test_no_range_is_made_of_what_is_none(ends: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match=r"is above|is not finite"):
        Range(*ends)
