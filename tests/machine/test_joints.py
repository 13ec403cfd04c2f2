"""What a machine tells about its joints: numbers, kinds, units, and the errors that name it."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.formats.toml.reading import read
from tests.machine.samples import TOML


def test_joints_are_counted_from_one_and_entries_of_q_from_zero() -> None:
    machine = read(TOML, "arm.toml")
    assert [machine.joint(j).name for j in (1, 2, 3)] == ["base_yaw", "lift", "tip"]
    assert (machine.independent, machine.motors, machine.elastic) == ((1, 2), (1,), (2,))
    assert [joint.name for joint in machine.independent_joints] == ["base_yaw", "lift"]
    assert [joint.name for joint in machine.motor_joints] == ["base_yaw"]
    assert (machine.motor_entries, machine.elastic_entries) == ((0,), (1,))


def test_entries_skip_fixed_frames() -> None:
    machine = read(TOML, "arm.toml")
    yaw, lift, tip = machine.joints
    turned = replace(machine, joints=(tip, yaw, lift))
    assert (turned.motors, turned.elastic) == ((2,), (3,))
    assert (turned.motor_entries, turned.elastic_entries) == ((0,), (1,))


def test_units_follow_the_kind_of_joint() -> None:
    yaw, lift, _ = read(TOML, "arm.toml").joints
    assert (yaw.unit, yaw.force_unit) == ("rad", "N m")
    assert (lift.unit, lift.force_unit) == ("m", "N")


def test_an_error_names_the_file_or_else_the_machine() -> None:
    machine = read(TOML, "arm.toml")
    assert str(machine.error("joints", "too few")) == "arm.toml: joints: too few"
    assert str(replace(machine, source="").error("joints", "too few")) == "arm: joints: too few"
