"""Dry friction that creeps on joints without a motor: even steps and the ladder follow it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symoro_elastic as se

MASSES, STIFFNESS, DAMPING = (3.0, 5.0), 2e4, 40.0
STROKE, DURATION = 0.05, 0.3


def drive(kind: str, creep: float, coulomb: float = 4.0) -> dict[str, Any]:
    """A motor that slides, and a load that it carries on a spring, or that slides on it."""
    rows = [
        {"name": "motor", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "z1"},
        {"name": "load", "antecedent": "motor", "kind": kind, "sigma": 1, "r": "z2"},
    ]
    bodies = {name: {"mass": mass} for name, mass in zip(("motor", "load"), MASSES, strict=True)}
    law = {"springs": {"load": {"stiffness": STIFFNESS, "damping": DAMPING}}} if kind == "elastic" else {}
    friction = {"load": {"coulomb": coulomb, "creep": creep} if creep else {"coulomb": coulomb}}
    return {"name": "drive", "gravity": [0, 0, 0], "joints": rows, "bodies": bodies, "friction": friction, **law}


def scene(tolerance: float = 1e-5) -> dict[str, Any]:
    motion = {"duration": DURATION, "moves": [{"motor": "motor", "by": STROKE, "in": 0.2}]}
    return {"motion": motion, "wanted": {"outputs": ["load.z"], "tolerance": tolerance}}


def truth(kind: str, creep: float, times: np.ndarray, accelerations: Any) -> np.ndarray:
    """Position of the load by scipy, the motor's acceleration given: m2 (a + x'') = - k x - d x' - F."""
    k, d = (STIFFNESS, DAMPING) if kind == "elastic" else (0.0, 0.0)

    def rate(t: float, y: np.ndarray) -> list[float]:
        rubbing = 4.0 * y[1] / np.hypot(y[1], creep)
        return [y[1], -accelerations(t) - (k * y[0] + d * y[1] + rubbing) / MASSES[1]]

    return solve_ivp(rate, (0, DURATION), [0.0, 0.0], method="LSODA", t_eval=times, rtol=1e-9, atol=1e-12).y[0]


THOROUGH = [("passive", "w3"), ("elastic", "rk4"), ("passive", "rk4")]


@pytest.mark.parametrize(
    ("kind", "method"), [("elastic", "w3"), *(pytest.param(*one, marks=pytest.mark.thorough) for one in THOROUGH)]
)
def test_even_steps_follow_friction_that_creeps(kind: str, method: str) -> None:
    (found,) = se.simulate(drive(kind, 1e-2), scene(), method=method, step=1e-4)
    t, q, a = found.motion.t, found.motion.q, found.motion.qdd
    wanted = truth(kind, 1e-2, t, lambda x: np.interp(x, t, a[:, 0]))
    assert np.abs(wanted).max() > 1e-4
    assert np.abs(q[:, 1] - wanted).max() < 1e-3 * np.abs(wanted).max()


@pytest.mark.thorough
def test_the_ladder_takes_friction_that_creeps() -> None:
    found = se.ladder(drive("elastic", 1e-2), scene(1e-4))
    assert found.rungs


@pytest.mark.parametrize(
    ("function", "way_out"),
    [
        (se.ladder, "load has no motor, so dry friction holds it at times, .*: give its friction a creep velocity"),
        (lambda m, s: se.simulate(m, s, method="w3", step=1e-3), "friction, load: .* give creep beside it"),
    ],
)
def test_friction_that_sticks_is_refused_with_the_way_out(function: Any, way_out: str) -> None:
    with pytest.raises(se.InputError, match=way_out):
        function(drive("elastic", 0.0), scene())
