"""Plots of results at one position: the drawn numbers are those of the results, in N/um."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.poses.frame_stiffness import StiffnessMap
from tests.analysis.poses.test_frame_stiffness import TWO_AXIS, post
from tests.command_line import EXAMPLES, run

pytest.importorskip("matplotlib")


def widths(axes: Any) -> list[float]:
    return [patch.get_width() for patch in axes.patches]


def test_bars_of_stiffness_are_in_newtons_by_micrometre() -> None:
    result = se.stiffness(post())
    along, about, springs, _ = result.plot().axes
    assert along.get_xlabel() == "stiffness, N/um" and about.get_xlabel() == "stiffness, N m/urad"
    assert widths(along)[2:] == pytest.approx([1e-6 / result.compliance[2, 2], 1e-6 * result.least_stiffness])
    assert next(text.get_text() for text in along.get_yticklabels()) == "x: rigid"
    assert {text.get_text() for text in springs.texts} >= {f"{result.shares_by_axis['z']['hinge']:.0%}"}


@pytest.mark.thorough
def test_a_map_over_one_joint_is_curves_and_over_two_contours() -> None:
    one = se.stiffness(TWO_AXIS, frame="tool", along={"motor_x": [0.4, 0.0, 0.2]})
    (axes,) = one.plot().axes
    worst = axes.get_lines()[-1]
    assert worst.get_xdata().tolist() == [0.0, 0.2, 0.4] and axes.get_ylabel() == "stiffness, N/um"
    np.testing.assert_allclose(worst.get_ydata(), [1e-6 * one.points[k].least_stiffness for k in (1, 2, 0)])
    two = se.stiffness(TWO_AXIS, frame="tool", along={"motor_x": [0.0, 0.2], "motor_y": [0.0, 0.1, 0.2]})
    axes = two.plot().axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("motor_x, rad or m", "motor_y, rad or m")
    assert len(axes.get_lines()[-1].get_xdata()) == 6


@pytest.mark.thorough
def test_a_rigid_frame_and_a_pose_out_of_reach_have_a_reason() -> None:
    joints = [*post()["joints"], {"name": "floor", "antecedent": 0, "kind": "fixed"}]
    rigid = StiffnessMap((se.stiffness(post(joints=joints), frame="floor"),) * 2)
    assert "rigid" in rigid.plots().left_out["stiffness"]
    far = se.ik(EXAMPLES / "planar_2r.toml", position=(9.0, 0.0, 0.0))
    assert "no start reaches the pose" in far.plots().left_out["solutions"]


def test_solutions_and_results_of_models_are_bars() -> None:
    result = se.ik(EXAMPLES / "planar_2r.toml", position=(0.5, 0.3, 0.0))
    drawn = widths(result.plot().axes[0])
    assert drawn == pytest.approx([x for solution in result.solutions for x in solution.joints.values()])
    values = se.evaluate(EXAMPLES / "planar_2r.toml", ["inverse_dynamics", "inertia_matrix"], at={"shoulder": 0.3})
    tau = values.models["inverse_dynamics"][0].entries
    assert widths(values.plot("inverse_dynamics_tau").axes[0]) == pytest.approx(list(tau.values()))
    assert "inertia_matrix_A" in values.plots()


@pytest.mark.thorough
def test_the_command_draws(tmp_path: Any) -> None:
    run("stiffness", TWO_AXIS, "--frame", "tool", "--plots", tmp_path / "plots")
    assert (tmp_path / "plots" / "stiffness.png").exists()
