"""Friction with states and falling with velocity: (D1), (D2) with their branches, energy, and models that hold them."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.codegen.integration.tableaus import W3
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import NO_NUMBER, TUNED, CurrentControl, Drive, Drives, LowPass
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.joints import Electrics
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.models.steps.closed_dynamics import closed_dynamics
from symoro_elastic.models.steps.implicit_steps import Motors, implicit_system
from symoro_elastic.models.steps.time_steps import refuse_machines
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.symbolic.program import Program

LAW = {
    "viscous": 0.4,
    "coulomb": 1.0,
    "static": 1.5,
    "stribeck": 1e-3,
    "bristle": 1e5,
    "bristle_damping": 316.0,
    "breakaway": 0.7,
}
"""Canudas de Wit et al., A new model for control of systems with friction, IEEE TAC 40, 1995, elasto-plastic."""


def slider(**law: float) -> Machine:
    """A mass of 1 kg that slides under a motor."""
    friction = Friction(**{key: Formula.parse(repr(x)) for key, x in law.items()})
    return Machine("mass", (Joint("mass", 0, Kind.MOTOR, 1, "x", body=Body(Formula.parse(1)), friction=friction),))


def rate_of_bristle(v: float, z: float, law: dict[str, float], load: float = 0.0) -> float:
    """By the branches of the specification, which the models do not have."""
    coulomb = law["coulomb"] + law.get("load", 0.0) * abs(load)
    static = law.get("static", law["coulomb"]) + law.get("load", 0.0) * abs(load)
    level = coulomb + (static - coulomb) / (1 + (v / law["stribeck"]) ** 2) if "static" in law else coulomb
    largest = level / law["bristle"]
    elastic = law["breakaway"] * largest
    alpha = 1.0
    if law["breakaway"]:
        x = (abs(z) - elastic) / (largest - elastic)
        alpha = 0.0 if v * z <= 0 or x <= 0 else 1.0 if x >= 1 else 3 * x**2 - 2 * x**3
    return v - alpha * law["bristle"] * abs(v) / level * z


@pytest.mark.parametrize("breakaway", [0.0, 0.7])
@pytest.mark.parametrize("load", [{}, {"load": 0.1}])
def test_models_are_the_equations(breakaway: float, load: dict[str, float]) -> None:
    law = LAW | {"breakaway": breakaway} | load
    machine, rng = slider(**law), np.random.default_rng(1)
    v, z = rng.normal(size=400) * 2e-3, rng.normal(size=400) * 1.2e-5
    v[:3], z[2:5] = 0.0, 0.0
    lam, tau = rng.normal(size=400) * 5, rng.normal(size=400)
    found = numpy_model(machine, ("direct_dynamics", "inverse_dynamics", "friction_forces"))
    more = {"load": lam[:, None]} if load else {}
    zd = np.array([rate_of_bristle(*x, law, one) for *x, one in zip(v, z, lam, strict=True)])
    force = law["bristle"] * z + law["bristle_damping"] * zd + law["viscous"] * v
    given = {"q": np.zeros((400, 1)), "qd": v[:, None], "z": z[:, None], **more}
    qdd, rates = found.direct_dynamics(tau=tau[:, None], **given)
    assert np.abs(rates[:, 0] - zd).max() < 1e-14
    assert np.abs(qdd[:, 0] - (tau - force)).max() < 1e-12
    torque, _, rates = found.inverse_dynamics(qdd_motor=qdd, **given)
    assert np.abs(torque[:, 0] - tau).max() < 1e-12 and np.abs(rates[:, 0] - zd).max() < 1e-14
    alone = {key: x for key, x in given.items() if key != "q"}
    assert np.abs(found.friction_forces(**alone)[:, 0] - force).max() < 1e-12


def test_rates_are_those_of_mujoco() -> None:
    """Its dcmotor with lugre="100 0.1 0.5 0.8 0.05" at 2 rad/s and z = 1e-3: zd 1.6, force 0.3 with 0.02 viscous.

    It has exp, which is 0 to all digits at that velocity: without `static` both are the same there.
    """
    assert math.exp(-((2 / 0.05) ** 2)) == 0.0
    law = {"viscous": 0.02, "coulomb": 0.5, "bristle": 100.0, "bristle_damping": 0.1, "breakaway": 0.0}
    found = numpy_model(slider(**law), ("direct_dynamics",))
    qdd, zd = found.direct_dynamics(np.zeros(1), np.array([2.0]), np.array([1e-3]), np.zeros(1))
    assert abs(zd[0] - 1.6) < 1e-12 and abs(qdd[0] + 0.3) < 1e-12


@pytest.mark.parametrize("creep", [0.0, 0.3])
def test_friction_that_falls_with_velocity_has_the_slope_in_derivatives(creep: float) -> None:
    law = {"viscous": 0.4, "coulomb": 1.0, "static": 1.5, "stribeck": 0.2, "creep": creep}
    model = numpy_model(slider(**law), ("friction_forces", "inverse_dynamics_derivatives"))
    v, h = np.linspace(-1, 1, 20)[:, None], 1e-6
    slope = (model.friction_forces(v + h) - model.friction_forces(v - h)) / (2 * h)
    found = model.inverse_dynamics_derivatives(np.zeros((20, 1)), v, np.zeros((20, 1)))
    by_qd = dict(zip(model.OUTPUTS["inverse_dynamics_derivatives"], found, strict=True))["dtau_dqd"]
    assert np.abs(by_qd.ravel() - slope.ravel()).max() < 1e-7


@pytest.mark.parametrize("breakaway", [0.0, 0.7])
def test_friction_gives_no_energy(breakaway: float) -> None:
    """At 1e5 states: its power is at least that which its bristle stores, so none comes out along any motion.

    Deflections are within static/bristle, which no motion leaves: z zd is not positive there. Viscous friction is above
    the bound of Barabanov and Ortega; below it, there are states that give energy.
    """
    law = LAW | {"breakaway": breakaway, "viscous": 158.001}
    assert check(slider(**law)) == []
    assert "friction may give energy" in check(slider(**LAW))[0]
    rng, count = np.random.default_rng(3), 100_000
    v = rng.choice([-1, 1], count) * 10 ** rng.uniform(-7, 1, count)
    z = rng.uniform(-1, 1, count) * law["static"] / law["bristle"]
    model = numpy_model(slider(**law), ("direct_dynamics",))
    qdd, zd = (x[:, 0] for x in model.direct_dynamics(0 * v[:, None], v[:, None], z[:, None], 0 * v[:, None]))
    taken, stored = -qdd * v, law["bristle"] * z * zd
    assert ((taken - stored) / (np.abs(taken) + np.abs(stored))).min() >= -1e-9
    outermost = np.sign(z) * law["static"] / law["bristle"]
    _, zd = model.direct_dynamics(0 * v[:, None], v[:, None], outermost[:, None], 0 * v[:, None])
    assert (zd[:, 0] * outermost).max() <= 1e-20
    assert ((taken - 157 * v * v - stored) / (np.abs(taken) + np.abs(stored))).min() < -1e-3


def operations(program: Program) -> int:
    return program.count.mul + program.count.add + program.count.div


def with_friction_of_motor(machine: DescribedMachine, law: Friction) -> DescribedMachine:
    laws = ((one, law if one.name == "motor" else Friction()) for one in machine.joints)
    return replace(machine, joints=tuple(replace(one, friction=own) for one, own in laws))


def per_step(machine: Machine, motors: Motors) -> int:
    folded = [p.name for p in machine.parameters]
    driven = motors is Motors.DRIVES
    right = closed_dynamics(machine, folded) if driven else trace(machine, "direct_dynamics", folded=folded)
    once, solve = implicit_system(machine, motors, folded)
    return len(W3.b) * (operations(right.program) + operations(solve.program)) + operations(once.program)


@pytest.mark.parametrize(("breakaway", "most"), [(0.0, 195), (0.7, 220)])
def test_operations_of_a_cascade_with_friction(breakaway: float, most: int) -> None:
    """In a step of w3 for PI, lag of the current loop and friction on one motor: LuGre, elasto-plastic."""
    described = read_machine(Path(__file__).parents[2] / "examples" / "ball_screw.toml")[0]
    law = slider(**LAW | {"breakaway": breakaway}).joints[0].friction
    bent, bare = (with_friction_of_motor(described, one) for one in (law, Friction(viscous=law.viscous)))
    drive = Drive(Formula.parse(30), Formula.parse("1.5"), Formula.parse("0.02"), Formula.parse("2e-4"))
    driven = replace(bent, drives=Drives({"motor": drive}))
    assert per_step(driven, Motors.DRIVES) - per_step(bare, Motors.TORQUE) <= most


def test_operations_of_parts_of_drives() -> None:
    """In a step of w3: a limit with its back-calculation, a filter of the set point, a winding with both limits."""
    described = read_machine(Path(__file__).parents[2] / "examples" / "ball_screw.toml")[0]
    winding = Electrics(*map(Formula.parse, ("0.5", "2e-3", "0.2", "0.15")))
    bare = with_friction_of_motor(described, Friction(viscous=Formula.parse("0.4")))
    bare = replace(bare, joints=tuple(replace(one, electrics=winding) for one in bare.joints))
    plain = Drive(Formula.parse(30), Formula.parse("1.5"), Formula.parse("0.02"), Formula.parse("2e-4"))
    few = Formula.parse("15")
    wound = replace(plain, lag=ZERO, current=CurrentControl(Formula.parse("4"), Formula.parse("3e-3")))
    drives = {
        107: plain,
        183: replace(plain, torque_limit=few),
        187: replace(plain, set_point=LowPass(Formula.parse("60"), 2)),
        200: wound,
        374: replace(wound, current_limit=few, voltage_limit=few),
    }
    without = per_step(bare, Motors.TORQUE)
    for most, drive in drives.items():
        assert per_step(replace(bare, drives=Drives({"motor": drive})), Motors.DRIVES) - without <= most


@pytest.mark.parametrize(
    ("law", "steps", "says"),
    [
        (LAW, ("midpoint",), "midpoint is not offered with states of friction .*use w3"),
        (LAW, ("rodas4",), "rodas4 is not offered with states of friction"),
        ({"coulomb": 1, "creep": 0.1, "load": 0.1}, ("rodas4",), "rodas4 is not offered with friction that rises"),
    ],
)
def test_steps_that_are_refused(law: dict[str, float], steps: Any, says: str) -> None:
    with pytest.raises(InputError, match=says):
        refuse_machines(slider(**law), steps)


def driven_slider(**changes: Any) -> DescribedMachine:
    drive = replace(Drive(*map(Formula.parse, ("30", "1.5", "0.02", "2e-4"))), **changes)
    return replace(DescribedMachine.of(slider(viscous=0.1)), drives=Drives({"mass": drive}))


@pytest.mark.parametrize("method", ["rodas4", "midpoint"])
def test_steps_without_states_of_drives_are_refused(method: str) -> None:
    with pytest.raises(InputError, match=f"drives, mass: {method} is not offered with drives: use w3, or leave"):
        trace_models(driven_slider(), Scene(models=("direct_dynamics",), steps=(method,)))


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"Kp": TUNED}, f"a gain of mass is {NO_NUMBER}"),
        ({"measured": "tip.x"}, "mass measures tip.x, which is known along a motion only: simulate takes it"),
        ({"period": Formula.parse("1e-3")}, "mass has a period: its controller is the model control"),
    ],
)
def test_steps_without_drives_say_why(changes: dict[str, Any], why: str, tmp_path: Path) -> None:
    made = se.generate(driven_slider(**changes), "direct_dynamics", steps=["w3"], targets=["c"], out=tmp_path)
    assert made.notes == (f"time steps are without [drives]: {why}",)


@pytest.mark.parametrize(
    ("law", "model", "says"),
    [
        (LAW, "regressor", "regressor, friction, mass, static: torques are not linear in its parameters"),
        (LAW, "feed_forward", "friction, mass: feed_forward does not know its state"),
    ],
)
def test_models_that_are_refused(law: dict[str, float], model: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        trace(slider(**law), model)
