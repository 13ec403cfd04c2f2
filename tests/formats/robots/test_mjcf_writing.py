"""A machine written as MJCF has the forces, accelerations and frames that MuJoCo computes, and is read back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.robots.mjcf_writing import write
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.left_out_parts import without
from symoro_elastic.machine.machine import NO_VECTOR, Floating, Kind, Machine, Orientation
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.command_line import EXAMPLES, run
from tests.formats.robots.mjcf_samples import ROBOTS
from tests.formats.robots.test_mjcf import OURS
from tests.references.random_machines import chain, random_machine

mujoco = pytest.importorskip("mujoco")

EXACT = 1e-12


def worst(machine: Machine, states: int = 3) -> float:
    """The largest error of forces, frames and accelerations against MuJoCo's model of what is written."""
    from tests.references.mujoco_model import Compared

    found = Compared.of_text(machine, write(machine)).errors(states)
    return max(found.forces, found.frames, found.accelerations)


def again(machine: Machine, folder: Path) -> Machine:
    file = folder / "again.xml"
    file.write_text(write(machine), encoding="utf-8")
    return read_machine(file)[0]


def on_base(machine: Machine, seed: int) -> Machine:
    """The machine on a base at rest, one that floats, or one that moves without turning."""
    if seed % 3 == 1:
        body = next(row.body for row in chain(2, seed=seed, symbolic=False).joints)
        return replace(machine, floating=Floating(body=body))
    if seed % 3 == 2:
        base = random_machine(seed, moving_base=True).base
        return replace(machine, base=replace(base, angular_velocity=NO_VECTOR, angular_acceleration=NO_VECTOR))
    return machine


def written(seed: int) -> Machine:
    """A random machine that MJCF can hold: no forces on bodies, and at most one joint on what has no mass."""
    return on_base(random_machine(seed, joints=4 + seed % 6, wrenches=False), seed)


SEEDS = [0, 1, 2, 3, 4, 7, 8]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", SEEDS)
def test_random_trees_are_mujocos(seed: int) -> None:
    """Motors with rotors, springs with neutral positions, friction, massless links; bases that float, and that move."""
    assert worst(written(seed)) < EXACT


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [k for k in range(9, 33) if k != 17])
def test_more_of_them(seed: int) -> None:
    assert worst(written(seed)) < EXACT


@pytest.mark.parametrize("name", ["two_axis.toml", "floating_arm.toml", "pendant_arm.urdf"])
def test_examples_are_mujocos(name: str) -> None:
    """Links without mass between joints are joints on one body: two_axis has seven."""
    machine = read_machine(f"examples/{name}")[0]
    if machine.floating:
        machine = replace(machine, floating=replace(machine.floating, orientation=Orientation.ROTATION))
    assert worst(machine) < EXACT


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_what_mjcf_said_is_written_again(name: str, tmp_path: Path) -> None:
    """From MJCF to a machine, to MJCF, to a machine: springs beside motors too; all torques are the same."""
    file = tmp_path / "first.xml"
    file.write_text(ROBOTS[name], encoding="utf-8")
    first = read_machine(file)[0]
    second = again(first, tmp_path)
    assert [(row.name, row.kind) for row in second.joints] == [(row.name, row.kind) for row in first.joints]
    assert_alike(first, again(second, tmp_path))


def assert_alike(first: Machine, second: Machine) -> None:
    """Inverse and direct dynamics of both at three states of their independent joints."""
    names = [row.name for row in first.independent_joints]
    assert [row.name for row in second.independent_joints] == names
    models = ("inverse_dynamics", "direct_dynamics")
    ours, theirs = numpy_model(first, models), numpy_model(second, models)
    rng = np.random.default_rng(len(names))
    for _ in range(3):
        state: dict[str, Any] = {"q": rng.uniform(-0.3, 0.3, len(names)), "qd": rng.normal(size=len(names))}
        if first.floating:
            state |= {"R0": np.eye(3).ravel(), "V0": rng.normal(size=6), "f0": rng.normal(size=6)}
        given = rng.normal(size=len(first.motors))
        for model, key in (("inverse_dynamics", "qdd_motor"), ("direct_dynamics", "tau")):
            a, b = (getattr(one, model)(**state, **{key: given}) for one in (ours, theirs))
            a, b = (np.concatenate([*map(np.ravel, x)]) if isinstance(x, tuple) else x for x in (a, b))
            assert b == pytest.approx(a, rel=0, abs=1e-11 * max(1.0, np.abs(a).max()))


