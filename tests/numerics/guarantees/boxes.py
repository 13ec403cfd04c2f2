"""Limits of machines for tests."""

from __future__ import annotations

import math

from symoro_elastic.machine.limits import JointLimits, Limits, Range
from symoro_elastic.machine.machine import Joint, Kind, Machine


def both_ways(x: float) -> Range:
    return Range(-x, x)


def limits_of_test(machine: Machine, scale: float = 1.0) -> Limits:
    """Whole turns, 0.4 m, 2 rad/s, 5 rad/s2, 50 N m, springs bent by 0.01 rad or 2 mm, all times `scale`."""
    return Limits({machine.joint(j).name: _limits(machine.joint(j), scale) for j in machine.with_variable})


def _limits(joint: Joint, scale: float) -> JointLimits:
    turns = joint.sigma == 0
    reach = (0.01 if turns else 0.002) if joint.kind is Kind.ELASTIC else (math.pi if turns else 0.4)
    return JointLimits(*(both_ways(x * scale) for x in (reach, 2.0, 5.0, 50.0)))
