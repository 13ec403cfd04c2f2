"""Derivatives of Gamma(q, qd, qdd) by one recursion over composite bodies.

While joint j moves a little, all that it carries is displaced as one body. In axes of that body the
field of accelerations changes by a screw dA, and the angular velocities by a vector theta. For a
revolute joint

    by q_j:    dA = [vd x z; wd x z + w x (w x z)],   theta = w x z,
    by qd_j:   dA = [0; 2 w x z],                     theta = z,
    by qdd_j:  dA = a_j,                              theta = 0,

with V'_j = [vd; wd], in the inertial frame that moves along with the origin of frame j. The wrench on
everything beyond joint i changes by

    df_i = I_i dA + [theta x p_i; Q_i theta],

where I_i is the composite inertia, p_i twice the momentum of these bodies and Q_i theta twice the
moment of their Coriolis forces in a turn theta, in the inertial frame of the origin of frame i. The
rows of joint i meet the changes that joints before it make on their way to the base; its columns go
there as wrenches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.kinematics import Scalars, path
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import (
    EZ,
    IDENTITY,
    ZERO,
    AxialTransform,
    Axis,
    Matrix,
    RigidInertia,
    Scalar,
    Transform,
    Twist,
    Vector,
    Wrench,
    cross,
    dot,
    hat_plus_hat_squared,
    rotated_matrix,
)

Entries = dict[tuple[int, int], Scalar]
"""Entries of a matrix by the joints of row and column; those that are missing are zero."""
Steps = list[tuple[AxialTransform, Vector]]
"""The axial transforms of a link from its end to its start, each with twice the velocity that it adds."""


@dataclass(frozen=True)
class Change:
    """Change dA of the accelerations of all bodies beyond a joint, and rotation theta, for its small motion."""

    acceleration: Twist
    theta: Vector


@dataclass(frozen=True)
class Row:
    """Change of a joint's torque as a linear function of dA and theta."""

    of_acceleration: Wrench
    of_theta: Vector

    def of(self, change: Change) -> Scalar:
        """The change of torque that a motion of a joint, `change`, causes."""
        (force, moment), (linear, angular) = self.of_acceleration, change.acceleration
        return dot(force, linear) + dot(moment, angular) + dot(self.of_theta, change.theta)

    def to_antecedent(self, steps: Steps) -> Row:
        """The row in the antecedent frame."""
        wrench, of_theta = self.of_acceleration, self.of_theta
        for step, boost in steps:
            of_theta = step.rotate(of_theta + cross(boost, wrench.force))
            wrench = Transform((step,)).T * wrench
        return Row(wrench, of_theta)


@dataclass(frozen=True)
class Composite:
    """All bodies beyond a joint as one: their inertia, p and Q."""

    inertia: RigidInertia
    p: Vector
    Q: Matrix

    @classmethod
    def of_body(cls, body: RigidInertia, w: Vector) -> Composite:
        """The composite of one body at angular velocity w: p = 2 w x MS, Q = -hat(w) (tr(J) 1 - 2 J)."""
        xx, xy, xz, yy, yz, zz = body.inertia
        x = Vector(yy + zz - xx, -2 * xy, -2 * xz)
        y = Vector(-2 * xy, xx + zz - yy, -2 * yz)
        z = Vector(-2 * xz, -2 * yz, xx + yy - zz)
        return cls(body, cross(w, 2 * body.moments), Matrix(cross(x, w), cross(y, w), cross(z, w)).T)

    def __add__(self, other: Composite) -> Composite:
        return Composite(self.inertia + other.inertia, self.p + other.p, self.Q + other.Q)

    def wrench(self, change: Change) -> Wrench:
        """The wrench df that a change of motion requires on the composite body."""
        force, moment = self.inertia.spatial * change.acceleration
        return Wrench(force + cross(change.theta, self.p), moment + self.Q * change.theta)

    def row(self, axis: Axis) -> Row:
        """The component a^T df along a joint axis as a linear function of the change of motion."""
        of_theta = self.Q.z if axis is Axis.REVOLUTE else cross(self.p, EZ)
        return Row(self.inertia.spatial * axis, of_theta)

    def to_antecedent(self, steps: Steps) -> Composite:
        """The composite body, described in the antecedent frame."""
        inertia, p, Q = self.inertia, self.p, self.Q
        for step, boost in steps:
            Q = Q + _swept(inertia.moments, boost)
            p = p + inertia.mass * boost
            Q = rotated_matrix(step, Q + _swept(step.along, p))
            inertia, p = inertia.to_antecedent(Transform((step,))), step.rotate(p)
        return Composite(inertia, p, Q)


