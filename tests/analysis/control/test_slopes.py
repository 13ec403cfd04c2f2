"""Slopes of margins and poles: against a drive of two masses in closed form, by differences in 40 digits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.control import pole_slopes
from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.analysis.vibration.responses import with_modal_damping
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from tests.analysis.control.test_closed_loops import MACHINES, RATIO, drives_of
from tests.analysis.control.test_largest_gain import DAMPING, DEAD, LAG, LOAD, MOTOR, STIFFNESS, drive

KP, KV, TN = 6.0, 40.0, 0.03
GIVEN = {
    "motor": MOTOR,
    "load": LOAD,
    "k": STIFFNESS,
    "c": DAMPING,
    "lag": LAG,
    "dead": DEAD,
    "Kp": KP,
    "Kv": KV,
    "Tn": TN,
}
NAMES = {
    **{"arm.stiffness": "k", "arm.damping": "c", "motor.rotor_inertia": "motor", "arm.ZZ": "load"},
    **{"dead time": "dead", "lag of the current loop": "lag", "Kp": "Kp", "Kv": "Kv", "Tn": "Tn"},
}
STEP = mpmath.mpf(10) ** -12


@pytest.fixture(scope="module")
def found() -> Any:
    return se.control(drive(Kv=KV, Kp=KP, Tn=TN))


def open_loop(s: Any, p: dict[str, Any], loop: str) -> Any:
    """L of the velocity loop, or of the position loop around it."""
    spring = p["c"] * s + p["k"]
    response = (p["load"] * s**2 + spring) / (
        p["motor"] * s**2 * (p["load"] * s**2 + spring) + p["load"] * s**2 * spring
    )
    C = p["Kp"] * (1 + 1 / (p["Tn"] * s)) * mpmath.exp(-s * p["dead"]) / (1 + p["lag"] * s)
    inner = C * s * response
    return inner if loop == "velocity" else p["Kv"] * C * response / (1 + inner)


def slope_of(value: Any, key: str) -> Any:
    """d value / d ln p by differences; `value` takes the numbers of the machine."""
    with mpmath.workdps(40):
        numbers = {name: mpmath.mpf(x) for name, x in GIVEN.items()}
        up, down = (value({**numbers, key: numbers[key] * mpmath.exp(x)}) for x in (STEP, -STEP))
        return (up - down) / (2 * STEP)


def margin(kind: str, loop: str, near: float) -> Any:
    """A margin as a function of numbers: its frequency is found next to `near`, Hz."""

    def L(w: Any, p: dict[str, Any]) -> Any:
        return open_loop(1j * w, p, loop)

    zero, value = {
        "modulus": (
            lambda w, p: mpmath.diff(lambda x: abs(1 + L(x, p)) ** 2, w),
            lambda w, p: mpmath.log(abs(1 + L(w, p))),
        ),
        "phase": (lambda w, p: mpmath.log(abs(L(w, p))), lambda w, p: abs(mpmath.degrees(mpmath.arg(-L(w, p))))),
        "gain": (lambda w, p: mpmath.im(L(w, p)), lambda w, p: mpmath.log(-1 / mpmath.re(L(w, p)))),
    }[kind]

    def of(p: dict[str, Any]) -> Any:
        w = mpmath.findroot(lambda x: zero(x, p), 2 * mpmath.pi * near, tol=1e-60)
        return value(w, p)

    return of


@pytest.mark.sampled(5)
@pytest.mark.parametrize("loop", ["velocity", "position"])
@pytest.mark.parametrize("kind", ["modulus", "phase", "gain"])
def test_slopes_of_margins_are_those_of_differences(found: Any, kind: str, loop: str) -> None:
    margins = getattr(found.places[0].axes[0], loop)
    near = getattr(margins, f"{kind}_frequency")
    slopes = getattr(found.margin_slopes("motor", loop), kind)
    assert slopes.keys() >= NAMES.keys() - ({"Kv"} if loop == "velocity" else set())
    of = margin(kind, loop, near)
    for name in NAMES.keys() & slopes.keys():
        expected = float(slope_of(of, NAMES[name]))
        assert slopes[name] == pytest.approx(expected, rel=1e-8, abs=1e-8), name


def test_slopes_of_poles_are_those_of_differences(found: Any) -> None:
    """Of the one that decays least, and of that of the spring."""
    for asked in (None, 100 + 250j):
        pole, slopes = found.pole_slopes(asked)

        def root(p: dict[str, Any], pole: complex = pole) -> Any:
            return mpmath.findroot(lambda s: 1 + open_loop(s, p, "position"), mpmath.mpc(pole), tol=1e-60)

        with mpmath.workdps(40):
            assert pole == pytest.approx(complex(root({name: mpmath.mpf(x) for name, x in GIVEN.items()})), rel=1e-9)
        for name, key in NAMES.items():
            ours = slopes[name if "." in name else f"motor, {name}"]
            assert ours == pytest.approx(complex(slope_of(root, key)), rel=1e-8, abs=1e-8 * abs(pole)), name


def test_other_axes_and_loops_are_refused(found: Any) -> None:
    for given, what in ((("arm",), "motor: arm is none of motor"), (("motor", "current"), "loop: current is none of")):
        with pytest.raises(InputError, match=what):
            found.margin_slopes(*given)
    assert np.isfinite([*found.margin_slopes("motor").modulus.values()]).all()


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*MACHINES])
def test_poles_of_several_axes_move_with_drives_and_masses(name: str) -> None:
    """By differences of the poles themselves: gains and parts of each drive, a stiffness, a mass, a rotor."""
    plant = MACHINES[name]()
    cascades = drives_of(plant)
    poles = closed_loop(plant, cascades).poles
    near = max(poles[poles.imag > 1], key=lambda s: np.sort(abs(poles - s))[1] / abs(s))  # poles apart move straight
    pole, slopes = pole_slopes(plant, cascades, complex(near))
    motion = plant.linear.motion
    kinds = (".stiffness", ".mass", ".ZZ", ".rotor_inertia")
    parameters = [x for kind in kinds if (x := next((x for x in motion.parameters if x.endswith(kind)), ""))]

    def moved(factor: float, name: str) -> complex:
        there, changed = plant, cascades
        if name in motion.parameters:
            machine = motion.at_values({name: motion.parameters[name] * factor})
            linear = with_modal_damping(linearize(machine, equilibrium(machine, {})), RATIO)
            there = replace(plant, linear=linear)
        else:
            motor, key = name.split(", ")
            changed = [with_factor(one, key, factor) if one.motor == motor else one for one in cascades]
        return pole_slopes(there, changed, pole)[0]

    gains = [f"{one.motor}, {key}" for one in cascades for key in ("Kp", "Kv", "dead time", "lag", "notch")]
    for name_of in (*parameters, *gains):
        near_by, far = (moved(np.exp(h), name_of) - moved(np.exp(-h), name_of) for h in (1e-3, 2e-3))
        expected = (8 * near_by - far) / 12e-3
        assert slopes[name_of] == pytest.approx(expected, rel=1e-6, abs=1e-8 * abs(pole)), name_of


def with_factor(one: Cascade, key: str, factor: float) -> Cascade:
    """The drive with a gain, or a time of its path, times a factor."""
    if key in ("Kp", "Kv"):
        return replace(one, **{key: getattr(one, key) * factor})
    times = {"dead time": "time", "lag": "time", "notch": "frequency"}
    path = tuple(
        replace(part, **{times[key]: getattr(part, times[key]) * factor}) if part.name == key else part
        for part in one.path
    )
    return replace(one, path=path)
