"""Gains by the modulus margins of their loops at all positions: Kp, Tn, Kv of the axes in turn.

    Kp   the largest of the velocity loop without integral part, times `ROOM` where an integral part is tuned, too
    Tn   the smallest with which the velocity loop keeps nine tenths of its distance, or that of position loops
    Kv   the largest of the position loop around it

In a first pass axes whose gains are tuned are held, and free, as they are at low and at high frequencies, and the
smaller gain counts; in a second pass all loops are closed. Loops that were closed after it may leave an axis less room:
position gains above the largest that all others allow are lowered to it, until there is none.
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
ABOVE = 0.01
"""Relative excess of a position gain over the largest from which it is lowered."""
MOST_LOWERED = 20
"""Passes in which gains are lowered."""


@dataclass(frozen=True)
class Distances:
    """The least |1 + L| of velocity loops and of position loops."""

    velocity: float
    position: float


@dataclass(frozen=True)
class Tuning:
    """How gains are tuned: at `distances`, all or only those that the file leaves open, one by one or `together`."""

    distances: Distances = Distances(0.5, 0.7)
    all_gains: bool = False
    together: bool = False


AT_USUAL_DISTANCES = Tuning()
"""Gains that the file leaves open, at the default modulus margins."""


def tuned_cascades(plants: Sequence[Plant], cascades: Sequence[Cascade], distances: Distances) -> list[Cascade]:
    """Return the cascades with computed gains; raises `InputError` for one without solution or limit."""
    tuned = list(cascades)
    for turn in range(PASSES):
        for k, drive in enumerate(tuned):
            if drive.tuned_gains:
                closed = [x for x in tuned if x is not drive and (turn or not x.tuned_gains)]
                open_motors = tuple(x.motor for x in tuned if x is not drive and x not in closed)
                at = [replace(plant, held=(*plant.held, *locked)) for plant in plants for locked in {(), open_motors}]
                tuned[k] = _tuned_cascade([AxisLoops.around(plant, drive, closed) for plant in at], drive, distances)
    coupled = [k for k, drive in enumerate(cascades) if "Kv" in drive.tuned_gains and len(cascades) > 1]
    for _ in range(MOST_LOWERED):
        before = list(tuned)
        for k in coupled:
            tuned[k] = _lowered(plants, tuned, k, distances)
        if tuned == before:
            break
    return tuned


def _lowered(plants: Sequence[Plant], tuned: Sequence[Cascade], k: int, distances: Distances) -> Cascade:
    """Return a cascade with its Kv lowered to what its margin allows while all other loops are closed."""
    drive, others = tuned[k], [x for x in tuned if x is not tuned[k]]
    loops = [AxisLoops.around(plant, drive, others) for plant in plants]
    largest = _least(loops, drive, "Kv", lambda at: largest_Kv(at, distances.position))
    return drive.with_gains(Kv=largest) if drive.Kv > (1 + ABOVE) * largest else drive


def _tuned_cascade(loops: Sequence[AxisLoops], drive: Cascade, distances: Distances) -> Cascade:
    """Return one cascade with its tuned gains, from its loops at all positions."""
    integral = "Tn" in drive.tuned_gains
    if "Kp" in drive.tuned_gains:
        without = drive.with_gains(Tn=np.inf) if integral else drive
        largest = _least(loops, without, "Kp", lambda at: largest_Kp(at, distances.velocity))
        drive = drive.with_gains(Kp=(ROOM if integral else 1.0) * largest)
    if integral:
        without = drive.with_gains(Tn=np.inf)
        rate = _least(loops, without, "Tn", lambda at: largest_integral(at, distances.velocity, distances.position))
        drive = drive.with_gains(Tn=1 / rate)
    if "Kv" in drive.tuned_gains:
        drive = drive.with_gains(Kv=_least(loops, drive, "Kv", lambda at: largest_Kv(at, distances.position)))
    return drive


def _least(
    loops: Sequence[AxisLoops], one: Cascade, key: str, largest: Callable[[AxisLoops], LargestGain | None]
) -> float:
    """Return the largest gain `key` that all positions allow."""
    return min(_at(replace(at, cascade=one), key, largest) for at in loops)


def _at(loops: AxisLoops, key: str, largest: Callable[[AxisLoops], LargestGain | None]) -> float:
    """Return the largest gain at one position; raises `InputError` without a solution or without a limit."""
    limit, plant = largest(loops), loops.plant
    place = "".join(f" at {name}={x:g}" for name, x in plant.place.items())
    where = f"drives, {loops.cascade.motor}, {key}"
    if limit is None:
        what = f"no value keeps the loop stable and at its distance{place}: lower --modulus, or change the other gains"
        raise InputError(plant.linear.motion.source, where, what)
    if limit.gain == np.inf:
        what = f"nothing limits it{place}: give a dead_time, a period, or the lag of the current loop"
        raise InputError(plant.linear.motion.source, where, what)
    return limit.gain
