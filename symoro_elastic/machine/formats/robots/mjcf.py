"""Robots in MJCF, the format of MuJoCo: bodies, joints, springs, actuators and equality constraints.

A joint's position is MuJoCo's `qpos`, its `ref` included. Several joints on a body have links without mass between
them; the frame of a link has the axes of its body, and its origin on the axis of its last joint.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.machine.formats.files import name_of
from symoro_elastic.machine.formats.robots.description import (
    Connection,
    Description,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    Placement,
)
from symoro_elastic.machine.formats.robots.mjcf_bodies import WORLD, Bodies, Freedom
from symoro_elastic.machine.formats.robots.mjcf_equalities import Equalities
from symoro_elastic.machine.formats.robots.mjcf_forces import Forces
from symoro_elastic.machine.formats.robots.mjcf_model import Compiled, compiled
from symoro_elastic.machine.formats.robots.mjcf_remarks import remarks_of
from symoro_elastic.machine.names import distinct


def describe(text: str, source: str) -> Description:
    """The robot in an MJCF text; raises `InputError`, one line that names the body, the joint or the line."""
    return _Robot(compiled(text, source)).description


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
            links=(Link(WORLD), *(link for link, _ in parts)),
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
        if model.body_weldid[b] == 0:
            return Link(self.bodies.names[b])
        principal = self.bodies.rotation(model.body_iquat[b])
        center = self.bodies.on_link(b).translation + model.body_ipos[b]
        inertia = principal * model.body_inertia[b] @ principal.T
        return Link(self.bodies.names[b], float(model.body_mass[b]), center, inertia, frame_only=False)

    def _between(self, freedom: Freedom) -> Link:
        """The link without mass that a joint carries where its body has further ones."""
        return Link(distinct(f"{freedom.name}_link", self.bodies.names), frame_only=False)

    def _joint(self, freedom: Freedom, parent: str, child: str, at: Placement) -> LinkJoint:
        """A joint, at position 0 where the reference position puts the body as the file does."""
        forces = self.forces.on(freedom)
        if freedom.type is JointType.FLOATING:
            return LinkJoint(freedom.name, freedom.type, parent, child, at)
        at = at * self._displacement(freedom, -freedom.reference)
        joint = LinkJoint(freedom.name, freedom.type, parent, child, at, freedom.axis, **forces)
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
