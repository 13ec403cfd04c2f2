"""Origins and axes of all joints in frame 0, in numbers, at one position."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.names import no_such
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.models.bound.bind import closed_forms
from symoro_elastic.models.loops.assembly import Position
from symoro_elastic.models.loops.plan import Plan, plan_of
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

LARGEST = 1e9
"""Largest position that is accepted, rad or m."""
FARTHEST = 20.0
"""Longest distance from the start of a loop over which its dependent variables are continued, rad or m."""
Point = tuple[float, float, float]


@dataclass(frozen=True)
class PlacedJoint:
    """Origin (m), axes z and x of a joint's frame, in frame 0; NaN where they depend on parameters without value."""

    joint: Joint
    origin: Point
    axis: Point
    x: Point


@dataclass(frozen=True)
class PlacedMachine:
    """Joints at one position: `q` by name, rad or m; for coupled joints, the value of their cells."""

    q: dict[str, float]
    joints: tuple[PlacedJoint, ...]


def placed_machine(machine: Machine, at: Mapping[str, float]) -> PlacedMachine:
    """Return origins and axes of the joints of a machine at a position at which its loops are closed.

    `at` are positions by joint or joint variable. Where it gives none, springs are at their neutral positions, joints
    of loops at the start of the loop, others at zero. Raises `InputError` for a joint that does not move by itself,
    and where the loops do not close.
    """
    values = parameter_values(machine)
    neutral = {joint.name: _value(joint.spring.neutral, values) for joint in machine.independent_joints}
    free = neutral | _start_positions(machine) | _requested_positions(machine, at)
    own = free | (_dependent_positions(machine, values, free) if machine.loops else {})
    positions = {name: Formula.parse(x) for name, x in own.items() if not math.isnan(x)}
    tree = Tree(restrict(replace(machine, loops=()), Scene(locked=positions)))
    placements = frames(tree.mechanism)[1:]
    leaves = [x for frame in placements for x in (*frame.origin, *frame.z, *frame.rotation.T.x)]
    names = (*(parameter.name for parameter in machine.parameters), *machine.variables)
    value = evaluate(leaves, dict.fromkeys(names, math.nan) | values, FLOATS)

    def numbers(vector: tuple[Scalar, ...]) -> Point:
        x, y, z = (float(value(x)) for x in vector)
        return x, y, z

    joints = zip(machine.joints, placements, strict=True)
    axes = tuple(PlacedJoint(j, numbers(f.origin), numbers(f.z), numbers(f.rotation.T.x)) for j, f in joints)
    return PlacedMachine({**own, **_coupled_cells(machine, values, own)}, axes)


def _start_positions(machine: Machine) -> dict[str, float]:
    """Assembled start positions of the independent joints of loops."""
    if not machine.loops:
        return {}
    start = plan_of(machine).positions[0]
    started = {name for loop in machine.loops for name in loop.start}
    return {joint.name: start[j] for j, joint in _rows(machine, machine.independent) if joint.variable in started}


def _dependent_positions(machine: Machine, values: Mapping[str, float], free: Mapping[str, float]) -> dict[str, float]:
    """Positions of the dependent joints, by closed forms or by continuation from the start."""
    plan, dependent = plan_of(machine), dict(_rows(machine, machine.dependent))
    names = [parameter.name for parameter in machine.parameters]
    if any(loop.is_assembled for loop in plan.loops):
        if not values.keys() >= {*names} or any(map(math.isnan, free.values())):
            return {joint.name: math.nan for joint in dependent.values()}
        position = _position_at(
            machine, plan, {j: free[joint.name] for j, joint in _rows(machine, machine.independent)}
        )
        return {joint.name: position[j] for j, joint in dependent.items()}
    positions: dict[str, float] = {str(joint.variable): free[joint.name] for joint in machine.independent_joints}
    forms = closed_forms(machine)
    try:
        value = evaluate(
            [forms[j] for j in dependent], {**dict.fromkeys(names, math.nan), **values, **positions}, FLOATS
        )
        closed = {joint.name: float(value(forms[j])) for j, joint in dependent.items()}
    except (ArithmeticError, ValueError):
        raise _not_closed(machine) from None
    is_known = values.keys() >= {*names} and not any(map(math.isnan, positions.values()))
    if is_known and any(map(math.isnan, closed.values())):
        raise _not_closed(machine)
    return closed


def _position_at(machine: Machine, plan: Plan, target: Mapping[int, float]) -> Position:
    """The assembled position at given independent variables, on the branch of the start."""
    far = max((abs(x - plan.positions[0][j]) for j, x in target.items() if j in machine.in_loops), default=0.0)
    position = plan.assembly.position_at(plan.positions[0], target) if far < FARTHEST else None
    if position is None:
        raise _not_closed(machine)
    return position


def _not_closed(machine: Machine) -> InputError:
    loops = ", ".join(loop.name for loop in machine.loops)
    what = f"{loops} cannot close at this position: stay nearer to start, or give other joints of the loop too"
    return InputError(machine.label, "--at", what)


def _coupled_cells(machine: Machine, values: Mapping[str, float], own: Mapping[str, float]) -> dict[str, float]:
    """Values of the cells of coupled joints, by joint."""
    symbols = {**values, **{str(joint.variable): own[joint.name] for _, joint in _rows(machine, machine.with_variable)}}
    rows = [joint for j, joint in _rows(machine, machine.articulated) if j not in machine.with_variable]
    return {joint.name: _value(joint.selected, symbols) for joint in rows}


def _rows(machine: Machine, joints: Iterable[int]) -> Iterator[tuple[int, Joint]]:
    return ((j, machine.joint(j)) for j in joints)


def _value(formula: Formula, values: Mapping[str, float]) -> float:
    try:
        return formula.value(values) if formula.names <= values.keys() else math.nan
    except FormulaError:
        return math.nan


def _requested_positions(machine: Machine, at: Mapping[str, float]) -> dict[str, float]:
    names = {str(joint.variable): joint.name for joint in machine.independent_joints}
    names |= {joint.name: joint.name for joint in machine.independent_joints}
    for name, x in at.items():
        if name not in names:
            raise InputError(machine.label, "--at", _not_free(machine, name, names))
        if not abs(x) <= LARGEST:
            raise InputError(machine.label, "--at", f"{name}={x:g} is out of range: give a number up to {LARGEST:g}")
    return {names[name]: x for name, x in at.items()}


def _not_free(machine: Machine, name: str, names: Iterable[str]) -> str:
    """Message for a name that does not belong to an independent variable."""
    for j, joint in _rows(machine, machine.articulated):
        if name in (joint.name, joint.variable) and j not in machine.independent:
            return machine.why_dependent(name)
    return no_such("moving joint", name, names)
