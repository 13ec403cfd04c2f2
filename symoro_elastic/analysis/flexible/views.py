"""Bodies by modes, and numbers of joints and modes, as tables and as data for JSON."""

from __future__ import annotations

import math

import numpy as np

from symoro_elastic.analysis.flexible.parts import FlexibleParts, PartErrors
from symoro_elastic.analysis.flexible.reduction import FlexibleModes
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of, table_of
from symoro_elastic.quantities.units import MICRO

MOST_ROWS = 12
"""Modes that are listed."""
LEAST = 1e-9
"""Relative errors of frequencies and compliances below which they are rounding."""

declare(
    FlexibleModes,
    Field("source"),
    Field("about", "body.about"),
    Field("mass", lambda x: x.body.rigid[0]),
    Field("center", lambda x: (x.body.rigid[1] / x.body.rigid[0]).tolist()),
    Field("frequencies", "body.frequencies", array=True),
    Field("compliance", lambda x: {name: x.body.compliance(name).tolist() for name in x.body.places}),
)


@parts_of.register
def _(result: FlexibleModes) -> list[Part]:
    """Return frequencies, and the compliances of interfaces along and about the axes."""
    body = result.body
    center = ", ".join(f"{x:.5g}" for x in body.rigid[1] / body.rigid[0])
    table = Table(("mode", "Hz, joint held"), title="modes")
    for k, frequency in enumerate(body.frequencies[:MOST_ROWS], start=1):
        table.add_row(str(k), f"{frequency:.6g}")
    yields = Table(("interface", "at, m", "x, y, z, um/N", "about x, y, z, urad/(N m)"), title="compliance, joint held")
    for name, interface in body.places.items():
        along = MICRO * np.diag(body.compliance(name))
        at, first, last = (", ".join(f"{x:.4g}" for x in part) for part in (interface.point, along[:3], along[3:]))
        yields.add_row(name, at, first, last)
    more = [f"{body.count - MOST_ROWS} more modes: --json lists all"] if body.count > MOST_ROWS else []
    return [result.headline, f"centre of mass at {center} m from the joint", table, *more, yields, *body.doubts]


def count_text(row: PartErrors) -> str:
    """Return the number of joints or modes of a row, and which."""
    return f"{row.count} {row.what if row.count > 1 else row.what[:-1]}"


def _percent(x: float) -> str:
    """Relative error as text, in percent."""
    return "-" if math.isnan(x) else f"{100 * x:.2g} %" if x > LEAST else "0"


declare(
    PartErrors,
    Field("part", head="part"),
    Field("count", head="joints or modes", text=count_text),
    *map(Field, ("what", "predicted", "measured")),
    Field("of_modes", head="frequencies, predicted", json=False, text=lambda x: _percent(x.predicted[0])),
    Field("of_modes", head="measured", json=False, text=lambda x: _percent(x.measured[0])),
    Field("compliance", head="compliance, predicted", json=False, text=lambda x: _percent(x.predicted[1])),
    Field("compliance", head="measured", json=False, text=lambda x: _percent(x.measured[1])),
    Field("operations", head="operations"),
    Field("present", head="", text=lambda x: "in the file" if x.count == x.present else ""),
)
declare(
    FlexibleParts,
    Field("machine"),
    Field("frame", "frame_name"),
    Field("within"),
    Field("rows"),
    Field("advised", lambda x: {name: row and row.count for name, row in x.advised.items()}),
)


@parts_of.register
def _(result: FlexibleParts) -> list[Part]:
    """Return a row for each number of joints or modes, and which are enough."""
    title = f"{result.machine}: errors of first frequencies and of the compliance of {result.frame_name}, motors held"
    parts: list[Part] = [table_of(PartErrors, result.rows, title)]
    if result.within is not None:
        enough = [f"{name} {count_text(row)}" for name, row in result.advised.items() if row]
        lacking = [name for name, row in result.advised.items() if not row]
        parts += [f"within {_percent(result.within)}: {', '.join(enough)}"] if enough else []
        parts += [f"not enough with all that can be tried: {', '.join(lacking)}"] if lacking else []
    return parts
