"""Gains by published rules, which see an axis as one inertia J behind small times of the torque, T in all.

    amount optimum       Kp = J/(2 T), no integral part, T_v = 2 T    Kessler 1955: velocity steps 4.3 % too far
    symmetrical optimum  Kp = J/(2 T), Tn = 4 T, T_v = 4 T            Kessler 1958: 43.4 % too far, 37 degrees
    position             Kv = 1/(4 T_v)                               the largest without overshoot

T is the sum of the dead time, half the period, the lag of the current loop and the times of filters; J that of the axis
with springs that do not deflect. They know of no spring: what the loops have of them is computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cascade import Biquad, Cascade, Element, Hold
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.loops import loops_of, margins
from symoro_elastic.analysis.control.plant import Plant
from symoro_elastic.analysis.control.sampled import sampled_loop

RULES = {"amount optimum": ("Kessler 1955", np.inf, 2.0), "symmetrical optimum": ("Kessler 1958", 4.0, 4.0)}
"""Source, Tn and T_v over T; Kp is J/(2 T) in both."""


@dataclass(frozen=True)
class RuledAxis:
    """Gains of an axis by a rule, and the least |1 + L| of its loops at all positions; `growth` of all loops, 1/s."""

    rule: str
    source: str
    cascade: Cascade
    inertia: float
    time: float
    velocity: float
    position: float
    growth: float


def ruled(plants: Sequence[Plant], cascades: Sequence[Cascade]) -> tuple[RuledAxis, ...]:
    """Return the gains of each axis by each rule, for the largest inertia of all positions.

    Axes without a dead time, period, lag or filter are left as they are, and have no rows.
    """
    found: list[RuledAxis] = []
    for rule, (source, integral, behind) in RULES.items():
        inertias = [max(inertia(plant, one.motor) for plant in plants) for one in cascades]
        times = [sum(map(small_time, one.path)) for one in cascades]
        closed = [
            one.with_gains(Kp=J / (2 * T), Tn=integral * T, Kv=1 / (4 * behind * T)) if T else one
            for one, J, T in zip(cascades, inertias, times, strict=True)
        ]
        growth = max((sampled_loop(plant, closed) or closed_loop(plant, closed)).growth for plant in plants)
        loops = [loops_of(plant, closed) for plant in plants]
        for k, one in enumerate(closed):
            if times[k]:
                velocity = min(margins(at[k].velocity_loop, at[k].frequencies).modulus for at in loops)
                position = min(margins(at[k].position_loop, at[k].frequencies).modulus for at in loops)
                found.append(RuledAxis(rule, source, one, inertias[k], times[k], velocity, position, growth))
    return tuple(found)


def inertia(plant: Plant, motor: str) -> float:
    """Return the inertia of an axis, kg m2 or kg, whose springs do not deflect: only its own variable moves."""
    velocity = plant.axes[motor].velocity
    return float(velocity @ plant.linear.M @ velocity) / float(velocity @ velocity) ** 2


def small_time(one: Element) -> float:
    """Return the time, s, by which an element is late at low frequencies: -d ln P/ds at 0."""
    if isinstance(one, Biquad):
        return 2 * (one.below - (0.0 if one.low else one.above)) / one.w
    return one.time / 2 if isinstance(one, Hold) else one.time
