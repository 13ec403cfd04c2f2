"""Limits in URDF and MJCF are those of the joint variables of the table: beside Pinocchio and MuJoCo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats.reading import read
from symoro_elastic.formats.robots.modified_dh import machine_of
from symoro_elastic.formats.robots.urdf import describe
from symoro_elastic.formats.robots.urdf_writing import write
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.limits import JointLimits, Range
from symoro_elastic.machine.valid_names import with_valid_names
from tests.formats.robots.samples import ARM, GRIPPER, joint, link, robot

NINE = Range(-9.0, 9.0)


def urdf(text: str) -> DescribedMachine:
    return with_valid_names(machine_of(describe(text, "robot.urdf"), "robot.urdf"))


def of_pinocchio(text: str) -> dict[str, tuple[float, ...]]:
    """Lower and upper position, largest velocity and effort of each joint with one coordinate, as Pinocchio reads."""
    pinocchio = pytest.importorskip("pinocchio")
    model = pinocchio.buildModelFromXML(text)
    found = {}
    for j in range(1, model.njoints):
        if model.nqs[j] == 1:
            q, v = model.idx_qs[j], model.idx_vs[j]
            ends = (model.lowerPositionLimit[q], model.upperPositionLimit[q])
            found[model.names[j]] = (*ends, model.velocityLimit[v], model.effortLimit[v])
    return found


def test_limits_of_urdf_are_pinocchios() -> None:
    limits = urdf(ARM).limits
    compared = of_pinocchio(ARM)
    assert compared
    for name, (low, high, velocity, effort) in compared.items():
        either_way = Range(-velocity, velocity), None, Range(-effort, effort)
        assert limits.of(name) == JointLimits(Range(low, high), *either_way)
    assert not limits.of("shoulder")


TURNED = robot(
    *map(link, "abcd"),
    joint("over", "a", "b", rpy=(np.pi, 0.3, 0), axis=(0, 0, -1)).replace('lower="-9"', 'lower="-0.5"'),
    joint("across", "b", "c", rpy=(0.2, -0.7, 1), axis=(0.6, 0, -0.8)).replace('upper="9"', 'upper="0.75"'),
    joint("along", "c", "d", "prismatic", rpy=(1, 0, 0), axis=(-1, 0, 0)).replace('lower="-9"', 'lower="0.1"'),
)


def test_positions_of_the_table_are_those_of_the_robot() -> None:
    """Axes against z, and frames that are turned: at the ends of the ranges the links are where Pinocchio has them."""
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model
    from tests.references.urdf_in_pinocchio import Robot

    machine, reference = urdf(TURNED), of_pinocchio(TURNED)
    assert {name: machine.limits.of(name).position for name in reference} == {
        name: Range(low, high) for name, (low, high, _, _) in reference.items()
    }
    names = [row.name for row in machine.independent_joints]
    first = None
    for end in ("low", "high"):
        q = {name: getattr(machine.limits.of(name).position, end) for name in names}
        at_zero = dict.fromkeys(names, 0.0)
        ours = [pinocchio_model.frames(machine, np.array([x[name] for name in names])) for x in (q, at_zero)]
        moved = ours[0][-1] @ np.linalg.inv(ours[1][-1])
        theirs = [Robot(TURNED).frames(x)["link", "d"][0] for x in (q, at_zero)]
        assert moved == pytest.approx(theirs[0] @ np.linalg.inv(theirs[1]), abs=1e-12)
        assert first is None or not np.allclose(first, moved)
        first = moved


def test_what_is_written_as_urdf_is_read_back_and_is_pinocchios() -> None:
    machine = urdf(ARM)
    again = write(machine)
    assert urdf(again).limits == machine.limits
    found, wanted = of_pinocchio(again), of_pinocchio(ARM)
    assert {name: found[name] for name in wanted} == wanted


HEAD = 'name = "m"\ngravity = [0, 0, -9.81]\njoints = [\n'
TWO = (
    f'{HEAD}{{ name = "a", kind = "motor", sigma = 0, theta = "q1 + 1" }},\n'
    '{ name = "b", kind = "motor", sigma = 1, r = "q2" }'
)
LIMITED = {
    "": {},
    "a = { velocity = 3, torque = 5 }": {"a": JointLimits(None, Range(-3, 3), None, Range(-5, 5))},
    "a = { position = [-1, 2] }": {"a": JointLimits(Range(-1, 2))},
    "b = { acceleration = 7, position = [0.1, 0.2] }": {"b": JointLimits(Range(0.1, 0.2), None, Range(-7, 7))},
}


@pytest.mark.parametrize(("line", "joints"), LIMITED.items())
def test_no_limit_is_invented_in_urdf(line: str, joints: dict[str, JointLimits]) -> None:
    """What URDF demands beside those of the machine stands for none when it is read."""
    assert urdf(write(toml.read(f"{TWO} ]\n[limits]\n{line}\n", "m.toml"))).limits.joints == joints


def test_what_urdf_cannot_say_of_limits_is_refused_by_the_joint() -> None:
    machine = toml.read(f"{TWO} ]\n[limits]\na = {{ torque = [-1, 2] }}\n", "m.toml")
    with pytest.raises(InputError, match=r"joint 1 \(a\), limits, torque: \[-1, 2\]: URDF has one number either way"):
        write(machine)


def limit(text: str, kind: str = "revolute") -> str:
    """A robot of one joint with this limit."""
    given = joint("j", "a", "b", kind).replace('<limit lower="-9" upper="9" effort="9" velocity="9"/>', text)
    return robot(link("a"), link("b"), given)


ODD = {
    "none": ("", JointLimits()),
    "rates only": ('<limit effort="9" velocity="9"/>', JointLimits(None, NINE, None, NINE)),
    "one end": ('<limit lower="-9"/>', JointLimits(Range(-9.0, 0.0))),
    "no room": ('<limit lower="0" upper="0" effort="0" velocity="0"/>', JointLimits()),
    "infinite": ('<limit lower="-inf" upper="inf" effort="inf" velocity="9"/>', JointLimits(None, NINE)),
    "far": ('<limit lower="-1e10" upper="3e38" effort="1e9" velocity="9"/>', JointLimits(None, NINE)),
    "acceleration": ('<limit acceleration="9"/>', JointLimits(None, None, NINE)),
    "negative": ('<limit effort="-9" velocity="9"/>', JointLimits(None, NINE)),
}


@pytest.mark.parametrize(("text", "wanted"), ODD.values(), ids=ODD)
def test_limits_of_urdf_that_stand_for_none_are_none(text: str, wanted: JointLimits) -> None:
    assert urdf(limit(text)).limits.of("j") == wanted


def test_a_continuous_joint_has_no_range() -> None:
    assert urdf(limit('<limit lower="-9" upper="9" effort="9" velocity="9"/>', "continuous")).limits.of(
        "j"
    ) == JointLimits(None, NINE, None, NINE)


def test_limits_of_urdf_that_are_wrong_are_said() -> None:
    machine = urdf(limit('<limit lower="2" upper="-2" effort="9" velocity="9"/>'))
    assert machine.limits.of("j") == JointLimits(None, NINE, None, NINE)
    assert "limits whose lower end is above the upper one are not taken: joint 'j'" in machine.origin.remarks
    with pytest.raises(InputError, match=r"joint 'j': <limit> effort: 'much' is not a number"):
        urdf(limit('<limit effort="much"/>'))


def test_joints_that_follow_others_have_none_and_names_follow() -> None:
    machine = urdf(GRIPPER)
    assert {*machine.limits.joints} <= {row.name for row in machine.independent_joints}
    assert urdf(robot(*map(link, "ab"), joint("1 j", "a", "b"))).limits.joints == {
        "x1_j": JointLimits(NINE, NINE, None, NINE)
    }


MJCF = """<mujoco><compiler angle="{angle}" autolimits="{auto}"/><worldbody>
<body><joint name="a" axis="0 0 -1" range="{low} {high}" ref="{ref}" {of_a}/><inertial pos="0 0 0.1" mass="1"
 diaginertia="1 1 1"/><body pos="1 0 0" euler="{turn} 0 0"><joint name="b" type="slide" axis="1 0 0"
 range="-0.2 0.3" {of_b}/><inertial pos="0 0 0.1" mass="1" diaginertia="1 1 1"/></body></body></worldbody>
