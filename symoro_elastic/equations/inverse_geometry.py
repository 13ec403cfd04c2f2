"""Inverse geometric model of a serial chain: every joint position that gives a frame its placement.

A chain is C0 J1 C1 J2 ... Jn Cn = T with J a turn about z or a shift along z and C constant. It is
solved where it falls apart into parts that closed forms know (Pieper 1968, Paul 1981, Khalil and
Dombre 2002, chapter 4), from the base or, as T^-1 is a chain too, from its end:

- up to three joints, then one to three revolute joints whose axes meet in a point: the former
  place this point, the latter give the orientation;
- up to three revolute joints, which give the orientation, and up to three prismatic ones among them,
  of which the position is a linear function;
- three revolute joints with parallel axes between one joint and one or two revolute joints: height
  and direction of the parallel axes do not see the three, which are a planar arm.

With less than six joints T must be one of the placements they can give. What is found is put back
then; a solution that misses T has no value (NaN).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial, reduce
from itertools import pairwise
from typing import NamedTuple

from symoro_elastic.equations.inverse_geometry_points import (
    Mover,
    Solution,
    meeting,
    named,
    numbers_of,
    onto_surface,
    reach,
)
from symoro_elastic.equations.inverse_geometry_types import (
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
from symoro_elastic.equations.spatial import (
    ZERO,
    Matrix,
    Scalar,
    Vector,
    cross,
    dot,
    subtract,
    times,
    transpose,
    turn,
    turn_back,
)

MISSED = Fraction(1, 2**34)
FLAT = Fraction(1, 2**36)
NOT_A_PLACEMENT = Fraction(1, 2**20)
NO_WRIST, ORIENTED = "no wrist", "orientation does not give the angles"
FIRST: Vector = (1, 0, 0)
LAST: Vector = (0, 0, 1)


class Chain(NamedTuple):
    """C0 J1 C1 ... Jn Cn: the joints that move and the placements before, between and after them."""

    movers: tuple[Mover, ...]
    between: tuple[Pose, ...]

    def reversed(self) -> Chain:
        """The same chain from its other end."""
        return Chain(self.movers[::-1], tuple(pose.inverse() for pose in reversed(self.between)))


class Branch(NamedTuple):
    """One solution: the joints in the order of the chain and a measure that is zero where it is singular."""

    found: Solution
    measure: Scalar


def inverse_geometric_model(f: Functions, chain: Chain, T: Pose) -> list[Branch]:
    """Every position of the joints (rad, m) that places the end of the chain at T (m).

    `T` is 0T of the last frame. The measure is the product of the square roots and distances that vanish in
    singular positions (m^k). A solution that does not exist is NaN, its measure too. Raises `NoClosedForm`.
    """
    _check_number(chain)
    if len(chain.movers) == 6:
        T = _placement(f, T)
    branches = [_branch(f, solution) for solution in _solutions(f, chain, T)]
    return branches if len(chain.movers) == 6 else [_put_back(f, chain, T, branch) for branch in branches]


def inverse_position_model(f: Functions, chain: Chain, P: Vector) -> list[Branch]:
    """Every position of up to three joints (rad, m) that brings the origin of the last frame to P (m).

    Raises `NoClosedForm`.
    """
    if len(chain.movers) > 3:
        reason = f"a place in space determines three joints at most, and {len(chain.movers)} move"
        raise NoClosedForm(numbers_of(chain.movers), reason)
    branches = [_branch(f, solution) for solution in _arms(f, chain, P)]
    if len(chain.movers) == 3:
        return branches
    return [_with_origin_put_back(f, chain, P, branch) for branch in branches]


def _check_number(chain: Chain) -> None:
    if len(chain.movers) > 6:
        reason = f"{len(chain.movers)} joints move: with more than six there is no finite number of solutions"
        raise NoClosedForm(numbers_of(chain.movers), reason)


def _solutions(f: Functions, chain: Chain, T: Pose) -> list[Solution]:
    """By the first way that works; the reason of the nearest miss where none does."""
    reasons: list[NoClosedForm] = []
    for attempt in _ways(chain):
        for turned in (False, True):
            try:
                if turned:
                    return [_reversed(s) for s in attempt(f, chain.reversed(), T.inverse())]
                return attempt(f, chain, T)
            except NoClosedForm as error:
                reasons.append(error)
    raise _nearest(reasons, len(chain.movers))


def _nearest(reasons: Sequence[NoClosedForm], n: int) -> NoClosedForm:
    others = [reason for reason in reasons if reason.condition != ORIENTED]
    return others[-2] if n < 4 else next((reason for reason in others if reason.condition != NO_WRIST), others[0])


def _ways(chain: Chain) -> Iterator[Callable[[Functions, Chain, Pose], list[Solution]]]:
    """First orientation where it gives the angles without a square root, and last where it needs one."""
    n, turns = len(chain.movers), sum(mover.turns for mover in chain.movers)
    if turns < 3:
        yield _turns_then_shifts
    for k in range(min(3, n), max(n - 4, -1), -1):
        yield partial(_point_then_axes, k=k)
    if turns == 3:
        yield _turns_then_shifts
    if n > 4:
        yield _parallel_axes


def _reversed(solution: Solution) -> Solution:
    return tuple(found.reversed() for found in reversed(solution))


def _branch(f: Functions, solution: Solution) -> Branch:
    """A solution and its measure; no joint has a value where the measure has none."""
    measure = reduce(lambda a, b: a * b, (found.measure for found in solution), 1)
    return Branch(_divided(solution, f.sign(measure + 1)), measure)


def _divided(solution: Solution, one: Scalar) -> Solution:
    """The same solution where `one` is one, none where it is NaN; motions stay as they are."""
    return tuple(found._replace(variable=found.variable / one) for found in solution)


def _arms(f: Functions, chain: Chain, P: Vector) -> list[Solution]:
    """What brings the origin of the last frame to P."""
    return reach(f, chain.movers, chain.between[1:-1], chain.between[-1].origin, chain.between[0].point_back(P))


# A point, then axes that meet in it


def _point_then_axes(f: Functions, chain: Chain, T: Pose, k: int) -> list[Solution]:
    """The last k axes are taken for the wrist."""
    m = len(chain.movers) - k
    wrist, poses = chain.movers[m:], chain.between[m + 1 : -1]
    here, there = _meeting_point(f, wrist, poses)
    if k == 0:
        return _arms(f, chain, T.origin)
    inner = chain.between[0].inverse().then(T).then(chain.between[-1].inverse())
    target = inner.point(along(there))
    arms = reach(f, chain.movers[:m], chain.between[1:m], chain.between[m].point(along(here)), target)
    solutions = []
    for arm in arms:
        first, last = (_carried(chain, arm, times(inner.rotation, axis)) for axis in (FIRST, LAST))
        solutions += [(*arm, *ends) for ends in _WRISTS[k](f, wrist, poses, first, last)]
    return solutions


def _meeting_point(f: Functions, wrist: Sequence[Mover], poses: Sequence[Pose]) -> tuple[Scalar, Scalar]:
    """Where up to three axes meet: z in the frame of the first, z in the frame of the last. Raises `NoClosedForm`."""
    for mover in wrist:
        if not mover.turns:
            raise _no_wrist([mover], f"joint {mover.joint} is prismatic: {named(wrist)} make no wrist")
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
    return f"the axes of {named(wrist)} do not meet in one point"


def _no_wrist(movers: Sequence[Mover], reason: str, miss: Miss | None = None) -> NoClosedForm:
    return NoClosedForm(numbers_of(movers), reason, miss, NO_WRIST)


def _carried(chain: Chain, arm: Solution, v: Vector) -> Vector:
    """Components, after the joints of an arm and the placement that follows, of a vector given before them."""
    for found, pose in zip(arm, chain.between[1:], strict=False):
        v = times(transpose(pose.rotation), turn_back(found.motion, v))
    return v


def _one_axis(
    f: Functions, wrist: Sequence[Mover], _: Sequence[Pose], first: Vector, last: Vector
) -> Iterator[Solution]:
    """Rot(z, q1) = M."""
    yield (type_3(f, wrist[0].joint, FIRST, first),)


def _two_axes(
    f: Functions, wrist: Sequence[Mover], poses: Sequence[Pose], first: Vector, last: Vector
) -> Iterator[Solution]:
    """Rot(z, q1) R Rot(z, q2) = M: the last column gives q1, the first q2."""
    found = type_3(f, wrist[0].joint, transpose(poses[0].rotation)[2], last)
    x = times(transpose(poses[0].rotation), turn_back(found.motion, first))
    yield found, type_3(f, wrist[1].joint, FIRST, x)


def _three_axes(
    f: Functions, wrist: Sequence[Mover], poses: Sequence[Pose], first: Vector, last: Vector
) -> Iterator[Solution]:
    """Rot(z, q1) R Rot(z, q2) S Rot(z, q3) = M: its last column is a point to be reached, its first gives q3."""
    centred = [Pose(pose.rotation, (0, 0, 0)) for pose in poses]
    axis = transpose(poses[1].rotation)[2]
    for found, middle in reach(f, wrist[:2], centred[:1], axis, last):
        x = turn_back(middle.motion, times(transpose(poses[0].rotation), turn_back(found.motion, first)))
        x = times(transpose(poses[1].rotation), x)
        yield found, middle, type_3(f, wrist[2].joint, FIRST, x)


_WRISTS = {1: _one_axis, 2: _two_axes, 3: _three_axes}


# Orientation, then prismatic joints


def _turns_then_shifts(f: Functions, chain: Chain, T: Pose) -> list[Solution]:
    """Up to three revolute joints, neighbours among them not parallel, and up to three prismatic ones, in any order.

    Orientation depends on the former only; the position is linear in what the latter move.
    """
    turns = [mover for mover in chain.movers if mover.turns]
    if len(turns) > 3 or len(chain.movers) - len(turns) > 3:
        reason = "there are more than three revolute or more than three prismatic joints"
        raise NoClosedForm(numbers_of(chain.movers), reason, None, ORIENTED)
    if not turns:
        return [_with_shifts(f, chain, (), T.origin)]
    before, *between, after = _between_turns(chain)
    first, last = (times(transpose(before), times(T.rotation, after[k])) for k in (0, 2))
    return [_with_shifts(f, chain, angles, T.origin) for angles in _angles(f, turns, between, first, last)]


def _between_turns(chain: Chain) -> list[Matrix]:
    """Orientations of the placements between revolute joints, prismatic ones left out."""
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
        if is_along_z(f, transpose(pose.rotation)[2]):
            raise NoClosedForm(numbers_of(pair), f"the axes of {named(pair)} are parallel", None, ORIENTED)
    return list(_WRISTS[len(turns)](f, turns, poses, first, last))


def _with_shifts(f: Functions, chain: Chain, angles: Solution, P: Vector) -> Solution:
    """The prismatic joints that bring the end of the chain to P: r1 z1 + r2 z2 + r3 z3 = P - P(r = 0)."""
    known = {found.joint: found for found in angles}
    axes: dict[int, Vector] = {}
    pose = chain.between[0]
    for mover, after in zip(chain.movers, chain.between[1:], strict=True):
        if mover.turns:
            pose = pose.moved(known[mover.joint].motion)
        else:
            axes[mover.joint] = transpose(pose.rotation)[2]
        pose = pose.then(after)
    shifts = _SHIFTS[len(axes)](f, list(axes), list(axes.values()), subtract(P, pose.origin))
    known |= {found.joint: found for found in shifts}
    return tuple(known[mover.joint] for mover in chain.movers)


def _one_shift(f: Functions, joints: Sequence[int], z: Sequence[Vector], p: Vector) -> list[Found]:
    return [shifted_by(joints[0], dot(z[0], p))]


def _two_shifts(f: Functions, joints: Sequence[int], z: Sequence[Vector], p: Vector) -> list[Found]:
    normal = cross(z[0], z[1])
    size = dot(normal, normal)
    lengths = dot(cross(p, z[1]), normal), dot(cross(z[0], p), normal)
    return _shifts_by_quotients(f, joints, lengths, size, size)


def _three_shifts(f: Functions, joints: Sequence[int], z: Sequence[Vector], p: Vector) -> list[Found]:
    """By Cramer's rule; the determinant vanishes where the three lie in a plane."""
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


