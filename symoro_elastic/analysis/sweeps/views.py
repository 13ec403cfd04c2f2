"""Sweeps as tables, sentences and plain data."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from symoro_elastic.analysis.sweeps.shares import CONFIDENCE, Share
from symoro_elastic.analysis.sweeps.sweep import REASON, Sweep
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.results import (
    Field,
    Part,
    Table,
    arrays_of,
    columns_of,
    declare,
    json_of,
    parts_of,
    plain,
)

MOST_ROWS, MOST_COLUMNS = 40, 6
"""Figures and quantities that tables show; files hold all."""
MOST_REASONS = 3


declare(Share, *(Field(name) for name in ("name", "low", "high", "within", "points", "share", "interval")))


@parts_of.register
def _(found: Sweep) -> list[Part]:
    influence = [_influence_table(found)] if len(found.points) > 1 else []
    shares = [shares_table(found)] if found.shares else []
    return [_figures_table(found), *shares, *influence, *_lines(found)]


@arrays_of.register
def _(found: Sweep) -> dict[str, AnyArray]:
    """Return quantities and results by name, (N,) each."""
    return {**dict(zip(found.quantities, found.points.T, strict=True)), **found.figures}


@columns_of.register
def _(found: Sweep) -> dict[str, Any]:
    """Return a row for each point: quantities, and results or the reason why there are none."""
    return {**found.arrays(), REASON: list(found.reasons)}


def _figures_table(found: Sweep) -> Table:
    """Return the least, median and largest value of each figure, and the points of the extremes."""
    table = Table(("figure", "least", "median", "largest", "least at", "largest at"), title=found.headline)
    for name, x in list(found.figures.items())[:MOST_ROWS]:
        there = np.flatnonzero(~np.isnan(x))
        if len(there):
            low, high = (int(there[k]) for k in (np.argmin(x[there]), np.argmax(x[there])))
            numbers = (f"{value:.4g}" for value in (x[low], np.median(x[there]), x[high]))
            table.add_row(_titled(found, name), *numbers, _place(found, low), _place(found, high))
        else:
            table.add_row(_titled(found, name), "-", "-", "-", "", "")
    return table


def shares_table(found: Sweep) -> Table:
    """Return a row for each result with a range: the share of points within it, and of all draws."""
    heads = ("figure", "from", "to", "points within", "share", f"share of all draws, {CONFIDENCE:.0%}")
    table = Table(heads, title="required")
    for one in found.shares:
        ends = ("" if np.isinf(x) else f"{x:.4g}" for x in (one.low, one.high))
        interval = f"{one.interval[0]:.1%} to {one.interval[1]:.1%}" if one.interval else "-"
        table.add_row(one.name, *ends, f"{one.within} of {one.points}", f"{one.share:.1%}", interval)
    return table


def _influence_table(found: Sweep) -> Table:
    """Return a row for each figure with the influence of the strongest quantities."""
    by = found.influence
    shown = by.strongest()[:MOST_COLUMNS]
    table = Table(("figure", *(by.quantities[k] for k in shown)), title=by.title)
    for row, name in list(enumerate(by.figures))[:MOST_ROWS]:
        table.add_row(name, *(_influence(by.values, by.slopes, row, k) for k in shown))
    return table


def _influence(values: Array, slopes: Array | None, row: int, k: int) -> str:
    if np.isnan(values[row, k]):
        return "-"
    if slopes is None:
        return f"{values[row, k]:+.2f}"
    return f"{values[row, k]:+.2f} / " + ("-" if np.isnan(slopes[row, k]) else f"{slopes[row, k]:+.3f}")


def _lines(found: Sweep) -> list[str]:
    """Return sentences about what is not shown and about points without result."""
    lines = []
    if len(found.figures) > MOST_ROWS:
        lines.append(f"{len(found.figures) - MOST_ROWS} more results are in the files (--out); choose them by --result")
    if len(found.quantities) > MOST_COLUMNS:
        lines.append(f"the {MOST_COLUMNS} quantities of the largest influence are shown")
    empty = [name for name, x in found.figures.items() if np.isnan(x).all()]
    if empty:
        lines.append(f"without a value at any point: {', '.join(empty[:MOST_ROWS])}")
    reasons = Counter(filter(None, found.reasons))
    if reasons:
        lines.append(f"{found.failures} of {len(found.points)} points have no result:")
        lines += [f"  {count} times {reason}" for reason, count in reasons.most_common(MOST_REASONS)]
        if len(reasons) > MOST_REASONS:
            lines.append(f"  and {len(reasons) - MOST_REASONS} reasons more")
    return lines


@json_of.register
def _(found: Sweep) -> dict[str, Any]:
    """Return points, results and influences as plain data; null where there is no value."""
    by, design = found.influence, found.design
    drawn = {} if design.is_grid else {"seed": design.seed}
    return {
        "name": found.machine,
        "of": found.of,
        "sampling": design.sampling,
        **drawn,
        "quantities": {name: found.points[:, k].tolist() for k, name in enumerate(found.quantities)},
        "lengths": list(design.lengths),
        "figures": plain(found.figures),
        "shares": [json_of(one) for one in found.shares],
        "units": dict(found.units),
        "failed": {str(k): reason for k, reason in enumerate(found.reasons) if reason},
        "influence": {
            name: dict(zip(by.quantities, plain(by.values[k]), strict=True)) for k, name in enumerate(by.figures)
        },
    }


def _titled(found: Sweep, name: str) -> str:
    return f"{name}, {found.units[name]}" if name in found.units else name


def _place(found: Sweep, point: int) -> str:
    pairs = zip(found.quantities, found.points[point], strict=True)
    shown = [f"{name} = {x:.4g}" for name, x in pairs]
    return ", ".join(shown) if len(shown) <= MOST_COLUMNS // 2 else f"point {point + 1}"
