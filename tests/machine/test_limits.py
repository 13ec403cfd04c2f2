"""Limits in print: with units, of what moves only, and nothing where there are none."""

from __future__ import annotations

import json

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.results import Table
from symoro_elastic.machine.limits import JointLimits, Range, range_of
from symoro_elastic.machine.views import limits_table
from tests.command_line import EXAMPLES, run

TEXT = """name = "m"
joints = [
  { name = "rail", kind = "motor",   sigma = 1, r = "q1" },
  { name = "gear", kind = "elastic", sigma = 0, theta = "q2" },
]
[parameters]
k = { value = 1e6, unit = "N m/rad", tolerance = "10 %" }
[springs]
gear = { stiffness = "k" }
[limits]
gear = { torque = [-15, 20.5] }
rail = { position = [-0.4, "400 mm"], velocity = 2 }
"""


def test_the_table_has_units_by_the_type_of_the_joint_and_the_order_of_the_joints() -> None:
    machine = toml.read(TEXT, "m.toml")
    table = limits_table(machine, "limits")
    assert table.heads == ("joint", "position", "velocity", "acceleration", "torque")
    assert table.rows == [("rail", "-0.4 to 0.4 m", "-2 to 2 m/s", "", ""), ("gear", "", "", "", "-15 to 20.5 N m")]
    shown = machine.parts()
    assert table in shown and "k = 1e6 N m/rad (900000 to 1.1e+06)" in shown


def test_machines_without_limits_have_no_table() -> None:
    shown = se.read(EXAMPLES / "gantry.toml").parts()
    assert [part.title for part in shown if isinstance(part, Table)] == ["gantry"]


def test_show_prints_them_and_gives_them_as_json() -> None:
    """Of a scene that locks the gear, whose limits are those of nothing then."""
    file = str(EXAMPLES / "all_keys.toml")
    printed = run("show", file).output
    assert "slide   0 to 0.4 m" in printed and "gear    " not in printed.split("limits")[1].split("g0 =")[0]
    found = json.loads(run("show", file, "--json").output)["limits"]
    assert found["joints"]["slide"] == {"position": [0.0, 0.4], "velocity": [-0.3, 0.3], "torque": [-200.0, 250.0]}
    assert found["parameters"] == {"L1": [0.2985, 0.3015]} and "gear" not in found["joints"]


def test_ranges_without_room_or_as_far_as_nothing_reaches_are_none() -> None:
    assert range_of(-1.0, 2.0, 10.0) == Range(-1.0, 2.0)
    for low, high in ((0.0, 0.0), (1.0, -1.0), (-10.0, 1.0), (0.0, 10.0), (float("nan"), 1.0), (0.0, float("inf"))):
        assert range_of(low, high, 10.0) is None
    assert 2.0 in Range(-1.0, 2.0) and 2.0001 not in Range(-1.0, 2.0)
    assert not JointLimits() and JointLimits(torque=Range(0.0, 0.0))