def _parallel_axes(f: Functions, chain: Chain, T: Pose) -> list[Solution]:
    """C0 J1 C1 (J2 C2 J3 C3 J4) C4 J5 (C5 J6) C_n = T with the axes of 2, 3 and 4 parallel."""
    arm, ends = chain.movers[1:4], chain.movers[4:]
    for mover in (*arm, *ends):
        if not mover.turns:
            raise _no_wrist([mover], f"joint {mover.joint} is prismatic")
    for pose in chain.between[2:4]:
        if not is_along_z(f, transpose(pose.rotation)[2]):
            raise _no_wrist(arm, f"the axes of {named(arm)} are not parallel")
    arm_at_zero = reduce(Pose.then, chain.between[2:5], STILL)
    if is_along_z(f, arm_at_zero.rotation[2]):
        raise _no_wrist(chain.movers[1:5], f"the axes of {named(chain.movers[1:5])} are all parallel")
    here, there = _meeting_point(f, ends, chain.between[5:-1])
    inner = chain.between[0].inverse().then(T).then(chain.between[-1].inverse())
    height = plane(LAST, arm_at_zero.point(along(here))[2]).seen_from(chain.between[1])
    solutions: list[Solution] = []
    for first in onto_surface(f, chain.movers[0], height, inner.point(along(there))):
        rest = chain.between[1].inverse().then(_undone(first.reversed(), inner))
        for last in _ends(f, ends, chain.between[5:-1], arm_at_zero.rotation[2], rest.rotation[2]):
            solutions += [(first, *planar, *last) for planar in _planar(f, chain, rest, last)]
    return solutions


