"""Robots in MJCF, the format of MuJoCo: bodies, joints, springs, actuators and equality constraints.

A joint's position is MuJoCo's `qpos`, its `ref` included. Several joints on a body have links without mass between
them; the frame of a link has the axes of its body, and its origin on the axis of its last joint.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.robots.axis_frames import Axis, frame_on
from symoro_elastic.formats.robots.mjcf_bodies import WORLD, Bodies, Freedom
from symoro_elastic.formats.robots.mjcf_model import Compiled, mujoco_model
from symoro_elastic.formats.robots.robot import (
    LARGEST,
    SPRING_OF_FOLLOWER,
    Connection,
    Description,
    Holding,
    JointType,
    Link,
    LinkJoint,
    Mimicked,
    PlacedFrame,
    Placement,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import BodyShape
from symoro_elastic.machine.limits import JointLimits, range_of
from symoro_elastic.machine.names import distinct, list_of_names, quote
from symoro_elastic.quantities.frames import JOINT, LINK, SITE

CONNECT, WELD, FOLLOWING = "mjEQ_CONNECT", "mjEQ_WELD", "mjEQ_JOINT"
SHOWN_GROUPS = (0, 1, 2)
"""Those that the viewer shows at first: shapes of contacts are in others where they are not to be seen."""
ON_JOINTS = ("mjTRN_JOINT", "mjTRN_JOINTINPARENT")


def describe(text: str, source: str) -> Description:
    """Read the robot in an MJCF text; raises `InputError`, one line that names the body, the joint or the line."""
    return _Robot(mujoco_model(text, source)).description


@dataclass(frozen=True, eq=False)
class _Robot:
    """Conversion of a compiled MuJoCo model to a robot description."""

    compiled: Compiled

    @cached_property
    def description(self) -> Description:
        """Description of the robot."""
        parts = [part for b in self.bodies.modelled for part in self._chain(b)]
        model, gravity = self.bodies.model, not self.forces.off("GRAVITY")
        x, y, z = (float(g) * gravity for g in model.opt.gravity)
        return Description(
            name=name_of(self.compiled.name) if self.compiled.name else name_of_file(self.compiled.source),
            links=(Link(WORLD, shapes=self.shapes.get(WORLD, ())), *(link for link, _ in parts)),
            joints=tuple(joint for _, joint in parts),
            connections=tuple(self._at_assembly(connection) for connection in self.equalities.connections),
            gravity=(x, y, z),
            remarks=tuple(_remarks(self.bodies, self.forces, self.equalities)),
            frames=tuple(self._frames()),
        )

    def _frames(self) -> Iterator[PlacedFrame]:
        """The frames of bodies, of joints (on their anchors), and of sites."""
        model = self.bodies.model
        for b in self.bodies.modelled:
            yield PlacedFrame(self.bodies.names[b], LINK, self.bodies.names[b], self.bodies.on_link(b))
            after = {freedom.number: self._link_after(b, freedom) for freedom in self.bodies.freedoms(b)}
            yield from (PlacedFrame(self.bodies.joint_names[j], JOINT, link) for j, link in after.items())
        for b in range(1, model.nbody):
            on = None if b in self.bodies.modelled else self.bodies.place(b)
            if on and model.body(b).name:
                yield PlacedFrame(model.body(b).name, LINK, *on)
        for s in range(model.nsite):
            on = self.bodies.place(int(model.site_bodyid[s]))
            if on and model.site(s).name:
                at = Placement(self.bodies.rotation(model.site_quat[s]), model.site_pos[s].copy())
                yield PlacedFrame(model.site(s).name, SITE, on[0], on[1] * at)

    @cached_property
    def bodies(self) -> Bodies:
        """The bodies of the robot."""
        return Bodies(self.compiled)

    @cached_property
    def forces(self) -> Forces:
        """Forces on the joints of the model."""
        return replace(self.equalities.forces, tendons=self.equalities.tendons)

    @cached_property
    def shapes(self) -> dict[str, tuple[BodyShape, ...]]:
        """Shapes of the links."""
        return shapes_by_link(self.bodies)

    @cached_property
    def equalities(self) -> Equalities:
        """Equality constraints of the model."""
        return Equalities(self.bodies, Forces(self.bodies))

    def _chain(self, b: int) -> Iterator[tuple[Link, LinkJoint]]:
        """Links of a body with the joints that carry them; intermediate links are massless, the last has the mass."""
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
            name = self._link_after(b, freedom)
            link = self._link(b) if name == self.bodies.names[b] else Link(name, frame_only=False)
            yield link, self._joint(freedom, parent, name, at)
            parent, at, before = link.name, Placement(), freedom.anchor

    def _link(self, b: int) -> Link:
        """Link with mass and inertia of a body; without them for a body fixed to the world."""
        model = self.bodies.model
        name = self.bodies.names[b]
        shapes = self.shapes.get(name, ())
        if model.body_weldid[b] == 0:
            return Link(name, shapes=shapes)
        principal = self.bodies.rotation(model.body_iquat[b])
        center = self.bodies.on_link(b).translation + model.body_ipos[b]
        inertia = principal * model.body_inertia[b] @ principal.T
        return Link(name, float(model.body_mass[b]), center, inertia, frame_only=False, shapes=shapes)

    def _link_after(self, b: int, freedom: Freedom) -> str:
        """Link carried by a freedom of a body: the body's for its last freedom, else a massless link."""
        is_last = freedom.name == self.bodies.freedoms(b)[-1].name
        return self.bodies.names[b] if is_last else distinct(f"{freedom.name}_link", self.bodies.names)

    def _joint(self, freedom: Freedom, parent: str, child: str, at: Placement) -> LinkJoint:
        """Joint of a freedom, with its position zero such that the reference position gives the file's placement."""
        forces = self.forces.on(freedom)
        if freedom.type is JointType.FLOATING:
            return LinkJoint(freedom.name, freedom.type, parent, child, at, damping=forces["damping"])
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

    def _at_assembly(self, connection: Connection) -> Connection:
        """Return the connection with the joint positions at which the file assembles it."""
        positions = {f.name: f.reference for b in self.bodies.modelled for f in self.bodies.freedoms(b)}
        return replace(connection, start=positions)


