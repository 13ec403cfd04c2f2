"""The machine in Pinocchio (C++, recursive algorithms of Featherstone), in double precision.

Fixed frames become operational frames and their bodies are welded to the joint that carries them. Pinocchio wants
the joints in depth-first order; results come back in table order. Springs and friction are added outside;
wrenches go in as external forces. A moving base is a free-flyer whose motion is given. Pinocchio's forces and
motions are linear part first too, in the frame of the joint; its accelerations of the free-flyer are spatial ones
(a - w x v). Callers do `pytest.importorskip("pinocchio")`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin  # type: ignore[import-untyped, unused-ignore]

from symoro_elastic.machine.machine import Kind, Machine
from tests.references.numbers_of_machine import Array, BodyNumbers, JointNumbers, MachineNumbers, Values, numbers_of

Numbers = Sequence[float] | Array


@dataclass(frozen=True)
class _Built:
    """`order[k]` is the index in Pinocchio's velocity of entry k of q; `root` its number of base coordinates.

    `carriers[j]` and `places[j]`: the Pinocchio joint that carries frame j and where.
    """

    numbers: MachineNumbers
    model: Any
    data: Any
    order: list[int]
    carriers: list[int]
    places: list[Any]
    root: int


def direct_dynamics(machine: Machine, q: Numbers, qd: Numbers, tau: Numbers, values: Values | None = None) -> Array:
    """qdd, n entries: the articulated-body algorithm `aba`; with a moving base `crba` and a solution."""
    built = _build(machine, values)
    forces = _joint_forces(built, np.asarray(q), np.asarray(qd))
    forces[built.numbers.motors] += tau
    if built.root:
        return np.linalg.solve(_inertia_matrix(built, q), forces - _bias_forces(built, q, qd, friction=False))
    acceleration = pin.aba(
        built.model, built.data, _put(built, q), _put(built, qd), _put(built, forces), _external_forces(built)
    )
    return np.array(acceleration[built.order])


def inverse_dynamics(
    machine: Machine, q: Numbers, qd: Numbers, qdd_motor: Numbers, values: Values | None = None
) -> tuple[Array, Array]:
    """(tau of the motors, qdd of all joints) by the partition [11] of `crba` and `rnea`."""
    built = _build(machine, values)
    inertia, bias = _inertia_matrix(built, q), _bias_forces(built, q, qd, friction=False)
    forces = _joint_forces(built, np.asarray(q), np.asarray(qd))
    rigid, soft = built.numbers.motors, built.numbers.among_moving(Kind.ELASTIC, Kind.PASSIVE)
    qdd = np.zeros(len(forces))
    qdd[rigid] = qdd_motor
    qdd[soft] = np.linalg.solve(inertia[np.ix_(soft, soft)], (forces - bias - inertia @ qdd)[soft])
    return (inertia @ qdd + bias - forces)[rigid], qdd


def inertia_matrix(machine: Machine, q: Numbers, values: Values | None = None) -> Array:
    """A(q), n x n: `crba`, rotor inertias as armature."""
    return _inertia_matrix(_build(machine, values), q)


def bias_forces(machine: Machine, q: Numbers, qd: Numbers, values: Values | None = None) -> Array:
    """H(q, qd): `rnea` without acceleration, and friction."""
    return _bias_forces(_build(machine, values), q, qd, friction=True)


def frames(machine: Machine, q: Numbers, values: Values | None = None) -> Array:
    """0Tj of every frame in table order: (frames, 4, 4)."""
    built = _build(machine, values)
    pin.forwardKinematics(built.model, built.data, _put(built, q, position=True))
    placed = zip(built.carriers, built.places, strict=True)
    return np.array([(built.data.oMi[carrier] * place).homogeneous for carrier, place in placed])


def model_of(machine: Machine, values: Values | None = None) -> tuple[Any, list[int], MachineNumbers]:
    """Pinocchio's model, the index in its velocity of each entry of q, and the numbers it was made of."""
    built = _build(machine, values)
    return built.model, built.order, built.numbers


def carried_frame(machine: Machine, j: int) -> tuple[int, Any]:
    """The joint of Pinocchio that carries frame j (numbers from 1), and where."""
    return _carried(_build(machine, None), j)


def _carried(built: _Built, j: int) -> tuple[int, Any]:
    return built.carriers[j - 1], built.places[j - 1]


@dataclass(frozen=True)
class BaseState:
    """How a floating base is turned (to the world), its velocity and acceleration in its own axes, linear part first.

    The acceleration is that of the origin, as everywhere in the project.
    """

    rotation: Array
    velocity: Array
    acceleration: Array

    @property
    def spatial(self) -> Array:
        """The acceleration as Pinocchio wants it: a - w x v."""
        return self.acceleration - np.append(np.cross(self.velocity[3:], self.velocity[:3]), np.zeros(3))


