"""Problems of the literature on multibody dynamics: their reference solutions, published or by other equations."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from tests.closed_chains.problems import (
    BALL,
    ROD,
    SLIDER,
    START,
    TORQUE,
    TURNING,
    bricard,
    governor,
    squeezer,
    torque_of_spring,
    windows,
)

AT_END = {"beta": 15.81077119629904, "gam": 0.04082224013073101, "delta": 0.5244099658805304, "eps": 1.048080741042263}
"""Variables of bodies that turn about fixed pivots, at 0.03 s, rad."""


@pytest.mark.thorough
def test_the_squeezer_ends_where_the_reference_does() -> None:
    """Nine digits after two and a half turns of the crank; the reference and our own convergence agree no further."""
    integrate = pytest.importorskip("scipy.integrate")
    model = se.load(squeezer(), "direct_dynamics", "dependent_coordinates")
    joints = ("beta", "Theta", "gam", "delta", "Phi", "eps", "Omega")

    def at(beta: float) -> dict[str, float]:
        return dict(zip(joints, model.dependent_coordinates([beta]).tolist(), strict=True))

    for name, value in at(START["beta"]).items():
        assert value == pytest.approx(START[name], abs=1e-14)

    def rates(_: float, state: np.ndarray) -> list[float]:
        beta, rate = state
        tau = [TORQUE, torque_of_spring(at(beta)["gam"])]
        return [rate, model.direct_dynamics([beta], [rate], tau)[0]]

    found = integrate.solve_ivp(rates, (0, 0.03), [START["beta"], 0], method="DOP853", rtol=1e-12, atol=1e-12)
    end = at(found.y[0, -1])
    for name, value in AT_END.items():
        assert end[name] == pytest.approx(value, abs=5e-9)


@pytest.mark.parametrize("count", [2, pytest.param(40, marks=pytest.mark.thorough)])
def test_a_chain_of_four_bars_is_a_pendulum(count: int) -> None:
    """At every position, flat ones too, where other formulations gain freedoms: 13 products, however long it is."""
    model = se.load(windows(count), "direct_dynamics")
    inertia, weight = (count + 1) / 3 + count, 9.81 * ((count + 1) / 2 + count)
    for phi in (math.pi / 2, 0.3, 0.0, -2.0, math.pi):
        expected = -weight / inertia * math.cos(phi)
        assert model.direct_dynamics([phi], [0.7], [0.0])[0] == pytest.approx(expected, rel=1e-14, abs=1e-14)
    assert "13x " in model.direct_dynamics.__doc__


# Bricard's mechanism: one freedom, though five equations are expected to leave none


def rods(theta: Any) -> Any:
    """Ends of the rods: the closed form of the ring with three-fold symmetry, cos a + cos b + cos a cos b = 0."""
    other = np.arccos(-np.cos(theta) / (1 + np.cos(theta)))
    points, R = [np.zeros(3)], np.eye(3)
    for k in range(5):
        turn, side = (theta, other)[k % 2], (-1) ** k
        c, s = np.cos(turn), np.sin(turn)
        R = R @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        points.append(points[-1] + R[:, 0])
        R = R @ np.array([[1, 0, 0], [0, 0, -side], [0, side, 0]])
    return np.array(points)


def rate_of_fall(theta: float) -> float:
    """Rate at which the crank passes a position after the start at rest, rad/s, by the energy of five rods."""
    P = rods(theta + 1e-30j)
    v, fallen = P.imag / 1e-30, (P.real - rods(math.pi / 2))[:, 2]
    inertia = sum(v[k] @ v[k] + v[k] @ v[k + 1] + v[k + 1] @ v[k + 1] for k in range(5)) / 3
    return math.sqrt(2 * 9.81 * sum(fallen[k] + fallen[k + 1] for k in range(5)) / 2 / inertia)


def period_of_bricard(nodes: int) -> float:
    """By the midpoint rule in s, theta = pi/2 sin s, which is exact to rounding for periodic functions."""
    at = (np.arange(nodes) + 0.5) * (math.pi / 2) / nodes
    rates = [math.pi / 2 * math.cos(s) / rate_of_fall(math.pi / 2 * math.sin(s)) for s in at]
    return 4 * math.pi / 2 * float(np.mean(rates))


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_bricards_mechanism_swings_with_the_period_of_its_energy() -> None:
    """Two periods, 10 s: assembled loops, DOP853 at 1e-12, against a quadrature that has no recursion and no loop."""
    integrate = pytest.importorskip("scipy.integrate")
    model = se.load(bricard(), "assemble", "direct_dynamics", backend="c")
    period, guess = period_of_bricard(40), np.full(4, math.pi / 2)
    assert period == pytest.approx(period_of_bricard(60), rel=1e-13)
    assert period == pytest.approx(4.98630860865664, rel=1e-13)

    def rates(_: float, state: np.ndarray) -> list[float]:
        guess[:], residual = model.assemble(state[:1], guess)
        assert residual < 1e-12
        return [state[1], model.direct_dynamics(state[:1], guess, state[1:], [0.0])[0]]

    times = period * np.array([0.25, 0.5, 1, 2])
    start = [math.pi / 2, 0]
    found = integrate.solve_ivp(rates, (0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-12)
    wanted = np.array([[0, -math.pi / 2, math.pi / 2, math.pi / 2], [-rate_of_fall(0.0), 0, 0, 0]])
    np.testing.assert_allclose(found.y, wanted, atol=2e-11)


# A governor on a spring


def about_arms(stiffness: float, damping: float, neutral: float) -> Callable[[float, np.ndarray], list[float]]:
    """Lagrange's equation in the angle of the arms, written out; the axis keeps its moment of momentum."""
    of_sine = 2 * (2 * ROD / 3 + BALL)
    momentum = (TURNING + of_sine / 4) * 2 * math.pi

    def rates(_: float, state: np.ndarray) -> list[float]:
        _, a, ad = state
        s, c = math.sin(a), math.cos(a)
        inertia = 2 * (ROD / 3 + BALL + ROD / 3 * c * c + 7 * ROD / 3 * s * s) + 4 * SLIDER * s * s
        slope = (8 * ROD + 8 * SLIDER) * s * c
        spin = momentum / (TURNING + of_sine * s * s)
        weight = 9.81 * s * (4 * ROD + 2 * BALL + 2 * SLIDER)
        spring = 2 * s * (stiffness * (-2 * c - neutral) + damping * 2 * s * ad)
        return [spin, ad, (of_sine * s * c * spin**2 - slope * ad**2 / 2 - weight - spring) / inertia]

    return rates


