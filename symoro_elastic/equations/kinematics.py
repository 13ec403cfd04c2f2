"""Geometric and kinematic models [1]-[7]. Lists are indexed by link number; entry 0 is the base."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from symoro_elastic.equations.mechanism import Axis, Link, Mechanism
from symoro_elastic.equations.spatial import (
    Matrix,
    Pair,
    Scalar,
    Symmetric,
    Vector,
    add,
    cross,
    full,
    hat_plus_hat_squared,
    hat_squared,
    origin,
    scale,
    screw_to_child,
    subtract,
    times,
    to_child,
    transpose,
    turn,
    turn_back,
)

Scalars: TypeAlias = Sequence[Scalar]


def frames(mechanism: Mechanism) -> list[tuple[Matrix, Vector]]:
    """0Aj and 0Pj of every frame [2]."""
    placed: list[tuple[Matrix, Vector]] = [(((1, 0, 0), (0, 1, 0), (0, 0, 1)), (0, 0, 0))]
    for _, link in mechanism.numbered():
        placed.append(moved_frame(link, *placed[link.antecedent]))
    return placed


def carried_velocity(link: Link, w_i: Vector) -> Vector:
    """jw_i = jAi w_i."""
    return to_child(link.placement, w_i)


def angular_velocities(mechanism: Mechanism, qd: Scalars) -> list[Vector]:
    """w_j = jAi w_i + s0 qd_j z [3], rad/s in frame j."""
    w = [mechanism.velocity[1]]
    for j, link in mechanism.numbered():
        w.append(add(carried_velocity(link, w[link.antecedent]), link.axis.screw(qd[j])[1]))
    return w


def velocity_terms(mechanism: Mechanism, qd: Scalars, w: list[Vector], squares: list[Symmetric]) -> list[Pair]:
    """g_j [7], the part of V'_j that depends on velocities only; `squares` are hat(w_j) hat(w_j)."""
    g: list[Pair] = [((0, 0, 0), (0, 0, 0))]
    for j, link in mechanism.numbered():
        i = link.antecedent
        carried = to_child(link.placement, times(full(squares[i]), origin(link.placement)))
        linear, angular = coriolis(link, carried_velocity(link, w[i]), qd[j])
        g.append((add(carried, linear), angular))
    return g


def coriolis(link: Link, jw_i: Vector, qd: Scalar) -> Pair:
    """[2 s1 (jw_i x qd z); s0 (jw_i x qd z)], the joint's own part of g_j [7]."""
    if link.axis is Axis.NONE:
        return (0, 0, 0), (0, 0, 0)
    if link.axis is Axis.REVOLUTE:
        return (0, 0, 0), cross(jw_i, (0, 0, qd))
    return cross(jw_i, (0, 0, qd + qd)), (0, 0, 0)


def squared_velocities(w: list[Vector]) -> list[Symmetric]:
    """hat(w_j) hat(w_j) of every link."""
    return [hat_squared(w_j) for w_j in w]


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


def path(mechanism: Mechanism, j: int) -> list[int]:
    """Numbers of the links from the base to link j."""
    links: list[int] = []
    while j:
        links.append(j)
        j = mechanism.links[j - 1].antecedent
    return links[::-1]


def jacobian(mechanism: Mechanism, placed: list[tuple[Matrix, Vector]], frame: int) -> dict[int, Pair]:
    """Columns of the basic Jacobian of a frame, linear part first, in frame 0; by joint number.

    V_frame = sum of the columns times qd. A revolute joint gives [z x (P - P_j); z], a prismatic
    joint [z; 0], for the joints on the path from the base.
    """
    columns: dict[int, Pair] = {}
    for j in path(mechanism, frame):
        rotation, position = placed[j]
        z = transpose(rotation)[2]
        if mechanism.links[j - 1].axis is Axis.REVOLUTE:
            columns[j] = cross(z, subtract(placed[frame][1], position)), z
        elif mechanism.links[j - 1].axis is Axis.PRISMATIC:
            columns[j] = z, (0, 0, 0)
    return columns


def placement_between(mechanism: Mechanism, k: int, f: int) -> tuple[Matrix, Vector]:
    """kAf and kPf, over the joints between the two frames only."""
    from_k, from_f = path(mechanism, k), path(mechanism, f)
    shared = len([i for i, j in zip(from_k, from_f, strict=False) if i == j])
    rotation: Matrix = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    position: Vector = (0, 0, 0)
    for j in reversed(from_k[shared:]):
        for screw in reversed(mechanism.links[j - 1].placement):
            position = subtract(position, scale(screw.shift, transpose(rotation)[screw.axis]))
            rotation = (turn(screw, rotation[0]), turn(screw, rotation[1]), turn(screw, rotation[2]))
    for j in from_f[shared:]:
        rotation, position = moved_frame(mechanism.links[j - 1], rotation, position)
    return rotation, position


def moved_frame(link: Link, rotation: Matrix, position: Vector) -> tuple[Matrix, Vector]:
    """Frame j from frame i, both seen from any third [1]."""
    for screw in link.placement:
        position = add(position, scale(screw.shift, transpose(rotation)[screw.axis]))
        rotation = (turn_back(screw, rotation[0]), turn_back(screw, rotation[1]), turn_back(screw, rotation[2]))
    return rotation, position
