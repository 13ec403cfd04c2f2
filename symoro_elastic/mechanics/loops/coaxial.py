"""Loops whose joints all turn about one axis, as a spring beside a motor: one angle takes back the sum of the others.

The sum is exact over whole turns, where an angle that is found from its sine and cosine jumps by one. S is constant.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping

from symoro_elastic.mechanics.loops.circuit import Circuit, Segment
from symoro_elastic.mechanics.loops.parallelogram import NO_TURN
from symoro_elastic.mechanics.loops.planar import Complex
from symoro_elastic.mechanics.spatial import Axis, Scalar, is_zero


def coaxial(
    loop: Circuit, unknown: Collection[int], angles: Mapping[int, Scalar], angle_of: Callable[[Complex], Scalar]
) -> dict[int, Scalar] | None:
    """Angle of the one unknown joint of a loop about one axis; None for any other loop.

    `loop` passes all its joints as unknown ones, `angles` are those of the others; `angle_of` gives the angle of a
    constant turn.
    """
    sought = [k for k, joint in enumerate(loop.unknown) if joint.joint in unknown]
    if len(sought) != 1 or not _is_coaxial(loop):
        return None
    loop = loop.from_joint(sought[0])
    first, *others = loop.unknown
    total: Scalar = 0
    turn, mirrored = NO_TURN, 1
    for segment, joint in zip(loop.segments, [*others, None], strict=True):
        rotation = segment.frame.rotation
        turn = turn * Complex(rotation.x.x, mirrored * rotation.y.x)
        mirrored *= 1 if rotation.z.z == 1 else -1
        if joint is not None:
            total = total + mirrored * joint.sense * angles[joint.joint]
    if mirrored != 1:
        return None
    return {first.joint: -first.sense * total + angle_of(turn.conjugate if first.sense > 0 else turn)}


def _is_coaxial(loop: Circuit) -> bool:
    turning = all(joint.axis is Axis.REVOLUTE for joint in loop.unknown)
    return turning and all(map(_stays_on_axis, loop.segments))


def _stays_on_axis(segment: Segment) -> bool:
    """Whether z at both ends of a segment is one line."""
    rotation, origin = segment.frame.rotation, segment.frame.origin
    return all(map(is_zero, (origin.x, origin.y, rotation.x.z, rotation.y.z)))
