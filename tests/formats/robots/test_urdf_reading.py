"""URDF that is not a robot, or that a model cannot hold: one line that names the place; what is left out is said."""

from __future__ import annotations

import random

import numpy as np
import pytest

from symoro_elastic.formats.robots.modified_dh import machine_of
from symoro_elastic.formats.robots.robot import JointType
from symoro_elastic.formats.robots.urdf import describe, rotation
from symoro_elastic.formats.robots.xml_text import MOST_DEPTH, MOST_ELEMENTS
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.valid_names import with_valid_names
from symoro_elastic.models.packaging import reserved_words
from tests.formats.robots.samples import ARM, GRIPPER, joint, link, robot

BOMB = """<!DOCTYPE robot [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>
<robot name="&b;"/>"""
OUTSIDE = '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="x"><link name="&x;"/></robot>'
A, B, C = map(link, "abc")
REFUSED = {
    "bomb": (BOMB, "line 1: a DOCTYPE"),
    "external entity": (OUTSIDE, "line 1: a DOCTYPE"),
    "unknown entity": ('<robot name="&x;"/>', "line 1, column 1: no XML: undefined entity"),
    "half": ("<robot><link", "line 1, column 8: no XML: unclosed token"),
    "empty": ("", "line 1, column 1: no XML: no element found"),
    "deep": ("<robot>" + "<a>" * MOST_DEPTH, f"line 1: elements are nested more than {MOST_DEPTH} deep"),
    "many": ("<robot>" + "<a/>" * MOST_ELEMENTS, f"line 1: more than {MOST_ELEMENTS} elements"),
    "no link": ("<robot/>", "robot: it has no link"),
    "MJCF": ("<mujoco/>", "element <mujoco>: MJCF: its suffix is .xml"),
    "SDF": ("<sdf/>", "element <sdf>: SDF, which is not read"),
    "HTML": ("<html/>", "element <html>: a URDF file begins with <robot>"),
    "macro": (robot('<xacro:arm parent="a"/>'), "element <xacro:arm>: xacro, not URDF: expand it first"),
    "property": (robot(A.replace("0.02", "${x}")), "element <origin>: xacro, not URDF: expand it first"),
    "nameless": (robot("<link/>"), "element <link>: a link has no name"),
    "link twice": (robot(A, A), "link 'a': the name is given twice"),
    "joint twice": (robot(A, B, C, joint("j", "a", "b"), joint("j", "b", "c")), "joint 'j': the name is given twice"),
    "no such link": (robot(A, B, joint("j", "a", "bb")), "joint 'j': its child 'bb' is not a link; did you mean"),
    "no child": (
        robot(A, '<joint name="j" type="fixed"><parent link="a"/></joint>'),
        "joint 'j': <joint> lacks <child>",
    ),
    "nameless child": (robot(A, B, joint("j", "a", "")), "joint 'j': <child> lacks link"),
    "two roots": (robot(A, B, C, joint("j", "a", "b")), "links: 'a', 'c' are not children of a joint"),
    "two parents": (
        robot(A, B, C, joint("i", "a", "b"), joint("j", "a", "c"), joint("k", "c", "b")),
        "joint 'k': its child 'b' is the child of joint 'i' too",
    ),
    "cycle": (
        robot(A, B, C, joint("j", "b", "c"), joint("k", "c", "b")),
        "joint 'k': the links 'b' to 'c' to 'b' are in a cycle: a robot is a tree",
    ),
    "on itself": (robot(A, B, joint("j", "b", "b")), "joint 'j': the links 'b' to 'b' are in a cycle"),
    "all in a cycle": (
        robot(A, B, joint("j", "a", "b"), joint("k", "b", "a")),
        "joint 'k': the links 'a' to 'b' to 'a' are in",
    ),
    "zero axis": (robot(A, B, joint("j", "a", "b", axis=(0, 0, 0))), "joint 'j': its axis is 0 0 0"),
    "axis nan": (
        robot(A, B, joint("j", "a", "b", axis=(0, float("nan"), 1))),
        "joint 'j': <axis> xyz: 'nan' is not finite",
    ),
    "two numbers": (
        robot(A, B, joint("j", "a", "b", axis=(0, 1))),
        "joint 'j': <axis> xyz = '0.0 1.0' must be 3 numbers",
    ),
    "place inf": (robot(A, B, joint("j", "a", "b", xyz=(0, 1e999, 1))), "joint 'j': <origin> xyz: 'inf' is not finite"),
    "word": (robot(A.replace('value="1.0"', 'value="one"')), "link 'a': <mass> value: 'one' is not a number"),
    "underscore": (robot(A.replace('value="1.0"', 'value="1_0"')), "link 'a': <mass> value: '1_0' is not a number"),
    "negative": (robot(A.replace('value="1.0"', 'value="-2"')), "link 'a': its mass is negative: -2"),
    "no mass": (robot(A.replace('<mass value="1.0"/>', "")), "link 'a': <inertial> lacks <mass>"),
    "no izz": (robot(A.replace("izz", "IZZ")), "link 'a': <inertia> lacks izz"),
    "ball": (
        robot(A, B, joint("j", "a", "b", "ball")),
        "joint 'j': 'ball' is not a type of joint: there are revolute,",
    ),
    "planar": (robot(A, B, joint("j", "a", "b", "planar")), "joint 'j': a planar joint: write it as two prismatic"),
    "floats on the way": (
        robot(A, B, C, joint("j", "a", "b"), joint("k", "b", "c", "floating")),
        "joint 'k': a floating joint is for the base",
    ),
    "floats beside": (
        robot(A, B, C, joint("j", "a", "b"), joint("k", "a", "c", "floating")),
        "joint 'k': a floating joint is for the base",
    ),
    "mimics none": (
        robot(A, B, joint("j", "a", "b", inside='<mimic joint="x"/>')),
        "joint 'j': it mimics 'x', which is no",
    ),
    "mimics nothing": (robot(A, B, joint("j", "a", "b", inside="<mimic/>")), "joint 'j': <mimic> lacks joint"),
    "mimics a fixed": (
        robot(A, B, C, joint("i", "a", "b", "fixed"), joint("j", "a", "c", inside='<mimic joint="i"/>')),
        "joint 'j': it mimics 'i', which has no variable of its own",
    ),
    "damping": (
        robot(A, B, joint("j", "a", "b", inside='<dynamics damping="-1"/>')),
        "joint 'j': its damping is negative: -1",
    ),
}


