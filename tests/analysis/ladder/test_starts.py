"""Starts fill their box evenly, and are the same for a seed."""

from __future__ import annotations

import numpy as np

from symoro_elastic.analysis.ladder.rungs import COUNT, starts

BOX = {"motor_x": (-0.2, 0.3), "motor_y": (0.1, 0.1), "turn": (1.0, 3.0)}


def test_each_part_of_each_range_holds_one_start() -> None:
    found = starts(BOX)
    assert len(found) == COUNT and all(list(start) == list(BOX) for start in found)
    for name, (low, high) in BOX.items():
        x = np.array([start[name] for start in found])
        if high > low:
            assert sorted(np.floor((x - low) / (high - low) * COUNT).astype(int)) == list(range(COUNT))
        else:
            assert (x == low).all()


def test_seeds() -> None:
    assert starts(BOX, 5, seed=3) == starts(BOX, 5, seed=3) != starts(BOX, 5, seed=4)
