"""Limits of a machine that a motion exceeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import limits_of
from symoro_elastic.machine.limits import LIMITED, Range, unit_of
from symoro_elastic.machine.machine import Joint, Machine

ROUNDING = 1e-9
"""Of the larger end of a range: by so much a motion may leave it."""


@dataclass(frozen=True)
class Beyond:
    """An exceeded limit of a joint: first at time `t`, s, with the extreme `value`, in `unit`."""

    joint: str
    quantity: str
    t: float
    value: float
    low: float
    high: float
    unit: str

    def __str__(self) -> str:
        """Return the exceeded limit as a sentence."""
        allowed = f"{self.low:.4g} to {self.high:.4g} {self.unit}"
        reached = f"{self.value:.4g} {self.unit}"
        return f"{self.joint} leaves its limits: {self.quantity} up to {reached}, {allowed}, first at {self.t:.4g} s"


def beyond_limits(machine: Machine, t: Array, motion: Mapping[str, Mapping[str, Array]]) -> tuple[Beyond, ...]:
    """Return the exceeded limits of a motion at times t (N,), by quantity and joint, SI units."""
    joints = {joint.name: joint for joint in machine.joints}
    limits = limits_of(machine).joints
    pairs = ((joints[name], quantity) for name in limits for quantity in LIMITED if name in motion.get(quantity, {}))
    exceeded = (
        _beyond(joint, quantity, allowed, t, motion[quantity][joint.name])
        for joint, quantity in pairs
        if (allowed := getattr(limits[joint.name], quantity)) is not None
    )
    return tuple(limit for limit in exceeded if limit)


def of_joints(joints: Iterable[Joint], q: Array, qd: Array, qdd: Array) -> Iterator[tuple[str, dict[str, Array]]]:
    """Yield position, velocity and acceleration (N,) of joints by name, from their columns (N, joints)."""
    names = [joint.name for joint in joints]
    for quantity, block in zip(LIMITED, (q, qd, qdd), strict=False):
        yield quantity, dict(zip(names, block.T, strict=True))


def _beyond(joint: Joint, quantity: str, allowed: Range, t: Array, x: Array) -> Beyond | None:
    by = np.maximum(allowed.low - x, x - allowed.high)
    outside = by > ROUNDING * max(abs(allowed.low), abs(allowed.high))
    if not outside.any():
        return None
    most = float(x[np.nanargmax(by)])
    ends = allowed.low, allowed.high
    return Beyond(joint.name, quantity, float(t[np.argmax(outside)]), most, *ends, unit_of(quantity, joint))
