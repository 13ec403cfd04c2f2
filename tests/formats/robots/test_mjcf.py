"""Robots in MJCF have the positions, forces and accelerations that MuJoCo computes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.reading import read
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.formats.robots.mjcf_samples import GRIPPER, ROBOTS, SEVERAL, SPRINGS, SPRUNG_MOTORS, random_robot

pytest.importorskip("mujoco")

EXACT = 1e-12


def written(text: str, folder: Path) -> Path:
    file = folder / "robot.xml"
    file.write_text(text, encoding="utf-8")
    return file


def machine_of(text: str, folder: Path) -> Machine:
    return read(written(text, folder))


def worst(text: str, folder: Path, states: int = 3) -> float:
    from tests.references.mujoco_model import Compared

    found = Compared.of_file(written(text, folder)).errors(states)
    return max(found.forces, found.frames, found.accelerations)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_inverse_and_forward_dynamics_and_frames_are_mujocos(name: str, tmp_path: Path) -> None:
    assert worst(ROBOTS[name], tmp_path) < EXACT


@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", range(6))
def test_those_of_random_robots_too(seed: int, tmp_path: Path) -> None:
    assert worst(random_robot(seed), tmp_path) < EXACT


def kinds(machine: Machine) -> dict[str, str]:
    return {joint.name: joint.kind.value for joint in machine.joints}


def test_actuators_make_motors_springs_elastic_joints_and_neither_passive_ones(tmp_path: Path) -> None:
    machine = machine_of(SPRINGS, tmp_path)
    assert kinds(machine) == {"swing": "motor", "slide": "elastic", "bend": "elastic", "spin": "passive"}
    swing, slide, _, _ = machine.joints
    assert swing.rotor_inertia.value() == pytest.approx(0.3 + 9 * 0.01, abs=1e-15)
    assert swing.friction.viscous.value() == pytest.approx(0.7 + 9 * 0.2, abs=1e-15)
    assert swing.friction.coulomb.value() == 0.4
    spring = slide.spring
    assert (spring.stiffness.value(), spring.neutral.value(), spring.damping.value()) == (300, 0.02, 4)


def test_without_any_actuator_joints_are_driven(tmp_path: Path) -> None:
    machine = machine_of(SEVERAL, tmp_path)
    assert kinds(machine) == {
        **dict.fromkeys(("along", "across", "turn", "tilt", "body5_joint"), "motor"),
        "camera": "fixed",
    }
    assert machine.origin.remarks[0] == "the file has no actuators: joints without springs are taken as driven"


def test_a_spring_beside_a_motor_needs_no_row_and_counts_whole_turns(tmp_path: Path) -> None:
    machine = machine_of(SPRUNG_MOTORS, tmp_path)
    assert kinds(machine) == dict.fromkeys(("j1", "j2", "j3"), "motor")
    model = numpy_model(machine, ("inverse_dynamics",))
    q = np.array([[0.1, 0.2, 0.0], [0.1 + 4 * np.pi, 0.2 - 2 * np.pi, 0.0]])
    (near, far), _ = model.inverse_dynamics(q, np.zeros(3), np.zeros(3))
    assert far - near == pytest.approx([40 * 4 * np.pi, -40 * 2 * np.pi, 0], abs=1e-11)


BALL = """
<mujoco><option gravity="0.5 1 -9"/><worldbody>
  <body name="socket" pos="0.1 0 0"><joint name="ball" type="ball" pos="0 0.02 0.1"/>
    <inertial pos="0.1 0.2 -0.1" mass="2" fullinertia="0.05 0.07 0.06 0.004 -0.003 0.002"/>
    <body name="arm" pos="0 0.3 0"><joint name="elbow" axis="1 0 0"/>
      <inertial pos="0 0 0.2" mass="1" diaginertia="0.02 0.03 0.01"/></body></body>
