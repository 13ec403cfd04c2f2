"""Bodies by modes of a figure: the surface of their mesh, which moves with the modes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.flexible import Surface
from symoro_elastic.machine.machine import Machine
from symoro_elastic.pages.drawing.bars import BEAM
from symoro_elastic.pages.drawing.shapes import transform

MOST_IN_PICTURE = 400
"""Triangles of a surface on paper."""


@dataclass(frozen=True)
class Skin:
    """The surface of a body in the frame `root`, with the frames of its modes, and their names.

    The frame of a mode slides by its deflection along z of the body, so that placements hold deflections, too.
    """

    root: int
    rows: tuple[int, ...]
    springs: tuple[str, ...]
    surface: Surface
    role: str = BEAM

    def points(self, T: Array) -> Array:
        """Return the points (N, 3) of the surface with frames at placements T (1 + rows, 4, 4)."""
        body = T[self.root]
        e = (T[list(self.rows), :3, 3] - body[:3, 3]) @ body[:3, 2]
        return transform(body, self.surface.at(e))

    @property
    def coarse(self) -> Skin:
        """The skin with few enough triangles for a picture on paper."""
        return replace(self, surface=self.surface.coarse(MOST_IN_PICTURE))


def skins_of(machine: Machine) -> Iterator[Skin]:
    """Yield the bodies by modes whose files have surfaces."""
    for root, (body, rows) in machine.flexible_bodies.items():
        if body.surface is not None:
            yield Skin(root, rows, body.modes, body.surface)
