"""Simulated motions on a floating base: against Pinocchio's free-flyer, conserved quantities, frames in the world."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.ladder.rungs import ladder_of_prediction, prediction_of
from symoro_elastic.analysis.simulation.adaptive import simulate_adaptively
from symoro_elastic.analysis.simulation.moving_base import quaternion, rotations
from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.analysis.simulation.simulate import Request, simulate
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.formats.reading import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.motions import motions_of
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Base, Joint, Kind, Machine, Orientation
from symoro_elastic.machine.machine import KnownOfBase as Known
from tests.codegen.integration.floating_motions import FloatingState, integrated, rotation
from tests.command_line import EXAMPLES
from tests.generated_code import COMPILERS

pytestmark = pytest.mark.sampled(4)

SERVOS = "servo = { shoulder = { kp = 8, kd = 1 }, elbow = { kp = 4, kd = 0.3 } }"
MOVES = """
[motion]
duration = 0.2
moves = [{ motor = "shoulder", by = 0.5, in = 0.15 }, { motor = "elbow", by = -0.5, from = 0.05, in = 0.15 }]
"""
BASE = """
[motion.base]
position = [1, 2, 3]
orientation = [0.8, 0, 0.6, 0]
velocity = [0.5, 0, -0.2, 0.3, -0.4, 0.6]
wrench = [2, 0, 20, 0.1, 0.2, -0.1]
"""
OUTPUTS = tuple(f"{owner}.{x}" for owner in ("base", "hand") for x in ("x", "vx", "ax", "z", "vz", "az", "wy", "wdy"))
needs_compiler = pytest.mark.skipif(not COMPILERS, reason="no C compiler")


def arm(turned: Orientation = Orientation.QUATERNION) -> Machine:
    machine, _ = read_machine(EXAMPLES / "floating_arm.toml")
    assert machine.floating is not None
    return replace(machine, floating=replace(machine.floating, orientation=turned)).asking(motions=())


def reference(text: str, machine: Machine | None = None) -> Reference:
    described = machine or arm()
    return reference_of(described, motions_of(load(text, "scene.toml"), described)[0])


@cache
def simulated(way: str) -> Simulation:
    """Under servos by even or by adapted steps; motors that follow exactly, the base turned by a matrix."""
    if way == "exact":
        return simulate(reference(MOVES + BASE, arm(Orientation.ROTATION)), Request(OUTPUTS, method="rk4", step=1e-3))
    given = reference(MOVES + SERVOS + BASE)
    if way == "adapted":
        return simulate_adaptively(given, Request(OUTPUTS, {"base.x": 1e-6}), {})
    return simulate(given, Request(OUTPUTS, method="w3", step=1e-3))


class OfReference:
    """What `integrated` is given of a reference."""

    def __init__(self, of: Reference) -> None:
        self.of, self._last = of, dict[float, tuple[Array, ...]]()
        self.kp, self.kd = of.servo or (np.zeros(2), np.zeros(2))

    def f0(self, t: float) -> Array:
        return self.of.base["f0"]

    def y(self, t: float, order: int = 0) -> Array:
        if t not in self._last:
            self._last = {t: self.of.at(np.array([t]))}
        found: Array = self._last[t][order][0]
        return found

    def torque(self, t: float, q: Array, qd: Array, variant: str) -> Array:
        return self.of.start.tau + self.kp * (self.y(t) - q) + self.kd * (self.y(t, 1) - qd)


@cache
def exact(variant: str) -> Array:
    pinocchio: Any = pytest.importorskip("pinocchio") and pytest.importorskip("tests.references.pinocchio_model")
    of = reference(MOVES + (SERVOS if variant == "_servo" else "") + BASE)
    free = pinocchio.FreeFlyer(of.machine)
    at = FloatingState(of.start.q, of.start.qd, of.base["Q0"], of.base["P0"], of.base["V0"])

    def equations(R: Array, V0: Array, q: Array, qd: Array) -> tuple[Array, Array]:
        found: tuple[Array, Array] = free.equations(pinocchio.BaseState(R, V0, np.zeros(6)), q, qd)
        return found

    return integrated(of.machine, equations, at, variant, of.duration, OfReference(of), 1e-10)


@pytest.mark.sampled(5)
@needs_compiler
@pytest.mark.parametrize(("way", "variant"), [("even", "_servo"), ("adapted", "_servo"), ("exact", "_driven")])
def test_motions_end_where_pinocchio_says(way: str, variant: str) -> None:
    """Within the error that is measured, and 1e-8 of the adapted steps, 1e-9 of the reference."""
    found, wanted = simulated(way), exact(variant)
    q, qd, Q, P, V = np.split(wanted, [2, 4, 8, 11])
    run = found.trajectory
    turned = run.base["Q0"][-1] if "Q0" in run.base else run.base["R0"][-1]
    ours = (run.q[-1], run.qd[-1], rotation(turned), run.base["P0"][-1], run.base["V0"][-1])
    wrong = [np.abs(one - other).max() for one, other in zip(ours, (q, qd, rotation(Q), P, V), strict=True)]
    assert max(wrong) < 2 * max(found.errors.values()) + (1e-8 if way == "adapted" else 1e-9)
    assert way == "adapted" or 1e-10 < max(found.errors.values()) < 1e-3


@pytest.mark.thorough
@needs_compiler
@pytest.mark.parametrize("way", ["even", "adapted", "exact"])
def test_energy_is_balanced_and_rotations_stay_rotations(way: str) -> None:
    """What motors and the wrench put in is in the arm, to the error of Simpson's rule and of the steps."""
    found = simulated(way)
    assert found.energy.put_in > 1 and abs(found.energy.left_over) < 1e-5 * found.energy.put_in
    base = found.motion.base
    lengths = np.linalg.norm(base["Q0"], axis=1) if "Q0" in base else np.linalg.norm(base["R0"], axis=1) / np.sqrt(3)
    assert np.abs(lengths - 1).max() < 4e-16


