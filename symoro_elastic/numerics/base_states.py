"""Test states of a floating base, as moderate or extreme as those of the joints it carries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.equations.floating_base import rotation_of

STILL = ("at rest", "everything zero")
FAST = ("very fast and very slow", "everything extreme")
LOADED = ("large torques", "everything extreme")
WIDTHS = {"R0": 9, "Q0": 4, "P0": 3, "V0": 6, "V0d": 6, "f0": 6}


def base_states(titles: Sequence[str], rng: np.random.Generator) -> dict[str, Array]:
    """R0, Q0, P0, V0, V0d, f0 of each state, stacked: turned anyhow, within 10 m, velocities within 2,
    accelerations within 5 and wrenches within 20; of an extreme state as the title says.
    """
    drawn = [_drawn(title, rng) for title in titles]
    return {name: np.array([state[name] for state in drawn]).reshape(-1, width) for name, width in WIDTHS.items()}


def _drawn(title: str, rng: np.random.Generator) -> dict[str, Array]:
    quaternion = np.array([1.0, 0.0, 0.0, 0.0]) if title == "everything zero" else rng.normal(size=4)
    quaternion = quaternion / np.linalg.norm(quaternion)
    resting = title in STILL
    return {
        "R0": np.array(rotation_of(quaternion.tolist())).ravel(),
        "Q0": quaternion,
        "P0": _entries(rng, 3, 10.0, resting),
        "V0": _entries(rng, 6, 2.0, resting, (-6, 6) if title in FAST else None),
        "V0d": _entries(rng, 6, 5.0, resting, (2, 8) if title in LOADED else None),
        "f0": _entries(rng, 6, 20.0, resting, (2, 8) if title in LOADED else None),
    }


def _entries(
    rng: np.random.Generator, count: int, size: float, zero: bool, decades: tuple[float, float] | None = None
) -> Array:
    """Numbers within `size`, of a size from 10^low to 10^high, or zeros."""
    if zero:
        return np.zeros(count)
    if decades is None:
        return rng.uniform(-size, size, count)
    found: Array = 10 ** rng.uniform(*decades, count) * rng.choice([-1.0, 1.0], count)
    return found
