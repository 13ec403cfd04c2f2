"""Sweeps as tables, sentences and plain data."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from symoro_elastic.analysis.sweeps.sweep import CONFIDENCE, REASON, Share, Sweep
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
def _(sweep: Sweep) -> list[Part]:
    influence = [_influence_table(sweep)] if len(sweep.points) > 1 else []
    shares = [shares_table(sweep)] if sweep.shares else []
    return [_figures_table(sweep), *shares, *influence, *_lines(sweep)]


@arrays_of.register
def _(sweep: Sweep) -> dict[str, AnyArray]:
    """Return quantities and results by name, (N,) each."""
    return {**dict(zip(sweep.quantities, sweep.points.T, strict=True)), **sweep.figures}


@columns_of.register
def _(sweep: Sweep) -> dict[str, Any]:
    """Return a row for each point: quantities, and results or the reason why there are none."""
    return {**sweep.arrays(), REASON: list(sweep.reasons)}


def _figures_table(sweep: Sweep) -> Table:
    """Return the least, median and largest value of the results, and the points of the extremes."""
    table = Table(("figure", "least", "median", "largest", "least at", "largest at"), title=sweep.headline)
    for name, x in list(sweep.figures.items())[:MOST_ROWS]:
        there = np.flatnonzero(~np.isnan(x))
        if len(there):
            low, high = (int(there[k]) for k in (np.argmin(x[there]), np.argmax(x[there])))
            numbers = (f"{value:.4g}" for value in (x[low], np.median(x[there]), x[high]))
            table.add_row(_title(sweep, name), *numbers, _place(sweep, low), _place(sweep, high))
        else:
            table.add_row(_title(sweep, name), "-", "-", "-", "", "")
    return table


def shares_table(sweep: Sweep) -> Table:
    """Return a row for each result with a range: the fraction of points within it, and its interval."""
    heads = ("figure", "from", "to", "points within", "share", f"share of all draws, {CONFIDENCE:.0%}")
    table = Table(heads, title="required")
    for share in sweep.shares:
        ends = ("" if np.isinf(x) else f"{x:.4g}" for x in (share.low, share.high))
        interval = f"{share.interval[0]:.1%} to {share.interval[1]:.1%}" if share.interval else "-"
        table.add_row(share.name, *ends, f"{share.within} of {share.points}", f"{share.share:.1%}", interval)
    return table


def _influence_table(sweep: Sweep) -> Table:
    """Return a row for each result with the influence of the strongest quantities."""
    by = sweep.influence
    listed = by.strongest()[:MOST_COLUMNS]
    table = Table(("figure", *(by.quantities[k] for k in listed)), title=by.title)
    for row, name in list(enumerate(by.figures))[:MOST_ROWS]:
        table.add_row(name, *(_influence(by.values, by.slopes, row, k) for k in listed))
    return table


def _influence(values: Array, slopes: Array | None, row: int, k: int) -> str:
    if np.isnan(values[row, k]):
        return "-"
    if slopes is None:
        return f"{values[row, k]:+.2f}"
    return f"{values[row, k]:+.2f} / " + ("-" if np.isnan(slopes[row, k]) else f"{slopes[row, k]:+.3f}")


def _lines(sweep: Sweep) -> list[str]:
    """Return sentences about omitted results and about points without result."""
    lines = []
    if len(sweep.figures) > MOST_ROWS:
        lines.append(f"{len(sweep.figures) - MOST_ROWS} more results are in the files (--out); choose them by --result")
    if len(sweep.quantities) > MOST_COLUMNS:
        lines.append(f"the {MOST_COLUMNS} quantities of the largest influence are shown")
    empty = [name for name, x in sweep.figures.items() if np.isnan(x).all()]
    if empty:
        lines.append(f"without a value at any point: {', '.join(empty[:MOST_ROWS])}")
    reasons = Counter(filter(None, sweep.reasons))
    if reasons:
        lines.append(f"{sweep.failures} of {len(sweep.points)} points have no result:")
        lines += [f"  {count} times {reason}" for reason, count in reasons.most_common(MOST_REASONS)]
        if len(reasons) > MOST_REASONS:
            lines.append(f"  and {len(reasons) - MOST_REASONS} reasons more")
    return lines


@json_of.register
def _(sweep: Sweep) -> dict[str, Any]:
    """Return points, results and influences as plain data; null for a missing value."""
    by, design = sweep.influence, sweep.design
    seed = {} if design.is_grid else {"seed": design.seed}
    return {
        "name": sweep.machine,
        "of": sweep.of,
        "sampling": design.sampling,
        **seed,
        "quantities": {name: sweep.points[:, k].tolist() for k, name in enumerate(sweep.quantities)},
        "lengths": list(design.lengths),
        "figures": plain(sweep.figures),
        "shares": [json_of(share) for share in sweep.shares],
        "units": dict(sweep.units),
        "failed": {str(k): reason for k, reason in enumerate(sweep.reasons) if reason},
        "influence": {
            name: dict(zip(by.quantities, plain(by.values[k]), strict=True)) for k, name in enumerate(by.figures)
        },
    }


def _title(sweep: Sweep, name: str) -> str:
    return f"{name}, {sweep.units[name]}" if name in sweep.units else name


def _place(sweep: Sweep, point: int) -> str:
    pairs = zip(sweep.quantities, sweep.points[point], strict=True)
    texts = [f"{name} = {x:.4g}" for name, x in pairs]
    return ", ".join(texts) if len(texts) <= MOST_COLUMNS // 2 else f"point {point + 1}"
