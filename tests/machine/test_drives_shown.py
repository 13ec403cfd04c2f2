"""Drives in print: the table of `show`, its JSON, and the remarks of the page on which a machine moves."""

from __future__ import annotations

import json

import symoro_elastic as se
from symoro_elastic.machine.views import by_first_cell, drives_table
from tests.command_line import EXAMPLES, run

AXIS = EXAMPLES / "ball_screw.toml"


def test_show_says_kind_gains_and_what_comes_late() -> None:
    printed = run("show", AXIS).output
    assert "drives" in printed and "cascade" in printed and "tuned" in printed
    (row,) = drives_table(se.read(AXIS)).rows
    assert row == ("motor", "cascade", "tuned", "tuned", "tuned", "motor", "lag 2e-4 s, period 1.25e-4 s")
    assert json.loads(run("show", AXIS, "--json").output)["drives"] == by_first_cell(drives_table(se.read(AXIS)))


def test_gains_have_the_unit_of_their_joint() -> None:
    given = {
        "motor_x": {"Kp": 5000, "Kv": 20, "measured": "tool.x", "filters": [{"notch": 300, "depth": 0.1, "width": 0.5}]}
    }
    machine = se.read({"name": "m", "joints": [{"name": "motor_x", "kind": "motor", "sigma": 1, "r": "x"},
                                               {"name": "tool", "antecedent": "motor_x", "kind": "fixed", "sigma": 2}],
                       "bodies": {"motor_x": {"mass": 1}}, "drives": given})  # fmt: skip
    (row,) = drives_table(machine).rows
    assert row[2:6] == ("5000 N s/m", "-", "20 1/s", "tool.x") and row[6] == "notch 300 Hz"
    assert (
        by_first_cell(
            drives_table(se.read({"name": "m", "joints": [{"name": "a", "kind": "motor", "sigma": 1, "r": "x"}]}))
        )
        == {}
    )


def test_what_else_a_drive_has_is_shown() -> None:
    """Feed-forward, filters of the set point, current controllers and limits; without them the columns are left out."""
    table = drives_table(se.read(EXAMPLES / "all_keys.toml"))
    assert table.heads[-3:] == ("torque comes", "set point", "limits")
    by_name = {row[0]: row[-3:] for row in table.rows}
    assert by_name["table"] == (
        "current loop 6 V/A, 2e-3 s, back-EMF compensated times 0.8, notch 90 Hz",
        "velocity forward times 0.8, torque of the inverse model forward",
        "current 40 A, voltage 48 V",
    )
    assert by_name["shoulder"][1:] == (
        "low-pass 60 Hz, velocity forward times 0.9, acceleration forward times 0.5",
        "torque 300 N m",
    )
    assert by_name["slide"][1:] == ("mean of 2e-3 s", "torque 2e3 N, windup 0.02 s")
    assert len(drives_table(se.read(EXAMPLES / "two_axis.toml")).heads) == 7


def test_the_page_says_the_drives() -> None:
    assert "drive of motor: cascade, Kp tuned, Tn tuned, Kv tuned, measured: motor" in se.view(AXIS).html
