"""Inverse geometric models: all positions of the chain of joints to a frame that give the frame its placement.

The chain is solved for its joints, and these for the independent variables that they follow. Variables that do not
move the frame have no column in the result.

The joints of a chain to a frame, and the independent variables that they follow by constant rates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.mechanics.coordinates import Row, Rows
from symoro_elastic.mechanics.inverse_geometry.decompositions import Chain
from symoro_elastic.mechanics.inverse_geometry.equation_types import STILL, Functions, NoClosedForm, Pose
from symoro_elastic.mechanics.inverse_geometry.followed import Followed, angles_of_followers
from symoro_elastic.mechanics.inverse_geometry.points import Mover
from symoro_elastic.mechanics.inverse_geometry.serial_chain import (
    Branch,
    inverse_geometric_model,
    inverse_position_model,
    where_followed,
)
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.mechanics.spatial import ZERO, AxialTransform, Axis, Matrix, Twist, Vector, X, Z, cross
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Frame, Frames, Model, Result, Results
from symoro_elastic.models.bound.rules import independent_motors
from symoro_elastic.models.tree.modular import SEED, modulo_prime, zero_test
from symoro_elastic.quantities import Quantity, quantity
from symoro_elastic.symbolic.arithmetic import ModularAngles
from symoro_elastic.symbolic.differentiation import substitute
from symoro_elastic.symbolic.expression import Expression, Level, is_constant, operand
from symoro_elastic.symbolic.finite_field import Residue
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, sign, square_root
from symoro_elastic.symbolic.operations import COS
from symoro_elastic.symbolic.program import Section

POSE, POSITION = slice(0, 6), slice(0, 3)
DOUBLE_BITS = 53
"""Mantissa bits of doubles, whose rounding errors are the bounds by which reachability is decided."""
PLACEMENT = quantity("T").entries
Solve = Callable[[Functions, Chain, Pose], list[Branch]]
Columns: TypeAlias = Mapping[int, Sequence[Residue]]
"""Exact columns of a Jacobian at a random position, by joint or by variable."""


class Task(NamedTuple):
    """The frame to be placed, by its number in the mechanism, the rows on its path, and the solver.

    `rows` are those of a twist of the frame that matter.
    """

    frame: Frame
    path: Sequence[int]
    solve: Solve
    rows: slice


def _inverse_geometric_model(bound: Bound, frames: Frames) -> Results:
    return _solve_for_joints(bound, frames, inverse_geometric_model, POSE)


def _inverse_position_model(bound: Bound, frames: Frames) -> Results:
    return _solve_for_joints(bound, frames, lambda f, chain, T: inverse_position_model(f, chain, T.origin), POSITION)


def _solve_for_joints(bound: Bound, frames: Frames, solve: Solve, rows: slice) -> Results:
    frame = _frame(bound, frames)
    task = Task(frame, _path(bound, frame), solve, rows)
    try:
        branches = _branches(bound, task)
    except NoClosedForm as error:
        raise _refusal(bound, task, error) from None
    _name_branches(bound, [branch for branch, _ in branches])
    variables = tuple(branches[0][1])
    q = tuple(x for _, u in branches for x in u.values())
    measures = tuple(branch.measure for branch, _ in branches)
    is_whole = variables == bound.machine.independent
    labels = () if is_whole else tuple(bound.machine.joint(j).name for j in variables)
    size = len(branches)
    solutions = Result(None, q, (size, len(variables)), frames, labels)
    return {"q": solutions, "singularity": Result(None, measures, (size,))}


def _branches(bound: Bound, task: Task) -> list[tuple[Branch, dict[int, Scalar]]]:
    """Solutions for the joints of a chain, each with the independent variables by joint."""
    f = _functions(bound)
    S = rows_of_chain(bound, task.frame, task.path, task.rows)
    followed = variables_followed(bound, f.is_zero, S)
    chain = _chain(bound, f, task, S)
    on_circle = partial(cosine_sine, bound.graph)
    entries: Any = tuple(map(bound.graph.symbol, PLACEMENT))
    target = Pose(Matrix(*(Vector(*entries[k : k + 3]) for k in (0, 4, 8))), Vector(*entries[3:12:4]))
    solutions = task.solve(f, chain, target)
    branches = [where_followed(f, on_circle, chain, branch, followed.followers) for branch in solutions]
    return [(branch, followed.values({x.joint: x.variable for x in branch.found})) for branch in branches]


# Names


def _name_branches(bound: Bound, branches: Sequence[Branch]) -> None:
    """Name angles, lengths, sines, cosines and singularity measures, after joint and first solution."""
    for number, branch in enumerate(branches, start=1):
        for solution in branch.found:
            here = Section(f"Solution {number}", solution.joint)
            bound.names.give(solution.measure, f"root{solution.joint}_{number}", here)
            bound.names.give(solution.motion.cosine, f"cos{solution.joint}_{number}", here)
            bound.names.give(solution.motion.sine, f"sin{solution.joint}_{number}", here)
            bound.names.give(_angle(solution.motion), f"angle{solution.joint}_{number}", here)
            bound.names.give(solution.motion.shift, f"length{solution.joint}_{number}", here)


def _angle(motion: AxialTransform) -> Scalar:
    """The angle whose cosine is that of a motion; 0 if that is not an explicit angle."""
    cosine = motion.cosine
    return cosine.operands[0] if isinstance(cosine, Expression) and cosine.operation == COS else 0


# The chain


def _frame(bound: Bound, frames: Frames) -> Frame:
    """The frame to be placed, and the one that it is seen from, by their numbers in the mechanism."""
    if len(frames) > 1:
        raise InverseRefused(bound.machine, 0, "ask for one frame to be placed, not for several")
    return replace(frames[0], number=bound.link_of(frames[0].number), seen_from=bound.link_of(frames[0].seen_from or 0))


def _path(bound: Bound, frame: Frame) -> list[int]:
    """Rows of the table between the frame it is seen from and the frame to be placed."""
    path: list[int] = []
    machine, (j, start) = bound.machine, (_row_under(bound, k) for k in (frame.number, frame.seen_from or 0))
    while j > start:
        path.insert(0, j)
        j = machine.joint(j).antecedent
    if j != start:
        raise InverseRefused(machine, start, f"frame {start} does not carry the frame to be placed")
    if not {*path} & {*machine.articulated}:
        raise InverseRefused(machine, 0, "no joint moves the frame to be placed")
    return path


def _row_under(bound: Bound, link: int) -> int:
    return bound.mechanism.link(link).antecedent if _fixed_steps(bound, link) else link


def _fixed_steps(bound: Bound, link: int) -> tuple[AxialTransform, ...]:
    """Transform steps of a frame without a row relative to the row that carries it; none for frames of rows."""
    return bound.mechanism.link(link).transform.steps if link > len(bound.machine.joints) else ()


def _chain(bound: Bound, f: Functions, task: Task, S: Rows) -> Chain:
    """Placements that are constant between joints that have rows in S, structural zeros made exact."""
    movers: list[Mover] = []
    between = [STILL]
    for step in reversed(_fixed_steps(bound, task.frame.seen_from or 0)):
        between[-1] = between[-1].moved(step._replace(sine=-step.sine, shift=-step.shift))
    for j in task.path:
        joint = bound.machine.joint(j)
        before, after = _constant_steps(bound, j)
        for step in before:
            between[-1] = between[-1].moved(step)
        if j in S:
            movers.append(Mover(j, Axis(joint.sigma)))
            between.append(STILL)
        between[-1] = between[-1].moved(after)
    for step in _fixed_steps(bound, task.frame.number):
        between[-1] = between[-1].moved(step)
    return Chain(tuple(movers), tuple(_exact(f, pose) for pose in between))


def _constant_steps(bound: Bound, j: int) -> tuple[tuple[AxialTransform, AxialTransform], AxialTransform]:
    """The constant steps before the variable of a joint, and its offset after the variable."""

    def step(axis: int, angle: Scalar, shift: Scalar) -> AxialTransform:
        return AxialTransform(axis, *cosine_sine(bound.graph, angle), shift)

    joint = bound.machine.joint(j)
    gamma, b, alpha, d = bound.cells((joint.gamma, joint.b, joint.alpha, joint.d))
    theta, r = (at_zero(bound, j) if joint.sigma == k else bound.cell(x) for k, x in enumerate((joint.theta, joint.r)))
    return (step(Z, gamma, b), step(X, alpha, d)), step(Z, theta, r)


def _exact(f: Functions, pose: Pose) -> Pose:
    """Return a pose with numbers as fractions, whose quotients are exact, and zero for what vanishes identically."""

    def number(x: Scalar) -> Scalar:
        value = operand(0 if f.is_zero(x) else x)
        return value if isinstance(value, Expression) else Fraction(value)

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


def _refusal(bound: Bound, task: Task, error: NoClosedForm) -> InverseRefused:
    cause = _cause(bound, error)
    what = f"no inverse geometric model in closed form: {error.reason}" + (f": {cause}" if cause else "")
    zero = _zero_parameters(bound, task)
    if zero:
        say = "is zero, as its value says" if len(zero) == 1 else "are zero, as their values say"
        what += f"; there is one where {', '.join(zero)} {say}: fold {', '.join(zero)} into the code (--fold)"
    return InverseRefused(bound.machine, min(error.joints, default=0), what)


def _cause(bound: Bound, error: NoClosedForm) -> str:
    """The cells of the table that prevent a closed form; empty where fixed frames lie between the joints."""
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
        _branches(Bound(bound.machine, zero, bound.points), task)
    except (NoClosedForm, InputError):
        return []
    return zero


def _solutions(joints: int) -> Quantity:
    """The quantity of joint variables by solution, with a note on chains of fewer than this number of joints."""
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
        Parts.FRAMES,
        own=(_solutions(3),),
        on_base=(),
        least_bits=DOUBLE_BITS,
    ),
)


class InverseRefused(InputError):
    """Reason why a machine has no inverse geometric model in closed form; `joint` is the first cause, or 0."""

    def __init__(self, machine: Machine, joint: int, what: str) -> None:
        place = place_of(joint, machine.joint(joint)) if joint else "joints"
        super().__init__(machine.label, place, what)
        self.joint = joint


def rows_of_chain(bound: Bound, frame: Frame, path: Sequence[int], rows_of_twist: slice) -> Rows:
    """Rows of S of the joints on a path that move a frame, by the rows `rows_of_twist` of its twist.

    All entries are constant, and no variable can move without the frame. Raises `InverseRefused`.
    """
    S = {j: _row(bound, j) for j in path if j in bound.machine.articulated}
    _check_kinds(bound, sorted({v for row in S.values() for v in row}))
    angles = ModularAngles(SEED)
    columns = _jacobian_modulo_prime(bound, frame, S, angles, rows_of_twist)
    still = f"while the frame to be placed {'stays where it is' if len(columns[min(S)]) == 6 else 'keeps its origin'}"
    _check_variables(bound, _by_variable(S, columns, angles), still)
    moving = {j: row for j, row in S.items() if any(columns[j])}
    _check_joints(bound, {j: columns[j] for j in moving}, still)
    return moving


def at_zero(bound: Bound, j: int) -> Scalar:
    """Position of joint j where all variables are zero, rad or m."""
    zero = {x.operands[0]: 0 for x in bound.q.values()}
    return substitute(bound.graph, [bound.angle(j)], zero)[0]


def variables_followed(bound: Bound, is_zero: Callable[[Scalar], bool], S: Rows) -> Followed:
    """Formulas of independent variables by positions of the joints that follow them. Raises `InverseRefused`."""
    slides = [j for j in S if bound.machine.joint(j).sigma == 1]
    followed = angles_of_followers(is_zero, S, slides)
    if followed is None:
        what = f"{_joint_list(S)}: their angles are known only up to whole turns, so the variables are ambiguous"
        way_out = "fold their ratios into the code (--fold), or ask for another frame"
        raise InverseRefused(bound.machine, min(S), f"{what}: {way_out}")
    return followed


def _row(bound: Bound, j: int) -> Row:
    """Row of S of joint j. Raises `InverseRefused` where it changes with the position."""
    row = bound.coordinates.S[j]
    if any(isinstance(x, Expression) and x.level is Level.STATE for x in row.values()):
        raise InverseRefused(bound.machine, j, _not_linear(bound, j))
    return row


def _not_linear(bound: Bound, j: int) -> str:
    joint = bound.machine.joint(j)
    owners = {j, *(bound.machine.variables[x] for x in joint.selected.names & bound.machine.variables.keys())}
    loops = [loop.loop.name for loop in bound.loops if not owners.isdisjoint(loop.dependent)]
    if not loops:
        return f"{joint.selected.text!r} is not a linear formula of {', '.join(sorted(joint.selected.names))}"
    what = f"it follows from loop {loops[0]}, and not by sums of angles"
    return f"{what}: make it independent, choose other dependent joints (dependent = [...])"


def _check_kinds(bound: Bound, variables: Sequence[int]) -> None:
    """Refuse variables that forces set; a table without any motor is geometry only, as SYMORO's with mu = 0."""
    machine = bound.machine
    set_by_forces = {Kind.ELASTIC, Kind.PASSIVE} if machine.motors or machine.elastic else set()
    if _motors_set_all(bound):
        set_by_forces.discard(Kind.PASSIVE)
    for j in variables:
        joint = machine.joint(j)
        if joint.kind in set_by_forces:
            what = f"the joint is {joint.kind}: forces, not geometry, set where it stands"
            raise InverseRefused(machine, j, f"{what}; lock it in a scene")


