"""Motions over time for a page: the reference, and the simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.moving_base import rotation_at
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.bound.state import State

SAMPLES = 301
DIGITS = 9


@dataclass(frozen=True)
class Played:
    """A motion of a page: q (N, n) at times t (N,) s, and `reference` (N, n) of motors, springs undeflected.

    `remark` says why nothing was simulated; q is then the reference.
    """

    title: str
    t: Array
    q: Array
    reference: Array
    remark: str = ""


def reference_motion(reference: Reference, remark: str) -> Played:
    """Return a motion without simulation, with the reason."""
    t = np.linspace(0.0, reference.duration, SAMPLES)
    motion = reference.motion(t)
    q = with_base(motion.q, motion)
    return Played(reference.prescribed.place, t, q, q, remark)


def simulated_motion(simulation: Simulation) -> Played:
    """Return a simulated motion, sampled at no more times than a page can show."""
    moved = simulation.motion
    indices = np.unique(np.round(np.linspace(0, len(moved.t) - 1, min(SAMPLES, len(moved.t)))).astype(int))
    samples = moved[indices]
    q, wanted = (with_base(x, samples) for x in (samples.q, simulation.reference.states(samples.t)[0]))
    return Played(simulation.reference.prescribed.place, samples.t, q, wanted)


def with_base(q: Array, state: State) -> Array:
    """Return q (N, n) preceded by six coordinates of a freely moving base, which nothing prescribes.

    They are its position, and the angles of its orientation Rot(x) Rot(y) Rot(z).
    """
    if not state.base:
        return q
    R = rotation_at(state)
    about_x, about_z = np.arctan2(-R[:, 1, 2], R[:, 2, 2]), np.arctan2(-R[:, 0, 1], R[:, 0, 0])
    turned = np.stack([about_x, np.arcsin(np.clip(R[:, 0, 2], -1.0, 1.0)), about_z], axis=1)
    return np.asarray(np.concatenate([state.P0, np.unwrap(turned, axis=0), q], axis=1))


def motions_data(played: Sequence[Played]) -> list[dict[str, Any]]:
    """Return the data of motions for a page: times, positions, and deviations from the reference."""
    return [
        {
            "title": motion.title,
            "t": round_significant(motion.t, 7),
            "reference": round_significant(motion.reference, 8),
            "deviation": round_significant(motion.q - motion.reference, 8),
            "remark": motion.remark,
        }
        for motion in played
    ]


def round_significant(x: Any, digits: int = DIGITS) -> Any:
    """Return a number, or an array as lists, with so many significant digits; integers as such."""
    if hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, list):
        return [round_significant(entry, digits) for entry in x]
    rounded = float(f"{x:.{digits}g}")
    return int(rounded) if rounded.is_integer() and abs(rounded) < 1e15 else rounded
