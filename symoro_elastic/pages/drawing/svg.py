"""The picture of a machine as SVG: the same bytes for the same machine, on light and on dark paper."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from html import escape

import numpy as np

from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.pages.drawing.bars import BEAM
from symoro_elastic.pages.drawing.figure import BODY, Figure, figure_of, placements_of
from symoro_elastic.pages.drawing.joint_shapes import AXES
from symoro_elastic.pages.drawing.palette import DARK, LIGHT
from symoro_elastic.pages.drawing.projection import GHOST, OUTLINE, Drawn, Projection, view_of

HEIGHT, GAP = 15.0, 4.0
"""Of a line of text, and around it, px."""
NARROW, WIDE = frozenset("fijlrtI.,:;|'!()[] -"), frozenset("mwMW@%")
NARROW_ADVANCE, ADVANCE, CAPITAL_ADVANCE, WIDE_ADVANCE = 4.2, 6.8, 8.7, 10.2
"""Of characters in Helvetica and its likes at 12 px."""
DIRECTIONS = 16
FIRST, GROWTH = 16.0, 1.32
"""Distance of the first place from its point, px, and the ratio of successive distances."""
COVERED, CROSSED, HIDDEN = 30.0, 25.0, 60.0
"""What it costs, in px, to cover something drawn, to cross another line, to have a label on a line."""
SHARES = np.array([[0.15], [0.3], [0.45], [0.6], [0.75], [0.9]])
"""Points of a label's line that should be outside of other labels."""
PLENTY = 11
"""Rings of places that are compared, further ones only where these have no room."""

WIDTH, HEIGHT_MOST, MARGIN = 640.0, 460.0, 14.0
"""Of the machine itself, px; labels may extend beyond it."""
LEGEND = {
    "motor": "motor",
    "elastic": "spring",
    "passive": "passive joint",
    "coupled": "coupled joint",
    "cut": "cut joint of a loop",
    BODY: "body (box of equal inertia, or ball)",
    BEAM: "beam, or body by modes",
}


@dataclass(frozen=True)
class Picture:
    """A machine on paper, px: areas and lines, labels, and the edges left, top, right, bottom."""

    drawn: list[Drawn]
    labels: list[Label]
    box: tuple[float, float, float, float]
    figure: Figure

    @property
    def legend(self) -> list[tuple[str, str]]:
        """Drawn roles, and their meanings."""
        return legend_of({part.role for part in self.drawn})


def picture_of(figure: Figure, T: Array | None = None, arrows: Sequence[Array] = ()) -> Picture:
    """Return the picture of a machine with frames at placements T (1 + rows, 4, 4), by default the figure's.

    With lines (N, 3) of `arrows`, m, in frame 0, outlines of the figure at its own placements are a ghost behind it.
    """
    projection = Projection(figure, figure.reference if T is None else T, view_of(figure))
    drawn = projection.back_to_front
    if arrows:
        drawn = [*replace(projection, T=figure.reference).ghost, *drawn, *map(projection.arrow, arrows)]
    outline = np.concatenate([part.points for part in drawn])
    low, spread = outline.min(axis=0), np.ptp(outline, axis=0)
    scale = float(min(WIDTH / max(spread[0], 1e-12), HEIGHT_MOST / max(spread[1], 1e-12)))
    parts = [replace(part, points=(part.points - low) * scale) for part in drawn]
    obstacles = [part.points for part in parts if part.role not in (BODY, BEAM, "base", GHOST, *AXES)]
    boxes = np.array([[*points.min(axis=0), *points.max(axis=0)] for points in obstacles])
    anchors = (projection.anchors() - low) * scale
    names = [] if figure.is_crowded else [mark.name for mark in figure.marks]
    labels = place_labels(names, anchors, boxes.reshape(-1, 4))
    return Picture(parts, labels, _edges((outline - low) * scale, labels), figure)


def legend_of(roles: Collection[str]) -> list[tuple[str, str]]:
    """Return the roles in a legend, and their meanings."""
    return [(role, text) for role, text in LEGEND.items() if role in roles]


