"""A description as a tree: links that move together, and the order of joints in the table."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from symoro_elastic.formats.polynomials import Polynomial, direction_and_length
from symoro_elastic.formats.robots.axis_frames import NEARLY_PARALLEL, UNDECIDED
from symoro_elastic.formats.robots.robot import Description, JointType, Link, LinkJoint, Placement
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import MOST_JOINTS
from symoro_elastic.machine.formula import SMALLEST, ZERO, Formula
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.rounded_angles import TWELFTH, multiple_of_pi

EPS = 2.0**-52
ROUNDING = 16 * EPS
"""Error of angles, rad, and of lengths relative to that of a robot, that double precision leaves."""
NO_CHANCE = 1e-3
"""Part of the last digit by which a number that is meant to be a short decimal may differ from it."""
QUARTER = math.pi / 2
Length = float | Polynomial
"""A length, m, as a number or in names of parameters."""


@dataclass(frozen=True, eq=False)
class Carried:
    """How a link is carried: the joint that moves it, None on the base, and its placement in the joint's frame."""

    joint: LinkJoint | None
    placement: Placement


@dataclass(frozen=True, eq=False)
class Tree:
    """The links and joints of a description, verified to form one tree.

    `root` is the link that carries all others, `frame_0` the link whose frame is frame 0: the root, or the link that
    floats in it by the joint `floating`.
    """

    description: Description
    root: str
    children: dict[str, list[LinkJoint]]
    floating: LinkJoint | None = None

    @property
    def frame_0(self) -> str:
        """The link whose frame is frame 0."""
        return self.floating.child if self.floating else self.root

    @cached_property
    def joints(self) -> tuple[LinkJoint, ...]:
        """The joints beyond frame 0, fixed ones too: each before those that it carries, branch by branch."""
        ordered: list[LinkJoint] = []
        waiting = self.children[self.frame_0][::-1]
        while waiting:
            ordered.append(waiting.pop())
            waiting += self.children[ordered[-1].child][::-1]
        return tuple(ordered)

    @cached_property
    def moving(self) -> tuple[LinkJoint, ...]:
        """The moving joints, each before those that it carries, branch by branch."""
        return tuple(joint for joint in self.joints if joint.type is not JointType.FIXED)

    @cached_property
    def carrying(self) -> dict[str, Carried]:
        """By link: the joint that moves it, and the placement of the link in that joint's frame."""
        carriers = {self.frame_0: Carried(None, Placement())}
        for joint in self.joints:
            parent = carriers[joint.parent]
            fixed = joint.type is JointType.FIXED
            carriers[joint.child] = (
                Carried(parent.joint, parent.placement * joint.placement) if fixed else (Carried(joint, Placement()))
            )
        return carriers

    def seat(self, joint: LinkJoint) -> Placement:
        """Placement of a joint's frame at position 0 in the frame of the joint that moves its parent."""
        return self.carrying[joint.parent].placement * joint.placement

    def carrier(self, joint: LinkJoint) -> LinkJoint | None:
        """The joint that moves the parent of a joint; None on the base."""
        return self.carrying[joint.parent].joint

    @cached_property
    def carried_joints(self) -> dict[str, list[LinkJoint]]:
        """The moving joints directly carried by each joint, first the one that carries most joints."""
        carried: dict[str, list[LinkJoint]] = {joint.name: [] for joint in self.moving}
        weight = Counter({joint.name: 1 for joint in self.moving})
        for joint in reversed(self.moving):
            if carrier := self.carrier(joint):
                weight[carrier.name] += weight[joint.name]
        for joint in self.moving:
            if carrier := self.carrier(joint):
                carried[carrier.name].append(joint)
        return {name: sorted(joints, key=lambda joint: -weight[joint.name]) for name, joints in carried.items()}

    @cached_property
    def leaves(self) -> tuple[LinkJoint, ...]:
        """Fixed joints to links that carry nothing (tools, cameras), in the order of the joints that carry them."""
        fixed = [j for j in self.joints if j.type is JointType.FIXED and not self.children[j.child]]
        order = {joint.name: k for k, joint in enumerate(self.moving)}
        return tuple(sorted(fixed, key=lambda joint: order[carrier.name] if (carrier := self.carrier(joint)) else -1))

    @cached_property
    def _links_by_joint(self) -> dict[str, list[tuple[Link, Placement]]]:
        links: dict[str, list[tuple[Link, Placement]]] = {}
        for link in self.description.links:
            if carried := self.carrying.get(link.name):
                links.setdefault(carried.joint.name if carried.joint else "", []).append((link, carried.placement))
        return links

    def links_on(self, joint: LinkJoint | None) -> list[tuple[Link, Placement]]:
        """The links that move with a joint, or with frame 0, and their placements in its frame."""
        return self._links_by_joint.get(joint.name if joint else "", [])


