"""Current controllers of motors with windings: poles by python-control, slopes by differences, rates by MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.cascade import Cascade, CurrentLoop, cascade_of, current_system
from symoro_elastic.analysis.control.closed_loop import closed_loop, linear_law
from symoro_elastic.analysis.control.drive_laws import XD
from symoro_elastic.analysis.control.loops import influences, largest_Kp, largest_Kv, loops_of
from tests.analysis.control.test_closed_loops import plant_of

KT = 0.1
LOOP = CurrentLoop(6.0, 2e-3, 0.5, 1e-3, KT * KT)


def test_the_rate_of_a_current_is_that_of_mujoco() -> None:
    """Its `dcmotor`: 2799.5 A/s at 1 mA, 3 V and 2 rad/s with 0.1 N m/A, 0.5 Ohm, 1 mH."""
    drive = linear_law(Cascade("m", 0.0, 1.0, np.inf, (LOOP,)))
    current, wanted = 1e-3, 1e-3 + 3 / LOOP.kp
    state = np.array([KT * current, 0.0])
    rate = drive.A @ state + current_system(LOOP).B * KT * wanted + (drive.B[:, XD] + current_system(LOOP).B) * 2
    assert rate[0] / KT == pytest.approx(2799.5, rel=1e-12)


def cascades(drag: float = 0.05, **changes: float) -> list[Cascade]:
    return [Cascade("motor", 15.0, 1.5, 0.05, (replace(LOOP, drag=drag, **changes),))]


def test_poles_are_those_of_python_control() -> None:
    """The motor with its winding in states of its own, i in A and the voltage by a transfer function."""
    control = pytest.importorskip("control")
    plant, (one,) = plant_of("ball_screw.toml"), cascades()
    row, linear, n = plant.axes["motor"].velocity, plant.linear, len(plant.linear.M)
    Kt = 0.05**0.5
    inverse = np.linalg.inv(linear.M)
    A = np.block([
        [np.zeros((n, n)), np.eye(n), np.zeros((n, 1))],
        [-inverse @ linear.K, -inverse @ linear.D, Kt * inverse @ row[:, None]],
        [np.zeros((1, n)), -Kt / LOOP.inductance * row[None], np.array([[-LOOP.resistance / LOOP.inductance]])],
    ])  # fmt: skip
    B = np.append(np.zeros(2 * n), 1 / LOOP.inductance)[:, None]
    C = np.array([[*row, *np.zeros(n + 1)], [*np.zeros(n), *row, 0], [*np.zeros(2 * n), 1]])
    machine = control.ss(A, B, C, 0, inputs="u", outputs=["p", "v", "i"], name="machine")
    s = control.tf("s")
    speed = control.ss(one.Kp * (1 + 1 / (one.Tn * s)) / Kt, inputs="e", outputs="iw", name="speed")
    amplifier = control.ss(LOOP.kp * (1 + 1 / (LOOP.ti * s)), inputs="ei", outputs="u", name="amplifier")
    error = control.ss([], [], [], [[1.0, -one.Kv, -1.0]], inputs=["r", "p", "v"], outputs="e", name="error")
    lack = control.ss([], [], [], [[1.0, -1.0]], inputs=["iw", "i"], outputs="ei", name="lack")
    whole = control.interconnect([machine, speed, amplifier, error, lack], inputs=["r"], outputs=["p"])
    theirs, ours = whole.poles(), closed_loop(plant, [one]).poles
    assert len(theirs) == len(ours)
    assert (np.abs(ours[:, None] - theirs).min(axis=1) <= 1e-10 * np.abs(ours).max()).all()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("key", ["Kp", "Kv"])
def test_slopes_of_largest_gains_are_those_of_differences(key: str) -> None:
    plant = plant_of("ball_screw.toml")
    largest = largest_Kp if key == "Kp" else largest_Kv
    (loops,) = loops_of(plant, cascades())
    found = largest(loops, 0.5)
    assert found and np.isfinite(found.gain)
    slopes = influences(loops, key, found)
    names = {"resistance": "resistance", "inductance": "inductance", "kp": "kp of the current loop"}
    names |= {"ti": "ti of the current loop", "drag": "back_emf"}
    for field, name in names.items():
        value, h = {**vars(LOOP), "drag": 0.05}[field], 1e-3
        near = [largest(loops_of(plant, cascades(**{field: value * (1 + x)}))[0], 0.5) for x in (-h, h)]
        assert near[0] and near[1]
        expected = (np.log(near[1].gain) - np.log(near[0].gain)) / (2 * h)
        assert slopes[name] == pytest.approx(expected, rel=1e-4, abs=1e-5), name


@pytest.mark.parametrize("back_emf", [0, "Ke", 0.1])
def test_a_back_emf_of_0_is_that_of_the_torque_constant(back_emf: object) -> None:
    """Also where a parameter is 0: drag = n^2 Kt Ke."""
    winding = {"resistance": 0.5, "inductance": 1e-3, "torque_constant": KT, "back_emf": back_emf}
    machine = se.read({
        "name": "drive",
        "joints": [{"name": "m", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}],
        "parameters": {"Ke": 0},
        "motors": {"m": {"rotor_inertia": 1e-4, "ratio": 3, **winding}},
        "bodies": {"m": {"mass": 1, "inertia": [0.01, 0.01, 0.01]}},
        "drives": {"m": {"Kv": 20, "Kp": 1, "current": {"kp": 6, "ti": 2e-3}}},
    })  # fmt: skip
    found = cascade_of(machine.joints[0], machine.drives.by_motor["m"], {"Ke": 0.0}, "drive")
    (loop,) = (one for one in found.path if isinstance(one, CurrentLoop))
    assert loop.drag == pytest.approx(9 * KT * KT, rel=1e-15)
