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


@pytest.mark.thorough
def test_the_line_to_the_nearest_point_is_as_long_as_the_modulus_margin() -> None:
    result = se.control(EXAMPLES / "ball_screw.toml", damping=0.02)
    axis = result.places[0].axes[0]
    (plane,) = result.plot(f"nyquist_{axis.motor}").axes
    lengths = [np.hypot(*(line.get_xydata()[1] - (-1, 0))) for line in plane.lines if len(line.get_xdata()) == 2]
    assert lengths == pytest.approx([axis.velocity.modulus, axis.position.modulus], rel=0.02)


@pytest.mark.thorough
def test_the_largest_sensitivity_is_the_inverse_of_the_modulus_margin() -> None:
    result = se.tune(EXAMPLES / "ball_screw.toml", damping=0.02)
    axis = result.places[0].axes[0]
    (magnitude,) = result.plot(f"sensitivity_{axis.motor}").axes
    drawn = [line.get_ydata().max() for line in magnitude.lines if len(line.get_xdata()) > 2]
    assert drawn == pytest.approx([-20 * np.log10(x.modulus) for x in (axis.velocity, axis.position)], abs=0.05)
    assert result.as_json() == se.control(EXAMPLES / "ball_screw.toml", damping=0.02, tune=True).as_json()


def test_speeds_of_lobes_are_even_in_the_time_of_a_turn() -> None:
    lobes = se.lobes(EXAMPLES / "ball_screw.toml", direction="table.x", cutting=2e9, damping=0.02)
    assert lobes.speeds[[0, -1]] == pytest.approx([1000, 20_000]) and np.ptp(np.diff(1 / lobes.speeds)) < 1e-15
