"""Plots of an update: measured responses with coherence, the model before and after; standard deviations."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from symoro_elastic.analysis.updating.measured import MeasuredResponse
from symoro_elastic.analysis.updating.updated import Updated
from symoro_elastic.foundation.array_types import ComplexArray
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of

DARK, LIGHT, MEASURED = "#14365d", "#9aa5b1", "#e3b261"


@figures_of.register
def _(result: Updated) -> dict[str, Any]:
    """Return test<k>_<output>_<input> for each response."""
    figures = {}
    for t, (test, old, new) in enumerate(zip((*result.tests, *result.unseen), *result.predictions, strict=True)):
        for one, before, after in zip(test.responses, old.responses, new.responses, strict=True):
            label = re.sub(r"\W+", "_", f"test{t + 1}_{one.output}_{one.input}").strip("_")
            kind = "fitted" if t < len(result.tests) else "predicted"
            at = ", ".join(f"{name} at {x:g}" for name, x in test.at.items())
            title = f"{test.name}: {one.output} by {one.input}{f', {at}' if at else ''} ({kind})"
            figures[label] = response(one, before.G, after.G, title, result.settings.without)
    return figures


def response(
    measured: MeasuredResponse, before: ComplexArray, after: ComplexArray, title: str,
    without: tuple[tuple[float, float], ...] = (),
) -> Any:  # fmt: skip
    """Return magnitude and phase over the frequency: dots measured, a thin line before, a thick one after the fit."""
    has_coherence = measured.coherence is not None
    figure = new_figure(8.0, 6.0 if has_coherence else 5.0)
    heights = [3, 1.5, 0.8] if has_coherence else [3, 1.5]
    magnitude, phase, *rest = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    f = measured.f
    for axis, of in ((magnitude, np.abs), (phase, lambda H: np.degrees(np.angle(H)))):
        axis.plot(f, of(measured.H), ".", color=MEASURED, markersize=2.5, label="measured")
        axis.plot(f, of(before), color=LIGHT, linewidth=0.8, label="before")
        axis.plot(f, of(after), color=DARK, linewidth=1.0, label="after")
    if measured.coherence is not None:
        rest[0].fill_between(f, measured.coherence, color=LIGHT, alpha=0.4, linewidth=0)
        rest[0].set_ylim(0, 1.05)
        rest[0].set_ylabel("coherence")
    magnitude.set_xscale("log")
    magnitude.set_yscale("log")
    magnitude.set_ylabel(f"|{measured.output} / {measured.input}|, SI")
    magnitude.legend(fontsize="x-small")
    phase.set_ylabel("phase, deg")
    for axis in (magnitude, phase, *rest):
        axis.grid(True, which="both", linewidth=0.3)
        for low, high in without:
            axis.axvspan(low, high, color=LIGHT, alpha=0.15, linewidth=0)
    (rest[0] if rest else phase).set_xlabel("frequency, Hz")
    magnitude.set_title(title, fontsize="small")
    return figure
