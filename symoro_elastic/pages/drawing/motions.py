"""Motions over time as a page plays them: the reference, and what was simulated beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.drawing.significant import rounded
from symoro_elastic.simulation.moving_base import BaseStates, rotation_at, rows
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
    q = with_base(reference.states(t)[0], rows(reference.base, len(t)))
    return Played(reference.prescribed.place, t, q, q, remark)


def simulated_motion(found: Simulation) -> Played:
    """Return a simulated motion, at no more times than are seen."""
    moved = found.motion
    kept = np.unique(np.round(np.linspace(0, len(moved.t) - 1, min(SAMPLES, len(moved.t)))).astype(int))
    t, base = moved.t[kept], {name: x[kept] for name, x in moved.base.items()}
    q, wanted = (with_base(x, base) for x in (moved.q[kept], found.reference.states(t)[0]))
    return Played(found.reference.prescribed.place, t, q, wanted)


def with_base(q: Array, base: BaseStates) -> Array:
    """Return q (N, n) behind the six coordinates of a floating base, which nothing prescribes.

    They are its position, and the angles of its orientation Rot(x) Rot(y) Rot(z).
    """
    if not base:
        return q
    R = rotation_at(base)
    about_x, about_z = np.arctan2(-R[:, 1, 2], R[:, 2, 2]), np.arctan2(-R[:, 0, 1], R[:, 0, 0])
    turned = np.stack([about_x, np.arcsin(np.clip(R[:, 0, 2], -1.0, 1.0)), about_z], axis=1)
    found: Array = np.concatenate([base["P0"], np.unwrap(turned, axis=0), q], axis=1)
    return found


def motions_data(played: Sequence[Played]) -> list[dict[str, Any]]:
    """Return what a page plays: times, positions, and deviations from the reference."""
    return [
        {
            "title": one.title,
            "t": rounded(one.t, 7),
            "reference": rounded(one.reference, 8),
            "deviation": rounded(one.q - one.reference, 8),
            "remark": one.remark,
        }
        for one in played
    ]
