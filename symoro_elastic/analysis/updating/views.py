"""What an update found, as text, as columns and as data for JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symoro_elastic.analysis.updating.doubts import Band
from symoro_elastic.analysis.updating.next_tests import Candidate
from symoro_elastic.analysis.updating.told import Found
from symoro_elastic.analysis.updating.updated import Shown, Updated
from symoro_elastic.foundation.results import Field, Part, Table, declare, parts_of, table_of

declare(
    Found,
    Field("label", "unknown.label", head="parameter", json=False, column="label"),
    Field("file", lambda x: x.unknown.start if x.unknown.of_file else math.nan, head="file", form=".5g", column="file"),
    Field("value", head="found", form=".5g", column="value"),
    Field("std", column="std"),
    Field("relative_std", "relative", head="std %", text=lambda x: f"{100 * x.relative:.2g}"),
    Field("unit", "unknown.unit", head="unit", column="unit"),
    Field("verdict", lambda x: str(x.verdict), head="verdict", column="verdict"),
)
declare(Band, Field("low"), Field("high"), Field("chi2"))
declare(
    Shown,
    Field("test", head="test"),
    Field("output", head="output"),
    Field("input", head="input"),
    Field("fitted", "is_fitted", head="", text=lambda x: "fitted" if x.is_fitted else "predicted"),
    Field("before", head="median |dB| before", form=".2f"),
    Field("after", head="after", form=".2f"),
    Field("peaks_before", head="peaks % before", text=lambda x: _percent(x.peaks_before)),
    Field("peaks_after", head="after", text=lambda x: _percent(x.peaks_after)),
)
declare(
    Candidate,
    Field("test", "what", head="next test"),
    Field("fall", head="variance falls by", text=lambda x: f"{100 * x.fall:.0f} %"),
    Field("tells", head="tells", text=lambda x: ", ".join(x.tells) or "-"),
)
declare(
    Updated,
    Field("parameters", lambda x: {e.unknown.label: e for e in x.estimates}, rows=Found),
    Field("chi2", "fit.chi2"),
    Field("model", "verdict_on_model"),
    Field("bands"),
    Field("not_told", "untold"),
    Field("responses", "shown"),
    Field("notes"),
)


def _percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100 * share:.2f}"


@parts_of.register
def _(result: Updated) -> Sequence[Part]:
    """Return the verdict on the model, the table, what is not told apart, predicted tests, notes."""
    kept = [one for one in result.estimates if not one.unknown.is_nuisance]
    predicted = [one for one in result.shown if not one.is_fitted and one.input]
    tables: list[Part] = [table_of(Shown, result.shown, f"{result.machine.name}: responses", keys=3)]
    doubted = len(result.estimates) - len(kept)
    masses = (
        [f"{doubted} masses and inertias were doubted by {100 * result.settings.mass_doubt:g} %"] if doubted else []
    )
    seen = [_unseen(predicted)] if predicted else []
    return [
        result.verdict_on_model,
        table_of(Found, kept, f"{result.machine.name}: parameters"),
        *result.untold,
        *(tables if result.shown else []),
        *seen,
        *masses,
        *result.notes,
    ]


def _unseen(shown: Sequence[Shown]) -> str:
    """Return a sentence about tests that were only predicted."""
    before, after = (sum(getattr(one, name) for one in shown) / len(shown) for name in ("before", "after"))
    count = f"{len(shown)} response{'' if len(shown) == 1 else 's'}"
    return f"{count} that were not fitted: {after:.2g} dB off after the fit, {before:.2g} dB before"


def next_table(candidates: Sequence[Candidate], machine: str) -> Table:
    """Return the table of the next tests."""
    return table_of(Candidate, candidates, f"{machine}: the next test")
