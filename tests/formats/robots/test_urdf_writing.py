"""A machine written as URDF is the same robot; what URDF cannot say is refused by the joint."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats import read_machine
from symoro_elastic.formats.robots.joint_tree import about_x, about_z
from symoro_elastic.formats.robots.modified_dh import machine_of
from symoro_elastic.formats.robots.urdf import describe, rotation
from symoro_elastic.formats.robots.urdf_writing import rpy_of, write
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.valid_names import with_valid_names
from tests.formats.robots.samples import ARM, GRIPPER, joint, link, random_robots, robot

HEAD = 'name = "m"\ngravity = [0, 0, -9.81]\njoints = [\n'
ROW = '  {{ name = "{0}", antecedent = {1}, kind = "{2}", sigma = 0, theta = "{3}" }},\n'
SOFT = HEAD + ROW.format("a", 0, "elastic", "q1") + "]\n[springs]\na = { stiffness = 3 }\n"
RIGID = HEAD + ROW.format("a", 0, "motor", "q1") + ROW.format("b", 1, "motor", "q2") + "]\n"
FOLLOWING = HEAD + ROW.format("a", 0, "motor", "q1") + ROW.format("b", 1, "coupled", "FORMULA") + "]\n"
FLOATING = (
    RIGID + '[base]\nfloating = "rotation"\nbody = { mass = 2, center_of_mass = [0, 0, 0.1], inertia = [1, 1, 1] }\n'
)


def read(text: str) -> Machine:
    return with_valid_names(machine_of(describe(text, "robot.urdf"), "robot.urdf"))


def again(machine: Machine) -> Machine:
    """The machine read back from its URDF."""
    return read(write(machine))


def rounded(machine: Machine) -> dict[str, list[float]]:
    """The numbers of rows and bodies."""
    keys = {"gamma", "b", "alpha", "d", "theta", "r"}
    found = {}
    for row in machine.joints:
        cells = [getattr(row, key) for key in sorted(keys - {SELECTED.get(row.sigma)})] + [
            row.body.mass,
            *row.body.moments,
            *row.body.inertia,
        ]
        found[row.name] = [cell.value() for cell in cells] + [
            row.friction.viscous.value(),
            row.friction.coulomb.value(),
        ]
    return found


def test_what_is_written_is_read_back() -> None:
    """Rows, bodies and friction, to the last digits, and links and joints by their names."""
    first = read(ARM)
    second = again(first)
    assert [(row.name, row.kind) for row in second.joints] == [(row.name, row.kind) for row in first.joints]
    for found, wanted in zip(rounded(second).values(), rounded(first).values(), strict=True):
        assert found == pytest.approx(wanted, rel=1e-13, abs=1e-15)
    assert {frame.name for frame in second.frames} == {frame.name for frame in first.frames}


def test_joints_that_follow_others_are_read_back() -> None:
    """Their frames are turned by their offsets; torques and links are those of the first file."""
    pytest.importorskip("pinocchio")
    from tests.references.compared_robots import ComparedRobot

    assert ComparedRobot(GRIPPER, again(read(GRIPPER))).errors().worst < 1e-12


@given(random_robots())
@settings(max_examples=25)
def test_random_robots_survive_urdf_and_toml(text: str) -> None:
    """The URDF of a table is that robot in Pinocchio, frames between nearly parallel axes included."""
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model
    from tests.references.compared_robots import OfTable
    from tests.references.urdf_in_pinocchio import Motion, Robot

    machine = toml.read(toml.write(read(text)), "robot.toml")
    written = Robot(write(machine))
    rng = np.random.default_rng(0)
    q, qd, qdd = rng.normal(size=(3, len(machine.independent)))
    names = [row.name for row in machine.independent_joints]
    motion = Motion(*(dict(zip(names, x, strict=True)) for x in (q, qd, qdd)))
    tau = pinocchio_model.inertia_matrix(machine, q) @ qdd + pinocchio_model.bias_forces(machine, q, qd)
    found = [written.torques(motion)[name] for name in names]
    assert found == pytest.approx(tau, rel=0, abs=1e-12 * max(1.0, np.abs(tau).max()))
    assert OfTable(text, machine).errors(states=1).worst < 1e-12
    again, first = {name: found for (_, name), found in written.frames(motion.q).items()}, Robot(text)
    order = [written.own.index(name) for name in first.own]
    for (_, name), (wanted, columns) in first.frames(motion.q).items():
        size = max(1.0, np.abs(wanted).max())
        assert again[name][0] == pytest.approx(wanted, rel=0, abs=1e-12 * size)
        assert again[name][1][:, order] == pytest.approx(columns, rel=0, abs=1e-12 * size)


def test_bodies_about_the_origin_are_written_about_the_centre_of_mass() -> None:
    from symoro_elastic.formats.central import about_origin

    machine = read(ARM)
    origin = replace(machine, joints=tuple(replace(row, body=about_origin(row.body)) for row in machine.joints))
    for found, wanted in zip(rounded(again(origin)).values(), rounded(again(machine)).values(), strict=True):
        assert found == pytest.approx(wanted, rel=1e-12, abs=1e-15)


def test_a_floating_base_floats_in_a_link_of_its_own() -> None:
    machine = toml.read(FLOATING, "m.toml")
    text = write(machine)
    assert '<joint name="base_joint" type="floating">' in text and '<link name="world" />' in text
    found = again(machine)
    assert found.floating and found.floating.body.mass.value() == 2.0


def test_links_of_the_base_have_names_that_are_free() -> None:
    text = robot(*map(link, ("ground", "world", "base")), joint("base", "ground", "world"), joint("j", "world", "base"))
    machine = read(text)
    assert [row.name for row in machine.joints] == ["base", "j"]
    assert '<link name="base_2" />' in write(replace(machine, frames=()))


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (SOFT, "joint 1 (a), kind: elastic: URDF has no springs: write .toml"),
        (RIGID.replace("motor", "passive"), "joint 1 (a), kind: passive: URDF cannot say which joint has no motor"),
        (RIGID + "[motors]\nb = { rotor_inertia = 1 }\n", "joint 2 (b), rotor_inertia: URDF has no rotors"),
        (RIGID + "[wrenches]\nb = { force = [0, 1, 0] }\n", "joint 2 (b), force y: URDF has no forces on bodies"),
        (
            RIGID + "[friction]\na = { coulomb = 1, creep = 0.1 }\n",
            "joint 1 (a), creep velocity: URDF has no creep velocities",
        ),
        (
            RIGID + '[base]\nfloating = "rotation"\nangular_damping = 2\n',
            "base, angular_damping: URDF has no damping of a floating base, write .toml, or leave it out",
        ),
        (RIGID + "[springs]\nb = { stiffness = 3 }\n", "joint 2 (b), stiffness: URDF has no springs: write .toml"),
        (RIGID + "[base]\nvelocity = [0, 1, 0]\n", "velocity y: URDF has no moving base"),
        (RIGID.replace("-9.81", "9.81"), "gravity: it is [0, 0, 9.81], but readers of URDF assume [0, 0, -9.81]"),
        (RIGID + "[bodies]\nb = { mass = 0, first_moments = [1, 0, 0] }\n", "joint 2 (b): first moments without mass"),
        (
            RIGID + "[bodies]\nb = { mass = 'M2', center_of_mass = [0, 0, 0] }\n[parameters]\nM2 = nan\n",
            "joint 2 (b): parameter M2 in mass has no value, and URDF holds numbers only",
        ),
        (
            FOLLOWING.replace("FORMULA", "q1*q1"),
            "joint 2 (b), theta: 'q1*q1': URDF has joints that follow one other in",
        ),
        (FOLLOWING.replace("FORMULA", "sin(q1)"), "joint 2 (b), theta: 'sin(q1)': URDF has joints that follow one"),
        (FOLLOWING.replace("FORMULA", "1/q1"), "joint 2 (b), theta: '1/q1': URDF has joints that follow one other in"),
        (
            RIGID.replace('"q2"', '"q2 + 3*q1", variable = "q2"'),
            "joint 2 (b), theta: '3*q1': URDF has joints that follow one other in proportion",
        ),
    ],
)
def test_what_urdf_cannot_say_is_refused_by_the_joint(text: str, why: str) -> None:
    with pytest.raises(InputError) as error:
        write(toml.read(text.replace("'M2'", '"M2"'), "m.toml"))
    assert str(error.value).startswith(f"m.toml: {why}")


def test_closed_loops_are_refused(tmp_path: Path) -> None:
    machine, _ = read_machine("examples/palletizer.toml")
    with pytest.raises(InputError, match=r"loop \w+: URDF has no closed loops"):
        write(machine)


@pytest.mark.parametrize(("formula", "factor", "offset"), [("(q1 - 0.5)/2", 0.5, -0.25), ("-3*q1 + N*2", -3.0, 1.5)])
def test_joints_follow_in_proportion(formula: str, factor: float, offset: float) -> None:
    machine = toml.read(FOLLOWING.replace("FORMULA", formula) + "[parameters]\nN = 0.75\n", "m.toml")
    text = write(machine)
    assert f'<mimic joint="a" multiplier="{factor}" offset="0" />' in text
    follower = describe(text, "m.urdf").joints[1]
    assert follower.placement.rotation == pytest.approx(about_z(offset, 0.0).rotation)


ANGLES = st.one_of(st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi, np.pi / 2 - 1e-9]), st.floats(-3.2, 3.2))


@given(ANGLES, ANGLES, ANGLES)
def test_roll_pitch_and_yaw_give_the_rotation_back(gamma: float, alpha: float, theta: float) -> None:
    """To rounding, where the pitch is a quarter turn too."""
    turn = (about_z(gamma, 0.0) * about_x(alpha, 0.0) * about_z(theta, 0.0)).rotation
    assert rotation(*rpy_of(turn)) == pytest.approx(turn, rel=0, abs=1e-14)
