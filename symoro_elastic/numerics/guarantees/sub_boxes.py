"""Sub-boxes: a box is cut where that makes bounds smallest, and all parts are looked at together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.guarantees.intervals import Interval

Parts: TypeAlias = Mapping[str, Interval]
"""The sub-boxes of a box: the intervals of each variable, one for each sub-box."""
LEAST_GAIN = 0.02
"""Of the mean logarithm of bounds: cutting a box is worth as much."""
UNBOUNDED = 1e30
"""Stands for no bound, where boxes in parts are compared."""


def halved(parts: Parts, name: str) -> dict[str, Interval]:
    """Twice as many sub-boxes: each cut in the middle of one variable."""
    cut = parts[name]
    middle = cut.low / 2 + cut.high / 2
    halves = {each: Interval(np.tile(x.low, 2), np.tile(x.high, 2)) for each, x in parts.items()}
    halves[name] = Interval(np.concatenate([cut.low, middle]), np.concatenate([middle, cut.high]))
    return halves


def side_by_side(boxes: Sequence[Parts]) -> dict[str, Interval]:
    """The sub-boxes of several boxes in one row, to be looked at together."""
    joined = {name: [box[name] for box in boxes] for name in boxes[0]}
    return {
        name: Interval(np.concatenate([x.low for x in parts]), np.concatenate([x.high for x in parts]))
        for name, parts in joined.items()
    }


def cut(
    whole: Parts,
    names: Sequence[str],
    bounds: Callable[[Parts], Array],
    most: int,
    progress: Progress = no_progress,
    least_gain: float = LEAST_GAIN,
) -> Parts:
    """At most so many sub-boxes of a box, cut each time in the middle of the variable that makes bounds smallest.

    `bounds` gives the bound of each result (results, sub-boxes); of a box in parts the largest counts. It ends
    where a cut gains less than `least_gain`.
    """
    if not names:
        return whole
    steps = int(math.log2(most))
    (before,) = _sizes([whole], bounds)
    for step in range(steps):
        tried = [halved(whole, name) for name in names]
        sizes = _sizes(tried, bounds)
        progress(step + 1, steps)
        best = min(range(len(tried)), key=sizes.__getitem__)
        if not sizes[best] < before - least_gain:
            break
        whole, before = tried[best], sizes[best]
    return whole


def _sizes(boxes: Sequence[Parts], bounds: Callable[[Parts], Array]) -> list[float]:
    """The mean logarithm of the bounds of each of some boxes, in as many parts each."""
    found = bounds(side_by_side(boxes))
    by_box = found.reshape(len(found), len(boxes), -1).max(axis=2)
    logs = np.log(np.where(np.isfinite(by_box), by_box, UNBOUNDED), where=by_box > 0, out=np.zeros_like(by_box))
    return [float(each) for each in logs.mean(axis=0)]
