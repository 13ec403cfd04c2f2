"""The largest gain that keeps a distance from instability: exact at each frequency, without a search over gains.

With an open loop of which 1 + L = a + k b, the distance |a + k b| >= modulus is a quadratic in k: each frequency
forbids an interval of k. What is left between the intervals of all frequencies are gaps; the largest gain is the upper
end of the lowest gap in which the closed loop is stable, the least lower end of the intervals above it. Above it other
stable gaps may exist: it is the largest from below. The gap above all intervals counts only where there is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.packages import for_vibrations

Terms = tuple[ComplexArray, ComplexArray]
"""a and b of 1 + L = a + k b, over frequencies."""
EXACT = 1e-12
"""Relative error of the critical frequency."""
FAR = 1e100
"""A gain that nothing limits, while the least one is sought: its square is a number."""
LEAST = 1e-12
"""Of the largest lower end, below which a gain is nothing."""


@dataclass(frozen=True)
class LargestGain:
    """The largest gain, and the frequency, Hz, at which the distance is met; infinite and NaN where none limits it."""

    gain: float
    frequency: float


def forbidden(a: ComplexArray, b: ComplexArray, modulus: float) -> tuple[Array, Array]:
    """Return the ends of the intervals of k > 0 in which |a + k b| < modulus; NaN where there is none."""
    square, half = np.abs(b) ** 2, (a.conj() * b).real
    rest = np.abs(a) ** 2 - modulus**2
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(half**2 - square * rest)
        high = (root - half) / square
        # The product of both roots is rest/square: the smaller one without cancellation.
        low = np.where(half < 0, rest / (root - half), (-half - root) / square)
    found = (high > 0) & np.isfinite(root) & (square > 0)
    return np.where(found, np.maximum(low, 0.0), np.nan), np.where(found, high, np.nan)


def gaps(low: Array, high: Array) -> list[tuple[float, float]]:
    """Return the intervals of k > 0 that no frequency forbids, ascending; the last one may end at infinity.

    One that the first frequency ends is none: lower frequencies would end it earlier.
    """
    order = np.argsort(low)
    found, reached = [], 0.0
    for k in order[~np.isnan(low[order])]:
        if low[k] > reached and k > 0:
            found.append((reached, float(low[k])))
        reached = max(reached, float(high[k]))
    return [*found, (reached, np.inf)]


def largest_gain(
    terms: Callable[[Array], Terms], frequencies: Array, modulus: float, is_stable: Callable[[float], bool]
) -> LargestGain | None:
    """Return the largest gain k, or None where no gap between forbidden intervals is stable.

    `terms` gives a and b at frequencies in Hz, `frequencies` are those that are tried, close to each other where the
    loop changes fast.
    """
    low, high = forbidden(*terms(frequencies), modulus)
    for lower, upper in gaps(low, high):
        if upper == np.inf:
            return LargestGain(np.inf, np.nan) if lower == 0 and is_stable(1.0) else None
        if upper - lower > LEAST * upper and is_stable(np.sqrt(lower * upper) or upper / 2):
            return _refined(terms, frequencies, low, modulus, lower)
    return None


def _refined(
    terms: Callable[[Array], Terms], frequencies: Array, low: Array, modulus: float, above: float
) -> LargestGain:
    """Return the least lower end above a gain, between the neighbours of the frequencies where it is least."""
    candidates = np.where(low > above, low, np.inf)
    best = LargestGain(float(candidates.min()), float(frequencies[candidates.argmin()]))

    def lower_end(frequency: float) -> float:
        ends, _ = forbidden(*terms(np.array([frequency])), modulus)
        return float(ends[0]) if ends[0] > above else FAR

    dips = [k for k in range(len(low)) if np.isfinite(candidates[k]) and candidates[k] <= _beside(candidates, k)]
    for k in sorted(dips, key=lambda k: float(candidates[k]))[:3]:
        value, frequency = refined_minimum(lower_end, frequencies, k)
        if value < best.gain:
            best = LargestGain(value, frequency)
    return best


def refined_minimum(of: Callable[[float], float], frequencies: Array, k: int) -> tuple[float, float]:
    """Return the least value between the neighbours of frequency k, and its place.

    It is sought over the distance from frequency k, so that the place is as exact as the minimum is flat.
    """
    search = for_vibrations("scipy.optimize").minimize_scalar
    middle, ends = frequencies[k], frequencies[[max(k - 1, 0), min(k + 1, len(frequencies) - 1)]]
    found = search(lambda d: of(middle + d), bounds=tuple(ends - middle), method="bounded",
                   options={"xatol": EXACT * middle})  # fmt: skip
    here = of(float(middle))
    return (float(found.fun), float(middle + found.x)) if found.fun < here else (here, float(middle))


def _beside(values: Array, k: int) -> float:
    """Return the smaller neighbour of a value."""
    return float(min(values[max(k - 1, 0)], values[min(k + 1, len(values) - 1)]))
