"""Test trajectories of feed-forward: all their derivatives are as moderate or extreme as their state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.numerics.base_states import LOADED, STILL
from symoro_elastic.quantities import MOTION


def reference_motions(q: Array, qd: Array, qdd: Array, titles: Sequence[str], rng: np.random.Generator) -> Array:
    """Return y and its derivatives, (N, 13, m), from q, qd, qdd of motors (N, m).

    Each further derivative is up to w times the one before, w from 1 to 100 1/s; with large loads all are to 1e8.
    """
    motions = np.zeros((len(titles), len(MOTION), q.shape[1]))
    motions[:, 0], motions[:, 1], motions[:, 2] = q, qd, qdd
    for state, title in enumerate(titles):
        further = motions[state, 3:]
        if title in LOADED:
            further[:] = 10 ** rng.uniform(2, 8, further.shape) * rng.choice([-1.0, 1.0], further.shape)
        elif title not in STILL:
            rate = 10 ** rng.uniform(0, 2)
            further[:] = rng.uniform(-5, 5, further.shape) * rate ** np.arange(1, len(further) + 1)[:, None]
    return motions