def tree_of(description: Description, source: str) -> Tree:
    """The tree of a description; raises `InputError` that names links and joints outside a single tree."""
    links = [link.name for link in description.links]
    _refuse_twice("link", links, source)
    _refuse_twice("joint", [joint.name for joint in description.joints], source)
    children: dict[str, list[LinkJoint]] = {name: [] for name in links}
    above: dict[str, LinkJoint] = {}
    for joint in description.joints:
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in children:
                raise _wrong(source, joint, f"its {role} {quote(name)} is not a link{did_you_mean(name, children)}")
        if other := above.get(joint.child):
            what = f"its child {quote(joint.child)} is the child of joint {quote(other.name)} too: no closed loops"
            raise _wrong(source, joint, what)
        above[joint.child] = joint
        children[joint.parent].append(joint)
    root = _root(links, above, source)
    floating = _floating(description.joints, root, children, source)
    tree = Tree(description, root, children, floating)
    count = len(tree.moving) + len(tree.leaves)
    if count > MOST_JOINTS:
        raise InputError(source, "robot", f"{count} joints that move and leaves: at most {MOST_JOINTS} can be modelled")
    return tree


def _root(links: list[str], above: dict[str, LinkJoint], source: str) -> str:
    """The link that carries all others; raises `InputError` for several of them, or for links in a cycle."""
    if not links:
        raise InputError(source, "robot", "it has no link")
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        listed = ", ".join(map(quote, roots[:5])) + (" ..." if len(roots) > 5 else "")
        raise InputError(source, "links", f"{listed} are not children of a joint: one link must carry all others")
    cycle = _cycle(links, above)
    if cycle:
        around = " to ".join(map(quote, cycle[:6]))
        raise _wrong(source, above[cycle[0]], f"the links {around} are in a cycle: a robot is a tree")
    return roots[0]


def _cycle(links: Iterable[str], above: Mapping[str, LinkJoint]) -> list[str]:
    """Links that form a cycle, from parents to children; empty in a tree."""
    clear: set[str] = set()
    for name in links:
        chain: dict[str, None] = {}
        link = name
        while link in above and link not in clear and link not in chain:
            chain[link] = None
            link = above[link].parent
        if link in chain:
            return [link, *reversed([*chain][[*chain].index(link) :])]
        clear.update(chain)
    return []


def _floating(
    joints: Iterable[LinkJoint], root: str, children: dict[str, list[LinkJoint]], source: str
) -> LinkJoint | None:
    """The floating joint between the root, as world, and the robot; None for a fixed base."""
    floating = [joint for joint in joints if joint.type is JointType.FLOATING]
    for joint in floating:
        if joint.parent != root or len(children[root]) > 1:
            what = "a floating joint is for the base: that of the only child of the root link; elsewhere use six joints"
            raise _wrong(source, joint, what)
    return floating[0] if floating else None


def _refuse_twice(what: str, names: list[str], source: str) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(source, f"{what} {quote(twice[0])}", "the name is given twice: choose another")


