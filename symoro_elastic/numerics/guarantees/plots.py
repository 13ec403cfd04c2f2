"""Plots of certificates: guaranteed errors of the entries of results."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import dots, legend
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.numerics.evaluation.quantile_bound import CONFIDENCE
from symoro_elastic.numerics.guarantees.certificate import Certificate
from symoro_elastic.numerics.guarantees.certificates import Certificates

MOST_ENTRIES = 60


@figures_of.register
def _(found: Certificate) -> dict[str, Plot | str]:
    """Return the plot of proven and confident error bounds of the entries, at most 60."""
    count = min(MOST_ENTRIES, len(found.entries))
    title = f"{found.machine}: guaranteed error of {found.model}, {found.precision}"
    title += f"; {count} of {len(found.entries)} entries" if count < len(found.entries) else ""
    return {"errors": Plot(title, partial(_errors, found), size=(8.0, 1.6 + 0.22 * count))}


@figures_of.register
def _(found: Certificates) -> dict[str, Plot | str]:
    """Return the error plots of all certificates, by the names errors_<model>_<precision>."""
    plots = {f"errors_{x.model}_{x.precision}": figures_of(x)["errors"] for x in found.certificates}
    return plots or {"errors": "there is no certificate"}


def _errors(found: Certificate, axes: Any) -> None:
    shown = found.entries[:MOST_ENTRIES]
    likely = f"with {CONFIDENCE:.0%} confidence"
    errors = {"proven": [entry.error for entry in shown], likely: [entry.likely for entry in shown]}
    dots(axes, errors, [f"{entry.name} {entry.entry}".strip() for entry in shown])
    axes.set_xlabel("error, in units of the result")
    legend(axes)
