"""`evaluate`: results of models at a state, by the names of joints and frames."""

from __future__ import annotations

import json

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES, refused, run

ARM, TWO_AXIS = EXAMPLES / "planar_2r.toml", EXAMPLES / "two_axis.toml"
G, M1, M2, L1, LC1, LC2, I1, I2 = 9.81, 2.5, 1.5, 0.4, 0.2, 0.15, 0.035, 0.012


def test_torques_are_those_of_the_textbook() -> None:
    """The two-link arm at rest, and accelerating at its elbow."""
    q1, q2, a2 = np.radians(30.0), 0.4, 2.0
    found = se.evaluate(ARM, models=["inverse_dynamics"], at={"shoulder": "30 deg", "elbow": q2, "elbow.qdd": a2})
    gravity_2 = M2 * LC2 * G * np.cos(q1 + q2)
    gravity_1 = (M1 * LC1 + M2 * L1) * G * np.cos(q1) + gravity_2
    m22 = M2 * LC2**2 + I2
    m12 = m22 + M2 * L1 * LC2 * np.cos(q2)
    assert found.as_json()["inverse_dynamics"]["tau"] == pytest.approx(
        {"shoulder": gravity_1 + m12 * a2, "elbow": gravity_2 + m22 * a2}
    )


@pytest.mark.thorough
def test_every_model_of_joint_states_has_the_numbers_of_the_loaded_one() -> None:
    at = {"bed_yaw": 1e-4, "motor_x.qd": 0.3, "motor_y.tau": 50.0}
    found = se.evaluate(TWO_AXIS, models=["direct_dynamics", "inertia_matrix", "jacobian"], at=at).as_json()
    model = se.load(TWO_AXIS, "direct_dynamics", "inertia_matrix", "jacobian")
    names = list(model.JOINTS)
    q, qd = np.zeros(len(names)), np.zeros(len(names))
    q[names.index("bed_yaw")], qd[names.index("motor_x")] = 1e-4, 0.3
    np.testing.assert_array_equal([*found["direct_dynamics"]["qdd"].values()], model.direct_dynamics(q, qd, [0, 50.0]))
    A = [[*x.values()] for x in found["inertia_matrix"]["A"].values()]
    np.testing.assert_array_equal(A, model.inertia_matrix(q))
    np.testing.assert_array_equal(found["jacobian"]["J"]["tool"], model.jacobian(q)[model.FRAMES.index("tool")])


def test_the_command_prints_units_and_json() -> None:
    words = ("evaluate", str(ARM), "--model", "inverse_dynamics", "--at", "shoulder=30deg")
    assert "N m or N" in run(*words).stdout and "shoulder" in run(*words).stdout
    data = json.loads(run(*words, "--json").stdout)
    assert data["inverse_dynamics"]["tau"]["shoulder"] == pytest.approx(11.256814704741082)


def test_a_data_frame_has_a_row_for_each_entry() -> None:
    columns = se.evaluate(ARM, models=["inertia_matrix"]).columns()
    assert columns["row"] == ["shoulder", "shoulder", "elbow", "elbow"]
    assert columns["column"] == ["shoulder", "elbow"] * 2 and len(columns["value"]) == 4


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--at", "sholder=1"), "did you mean 'shoulder'"),
        (("--at", "shoulder.jerk=1"), "write shoulder, shoulder.qd, shoulder.qdd or shoulder.tau"),
        (("--at", "shoulder=1kg"), "--at"),
        (("--at", "tip=1"), "no moving joint 'tip'"),
        (("--model", "inverse_geometric_model"), "inverse_geometric_model"),
    ],
)
def test_wrong_states_are_rejected_by_name(words: tuple[str, ...], message: str) -> None:
    assert message in refused("evaluate", str(ARM), *words)


def test_parameters_without_value_are_named() -> None:
    with pytest.raises(InputError, match="XX1 has no value"):
        se.evaluate(EXAMPLES / "flex4.par", models=["inverse_dynamics"])
