"""Parallelograms: planar loops of four turning corners whose opposite sides are the same expressions.

Opposite sides stay parallel, so angles are sums of angles: S is constant, gam is zero, and nothing is divided by what
vanishes in the flat position.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from symoro_elastic.equations.loops.circuit import Circuit
from symoro_elastic.equations.loops.planar import Complex
from symoro_elastic.equations.spatial import Axis, Scalar, is_zero

QUARTERS: dict[tuple[Scalar, Scalar], int] = {(1, 0): 0, (0, 1): 1, (-1, 0): 2, (0, -1): 3}


@dataclass
class Corner:
    """The joints at one corner, each with its sense of turning, and quarter turns of the bodies between them."""

    joints: list[tuple[int, int]] = field(default_factory=list)
    quarters: int = 0


def parallelogram(
    loop: Circuit, unknown: Collection[int], angles: Mapping[int, Scalar], quarter: Scalar
) -> dict[int, Scalar] | None:
    """Angles of the unknown joints of a parallelogram; None for any other loop.

    `loop` passes all its joints as unknown ones, `angles` are those of the others, `quarter` is pi / 2. Where t_k is
    the turn at the corner after side k, t_k + t_(k+1) is constant.
    """
    found = _polygon(loop)
    if found is None or len(found) != 4:
        return None
    sides, corners = zip(*found, strict=True)
    constants = [_from_opposite(sides[k], sides[k - 2]) for k in range(4)]
    known = [k for k, corner in enumerate(corners) if all(j in angles and j not in unknown for j, _ in corner.joints)]
    single = [k for k, corner in enumerate(corners) if len(corner.joints) == 1]
    if None in constants or len(known) != 1 or {*known, *single} != set(range(4)):
        return None
    (first,) = known
    turn: Scalar = 0
    for j, sense in corners[first].joints:
        turn = turn + sense * angles[j]
    quarters = corners[first].quarters
    solved: dict[int, Scalar] = {}
    for k in ((first + i) % 4 for i in (1, 2, 3)):
        turn, quarters = -turn, (constants[k - 1] or 0) - quarters
        ((joint, sense),) = corners[k].joints
        solved[joint] = sense * turn + _least(sense * (quarters - corners[k].quarters)) * quarter
    return solved


def _polygon(loop: Circuit) -> list[tuple[Complex, Corner]] | None:
    """Sides, in axes that turn at corners only, each with the corner at its end; None where one is no plain length."""
    lengths = [_side(loop, k, 1).length for k in range(len(loop.unknown))]
    if all(x is not None and is_zero(x) for x in lengths):
        return None
    loop = loop.from_joint(next(k for k, x in enumerate(lengths) if x is None or not is_zero(x)))
    found: list[tuple[Complex, Corner]] = []
    mirrored = 1
    for k, joint in enumerate(loop.unknown):
        rotation = loop.segments[k - 1].frame.rotation
        side, quarter = _side(loop, k, mirrored), QUARTERS.get((rotation.x.x, rotation.y.x))
        if side.length is None or quarter is None or joint.axis is not Axis.REVOLUTE:
            return None
        if not is_zero(side.length):
            found.append((side, Corner()))
        corner = found[-1][1]
        corner.quarters += mirrored * quarter
        mirrored *= 1 if rotation.z.z == 1 else -1
        corner.joints.append((joint.joint, mirrored * joint.sense))
    return found if mirrored == 1 else None


def _side(loop: Circuit, k: int, mirrored: int) -> Complex:
    """The side that ends at joint k."""
    x, y, _ = loop.segments[k - 1].frame.origin
    return Complex(x, mirrored * y)


def _from_opposite(u: Complex, v: Complex) -> int | None:
    """Quarter turns from a side to the opposite one, which runs back; None where their lengths differ."""
    if u.length is None or v.length is None:
        return None
    turns = int(is_zero(u.x)) - int(is_zero(v.x)) + 2
    if is_zero(u.length - v.length):
        return turns
    return turns + 2 if is_zero(u.length + v.length) else None


def _least(quarters: int) -> int:
    """The same turn as -1, 0, 1 or 2 quarters."""
    return (quarters + 1) % 4 - 1
