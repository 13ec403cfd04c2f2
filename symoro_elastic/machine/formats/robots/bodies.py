"""Links that move together as one body."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.formats.robots.description import Link, Placement
from symoro_elastic.machine.formats.robots.rows import ROUNDING, length_cell
from symoro_elastic.machine.machine import Body

ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


def body_of(links: Iterable[tuple[Link, Placement]], length: float, products: float = 0.0) -> Body:
    """The body that links with these placements make, about its centre of mass in the frame of the placements.

    Coordinates of the centre below `length`, m, and products of inertia below `products` of the trace are zero.
    """
    placed = [
        (link.mass, place.rotation @ link.center + place.translation, _turned(link, place)) for link, place in links
    ]
    mass = float(sum(m for m, _, _ in placed))
    center = sum((m * c for m, c, _ in placed), np.zeros(3)) / mass if mass else np.zeros(3)
    inertia = sum((tensor + m * _point_mass(c - center) for m, c, tensor in placed), np.zeros((3, 3)))
    trace = float(np.trace(inertia))
    least = [max(products, ROUNDING) * trace, ROUNDING * trace]
    if not mass and not np.any(inertia):
        return Body()
    x, y, z = (length_cell(float(entry), length) for entry in center)
    xx, xy, xz, yy, yz, zz = (length_cell(float(inertia[i, k]), least[i == k]) for i, k in ENTRIES)
    return Body(length_cell(mass, 0.0), (x, y, z), (xx, xy, xz, yy, yz, zz), central=True)


def _turned(link: Link, place: Placement) -> Array:
    """The inertia of a link about its centre of mass, in axes of the frame in which it is placed."""
    turned: Array = place.rotation @ link.inertia @ place.rotation.T
    return turned


def _point_mass(c: Array) -> Array:
    """Inertia about the origin of a unit mass at c."""
    tensor: Array = (c @ c) * np.eye(3) - np.outer(c, c)
    return tensor
