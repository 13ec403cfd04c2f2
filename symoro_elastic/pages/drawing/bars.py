"""Beams of a figure: bars with their section along a smooth curve through the frames of their pieces.

The curve is cubic from station to station, root, middle of every rigid piece, and end, and tangent to them there.
A beam by modes has its root and its end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.beams.sections import TORSION
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bound.viewing import number_or_nan
from symoro_elastic.pages.drawing.shapes import inverse, placement

BEAM = "beam"
CORNERS_OF_ROUND = 20
RINGS = 24
"""Rings of corners along a bar, at least."""
SLENDER = 20
"""Length by diameter of a beam without section and inertia."""


@dataclass(frozen=True)
class Bar:
    """A beam from the row `root` to `end`: at its stations it is fixed to `frames` (S,).

    `stations` (S, 4, 4) are placements there, x along the beam, `outline` (N, 2) is its section in y and z, m: four
    corners, or those of a circle. `springs` are the names of its elastic rows.
    """

    root: int
    end: int
    frames: tuple[int, ...]
    stations: Array
    outline: Array
    springs: tuple[str, ...]
    role: str = BEAM

    @property
    def steps(self) -> int:
        """Rings from one station to the next."""
        return math.ceil(RINGS / (len(self.frames) - 1))

    @property
    def is_round(self) -> bool:
        """Whether the section is a circle."""
        return len(self.outline) > 4

    @property
    def corners(self) -> list[tuple[int, Array, Array]]:
        """The frames of its stations, their placements there, and corners of the section in these (4, 3), m."""
        flat = np.pad(self.outline[:: len(self.outline) // 4], ((0, 0), (1, 0)))
        return [(frame, at, flat) for frame, at in zip(self.frames, self.stations, strict=True)]

    def rings(self, T: Array) -> Array:
        """Return the outlines along the bar (R, N, 3) with frames at placements T (1 + rows, 4, 4)."""
        at = T[list(self.frames)] @ self.stations
        t = np.arange(self.steps + 1)[:, None] / self.steps
        parts = [_between(a, b, t[k > 0 :]) for k, (a, b) in enumerate(pairwise(at))]
        points, y, z = (np.concatenate(column)[:, None] for column in zip(*parts, strict=True))
        return np.asarray(points + self.outline[:, :1] * y + self.outline[:, 1:] * z)


def _between(a: Array, b: Array, t: Array) -> tuple[Array, Array, Array]:
    """Points of a cubic curve from placement a to b (4, 4) at t (K, 1), and directions of y and z there."""
    start, way = a[:3, 3], b[:3, 3] - a[:3, 3]
    far = np.linalg.norm(way)
    out, into = far * a[:3, 0], far * b[:3, 0]
    points = start + t * (out + t * (3 * way - 2 * out - into + t * (out + into - 2 * way)))
    x = out + t * (2 * (3 * way - 2 * out - into) + 3 * t * (out + into - 2 * way))
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    y = a[:3, 1] + t * (b[:3, 1] - a[:3, 1])
    y = y - np.sum(x * y, axis=1, keepdims=True) * x
    y = y / np.linalg.norm(y, axis=1, keepdims=True)
    return points, y, np.cross(x, y)


def bars_of(machine: Machine, straight: Callable[[], Array], values: Mapping[str, float]) -> list[Bar]:
    """Return the beams of a machine as bars, by the placements (1 + rows, 4, 4) where they are straight.

    None where these raise `InputError`: loops do not close there.
    """
    beams = DescribedMachine.of(machine).origin.beams
    ends = ((beam, machine.rows.get(f"{beam.name}_root"), machine.rows.get(f"{beam.name}_end")) for beam in beams)
    rows = [(beam, root, end) for beam, root, end in ends if root and end and root < end]
    try:
        T = straight() if rows else np.empty(0)
    except InputError:
        return []
    return [bar for row in rows if (bar := _bar(machine, *row, T, values))]


def _bar(machine: Machine, beam: Beam, root: int, end: int, T: Array, values: Mapping[str, float]) -> Bar | None:
    """The bar of a beam between two rows; None where it has no length."""
    chain = [end]
    while chain[0] > root:
        chain.insert(0, machine.joint(chain[0]).antecedent)
    far = float(np.linalg.norm(T[end, :3, 3] - T[root, :3, 3]))
    if chain[0] != root or not far > 0:
        return None
    along = [inverse(T[j]) @ T[root] for j in chain]
    frames, stations = [root], [np.eye(4)]
    is_by_modes = any(machine.joint(j).kind is Kind.COUPLED for j in chain)
    for j, axes, after in zip(chain, along, [] if is_by_modes else chain[1:], strict=False):
        piece = (inverse(T[j]) @ T[after])[:3, 3]
        if np.linalg.norm(piece) > 1e-6 * far:
            frames, stations = [*frames, j], [*stations, placement(piece / 2, axes[:3, :3])]
    stations.append(placement(np.zeros(3), along[-1][:3, :3]))
    springs = (joint.name for joint in machine.joints[root - 1 : end] if joint.kind is Kind.ELASTIC)
    return Bar(root, end, (*frames, end), np.array(stations), _outline(beam, far, values), tuple(springs))


def _outline(beam: Beam, length: float, values: Mapping[str, float]) -> Array:
    """Corners (N, 2) of the section; a rod of equal inertia about the axis without one, or a slender one."""
    kind, texts = beam.section
    sizes = [number_or_nan(Formula.parse(text), values) for text in texts]
    if kind in ("bar", "box") and sizes[0] > 0 and sizes[1] > 0:
        y, z = sizes[:2] if beam.along[-1] != "y" else sizes[1::-1]
        return np.array([[-y, -z], [y, -z], [y, z], [-y, z]]) / 2
    if not sizes:
        inertia, mass = (number_or_nan(Formula.parse(text), values) for text in (beam.inertia[TORSION], beam.mass))
        sizes = [min(math.sqrt(8 * inertia / mass), length) if inertia > 0 and mass > 0 else math.nan]
    radius = (sizes[0] if sizes[0] > 0 else length / SLENDER) / 2
    angles = 2 * np.pi * np.arange(CORNERS_OF_ROUND) / CORNERS_OF_ROUND
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
