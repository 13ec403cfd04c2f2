"""The joints of a chain to a frame, and the independent variables that they follow by constant rates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.mechanics.coordinates import Row, Rows
from symoro_elastic.mechanics.inverse_geometry.followed import Followed, angles_of_followers
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.mechanics.spatial import ZERO, Axis, Twist, cross
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.driving import independent_motors
from symoro_elastic.models.model import Frame
from symoro_elastic.models.modular import SEED, modulo_prime
from symoro_elastic.symbolic.arithmetic import ModularAngles
from symoro_elastic.symbolic.differentiation import substitute
from symoro_elastic.symbolic.expression import Expression, Level
from symoro_elastic.symbolic.finite_field import Residue

Columns: TypeAlias = Mapping[int, Sequence[Residue]]
"""By joint, or by variable: what its rate does to a frame at a random position, exactly."""


class InverseRefused(InputError):
    """Why a machine has no inverse geometric model in closed form; `joint` is the first one to blame, or 0."""

    def __init__(self, machine: Machine, joint: int, what: str) -> None:
        place = place_of(joint, machine.joint(joint)) if joint else "joints"
        super().__init__(machine.label, place, what)
        self.joint = joint


def rows_of_chain(bound: Bound, frame: Frame, path: Sequence[int], wanted: slice) -> Rows:
    """Rows of S of the joints on a path that move a frame, of whose twist some rows are `wanted`.

    All entries are constant, and no variable can move without the frame. Raises `InverseRefused`.
    """
    S = {j: _row(bound, j) for j in path if j in bound.machine.articulated}
    _check_kinds(bound, sorted({v for row in S.values() for v in row}))
    angles = ModularAngles(SEED)
    columns = _jacobian_modulo_prime(bound, frame, S, angles, wanted)
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
    """Independent variables from positions of the joints that follow them. Raises `InverseRefused`."""
    slides = [j for j in S if bound.machine.joint(j).sigma == 1]
    found = angles_of_followers(is_zero, S, slides)
    if found is None:
        what = f"{_listed(S)}: their angles are known only up to whole turns, so the variables are ambiguous"
        way_out = "fold their ratios into the code (--fold), or ask for another frame"
        raise InverseRefused(bound.machine, min(S), f"{what}: {way_out}")
    return found


def _row(bound: Bound, j: int) -> Row:
    """Row of S of joint j. Raises `InverseRefused` where it changes with the position."""
    row = bound.coordinates.S[j]
    if any(isinstance(x, Expression) and x.level is Level.STATE for x in row.values()):
        raise InverseRefused(bound.machine, j, _not_linear(bound, j))
    return row


def _not_linear(bound: Bound, j: int) -> str:
    joint = bound.machine.joint(j)
    owners = {j, *(bound.machine.variables[x] for x in joint.selected.names & bound.machine.variables.keys())}
    loops = [one.loop.name for one in bound.loops if not owners.isdisjoint(one.dependent)]
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
    """Whether motors, of which some are on dependent joints, determine all independent variables but deflections."""
    if not any(j in bound.machine.dependent for j in bound.motors):
        return False
    rows = {j: bound.coordinates.S_x[j] for j in (*bound.motors, *bound.machine.elastic)}
    return len(independent_motors(bound, rows)) == len(bound.machine.independent)


# Redundant chains


def _jacobian_modulo_prime(
    bound: Bound, frame: Frame, joints: Iterable[int], angles: ModularAngles, wanted: slice
) -> Columns:
    """Columns [z x P; z] or [z; 0] of a frame at a random position, exactly: zero means zero at every position."""
    mechanism = modulo_prime(bound.mechanism, angles)
    placed = frames(mechanism)
    columns: dict[int, list[Residue]] = {}
    for j in joints:
        z, arm = placed[j].z, placed[frame.number].origin - placed[j].origin
        twist = Twist(cross(z, arm), z) if mechanism.link(j).axis is Axis.REVOLUTE else Twist(z, ZERO)
        columns[j] = [_residue(x) for x in twist.entries[wanted]]
    return columns


def _residue(x: Any) -> Residue:
    return x if isinstance(x, Residue) else Residue(x)


def _by_variable(S: Rows, columns: Columns, angles: ModularAngles) -> Columns:
    """Columns times S."""
    value = angles.values(x for row in S.values() for x in row.values())
    found: dict[int, list[Residue]] = {}
    for j, row in S.items():
        for v, x in row.items():
            before = found.get(v, [Residue(0)] * len(columns[j]))
            found[v] = [a + b * value(x) for a, b in zip(before, columns[j], strict=True)]
    return {v: found[v] for v in sorted(found)}


def _check_variables(bound: Bound, columns: Columns, still: str) -> None:
    """Refuse variables that move against each other at every position, the frame (or its origin) being still."""
    dependent = first_dependent(columns)
    if not dependent:
        return
    if len(dependent) == 1:
        what = f"it can move at every position {still}: lock it in a scene"
    else:
        what = f"{_listed(dependent)} can move against each other at every position {still}"
        what += ": the arm is redundant, lock one of them in a scene"
    raise InverseRefused(bound.machine, dependent[0], what)


def _check_joints(bound: Bound, columns: Columns, still: str) -> None:
    """Refuse joints that only what they follow keeps from moving against each other."""
    dependent = first_dependent(columns)
    if dependent:
        what = f"{_listed(dependent)} follow fewer variables; alone they could move against each other {still}"
        what += ", so there is no inverse geometric model in closed form: ask for a frame before them"
        raise InverseRefused(bound.machine, dependent[0], what)


def first_dependent(columns: Columns) -> list[int]:
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


def _listed(joints: Iterable[int]) -> str:
    *others, last = map(str, joints)
    return f"joints {', '.join(others)} and {last}" if others else f"joint {last}"
