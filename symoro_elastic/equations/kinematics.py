"""Geometric and kinematic models [1]-[7]. Lists are indexed by link number; entry 0 is the base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from symoro_elastic.equations.mechanism import Axis, Link, Mechanism
from symoro_elastic.equations.spatial import (
    ZERO,
    Matrix,
    Pair,
    Placement,
    Scalar,
    Vector,
    add,
    arm,
    cross,
    hat_plus_hat_squared,
    origin,
    scale,
    screw_to_child,
    subtract,
    times,
    to_antecedent,
    to_child,
    transpose,
    turn,
    turn_back,
)

Scalars: TypeAlias = Sequence[Scalar]


def frames(mechanism: Mechanism, seen_from: int = 0) -> list[tuple[Matrix, Vector]]:
    """kAj and kPj of every frame j, seen from frame k: 0Aj and 0Pj [2] unless another one is named.

    The joints between the two frames enter, and no other.
    """
    placed: dict[int, tuple[Matrix, Vector]] = {seen_from: (((1, 0, 0), (0, 1, 0), (0, 0, 1)), (0, 0, 0))}
    for j in reversed(path(mechanism, seen_from)):
        link = mechanism.links[j - 1]
        placed[link.antecedent] = antecedent_frame(link, *placed[j])
    for j, link in mechanism.numbered():
        if j not in placed:
            placed[j] = moved_frame(link, *placed[link.antecedent])
    return [placed[j] for j in range(len(mechanism.links) + 1)]


def moved_frame(link: Link, rotation: Matrix, position: Vector) -> tuple[Matrix, Vector]:
    """Frame j from frame i, both seen from any third [1]."""
    for screw in link.placement:
        position = add(position, scale(screw.shift, transpose(rotation)[screw.axis]))
        rotation = (turn_back(screw, rotation[0]), turn_back(screw, rotation[1]), turn_back(screw, rotation[2]))
    return rotation, position


def antecedent_frame(link: Link, rotation: Matrix, position: Vector) -> tuple[Matrix, Vector]:
    """Frame i from frame j, both seen from any third."""
    for screw in reversed(link.placement):
        position = subtract(position, scale(screw.shift, transpose(rotation)[screw.axis]))
        rotation = (turn(screw, rotation[0]), turn(screw, rotation[1]), turn(screw, rotation[2]))
    return rotation, position


@dataclass(frozen=True)
class View:
    """All frames as one of them, k, sees them: kAj and kPj, and how far they are from their anchors.

    The anchor of frame j is the last revolute joint before it, or the base: what lies between turns
    alike. `levers[j]` is kPj less that of the anchor; only joints between the two enter.
    """

    placed: list[tuple[Matrix, Vector]]
    anchors: list[int]
    levers: list[Vector]


def view(mechanism: Mechanism, seen_from: int = 0) -> View:
    """What frame k sees."""
    seen, between = View(frames(mechanism, seen_from), [0], [ZERO]), path(mechanism, seen_from)
    for j, link in mechanism.numbered():
        i = link.antecedent
        if j in between:
            lever = subtract(ZERO, antecedent_frame(link, seen.placed[j][0], ZERO)[1])
        else:
            lever = moved_frame(link, seen.placed[i][0], ZERO)[1]
        anchored = not i or mechanism.links[i - 1].axis is Axis.REVOLUTE
        seen.anchors.append(i if anchored else seen.anchors[i])
        seen.levers.append(lever if anchored else add(seen.levers[i], lever))
    return seen


def carried_velocity(link: Link, w_i: Vector) -> Vector:
    """jw_i = jAi w_i."""
    return to_child(link.placement, w_i)


def angular_velocities(mechanism: Mechanism, qd: Scalars) -> list[Vector]:
    """w_j = jAi w_i + s0 qd_j z [3], rad/s in frame j."""
    w = [mechanism.velocity[1]]
    for j, link in mechanism.numbered():
        w.append(add(carried_velocity(link, w[link.antecedent]), link.axis.screw(qd[j])[1]))
    return w


def velocity_terms(mechanism: Mechanism, qd: Scalars, w: list[Vector]) -> list[Pair]:
    """g_j [7], the part of V'_j that depends on velocities only, in frame j without its last turn."""
    g: list[Pair] = [(ZERO, ZERO)]
    for j, link in mechanism.numbered():
        carried = to_child(link.unturned, w[link.antecedent])
        slide, spin = link.axis.screw(qd[j])
        centripetal = cross(carried, cross(carried, arm(link.unturned)))
        g.append((add(centripetal, cross(carried, add(slide, slide))), cross(carried, spin)))
    return g


def coriolis(link: Link, jw_i: Vector, qd: Scalar) -> Pair:
    """[2 s1 (jw_i x qd z); s0 (jw_i x qd z)], the joint's own part of g_j [7]."""
    if link.axis is Axis.NONE:
        return (0, 0, 0), (0, 0, 0)
    if link.axis is Axis.REVOLUTE:
        return (0, 0, 0), cross(jw_i, (0, 0, qd))
    return cross(jw_i, (0, 0, qd + qd)), (0, 0, 0)


