"""Dependent joints of closed loops, for files that do not state them and whose passive joints do not suffice.

The usual ones are the passive joints of the loops. They do not do where there are none, or where they are not as many
as the conditions by which the loops are closed. The conditions are rows of a Jacobian where the file assembles the
robot: as many joints follow as its rank says, first those without a motor or a spring that no other joint follows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from symoro_elastic.formats.robots.joint_tree import Tree, displacement_at
from symoro_elastic.formats.robots.robot import Connection, Holding, JointType, LinkJoint, Placement
from symoro_elastic.foundation.array_types import Array

RANK = 1e-9
"""Part of the largest singular value from which on another one counts: loops are assembled to 1e-6 in most files, and
the lengths of a loop differ by less than 1e3."""
HELD_ROWS = {Holding.POINT: [0, 1, 2], Holding.AXIS: [0, 1, 2, 3, 4], Holding.FRAME: [0, 1, 2, 3, 4, 5]}
"""Components of the twist between two frames that a connection holds, in axes of the first."""


def following_joints(
    tree: Tree, connections: Sequence[Connection], slopes: Mapping[str, tuple[str, float]]
) -> dict[str, tuple[str, ...]]:
    """Choose dependent joints for each loop, by its name; none if its passive joints suffice.

    `slopes` are the joints that others follow, and in which proportion, by the names of the followers.
    """
    conditions = {connection.name: _columns(tree, connection, slopes) for connection in connections}
    columns = _stack_columns([*conditions.values()])
    joints = {joint.name: joint for joint in tree.moving if joint.name in columns}
    leaders = {leader for leader, _ in slopes.values()}
    passive = [name for name, joint in joints.items() if not joint.driven and not joint.stiffness]
    rank = _rank([*columns.values()])
    if len(passive) == rank == _rank([columns[name] for name in passive]):
        return {}
    chosen: list[str] = []
    for name in sorted(joints, key=lambda name: (name in leaders, name not in passive, joints[name].driven)):
        if len(chosen) < rank and _rank([columns[other] for other in (*chosen, name)]) > len(chosen):
            chosen.append(name)
    return {loop: tuple(name for name in chosen if name in own) for loop, own in conditions.items()}


def _stack_columns(conditions: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Jacobian columns by joint for the conditions of all loops, stacked."""
    names = dict.fromkeys(name for columns in conditions for name in columns)
    heights = [len(next(iter(columns.values()))) if columns else 0 for columns in conditions]
    blocks = [*zip(conditions, heights, strict=True)]
    return {name: np.concatenate([own.get(name, np.zeros(height)) for own, height in blocks]) for name in names}


def _rank(columns: list[Array]) -> int:
    if not columns:
        return 0
    sizes = np.linalg.svd(np.array(columns), compute_uv=False)
    return int(np.count_nonzero(sizes > RANK * max(sizes.max(), np.finfo(float).tiny)))


def _columns(tree: Tree, connection: Connection, slopes: Mapping[str, tuple[str, float]]) -> dict[str, Array]:
    """Jacobian columns of a connection's conditions by joint; followers count as their leaders."""
    first_end: Placement | None = None
    columns: dict[str, Array] = {}
    ends = ((connection.first, connection.on_first, -1.0), (connection.second, connection.on_second, 1.0))
    for link, on_link, sign in ends:
        joints = [*_branch(tree, link)]
        placements = {joint.name: place for joint, place in _placements(tree, joints, connection.start)}
        carrier = placements[joints[-1].name] if joints else Placement()
        end = carrier * tree.carrying[link].placement * on_link
        first_end = first_end or end
        for joint in joints:
            leader, slope = slopes.get(joint.name, (joint.name, 1.0))
            at = placements[joint.name]
            axis, arm = at.rotation @ joint.axis, end.translation - at.translation
            slides = joint.type is JointType.PRISMATIC
            linear, angular = (axis, np.zeros(3)) if slides else (np.cross(axis, arm), axis)
            to_end = first_end.rotation.T
            twist = np.concatenate([to_end @ linear, to_end @ angular])[HELD_ROWS[connection.holding]]
            columns[leader] = columns.get(leader, 0.0) + sign * slope * twist
    return {name: column for name, column in columns.items() if np.abs(column).max() > RANK}


def _branch(tree: Tree, link: str) -> Iterator[LinkJoint]:
    """The joints that move a link, from the base outwards."""
    joint = tree.carrying[link].joint
    if joint:
        yield from _branch(tree, joint.parent)
        yield joint


def _placements(
    tree: Tree, joints: list[LinkJoint], start: Mapping[str, float]
) -> Iterator[tuple[LinkJoint, Placement]]:
    """Joints of a branch with their placements at the assembly of the loop."""
    before = Placement()
    for joint in joints:
        before = before * tree.seat(joint) * displacement_at(joint, start.get(joint.name, 0.0))
        yield joint, before