@dataclass(frozen=True)
class TorqueDerivatives:
    """Derivatives of Gamma by q, qd and qdd (the inertia matrix), with their intermediate quantities, by joint.

    `rows` and `columns` belong to (joint j, link i on the path to it) and are taken at link i; a column
    holds the wrenches by q_j and by qd_j. Link 0 is a base that is part of the machine.
    """

    by_q: Entries
    by_qd: Entries
    by_qdd: Entries
    composites: dict[int, Composite]
    moved: dict[int, Change]
    sped: dict[int, Change]
    rows: dict[tuple[int, int], Row]
    columns: dict[tuple[int, int], tuple[Wrench, Wrench]]


def torque_derivatives(mechanism: Mechanism, qd: Scalars, found: Dynamics) -> TorqueDerivatives:
    """Derivatives of the torques of all joints, without friction and springs, at the motion `found`.

    Units N m/rad, N m s/rad, kg m2, or with m and N.
    """
    partials = _bodies(mechanism, found.w)
    _add_changes(mechanism, found, partials)
    for j in _added_rows(mechanism, qd, found.w, partials):
        _add_columns(mechanism, j, found.f[j], partials)
    return partials


def by_accelerations(mechanism: Mechanism, qd: Scalars, w: Sequence[Vector]) -> TorqueDerivatives:
    """The part of the derivatives that needs no accelerations: composite bodies, rows, and the inertia matrix."""
    partials = _bodies(mechanism, w)
    for _ in _added_rows(mechanism, qd, w, partials):
        pass
    return partials


def add_motion(mechanism: Mechanism, found: Dynamics, made: TorqueDerivatives) -> None:
    """Add the part that accelerations determine: changes, columns, derivatives by q and qd."""
    _add_changes(mechanism, found, made)
    for j in (j for j, _ in mechanism.from_tips() if j in made.moved):
        for i in reversed(path(mechanism, j)):
            _add_by_row(j, i, made)
        _add_columns(mechanism, j, found.f[j], made)


def _bodies(mechanism: Mechanism, w: Sequence[Vector]) -> TorqueDerivatives:
    """Bodies that do not carry others yet."""
    bodies = {j: Composite.of_body(link.body, w[j]) for j, link in mechanism.from_base()}
    if mechanism.body is not None:
        bodies[0] = Composite.of_body(mechanism.body, w[0])
    return TorqueDerivatives({}, {}, {}, bodies, {}, {}, {}, {})


def _add_changes(mechanism: Mechanism, found: Dynamics, made: TorqueDerivatives) -> None:
    for j, link in mechanism.from_base():
        if link.axis is not Axis.NONE:
            made.moved[j], made.sped[j] = _changes(link.axis, j, found)


def _added_rows(mechanism: Mechanism, qd: Scalars, w: Sequence[Vector], made: TorqueDerivatives) -> Iterator[int]:
    """Yield joints from the tips to the base, after their composite body and row are computed."""
    steps = {j: _steps(link, w[link.antecedent], qd[j]) for j, link in mechanism.from_base()}
    for j, link in mechanism.from_tips():
        if link.antecedent in made.composites:
            made.composites[link.antecedent] += made.composites[j].to_antecedent(steps[j])
        if link.axis is not Axis.NONE:
            _add_row(mechanism, j, steps, made)
            made.by_qdd[j, j] = made.by_qdd[j, j] + link.rotor_inertia
            yield j


def _changes(axis: Axis, j: int, found: Dynamics) -> tuple[Change, Change]:
    """Changes by q_j and by qd_j."""
    w, U = found.w[j], found.U.get(j) or hat_plus_hat_squared(found.w[j], found.wd[j])
    tilt, U_z = cross(w, EZ), U.T.z
    twice = tilt + tilt
    if axis is Axis.PRISMATIC:
        return Change(Twist(U_z, ZERO), ZERO), Change(Twist(twice, ZERO), ZERO)
    return Change(Twist(cross(found.vd[j], EZ), U_z), tilt), Change(Twist(ZERO, twice), EZ)


def _steps(link: Link, w: Vector, qd: Scalar) -> Steps:
    """Steps to the antecedent frame, whose angular velocity is `w`."""
    steps: Steps = []
    for step in link.transform.steps:
        w = step.rotate_back(w)
        steps.append((step, cross(w, 2 * step.along)))
    step, boost = steps.pop()
    return [(step, boost + (2 * qd * link.axis).linear), *reversed(steps)]