@needs_compiler
def test_frames_move_in_the_world() -> None:
    """Positions, velocities and accelerations of base and hand are each the rate of the one before."""
    found = simulated("even")
    column = dict(zip(found.names, found.outputs.T, strict=True))
    h, rates = found.trajectory.step, [("x", "vx", "ax"), ("z", "vz", "az")]
    pairs = [*(pair for x, v, a in rates for pair in ((x, v), (v, a))), ("wy", "wdy")]
    for owner in ("base", "hand"):
        for x, rate in pairs:
            y, wanted = column[f"{owner}.{x}"], column[f"{owner}.{rate}"]
            differences = (y[:-4] - 8 * y[1:-3] + 8 * y[3:-1] - y[4:]) / (12 * h)
            assert np.abs(differences - wanted[2:-2]).max() < 1e-4 * np.abs(wanted).max(), (owner, x)


@needs_compiler
def test_the_hand_is_where_pinocchio_places_it() -> None:
    pin: Any = pytest.importorskip("pinocchio")
    pinocchio: Any = pytest.importorskip("tests.references.pinocchio_model")
    found, machine = simulated("even"), arm()
    model, order, _ = pinocchio.model_of(machine)
    carrier, place = pinocchio.carried_frame(machine, 3)
    column = dict(zip(found.names, found.outputs.T, strict=True))
    for s in (0, 100, 200):
        base, position = found.motion.base, pin.neutral(model)
        position[:7] = [*base["P0"][s], *np.roll(base["Q0"][s], -1)]
        position[[k + 1 for k in order]] = found.motion.q[s]
        data = model.createData()
        pin.forwardKinematics(model, data, position)
        at = (data.oMi[carrier] * place).translation
        np.testing.assert_allclose([column["hand.x"][s], column["hand.z"][s]], at[[0, 2]], rtol=0, atol=1e-13)


@needs_compiler
def test_momentum_stays_while_the_arm_moves() -> None:
    """No weight, no wrench: motors are internal, so linear and angular momentum of the whole stay."""
    pinocchio: Any = pytest.importorskip("pinocchio") and pytest.importorskip("tests.references.pinocchio_model")
    machine = replace(arm(), base=Base())
    found = simulate(
        reference(MOVES + SERVOS + "\nbase = { velocity = [0.5, 0, -0.2, 0.3, -0.4, 0.6] }", machine),
        Request(("base.x",), method="rk4", step=5e-4),
    )
    free, motion = pinocchio.FreeFlyer(machine), found.motion
    states = zip(motion.base["Q0"], motion.base["P0"], motion.base["V0"], motion.q, motion.qd, strict=True)
    momenta = np.array([free.momentum(rotation(Q), P, V, q, qd) for Q, P, V, q, qd in [*states][::50]])
    assert np.ptp(motion.q, axis=0).min() > 0.1
    assert np.abs(momenta - momenta[0]).max() < 1e-9 * np.abs(momenta).max()


@pytest.mark.thorough
@needs_compiler
def test_a_body_without_joints_flies() -> None:
    """It falls by g t^2 / 2, and turns about its axis of symmetry."""
    machine = replace(arm(), joints=(Joint("tip", 0, Kind.FIXED, 2),), parameters=())
    text = "[motion]\nduration = 0.5\nbase = { velocity = [1, 0, 0, 0, 0, 2] }"
    found = simulate(reference(text, machine), Request(("base.x", "base.rz"), method="rk4", step=0.005))
    assert found.outputs[-1] == pytest.approx([0.5, 1.0], abs=1e-9)
    centre = 0.02
    assert found.motion.base["P0"][-1, 2] + centre == pytest.approx(centre - 9.81 * 0.125, abs=1e-12)


