"""Inverse geometric model of a serial chain: every joint position that gives a frame its placement.

A chain is C0 J1 C1 J2 ... Jn Cn = T with J a turn about z or a shift along z and C constant. It is
solved where it falls apart into parts that closed forms know (Pieper 1968, Paul 1981, Khalil and
Dombre 2002, chapter 4), from the base or, as T^-1 is a chain too, from its end:

- up to three joints, then one to three revolute joints whose axes meet in a point: the former
  place this point, the latter give the orientation;
- up to three revolute joints, which give the orientation, and up to three prismatic ones among them,
  whose positions enter linearly;
- three revolute joints with parallel axes between one joint and one or two revolute joints: height
  and direction of the parallel axes do not see the three, which are a planar arm.

With less than six joints T must be one of the placements they can give. What is found is put back
then; a solution that misses T has no value (NaN).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from typing import NamedTuple, TypeAlias

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.coordinates import Rows, product
from symoro_elastic.mechanics.inverse_geometry.decompositions import (
    NO_WRIST,
    ORIENTED,
    Chain,
    arms_to,
    parallel_axes,
    point_then_axes,
    turns_then_shifts,
)
from symoro_elastic.mechanics.inverse_geometry.equation_types import Functions, NoClosedForm, Pose, only_where
from symoro_elastic.mechanics.inverse_geometry.points import Solution, from_other_end, numbers_of
from symoro_elastic.mechanics.spatial import ZERO, Matrix, Scalar, Vector, cross, dot

MISSED = Fraction(1, 2**34)
NOT_A_PLACEMENT = Fraction(1, 2**20)
OnCircle: TypeAlias = Callable[[Scalar], tuple[Scalar, Scalar]]


class Branch(NamedTuple):
    """One solution: the joints in the order of the chain and a measure that is zero where it is singular."""

    found: Solution
    measure: Scalar


def inverse_geometric_model(f: Functions, chain: Chain, T: Pose) -> list[Branch]:
    """All positions of the joints (rad, m) that place the end of the chain at T (m).

    `T` is 0T of the last frame. The measure is the product of the square roots and distances that vanish in
    singular positions (m^k). A solution that does not exist is NaN, its measure too. Raises `NoClosedForm`.
    """
    if len(chain.movers) > 6:
        reason = f"{len(chain.movers)} joints move: more than six have infinitely many solutions"
        raise NoClosedForm(numbers_of(chain.movers), reason)
    if len(chain.movers) == 6:
        T = _placement(f, T)
    branches = [_branch(f, solution) for solution in solutions(f, chain, T)]
    return branches if len(chain.movers) == 6 else [_put_back(f, chain, T, branch) for branch in branches]


def inverse_position_model(f: Functions, chain: Chain, P: Vector) -> list[Branch]:
    """All positions of up to three joints (rad, m) that bring the origin of the last frame to P (m).

    Raises `NoClosedForm`.
    """
    if len(chain.movers) > 3:
        reason = f"a position in space determines at most three joints, and {len(chain.movers)} move"
        raise NoClosedForm(numbers_of(chain.movers), reason)
    branches = [_branch(f, solution) for solution in arms_to(f, chain, P)]
    if len(chain.movers) == 3:
        return branches
    return [_only_close(f, branch, [], _end_pose(chain, branch.found).origin - P, P) for branch in branches]


def solutions(f: Functions, chain: Chain, T: Pose) -> list[Solution]:
    """Solutions that place the end of a chain at T, by the first decomposition that applies.

    Raises `NoClosedForm` with the reason of the nearest miss.
    """
    reasons: list[NoClosedForm] = []
    for attempt in _ways(chain):
        for turned in (False, True):
            try:
                if turned:
                    return [from_other_end(s) for s in attempt(f, chain.from_other_end(), T.inverse())]
                return attempt(f, chain, T)
            except NoClosedForm as error:
                reasons.append(error)
    raise _nearest(reasons, len(chain.movers))


def _nearest(reasons: Sequence[NoClosedForm], n: int) -> NoClosedForm:
    candidates = [reason for reason in reasons if reason.condition != ORIENTED]
    return candidates[-2] if n < 4 else next((x for x in candidates if x.condition != NO_WRIST), candidates[0])


def _ways(chain: Chain) -> Iterator[Callable[[Functions, Chain, Pose], list[Solution]]]:
    """Yield solvers of the chain: by orientation first where it needs no square root, and last where it needs one."""
    n, turns = len(chain.movers), sum(mover.turns for mover in chain.movers)
    if turns < 3:
        yield turns_then_shifts
    for k in range(min(3, n), max(n - 4, -1), -1):
        yield partial(point_then_axes, k=k)
    if turns == 3:
        yield turns_then_shifts
    if n > 4:
        yield parallel_axes


def _branch(f: Functions, solution: Solution) -> Branch:
    """A solution with its singularity measure; joints have no value where the measure has none."""
    measure: Scalar = 1
    for value in solution:
        measure = measure * value.measure
    return Branch(_valid_where(solution, f.sign(measure + 1)), measure)


def _valid_where(solution: Solution, one: Scalar) -> Solution:
    """The solution where `one` is one, no values where it is NaN; motions are unchanged."""
    return tuple(value._replace(variable=value.variable / one) for value in solution)


# Is it so?


def _placement(f: Functions, T: Pose) -> Pose:
    """The pose T, NaN where its rotation matrix is not valid."""
    x, y, z = T.rotation
    faults = [dot(x, x) - 1, dot(y, y) - 1, dot(x, y), *(cross(x, y) - z)]
    ok = only_where(f, NOT_A_PLACEMENT * NOT_A_PLACEMENT - _squares(faults))
    return Pose(Matrix(*(Vector(r.x / ok, r.y / ok, r.z / ok) for r in T.rotation)), T.origin)


def _put_back(f: Functions, chain: Chain, T: Pose, branch: Branch) -> Branch:
    """A branch, NaN where it does not place the end of the chain at T."""
    pose = _end_pose(chain, branch.found)
    turns = [x for ours, given in zip(pose.rotation, T.rotation, strict=True) for x in ours - given]
    return _only_close(f, branch, turns, pose.origin - T.origin, T.origin)


def _end_pose(chain: Chain, solution: Solution) -> Pose:
    pose = chain.between[0]
    for value, after in zip(solution, chain.between[1:], strict=True):
        pose = pose.moved(value.motion).then(after)
    return pose


def _only_close(f: Functions, branch: Branch, turns: list[Scalar], shifts: Vector, P: Vector) -> Branch:
    size = 1 + dot(P, P)
    ok = only_where(f, MISSED * MISSED * size - (_squares(turns) * size + _squares(shifts)))
    return Branch(_valid_where(branch.found, ok), branch.measure / ok)


def where_followed(f: Functions, on_circle: OnCircle, chain: Chain, branch: Branch, followers: Rows) -> Branch:
    """A branch, NaN where followers do not follow: x_j must be the row of `followers` times x.

    `on_circle` gives cosine and sine.
    """
    x = {value.joint: value.variable for value in branch.found}
    for mover in chain.movers:
        if mover.joint in followers:
            away = x[mover.joint] - product(followers[mover.joint], x)
            cosine, sine = on_circle(away) if mover.turns else (1, away)
            branch = _only_close(f, branch, [1 - cosine, sine], ZERO, ZERO)
    return branch


def _squares(faults: Iterable[Scalar]) -> Scalar:
    return sum_of(x * x for x in faults)
