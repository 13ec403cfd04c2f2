"""Modes of a machine for a page: shapes in coordinates of q, and the distribution of their energy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.drawn_modes import BentPoints, DrawnMode, DrawnPoints, drawn_modes
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
from symoro_elastic.pages.drawing.figure import CORNERS, Figure
from symoro_elastic.pages.drawing.motions import round_significant
from symoro_elastic.pages.drawing.shapes import arrow, transform

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


def corners_of(figure: Figure) -> DrawnPoints:
    """Return the corners of all solids of a figure at its own placements, and those of beams at their stations."""
    corners = [(x.frame, x.placement, CORNERS * np.array(x.size)) for x in figure.solids]
    corners += [station for bar in figure.bars for station in bar.corners]
    T, skins = figure.reference, [skin.coarse for skin in figure.skins]
    parts = [(j, transform(T[j] @ at, x)) for j, at, x in corners] + [(skin.root, skin.points(T)) for skin in skins]
    frames = np.repeat([j for j, _ in parts], [len(x) for _, x in parts]).astype(int)
    points = np.concatenate([np.empty((0, 3)), *(x for _, x in parts)])
    ends = np.cumsum([len(x) for _, x in parts])[len(corners) :]
    bent = tuple(
        BentPoints(range(end - len(skin.surface.points), end), skin.root, skin.rows, T[skin.root][:3, :3], skin.surface)
        for end, skin in zip(ends.tolist(), skins, strict=True)
    )
    return DrawnPoints(points, frames, T[frames, :3, 3], figure.extent, bent)


def changes_of(modal: Modes, mode: DrawnMode) -> Array:
    """Return the change of q (n,) by a mode at full amplitude."""
    change = np.zeros(len(modal.linear.state.q))
    change[list(modal.linear.kept)] = modal.shapes[:, mode.k] * mode.factor
    return change


def arrows_of(mode: DrawnMode, drawn: DrawnPoints) -> list[Array]:
    """Return the lines (N, 3), m, of arrows where a mode moves most."""
    return [line for i in mode.arrows for line in arrow(drawn.points[i], mode.displacements[i])]


def modes_data(mode_set: ModeSet, figure: Figure) -> dict[str, Any]:
    """Return the data of a set of modes for a page: the lowest, their shapes (n,) in q at full amplitude."""
    if mode_set.modal is None:
        return {"title": mode_set.title, "refused": mode_set.refused, "modes": [], "count": 0}
    modal = mode_set.modal
    energies, corners, motions = (strain_shares(modal), kinetic_shares(modal)), corners_of(figure), frame_shapes(modal)
    drawn = drawn_modes(modal, range(min(len(modal.eigenvalues), MOST_MODES)), corners)
    return {
        "title": mode_set.title,
        "refused": "",
        "count": len(modal.eigenvalues),
        "modes": [
            _mode(modal, mode, motions[:, :, mode.k], *energies)
            | {"arrows": [round_significant(line, 6) for line in arrows_of(mode, corners)]}
            for mode in drawn
        ],
    }


def _mode(modal: Modes, mode: DrawnMode, motion: Array, strain: Shares, kinetic: Shares) -> dict[str, Any]:
    k, ratio = mode.k, float(modal.damping_ratios[mode.k])
    return {
        "hertz": round_significant(modal.frequencies[k]),
        "growth": round_significant(modal.growth[k]),
        "damping": None if math.isnan(ratio) else round_significant(ratio),
        "shape": round_significant(changes_of(modal, mode)),
        "most": _most(modal, mode.factor * motion),
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


def _largest(shares: Shares, k: int) -> list[list[Any]]:
    """Names and shares of energy, the largest first."""
    column = shares.shares[:, k]
    order = [int(row) for row in np.argsort(-column, kind="stable") if column[row] >= LEAST_SHARE]
    return [[shares.names[row], round_significant(column[row], 4)] for row in order]
