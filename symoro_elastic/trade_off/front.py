"""The Pareto front of time and error, and the fastest configuration within a tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterable

from symoro_elastic.trade_off.configurations import Measurement

MATTERS = 1.25
"""Ratio of worst errors over random states above which the difference is significant."""


def front(measurements: Iterable[Measurement], with_fast_math: bool = False) -> list[Measurement]:
    """Return the Pareto front, fastest first: no other configuration is faster and as accurate, or nearly so.

    Configurations with -ffast-math are on it only if `with_fast_math` allows them.
    """
    best: list[Measurement] = []
    for one in sorted(_allowed(measurements, with_fast_math), key=lambda f: (f.ns, f.error)):
        if math.isfinite(one.error) and (not best or one.error * MATTERS < best[-1].error):
            best.append(one)
    return best


def fastest_within(
    measurements: Iterable[Measurement], tolerance: float, with_fast_math: bool = False
) -> Measurement | None:
    """Return the fastest configuration whose errors at other states are bounded by a tolerance, or None."""
    good = [one for one in _allowed(measurements, with_fast_math) if one.bound <= tolerance]
    return min(good, key=lambda one: one.ns, default=None)


def most_accurate(measurements: Iterable[Measurement], with_fast_math: bool = False) -> Measurement:
    """Return the configuration with the smallest bound on errors, the fastest of several."""
    return min(_allowed(measurements, with_fast_math), key=lambda one: (_or_infinite(one.bound), one.ns))


def _allowed(measurements: Iterable[Measurement], with_fast_math: bool) -> list[Measurement]:
    return [one for one in measurements if with_fast_math or one.configuration.is_safe]


def _or_infinite(error: float) -> float:
    return math.inf if math.isnan(error) else error
