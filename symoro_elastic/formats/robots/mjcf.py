"""Robots in MJCF, the format of MuJoCo: bodies, joints, springs, actuators and equality constraints.

A joint's position is MuJoCo's `qpos`, its `ref` included. Several joints on a body have links without mass between
them; the frame of a link has the axes of its body, and its origin on the axis of its last joint.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.robots.axis_frames import Axis, frame_on
from symoro_elastic.formats.robots.mjcf_bodies import WORLD, Bodies, Freedom
from symoro_elastic.formats.robots.mjcf_forces import Forces
from symoro_elastic.formats.robots.mjcf_model import Compiled, mujoco_model
from symoro_elastic.formats.robots.mjcf_shapes import shapes_by_link
from symoro_elastic.formats.robots.robot import (
    Connection,
    Description,
    Holding,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    Placement,
)
from symoro_elastic.machine.described import BodyShape
from symoro_elastic.machine.names import distinct, list_of_names, quote

CONNECT, WELD, JOINT = "mjEQ_CONNECT", "mjEQ_WELD", "mjEQ_JOINT"


def describe(text: str, source: str) -> Description:
    """The robot in an MJCF text; raises `InputError`, one line that names the body, the joint or the line."""
    return _Robot(mujoco_model(text, source)).description


@dataclass(frozen=True, eq=False)
class _Robot:
    """A compiled model on the way to its description."""

    compiled: Compiled

    @cached_property
    def description(self) -> Description:
        """The robot."""
        parts = [part for b in self.bodies.taken for part in self._chain(b)]
        model, gravity = self.bodies.model, not self.forces.off("GRAVITY")
        x, y, z = (float(g) * gravity for g in model.opt.gravity)
        return Description(
            name=name_of(self.compiled.name) if self.compiled.name else name_of_file(self.compiled.source),
            links=(Link(WORLD, shapes=self.shapes.get(WORLD, ())), *(link for link, _ in parts)),
            joints=tuple(joint for _, joint in parts),
            connections=tuple(self._assembled(one) for one in self.equalities.connections),
            gravity=(x, y, z),
            remarks=remarks_of(self.bodies, self.forces, self.equalities),
        )

    @cached_property
    def bodies(self) -> Bodies:
        """The bodies of the robot."""
        return Bodies(self.compiled)

    @cached_property
    def forces(self) -> Forces:
        """What acts on its joints."""
        return Forces(self.bodies)

    @cached_property
    def shapes(self) -> dict[str, tuple[BodyShape, ...]]:
        """What its links look like."""
        return shapes_by_link(self.bodies)

    @cached_property
    def equalities(self) -> Equalities:
        """What else it holds together."""
        return Equalities(self.bodies, self.forces)

    def _chain(self, b: int) -> Iterator[tuple[Link, LinkJoint]]:
        """The links of a body, the last one with its mass, each with the joint that carries it."""
        carrier = int(self.bodies.model.body_parentid[b])
        parent, at = self.bodies.names[carrier], self.bodies.seat(b)
        if carrier:
            at = self.bodies.on_link(carrier) * at
        freedoms = self.bodies.freedoms(b)
        if not freedoms:
            name = distinct(f"{self.bodies.names[b]}_fixed", self.bodies.joint_names)
            yield self._link(b), LinkJoint(name, JointType.FIXED, parent, self.bodies.names[b], at)
        before = np.zeros(3)
        for freedom in freedoms:
            at = at * Placement(translation=freedom.anchor - before)
            is_last = freedom is freedoms[-1]
            link = (
                self._link(b)
                if is_last
                else Link(distinct(f"{freedom.name}_link", self.bodies.names), frame_only=False)
            )
            yield link, self._joint(freedom, parent, link.name, at)
            parent, at, before = link.name, Placement(), freedom.anchor

    def _link(self, b: int) -> Link:
        """The link with the mass of a body; one at rest needs none."""
        model = self.bodies.model
        name = self.bodies.names[b]
        shapes = self.shapes.get(name, ())
        if model.body_weldid[b] == 0:
            return Link(name, shapes=shapes)
        principal = self.bodies.rotation(model.body_iquat[b])
        center = self.bodies.on_link(b).translation + model.body_ipos[b]
        inertia = principal * model.body_inertia[b] @ principal.T
        return Link(name, float(model.body_mass[b]), center, inertia, frame_only=False, shapes=shapes)

    def _between(self, freedom: Freedom) -> Link:
        """The link without mass that a joint carries where its body has further ones."""
        return Link(distinct(f"{freedom.name}_link", self.bodies.names), frame_only=False)

    def _joint(self, freedom: Freedom, parent: str, child: str, at: Placement) -> LinkJoint:
        """A joint, at position 0 where the reference position puts the body as the file does."""
        forces = self.forces.on(freedom)
        if freedom.type is JointType.FLOATING:
            return LinkJoint(freedom.name, freedom.type, parent, child, at)
        at = at * self._displacement(freedom, -freedom.reference)
        limits = self.forces.limits(freedom)
        joint = LinkJoint(freedom.name, freedom.type, parent, child, at, freedom.axis, **forces, limits=limits)
        follows = self.equalities.followers.get(freedom.number)
        if isinstance(follows, Mimicked):
            return replace(joint, follows=follows, driven=False)
        if follows is not None:
            return LinkJoint(joint.name, JointType.FIXED, parent, child, at * self._displacement(freedom, follows))
        return joint

    def _displacement(self, freedom: Freedom, position: float) -> Placement:
        if freedom.type is JointType.PRISMATIC:
            return Placement(translation=position * freedom.axis)
        return Placement(self.bodies.about(freedom.axis, position))

    def _assembled(self, connection: Connection) -> Connection:
        """The connection with the positions at which the file assembles it."""
        positions = {f.name: f.reference for b in self.bodies.taken for f in self.bodies.freedoms(b)}
        return replace(connection, start=positions)


def name_of_file(source: str) -> str:
    """The name of a machine that its file does not give."""
    return name_of(source.replace("\\", "/").rpartition("/")[2].rpartition(".")[0])


OF_TENDONS = ("stiffness", "damping", "frictionloss", "armature", "limited")


def remarks_of(bodies: Bodies, forces: Forces, equalities: Equalities) -> tuple[str, ...]:
    """Return what is not taken of a file, and what is taken otherwise than it stands there."""
    return tuple(_remarks(bodies, forces, equalities))


def _remarks(bodies: Bodies, forces: Forces, equalities: Equalities) -> Iterator[str]:
    model = bodies.model
    if bodies.objects:
        yield f"free bodies beside the robot are ignored: {list_of_names(bodies.names[b] for b in bodies.objects)}"
    balls = [
        bodies.joint_names[j]
        for j in range(model.njnt)
        if bodies.type_of(j) is None and model.jnt_bodyid[j] in bodies.taken
    ]
    if balls:
        what = "ball joints are turns about x, y and z, singular where the second is at a right angle"
        yield f"{what}: {list_of_names(balls)}"
    if not model.nu:
        yield "the file has no actuators: joints without springs are taken as driven"
    elif any(map(forces.is_more_than_torque, range(model.nu))):
        yield "torques act on the joints: gears and control laws of actuators are ignored"
    if forces.elsewhere:
        names = (model.actuator(a).name or f"actuator {a + 1}" for a in forces.elsewhere)
        yield f"actuators that act on no joint are ignored: {list_of_names(names)}"
    driven = [bodies.joint_names[j] for j in equalities.followers if j in forces.actuators]
    if driven:
        yield f"these joints follow others, so their actuators are ignored: {list_of_names(driven)}"
    if equalities.left_out:
        yield f"equality constraints that are ignored: {list_of_names(equalities.left_out)}"
    without = [*_without_model(bodies, forces)]
    if without:
        yield f"not modelled: {', '.join(without)}"


def _without_model(bodies: Bodies, forces: Forces) -> Iterator[str]:
    """Forces that are not modelled."""
    model = bodies.model
    if bodies.compiled.has_contacts and not forces.off("CONTACT"):
        yield "contacts"
    if model.jnt_limited.any() and not forces.off("LIMIT"):
        yield "stops at the limits of joints"
    tendons = [t for t in range(model.ntendon) if any(getattr(model, f"tendon_{key}")[t] for key in OF_TENDONS)]
    if tendons:
        yield f"forces of tendons ({list_of_names(model.tendon(t).name or f'tendon {t + 1}' for t in tendons)})"
    if model.opt.density or model.opt.viscosity:
        yield "forces of the fluid around it"
    if model.body_gravcomp.any():
        yield "forces that compensate gravity (gravcomp)"


# Equality constraints of a compiled MJCF model: joints that follow others, and connections that close loops.
@dataclass(frozen=True, eq=False)
class Equalities:
    """The equality constraints of a model that are in force."""

    bodies: Bodies
    forces: Forces

    @cached_property
    def followers(self) -> dict[int, Mimicked | float]:
        """By the number of a joint: the joint that it follows, or the position, rad or m, at which it is held."""
        found: dict[int, Mimicked | float] = {}
        for e in self._of(JOINT):
            first, second = int(self._model.eq_obj1id[e]), int(self._model.eq_obj2id[e])
            law = self._law(e, first, second)
            if second >= 0 and self._is_led_by_first(first, second, law):
                first, second = second, first
                law = Polynomial([-law.coef[0] / law.coef[1], 1 / law.coef[1]])
            if first in found:
                what = f"equality constraints {quote(self.name(e))} and others determine its position: keep one"
                raise self.bodies.compiled.error(f"joint {quote(self.bodies.joint_names[first])}", what)
            found[first] = self._following(first, second, law)
        return found

    @cached_property
    def connections(self) -> tuple[Connection, ...]:
        """What holds bodies of the robot together, or to the world."""
        return with_hinges([one for e in self._of(CONNECT, WELD) if (one := self._connection(e))])

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Names of the constraints that are not taken: of tendons, to bodies that are not taken, and not in force."""
        taken = set(self._of(JOINT)) | {e for e in self._of(CONNECT, WELD) if self._connection(e)}
        return tuple(self.name(e) for e in range(self._model.neq) if e not in taken)

    def name(self, e: int) -> str:
        """The name of a constraint; its type and number where the file gives none."""
        given = [self._model.equality(k).name for k in range(self._model.neq)]
        return given[e] or f"{self._type(e).removeprefix('mjEQ_').lower()}{e + 1}"

    @property
    def _model(self) -> Any:
        return self.bodies.model

    def _type(self, e: int) -> str:
        name: str = self.bodies.compiled.mujoco.mjtEq(self._model.eq_type[e]).name
        return name

    def _of(self, *types: str) -> Iterator[int]:
        """Numbers of the constraints of some types that are in force."""
        if not self.forces.off("EQUALITY") and not self.forces.off("CONSTRAINT"):
            yield from (e for e in range(self._model.neq) if self._type(e) in types and self._model.eq_active0[e])

    def _law(self, e: int, first: int, second: int) -> Polynomial:
        """The position of the first joint as a polynomial of that of the second."""
        own, other = (float(self._model.qpos0[self._model.jnt_qposadr[j]]) if j >= 0 else 0.0 for j in (first, second))
        coefficients = self._model.eq_data[e][: 5 if second >= 0 else 1]
        law: Polynomial = Polynomial(coefficients)(Polynomial([-other, 1.0])) + own
        return law.trim()

    def _is_led_by_first(self, first: int, second: int, law: Polynomial) -> bool:
        """Whether the second joint is to follow: the first has the motor or the spring, and the law is linear."""
        acted = [bool(self.forces.actuators.get(j)) or self._model.jnt_stiffness[j] > 0 for j in (first, second)]
        return acted == [True, False] and law.degree() == 1

    def _following(self, first: int, second: int, law: Polynomial) -> Mimicked | float:
        name = self.bodies.joint_names[first]
        if self._model.jnt_stiffness[first] > 0 and not self.forces.off("SPRING"):
            what = "it has a spring and follows another joint: move the spring to that joint"
            raise self.bodies.compiled.error(f"joint {quote(name)}", what)
        if second < 0 or law.degree() == 0:
            return float(law.coef[0])
        offset, multiplier, *powers = map(float, law.coef)
        return Mimicked(self.bodies.joint_names[second], multiplier, offset, tuple(powers))

    def _connection(self, e: int) -> Connection | None:
        """A connection of two links; None where a body is not taken, or where both are one."""
        ends = self._ends(e)
        if ends is None or ends[0][0] == ends[1][0]:
            return None
        (first, on_first), (second, on_second) = ends
        holding = Holding.FRAME if self._type(e) == WELD else Holding.POINT
        return Connection(self.name(e), first, second, on_first, on_second, holding)

    def _ends(self, e: int) -> tuple[tuple[str, Placement], tuple[str, Placement]] | None:
        """The link of each of the two frames that coincide, and the placement of the frame there."""
        model, data = self._model, self._model.eq_data[e]
        objects = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if model.eq_objtype[e] == self.bodies.compiled.mujoco.mjtObj.mjOBJ_SITE:
            owners = [int(model.site_bodyid[s]) for s in objects]
            frames = [Placement(self.bodies.rotation(model.site_quat[s]), model.site_pos[s].copy()) for s in objects]
        elif self._type(e) == WELD:
            owners, frames = [*objects], [Placement(self.bodies.rotation(data[6:10]), data[3:6].copy()), Placement()]
        else:
            owners = [*objects]
            frames = [Placement(translation=data[:3].copy()), Placement(translation=data[3:6].copy())]
        places = [self.bodies.place(b) for b in owners]
        if places[0] is None or places[1] is None:
            return None
        (first, a), (second, b) = places[0], places[1]
        return (first, a * frames[0]), (second, b * frames[1])


