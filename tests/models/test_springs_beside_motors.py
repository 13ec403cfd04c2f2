"""A spring beside a motor: the machine of a motor without torque is that of an elastic joint."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.par.reading import read as read_par
from symoro_elastic.formats.par.reading import write as write_par
from symoro_elastic.formats.toml.reading import read as read_toml
from symoro_elastic.formats.toml.writing import write as write_toml
from symoro_elastic.generation.pipeline import operation_counts
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.command_line import refused
from tests.references.random_machines import random_machine, random_state, with_springs_beside_motors

EXACT = 1e-12
MODELS = ("direct_dynamics", "inverse_dynamics", "energy", "linearization", "direct_dynamics_derivatives", "regressor")


def pair(seed: int) -> tuple[Machine, Machine]:
    """A machine in which all motors have springs, and the same with elastic joints in place of the motors."""
    bare = random_machine(seed, joints=5, kinds=(Kind.MOTOR, Kind.PASSIVE), massless=0.0)
    driven = with_springs_beside_motors(bare, seed)
    rows = (replace(x, kind=Kind.ELASTIC) if x.kind is Kind.MOTOR else x for x in driven.joints)
    return driven, replace(driven, joints=tuple(rows))


@pytest.mark.sampled(5)
@pytest.mark.parametrize("seed", range(3))
def test_motors_without_torque_are_elastic_joints(seed: int) -> None:
    """Accelerations, their slopes, energies and small motions, and no torque gives these accelerations."""
    driven, elastic = (numpy_model(machine, MODELS) for machine in pair(seed))
    q, qd, _ = (np.array(x, dtype=float) for x in random_state(pair(seed)[0], seed))
    motors = [k for k, joint in enumerate(pair(seed)[0].independent_joints) if joint.kind is Kind.MOTOR]
    still = np.zeros(len(motors))
    qdd = elastic.direct_dynamics(q, qd, [])
    assert driven.direct_dynamics(q, qd, still) == pytest.approx(qdd, rel=EXACT)
    tau, others = driven.inverse_dynamics(q, qd, qdd[motors])
    assert np.abs(tau).max() < EXACT * np.abs(elastic.linearization(q, qd, qdd)[0]).max() * np.abs(qdd).max()
    assert others == pytest.approx(qdd, rel=EXACT)
    pairs = [(driven.energy(q, qd), elastic.energy(q, qd))]
    pairs += [(driven.linearization(q, qd, qdd), elastic.linearization(q, qd, qdd))]
    pairs += [
        (driven.direct_dynamics_derivatives(q, qd, still)[:2], elastic.direct_dynamics_derivatives(q, qd, [])[:2])
    ]
    for found, wanted in pairs:
        for ours, theirs in zip(found, wanted, strict=True):
            assert np.abs(ours - theirs).max() < EXACT * np.abs(theirs).max()


def test_the_torque_is_proportional_to_the_stretch_over_whole_turns() -> None:
    without, sprung = (numpy_model(read_toml(text, "arm.toml"), ("inverse_dynamics",)) for text in (BARE, ARM))
    q, qd, qdd = np.array([[0.3, 0.2], [0.3, 0.2 + 8 * np.pi]]), [0.4, -2.0], [0.5, 3.0]
    tau = sprung.inverse_dynamics(q, qd, qdd)[0] - without.inverse_dynamics(q, qd, qdd)[0]
    assert tau == pytest.approx(np.stack([np.zeros(2), 30 * (q[:, 1] - np.radians(20))], axis=1), abs=1e-12)


def test_it_costs_a_product_and_two_sums() -> None:
    scene = Scene(("inverse_dynamics",))
    without, sprung = (
        operation_counts(read_toml(text, "arm.toml"), scene)["inverse_dynamics"][0] for text in (BARE, ARM)
    )
    assert (sprung.products - without.products, sprung.add - without.add) == (1, 2)


ARM = """
name = "arm"
gravity = [0, -9.81, 0]
joints = [
  { name = "shoulder", kind = "motor", sigma = 0, theta = "q1" },
  { name = "elbow", kind = "motor", sigma = 0, d = 0.4, theta = "q2" },
]
[bodies]
shoulder = { mass = 3, center_of_mass = [0.2, 0, 0], inertia = [0.01, 0.1, 0.1] }
elbow = { mass = 2, center_of_mass = [0.2, 0, 0], inertia = [0.01, 0.1, 0.1] }
[springs]
elbow = { stiffness = "30 N m/rad", neutral = "20 deg" }
"""
BARE = ARM[: ARM.index("[springs]")]


@pytest.mark.parametrize("write, read, ending", [(write_toml, read_toml, "toml"), (write_par, read_par, "par")])
def test_files_keep_it(write: Any, read: Any, ending: str) -> None:
    machine = read_toml(ARM, "arm.toml")
    assert read(write(machine), f"arm.{ending}").joints == machine.joints


FAULTS = {
    "stiffness = 30, damping = 1": "damping",
    "stiffness = 30, backlash = 0.01": "backlash",
    "neutral = 0.1": "the motor has no spring: give its stiffness, or leave it out",
    'stiffness = "30*cos(q1)"': "stiffness",
}


@pytest.mark.parametrize("cells", FAULTS)
def test_what_only_elastic_joints_have_is_refused(cells: str, tmp_path: Path) -> None:
    file = tmp_path / "arm.toml"
    file.write_text(BARE + f"[springs]\nelbow = {{ {cells} }}\n", encoding="utf-8")
    line = refused("check", str(file))
    assert "joint 2 (elbow)" in line and FAULTS[cells] in line