</worldbody><actuator><motor joint="elbow"/></actuator></mujoco>
"""


@pytest.mark.parametrize("damping", ["", 'damping="0.4"'])
def test_a_ball_joint_is_three_turns(damping: str, tmp_path: Path) -> None:
    """Their torques are those of MuJoCo's moments, by the virtual work of each turn."""
    import mujoco

    text = BALL.replace('type="ball"', f'type="ball" {damping}')
    machine = machine_of(text, tmp_path)
    assert [joint.name for joint in machine.joints] == ["ball_x", "ball_y", "ball_z", "elbow"]
    generated = numpy_model(machine, ("inertia_matrix", "bias_forces"))
    q, qd, qdd = (np.array(x) for x in ([0.4, -0.7, 1.1, 0.3], [0.5, 1.5, -1.0, 2.0], [1.0, -2.0, 3.0, 0.5]))
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)

    (da, db, dc), (_, sb, sc), (_, cb, cc) = qd[:3], np.sin(q[:3]), np.cos(q[:3])
    S = np.array([[cb * cc, sc, 0], [-cb * sc, cc, 0], [sb, 0, 1]])  # angular velocity in axes of the body, by rates
    x = -(sb * db * cc + cb * sc * dc) * da + cc * dc * db
    y = (sb * db * sc - cb * cc * dc) * da - sc * dc * db
    S_rate = np.array([x, y, cb * db * da])
    turn = np.zeros(4), np.zeros(4)
    data.qpos[:4] = [1, 0, 0, 0]
    for axis, angle in zip(np.eye(3), q[:3], strict=True):
        mujoco.mju_axisAngle2Quat(turn[0], axis, angle)
        mujoco.mju_mulQuat(turn[1], data.qpos[:4].copy(), turn[0])
        data.qpos[:4] = turn[1]
    data.qpos[4], data.qvel[:], data.qacc[:] = q[3], [*(S @ qd[:3]), qd[3]], [*(S @ qdd[:3] + S_rate), qdd[3]]
    mujoco.mj_inverse(model, data)
    wanted = [*(S.T @ data.qfrc_inverse[:3]), data.qfrc_inverse[3]]
    found = generated.inertia_matrix(q) @ qdd + generated.bias_forces(q, qd)
    assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12)


def polynomial(text: str, folder: Path, law: np.polynomial.Polynomial, leader: int) -> None:
    """Compare the torque of a machine of two joints, one of which follows the other by a law, with MuJoCo's forces."""
    import mujoco

    machine = machine_of(text, folder)
    assert [joint.kind.value for joint in machine.joints] == (["motor", "coupled"], ["coupled", "motor"])[leader]
    generated, model = numpy_model(machine, ("inverse_dynamics",)), mujoco.MjModel.from_xml_path(machine.source)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    data, follower = mujoco.MjData(model), 1 - leader
    first, second = law.deriv(), law.deriv(2)
    for q, qd, qdd in ((0.2, 1.5, -2.0), (-0.7, -2.0, 4.0)):
        data.qpos[leader], data.qvel[leader], data.qacc[leader] = q, qd, qdd
        data.qpos[follower], data.qvel[follower] = law(q), first(q) * qd
        data.qacc[follower] = first(q) * qdd + second(q) * qd**2
        mujoco.mj_inverse(model, data)
        wanted = data.qfrc_inverse[leader] + first(q) * data.qfrc_inverse[follower]
        assert generated.inverse_dynamics([q], [qd], [qdd])[0] == pytest.approx([wanted], rel=1e-12)


FOLLOWING = """
<mujoco><worldbody><body><joint name="first" axis="0 1 0" ref="0.3" damping="0.2"/>
  <inertial pos="0.1 0 0" mass="2" diaginertia="0.1 0.2 0.2"/>
  <body pos="0.4 0 0"><joint name="second" type="{type}" axis="0 1 1" ref="-0.1" armature="0.05" damping="0.3"/>
    <inertial pos="0 0.1 0" mass="1" diaginertia="0.05 0.02 0.03"/></body></body></worldbody>
  <compiler angle="radian"/>
  <equality><joint joint1="{one}" joint2="{two}" polycoef="{coefficients}"/></equality>
  <actuator><motor joint="{driven}"/></actuator></mujoco>
"""


