"""Origins and axes of joints as `show` prints them."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.machine.formats import read_machine
from symoro_elastic.machine.machine import Joint, Kind, Parameter
from symoro_elastic.models.joint_axes import placed_machine
from symoro_elastic.report.tables import axes_table
from tests.command_line import EXAMPLES, refused, run
from tests.compiled_models import cell
from tests.references.multiprecision import geometric_model
from tests.references.random_machines import random_machine
from tests.vibration.machines import machine_of, spring

TWO_AXIS = EXAMPLES / "two_axis.toml"


@pytest.mark.parametrize("seed", range(12))
def test_origins_and_axes_are_those_of_a_reference(seed: int) -> None:
    machine = random_machine(seed, joints=8, symbolic=seed % 2 == 0)
    q = np.random.default_rng(seed).uniform(-2, 2, len(machine.moving)).tolist()
    at = {joint.name: x for joint, x in zip(machine.moving_joints, q, strict=True)}
    found = placed_machine(machine, at)
    assert found.q == at
    for one, T in zip(found.joints, geometric_model(machine, q), strict=True):
        np.testing.assert_allclose(one.origin, [float(T[k][3]) for k in range(3)], atol=1e-13)
        np.testing.assert_allclose(one.axis, [float(T[k][2]) for k in range(3)], atol=1e-13)


def test_springs_are_at_their_neutral_positions() -> None:
    bent = Joint("bent", 0, Kind.ELASTIC, 0, "q1", spring=spring(10, neutral="N1"))
    machine = machine_of("bent", bent, Joint("tip", 1, Kind.FIXED, 2, d=cell(2)))
    known = replace(machine, parameters=(Parameter("N1", cell("pi/2")),))
    assert placed_machine(known, {}).q == {"bent": math.pi / 2}
    np.testing.assert_allclose(placed_machine(known, {}).joints[1].origin, [0, 2, 0], atol=1e-15)
    assert placed_machine(known, {"q1": 0.0}).joints[1].origin == (2, 0, 0)
    unknown = replace(machine, parameters=(Parameter("N1"),))
    assert math.isnan(placed_machine(unknown, {}).q["bent"])


def test_only_what_depends_on_missing_values_is_left_open() -> None:
    cells = {
        str(c.header): list(c.cells)
        for c in axes_table(placed_machine(read_machine(EXAMPLES / "rx90.par")[0], {})).columns
    }
    assert cells["this axis"] == ["z", "-y", "-y", "z", "-y", "z"]
    assert cells["origin x, m"] == ["0", "0", "-", "-", "-", "-"] and cells["y, m"] == ["0"] * 6
    assert cells["z, m"] == ["0", "0", "0", "-", "-", "-"]


def test_show_prints_axes_at_a_position() -> None:
    found = json.loads(run("show", TWO_AXIS, "--json", "--at", "motor_x=0.1", "--at", "q9=0.2").stdout)
    assert found["position"]["motor_x"] == 0.1 and found["position"]["motor_y"] == 0.2
    np.testing.assert_allclose(found["axes"]["tool"]["origin"], [0.1 + 0.15, 0.35 + 0.2 + 0.25, 0], atol=1e-15)
    assert found["axes"]["motor_y"]["axis"] == [0, 1, 0]
    (line,) = (
        x for x in run("show", TWO_AXIS, "--at", "motor_x=0.1").stdout.splitlines() if "motor_y" in x and "along" in x
    )
    assert line.split() == ["9", "motor_y", "0", "0.1", "0.35", "0", "slides", "along", "y"]


@pytest.mark.parametrize("given", ["motor_z=1", "tool=1", "motor_x=1e300", "motor_x=nan"])
def test_positions_that_cannot_be_are_refused(given: str) -> None:
    assert "--at" in refused("show", TWO_AXIS, "--at", given)