CROSSED = OURS.replace('sigma = 0, d = 0.45, theta = "q4"', "sigma = 2, d = 0.45").replace(
    'meets = "end"', 'meets = "end", closes = "point"'
)


def palletizer() -> Machine:
    return without(read_machine("examples/palletizer.toml")[0], ["creep"])[0]


LOOPS = {
    "hinge": lambda: toml.read(OURS, "m.toml"),
    "point": lambda: toml.read(CROSSED, "m.toml"),
    "palletizer": palletizer,
    "gantry": lambda: read_machine("examples/gantry.toml")[0],
}


@pytest.mark.parametrize("name", LOOPS)
def test_mujocos_constraints_hold_where_loops_are_closed(name: str) -> None:
    """At positions of the closed loops the equality constraints have no residual, along the motion either."""
    machine = LOOPS[name]()
    generated = numpy_model(machine, ("dependent_coordinates",))
    rows = machine.independent_joints
    start = {key: x.value() for loop in machine.loops for key, x in loop.start.items()}
    model = mujoco.MjModel.from_xml_string(write(machine))
    data = mujoco.MjData(model)
    joints = {model.joint(k).name: model.joint(k).qposadr[0] for k in range(model.njnt)}
    for shift in (0.0, 0.02, -0.05):
        q = np.array([start.get(str(row.variable), 0.0) for row in rows]) + shift * np.arange(1, len(rows) + 1)
        owners = [machine.joint(j).name for j in machine.with_variable]
        found = dict(zip(owners, generated.dependent_coordinates(q), strict=True))
        for joint, x in found.items():
            if joint in joints:
                data.qpos[joints[joint]] = x
        mujoco.mj_forward(model, data)
        equal = data.efc_type == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
        assert equal.sum() >= 3 * len(machine.loops)
        assert np.abs(data.efc_pos[equal]).max() < 1e-12


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["hinge", "point", "palletizer"])
def test_loops_are_read_back(name: str, tmp_path: Path) -> None:
    """A hinge, which two points make, is a cut joint that turns again."""
    machine = LOOPS[name]()
    second = again(machine, tmp_path)
    cuts = [(machine.joint(loop.cut).sigma, loop.closes) for loop in machine.loops]
    assert [(second.joint(loop.cut).sigma, loop.closes) for loop in second.loops] == cuts
    around(machine, second)


def around(first: Machine, second: Machine) -> None:
    """Compare torques near the start of the loops."""
    models = ("inverse_dynamics",)
    start = {key: x.value() for loop in first.loops for key, x in loop.start.items()}
    q = np.array([start.get(str(row.variable), 0.0) for row in first.independent_joints]) + 0.02
    ones = np.ones(len(q))
    named = dict(zip([row.name for row in first.independent_joints], q, strict=True))
    torques = []
    for one in (first, second):
        own = np.array([named[row.name] for row in one.independent_joints])
        tau = numpy_model(one, models).inverse_dynamics(own, ones, ones[: len(one.motors)])[0]
        torques.append(dict(zip([row.name for row in one.motor_joints], tau, strict=True)))
    assert torques[1] == pytest.approx(torques[0], rel=1e-11)


def test_a_joint_that_follows_another_is_read_back(tmp_path: Path) -> None:
    machine = toml.read(COUPLED.replace("FORMULA", "0.2 - 0.5*q1 + 0.3*q1^2 - 0.1*q1^4"), "m.toml")
    assert_alike(machine, again(machine, tmp_path))


