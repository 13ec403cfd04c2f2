"""Inverse geometric models: all positions of the chain of joints to a frame that give the frame its placement.

Joints that are not on the way to the frame do not move it: they have no column in the result.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from symoro_elastic.equations.inverse_geometry.decompositions import Chain
from symoro_elastic.equations.inverse_geometry.equation_types import STILL, Functions, NoClosedForm, Pose
from symoro_elastic.equations.inverse_geometry.model import Branch, inverse_geometric_model, inverse_position_model
from symoro_elastic.equations.inverse_geometry.points import Mover
from symoro_elastic.equations.kinematics import frames
from symoro_elastic.equations.spatial import ZERO, AxialTransform, Axis, Matrix, Twist, Vector, X, Z, cross
from symoro_elastic.errors import InputError
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import Frame, Frames, Model, Result, Results
from symoro_elastic.models.modular import SEED, modulo_prime
from symoro_elastic.quantities import Quantity, quantity
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import ModularAngles
from symoro_elastic.symbolic.expression import Expression, Level, operand
from symoro_elastic.symbolic.finite_field import Residue
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, sign, square_root
from symoro_elastic.symbolic.operations import COS
from symoro_elastic.symbolic.program import Section

POSE, POSITION = slice(0, 6), slice(0, 3)
DOUBLE_BITS = 53
"""What tells reachable places from others are bounds that are the rounding errors of doubles."""
PLACEMENT = quantity("T").entries
Solve = Callable[[Functions, Chain, Pose], list[Branch]]


class InverseRefused(InputError):
    """Why a machine has no inverse geometric model in closed form; `joint` is the first one to blame, or 0."""

    def __init__(self, machine: Machine, joint: int, what: str) -> None:
        place = place_of(joint, machine.joint(joint)) if joint else "joints"
        super().__init__(machine.label, place, what)
        self.joint = joint


def _inverse_geometric_model(bound: Bound, asked: Frames) -> Results:
    return _solved(bound, asked, inverse_geometric_model, POSE)


def _inverse_position_model(bound: Bound, asked: Frames) -> Results:
    return _solved(bound, asked, lambda f, chain, T: inverse_position_model(f, chain, T.origin), POSITION)


def _target(bound: Bound) -> Pose:
    entries: Any = tuple(map(bound.graph.symbol, PLACEMENT))
    return Pose(Matrix(*(Vector(*entries[k : k + 3]) for k in (0, 4, 8))), Vector(*entries[3:12:4]))


def _solved(bound: Bound, asked: Frames, solve: Solve, rows: slice) -> Results:
    frame = _frame(bound.machine, asked)
    numbers = _path(bound.machine, frame)
    moving = tuple(j for j in numbers if bound.machine.joint(j).sigma != 2)
    _check_independent(bound, frame, moving, rows)
    try:
        branches = _branches(bound, numbers, solve)
    except NoClosedForm as error:
        raise _refused(bound, numbers, solve, error) from None
    _name_branches(bound, branches)
    variables = [{found.joint: found.variable for found in branch.found} for branch in branches]
    q = tuple(entries[j] for entries in variables for j in moving)
    measures = tuple(branch.measure for branch in branches)
    size = len(branches)
    return {
        "q": Result(None, q, (size, len(moving)), column_labels=_some_joints(bound.machine, moving)),
        "singularity": Result(None, measures, (size,)),
    }


def _branches(bound: Bound, numbers: Sequence[int], solve: Solve) -> list[Branch]:
    f = _functions(bound)
    return solve(f, _chain(bound, f, numbers), _target(bound))


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


def _frame(machine: Machine, asked: Frames) -> Frame:
    """The frame to be placed: the one that is asked for, or the last one."""
    if len(asked) == 1:
        return asked[0]
    if len(asked) < len(machine.joints):
        raise InverseRefused(machine, 0, "ask for one frame to be placed, not for several")
    return Frame(len(machine.joints))


def _some_joints(machine: Machine, chain: tuple[int, ...]) -> tuple[str, ...]:
    """Names of the joints of a chain; none where they are all that move."""
    return () if chain == machine.moving else tuple(machine.joint(j).name for j in chain)


def _path(machine: Machine, frame: Frame) -> list[int]:
    """Joints and fixed frames between the frame it is seen from and the frame to be placed."""
    path: list[int] = []
    j, start = frame.number, frame.seen_from or 0
    while j > start:
        path.insert(0, j)
        j = machine.joint(j).antecedent
    if j != start:
        raise InverseRefused(machine, start, f"frame {start} does not carry frame {frame.number}")
    if all(machine.joint(j).sigma == 2 for j in path):
        raise InverseRefused(machine, 0, "no joint moves the frame to be placed")
    _check_kinds(machine, path)
    return path


def _check_kinds(machine: Machine, path: Sequence[int]) -> None:
    """Refuse joints that forces move; a table without any motor is geometry only, as SYMORO's with mu = 0."""
    set_by_forces = {Kind.ELASTIC, Kind.PASSIVE} if machine.motors or machine.elastic else set()
    for j in path:
        joint = machine.joint(j)
        if joint.kind in set_by_forces:
            what = f"the joint is {joint.kind}: forces, not geometry, set where it stands"
            raise InverseRefused(machine, j, f"{what}; lock it in a scene")


