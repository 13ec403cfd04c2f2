"""URDF as links and joints.

Lengths of axes, shapes and what simulators add are not part of a model; what changes one and cannot be taken
is reported in `remarks`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.robots.joint_tree import rotation
from symoro_elastic.formats.robots.robot import (
    EXPAND,
    Description,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    PlacedFrame,
    Placement,
)
from symoro_elastic.formats.robots.xml_text import numbers, root_element
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import BodyShape
from symoro_elastic.machine.limits import JointLimits, Range, range_of
from symoro_elastic.machine.names import list_of_names, quote
from symoro_elastic.quantities.frames import JOINT, LINK

TYPES = {
    "revolute": JointType.REVOLUTE,
    "continuous": JointType.REVOLUTE,
    "prismatic": JointType.PRISMATIC,
    "fixed": JointType.FIXED,
    "floating": JointType.FLOATING,
}
PLANAR = "a planar joint: write it as two prismatic joints and a revolute one, with links without inertia between"
MODELLED = {"link", "joint", "transmission"}
WITHOUT_EFFECT = {"material", "gazebo", "sensor", "plugin", "static", "verbose", "mujoco", "capsule_geometry"}
ENTRIES = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
NOT_OF_LENGTH_ONE = 1e-3
FAR = 1e9
"""Limits from this value on mean none: files must state some."""
EITHER_WAY = {"velocity": "velocity", "acceleration": "acceleration", "effort": "torque"}
"""Attributes of <limit> that hold either way, acceleration since version 1.2, and the quantities that they limit."""


def describe(text: str, source: str) -> Description:
    """Read the robot in a URDF text; raises `InputError` that names the link or the joint."""
    robot = root_element(text, source)
    _refuse_others(robot, source)
    rotors = Rotors(robot, source)
    links = tuple(_link(link, source) for link in robot.findall("link"))
    joints = tuple(_joint(joint, rotors, source) for joint in robot.findall("joint"))
    return Description(
        name=robot.get("name") or name_of(Path(source).stem),
        links=links,
        joints=joints,
        remarks=(*_remarks(robot), *rotors.remarks(joints)),
        frames=(
            *(PlacedFrame(link.name, LINK, link.name) for link in links),
            *(PlacedFrame(joint.name, JOINT, joint.child) for joint in joints),
        ),
    )


def _refuse_others(robot: Element, source: str) -> None:
    """Raise `InputError` for XML that is not URDF."""
    unexpanded = [element for element in robot.iter() if element.tag.startswith("xacro:")]
    unexpanded += [e for e in _elements_of_model(robot) if any("${" in x or "$(" in x for x in e.attrib.values())]
    if unexpanded:
        raise InputError(source, f"element <{unexpanded[0].tag}>", EXPAND)
    if robot.tag != "robot":
        advice = {"mujoco": "MJCF: its suffix is .xml", "sdf": "SDF, which is not read: convert it to URDF"}
        what = advice.get(robot.tag, "a URDF file begins with <robot>")
        raise InputError(source, f"element <{robot.tag}>", what)


def _elements_of_model(robot: Element) -> Iterator[Element]:
    """The elements of links and joints that a model needs: all but shapes."""
    for element in robot:
        if element.tag in ("link", "joint"):
            yield element
            for part in element:
                if part.tag not in ("visual", "collision"):
                    yield from part.iter()


def _link(link: Element, source: str) -> Link:
    name = _name(link, source)
    place = f"link {quote(name)}"
    inertial = link.find("inertial")
    shapes = tuple(_shapes(link, source, place))
    if inertial is None:
        return Link(name, shapes=shapes)
    (mass,) = numbers(_child(inertial, "mass", source, place), "value", None, 1, source, place)
    if mass < 0:
        raise InputError(source, place, f"its mass is negative: {mass:g}")
    tensor = _child(inertial, "inertia", source, place)
    inertia = np.array([[_entry(tensor, key, source, place) for key in row] for row in ENTRIES])
    origin = _origin(inertial, source, place)
    return Link(name, mass, origin.translation, origin.rotation @ inertia @ origin.rotation.T, False, shapes)


def _shapes(link: Element, source: str, place: str) -> Iterator[BodyShape]:
    """Shapes of a link: names of meshes, whose files are not opened; invalid ones are omitted."""
    for visual in link.findall("visual"):
        for shape in visual.iterfind("geometry/*"):
            try:
                at = _origin(visual, source, place).matrix
                if drawn_shape := _shape(shape, source, place):
                    yield replace(drawn_shape, points=at @ drawn_shape.points)
            except InputError:
                continue


def _shape(shape: Element, source: str, place: str) -> BodyShape | None:
    """Mesh, box, cylinder or sphere of a shape element, with its size; None for others."""

    def of(key: str, default: str | None, count: int) -> list[float]:
        return numbers(shape, key, default, count, source, place)

    if shape.tag == "mesh" and shape.get("filename"):
        return BodyShape(np.diag([*of("scale", "1 1 1", 3), 1.0]), shape.get("filename", ""))
    if shape.tag == "box":
        return BodyShape(np.diag([*(x / 2 for x in of("size", None, 3)), 1.0]), solid="box")
    if shape.tag in ("cylinder", "sphere"):
        (r,) = of("radius", None, 1)
        half = of("length", None, 1)[0] / 2 if shape.tag == "cylinder" else r
        return BodyShape(np.diag([r, r, half, 1.0]), solid="cylinder" if shape.tag == "cylinder" else "ellipsoid")
    return None


def _entry(tensor: Element, key: str, source: str, place: str) -> float:
    """Entry of the inertia tensor; products may be missing."""
    return numbers(tensor, key, None if key[1] == key[2] else "0", 1, source, place)[0]


def _joint(joint: Element, rotors: Rotors, source: str) -> LinkJoint:
    name = _name(joint, source)
    place = f"joint {quote(name)}"
    kind = joint.get("type", "")
    if kind not in TYPES:
        message = f"{quote(kind)} is not a type of joint: there are {', '.join(TYPES)}"
        raise InputError(source, place, PLANAR if kind == "planar" else message)
    type_ = TYPES[kind]
    damping, friction = _dynamics(joint, source, place)
    fixed = type_ in (JointType.FIXED, JointType.FLOATING)
    return LinkJoint(
        name,
        type_,
        _link_of(joint, "parent", source, place),
        _link_of(joint, "child", source, place),
        _origin(joint, source, place),
        np.array([1.0, 0.0, 0.0]) if fixed else _axis(joint, source, place),
        damping=0.0 if fixed else damping,
        friction=0.0 if fixed else friction,
        rotor_inertia=0.0 if fixed else rotors.inertia(name),
        follows=None if fixed else _followed_joint(joint, source, place),
        limits=JointLimits() if fixed else limits_of(joint, source, place),
    )


def _dynamics(joint: Element, source: str, place: str) -> tuple[float, float]:
    """Viscous and dry friction of a joint."""
    dynamics = joint.find("dynamics")
    if dynamics is None:
        return 0.0, 0.0
    damping, friction = (numbers(dynamics, key, "0", 1, source, place)[0] for key in ("damping", "friction"))
    for key, value in (("damping", damping), ("friction", friction)):
        if value < 0:
            raise InputError(source, place, f"its {key} is negative: {value:g}")
    return damping, friction


def limits_of(joint: Element, source: str, place: str) -> JointLimits:
    """Limits of a joint, without empty ranges and without huge ones that mean no limit."""
    limit = joint.find("limit")
    if limit is None:
        return JointLimits()
    return JointLimits(
        position=range_of(*_ends(limit, source, place), FAR) if joint.get("type") != "continuous" else None,
        **{quantity: _either_way(limit, key, source, place) for key, quantity in EITHER_WAY.items()},
    )


def _ends(limit: Element, source: str, place: str) -> tuple[float, float]:
    """Lower and upper position limit; 0 if only the other one is stated, as URDF defines."""
    lower, upper = (_limit(limit, key, source, place) for key in ("lower", "upper"))
    return lower, upper


def _either_way(limit: Element, key: str, source: str, place: str) -> Range | None:
    largest = _limit(limit, key, source, place)
    return range_of(-largest, largest, FAR)


def _limit(limit: Element, key: str, source: str, place: str) -> float:
    """A number of a limit, 0 by default; it may be infinite."""
    if limit.get(key, "").strip().lower().lstrip("+-") in ("inf", "infinity"):
        return math.copysign(math.inf, -1.0 if limit.get(key, "").strip()[0] == "-" else 1.0)
    return numbers(limit, key, "0", 1, source, place)[0]


def _axis(joint: Element, source: str, place: str) -> Array:
    """Direction of the axis, of length 1."""
    element = joint.find("axis")
    axis = np.array([1.0, 0.0, 0.0] if element is None else numbers(element, "xyz", None, 3, source, place))
    largest = np.abs(axis).max()
    if not largest:
        raise InputError(source, place, "its axis is 0 0 0: an axis has a direction, such as 0 0 1")
    return np.asarray(axis / largest / np.linalg.norm(axis / largest))


def _followed_joint(joint: Element, source: str, place: str) -> Mimicked | None:
    mimic = joint.find("mimic")
    if mimic is None:
        return None
    leader = mimic.get("joint")
    if not leader:
        raise InputError(source, place, "<mimic> lacks joint, the name of the joint that it follows")
    multiplier, offset = (
        numbers(mimic, key, default, 1, source, place)[0] for key, default in (("multiplier", "1"), ("offset", "0"))
    )
    return Mimicked(leader, multiplier, offset)


def _origin(element: Element, source: str, place: str) -> Placement:
    origin = element.find("origin")
    if origin is None:
        return Placement()
    roll, pitch, yaw = numbers(origin, "rpy", "0 0 0", 3, source, place)
    return Placement(rotation(roll, pitch, yaw), np.array(numbers(origin, "xyz", "0 0 0", 3, source, place)))


def _name(element: Element, source: str) -> str:
    name = element.get("name")
    if not name:
        raise InputError(source, f"element <{element.tag}>", f"a {element.tag} has no name")
    return name


def _child(element: Element, tag: str, source: str, place: str) -> Element:
    child = element.find(tag)
    if child is None:
        raise InputError(source, place, f"<{element.tag}> lacks <{tag}>")
    return child


def _link_of(joint: Element, role: str, source: str, place: str) -> str:
    name = _child(joint, role, source, place).get("link")
    if not name:
        raise InputError(source, place, f"<{role}> lacks link, the name of its {role}")
    return name


def _remarks(robot: Element) -> Iterator[str]:
    """Yield remarks on contents of the file that the model omits."""
    if any(True for _ in robot.iter("mesh")):
        yield "meshes, package:// and others, are not read: a model needs masses; view draws those it finds"
    unknown = dict.fromkeys(e.tag for e in robot if e.tag not in MODELLED | WITHOUT_EFFECT)
    if unknown:
        yield f"unknown URDF elements are ignored: {list_of_names(unknown)}"
    springs = [e.get("reference", "") for e in robot.findall("gazebo") if e.find("springStiffness") is not None]
    if springs:
        yield f"springs for Gazebo are not read: joint {list_of_names(springs)}; give them by convert --elastic JOINT=K"
    reversed_ = [joint.get("name", "") for joint in robot.findall("joint") if _is_reversed(joint)]
    if reversed_:
        yield f"limits whose lower end is above the upper one are not taken: joint {list_of_names(reversed_)}"
    odd = [joint.get("name", "") for joint in robot.findall("joint") if _is_long(joint)]
    if odd:
        yield f"axes that are not of length 1 give directions only: joint {list_of_names(odd)}"


def _is_reversed(joint: Element) -> bool:
    """Return whether a moving joint has reversed position limits."""
    limit = joint.find("limit")
    if limit is None or joint.get("type") not in ("revolute", "prismatic"):
        return False
    return float(limit.get("lower", "0")) > float(limit.get("upper", "0"))


def _is_long(joint: Element) -> bool:
    """Return whether the axis vector of a moving joint does not have length 1."""
    axis = joint.find("axis")
    if axis is None or joint.get("type") in ("fixed", "floating"):
        return False
    length = math.hypot(*map(float, axis.get("xyz", "").split()))
    return abs(length - 1.0) > NOT_OF_LENGTH_ONE


ROTOR, RATIO = "drake:rotor_inertia", "drake:gear_ratio"


class Rotors:
    """Transmissions of a robot, by the joints that they drive."""

    def __init__(self, robot: Element, source: str) -> None:
        self.source = source
        self.by_joint: dict[str, Element] = {}
        for transmission in robot.findall("transmission"):
            for joint in transmission.findall("joint"):
                self.by_joint.setdefault(joint.get("name", ""), transmission)

    def inertia(self, joint: str) -> float:
        """Rotor inertia reflected to the joint: that of Drake's elements, times the squared gear ratio."""
        actuator = self._actuator(joint)
        if actuator is None or actuator.find(ROTOR) is None:
            return 0.0
        inertia, ratio = (self._value(actuator, tag, joint) for tag in (ROTOR, RATIO))
        if inertia < 0:
            raise InputError(self.source, f"joint {quote(joint)}", f"its rotor inertia is negative: {inertia:g}")
        return inertia * ratio * ratio

    def remarks(self, joints: Iterable[LinkJoint]) -> Iterator[str]:
        """Yield remarks on unused gear ratios, and on joints without transmission, which get motors."""
        own = [j.name for j in joints if j.type is not JointType.FIXED and j.follows is None]
        reduced = [name for name in own if self._is_reduced(name) and not self.inertia(name)]
        if reduced:
            yield (
                "motor torques are those on the joints: mechanicalReduction is not applied, and no rotor inertia is "
                f"known; give it in [motors] ({list_of_names(reduced)})"
            )
        without = [name for name in own if name not in self.by_joint]
        if self.by_joint and without:
            yield f'{list_of_names(without)}: no transmission, treated as actuated (set kind = "passive" if not)'

    def _actuator(self, joint: str) -> Element | None:
        transmission = self.by_joint.get(joint)
        return None if transmission is None else transmission.find("actuator")

    def _value(self, actuator: Element, tag: str, joint: str) -> float:
        element = actuator.find(tag)
        return 1.0 if element is None else numbers(element, "value", None, 1, self.source, f"joint {quote(joint)}")[0]

    def _is_reduced(self, joint: str) -> bool:
        transmission = self.by_joint.get(joint)
        texts = [] if transmission is None else [e.text or "" for e in transmission.iter("mechanicalReduction")]
        return any(text.strip() not in ("", "1", "1.0") for text in texts)