def test_columns_hold_the_base() -> None:
    if not COMPILERS:
        pytest.skip("no C compiler")
    columns, base = simulated("even").arrays(), simulated("even").motion.base
    for name, entries in (("Q0", "wxyz"), ("P0", "xyz")):
        for k, entry in enumerate(entries):
            np.testing.assert_array_equal(columns[f"{name}_{entry}"], base[name][:, k])
    assert {"V0_6", "Vd0_6", "F0_6"} <= columns.keys()


def test_springs_start_at_rest_on_a_held_base() -> None:
    """A spring bends by m g / k where gravity is along it: the base turned by a quarter about y."""
    text = """
name = "mast"
gravity = [0, 0, -9.81]
joints = [{ name = "slide", kind = "elastic", sigma = 1, r = "q1" }]
bodies = { slide = { mass = 2 } }
springs = { slide = { stiffness = 1000 } }
base = { floating = "quaternion", body = { mass = 5, inertia_at_origin = [1, 1, 1] } }
"""
    machine = toml.read(text, "mast.toml")
    upright = reference("[motion]\nduration = 1\n", machine)
    lying = reference(
        "[motion]\nduration = 1\nbase = { orientation = [0.5, 0, 0.5, 0] }\n".replace("0.5", "0.70711"), machine
    )
    assert upright.start.q[0] == pytest.approx(-2 * 9.81 / 1000, rel=1e-9)
    assert abs(lying.start.q[0]) < 1e-15 and np.linalg.norm(lying.base["Q0"]) == pytest.approx(1, abs=1e-15)


def test_quaternions_and_matrices_are_those_of_each_other() -> None:
    Q = np.random.default_rng(1).normal(size=(20, 4))
    Q /= np.linalg.norm(Q, axis=1, keepdims=True) * np.sign(Q[:, :1])
    R = rotations(Q)
    np.testing.assert_allclose(R, [rotation(each) for each in Q], atol=1e-15)
    np.testing.assert_allclose([quaternion(each) for each in R], Q, atol=1e-14)


# Refusals


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (MOVES + 'forces = [{ at = "hand", fx = 1, in = 0.1 }]', "motion, forces: not offered on a floating base"),
        (MOVES + "base = { orientation = [1, 1, 0, 0] }", "base, orientation: the length of the quaternion is 1.414"),
        (MOVES + "base = { orientation = [1, 0, 0, 0, 1, 0, 0, 0, -1] }", "base, orientation: this is not a rotation"),
        (MOVES + "base = { orientation = [1, 0, 0] }", "orientation"),
        (MOVES + "base = { wrench = [1e12, 0, 0, 0, 0, 0] }", "base, wrench: 1e\\+12 is out of range"),
        (MOVES + "base = { speed = [1, 0, 0] }", "speed"),
    ],
)
def test_starts_that_are_none_are_refused(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        reference(text)


def test_a_fixed_base_has_no_start() -> None:
    fixed = replace(arm(), floating=None)
    with pytest.raises(InputError, match="motion, base: the base of the machine is fixed"):
        reference(MOVES + "base = { position = [0, 0, 1] }", fixed)


def test_a_base_of_known_acceleration_has_no_motion() -> None:
    machine = arm()
    assert machine.floating is not None
    driven = replace(machine, floating=replace(machine.floating, known=Known.ACCELERATION))
    with pytest.raises(InputError, match="base, known: the acceleration of the base is given"):
        reference(MOVES, driven)


def test_the_ladder_is_refused() -> None:
    machine = arm()
    with pytest.raises(InputError, match="ladder: not offered on a floating base"):
        ladder_of_prediction(prediction_of(machine, [reference(MOVES).prescribed], {"base.x": 1e-3}))


@pytest.mark.thorough
@needs_compiler
def test_steps_that_let_the_base_grow_out_of_range_are_refused() -> None:
    """A body that tumbles too fast for its steps: none of its joints tells, it has none."""
    text = "[motion]\nduration = 1\nbase = { velocity = [0, 0, 0, 3e3, 2e3, 1e3] }"
    machine = replace(arm(), joints=(Joint("tip", 0, Kind.FIXED, 2),), parameters=())
    with pytest.raises(InputError, match="--step: the motion leaves the valid range at"):
        simulate(reference(text, machine), Request(("base.rx",), method="rk4", step=0.05))
