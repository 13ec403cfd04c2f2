"""Samples of smooth functions: values between them, derivatives by their arguments."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symoro_elastic.array_types import Array

NEIGHBOURS = range(4)
STEP = 1e-6
"""Of central differences, rad, m, rad/s or m/s: of quantities that change over 1, they are right to 1e-10."""


def between(t: Array, x: Array, wanted: Array) -> Array:
    """Return x (N, ...), given at even times t (N,), at other times: cubic through the four nearest."""
    place = (wanted - t[0]) / (t[1] - t[0])
    first = np.clip(place.astype(int) - 1, 0, len(t) - len(NEIGHBOURS))
    s = place - first
    total = np.zeros((len(wanted), *x.shape[1:]))
    for k in NEIGHBOURS:
        others = [m for m in NEIGHBOURS if m != k]
        weight = np.prod([(s - m) / (k - m) for m in others], axis=0)
        total += weight.reshape(-1, *(1,) * (x.ndim - 1)) * x[first + k]
    return total


def slopes(function: Callable[[Array], Array], x: Array) -> Array:
    """Return the derivatives (N, ..., n) of values (N, ...) by x (N, n), by central differences."""
    changes = STEP * np.eye(x.shape[1])
    return np.stack([(function(x + change) - function(x - change)) / (2 * STEP) for change in changes], axis=-1)
