"""Test states of a floating base, as moderate or extreme as those of the joints it carries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.mechanics.floating_base import rotation_of
from symoro_elastic.quantities import ON_BASE, VELOCITIES, Samples

STILL = ("at rest", "everything zero")
FAST = ("very fast and very slow", "everything extreme")
LOADED = ("large torques", "everything extreme")
ROTATIONS = ("R0", "Q0")


def base_states(titles: Sequence[str], rng: np.random.Generator) -> dict[str, Array]:
    """R0, Q0, P0, V0, V0d, f0 of each state, stacked: turned anyhow, within 10 m, velocities within 2,
    accelerations within 5 and wrenches within 20; of an extreme state as the title says.
    """
    drawn = [_drawn(title, rng) for title in titles]
    return {row.name: np.array([state[row.name] for state in drawn]).reshape(-1, len(row.entries)) for row in ON_BASE}


def _drawn(title: str, rng: np.random.Generator) -> dict[str, Array]:
    quaternion = np.array([1.0, 0.0, 0.0, 0.0]) if title == "everything zero" else rng.normal(size=4)
    quaternion = quaternion / np.linalg.norm(quaternion)
    rotations = dict(zip(ROTATIONS, (np.array(rotation_of(quaternion.tolist())).ravel(), quaternion), strict=True))
    sampled = ((row, row.samples) for row in ON_BASE if row.samples)
    return rotations | {row.name: _entries(rng, len(row.entries), samples, title) for row, samples in sampled}


def _entries(rng: np.random.Generator, count: int, samples: Samples, title: str) -> Array:
    """Moderate numbers, extreme ones where the title says so, or zeros."""
    if title in STILL:
        return np.zeros(count)
    if samples.decades is None or title not in (FAST if samples is VELOCITIES else LOADED):
        return rng.uniform(-samples.size, samples.size, count)
    found: Array = 10 ** rng.uniform(*samples.decades, count) * rng.choice([-1.0, 1.0], count)
    return found