@pytest.mark.parametrize(
    ("stiffness", "damping", "neutral", "method", "tolerance", "duration"),
    [
        pytest.param(1e3, 5.0, -1.5, "DOP853", 1e-12, 10.0, id="soft"),
        pytest.param(8e5, 4e4, -1.5, "Radau", 1e-10, 1.0, id="stiff", marks=pytest.mark.thorough),
    ],
)
def test_a_governor_moves_as_by_lagrange_in_another_coordinate(
    stiffness: float, damping: float, neutral: float, method: str, tolerance: float, duration: float
) -> None:
    """Position of the slider here, angle of the arms there: two loops, a spring and a damper; a turn in a second."""
    integrate = pytest.importorskip("scipy.integrate")
    model = se.load(governor(stiffness, damping, neutral), "direct_dynamics")
    start = [0, -math.sqrt(3), 2 * math.pi, 0]

    def rates(_: float, x: np.ndarray) -> list[float]:
        return [x[2], x[3], *model.direct_dynamics(x[:2], x[2:], [0.0])]

    given = {"method": method, "rtol": tolerance, "atol": tolerance}
    ours = integrate.solve_ivp(rates, (0, duration), start, **given).y[:, -1]
    other = about_arms(stiffness, damping, neutral)
    psi, a, ad = integrate.solve_ivp(other, (0, duration), [0, math.pi / 6, 0], **given).y[:, -1]
    assert abs(ours[1] - start[1]) > 0.02
    np.testing.assert_allclose(ours[[0, 1, 3]], [psi, -2 * math.cos(a), 2 * math.sin(a) * ad], atol=20 * tolerance)
