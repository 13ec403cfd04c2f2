"""The table of a robot is the robot: torques and frames of all links are those of Pinocchio's reading of the URDF."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings

from symoro_elastic.formats.robots.modified_dh import machine_of, table_of
from symoro_elastic.formats.robots.robot import Connection, Description, JointType, Link, LinkJoint, Mimicked, Placement
from symoro_elastic.formats.robots.urdf import describe
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Closing, Kind, Machine
from symoro_elastic.machine.valid_names import with_valid_names
from tests.formats.robots.samples import ARM, GRIPPER, joint, link, random_robots, robot

pytest.importorskip("pinocchio")

from tests.references import pinocchio_model
from tests.references.compared_robots import ComparedRobot, OfTable

BOUND = 1e-12
KEYS = ("gamma", "b", "alpha", "d", "theta", "r")


def read(text: str) -> Machine:
    machine = with_valid_names(machine_of(describe(text, "robot.urdf"), "robot.urdf"))
    check(machine)
    return machine


def cells(machine: Machine) -> dict[str, tuple[str, ...]]:
    return {row.name: tuple(getattr(row, key).text for key in KEYS) for row in machine.joints}


@pytest.mark.parametrize("text", [ARM, GRIPPER], ids=["arm", "gripper"])
def test_generated_code_is_the_robot(text: str) -> None:
    assert ComparedRobot(text, read(text)).errors().worst < BOUND


@pytest.mark.thorough
@given(random_robots())
@settings(max_examples=60)
def test_tables_of_random_robots_are_the_robots(text: str) -> None:
    """Odd and quarter turns, parallel, nearly parallel and coaxial axes, slides, branches."""
    machine = read(text)
    assert OfTable(text, machine).errors(states=2).worst < BOUND
    lengths = [abs(getattr(row, key).value()) for row in machine.joints for key in ("b", "d", "r")]
    assert max(lengths) < 400.0, "a frame is far away"


@given(random_robots())
@settings(max_examples=20)
def test_snapped_tables_are_off_by_what_they_say(text: str) -> None:
    description = describe(text, "robot.urdf")
    table = table_of(description, "robot.urdf", 1e-9)
    errors = OfTable(text, table.machine).errors(states=1)
    reach = 4.0 * len(description.joints)
    assert errors.frames <= BOUND + reach * (table.deviation.rotation + table.deviation.translation)
    assert table.deviation.rotation < 1e-7 and table.deviation.translation < 1e-7


# The choice of frames

CHAIN = robot(
    '<link name="base"/>',
    *(link(name) for name in ("a", "b", "c")),
    joint("waist", "base", "a", xyz=(0, 0, 0.36)),
    joint("shoulder", "a", "b", xyz=(0, 0.1, 0.2), rpy=(-math.pi / 2, 0, 0)),
    joint("elbow", "b", "c", xyz=(0.42, 0, 0.05)),
    '<link name="hand"/>',
    joint("hand_joint", "c", "hand", "fixed", (0.2, 0, 0)),
)


def test_a_chain_has_the_table_of_the_textbook() -> None:
    """gamma and b are for branches; offsets along parallel axes come together at their end."""
    assert cells(read(CHAIN)) == {
        "waist": ("0", "0", "0", "0", "0", "0.56"),
        "shoulder": ("0", "0", "-pi/2", "0", "0", "0"),
        "elbow": ("0", "0", "0", "0.42", "0", "0"),
        "hand": ("0", "0", "0", "0.2", "0", "0.15"),
    }


def test_frames_of_leaves_are_kept_and_inner_links_are_merged() -> None:
    machine = read(ARM)
    assert [(row.name, row.kind) for row in machine.joints] == [
        *((name, Kind.MOTOR) for name in ("waist", "shoulder", "elbow", "slide")),
        *((name, Kind.FIXED) for name in ("cover", "tool")),
    ]
    masses = [row.body.mass.value() for row in machine.joints]
    assert masses == pytest.approx([8.5, 4.4, 2.5, 1.5, 0, 0])


def test_links_may_have_the_names_of_joints() -> None:
    """Leaves are told from joints of the same name, and get another one."""
    links = [link(name) for name in ("base", "one", "two", "first", "second")]
    joints = [
        joint("first", "base", "one"),
        joint("second", "one", "two", rpy=(0.3, 0.2, 0.1)),
        joint("fix one", "one", "first", "fixed", (0.1, 0.2, 0.3)),
        joint("fix two", "one", "second", "fixed", (0.3, 0.2, 0.1), (0.5, 0, 0)),
    ]
    text = robot(*links, *joints)
    machine = read(text)
    assert [(row.name, row.antecedent) for row in machine.joints] == [
        *(("first", 0), ("second", 1), ("first_2", 1), ("second_2", 1))
    ]
    assert OfTable(text, machine).errors().worst < BOUND


@pytest.mark.parametrize("tilt", [1e-3, 1e-6, 1e-9, 1e-12])
def test_nearly_parallel_axes_have_a_frame_between(tilt: float) -> None:
    """Their common normal is up to 1e12 m away: a frame moves there, the next one turns."""
    text = robot(*map(link, "abc"), joint("one", "a", "b"), joint("two", "b", "c", rpy=(tilt, 0, 0)))
    rows = cells(read(text))
    assert [*rows] == ["one", "two_seat", "two"]
    assert rows["two_seat"] == ("0", "0", "0", "0.3", "0", "0")
    assert float(rows["two"][2]) == pytest.approx(tilt, rel=1e-3) and rows["two"][1::2] == ("0", "0", "0")
    assert OfTable(text, read(text)).errors().worst < BOUND
    if tilt < 1e-9:
        snapped = table_of(describe(text, ""), "", 1e-9)
        assert cells(snapped.machine) == {
            "one": ("0",) * 6 and ("0", "0", "0", "0.3", "0", "0"),
            "two": rows["two_seat"],
        }
        assert snapped.deviation.rotation == pytest.approx(tilt, rel=1e-2)


def test_snapping_takes_simple_numbers_only() -> None:
    text = robot(
        *map(link, "abc"),
        joint("one", "a", "b", rpy=(1.57079632679, 0, 0.5235987756)),
        joint("two", "b", "c", xyz=(0.1234567890123, 1e-11, 0.2), rpy=(0, 0.5, 0)),
    )
    exact, snapped = (table_of(describe(text, ""), "", snap) for snap in (0.0, 1e-9))
    assert max(exact.deviation.rotation, exact.deviation.translation) < 1e-15
    assert 1e-12 < snapped.deviation.rotation < 1e-9
    assert (cells(snapped.machine)["one"][2], cells(exact.machine)["one"][2]) == ("pi/2", "1.57079632679")


def test_snapped_lengths_are_short_decimals_where_they_are_near_to_one() -> None:
    """0.25 but for 3e-12 is 0.25; 0.1234567890123 stays, though eight digits of it were within the tolerance."""
    text = robot(*map(link, "abc"), joint("one", "a", "b", xyz=(0.1234567890123, 0, 0)), joint("two", "b", "c"))
    text = text.replace('xyz="0.3 0.0 0.0"', 'xyz="0.250000000003 0.0 0.0"')
    assert [row[3] for row in cells(table_of(describe(text, ""), "", 1e-9).machine).values()] == [
        "0.1234567890123",
        "0.25",
    ]
    assert [row[3] for row in cells(read(text)).values()] == ["0.1234567890123", "0.250000000003"]


# Joints of all kinds

TWO = (Link("base"), Link("a", 1.0, np.array([0.1, 0, 0]), np.eye(3), False), Link("b", 2.0, np.zeros(3), np.eye(3)))
Z = np.array([0.0, 0.0, 1.0])


def described(*joints: LinkJoint, connections: tuple[Connection, ...] = ()) -> Machine:
    return machine_of(Description("two", TWO, joints, connections), "two")


def two(**second: object) -> tuple[LinkJoint, LinkJoint]:
    first = LinkJoint("first", JointType.REVOLUTE, "base", "a", Placement(), Z)
    place = Placement(translation=np.array([0.5, 0.0, 0.0]))
    return first, LinkJoint("second", JointType.REVOLUTE, "a", "b", place, Z, **second)  # type: ignore[arg-type]


def test_springs_passive_joints_and_rotors_are_rows_of_their_kind() -> None:
    _, spring = described(*two(stiffness=20.0, neutral=0.1, damping=0.3, friction=0.2, driven=False)).joints
    assert spring.kind is Kind.ELASTIC
    assert [x.text for x in (spring.spring.stiffness, spring.spring.neutral, spring.spring.damping)] == [
        "20",
        "0.1",
        "0.3",
    ]
    assert (spring.friction.viscous.text, spring.friction.coulomb.text) == ("0", "0.2")
    _, passive = described(*two(damping=0.3, driven=False)).joints
    assert (passive.kind, passive.friction.viscous.text) == (Kind.PASSIVE, "0.3")
    _, motor = described(*two(rotor_inertia=0.02)).joints
    assert (motor.kind, motor.rotor_inertia.text) == (Kind.MOTOR, "0.02")


def test_followers_are_coupled_rows_with_the_offsets_of_all() -> None:
    machine = read(GRIPPER)
    kinds = {row.name: row.kind for row in machine.joints}
    assert kinds["right_finger"] == kinds["thumb_joint"] == Kind.COUPLED
    variable = next(row.variable for row in machine.joints if row.name == "left_finger")
    right, thumb = (next(row for row in machine.joints if row.name == name) for name in ("right_finger", "thumb_joint"))
    assert right.r.names == thumb.theta.names == {variable}
    values = {str(variable): 0.2}
    start = {str(variable): 0.0}
    assert right.r.value(values) - right.r.value(start) == pytest.approx(0.1)
    assert thumb.theta.value(values) - thumb.theta.value(start) == pytest.approx(-3.0)
    assert "coupled rows, without a variable, and without limits: 'right_finger', 'thumb_joint'" in "\n".join(
        machine.origin.remarks
    )


@pytest.mark.parametrize(
    ("follows", "why"),
    [
        (Mimicked("third"), "it mimics 'third', which is not a joint"),
        (Mimicked("second"), "it mimics 'second', which mimics it"),
        (Mimicked("first", 0.0), "its multiplier is 0"),
    ],
)
def test_joints_that_cannot_follow_are_refused(follows: Mimicked, why: str) -> None:
    with pytest.raises(InputError, match=f"^two: joint 'second': {why}"):
        described(*two(follows=follows))


def test_a_cycle_of_joints_that_mimic_is_told_by_the_next_one() -> None:
    mass = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    links = "".join(f'<link name="{name}">{mass}</link>' for name in "abcd")
    joints = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<mimic joint="{other}"/></joint>'
        for name, parent, child, other in (("j", "a", "b", "k"), ("k", "b", "c", "OTHER"), ("l", "c", "d", "k"))
    )
    for other, said in (("j", "it mimics 'k', which mimics it"), ("l", "it mimics 'k', which follows itself")):
        with pytest.raises(InputError, match=f"joint 'j': {said}: break the cycle"):
            read(f'<robot name="r">{links}{joints.replace("OTHER", other)}</robot>')


def test_a_spring_beside_a_motor_is_on_the_row_of_the_motor() -> None:
    second = described(*two(stiffness=3.0, neutral=0.2, damping=0.5)).joint(2)
    assert second.kind is Kind.MOTOR and second.friction.viscous.value() == 0.5
    assert (second.spring.stiffness.value(), second.spring.neutral.value()) == (3.0, 0.2)


def test_a_spring_on_a_joint_that_follows_is_refused() -> None:
    with pytest.raises(InputError, match=r"joint 'second': it has a spring and follows another joint"):
        described(*two(stiffness=3.0, follows=Mimicked("first")))


def test_connections_are_loops() -> None:
    ends = Placement(translation=np.array([0.4, 0, 0])), Placement(translation=np.array([0.6, 0.3, 0]))
    machine = with_valid_names(
        described(*two(driven=False), connections=(Connection("pin joint", "b", "base", *ends),))
    )
    (loop,) = machine.loops
    assert loop.closes is Closing.POINT and loop.name == "loop_1"
    cut, meets = machine.joint(loop.cut), machine.joint(loop.meets)
    assert (cut.kind, machine.joint(cut.antecedent).name, cut.d.text) == (Kind.CUT, "second", "0.4")
    assert (meets.kind, meets.antecedent) == (Kind.FIXED, 0)
    assert math.hypot(0.6, 0.3) == pytest.approx(meets.d.value())


def test_a_floating_joint_makes_the_base_float() -> None:
    """Forces, accelerations and A of base and joints are those of Pinocchio's free-flyer."""
    text = robot(
        '<link name="world"/>',
        *(link(name) for name in ("hull", "arm", "fin")),
        joint("float", "world", "hull", "floating", xyz=(0, 0, 0)),
        joint("shoulder", "hull", "arm", xyz=(0.2, 0.1, 0), rpy=(0.5, 0.2, 0)),
        joint("hinge", "hull", "fin", xyz=(-0.3, 0, 0.1), axis=(1, 0, 0)),
    )
    machine = read(text)
    assert machine.floating and machine.floating.body.mass.value() == 1.0
    import pinocchio as pin

    model = pin.buildModelFromXML(text)
    data, rng = model.createData(), np.random.default_rng(3)
    q, qd, qdd = rng.normal(size=(3, 2))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    base = pinocchio_model.BaseState(turn, rng.normal(size=6), rng.normal(size=6))
    found, _, _ = pinocchio_model.floating_dynamics(machine, base, q, qd, qdd)
    position = np.concatenate([np.zeros(3), pin.Quaternion(turn).coeffs(), q])
    names = [str(name) for name in model.names][2:]
    order = [names.index(row.name) for row in machine.joints]
    wanted = pin.rnea(
        *(model, data, np.concatenate([position[:7], q[np.argsort(order)]])),
        np.concatenate([base.velocity, qd[np.argsort(order)]]),
        np.concatenate([base.spatial, qdd[np.argsort(order)]]),
    )
    assert found == pytest.approx(
        np.concatenate([wanted[:6], wanted[6:][order]]), rel=0, abs=1e-12 * np.abs(wanted).max()
    )
