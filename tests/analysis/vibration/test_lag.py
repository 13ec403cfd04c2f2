"""Springs with damping: their deflections follow tau q' + q = u, and the torques make the full model follow."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.vibration.feed_forward import feed_forward, lagging, notes, orders
from symoro_elastic.analysis.vibration.reference_trajectory import move
from symoro_elastic.formats.toml.starting import starting_text
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Friction, Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.programs.catalogue import trace
from tests.analysis.vibration.machines import drive, machine_of, slide, spring
from tests.analysis.vibration.test_reference_trajectory import (
    LOCKED,
    flex4,
    outboard,
    simulated,
    two_axis,
    whole_two_axis,
)
from tests.compiled_models import cell
from tests.models.test_feed_forward import with_springs
from tests.references.random_machines import random_machine

pytestmark = pytest.mark.sampled(4)


@pytest.mark.parametrize("tau", [1e-12, 1e-5, 1e-3, 2e-3, 0.1, 10.0])
def test_a_lag_of_a_sine(tau: float) -> None:
    """u = cos t + sin 2t gives cosines that lag; uneven samples, every order, any tau."""
    t = np.sort(np.random.default_rng(0).uniform(0, 3, 400)) * np.linspace(0.7, 1.0, 400)
    rates = (1j, 2j)
    u = np.array([sum(a * s**k * np.exp(s * t) for a, s in zip((1, -1j), rates, strict=True)).real for k in range(4)])
    q = np.array(
        [sum(a * s**k / (1 + s * tau) * np.exp(s * t) for a, s in zip((1, -1j), rates, strict=True)).real
         for k in range(4)]
    )  # fmt: skip
    transient = (q[:, 0] - lagging(t, u, tau)[:, 0])[:, None] * np.exp(-(t - t[0]) / tau)
    assert abs(lagging(t, u, tau) + transient - q).max() < 1e-6


def damped(machine: Machine, time: float) -> Machine:
    """The machine with damping in each spring, `time` seconds times its stiffness."""
    joints = tuple(
        replace(j, spring=replace(j.spring, damping=Formula.parse(f"({j.spring.stiffness}) * {time}")))
        if j.kind is Kind.ELASTIC else replace(j, friction=Friction(j.friction.viscous)) for j in machine.joints
    )  # fmt: skip
    return replace(machine, joints=joints)


@pytest.mark.parametrize(
    ("machine", "duration", "rate", "best"),
    [
        (drive(d=200.0), 0.4, 1000, 1e-9),
        (damped(flex4(), 0.01), 1.0, 400, 4e-9),
        (damped(two_axis(), 2e-4), 0.05, 20000, 1e-9),
    ],
    ids=["mass", "flex4", "two_axis"],
)
def test_the_full_model_follows_through_damped_springs(
    machine: Machine, duration: float, rate: float, best: float
) -> None:
    """The error is that of the integrations, of fourth order; without the lag the load would miss far more."""
    degree = max(orders(machine).values()) + 5
    errors = []
    for samples in (rate, 2 * rate):
        wanted = move(machine, {}, {"": 0.1}, duration, degree, samples)
        found = feed_forward(machine, wanted)
        y = np.stack(list(wanted.y.values()), axis=-1)[0]
        np.testing.assert_allclose(outboard(machine, found.q), y, rtol=0, atol=1e-15)
        errors.append(abs(outboard(machine, simulated(found)) - y[::2]).max())
    assert errors[1] < best and errors[0] / errors[1] > 10


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [3, 5])
def test_random_trees_with_damping_follow(seed: int) -> None:
    stiff = random_machine(seed, joints=3, kinds=(Kind.MOTOR,), branching=0.3, prismatic=0.4, symbolic=False)
    machine = damped(with_springs(stiff, [1, 2], seed), 0.005)
    errors = []
    for rate in (400, 800):
        found = feed_forward(machine, move(machine, {"": 0.1}, {"": 0.2}, 1.0, 13, rate))
        errors.append(abs(simulated(found) - found.q[::2]).max())
    assert errors[1] < 1e-6 and errors[0] / errors[1] > 10


def test_viscous_friction_of_a_spring_is_damping() -> None:
    rubbing = drive()
    load = replace(rubbing.joints[1], friction=Friction(cell(200)))
    one, other = drive(d=200.0), replace(rubbing, joints=(rubbing.joints[0], load))
    found = [feed_forward(machine, move(machine, {}, {"": 0.1}, 0.4, 6)).tau for machine in (one, other)]
    np.testing.assert_allclose(*found, rtol=1e-12)


def test_code_with_damping_is_refused_and_names_the_command() -> None:
    with pytest.raises(InputError, match=r"\(load\), damping: feed_forward: .*or use the command feed-forward"):
        trace(drive(d=1.0), "feed_forward")


# Springs that no motor drives


def test_springs_beside_the_motors_are_left_out() -> None:
    """Torques are those of the machine with them locked; loads and frequencies say what they cost."""
    whole = whole_two_axis()
    locked = restrict(whole, Scene(locked=dict.fromkeys(set(LOCKED) - {"sensor_head"}, ZERO)))
    found, same = (feed_forward(one, move(one, {}, {"": 0.1}, 0.5, 7, 200)) for one in (whole, locked))
    np.testing.assert_array_equal(found.tau, same.tau)
    assert found.left_out is not None and same.left_out is None
    assert set(found.left_out.deflections) == set(LOCKED) - {"sensor_head"} and found.left_out.frequency
    assert all(f"{name} " in notes(found)[0] for name in found.left_out.deflections)
    assert found.as_json()["left_out"]["frequency"] == found.left_out.frequency


def test_what_a_spring_left_out_costs() -> None:
    """A wall that gives way: m ydd bends it by m ydd / k, and it vibrates at sqrt(k / m) with all masses on it."""
    wall, motor = slide("wall", 0, Kind.ELASTIC, 7, spring=spring(1e6)), slide("motor", 1, Kind.MOTOR, 3)
    machine = machine_of("soft", wall, motor, slide("load", 2, Kind.ELASTIC, 5, spring=spring(2e4)))
    wanted = move(machine, {}, {"": 0.1}, 0.4, 9)
    found = feed_forward(machine, wanted)
    assert found.left_out is not None and found.orders == {"motor": 4}
    rows: Any = wanted.y["motor"]
    load = np.abs(8 * rows[2] + 3 * 5 / 2e4 * rows[4]).max()
    assert found.left_out.deflections["wall"] == pytest.approx(load / 1e6, rel=1e-2)
    assert found.left_out.frequency == pytest.approx(np.sqrt(1e6 / 15) / (2 * np.pi), rel=1e-9)
    said = notes(found)[0]
    assert said.startswith("no motor controls these springs, so they are held") and "from 41.09 Hz" in said


def test_limits_that_a_motion_exceeds_are_named(tmp_path: Path) -> None:
    """As `simulate` names them; the default move of a stiff arm lasts five of its periods."""
    path = tmp_path / "elastic.toml"
    text = starting_text("elastic", "elastic")
    path.write_text(text.replace("acceleration = 15", "acceleration = 15, torque = 100"))
    slow, fast = (se.feed_forward(path, strokes=0.1, duration=duration) for duration in (5.0, 0.05))
    assert slow.beyond == () and slow.as_json()["beyond_limits"] == []
    assert [(one.joint, one.quantity) for one in fast.beyond] == [("drive", "velocity"), ("drive", "torque")]
    assert str(fast.beyond[1]) in fast.parts() and fast.beyond[1].value == pytest.approx(np.abs(fast.tau).max())
