"""Three decompositions of a serial chain into problems with closed forms.

Sources: Pieper (1968); Paul (1981); Khalil and Dombre (2002), chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

from symoro_elastic.mechanics.inverse_geometry.equation_types import (
    STILL,
    Found,
    Functions,
    Miss,
    NoClosedForm,
    Pose,
    along,
    is_along_z,
    only_where,
    plane,
    shifted_by,
    type_3,
)
from symoro_elastic.mechanics.inverse_geometry.points import (
    Mover,
    Solution,
    meeting,
    names_in_words,
    numbers_of,
    onto_surface,
    reach,
)
from symoro_elastic.mechanics.spatial import EX, EZ, ZERO, Matrix, Scalar, Vector, cross, dot

FLAT = Fraction(1, 2**36)
NO_WRIST, ORIENTED = "no wrist", "orientation does not give the angles"
FIRST, LAST = EX, EZ


class Chain(NamedTuple):
    """C0 J1 C1 ... Jn Cn: the joints that move and the placements before, between and after them."""

    movers: tuple[Mover, ...]
    between: tuple[Pose, ...]

    def from_other_end(self) -> Chain:
        """The chain from its other end."""
        return Chain(self.movers[::-1], tuple(pose.inverse() for pose in reversed(self.between)))


def arms_to(f: Functions, chain: Chain, P: Vector) -> list[Solution]:
    """Solutions that bring the origin of the last frame to P."""
    return reach(f, chain.movers, chain.between[1:-1], chain.between[-1].origin, chain.between[0].point_back(P))


# A point, then axes that meet in it


def point_then_axes(f: Functions, chain: Chain, T: Pose, k: int) -> list[Solution]:
    """Solutions with the last k axes as wrist."""
    m = len(chain.movers) - k
    wrist, poses = chain.movers[m:], chain.between[m + 1 : -1]
    here, there = _meeting_point(f, wrist, poses)
    if k == 0:
        return arms_to(f, chain, T.origin)
    inner = chain.between[0].inverse().then(T).then(chain.between[-1].inverse())
    target = inner.point(along(there))
    arms = reach(f, chain.movers[:m], chain.between[1:m], chain.between[m].point(along(here)), target)
    solutions = []
    for arm in arms:
        first, last = (_carry(chain, arm, inner.rotation * axis) for axis in (FIRST, LAST))
        solutions += [(*arm, *ends) for ends in _WRISTS[k](f, wrist, poses, first, last)]
    return solutions


def _meeting_point(f: Functions, wrist: Sequence[Mover], poses: Sequence[Pose]) -> tuple[Scalar, Scalar]:
    """Intersection of up to three axes: z in the frame of the first, z in that of the last. Raises `NoClosedForm`."""
    for mover in wrist:
        if not mover.turns:
            raise _no_wrist([mover], f"joint {mover.joint} is prismatic: {names_in_words(wrist)} do not form a wrist")
    if len(wrist) < 2:
        return 0, 0
    (here, middle), *others = [
        _meeting(f, wrist, pair, pose) for pair, pose in zip(pairwise(wrist), poses, strict=True)
    ]
    if not others:
        return here, middle
    before, there = others[0]
    if not f.is_zero(middle - before):
        raise _no_wrist(wrist, _not_in_one_point(wrist), Miss(wrist[1].joint, "elsewhere"))
    return here, there


def _meeting(f: Functions, wrist: Sequence[Mover], pair: Sequence[Mover], pose: Pose) -> tuple[Scalar, Scalar]:
    try:
        return meeting(f, pair, pose)
    except NoClosedForm as error:
        reason = _not_in_one_point(wrist) if len(wrist) == 3 else error.reason
        raise _no_wrist(wrist, reason, error.miss) from None


def _not_in_one_point(wrist: Sequence[Mover]) -> str:
    return f"the axes of {names_in_words(wrist)} do not meet in one point"


def _no_wrist(movers: Sequence[Mover], reason: str, miss: Miss | None = None) -> NoClosedForm:
    return NoClosedForm(numbers_of(movers), reason, miss, NO_WRIST)


def _carry(chain: Chain, arm: Solution, v: Vector) -> Vector:
    """Components of a given vector after the joints of an arm and the placement that follows."""
    for joint, pose in zip(arm, chain.between[1:], strict=False):
        v = pose.rotation.T * joint.motion.rotate_back(v)
    return v


def _one_axis(
    f: Functions, wrist: Sequence[Mover], _: Sequence[Pose], first: Vector, last: Vector
) -> Iterator[Solution]:
    """Solutions of Rot(z, q1) = M, given the first column of M."""
    yield (type_3(f, wrist[0].joint, FIRST, first),)


def _two_axes(
    f: Functions, wrist: Sequence[Mover], poses: Sequence[Pose], first: Vector, last: Vector
) -> Iterator[Solution]:
    """Solve Rot(z, q1) R Rot(z, q2) = M: the last column gives q1, the first q2."""
    first_turn = type_3(f, wrist[0].joint, poses[0].rotation.T[2], last)
    x = poses[0].rotation.T * first_turn.motion.rotate_back(first)
    yield first_turn, type_3(f, wrist[1].joint, FIRST, x)


def _three_axes(
    f: Functions, wrist: Sequence[Mover], poses: Sequence[Pose], first: Vector, last: Vector
) -> Iterator[Solution]:
    """Solve Rot(z, q1) R Rot(z, q2) S Rot(z, q3) = M: the last column is a point to reach, the first gives q3."""
    centred = [Pose(pose.rotation, ZERO) for pose in poses]
    axis = poses[1].rotation.T[2]
    for found, middle in reach(f, wrist[:2], centred[:1], axis, last):
        x = middle.motion.rotate_back(poses[0].rotation.T * found.motion.rotate_back(first))
        x = poses[1].rotation.T * x
        yield found, middle, type_3(f, wrist[2].joint, FIRST, x)


_WRISTS = {1: _one_axis, 2: _two_axes, 3: _three_axes}


# Orientation, then prismatic joints


def turns_then_shifts(f: Functions, chain: Chain, T: Pose) -> list[Solution]:
    """Solutions of a chain of up to three revolute joints, successive ones not parallel, and up to three slides.

    Orientation depends on the former only; the position is linear in what the latter move.
    """
    turns = [mover for mover in chain.movers if mover.turns]
    if len(turns) > 3 or len(chain.movers) - len(turns) > 3:
        reason = "there are more than three revolute or more than three prismatic joints"
        raise NoClosedForm(numbers_of(chain.movers), reason, None, ORIENTED)
    if not turns:
        return [_with_shifts(f, chain, (), T.origin)]
    before, *between, after = _between_turns(chain)
    first, last = (before.T * (T.rotation * after[k]) for k in (0, 2))
    return [_with_shifts(f, chain, angles, T.origin) for angles in _angles(f, turns, between, first, last)]


def _between_turns(chain: Chain) -> list[Matrix]:
    """Orientations of the placements between revolute joints, without prismatic joints."""
    rotations = [chain.between[0].rotation]
    for mover, pose in zip(chain.movers, chain.between[1:], strict=True):
        if mover.turns:
            rotations.append(pose.rotation)
        else:
            rotations[-1] = Pose(rotations[-1], ZERO).then(pose).rotation
    return rotations


def _angles(
    f: Functions, turns: Sequence[Mover], between: Sequence[Matrix], first: Vector, last: Vector
) -> list[Solution]:
    poses = [Pose(rotation, ZERO) for rotation in between]
    for pair, pose in zip(pairwise(turns), poses, strict=True):
        if is_along_z(f, pose.rotation.T[2]):
            raise NoClosedForm(numbers_of(pair), f"the axes of {names_in_words(pair)} are parallel", None, ORIENTED)
    return list(_WRISTS[len(turns)](f, turns, poses, first, last))


def _with_shifts(f: Functions, chain: Chain, angles: Solution, P: Vector) -> Solution:
    """The prismatic joints that bring the end of the chain to P: r1 z1 + r2 z2 + r3 z3 = P - P(r = 0)."""
    values = {value.joint: value for value in angles}
    axes: dict[int, Vector] = {}
    pose = chain.between[0]
    for mover, after in zip(chain.movers, chain.between[1:], strict=True):
        if mover.turns:
            pose = pose.moved(values[mover.joint].motion)
        else:
            axes[mover.joint] = pose.rotation.T[2]
        pose = pose.then(after)
    shifts = _SHIFTS[len(axes)](f, list(axes), list(axes.values()), P - pose.origin)
    values |= {value.joint: value for value in shifts}
    return tuple(values[mover.joint] for mover in chain.movers)


def _one_shift(f: Functions, joints: Sequence[int], z: Sequence[Vector], p: Vector) -> list[Found]:
    return [shifted_by(joints[0], dot(z[0], p))]


def _two_shifts(f: Functions, joints: Sequence[int], z: Sequence[Vector], p: Vector) -> list[Found]:
    normal = cross(z[0], z[1])
    size = dot(normal, normal)
    lengths = dot(cross(p, z[1]), normal), dot(cross(z[0], p), normal)
    return _shifts_by_quotients(f, joints, lengths, size, size)


def _three_shifts(f: Functions, joints: Sequence[int], z: Sequence[Vector], p: Vector) -> list[Found]:
    """Solve for three slides by Cramer's rule; the determinant vanishes where their directions lie in a plane."""
    normals = cross(z[1], z[2]), cross(z[2], z[0]), cross(z[0], z[1])
    volume = dot(z[0], normals[0])
    return _shifts_by_quotients(f, joints, [dot(p, n) for n in normals], volume, volume * volume)


