"""What an update found, as text, as columns and as data for JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symoro_elastic.foundation.results import Field, Part, declare, parts_of, table_of
from symoro_elastic.measured.fitting.estimates import Estimate
from symoro_elastic.measured.vibration_tests.diagnostics import Band
from symoro_elastic.measured.vibration_tests.next_tests import Candidate
from symoro_elastic.measured.vibration_tests.updated import Shown, Updated

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
    Field("estimates", lambda x: {e.unknown.label: e for e in x.estimates}, rows=Estimate),
    Field("chi2", "fit.chi2"),
    Field("model", "verdict_on_model"),
    Field("bands"),
    Field("undetermined"),
    Field("responses", "shown"),
    Field("notes"),
)


def _percent(share: float) -> str:
    return "-" if math.isnan(share) else f"{100 * share:.2f}"


@parts_of.register
def _(result: Updated) -> Sequence[Part]:
    """Return the verdict on the model, and tables of estimates, undetermined directions, tests, notes."""
    reported = [entry for entry in result.estimates if not entry.unknown.is_nuisance]
    predicted = [entry for entry in result.shown if not entry.is_fitted and entry.input]
    tables: list[Part] = [table_of(Shown, result.shown, f"{result.machine.name}: responses", keys=3)]
    doubted = len(result.estimates) - len(reported)
    masses = (
        [f"{doubted} masses and inertias had a prior standard deviation of {100 * result.settings.mass_doubt:g} %"]
        if doubted
        else []
    )
    sentences = [_unseen(predicted)] if predicted else []
    return [
        result.verdict_on_model,
        table_of(Estimate, reported, f"{result.machine.name}: parameters"),
        *result.undetermined,
        *(tables if result.shown else []),
        *sentences,
        *masses,
        *result.notes,
    ]


def _unseen(shown: Sequence[Shown]) -> str:
    """Return a sentence about tests that were predicted and not fitted."""
    before, after = (sum(getattr(response, name) for response in shown) / len(shown) for name in ("before", "after"))
    count = f"{len(shown)} response{'' if len(shown) == 1 else 's'}"
    return f"{count} that were not fitted: {after:.2g} dB off after the fit, {before:.2g} dB before"
