"""Attacks on proven bounds: dense samples of a box, and climbing from the largest of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Array = NDArray[np.float64]


class Range(NamedTuple):
    """A range of a variable."""

    low: float
    high: float


def worst_found(
    f: Callable[[Array], Array], box: Mapping[str, Range], samples: int, seed: int, climbs: int = 4
) -> float:
    """The largest |f| found; `f` takes (variables, states), in the order of the box. Half of the states are at ends."""
    draw = np.random.default_rng(seed)
    low, high = (np.array([getattr(x, end) for x in box.values()]) for end in ("low", "high"))
    share = draw.uniform(size=(len(box), samples))
    some = share[:, samples // 2 :]
    some[:] = np.where(draw.uniform(size=some.shape) < 0.5, some.round(), some)
    states = low[:, None] + (high - low)[:, None] * share
    values = np.abs(f(states))
    best = float(values.max())
    for k in np.argsort(-values)[:climbs]:
        found = minimize(lambda x: -abs(f(x[:, None])[0]), states[:, k], method="L-BFGS-B", bounds=[*zip(low, high)])
        best = max(best, -float(found.fun))
    return best


def box_of(**ranges: Sequence[float]) -> dict[str, Range]:
    """A box from pairs of ends, by name."""
    return {name: Range(*map(float, ends)) for name, ends in ranges.items()}