def name_of_file(source: str) -> str:
    """Machine name from the name of its file, for a file that states none."""
    return name_of(source.replace("\\", "/").rpartition("/")[2].rpartition(".")[0])


OF_TENDONS = ("stiffness", "damping", "frictionloss", "armature", "limited")


def _remarks(bodies: Bodies, forces: Forces, equalities: Equalities) -> Iterator[str]:
    """Yield remarks on omitted contents of a file, and on contents with another interpretation."""
    model = bodies.model
    if bodies.objects:
        yield f"free bodies besides the robot are ignored: {list_of_names(bodies.names[b] for b in bodies.objects)}"
    balls = [
        bodies.joint_names[j]
        for j in range(model.njnt)
        if bodies.type_of(j) is None and model.jnt_bodyid[j] in bodies.modelled
    ]
    if balls:
        what = "ball joints are turns about x, y and z, singular where the second is at a right angle"
        yield f"{what}: {list_of_names(balls)}"
    if not model.nu:
        yield "the file has no actuators: joints without springs are taken as driven"
    elif any(map(forces.is_more_than_torque, range(model.nu))):
        yield "torques act on the joints: gears and control laws of actuators are ignored"
    driving = {a for gears in forces.tendons.values() for a, _ in gears}
    if elsewhere := [a for a in forces.elsewhere if a not in driving]:
        names = (model.actuator(a).name or f"actuator {a + 1}" for a in elsewhere)
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
    """Forces in the file that are not modelled."""
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
    """The active equality constraints of a model."""

    bodies: Bodies
    forces: Forces

    @cached_property
    def followers(self) -> dict[int, Mimicked | float]:
        """By joint number: the law of a following joint, or its fixed position, rad or m."""
        followers: dict[int, Mimicked | float] = {}
        for e in self._of(FOLLOWING):
            first, second = int(self._model.eq_obj1id[e]), int(self._model.eq_obj2id[e])
            law = self._law(e, first, second)
            # Of a linear law the joint with the motor or the spring leads.
            if second >= 0 and law.degree() == 1 and [*map(self.forces.acts_on, (first, second))] == [True, False]:
                first, second = second, first
                law = Polynomial([-law.coef[0] / law.coef[1], 1 / law.coef[1]])
            if first in followers:
                what = f"equality constraints {quote(self.name(e))} and others determine its position: keep one"
                raise self.bodies.compiled.error(f"joint {quote(self.bodies.joint_names[first])}", what)
            followers[first] = self._following(first, second, law)
        return followers

    @cached_property
    def tendons(self) -> dict[int, list[tuple[int, float]]]:
        """By joint number: actuators with gears on fixed tendons of the joint and of its followers."""
        by_joint: dict[int, list[tuple[int, float]]] = {}
        for a, gears in self.forces.on_tendons.items():
            moved = [(self._leader(j), gear) for j, gear in gears.items()]
            leaders = {leader for (leader, _), _ in moved}
            if len(leaders) == 1 and (leader := leaders.pop()) is not None:
                by_joint.setdefault(leader, []).append((a, sum(slope * gear for (_, slope), gear in moved)))
        return by_joint

    def _leader(self, j: int) -> tuple[int | None, float]:
        """Independent joint that a joint follows, and the ratio; None if the ratio is not constant."""
        slope = 1.0
        while j in self.followers:
            law = self.followers[j]
            if not isinstance(law, Mimicked) or any(law.powers):
                return None, 0.0
            j, slope = self.bodies.joint_names.index(law.joint), slope * law.multiplier
        return j, slope

    @cached_property
    def connections(self) -> tuple[Connection, ...]:
        """Connections between bodies of the robot, or to the world."""
        return with_hinges([connection for e in self._of(CONNECT, WELD) if (connection := self._connection(e))])

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Names of omitted constraints: on tendons, on omitted bodies, and disabled ones."""
        modelled = set(self._of(FOLLOWING)) | {e for e in self._of(CONNECT, WELD) if self._connection(e)}
        return tuple(self.name(e) for e in range(self._model.neq) if e not in modelled)

    def name(self, e: int) -> str:
        """Name of a constraint, or its type and number if it has none in the file."""
        names = [self._model.equality(k).name for k in range(self._model.neq)]
        return names[e] or f"{self._type(e).removeprefix('mjEQ_').lower()}{e + 1}"

    @property
    def _model(self) -> Any:
        return self.bodies.model

    def _type(self, e: int) -> str:
        name: str = self.bodies.compiled.mujoco.mjtEq(self._model.eq_type[e]).name
        return name

    def _of(self, *types: str) -> Iterator[int]:
        """Numbers of the active constraints of some types."""
        if not self.forces.off("EQUALITY") and not self.forces.off("CONSTRAINT"):
            yield from (e for e in range(self._model.neq) if self._type(e) in types and self._model.eq_active0[e])

    def _law(self, e: int, first: int, second: int) -> Polynomial:
        """Position of the first joint as a polynomial of the second joint's position."""
        own, other = (float(self._model.qpos0[self._model.jnt_qposadr[j]]) if j >= 0 else 0.0 for j in (first, second))
        coefficients = self._model.eq_data[e][: 5 if second >= 0 else 1]
        law: Polynomial = Polynomial(coefficients)(Polynomial([-other, 1.0])) + own
        return law.trim()

    def _following(self, first: int, second: int, law: Polynomial) -> Mimicked | float:
        name = self.bodies.joint_names[first]
        if self._model.jnt_stiffness[first] > 0 and not self.forces.off("SPRING"):
            raise self.bodies.compiled.error(f"joint {quote(name)}", SPRING_OF_FOLLOWER)
        if second < 0 or law.degree() == 0:
            return float(law.coef[0])
        offset, multiplier, *powers = map(float, law.coef)
        return Mimicked(self.bodies.joint_names[second], multiplier, offset, tuple(powers))

    def _connection(self, e: int) -> Connection | None:
        """Connection of two links by a constraint; None for an omitted body, or within one link."""
        ends = self._ends(e)
        if ends is None or ends[0][0] == ends[1][0]:
            return None
        (first, on_first), (second, on_second) = ends
        holding = Holding.FRAME if self._type(e) == WELD else Holding.POINT
        return Connection(self.name(e), first, second, on_first, on_second, holding)

    def _ends(self, e: int) -> tuple[tuple[str, Placement], tuple[str, Placement]] | None:
        """The two coinciding frames of a constraint, each as a link and the frame's placement in it."""
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
    """Return the connections, with two point connections between the same links replaced by a hinge."""
    pairs: dict[tuple[str, str], list[Connection]] = {}
    for connection in connections:
        if connection.holding is Holding.POINT:
            pairs.setdefault((connection.first, connection.second), []).append(connection)
    hinges = {id(pair[0]): hinge for pair in pairs.values() if len(pair) == 2 and (hinge := _hinge(*pair))}
    seconds = {id(pair[1]) for pair in pairs.values() if id(pair[0]) in hinges}
    return tuple(hinges.get(id(connection), connection) for connection in connections if id(connection) not in seconds)


