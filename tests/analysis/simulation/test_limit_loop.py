"""A position loop closed over backlash: without it all comes to rest, with it a limit loop lasts; own integration.

Parameters are chosen here, in no publication: motor 1 kg, load 2 kg, spring 1e5 N/m with 1 mm of backlash, Kv 10 1/s,
Kp 100 N s/m, Tn 50 ms on the position of the load.
"""

from __future__ import annotations

import shutil
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.array_types import Array
from tests.analysis.simulation.test_driven import SHORT, drive
from tests.analysis.simulation.test_driven import scene as rotating

scipy_integrate = pytest.importorskip("scipy.integrate")
pytestmark = pytest.mark.skipif(not (shutil.which("gcc") or shutil.which("clang")), reason="needs a C compiler")

MOTOR, LOAD, STIFFNESS, DAMPING, BACKLASH = 1.0, 2.0, 1e5, 20.0, 1e-3
KV, KP, TN, BY, IN = 10.0, 100.0, 0.05, 5e-3, 0.1


def axis(measured: str, **spring: float) -> dict[str, Any]:
    return {
        "name": "axis",
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 1, "r": "q1"},
            {"name": "load", "antecedent": "motor", "kind": "elastic", "sigma": 1, "r": "q2"},
        ],
        "bodies": {"load": {"mass": LOAD}},
        "motors": {"motor": {"rotor_inertia": MOTOR}},
        "springs": {"load": {"stiffness": STIFFNESS, "damping": DAMPING} | spring},
        "drives": {"motor": {"Kv": KV, "Kp": KP, "Tn": TN, "measured": measured}},
    }


def scene(duration: float, tolerance: float = 1e-6) -> dict[str, Any]:
    moves = [{"motor": "motor", "by": BY, "in": IN}]
    motion = {"duration": duration, "moves": moves, "drives": True}
    return {"motion": motion, "wanted": {"tolerance": {"load.z": tolerance}}}


def own_motion(t: Array, backlash: float) -> Array:
    """q1 + q2 (N,): MOTOR q1'' = tau + S, LOAD (q1'' + q2'') = -S, S = k D(q2) + c D'(q2) q2' (D3)."""
    half, e = backlash / 2, backlash / 50

    def rate(time: float, y: Array) -> list[float]:
        q1, q2, v1, v2, xi = y
        x = min(time / IN, 1.0)
        r, rd = BY * x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3), BY * 140 * x**3 * (1 - x) ** 3 / IN
        over, under = np.hypot(q2 + half, e), np.hypot(q2 - half, e)
        D = q2 - (over - under) / 2 if backlash else q2
        slope = 1 - ((q2 + half) / over - (q2 - half) / under) / 2 if backlash else 1.0
        S, error = STIFFNESS * D + DAMPING * slope * v2, KV * (r - q1 - q2) + rd - v1
        a1 = (KP * (error + xi / TN) + S) / MOTOR
        return [v1, v2, a1, -S / LOAD - a1, error]

    options = {"rtol": 1e-9, "atol": 1e-12, "max_step": 1e-3}
    y = scipy_integrate.solve_ivp(rate, (0, t[-1]), np.zeros(5), "DOP853", t_eval=t, **options).y
    return np.asarray(y[0] + y[1])


@pytest.mark.thorough
def test_backlash_makes_a_limit_loop() -> None:
    """Eight swings of even steps, with amplitude and period of an own integration, which lasts."""
    (found,) = se.simulate(axis("load.z", backlash=BACKLASH), scene(2.0), method="w3")
    t, z = found.motion.t, found.motion.q.sum(axis=1)
    wanted = own_motion(t, BACKLASH)
    assert np.abs(z - wanted).max() < 5e-6
    late, z, wanted = t > 1.0, z - BY, wanted - BY
    assert np.ptp(wanted[late]) > 1.2 * BACKLASH
    assert abs(np.ptp(z[late]) / np.ptp(wanted[late]) - 1) < 1e-3
    rising = [np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0) & late[1:]) for x in (z, wanted)]
    assert len(rising[0]) == len(rising[1]) >= 3
    assert np.abs(t[rising[0]] - t[rising[1]]).max() <= 2 * np.diff(t).max()
    last, before = (np.ptp(x) for x in (z[t > 1.5], z[(t > 1.0) & (t <= 1.5)]))
    assert abs(last / before - 1) < 0.02


@pytest.mark.thorough
@pytest.mark.parametrize("measured", ["load.z", "load at (0, 0, 0.2).z", "load.q"])
def test_loads_are_measured_by_even_steps(measured: str) -> None:
    """As adapted steps measure them; the deflection of a spring is no position of a load, and is refused."""
    if measured == "load.q":
        with pytest.raises(se.InputError, match=r"load\.q does not move with motor here"):
            se.simulate(axis(measured), scene(0.15))
        return
    (even,) = se.simulate(axis(measured), scene(0.15), method="w3")
    z = even.motion.q.sum(axis=1)
    assert np.abs(z - own_motion(even.motion.t, 0.0)).max() < 2e-6
    motors = own_motion(even.motion.t, 0.0) - even.motion.q[:, 0]
    assert np.abs(motors).max() > 1e-5


@pytest.mark.thorough
def test_a_position_that_turns_with_its_motor() -> None:
    """A point of a turning arm, whose ratio changes on the way: even steps as adapted ones."""
    made = drive(measured="arm at (0.3, 0, 0).y", Kv=10)
    moved = SHORT | {"moves": [{"motor": "motor", "by": 0.2, "in": 0.02}]}
    even, adapted = (se.simulate(made, rotating(**moved), adaptive=way)[0].motion for way in (False, True))
    assert np.abs(even.q[-1] - adapted.q[-1]).max() < 2e-7
    (plain,) = se.simulate(drive(Kv=10), rotating(**moved))
    assert np.abs(plain.motion.q[-1] - even.q[-1]).max() > 1e-5
