"""Loops closed by constant maps (L9): angles are sums of angles, S is constant and gam is zero.

Parallelograms are planar loops of four turning corners whose opposite sides are the same expressions. These stay
parallel, and nothing is divided by what vanishes in the flat position. Constant angles are unit complex numbers: turns
add up by multiplication. Where all joints turn about the same axis, as with a spring next to a motor, an angle undoes
the sum of the others: over whole turns too, where an angle from its sine and cosine jumps by one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.loops.circuit import Circuit, Segment
from symoro_elastic.mechanics.loops.planar import Complex
from symoro_elastic.mechanics.spatial import Axis, Scalar, X, Z, is_zero

NO_TURN, HALF_TURN = Complex(1, 0), Complex(-1, 0)


class Side(NamedTuple):
    """A side: a length along a direction that is constant in the axes of its body."""

    length: Scalar
    direction: Complex


@dataclass
class Corner:
    """The joints at one corner, each with its sense of turning, and the constant turn of the bodies between them."""

    joints: list[tuple[int, int]] = field(default_factory=list)
    turn: Complex = NO_TURN


def parallelogram(
    loop: Circuit, unknown: Collection[int], angles: Mapping[int, Scalar], angle_of: Callable[[Complex], Scalar]
) -> dict[int, Scalar] | None:
    """Angles of the unknown joints of a parallelogram; None for any other loop.

    `loop` passes all its joints as unknown ones, `angles` are those of the others; `angle_of` gives the angle of a
    constant turn. Where t_k is the turn at the corner after side k, t_k + t_(k+1) is constant.
    """
    polygon = _polygon(loop)
    if polygon is None or len(polygon) != 4:
        return None
    sides, corners = zip(*polygon, strict=True)
    constants = [_from_opposite(sides[k], sides[k - 2]) for k in range(4)]
    given = [k for k, corner in enumerate(corners) if all(j in angles and j not in unknown for j, _ in corner.joints)]
    single = [k for k, corner in enumerate(corners) if len(corner.joints) == 1]
    if None in constants or len(given) != 1 or {*given, *single} != set(range(4)):
        return None
    (first,) = given
    angle = sum_of(sense * angles[j] for j, sense in corners[first].joints)
    turn = corners[first].turn
    solved: dict[int, Scalar] = {}
    for k in ((first + i) % 4 for i in (1, 2, 3)):
        angle, turn = -angle, (constants[k - 1] or NO_TURN) * turn.conjugate
        ((joint, sense),) = corners[k].joints
        own = turn * corners[k].turn.conjugate
        solved[joint] = sense * angle + angle_of(own if sense > 0 else own.conjugate)
    return solved


def _polygon(loop: Circuit) -> list[tuple[Side, Corner]] | None:
    """Sides of a loop, each with the corner at its end; None where a segment is not a single side."""
    if any(joint.axis is not Axis.REVOLUTE for joint in loop.unknown):
        return None
    lengths = [_side(segment, 1) for segment in loop.segments]
    long = [k for k, side in enumerate(lengths) if side is not None and not is_zero(side.length)]
    if None in lengths or not long:
        return None
    loop = loop.from_joint((long[0] + 1) % len(loop.unknown))
    polygon: list[tuple[Side, Corner]] = []
    mirrored = 1
    for k, joint in enumerate(loop.unknown):
        segment = loop.segments[k - 1]
        side = _side(segment, mirrored)
        if side is not None and not is_zero(side.length):
            polygon.append((side, Corner()))
        corner, rotation = polygon[-1][1], segment.frame.rotation
        corner.turn = corner.turn * Complex(rotation.x.x, mirrored * rotation.y.x)
        mirrored *= 1 if rotation.z.z == 1 else -1
        corner.joints.append((joint.joint, mirrored * joint.sense))
    return polygon if mirrored == 1 else None


def _side(segment: Segment, mirrored: int) -> Side | None:
    """The side along a segment; None where it is made of several shifts in several directions."""
    x, y, _ = segment.frame.origin
    if is_zero(y):
        return Side(x, NO_TURN)
    if is_zero(x):
        return Side(y, Complex(0, mirrored))
    return _along_one_shift(segment, mirrored)


def _along_one_shift(segment: Segment, mirrored: int) -> Side | None:
    """The side of a segment that has one shift in the plane, after constant turns about its normal."""
    direction, found = NO_TURN, []
    for step, sense in segment.steps:
        if step.axis == X and not is_zero(step.sine):
            return None
        if step.axis == X and not is_zero(step.shift):
            found.append(Side(sense * step.shift, direction))
        if step.axis == X:
            mirrored *= 1 if step.cosine == 1 else -1
        elif step.axis == Z:
            direction = direction * Complex(step.cosine, sense * mirrored * step.sine)
    return found[0] if len(found) == 1 else None


def _from_opposite(u: Side, v: Side) -> Complex | None:
    """The turn from a side to the opposite one, which runs back; None where their lengths differ."""
    turn = u.direction * v.direction.conjugate
    if is_zero(u.length - v.length):
        return turn * HALF_TURN
    return turn if is_zero(u.length + v.length) else None


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
