"""Estimates as a table, as columns and as data for JSON."""

from __future__ import annotations

import math

from symoro_elastic.foundation.results import Field, declare
from symoro_elastic.measured.fitting.estimates import Estimate

declare(
    Estimate,
    Field("label", "unknown.label", head="parameter", json=False, column="label"),
    Field("formula", lambda e: e.unknown.formula or e.unknown.label, column="formula"),
    Field(
        "file", lambda e: e.unknown.nominal if e.unknown.of_file else math.nan, head="file", form=".5g", column="file"
    ),
    Field("value", head="estimated", form=".5g", column="value"),
    Field("std", column="std"),
    Field("relative_std", "relative", head="std %", text=lambda e: f"{100 * e.relative:.2g}"),
    Field("unit", "unknown.unit", head="unit", column="unit"),
    Field("verdict", lambda e: str(e.verdict), head="verdict", column="verdict"),
    Field("reason"),
)
