"""Sampled loops: the map of a period against scipy's and against fine steps, and intervals of stable gains."""

from __future__ import annotations

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.cascade import (
    CURRENT,
    Biquad,
    Cascade,
    DeadTime,
    Element,
    FirstOrder,
    Hold,
    biquad_system,
    laplace,
)
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.sampled import by_tustin, sampled_loop
from symoro_elastic.foundation.errors import InputError
from tests.analysis.control.test_closed_loops import plant_of
from tests.analysis.control.test_largest_gain import drive

signal, linalg = pytest.importorskip("scipy.signal"), pytest.importorskip("scipy.linalg")

PERIOD = 2.5e-4


def cascade(gain: float, dead: float, *more: Element, Tn: float = 0.02) -> Cascade:
    path = (DeadTime("dead time", dead), Hold("period", PERIOD), FirstOrder(CURRENT, 2e-4), *more)
    return Cascade("motor", 20.0, gain, Tn, path)


@pytest.mark.parametrize("dead", [PERIOD, 0.3 * PERIOD])
def test_the_map_is_that_of_fine_steps_with_held_torques(dead: float) -> None:
    """From random states over five periods; the controller written out beside it."""
    plant, one = plant_of("ball_screw.toml"), cascade(3.0, dead)
    loop, n = sampled_loop(plant, [one]), len(plant.linear.M)
    assert loop is not None
    axis, free = plant.axes["motor"], closed_loop(plant, [])
    fine = PERIOD / 100
    whole = np.zeros((2 * n + 2, 2 * n + 2))
    whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n] = free.A, free.by_force @ axis.velocity
    whole[2 * n, 2 * n :] = -1 / 2e-4, 1 / 2e-4
    step = linalg.expm(whole * fine)
    state = np.random.default_rng(4).normal(size=len(loop.map)) * 1e-3
    x, w, integral = state[: 2 * n + 1], state[2 * n + 1], state[2 * n + 2]
    for _ in range(5):
        error = -(20.0 * axis.position @ x[:n] + axis.velocity @ x[n : 2 * n])
        integral += PERIOD * error
        new = 3.0 * (error + integral / 0.02)
        for k in range(100):
            x = (step @ np.append(x, w if k < round(100 * dead / PERIOD) else new))[:-1]
        w, state = new, loop.map @ state
        assert np.allclose(state, [*x, w, integral], rtol=1e-9, atol=1e-9 * np.abs(state).max())


def test_a_dead_time_of_a_period_is_that_of_scipy() -> None:
    plant = plant_of("ball_screw.toml")
    free, n = closed_loop(plant, []), 2 * len(plant.linear.M)
    push = free.by_force @ plant.axes["motor"].velocity
    A, B = np.zeros((n + 1, n + 1)), np.zeros((n + 1, 1))
    A[:n, :n], A[:n, n], A[n, n], B[n] = free.A, push, -1 / 2e-4, 1 / 2e-4
    held = signal.cont2discrete((A, B, np.eye(n + 1), np.zeros((n + 1, 1))), PERIOD)
    loop = sampled_loop(plant, [cascade(3.0, PERIOD)])
    assert loop is not None
    size = np.abs(held[0]).max()
    assert np.allclose(loop.map[: n + 1, : n + 1], held[0], rtol=1e-12, atol=1e-12 * size)
    assert np.allclose(loop.map[: n + 1, n + 1], held[1][:, 0], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("low", [False, True])
def test_filters_are_right_at_their_own_frequency(low: bool) -> None:
    """Tustin's rule with prewarping, at rest and at w; elsewhere it is not."""
    one = Biquad("filter", 300.0, 0.0 if low else 0.1, 0.5, low)
    system = by_tustin(biquad_system(one), one.w, PERIOD)
    for f, is_exact in ((1e-3, True), (300.0, True), (900.0, False)):
        z = np.exp(2j * np.pi * f * PERIOD)
        sampled = system.C @ np.linalg.solve(z * np.eye(2) - system.A, system.B) + system.D
        assert np.isclose(sampled, one.at(laplace(np.array([f])))[0], rtol=1e-6) == is_exact


INTERVALS = {1e-3: (0.14, 0.713), 2.5e-4: (0.13, 15.25), 1.25e-4: (0.13, 8.85), 6.25e-5: (0.13, 20.09)}
"""Gains by period, published by a trial: `ball_screw` with 1 % damping, Kv 20, Tn 20 ms, a dead time of a period."""


@pytest.mark.sampled(2)
@pytest.mark.parametrize("period", INTERVALS)
def test_gains_are_stable_in_an_interval(period: float) -> None:
    (low, high), plant = INTERVALS[period], plant_of("ball_screw.toml", ratio=0.01)
    path = (DeadTime("dead time", period), Hold("period", period), FirstOrder(CURRENT, 2e-4))
    found = []
    for gain in (0.9 * low, 1.2 * low, 0.995 * high, 1.005 * high):
        loop = sampled_loop(plant, [Cascade("motor", 20.0, gain, 0.02, path)])
        found.append(loop is not None and loop.growth < 0)
    assert found == [False, True, True, False]


def test_control_says_what_the_map_says() -> None:
    """A gain that a continuous controller bears, and one at 1 ms does not."""
    slow = se.control(drive(Kp=40.0, Kv=20.0, dead_time=1e-3, period=1e-3)).places[0]
    fast = se.control(drive(Kp=40.0, Kv=20.0, dead_time=1e-4, period=1e-4)).places[0]
    assert slow.growth > 0 > fast.growth and (slow.period, fast.period) == (1e-3, 1e-4)


def test_what_no_map_has_is_refused() -> None:
    with pytest.raises(InputError, match=r"motor, dead_time: 0\.001 s is longer than the period, 0\.0001 s"):
        se.control(drive(Kp=1.0, Kv=20.0, dead_time=1e-3, period=1e-4))