def machine_picture(machine: Machine, at: Mapping[str, float] | None = None) -> Picture:
    """Return the picture of a machine, restricted to a scene, with joints at positions, rad or m; springs are neutral.

    Raises `InputError` for positions of joints that do not move by themselves, and loops that do not close.
    """
    placements = placements_of(machine)
    return picture_of(figure_of(placements, placements.position(at or {})))


def svg(picture: Picture, dark: bool = True) -> str:
    """Return a standalone SVG document; names of the machine are text in it, never markup.

    It follows the colours that a reader prefers; without `dark` it is for light paper only.
    """
    left, top, right, bottom = picture.box
    legend = _legend(picture.legend, left, right, bottom)
    remarks = picture.figure.remarks
    bottom += MARGIN + 20 * len(legend[1]) + 16 * len(remarks)
    return render(
        "view/picture.svg.j2",
        title=escape(f"Machine {picture.figure.title}: {joint_counts(picture.figure)}"),
        box=" ".join(_text(x) for x in (left, top, right - left, bottom - top)),
        size=(_text(right - left), _text(bottom - top)),
        light=_style(picture, dark=False),
        dark=_style(picture, dark=True) if dark else [],
        shapes=[_shape(part) for part in picture.drawn],
        labels=[_label(label) for label in picture.labels],
        legend=legend[0],
        notes=_notes(remarks, left, bottom),
    )


def _notes(remarks: Sequence[str], left: float, bottom: float) -> list[tuple[str, str, str]]:
    """Places of the remarks, one below the other, and their texts."""
    lines = enumerate(reversed(remarks))
    return [(_text(left + MARGIN), _text(bottom - 16 * k - 10), escape(remark)) for k, remark in lines]


def svg_for_light_paper(machine: Machine) -> str:
    """Return the picture of a machine at its start; empty if it cannot be drawn there."""
    try:
        return svg(machine_picture(machine), dark=False)
    except InputError:
        return ""


def joint_counts(figure: Figure) -> str:
    """Return the numbers of a machine's joints by kind, in words."""
    names = {"motor": "motor", "elastic": "elastic joint", "passive": "passive joint", "coupled": "coupled joint"}
    names |= {BEAM: "beam"}
    kinds = [*(mark.role for mark in figure.marks), *(bar.role for bar in figure.bars)]
    counts = {name: kinds.count(role) for role, name in names.items()}
    parts = [f"{count} {name}{'s' * (count > 1)}" for name, count in counts.items() if count]
    return ", ".join(parts) or "no joint moves"


def _edges(outline: Array, labels: Sequence[Label]) -> tuple[float, float, float, float]:
    everything = np.concatenate([outline, *(np.array(label.box).reshape(2, 2) for label in labels)])
    (left, top), (right, bottom) = everything.min(axis=0) - MARGIN, everything.max(axis=0) + MARGIN
    return float(left), float(top), float(right), float(bottom)


def _shape(part: Drawn) -> tuple[str, str]:
    """Return the CSS classes and the SVG path of a drawn area or line."""
    path = "M" + " ".join(f"{_text(x)},{_text(y)}" for x, y in part.points.tolist())
    return (f"{part.role} s{part.shade}", f"{path}Z") if part.closed else (f"{part.role} line", path)


def _label(label: Label) -> dict[str, str]:
    end_x, end_y = label.end
    numbers = {"x": label.x, "y": label.y + 4, "ax": label.anchor_x, "ay": label.anchor_y, "ex": end_x, "ey": end_y}
    return {name: _text(x) for name, x in numbers.items()} | {"text": escape(label.text)}


def _legend(
    entries: Sequence[tuple[str, str]], left: float, right: float, bottom: float
) -> tuple[list[dict[str, str]], list[int]]:
    """Return the entries of the legend with their positions in the picture, and the numbers of its rows."""
    cells, x, row = [], left + MARGIN, 0
    for role, text in entries:
        if x + width(text) + 20 > right and x > left + MARGIN:
            x, row = left + MARGIN, row + 1
        cells.append({"role": role, "text": text, "x": _text(x), "y": _text(bottom + HEIGHT + 20 * row)})
        x += width(text) + 26
    return cells, list(range(row + 1)) if entries else []


