"""A motor that carries a spring along and an arm on a second one; their stiffness and damping are parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.integrate import solve_ivp

from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Move, PrescribedMotion, Servo
from tests.analysis.ladder.truth import pinocchio_dynamics

TEXT = """
name = "carriage"
gravity = [0, -9.81, 0]
joints = [
  { name = "motor", kind = "motor",   sigma = 1, alpha = "pi/2",  r = "q1" },
  { name = "screw", kind = "elastic", sigma = 1, r = "q2" },
  { name = "arm",   kind = "elastic", sigma = 0, alpha = "-pi/2", theta = "q3" },
]
[parameters]
KS = 4e5
DS = 0
KA = 2e4
DA = 0
[bodies]
motor = { mass = 5 }
screw = { mass = 10 }
arm = { mass = 3, center_of_mass = [0.5, 0.1, 0], inertia = [0.2, 0.3, 0.4] }
[springs]
screw = { stiffness = "KS", damping = "DS" }
arm = { stiffness = "KA", damping = "DA" }
"""
STIFFNESS, INERTIA = np.array([4e5, 2e4]), np.array([13.0, 1.2])
"""Of screw and arm; what moves with each, about."""


def carriage() -> Machine:
    return toml.read(TEXT, "carriage.toml")


def values(times: float, damping: float) -> dict[str, float]:
    """Parameters with stiffness so many times as large, and a damping ratio."""
    k = STIFFNESS * times
    d = 2 * damping * np.sqrt(k * INERTIA)
    return {"KS": float(k[0]), "DS": float(d[0]), "KA": float(k[1]), "DA": float(d[1])}


def moved(given: Mapping[str, float] | None, by: float = 0.1, servo: Servo | None = None) -> Reference:
    """The motor by so much in 0.15 s of 0.2 s."""
    servos = {"motor": servo} if servo else {}
    motion = PrescribedMotion(0.2, {}, (Move("motor", by, 0.0, 0.15),), servo=servos, source="scene.toml")
    return reference_of(carriage(), motion, given)


def true_motion(reference: Reference, given: Mapping[str, float], t: Array) -> Array:
    """q (N, 3) under servos: A and H of Pinocchio, integrated by DOP853, by Radau where springs are stiff."""
    dynamics = pinocchio_dynamics(reference.machine)
    k, d = np.array([0, given["KS"], given["KA"]]), np.array([0, given["DS"], given["DA"]])
    assert reference.servo is not None
    kp, kd = reference.servo

    def rate(time: float, y: Array) -> Array:
        q, v = np.split(y, 2)
        (A,), (H,) = dynamics(q[None], v[None])
        wanted, moving, _ = reference.at(np.array([time]))
        forces = -k * q - d * v - H
        forces[0] += (reference.start.tau[0] + kp * (wanted[0] - q[:1]) + kd * (moving[0] - v[:1]))[0]
        return np.concatenate([v, np.linalg.solve(A, forces)])

    start = np.concatenate([reference.start.q, reference.start.qd])
    method = "Radau" if max(k) > 1e6 else "DOP853"
    found = solve_ivp(rate, (0, t[-1]), start, method, t, rtol=1e-7, atol=1e-10)
    assert found.success
    return found.y[:3].T
