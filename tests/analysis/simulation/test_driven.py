"""Motions of motors with drives: against the linear system of all loops, against servos, and what is refused."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.control import with_gains
from symoro_elastic.foundation.errors import InputError

scipy_integrate = pytest.importorskip("scipy.integrate")
pytestmark = pytest.mark.skipif(not (shutil.which("gcc") or shutil.which("clang")), reason="needs a C compiler")

EXAMPLES = Path(__file__).parents[3] / "examples"


def drive(**changes: Any) -> dict[str, Any]:
    """A motor with drive, spring and load; linear."""
    given = {"Kv": 20, "Kp": 2.5, "Tn": 0.02, "current": {"lag": 4e-4}, "dead_time": 3.75e-4} | changes
    return {
        "name": "drive",
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "arm", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        ],
        "bodies": {"arm": {"inertia_at_origin": [0, 0, 0.05]}},
        "motors": {"motor": {"rotor_inertia": 0.02}},
        "springs": {"arm": {"stiffness": 1000.0, "damping": 0.1}},
        "drives": {"motor": given},
    }


def wound(**limits: float) -> dict[str, Any]:
    """The same with a winding, and limits of it."""
    made = drive(current={"kp": 4.0, "ti": 3e-3}, limits=limits)
    made["motors"]["motor"] |= {"resistance": 0.5, "inductance": 2e-3, "torque_constant": 0.2}
    return made


def scene(**changes: Any) -> dict[str, Any]:
    motion = {
        "duration": 0.1,
        "moves": [{"motor": "motor", "by": 0.1, "in": 0.06}],
        "forces": [{"at": "arm", "mz": 2.0, "from": 0.05, "in": 0.01}],
        "drives": True,
    }
    return {"motion": motion | changes, "wanted": {"tolerance": {"arm.q": 1e-7, "motor.q": 1e-7}}}


SHORT = {
    "duration": 0.03,
    "moves": [{"motor": "motor", "by": 0.02, "in": 0.02}],
    "forces": [{"at": "arm", "mz": 2.0, "from": 0.015, "in": 0.005}],
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"Tn": 0.05, "filters": [{"notch": 35, "depth": 0.1, "width": 0.6}, {"lowpass": 300, "order": 2}]},
        {"measured": "arm.rz", "Kv": 10},
    ],
)
def test_a_linear_machine_moves_as_its_closed_loops_do(changes: dict[str, Any]) -> None:
    """By scipy on A of `control`, whose poles are those of python-control elsewhere."""
    (found,) = se.simulate(drive(**changes), scene(**SHORT), adaptive=True)
    control = se.control(drive(**changes))
    loop, t = control.loops[0], found.motion.t
    moment = control.plants[0].linear.motion  # the moment turns both joints
    assert moment.names == ["motor", "arm"]

    def rate(time: float, x: np.ndarray) -> np.ndarray:
        r, rd, rdd = (row[0] for row in found.reference.at(np.array([time])))
        wrench = found.reference.wrenches(np.array([time]))[0][0]
        set_points = sum(B @ x for B, x in zip(loop.by_set_point, (r, rd, rdd), strict=True))
        return loop.A @ x + set_points + loop.by_force @ np.full(2, wrench[5])

    expected = scipy_integrate.solve_ivp(
        rate, (0, t[-1]), np.zeros(len(loop.A)), "DOP853", t[::20], rtol=1e-9, atol=1e-11, max_step=1e-3
    ).y[:2].T  # fmt: skip
    assert np.abs(found.motion.q[::20] - expected).max() < 1e-7
    assert found.is_within


@pytest.mark.thorough
def test_a_proportional_drive_without_a_path_is_a_servo() -> None:
    """kp = Kp Kv and kd = Kp, on an arm under gravity."""
    arm = se.read(EXAMPLES / "planar_2r.toml")
    motors = [joint.name for joint in arm.motor_joints]
    gains = {motors[0]: (400.0, 15.0), motors[1]: (150.0, 12.0)}
    rows = {name: f"{name} = {{ Kv = {kv}, Kp = {kp / 10} }}" for name, (kp, kv) in gains.items()}
    text = (EXAMPLES / "planar_2r.toml").read_text() + "\n[drives]\n" + "\n".join(rows.values())
    from symoro_elastic.formats.toml import reading

    driven = reading.read(text, "planar.toml")
    motion = {"duration": 0.1, "moves": [{"motor": name, "by": 0.1, "in": 0.06} for name in motors]}
    wanted = {"tolerance": {f"{name}.q": 1e-8 for name in motors}}
    servo = {name: {"kp": kp / 10 * kv, "kd": kp / 10} for name, (kp, kv) in gains.items()}
    (by_drives,) = se.simulate(driven, {"motion": {**motion, "drives": True}, "wanted": wanted}, adaptive=True)
    (by_servos,) = se.simulate(driven, {"motion": {**motion, "servo": servo}, "wanted": wanted}, adaptive=True)
    assert np.abs(by_drives.motion.q[-1] - by_servos.motion.q[-1]).max() < 1e-7
    assert np.abs(by_drives.motion.tau[-1] - by_servos.motion.tau[-1]).max() < 1e-4
    assert "[drives] are not simulated" in "".join(str(part) for part in by_servos.parts())
    assert "[drives]" not in "".join(str(part) for part in by_drives.parts())


@pytest.mark.thorough
def test_derivatives_are_those_of_the_right_side(tmp_path: Path) -> None:
    from symoro_elastic.analysis.simulation.driven import DrivenMotion
    from symoro_elastic.api.motions import Integrating, plan

    machine = with_gains(se.read(EXAMPLES / "two_axis.toml"), se.control(EXAMPLES / "two_axis.toml", damping=0.02))
    motion = {"duration": 0.1, "moves": [{"motor": "motor_x", "by": 0.01, "in": 0.05}], "drives": True}
    system = DrivenMotion(plan(machine, {"motion": motion}, Integrating()).references[0], tmp_path)
    near, y = system.reference.at_start, system.start
    y = y + 1e-4 * np.random.default_rng(2).normal(size=len(y))
    J = system.jacobian(0.02, y, near)
    steps = 1e-6 * np.maximum(1e-3, np.abs(y))
    for k, h in enumerate(steps):
        e = np.eye(len(y))[k] * h
        column = (system.rate(0.02, y + e, near) - system.rate(0.02, y - e, near)) / (2 * h)
        assert np.allclose(J[:, k], column, rtol=1e-4, atol=1e-6 * np.abs(J).max()), k


HANGING = {"arm": {"mass": 1, "center_of_mass": [0.5, 0, 0], "inertia": [0, 0.05, 0.05]}}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("machine", "motion", "options", "what"),
    [
        (
            drive(measured="arm.rz"),
            {},
            {},
            "measured: even steps do not measure rotations of frames: simulate with adaptive",
        ),
        (
            drive(limits={"torque": 2.0}) | {"gravity": [0, -9.81, 0], "bodies": HANGING},
            {},
            {},
            "motor, limits: 2 does not hold the machine at the start, which needs 4.905: raise it",
        ),
        (
            wound(voltage=10.0) | {"gravity": [0, -9.81, 0], "bodies": HANGING},
            {},
            {},
            "limits, voltage: its torque at rest, 4, does not hold the machine at the start, which needs 4.905",
        ),
        (drive(), {}, {"method": "rodas4", "step": 1e-3}, "method: rodas4 is not offered with drives: use w3"),
        (
            drive(current={"lag": 2e-4}),
            {},
            {"method": "rk4", "step": 1e-3},
            "step: 0.001 s is beyond the limit of rk4 here: give at most 0.000557 s, or w3, w2",
        ),
        (drive(Kp="tuned"), {}, {"adaptive": True}, 'drives, motor, Kp: is "tuned", which is no number'),
        (drive() | {"drives": {}}, {}, {"adaptive": True}, "motor has none: give one to all motors below [drives]"),
        (drive(), {"servo": {"motor": {"kp": 1, "kd": 1}}}, {"adaptive": True}, "motors have drives or servos"),
    ],
)
def test_what_is_not_simulated_is_refused(machine: Any, motion: Any, options: Any, what: str) -> None:
    with pytest.raises(InputError) as error:
        se.simulate(machine, scene(**motion), **options)
    assert what in str(error.value)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "changes",
    [
        {"dead_time": 2e-4, "filters": [{"notch": 35, "depth": 0.1, "width": 0.6}]},
        {"limits": {"torque": 5.0}, "filters": [{"lowpass": 300}], "set_point": {"lowpass": 80, "order": 2}},
    ],
)
def test_even_steps_are_the_adapted_ones(changes: dict[str, Any]) -> None:
    """Generated steps with states of drives against numpy with systems of `control`; weight and feed-forward too."""
    made = drive(**changes, feed_forward={"velocity": 0.9, "acceleration": 0.05}) | {"gravity": [0, -9.81, 0]}
    made["bodies"] = {"arm": {"mass": 1, "center_of_mass": [0.1, 0, 0], "inertia": [0, 0, 0.05]}}
    (even,), (adapted,) = se.simulate(made, scene()), se.simulate(made, scene(), adaptive=True)
    assert even.trajectory.method == "w3"
    assert np.abs(even.motion.q[-1] - adapted.motion.q[-1]).max() < 3e-7
    assert np.abs(even.motion.tau[0] - adapted.motion.tau[0]).max() < 1e-9
    assert np.abs(even.motion.tau[-1] - adapted.motion.tau[-1]).max() < 1e-4


LIMITED = {"limits": {"torque": 3.0, "windup": 0.008}, "set_point": {"lowpass": 60, "order": 2}}
FILTERED = {"filters": [{"notch": 35, "depth": 0.1, "width": 0.6}], "feed_forward": {"acceleration": 0.05}}


def by_hand(given: dict[str, Any], reference: Any, t: np.ndarray) -> np.ndarray:
    """q (N, 2) of `drive` with a limit, a filter of the set point, at most a notch, and a lag; by Radau.

    The filter of the set point is of r, rd and rdd each, as that of controllers.
    """
    Kv, Kp, Tn, lag, acceleration = 20, 2.5, 0.02, 4e-4, given.get("feed_forward", {}).get("acceleration", 0)
    limit, Tt = given["limits"]["torque"], given["limits"].get("windup", Tn)
    w, order = 2 * np.pi * given["set_point"]["lowpass"], given["set_point"].get("order", 1)
    M, wn = np.array([[0.07, 0.05], [0.05, 0.05]]), 2 * np.pi * 35

    def rate(time: float, x: np.ndarray) -> np.ndarray:
        (q, v), (xi, tau, p, pd), F = (x[:2], x[2:4]), x[4:8], x[8:].reshape(3, 2)
        set_points = np.array([row[0] for row in reference.at(np.array([time]))])
        if order == 1:
            shaped = np.stack([w * (set_points[:, 0] - F[:, 0]), np.zeros(3)], axis=1)
        else:
            shaped = np.stack([F[:, 1], w * w * (set_points[:, 0] - F[:, 0]) - 2**0.5 * w * F[:, 1]], axis=1)
        e = Kv * (F[0, 0] - q[0]) + F[1, 0] - v[0]
        u = Kp * (e + xi / Tn) + acceleration * F[2, 0]
        pdd = u - 2 * 0.6 * wn * pd - wn * wn * p
        f = pdd + 2 * 0.1 * wn * pd + wn * wn * p if "filters" in given else u
        held = min(limit, max(-limit, f))
        qdd = np.linalg.solve(M, [tau, -1000 * q[1] - 0.1 * v[1]])
        own = [e + (held - f) * Tn / (Kp * Tt), (held - tau) / lag, pd, pdd]
        return np.concatenate([v, qdd, own, shaped.ravel()])

    options = {"rtol": 1e-10, "atol": 1e-12, "max_step": 2e-4}
    return np.asarray(scipy_integrate.solve_ivp(rate, (0, t[-1]), np.zeros(14), "Radau", t, **options).y[:2].T)


@pytest.mark.thorough
@pytest.mark.parametrize("changes", [LIMITED, LIMITED | FILTERED | {"set_point": {"lowpass": 60}}])
def test_limits_and_filters_of_set_points_are_those_of_equations_by_hand(changes: dict[str, Any]) -> None:
    motion = {"duration": 0.06, "moves": [{"motor": "motor", "by": 0.1, "in": 0.03}], "forces": []}
    wanted = {"wanted": {"tolerance": {"arm.q": 1e-9, "motor.q": 1e-9}}}
    (found,) = se.simulate(drive(dead_time=0, **changes), scene(**motion) | wanted, adaptive=True)
    some = slice(None, None, 20)
    expected = by_hand(changes, found.reference, found.motion.t[some])
    assert np.abs(found.motion.tau).max() > 2.9
    assert np.abs(found.motion.q[some] - expected).max() < 1e-8


@pytest.mark.thorough
def test_back_calculation_overshoots_less_than_an_integral_that_winds_up() -> None:
    """A move three times as fast as the limit allows; a long `windup` is next to none."""
    motion = {"duration": 0.4, "moves": [{"motor": "motor", "by": 1.0, "in": 0.08}], "forces": []}
    wanted = {"wanted": {"tolerance": {"arm.q": 1e-3, "motor.q": 1e-3}}}
    overshoot = []
    for windup in (0.02, 1e3):
        limits = {"torque": 4.0, "windup": windup}
        (found,) = se.simulate(drive(limits=limits), scene(**motion) | wanted, step=2e-4, method="w3")
        overshoot.append(found.motion.q[:, 0].max() - 1)
    assert 0 <= overshoot[0] < overshoot[1] / 2


@pytest.mark.thorough
def test_a_limit_that_is_not_reached_changes_nothing() -> None:
    filters = {"filters": [{"notch": 35, "depth": 0.1, "width": 0.6}]}
    (free,) = se.simulate(drive(**filters), scene(**SHORT), step=1e-4, method="w3")
    (limited,) = se.simulate(drive(limits={"torque": 1e3}, **filters), scene(**SHORT), step=1e-4, method="w3")
    assert np.abs(limited.motion.q[-1] - free.motion.q[-1]).max() < 1e-7


def test_slopes_of_a_limited_law_are_those_of_its_rates() -> None:
    from symoro_elastic.analysis.control.cascade import Biquad, Cascade, CurrentLoop, DeadTime, FirstOrder
    from symoro_elastic.analysis.control.drive_laws import law_of

    path = (DeadTime("dead time", 3e-4), Biquad("notch", 40.0, 0.1, 0.5))
    for shaped in (FirstOrder("low-pass", 5e-3), Biquad("low-pass", 60.0, 0.0, 0.7, low=True), None):
        winding = CurrentLoop(4.0, 3e-3, 0.5, 2e-3, 0.01, compensated=0.02)
        limits = {"torque_limit": 3.0, "voltage_limit": 4.0, "windup": 0.01}
        law = law_of(Cascade("m", 20.0, 2.5, 0.02, (*path, winding), 0.9, 0.1, set_point=shaped, **limits))
        for size in (1e-3, 1.0):  # within the limit, and beyond
            n, rng = len(law.A), np.random.default_rng(4)
            z, u = size * rng.normal(size=n), size * rng.normal(size=6)
            A, B, C, D = law.slopes(z, u)
            h = 1e-4 * size
            for slope, torque, dz, du in (
                *((A[:, k], C[k], h * np.eye(n)[k], np.zeros(6)) for k in range(n)),
                *((B[:, k], D[k], np.zeros(n), h * np.eye(6)[k]) for k in range(6)),
            ):
                change = (law.rates(z + dz, u + du) - law.rates(z - dz, u - du)) / (2 * h)
                assert np.allclose(slope, change, rtol=1e-6, atol=1e-5 * np.abs(slope).max() + 1e-4)
                change = (law.torques(z + dz, u + du) - law.torques(z - dz, u - du)) / (2 * h)
                assert np.allclose(torque, change, rtol=1e-6, atol=1e-5)


@pytest.mark.thorough
def test_a_winding_is_that_of_an_own_integration() -> None:
    """States in A, V and rad, written out for this motor: back-EMF, current controller, cascade, spring."""
    R, L, Kt, Ke, kp, ti = 0.5, 2e-3, 0.2, 0.15, 4.0, 3e-3
    tables = drive(current={"kp": kp, "ti": ti}, dead_time=0, Tn=0.05)
    tables["motors"] = {
        "motor": {"rotor_inertia": 0.02, "resistance": R, "inductance": L, "torque_constant": Kt, "back_emf": Ke}
    }
    motion = scene(**{**SHORT, "forces": []})
    (found,) = se.simulate(tables, motion, adaptive=True)
    free = {**tables, "motors": {"motor": {**tables["motors"]["motor"], "back_emf": 1e-9}}}
    (without,) = se.simulate(free, motion, adaptive=True)
    J, Jl, k, d, Kv, Kp, Tn = 0.02, 0.05, 1000.0, 0.1, 20.0, 2.5, 0.05
    at = found.reference.at

    def rate(t: float, y: Any) -> Any:
        q, x, v, w, integral, i, volts = y
        (r,), (rd,), _ = (row[0] for row in at(np.array([t])))
        e = Kv * (r - q) + rd - v
        wanted = Kp * (e + integral / Tn) / Kt
        u = kp * (wanted - i) + volts
        spring = k * x + d * w
        a = (Kt * i + spring) / J
        b = -spring / Jl - a
        return np.array([v, w, a, b, e, (u - R * i - Ke * v) / L, kp / ti * (wanted - i)])

    y = scipy_integrate.solve_ivp(rate, (0, 0.03), np.zeros(7), method="Radau", rtol=1e-11, atol=1e-13).y[:, -1]
    np.testing.assert_allclose(found.motion.q[-1], y[:2], atol=2e-8)
    assert abs(found.motion.q[-1, 0] - without.motion.q[-1, 0]) > 1e-6, "the back-EMF brakes"


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("limits", "period"), [({"current": 3.0, "voltage": 2.0}, None), ({"voltage": 1.5}, 1e-3), ({"current": 2.5}, 1e-3)]
)
def test_limits_of_current_and_voltage_are_those_of_equations_by_hand(
    limits: dict[str, float], period: float | None
) -> None:
    """In A and V, continuous, and with a controller that is sampled; without spring."""
    R, L, Kt, n, kp, ti, share = 0.5, 2e-3, 0.02, 10.0, 4.0, 3e-3, 0.4
    J, Kv, Kp, Tn = 0.02 * n * n, 20.0, 3.0, 0.05
    given = {"current": {"kp": kp, "ti": ti, "compensation": share}, "dead_time": period or 0, "limits": limits}
    tables = drive(Kp=Kp, Tn=Tn, **given, **({"period": period} if period else {}))
    tables |= {"joints": tables["joints"][:1], "bodies": {}, "springs": {}}
    tables["motors"] = {"motor": {"rotor_inertia": 0.02, "ratio": n, "resistance": R, "inductance": L,
                                  "torque_constant": Kt}}  # fmt: skip
    motion = {"duration": 0.02, "moves": [{"motor": "motor", "by": 0.1, "in": 0.015}], "drives": True}
    (found,) = se.simulate(tables, {"motion": motion, "wanted": {"tolerance": {"motor.q": 1e-7}}}, adaptive=True)
    at, most, U = found.reference.at, limits.get("current", np.inf), limits.get("voltage", np.inf)

    def clipped(x: float, limit: float) -> float:
        return min(limit, max(-limit, x))

    def of_velocity(t: float, q: float, v: float, xi: float) -> tuple[float, float, float]:
        (r,), (rd,), _ = (row[0] for row in at(np.array([t])))
        e = Kv * (r - q) + rd - v
        xi = xi + (period or 0) * e
        f = Kp * (e + xi / Tn)
        held = clipped(f, n * Kt * most)
        return held, e + (held - f) / Kp, xi + (period or 0) * (held - f) / Kp

    def rate(t: float, y: Any, wanted: float | None) -> Any:
        q, v, xi, i, volts = y
        held, xid, _ = of_velocity(t, q, v, xi)
        held, xid = (held, xid) if wanted is None else (wanted, 0.0)
        lack = held / (n * Kt) - i
        free = kp * lack + volts + share * n * Kt * v
        u = clipped(free, U)
        return np.array([v, n * Kt * i / J, xid, (u - R * i - n * Kt * v) / L, kp / ti * lack + (u - free) / ti])

    y, wanted, options = np.zeros(5), 0.0, {"method": "Radau", "rtol": 1e-10, "atol": 1e-12, "max_step": 5e-5}
    count = round(motion["duration"] / period) if period else 1
    for k in range(count):
        span = (k * motion["duration"] / count, (k + 1) * motion["duration"] / count)
        next_one, _, later = of_velocity(span[0], y[0], y[1], y[2])
        y = scipy_integrate.solve_ivp(rate, span, y, args=(wanted if period else None,), **options).y[:, -1]
        if period:
            wanted, y[2] = next_one, later
    assert abs(found.motion.q[-1, 0] - y[0]) < 2e-8
    (free,) = se.simulate(tables | {"drives": {"motor": {**tables["drives"]["motor"], "limits": {}}}},
                          {"motion": motion}, adaptive=True)  # fmt: skip
    assert abs(found.motion.q[-1, 0] - free.motion.q[-1, 0]) > 1e-5, "the limits are reached"


@pytest.mark.thorough
def test_backlash_within_a_loop_around_the_load_is_that_of_equations_by_hand() -> None:
    """1 mrad between motor and load, whose position is controlled: the motor crosses it, D(x) of (D3)."""
    b, e, Kv, Kp, Tn, lag = 1e-3, 2e-5, 30.0, 2.5, 0.02, 4e-4
    tables = drive(measured="arm.rz", Kv=Kv, Kp=Kp, Tn=Tn, dead_time=0)
    tables["springs"]["arm"] |= {"backlash": b, "rounding": e}
    motion = {"duration": 0.03, "drives": True, "moves": [{"motor": "motor", "by": 0.004, "in": 0.015}]}
    wanted = {"tolerance": {"arm.q": 1e-6, "motor.q": 1e-6}}
    (found,) = se.simulate(tables, {"motion": motion, "wanted": wanted}, adaptive=True)

    def rounded(u: float) -> float:
        return float(np.hypot(u, e))

    def rate(t: float, y: Any) -> Any:
        q, x, v, w, xi, tau = y
        (r,), (rd,), _ = (row[0] for row in found.reference.at(np.array([t])))
        over, under = x + b / 2, x - b / 2
        pressed = x - (rounded(over) - rounded(under)) / 2
        share = 1 - (over / rounded(over) - under / rounded(under)) / 2
        spring = 1000 * pressed + 0.1 * share * w
        behind = Kv * (r - q - x) + rd - v
        a = (tau + spring) / 0.02
        return np.array([v, w, a, -spring / 0.05 - a, behind, (Kp * (behind + xi / Tn) - tau) / lag])

    t = found.motion.t[::25]
    y = scipy_integrate.solve_ivp(rate, (0, t[-1]), np.zeros(6), "DOP853", t, rtol=1e-10, atol=1e-13).y
    assert np.abs(found.motion.q[::25] - y[:2].T).max() < 1e-7
    assert y[1].min() < -b / 2 and y[1].max() > b / 2, "both flanks are touched"


@pytest.mark.thorough
def test_limits_of_current_and_voltage_are_those_of_an_own_integration() -> None:
    """Even steps; both limits act, the integral parts give way in Tn and ti; behind a gear that reverses."""
    R, L, Kt, Ke, kp, ti, ampere, volt = 0.5, 2e-3, 0.2, 0.15, 4.0, 3e-3, 12.0, 8.0
    tables = drive(current={"kp": kp, "ti": ti}, dead_time=0, Tn=0.05, limits={"current": ampere, "voltage": volt})
    winding = {"rotor_inertia": 0.02, "resistance": R, "inductance": L, "torque_constant": Kt, "back_emf": Ke}
    n = -3.0
    tables["motors"] = {"motor": winding | {"ratio": n}}
    motion = scene(duration=0.04, moves=[{"motor": "motor", "by": 0.15, "in": 0.03}], forces=[])
    (found,) = se.simulate(tables, motion)
    J, Jl, k, d, Kv, Kp, Tn = 0.02 * n * n, 0.05, 1000.0, 0.1, 20.0, 2.5, 0.05
    at, acted = found.reference.at, [0, 0]

    def rate(t: float, y: Any) -> Any:
        q, x, v, w, integral, i, volts = y
        (r,), (rd,), _ = (row[0] for row in at(np.array([t])))
        e = Kv * (r - q) + rd - v
        wanted = Kp * (e + integral / Tn) / (Kt * n)
        limited = min(max(wanted, -ampere), ampere)
        u = kp * (limited - i) + volts
        held = min(max(u, -volt), volt)
        acted[0] += limited != wanted
        acted[1] += held != u
        spring = k * x + d * w
        a = (Kt * n * i + spring) / J
        integral_rate = e + Kt * n * (limited - wanted) / Kp
        volts_rate = kp / ti * (limited - i) + (held - u) / ti
        return np.array([v, w, a, -spring / Jl - a, integral_rate, (held - R * i - Ke * n * v) / L, volts_rate])

    options = {"rtol": 1e-9, "atol": 1e-11, "max_step": 1e-4}
    y = scipy_integrate.solve_ivp(rate, (0, 0.04), np.zeros(7), method="Radau", **options).y[:, -1]
    assert min(acted) > 100
    np.testing.assert_allclose(found.motion.q[-1], y[:2], atol=2e-7)
    np.testing.assert_allclose(found.motion.tau[-1], Kt * n * y[5], atol=2e-4)