<actuator>{motors}</actuator></mujoco>"""
IN_DEGREES = {"angle": "degree", "low": -90, "high": 45, "ref": 10, "turn": 30}
IN_RADIANS = {"angle": "radian", "low": -np.pi / 2, "high": np.pi / 4, "ref": 0.2, "turn": 0.5}
USUAL = {"auto": "true", "of_a": "", "of_b": "", "motors": '<motor joint="a"/>'}


def mjcf(folder: Path, **given: object) -> DescribedMachine:
    pytest.importorskip("mujoco")
    file = folder / "robot.xml"
    file.write_text(MJCF.format(**USUAL | IN_RADIANS | given), encoding="utf-8")
    return read(file)


@pytest.mark.parametrize("units", [IN_DEGREES, IN_RADIANS], ids=["degree", "radian"])
def test_ranges_of_mjcf_are_those_at_which_mujoco_has_its_stops(units: dict[str, object], tmp_path: Path) -> None:
    """MuJoCo's own constraint is active just beyond the ends, and not before; `ref` shifts nothing."""
    machine = mjcf(tmp_path, **units)
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    for k, name in enumerate("ab"):
        ends = machine.limits.of(name).position
        assert ends is not None
        assert name == "b" or (ends.low, ends.high) == pytest.approx((-np.pi / 2, np.pi / 4), rel=1e-15)
        for inside, outside in ((ends.low + 1e-9, ends.low - 1e-9), (ends.high - 1e-9, ends.high + 1e-9)):
            touched = []
            for x in (inside, outside):
                data = mujoco.MjData(model)
                data.qpos[:] = 0.0
                data.qpos[k] = x
                mujoco.mj_forward(model, data)
                touched.append(data.nefc)
            assert touched == [0, 1]


