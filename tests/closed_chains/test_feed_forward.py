"""Feed-forward through transmissions and in loops: its motion fulfils d'Alembert's principle in many digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Friction, Kind, Machine, Spring
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.dynamics.feed_forward import over_time
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.closed_chains.machines import machine, situations
from tests.references.closed_chains import DIGITS, Array, State, exact, in_many_digits
from tests.references.virtual_work import VirtualWork

pytestmark = pytest.mark.sampled(5)

STEP, EXACT = mpf(10) ** -20, 1e-25
AT = mpf("0.37")

WRIST = Path(__file__).parent / "mixing_wrist.toml"


def undamped(described: Machine, locked: Mapping[str, str]) -> Machine:
    """The machine without dampers, and without the springs that no motor makes follow."""
    kept = restrict(described, Scene(locked={name: Formula.parse(x) for name, x in locked.items()}))
    springs = (replace(joint, spring=replace(joint.spring, damping=ZERO)) for joint in kept.joints)
    return replace(kept, joints=tuple(springs))


@pytest.fixture
def wrist() -> Machine:
    return read_machine(WRIST)[0]


@in_many_digits
def swinging(starts: list[float]) -> Callable[[Any], list[list[Any]]]:
    """y and its derivatives of each motor: sines of different rates about where the motors start."""

    def motion(t: Any) -> list[list[Any]]:
        rates = [mpf(9 + 4 * k) / 10 for k in range(len(starts))]
        y = [[w**k * mp.sin(w * t + k * mp.pi / 2) / 20 for w in rates] for k in range(13)]
        y[0] = [x + mpf(start) for x, start in zip(y[0], starts, strict=True)]
        return y

    return motion


@in_many_digits
def commanded(described: Machine, y: list[list[Any]]) -> dict[str, Array]:
    program, arithmetic = trace(described, "feed_forward").program, multiprecision(DIGITS)
    symbols = {p.name: p.value.evaluate({}, {}, exact) for p in described.parameters if p.value}
    for entries, numbers in zip(program.inputs, y, strict=False):
        symbols |= dict(zip(entries.symbols, numbers, strict=True))
    value = evaluate([x for output in program.outputs for x in output.entries], symbols, arithmetic)
    return {o.name: np.array([exact(value(x)) for x in o.entries], dtype=object) for o in program.outputs}


@in_many_digits
def assert_followed(described: Machine, starts: list[float], guess: Mapping[str, float], loads: list[str]) -> None:
    """Forces vanish, velocities are those of positions, and the joints `loads` are where they were wanted."""
    motion = swinging(starts)
    before, here, after = (commanded(described, motion(AT + k * STEP)) for k in (-1, 0, 1))
    qd, qdd = ((after[name] - before[name]) / (2 * STEP) for name in ("q", "qd"))
    at = VirtualWork(described, State(list(here["q"]), list(here["qd"]), guess))
    left = at.residual(qdd, list(here["tau"]))
    scale = max(map(abs, here["tau"]))
    assert max(map(abs, left)) < EXACT * scale
    assert max(map(abs, qd - here["qd"])) < EXACT * max(map(abs, qd))
    values = dict(zip([j.name for j in described.joints], at.chain.joint_values(at.rows, at.at), strict=True))
    for name, wanted in zip(loads, motion(AT)[0], strict=False):
        assert abs(values[name] - wanted) < EXACT, name


def test_through_a_ball_screw() -> None:
    """Shaft, belt, screw and nut: the coordinate of the motor is the position of the nut."""
    described = undamped(machine("ball_screw"), {"screw_axial": "1e-5", "table": "0", "encoder": "0"})
    assert_followed(described, [0.02], {}, ["nut"])


def test_springs_on_the_axis_behind_a_transmission() -> None:
    described = undamped(machine("ball_screw"), {"screw_axial": "0", "screw": "0", "encoder": "0"})
    assert [j.name for j in described.independent_joints][-1] == "table"
    assert_followed(described, [0.02], {}, [])


def test_couplings_that_mix_motors_and_springs(wrist: Machine) -> None:
    """Roll follows pitch: its spring loads both chains. A disk that follows has inertia and friction."""
    assert_followed(undamped(wrist, {"hand": "0"}), [0.3, -0.2], {}, ["pitch", "roll"])


def test_springs_against_the_axis_behind_a_mixing_coupling(wrist: Machine) -> None:
    assert_followed(wrist, [0.3, -0.2], {}, [])


def test_in_a_loop_with_elastic_cranks() -> None:
    described = undamped(machine("five_bar"), {"tool": "0.1"})
    assert_followed(described, [2.3, 0.8], situations("five_bar")[0].state.guess, [])


@pytest.mark.thorough
def test_in_a_loop_in_space() -> None:
    """Its closed form is that of inverse geometry."""
    described = undamped(machine("spatial_four_bar"), {})
    assert_followed(described, [0.6], situations("spatial_four_bar")[0].state.guess, [])


def test_in_a_parallelogram() -> None:
    described = undamped(machine("parallelogram_loop"), {"wrist": "0"})
    assert_followed(described, [0.2, -0.9, 0.4], {}, ["yaw", "arm", "crank"])


# Springs on dependent joints, and stiffness that changes with positions


def with_spring(described: Machine, name: str, stiffness: str, **cells: str) -> Machine:
    """The machine with a spring at a joint, without its friction."""
    spring = Spring(Formula.parse(stiffness), **{key: Formula.parse(x) for key, x in cells.items()})
    joints = (
        replace(joint, kind=Kind.ELASTIC, spring=spring, friction=Friction()) if joint.name == name else joint
        for joint in described.joints
    )
    return replace(described, joints=tuple(joints))


def strut(stiffness: str, flap: str = "5000") -> Machine:
    """A flap behind a motor and a spring, held by a strut with a spring whose variable the loop gives."""
    held = with_spring(undamped(machine("gas_spring"), {}), "rod", stiffness, neutral="0.5", damping="40")
    loops = (replace(held.loops[0], dependent=("cylinder", "rod")),)
    return with_spring(replace(held, loops=loops), "flap", flap)


def test_a_spring_on_a_dependent_joint() -> None:
    assert_followed(strut("3000"), [0.6], situations("gas_spring")[0].state.guess, [])


def test_stiffness_of_a_spring_on_a_dependent_joint() -> None:
    assert_followed(strut("3000 + 200*s + 50*a^2"), [0.6], situations("gas_spring")[0].state.guess, [])


def test_stiffness_that_changes_with_the_load() -> None:
    held = strut("3000", "5000*(1 + 0.1*sin(qm + d_flap))")
    assert_followed(held, [0.6], situations("gas_spring")[0].state.guess, [])


def test_stiffness_that_changes_with_the_motor() -> None:
    """A spring as stiff as its motor stands, behind it one as stiff as its screw stands."""
    held = with_spring(undamped(machine("screw"), {"tool": "0"}), "screw", "40000*(1 - 0.3*sin(qm))")
    varying = with_spring(held, "nut", "EA/(rest - pitch/(2*pi)*(qm + d_screw))", neutral="-0.0001")
    assert_followed(varying, [0.6, 0.3], {}, ["nut", "head"])


def test_stiffness_that_changes_with_the_deflection(wrist: Machine) -> None:
    """A spring against the axis before it, behind one that is progressive, behind a transmission."""
    progressive = with_spring(wrist, "roll", "4000 + 3e7*d6^2", neutral="0.002")
    varying = with_spring(progressive, "hand", "700 + 100*sin(d7)", neutral="-0.02")
    assert_followed(varying, [0.3, -0.2], {}, [])


def test_a_spring_that_needs_its_own_deflection_is_refused() -> None:
    """The nut is as stiff as the motor stands, and the spring between the two is bent by what the nut carries."""
    held = with_spring(undamped(machine("screw"), {"tool": "0"}), "screw", "40000")
    with pytest.raises(InputError, match="need each other's deflections"):
        trace(with_spring(held, "nut", "EA/(rest - pitch/(2*pi)*qm)"), "feed_forward")


def test_a_damped_spring_whose_stiffness_changes_is_refused() -> None:
    with pytest.raises(InputError, match=r"joint 2 \(flap\), damping: .*differential equation"):
        trace(with_spring(strut("3000"), "flap", "5000 + s", damping="1"), "feed_forward")
    with pytest.raises(InputError, match=r"joint 2 \(flap\), stiffness: .*depends on positions, and .* damping"):
        over_time(with_spring(strut("3000"), "flap", "5000 + s", damping="1"))


def test_stiffness_that_changes_with_another_load(wrist: Machine) -> None:
    held = undamped(wrist, {"hand": "0"})
    varying = with_spring(held, "roll", "4000 + 500*sin(q5/N5 + d5)", neutral="0.003")
    assert_followed(varying, [0.3, -0.2], {}, ["pitch", "roll"])


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("ring", "loop ring: feed_forward: it has no closed form"),
        ("gantry", r"joint 1 \(carriage_2\), kind|joint . \(carriage_2\), kind: feed_forward: its variable follows"),
        ("ball_screw", "feed_forward: it is elastic, but not the single spring behind a motor"),
    ],
)
def test_what_is_refused(name: str, what: str) -> None:
    with pytest.raises(InputError, match=what):
        trace(undamped(machine(name), {}), "feed_forward")
