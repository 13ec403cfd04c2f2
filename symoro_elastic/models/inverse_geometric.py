"""Inverse geometric models: all positions of the chain of joints to a frame that give the frame its placement.

The chain is solved for its joints, and these for the independent variables that they follow. Variables that do not
move the frame have no column in the result.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.mechanics.coordinates import Rows
from symoro_elastic.mechanics.inverse_geometry.decompositions import Chain
from symoro_elastic.mechanics.inverse_geometry.equation_types import STILL, Functions, NoClosedForm, Pose
from symoro_elastic.mechanics.inverse_geometry.points import Mover
from symoro_elastic.mechanics.inverse_geometry.serial_chain import (
    Branch,
    inverse_geometric_model,
    inverse_position_model,
    where_followed,
)
from symoro_elastic.mechanics.spatial import AxialTransform, Axis, Matrix, Vector, X, Z
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.chain_joints import InverseRefused, at_zero, rows_of_chain, variables_followed
from symoro_elastic.models.model import Frame, Frames, Model, Result, Results
from symoro_elastic.models.modular import zero_test
from symoro_elastic.quantities import Quantity, quantity
from symoro_elastic.symbolic.expression import Expression, is_constant, operand
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, sign, square_root
from symoro_elastic.symbolic.operations import COS
from symoro_elastic.symbolic.program import Section

POSE, POSITION = slice(0, 6), slice(0, 3)
DOUBLE_BITS = 53
"""What tells reachable places from others are bounds that are the rounding errors of doubles."""
PLACEMENT = quantity("T").entries
Solve = Callable[[Functions, Chain, Pose], list[Branch]]


class Task(NamedTuple):
    """The frame to be placed, the rows of the table on the way to it, and how it is solved.

    `rows` are those of a twist of the frame that matter.
    """

    frame: Frame
    path: Sequence[int]
    solve: Solve
    rows: slice


def _inverse_geometric_model(bound: Bound, asked: Frames) -> Results:
    return _solved(bound, asked, inverse_geometric_model, POSE)


def _inverse_position_model(bound: Bound, asked: Frames) -> Results:
    return _solved(bound, asked, lambda f, chain, T: inverse_position_model(f, chain, T.origin), POSITION)


def _target(bound: Bound) -> Pose:
    entries: Any = tuple(map(bound.graph.symbol, PLACEMENT))
    return Pose(Matrix(*(Vector(*entries[k : k + 3]) for k in (0, 4, 8))), Vector(*entries[3:12:4]))


def _solved(bound: Bound, asked: Frames, solve: Solve, rows: slice) -> Results:
    frame = _frame(bound, asked)
    task = Task(frame, _path(bound.machine, frame), solve, rows)
    try:
        branches = _branches(bound, task)
    except NoClosedForm as error:
        raise _refused(bound, task, error) from None
    _name_branches(bound, [branch for branch, _ in branches])
    variables = tuple(branches[0][1])
    q = tuple(x for _, u in branches for x in u.values())
    measures = tuple(branch.measure for branch, _ in branches)
    size = len(branches)
    return {
        "q": Result(None, q, (size, len(variables)), column_labels=_some_joints(bound.machine, variables)),
        "singularity": Result(None, measures, (size,)),
    }


def _branches(bound: Bound, task: Task) -> list[tuple[Branch, dict[int, Scalar]]]:
    """Solutions for the joints of a chain, each with the independent variables by joint."""
    f = _functions(bound)
    S = rows_of_chain(bound, task.frame, task.path, task.rows)
    followed = variables_followed(bound, f.is_zero, S)
    chain = _chain(bound, f, task.path, S)
    on_circle = partial(cosine_sine, bound.graph)
    solved = task.solve(f, chain, _target(bound))
    branches = [where_followed(f, on_circle, chain, branch, followed.followers) for branch in solved]
    return [(branch, followed.values({x.joint: x.variable for x in branch.found})) for branch in branches]


# Names


def _name_branches(bound: Bound, branches: Sequence[Branch]) -> None:
    """Name angles, lengths, their sines and cosines and what vanishes, after joint and first solution."""
    for number, branch in enumerate(branches, start=1):
        for found in branch.found:
            here = Section(f"Solution {number}", found.joint)
            bound.names.give(found.measure, f"root{found.joint}_{number}", here)
            bound.names.give(found.motion.cosine, f"cos{found.joint}_{number}", here)
            bound.names.give(found.motion.sine, f"sin{found.joint}_{number}", here)
            bound.names.give(_angle(found.motion), f"angle{found.joint}_{number}", here)
            bound.names.give(found.motion.shift, f"length{found.joint}_{number}", here)


def _angle(motion: AxialTransform) -> Scalar:
    """The angle of which a motion holds the cosine."""
    cosine = motion.cosine
    return cosine.operands[0] if isinstance(cosine, Expression) and cosine.operation == COS else 0


# The chain


def _frame(bound: Bound, asked: Frames) -> Frame:
    """The frame to be placed: the requested one, or the last one."""
    if len(asked) == 1:
        return replace(
            asked[0], number=bound.met_frame(asked[0].number), seen_from=bound.met_frame(asked[0].seen_from or 0)
        )
    if len(asked) < len(bound.machine.joints):
        raise InverseRefused(bound.machine, 0, "ask for one frame to be placed, not for several")
    return Frame(bound.met_frame(len(bound.machine.joints)))


def _some_joints(machine: Machine, variables: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the joints that own variables; none where they are all that move."""
    return () if variables == machine.independent else tuple(machine.joint(j).name for j in variables)


