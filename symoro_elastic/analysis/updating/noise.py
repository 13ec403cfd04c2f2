"""How exact measured responses are: standard deviations of their real and imaginary parts, by line.

With coherence g2 of n averages (Bendat and Piersol, Random Data):  sd^2 = |H|^2 (1 - g2)/(2 g2 n)
"""

from __future__ import annotations

import numpy as np

from symoro_elastic.analysis.updating.measured import MeasuredResponse
from symoro_elastic.foundation.array_types import Array

LEAST_COHERENCE, MOST_COHERENCE = 0.01, 1 - 1e-4
GUESS = 0.01
"""Of |H| and of its median: what noise is taken to be until residuals tell it."""


def is_known(response: MeasuredResponse, averages: int | None) -> bool:
    """Whether coherence and averages tell the noise, so that chi2 says something about the model."""
    return response.coherence is not None and averages is not None


def deviations(response: MeasuredResponse, averages: int | None) -> Array:
    """Return the standard deviations (N) of real and imaginary parts; only their shape where these are unknown."""
    size = np.abs(response.H)
    if response.coherence is None:
        shape: Array = GUESS * np.hypot(size, np.median(size))
        return shape
    g2 = np.clip(response.coherence, LEAST_COHERENCE, MOST_COHERENCE)
    found: Array = size * np.sqrt((1 - g2) / (2 * g2 * (averages or 1)))
    return np.maximum(found, 1e-3 * GUESS * max(float(np.median(size)), np.finfo(float).tiny))
