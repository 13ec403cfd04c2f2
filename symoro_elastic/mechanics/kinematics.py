"""Geometric and kinematic models [1]-[7]. Lists are indexed by link number; entry 0 is the base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    EZ,
    IDENTITY,
    ZERO,
    Axis,
    Matrix,
    Scalar,
    Transform,
    Twist,
    Vector,
    cross,
    hat_plus_hat_squared,
)

Scalars: TypeAlias = Sequence[Scalar]


class Frame(NamedTuple):
    """Orientation kAj and origin kPj of a frame j, expressed in a frame k."""

    rotation: Matrix
    origin: Vector

    @property
    def z(self) -> Vector:
        """The axis z_j, in frame k."""
        return self.rotation.T.z

    def child(self, link: Link) -> Frame:
        """The frame of a link whose antecedent this is: kTi iTj."""
        rotation, origin = self
        for step in link.transform.steps:
            origin = origin + step.shift * rotation.T[step.axis]
            rotation = step.rotate_rows(rotation)
        return Frame(rotation, origin)  # (1)

    def antecedent(self, link: Link) -> Frame:
        """The frame kTi of the antecedent of a link, where this is the link's frame kTj: kTj jTi."""
        rotation, origin = self
        for step in reversed(link.transform.steps):
            origin = origin - step.shift * rotation.T[step.axis]
            rotation = step.rotate_rows_back(rotation)
        return Frame(rotation, origin)  # (1)


def frames(mechanism: Mechanism, seen_from: int = 0) -> list[Frame]:
    """Every frame j expressed in frame k = `seen_from`; k = 0 gives 0Tj [2].

    Only the joints between the two frames enter.
    """
    poses = {seen_from: Frame(IDENTITY, ZERO)}
    for j in reversed(path(mechanism, seen_from)):
        link = mechanism.link(j)
        poses[link.antecedent] = poses[j].antecedent(link)
    for j, link in mechanism.from_base():
        if j not in poses:
            poses[j] = poses[link.antecedent].child(link)  # (2)
    return [poses[j] for j in range(len(mechanism.links) + 1)]


class FrameSet(NamedTuple):
    """All frames j expressed in frame k; the joint that is the anchor of each, and the vector from there to its origin.

    The anchor of frame j is the last revolute joint before it, or the base: what lies between rotates as one body.
    `levers[j]` is kPj less kP of the anchor; only joints between the two enter.
    """

    frames: list[Frame]
    anchors: list[int]
    levers: list[Vector]


def frame_set(mechanism: Mechanism, seen_from: int = 0) -> FrameSet:
    """All frames expressed in frame k = `seen_from`."""
    views = FrameSet(frames(mechanism, seen_from), [0], [ZERO])
    between = path(mechanism, seen_from)
    for j, link in mechanism.from_base():
        i = link.antecedent
        if j in between:
            lever = -Frame(views.frames[j].rotation, ZERO).antecedent(link).origin
        else:
            lever = Frame(views.frames[i].rotation, ZERO).child(link).origin
        anchored = not i or mechanism.link(i).axis is Axis.REVOLUTE
        views.anchors.append(i if anchored else views.anchors[i])
        views.levers.append(lever if anchored else views.levers[i] + lever)
    return views


def angular_velocities(mechanism: Mechanism, qd: Scalars) -> list[Vector]:
    """Angular velocity w_j of every link [3], rad/s in frame j."""
    w = [mechanism.velocity.angular]
    for j, link in mechanism.from_base():
        alike = link.parallel
        own = (qd[j] * link.axis).angular
        w.append(
            alike.components(w[alike.number]) if alike else link.transform.to_child(w[link.antecedent]) + own
        )  # (3)
    return w


def velocity_terms(mechanism: Mechanism, qd: Scalars, w: list[Vector]) -> list[Twist]:
    """gamma_j [7], the part of V'_j that depends on velocities only, in the frame before the joint's rotation."""
    gamma = [AT_REST]
    for j, link in mechanism.from_base():
        jw_i = link.before.to_child(w[link.antecedent])
        slide, spin = qd[j] * link.axis
        centripetal = cross(jw_i, cross(jw_i, link.before.origin_in_child))
        gamma.append(Twist(centripetal + cross(jw_i, slide + slide), cross(jw_i, spin)))  # (7)
    return gamma


def coriolis(link: Link, w_i: Vector, qd: Scalar) -> Twist:
    """The joint's own part of gamma_j [7], in frame j: all but the centripetal acceleration."""
    if link.axis is Axis.NONE:
        return AT_REST
    jw_i = link.transform.to_child(w_i)
    if link.axis is Axis.REVOLUTE:
        return Twist(ZERO, cross(jw_i, qd * EZ))  # (7)
    return Twist(cross(jw_i, (qd + qd) * EZ), ZERO)  # (7)


class AngularMotion(NamedTuple):
    """Angular acceleration wd of a link and U = hat(wd) + hat(w) hat(w), in its frame."""

    wd: Vector
    U: Matrix


