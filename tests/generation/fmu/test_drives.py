"""FMUs of machines with drives and friction with states: own equations, CVODE, samples, states, what is refused."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(not shutil.which("cc") and not shutil.which("gcc"), reason="needs a C compiler")

from fmpy import simulate_fmu  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402
from scipy.optimize import fsolve  # noqa: E402
from scipy.signal import tf2ss  # noqa: E402

import symoro_elastic as se  # noqa: E402
from symoro_elastic.analysis.simulation.reference_motion import reference_of  # noqa: E402
from symoro_elastic.foundation.errors import InputError  # noqa: E402
from symoro_elastic.generation.fmu import Options  # noqa: E402
from symoro_elastic.generation.fmu.mock_up_unit import unit_of  # noqa: E402
from symoro_elastic.machine.drives import TUNED, Drives  # noqa: E402
from symoro_elastic.machine.formula import Formula  # noqa: E402
from symoro_elastic.machine.joints import Friction  # noqa: E402
from symoro_elastic.machine.scene import Scene  # noqa: E402
from tests.generation.fmu.running import CO_SIMULATION, MODEL_EXCHANGE, running  # noqa: E402

Machine = Any
MOTORS = ("drive", "rod")
TURN = {
    "Kv": 20, "Kp": 30, "Tn": 0.05, "current": {"lag": 2e-4}, "dead_time": 1.5e-4,
    "filters": [{"notch": 120, "depth": 0.05, "width": 0.5}, {"lowpass": 400, "order": 1}],
    "feed_forward": {"velocity": 1, "acceleration": 0.9},
}  # fmt: skip
SLIDE = {"Kv": 30, "Kp": 120, "current": {"lag": 1e-3}}
BRISTLE = {
    "viscous": 9, "coulomb": 4, "static": 5, "stribeck": 0.02, "bristle": 2e5, "bristle_damping": 30,
}  # fmt: skip
SHARES = (0.1, 0.2)
DRY = {"viscous": 0.2, "coulomb": 0.3, "creep": 0.05}
PERIOD = 5e-4
SAMPLED = {
    "drive": {**TURN, "period": PERIOD, "dead_time": 2e-4, "limits": {"torque": 24}},
    "rod": {
        **SLIDE, "current": {"kp": 4, "ti": 4e-3}, "period": PERIOD, "set_point": {"average": 4 * PERIOD},
        "limits": {"voltage": 6},
    },
}  # fmt: skip
"""A lag, and a winding whose voltage is at its limit for a time."""
WOUND = {"resistance": 0.5, "inductance": 2e-3, "torque_constant": 20}


def arm(drives: dict[str, Any], friction: dict[str, Any], dry: Any = None, **more: Any) -> Machine:
    """A turn with a spring behind it, and a slide that hangs on it."""
    joints = [
        {"name": "drive", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "arm", "antecedent": "drive", "kind": "elastic", "sigma": 0, "theta": "q2"},
        {"name": "rod", "antecedent": "arm", "kind": "motor", "sigma": 1, "alpha": "pi/2", "d": 0.6, "r": "q3"},
    ]
    bodies = {
        "arm": {"mass": 4, "center_of_mass": [0.3, 0.02, 0], "inertia": [0.02, 0.2, 0.2]},
        "rod": {"mass": 1.5, "center_of_mass": [0.05, 0, 0.1], "inertia": [0.01, 0.01, 0.003]},
    }
    return se.read(
        {
            "name": "driven_arm",
            "gravity": [0, -9.81, 0],
            "joints": joints,
            "bodies": bodies,
            "springs": {"arm": {"stiffness": 2000, "damping": 2.5}},
            "motors": {"drive": {"rotor_inertia": 0.5}, "rod": {"rotor_inertia": 0.1, **WOUND}},
            "friction": {"drive": dry or {"viscous": 0.2}, "rod": friction},
            "drives": drives,
            **more,
        }
    )


@cache
def continuous() -> Machine:
    return arm({"drive": TURN, "rod": SLIDE}, BRISTLE)


@cache
def loaded() -> Machine:
    """The same, with friction that rises with the torques through both motors."""
    return arm({"drive": TURN, "rod": SLIDE}, BRISTLE | {"load": SHARES[1]}, DRY | {"load": SHARES[0]})


def sampled(**more: Any) -> Machine:
    return arm(SAMPLED, {"viscous": 1.5}, **more)


CASES: dict[str, Callable[[], Machine]] = {"continuous": continuous, "sampled": sampled, "loaded": loaded}


@pytest.fixture(scope="module")
def units(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, int], Path]:
    folder = tmp_path_factory.mktemp("units")

    @cache
    def made(case: str, version: int) -> Path:
        path = folder / f"{case}{version}.fmu"
        path.write_bytes(unit_of(CASES[case](), Scene(), Options(version)).archive)
        return path

    return made


@pytest.mark.thorough
@pytest.mark.parametrize("case", [pytest.param("loaded", marks=pytest.mark.thorough), "sampled"])
def test_fmpy_finds_no_errors(units: Callable[[str, int], Path], case: str) -> None:
    for version in (2, 3):
        assert not validate_fmu(str(units(case, version)))


# Own equations: transfer functions of the drives in another form of states, (D2) as it is printed.
def _pade(T: float) -> Any:
    return tf2ss([T * T / 12, -T / 2, 1], [T * T / 12, T / 2, 1])


def _notch(f: float, depth: float, width: float) -> Any:
    w = 2 * np.pi * f
    return tf2ss([1, 2 * depth * w, w * w], [1, 2 * width * w, w * w])


PATHS = (
    (_pade(1.5e-4), tf2ss([1], [2e-4, 1]), _notch(120, 0.05, 0.5), tf2ss([800 * np.pi], [1, 800 * np.pi])),
    (tf2ss([1], [1e-3, 1]),),
)


def bristle_rate(v: float, z: float, more: float) -> float:
    g = 4 + (5 - 4) / (1 + (v / 0.02) ** 2) + more
    steady, alpha = g / 2e5, 0.0
    if v * z > 0:
        x = min(max((abs(z) - 0.7 * steady) / (steady - 0.7 * steady), 0.0), 1.0)
        alpha = 3 * x**2 - 2 * x**3
    return v - alpha * 2e5 * abs(v) / g * z


class Own:
    """y = [q, qd, bristle, integral part, paths] of the arm under constant inputs r, rd, rdd, tau (2,)."""

    def __init__(self, at: np.ndarray, held: np.ndarray, inputs: tuple[np.ndarray, ...], shares: Any) -> None:
        frictionless = tuple(replace(one, friction=Friction()) for one in continuous().joints)
        self.model = se.load(replace(continuous(), joints=frictionless), ["direct_dynamics"])
        self.inputs, self.shares, self.load = inputs, np.array(shares), np.zeros(2)
        rest = [np.linalg.solve(A, -B[:, 0] * u) for u, path in zip(held, PATHS, strict=True) for A, B, *_ in path]
        self.start = np.concatenate([at, np.zeros(5), *rest])

    def rate(self, _: float, y: np.ndarray) -> np.ndarray:
        q, qd, z, (r, rd, rdd, fed) = y[:3], y[3:6], y[6], self.inputs
        x, v = q[[0, 2]], qd[[0, 2]]
        e = np.array([20, 30]) * (r - x) + rd - v
        torque = np.array([30 * (e[0] + y[7] / 0.05) + 0.9 * rdd[0], 120 * e[1]]) + fed
        rates, first = [np.array([0.0, e[0]])], 8
        for k, path in enumerate(PATHS):
            for A, B, C, D in path:
                own = y[first : first + len(A)]
                rates.append(A @ own + B[:, 0] * torque[k])
                torque[k] = C[0] @ own + D[0, 0] * torque[k]
                first += len(A)

        def under(load: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
            level = self.shares * abs(load)
            dry = (0.3 + level[0]) * v[0] / np.hypot(v[0], 0.05) if self.shares.any() else 0.0
            zd = bristle_rate(v[1], z, level[1])
            friction = np.array([dry + 0.2 * v[0], 2e5 * z + 30 * zd + 9 * v[1]])
            qdd = self.model.direct_dynamics(q, qd, torque - friction)
            return qdd, torque - friction - np.array([0.5, 0.1]) * qdd[[0, 2]], zd

        if self.shares.any():
            self.load = fsolve(lambda x: under(x)[1] - x, self.load, xtol=1e-11)
        qdd, _, rates[0][0] = under(self.load)
        return np.concatenate([qd, qdd, *rates])


@pytest.mark.parametrize(
    ("case", "shares"), [("continuous", (0, 0)), pytest.param("loaded", SHARES, marks=pytest.mark.thorough)]
)
def test_states_of_drives_and_friction_are_those_of_own_equations(
    units: Callable[[str, int], Path], case: str, shares: tuple[float, float]
) -> None:
    """CVODE by FMPy within 1e-8, co-simulation nearer, against Radau on equations of its own."""
    names = [f"{joint}.{x}" for x in ("q", "qd") for joint in ("drive", "arm", "rod")] + ["rod.friction"]
    set_points = [f"{name}.{x}" for x in ("r", "rd", "rdd", "tau") for name in MOTORS]
    with running(units(case, 2)) as one:
        at, inputs = one.get(names[:3]), one.get(set_points).reshape(4, 2)
        held = inputs[3].copy()
        assert np.abs(one.get(one.rates) / one.nominals()).max() < 1e-9
        np.testing.assert_allclose(one.get(["drive.tau_m", "rod.tau_m"]), held, rtol=1e-12)
    inputs += [[0.02, 0.004], [0.03, 0.01], [0.1, 0.2], [0.5, -1]]
    own = Own(at, held, tuple(inputs), shares)
    run = solve_ivp(own.rate, (0, 0.05), own.start, method="Radau", rtol=1e-11, atol=1e-13, max_step=2e-3)
    expected = run.y[:7, -1]
    assert np.abs(expected[:3] - at).min() > 1e-4
    given = dict(zip(set_points, inputs.ravel().tolist(), strict=True))
    for version, kind, tolerance, bound in (
        (2, MODEL_EXCHANGE, 1e-10, 1e-8),
        (3, MODEL_EXCHANGE, 1e-10, 1e-8),
        (2, CO_SIMULATION, 1e-10, 1e-10),
        (3, CO_SIMULATION, 1e-10, 1e-10),
    ):
        found = simulate_fmu(
            str(units(case, version)),
            fmi_type=kind,
            stop_time=0.05,
            start_values=given,
            output=names,
            output_interval=1e-3,
            relative_tolerance=tolerance,
        )
        assert np.abs([found[name][-1] for name in names] - expected).max() < bound, kind


@pytest.mark.thorough
def test_parameters_of_drives_are_parameters(units: Callable[[str, int], Path]) -> None:
    """An FMU with another gain is that of the machine with that gain."""
    changed = arm({"drive": {**TURN, "Kp": 40, "current": {"lag": 4e-4}}, "rod": SLIDE}, BRISTLE)
    other = units("continuous", 2).with_name("changed.fmu")
    other.write_bytes(unit_of(changed, Scene(), Options(2)).archive)
    ends = []
    for path, more in ((units("continuous", 2), {"drive.Kp": 40.0, "drive.lag": 4e-4}), (other, {})):
        with running(path, CO_SIMULATION, 1e-10) as one:
            assert one.variables["drive.Kp"].unit == "N.m.s/rad"
            one.set({**more, "drive.r": 0.01})
            one.begin()
            one.step(0.0, 0.02)
            ends.append(one.get(one.states) / one.nominals())
    np.testing.assert_allclose(*ends, atol=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("case", CASES)
def test_directional_derivatives_are_those_of_differences(units: Callable[[str, int], Path], case: str) -> None:
    source = np.random.default_rng(5)
    with running(units(case, 2)) as one:
        one.begin()
        one.fmu.newDiscreteStates()
        start = one.get(one.states)
        one.set(dict(zip(one.states, start + one.nominals() * source.uniform(0.1, 0.2, len(start)), strict=True)))
        unknowns = [*one.rates, "drive.tau_m", "rod.tau_m"]
        for name in [*one.states, *one.named("input"), "drive.lag", "arm.stiffness"]:
            exact, (x,) = one.along(unknowns, {name: 1.0}), one.get([name])
            h = 1e-4 * (one.nominals()[one.states.index(name)] if name in one.states else abs(x) or 1.0)
            sides = []
            for sign in (1, -1):
                one.set({name: x + sign * h})
                sides.append(one.get(unknowns))
            one.set({name: x})
            slope = (sides[0] - sides[1]) / (2 * h)
            scale = np.abs(one.get(unknowns)).max() / h
            assert np.abs(slope - exact).max() <= 1e-5 * np.abs(exact).max() + 1e-9 * scale, name


MOVES = {
    "duration": 0.06,
    "moves": [{"motor": "drive", "by": 0.05, "in": 0.04}, {"motor": "rod", "by": 0.01, "in": 0.03}],
    "drives": True,
}


@pytest.mark.thorough
def test_sampled_drives_move_as_they_are_simulated(units: Callable[[str, int], Path]) -> None:
    """Limits, filters, dead times of a part and of a whole period; back from bytes in the middle."""
    machine = sampled(motion=[MOVES], wanted={"tolerance": 1e-9, "outputs": ["drive.q", "rod.q"]})
    (expected,) = se.simulate(machine, adaptive=True)
    reference, steps = reference_of(machine, machine.asked.motions[0]), 120
    names = [f"{joint}.{x}" for x in ("q", "qd") for joint in ("drive", "arm", "rod")]
    assert np.abs(expected.motion.tau[:, 0]).max() == pytest.approx(24)
    for version in (2, 3):
        with running(units("sampled", version), CO_SIMULATION, 1e-10) as one:
            one.begin()
            kept, found = b"", []
            for first in (0, 70):
                if first:
                    one.go_back(one.of_bytes(kept))
                for k in range(first, steps):
                    kept = one.as_bytes(one.state()) if k == 70 else kept
                    rates = (x[0].tolist() for x in reference.at(np.array([k * PERIOD])))
                    for key, x in zip(("r", "rd", "rdd"), rates, strict=True):
                        one.set({f"{name}.{key}": value for name, value in zip(MOTORS, x, strict=True)})
                    one.step(k * PERIOD, PERIOD)
                found.append(one.get(names))
        assert (found[0] == found[1]).all()
        motion = expected.motion
        assert np.abs(found[0] - np.concatenate([motion.q[-1], motion.qd[-1]])).max() < 1e-8


@pytest.mark.thorough
def test_time_events_of_model_exchange_are_the_samples(units: Callable[[str, int], Path]) -> None:
    """CVODE between events as co-simulation, whose steps are of any length."""
    names, ends = ["drive.q", "arm.q", "rod.q"], {}
    for version in (2, 3):
        for kind, interval in ((MODEL_EXCHANGE, 1e-3), (CO_SIMULATION, 7e-3)):
            found = simulate_fmu(
                str(units("sampled", version)),
                fmi_type=kind,
                stop_time=0.035,
                start_values={"drive.r": 0.01, "rod.r": 0.002},
                output=names,
                output_interval=interval,
                relative_tolerance=1e-10,
            )
            ends[version, kind] = np.array([found[name][-1] for name in names])
    first = ends[2, CO_SIMULATION]
    assert all(np.abs(x - first).max() < 1e-8 for x in ends.values())
    assert abs(first[0]) > 1e-3


@pytest.mark.sampled(2)
@pytest.mark.parametrize("period", [None, PERIOD])
def test_the_encoder_of_a_load_is_that_of_own_equations(tmp_path: Path, period: float | None) -> None:
    """rod.y = 0.6 sin(q1 + q2) - q3 cos(q1 + q2) in place of q1, by what it changes with q1 at the start."""
    turn: dict[str, Any] = {"Kv": 20, "Kp": 30, "Tn": 0.05, "measured": "rod.y"}
    slide: dict[str, Any] = {"Kv": 30, "Kp": 120}
    times = {} if period is None else {"period": period, "dead_time": period}
    made = arm({"drive": turn | times, "rod": slide | times}, {"viscous": 1.5}, gravity=[0, 0, 0])
    (tmp_path / "load.fmu").write_bytes(unit_of(made, Scene(), Options()).archive)
    model, wanted, count = se.load(made, ["direct_dynamics"]), np.array([0.02, 0.003]), 40
    integral, held, y = 0.0, np.zeros(2), np.zeros(7)

    def errors(y: np.ndarray) -> np.ndarray:
        x = (0.6 * np.sin(y[0] + y[1]) - y[2] * np.cos(y[0] + y[1])) / 0.6
        return np.array([20, 30]) * (wanted - [x, y[2]]) - y[[3, 5]]

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        e = errors(y)
        torque = held if period else np.array([30 * (e[0] + y[6] / 0.05), 120 * e[1]])
        return np.concatenate([y[3:6], model.direct_dynamics(y[:3], y[3:6], torque), e[:1]])

    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
    for _ in range(count):
        e = errors(y)
        integral += PERIOD * e[0]
        y = solve_ivp(rate, (0, PERIOD), y, **options).y[:, -1]
        held = np.array([30 * (e[0] + integral / 0.05), 120 * e[1]])
    assert abs(y[0] - 0.6 * np.sin(y[0] + y[1]) / 0.6) > 1e-5 and y[0] > 1e-3
    with running(tmp_path / "load.fmu", CO_SIMULATION, 1e-11) as one:
        one.begin()
        one.set({"drive.r": wanted[0], "rod.r": wanted[1]})
        for k in range(count):
            one.step(k * PERIOD, PERIOD)
        found = one.get([f"{joint}.{x}" for x in ("q", "qd") for joint in ("drive", "arm", "rod")])
    np.testing.assert_allclose(found, y[:6], rtol=0, atol=1e-8 * np.abs(y[:6]).max())


def test_what_no_unit_has_is_refused_by_name() -> None:
    limited = {"drive": {**TURN, "measured": "arm.q"}, "rod": SLIDE}
    for drives, said in (
        (limited, "drives, drive, measured: arm.q does not move with drive here"),
        ({"drive": {**TURN, "measured": "rod.qd"}, "rod": SLIDE}, "drives, drive, measured: rod.qd is no position"),
        ({"drive": {**TURN, "measured": "rod.rz"}, "rod": SLIDE}, "an FMU does not measure rotations of frames"),
        ({"drive": {**SAMPLED["drive"], "dead_time": 1e-3}, "rod": SAMPLED["rod"]}, "is longer than the period"),
        ({"drive": SAMPLED["drive"]}, "drives, rod: is missing"),
    ):
        with pytest.raises(InputError, match=said):
            unit_of(arm(drives, {"viscous": 1.5}), Scene(), Options())


@pytest.mark.thorough
def test_without_drives_torques_are_inputs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symoro_elastic.generation.fmu.mock_up_unit.shared_library", lambda *_: None)
    machine = continuous()
    known = {name: replace(one, Kp=TUNED) for name, one in machine.drives.by_motor.items()}
    sought = unit_of(replace(machine, drives=Drives(known)), Scene(), Options())
    assert 'a gain of [drives] (drive, rod) is "tuned"' in sought.notes[0]
    left_out = unit_of(machine, Scene(), Options(by_torque=True))
    for one in (sought, left_out):
        assert one.programs.states == ("rod.friction",) and list(one.programs.inputs) == ["tau"]
    held = unit_of(machine, Scene(locked={"rod": Formula.parse(0)}), Options()).programs
    assert held.states == tuple(
        x for x in unit_of(machine, Scene(), Options()).programs.states if x.startswith("drive.")
    )
