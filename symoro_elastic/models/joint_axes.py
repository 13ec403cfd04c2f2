"""Origins and axes of all joints in frame 0, in numbers, at one position."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from symoro_elastic.equations.kinematics import frames
from symoro_elastic.errors import InputError
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.names import did_you_mean, quoted
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

LARGEST = 1e9
"""Of a position that is given, rad or m."""
Point = tuple[float, float, float]


@dataclass(frozen=True)
class PlacedJoint:
    """Origin (m) and axis z of the frame of a joint, in frame 0; NaN where they depend on parameters without value."""

    joint: Joint
    origin: Point
    axis: Point


@dataclass(frozen=True)
class PlacedMachine:
    """Joints at one position: `q` by name, rad or m."""

    q: dict[str, float]
    joints: tuple[PlacedJoint, ...]


def placed_machine(machine: Machine, at: Mapping[str, float]) -> PlacedMachine:
    """Return the joints of a machine at a position, springs at their neutral positions and others at zero unless given.

    `at` are positions by joint or joint variable. Raises `InputError` for a joint that does not move.
    """
    values = parameter_values(machine)
    position = _neutral(machine, values) | _given(machine, at)
    known = {name: Formula.parse(x) for name, x in position.items() if not math.isnan(x)}
    bound = Bound(restricted(machine, Scene(locked=known)))
    found = frames(bound.mechanism)[1:]
    leaves = [x for frame in found for x in (*frame.origin, *frame.z)]
    names = (*(parameter.name for parameter in machine.parameters), *(str(j.variable) for j in machine.moving_joints))
    value = evaluate(leaves, dict.fromkeys(names, math.nan) | values, FLOATS)

    def numbers(vector: tuple[Scalar, ...]) -> Point:
        x, y, z = (float(value(x)) for x in vector)
        return x, y, z

    joints = zip(machine.joints, found, strict=True)
    return PlacedMachine(position, tuple(PlacedJoint(j, numbers(f.origin), numbers(f.z)) for j, f in joints))


def _neutral(machine: Machine, values: Mapping[str, float]) -> dict[str, float]:
    """Neutral positions of springs, zero of other joints."""
    found = {}
    for joint in machine.moving_joints:
        neutral = joint.spring.neutral
        try:
            found[joint.name] = neutral.value(values) if neutral.names <= values.keys() else math.nan
        except FormulaError:
            found[joint.name] = math.nan
    return found


def _given(machine: Machine, at: Mapping[str, float]) -> dict[str, float]:
    names = {str(joint.variable): joint.name for joint in machine.moving_joints}
    names |= {joint.name: joint.name for joint in machine.moving_joints}
    for name, x in at.items():
        if name not in names:
            raise InputError(machine.label, "--at", f"no joint {quoted(name)} moves{did_you_mean(name, names)}")
        if not abs(x) <= LARGEST:
            raise InputError(machine.label, "--at", f"{name}={x:g} is out of range: give a number up to {LARGEST:g}")
    return {names[name]: x for name, x in at.items()}