def _shifts_by_quotients(
    f: Functions, joints: Sequence[int], over: Sequence[Scalar], under: Scalar, squared_sine: Scalar
) -> list[Found]:
    """Quotients without a value where directions are so near to dependent that digits are lost."""
    ok = only_where(f, squared_sine - FLAT)
    first, *others = (shifted_by(j, x / (under * ok)) for j, x in zip(joints, over, strict=True))
    return [first._replace(measure=f.square_root(squared_sine) / ok), *others]


_SHIFTS = {0: lambda *_: [], 1: _one_shift, 2: _two_shifts, 3: _three_shifts}


# Three parallel axes


def parallel_axes(f: Functions, chain: Chain, T: Pose) -> list[Solution]:
    """Solve C0 J1 C1 (J2 C2 J3 C3 J4) C4 J5 (C5 J6) C_n = T where the axes of joints 2, 3 and 4 are parallel."""
    arm, ends = chain.movers[1:4], chain.movers[4:]
    for mover in (*arm, *ends):
        if not mover.turns:
            raise _no_wrist([mover], f"joint {mover.joint} is prismatic")
    for pose in chain.between[2:4]:
        if not is_along_z(f, pose.rotation.T[2]):
            raise _no_wrist(arm, f"the axes of {names_in_words(arm)} are not parallel")
    arm_at_zero = reduce(Pose.then, chain.between[2:5], STILL)
    if is_along_z(f, arm_at_zero.rotation[2]):
        raise _no_wrist(chain.movers[1:5], f"the axes of {names_in_words(chain.movers[1:5])} are all parallel")
    here, there = _meeting_point(f, ends, chain.between[5:-1])
    inner = chain.between[0].inverse().then(T).then(chain.between[-1].inverse())
    height = plane(LAST, arm_at_zero.point(along(here))[2]).seen_from(chain.between[1])
    solutions: list[Solution] = []
    for first in onto_surface(f, chain.movers[0], height, inner.point(along(there))):
        target = chain.between[1].inverse().then(_undone(first.from_other_end(), inner))
        for last in _ends(f, ends, chain.between[5:-1], arm_at_zero.rotation[2], target.rotation[2]):
            solutions += [(first, *planar, *last) for planar in _planar(f, chain, target, last)]
    return solutions


def _undone(motion: Found, pose: Pose) -> Pose:
    """The product J T of a joint's motion and a pose."""
    R, p = pose
    columns = Matrix(*(motion.motion.rotate(column) for column in R.T))
    return Pose(columns.T, motion.point(p))


def _ends(f: Functions, ends: Sequence[Mover], poses: Sequence[Pose], axis: Vector, seen: Vector) -> Iterator[Solution]:
    """Solutions of the last joints that bring the direction `seen` in the last frame to that of the parallel axes."""
    if len(ends) == 1:
        yield (type_3(f, ends[0].joint, seen, axis),)
        return
    centred = [Pose(pose.rotation, ZERO) for pose in poses]
    yield from reach(f, ends, centred, seen, axis)


def _planar(f: Functions, chain: Chain, rest: Pose, last: Solution) -> list[Solution]:
    """Solutions of the three joints with parallel axes, from the solution `last` of the joints after them."""
    pose = rest
    for found, before in zip(reversed(last), reversed(chain.between[4 : 4 + len(last)]), strict=True):
        pose = pose.moved(found.from_other_end().motion).then(before.inverse())
    arm = Chain(chain.movers[1:4], (STILL, *chain.between[2:4], STILL))
    return point_then_axes(f, arm, pose, 1)