def _hinge(connection: Connection, other: Connection) -> Connection | None:
    """The hinge through the points of two connections; None if their distances on both links differ."""
    ends = (connection.on_first, other.on_first), (connection.on_second, other.on_second)
    axes = [b.translation - a.translation for a, b in ends]
    lengths = [float(np.linalg.norm(axis)) for axis in axes]
    if not min(lengths) or abs(lengths[0] - lengths[1]) > SAME_LENGTH * max(lengths):
        return None
    lines = [Axis(a.translation, axis / length) for (a, _), axis, length in zip(ends, axes, lengths, strict=True)]
    first, second = (frame_on(line, a, None) for line, (a, _) in zip(lines, ends, strict=True))
    return replace(connection, on_first=first, on_second=second, holding=Holding.AXIS)


def shapes_by_link(bodies: Bodies) -> dict[str, tuple[BodyShape, ...]]:
    """Return the shapes of links, by link name."""
    shapes_of_link: dict[str, tuple[BodyShape, ...]] = {}
    model = bodies.model
    for g in range(model.ngeom):
        place = bodies.place(int(model.geom_bodyid[g]))
        if place and model.geom_group[g] in SHOWN_GROUPS and model.geom_rgba[g][3] > 0:
            link, on_link = place
            at = on_link * _placement(bodies, model.geom_quat[g], model.geom_pos[g])
            shapes = (replace(shape, points=at.matrix @ shape.points) for shape in _shapes(bodies, g))
            shapes_of_link[link] = (*shapes_of_link.get(link, ()), *shapes)
    return shapes_of_link


