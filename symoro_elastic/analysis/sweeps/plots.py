"""Plots of sweeps: lines over one quantity, maps over two, influences of many."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.sweeps.sweep import Sweep
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import (
    bars,
    by_unit,
    contours,
    curves,
    legend,
    logarithmic,
    shades,
    shorten,
    y_label,
)
from symoro_elastic.foundation.results import figures_of

MOST_MAPS, MOST_BARS, MOST_IN_BARS = 12, 15, 6
CONSTANT = 1e-9
"""Of the largest value of a map: a range that is rounding."""


@figures_of.register
def _(sweep: Sweep) -> dict[str, Plot | str]:
    """Return <figure>_over_<quantity> of grids of one quantity, a picture for each unit, and of two, one for each.

    Others and samples are in the picture `influence`. Results that do not change are left out.
    """
    names = [name for name, x in sweep.figures.items() if np.isfinite(x).any()]
    if not names:
        return {"influence": "no point has a result"}
    over = "_and_".join(name.removeprefix("q.") for name in sweep.quantities)
    if sweep.design.is_grid and len(sweep.quantities) == 1:
        groups = by_unit([sweep.units.get(name, "") for name in names]).values()
        together = [[names[k] for k in group] for group in groups]
        return {f"{_together(some)}_over_{over}": _lines(sweep, some) for some in together}
    if sweep.design.is_grid and len(sweep.quantities) == 2 and min(sweep.design.lengths) > 1:
        few = f"{MOST_MAPS} maps are drawn: choose results by --result"
        return {f"{name}_over_{over}": _map(sweep, name) if k < MOST_MAPS else few for k, name in enumerate(names)}
    return {"influence": _influence(sweep, names)}


def _together(names: Sequence[str]) -> str:
    """Name of a plot of several results: their common prefix."""
    if len(names) == 1:
        return names[0]
    alike = next((k for k, x in enumerate(zip(*names, strict=False)) if len({*x}) > 1), min(map(len, names)))
    stem = names[0][:alike].rstrip("_.0123456789")
    return stem if len(stem) > 2 else f"{names[0]}_and_{len(names) - 1}_more"


def _lines(sweep: Sweep, names: Sequence[str]) -> Plot | str:
    """Return results of one unit over the quantity of a grid, or a note that all are constant."""
    if all(constants := [_constant(sweep, name) for name in names]):
        return "; ".join(constants)
    what = names[0] if len(names) == 1 else f"{sweep.of}"
    title = f"{sweep.machine}: {what} over {sweep.quantities[0]}"
    return Plot(title, partial(_draw_lines, sweep, names), size=(8.0, 4.8))


def _draw_lines(sweep: Sweep, names: Sequence[str], axis: Any) -> None:
    (x,) = sweep.points.T
    order = np.argsort(x, kind="stable")
    columns = np.transpose([sweep.figures[name][order] for name in names])
    low, high = np.nanmin(columns, axis=0), np.nanmax(columns, axis=0)
    changes = (high - low) / np.maximum(np.abs(low), np.abs(high)).clip(1e-300)
    curves(axis, x[order], columns, names, ranks=changes, marker=".")
    if is_logarithmic(x):
        logarithmic(axis, "x")
    axis.set_xlabel(_label(sweep, sweep.quantities[0]))
    y_label(axis, *([] if len(names) > 1 else [names[0]]), sweep.units.get(names[0], ""))
    if len(names) > 1:
        legend(axis)


def _map(sweep: Sweep, name: str) -> Plot | str:
    """Return a map of a result over the two quantities of a grid; points without a value are white."""
    if reason := _constant(sweep, name):
        return reason
    title = f"{sweep.machine}: {name} over {' and '.join(sweep.quantities)}"
    return Plot(title, partial(_draw_map, sweep, name), size=(7.5, 5.2))


def _constant(sweep: Sweep, name: str) -> str:
    """Return a note on the value of a constant result; empty for others."""
    values = sweep.figures[name]
    finite = values[np.isfinite(values)]
    if np.ptp(finite) > CONSTANT * np.abs(finite).max():
        return ""
    where = "" if len(finite) == len(values) else " with a result"
    return f"{name} is {finite[0]:.4g} {sweep.units.get(name, '')}".rstrip() + f" at all points{where}"


def _draw_map(sweep: Sweep, name: str, axis: Any) -> None:
    first, second = (sweep.design.along(k) for k in range(2))
    rows, columns = np.argsort(first, kind="stable"), np.argsort(second, kind="stable")
    values = np.ma.masked_invalid(sweep.on_grid(name)[np.ix_(rows, columns)])
    x, y = np.meshgrid(second[columns], first[rows])
    names = tuple(_label(sweep, sweep.quantities[k]) for k in (1, 0))
    logarithmic(axis, *(which for which, coordinates in (("x", second), ("y", first)) if is_logarithmic(coordinates)))
    contours(x, y, values, names, _label(sweep, name), axis)


def _influence(sweep: Sweep, names: Sequence[str]) -> Plot:
    """Return the influence of the quantities on each result, the largest first."""
    rows = min(MOST_BARS, len(sweep.quantities))
    listed = list(names[:MOST_IN_BARS])
    title = f"{sweep.machine}: {sweep.of}, influence of each quantity"
    title += f"; {len(listed)} of {len(names)} results" if len(listed) < len(names) else ""
    return Plot(title, partial(_draw_bars, sweep, listed), size=(8.0, 1.5 + 0.3 * rows * max(1, len(listed)) ** 0.5))


def _draw_bars(sweep: Sweep, listed: Sequence[str], axis: Any) -> None:
    by = sweep.influence
    order = by.strongest()[:MOST_BARS]
    lengths = {name: by.values[by.figures.index(name), order].tolist() for name in listed}
    bars(axis, lengths, [by.quantities[k] for k in order])
    axis.set_xlim(-1.05, 1.05)
    axis.axvline(0.0, color=shades().ink, linewidth=0.8)
    axis.set_xlabel("share of the range" if sweep.design.is_grid else "correlation of ranks")
    legend(axis)


def is_logarithmic(x: Array) -> bool:
    """Return whether values are evenly spaced on a logarithmic scale."""
    ordered = np.sort(x)
    if len(x) < 3 or ordered[0] <= 0 or ordered[-1] < 8 * ordered[0]:
        return False
    return float(np.std(np.diff(np.log(ordered)))) < 0.5 * float(np.std(np.diff(ordered)) / np.mean(np.diff(ordered)))


def _label(sweep: Sweep, name: str) -> str:
    label = shorten(name)
    return f"{label}, {sweep.units[name]}" if name in sweep.units else label
