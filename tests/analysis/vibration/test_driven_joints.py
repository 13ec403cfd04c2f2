"""Feed-forward of machines whose motors follow from loops: motions of platforms, against multipliers in 70 digits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.time_series.measurements import read_columns
from symoro_elastic.analysis.vibration.driven_joints import of_motors, with_motors_on_load_joints
from symoro_elastic.analysis.vibration.feed_forward import FeedForward, feed_forward, orders, save_feed_forward, starts
from symoro_elastic.analysis.vibration.reference_trajectory import move
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine, Spring
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from tests.closed_chains.machines import machine as closed_chain
from tests.codegen.test_time_steps import driven_at
from tests.references.closed_chains import State
from tests.references.constraint_multipliers import Multipliers

pytestmark = pytest.mark.sampled(4)

STROKES = {"along_x": 0.04, "along_y": -0.03, "platform": 0.05}
PLACES = (30, 75)
"""Samples that are looked at: motors turn both ways."""


@cache
def delta() -> Machine:
    """A mass hangs from the platform on a spring along the last of its slides."""
    hung = Spring(Formula.parse("5000"), neutral=Formula.parse("-0.01"))
    tool = Joint("tool", 3, Kind.ELASTIC, 1, "dz", body=Body(Formula.parse("0.3")), spring=hung)
    machine = closed_chain("delta")
    return replace(machine, joints=(*machine.joints, tool))


def found(machine: Machine, strokes: dict[str, float], duration: float = 0.1) -> FeedForward:
    degree = max(orders(machine).values()) + 2
    return feed_forward(machine, move(with_motors_on_load_joints(machine), starts(machine), strokes, duration, degree))


@cache
def moved() -> FeedForward:
    return found(delta(), STROKES)


def multipliers(of: FeedForward, k: int) -> Multipliers:
    return Multipliers(of.machine, State(list(of.q[k]), list(of.qd[k]), start_of(of.machine).by_variable))


def accelerations(of: FeedForward, k: int) -> dict[str, float]:
    """Of all own variables under the torques, by joint."""
    at = multipliers(of, k)
    names = [of.machine.joint(j).name for j in of.machine.with_variable]
    return dict(zip(names, at.direct(list(of.tau[k])).astype(float).tolist(), strict=True))


@pytest.mark.thorough
@pytest.mark.parametrize("k", PLACES)
def test_the_platform_accelerates_as_wanted(k: int) -> None:
    """Under the torques alone; positions and velocities of the motors are those of the loops closed in 70 digits.

    Along the spring it is the tool that does: it hangs on a spring that is inverted, by two more derivatives.
    """
    xdd, of = accelerations(moved(), k), moved()
    xdd["platform"] += xdd["tool"]
    assert of.orders == {"along_x": 2, "along_y": 2, "platform": 4} and abs(of.q[k, 3] + 0.01) > 1e-4
    assert of.q[k, 2] + of.q[k, 3] == pytest.approx(of.reference.y["platform"][0, k], abs=1e-15)
    for name, rows in of.reference.y.items():
        assert xdd[name] == pytest.approx(rows[2, k], rel=1e-10, abs=1e-10), name
    at, of_motors = multipliers(of, k), of.following
    motors = [at.chain.own.index(name) for name in at.chain.motors]
    assert of_motors is not None and of.motors == ("arm_1", "arm_2", "arm_3")
    np.testing.assert_allclose(of_motors.x[k], at.x[motors].astype(float), rtol=0, atol=1e-13)
    np.testing.assert_allclose(of_motors.xd[k], at.xd[motors].astype(float), rtol=0, atol=1e-12)


def test_torques_of_more_motors_than_freedoms_are_shared() -> None:
    """By the weights of the file; without, the sum of squares is least, and a line says so."""
    strokes = {"carriage_1": 0.2, "ram": 0.1}
    of, k = found(closed_chain("gantry_rigid"), strokes), PLACES[0]
    wanted, _ = multipliers(of, k).inverse([of.reference.y.get(x, np.zeros((3, 99)))[2, k] for x in _motors(of)])
    np.testing.assert_allclose(of.tau[k], wanted.astype(float), rtol=1e-11, atol=1e-9)
    assert "sum of squares" not in "".join(of.as_json()["notes"])
    plain = replace(of.machine, joints=tuple(replace(row, sharing=ZERO) for row in closed_chain("gantry_rigid").joints))
    even = found(plain, strokes)
    assert even.tau[k, 0] + even.tau[k, 3] == pytest.approx(of.tau[k, 0] + of.tau[k, 3], rel=1e-12)
    assert even.tau[k, 0] == pytest.approx(even.tau[k, 3], rel=1e-12)
    assert "the least sum of squares" in even.as_json()["notes"][0]


def _motors(of: FeedForward) -> list[str]:
    """The motor whose motion each one has: the carriages move together."""
    return ["carriage_1" if name == "carriage_2" else name for name in of.motors]


@pytest.mark.thorough
def test_motors_become_independent_where_loops_then_have_closed_forms() -> None:
    """A beam that is elastic: the motion that is wanted is that of the motors."""
    machine = closed_chain("gantry")
    assert [joint.name for joint in with_motors_on_load_joints(machine).motor_joints] == [
        "carriage_1",
        "cross_slide",
        "ram",
        "carriage_2",
    ]
    of, k = found(machine, {"carriage_1": 0.05, "carriage_2": 0.05}), PLACES[0]
    xdd = accelerations(of, k)
    for name, rows in of.reference.y.items():
        assert xdd[name] == pytest.approx(rows[2, k], rel=1e-9, abs=1e-9), name


@pytest.mark.thorough
def test_what_is_written_and_drawn_holds_joints_and_motors(tmp_path: Path) -> None:
    save_feed_forward(moved(), tmp_path / "move.npz")
    columns = read_columns(tmp_path / "move.npz", delta())
    assert moved().following is not None
    np.testing.assert_array_equal(columns["q_arm_2"], moved().following.x[:, 1])
    np.testing.assert_array_equal(columns["qd_arm_3"], moved().following.xd[:, 2])
    np.testing.assert_array_equal(columns["q_platform"], moved().q[:, 2] + 0.0)
    said = moved().as_json()
    assert said["joints"]["along_x"] == {"order": 2, "given": 6} and set(said["joints"]) == set(STROKES)
    assert set(said["motors"]["arm_1"]) == {"torque", "torque_rms", "velocity"}
    names = [[text.get_text() for text in axis.get_legend().get_texts()] for axis in moved().plot().axes]
    assert names[-1] == ["arm_1", "arm_2", "arm_3"] and {x for each in names[:-1] for x in each} == {*STROKES}


# Refusals


def test_springs_on_which_dependent_motors_act_are_refused() -> None:
    """The beam of a gantry, where the second carriage follows from it."""
    gantry = closed_chain("gantry")
    rows = (replace(row, kind=Kind.PASSIVE) if row.name == "carriage_2" else row for row in gantry.joints)
    led, q = replace(gantry, joints=tuple(rows)), start_of(gantry).q[None]
    with pytest.raises(InputError, match="joint beam: feed-forward: motors on dependent joints act on this spring"):
        of_motors(gantry, led, np.zeros(1), q, 0 * q, np.zeros((1, 3)))


@pytest.mark.thorough
def test_what_is_refused_has_a_way_out() -> None:
    with pytest.raises(InputError, match=r"joint link_3: feed-forward: .* loop without closed form.*under servos"):
        with_motors_on_load_joints(driven_at(closed_chain("ring"), "link_3"))
    gantry, idle = closed_chain("gantry_rigid"), ("cross_slide", "ram")
    joints = (replace(row, kind=Kind.PASSIVE) if row.name in idle else row for row in gantry.joints)
    with pytest.raises(InputError, match="2 motors cannot prescribe the motion of 3 joints: lock some in a scene"):
        found(replace(gantry, joints=tuple(joints)), {"carriage_1": 0.1})
    with pytest.raises(InputError, match=r"joint 4 \(arm_1\), kind: feed_forward: .* use the command feed-forward"):
        trace(delta(), "feed_forward")
    with pytest.raises(
        InputError, match=r"loop leg_2: feed-forward: from 0.06\d* s on .* it does not close any more: "
    ):
        found(delta(), {"platform": -0.4})
