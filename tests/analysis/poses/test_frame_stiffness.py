"""`stiffness`: the 6 x 6 matrix of a frame with motors held."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES, refused, run

TWO_AXIS = EXAMPLES / "two_axis.toml"
K1, K2, A = 3e7, 5e5, 0.4


def post(**changes: Any) -> dict[str, Any]:
    """A slide along z on a spring, and an arm that turns about x0 on one: a force along z bends both."""
    return {
        "name": "post",
        "gravity": [0, 0, 0],
        "joints": [
            {"name": "foot", "antecedent": 0, "kind": "elastic", "sigma": 1, "r": "z"},
            {"name": "hinge", "antecedent": "foot", "kind": "elastic", "sigma": 0, "alpha": "pi/2", "theta": "turn"},
            {"name": "tip", "antecedent": "hinge", "kind": "fixed", "sigma": 2, "d": A},
        ],
        "bodies": {"foot": {"mass": 5}, "hinge": {"mass": 2, "inertia": [0.1, 0.1, 0.1]}},
        "springs": {"foot": {"stiffness": K1}, "hinge": {"stiffness": K2}},
        **changes,
    }


def test_springs_in_series_add_compliances_and_have_their_shares() -> None:
    found = se.stiffness(post())
    compliance = 1 / K1 + A**2 / K2
    assert found.compliance[2, 2] == pytest.approx(compliance)
    assert found.worst_compliance == pytest.approx(compliance) and np.abs(found.worst) == pytest.approx([0, 0, 1])
    assert found.shares == pytest.approx({"hinge": A**2 / K2 / compliance, "foot": 1 / K1 / compliance})
    assert "stiffen hinge first" in found.advice


def test_stiffening_a_spring_does_what_the_advice_says() -> None:
    before = se.stiffness(post())
    after = se.stiffness(post(springs={"foot": {"stiffness": K1}, "hinge": {"stiffness": 1.1 * K2}}))
    less = 1 - after.worst_compliance / before.worst_compliance
    assert f"by {less:.1%}" in before.advice


def test_the_matrix_is_that_of_a_static_solution() -> None:
    """Another way: equilibria under small forces on the frame, by the direct model's zero acceleration."""
    found = se.stiffness(TWO_AXIS, frame="tool", at={"motor_x": 0.1})
    linear = se.linearize(TWO_AXIS, at={"motor_x": 0.1}, hold=["all"], inputs=["tool.fx", "tool.fy", "tool.mz"],
                          outputs=["tool.x", "tool.y", "tool.rz"])  # fmt: skip
    expected = linear.Cq @ np.linalg.solve(linear.K, linear.F)
    np.testing.assert_allclose(found.compliance[np.ix_([0, 1, 5], [0, 1, 5])], expected, rtol=1e-9, atol=1e-18)
    yields = np.ix_([0, 1, 5], [0, 1, 5])
    np.testing.assert_allclose(found.stiffness[yields] @ found.compliance[yields], np.eye(3), atol=1e-9)
    assert np.isnan(found.stiffness[2]).all()


def test_a_map_has_a_row_for_each_position() -> None:
    found = se.stiffness(TWO_AXIS, frame="tool", along={"motor_x": [0.0, 0.2, 0.4]})
    assert [one.at["motor_x"] for one in found.points] == [0.0, 0.2, 0.4]
    single = se.stiffness(TWO_AXIS, frame="tool", at={"motor_x": 0.2})
    np.testing.assert_array_equal(found.points[1].compliance, single.compliance)
    assert "N/um" in found.headline


@pytest.mark.thorough
def test_the_command_gives_matrices_and_shares() -> None:
    data = json.loads(run("stiffness", str(TWO_AXIS), "--frame", "tool", "--json").stdout)
    assert np.shape(data["compliance"]) == np.shape(data["stiffness"]) == (6, 6)
    assert sum(data["shares"].values()) == pytest.approx(1, abs=0.05) and data["stiffness"][2] == [None] * 6
    assert "worst direction" in run("stiffness", str(TWO_AXIS), "--frame", "tool").stdout
    assert "springs that yield" in run("stiffness", str(TWO_AXIS), "--along", "motor_x=0:0.4:2").stdout


def test_what_yields_to_nothing_or_freely_is_rejected() -> None:
    assert "nothing yields to a force" in refused("stiffness", str(EXAMPLES / "planar_2r.toml"))
    free = post(springs={"foot": {"stiffness": K1}})
    free["joints"][1] |= {"kind": "passive"}
    with pytest.raises(InputError, match="hinge: it moves freely"):
        se.stiffness(free)
    assert "nose" in refused("stiffness", str(TWO_AXIS), "--frame", "nose")


def test_a_grid_takes_a_motor_once() -> None:
    variable = str(se.read(TWO_AXIS).motor_joints[0].variable)
    twice = ("--along", "motor_x=0:1:2", "--along", f"{variable}=0:1:2")
    assert "are the same joint: name each once" in refused("stiffness", str(TWO_AXIS), *twice)
    assert "motor_x is at 0.2 by --at" in refused("stiffness", str(TWO_AXIS), *twice[:2], "--at", "motor_x=0.2")
    rigid = se.stiffness(TWO_AXIS, frame="bed_yaw", along={"motor_x": [0.0, 0.4]})
    assert all(point.least_stiffness == np.inf for point in rigid.points) and "rigid" in rigid.headline