def _style(picture: Picture, dark: bool) -> list[str]:
    """Return the CSS rules for the roles that occur in a picture."""
    palette = DARK if dark else LIGHT
    rules = [f".label {{ fill: {palette.ink}; stroke: {palette.paper} }}", f".dot {{ fill: {palette.ink} }}"]
    rules += [f".leader {{ stroke: {palette.faint} }}", f".note {{ fill: {palette.faint} }}"]
    used = sorted({(part.role, part.shade) for part in picture.drawn if part.closed})
    fills = {(role, shade): "none" if shade == OUTLINE else palette.shade(role, shade) for role, shade in used}
    rules += [f".{role}.s{shade} {{ fill: {fill} }}" for (role, shade), fill in fills.items()]
    for role in sorted({part.role for part in picture.drawn}):
        lines = palette.roles[role]
        rules += [f".{role} {{ stroke: {palette.outline(role)} }}", f".{role}.line {{ stroke: {lines} }}"]
    rules += [f".key.{role} {{ fill: {palette.roles[role]} }}" for role, _ in picture.legend]
    return [f".machine {rule}" for rule in rules]


def _text(x: float) -> str:
    """A number of pixels to a tenth, without trailing zero or negative zero."""
    digits = f"{x:.1f}".removesuffix(".0")
    return "0" if digits == "-0" else digits


# Labels near their points: without overlap, and clear of the drawing as far as possible.
@dataclass(frozen=True)
class Label:
    """A text whose left end and middle are at (x, y) px, for the point (anchor_x, anchor_y)."""

    text: str
    x: float
    y: float
    anchor_x: float
    anchor_y: float

    @cached_property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom, px."""
        return self.x, self.y - HEIGHT / 2, self.x + width(self.text), self.y + HEIGHT / 2

    @cached_property
    def end(self) -> tuple[float, float]:
        """The end of the line from the point to the text."""
        left, _, right, _ = self.box
        return (left - GAP if self.anchor_x <= (left + right) / 2 else right + GAP), self.y


@cache
def width(text: str) -> float:
    """Return an upper bound of the width of a text, px."""
    return sum(map(_advance, text))


def _advance(character: str) -> float:
    if character in NARROW:
        return NARROW_ADVANCE
    if character in WIDE:
        return WIDE_ADVANCE
    return CAPITAL_ADVANCE if character.isupper() else ADVANCE


def place_labels(texts: Sequence[str], anchors: Array, obstacles: Array) -> list[Label]:
    """Return a label for each text near its anchor, the first of (N, 2), clear of the boxes `obstacles` (M, 4)."""
    labels: list[Label] = []
    boxes = np.empty((len(texts), 8))  # of labels so far: box, anchor, end
    for k, (text, anchor) in enumerate(zip(texts, anchors, strict=False)):
        labels.append(_best(text, anchor, anchors, obstacles, boxes[:k]))
        boxes[k] = *labels[k].box, labels[k].anchor_x, labels[k].anchor_y, *labels[k].end
    return labels


def _best(text: str, anchor: Array, anchors: Array, obstacles: Array, labels: Array) -> Label:
    """Return the label at the place of least cost; further rings are searched until a place is free."""
    label = _within(text, anchor, anchors, obstacles, labels, range(PLENTY))
    ring = PLENTY
    while label is None:
        label = _within(text, anchor, anchors, obstacles, labels, range(ring, ring + 1))
        ring += 1
    return label


def _within(
    text: str, anchor: Array, anchors: Array, obstacles: Array, labels: Array, rings: Sequence[int]
) -> Label | None:
    """Return the label at the first place of least cost in these rings; None if all places are occupied."""
    x, y, distance = _places(text, anchor, rings)
    boxes = np.stack([x, y - HEIGHT / 2, x + width(text), y + HEIGHT / 2], axis=1)
    free = np.flatnonzero(_free(boxes, anchors, labels))
    if not len(free):
        return None
    cost = distance[free] + COVERED * np.minimum(_near(boxes[free], obstacles, 0.0, 0.0).sum(axis=1), 6.0)
    cost += _crossings(anchor, boxes[free], labels)
    k = int(free[np.flatnonzero(cost <= cost.min() + 1e-6)[0]])
    return Label(text, float(x[k]), float(y[k]), float(anchor[0]), float(anchor[1]))


def _places(text: str, anchor: Array, rings: Sequence[int]) -> tuple[Array, Array, Array]:
    """Left ends and middles of a text around its point, and distances from it, px: ring by ring, (K,) each."""
    angles = 2 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    distance = np.repeat([FIRST * GROWTH**ring for ring in rings], DIRECTIONS)
    across, up = np.tile(np.cos(angles), len(rings)), np.tile(np.sin(angles), len(rings))
    shift = width(text) * np.where(across > 0.35, 0.0, np.where(across < -0.35, -1.0, -0.5))
    return anchor[0] + distance * across + shift, anchor[1] - distance * up, distance


def overlap(box: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two boxes are closer than the gap."""
    return bool(_near(np.array([box]), np.array([other]))[0, 0])


