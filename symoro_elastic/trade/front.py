"""Which points are worth their time, and which is the fastest that is good enough."""

from __future__ import annotations

import math
from collections.abc import Iterable

from symoro_elastic.trade.points import Figures

MATTERS = 1.25
"""How much smaller the worst error of some random states must be to be more than luck."""


def front(figures: Iterable[Figures], with_fast_math: bool = False) -> list[Figures]:
    """The Pareto front, fastest first: no other point is faster and as accurate, or nearly so.

    Points with -ffast-math are on it only where they are allowed to be.
    """
    found: list[Figures] = []
    for one in sorted(_allowed(figures, with_fast_math), key=lambda f: (f.ns, f.error)):
        if math.isfinite(one.error) and (not found or one.error * MATTERS < found[-1].error):
            found.append(one)
    return found


def fastest_within(figures: Iterable[Figures], tolerance: float, with_fast_math: bool = False) -> Figures | None:
    """The fastest point whose worst error is within a tolerance; None where there is none."""
    good = [one for one in _allowed(figures, with_fast_math) if one.error <= tolerance]
    return min(good, key=lambda one: one.ns, default=None)


def most_accurate(figures: Iterable[Figures], with_fast_math: bool = False) -> Figures:
    """The point with the smallest worst error, the fastest of several."""
    return min(_allowed(figures, with_fast_math), key=lambda one: (_or_infinite(one.error), one.ns))


def _allowed(figures: Iterable[Figures], with_fast_math: bool) -> list[Figures]:
    return [one for one in figures if with_fast_math or one.point.is_safe]


def _or_infinite(error: float) -> float:
    return math.inf if math.isnan(error) else error
