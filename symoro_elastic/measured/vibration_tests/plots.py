"""Plots of an update: measured responses with coherence, the model before and after."""

from __future__ import annotations

import re
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.responses import quotient_unit
from symoro_elastic.foundation.array_types import ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, legend, logarithmic, shades, y_label
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.vibration_tests.measured import MeasuredResponse
from symoro_elastic.measured.vibration_tests.updated import Updated
from symoro_elastic.numerics.motion.signals import input_unit, output_unit

Windows = tuple[tuple[float, float], ...]


@figures_of.register
def _(result: Updated) -> dict[str, Plot | str]:
    """Return test<k>_<output>_<input> for each response."""
    figures: dict[str, Plot | str] = {}
    for t, (test, old, new) in enumerate(zip((*result.tests, *result.unseen), *result.predictions, strict=True)):
        for one, before, after in zip(test.responses, old.responses, new.responses, strict=True):
            label = re.sub(r"\W+", "_", f"test{t + 1}_{one.output}_{one.input}").strip("_")
            kind = "fitted" if t < len(result.tests) else "predicted"
            at = "".join(f", {name} at {x:g}" for name, x in test.at.items())
            title = f"{result.machine.name}: {test.name}, {one.output} by {one.input}{at} ({kind})"
            ratios = (3.0, 1.5, 0.8) if one.coherence is not None else (3.0, 1.5)
            unit = _unit(result.machine, one)
            draw = partial(_response, one, unit, before.G, after.G, result.settings.without)
            figures[label] = Plot(title, draw, len(ratios), size=(8.0, 3.5 + len(ratios)), ratios=ratios)
    return figures


def _unit(machine: Machine, response: MeasuredResponse) -> str:
    """The unit of a response, such as m/s2 / N; that of a set point is that of its joint."""
    try:
        return quotient_unit(output_unit(machine, response.output), input_unit(machine, response.input))
    except InputError:
        return "SI units"


def _response(
    measured: MeasuredResponse, unit: str, before: ComplexArray, after: ComplexArray, without: Windows, *axes: Any
) -> None:
    """Draw magnitude, phase and coherence: dots measured, a grey line before, a dark one after the fit.

    Phases are those that are nearest to the ones after the fit.
    """
    f, (magnitude, phase, *rest) = measured.f, axes
    reached = np.unwrap(np.angle(after))
    for axis, of in ((magnitude, np.abs), (phase, lambda H: np.degrees(reached + np.angle(H * np.conj(after))))):
        axis.plot(f, of(measured.H), ".", color=curve(1)["color"], markersize=2.5, label="measured")
        axis.plot(f, of(before), color=shades().grey, linewidth=0.9, label="before")
        axis.plot(f, of(after), color=curve(0)["color"], linewidth=1.0, label="after")
    for coherence in rest:
        coherence.fill_between(f, measured.coherence, color=shades().grey, alpha=0.4, linewidth=0)
        coherence.set_ylim(0, 1.05)
        y_label(coherence, "coherence")
    logarithmic(magnitude, "y")
    y_label(magnitude, "magnitude", unit)
    y_label(phase, "phase", "deg")
    legend(magnitude)
    for axis in axes:
        logarithmic(axis, "x")
        for low, high in without:
            axis.axvspan(low, high, color=shades().grey, alpha=0.15, linewidth=0)
    axes[-1].set_xlabel("frequency, Hz")