COUPLED = """
name = "m"
joints = [
  { name = "a", kind = "motor", sigma = 0, theta = "q1" },
  { name = "b", kind = "coupled", sigma = 0, alpha = "pi/2", d = 0.4, theta = "FORMULA" },
  { name = "tip", kind = "fixed", d = 0.2 },
]
[bodies]
a = { mass = 2, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.2] }
b = { mass = 1, center_of_mass = [0.2, 0, 0], inertia = [0.1, 0.2, 0.3] }
"""
ARM = COUPLED.replace("coupled", "motor").replace("FORMULA", "q2")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (ARM + "[wrenches]\nb = { force = [0, 1, 0] }\n", "joint 2 (b), force y: MJCF has no forces on bodies: write"),
        (ARM + "[friction]\na = { coulomb = 1, creep = 0.1 }\n", "joint 1 (a), creep velocity: MJCF has no creep"),
        (ARM + "[base]\nangular_velocity = [0, 0, 1]\n", "angular_velocity z: MJCF has no turning base"),
        (
            ARM + '[base]\nfloating = "rotation"\nlinear_damping = 2\n',
            "base, linear_damping: MJCF has one damping for both: give linear_damping and angular_damping one number",
        ),
        (ARM.replace("mass = 1", "mass = 0"), "joint 'b': mass and principal moments of inertia of what moves must"),
        (ARM.replace("0.1, 0.2, 0.3", "0.1, 0.2, 0.4"), "joint 'b': moments 0.1, 0.2 and 0.4 kg m2 about its centre"),
        (COUPLED.replace("FORMULA", "sin(q1)"), "joint 2 (b), theta: 'sin(q1)': MJCF has joints that follow one other"),
        (COUPLED.replace("FORMULA", "q1^5"), "joint 2 (b), theta: 'q1^5': MJCF has joints that follow one other by a"),
        (
            ARM.replace('"motor", sigma = 0, theta = "q1"', '"elastic", sigma = 0, theta = "q1"')
            + '[springs]\na = { stiffness = "10 + q2" }\n',
            "joint 1 (a), stiffness: '10 + q2': MJCF holds numbers only, nothing that changes with joints",
        ),
        (
            OURS.replace('kind = "cut",     sigma = 0, d = 0.45, theta', 'kind = "cut",     sigma = 1, d = 0.45, r'),
            "loop bars: its cut joint pin slides, which MJCF has not: cut it at a joint that turns",
        ),
    ],
)
def test_what_mjcf_cannot_say_is_refused_by_the_joint(text: str, why: str) -> None:
    with pytest.raises(InputError) as error:
        write(toml.read(text, "m.toml"))
    assert str(error.value).startswith(f"m.toml: {why}")


def test_bodies_that_are_flat_are_taken(tmp_path: Path) -> None:
    """The largest moment is the sum of the others but for rounding: 0.1 + 0.7 < 0.8 in double precision."""
    flat = toml.read(ARM.replace("0.1, 0.2, 0.3", "0.1, 0.7, 0.8"), "m.toml")
    assert worst(flat) < EXACT


@pytest.mark.thorough
def test_chains_deeper_than_xml_is_read_are_refused() -> None:
    with pytest.raises(InputError, match="joint 'joint391': more than 390 bodies carry each other"):
        write(chain(391, symbolic=False))


def test_the_command_writes_notes_and_what_is_left_out(tmp_path: Path) -> None:
    target = tmp_path / "p.xml"
    ran = run("convert", "examples/palletizer.toml", str(target), "--drop", "creep")
    assert "left out: what makes dry friction of flange smooth: it jumps at rest" in ran.stderr
    assert "<!-- left out: what makes dry friction of flange smooth" in target.read_text()
    machine = se.read(target)
    assert machine.loops and machine.name == "palletizer"


LIMITED = """
[limits]
a = { position = [-1, 2], velocity = 3, torque = [-5, 4] }
b = { position = [-0.5, 0.5] }
"""


def test_limits_are_written_and_read_back(tmp_path: Path) -> None:
    """Positions and torques of motors; a comment says what MJCF has not."""
    machine = toml.read(ARM + LIMITED, "m.toml")
    text = write(machine)
    assert "<!-- left out: limits of velocity of a -->" in text
    found = se.read(written_to(tmp_path, text), warn=lambda _: None).limits
    assert (found.of("a").position, found.of("a").torque) == (
        machine.limits.of("a").position,
        machine.limits.of("a").torque,
    )
    assert found.of("b") == machine.limits.of("b") and found.of("a").velocity is None


def written_to(folder: Path, text: str) -> Path:
    file = folder / "limited.xml"
    file.write_text(text, encoding="utf-8")
    return file


def test_motors_that_follow_others_are_refused() -> None:
    """MJCF would have them as motors of their own, and a reader could not tell which joints follow."""
    machine, _ = read_machine(EXAMPLES / "sr400.par")
    (loop,) = machine.loops
    driven = replace(machine.joint(8), kind=Kind.MOTOR)
    joints = tuple(driven if joint.name == driven.name else joint for joint in machine.joints)
    with pytest.raises(InputError, match=f"{driven.name} follow the others and have motors"):
        write(replace(machine, joints=joints, loops=(replace(loop, dependent=("elbow", driven.name)),)))
