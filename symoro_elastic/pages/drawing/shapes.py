"""Parts of a figure: solids and wires that move with the frames of a machine, and frames by placements."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from symoro_elastic.foundation.array_types import Array

HEAD = 0.3
"""Of an arrow's length: that of its head, which is as wide."""


class Shape(StrEnum):
    """Shape of a solid: a box with edges along x, y, z, a cylinder about z, or a ball."""

    BOX = "box"
    CYLINDER = "cylinder"
    BALL = "ball"


@dataclass(frozen=True)
class Solid:
    """A box, a cylinder or a ball fixed to a frame: placement (4, 4) of its centre there, size along x, y, z, m.

    `role` is its meaning, which determines its colour; the faces of an `outlined` one are transparent.
    """

    frame: int
    role: str
    shape: Shape
    placement: Array
    size: tuple[float, float, float]
    outlined: bool = False


@dataclass(frozen=True)
class Wire:
    """A line through points (N, 3), m, of a frame: a spring, or an axis.

    Each point stays behind by its share (N,) of what the joint of the frame has moved since the figure was made: 0
    moves with the frame, 1 stays with the antecedent.
    """

    frame: int
    role: str
    points: Array
    behind: Array


def placement(x: Array, R: Array | None = None) -> Array:
    """Return the placement (4, 4) with origin x (3,) and axes R (3, 3), by default the unit matrix."""
    T = np.eye(4)
    T[:3, 3] = x
    if R is not None:
        T[:3, :3] = R
    return T


def arrow(start: Array, way: Array) -> list[Array]:
    """Return the lines (2 or 3, 3) of an arrow along a vector (3,) other than zero: its shaft and pairs of barbs."""
    tip, length, axes = start + way, float(np.linalg.norm(way)), axes_along(way)
    back = tip - HEAD * length * axes[:, 2]
    barbs = [[back + sense * HEAD / 2 * length * axes[:, k] for sense in (1, -1)] for k in (0, 1)]
    return [np.stack([start, tip]), *(np.stack([one, tip, other]) for one, other in barbs)]


def inverse(T: Array) -> Array:
    """Return the inverse of a placement (4, 4)."""
    R = T[:3, :3].T
    return placement(-R @ T[:3, 3], R)


def transform(T: Array, points: Array) -> Array:
    """Return points (N, 3) of a frame with the placement T (4, 4) in the frame that this refers to."""
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])


def axes_along(z: Array) -> Array:
    """Return a rotation (3, 3) whose z axis has the direction of a vector (3,) other than zero."""
    z = z / np.linalg.norm(z)
    aside = np.eye(3)[int(np.argmin(np.round(np.abs(z), 9)))]
    x = np.cross(aside, z)
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def slip(T: Array, reference: Array, slides: bool) -> float:
    """Return the displacement of a joint, m or rad, from the placements (4, 4) in its antecedent now and before."""
    moved = inverse(reference) @ T
    return float(moved[2, 3] if slides else np.arctan2(moved[1, 0], moved[0, 0]))


def bend(wire: Wire, moved: float, slides: bool) -> Array:
    """Return the points (N, 3) of a wire in its frame after a joint's displacement, m or rad."""
    by = -moved * wire.behind
    if slides:
        return np.asarray(wire.points + by[:, None] * np.array([0.0, 0.0, 1.0]))
    x, y, z = wire.points.T
    return np.stack([x * np.cos(by) - y * np.sin(by), x * np.sin(by) + y * np.cos(by), z], axis=1)
