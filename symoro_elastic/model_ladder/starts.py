"""Positions at which a motion may start: a sample of a box."""

from __future__ import annotations

from collections.abc import Mapping

from symoro_elastic.packages import for_vibrations

COUNT, SEED = 20, 0


def starts(box: Mapping[str, tuple[float, float]], count: int = COUNT, seed: int = SEED) -> list[dict[str, float]]:
    """Return positions by joint in a box of ranges by joint, rad or m: a Latin hypercube, the same for a seed.

    Each range is divided into `count` parts, and each part holds one position.
    """
    qmc = for_vibrations("scipy.stats.qmc")
    shares = qmc.LatinHypercube(len(box), seed=seed).random(count)
    return [
        {name: low + share * (high - low) for (name, (low, high)), share in zip(box.items(), row, strict=True)}
        for row in shares.tolist()
    ]
