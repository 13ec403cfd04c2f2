"""Adapted steps with states of friction, and friction that rises with load: against own equations in scipy."""

from __future__ import annotations

import shutil
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from tests.analysis.simulation.test_driven import drive
from tests.models.test_friction_states import rate_of_bristle

scipy_integrate = pytest.importorskip("scipy.integrate")
pytestmark = pytest.mark.skipif(not (shutil.which("gcc") or shutil.which("clang")), reason="needs a C compiler")

LAW = {
    "viscous": 0.02,
    "coulomb": 0.6,
    "static": 0.9,
    "stribeck": 0.05,
    "bristle": 600.0,
    "bristle_damping": 0.7,
    "breakaway": 0.7,
}
MOTOR, ARM, STIFFNESS, DAMPING = 0.02, 0.05, 1000.0, 0.1
SERVO = {"motor": {"kp": 120.0, "kd": 1.5}}
MOVES: list[dict[str, Any]] = [
    {"motor": "motor", "by": 0.05, "in": 0.04},
    {"motor": "motor", "by": -0.05, "from": 0.05, "in": 0.04},
]


def machine(**changes: Any) -> dict[str, Any]:
    made = drive()
    del made["drives"]
    return made | {"friction": {"motor": LAW}} | changes


def scene(tolerance: float, **motion: Any) -> dict[str, Any]:
    given = {"duration": 0.12, "moves": MOVES} | motion
    return {"motion": given, "wanted": {"tolerance": {"arm.q": tolerance, "motor.q": tolerance}}}


def own_motion(reference: Reference, t: Array) -> Array:
    """q1, q2 (N, 2) under the servo: 0.02 q1'' = tau - friction + k q2 + d q2', 0.05 (q1'' + q2'') = -k q2 - d q2'."""

    def rate(time: float, y: Array) -> list[float]:
        (r,), (rd,) = (x[0] for x in reference.at(np.array([time]))[:2])
        q1, q2, v1, v2, z = y
        zd = rate_of_bristle(v1, z, LAW)
        friction = LAW["bristle"] * z + LAW["bristle_damping"] * zd + LAW["viscous"] * v1
        spring = STIFFNESS * q2 + DAMPING * v2
        a1 = (120.0 * (r - q1) + 1.5 * (rd - v1) - friction + spring) / MOTOR
        return [v1, v2, a1, -spring / ARM - a1, zd]

    found = scipy_integrate.solve_ivp(rate, (0, t[-1]), np.zeros(5), "Radau", t_eval=t, rtol=1e-8, atol=1e-11)
    return np.asarray(found.y[:2].T)


@pytest.mark.thorough
def test_a_servo_against_own_equations() -> None:
    (found,) = se.simulate(machine(), scene(1e-5, servo=SERVO), adaptive=True)
    wanted = own_motion(found.reference, found.motion.t)
    error = np.abs(found.motion.q - wanted).max()
    assert error < 1e-7 and error < 2 * max(found.errors.values()) + 1e-9
    assert np.abs(found.motion.z).max() > 0.9 * LAW["coulomb"] / LAW["bristle"]


@pytest.mark.thorough
@pytest.mark.parametrize("way", ["drives", "sampled", "exact"])
def test_other_motors_against_even_steps(way: str) -> None:
    given = {"motor": {"Kv": 20, "Kp": 2.5, "Tn": 0.02, "current": {"lag": 4e-4}}}
    if way == "sampled":
        given["motor"] |= {"period": 1e-3}
    made = machine(drives=given) if way != "exact" else machine(friction={"arm": LAW})
    motion: dict[str, Any] = {} if way == "exact" else {"drives": True}
    (adapted,) = se.simulate(made, scene(1e-6, **motion), adaptive=True)
    (even,) = se.simulate(made, scene(1e-6, **motion))
    ends = [found.motion.q[-1] for found in (adapted, even)]
    assert np.abs(ends[0] - ends[1]).max() < 1e-6