def _motors_set_all(bound: Bound) -> bool:
    """Whether motors on dependent joints determine, with the springs, all independent variables."""
    if not any(j in bound.machine.dependent for j in bound.motors):
        return False
    rows = {j: bound.coordinates.S_x[j] for j in (*bound.motors, *bound.machine.elastic)}
    return len(independent_motors(bound, rows)) == len(bound.machine.independent)


# Redundant chains


def _jacobian_modulo_prime(
    bound: Bound, frame: Frame, joints: Iterable[int], angles: ModularAngles, rows_of_twist: slice
) -> Columns:
    """Columns [z x P; z] or [z; 0] of a frame at a random position, exactly: zero means zero at every position."""
    mechanism = modulo_prime(bound.mechanism, angles)
    poses = frames(mechanism)
    columns: dict[int, list[Residue]] = {}
    for j in joints:
        z, arm = poses[j].z, poses[frame.number].origin - poses[j].origin
        twist = Twist(cross(z, arm), z) if mechanism.link(j).axis is Axis.REVOLUTE else Twist(z, ZERO)
        entries: Any = twist.entries[rows_of_twist]
        columns[j] = [x if isinstance(x, Residue) else Residue(x) for x in entries]
    return columns


def _by_variable(S: Rows, columns: Columns, angles: ModularAngles) -> Columns:
    """Columns of the independent variables: columns of the joints times S."""
    value = angles.values(x for row in S.values() for x in row.values())
    sums: dict[int, list[Residue]] = {}
    for j, row in S.items():
        for v, x in row.items():
            before = sums.get(v, [Residue(0)] * len(columns[j]))
            sums[v] = [a + b * value(x) for a, b in zip(before, columns[j], strict=True)]
    return {v: sums[v] for v in sorted(sums)}