@pytest.mark.parametrize("kind", ["hinge", "slide"])
@pytest.mark.parametrize("coefficients", ["0.1 2 0 0 0", "0 -1 0 0 0", "0.05 0.5 0.3 -0.2 0.1", "0 0 0.4 0 0"])
def test_joints_follow_others_by_polynomials_of_the_distance_from_their_references(
    coefficients: str, kind: str, tmp_path: Path
) -> None:
    text = FOLLOWING.format(type=kind, one="second", two="first", coefficients=coefficients, driven="first")
    law = np.polynomial.Polynomial([float(x) for x in coefficients.split()])
    polynomial(text, tmp_path, law(np.polynomial.Polynomial([-0.3, 1])) - 0.1, 0)


def test_the_joint_with_the_motor_leads(tmp_path: Path) -> None:
    """The constraint makes the first joint follow the second, which has the motor: the law is turned round."""
    text = FOLLOWING.format(type="hinge", one="first", two="second", coefficients="0.1 2 0 0 0", driven="first")
    polynomial(text, tmp_path, np.polynomial.Polynomial([-0.1 - 0.4 / 2, 1 / 2]), 0)


def test_a_joint_that_is_held_is_fixed_where_it_is_held(tmp_path: Path) -> None:
    text = FOLLOWING.replace('joint2="{two}"', "")
    held = machine_of(text.format(type="hinge", one="second", coefficients="0.7 0 0 0 0", driven="first"), tmp_path)
    assert [joint.kind.value for joint in held.joints] == ["motor", "fixed"]
    tree = text.replace("<equality>", "<!-- ").replace("</equality>", "-->")
    free = machine_of(tree.format(type="hinge", one="second", coefficients="0", driven="first"), tmp_path)
    of_held, of_free = (numpy_model(one, ("inertia_matrix", "bias_forces")) for one in (held, free))
    q, whole = [0.4], [0.4, 0.7 - 0.1]
    assert of_held.inertia_matrix(q)[0, 0] == pytest.approx(of_free.inertia_matrix(whole)[0, 0], rel=1e-14)
    assert of_held.bias_forces(q, [1.0]) == pytest.approx(of_free.bias_forces(whole, [1.0, 0.0])[:1], rel=1e-13)


OURS = """
name = "four_bar"
gravity = [0, -9.81, 0]
joints = [
  { name = "crank",  antecedent = 0,        kind = "motor",   sigma = 0, theta = "q1" },
  { name = "rod",    antecedent = "crank",  kind = "passive", sigma = 0, d = 0.15, theta = "q2" },
  { name = "rocker", antecedent = 0,        kind = "passive", sigma = 0, d = 0.5, theta = "q3" },
  { name = "pin",    antecedent = "rod",    kind = "cut",     sigma = 0, d = 0.45, theta = "q4" },
  { name = "end",    antecedent = "rocker", kind = "fixed",   sigma = 2, d = 0.3 },
]
[loops]
bars = { cut = "pin", meets = "end", start = { q1 = 1.0, q2 = -0.6, q3 = 1.6 } }
[bodies]
crank  = { mass = 1, center_of_mass = [0.07, 0, 0], inertia = [0.001, 0.003, 0.003] }
rod    = { mass = 1, center_of_mass = [0.22, 0, 0], inertia = [0.001, 0.02, 0.02] }
rocker = { mass = 1, center_of_mass = [0.15, 0, 0], inertia = [0.001, 0.01, 0.01] }
"""
THEIRS = """
<mujoco model="four_bar">
  <compiler angle="radian"/>
  <option gravity="0 -9.81 0"/>
  <worldbody>
    <body name="crank_body" euler="0 0 {q1}">
      <joint name="crank" axis="0 0 1" ref="{q1}"/>
      <inertial pos="0.07 0 0" mass="1" diaginertia="0.001 0.003 0.003"/>
      <body name="rod_body" pos="0.15 0 0" euler="0 0 {q2}">
        <joint name="rod" axis="0 0 1" ref="{q2}"/>
        <inertial pos="0.22 0 0" mass="1" diaginertia="0.001 0.02 0.02"/>
        <site name="tip" pos="0.45 0 0"/>
      </body>
    </body>
    <body name="rocker_body" pos="0.5 0 0" euler="0 0 {q3}">
      <joint name="rocker" axis="0 0 1" ref="{q3}"/>
      <inertial pos="0.15 0 0" mass="1" diaginertia="0.001 0.01 0.01"/>
      <site name="end" pos="0.3 0 0"/>
    </body>
  </worldbody>
  <equality>{loop}</equality>
  <actuator><motor joint="crank"/></actuator>
</mujoco>
"""
LOOPS = (
    '<connect name="bars" body1="rod_body" body2="rocker_body" anchor="0.45 0 0"/>',
    '<connect name="bars" site1="end" site2="tip"/>',
)


