"""Slopes by every name of a file against differences of the whole figure: machine, drives and operating point anew."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.control import margin_slopes, pole_slopes
from symoro_elastic.analysis.control.cutting import Cut, Milling
from symoro_elastic.analysis.control.driven_machine import DrivenMachine, driven_machine
from symoro_elastic.analysis.control.lobes import lobe
from symoro_elastic.analysis.control.loops import influences, largest_Kp, largest_Kv, loops_of, margins
from symoro_elastic.analysis.control.tuning import AT_USUAL_DISTANCES
from symoro_elastic.analysis.vibration.linearization import linear_slopes, linearize, response_slopes, with_motors
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.analysis.vibration.responses import (
    frequency_response,
    with_modal_damping,
    with_modal_damping_slopes,
)
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium

pytest.importorskip("scipy.linalg")

EXAMPLES = Path(__file__).parents[3] / "examples"
STEP = 1e-4
WINDING = {"resistance": 0.5, "inductance": 1e-3}
Figures = dict[tuple[str, ...], float | complex]


def shared(**changes: Any) -> dict[str, Any]:
    """A slide and an arm in a plane with gravity: parameters that stand in bodies, springs, windings and drives."""
    drives = {
        "x": {
            **{"Kv": 30.0, "Kp": "60*(J*N^2 + 60)", "Tn": 0.02, "dead_time": "T", "measured": "tool.x"},
            "current": {"kp": 6.0, "ti": 2e-3},
        },
        "b": {
            **{"Kv": 25.0, "Kp": 500.0, "dead_time": "2*T", "current": {"lag": "T"}},
            "filters": [{"notch": "k4/2000", "depth": 0.1, "width": "L1"}],
        },
    }
    return {
        "name": "shared",
        "gravity": [0, -9.81, 0],
        "joints": [
            {"name": "x", "kind": "motor", "sigma": 1, "gamma": "pi/2", "alpha": "pi/2", "r": "qx"},
            {"name": "sx", "kind": "elastic", "sigma": 1, "r": "dx"},
            {"name": "b", "kind": "motor", "sigma": 0, "alpha": "-pi/2", "theta": "qb + 1"},
            {"name": "sb", "kind": "elastic", "sigma": 0, "theta": "db"},
            {"name": "arm", "kind": "elastic", "sigma": 0, "d": "L1", "theta": "da"},
            {"name": "tool", "kind": "fixed", "sigma": 2, "d": "L2"},
        ],
        "parameters": {"L1": 0.45, "L2": 0.25, "N": 600.0, "T": 1.3e-4, "k4": 3e5, "J": 2e-4, "m4": 6.0, "n4": 2e-3},
        "bodies": {
            "sx": {"mass": 40},
            "sb": {"mass": 12, "center_of_mass": [0.1, 0.02, 0], "inertia": [0.4, 0.4, 0.3]},
            "arm": {"mass": "m4", "center_of_mass": [0.15, 0.01, 0], "inertia": [0.1, 0.1, 0.06]},
        },
        "springs": {
            "sx": {"stiffness": 6e7, "damping": 3e3},
            "sb": {"stiffness": 2e5, "damping": 8.0},
            "arm": {"stiffness": "k4", "damping": "k4/40000", "neutral": "n4"},
        },
        "motors": {
            "x": {
                "rotor_inertia": "J",
                "ratio": "N",
                "resistance": 0.5,
                "inductance": 1e-3,
                "torque_constant": "J*500",
            },
            "b": {"rotor_inertia": 1e-4, "ratio": 100},
        },
        "drives": {**drives, **changes},
    }


def sampled() -> dict[str, Any]:
    b = {"Kv": 25.0, "Kp": 500.0, "period": "T", "current": {"lag": "T"}, "filters": [{"lowpass": "k4/500"}]}
    return shared(b=b, x={"Kv": 30.0, "Kp": 1e5, "period": "T", "current": {"kp": 6.0, "ti": 2e-3}})


def one_held() -> dict[str, Any]:
    machine = shared()
    del machine["drives"]["b"]
    return machine


def example(name: str, **drives: Any) -> dict[str, Any]:
    machine = tomllib.loads((EXAMPLES / f"{name}.toml").read_text())
    return {**machine, "drives": drives}


def timed(Kv: float, Kp: float, **more: Any) -> dict[str, Any]:
    return {"Kv": Kv, "Kp": Kp, "current": {"lag": 2e-4}, "dead_time": 1.5e-4, **more}


MACHINES: dict[str, tuple[Callable[[], dict[str, Any]], float]] = {
    "shared": (shared, 0.0),
    "sampled": (sampled, 0.0),
    "one held": (one_held, 0.0),
    "two_axis": (lambda: example("two_axis", motor_x=timed(40.0, 3e4, Tn=0.02), motor_y=timed(50.0, 2e5)), 0.02),
    "linkage": (
        lambda: example("linkage", waist=timed(10.0, 100.0), arm=timed(12.0, 300.0, measured="tool.z"),
                        drive=timed(12.0, 30.0, Tn=0.05)), 0.02,
    ),
}  # fmt: skip
CUTS = {
    "turning": Cut(2e9, 1, "tool.x", "-tool.y"),
    "milling": Cut(2e9, 3, "tool.x", "tool.x", Milling("tool.y", 6e8, 0.4)),
}


@dataclass(frozen=True)
class Case:
    """A machine at an operating point, anew for other values of its parameters."""

    motion: EquationsOfMotion
    damping: float

    @classmethod
    @cache
    def of(cls, name: str) -> Case:
        table, damping = MACHINES[name]
        signals = ("tool.x", "tool.y", "tool.z")
        return cls(motion_of(se.read(table()), {}, (), signals), damping)

    def with_value(self, name: str, x: float) -> DrivenMachine:
        return self.at(self.motion.at_values({name: x}))

    def at(self, motion: EquationsOfMotion) -> DrivenMachine:
        states = [({}, equilibrium(motion, {}))]
        return driven_machine(motion, states, AT_USUAL_DISTANCES, self.damping, ("tool.x", "tool.y", "tool.z"))


def loop_figures(driven: DrivenMachine) -> Figures:
    """Logarithms of gains and moduli, phases in deg."""
    figures: Figures = {}
    for one in loops_of(driven.plants[0], driven.cascades):
        motor = one.cascade.motor
        for key, limit in (("Kp", largest_Kp(one, 0.5)), ("Kv", largest_Kv(one, 0.7))):
            if limit and np.isfinite(limit.gain):
                figures[motor, key] = np.log(limit.gain)
        for loop, of in (("velocity", one.velocity_loop), ("position", one.position_loop)):
            found = margins(of, one.frequencies)
            figures |= {(motor, loop, "modulus"): np.log(found.modulus), (motor, loop, "phase"): found.phase,
                        (motor, loop, "gain"): np.log(found.gain)}  # fmt: skip
    return {key: x for key, x in figures.items() if np.isfinite(x)}


def loop_slopes(driven: DrivenMachine) -> dict[tuple[str, ...], Mapping[str, float]]:
    slopes: dict[tuple[str, ...], Mapping[str, float]] = {}
    for one in loops_of(driven.plants[0], driven.cascades):
        motor = one.cascade.motor
        for key, limit in (("Kp", largest_Kp(one, 0.5)), ("Kv", largest_Kv(one, 0.7))):
            if limit:
                slopes[motor, key] = influences(one, key, limit)
        for loop, key, of in (("velocity", "Kp", one.velocity_loop), ("position", "Kv", one.position_loop)):
            found = margin_slopes(one, key, margins(of, one.frequencies))
            slopes |= {(motor, loop, of): getattr(found, of) for of in ("modulus", "phase", "gain")}
    return slopes


def slope(of: Callable[[float], Any], x: float) -> Any:
    """d of/d ln x, to the fourth order."""
    near, far = (of(x * np.exp(h)) - of(x * np.exp(-h)) for h in (STEP, 2 * STEP))
    return (8 * near - far) / (12 * STEP)


def numbers_of(name: str, every: bool) -> dict[str, float]:
    """Values of names of `[parameters]`, or of all: numbers of tables and of drives, too."""
    return {p: x for p, x in Case.of(name).motion.numbers.items() if x and (every or "." not in p)}


def slope_of(slopes: Mapping[str, Any], driven: DrivenMachine, motor: str, name: str) -> Any:
    """A slope by a name; those of an axis call numbers of its own drive without its name."""
    called = {p: label for one in driven.cascades for p, label in one.names.items()}.get(name, name)
    return slopes.get(called.removeprefix(f"{motor}, "), 0.0)


QUICK = [("shared", False), ("sampled", False)]
EVERY = [pytest.param(name, True, marks=pytest.mark.thorough) for name in MACHINES]


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("name", "every"), [*QUICK, *EVERY])
def test_slopes_of_gains_and_margins_are_complete(name: str, every: bool) -> None:
    case = Case.of(name)
    driven = case.at(case.motion)
    slopes = loop_slopes(driven)
    for parameter, x in numbers_of(name, every).items():
        tried = [loop_figures(case.with_value(parameter, x * np.exp(h * STEP))) for h in (-2, -1, 1, 2)]
        for key in set.intersection(*({*one} for one in tried)):
            low, lower, higher, high = (one[key] for one in (tried[0], tried[1], tried[2], tried[3]))
            expected = (8 * (higher - lower) - (high - low)) / (12 * STEP)
            largest = max(map(abs, slopes[key].values()))
            assert slope_of(slopes[key], driven, key[0], parameter) == pytest.approx(
                expected, rel=1e-7, abs=1e-7 * max(1.0, largest)
            ), (key, parameter)


@pytest.mark.sampled(12)
@pytest.mark.parametrize(("name", "every"), [*QUICK, *EVERY])
def test_slopes_of_poles_are_complete(name: str, every: bool) -> None:
    case = Case.of(name)
    driven = case.at(case.motion)
    poles = closed_loop(driven.plants[0], driven.cascades).poles
    pole = max(poles[poles.imag > 1], key=lambda s: s.real)
    pole, slopes = pole_slopes(driven.plants[0], driven.cascades, complex(pole))
    for parameter, x in numbers_of(name, every).items():

        def moved(value: float, parameter: str = parameter, pole: complex = pole) -> complex:
            changed = case.with_value(parameter, value)
            return pole_slopes(changed.plants[0], changed.cascades, pole)[0]

        ours = slope_of(slopes, driven, "", parameter)
        assert ours == pytest.approx(slope(moved, x), rel=1e-7, abs=1e-8 * abs(pole)), parameter


@pytest.mark.sampled(12)
@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize(("name", "every"), [QUICK[0], *EVERY[:3]])
def test_slopes_of_the_least_depth_are_complete(name: str, every: bool, cut: str) -> None:
    case, speeds = Case.of(name), np.array([3000.0])
    driven = case.at(case.motion)
    slopes = lobe(driven.plants[0], driven.cascades, CUTS[cut], speeds).influences
    for parameter, x in numbers_of(name, every).items():

        def depth(value: float, parameter: str = parameter) -> float:
            changed = case.with_value(parameter, value)
            return float(np.log(lobe(changed.plants[0], changed.cascades, CUTS[cut], speeds).least))

        ours = slope_of(slopes, driven, "", parameter)
        assert ours == pytest.approx(slope(depth, x), rel=1e-6, abs=1e-6), parameter


def redundant() -> dict[str, Any]:
    """The linkage rigid, with more motors than it needs: the rate of one depends on a gear and on lengths."""
    machine = example("linkage")
    machine["joints"][3]["kind"] = machine["joints"][5]["kind"] = "motor"
    return {key: x for key, x in machine.items() if key not in ("springs", "drives")}


OPEN: dict[str, Callable[[], dict[str, Any]]] = {
    "shared": lambda: {key: x for key, x in shared().items() if key != "drives"},
    "redundant": redundant,
    "linkage": lambda: {key: x for key, x in example("linkage").items() if key != "drives"},
}


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("name", "every"), [*((x, False) for x in OPEN), *(pytest.param(x, True, marks=pytest.mark.thorough) for x in OPEN)]
)
def test_slopes_of_modes_and_responses_are_complete(name: str, every: bool) -> None:
    """Motors under controllers, a damping ratio in unstable modes, positions of loops that begin where a name says."""
    motion = motion_of(se.read(OPEN[name]()), {}, ("tool.fx",), ("tool.x", "tool.az"))
    gains = dict.fromkeys(motion.motor_names, (2e3, 30.0))

    def at(there: EquationsOfMotion) -> Any:
        linear = linearize(there, equilibrium(there, {}), ("tool.fx",), ("tool.x", "tool.az"))
        return with_motors(linear, (), gains)

    linear, f = at(motion), np.array([2.0, 11.0])
    modal, damped = modes(linear), with_modal_damping(linear, 0.02)
    frequencies = dict(zip(modal.sensitivity.parameters, modal.sensitivity.slopes, strict=True))
    slopes = with_modal_damping_slopes(linear_slopes(linear), 0.02)
    slopes = type(slopes)(**{**vars(slopes), "linear": damped})
    responses = dict(zip(slopes.names, response_slopes(slopes, f)[1], strict=True))
    values = frequency_response(damped, f).values
    for parameter, x in motion.parameters.items():
        if not x or ("." in parameter and not every):
            continue

        def moved(value: float, parameter: str = parameter) -> np.ndarray:
            changed = at(motion.at_values({parameter: value}))
            G = frequency_response(with_modal_damping(changed, 0.02), f).values.ravel()
            return np.concatenate([modes(changed).frequencies, G.real, G.imag])

        n = len(modal.frequencies)
        by_G = x * responses[parameter].ravel()
        ours = [x * frequencies.get(parameter, np.zeros(n)), by_G.real, by_G.imag]
        sizes = [np.ones(n) * modal.frequencies.max(), *(np.full(values.size, np.abs(values).max()),) * 2]
        error = np.abs(np.concatenate(ours) - slope(moved, x)) / np.concatenate(sizes)
        assert error.max() < 1e-7, parameter
