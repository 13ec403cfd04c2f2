"""Floating machines that hover: on forces of constant direction, and on thrusts that turn with their frames."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.vibration.linearization import Linearization, linearize
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.analysis.vibration.views import state_json, state_lines
from symoro_elastic.formats import write_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import Thrusts, equilibrium, hover, thrusts_of, with_thrusts
from tests.analysis.vibration.machines import WEIGHT, drive, spring
from tests.analysis.vibration.test_free_base import M1, M2, K, pair
from tests.command_line import refused, run
from tests.compiled_models import cell, vector

pytestmark = pytest.mark.sampled(4)

G, TOTAL = 9.81, 9.81 * (M1 + M2)


def hovering(machine: Machine, thrusts: Thrusts) -> Linearization:
    motion = motion_of(with_thrusts(machine, thrusts))
    return linearize(motion, hover(motion, {}, thrusts))


def drone() -> Machine:
    """Rotors beside a body, an arm of a spring that bends under its own weight."""
    arm = Joint("arm", 0, Kind.ELASTIC, 0, "q_arm", d=cell(0.1), alpha=cell("pi/2"), spring=spring(50))
    arm = replace(arm, body=Body(cell(0.5), vector(0.1, 0, 0)))
    rotors = [
        Joint(f"rotor{k}", 0, Kind.FIXED, 2, gamma=cell(f"pi/2*{k}"), d=cell(0.3), alpha=cell(0)) for k in range(4)
    ]
    whole = pair(WEIGHT)
    return replace(whole, joints=(*whole.joints, arm, *rotors))


def test_a_force_of_constant_direction_carries_the_base() -> None:
    motion = motion_of(pair(WEIGHT))
    linear = linearize(motion, equilibrium(motion, carried=True), (), ())
    assert linear.state.tau == pytest.approx([0, 0, TOTAL, 0, 0, 0, 0], abs=1e-12)
    assert linear.is_symmetric and linear.unrest == ()
    assert modes(linear).frequencies[-1] == pytest.approx(np.sqrt(K * (1 / M1 + 1 / M2)) / (2 * np.pi), rel=1e-6)
    assert "carried by base.z 98.1 N" in state_lines(linear)
    assert state_json(linear)["base"]["base.z"] == pytest.approx(TOTAL)


def test_thrusts_turn_with_their_frames() -> None:
    """Tilted by a small angle, a craft is pulled sideways by its weight: x'' = g ry, y'' = -g rx."""
    linear = hovering(pair(WEIGHT), {"base.fz": None})
    assert thrusts_of(linear.motion)["base.fz"] == pytest.approx(TOTAL, rel=1e-14)
    assert linear.K[:3, 3:6] == pytest.approx(np.array([[0, -TOTAL, 0], [TOTAL, 0, 0], [0, 0, 0]]), abs=1e-9)
    assert not linear.is_symmetric
    with pytest.raises(InputError, match=r"not symmetric.*--hover"):
        modes(linear)


def test_thrusts_are_found_as_springs_bend() -> None:
    """Four rotors lift a craft whose arm sags, which moves its centre of mass: forces and moments balance."""
    linear = hovering(drone(), dict.fromkeys([f"rotor{k}.fz" for k in range(4)]))
    found = thrusts_of(linear.motion)
    assert sum(found.values()) == pytest.approx(TOTAL + 0.5 * G, rel=1e-12)
    sag = linear.state.q[-1]
    lever = 0.1 + 0.2 * np.cos(sag)
    assert 0.3 * (found["rotor0.fz"] - found["rotor2.fz"]) == pytest.approx(0.5 * G * lever, rel=1e-9)
    assert sag != 0 and linear.unrest == () and linear.state.residual < 1e-9


def test_a_thrust_that_is_given_is_not_changed() -> None:
    rotors: dict[str, float | None] = {f"rotor{k}.fz": None for k in range(4)}
    found = thrusts_of(hovering(drone(), {**rotors, "base.fz": 30.0}).motion)
    assert found["base.fz"] == 30.0 and sum(found.values()) == pytest.approx(TOTAL + 0.5 * G, rel=1e-12)


@pytest.mark.parametrize(
    ("machine", "thrusts", "said"),
    [
        (pair(WEIGHT), {"base.fx": None}, r"do not balance base\.z \(98\.1 N\)"),
        (pair(WEIGHT), {"base.fz": 98.0}, r"do not balance base\.z \(0\.1 N\)"),
        (pair(WEIGHT), {"bose.fz": None}, "did you mean 'base'"),
        (pair(WEIGHT), {"base.vz": None}, "is not FRAME.fx|fy"),
        (pair(WEIGHT), {"base.fz": 1e300}, "out of range"),
        (drive(), {"load.fz": None}, "the base is fixed"),
    ],
)
def test_thrusts_refused(machine: Machine, thrusts: Thrusts, said: str) -> None:
    with pytest.raises(InputError, match=said) as error:
        hovering(machine, thrusts)
    assert "\n" not in str(error.value)


@pytest.mark.thorough
def test_the_commands(tmp_path: Path) -> None:
    file = tmp_path / "craft.toml"
    write_machine(pair(WEIGHT), file)
    assert "--hover" in refused("modes", file)
    found = json.loads(run("modes", file, "--hover", "--json").stdout)
    assert found["state"]["base"]["base.z"] == pytest.approx(TOTAL)
    assert "carried by base.fz 98.1" in run("linearize", file, "--thrust", "base.fz").stdout
    assert run("response", file, "--thrust", "base.fz", "--input", "base.my", "--output", "base.z").exit_code == 0
    assert "--hover: remove --thrust" in refused("linearize", file, "--thrust", "base.fz", "--hover")
