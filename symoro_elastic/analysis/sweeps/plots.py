"""Plots of sweeps: lines over one quantity, maps over two, influences of many."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from symoro_elastic.analysis.sweeps.sweep import Sweep
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of

MOST_CURVES, MOST_MAPS, MOST_BARS = 12, 12, 15


@figures_of.register
def _(found: Sweep) -> dict[str, Any]:
    """Return figures_<k>, one for each unit, of grids of one quantity, map_<k>, one for each figure, of two.

    Others and samples are in the figure `influence`.
    """
    names = [name for name, x in found.figures.items() if np.isfinite(x).any()]
    if found.design.is_grid and len(found.quantities) == 1:
        return {f"figures_{k}": lines(found, group) for k, group in _by_unit(found, names)}
    if found.design.is_grid and len(found.quantities) == 2 and min(found.design.lengths) > 1:
        return {f"map_{k}": map_of(found, name) for k, name in enumerate(names[:MOST_MAPS], 1)}
    return {"influence": bars(found, names)}


def _by_unit(found: Sweep, names: Sequence[str]) -> list[tuple[int, list[str]]]:
    units = list(dict.fromkeys(found.units.get(name, "") for name in names))
    groups = [[name for name in names if found.units.get(name, "") == unit] for unit in units]
    return list(enumerate(groups, 1))


def lines(found: Sweep, names: Sequence[str]) -> Any:
    """Return the plot of results of one unit over the quantity of a grid."""
    figure = new_figure(8.0, 5.0)
    axis = figure.subplots()
    (x,) = found.points.T
    order = np.argsort(x, kind="stable")
    for name in names[:MOST_CURVES]:
        axis.plot(x[order], found.figures[name][order], label=name, linewidth=0.9, marker=".", markersize=3)
    if is_logarithmic(x):
        axis.set_xscale("log")
    axis.set_xlabel(_labelled(found, found.quantities[0]))
    axis.set_ylabel(found.units.get(names[0], "") if len(names) > 1 else _labelled(found, names[0]))
    axis.grid(True, which="both", linewidth=0.3)
    if len(names) > 1:
        axis.legend(fontsize="x-small")
    return figure


def map_of(found: Sweep, name: str) -> Any:
    """Return a figure over the two quantities of a grid, as colours; points without a value stay white."""
    figure = new_figure(7.0, 5.5)
    axis = figure.subplots()
    first, second = (found.design.along(k) for k in range(2))
    rows, columns = np.argsort(first, kind="stable"), np.argsort(second, kind="stable")
    values = np.ma.masked_invalid(found.on_grid(name)[np.ix_(rows, columns)])
    drawn = axis.pcolormesh(second[columns], first[rows], values, shading="nearest", cmap="viridis")
    for set_scale, x in ((axis.set_xscale, second), (axis.set_yscale, first)):
        if is_logarithmic(x):
            set_scale("log")
    axis.set_xlabel(_labelled(found, found.quantities[1]))
    axis.set_ylabel(_labelled(found, found.quantities[0]))
    figure.colorbar(drawn, label=_labelled(found, name))
    return figure


def bars(found: Sweep, names: Sequence[str]) -> Any:
    """Return the influence of each quantity on each figure as bars, the largest first."""
    by, shown = found.influence, list(names[:MOST_CURVES])
    order = by.strongest()[:MOST_BARS]
    figure = new_figure(8.0, 1.5 + 0.22 * len(order) * max(1, len(shown)) ** 0.7)
    axis = figure.subplots()
    height = 0.8 / max(1, len(shown))
    for k, name in enumerate(shown):
        row = np.nan_to_num(by.values[by.figures.index(name), order])
        axis.barh(np.arange(len(order)) + k * height, row, height, label=name)
    axis.set_yticks(np.arange(len(order)) + 0.4 - height / 2, [by.quantities[k] for k in order])
    axis.invert_yaxis()
    axis.set_xlim(-1.05, 1.05)
    axis.axvline(0.0, color="black", linewidth=0.6)
    axis.set_xlabel("share of the range" if found.design.is_grid else "correlation of ranks")
    axis.grid(True, axis="x", linewidth=0.3)
    axis.legend(fontsize="x-small")
    return figure


def is_logarithmic(x: Array) -> bool:
    """Return whether values are spaced as on a logarithmic scale."""
    ordered = np.sort(x)
    if len(x) < 3 or ordered[0] <= 0 or ordered[-1] < 8 * ordered[0]:
        return False
    return float(np.std(np.diff(np.log(ordered)))) < 0.5 * float(np.std(np.diff(ordered)) / np.mean(np.diff(ordered)))


def _labelled(found: Sweep, name: str) -> str:
    return f"{name}, {found.units[name]}" if name in found.units else name
