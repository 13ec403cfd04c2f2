"""Plots of singularities: which joints move alike at each kind of position, and which motion is lost."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.analysis.singularities.singularities import Singularities
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, legend, shortened
from symoro_elastic.foundation.results import figures_of


@figures_of.register
def _(found: Singularities) -> dict[str, Plot | str]:
    """Return positions: a row for each kind, points at joints that move alike and at components that are lost."""
    if not found.positions:
        return {"positions": "the determinant does not vanish"}
    title = f"{found.machine}: singular positions of {', '.join(found.components)}"
    columns = len(found.joints) + len(found.components)
    size = (max(6.0, 4.0 + 0.4 * columns), 2.2 + 0.3 * len(found.positions))
    return {"positions": Plot(title, partial(_positions, found), size=size)}


def _positions(found: Singularities, axes: Any) -> None:
    columns = [*found.joints, *found.components]
    groups = (("joints move alike", found.joints, 0, "alike", "o"), ("lost", found.components, 1, "lost", "X"))
    for label, names, k, which, mark in groups:
        places = [
            (columns.index(name, 0 if k == 0 else len(found.joints)), row)
            for row, position in enumerate(found.positions)
            for name in getattr(position, which)
            if name in names
        ]
        look = {"linestyle": "", "marker": mark, "markersize": 8, "color": curve(k)["color"]}
        axes.plot(*zip(*places, strict=True) if places else ([], []), label=label, **look)
    look = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
    axes.set_xticks(range(len(columns)), [shortened(name) for name in columns], **look)
    axes.set_yticks(range(len(found.positions)), [shortened(one.condition, 40) for one in found.positions])
    axes.set_xlabel("joints, components of the frame")
    axes.set_ylabel("where")
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(found.positions) - 0.5, -0.5)
    legend(axes)
