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
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.models.bind import closed_forms
from symoro_elastic.models.loops.assembly import Position
from symoro_elastic.models.loops.plan import Plan, plan_of
from symoro_elastic.models.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

LARGEST = 1e9
"""Of a position that is given, rad or m."""
FARTHEST = 20.0
"""Longest way from the start of a loop whose dependent variables are followed, rad or m."""
Point = tuple[float, float, float]


@dataclass(frozen=True)
class PlacedJoint:
    """Origin (m) and axis z of the frame of a joint, in frame 0; NaN where they depend on parameters without value."""

    joint: Joint
    origin: Point
    axis: Point


@dataclass(frozen=True)
class PlacedMachine:
    """Joints at one position: `q` by name, rad or m; of coupled joints it is what their cells hold."""

    q: dict[str, float]
    joints: tuple[PlacedJoint, ...]


def placed_machine(machine: Machine, at: Mapping[str, float]) -> PlacedMachine:
    """Return the joints of a machine at a position, those that loops give closed.

    `at` are positions by joint or joint variable. Where it gives none, springs are at their neutral positions, joints
    of loops at the start of the loop, others at zero. Raises `InputError` for a joint that does not move by itself,
    and where the loops do not close.
    """
    values = parameter_values(machine)
    free = _neutral(machine, values) | _started(machine) | _given(machine, at)
    own = free | (_closed(machine, values, free) if machine.loops else {})
    known = {name: Formula.parse(x) for name, x in own.items() if not math.isnan(x)}
    tree = Tree(restrict(replace(machine, loops=()), Scene(locked=known)))
    found = frames(tree.mechanism)[1:]
    leaves = [x for frame in found for x in (*frame.origin, *frame.z)]
    names = (*(parameter.name for parameter in machine.parameters), *machine.variables)
    value = evaluate(leaves, dict.fromkeys(names, math.nan) | values, FLOATS)

    def numbers(vector: tuple[Scalar, ...]) -> Point:
        x, y, z = (float(value(x)) for x in vector)
        return x, y, z

    joints = zip(machine.joints, found, strict=True)
    placed = tuple(PlacedJoint(j, numbers(f.origin), numbers(f.z)) for j, f in joints)
    return PlacedMachine({**own, **_coupled(machine, values, own)}, placed)


def _started(machine: Machine) -> dict[str, float]:
    """Independent joints of loops that have a start, at the assembled one."""
    if not machine.loops:
        return {}
    start = plan_of(machine).positions[0]
    given = {name for loop in machine.loops for name in loop.start}
    return {joint.name: start[j] for j, joint in _numbered(machine, machine.independent) if joint.variable in given}


def _closed(machine: Machine, values: Mapping[str, float], free: Mapping[str, float]) -> dict[str, float]:
    """Dependent joints at a position of the independent ones, by closed forms or by continuation from the start."""
    plan, dependent = plan_of(machine), dict(_numbered(machine, machine.dependent))
    names = [parameter.name for parameter in machine.parameters]
    if any(one.is_assembled for one in plan.loops):
        if not values.keys() >= {*names} or any(map(math.isnan, free.values())):
            return {joint.name: math.nan for joint in dependent.values()}
        found = _continued(machine, plan, {j: free[joint.name] for j, joint in _numbered(machine, machine.independent)})
        return {joint.name: found[j] for j, joint in dependent.items()}
    known: dict[str, float] = {str(joint.variable): free[joint.name] for joint in machine.independent_joints}
    forms = closed_forms(machine)
    try:
        value = evaluate([forms[j] for j in dependent], {**dict.fromkeys(names, math.nan), **values, **known}, FLOATS)
        closed = {joint.name: float(value(forms[j])) for j, joint in dependent.items()}
    except (ArithmeticError, ValueError):
        raise _open(machine) from None
    is_known = values.keys() >= {*names} and not any(map(math.isnan, known.values()))
    if is_known and any(map(math.isnan, closed.values())):
        raise _open(machine)
    return closed


def _continued(machine: Machine, plan: Plan, target: Mapping[int, float]) -> Position:
    """The assembled position at independent variables, on the branch of the start."""
    far = max((abs(x - plan.positions[0][j]) for j, x in target.items() if j in machine.in_loops), default=0.0)
    found = plan.assembly.position_at(plan.positions[0], target) if far < FARTHEST else None
    if found is None:
        raise _open(machine)
    return found


def _open(machine: Machine) -> InputError:
    loops = ", ".join(loop.name for loop in machine.loops)
    what = f"{loops} cannot close at this position: stay nearer to start, or give other joints of the loop too"
    return InputError(machine.label, "--at", what)


def _coupled(machine: Machine, values: Mapping[str, float], own: Mapping[str, float]) -> dict[str, float]:
    """What the cells of coupled joints hold."""
    known = {
        **values,
        **{str(joint.variable): own[joint.name] for _, joint in _numbered(machine, machine.with_variable)},
    }
    rows = [joint for j, joint in _numbered(machine, machine.articulated) if j not in machine.with_variable]
    return {joint.name: _value(joint.selected, known) for joint in rows}


def _numbered(machine: Machine, joints: Iterable[int]) -> Iterator[tuple[int, Joint]]:
    return ((j, machine.joint(j)) for j in joints)


def _value(formula: Formula, values: Mapping[str, float]) -> float:
    try:
        return formula.value(values) if formula.names <= values.keys() else math.nan
    except FormulaError:
        return math.nan


def _neutral(machine: Machine, values: Mapping[str, float]) -> dict[str, float]:
    """Neutral positions of springs, zero of other joints."""
    return {joint.name: _value(joint.spring.neutral, values) for joint in machine.independent_joints}


def _given(machine: Machine, at: Mapping[str, float]) -> dict[str, float]:
    names = {str(joint.variable): joint.name for joint in machine.independent_joints}
    names |= {joint.name: joint.name for joint in machine.independent_joints}
    for name, x in at.items():
        if name not in names:
            raise InputError(machine.label, "--at", _not_free(machine, name) + did_you_mean(name, names))
        if not abs(x) <= LARGEST:
            raise InputError(machine.label, "--at", f"{name}={x:g} is out of range: give a number up to {LARGEST:g}")
    return {names[name]: x for name, x in at.items()}


def _not_free(machine: Machine, name: str) -> str:
    """Why a name is that of no independent variable."""
    for j, joint in _numbered(machine, machine.articulated):
        if name in (joint.name, joint.variable) and j not in machine.independent:
            others = ", ".join(str(other.variable) for other in machine.independent_joints)
            return f"{quote(name)} follows from other variables: give some of {others}"
    return f"no joint {quote(name)} moves"
