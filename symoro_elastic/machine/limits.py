"""Limits of a machine: ranges of the positions, velocities, accelerations and torques of its joints, of its parameters.

They are what a file says beside mechanics: no model depends on them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields


@dataclass(frozen=True)
class Range:
    """A range of a quantity, its ends among it, in SI units; raises `ValueError` where it is none."""

    low: float
    high: float

    def __post_init__(self) -> None:
        """Refuse ends that are not finite, or that are reversed."""
        if reason := why_no_range(self.low, self.high):
            raise ValueError(reason)

    def __contains__(self, x: float) -> bool:
        """Whether a number is in the range; NaN is not."""
        return self.low <= x <= self.high

    @property
    def is_symmetric(self) -> bool:
        """Whether zero is its middle."""
        return self.low == -self.high


def why_no_range(low: float, high: float) -> str:
    """Return why two numbers are not the ends of a range; empty where they are."""
    for x in (low, high):
        if not math.isfinite(x):
            return f"{x} is not finite: a range has two finite ends, leave out what has no limit"
    return f"the low end, {low:g}, is above the high one, {high:g}" if low > high else ""


@dataclass(frozen=True)
class JointLimits:
    """Ranges of a joint's position, velocity, acceleration and torque (force where it slides); None: not limited."""

    position: Range | None = None
    velocity: Range | None = None
    acceleration: Range | None = None
    torque: Range | None = None

    def __bool__(self) -> bool:
        """Whether anything is limited."""
        return any(getattr(self, name) is not None for name in LIMITED)


LIMITED = tuple(each.name for each in fields(JointLimits))
"""The limited quantities of a joint: position, velocity, acceleration, torque."""


@dataclass(frozen=True)
class Limits:
    """Limits of joints by joint name, ranges of parameters by parameter name; what is not limited is not in them."""

    joints: Mapping[str, JointLimits] = field(default_factory=dict)
    parameters: Mapping[str, Range] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self.joints or self.parameters)

    def of(self, joint: str) -> JointLimits:
        """Return the limits of a joint, which has none where it is not named."""
        return self.joints.get(joint, JointLimits())
