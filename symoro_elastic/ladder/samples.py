"""Samples of smooth functions: values between them, derivatives by their arguments."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symoro_elastic.array_types import Array

STEP = 1e-6
"""Of central differences, rad, m, rad/s or m/s: of quantities that change over 1, they are right to 1e-10."""


def between(t: Array, x: Array, wanted: Array) -> Array:
    """Return x (N, ...) given at even times t (N,) at the times wanted, linear between."""
    place = np.clip((wanted - t[0]) / (t[1] - t[0]), 0, len(t) - 1)
    k = np.minimum(place.astype(int), len(t) - 2)
    share = (place - k).reshape(-1, *(1,) * (x.ndim - 1))
    found: Array = (1 - share) * x[k] + share * x[k + 1]
    return found


def slopes(function: Callable[[Array], Array], x: Array) -> Array:
    """Return the derivatives (N, ..., n) of values (N, ...) by x (N, n), by central differences."""
    changes = STEP * np.eye(x.shape[1])
    return np.stack([(function(x + change) - function(x - change)) / (2 * STEP) for change in changes], axis=-1)
