"""Limits of explicit steps and vibrations that are damped, against the theory of each method."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.prediction.path import linear_path
from symoro_elastic.analysis.simulation.prediction.step_error import damped_above, growth, largest_stable_step, poles
from symoro_elastic.codegen.integration.tableaus import METHODS, RK4
from tests.analysis.ladder.motions import moved
from tests.analysis.ladder.scenes import all_motors, flex4, tuned


@pytest.mark.parametrize("name", METHODS)
def test_growth_is_the_exponential_to_the_order_of_the_method(name: str) -> None:
    """At half the argument the error is 2^(order + 1) times smaller: T is exact here, so W-methods may do better."""
    method = METHODS[name]
    z = 0.2 * np.exp(1j * np.linspace(0.0, np.pi, 7))
    error, half = (np.abs(growth(method, x) - np.exp(x)) for x in (z, z / 2))
    assert (np.log2(error / half) > method.order + 0.7).all()


def test_limits_of_rk4() -> None:
    """2.8284 beside the imaginary axis, 2.7853 on the real one (Hairer and Wanner, section IV.2)."""
    undamped = np.array([1j, -1j, 0.0]) * 1000
    assert largest_stable_step(RK4, undamped) == pytest.approx(np.sqrt(8) / 1000, rel=1e-6)
    assert largest_stable_step(RK4, np.array([-500.0 + 0j])) == pytest.approx(2.785293563 / 500, rel=1e-6)
    assert largest_stable_step(RK4, np.array([1000j, -2000.0])) == pytest.approx(2.785293563 / 2000, rel=1e-6)


def test_motions_that_grow_set_no_limit() -> None:
    assert largest_stable_step(RK4, np.array([3.0 + 0j, -3.0 + 0j, 0.0])) == pytest.approx(2.785293563 / 3, rel=1e-6)
    assert largest_stable_step(RK4, np.zeros(4, dtype=complex)) == np.inf


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["w2", "w3", "rodas4"])
def test_implicit_methods_have_no_limit(name: str) -> None:
    assert largest_stable_step(METHODS[name], np.array([1e9j, -1e9 + 0j])) == np.inf


def test_poles_are_those_of_the_springs() -> None:
    """Along the motion they change with the position; the fastest of 40 Hz springs is faster than one alone."""
    machine = tuned(flex4(), (40,))
    path = linear_path(moved(machine, 0.2, all_motors(machine, 0.5, 0.2)), (), 50)
    found = np.abs(poles(path)) / (2 * np.pi)
    assert found.max() > 40 and poles(path, (1, 3)).size == 0
    alone = poles(path, (3,))
    inertia = path.M[0, 1, 1]
    assert np.abs(alone).max() == pytest.approx(np.sqrt(path.stiffness[1] / inertia), rel=0.2)


@pytest.mark.parametrize("name", ["w2", "w3"])
def test_damped_vibrations_lose_a_tenth_in_a_period(name: str) -> None:
    """Half as fast ones less; steps half as long follow twice as fast ones."""
    method, h = METHODS[name], 1e-3
    found = damped_above(method, h)
    assert found is not None and found < 1 / (2 * h)
    assert damped_above(method, h / 2) == pytest.approx(2 * found)
    for ratio, kept in ((0.5, 0.98), (1.0, 0.9)):
        wh = 2 * np.pi * found * ratio * h
        part = np.abs(growth(method, np.array([1j * wh])))[0] ** (2 * np.pi / wh)
        assert part > kept if ratio < 1 else part == pytest.approx(kept, rel=1e-2)


def test_a_vibration_that_rodas_follows_has_two_steps_a_period() -> None:
    assert damped_above(METHODS["rodas4"], 1e-3) == pytest.approx(500)


@pytest.mark.parametrize("name", ["midpoint", "rk4"])
def test_others_damp_nothing(name: str) -> None:
    assert damped_above(METHODS[name], 1e-3) is None
