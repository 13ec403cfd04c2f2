"""Motions over time as a page plays them: the reference, and what was simulated beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.drawing.significant import rounded
from symoro_elastic.simulation.reference import Reference
from symoro_elastic.simulation.simulated import Simulation

SAMPLES = 301


@dataclass(frozen=True)
class Played:
    """A motion to be played: q (N, n) at times t (N,) s, and `reference` (N, n) where motors follow and springs stay.

    `remark` says why nothing was simulated; q is then the reference.
    """

    title: str
    t: Array
    q: Array
    reference: Array
    remark: str = ""


def reference_motion(reference: Reference, remark: str) -> Played:
    """Return a motion that was not simulated, and why."""
    t = np.linspace(0.0, reference.duration, SAMPLES)
    q = reference.states(t)[0]
    return Played(reference.prescribed.place, t, q, q, remark)


def simulated_motion(found: Simulation) -> Played:
    """Return a simulated motion, at no more times than are seen."""
    moved = found.motion
    kept = np.unique(np.round(np.linspace(0, len(moved.t) - 1, min(SAMPLES, len(moved.t)))).astype(int))
    t = moved.t[kept]
    return Played(found.reference.prescribed.place, t, moved.q[kept], found.reference.states(t)[0])


def motions_data(played: Sequence[Played]) -> list[dict[str, Any]]:
    """Return what a page plays: times, positions, and deviations from the reference."""
    return [
        {
            "title": one.title,
            "t": rounded(one.t, 7),
            "reference": rounded(one.reference, 8),
            "deviation": rounded(one.q - one.reference, 6),
            "remark": one.remark,
        }
        for one in played
    ]
