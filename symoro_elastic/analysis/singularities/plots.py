"""Plots of singularities: dependent joints and lost motion at each kind of position."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.analysis.singularities.singularities import Singularities
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, legend, shorten
from symoro_elastic.foundation.results import figures_of


@figures_of.register
def _(result: Singularities) -> dict[str, Plot | str]:
    """Return positions: a row for each kind, points at dependent joints and at lost components."""
    if not result.positions:
        return {"positions": "the determinant does not vanish"}
    title = f"{result.machine}: singular positions of {', '.join(result.components)}"
    columns = len(result.joints) + len(result.components)
    size = (max(6.0, 4.0 + 0.4 * columns), 2.2 + 0.3 * len(result.positions))
    return {"positions": Plot(title, partial(_positions, result), size=size)}


def _positions(result: Singularities, axes: Any) -> None:
    columns = [*result.joints, *result.components]
    groups = (("joints move alike", result.joints, 0, "alike", "o"), ("lost", result.components, 1, "lost", "X"))
    for label, names, k, which, mark in groups:
        places = [
            (columns.index(name, 0 if k == 0 else len(result.joints)), row)
            for row, position in enumerate(result.positions)
            for name in getattr(position, which)
            if name in names
        ]
        look = {"linestyle": "", "marker": mark, "markersize": 8, "color": curve(k)["color"]}
        axes.plot(*zip(*places, strict=True) if places else ([], []), label=label, **look)
    look = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
    axes.set_xticks(range(len(columns)), [shorten(name) for name in columns], **look)
    axes.set_yticks(range(len(result.positions)), [shorten(x.condition, 40) for x in result.positions])
    axes.set_xlabel("joints, components of the frame")
    axes.set_ylabel("where")
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(result.positions) - 0.5, -0.5)
    legend(axes)
