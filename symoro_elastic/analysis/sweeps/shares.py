"""The share of points at which results are within the ranges that they are required in, and what a sample says of it.

Of n independent draws k are within: the interval of Clopper and Pearson (1934) holds the share of all draws with a
probability of at least `CONFIDENCE`, whatever it is. Points of a Latin hypercube are not independent; the interval is
wider than theirs where results are nearly sums of what each quantity does. A Sobol sequence and a grid have none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from numbers import Real

import numpy as np

from symoro_elastic.analysis.sweeps.design import Design
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.machine.names import did_you_mean, quote

CONFIDENCE = 0.95
INDEPENDENT = ("random", "latin")
ALL = "all of them"


@dataclass(frozen=True)
class Share:
    """Of `points`, the number `within` the range low to high of a result; `interval` of the share of all draws."""

    name: str
    low: float
    high: float
    within: int
    points: int
    interval: tuple[float, float] | None

    @property
    def share(self) -> float:
        """The share of the points."""
        return self.within / self.points


def shares(
    design: Design, figures: Mapping[str, Array], required: Mapping[str, tuple[float, float]]
) -> tuple[Share, ...]:
    """Return the share for each result, and that of points at which all are within their ranges where there are more.

    `required` are ranges by name of a result, or by pattern. A point without a result is not within. Raises
    `InputError` for a name that no result has.
    """
    found: list[Share] = []
    everywhere = np.ones(len(design.points), dtype=bool)
    for pattern, ends in required.items():
        low, high = _ends(pattern, ends)
        names = [name for name in figures if name == pattern or fnmatchcase(name, pattern)]
        if not names:
            what = f"there is no result {quote(pattern)}{did_you_mean(pattern, figures)}"
            raise InputError("symoro-elastic", "--require", what)
        for name in names:
            inside = (figures[name] >= low) & (figures[name] <= high)
            everywhere &= inside
            found.append(_share(design, name, low, high, inside))
    if len(found) > 1:
        found.append(_share(design, ALL, -np.inf, np.inf, everywhere))
    return tuple(found)


def _ends(name: str, given: object) -> tuple[float, float]:
    if isinstance(given, Sequence) and len(given) == 2 and all(isinstance(x, Real) for x in given):
        low, high = map(float, given)
        if low <= high:
            return low, high
    raise InputError("symoro-elastic", "--require", f"{quote(name)}: {given!r} is not (low, high)")


def _share(design: Design, name: str, low: float, high: float, inside: BoolArray) -> Share:
    within, points = int(inside.sum()), len(inside)
    interval = interval_of(within, points) if design.sampling in INDEPENDENT else None
    return Share(name, low, high, within, points, interval)


@cache
def interval_of(within: int, points: int) -> tuple[float, float]:
    """Return the interval of Clopper and Pearson of a share, of which `within` of `points` draws are."""
    found = import_optional("scipy.stats", "an interval of confidence", "sweep").binomtest(within, points)
    interval = found.proportion_ci(CONFIDENCE, "exact")
    return float(interval.low), float(interval.high)
