"""A bound on the largest of many errors that have not been drawn, from the largest of those that have.

Above a high threshold errors have a tail P(e > x) = c x^-a: a result is small where its terms cancel. Of n errors, u is
the one of rank k + 1 and S = sum ln(e_i / u) over the k above it. With G = a S of a gamma distribution of shape k, the
largest of m more errors has ln(max / u) <= t S with the probability

    E[(1 + m/n exp(-t G))^-(k + 1)]

whatever c and a are. Lighter tails are within the bound more often. Tails of machines grow heavier further out, where
all entries of a result cancel: a bound is fitted to a higher probability (`FITTED`) than what it promises
(`CONFIDENCE`), which tests draw.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from symoro_elastic.array_types import Array

MOST_IN_TAIL, SHARE_IN_TAIL = 50, 20
"""The tail is a twentieth of the errors, at most fifty of them."""
FEWEST_IN_TAIL = 2
CONFIDENCE, FITTED = 0.95, 0.99
GRID, SPREAD = 4001, 12.0


def bound_of_more(errors: Array, more: int, fitted: float = FITTED) -> float:
    """Return a bound on the largest of `more` errors that are not drawn yet, with a probability.

    `errors` (n,) are drawn at random, positive; infinite where one of them is, or where they are fewer than 40.
    """
    tail = min(MOST_IN_TAIL, len(errors) // SHARE_IN_TAIL)
    if tail < FEWEST_IN_TAIL or not np.isfinite(errors).all():
        return math.inf
    largest = np.sort(errors)[-tail - 1 :]
    spread = float(np.log(largest[1:] / largest[0]).sum())
    exponent = _quantile(tail, more / len(errors), fitted) * spread
    return float(largest[0]) * math.exp(exponent) if exponent < 700 else math.inf


@cache
def _quantile(tail: int, ratio: float, confidence: float) -> float:
    """Return t of the confidence; `ratio` is m/n."""
    shape = np.linspace(max(0.0, tail - SPREAD * math.sqrt(tail)), tail + SPREAD * math.sqrt(tail) + SPREAD, GRID)[1:]
    log_density = (tail - 1) * np.log(shape) - shape
    density = np.exp(log_density - log_density.max())
    density /= density.sum()
    low, high = 0.0, 1.0
    while _probability(high, tail, ratio, shape, density) < confidence:
        low, high = high, 2 * high
    for _ in range(60):
        middle = (low + high) / 2
        if _probability(middle, tail, ratio, shape, density) < confidence:
            low = middle
        else:
            high = middle
    return high


def _probability(t: float, tail: int, ratio: float, shape: Array, density: Array) -> float:
    """Return the probability that the largest of m more errors is below u exp(t S)."""
    return float(density @ np.exp(-(tail + 1) * np.log1p(ratio * np.exp(-t * shape))))
