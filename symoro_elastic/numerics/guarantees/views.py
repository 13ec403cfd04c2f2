"""Certificates as tables, as data for JSON, and as rows of a data frame."""

from __future__ import annotations

from typing import Any

from symoro_elastic.foundation.results import (
    Field,
    Part,
    columns_of,
    declare,
    fields_of,
    json_of,
    parts_of,
    plain,
    table_of,
)
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.certificate import Certificate, EntryBound, PivotBound
from symoro_elastic.numerics.guarantees.certificates import Certificates
from symoro_elastic.numerics.guarantees.wording import confidence, divisors, error_text, overflow, range_text

declare(
    EntryBound,
    Field("name", head="result", column="result"),
    Field("entry", head="of", column="of"),
    Field("low", column="low"),
    Field("high", column="high"),
    Field("range", head="range, proven", text=range_text, json=False, value=range_text),
    Field("error", head="error, proven", text=lambda one: error_text(one.error), column="error"),
    Field("likely", head="error, confident",
          text=lambda one: error_text(one.likely), column="likely error"),
    Field("guarantee", column="guarantee"),
)  # fmt: skip
declare(PivotBound, Field("name"), Field("least"))
declare(Range, Field("low"), Field("high"))


@parts_of.register
def _(result: Certificates) -> list[Part]:
    """Return a table of each certificate, its divisors and its range of numbers; what the confident errors mean."""
    shown: list[Part] = []
    for one in result.certificates:
        parts = f", {one.sub_boxes} sub-boxes" if one.sub_boxes > 1 else ""
        title = f"{result.machine}: {one.model}, {one.precision} precision, box {one.box.digest}{parts}; SI units"
        shown += [table_of(EntryBound, one.entries, title, keys=2), f"{divisors(one)}; {overflow(one)}"]
    return [*shown, confidence("confident")]


@columns_of.register
def _(result: Certificates) -> dict[str, Any]:
    """Return a row for each entry of each result."""
    rows = [(one, entry) for one in result.certificates for entry in one.entries]
    columns: dict[str, Any] = {"model": [one.model for one, _ in rows], "precision": [one.precision for one, _ in rows]}
    fields = [each for each in fields_of(EntryBound) if each.column]
    return columns | {each.column: [each.of(entry) for _, entry in rows] for each in fields}


@json_of.register
def _(one: Certificate) -> dict[str, Any]:
    """Return box, bounds and divisors as plain data; what is not bounded is null."""
    return {
        "model": one.model,
        "precision": one.precision,
        "guarantee": str(one.guarantee),
        "box": plain(one.box.ranges),
        "digest": one.box.digest,
        "sub_boxes": one.sub_boxes,
        "overflows": one.overflows,
        "divisors": plain(one.pivots),
        "results": plain(one.entries),
    }


@json_of.register
def _(result: Certificates) -> dict[str, Any]:
    """Return the certificates as plain data."""
    return {"machine": result.machine, "certificates": [json_of(one) for one in result.certificates]}