def _wrong(source: str, joint: LinkJoint, what: str) -> InputError:
    return InputError(source, f"joint {quote(joint.name)}", what)


@dataclass(frozen=True)
class Tolerance:
    """Angles, rad, and lengths, m, that count as zero; angles near fractions of a turn are rounded to them.

    `parts` is the angle, rad, whose multiples replace angles.
    """

    angle: float
    length: float
    parts: float = QUARTER

    @classmethod
    def rounding(cls, size: float) -> Tolerance:
        """Return the tolerance for rounding errors of a robot of this size, m."""
        return cls(ROUNDING, max(ROUNDING * size, SMALLEST))

    @classmethod
    def of(cls, tolerance: float, size: float) -> Tolerance:
        """Return the tolerance that a user states, rad and m."""
        exact = cls.rounding(size)
        return cls(max(tolerance, exact.angle), max(tolerance, exact.length), TWELFTH)


@dataclass(frozen=True)
class Row:
    """Geometric parameters of a row of the table, rad and m."""

    gamma: float = 0.0
    b: Length = 0.0
    alpha: float = 0.0
    d: Length = 0.0
    theta: float = 0.0
    r: Length = 0.0

    def put_into(self, joint: Joint, tolerance: Tolerance) -> Joint:
        """Return the joint with these geometric parameters, rounded to zero within the tolerance."""
        return replace(
            joint,
            gamma=angle_cell(self.gamma, tolerance),
            b=length_cell(self.b, tolerance.length),
            alpha=angle_cell(self.alpha, tolerance),
            d=length_cell(self.d, tolerance.length),
            theta=angle_cell(self.theta, tolerance),
            r=length_cell(self.r, tolerance.length),
        )


def rows_of(T: Placement, tolerance: Tolerance) -> list[Row]:
    """Return the rows for a displacement: one, or two if the z axes are nearly parallel and apart.

    Two as well where z of both are parallel, and names decide in which direction they are apart.
    """
    sine = math.hypot(*T.rotation[:2, 2])
    if sine >= NEARLY_PARALLEL:
        return [_general(T)]
    across = direction_and_length(T.translation[:2])
    if across is None:
        along_x = T.translation * [1.0, 0.0, 0.0]
        return [Row(d=along_x[0]), *rows_of(Placement(T.rotation, T.translation - along_x), tolerance)]
    if sine <= tolerance.angle:
        return [_parallel(T, tolerance, *across)]
    if math.hypot(*across[0]) > tolerance.length:
        return [_parallel(Placement(translation=T.translation), tolerance, *across), _general(Placement(T.rotation))]
    return [_general(Placement(T.rotation, T.translation * [0.0, 0.0, 1.0]))]


def placement_of(joint: Joint) -> Placement:
    """Displacement by a row whose cells are numbers, with its variable at 0."""
    keys = ("gamma", "b", "alpha", "d", "theta", "r")
    gamma, b, alpha, d, theta, r = (getattr(joint, key).value() for key in keys)
    return about_z(gamma, b) * about_x(alpha, d) * about_z(theta, r)


def angle_cell(angle: float, tolerance: Tolerance) -> Formula:
    """The formula of an angle, rad: a multiple of pi where it is within the tolerance of one, else a number."""
    parts = round(angle / tolerance.parts)
    if abs(angle - parts * tolerance.parts) > tolerance.angle:
        return number_cell(angle, tolerance.angle)
    return Formula.parse(multiple_of_pi(Fraction(round(parts * tolerance.parts / TWELFTH), 12)))


def length_cell(length: Length, tolerance: float) -> Formula:
    """Return the formula of a length or another number; zero if it is below the tolerance."""
    if isinstance(length, Polynomial):
        return length.without_rounding(tolerance).formula
    return ZERO if abs(length) <= tolerance else number_cell(length, tolerance)


