"""Steps of explicit Runge-Kutta methods."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from symoro_elastic.array_types import Array
from symoro_elastic.integration.tableaus import Tableau

Rate = Callable[[float, Array], Array]
"""f of y' = f(t, y)."""


def step(tableau: Tableau, rate: Rate, t: float, y: Array, h: float) -> Array:
    """Return y at t + h of y' = f(t, y), where `rate` is f and y an array of any shape.

    k_i = f(t + c_i h, y + h sum_j a_ij k_j),    y(t + h) = y + h sum_i b_i k_i
    """
    k: list[Array] = []
    for c, row in tableau.stages:
        k.append(rate(t + c * h, _moved(y, h, row, k)))
    return _moved(y, h, tableau.weights, k)


def _moved(y: Array, h: float, weights: Iterable[float], k: Iterable[Array]) -> Array:
    """Return y + h sum_j a_j k_j; terms with a_j = 0 are left out."""
    for a, rate in zip(weights, k, strict=True):
        if a:
            y = y + (h * a) * rate
    return y