def _undone(motion: Found, pose: Pose) -> Pose:
    """J T."""
    R, p = pose
    x, y, z = (turn(motion.motion, column) for column in transpose(R))
    return Pose(transpose((x, y, z)), motion.point(p))


def _ends(f: Functions, ends: Sequence[Mover], poses: Sequence[Pose], axis: Vector, seen: Vector) -> Iterator[Solution]:
    """Turns of the last joints that bring the direction of the parallel axes where it is seen in the last frame."""
    if len(ends) == 1:
        yield (type_3(f, ends[0].joint, seen, axis),)
        return
    centred = [Pose(pose.rotation, (0, 0, 0)) for pose in poses]
    yield from reach(f, ends, centred, seen, axis)


def _planar(f: Functions, chain: Chain, rest: Pose, last: Solution) -> list[Solution]:
    """The three parallel axes, all else being known."""
    pose = rest
    for found, before in zip(reversed(last), reversed(chain.between[4 : 4 + len(last)]), strict=True):
        pose = pose.moved(found.reversed().motion).then(before.inverse())
    arm = Chain(chain.movers[1:4], (STILL, *chain.between[2:4], STILL))
    return _point_then_axes(f, arm, pose, 1)


# Is it so?


def _placement(f: Functions, T: Pose) -> Pose:
    """T, without a value where its rotation is none."""
    x, y, z = T.rotation
    faults = [dot(x, x) - 1, dot(y, y) - 1, dot(x, y), *subtract(cross(x, y), z)]
    ok = only_where(f, NOT_A_PLACEMENT * NOT_A_PLACEMENT - _squares(faults))
    R: Matrix = tuple((r[0] / ok, r[1] / ok, r[2] / ok) for r in T.rotation)  # type: ignore[assignment]
    return Pose(R, T.origin)


