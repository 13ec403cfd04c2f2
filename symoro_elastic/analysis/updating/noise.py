"""How exact measured responses are: standard deviations of their real and imaginary parts, by line.

With coherence g2 that was estimated from n averages, too:  sd^2 = |H|^2 (1 - g2)/(2 g2 (n - 1)).  That of Bendat and
Piersol, Random Data, with n, needs the true coherence: of n records about a mean, n - 1 are free.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from symoro_elastic.analysis.updating.measured import MeasuredResponse
from symoro_elastic.foundation.array_types import Array

LEAST_COHERENCE, MOST_COHERENCE = 0.01, 1 - 1e-4
LARGEST_CHI2, TAIL = 1.15, 0.9
"""Without and with the tails of noise from n averages, found by simulation: chi2 is 1.33, 1.22, 1.09 with 3, 5, 10."""
SELDOM, USUAL_AVERAGES = 1e-5, 10
"""Share of lines that noise puts beyond the limit of spikes; averages where they are not known."""
GUESS = 0.01
"""Of |H| and of its median: what noise is taken to be until residuals tell it."""


def is_known(response: MeasuredResponse, averages: int | None) -> bool:
    """Whether coherence and averages tell the noise, so that chi2 says something about the model."""
    return response.coherence is not None and averages is not None and averages > 1


def usual_chi2(averages: Sequence[int]) -> float:
    """Return the largest chi2 of a right model; where few averages tell the noise, it is off in some lines."""
    return LARGEST_CHI2 + TAIL / max(min(averages, default=math.inf) - 1, 1)


def spike_limit(averages: int | None) -> float:
    """Return the size of complex residuals that noise seldom exceeds: P = (1 + r^2/k)^(-k/2), k = 2 (n - 1)."""
    free = 2 * max((averages or USUAL_AVERAGES) - 1, 1)
    return math.sqrt(free * (SELDOM ** (-2 / free) - 1))


def deviations(response: MeasuredResponse, averages: int | None) -> Array:
    """Return the standard deviations (N) of real and imaginary parts; only their shape where these are unknown."""
    size = np.abs(response.H)
    if response.coherence is None:
        shape: Array = GUESS * np.hypot(size, np.median(size))
        return shape
    g2 = np.clip(response.coherence, LEAST_COHERENCE, MOST_COHERENCE)
    found: Array = size * np.sqrt((1 - g2) / (2 * g2 * max((averages or 1) - 1, 1)))
    return np.maximum(found, 1e-3 * GUESS * max(float(np.median(size)), np.finfo(float).tiny))
