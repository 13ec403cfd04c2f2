"""The equations at a cut joint: W qd = 0, W qdd = -phi, and how far the loop is from being closed.

Frame e, on one side of the cut joint and without its variable, meets frame m, on the other side (L9). Components are
along the axes of m, or of any frame where the cut joint has no direction in the rows kept. Both branches are followed
from their last common body as if it were at rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symoro_elastic.mechanics.kinematics import FrameSet, frame_set, jacobian, motion_expressed_in
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import EZ, ZERO, Axis, Scalar, Twist, Vector, cross, hat_plus_hat_squared

KEPT = {Axis.REVOLUTE: (0, 1, 2, 3, 4), Axis.PRISMATIC: (0, 1, 3, 4, 5), Axis.NONE: (0, 1, 2, 3, 4, 5)}
"""Components of v_x v_y v_z w_x w_y w_z that a cut joint constrains."""
POINT = (0, 1, 2)
"""Constrained components where only the origins meet."""


@dataclass(frozen=True)
class CutJoint:
    """A cut joint: the links of frames e and m, the freedom along its axis, or all rotations at a point."""

    e: int
    m: int
    axis: Axis
    at_point: bool = False

    @property
    def rows(self) -> tuple[int, ...]:
        """Rows of the relative twist that are zero."""
        return POINT if self.at_point else KEPT[self.axis]


@dataclass(frozen=True)
class Branches:
    """The two branches of a loop as a mechanism of their own, on their last common body at rest.

    `number` is the number there of a link of the whole mechanism, `seen` are its frames as m, or another one, sees
    them.
    """

    mechanism: Mechanism
    number: Mapping[int, int]
    cut: CutJoint
    seen: FrameSet

    @property
    def reach(self) -> Vector:
        """Displacement from the origin of e to that of m along a cut slide; zero for other cut joints when closed."""
        return -self.seen.frames[self.number[self.cut.e]].origin


def branches_of(
    mechanism: Mechanism, links: Sequence[int], cut: CutJoint, view: int | None = None, pivot: int | None = None
) -> Branches:
    """The mechanism of the `links` of a loop, in the order of the table, seen from m or from the link `view`.

    With a `pivot`, a turn of m's branch, the lever of e leads over it: a side of a triangle by the two others.
    """
    number = {j: k for k, j in enumerate(sorted(links), start=1)}
    chain = tuple(
        replace(mechanism.link(j), antecedent=number.get(mechanism.link(j).antecedent, 0), parallel=None)
        for j in sorted(links)
    )
    part = Mechanism(chain)
    views = frame_set(part, number[cut.m] if view is None else number.get(view, 0))
    if pivot is not None:
        levers = [*views.levers]
        levers[number[cut.e]] = _over(views, number[pivot], number[cut.m], number[cut.e])
        views = views._replace(levers=levers)
    return Branches(part, number, cut, views)


def closing_columns(loop: Branches) -> dict[int, Twist]:
    """Columns of W by joint: the twist of e relative to m per unit of joint velocity (L10)."""
    e, m = (loop.number[j] for j in (loop.cut.e, loop.cut.m))
    to_cut, to_end = jacobian(loop.mechanism, loop.seen, e), jacobian(loop.mechanism, loop.seen, m)
    columns = {}
    for j, k in loop.number.items():
        if k in to_cut:
            columns[j] = _at_reach(loop, to_cut[k])
        elif k in to_end:
            columns[j] = -to_end[k]
    return columns


def closing_acceleration(loop: Branches, qd: Mapping[int, Scalar], qdd: Mapping[int, Scalar]) -> Twist:
    """Acceleration of e relative to m, e taken after the cut joint with its velocity (L11).

    With the part of qdd that is known it is phi: the other accelerations x have W x = -phi.
    """
    rates, gains = (_by_number(loop, by_joint) for by_joint in (qd, qdd))
    V, Vd = motion_expressed_in(loop.mechanism, loop.seen, rates, gains)
    e, m = (loop.number[j] for j in (loop.cut.e, loop.cut.m))
    (v, w), (vd, wd) = V[e], Vd[e]
    (v_m, w_m), (vd_m, wd_m) = V[m], Vd[m]
    if loop.cut.axis is Axis.PRISMATIC:
        slide = (v_m - v - cross(w, loop.reach)).z * EZ
        vd = vd + hat_plus_hat_squared(w, wd) * loop.reach + cross(w, slide + slide)
        return Twist(vd - vd_m, wd - wd_m)
    if loop.cut.axis is Axis.REVOLUTE and not loop.cut.at_point:
        wd = wd + cross(w, (w_m - w).z * EZ)
    return Twist(vd - vd_m, wd - wd_m)


def closing_error(loop: Branches) -> Twist:
    """Distance and small rotation of e from m, zero where the loop is closed; its derivative there is W (L18)."""
    rotation, origin = loop.seen.frames[loop.number[loop.cut.e]]
    if loop.cut.axis is Axis.REVOLUTE:
        return Twist(origin, cross(EZ, rotation.T.z))
    x, y, z = rotation.T.x, rotation.T.y, rotation.T.z
    angle = Fraction(1, 2) * Vector(y.z - z.y, z.x - x.z, x.y - y.x)
    return _at_reach(loop, Twist(origin, angle))


def _over(seen: FrameSet, pivot: int, m: int, e: int) -> Vector:
    """Lever of frame e from its anchor, computed by way of the pivot and of frame m, whose origin e meets."""
    way = ZERO
    for k in _anchors(seen, pivot):
        way = way + seen.levers[k]
    for k in reversed(_anchors(seen, seen.anchors[e])):
        way = way - seen.levers[k]
    for k in _anchors(seen, m):
        if k == pivot:
            break
        way = way + seen.levers[k]
    return way


def _anchors(seen: FrameSet, k: int) -> list[int]:
    """Link k, its anchor, the anchor of that ...: their levers sum to the vector from the last common body to k."""
    anchors = []
    while k:
        anchors.append(k)
        k = seen.anchors[k]
    return anchors


def _at_reach(loop: Branches, column: Twist) -> Twist:
    """The twist of the body of e at the origin of m, which differs from that of e along a cut slide."""
    if loop.cut.axis is not Axis.PRISMATIC:
        return column
    return Twist(column.linear + cross(column.angular, loop.reach), column.angular)


def _by_number(loop: Branches, by_joint: Mapping[int, Scalar]) -> list[Scalar]:
    entries: list[Scalar] = [0] * (len(loop.number) + 1)
    for j, k in loop.number.items():
        entries[k] = by_joint.get(j, 0)
    return entries