@pytest.mark.parametrize("loop", LOOPS)
def test_a_four_bar_of_mjcf_is_ours(loop: str, tmp_path: Path) -> None:
    ours = numpy_model(toml.read(OURS, "ours.toml"), ("direct_dynamics", "inverse_dynamics", "dependent_coordinates"))
    q1, q2, q3 = map(float, ours.dependent_coordinates([1.0]))
    theirs = machine_of(THEIRS.format(q1=q1, q2=q2, q3=q3, loop=loop), tmp_path)
    assert kinds(theirs)["bars_cut"] == "cut"
    found = numpy_model(theirs, ("direct_dynamics", "inverse_dynamics", "dependent_coordinates"))
    q, qd = np.array([[0.4], [1.0], [2.5], [-1.7]]), np.array([[1.0], [-3.0], [0.5], [2.0]])
    for model, given in (("direct_dynamics", [[0.8]]), ("inverse_dynamics", [[-2.0]])):
        a, b = (np.concatenate(np.atleast_2d(*[getattr(x, model)(q, qd, given)])) for x in (found, ours))
        assert a == pytest.approx(b, rel=1e-12, abs=1e-12)
    assert found.dependent_coordinates(q) == pytest.approx(ours.dependent_coordinates(q), abs=1e-12)


def test_a_gripper_driven_by_a_tendon_is_mujocos(tmp_path: Path) -> None:
    """Its coordinates are those of the motor and of the springs; inertia and torques are MuJoCo's on them."""
    import mujoco
    import scipy.linalg

    machine = machine_of(GRIPPER, tmp_path)
    independent = {machine.joint(j).name: machine.joint(j).kind.value for j in machine.independent}
    assert independent == {"left_drive": "motor", "right_sprung": "elastic", "left_sprung": "elastic"}
    ours = numpy_model(machine, ("inertia_matrix", "inverse_dynamics", "dependent_coordinates"))
    model = mujoco.MjModel.from_xml_path(machine.source)
    data, q = mujoco.MjData(model), np.array([0.05, -0.1, 0.07])
    for j, x in zip(machine.with_variable, ours.dependent_coordinates(q), strict=True):
        data.qpos[model.joint(machine.joint(j).name).qposadr] = x
    data.qpos[model.joint("right_drive").qposadr] = data.qpos[model.joint("left_drive").qposadr]
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-14
    G = scipy.linalg.null_space(data.efc_J.reshape(-1, model.nv)[: data.ne])
    places = [int(model.joint(name).dofadr[0]) for name in independent]
    G = G @ np.linalg.inv(G[places])
    moved = np.zeros((3, model.nv))
    for of, motion in zip(moved, G.T, strict=True):
        mujoco.mj_mulM(model, data, of, np.ascontiguousarray(motion))
    wanted = moved @ G
    assert np.abs(ours.inertia_matrix(q) - wanted).max() < EXACT * wanted.max()
    motor = [kind == "motor" for kind in independent.values()]
    tau, qdd = ours.inverse_dynamics(q, np.zeros(3), [3.0])
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    data.qacc[:] = G @ qdd
    mujoco.mj_inverse(model, data)
    assert G.T @ data.qfrc_inverse == pytest.approx(np.where(motor, tau, 0), abs=EXACT * np.abs(wanted @ qdd).max())


