"""A machine as MJCF: a body for each link that moves, exact for trees, loops as equality constraints.

Frames of bodies are those of the table; a link without mass has its joint on the body that it carries, as MuJoCo needs
mass on what moves. Torques of motors act on the joints; rotors are armatures, reflected. Joints of loops have the start
of their loop as `ref`, so that MuJoCo begins there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.formats.robots.joint_tree import Tree, about_z, displacement_at, rpy_of, tree_of
from symoro_elastic.formats.robots.modified_dh import together
from symoro_elastic.formats.robots.numbered import SMOOTH, Holds, notes_of, numbers_text, plain, robot_of, size_of
from symoro_elastic.formats.robots.robot import Connection, Description, Holding, JointType, Link, LinkJoint, Placement
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.names import distinct, quote

WORLD = "world"
LEAST = 1e-14
"""Mass, kg, and moment of inertia, kg m2, that MuJoCo accepts for a moving body."""
FLAT = 1e-14
"""Part of the trace that is added to moments of inertia of flat bodies, with one equal to the sum of the others."""
MOST_JOINTS, MOST_DEPTH = 6, 390
"""On a body, and of bodies on each other: readers of XML stop at some depth."""
FORCES = {
    "stiffness": "stiffness",
    "neutral": "springref",
    "damping": "damping",
    "rotor_inertia": "armature",
    "friction": "frictionloss",
}
MJCF = Holds(
    "MJCF",
    lacks={
        "wrenches": "forces on bodies",
        "backlash": "springs with backlash",
        **SMOOTH,
        "cogging": "cogging of motors",
        "sharing": "weights of shared torques",
        "ball": "damping of three turns as one",
    },
    degree=4,
    following="joints that follow one other by a polynomial up to the fourth power",
    passive=True,
    any_gravity=True,
)


def write(machine: Machine) -> str:
    """Return the MJCF text of a machine; raises `InputError` that names the joint, the cell or the parameter."""
    motors = {joint.name for joint in machine.joints if joint.kind is Kind.MOTOR}
    for loop in machine.loops:
        driven = [name for name in loop.dependent if name in motors]
        if driven:
            what = f"{', '.join(driven)} follow the others and have motors, which MJCF cannot say: write .toml"
            raise machine.error(f"loop {loop.name}, dependent", what)
    robot = robot_of(machine, MJCF)
    return _Writer(robot, tree_of(robot, machine.label), machine.label).text


@dataclass(frozen=True, eq=False)
class _Writer:
    """Conversion of a robot description to MJCF."""

    robot: Description
    tree: Tree
    source: str

    @cached_property
    def text(self) -> str:
        root = Element("mujoco", model=self.robot.name)
        lost = [*filter(None, map(_lost_limits, self.tree.moving))]
        root.extend(map(Comment, (*notes_of(self.robot), *lost)))
        SubElement(root, "compiler", angle="radian", eulerseq="XYZ")
        SubElement(root, "option", gravity=numbers_text(self.robot.gravity))
        world = SubElement(root, "worldbody")
        on = {"": self._base(world)}
        self._add_frames(on[""], None)
        depth = {"": 0}
        for group in self.groups:
            carrier, name = self.tree.carrier(group[0]), group[-1].name
            carried = carrier.name if carrier else ""
            depth[name] = depth[carried] + 1
            if depth[name] > MOST_DEPTH:
                raise self._error(name, f"more than {MOST_DEPTH} bodies carry each other: MJCF is not read so deep")
            on[name] = self._add_body(on[carried], group)
        equality = Element("equality")
        for joint in self.tree.moving:
            self._add_law(equality, joint)
        for connection in self.robot.connections:
            self._add_loop(equality, connection, on)
        root.extend([equality] if len(equality) else [])
        actuators = Element("actuator")
        for joint in self.tree.moving:
            torque = {"ctrlrange": _ends(joint.limits.torque)} if joint.limits.torque else {}
            if joint.driven:
                SubElement(actuators, "motor", {"name": joint.name, "joint": joint.name, **torque})
        root.extend([actuators] if len(actuators) else [])
        indent(root)
        return tostring(root, encoding="unicode") + "\n"

    def _base(self, world: Element) -> Element:
        """Add the base to the world; return the element for its joints: the world, or the floating body."""
        if not self.tree.floating:
            return world
        body = SubElement(world, "body", name=self.tree.frame_0)
        free = self.tree.floating
        if free.damping:
            SubElement(body, "joint", type="free", name=free.name, damping=numbers_text([free.damping]))
        else:
            SubElement(body, "freejoint", name=free.name)
        self._add_inertia(body, together(self.tree.links_on(None)), "base")
        return body

    @cached_property
    def groups(self) -> list[list[LinkJoint]]:
        """The joints of each body: one, preceded by those of massless links that carry nothing else."""
        groups: list[list[LinkJoint]] = []
        for joint in self.tree.moving:
            carrier = self.tree.carrier(joint)
            if groups and carrier and groups[-1][-1] is carrier and self._is_massless(carrier):
                groups[-1].append(joint)
            else:
                groups.append([joint])
        for group in groups:
            if len(group) > MOST_JOINTS:
                what = f"{len(group)} joints in a row have no mass between them: MuJoCo accepts {MOST_JOINTS}"
                raise self._error(group[-1].name, what)
        return groups

    def _is_massless(self, joint: LinkJoint) -> bool:
        """Return whether a link is massless and carries one joint and no frames, so that one body has both joints."""
        link = together(self.tree.links_on(joint))
        bare = not link.mass and not link.inertia.any() and not link.center.any()
        return bare and len(self.tree.carried_joints[joint.name]) == 1 and joint.name not in self._with_frames

    @cached_property
    def _with_frames(self) -> set[str]:
        """Names of joints whose links have ends of loops, frames that are leaves, or sites."""
        ends = {link for connection in self.robot.connections for link in (connection.first, connection.second)}
        carrying = (*ends, *(joint.child for joint in self.tree.leaves), *(frame.link for frame in self.robot.frames))
        owners = [self.tree.carrying[name].joint for name in carrying]
        return {joint.name for joint in owners if joint}

    def _error(self, name: str, what: str) -> InputError:
        return InputError(self.source, f"joint {quote(name)}", what)

    @cached_property
    def references(self) -> dict[str, float]:
        """Reference positions of the joints, rad or m, at which the file places bodies: starts of loops, or 0."""
        start = {name: x for connection in self.robot.connections for name, x in connection.start.items()}
        for joint in self.tree.moving:
            if joint.follows:
                start[joint.name] = float(_law(joint)(start.get(joint.follows.joint, 0.0)))
        return start

    def _reference_placement(self, joint: LinkJoint) -> Placement:
        """Placement of a link's frame at the reference position, relative to position 0 of its joint."""
        return displacement_at(joint, self.references.get(joint.name, 0.0))

    def _add_body(self, carrier: Element, group: list[LinkJoint]) -> Element:
        """Add a body with its joints, its inertia and its frames, and return its element."""
        after = [self._reference_placement(group[0])]
        for joint in group[1:]:
            after.append(after[-1] * self.tree.seat(joint) * self._reference_placement(joint))
        own = group[-1]
        body = SubElement(carrier, "body", self._placement_attributes(own.child, self.tree.seat(group[0]) * after[-1]))
        for joint, placement in zip(group, after, strict=True):
            at = after[-1].inverse * placement
            point, axis = plain(at.translation, self.size), plain(at.rotation @ joint.axis)
            SubElement(body, "joint", _attributes(joint, point, axis, self.references.get(joint.name, 0.0)))
        self._add_inertia(body, together(self.tree.links_on(own)), own.name)
        self._add_frames(body, own)
        return body

    @cached_property
    def size(self) -> float:
        """Size of the robot: the largest distance between consecutive joints, m."""
        return size_of(self.robot)

    def _placement_attributes(self, name: str, at: Placement) -> dict[str, str]:
        """Name attribute of a body or site, distinct from the world, and its placement without zeros."""
        point, angles = plain(at.translation, self.size), plain(np.array(rpy_of(at.rotation)))
        attributes = {"name": distinct(name, (WORLD,))} | ({"pos": numbers_text(point)} if point.any() else {})
        return attributes | ({"euler": numbers_text(angles)} if angles.any() else {})

    def _add_frames(self, body: Element, joint: LinkJoint | None) -> None:
        """Add the frames on a link: leaves as bodies without joints, others as sites."""
        for leaf in self.tree.leaves:
            if self.tree.carrier(leaf) is joint:
                SubElement(body, "body", self._placement_attributes(leaf.child, self.tree.seat(leaf)))
        for frame in self.robot.frames:
            carried = self.tree.carrying.get(frame.link)
            if carried and carried.joint is joint:
                SubElement(body, "site", self._placement_attributes(frame.name, carried.placement * frame.placement))

    def _add_inertia(self, body: Element, link: Link, name: str) -> None:
        principal = np.linalg.eigvalsh(link.inertia)
        place, trace = f"joint {quote(name)}" if name != "base" else "base", principal.sum()
        if link.mass < LEAST or principal[0] < LEAST:
            what = "mass and principal moments of inertia of what moves must be positive for MuJoCo"
            raise InputError(self.source, place, f"{what}: give its body, or one fixed to it, some")
        if principal[2] - principal[0] - principal[1] > FLAT * trace:
            what = f"moments {principal[0]:g}, {principal[1]:g} and {principal[2]:g} kg m2 about its centre of mass"
            raise InputError(self.source, place, f"{what} are not those of a body, and MuJoCo refuses them")
        flat = principal[0] + principal[1] - principal[2] < FLAT * trace
        inertia = link.inertia + flat * FLAT * trace * np.eye(3)
        entries = [inertia[i, k] for i, k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        moments = {"fullinertia": entries} if any(entries[3:]) else {"diaginertia": entries[:3]}
        inertial: dict[str, Any] = {"pos": link.center, "mass": [link.mass], **moments}
        SubElement(body, "inertial", {key: numbers_text(numbers) for key, numbers in inertial.items()})

    def _add_law(self, equality: Element, joint: LinkJoint) -> None:
        """Add the constraint of a following joint: a polynomial of the deviation from its reference."""
        if not joint.follows:
            return
        law = _law(joint)(Polynomial([self.references.get(joint.follows.joint, 0.0), 1.0]))
        law.coef[0] -= self.references[joint.name]
        coefficients = numbers_text([*law.coef, *[0.0] * (5 - len(law.coef))])
        names = {"name": f"{joint.name}_follows", "joint1": joint.name, "joint2": joint.follows.joint}
        SubElement(equality, "joint", names | {"polycoef": coefficients})

    def _add_loop(self, equality: Element, connection: Connection, on: dict[str, Element]) -> None:
        """Add the constraint of a loop between sites: of points or frames; two points make a hinge."""
        kinds = {Holding.FRAME: "weld"}
        along = about_z(0.0, self.size)
        shifts = {"": Placement(), **({"_axis": along} if connection.holding is Holding.AXIS else {})}
        for suffix, shift in shifts.items():
            name = connection.name + suffix
            for end, link, at in (
                ("cut", connection.first, connection.on_first),
                ("end", connection.second, connection.on_second),
            ):
                carried = self.tree.carrying[link]
                owner = on[carried.joint.name if carried.joint else ""]
                place = self._placement_attributes(f"{name}_{end}", carried.placement * at * shift)
                owner.insert(0, Element("site", place))
            attributes = {"name": name, "site1": f"{name}_cut", "site2": f"{name}_end"}
            SubElement(equality, kinds.get(connection.holding, "connect"), attributes)


def _law(joint: LinkJoint) -> Polynomial:
    """Polynomial of a joint's position in the position of the joint that it follows."""
    assert joint.follows
    return Polynomial([joint.follows.offset, joint.follows.multiplier, *joint.follows.powers])


def _attributes(joint: LinkJoint, point: Array, axis: Array, reference: float) -> dict[str, str]:
    """MJCF attributes of a joint, zeros omitted."""
    kind = "slide" if joint.type is JointType.PRISMATIC else "hinge"
    forces: dict[str, Any] = {key: getattr(joint, name) for name, key in FORCES.items()}
    forces = {"ref": reference, **forces}
    attributes = {"name": joint.name, "type": kind, "axis": numbers_text(axis)}
    attributes |= {"pos": numbers_text(point)} if point.any() else {}
    attributes |= {"range": _ends(joint.limits.position)} if joint.limits.position else {}
    return attributes | {key: numbers_text([x]) for key, x in forces.items() if x}


def _ends(limits: Range) -> str:
    return numbers_text([limits.low, limits.high])


def _lost_limits(joint: LinkJoint) -> str:
    """Return a comment on limits that MJCF cannot represent; empty without such limits."""
    names = ("velocity", "acceleration") if joint.driven else ("velocity", "acceleration", "torque")
    lost = [name for name in names if getattr(joint.limits, name) is not None]
    return f" left out: limits of {' and '.join(lost)} of {joint.name} " if lost else ""
