"""Problems of the literature on multibody dynamics: their reference solutions, published or by other equations."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from tests.closed_chains.problems import (
    BALL,
    RECTANGULAR,
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


# Bodies in the coordinates of all of them, which no table of joints has


ROUND = 1 / 600
"""Moment of inertia of a rod of 1 kg and 0.1 m x 0.1 m about its length, kg m2, which a free rod needs."""


@dataclass
class FreeBodies:
    """Rods of 1 kg of a ring of hinges: positions, quaternions and velocities of all, and multipliers.

    A hinge holds a point of two bodies together, and an axis: five equations, of which one in the ring is redundant;
    its multipliers are those of least norm. `joints` are frames (4, 4) of the hinges and of the end, z along the axes.
    """

    joints: Sequence[np.ndarray]
    links: Sequence[float]

    def __post_init__(self) -> None:
        self.rods = len(self.joints) - 2
        ends = [(k - 1, k) for k in range(self.rods)] + [(self.rods - 1, -1)]
        self.hinges = [(a, b, T[:3, 3], T[:3, 2]) for (a, b), T in zip(ends, self.joints, strict=False)]
        rods = [
            (T[:3, :3], T[:3, 3], a) for T, a in zip(self.joints[: self.rods], self.links[: self.rods], strict=True)
        ]
        self.centres = [R @ [a / 2, 0, 0] + p for R, p, a in rods]
        self.tensors = [R @ np.diag([ROUND, a * a / 12, a * a / 12]) @ R.T for R, _, a in rods]
        self.start = np.concatenate([*self.centres, *[[1.0, 0, 0, 0]] * self.rods, np.zeros(6 * self.rods)])

    def rates(self, y: np.ndarray) -> np.ndarray:
        """Newton's and Euler's equations with hinges, in axes of the ground."""
        n = self.rods
        r, quaternions, v, w = (y[a * n : b * n].reshape(n, -1) for a, b in ((0, 3), (3, 7), (7, 10), (10, 13)))
        R = [turned(x / np.linalg.norm(x)) for x in quaternions]
        M, f = np.zeros((6 * n, 6 * n)), np.zeros(6 * n)
        for k in range(n):
            tensor = R[k] @ self.tensors[k] @ R[k].T
            M[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = np.eye(3)
            M[3 * (n + k) : 3 * (n + k) + 3, 3 * (n + k) : 3 * (n + k) + 3] = tensor
            f[3 * k + 2], f[3 * (n + k) : 3 * (n + k) + 3] = 9.81, -np.cross(w[k], tensor @ w[k])
        C, held = self.hinged(r, R, v, w)
        inverse = np.linalg.inv(M)
        forces = np.linalg.pinv(C @ inverse @ C.T, rcond=1e-10) @ (held - C @ inverse @ f)
        turning = [0.5 * product(np.array([0, *rate]), x) for rate, x in zip(w, quaternions, strict=True)]
        return np.concatenate([v.ravel(), *turning, inverse @ (f + C.T @ forces)])

    def hinged(self, r: Any, R: Any, v: Any, w: Any) -> tuple[np.ndarray, np.ndarray]:
        """Rows C of the hinges, and what C times the accelerations is."""
        n, rows, held = self.rods, [], []
        for a, b, point, axis in self.hinges:
            row, far = np.zeros((6, 6 * n)), np.zeros(6)
            for body, sign in ((a, 1.0), (b, -1.0)):
                if 0 <= body < n:
                    arm = R[body] @ (point - self.centres[body])
                    row[:3, 3 * body : 3 * body + 3] = sign * np.eye(3)
                    row[:3, 3 * (n + body) : 3 * (n + body) + 3] = -sign * crossing(arm)
                    row[3:, 3 * (n + body) : 3 * (n + body) + 3] = -sign * crossing(R[body] @ axis)
                    far[:3] += sign * np.cross(w[body], np.cross(w[body], arm))
                    far[3:] += sign * np.cross(w[body], np.cross(w[body], R[body] @ axis))
            rows.append(row)
            held.append(-far)
        return np.concatenate(rows), np.concatenate(held)


def crossing(x: np.ndarray) -> np.ndarray:
    """Return the matrix of x cross."""
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])


def turned(x: np.ndarray) -> np.ndarray:
    """Return the rotation of a quaternion of length 1."""
    hat = crossing(x[1:])
    return np.eye(3) + 2 * x[0] * hat + 2 * hat @ hat


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product of two quaternions."""
    return np.concatenate([[a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])])


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_a_rectangular_bricard_mechanism_moves_as_its_bodies_do() -> None:
    """1 s under gravity from rest: one coordinate and an assembled loop, against 65 numbers and 36 equations."""
    integrate = pytest.importorskip("scipy.integrate")
    table = bricard(RECTANGULAR, 1.2)
    for body in table["bodies"].values():
        body["inertia"][0] = ROUND
    model = se.load(table, "assemble", "direct_dynamics", "geometric_model", backend="c")
    guess, _ = model.assemble([1.2], [math.pi / 2] * 4)
    guess, _ = model.assemble([1.2], guess)

    def rates(_: float, state: np.ndarray) -> list[float]:
        guess[:], residual = model.assemble(state[:1], guess)
        assert residual < 1e-12
        return [state[1], model.direct_dynamics(state[:1], guess, state[1:], [0.0])[0]]

    free = FreeBodies(np.asarray(model.geometric_model([1.2], guess)), RECTANGULAR)
    found = integrate.solve_ivp(rates, (0, 1), [1.2, 0], method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    other = integrate.solve_ivp(lambda _, y: free.rates(y), (0, 1), free.start, method="DOP853", rtol=1e-11, atol=1e-11)
    guess[:], _ = model.assemble(found[:1], guess)
    frames = np.asarray(model.geometric_model(found[:1], guess))
    centres = [T[:3, :3] @ [a / 2, 0, 0] + T[:3, 3] for T, a in zip(frames, RECTANGULAR[:5], strict=False)]
    np.testing.assert_allclose(other.y[:15, -1].reshape(5, 3), centres, atol=1e-10)


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