SAME_LENGTH = 1e-9
"""Part by which the distances of two points on two links may differ where a hinge goes through both."""


def with_hinges(connections: Sequence[Connection]) -> tuple[Connection, ...]:
    """Return the connections, two links that are held together at two points as a hinge through both."""
    pairs: dict[tuple[str, str], list[Connection]] = {}
    for one in connections:
        if one.holding is Holding.POINT:
            pairs.setdefault((one.first, one.second), []).append(one)
    hinges = {id(pair[0]): hinge for pair in pairs.values() if len(pair) == 2 and (hinge := _hinge(*pair))}
    seconds = {id(pair[1]) for pair in pairs.values() if id(pair[0]) in hinges}
    return tuple(hinges.get(id(one), one) for one in connections if id(one) not in seconds)


def _hinge(one: Connection, other: Connection) -> Connection | None:
    """The hinge through the points of two connections; None where these are not as far apart on both links."""
    ends = (one.on_first, other.on_first), (one.on_second, other.on_second)
    axes = [b.translation - a.translation for a, b in ends]
    lengths = [float(np.linalg.norm(axis)) for axis in axes]
    if not min(lengths) or abs(lengths[0] - lengths[1]) > SAME_LENGTH * max(lengths):
        return None
    lines = [Axis(a.translation, axis / length) for (a, _), axis, length in zip(ends, axes, lengths, strict=True)]
    first, second = (frame_on(line, a, None) for line, (a, _) in zip(lines, ends, strict=True))
    return replace(one, on_first=first, on_second=second, holding=Holding.AXIS)
