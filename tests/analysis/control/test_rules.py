"""Gains by published rules: what their sources say of one inertia behind one lag, and the times of a torque's path."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.cascade import laplace
from symoro_elastic.analysis.control.control import RuledAxis, inertia, small_time

signal = pytest.importorskip("scipy.signal")

LAG, MASS = 1e-3, 30.0


def one_mass(**drive: Any) -> dict[str, Any]:
    joints = [{"name": "motor", "kind": "motor", "sigma": 1, "r": "x"}]
    drives = {"motor": {"Kp": 1000, "Kv": 10, "Tn": 0.1, "current": {"lag": LAG}, **drive}}
    return {
        "name": "mass",
        "gravity": [0, 0, 0],
        "joints": joints,
        "bodies": {"motor": {"mass": MASS}},
        "drives": drives,
    }


def rules() -> tuple[RuledAxis, RuledAxis]:
    amount, symmetrical = se.control(one_mass(), rule=True, damping=0.01).rules
    return amount, symmetrical


def overshoot(above: list[float], below: list[float]) -> float:
    t = np.linspace(0, 60 * LAG, 60_001)
    _, y = signal.step((above, below), T=t)
    return float(y.max() - 1)


@pytest.mark.thorough
def test_velocity_steps_overshoot_as_published() -> None:
    """4.3 % and 43.4 %, 37 degrees of phase: Kp (1 + 1/(Tn s))/(m s (1 + T s)) closed."""
    amount, symmetrical = rules()
    assert amount.time == symmetrical.time == LAG and amount.inertia == MASS
    Kp = amount.cascade.Kp
    assert overshoot([Kp], [MASS * LAG, MASS, Kp]) == pytest.approx(np.exp(-np.pi), abs=1e-5)
    Kp, Tn = symmetrical.cascade.Kp, symmetrical.cascade.Tn
    assert overshoot([Kp * Tn, Kp], [MASS * Tn * LAG, MASS * Tn, Kp * Tn, Kp]) == pytest.approx(0.434, abs=5e-4)
    drive = {"Kp": Kp, "Tn": Tn, "Kv": symmetrical.cascade.Kv}
    phase = se.control(one_mass(**drive)).places[0].axes[0].velocity.phase
    assert phase == pytest.approx(np.degrees(np.arctan(2) - np.arctan(0.5)), abs=1e-6)
    assert round(phase) == 37


def test_positions_do_not_overshoot_at_the_time_of_the_velocity_loop() -> None:
    """Kv/(s (1 + T_v s)) closed: at 1/(4 T_v) both poles are the same, above they swing."""
    for one, behind in zip(rules(), (2, 4), strict=True):
        Kv, T_v = one.cascade.Kv, behind * LAG
        poles = np.roots([T_v, 1, Kv])
        assert poles == pytest.approx(np.full(2, -1 / (2 * T_v)), rel=1e-6)


def test_the_time_of_a_path_is_its_slope_at_rest() -> None:
    filters = [{"notch": 300, "depth": 0.05, "width": 0.6}, {"lowpass": 800, "order": 2}, {"lowpass": 500, "order": 1}]
    drive = one_mass(period=5e-4, dead_time=4e-4, filters=filters)
    one = se.control(drive).cascades[0]
    f = 1e-3
    late = -np.angle(one.path_at(laplace(np.array([f])))[0]) / (2 * np.pi * f)
    assert sum(map(small_time, one.path)) == pytest.approx(late, rel=1e-7)


@pytest.mark.thorough
def test_the_inertia_is_that_of_rigid_springs() -> None:
    """All that motor_x moves, and its rotor; the rules know of no spring, and the loops say so."""
    found = se.control("examples/two_axis.toml", damping=0.02, rule=True)
    linear = found.plants[0].linear
    k = [*linear.motion.names].index("motor_x")
    joints = linear.motion.joints
    assert inertia(found.plants[0], "motor_x") == pytest.approx(linear.M[k, k], rel=1e-12) and len(joints) > k
    assert all(one.growth > 0 for one in found.rules) and len(found.rules) == 4
    assert any("published rules" in (getattr(part, "title", "") or "") for part in found.parts())


def test_drives_whose_torque_comes_at_once_have_no_rule() -> None:
    assert se.control(one_mass(current={"lag": 0}), rule=True).rules == ()
