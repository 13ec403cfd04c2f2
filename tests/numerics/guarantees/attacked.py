"""Attacks on proven bounds: dense samples of a box, and climbing from the largest of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.box import Box

Array = NDArray[np.float64]


def worst_found(f: Callable[[Array], Array], box: Box, samples: int, seed: int, climbs: int = 4) -> float:
    """The largest |f| found; `f` takes (variables, states), in the order of the box. Half of the states are at ends."""
    draw = np.random.default_rng(seed)
    low, high = (np.array([getattr(x, end) for x in box.ranges.values()]) for end in ("low", "high"))
    share = draw.uniform(size=(len(box.ranges), samples))
    some = share[:, samples // 2 :]
    some[:] = np.where(draw.uniform(size=some.shape) < 0.5, some.round(), some)
    states = low[:, None] + (high - low)[:, None] * share
    values = np.abs(f(states))
    best = float(values.max())
    for k in np.argsort(-values)[:climbs]:
        ends = [*zip(low, high, strict=True)]
        found = minimize(lambda x: -abs(f(x[:, None])[0]), states[:, k], method="L-BFGS-B", bounds=ends)
        best = max(best, -float(found.fun))
    return best


def box_of(positions: str = "", **ranges: Sequence[float]) -> Box:
    """A box from pairs of ends, by name; `positions` are names, with spaces between."""
    return Box({name: Range(*map(float, ends)) for name, ends in ranges.items()}, frozenset(positions.split()))
