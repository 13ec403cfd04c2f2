"""A machine as URDF: its frames as links, modified Denavit-Hartenberg parameters as origins.

URDF has numbers only, no springs, no rotors, no loops, and no gravity: readers use 9.81 m/s2 against z. What it lacks
is refused by the joint. Limits that it demands and the machine does not have are too far to be reached.
"""

from __future__ import annotations

from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from symoro_elastic.formats.robots.joint_tree import rpy_of
from symoro_elastic.formats.robots.numbered import (
    SMOOTH,
    Holds,
    notes_of,
    numbers_text,
    plain,
    robot_of,
    with_frames_as_links,
)
from symoro_elastic.formats.robots.robot import JointType, Link, LinkJoint
from symoro_elastic.formats.robots.urdf import EITHER_WAY, FAR
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Machine

GRAVITY = (0.0, 0.0, -9.81)
URDF = Holds(
    "URDF",
    lacks={
        **{"springs": "springs", "motors": "rotors", "wrenches": "forces on bodies", **SMOOTH, "loops": "closed loops"},
        "ball": "damping of ball joints",
        "base": "damping of a floating base",
    },
    degree=1,
    following="joints that follow one other in proportion",
)


def write(machine: Machine) -> str:
    """Return the URDF text of a machine; raises `InputError` that names the joint, the cell or the parameter."""
    described = with_frames_as_links(robot_of(machine, URDF))
    if described.gravity != GRAVITY:
        listed = ", ".join(f"{x:g}" for x in described.gravity)
        what = f"it is [{listed}], but readers of URDF assume [0, 0, -9.81]: turn frame 0, and give this gravity"
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


def _add_link(robot: Element, link: Link) -> None:
    element = SubElement(robot, "link", name=link.name)
    if link.frame_only:
        return
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=numbers_text(link.center), rpy="0 0 0")
    SubElement(inertial, "mass", value=numbers_text([link.mass]))
    entries = {f"i{'xyz'[i]}{'xyz'[k]}": numbers_text([link.inertia[i, k]]) for i in range(3) for k in range(i, 3)}
    SubElement(inertial, "inertia", entries)


def _add_joint(robot: Element, joint: LinkJoint, machine: Machine) -> None:
    is_endless = joint.type is JointType.REVOLUTE and not joint.limits.position
    element = SubElement(robot, "joint", name=joint.name, type="continuous" if is_endless else joint.type.value)
    if joint.type is not JointType.FLOATING:
        origin = joint.placement
        SubElement(element, "origin", xyz=numbers_text(origin.translation), rpy=numbers_text(rpy_of(origin.rotation)))
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    if joint.type in (JointType.FIXED, JointType.FLOATING):
        return
    SubElement(element, "axis", xyz=numbers_text(plain(joint.axis)))
    if joint.type is JointType.PRISMATIC or joint.limits:
        SubElement(element, "limit", _limit(joint, machine, is_endless))
    if joint.damping or joint.friction:
        friction = {"damping": numbers_text([joint.damping]), "friction": numbers_text([joint.friction])}
        SubElement(element, "dynamics", friction)
    if joint.follows:
        multiplier = numbers_text([joint.follows.multiplier])
        SubElement(element, "mimic", joint=joint.follows.joint, multiplier=multiplier, offset="0")


def _limit(joint: LinkJoint, machine: Machine, is_endless: bool) -> dict[str, str]:
    """Attributes of a joint's limit element: the required ones, and others that are known."""
    attributes = {"lower": -FAR, "upper": FAR, "effort": FAR, "velocity": FAR}
    if is_endless:
        del attributes["lower"], attributes["upper"]
    if joint.limits.position:
        attributes |= {"lower": joint.limits.position.low, "upper": joint.limits.position.high}
    for key, quantity in EITHER_WAY.items():
        limits = getattr(joint.limits, quantity)
        if limits is None:
            continue
        if not limits.is_symmetric:
            place = next(place_of(j, row) for j, row in enumerate(machine.joints, start=1) if row.name == joint.name)
            what = f"[{limits.low:g}, {limits.high:g}]: URDF has one number either way: give one, or write .toml"
            raise machine.error(f"{place}, limits, {quantity}", what)
        attributes[key] = limits.high
    return {key: numbers_text([x]) for key, x in attributes.items()}