def turning(link: Link, w_i: Vector, wd_i: Vector, U_i: Matrix, w_j: Vector, qdd: Scalar) -> tuple[Vector, Matrix]:
    """wd_j [6] and U_j = hat(wd_j) + hat(w_j) hat(w_j) of a revolute joint.

    Points of its axis belong to both links: U_j z is U_i z turned, whatever the joint does. Found so it keeps its
    digits where qd_j is large, and gives wd_x and wd_y without products of its own.
    """
    along = turn_back(link.last_turn, _along_axis(link.unturned, w_i, wd_i, U_i))
    _, _, spin = to_child(link.unturned, wd_i)
    x, y, z = w_j
    wd_j = (y * z - along[1], along[0] - x * z, spin + qdd)
    return wd_j, hat_plus_hat_squared(w_j, wd_j, along)


def _along_axis(placement: Placement, w: Vector, wd: Vector, U: Matrix) -> Vector:
    """U z in the moved frame, which does not move; quarter turns find it in a column of U."""
    if all(screw.turns_by_quarters for screw in placement):
        return to_child(placement, times(U, to_antecedent(placement, (0, 0, 1))))
    x, y, z = to_child(placement, w)
    wx, wy, _ = to_child(placement, wd)
    return (x * z + wy, y * z - wx, -(x * x + y * y))


def velocities(mechanism: Mechanism, qd: Scalars) -> list[Pair]:
    """V_j [3]: velocity of the origin (m/s) and angular velocity (rad/s) of every frame, in frame j."""
    found = [mechanism.velocity]
    for j, link in mechanism.numbered():
        linear, angular = screw_to_child(link.placement, found[link.antecedent])
        moved, turned = link.axis.screw(qd[j])
        found.append((add(linear, moved), add(angular, turned)))
    return found


def accelerations(mechanism: Mechanism, qd: Scalars, qdd: Scalars) -> list[Pair]:
    """V'_j [6]: acceleration of the origin (m/s2) and angular acceleration (rad/s2), in frame j.

    Starts from the acceleration of the base that the mechanism holds, gravity included there.
    """
    w = angular_velocities(mechanism, qd)
    found = [mechanism.acceleration]
    for j, link in mechanism.numbered():
        i = link.antecedent
        linear, angular = coriolis(link, carried_velocity(link, w[i]), qd[j])
        moved, turned = link.axis.screw(qdd[j])
        vd_i, wd_i = found[i]
        carried = to_child(link.placement, add(vd_i, times(hat_plus_hat_squared(w[i], wd_i), origin(link.placement))))
        wd = add(to_child(link.placement, wd_i), add(angular, turned))
        found.append((add(carried, add(linear, moved)), wd))
    return found


def seen_motion(mechanism: Mechanism, seen: View, qd: Scalars, qdd: Scalars) -> tuple[list[Pair], list[Pair]]:
    """V_j [3] and V'_j [6] of every frame, all components in the one frame that sees them.

    Unlike components in frame j that are turned back, these are free of the angle of a revolute joint j.
    Base as in `accelerations`.
    """
    rotation = seen.placed[0][0]
    V = [(times(rotation, mechanism.velocity[0]), times(rotation, mechanism.velocity[1]))]
    Vd = [(times(rotation, mechanism.acceleration[0]), times(rotation, mechanism.acceleration[1]))]
    slides: list[Pair] = [(ZERO, ZERO)]
    tilts = [(ZERO, V[0][1])]  # the axis that a frame turns about, and w but for the turns about it
    for j, link in mechanism.numbered():
        (v, w), (vd, wd), lever = V[seen.anchors[j]], Vd[seen.anchors[j]], seen.levers[j]
        axis, tilting = tilts[seen.anchors[j]]
        speed, push = slides[link.antecedent]
        z = transpose(seen.placed[j][0])[2]
        rate, gain = scale(qd[j], z), scale(qdd[j], z)
        if link.axis is Axis.PRISMATIC:
            speed, push = add(speed, rate), add(push, gain)
        v = add(add(v, cross(w, lever)), speed)
        vd = add(add(vd, times(hat_plus_hat_squared(w, wd), lever)), add(cross(w, add(speed, speed)), push))
        if link.axis is Axis.REVOLUTE:
            axis, tilting = z, tilting if axis == z else w
            w, wd = add(w, rate), add(wd, add(cross(tilting, rate), gain))
            speed, push = ZERO, ZERO
        V.append((v, w))
        Vd.append((vd, wd))
        slides.append((speed, push))
        tilts.append((axis, tilting))
    return V, Vd


def path(mechanism: Mechanism, j: int) -> list[int]:
    """Numbers of the links from the base to link j."""
    links: list[int] = []
    while j:
        links.append(j)
        j = mechanism.links[j - 1].antecedent
    return links[::-1]


def jacobian(mechanism: Mechanism, seen: View, frame: int) -> dict[int, Pair]:
    """Columns of the basic Jacobian of a frame, linear part first, by joint number.

    V_frame = sum of the columns times qd, on a base at rest. A revolute joint gives [z x (P - P_j); z],
    a prismatic joint [z; 0], for the joints on the path from the base. Components are in the frame
    that sees them.
    """
    columns: dict[int, Pair] = {}
    anchor, lever = frame, ZERO
    for j in reversed(path(mechanism, frame)):
        z = transpose(seen.placed[j][0])[2]
        if mechanism.links[j - 1].axis is Axis.PRISMATIC:
            columns[j] = z, ZERO
        elif mechanism.links[j - 1].axis is Axis.REVOLUTE:
            if j != anchor:
                anchor, lever = j, add(lever, seen.levers[anchor])
            columns[j] = cross(z, lever), z
    return columns
