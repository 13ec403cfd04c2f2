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
from symoro_elastic.numerics.guarantees.certificate import Certificate, EntryBound, PivotBound, evidence_text
from symoro_elastic.numerics.guarantees.certificates import Certificates
from symoro_elastic.numerics.guarantees.header import confidence, divisors, error_text, overflow, range_text

declare(
    EntryBound,
    Field("name", head="result", column="result"),
    Field("entry", head="of", column="of"),
    Field("low", column="low"),
    Field("high", column="high"),
    Field("range", head="range, proven", text=range_text, json=False, value=range_text),
    Field("error", head="error, proven", text=lambda entry: error_text(entry.error), column="error"),
    Field("likely", head="error, confident",
          text=lambda entry: error_text(entry.likely), column="likely error"),
    Field("guarantee", lambda x: evidence_text(x.guarantee), column="guarantee"),
)  # fmt: skip
declare(PivotBound, Field("name"), Field("least"))
declare(Range, Field("low"), Field("high"))


@parts_of.register
def _(result: Certificates) -> list[Part]:
    """Return tables of certificates with their divisors and range of numbers, and the meaning of confident errors."""
    shown: list[Part] = []
    for x in result.certificates:
        parts = f", {x.sub_boxes} sub-boxes" if x.sub_boxes > 1 else ""
        title = f"{result.machine}: {x.model}, {x.precision} precision, box {x.box.digest}{parts}; SI units"
        shown += [table_of(EntryBound, x.entries, title, keys=2), f"{divisors(x)}; {overflow(x)}"]
    return [*shown, confidence("confident")]


@columns_of.register
def _(result: Certificates) -> dict[str, Any]:
    """Return the entries of all results as rows."""
    rows = [(certificate, entry) for certificate in result.certificates for entry in certificate.entries]
    columns: dict[str, Any] = {"model": [x.model for x, _ in rows], "precision": [x.precision for x, _ in rows]}
    fields = [field for field in fields_of(EntryBound) if field.column]
    return columns | {field.column: [field.of(entry) for _, entry in rows] for field in fields}


@json_of.register
def _(certificate: Certificate) -> dict[str, Any]:
    """Return box, bounds and divisors as plain data; what is not bounded is null."""
    return {
        "model": certificate.model,
        "precision": certificate.precision,
        "guarantee": evidence_text(certificate.guarantee),
        "box": plain(certificate.box.ranges),
        "digest": certificate.box.digest,
        "sub_boxes": certificate.sub_boxes,
        "overflows": certificate.overflows,
        "divisors": plain(certificate.pivots),
        "results": plain(certificate.entries),
    }


@json_of.register
def _(result: Certificates) -> dict[str, Any]:
    """Return the certificates as plain data."""
    return {"machine": result.machine, "certificates": [json_of(certificate) for certificate in result.certificates]}
