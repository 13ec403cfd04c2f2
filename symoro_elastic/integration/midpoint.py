"""The implicit midpoint rule: y(t + h) = y + h k, k = f(t + h/2, y + h k/2)."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.quantities.time_steps import TimeStep


@dataclass(frozen=True)
class Midpoint:
    """The rule with a fixed number of steps of Newton's method, each with the system of W-methods."""

    name: str
    title: str
    order: int
    iterations: int


MIDPOINT = Midpoint(TimeStep.MIDPOINT, "implicit midpoint rule, order 2", 2, 4)
"""Hairer, Lubich and Wanner, Geometric Numerical Integration, section II.1.1, Gauss method of one stage: it keeps the
energy of linear vibrations."""
