"""Faults of measured columns: clipped or frozen samples, and counters that wrap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.time_series.resolution import resolution_of
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray

FEW_LEVELS = 8
"""Values of a column that is a command of steps, which stays everywhere."""
EQUAL = 1e-9
"""Of the range of a column: differences that conversion and sampling anew leave of none."""
PARABOLA = 1 / (np.sqrt(2) - 1)
"""Time of a smooth peak within one step of its end, over that within the next step."""
BEYOND = 0.01
"""Of the samples at an end of a range: so many may be beyond it."""
POISSON = 3.0
"""Standard deviations of a count."""
FEWEST_STAYS = 3
"""Samples at one value, in units of usual stays, that peaks of a column without steps do not have."""
LONGEST_STAY = 10
"""Lengths of the longest usual stay (99 %) after which a column that does not change is stuck."""
SHORTEST_STUCK = 20  # samples
FEWEST_REPEATED = 10  # lines of a response
LEAP = 3.0
"""Usual changes by which a column that was stuck goes on, for what it measures went on; one that turns does not."""
WRAP_OVER_STEPS, ALIKE_WRAPS = 2.5, 0.35
"""Jumps of a counter over other steps (98 %), and the spread of their sizes: a period less up to a third of it."""
BENDS, FAR_BENT = (1, 2, 4, 8, 16, 32, 64), 4.0
"""Lags of second differences, in samples, and how far above usual ones the difference at a stop is."""
SPIKE = 3  # samples after which a spike is over
LATE = 1.5  # usual steps of time: longer ones are gaps


def stays(x: Array) -> BoolArray:
    """Return a mask of samples (N) at an end of a column's range, as if clipped, or that do not change.

    A column of a few values is a command, and zero is never an end. Quantization, peaks, and a few samples beyond
    an end, such as spikes that were repaired, are allowed for; a column that repeats no other value has no steps, and
    its peaks no equal samples.
    """
    staying, span = np.zeros(len(x), dtype=bool), float(np.ptp(x)) if len(x) else 0.0
    if not span or len(np.unique(x)) <= FEW_LEVELS:
        return staying
    near = EQUAL * span
    firsts = np.flatnonzero(np.concatenate([[True], np.abs(np.diff(x)) > near]))
    lengths, values = np.diff(np.append(firsts, len(x))), x[firsts]
    levels, counts = np.unique(np.round(x / near) * near, return_counts=True)
    often = levels[counts > FEWEST_STAYS]
    ends = [float(often[k]) for k in ((0, -1) if len(often) else ())]
    within = lengths[np.all([np.abs(values - end) > near for end in ends], axis=0)] if ends else lengths
    usual, long = (float(np.quantile(within, share)) for share in (0.5, 0.99)) if len(within) else (1.0, 1.0)
    resolution = resolution_of(x)
    has_steps = bool((counts[~np.isin(levels, [*ends, levels[0], levels[-1], 0.0])] > 1).any())
    for sign, end in zip((1, -1), ends, strict=False):
        depth = sign * (x - end)
        at = np.abs(depth) <= near
        step = max(resolution, float(depth[depth > near].min(initial=span)))
        count = float(((depth > near) & (depth <= 1.5 * step)).sum()) - (step > 1.5 * resolution)
        most = PARABOLA * (count / usual + POISSON * np.sqrt(max(count, 0.0) / usual)) if has_steps else 0.0
        is_end = (depth < -near).sum() <= BEYOND * at.sum() and abs(end) > 2 * near
        if is_end and at.sum() / usual > max(FEWEST_STAYS, most):
            staying |= at
    changes = np.append(np.abs(np.diff(values)), 0.0)
    leaps = changes > LEAP * np.median(changes)
    stuck = (lengths > max(LONGEST_STAY * long, SHORTEST_STUCK)) & (np.abs(values) > near) & leaps
    staying |= np.repeat(stuck, lengths)
    return staying


def frozen(x: Array) -> BoolArray:
    """Return a mask of samples (N) of a position that are constant during motion, as beyond a sensor's range.

    A joint that comes to rest slows down before it stands: there the position bends no more than elsewhere.
    """
    still, span = np.zeros(len(x), dtype=bool), float(np.ptp(x)) if len(x) else 0.0
    firsts = np.flatnonzero(np.concatenate([[True], np.abs(np.diff(x)) > EQUAL * span]))
    lengths = np.diff(np.append(firsts, len(x)))
    long = lengths > max(SHORTEST_STUCK, LONGEST_STAY * float(np.quantile(lengths, 0.5))) if span else lengths < 0
    starts, ends = firsts[long], firsts[long] + lengths[long] - 1
    bends = np.zeros(len(starts), dtype=bool)
    for reach in BENDS if len(starts) else ():
        bend = np.zeros(len(x))
        bend[reach:-reach] = np.abs(x[2 * reach :] - 2 * x[reach:-reach] + x[: -2 * reach])
        moving = ~neighbourhood(np.isin(np.arange(len(x)), [*starts, *ends]) | np.repeat(long, lengths), reach)
        usual = np.quantile(bend[moving], 0.998) if moving.any() else np.inf
        bent = np.maximum(bend[starts], bend[ends]) > FAR_BENT * max(float(usual), resolution_of(x))
        bends |= bent & (lengths[long] > reach)
    for first, last in zip(starts[bends], ends[bends], strict=True):
        still[first : last + 1] = True
    return still


def repetitions(x: ComplexArray) -> BoolArray:
    """Return a mask of lines (N) that repeat the previous one in long stretches, as in padded files."""
    same = np.concatenate([[False], (x[1:] == x[:-1]) & (x[1:] != 0)])
    starts = np.flatnonzero(~same)
    lengths = np.diff(np.append(starts, len(x)))
    return same & np.repeat((lengths > FEWEST_REPEATED) & (lengths < len(x)), lengths)


def neighbourhood(marked: BoolArray, reach: int) -> BoolArray:
    """Return a mask of the marked samples (N) and their `reach` neighbours on each side."""
    near = np.convolve(marked, np.ones(2 * reach + 1), mode="same") if reach else marked
    return np.asarray(near > 0.5)


@dataclass(frozen=True)
class Wraps:
    """Jumps of a wrapping counter: their number, the first sample after a jump (from 0), and the period."""

    count: int
    first: int
    period: float


def wraps_of(t: Array, x: Array) -> Wraps | None:
    """Return the wraps of positions x (N) at times t: jumps of one size, far above other steps; None without any.

    Spikes, which come back within a few samples, are none, and neither are gaps in time.
    """
    steps = np.diff(x)
    steps[np.diff(t) > LATE * np.median(np.diff(t))] = 0.0
    size = np.abs(steps)
    jumps = np.flatnonzero(size > 0.5 * size.max(initial=0.0))
    steady = np.delete(size, jumps)
    usual = float(np.quantile(steady, 0.98)) if len(steady) > 4 * len(jumps) else np.inf
    if not len(jumps) or not 0 < usual * WRAP_OVER_STEPS < size[jumps].min():
        return None
    back = [k for k in jumps if np.abs(x[k + 2 : k + 2 + SPIKE] - x[k]).min(initial=np.inf) < 0.1 * size[k]]
    forth = [k for k in jumps if np.abs(x[max(k - SPIKE, 0) : k] - x[k + 1]).min(initial=np.inf) < 0.1 * size[k]]
    lasting = np.setdiff1d(jumps, [*back, *forth])
    if not len(lasting):
        return None
    period = float(np.median(size[lasting]))
    if np.ptp(size[jumps]) > ALIKE_WRAPS * period or np.ptp(x) > (1 + ALIKE_WRAPS) * period:
        return None
    inner = lasting[(lasting > 0) & (lasting < len(steps) - 1)]
    along = np.abs(steps[inner] - (steps[inner - 1] + steps[inner + 1]) / 2)
    return Wraps(len(jumps), int(lasting[0]) + 1, float(np.median(along)) if len(inner) else period)