def _path(machine: Machine, frame: Frame) -> list[int]:
    """Joints and fixed frames between the frame it is seen from and the frame to be placed."""
    path: list[int] = []
    j, start = frame.number, frame.seen_from or 0
    while j > start:
        path.insert(0, j)
        j = machine.joint(j).antecedent
    if j != start:
        raise InverseRefused(machine, start, f"frame {start} does not carry frame {frame.number}")
    if not {*path} & {*machine.articulated}:
        raise InverseRefused(machine, 0, "no joint moves the frame to be placed")
    return path


def _chain(bound: Bound, f: Functions, path: Sequence[int], S: Rows) -> Chain:
    """Placements that are constant between joints that have rows in S, structural zeros made exact."""
    movers: list[Mover] = []
    between = [STILL]
    for j in path:
        joint = bound.machine.joint(j)
        before, after = _constant_steps(bound, j)
        for step in before:
            between[-1] = between[-1].moved(step)
        if j in S:
            movers.append(Mover(j, Axis(joint.sigma)))
            between.append(STILL)
        between[-1] = between[-1].moved(after)
    return Chain(tuple(movers), tuple(_exact(f, pose) for pose in between))


def _constant_steps(bound: Bound, j: int) -> tuple[tuple[AxialTransform, AxialTransform], AxialTransform]:
    """What comes before the variable of a joint, and its offset, which comes after."""

    def step(axis: int, angle: Scalar, shift: Scalar) -> AxialTransform:
        return AxialTransform(axis, *cosine_sine(bound.graph, angle), shift)

    joint = bound.machine.joint(j)
    gamma, b, alpha, d = bound.cells((joint.gamma, joint.b, joint.alpha, joint.d))
    theta, r = (at_zero(bound, j) if joint.sigma == k else bound.cell(x) for k, x in enumerate((joint.theta, joint.r)))
    return (step(Z, gamma, b), step(X, alpha, d)), step(Z, theta, r)


def _exact(f: Functions, pose: Pose) -> Pose:
    """Numbers as fractions, so that their quotients are exact, and zero for what is zero at all values."""

    def number(x: Scalar) -> Scalar:
        found = operand(0 if f.is_zero(x) else x)
        return found if isinstance(found, Expression) else Fraction(found)

    def vector(v: Vector) -> Vector:
        return Vector(*map(number, v))

    return Pose(Matrix(*map(vector, pose.rotation)), vector(pose.origin))


def _functions(bound: Bound) -> Functions:
    def turn(x: Scalar, y: Scalar, _: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        angle = arc_tangent(bound.graph, y, x)
        return angle, *cosine_sine(bound.graph, angle)

    return Functions(
        lambda x: square_root(bound.graph, x), turn, lambda x: sign(bound.graph, x), zero_test(), is_constant
    )


# Refusals


def _refused(bound: Bound, task: Task, error: NoClosedForm) -> InverseRefused:
    cause = _cause(bound, error)
    what = f"no inverse geometric model in closed form: {error.reason}" + (f": {cause}" if cause else "")
    zero = _zero_parameters(bound, task)
    if zero:
        say = "is zero, as its value says" if len(zero) == 1 else "are zero, as their values say"
        what += f"; there is one where {', '.join(zero)} {say}: fold {', '.join(zero)} into the code (--fold)"
    return InverseRefused(bound.machine, min(error.joints, default=0), what)


def _cause(bound: Bound, error: NoClosedForm) -> str:
    """The cells of the table that make it so; none where fixed frames lie between the joints."""
    if error.miss is None:
        return ""
    joints, (j, how) = bound.machine.joints, error.miss
    if how == "elsewhere":
        after = "" if joints[j].sigma == 2 or joints[j].b.is_zero else f" + b{j + 1}"
        return f"r{j}{after} is not zero"
    if joints[j - 1].antecedent not in error.joints:
        return ""
    return f"d{j} is not zero" if how == "apart" else f"the sine of alpha{j} is zero"


def _zero_parameters(bound: Bound, task: Task) -> list[str]:
    """Parameters whose value is zero, if there is a closed form where they are."""
    zero = [p.name for p in bound.machine.parameters if p.value is not None and p.value.value() == 0]
    if not zero:
        return []
    try:
        _branches(Bound(bound.machine, zero), task)
    except (NoClosedForm, InputError):
        return []
    return zero


FAMILY = "inverse geometry"


def _solutions(joints: int) -> Quantity:
    """Joint variables of each solution; fewer than this number of joints reach few targets."""
    return replace(
        quantity("q"),
        meaning="variables of the joints that move the frame, for each solution",
        note=f"NaN where there is none: fewer than {joints} joints need a target that is in reach to 12 digits",
        shape="solutions x n",
    )


_PLACEMENT = replace(
    quantity("T"), meaning="placement of the frame, 4 x 4, row by row", shape=str(len(PLACEMENT)), frame0=False
)
INVERSE_GEOMETRIC = (
    Model(
        "inverse_geometric_model",
        "inverse geometric model: all joint positions that place a frame",
        "(Pieper 1968, Paul 1981)",
        ("T",),
        ("q", "singularity"),
        _inverse_geometric_model,
        FAMILY,
        Parts.FRAMES,
        own=(_PLACEMENT, _solutions(6)),
        on_base=(),
        least_bits=DOUBLE_BITS,
    ),
    Model(
        "inverse_position_model",
        "inverse geometric model: all joint positions that bring the origin of a frame to a position",
        "(Pieper 1968, Paul 1981)",
        ("P",),
        ("q", "singularity"),
        _inverse_position_model,
        FAMILY,
        Parts.FRAMES,
        own=(_solutions(3),),
        on_base=(),
        least_bits=DOUBLE_BITS,
    ),
)