def _check_variables(bound: Bound, columns: Columns, still: str) -> None:
    """Refuse variables that move against each other at every position, the frame (or its origin) being still."""
    dependent = first_dependent(columns)
    if not dependent:
        return
    if len(dependent) == 1:
        what = f"it can move at every position {still}: lock it in a scene"
    else:
        what = f"{_joint_list(dependent)} can move against each other at every position {still}"
        what += ": the arm is redundant, lock one of them in a scene"
    raise InverseRefused(bound.machine, dependent[0], what)


def _check_joints(bound: Bound, columns: Columns, still: str) -> None:
    """Reject joints that would be redundant if they were independent."""
    dependent = first_dependent(columns)
    if dependent:
        what = f"{_joint_list(dependent)} follow fewer variables; alone they could move against each other {still}"
        what += ", so the inverse geometric model has no closed form: ask for a frame before them"
        raise InverseRefused(bound.machine, dependent[0], what)


def first_dependent(columns: Columns) -> list[int]:
    """Keys of the first columns of exact numbers that are linearly dependent, all of them needed; else none."""
    basis: list[tuple[int, list[Residue], dict[int, Residue]]] = []
    for key, column in columns.items():
        remainder, parts = list(column), {key: Residue(1)}
        for pivot, reduced, made_of in basis:
            factor = remainder[pivot] / reduced[pivot]
            remainder = [x - factor * y for x, y in zip(remainder, reduced, strict=True)]
            for part, weight in made_of.items():
                parts[part] = parts.get(part, Residue(0)) - factor * weight
        pivots = [k for k, x in enumerate(remainder) if x]
        if not pivots:
            return sorted(part for part, weight in parts.items() if weight)
        basis.append((pivots[0], remainder, parts))
    return []


def _joint_list(joints: Iterable[int]) -> str:
    *first, last = map(str, joints)
    return f"joints {', '.join(first)} and {last}" if first else f"joint {last}"
