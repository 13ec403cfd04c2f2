"""Modes of a machine as a page moves them: shapes in coordinates of q, and where their energy is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.energies import Shares, frame_shapes, kinetic_shares, strain_shares
from symoro_elastic.analysis.vibration.linearization import Linearization, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, modes, refuse_rigid
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.pages.drawing.significant import round_significant

SEEN, LEVER = 0.04, 0.35
"""Of the extent: how far the farthest frame moves at full amplitude, and the lever on which a rotation counts."""
MOST_MODES = 60
LEAST_SHARE = 0.005
HELD, FREE = "motors held", "motors free"


@dataclass(frozen=True)
class ModeSet:
    """The modes of a machine with its motors held, or free; `refused` says why there are none."""

    title: str
    modal: Modes | None
    refused: str = ""


def mode_sets(linear: Linearization) -> list[ModeSet]:
    """Return the modes about a position with all motors held, and with motors free where there are motors."""
    motors = [linear.motion.names[k] for k in linear.motion.motors]
    if not motors:
        return [_set("modes", linear, ())]
    return [_set(HELD, linear, motors), _set(FREE, linear, ())]


def _set(title: str, linear: Linearization, held: Sequence[str]) -> ModeSet:
    try:
        kept = with_motors(linear, held) if held else linear
        refuse_rigid(kept)
        return ModeSet(title, modes(kept))
    except InputError as error:
        return ModeSet(title, None, error.what)


def modes_data(one: ModeSet, extent: float) -> dict[str, Any]:
    """Return what a page shows of a set of modes: the lowest of them, their shapes (n,) in q at full amplitude."""
    if one.modal is None:
        return {"title": one.title, "refused": one.refused, "modes": [], "count": 0}
    modal = one.modal
    strain, kinetic = strain_shares(modal), kinetic_shares(modal)
    seen = frame_shapes(modal)
    shown = range(min(len(modal.eigenvalues), MOST_MODES))
    return {
        "title": one.title,
        "refused": "",
        "count": len(modal.eigenvalues),
        "modes": [_mode(modal, k, seen[:, :, k], _amplitude(seen[:, :, k], extent), strain, kinetic) for k in shown],
    }


def full_shapes(modal: Modes, some: Sequence[int], extent: float) -> Array:
    """Return the changes of q (modes, n) by some modes at full amplitude, for a machine of an extent, m."""
    seen, shapes = frame_shapes(modal), np.zeros((len(some), len(modal.linear.state.q)))
    for shape, k in zip(shapes, some, strict=True):
        shape[list(modal.linear.kept)] = modal.shapes[:, k] * _amplitude(seen[:, :, k], extent)
    return shapes


def _mode(modal: Modes, k: int, seen: Array, amplitude: float, strain: Shares, kinetic: Shares) -> dict[str, Any]:
    shape = np.zeros(len(modal.linear.state.q))
    shape[list(modal.linear.kept)] = modal.shapes[:, k] * amplitude
    ratio = float(modal.damping_ratios[k])
    return {
        "hertz": round_significant(modal.frequencies[k]),
        "growth": round_significant(modal.growth[k]),
        "damping": None if math.isnan(ratio) else round_significant(ratio),
        "shape": round_significant(shape),
        "most": _most(modal, seen * amplitude),
        "strain": _largest(strain, k),
        "kinetic": _largest(kinetic, k),
    }


def _most(modal: Modes, seen: Array) -> dict[str, Any]:
    """The frame that moves most at full amplitude, and how far, m; where none moves, the one that turns most, rad."""
    names = [joint.name for joint in modal.linear.motion.machine.joints]
    for unit, columns in (("m", seen[:, :3]), ("rad", seen[:, 3:])):
        far = np.linalg.norm(columns, axis=1)
        if far.max(initial=0.0) > 0:
            return {"frame": names[int(np.argmax(far))], "far": round_significant(far.max()), "unit": unit}
    return {"frame": "", "far": 0.0, "unit": "m"}


def _amplitude(seen: Any, extent: float) -> float:
    """Return the factor that makes a mode visible: displacements (frames, 6) of a unit become a share of the extent."""
    far = max(float(np.abs(seen[:, :3]).max(initial=0.0)), LEVER * extent * float(np.abs(seen[:, 3:]).max(initial=0.0)))
    return SEEN * extent / far if far > 0 else 0.0


def _largest(shares: Shares, k: int) -> list[list[Any]]:
    """Names and shares of energy, the largest first."""
    column = shares.shares[:, k]
    order = [int(row) for row in np.argsort(-column, kind="stable") if column[row] >= LEAST_SHARE]
    return [[shares.names[row], round_significant(column[row], 4)] for row in order]
