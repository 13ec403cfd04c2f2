"""The inverse model fed forward: exact following, linear loops against their state space, and in time."""

from __future__ import annotations

import shutil
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.loops import loops_of
from symoro_elastic.foundation.errors import InputError

pytest.importorskip("scipy.linalg")
LOOSE = {"tolerance": {"one.q": 1e-5, "two.q": 1e-5}}
needs_compiler = pytest.mark.skipif(not (shutil.which("gcc") or shutil.which("clang")), reason="needs a C compiler")


def arm(**drives: Any) -> dict[str, Any]:
    """A 2R arm under gravity, with springs where `stiffness` is given; both motors feed the inverse model forward."""
    joints = [
        {"name": "one", "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "gear", "antecedent": "one", "kind": "elastic", "sigma": 0, "theta": "q2"},
        {"name": "two", "antecedent": "gear", "kind": "motor", "sigma": 0, "d": 0.4, "theta": "q3"},
    ]
    given = {"Kv": 15, "Kp": 40, "Tn": 0.1, "feed_forward": {"torque": True}} | drives
    return {
        "name": "arm",
        "gravity": [0, -9.81, 0],
        "joints": joints,
        "bodies": {
            "gear": {"mass": 4, "center_of_mass": [0.2, 0, 0], "inertia": [0.01, 0.1, 0.1]},
            "two": {"mass": 2, "center_of_mass": [0.1, 0.02, 0], "inertia": [0.01, 0.03, 0.03]},
        },
        "springs": {"gear": {"stiffness": 4e4, "damping": 10.0}},
        "motors": {"one": {"rotor_inertia": 0.4}, "two": {"rotor_inertia": 0.1}},
        "friction": {"one": {"viscous": 0.7}},
        "drives": {"one": given, "two": given},
    }


@pytest.mark.sampled(2)
@pytest.mark.parametrize("changes", [{}, {"current": {"lag": 5e-4}, "filters": [{"lowpass": 300, "order": 2}]}])
def test_what_follows_a_set_point_is_that_of_all_loops(changes: dict[str, Any]) -> None:
    """C (s - A)^-1 (B_0 + s B_1 + s^2 B_2), each axis by its own set point and the cross feed of the other drive."""
    found = se.control(arm(**changes))
    loop, (plant,) = found.loops[0], found.plants
    frequencies = np.array([0.3, 2.0, 9.0, 40.0])
    for k, axis in enumerate(loops_of(plant, found.cascades)):
        expected = []
        for s in 2j * np.pi * frequencies:
            column = sum(s**p * B[:, k] for p, B in enumerate(loop.by_set_point))
            moved = np.linalg.solve(s * np.eye(len(loop.A)) - loop.A, column)
            expected.append(axis.axis.position @ plant.free @ moved[: plant.free.shape[1]])
        assert axis.position_response(frequencies) == pytest.approx(np.array(expected), rel=1e-10)


def test_a_stiff_machine_follows_exactly_at_all_frequencies() -> None:
    machine = arm()
    machine["joints"] = [machine["joints"][0], machine["joints"][2] | {"antecedent": "one"}]
    machine["bodies"]["one"] = machine["bodies"].pop("gear")
    machine["springs"] = {}
    found = se.control(machine)
    for axis in loops_of(found.plants[0], found.cascades):
        assert axis.position_response(np.array([0.1, 3.0, 200.0])) == pytest.approx(1, abs=1e-12)
    assert [axis.velocity_error for axis in found.places[0].axes] == pytest.approx([0, 0], abs=1e-12)


@needs_compiler
@pytest.mark.thorough
@pytest.mark.parametrize("period", [None, 1e-3])
def test_motors_follow_ten_times_as_closely(period: float | None) -> None:
    """In time, continuous and sampled; a linear drive leaves the loads of both axes to its integral part."""
    timed = {"period": period} if period else {}
    moves = [{"motor": name, "by": by, "in": 0.1} for name, by in (("one", 0.1), ("two", -0.1))]
    scene = {"motion": {"duration": 0.1, "moves": moves, "drives": True}, "wanted": LOOSE}
    deviations = []
    for fed in (True, False):
        feed = {"feed_forward": {"torque": True} if fed else {"velocity": 1}}
        (found,) = se.simulate(arm(**timed, **feed), scene, adaptive=True)
        x, _ = found.reference.of_motors(found.motion)
        deviations.append(np.abs(x - found.reference.at(found.motion.t)[0]).max())
    assert deviations[0] < 0.1 * deviations[1]


@needs_compiler
@pytest.mark.thorough
def test_even_steps_are_given_the_same_torques() -> None:
    moves = [{"motor": "one", "by": 0.1, "in": 0.04}]
    scene = {"motion": {"duration": 0.05, "moves": moves, "drives": True}, "wanted": LOOSE}
    ends = [se.simulate(arm(), scene, adaptive=adaptive)[0].motion.q[-1] for adaptive in (True, False)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-5)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"feed_forward": {"torque": True, "acceleration": 0.1}}, "acceleration.*conflicts with torque = true"),
        ({"feed_forward": {"torque": True}, "set_point": {"lowpass": 30}}, "torque.*is of the set point before"),
        ({"feed_forward": {"torque": 1}}, "torque"),
    ],
)
def test_what_cannot_be_fed_is_refused(changes: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        se.control(arm(**changes))
