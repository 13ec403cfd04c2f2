"""Shapes of joints: cylinders that turn, carriages on rails, springs, rods between frames.

Lengths are multiples of a unit that follows the extent of the machine.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Joint, Kind
from symoro_elastic.pages.drawing.shapes import Shape, Solid, Wire, axes_along, inverse, placement

ROD, LINK, RAIL, BASE, AXES = 0.34, "link", "rail", "base", ("x", "y", "z")
COIL, TURNS, COIL_POINTS = 3.6, 5, 91
SPIRAL, SPIRAL_TURNS, SPIRAL_POINTS = 2.0, 2.5, 61
REACH = 7.0
"""Of a carriage on its rail to each side, and of a slider of the page."""
SAME = 1e-6
"""Of the unit: a distance that is none."""


def joint_shapes(j: int, joint: Joint, T: Array, unit: float) -> Iterator[Solid | Wire]:
    """Return the shapes of joint j and of the rod to it; T (1 + rows, 4, 4) are the placements of all frames."""
    own, before = T[j], T[joint.antecedent]
    yield from _axes(j, unit)
    if joint.sigma == 1:
        yield from _sliding(j, joint, inverse(before) @ own, unit)
        return
    yield from _rod(joint.antecedent, np.zeros(3), (inverse(before) @ own)[:3, 3], unit)
    if joint.kind is Kind.ELASTIC:
        yield _cylinder(j, joint.kind, 0.7 * unit, 2.0 * unit)
        yield _spiral(j, unit)
    elif joint.sigma == 0:
        yield _cylinder(j, joint.kind, 1.7 * unit, 2.2 * unit)
    else:
        yield Solid(j, joint.kind, Shape.BOX, np.eye(4), (0.8 * unit,) * 3)


def base_shapes(up: Array, unit: float) -> Iterator[Solid | Wire]:
    """Return the plate of the base, below the origin of frame 0, and the axes of frame 0."""
    yield Solid(0, BASE, Shape.BOX, placement(-1.6 * unit * up, axes_along(up)), (6 * unit, 6 * unit, 0.6 * unit))
    yield from _axes(0, unit)


def _axes(j: int, unit: float) -> Iterator[Wire]:
    for k, axis in enumerate(AXES):
        yield Wire(j, axis, np.stack([np.zeros(3), 2.4 * unit * np.eye(3)[k]]), np.zeros(2))


def _sliding(j: int, joint: Joint, frame: Array, unit: float) -> Iterator[Solid | Wire]:
    """A carriage on its rail, or a coil between two discs; `frame` is the frame in its antecedent."""
    along, at, a = frame[:3, 2], frame[:3, 3], joint.antecedent
    if joint.kind is Kind.ELASTIC:
        foot = at - COIL * unit * along
        yield from _rod(a, np.zeros(3), foot, unit)
        yield replace(_disc(a, unit), placement=placement(foot, axes_along(along)))
        yield _disc(j, unit)
        yield _coil(j, unit)
        return
    foot = at - along * float(at @ along)
    ends = sorted((0.0, float(at @ along)))
    low, high = ends[0] - REACH * unit, ends[1] + REACH * unit
    yield from _rod(a, np.zeros(3), foot, unit)
    rail = placement(foot + along * (low + high) / 2, frame[:3, :3])
    yield Solid(a, RAIL, Shape.BOX, rail, (0.5 * unit, 0.5 * unit, high - low))
    yield Solid(j, joint.kind, Shape.BOX, np.eye(4), (1.7 * unit, 1.7 * unit, 2.4 * unit))


def _cylinder(j: int, role: str, diameter: float, length: float) -> Solid:
    return Solid(j, role, Shape.CYLINDER, np.eye(4), (diameter, diameter, length))


def _disc(j: int, unit: float) -> Solid:
    """The end of a coil."""
    return _cylinder(j, Kind.FIXED, 1.7 * unit, 0.2 * unit)


def _rod(frame: int, begin: Array, end: Array, unit: float) -> Iterator[Solid]:
    """A rod between two distinct points of a frame."""
    way = end - begin
    length = float(np.linalg.norm(way))
    if length > SAME * unit:
        size = (ROD * unit, ROD * unit, length)
        yield Solid(frame, LINK, Shape.CYLINDER, placement((begin + end) / 2, axes_along(way)), size)


def _coil(j: int, unit: float) -> Wire:
    """A helix along z that ends at the frame and begins at the antecedent."""
    t = np.linspace(0.0, 1.0, COIL_POINTS)
    angle = 2 * np.pi * TURNS * t
    radius = 0.8 * unit
    return Wire(
        j,
        Kind.ELASTIC,
        np.stack([radius * np.cos(angle), radius * np.sin(angle), COIL * unit * (t - 1)], axis=1),
        1 - t,
    )


def _spiral(j: int, unit: float) -> Wire:
    """A spiral about z, its inner end at the joint, its outer end at the antecedent."""
    t = np.linspace(0.0, 1.0, SPIRAL_POINTS)
    angle, radius = 2 * np.pi * SPIRAL_TURNS * t, (0.35 + (SPIRAL - 0.35) * t) * unit
    return Wire(j, Kind.ELASTIC, np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * t], axis=1), t)