LOADED = {"viscous": 0.02, "coulomb": 0.4, "load": 0.3, "creep": 0.02}
BODY = 0.03
"""Inertia of the motor's body, N m s^2/rad, behind its transmission; its rotor has that of MOTOR."""


def under_load(reference: Reference, t: Array, law: dict[str, float]) -> Array:
    """q1, q2 (N, 2), then lambda = tau - friction(lambda) - MOTOR q1'', by Brent."""
    brentq = pytest.importorskip("scipy.optimize").brentq

    def accelerations(time: float, y: Array) -> tuple[float, float, float, float]:
        (r,), (rd,) = (x[0] for x in reference.at(np.array([time]))[:2])
        q1, q2, v1, v2 = y[:4]
        tau, spring = 120.0 * (r - q1) + 1.5 * (rd - v1), STIFFNESS * q2 + DAMPING * v2

        def friction(load: float) -> tuple[float, float]:
            if "bristle" in law:
                zd = rate_of_bristle(v1, y[4], law, load)
                return law["bristle"] * y[4] + law["bristle_damping"] * zd + law["viscous"] * v1, zd
            dry = law["coulomb"] + law["load"] * abs(load)
            return dry * v1 / np.hypot(v1, law["creep"]) + law["viscous"] * v1, 0.0

        def first(load: float) -> float:
            return (tau - friction(load)[0] + spring) / (MOTOR + BODY)

        load = brentq(lambda x: x - (tau - friction(x)[0] - MOTOR * first(x)), -1e3, 1e3, xtol=1e-13, rtol=1e-14)
        return first(load), -spring / ARM - first(load), friction(load)[1], load

    def rate(time: float, y: Array) -> list[float]:
        a1, a2, zd, _ = accelerations(time, y)
        return [y[2], y[3], a1, a2, zd][: len(y)]

    start, options = np.zeros(4 + ("bristle" in law)), {"rtol": 1e-7, "atol": 1e-10}
    y = scipy_integrate.solve_ivp(rate, (0, t[-1]), start, "Radau", t_eval=t, **options).y.T
    loads = [accelerations(time, row)[3] for time, row in zip(t, y, strict=True)]
    return np.column_stack([y[:, :2], loads])


@pytest.mark.thorough
@pytest.mark.parametrize("law", [LOADED, LAW | {"load": 0.3}], ids=["creep", "bristle"])
def test_friction_that_rises_with_load(law: dict[str, float]) -> None:
    made = machine(friction={"motor": law})
    made["bodies"]["motor"] = {"inertia_at_origin": [0, 0, BODY]}
    move = {"motor": "motor", "by": 0.02, "in": 0.025}
    (found,) = se.simulate(made, scene(1e-4, duration=0.03, moves=[move], servo=SERVO), adaptive=True)
    wanted = under_load(found.reference, found.motion.t, law)
    assert np.abs(found.motion.q - wanted[:, :2]).max() < 1e-6
    assert np.abs(found.motion.load[:, 0] - wanted[:, 2]).max() < 1e-3 * np.abs(wanted[:, 2]).max()


@pytest.mark.thorough
def test_even_steps_find_loads_in_each_stage() -> None:
    """Their order is kept; loads are those of adapted steps, errors those that are said."""
    made = machine(friction={"motor": LOADED | {"creep": 0.2}})
    made["bodies"]["motor"] = {"inertia_at_origin": [0, 0, BODY]}
    given = scene(1e-9, duration=0.06, moves=MOVES[:1], servo=SERVO)
    (exact,) = se.simulate(made, given, adaptive=True)
    for method, order in (("w2", 1.9), ("w3", 2.7)):
        runs = [se.simulate(made, given, method=method, step=h)[0] for h in (5e-4, 1.25e-4)]
        errors = [np.abs(run.motion.q[-1] - exact.motion.q[-1]).max() for run in runs]
        assert np.log2(errors[0] / errors[1]) / 2 > order and errors[0] < 5e-6
        assert errors[0] < 1.5 * max(runs[0].errors.values())
        assert abs(runs[1].motion.load[-1] - exact.motion.load[-1]).max() < 1e-4