def _add_row(mechanism: Mechanism, j: int, steps: dict[int, Steps], made: TorqueDerivatives) -> None:
    """Add the row of joint j at each link on its path, and its derivatives by the accelerations of their joints."""
    row = made.composites[j].row(mechanism.link(j).axis)
    for i in reversed(path(mechanism, j)):
        made.rows[j, i] = row
        _add_by_row(j, i, made)
        if mechanism.link(i).axis is not Axis.NONE:
            made.by_qdd[j, i] = made.by_qdd[i, j] = mechanism.link(i).axis.T * row.of_acceleration
        row = row.to_antecedent(steps[i])
    if 0 in made.composites:
        made.rows[j, 0] = row


def _add_by_row(j: int, i: int, made: TorqueDerivatives) -> None:
    """Add derivatives of the torque of joint j by the variables of joint i, whose changes are known."""
    if i in made.moved:
        row = made.rows[j, i]
        made.by_q[j, i], made.by_qd[j, i] = row.of(made.moved[i]), row.of(made.sped[i])


def _add_columns(mechanism: Mechanism, j: int, f: Wrench, made: TorqueDerivatives) -> None:
    """Add derivatives of the torques of joints on the path to joint j by q_j and qd_j; f_j turns with the joint."""
    turned = Wrench(cross(EZ, f.force), cross(EZ, f.moment))
    if mechanism.link(j).axis is Axis.PRISMATIC:
        turned = Wrench(ZERO, turned.force)
    lifted, by_qd = made.composites[j].wrench(made.moved[j]), made.composites[j].wrench(made.sped[j])
    by_q = lifted + turned
    for i in reversed(path(mechanism, j)):
        made.columns[j, i] = by_q, by_qd
        link = mechanism.link(i)
        if i != j and i in made.moved:
            made.by_q[i, j], made.by_qd[i, j] = link.axis.T * by_q, link.axis.T * by_qd
        by_q, by_qd = link.transform.T * by_q, link.transform.T * by_qd
    if 0 in made.composites:
        made.columns[j, 0] = by_q, by_qd


def _swept(b: Vector, a: Vector) -> Matrix:
    """The matrix of theta -> b x (theta x a)."""
    x, y, z = a.x * b.x, a.y * b.y, a.z * b.z
    return Matrix(
        Vector(y + z, -(a.x * b.y), -(a.x * b.z)),
        Vector(-(a.y * b.x), x + z, -(a.y * b.z)),
        Vector(-(a.z * b.x), -(a.z * b.y), x + y),
    )


def add_base(made: TorqueDerivatives, w: Vector) -> None:
    """Add to `made` the base, turning with `w`: rows of its wrench, columns by its velocity and acceleration."""
    composite = made.composites[0]
    sped = {m: Change(Twist(ZERO, cross(w, e)), e) for m, e in zip(DEGREES[3:], IDENTITY, strict=True)}
    for m, entries in zip(DEGREES, composite.inertia.spatial.rows, strict=True):
        made.by_qdd.update({(m, n): x for n, x in zip(DEGREES, entries, strict=True)})
    for n, change in sped.items():
        made.by_qd.update({(m, n): x for m, x in zip(DEGREES, composite.wrench(change).entries, strict=True)})
    for j in made.moved:
        row, (by_q, by_qd) = made.rows[j, 0], made.columns[j, 0]
        made.by_qd.update({(j, n): row.of(change) for n, change in sped.items()})
        for k, m in enumerate(DEGREES):
            made.by_q[m, j], made.by_qd[m, j] = by_q.entries[k], by_qd.entries[k]
            made.by_qdd[m, j] = made.by_qdd[j, m] = row.of_acceleration.entries[k]


def by_pose(by_acceleration: Entries, gravity: Vector) -> Entries:
    """Columns of a small displacement (zero) and rotation of a base with a given acceleration, from its columns."""
    columns: Entries = {}
    for n, e in zip(DEGREES[3:], IDENTITY, strict=True):
        x, y, z = cross(e, gravity)
        for i in dict.fromkeys(i for i, _ in by_acceleration):
            a, b, c = (by_acceleration.get((i, m), 0) for m in DEGREES[:3])
            columns[i, n] = x * a + y * b + z * c
    return columns


def falling_by_pose(gravity: Vector) -> Entries:
    """Columns of a small displacement (zero) and rotation for the acceleration of a base under a known wrench."""
    turned = {n: (*cross(gravity, e), 0, 0, 0) for n, e in zip(DEGREES[3:], IDENTITY, strict=True)}
    return {(m, n): x for n, column in turned.items() for m, x in zip(DEGREES, column, strict=True)}
