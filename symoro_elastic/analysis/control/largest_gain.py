"""The largest gain that keeps a modulus margin: exact at each frequency, without a search over gains.

With an open loop of which 1 + L = a + k b, the distance |a + k b| >= modulus is a quadratic in k: each frequency
forbids an interval of k. What is left between the intervals of all frequencies are gaps. Of the lowest ones in which
the closed loop is stable, one after the other, the last one counts: an integral part may forbid gains between two of
them, at which the loop is stable, too. Its upper end, the least lower end of the intervals above it, is the largest
gain. Above the first gap that is not stable others may be: it is the largest from below. The gap above all intervals
counts where the last frequency forbids no gain, as of velocity loops without dead time and lag: nothing limits it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray

Terms = tuple[ComplexArray, ComplexArray]
"""a and b of 1 + L = a + k b, over frequencies."""
EXACT = 1e-12
"""Relative error of the critical frequency."""
FAR = 1e100
"""A gain that nothing limits, while the minimum is searched: its square is a number."""
TRIED, MOST_TURNS, SMOOTH = 17, 16, 2
"""Places at a time between neighbours, which narrow their interval by 8, how often at most, and how often before a
polynomial may be taken."""
FLAT, SAME, NEWTON = 1e-4, 1e-13, 8
"""Of the least value: what its neighbours may be above it where a polynomial is taken, and what rounding is; steps."""
LEAST = 1e-12
"""Relative width of a gap below which it is none."""


@dataclass(frozen=True)
class LargestGain:
    """The largest gain, and the frequency, Hz, at which the margin is met; infinite and NaN for an unlimited gain."""

    gain: float
    frequency: float


def forbidden(a: ComplexArray, b: ComplexArray, modulus: float) -> tuple[Array, Array]:
    """Return the ends of the intervals of k > 0 in which |a + k b| < modulus; NaN for an empty interval."""
    square, half = np.abs(b) ** 2, (a.conj() * b).real
    constant = np.abs(a) ** 2 - modulus**2
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(half**2 - square * constant)
        high = (root - half) / square
        # The product of both roots is rest/square: the smaller one without cancellation.
        low = np.where(half < 0, constant / (root - half), (-half - root) / square)
    is_interval = (high > 0) & np.isfinite(root) & (square > 0)
    return np.where(is_interval, np.maximum(low, 0.0), np.nan), np.where(is_interval, high, np.nan)


def gaps(low: Array, high: Array) -> list[tuple[float, float]]:
    """Return the intervals of k > 0 without a forbidden frequency, ascending; the last may end at infinity.

    One that the first frequency ends is none: lower frequencies would end it earlier.
    """
    order = np.argsort(low)
    intervals, reached = [], 0.0
    for k in order[~np.isnan(low[order])]:
        if low[k] > reached and k > 0:
            intervals.append((reached, float(low[k])))
        reached = max(reached, float(high[k]))
    return [*intervals, (reached, np.inf)]


def largest_gain(
    terms: Callable[[Array], Terms], frequencies: Array, modulus: float, is_stable: Callable[[float], bool]
) -> LargestGain | None:
    """Return the largest gain k, or None if no gap between forbidden intervals is stable.

    `terms` gives a and b at frequencies in Hz, `frequencies` are those that are tried, close to each other where the
    loop changes fast.
    """
    low, high = forbidden(*terms(frequencies), modulus)
    *between, top = gaps(low, high)
    above = None
    for lower, upper in [*between, *([top] if np.isnan(high[-1]) else [])]:
        if upper > (1 + LEAST) * lower:
            inside = float(np.sqrt(lower * upper)) or upper / 2
            if is_stable(inside if upper < np.inf else 2 * lower or 1.0):
                above = lower
            elif above is not None:
                break
    if above is None:
        return None
    if above == top[0]:
        return LargestGain(np.inf, np.nan)
    return _least_lower_end(terms, frequencies, low, modulus, above)


def _least_lower_end(
    terms: Callable[[Array], Terms], frequencies: Array, low: Array, modulus: float, above: float
) -> LargestGain:
    """Return the least gain larger than `above` at which a forbidden interval begins, refined between `frequencies`."""
    candidates = np.where(low > above, low, np.inf)
    best = LargestGain(float(candidates.min()), float(frequencies[candidates.argmin()]))

    def lower_ends(f: Array) -> Array:
        ends, _ = forbidden(*terms(f), modulus)
        return np.where(ends > above, ends, FAR)

    ends = np.concatenate([candidates[:1], candidates, candidates[-1:]])
    dips = np.flatnonzero(np.isfinite(candidates) & (candidates <= np.minimum(ends[:-2], ends[2:]))).tolist()
    for k in sorted(dips, key=lambda k: float(candidates[k]))[:3]:
        value, frequency = refined_minimum(lower_ends, frequencies, k)
        if value < best.gain:
            best = LargestGain(value, frequency)
    return best


def refined_minimum(of: Callable[[Array], Array], frequencies: Array, k: int) -> tuple[float, float]:
    """Return the least value between the neighbours of frequency k, and its frequency.

    Several places are tried at a time, the interval gets narrower by 8, until a polynomial of degree 4 through
    the five that are nearest is right: its lowest place is more exact than differences of values. Where values
    jump, the interval gets narrower as far as numbers do.
    """
    middle = float(frequencies[k])
    low, high = frequencies[[max(k - 1, 0), min(k + 1, len(frequencies) - 1)]] - middle
    best = (float(of(frequencies[k : k + 1])[0]), middle)
    for turn in range(MOST_TURNS):
        offsets = np.linspace(low, high, TRIED)
        values = of(middle + offsets)
        lowest = int(np.nanargmin(values))
        best = min(best, (float(values[lowest]), middle + float(offsets[lowest])))
        if high - low <= EXACT * middle:
            break
        near = slice(min(max(lowest - 2, 0), TRIED - 5), min(max(lowest - 2, 0), TRIED - 5) + 5)
        if turn >= SMOOTH and values[near].max() - values[lowest] < FLAT * abs(values[lowest]):
            place = _lowest_of_polynomial(offsets[near], values[near])
            value = float(of(np.array([middle + place]))[0])
            return (value, middle + place) if value <= best[0] * (1 + SAME) else best
        low, high = offsets[max(lowest - 1, 0)], offsets[min(lowest + 1, TRIED - 1)]
    return best


def _lowest_of_polynomial(x: Array, values: Array) -> float:
    """Return the minimizer of the polynomial of degree 4 through five equidistant points, between their ends."""
    h = (x[4] - x[0]) / 4
    series = np.polynomial.Polynomial.fit(x, values - values.min(), 4, domain=[x[2] - h, x[2] + h], window=[-1, 1])
    slope, bend = series.deriv(), series.deriv(2)
    place = x[int(values.argmin())]
    for _ in range(NEWTON):
        if not bend(place) > 0:
            break
        place = float(np.clip(place - slope(place) / bend(place), x[0], x[4]))
    return float(place)