HELD = """
<mujoco><worldbody>
  <body name="a" pos="0.1 0.2 0.3" euler="30 20 10"><joint name="u" pos="0.1 0 0.2" axis="1 2 3" ref="20"/>{mass}
    <body name="b" pos="0.3 0 0" euler="0 40 0"><joint name="v" pos="0 -0.1 0" axis="0 1 -1" ref="-5"/>{mass}
      <site name="p" pos="0.1 0.2 0" euler="10 0 70"/></body></body>
  <body name="c" pos="0.5 0 0" euler="0 0 -50"><joint name="w" pos="0.2 0 0" axis="1 0 0"/>{mass}
    <site name="q" pos="0 0.1 0.1" euler="0 30 0"/></body>
  <body name="post" pos="1 1 0"><body name="top" pos="0 0 1" euler="0 20 0"/></body>
</worldbody><equality>{equality}</equality></mujoco>
"""
CONNECTIONS = {
    "connected bodies": '<connect name="k" body1="b" body2="c" anchor="0.3 -0.1 0.2"/>',
    "connected to the world": '<connect name="k" body1="b" anchor="0.3 -0.1 0.2"/>',
    "connected to scenery": '<connect name="k" body1="b" body2="top" anchor="0.3 -0.1 0.2"/>',
    "welded bodies": '<weld name="k" body1="b" body2="c"/>',
    "welded to scenery": '<weld name="k" body1="top" body2="b"/>',
}


@pytest.mark.parametrize("name", CONNECTIONS)
def test_ends_of_loops_are_where_mujoco_holds_them(name: str, tmp_path: Path) -> None:
    """Each end moves with its body, and both meet as the file places the bodies."""
    import mujoco

    mass = '<inertial pos="0.1 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>'
    machine = machine_of(HELD.format(mass=mass, equality=CONNECTIONS[name]), tmp_path)
    open_ = replace(machine, loops=(), joints=tuple(map(_not_cut, machine.joints)))
    generated = numpy_model(open_, ("geometric_model",))
    model = mujoco.MjModel.from_xml_path(machine.source)
    data, ends = mujoco.MjData(model), (int(model.eq_obj1id[0]), int(model.eq_obj2id[0]))

    def poses(q: Any) -> list[Any]:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        found = np.tile(np.eye(4), (2, 1, 1))
        for T, body in zip(found, ends, strict=True):
            T[:3, :3], T[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
        return [*found]

    def rows(q: Any) -> tuple[Any, Any]:
        """The two ends, that of the first body first."""
        found = dict(zip(generated.FRAMES, generated.geometric_model(q), strict=True))
        return found["k_cut"], found["k_end"]

    reference, q = model.qpos0.copy(), np.array([0.3, -0.8, 1.2])
    first, second = (np.linalg.inv(T) @ row for T, row in zip(poses(reference), rows(reference), strict=True))
    moved = [T @ local for T, local in zip(poses(q), (first, second), strict=True)]
    meets = rows(reference)
    shown = slice(None) if "weld" in name else slice(3, 4)
    assert np.abs(meets[0] - meets[1])[:3, shown].max() < 1e-13
    assert max(np.abs(a - b).max() for a, b in zip(moved, rows(q), strict=True)) < 1e-13
    if "connected" in name:
        assert first[:3, 3] == pytest.approx([0.3, -0.1, 0.2], abs=1e-14)
    else:
        assert np.abs(second - np.eye(4)).max() < 1e-14 or np.abs(first - np.eye(4)).max() < 1e-14


def _not_cut(joint: Joint) -> Joint:
    return replace(joint, kind=Kind.FIXED) if joint.kind is Kind.CUT else joint
