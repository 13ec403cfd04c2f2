"""What is not a robot in an MJCF file is refused in one line that names the place, and nothing outside is read."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from symoro_elastic.formats.reading import read
from symoro_elastic.foundation import packages
from symoro_elastic.foundation.errors import InputError
from tests.command_line import run

pytest.importorskip("mujoco")

MASS = '<inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/>'


def robot(joint: str = '<joint name="j"/>', more: str = "", shapes: str = MASS, before: str = "") -> str:
    return f'<mujoco>{before}<worldbody><body name="link">{joint}{shapes}</body></worldbody>{more}</mujoco>'


BOMB = '<!DOCTYPE m [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>' + robot('<joint name="&b;"/>')
OUTSIDE = '<!DOCTYPE m [<!ENTITY a SYSTEM "file:///etc/passwd">]>' + robot('<joint name="&a;"/>')
ACTUATED = '<actuator><motor joint="j" damping="1 2"/></actuator>'
LARGE = "the model would hold more than 1e\\+07 numbers"
BAD = {
    "entities": (BOMB, "line 1: a DOCTYPE"),
    "external entities": (OUTSIDE, "line 1: a DOCTYPE"),
    "cut off": (robot()[:40], "line 1, column .*: no XML"),
    "too deep": ("<mujoco>" + "<body>" * 600 + "</body>" * 600 + "</mujoco>", "nested more than 400 deep"),
    "a URDF": ('<robot name="r"/>', "this is a URDF: give it the suffix .urdf"),
    "an SDF": ("<sdf/>", "SDF is not read"),
    "a part": ("<mujocoinclude/>", "it is a part of a model: read the file that includes it"),
    "another root": ("<html/>", "its root element is <html>"),
    "an unknown element": (robot("<jnt/>"), r"line 1: MuJoCo does not read it: .*'jnt'"),
    "an unknown keyword": (robot('<joint type="screw"/>'), "invalid keyword: 'screw'"),
    "a zero axis": (robot('<joint axis="0 0 0"/>'), "MuJoCo does not read it: .*axis"),
    "no number": (robot('<joint axis="0 x 0"/>'), "MuJoCo does not read it"),
    "not finite": (robot('<joint name="j" axis="0 nan 1"/>'), "joint 'j': axis holds a number that is not finite"),
    "an infinite length": (
        robot(shapes=MASS.replace("0.1", "inf", 1)),
        "body 'link': pos of <inertial> holds a number",
    ),
    "an infinite gravity": (robot(before='<option gravity="0 0 -inf"/>'), "option: gravity holds a number"),
    "no mass": (robot(shapes=""), "mass and inertia of moving bodies must be larger"),
    "nothing moves": (robot(""), "bodies: no joint: nothing moves"),
    "two that float": (
        "<mujoco><worldbody>"
        + f'<body name="a"><freejoint/>{MASS}</body><body name="b"><freejoint/>{MASS}</body>'
        + "</worldbody></mujoco>",
        "bodies: 'a', 'b' float independently: leave one machine in the file",
    ),
    "a stiffness that is a polynomial": (robot('<joint name="j" stiffness="1 2"/>'), "joint 'j': its stiffness is a"),
    "a damping that is one": (robot('<joint name="j" damping="1 2"/>'), "joint 'j': its damping is a polynomial"),
    "that of an actuator": (robot(more=ACTUATED), "joint 'j': its damping is a polynomial"),
    "a spring that yields": (robot('<joint name="j" stiffness="1" springyield="3"/>'), "joint 'j': its spring yields"),
    "a spring on a ball joint": (
        robot('<joint name="j" type="ball" stiffness="2"/>'),
        "joint 'j': it is a ball joint with stiffness, which is not modelled: write stiffness = 0",
    ),
    "armature of a free one": (
        robot('<joint name="j" type="free" armature="2"/><joint name="k"/>').replace('<joint name="k"/>', ""),
        "it is a free joint with armature",
    ),
    "cloth": (robot(more="", before='<worldbody><flexcomp name="c" type="grid"/></worldbody>'), "<flexcomp>: it makes"),
    "a rope": (robot('<composite type="cable"/>'), "<composite>: it makes deformable bodies"),
    "a plugin": (
        robot(before='<extension><plugin plugin="mujoco.elasticity.cable"/></extension>'),
        "<plugin>: forces of plugins are not modelled",
    ),
    "another model": (robot(before='<asset><model file="b.xml"/></asset>'), "model 'b.xml': it attaches another model"),
    "too many copies": (
        robot(
            f'<joint name="j"/><replicate count="99"><replicate count="99"><body>{MASS}</body></replicate></replicate>'
        ),
        "replicate: it makes more than 1000 copies",
    ),
    "a huge number of copies": (robot('<replicate count="99999999999999999999"/>'), "more than 1000 copies"),
    "no file": (robot(before="<include/>"), "include: it names no file"),
    "a missing part": (robot(before='<include file="b.xml"/>'), "include 'b.xml': no such file"),
    "a part above": (robot(before='<include file="../b.xml"/>'), "include '../b.xml': it is outside the folder"),
    "an absolute part": (
        robot(before='<include file="/etc/passwd"/>'),
        "include '/etc/passwd': it is outside the fold",
    ),
    "a path that is none": (robot(before='<include file="b&#10;.xml"/>'), r"include 'b\\n.xml': no such file"),
    "a missing mesh": (
        robot(shapes='<geom type="mesh" mesh="m"/>', before='<asset><mesh name="m" file="m.stl"/></asset>'),
        "mesh 'm.stl': no such file; body 'link' has no <inertial>",
    ),
    "a mesh outside": (
        robot(shapes='<geom type="mesh" mesh="m"/>', before='<asset><mesh name="m" file="../m.stl"/></asset>'),
        "mesh '../m.stl': it is outside the folder of the model, where nothing is read: body 'link' has no",
    ),
    "a spring on a follower": (
        robot(
            f'<joint name="j"/><body><joint name="k" stiffness="3"/>{MASS}</body>',
            '<equality><joint joint1="k" joint2="j"/></equality><actuator><motor joint="j"/></actuator>',
        ),
        "joint 'k': it has a spring and follows another joint: move the spring to that joint",
    ),
    "two positions": (
        robot(
            f'<joint name="j"/><body><joint name="k"/>{MASS}</body>',
            '<equality><joint joint1="k" joint2="j"/><joint joint1="k"/></equality>',
        ),
        "joint 'k': equality constraints 'joint2' and others determine its position: keep one",
    ),
    "a field of heights": (
        robot(before='<asset><hfield name="h" size="1 1 1 1" nrow="9999" ncol="9999"/></asset>'),
        LARGE,
    ),
    "a picture": (robot(before='<asset><texture name="t" type="2d" width="9999" height="9999"/></asset>'), LARGE),
    "a number of joints' numbers": (robot(before='<size nuser_jnt="100000000"/>'), f"<size> nuser_jnt: {LARGE}"),
    "numbers in other words": (robot(before='<size nuserdata="0x7fffffff"/>'), LARGE),
    "numbers of many elements": (robot(before='<size nuser_body="99999"/>', more="<sensor/>" * 200), LARGE),
    "keys": (robot(before='<size nkey="1e8"/>'), LARGE),
    "a mesh of many parts": (
        robot(before='<asset><mesh name="m" builtin="plate" params="3000 3000"/></asset>'),
        "<mesh>: params divide it into more than 100 parts",
    ),
    "copies of many elements": (
        robot(f'<joint name="j"/><replicate count="1000"><body>{MASS * 30}</body></replicate>'),
        "replicate: copies make more than 20000 elements",
    ),
    "a name that is too long": (robot(before=f'<include file="{"a" * 5000}"/>'), "no such file next to"),
    "a floating robot that is held": (
        '<mujoco><worldbody><body name="a"><freejoint/>'
        f'{MASS}<body name="b"><joint/>{MASS}</body></body></worldbody>'
        '<equality><connect name="rope" body1="b" anchor="0 0 0"/></equality></mujoco>',
        "connection 'rope': 'world' is not a link that the robot moves",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_no_robot_is_refused_in_one_line(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, said = BAD[name]
    folder = tmp_path / "models"
    folder.mkdir()
    (tmp_path / "b.xml").write_text("<mujocoinclude/>", encoding="utf-8")
    (tmp_path / "m.stl").write_bytes(b"")
    file = folder / "robot.xml"
    file.write_text(text, encoding="utf-8")
    monkeypatch.chdir(folder)
    with pytest.raises(InputError, match=said) as error:
        read(file)
    assert str(error.value).startswith(f"{file}: ") and "\n" not in str(error.value)
    assert [path.name for path in folder.iterdir()] == ["robot.xml"]


def test_a_link_to_a_file_outside_is_not_followed(tmp_path: Path) -> None:
    folder = tmp_path / "models"
    folder.mkdir()
    (tmp_path / "secret.xml").write_text("<mujocoinclude/>", encoding="utf-8")
    (folder / "part.xml").symlink_to(tmp_path / "secret.xml")
    (folder / "robot.xml").write_text(robot(before='<include file="part.xml"/>'), encoding="utf-8")
    with pytest.raises(InputError, match=r"include 'part\.xml': it is outside the folder of the model"):
        read(folder / "robot.xml")


def test_parts_are_read_from_folders_inside_and_refused_like_the_file(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    inner = tmp_path / "parts" / "inner.xml"
    (tmp_path / "parts" / "outer.xml").write_text('<x><include file="inner.xml"/></x>', encoding="utf-8")
    inner.write_text(f'<x><worldbody><body name="b"><joint name="k"/>{MASS}</body></worldbody></x>', encoding="utf-8")
    file = tmp_path / "robot.xml"
    file.write_text('<mujoco><include file="parts/outer.xml"/></mujoco>', encoding="utf-8")
    assert [joint.name for joint in read(file).joints] == ["k"]
    inner.write_text("<!DOCTYPE x><x/>", encoding="utf-8")
    with pytest.raises(InputError, match=r"inner.xml: line 1: a DOCTYPE"):
        read(file)
    inner.write_text('<x><include file="outer.xml"/></x>', encoding="utf-8")
    with pytest.raises(InputError, match="is included once"):
        read(file)


TETRAHEDRON = ((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def stl() -> bytes:
    triangles = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in TETRAHEDRON[corner]), 0) for face in FACES
    )
    return bytes(80) + struct.pack("<I", len(FACES)) + triangles


def test_files_of_shapes_are_read_only_where_they_give_the_inertia(tmp_path: Path) -> None:
    assets = (
        '<compiler meshdir="shapes"/><asset><mesh name="seen" file="../seen.stl"/><mesh file="solid.stl"/>'
        '<texture name="t" type="2d" file="../../t.png"/><material name="m" texture="t"/></asset>'
    )
    shapes = f'{MASS}<geom type="mesh" mesh="seen" material="m"/><body name="solid"><joint name="k"/>'
    text = robot(shapes=f'{shapes}<geom type="mesh" mesh="solid" material="m"/></body>', before=assets)
    (tmp_path / "shapes").mkdir()
    (tmp_path / "shapes" / "solid.stl").write_bytes(stl())
    (tmp_path / "robot.xml").write_text(text, encoding="utf-8")
    solid = read(tmp_path / "robot.xml").joint(2)
    assert solid.body.mass.value() == pytest.approx(1000 * 0.1**3 / 6, rel=1e-6)


def test_what_is_missing_without_the_package_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(packages, "import_module", fails)
    (tmp_path / "robot.xml").write_text(robot(), encoding="utf-8")
    with pytest.raises(InputError, match=r"reading MJCF needs mujoco: pip install 'symoro-elastic\[mjcf\]'"):
        read(tmp_path / "robot.xml")


def test_an_old_package_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import mujoco

    monkeypatch.setattr(mujoco, "__version__", "3.9.1")
    (tmp_path / "robot.xml").write_text(robot(), encoding="utf-8")
    with pytest.raises(InputError, match=r"mujoco: version 3\.9\.1 is installed, reading MJCF needs 4"):
        read(tmp_path / "robot.xml")


LEFT_OUT = """
<mujoco><option density="1000"/><worldbody>
  <body name="arm"><joint name="j" range="-1 1"/><geom size="0.1"/><site name="s"/>
    <body name="end" pos="0 0 1" gravcomp="1"><joint name="k" type="ball"/><geom size="0.1"/></body></body>
  <body name="box" pos="3 0 0"><freejoint/><geom size="0.1"/></body>
  <body name="hand" mocap="true"/>