def _shapes(bodies: Bodies, g: int) -> Iterator[BodyShape]:
    """The shape of a geom, in its frame: planes and fields of heights are not drawn."""
    model = bodies.model
    kind = bodies.compiled.mujoco.mjtGeom(model.geom_type[g]).name.removeprefix("mjGEOM_").lower()
    x, y, z = (float(size) for size in model.geom_size[g])
    mesh = bodies.compiled.meshes.get(g)
    if mesh is not None:
        yield mesh if kind != "mesh" else replace(mesh, points=_from_inertial(bodies, g) @ mesh.points)
    elif kind in ("box", "ellipsoid"):
        yield BodyShape(np.diag([x, y, z, 1.0]), solid=kind)
    elif kind == "sphere":
        yield BodyShape(np.diag([x, x, x, 1.0]), solid="ellipsoid")
    elif kind == "cylinder":
        yield BodyShape(np.diag([x, x, y, 1.0]), solid=kind)
    elif kind == "capsule" and x > 0:
        yield BodyShape(np.diag([x, x, x, 1.0]), solid=kind, straight=y / x)


def _from_inertial(bodies: Bodies, g: int) -> Array:
    """The placement that maps a mesh's points from MuJoCo's inertial frame to the frame of their file."""
    mesh = bodies.model.geom_dataid[g]
    return _placement(bodies, bodies.model.mesh_quat[mesh], bodies.model.mesh_pos[mesh]).inverse.matrix


def _placement(bodies: Bodies, quaternion: Array, position: Array) -> Placement:
    return Placement(bodies.rotation(quaternion), np.array(position))