def _put_back(f: Functions, chain: Chain, T: Pose, branch: Branch) -> Branch:
    """A branch, without a value where it does not place the end of the chain at T."""
    found = _placed(chain, branch.found)
    turns = [x for rows in zip(found.rotation, T.rotation, strict=True) for x in subtract(*rows)]
    return _only_close(f, branch, turns, subtract(found.origin, T.origin), T.origin)


def _with_origin_put_back(f: Functions, chain: Chain, P: Vector, branch: Branch) -> Branch:
    return _only_close(f, branch, [], subtract(_placed(chain, branch.found).origin, P), P)


def _placed(chain: Chain, solution: Solution) -> Pose:
    pose = chain.between[0]
    for found, after in zip(solution, chain.between[1:], strict=True):
        pose = pose.moved(found.motion).then(after)
    return pose


def _only_close(f: Functions, branch: Branch, turns: list[Scalar], shifts: Vector, P: Vector) -> Branch:
    size = 1 + dot(P, P)
    ok = only_where(f, MISSED * MISSED * size - (_squares(turns) * size + _squares(list(shifts))))
    return Branch(_divided(branch.found, ok), branch.measure / ok)


def _squares(faults: list[Scalar]) -> Scalar:
    return reduce(lambda a, b: a + b, (x * x for x in faults), 0)
