"""`ik`: positions of joints at which a frame has a pose."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from tests.closed_chains.machines import without_closed_form
from tests.command_line import EXAMPLES, ended, refused, run

ARM, PUMA = EXAMPLES / "planar_2r.toml", EXAMPLES / "puma560_measured.toml"
L1, L2 = 0.4, 0.3
SOLVED = 1e-8
REDUNDANT = {
    "name": "redundant",
    "gravity": [0, 0, 0],
    "joints": [
        {"name": "j1", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "j2", "antecedent": "j1", "kind": "motor", "sigma": 0, "d": 0.5, "theta": "q2"},
        {"name": "j3", "antecedent": "j2", "kind": "motor", "sigma": 0, "d": 0.5, "theta": "q3"},
        {"name": "tip", "antecedent": "j3", "kind": "fixed", "sigma": 2, "d": 0.5},
    ],
}


def test_both_elbows_of_a_planar_arm_are_those_of_the_law_of_cosines() -> None:
    x, y = 0.4, 0.35
    found = se.ik(ARM, position=(x, y, 0))
    elbow = np.arccos((x**2 + y**2 - L1**2 - L2**2) / (2 * L1 * L2))
    assert sorted(one.joints["elbow"] for one in found.solutions) == pytest.approx([-elbow, elbow], abs=SOLVED)
    assert found.redundant == 0 and not any(one.is_singular for one in found.solutions)


@settings(max_examples=10, deadline=None)
@given(st.lists(st.floats(-2.5, 2.5), min_size=6, max_size=6))
def test_positions_of_a_robot_are_recovered_from_its_pose(q: list[float]) -> None:
    model = se.load(PUMA, "geometric_model", only={"geometric_model": ["flange"]})
    T = np.asarray(model.geometric_model(q)).reshape(-1, 4, 4)[-1]
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    angles = rotation.from_matrix(T[:3, :3]).as_euler("xyz")
    found = se.ik(PUMA, frame="flange", position=T[:3, 3], orientation=angles, starts=5)
    assert found.solutions
    for one in found.solutions:
        reached = np.asarray(model.geometric_model([*one.joints.values()])).reshape(-1, 4, 4)[-1]
        np.testing.assert_allclose(reached, T, atol=SOLVED)


@pytest.mark.thorough
def test_eight_postures_of_a_puma_are_found_and_the_nearest_comes_first() -> None:
    at = {"waist": -2.3, "shoulder": 2.8}
    found = se.ik(PUMA, frame="flange", position=(0.4, 0.2, 0.3), orientation=(0.1, 3.0, 0.2), at=at)
    assert len(found.solutions) == 8
    q = np.array([[*one.joints.values()] for one in found.solutions])
    near = np.array([at.get(name, 0.0) for name in found.nearest])
    apart = np.linalg.norm((q - near + np.pi) % (2 * np.pi) - np.pi, axis=1)
    assert (np.diff(apart) >= 0).all()


@pytest.mark.thorough
def test_limits_hold_and_what_is_out_of_reach_says_by_how_much() -> None:
    far = se.ik(ARM, position=(1.0, 0, 0))
    assert not far.solutions and far.miss == pytest.approx(1.0 - L1 - L2, abs=SOLVED)
    limited = {
        "name": "limited",
        "gravity": [0, 0, 0],
        "joints": [{"name": "slide", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "x"}],
        "limits": {"slide": {"position": [0, 0.5]}},
    }
    assert se.ik(limited, frame="slide", position=(0, 0, 0.5)).solutions[0].at_limits == ("slide",)
    assert se.ik(limited, frame="slide", position=(0, 0, 0.6)).miss == pytest.approx(0.1, abs=1e-5)


@pytest.mark.thorough
def test_redundant_joints_are_counted_and_stay_near() -> None:
    at = {"j1": 0.3, "j2": 0.4, "j3": 0.5}
    model = se.load(REDUNDANT, "geometric_model", only={"geometric_model": ["tip"]})
    target = np.asarray(model.geometric_model([0.31, 0.4, 0.5])).reshape(-1, 4, 4)[-1][:3, 3]
    found = se.ik(REDUNDANT, position=target, at=at)
    (one,) = found.solutions
    assert found.redundant == 1 and np.abs(np.subtract([*one.joints.values()], [0.31, 0.4, 0.5])).max() < 0.02


def test_springs_stay_neutral() -> None:
    found = se.ik(EXAMPLES / "two_axis.toml", frame="tool", position=(0.3, 0.2, 0.25))
    for one in found.solutions:
        assert all(x == 0 for name, x in one.joints.items() if name not in ("motor_x", "motor_y"))
    assert found.solutions or found.miss > 0


@pytest.mark.thorough
def test_the_command_gives_json_and_exit_code_1_out_of_reach() -> None:
    data = json.loads(run("ik", str(ARM), "--position", "0.4,0.3,0", "--json").stdout)
    assert len(data["solutions"]) == 2 and {*data["solutions"][0]} == {"shoulder", "elbow"}
    assert ended("ik", str(ARM), "--position", "40cm,30cm,0").code == 0
    result = ended("ik", str(ARM), "--position", "2,0,0")
    assert result.code == 1 and "does not reach this pose" in result.out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--position", "1,2"), "is not three numbers"),
        (("--position", "nan,0,0"), "--position: 'nan,0,0': 'nan' is not a number: nan is not finite"),
        (("--position", "1,2,3", "--frame", "nose"), "nose"),
        (("--position", "1,2,3", "--at", "tip=1"), "--at"),
        (("--position", "1,2,3", "--orientation", "1,2"), "is not three numbers"),
    ],
)
def test_wrong_poses_are_rejected_by_name(words: tuple[str, ...], message: str) -> None:
    assert message in refused("ik", str(ARM), *words)


def test_loops_without_a_closed_form_are_rejected() -> None:
    with pytest.raises(InputError, match="no closed form"):
        se.ik(without_closed_form(), position=(0, 0, 0))
