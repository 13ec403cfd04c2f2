"""Limits of a machine: ranges of joint positions, velocities, accelerations and torques, and of parameters.

They are entries of a file besides mechanics: no model depends on them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

from symoro_elastic.machine.machine import Joint, Kind, Machine

TORQUE = "torque"


@dataclass(frozen=True)
class Range:
    """A range of a quantity, ends included, in SI units; raises `ValueError` for reversed or infinite ends."""

    low: float
    high: float

    def __post_init__(self) -> None:
        """Refuse ends that are not finite, or that are reversed."""
        if reason := why_no_range(self.low, self.high):
            raise ValueError(reason)

    def __contains__(self, x: float) -> bool:
        """Whether a number is in the range; never for NaN."""
        return self.low <= x <= self.high

    @property
    def is_symmetric(self) -> bool:
        """Whether the range is symmetric about zero."""
        return self.low == -self.high


def why_no_range(low: float, high: float) -> str:
    """Return why two numbers do not form a range; empty if they do."""
    for x in (low, high):
        if not math.isfinite(x):
            return f"{x} is not finite: a range has two finite ends, leave out what has no limit"
    return f"the low end, {low:g}, is above the high one, {high:g}" if low > high else ""


def range_of(low: float, high: float, far: float = math.inf) -> Range | None:
    """Return the range between two numbers; None for an empty one, or an end not within `far`."""
    return Range(low, high) if low < high and max(-low, high) < far else None


@dataclass(frozen=True)
class JointLimits:
    """Ranges of a joint's position, velocity, acceleration and torque (force where it slides); None: not limited."""

    position: Range | None = None
    velocity: Range | None = None
    acceleration: Range | None = None
    torque: Range | None = None

    def __bool__(self) -> bool:
        """Whether any quantity is limited."""
        return any(getattr(self, name) is not None for name in LIMITED)


LIMITED = tuple(field.name for field in fields(JointLimits))
"""The limited quantities of a joint: position, velocity, acceleration, torque."""
UNITS = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "acceleration": ("rad/s2", "m/s2"),
    TORQUE: ("N m", "N"),
}
"""Units of the limited quantities, of a joint that turns and of one that slides."""


@dataclass(frozen=True)
class Limits:
    """Limits of joints by joint name, ranges of parameters by parameter name; unlimited ones are absent."""

    joints: Mapping[str, JointLimits] = field(default_factory=dict)
    parameters: Mapping[str, Range] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Whether there is any limit."""
        return bool(self.joints or self.parameters)

    def of(self, joint: str) -> JointLimits:
        """Return the limits of a joint, empty ones for a joint without entry."""
        return self.joints.get(joint, JointLimits())


def why_unlimited(machine: Machine, j: int, quantity: str = "position") -> str:
    """Return why a quantity of joint j of a machine has no limits of its own; empty where it may have them."""
    joint = machine.joint(j)
    if joint.kind is Kind.CUT:
        return "it closes a loop: limit the joints of the loop"
    if joint.sigma == 2:
        return "a fixed frame does not move: leave it out"
    if joint.kind is Kind.COUPLED:
        followed = [machine.joint(k).name for name, k in machine.variables.items() if name in joint.selected.names]
        return f"a coupled joint has no variable of its own: limit {' and '.join(followed) or 'what it follows'}"
    if quantity == TORQUE and joint.kind is Kind.PASSIVE:
        return "a passive joint has neither a motor nor a spring, so no torque: leave it out"
    return ""


def unit_of(quantity: str, joint: Joint) -> str:
    """Return the unit of a limited quantity of a joint."""
    return UNITS[quantity][int(joint.sigma == 1)]


def within_machine(limits: Limits, machine: Machine) -> Limits:
    """Return those limits that apply to a machine: of its independent joints, and of parameters with a value."""
    allowed = {}
    for j, joint in enumerate(machine.joints, start=1):
        excluded = {name: None for name in LIMITED if why_unlimited(machine, j, name)}
        allowed[joint.name] = replace(limits.of(joint.name), **excluded)
    valued = {parameter.name for parameter in machine.parameters if parameter.value is not None}
    return Limits(
        {name: limit for name, limit in allowed.items() if limit},
        {name: interval for name, interval in limits.parameters.items() if name in valued},
    )