def _check_independent(bound: Bound, frame: Frame, moving: Sequence[int], rows: slice) -> None:
    """Refuse joints that move against each other at every position, the frame (or its origin) being still."""
    columns = _jacobian_modulo_prime(bound, frame, moving)
    dependent = first_dependent({j: _residues(column.entries[rows]) for j, column in columns.items()})
    if not dependent:
        return
    still = f"while the frame to be placed {'stays where it is' if rows == POSE else 'keeps its origin'}"
    if len(dependent) == 1:
        what = f"it can move at every position {still}: lock it in a scene"
    else:
        what = f"{_listed(dependent)} can move against each other at every position {still}"
        what += ": the arm is redundant, lock one of them in a scene"
    raise InverseRefused(bound.machine, dependent[0], what)


def _listed(joints: Sequence[int]) -> str:
    *others, last = map(str, joints)
    return f"joints {', '.join(others)} and {last}"


def _jacobian_modulo_prime(bound: Bound, frame: Frame, moving: Sequence[int]) -> dict[int, Twist]:
    """Columns [z x P; z] or [z; 0] of a frame at a random position, exactly: zero means zero at every position."""
    mechanism = modulo_prime(bound.mechanism)
    placed = frames(mechanism)
    columns: dict[int, Twist] = {}
    for j in moving:
        z, arm = placed[j].z, placed[frame.number].origin - placed[j].origin
        columns[j] = Twist(cross(z, arm), z) if mechanism.link(j).axis is Axis.REVOLUTE else Twist(z, ZERO)
    return columns


def _residues(column: Sequence[Any]) -> list[Residue]:
    return [x if isinstance(x, Residue) else Residue(x) for x in column]


def first_dependent(columns: Mapping[int, Sequence[Residue]]) -> list[int]:
    """Keys of the first columns of exact numbers that are linearly dependent, all of them needed; else none."""
    basis: list[tuple[int, list[Residue], dict[int, Residue]]] = []
    for key, column in columns.items():
        rest, parts = list(column), {key: Residue(1)}
        for pivot, reduced, made_of in basis:
            factor = rest[pivot] / reduced[pivot]
            rest = [x - factor * y for x, y in zip(rest, reduced, strict=True)]
            for part, weight in made_of.items():
                parts[part] = parts.get(part, Residue(0)) - factor * weight
        pivots = [k for k, x in enumerate(rest) if x]
        if not pivots:
            return sorted(part for part, weight in parts.items() if weight)
        basis.append((pivots[0], rest, parts))
    return []


def _chain(bound: Bound, f: Functions, numbers: Sequence[int]) -> Chain:
    """Placements that are constant between joints that move, structural zeros made exact."""
    movers: list[Mover] = []
    between = [STILL]
    for j in numbers:
        joint = bound.machine.joint(j)
        before, after = _constant_steps(bound, joint)
        for step in before:
            between[-1] = between[-1].moved(step)
        if joint.sigma != 2:
            movers.append(Mover(j, Axis(joint.sigma)))
            between.append(STILL)
        between[-1] = between[-1].moved(after)
    return Chain(tuple(movers), tuple(_exact(f, pose) for pose in between))


def _constant_steps(bound: Bound, joint: Joint) -> tuple[tuple[AxialTransform, AxialTransform], AxialTransform]:
    """What comes before the variable of a joint, and its offset, which comes after."""

    def step(axis: int, angle: Scalar, shift: Scalar) -> AxialTransform:
        return AxialTransform(axis, *cosine_sine(bound.graph, angle), shift)

    gamma, b, alpha, d, theta, r = bound.cells((joint.gamma, joint.b, joint.alpha, joint.d, joint.theta, joint.r))
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
    residues = ModularAngles(SEED)

    def is_zero(x: Scalar) -> bool:
        return not residues.values([x])(x) if isinstance(x, Expression) else x == 0

    def turn(x: Scalar, y: Scalar, _: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        angle = arc_tangent(bound.graph, y, x)
        return angle, *cosine_sine(bound.graph, angle)

    return Functions(
        lambda x: square_root(bound.graph, x),
        turn,
        lambda x: sign(bound.graph, x),
        is_zero,
        lambda x: not isinstance(x, Expression) or x.level < Level.STATE,
    )


# Refusals


def _refused(bound: Bound, numbers: Sequence[int], solve: Solve, error: NoClosedForm) -> InverseRefused:
    cause = _cause(bound, error)
    what = f"no inverse geometric model in closed form: {error.reason}" + (f": {cause}" if cause else "")
    zero = _zero_parameters(bound, numbers, solve)
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


def _zero_parameters(bound: Bound, numbers: Sequence[int], solve: Solve) -> list[str]:
    """Parameters whose value is zero, if there is a closed form where they are."""
    zero = [p.name for p in bound.machine.parameters if p.value is not None and p.value.value() == 0]
    if not zero:
        return []
    try:
        _branches(Bound(bound.machine, zero), numbers, solve)
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
        on_coupled=False,
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
        on_coupled=False,
    ),
)
