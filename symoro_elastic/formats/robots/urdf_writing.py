"""A machine as URDF: its frames as links, modified Denavit-Hartenberg parameters as origins.

URDF has numbers only, no springs, no rotors, no loops, and no gravity: readers take 9.81 m/s2 against z. What it lacks
is refused by the joint. Limits that it demands and the machine does not have are too far to be reached.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from symoro_elastic.formats.robots.displacements import ROUNDING, about_z
from symoro_elastic.formats.robots.numbered import SMOOTH, Holds, notes_of, numbers_text, robot_of
from symoro_elastic.formats.robots.robot import JointType, Link, LinkJoint
from symoro_elastic.formats.robots.urdf import EITHER_WAY, FAR
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Machine

GRAVITY = (0.0, 0.0, -9.81)
URDF = Holds(
    "URDF",
    lacks={"springs": "springs", "motors": "rotors", "wrenches": "forces on bodies", **SMOOTH, "loops": "closed loops"},
    degree=1,
    following="joints that follow one other in proportion",
)


def write(machine: Machine) -> str:
    """The URDF text of a machine; raises `InputError` that names the joint, the cell or the parameter."""
    described = robot_of(machine, URDF)
    if described.gravity != GRAVITY:
        shown = ", ".join(f"{x:g}" for x in described.gravity)
        what = f"it is [{shown}], but readers of URDF take [0, 0, -9.81]: turn frame 0, and give this gravity"
        raise machine.error("gravity", what)
    robot = Element("robot", name=described.name)
    robot.extend(map(Comment, notes_of(described)))
    joints = {joint.child: joint for joint in described.joints}
    for link in described.links:
        _add_link(robot, link)
        if link.name in joints:
            _add_joint(robot, joints[link.name], machine)
    indent(robot)
    return '<?xml version="1.0"?>\n' + tostring(robot, encoding="unicode") + "\n"


def _add_link(robot: Element, given: Link) -> None:
    link = SubElement(robot, "link", name=given.name)
    if given.frame_only:
        return
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=numbers_text(given.center), rpy="0 0 0")
    SubElement(inertial, "mass", value=numbers_text([given.mass]))
    entries = {f"i{'xyz'[i]}{'xyz'[k]}": numbers_text([given.inertia[i, k]]) for i in range(3) for k in range(i, 3)}
    SubElement(inertial, "inertia", entries)


def _add_joint(robot: Element, given: LinkJoint, machine: Machine) -> None:
    is_endless = given.type is JointType.REVOLUTE and not given.limits.position
    joint = SubElement(robot, "joint", name=given.name, type="continuous" if is_endless else given.type.value)
    if given.type is not JointType.FLOATING:
        origin = given.placement
        SubElement(joint, "origin", xyz=numbers_text(origin.translation), rpy=numbers_text(rpy_of(origin.rotation)))
    SubElement(joint, "parent", link=given.parent)
    SubElement(joint, "child", link=given.child)
    if given.type in (JointType.FIXED, JointType.FLOATING):
        return
    SubElement(joint, "axis", xyz="0 0 1")
    if given.type is JointType.PRISMATIC or given.limits:
        SubElement(joint, "limit", _limit(given, machine, is_endless))
    if given.damping or given.friction:
        friction = {"damping": numbers_text([given.damping]), "friction": numbers_text([given.friction])}
        SubElement(joint, "dynamics", friction)
    if given.follows:
        multiplier = numbers_text([given.follows.multiplier])
        SubElement(joint, "mimic", joint=given.follows.joint, multiplier=multiplier, offset="0")


def _limit(joint: LinkJoint, machine: Machine, is_endless: bool) -> dict[str, str]:
    """The attributes of a limit: those that URDF demands, and what else there is."""
    found = {"lower": -FAR, "upper": FAR, "effort": FAR, "velocity": FAR}
    if is_endless:
        del found["lower"], found["upper"]
    if joint.limits.position:
        found |= {"lower": joint.limits.position.low, "upper": joint.limits.position.high}
    for key, quantity in EITHER_WAY.items():
        given = getattr(joint.limits, quantity)
        if given is None:
            continue
        if not given.is_symmetric:
            place = next(place_of(j, row) for j, row in enumerate(machine.joints, start=1) if row.name == joint.name)
            what = f"[{given.low:g}, {given.high:g}]: URDF has one number either way: give one, or write .toml"
            raise machine.error(f"{place}, limits, {quantity}", what)
        found[key] = given.high
    return {key: numbers_text([x]) for key, x in found.items()}


def rpy_of(rotation: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw, rad, of a rotation (3, 3): Rot(z, yaw) Rot(y, pitch) Rot(x, roll).

    Roll is that of what is left after yaw and pitch, so the three are right together where the pitch is a quarter turn.
    """
    (xx, _, _), (yx, _, _), (zx, _, _) = rotation
    level = math.hypot(xx, yx)
    yaw = math.atan2(yx, xx) if level > ROUNDING else 0.0
    pitch = math.atan2(-zx, level)
    left = about_z(-yaw, 0.0).rotation @ rotation
    return math.atan2(-left[1, 2], left[1, 1]), pitch, yaw
