"""A figure projected on paper: areas and lines in the order in which they are drawn, from far to near."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.bound.viewing import view_axes
from symoro_elastic.pages.drawing.bars import BEAM, Bar
from symoro_elastic.pages.drawing.figure import BODY, CORNERS, Figure
from symoro_elastic.pages.drawing.joint_shapes import AXES
from symoro_elastic.pages.drawing.shapes import Shape, Solid, Wire, bend, inverse, slip, transform
from symoro_elastic.pages.drawing.skins import Skin

ROUND = 24
CIRCLE = np.array([[np.cos(2 * np.pi * k / ROUND), np.sin(2 * np.pi * k / ROUND), 0.0] for k in range(ROUND)])
"""Corners of a circle, of radius 1."""
LIGHT_FROM = np.array([-0.35, 0.75, 0.55])
"""Where the light comes from: from the left, from above and from the eye."""
LIT, DARK = 0.62, 0.15
OUTLINE = 3
"""The shade of a transparent area."""
GHOST, ARROW = "ghost", "arrow"
LAYERS = {"base": 0, BODY: 1, BEAM: 1}
"""What is drawn first, so that joints are seen through bodies."""
FACES = (
    *(((0, 1, 3, 2), 0, -1), ((4, 6, 7, 5), 0, 1), ((0, 4, 5, 1), 1, -1), ((2, 3, 7, 6), 1, 1)),
    *(((0, 2, 6, 4), 2, -1), ((1, 5, 7, 3), 2, 1)),
)
"""Corners of the faces of a box, and the axis and sense of its normal."""


@dataclass(frozen=True)
class View:
    """The direction of view: rows are the directions to the right, up, and to the eye, in frame 0."""

    axes: Array

    def of(self, points: Array) -> Array:
        """Return points (N, 3) as x to the right, y down, and nearness to the eye, m."""
        return np.asarray(points @ self.axes.T * np.array([1.0, -1.0, 1.0]))


@dataclass(frozen=True)
class Drawn:
    """A closed area, or an open line: points (N, 2) m, y down; `shade` of an area: 0 light to 2 dark, or OUTLINE."""

    role: str
    points: Array
    closed: bool
    shade: int = 1
    layer: int = 2
    near: float = 0.0


@dataclass(frozen=True)
class Projection:
    """A figure seen from one side, with its frames at placements (1 + rows, 4, 4)."""

    figure: Figure
    T: Array
    view: View

    @cached_property
    def back_to_front(self) -> list[Drawn]:
        """Areas and lines, the farthest first."""
        parts = [part for shape in self.figure.shapes for part in self._project(shape)]
        return sorted(parts, key=lambda part: (part.layer, round(part.near, 9)))

    @property
    def ghost(self) -> list[Drawn]:
        """Outlines of the solids but the base."""
        solids = (part for part in self.back_to_front if part.closed and part.role != "base")
        return [replace(part, role=GHOST, shade=OUTLINE) for part in solids]

    def arrow(self, line: Array) -> Drawn:
        """Return a line of an arrow, (N, 3) m in frame 0."""
        return Drawn(ARROW, self.view.of(line)[:, :2], False)

    def anchors(self) -> Array:
        """Return the origins of named frames on paper, (N, 2) m."""
        return self.view.of(self.T[[mark.frame for mark in self.figure.marks], :3, 3])[:, :2]

    def _project(self, shape: Solid | Wire | Bar | Skin) -> Iterator[Drawn]:
        if isinstance(shape, Wire):
            yield self._line(shape)
            return
        if isinstance(shape, Bar):
            yield from self._bar(shape)
            return
        if isinstance(shape, Skin):
            yield from self._skin(shape.coarse)
            return
        centred = self.T[shape.frame] @ shape.placement
        faces = {Shape.BOX: self._box, Shape.CYLINDER: self._cylinder, Shape.BALL: self._ball}[shape.shape]
        layer = LAYERS.get(shape.role, 2)
        for points, normal in faces(shape, centred):
            projected, shade = self.view.of(points), OUTLINE if shape.outlined else _shade(normal)
            yield Drawn(shape.role, projected[:, :2], True, shade, layer, float(projected[:, 2].mean()))

    def _line(self, wire: Wire) -> Drawn:
        j, figure = wire.frame, self.figure
        T, before = ((frames[figure.antecedents[j]], frames[j]) for frames in (self.T, figure.reference))
        moved = slip(inverse(T[0]) @ T[1], inverse(before[0]) @ before[1], figure.slides[j])
        projected = self.view.of(transform(self.T[j], bend(wire, moved, figure.slides[j])))
        layer = 3 if wire.role in AXES else 2
        return Drawn(wire.role, projected[:, :2], False, 1, layer, float(projected[:, 2].mean()))

    def _box(self, solid: Solid, T: Array) -> Iterator[tuple[Array, Array]]:
        """The faces towards the eye, and their normals in the view."""
        corners = transform(T, CORNERS * np.array(solid.size))
        for face, axis, sense in FACES:
            normal = self.view.axes @ T[:3, axis] * sense
            if normal[2] > 1e-9:
                yield corners[list(face)], normal

    def _cylinder(self, solid: Solid, T: Array) -> Iterator[tuple[Array, Array]]:
        """The outline of the side, and the end towards the eye."""
        circle = CIRCLE * np.array(solid.size) / 2
        along = T[:3, 2] * solid.size[2] / 2
        ends = [transform(T, circle) + way for way in (-along, along)]
        both = np.concatenate(ends)
        side = self.view.axes @ T[:3, 2]
        yield both[hull(self.view.of(both)[:, :2])], np.array([-side[1], side[0], 0.0]) * (1 if side[0] >= 0 else -1)
        if abs(side[2]) > 1e-9:
            yield ends[int(side[2] > 0)], side * np.sign(side[2])

    def _bar(self, bar: Bar) -> Iterator[Drawn]:
        """The sides towards the eye from end to end, or the outline of a round one, and the ends towards the eye."""
        rings = self.view.of(bar.rings(self.T)) * np.array([1.0, -1.0, 1.0])
        way = np.gradient(rings.mean(axis=1), axis=0)
        if bar.is_round:
            aside = np.stack([-way[:, 1], way[:, 0], 0 * way[:, 0]], axis=1)
            reach = np.einsum("rni,ri->rn", rings, aside)
            rows, sense = np.arange(len(rings)), 1 if way[:, 0].sum() >= 0 else -1
            faces = [(rings[rows, reach.argmin(axis=1)], rings[rows, reach.argmax(axis=1)], sense * aside.sum(axis=0))]
        else:
            sides = ((rings[:, k - 1], rings[:, k]) for k in range(len(bar.outline)))
            faces = [(a, b, np.cross(b - a, way).sum(axis=0)) for a, b in sides]
        areas = [(np.concatenate([a, b[::-1]]), normal) for a, b, normal in faces if bar.is_round or normal[2] > 0]
        areas += [(ring, out) for ring, out in ((rings[0], -way[0]), (rings[-1], way[-1])) if out[2] > 0]
        for points, normal in areas:
            shade = _shade(normal / (np.linalg.norm(normal) or 1.0))
            yield Drawn(bar.role, points[:, :2] * [1, -1], True, shade, LAYERS[bar.role], float(points[:, 2].mean()))

    def _skin(self, skin: Skin) -> Iterator[Drawn]:
        """The triangles towards the eye."""
        corners = (skin.points(self.T) @ self.view.axes.T)[skin.surface.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        for points, normal in zip(corners, normals, strict=True):
            if normal[2] > 0:
                shade = _shade(normal / np.linalg.norm(normal))
                yield Drawn(skin.role, points[:, :2] * [1, -1], True, shade, LAYERS[BEAM], float(points[:, 2].mean()))

    def _ball(self, solid: Solid, T: Array) -> Iterator[tuple[Array, Array]]:
        """The circle around a ball, and the direction to the eye."""
        yield CIRCLE * solid.size[0] / 2 @ self.view.axes + T[:3, 3], np.array([0.0, 0.0, 1.0])


def view_of(figure: Figure) -> View:
    """Return the view of pictures: from the front, from the right and from above."""
    return View(view_axes(figure.up))


def _shade(normal: Array) -> int:
    bright = float(normal @ LIGHT_FROM)
    return 0 if bright > LIT else 1 if bright > DARK else 2


def hull(points: Array) -> list[int]:
    """Return the indices of the corners of the convex hull of points (N, 2), in order around it."""
    ordered = sorted(enumerate(zip(*np.round(points, 12).T.tolist(), strict=True)), key=lambda numbered: numbered[1])
    order, at = [k for k, _ in ordered], points.tolist()

    def half(order: list[int]) -> list[int]:
        corners: list[int] = []
        for k in order:
            while len(corners) > 1 and _turn(at[corners[-2]], at[corners[-1]], at[k]) <= 0:
                corners.pop()
            corners.append(k)
        return corners[:-1]

    return half(order) + half(order[::-1])


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
