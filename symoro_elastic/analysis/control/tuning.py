"""Gains by the distance of their loops from instability at all positions: Kp, Tn, Kv of each axis in turn.

    Kp   the largest of the velocity loop without integral part, times `ROOM` where an integral part is sought, too
    Tn   the smallest with which the velocity loop keeps nine tenths of its distance, or that of position loops
    Kv   the largest of the position loop around it

In a first pass axes whose gains are sought are held, and free, as they are at low and at high frequencies, and the
smaller gain counts; in a second pass all loops are closed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.control.largest_gain import LargestGain
from symoro_elastic.analysis.control.loops import AxisLoops, largest_integral, largest_Kp, largest_Kv
from symoro_elastic.analysis.control.plant import Plant
from symoro_elastic.foundation.errors import InputError

ROOM = 0.8
"""Of the largest Kp, that leaves room for an integral part."""
PASSES = 2


@dataclass(frozen=True)
class Distances:
    """The least |1 + L| of velocity loops and of position loops."""

    velocity: float
    position: float


USUAL = Distances(0.5, 0.7)
"""Distances where none are given."""


def tuned(plants: Sequence[Plant], cascades: Sequence[Cascade], distances: Distances) -> list[Cascade]:
    """Return the cascades with their sought gains; raises `InputError` where none, or nothing, limits one."""
    found = list(cascades)
    for turn in range(PASSES):
        for k, one in enumerate(found):
            if one.sought:
                known = [x for x in found if x is not one and (turn or not x.sought)]
                others = tuple(x.motor for x in found if x is not one and x not in known)
                at = [replace(plant, held=(*plant.held, *held)) for plant in plants for held in {(), others}]
                found[k] = _tuned([AxisLoops.around(plant, one, known) for plant in at], one, distances)
    return found


def _tuned(loops: Sequence[AxisLoops], one: Cascade, distances: Distances) -> Cascade:
    """Return one cascade with its sought gains, from its loops at all positions."""
    integral = "Tn" in one.sought
    if "Kp" in one.sought:
        without = one.with_gains(Tn=np.inf) if integral else one
        largest = _least(loops, without, "Kp", lambda at: largest_Kp(at, distances.velocity))
        one = one.with_gains(Kp=(ROOM if integral else 1.0) * largest)
    if integral:
        without = one.with_gains(Tn=np.inf)
        rate = _least(loops, without, "Tn", lambda at: largest_integral(at, distances.velocity, distances.position))
        one = one.with_gains(Tn=1 / rate)
    if "Kv" in one.sought:
        one = one.with_gains(Kv=_least(loops, one, "Kv", lambda at: largest_Kv(at, distances.position)))
    return one


def _least(
    loops: Sequence[AxisLoops], one: Cascade, key: str, largest: Callable[[AxisLoops], LargestGain | None]
) -> float:
    """Return the gain that all positions allow."""
    return min(_at(replace(at, cascade=one), key, largest) for at in loops)


def _at(loops: AxisLoops, key: str, largest: Callable[[AxisLoops], LargestGain | None]) -> float:
    """Return the gain that one position allows; raises `InputError` where there is none, or nothing limits it."""
    found, plant = largest(loops), loops.plant
    place = "".join(f" at {name}={x:g}" for name, x in plant.place.items())
    where = f"drives, {loops.cascade.motor}, {key}"
    if found is None:
        what = f"no value keeps the loop stable and at its distance{place}: lower --modulus, or change the other gains"
        raise InputError(plant.linear.motion.source, where, what)
    if found.gain == np.inf:
        what = f"nothing limits it{place}: give a dead_time, a period, or the lag of the current loop"
        raise InputError(plant.linear.motion.source, where, what)
    return found.gain