def floating_dynamics(
    machine: Machine, base: BaseState, q: Numbers, qd: Numbers, qdd: Numbers
) -> tuple[Array, Array, Array]:
    """On a floating base: forces of base and joints by `rnea`, A by `crba`, accelerations that `aba` finds for these.

    Base first; friction and springs are left out.
    """
    built = _build(machine, None)
    place = [0.0, 0, 0, *pin.Quaternion(base.rotation).coeffs()]
    position, rows = _put(built, q, position=True), [*range(6), *built.order]
    position[:7] = place
    velocity, acceleration = _put(built, qd), _put(built, qdd)
    velocity[:6], acceleration[:6] = base.velocity, base.spatial
    model, data, wrenches = built.model, built.data, _external_forces(built)
    forces = np.array(pin.rnea(model, data, position, velocity, acceleration, wrenches))
    pin.crba(model, data, position)
    A = np.triu(data.M) + np.triu(data.M, 1).T
    found = np.array(pin.aba(model, data, position, velocity, forces, wrenches))[rows]
    found[:3] += np.cross(base.velocity[3:], base.velocity[:3])
    return forces[rows], A[np.ix_(rows, rows)], found


def _inertia_matrix(built: _Built, q: Numbers) -> Array:
    pin.crba(built.model, built.data, _put(built, q, position=True))
    matrix = np.triu(built.data.M) + np.triu(built.data.M, 1).T
    return np.array(matrix[np.ix_(built.order, built.order)])


def _bias_forces(built: _Built, q: Numbers, qd: Numbers, *, friction: bool) -> Array:
    base = built.numbers.base
    velocity, acceleration = _put(built, qd), np.zeros(built.model.nv)
    if built.root:
        velocity[:6] = [*base.velocity, *base.angular_velocity]
        acceleration[:6] = [
            *(base.acceleration - np.cross(base.angular_velocity, base.velocity)),
            *base.angular_acceleration,
        ]
    position = _put(built, q, position=True)
    forces = pin.rnea(built.model, built.data, position, velocity, acceleration, _external_forces(built))
    return np.array(forces[built.order]) + (_friction(built, np.asarray(qd)) if friction else 0.0)


def _joint_forces(built: _Built, q: Array, qd: Array) -> Array:
    """Springs [9] and friction: what acts on the joints besides the motors."""
    forces = -_friction(built, qd)
    for k in built.numbers.among_moving(Kind.ELASTIC):
        joint = built.numbers.joints[built.numbers.moving[k]]
        forces[k] -= joint.stiffness * (q[k] - joint.neutral) + joint.damping * qd[k]
    return forces


def _friction(built: _Built, qd: Array) -> Array:
    rows = [built.numbers.joints[j] for j in built.numbers.moving]
    return np.array([row.friction(rate) for row, rate in zip(rows, qd, strict=True)])


def _external_forces(built: _Built) -> Any:
    """Wrenches on the bodies, hence minus those that the bodies exert, moved to the joints that carry them."""
    forces = pin.StdVec_Force()
    forces.extend([pin.Force.Zero() for _ in range(built.model.njoints)])
    for joint, carrier, place in zip(built.numbers.joints, built.carriers, built.places, strict=True):
        forces[carrier] -= place.act(pin.Force(joint.force, joint.moment))
    return forces


def _put(built: _Built, entries: Numbers, *, position: bool = False) -> Array:
    """Entries of q, in table order, as a vector of Pinocchio's; a free-flyer at rest in frame 0."""
    vector = pin.neutral(built.model) if position else np.zeros(built.model.nv)
    shift = built.model.nq - built.model.nv if position else 0
    vector[[k + shift for k in built.order]] = entries
    return vector


def _build(machine: Machine, values: Values | None) -> _Built:
    numbers = numbers_of(machine, values=values)
    model = pin.Model()
    model.gravity = pin.Motion(numbers.base.gravity, np.zeros(3))
    base = numbers.base
    motion = (base.velocity, base.angular_velocity, base.acceleration, base.angular_acceleration)
    moving_base = any(np.any(part) for part in motion) or numbers.floating is not None
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "base") if moving_base else 0
    if numbers.floating:
        model.appendBodyToJoint(root, _inertia(numbers.floating), pin.SE3.Identity())
    carriers, places = [root] * len(numbers.joints), [pin.SE3.Identity()] * len(numbers.joints)

    def add(j: int) -> None:
        joint = numbers.joints[j]
        before = joint.antecedent - 1
        carrier, place = (carriers[before], places[before]) if joint.antecedent else (root, pin.SE3.Identity())
        place = place * _placement(joint)
        if joint.sigma != 2:
            moving = pin.JointModelPZ() if joint.sigma == 1 else pin.JointModelRZ()
            carrier, place = model.addJoint(carrier, moving, place, f"row {j + 1}"), pin.SE3.Identity()
        carriers[j], places[j] = carrier, place
        model.appendBodyToJoint(carrier, _inertia(joint.body), place)
        for child, row in enumerate(numbers.joints):
            if row.antecedent == j + 1:
                add(child)

    for j, row in enumerate(numbers.joints):
        if not row.antecedent:
            add(j)
    order = [model.joints[carriers[j]].idx_v for j in numbers.moving]
    armature = np.zeros(model.nv)
    armature[order] = [numbers.joints[j].rotor_inertia for j in numbers.moving]
    model.armature = armature
    return _Built(numbers, model, model.createData(), order, carriers, places, 6 if moving_base else 0)


