"""Loops in python-control: what it makes of them is what `control` says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.control import Control
from symoro_elastic.analysis.control.loops import loops_of

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def found() -> Control:
    pytest.importorskip("control")
    return se.control(EXAMPLES / "two_axis.toml", damping=0.02, compliances=["tool.x"])


@pytest.mark.thorough
def test_all_loops_closed_as_a_state_space(found: Control) -> None:
    closed = found.to_control()["closed"]
    assert list(closed.input_labels)[:3] == ["motor_x_r", "motor_x_rd", "motor_x_rdd"]
    assert list(closed.output_labels) == ["motor_x_position", "motor_y_position", "tool_x"]
    assert np.sort_complex(closed.poles()) == pytest.approx(np.sort_complex(found.loops[0].poles), rel=1e-6)
    at_rest = closed(1e-6j)
    (compliance,) = found.places[0].compliances
    assert at_rest[2, -1] == pytest.approx(compliance.static, rel=1e-5)
    assert at_rest[:2, [0, 3]] == pytest.approx(np.eye(2), abs=1e-5)


@pytest.mark.thorough
def test_open_loops_have_their_dead_times(found: Control) -> None:
    loops, systems = loops_of(found.plants[0], found.cascades), found.to_control()
    for one in loops:
        for name, of in (("velocity", one.velocity_loop), ("position", one.position_loop)):
            f = one.frequencies[[100, 900]]
            assert systems[f"{one.cascade.motor} {name}"](2j * np.pi * f) == pytest.approx(of(f), rel=1e-10)
    axis = found.places[0].axes[0]
    gain, phase = pytest.importorskip("control").stability_margins(systems["motor_x velocity"], method="frd")[:2]
    assert gain == pytest.approx(axis.velocity.gain, rel=1e-2)
    assert phase == pytest.approx(axis.velocity.phase, rel=1e-2)
