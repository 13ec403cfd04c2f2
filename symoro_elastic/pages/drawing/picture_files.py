"""Files of machine pictures: SVG written directly, PNG and PDF by matplotlib."""

from __future__ import annotations

from typing import Any

from symoro_elastic.foundation.file_forms import PICTURES, form_of
from symoro_elastic.foundation.output_files import write_file
from symoro_elastic.foundation.pictures import new_figure, picture
from symoro_elastic.pages.drawing.figure import BODY
from symoro_elastic.pages.drawing.palette import LIGHT
from symoro_elastic.pages.drawing.projection import OUTLINE, Drawn
from symoro_elastic.pages.drawing.svg import Picture, svg

PIXELS = 96.0
"""In an inch."""
CLEAR = 0.3
"""Opacity of bodies."""


def write_picture(drawing: Picture, path: str, place: str) -> None:
    """Write a picture as SVG, PNG or PDF, by its suffix; raises `InputError`, also without matplotlib."""
    form = form_of(path, PICTURES, place)[1:]
    content = svg(drawing).encode("utf-8") if form == "svg" else picture(_matplotlib_figure(drawing), form)
    write_file(content, path, place)


def _matplotlib_figure(machine_picture: Picture) -> Any:
    """The picture as a figure of matplotlib, on light paper."""
    left, top, right, bottom = machine_picture.box
    figure = new_figure((right - left) / PIXELS, (bottom - top) / PIXELS)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_xlim(left, right)
    axes.set_ylim(bottom, top)
    for order, part in enumerate(machine_picture.drawn):
        _plot(axes, part, order)
    for label in machine_picture.labels:
        end = label.end
        order = len(machine_picture.drawn) + 1
        axes.plot([label.anchor_x, end[0]], [label.anchor_y, end[1]], color=LIGHT.faint, linewidth=0.5, zorder=order)
        axes.plot([label.anchor_x], [label.anchor_y], ".", color=LIGHT.ink, markersize=3, zorder=order)
        halo = {"boxstyle": "square,pad=0.08", "facecolor": "white", "edgecolor": "none", "alpha": 0.75}
        axes.text(
            *(label.x, label.y, label.text),
            fontsize=8,
            color=LIGHT.ink,
            va="center",
            zorder=order + 1,
            bbox=halo,
            parse_math=False,
        )
    return figure


def _plot(axes: Any, part: Drawn, order: int) -> None:
    x, y = part.points.T
    if not part.closed:
        axes.plot(x, y, color=LIGHT.roles[part.role], linewidth=1.1, zorder=order)
        return
    clear = CLEAR if part.role == BODY else 1.0
    if part.shade != OUTLINE:
        axes.fill(x, y, facecolor=LIGHT.shade(part.role, part.shade), edgecolor="none", alpha=clear, zorder=order)
    edge = {"color": LIGHT.outline(part.role), "linewidth": 0.6, "alpha": min(1.0, 1.6 * clear)}
    axes.plot([*x, x[0]], [*y, y[0]], zorder=order, **edge)