@pytest.mark.parametrize(("text", "why"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_robot_is_refused_by_its_place(text: str, why: str) -> None:
    with pytest.raises(InputError) as error:
        machine_of(describe(text, "robot.urdf"), "robot.urdf")
    assert str(error.value).startswith(f"robot.urdf: {why}") and "\n" not in str(error.value)


@pytest.mark.parametrize("type_", ["revolute", "fixed"])
def test_robots_that_are_too_large_are_refused_before_any_work(type_: str) -> None:
    links = "".join(f'<link name="{k}"/>' for k in range(1002))
    joints = "".join(
        f'<joint name="{k}" type="{type_}"><parent link="0"/><child link="{k + 1}"/></joint>' for k in range(1001)
    )
    with pytest.raises(InputError, match=r"^big\.urdf: robot: 1001 joints that move and leaves: at most 1000 can be"):
        machine_of(describe(robot(links, joints), "big.urdf"), "big.urdf")


@pytest.mark.thorough
def test_chains_of_fixed_links_may_be_long() -> None:
    links = "".join(f'<link name="{k}"/>' for k in range(1500)) + A
    joints = "".join(joint(str(k), str(k), str(k + 1), "fixed", (0.001, 0, 0)) for k in range(1499))
    machine = machine_of(describe(robot(links, joints, joint("turn", "1499", "a")), ""), "")
    assert [row.name for row in machine.joints] == ["turn"]
    assert machine.joints[0].d.value() == pytest.approx(1.499 + 0.3)


def test_empty_lines_may_come_first() -> None:
    assert describe("\n \n" + ARM, "robot.urdf").name == "arm"
    with pytest.raises(InputError, match=r"^robot.urdf: line 3, column 8: no XML: unclosed token"):
        describe("\n \n<robot><link", "robot.urdf")


def test_paths_of_shapes_may_be_those_of_xacro() -> None:
    text = ARM.replace("package://arm/", "$(find arm)/")
    assert text != ARM and describe(text, "robot.urdf").name == "arm"


def test_defaults_are_those_of_the_format() -> None:
    """Origin zero, axis x, no friction; a link without inertia is a frame; the axis gets the length 1."""
    text = robot(
        '<link name="a"/><link name="b"/><link name="c"/>',
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>',
        joint("k", "b", "c", "continuous", axis=(0, -3e-200, 4e-200)),
    )
    description = describe(text, "robot.urdf")
    first, second = description.joints
    assert first.axis.tolist() == [1, 0, 0] and not first.placement.translation.any()
    assert second.axis == pytest.approx([0, -0.6, 0.8]) and second.type is JointType.REVOLUTE
    assert all(link.frame_only for link in description.links)


def test_the_length_of_an_axis_may_leave_double_precision() -> None:
    text = robot(A, B, joint("j", "a", "b", axis=(1e200, 1e200, 0)))
    with np.errstate(all="raise"):
        description = describe(text, "robot.urdf")
    assert description.joints[0].axis == pytest.approx([np.sqrt(0.5), np.sqrt(0.5), 0])


def test_roll_pitch_and_yaw_are_about_fixed_axes() -> None:
    quarter = np.pi / 2
    assert rotation(quarter, 0, 0) @ [0, 1, 0] == pytest.approx([0, 0, 1])
    assert rotation(0, quarter, 0) @ [0, 0, 1] == pytest.approx([1, 0, 0])
    assert rotation(quarter, 0, quarter) @ [0, 1, 0] == pytest.approx([0, 0, 1])


def remarks(*elements: str) -> list[str]:
    text = robot(A, B, C, joint("one", "a", "b"), joint("two", "b", "c"), *elements)
    return list(machine_of(describe(text, "robot.urdf"), "robot.urdf").origin.remarks)


def transmission(name: str, inside: str) -> str:
    return f'<transmission name="t"><joint name="{name}"/><actuator name="m">{inside}</actuator></transmission>'


@pytest.mark.parametrize(
    ("elements", "said"),
    [
        ((), []),
        (("<material/>", '<gazebo reference="a"/>', "<transmission/>"), []),
        (("<loop_joint/>", "<frame/>"), ["unknown URDF elements are ignored: 'loop_joint', 'frame'"]),
        (
            ('<gazebo reference="two"><springStiffness>20</springStiffness></gazebo>',),
            ["springs for Gazebo are not read: joint 'two'; give them by convert --elastic JOINT=K"],
        ),
        (
            (transmission("one", "<mechanicalReduction>100</mechanicalReduction>"),),
            [
                "motor torques are those on the joints: mechanicalReduction is not applied, and no rotor inertia is "
                "known; give it in [motors] ('one')",
                "'two': no transmission, treated as actuated (set kind = \"passive\" if not)",
            ],
        ),
    ],
)
def test_what_the_model_does_not_hold_is_said(elements: tuple[str, ...], said: list[str]) -> None:
    assert remarks(*elements) == said


def test_what_is_left_out_of_a_robot_is_said_once() -> None:
    machine = machine_of(
        describe(ARM.replace("<visual>", "<visual/><collision>").replace("</visual>", "</collision>"), ""), ""
    )
    assert machine.origin.remarks == (
        "meshes, package:// and others, are not read: a model needs masses; view draws those it finds",
    )
    long = robot(A, '<link name="b"/>', joint("j", "a", "b", axis=(0, 0, 2)))
    assert machine_of(describe(long, ""), "").origin.remarks == (
        "axes that are not of length 1 give directions only: joint 'j'",
        "no link has a mass in the file",
    )
    one_of_two = robot(A, B, '<link name="c"/>', joint("i", "a", "b"), joint("j", "b", "c"))
    assert "no mass in the file and are massless: 'j'" in machine_of(describe(one_of_two, ""), "").origin.remarks[0]
    hull = robot(A, B, C, joint("i", "a", "b"), joint("j", "a", "c"))
    (held,) = machine_of(describe(hull, ""), "").origin.remarks
    assert held.startswith("link 'a' is held, its mass of 1 kg is at rest")


def test_frames_are_those_of_the_file_whatever_they_are_called() -> None:
    """Links and joints that move, that are fixed, that are leaves, that are called base; by Pinocchio's placements."""
    pytest.importorskip("pinocchio")
    from tests.references.compared_robots import ComparedRobot

    rng = np.random.default_rng(0)

    def placed(name: str, parent: str, child: str, type_: str = "fixed") -> str:
        xyz, rpy, axis = rng.uniform(-1, 1, (3, 3)).tolist()
        return joint(name, parent, child, type_, xyz, rpy, axis)

    text = robot(
        *(A, B, C, '<link name="i"/>', '<link name="base"/>', '<link name="m"/>'),
        *(placed("i", "a", "b", "revolute"), placed("j", "b", "c", "prismatic"), placed("k", "c", "i")),
        *(placed("l", "b", "base"), placed("m", "a", "m")),
    )
    compared = ComparedRobot(text, with_valid_names(machine_of(describe(text, "r.urdf"), "r.urdf"), reserved_words()))
    named = {"link i", "joint i", "link base", "j", "b", "c", "k", "l", "m", "a"}
    assert named <= {*compared.our_names} and len(compared.frame_of) == 11
    errors = compared.errors()
    assert max(errors.frames, errors.jacobians) < 1e-14


def test_rotors_of_drake_are_those_of_the_joint() -> None:
    inside = '<drake:rotor_inertia value="2e-4"/><drake:gear_ratio value="50"/>'
    both = transmission("one", inside) + transmission("two", "")
    text = robot(A, B, C, joint("one", "a", "b"), joint("two", "b", "c"), both)
    description = describe(text.replace("<robot ", '<robot xmlns:drake="https://drake.mit.edu" '), "")
    assert [joint.rotor_inertia for joint in description.joints] == pytest.approx([0.5, 0.0])
    with pytest.raises(InputError, match="joint 'one': its rotor inertia is negative"):
        describe(text.replace("2e-4", "-2e-4"), "")


# Damage

PIECES = (
    "",
    "0",
    "-1",
    "nan",
    "1e999",
    "<",
    "/>",
    '"',
    "&lt;",
    "<joint",
    "link",
    "parent",
    'type="fixed"',
    "mimic",
    "\x00",
    "ä",
)


def damaged(rng: random.Random) -> str:
    """A robot with up to three pieces taken out, put in, or taken from another place."""
    text = rng.choice((ARM, GRIPPER))
    for _ in range(rng.randint(1, 3)):
        start = rng.randrange(len(text))
        other = rng.randrange(len(text))
        piece = rng.choice((*PIECES, text[other : other + rng.randrange(60)]))
        text = text[:start] + piece + text[start + rng.choice((0, 1, 5, 40)) :]
    return text


def test_no_damage_raises_anything_else() -> None:
    """A damaged file is a robot, or refused in one line."""
    rng, refused = random.Random(7), 0
    for _ in range(400):
        text = damaged(rng)
        try:
            check(with_valid_names(machine_of(describe(text, "robot.urdf"), "robot.urdf"), reserved_words()))
        except InputError as error:
            assert str(error).startswith("robot.urdf: ") and "\n" not in str(error), text
            refused += 1
    assert 200 < refused < 400
