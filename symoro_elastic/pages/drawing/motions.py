"""Motions over time as a page plays them: the reference, and what was simulated beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.moving_base import rotation_at
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.state import State
from symoro_elastic.pages.drawing.significant import round_significant

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
    motion = reference.motion(t)
    q = with_base(motion.q, motion)
    return Played(reference.prescribed.place, t, q, q, remark)


def simulated_motion(found: Simulation) -> Played:
    """Return a simulated motion, at no more times than are seen."""
    moved = found.motion
    kept = np.unique(np.round(np.linspace(0, len(moved.t) - 1, min(SAMPLES, len(moved.t)))).astype(int))
    seen = moved[kept]
    q, wanted = (with_base(x, seen) for x in (seen.q, found.reference.states(seen.t)[0]))
    return Played(found.reference.prescribed.place, seen.t, q, wanted)


def with_base(q: Array, state: State) -> Array:
    """Return q (N, n) behind six coordinates of a base that moves freely, which nothing prescribes.

    They are its position, and the angles of its orientation Rot(x) Rot(y) Rot(z).
    """
    if not state.base:
        return q
    R = rotation_at(state)
    about_x, about_z = np.arctan2(-R[:, 1, 2], R[:, 2, 2]), np.arctan2(-R[:, 0, 1], R[:, 0, 0])
    turned = np.stack([about_x, np.arcsin(np.clip(R[:, 0, 2], -1.0, 1.0)), about_z], axis=1)
    found: Array = np.concatenate([state.P0, np.unwrap(turned, axis=0), q], axis=1)
    return found


def motions_data(played: Sequence[Played]) -> list[dict[str, Any]]:
    """Return what a page plays: times, positions, and deviations from the reference."""
    return [
        {
            "title": one.title,
            "t": round_significant(one.t, 7),
            "reference": round_significant(one.reference, 8),
            "deviation": round_significant(one.q - one.reference, 8),
            "remark": one.remark,
        }
        for one in played
    ]
