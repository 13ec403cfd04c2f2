"""Drives in print: the table of `show`, its JSON, and the remarks of the page on which a machine moves."""

from __future__ import annotations

import json

import symoro_elastic as se
from symoro_elastic.machine.views import drives_json, drives_table
from tests.command_line import EXAMPLES, run

AXIS = EXAMPLES / "ball_screw.toml"


def test_show_says_kind_gains_and_what_comes_late() -> None:
    printed = run("show", AXIS).output
    assert "drives" in printed and "cascade" in printed and "tuned" in printed
    (row,) = drives_table(se.read(AXIS)).rows
    assert row == ("motor", "cascade", "tuned", "tuned", "tuned", "motor", "lag 2e-4 s, period 1.25e-4 s")
    assert json.loads(run("show", AXIS, "--json").output)["drives"] == drives_json(se.read(AXIS))


def test_gains_have_the_unit_of_their_joint() -> None:
    given = {
        "motor_x": {"Kp": 5000, "Kv": 20, "measured": "tool.x", "filters": [{"notch": 300, "depth": 0.1, "width": 0.5}]}
    }
    machine = se.read({"name": "m", "joints": [{"name": "motor_x", "kind": "motor", "sigma": 1, "r": "x"},
                                               {"name": "tool", "antecedent": "motor_x", "kind": "fixed", "sigma": 2}],
                       "bodies": {"motor_x": {"mass": 1}}, "drives": given})  # fmt: skip
    (row,) = drives_table(machine).rows
    assert row[2:6] == ("5000 N s/m", "-", "20 1/s", "tool.x") and row[6] == "notch 300 Hz"
    assert drives_json(se.read({"name": "m", "joints": [{"name": "a", "kind": "motor", "sigma": 1, "r": "x"}]})) == {}


def test_the_page_says_the_drives() -> None:
    assert "drive of motor: cascade, Kp tuned, Tn tuned, Kv tuned, measured: motor" in se.view(AXIS).html