@dataclass(frozen=True, eq=False)
class Forces:
    """Forces on the joints of a model; `tendons` are actuators with gears, acting on a joint by fixed tendons."""

    bodies: Bodies
    tendons: Mapping[int, Sequence[tuple[int, float]]] = field(default_factory=dict)

    def on(self, freedom: Freedom) -> dict[str, Any]:
        """The forces on a joint that turns or slides, as fields of its `LinkJoint`; raises `InputError`.

        Inertia and damping of actuators are as the joint feels them: times the square of the gear.
        """
        model, j = self.bodies.model, freedom.number
        if reason := next(self._faults(freedom), None):
            raise self.bodies.compiled.error(f"joint {quote(self.bodies.joint_names[j])}", reason)
        v, gears, damped = model.jnt_dofadr[j], self.gears(j), not self.off("DAMPER")
        damping = damped * float(model.dof_damping[v])
        if freedom.type is JointType.FLOATING:
            return {"driven": False, "damping": damping}
        if self._is_ball(freedom):
            return {"driven": False, "ball": damping * freedom.name.rstrip("_").endswith("_z")}
        stiffness = 0.0 if self.off("SPRING") else float(model.jnt_stiffness[j])
        damping += damped * sum(gear**2 * float(model.actuator_damping[a]) for a, gear in gears)
        return {
            "stiffness": stiffness,
            "neutral": float(model.qpos_spring[model.jnt_qposadr[j]]) if stiffness else 0.0,
            "damping": damping,
            "friction": 0.0 if self.off("FRICTIONLOSS") or self.off("CONSTRAINT") else float(model.dof_frictionloss[v]),
            "rotor_inertia": float(model.dof_armature[v] + sum(g**2 * model.actuator_armature[a] for a, g in gears)),
            "driven": bool(gears) or (not model.nu and not stiffness),
        }

    def gears(self, j: int) -> list[tuple[int, float]]:
        """Actuators that drive a joint, with the ratio of actuator speed to joint speed."""
        own = [(a, float(self.bodies.model.actuator_gear[a][0])) for a in self.actuators.get(j, ())]
        return [*own, *self.tendons.get(j, ())]

    def limits(self, freedom: Freedom) -> JointLimits:
        """Limits of a revolute or prismatic joint: its position, and the total torque of its actuators."""
        if self._is_ball(freedom) or freedom.type is JointType.FLOATING:
            return JointLimits()
        model, j = self.bodies.model, freedom.number
        torques = [self._torques(a, gear) for a, gear in self.gears(j)]
        low, high = sum((x for x, _ in torques), 0.0), sum((x for _, x in torques), 0.0)
        if model.jnt_actfrclimited[j]:
            least, most = map(float, model.jnt_actfrcrange[j])
            low, high = max(low, least), min(high, most)
        least, most = map(float, model.jnt_range[j])
        position = range_of(least, most, LARGEST) if model.jnt_limited[j] and not self.off("LIMIT") else None
        return JointLimits(position, torque=range_of(low, high, LARGEST) if torques else None)

    def _torques(self, a: int, gear: float) -> tuple[float, float]:
        """Return the least and largest torque, or force, of an actuator on a joint; infinite if not limited."""
        model = self.bodies.model
        low, high = -math.inf, math.inf
        if model.actuator_forcelimited[a]:
            low, high = map(float, model.actuator_forcerange[a])
        if model.actuator_ctrllimited[a] and not self._has_law(a):
            gain = float(model.actuator_gainprm[a][0])
            least, most = sorted(gain * float(x) for x in model.actuator_ctrlrange[a])
            low, high = max(low, least), min(high, most)
        first, second = (gear * x if gear else 0.0 for x in (low, high))
        return min(first, second), max(first, second)

    def _has_law(self, a: int) -> bool:
        """Whether the force of an actuator is not proportional to its control."""
        model = self.bodies.model
        return bool(model.actuator_dyntype[a] or model.actuator_gaintype[a] or model.actuator_biastype[a])

    def off(self, name: str) -> bool:
        """Return whether the options of the file disable a feature, by MuJoCo's name."""
        flag = getattr(self.bodies.compiled.mujoco.mjtDisableBit, f"mjDSBL_{name}")
        return bool(self.bodies.model.opt.disableflags & int(flag))

    @cached_property
    def actuators(self) -> dict[int, list[int]]:
        """Numbers of the actuators on each revolute or prismatic joint."""
        actuators: dict[int, list[int]] = {}
        for a in range(self.bodies.model.nu):
            if a not in self.elsewhere:
                actuators.setdefault(int(self.bodies.model.actuator_trnid[a][0]), []).append(a)
        return actuators

    @cached_property
    def on_tendons(self) -> dict[int, dict[int, float]]:
        """Ratios of actuator speed to joint speed on fixed tendons, by actuator and joint number."""
        model, mujoco = self.bodies.model, self.bodies.compiled.mujoco
        speeds: dict[int, dict[int, float]] = {}
        for a in range(model.nu):
            if mujoco.mjtTrn(model.actuator_trntype[a]).name != "mjTRN_TENDON":
                continue
            first = model.tendon_adr[t := int(model.actuator_trnid[a][0])]
            wraps = range(first, first + model.tendon_num[t])
            if all(mujoco.mjtWrap(model.wrap_type[w]).name == "mjWRAP_JOINT" for w in wraps):
                gear = float(model.actuator_gear[a][0])
                speeds[a] = {int(model.wrap_objid[w]): gear * float(model.wrap_prm[w]) for w in wraps}
        return speeds

    def acts_on(self, j: int) -> bool:
        """Whether an actuator acts on a joint, by a tendon too, or a spring."""
        driven = bool(self.actuators.get(j)) or any(j in gears for gears in self.on_tendons.values())
        return driven or self.bodies.model.jnt_stiffness[j] > 0

    @cached_property
    def elsewhere(self) -> tuple[int, ...]:
        """Numbers of the actuators that act on a tendon, a body, or a joint with several freedoms."""
        return tuple(a for a in range(self.bodies.model.nu) if not self._is_on_joint(a))

    def is_more_than_torque(self, a: int) -> bool:
        """Whether the control of an actuator differs from the torque, or force, on its joint."""
        model = self.bodies.model
        return self._has_law(a) or model.actuator_gainprm[a][0] != 1 or model.actuator_gear[a][0] != 1

    def _is_on_joint(self, a: int) -> bool:
        """Whether an actuator acts on a revolute or prismatic joint."""
        kind = self.bodies.compiled.mujoco.mjtTrn(self.bodies.model.actuator_trntype[a]).name
        simple = (JointType.REVOLUTE, JointType.PRISMATIC)
        return kind in ON_JOINTS and self.bodies.type_of(self.bodies.model.actuator_trnid[a][0]) in simple

    def _is_ball(self, freedom: Freedom) -> bool:
        return freedom.name != self.bodies.joint_names[freedom.number]

    def _faults(self, freedom: Freedom) -> Iterator[str]:
        """Properties of actuators that no machine can represent, with a remedy each."""
        model, j = self.bodies.model, freedom.number
        v = model.jnt_dofadr[j]
        several = 6 if freedom.type is JointType.FLOATING else 3 if self._is_ball(freedom) else 0
        if model.jnt_stiffnesspoly[j].any():
            yield "its stiffness is a polynomial of the deflection: only linear springs are modelled, give one number"
        if model.dof_dampingpoly[v].any() or any(
            model.actuator_dampingpoly[a].any() for a in self.actuators.get(j, [])
        ):
            yield "its damping is a polynomial of the velocity: only linear damping is modelled, give one number"
        if model.jnt_plasticadr[j] >= 0:
            yield "its spring yields: only elastic springs are modelled, remove springyield"
        if not several:
            return
        kind = "free" if several == 6 else "ball"
        numbers = {
            "stiffness": model.jnt_stiffness[j],
            "armature": model.dof_armature[v : v + several].any(),
            "frictionloss": model.dof_frictionloss[v : v + several].any(),
        }
        for key, value in numbers.items():
            if value:
                yield f"it is a {kind} joint with {key}, which is not modelled: write {key} = 0"
