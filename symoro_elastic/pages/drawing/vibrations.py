"""Modes of a machine for a page: shapes in coordinates of q, and the distribution of their energy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.linearization import Linearization, with_motors
from symoro_elastic.analysis.vibration.modes import (
    Modes,
    Shares,
    frame_shapes,
    kinetic_shares,
    modes,
    refuse_rigid,
    strain_shares,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.pages.drawing.motions import round_significant

SEEN, LEVER = 0.04, 0.35
"""Of the extent: how far the farthest frame moves at full amplitude, and the lever on which a rotation counts."""
MOST_MODES = 60
LEAST_SHARE = 0.005
HELD, FREE = "motors held", "motors free"


@dataclass(frozen=True)
class ModeSet:
    """The modes of a machine with motors held, or free; `refused` is the reason if there are none."""

    title: str
    modal: Modes | None
    refused: str = ""


def mode_sets(linear: Linearization) -> list[ModeSet]:
    """Return the modes about a position with all motors held, and with free motors if there are any."""
    motors = [linear.motion.names[k] for k in linear.motion.motors]
    if not motors:
        return [_set("modes", linear, ())]
    return [_set(HELD, linear, motors), _set(FREE, linear, ())]


def _set(title: str, linear: Linearization, locked: Sequence[str]) -> ModeSet:
    try:
        linear_of_free = with_motors(linear, locked) if locked else linear
        refuse_rigid(linear_of_free)
        return ModeSet(title, modes(linear_of_free))
    except InputError as error:
        return ModeSet(title, None, error.what)


def modes_data(mode_set: ModeSet, extent: float) -> dict[str, Any]:
    """Return the data of a set of modes for a page: the lowest, their shapes (n,) in q at full amplitude."""
    if mode_set.modal is None:
        return {"title": mode_set.title, "refused": mode_set.refused, "modes": [], "count": 0}
    modal = mode_set.modal
    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    displacements = frame_shapes(modal)
    indices = range(min(len(modal.eigenvalues), MOST_MODES))
    return {
        "title": mode_set.title,
        "refused": "",
        "count": len(modal.eigenvalues),
        "modes": [_mode(modal, k, displacements[:, :, k], extent, strain, kinetic) for k in indices],
    }


def full_shapes(modal: Modes, some: Sequence[int], extent: float) -> Array:
    """Return the changes of q (modes, n) by some modes at full amplitude, for a machine of an extent, m."""
    displacements, shapes = frame_shapes(modal), np.zeros((len(some), len(modal.linear.state.q)))
    for shape, k in zip(shapes, some, strict=True):
        shape[list(modal.linear.kept)] = modal.shapes[:, k] * _amplitude(displacements[:, :, k], extent)
    return shapes


def _mode(modal: Modes, k: int, frames: Array, extent: float, strain: Shares, kinetic: Shares) -> dict[str, Any]:
    shape, amplitude = np.zeros(len(modal.linear.state.q)), _amplitude(frames, extent)
    shape[list(modal.linear.kept)] = modal.shapes[:, k] * amplitude
    ratio = float(modal.damping_ratios[k])
    return {
        "hertz": round_significant(modal.frequencies[k]),
        "growth": round_significant(modal.growth[k]),
        "damping": None if math.isnan(ratio) else round_significant(ratio),
        "shape": round_significant(shape),
        "most": _most(modal, frames * amplitude),
        "strain": _largest(strain, k),
        "kinetic": _largest(kinetic, k),
    }


def _most(modal: Modes, displacements: Array) -> dict[str, Any]:
    """The frame that moves most at full amplitude, and its displacement, m; else the largest rotation, rad."""
    names = [joint.name for joint in modal.linear.motion.machine.joints]
    for unit, columns in (("m", displacements[:, :3]), ("rad", displacements[:, 3:])):
        far = np.linalg.norm(columns, axis=1)
        if far.max(initial=0.0) > 0:
            return {"frame": names[int(np.argmax(far))], "far": round_significant(far.max()), "unit": unit}
    return {"frame": "", "far": 0.0, "unit": "m"}


def _amplitude(displacements: Any, extent: float) -> float:
    """Return the factor that makes a mode visible: displacements (frames, 6) become a fraction of the extent."""
    translation, rotation = (float(np.abs(x).max(initial=0.0)) for x in (displacements[:, :3], displacements[:, 3:]))
    far = max(translation, LEVER * extent * rotation)
    return SEEN * extent / far if far > 0 else 0.0


def _largest(shares: Shares, k: int) -> list[list[Any]]:
    """Names and shares of energy, the largest first."""
    column = shares.shares[:, k]
    order = [int(row) for row in np.argsort(-column, kind="stable") if column[row] >= LEAST_SHARE]
    return [[shares.names[row], round_significant(column[row], 4)] for row in order]