def test_joints_that_are_not_limited_have_no_range(tmp_path: Path) -> None:
    machine = mjcf(tmp_path, auto="false", of_a='limited="true"', of_b='limited="false"')
    assert machine.limits.of("a").position and not machine.limits.of("b").position


MOTORS = {
    "none": ('<motor joint="a"/>', None),
    "control": ('<motor joint="a" gear="3" ctrlrange="-2 5"/>', Range(-6, 15)),
    "reversed": ('<motor joint="a" gear="-3" ctrlrange="-2 5"/>', Range(-15, 6)),
    "force": ('<motor joint="a" gear="2" ctrlrange="-2 5" forcerange="-1 1"/>', Range(-2, 2)),
    "gain": ('<general joint="a" gainprm="10" ctrlrange="-2 5"/>', Range(-20, 50)),
    "servo": ('<position joint="a" kp="10" ctrlrange="-2 5" forcerange="-3 4"/>', Range(-3, 4)),
    "servo without": ('<position joint="a" kp="10" ctrlrange="-2 5"/>', None),
    "two": ('<motor joint="a" ctrlrange="-1 1"/><motor joint="a" gear="2" ctrlrange="-1 3"/>', Range(-3, 7)),
}


@pytest.mark.parametrize(("motors", "wanted"), MOTORS.values(), ids=MOTORS)
def test_torques_are_those_of_mujocos_actuators_at_their_largest_controls(
    motors: str, wanted: Range | None, tmp_path: Path
) -> None:
    """MuJoCo's `qfrc_actuator` at controls far beyond, which it clamps, is the end of the range."""
    assert mjcf(tmp_path, motors=motors).limits.of("a").torque == wanted
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    reached = []
    for way in (-1.0, 1.0):
        data = mujoco.MjData(model)
        data.ctrl[:] = way * 1e12 * np.sign(model.actuator_gear[:, 0])
        mujoco.mj_forward(model, data)
        reached.append(data.qfrc_actuator[0])
    if wanted is not None:
        assert reached == pytest.approx([wanted.low, wanted.high])


def test_what_a_joint_takes_of_its_actuators_limits_their_torque(tmp_path: Path) -> None:
    machine = mjcf(tmp_path, of_a='actuatorfrcrange="-4 7"', motors='<motor joint="a" gear="3" ctrlrange="-2 5"/>')
    assert machine.limits.of("a").torque == Range(-4, 7)
    assert mjcf(tmp_path, of_a='actuatorfrcrange="-4 7"').limits.of("a").torque == Range(-4, 7)
