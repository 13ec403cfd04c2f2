"""The picture of a machine as SVG: the same bytes for the same machine, on light and on dark paper."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.codegen.templates import render
from symoro_elastic.drawing.figure import BODY, Figure, figure_of
from symoro_elastic.drawing.joint_shapes import AXES
from symoro_elastic.drawing.labels import HEIGHT, Label, labelled, width
from symoro_elastic.drawing.palette import DARK, LIGHT
from symoro_elastic.drawing.placements import placements_of
from symoro_elastic.drawing.projection import Drawn, Projection, view_of
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine

WIDTH, HEIGHT_MOST, MARGIN = 640.0, 460.0, 14.0
"""Of the machine itself, px; labels may stand beside it."""
LEGEND = {
    "motor": "motor",
    "elastic": "spring",
    "passive": "passive joint",
    "coupled": "coupled joint",
    "cut": "cut joint of a loop",
    BODY: "body of equal inertia",
}


@dataclass(frozen=True)
class Picture:
    """What a machine looks like on paper, px: areas and lines, labels, and the edges left, top, right, bottom."""

    drawn: list[Drawn]
    labels: list[Label]
    box: tuple[float, float, float, float]
    figure: Figure

    @property
    def legend(self) -> list[tuple[str, str]]:
        """Roles that are drawn, and what they stand for."""
        return legend_of({part.role for part in self.drawn})


def picture_of(figure: Figure, T: Array | None = None) -> Picture:
    """Return the picture of a machine with its frames at placements T (1 + rows, 4, 4), else as the figure has them."""
    projection = Projection(figure, figure.reference if T is None else T, view_of(figure))
    everything = np.concatenate([part.points for part in projection.drawn])
    low, spread = everything.min(axis=0), np.ptp(everything, axis=0)
    scale = float(min(WIDTH / max(spread[0], 1e-12), HEIGHT_MOST / max(spread[1], 1e-12)))
    drawn = [_scaled(part, low, scale) for part in projection.drawn]
    boxes = np.array([[*part.points.min(axis=0), *part.points.max(axis=0)] for part in drawn if _is_in_the_way(part)])
    anchors = (projection.anchors() - low) * scale
    names = [] if figure.is_crowded else [mark.name for mark in figure.marks]
    labels = labelled(names, anchors, boxes.reshape(-1, 4))
    return Picture(drawn, labels, _edges(drawn, labels), figure)


def legend_of(roles: Collection[str]) -> list[tuple[str, str]]:
    """Return those of the roles that a legend explains, and what they stand for."""
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
    legend = _legend(picture.legend, left, bottom)
    remarks = picture.figure.remarks
    bottom += MARGIN + 20 * len(legend[1]) + 16 * len(remarks)
    return render(
        "view/picture.svg.j2",
        title=escape(f"Machine {picture.figure.title}: {said(picture.figure)}"),
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
    """Return the picture of a machine at its start; an empty text where it cannot be drawn there."""
    try:
        return svg(machine_picture(machine), dark=False)
    except InputError:
        return ""


def said(figure: Figure) -> str:
    """How many joints of each kind a machine has, in words."""
    names = {"motor": "motor", "elastic": "elastic joint", "passive": "passive joint", "coupled": "coupled joint"}
    kinds = [mark.role for mark in figure.marks]
    counts = {name: kinds.count(role) for role, name in names.items()}
    parts = [f"{count} {name}{'s' * (count > 1)}" for name, count in counts.items() if count]
    return ", ".join(parts) or "no joint moves"


def _scaled(part: Drawn, low: Array, scale: float) -> Drawn:
    return Drawn(part.role, (part.points - low) * scale, part.closed, part.shade, part.layer, part.near)


def _is_in_the_way(part: Drawn) -> bool:
    return part.role not in (BODY, "base", *AXES)


def _edges(drawn: Sequence[Drawn], labels: Sequence[Label]) -> tuple[float, float, float, float]:
    corners = [part.points for part in drawn] + [np.array(label.box).reshape(2, 2) for label in labels]
    everything = np.concatenate(corners)
    (left, top), (right, bottom) = everything.min(axis=0) - MARGIN, everything.max(axis=0) + MARGIN
    return float(left), float(top), float(right), float(bottom)


def _shape(part: Drawn) -> tuple[str, str]:
    """Class and path of an area or a line."""
    path = "M" + " ".join(f"{_text(x)},{_text(y)}" for x, y in part.points.tolist())
    return (f"{part.role} s{part.shade}", f"{path}Z") if part.closed else (f"{part.role} line", path)


def _label(label: Label) -> dict[str, str]:
    end_x, end_y = label.end
    numbers = {"x": label.x, "y": label.y + 4, "ax": label.anchor_x, "ay": label.anchor_y, "ex": end_x, "ey": end_y}
    return {name: _text(x) for name, x in numbers.items()} | {"text": escape(label.text)}


def _legend(entries: Sequence[tuple[str, str]], left: float, bottom: float) -> tuple[list[dict[str, str]], list[int]]:
    """Places of the entries of the legend, in one row or more, and the rows."""
    found, x, row = [], left + MARGIN, 0
    for role, text in entries:
        if x + width(text) + 20 > left + WIDTH and x > left + MARGIN:
            x, row = left + MARGIN, row + 1
        found.append({"role": role, "text": text, "x": _text(x), "y": _text(bottom + HEIGHT + 20 * row)})
        x += width(text) + 26
    return found, list(range(row + 1)) if entries else []


def _style(picture: Picture, dark: bool) -> list[str]:
    """Rules of the roles that are drawn."""
    palette = DARK if dark else LIGHT
    rules = [f".label {{ fill: {palette.ink}; stroke: {palette.paper} }}", f".dot {{ fill: {palette.ink} }}"]
    rules += [f".leader {{ stroke: {palette.faint} }}", f".note {{ fill: {palette.faint} }}"]
    used = sorted({(part.role, part.shade) for part in picture.drawn if part.closed})
    rules += [f".{role}.s{shade} {{ fill: {palette.shaded(role, shade)} }}" for role, shade in used]
    for role in sorted({part.role for part in picture.drawn}):
        lines = palette.roles[role]
        rules += [f".{role} {{ stroke: {palette.outline(role)} }}", f".{role}.line {{ stroke: {lines} }}"]
    rules += [f".key.{role} {{ fill: {palette.roles[role]} }}" for role, _ in picture.legend]
    return [f".machine {rule}" for rule in rules]


def _text(x: float) -> str:
    """A number of pixels to a tenth, without a needless point or sign."""
    found = f"{x:.1f}".removesuffix(".0")
    return "0" if found == "-0" else found
