"""Motions that leave the branch of their loops are refused: where a four-bar ends, and where its branches meet.

Reference: the triangle of rod, rocker and the distance of their ends, by the law of cosines.
"""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.adaptive import simulate_adaptively
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.simulate import Request, simulate
from symoro_elastic.analysis.vibration.feed_forward import FeedForward, feed_forward, starts
from symoro_elastic.analysis.vibration.reference_trajectory import move
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Gains
from symoro_elastic.models.bound.state import State
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.evaluation.closed_positions import refuse_lost
from tests.analysis.ladder.motions import moved
from tests.closed_chains.machines import machine
from tests.closed_chains.test_branches import BASE, CHANGE_POINT, CRANK, ROCKER, four_bar

pytestmark = pytest.mark.sampled(5)

SHORT = 0.3
"""Length of a rod with which the crank cannot turn all the way."""
END = math.acos((BASE**2 + CRANK**2 - (SHORT + ROCKER) ** 2) / (2 * BASE * CRANK))
"""Angle of the crank at which rod and rocker are stretched."""
SERVO = {"crank": Gains(100.0, 4.0)}
PLACE = re.compile(r"four_bar\.toml: loop bars: ([\w-]+): from ([\d.e-]+) s on \(crank = ([\d.e-]+)\) (it [^:]*)")


def said(of: InputError) -> tuple[str, float, float, str]:
    """The command, time, position and reason of a refusal."""
    found = PLACE.match(str(of))
    assert found and "\n" not in str(of), of
    command, t, q, why = found.groups()
    return command, float(t), float(q), why


def commanded(described: Machine, stroke: float) -> FeedForward:
    return feed_forward(described, move(described, starts(described), {"crank": stroke}, 0.4, 5))


def servoed(described: Machine, stroke: float) -> Reference:
    return moved(described, 0.5, {"crank": (stroke, 0.4)}, {"crank": 1.0}, SERVO)


def test_feed_forward_beyond_the_end_of_a_loop() -> None:
    with pytest.raises(InputError) as caught:
        commanded(four_bar(SHORT, 1.0, 1), 2.0)
    command, t, q, why = said(caught.value)
    assert (command, why) == ("feed-forward", "it does not close any more") and 0 < t < 0.4
    assert END < q < END + 0.02  # a sample of 1 ms at 11 rad/s


@pytest.mark.parametrize("stroke", [-1.0, -2.0])
def test_feed_forward_to_and_through_a_change_point(stroke: float) -> None:
    with pytest.raises(InputError) as caught:
        commanded(four_bar(CHANGE_POINT, 1.0, 1), stroke)
    _, _, q, _ = said(caught.value)
    assert abs(q) < 0.02
    assert np.isfinite(commanded(four_bar(CHANGE_POINT - 1e-3, 1.0, 1), stroke).tau).all()


def test_a_simulated_motion_through_a_change_point() -> None:
    """Also one whose samples lie beside it on both sides, where the closed form has a kink."""
    with pytest.raises(InputError) as caught:
        simulate(servoed(four_bar(CHANGE_POINT, 1.0, 1), -2.0), Request(tolerance={"rocker.q": 1e-2}))
    command, t, q, why = said(caught.value)
    assert (command, why) == ("simulate", "it is singular") and 0.1 < t < 0.4 and abs(q) < 0.02


def test_a_servo_towards_positions_that_cannot_close() -> None:
    with pytest.raises(InputError) as caught:
        simulate(servoed(four_bar(SHORT, 1.0, 1), 2.0), Request(tolerance={"rocker.q": 1e-5}))
    _, t, q, _ = said(caught.value)
    assert 0.1 < t < 0.4 and END - 0.2 < q < END + 1e-3


def test_adapted_steps_name_the_loop() -> None:
    with pytest.raises(InputError) as caught:
        simulate_adaptively(servoed(four_bar(CHANGE_POINT, 1.0, 1), -2.0), Request(tolerance={"rocker.q": 1e-2}), {})
    _, _, q, _ = said(caught.value)
    assert abs(q) < 0.1


@pytest.mark.parametrize("name", ["parallelogram_loop", "palletizer", "delta", "ring", "wedge", "press"])
def test_motions_about_the_start_are_on_one_branch(name: str) -> None:
    """Constant maps have no singular position; loops without a closed form are followed."""
    described = machine(name)
    q, t = start_of(described).q, np.linspace(0, 1, 50)
    refuse_lost(described, "simulate", t, State({"q": q + 0.02 * np.sin(7 * t)[:, None]}))


def test_a_parallelogram_turns_through_the_flat_position() -> None:
    described, t = machine("parallelogram_loop"), np.linspace(0, 1, 50)
    q = start_of(described).q + np.eye(len(described.independent))[0] * 2 * np.pi * t[:, None]
    refuse_lost(described, "simulate", t, State({"q": q}))
