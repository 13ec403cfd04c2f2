"""Plots of drives: decibels, phases at multiples of 90 degrees, margins where they are computed."""

from __future__ import annotations

import numpy as np
import pytest

import symoro_elastic as se
from tests.command_line import EXAMPLES

pytest.importorskip("matplotlib")


def test_open_loops_are_in_decibels_with_their_margins() -> None:
    result = se.control(EXAMPLES / "ball_screw.toml", damping=0.02)
    axis = result.places[0].axes[0]
    magnitude, phase = result.plot(f"open_loops_{axis.motor}").axes
    assert magnitude.get_ylabel() == "open loop, dB"
    assert all(y % 90 == 0 for y in phase.get_yticks()) and len(phase.get_yticks()) >= 2
    drawn = {
        line.get_xdata()[0]: line.get_ydata() for line in (*magnitude.lines, *phase.lines) if len(line.get_xdata()) == 2
    }
    for margins in (axis.velocity, axis.position):
        gain, angle = drawn[margins.gain_frequency], drawn[margins.phase_frequency]
        assert gain == pytest.approx([0.0, -20 * np.log10(margins.gain)])
        assert angle[0] % 360 == 180 and abs(angle[1] - angle[0]) == pytest.approx(margins.phase, abs=1.0)


def test_the_line_to_the_nearest_point_is_as_long_as_the_modulus_margin() -> None:
    result = se.control(EXAMPLES / "ball_screw.toml", damping=0.02)
    axis = result.places[0].axes[0]
    (plane,) = result.plot(f"nyquist_{axis.motor}").axes
    lengths = [np.hypot(*(line.get_xydata()[1] - (-1, 0))) for line in plane.lines if len(line.get_xdata()) == 2]
    assert lengths == pytest.approx([axis.velocity.modulus, axis.position.modulus], rel=0.02)