def number_cell(x: float, tolerance: float = 0.0) -> Formula:
    """Return the formula of a number, in 15 digits if further digits are rounding errors.

    A decimal of 6 or 9 digits replaces it if that is within the tolerance, and far nearer than by chance.
    """
    for digits in (6, 9, 15):
        short = f"{x:.{digits}g}"
        resolution = 10.0 ** (math.floor(math.log10(abs(x) or 1.0)) - digits + 1)
        if abs(float(short) - x) <= max(min(tolerance, NO_CHANCE * resolution), 4 * EPS * abs(x)):
            return Formula.parse(short)
    return Formula.parse(x)


def _general(T: Placement) -> Row:
    """Row for a displacement to an axis that is not parallel to z."""
    (x, y, z3), p = T.rotation[:, 2], T.translation
    sine = math.hypot(x, y)
    r = (p[0] * x + p[1] * y) / (sine * sine)
    return _row(T, math.atan2(x, -y), math.atan2(sine, z3), (x * p[1] - y * p[0]) / sine, p[2] - r * z3, r)


def _parallel(T: Placement, tolerance: Tolerance, across: Array, length: Length) -> Row:
    """Row for a displacement to a parallel or antiparallel axis, at distance `across` (x, y) times `length`."""
    x, y = map(float, across)
    z = T.translation[2]
    apart = math.hypot(x, y) > tolerance.length
    gamma, d = (math.atan2(y, x), math.hypot(x, y) * length) if apart else (0.0, 0.0)
    along = T.rotation[2, 2] > 0
    return _row(T, gamma, 0.0 if along else math.pi, d, 0.0, z if along else -z)


def _row(T: Placement, gamma: float, alpha: float, d: Length, b: Length, r: Length) -> Row:
    """Row for a displacement with gamma between -pi/2 and pi/2, given all parameters but theta."""
    if not UNDECIDED - QUARTER < gamma <= QUARTER + UNDECIDED:
        gamma, alpha, d = math.remainder(gamma + math.pi, 2 * math.pi), -alpha, -d
    normal = np.array([math.cos(gamma), math.sin(gamma), 0.0])
    x, _, z = T.rotation.T
    return Row(gamma, b, alpha, d, math.atan2(np.cross(normal, x) @ z, normal @ x), r)


def about_z(angle: float, shift: Length) -> Placement:
    """Placement Rot(z, angle) Trans(z, shift)."""
    c, s = math.cos(angle), math.sin(angle)
    return Placement(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([0.0, 0.0, shift]))


def about_x(angle: float, shift: Length) -> Placement:
    """Placement Rot(x, angle) Trans(x, shift)."""
    c, s = math.cos(angle), math.sin(angle)
    return Placement(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), np.array([shift, 0.0, 0.0]))


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """The rotation (3, 3) by roll about x, then pitch about y, then yaw about z, all of the fixed frame, rad."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_y @ about_x)


def rpy_of(rotation: Array) -> tuple[float, float, float]:
    """Roll, pitch and yaw, rad, of a rotation (3, 3): Rot(z, yaw) Rot(y, pitch) Rot(x, roll).

    Roll is what remains after yaw and pitch, so the three are right together where the pitch is a quarter turn.
    """
    (xx, _, _), (yx, _, _), (zx, _, _) = rotation
    level = math.hypot(xx, yx)
    yaw = math.atan2(yx, xx) if level > ROUNDING else 0.0
    pitch = math.atan2(-zx, level)
    residual = about_z(-yaw, 0.0).rotation @ rotation
    return math.atan2(-residual[1, 2], residual[1, 1]), pitch, yaw


def displacement_at(joint: LinkJoint, x: float) -> Placement:
    """Displacement of a link at a joint position, rad or m, in axes of the link's frame."""
    if joint.type is JointType.PRISMATIC:
        return Placement(translation=x * joint.axis)
    across = np.cross(np.eye(3), joint.axis)
    return Placement(np.eye(3) + math.sin(x) * across + (1 - math.cos(x)) * across @ across)
