"""The box of the motions of a scene: the hull of what joints do in them, in place of the limits of a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from symoro_elastic.api.rows import BOXES, OF_FILE, SceneLike
from symoro_elastic.foundation.errors import among
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.limits import LIMITED, JointLimits, Limits, Range

if TYPE_CHECKING:
    from symoro_elastic.analysis.simulation.simulated import Simulation
    from symoro_elastic.foundation.array_types import Array

WIDENED = 1.1
"""The hull of a motion is widened by this factor about its middle."""


def limited(machine: DescribedMachine, limits: str, scene: SceneLike) -> DescribedMachine:
    """Return the machine with the limits that are asked for; raises `InputError` for a scene without a motion."""
    among((limits,), BOXES, "--limits")
    if limits == OF_FILE:
        return machine
    from symoro_elastic.api.motions import simulate

    joints = hull(simulate(machine, scene=scene))
    return replace(machine, limits=Limits(joints, machine.limits.parameters))


def hull(motions: Iterable[Simulation]) -> Mapping[str, JointLimits]:
    """Return the ranges of all joints in some motions, by joint, widened by a tenth."""
    ranges: dict[str, dict[str, Range]] = {}
    for one in motions:
        kept, motion = one.reference.machine, one.motion
        columns = [(kept.independent, (motion.q, motion.qd, motion.qdd)), (kept.motors, (motion.tau,))]
        for (numbers, arrays), names in zip(columns, (LIMITED[:3], LIMITED[3:]), strict=True):
            for name, values in zip(names, arrays, strict=True):
                for j, column in zip(numbers, values.T, strict=True):
                    of = ranges.setdefault(kept.joint(j).name, {})
                    of[name] = _joined(of.get(name), column)
    return {joint: JointLimits(**{name: _widened(x) for name, x in of.items()}) for joint, of in ranges.items()}


def _joined(before: Range | None, values: Array) -> Range:
    low, high = float(values.min()), float(values.max())
    return Range(min(low, before.low), max(high, before.high)) if before else Range(low, high)


def _widened(x: Range) -> Range:
    middle, half = x.low / 2 + x.high / 2, WIDENED * (x.high - x.low) / 2
    return Range(middle - half, middle + half)