def _near(boxes: Array, obstacles: Array, x: float = GAP, y: float = GAP / 2) -> BoolArray:
    """Which of boxes (K, 4) are closer to which `obstacles` (N, 4) than x and y, px: (K, N)."""
    across = (boxes[:, 0, None] < obstacles[:, 2] + x) & (obstacles[:, 0] < boxes[:, 2, None] + x)
    return np.asarray(across & (boxes[:, 1, None] < obstacles[:, 3] + y) & (obstacles[:, 1] < boxes[:, 3, None] + y))


def _free(boxes: Array, anchors: Array, labels: Array) -> BoolArray:
    """Which boxes (K, 4) are clear of the points (M, 2) and of the labels (N, 8)."""
    points = np.concatenate([anchors, anchors], axis=1)
    covered: BoolArray = np.concatenate([_near(boxes, points, GAP, 1.0), _near(boxes, labels[:, :4])], axis=1)
    return np.asarray(np.logical_not(np.logical_or.reduce(covered, axis=1)))


def _crossings(anchor: Array, boxes: Array, labels: Array) -> Array:
    """Cost of places of a label (K, 4), px, from lines that cross each other, texts or other labels (N, 8)."""
    left, right = boxes[:, 0], boxes[:, 2]
    near = np.where(anchor[0] <= (left + right) / 2, left - GAP, right + GAP)
    ends = np.stack([near, (boxes[:, 1] + boxes[:, 3]) / 2], axis=1)
    cost: Array = CROSSED * _cross(anchor, ends, labels).sum(axis=1)
    cost += HIDDEN * _run_through(np.broadcast_to(anchor, ends.shape), ends, labels[:, :4]).sum(axis=1)
    cost += HIDDEN * _run_through(labels[:, 4:6], labels[:, 6:], boxes).sum(axis=0)
    return cost


def _cross(anchor: Array, ends: Array, labels: Array) -> BoolArray:
    """Which lines from a point to the ends (K, 2) cross which label lines (N, 8): (K, N)."""
    starts, stops, b = labels[:, 4:6], labels[:, 6:], ends[:, None]
    here = _side(anchor, b, starts) * _side(anchor, b, stops) < 0
    there = _side(starts, stops, anchor) * _side(starts, stops, b) < 0
    return np.asarray(here & there & np.logical_or.reduce(starts != anchor, axis=1))


def _run_through(starts: Array, stops: Array, boxes: Array) -> BoolArray:
    """Which lines (K, 2) to (K, 2) run through which boxes (N, 4): (K, N)."""
    points = starts[:, None] + SHARES * (stops - starts)[:, None]  # (K, 6, 2)
    x, y = points[..., 0, None], points[..., 1, None]
    left, top, right, bottom = (boxes[:, k] for k in range(4))
    inside = (left - 1 < x) & (x < right + 1) & (top < y) & (y < bottom)
    return np.asarray(np.logical_or.reduce(inside, axis=1))


def _side(a: Array, b: Array, c: Array) -> Array:
    """The side of a line through a and b on which points c are, by the sign."""
    side: Array = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    return side
