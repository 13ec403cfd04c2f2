"""Samples of smooth functions: values between them, derivatives by their arguments."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symoro_elastic.foundation.array_types import Array

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


def interpolate(h: float, x: tuple[Array, Array, Array], wanted: Array) -> tuple[Array, Array]:
    """Return x and x' (M, ...) at times (M,) from x, x', x'' (N, ...) at times h apart from 0.

    Between samples they are polynomials of degree 5 with these values at both ends.
    """
    place = np.clip(wanted / h, 0.0, len(x[0]) - 1)
    first = np.minimum(place.astype(int), len(x[0]) - 2)
    s = (place - first).reshape(-1, *(1,) * (x[0].ndim - 1))
    (a, b), (u, v), (f, g) = ((y[first] * h**k, y[first + 1] * h**k) for k, y in enumerate(x))
    rise, turn, bend = b - a - u - f / 2, v - u - f, (g - f) / 2  # what the last three coefficients have to reach
    c3, c4, c5 = 10 * rise - 4 * turn + bend, -15 * rise + 7 * turn - 2 * bend, 6 * rise - 3 * turn + bend
    value = a + s * (u + s * (f / 2 + s * (c3 + s * (c4 + s * c5))))
    rate = u + s * (f + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))
    return value, rate / h


def slopes(function: Callable[[Array], Array], x: Array) -> Array:
    """Return the derivatives (N, ..., n) of values (N, ...) by x (N, n), by central differences."""
    changes = STEP * np.eye(x.shape[1])
    return np.stack([(function(x + change) - function(x - change)) / (2 * STEP) for change in changes], axis=-1)
