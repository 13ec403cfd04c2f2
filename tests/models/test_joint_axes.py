"""Origins and axes of joints as `show` prints them."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Joint, Kind, Parameter
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.pages.show import axes_table
from tests.analysis.vibration.machines import machine_of, spring
from tests.closed_chains.machines import FILES, machine, situations
from tests.command_line import EXAMPLES, refused, run
from tests.compiled_models import cell
from tests.references.constraint_multipliers import Multipliers
from tests.references.multiprecision import geometric_model
from tests.references.random_machines import random_machine

pytestmark = pytest.mark.sampled(6)

TWO_AXIS = EXAMPLES / "two_axis.toml"


@pytest.mark.parametrize("seed", range(12))
def test_origins_and_axes_are_those_of_a_reference(seed: int) -> None:
    machine = random_machine(seed, joints=8, symbolic=seed % 2 == 0)
    q = np.random.default_rng(seed).uniform(-2, 2, len(machine.independent)).tolist()
    at = {joint.name: x for joint, x in zip(machine.independent_joints, q, strict=True)}
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
    cells = dict(axes_table(placed_machine(read_machine(EXAMPLES / "rx90.par")[0], {})).columns)
    assert cells["this axis"] == ("z", "-y", "-y", "z", "-y", "z")
    assert cells["origin x, m"] == ("0", "0", "-", "-", "-", "-") and cells["y, m"] == ("0",) * 6
    assert cells["z, m"] == ("0", "0", "0", "-", "-", "-")


@pytest.mark.thorough
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


BEYOND = [("ring", 0), ("ring_with_slide", 0), ("ring_with_slide", 1)]
"""States on branches that small steps from the start do not reach: these loops nearly fold on the way, or do."""
PLACED = [(name, k) for name in FILES for k in range(2) if (name, k) not in BEYOND]


@pytest.mark.parametrize(("name", "k"), PLACED)
def test_joints_of_loops_are_where_a_reference_has_them(name: str, k: int) -> None:
    """At positions that the reference assembles in 70 digits; the axis of a cut joint stands still as it turns."""
    described, reference = machine(name), Multipliers(machine(name), situations(name)[k].state)
    at = position(name, k)
    found = placed_machine(described, at)
    assert {name: found.q[name] for name in at} == at
    for one, frame in zip(found.joints, reference.frames, strict=True):
        T = np.array(frame.transform, dtype=float)
        if one.joint.kind is not Kind.CUT or one.joint.sigma == 0:
            np.testing.assert_allclose(one.origin, T[:3, 3], atol=1e-9)
        np.testing.assert_allclose(one.axis, T[:3, 2], atol=1e-9)
    for j in described.with_variable:
        joint = described.joint(j)
        difference = found.q[joint.name] - float(reference.at[str(joint.variable)])
        assert (math.remainder(difference, 2 * math.pi) if joint.sigma == 0 else difference) == pytest.approx(
            0, abs=1e-9
        )


def test_the_next_branch_is_not_taken_for_that_of_the_start() -> None:
    """The ring folds on the way; Newton's method would end on another branch."""
    with pytest.raises(InputError, match="ring cannot close at this position"):
        placed_machine(machine("ring"), position("ring", 0))


def test_loops_are_closed_next_to_a_fold_too() -> None:
    found = {x.joint.name: x for x in placed_machine(machine("ring_with_slide"), position("ring_with_slide", 0)).joints}
    gap = np.subtract(found["slide"].origin, found["slide_end"].origin)
    np.testing.assert_allclose(np.cross(gap, found["slide_end"].axis), 0, atol=1e-10)
    np.testing.assert_allclose(found["slide"].axis, found["slide_end"].axis, atol=1e-10)


def position(name: str, k: int) -> dict[str, float]:
    return dict(
        zip((joint.name for joint in machine(name).independent_joints), situations(name)[k].state.u, strict=True)
    )
