"""Bodies by modes as tables and as data for JSON."""

from __future__ import annotations

import numpy as np

from symoro_elastic.analysis.fe_bodies.fe_body import FlexibleModes
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of
from symoro_elastic.quantities.units import MICRO

MOST_ROWS = 12
"""Modes that are listed."""

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