def angular_motion(
    j: int, link: Link, w: Sequence[Vector], wd: Mapping[int, Vector], U: Mapping[int, Matrix], qdd: Scalar
) -> AngularMotion:
    """wd_j [6] and U_j of link j, from those of its antecedent, or of a link parallel to it.

    Points of a revolute joint's axis belong to both links, so that U_j z = jAi U_i iz_j, whatever the joint does.
    Found so it keeps its digits where qd_j is large, and gives wd_x and wd_y without products of their own.
    """
    i, parallel = link.antecedent, link.parallel
    if parallel and parallel.number in U:
        return AngularMotion(parallel.components(wd[parallel.number]), parallel.entries(U[parallel.number]))
    if link.axis is not Axis.REVOLUTE:
        wd_j = link.transform.to_child(wd[i])  # (6)
        return AngularMotion(wd_j, hat_plus_hat_squared(w[j], wd_j))
    before, rotation = link.before, link.joint_rotation.step
    along_z = rotation.rotate_back(_along_axis(before, w[i], AngularMotion(wd[i], U[i])))
    x, y, z = w[j]
    wd_j = Vector(y * z - along_z.y, along_z.x - x * z, before.to_child(wd[i]).z + qdd)  # (6)
    return AngularMotion(wd_j, hat_plus_hat_squared(w[j], wd_j, along_z))


def _along_axis(before: Transform, w: Vector, motion: AngularMotion) -> Vector:
    """U_i iz_j in the frame before the joint's rotation; quarter turns find it in a column of U_i."""
    if before.permutes:
        return before.to_child(motion.U * before.to_antecedent(EZ))
    x, y, z = before.to_child(w)
    wx, wy, _ = before.to_child(motion.wd)
    return Vector(x * z + wy, y * z - wx, -(x * x + y * y))


def velocities(mechanism: Mechanism, qd: Scalars) -> list[Twist]:
    """V_j [3]: velocity of the origin (m/s) and angular velocity (rad/s) of every frame, in frame j."""
    V = [mechanism.velocity]
    for j, link in mechanism.from_base():
        V.append(link.transform * V[link.antecedent] + qd[j] * link.axis)  # (3)
    return V


def accelerations(mechanism: Mechanism, qd: Scalars, qdd: Scalars) -> list[Twist]:
    """V'_j [6]: acceleration of the origin (m/s2) and angular acceleration (rad/s2), in frame j.

    Starts from the acceleration of the base that the mechanism holds, gravity included there.
    """
    w = angular_velocities(mechanism, qd)
    Vd = [mechanism.acceleration]
    for j, link in mechanism.from_base():
        i, (vd, wd) = link.antecedent, Vd[link.antecedent]
        gamma = coriolis(link, w[i], qd[j])
        at_origin = vd + hat_plus_hat_squared(w[i], wd) * link.transform.origin
        carried, gain = link.transform.to_child(at_origin), qdd[j] * link.axis
        wd = link.transform.to_child(wd) + (gamma.angular + gain.angular)
        Vd.append(Twist(carried + (gamma.linear + gain.linear), wd))  # (6)
    return Vd


def motion_expressed_in(
    mechanism: Mechanism, seen: FrameSet, qd: Scalars, qdd: Scalars
) -> tuple[list[Twist], list[Twist]]:
    """V_j [3] and V'_j [6] of every frame, all components in the one frame k that expresses them.

    Unlike components in frame j that are rotated back, these do not contain the angle of a revolute joint j. With
    the anchor l of frame j, the lever p from it, the sliding velocity s of the joints between and its derivative s',

        v_j  = v_l + w_l x p + s,
        v'_j = v'_l + U_l p + 2 w_l x s + s',
        w_j = w_l + qd_j z_j,   w'_j = w'_l + w x (qd_j z_j) + qdd_j z_j

    at a revolute joint j, where w may leave out rotations about z_j itself. Base as in `accelerations`.
    """
    R = seen.frames[0].rotation
    V = [Twist(R * mechanism.velocity.linear, R * mechanism.velocity.angular)]
    Vd = [Twist(R * mechanism.acceleration.linear, R * mechanism.acceleration.angular)]
    slides = [AT_REST]
    axes = [(ZERO, V[0].angular)]
    for j, link in mechanism.from_base():
        anchor, lever = seen.anchors[j], seen.levers[j]
        (v, w), (vd, wd), (axis, w_before) = V[anchor], Vd[anchor], axes[anchor]
        s, sd = slides[link.antecedent]
        z = seen.frames[j].z
        rate, gain = qd[j] * z, qdd[j] * z
        if link.axis is Axis.PRISMATIC:
            s, sd = s + rate, sd + gain
        v = v + cross(w, lever) + s
        vd = vd + hat_plus_hat_squared(w, wd) * lever + (cross(w, s + s) + sd)
        if link.axis is Axis.REVOLUTE:
            axis, w_before = z, w_before if axis == z else w
            w, wd = w + rate, wd + (cross(w_before, rate) + gain)
            s, sd = ZERO, ZERO
        V.append(Twist(v, w))
        Vd.append(Twist(vd, wd))
        slides.append(Twist(s, sd))
        axes.append((axis, w_before))
    return V, Vd


def path(mechanism: Mechanism, j: int) -> list[int]:
    """Numbers of the links from the base to link j."""
    links: list[int] = []
    while j:
        links.append(j)
        j = mechanism.link(j).antecedent
    return links[::-1]


def jacobian(mechanism: Mechanism, seen: FrameSet, frame: int) -> dict[int, Twist]:
    """Columns of the basic Jacobian of a frame, linear part first, by joint number.

    V_frame = sum of the columns times qd, on a base at rest [3], for the joints on the path from the base. Components
    are in the frame that expresses them.
    """
    columns: dict[int, Twist] = {}
    anchor, lever = frame, ZERO
    for j in reversed(path(mechanism, frame)):
        z, axis = seen.frames[j].z, mechanism.link(j).axis
        if axis is Axis.PRISMATIC:
            columns[j] = Twist(z, ZERO)  # (3)
        elif axis is Axis.REVOLUTE:
            if j != anchor:
                anchor, lever = j, lever + seen.levers[anchor]
            columns[j] = Twist(cross(z, lever), z)  # (3)
    return columns
