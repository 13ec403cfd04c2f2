"""Motions of machines on a floating base: what is given over time, and an independent integration of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from scipy.integrate import solve_ivp

from symoro_elastic.codegen.integration.tableaus import METHODS, times_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine, Orientation

TOLERANCE = 1e-12
Equations = Callable[[Array, Array, Array, Array], tuple[Array, Array]]
"""A, and what A (V0d, qdd) is without motors and wrench, at the rotation of the base, V0, q and qd."""


@dataclass(frozen=True)
class FloatingState:
    """q, qd of the joints, quaternion Q0 (or the nine numbers of R0), P0, V0 of the base."""

    q: Array
    qd: Array
    turned: Array
    P0: Array
    V0: Array

    @property
    def whole(self) -> Array:
        """All entries, one after the other."""
        return np.concatenate([self.q, self.qd, self.turned, self.P0, self.V0])


def start(machine: Machine, seed: int = 4, speed: float = 1.0) -> FloatingState:
    rng, n = np.random.default_rng(seed), len(machine.independent)
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    by_matrix = machine.floating is not None and machine.floating.orientation is Orientation.ROTATION
    turned = rotation(quaternion).ravel() if by_matrix else quaternion
    drawn = (speed * rng.uniform(-1, 1, n), turned, rng.uniform(-1, 1, 3), speed * rng.uniform(-1, 1, 6))
    return FloatingState(rng.uniform(-0.4, 0.4, n), *drawn)


def rotation(turned: Array) -> Array:
    """The matrix of a quaternion w x y z of any length, or of nine numbers."""
    if turned.size == 9:
        return turned.reshape(3, 3)
    w, *v = turned / np.linalg.norm(turned)
    return np.eye(3) + 2 * w * hat(np.array(v)) + 2 * hat(np.array(v)) @ hat(np.array(v))


def hat(w: Array) -> Array:
    x, y, z = w
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


class Given(Protocol):
    """The wrench on the base, motions of the motors, and their torques, over time."""

    def f0(self, t: float) -> Array: ...

    def y(self, t: float, order: int = 0) -> Array: ...

    def torque(self, t: float, q: Array, qd: Array, variant: str) -> Array: ...


class Course:
    """What is given of the motors and the wrench on the base over time, with derivatives."""

    def __init__(self, q: Array, qd: Array) -> None:
        self.q, self.qd, m = q, qd, len(q)
        self.kp, self.kd = 40 + 10.0 * np.arange(m), 3 + 1.0 * np.arange(m)

    def f0(self, t: float) -> Array:
        return np.array([5.0, -3.0, 20.0, 2.0, -1.0, 3.0]) * np.cos(15 * t + np.arange(6))

    def tau(self, t: float) -> Array:
        return 4 * np.sin(20 * t + 0.3) * np.ones(len(self.q))

    def y(self, t: float, order: int = 0) -> Array:
        """From the start on, with velocity and acceleration."""
        wave = 0.05 * 25.0**order * np.cos(25 * t + order * np.pi / 2)
        still = self.q - 0.05 if order == 0 else np.zeros(len(self.q))
        return still + wave + (self.qd * (t if order == 0 else 1.0) if order < 2 else 0.0)

    def torque(self, t: float, q: Array, qd: Array, variant: str) -> Array:
        servo = self.kp * (self.y(t) - q) + self.kd * (self.y(t, 1) - qd) if variant == "_servo" else 0.0
        return self.tau(t) + servo


def course(machine: Machine, at: FloatingState) -> Course:
    motors = list(machine.motor_entries)
    return Course(at.q[motors], at.qd[motors])


def integrated(
    machine: Machine,
    equations: Equations,
    at: FloatingState,
    variant: str,
    duration: float,
    given: Given,
    tolerance: float = TOLERANCE,
) -> Array:
    """The state at the end, by DOP853: orientation by its own differential equation, the quaternion normalised."""
    n, motors = len(machine.independent), list(machine.motor_entries)
    k = at.turned.size

    def rate(t: float, y: Array) -> Array:
        q, qd, turned, _, V0 = np.split(y, [n, 2 * n, 2 * n + k, 2 * n + k + 3])
        if variant == "_driven":
            q, qd = q.copy(), qd.copy()
            q[motors], qd[motors] = given.y(t), given.y(t, 1)
        R, v, w = rotation(turned), V0[:3], V0[3:]
        found = accelerations(t, R, V0, q, qd)
        moved = np.concatenate([found[:3] - np.cross(w, v), found[3:6]])
        return np.concatenate([qd, found[6:], turning(turned, w), R @ v, moved])

    def accelerations(t: float, R: Array, V0: Array, q: Array, qd: Array) -> Array:
        A, right = equations(R, V0, q, qd)
        right, of_motors = right + np.concatenate([given.f0(t), np.zeros(n)]), [6 + j for j in motors]
        if variant != "_driven":
            right[of_motors] += given.torque(t, q[motors], qd[motors], variant)
            return np.linalg.solve(A, right)
        found, free = np.zeros(6 + n), [j for j in range(6 + n) if j not in of_motors]
        found[of_motors] = given.y(t, 2)
        found[free] = np.linalg.solve(A[np.ix_(free, free)], right[free] - A[np.ix_(free, of_motors)] @ given.y(t, 2))
        return found

    solved = solve_ivp(rate, (0, duration), at.whole, method="DOP853", rtol=tolerance, atol=tolerance)
    end: Array = solved.y[:, -1]
    if k == 4:
        end[2 * n : 2 * n + 4] /= np.linalg.norm(end[2 * n : 2 * n + 4])
    return end


def turning(turned: Array, w: Array) -> Array:
    """Rate of a rotation, or of a quaternion, that turns with w in axes of the base."""
    if turned.size == 9:
        found: Array = (rotation(turned) @ hat(w)).ravel()
        return found
    s, v = turned[0], turned[1:]
    return 0.5 * np.array([-v @ w, *(s * w + np.cross(v, w))])


def stepped(
    module: ModuleType, method: str, variant: str, at: FloatingState, duration: float, count: int, given: Course
) -> Array:
    """The state at the end of so many generated steps."""
    function: Callable[..., Any] = getattr(module, f"step_{method}{variant}")
    nodes = [float(x) for x in dict.fromkeys(times_of(METHODS[method]))]
    h, state = duration / count, (at.q, at.qd, at.turned, at.P0, at.V0)
    for k in range(count):
        times = [h * (k + x) for x in nodes]
        y = [[given.y(t, order) for t in times] for order in (0, 1, 2)]
        tau, f0 = [given.tau(t) for t in times], [given.f0(t) for t in times]
        rows = {"": [tau, f0], "_servo": [tau, y[0], y[1], f0, given.kp, given.kd], "_driven": [*y, f0]}[variant]
        state = function(*rows, h, *state)
    return np.concatenate(state)