def _placement(joint: JointNumbers) -> Any:
    """[1] at q = 0: Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r)."""
    x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    screws = ((joint.gamma, joint.b, z), (joint.alpha, joint.d, x), (joint.theta, joint.r, z))
    place = pin.SE3.Identity()
    for angle, shift, axis in screws:
        place = place * pin.SE3(pin.AngleAxis(angle, axis).matrix(), shift * axis)
    return place


def _inertia(body: BodyNumbers) -> Any:
    """Pinocchio holds the mass, the centre of mass and the inertia about it."""
    if not body.mass:
        if np.any(body.first_moment):
            raise ValueError("Pinocchio cannot hold first moments without mass")
        return pin.Inertia(0.0, np.zeros(3), body.inertia)
    centre = body.first_moment / body.mass
    central = body.inertia - body.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return pin.Inertia(body.mass, centre, central)


def constraint_dynamics(
    machine: Machine, met: Sequence[tuple[int, int]], q: Numbers, qd: Numbers, forces: Numbers
) -> Array:
    """qdd of a tree under forces on its joints, the origins of pairs of frames (numbers from 1) kept together.

    Multipliers found by proximal steps to 1e-14; planar loops have one row too many, which the steps bear.
    """
    built = _build(machine, None)
    constraints = pin.StdVec_RigidConstraintModel()
    for pair in met:
        (one, place), (other, end) = (_carried(built, j) for j in pair)
        constraints.append(pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, built.model, one, place, other, end))
    data = pin.StdVec_RigidConstraintData()
    data.extend([constraint.createData() for constraint in constraints])
    settings = pin.ProximalSettings(1e-14, 1e-10, 1000)
    model, state = built.model, built.data
    try:
        pin.initConstraintDynamics(model, state, constraints, data)
    except TypeError:  # before Pinocchio 4
        pin.initConstraintDynamics(model, state, constraints)
    position, velocity, given = _put(built, q, position=True), _put(built, qd), _put(built, forces)
    rest, scratch = np.zeros(model.nv), model.createData()
    for sign, wrenches in ((1, ()), (-1, (_external_forces(built),))):
        given += sign * pin.rnea(model, scratch, position, rest, rest, *wrenches)
    found = pin.constraintDynamics(model, state, position, velocity, given, constraints, data, settings)
    return np.array(found[built.order])


class FreeFlyer:
    """Accelerations of a machine on a floating base, springs and dampers included; built once for many states."""

    def __init__(self, machine: Machine) -> None:
        self._built = _build(machine, None)
        self.rows = [*range(6), *self._built.order]

    def equations(self, base: BaseState, q: Numbers, qd: Numbers) -> tuple[Array, Array]:
        """A by `crba`, and what A (V0d, qdd) is where the base and the motors push with nothing; base first."""
        built, model, data = self._built, self._built.model, self._built.data
        position, velocity = _put(built, q, position=True), _put(built, qd)
        position[:7] = [0.0, 0, 0, *pin.Quaternion(base.rotation).coeffs()]
        velocity[:6] = base.velocity
        still = np.zeros(model.nv)
        still[:6] = BaseState(base.rotation, base.velocity, np.zeros(6)).spatial
        bias = np.array(pin.rnea(model, data, position, velocity, still, _external_forces(built)))[self.rows]
        pin.crba(model, data, position)
        A = np.triu(data.M) + np.triu(data.M, 1).T
        passive = np.concatenate([np.zeros(6), _joint_forces(built, np.asarray(q), np.asarray(qd))])
        return A[np.ix_(self.rows, self.rows)], passive - bias

    def momentum(self, rotation: Array, position: Array, velocity: Array, q: Numbers, qd: Numbers) -> Array:
        """Linear momentum, and the angular one about the centre of mass, in axes of the world."""
        built = self._built
        place, speed = _put(built, q, position=True), _put(built, qd)
        place[:7] = [*position, *pin.Quaternion(rotation).coeffs()]
        speed[:6] = velocity
        found = pin.computeCentroidalMomentum(built.model, built.data, place, speed)
        return np.array([*found.linear, *found.angular])