</worldbody>
<tendon><fixed name="string" stiffness="2"><joint joint="j" coef="1"/></fixed></tendon>
<equality><weld name="drag" body1="hand" body2="end"/><connect name="off" body1="arm" anchor="0 0 0" active="false"/>
  <tendon name="taut" tendon1="string"/></equality>
<actuator><position name="servo" joint="j" kp="3"/><motor name="pull" site="s" gear="1 0 0 0 0 0"/></actuator></mujoco>
"""


def test_what_is_not_taken_is_said_once(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(LEFT_OUT, encoding="utf-8")
    assert [*read(tmp_path / "robot.xml").origin.remarks] == [
        "free bodies besides the robot are ignored: 'box'",
        "ball joints are turns about x, y and z, singular where the second is at a right angle: 'k'",
        "torques act on the joints: gears and control laws of actuators are ignored",
        "actuators that act on no joint are ignored: 'pull'",
        "equality constraints that are ignored: 'drag', 'off', 'taut'",
        "not modelled: contacts, stops at the limits of joints, forces of tendons ('string'), forces of the fluid "
        "around it, forces that compensate gravity (gravcomp)",
    ]


def test_convert_writes_the_table_and_says_what_is_left_out(tmp_path: Path) -> None:
    source, target = tmp_path / "robot.xml", tmp_path / "robot.toml"
    source.write_text(LEFT_OUT, encoding="utf-8")
    result = run("convert", source, target)
    assert "warning: free bodies besides the robot are ignored: 'box'" in result.stderr
    assert read(target).joints == read(source).joints
