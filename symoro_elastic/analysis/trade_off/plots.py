"""Plots of time against worst error of every configuration, and the front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

from symoro_elastic.analysis.trade_off.configurations import BATCH, Measurement, front
from symoro_elastic.analysis.trade_off.guaranteed import GuaranteedCurve
from symoro_elastic.analysis.trade_off.trade import Trade
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, legend, logarithmic, marker, shades
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.numerics.verification.accuracy import LEAST_ERROR

PRECISIONS = ("double", "single", "mixed", "double-double")
"""In the order of their colours and markers."""
LEAST_DRAWN = LEAST_ERROR * 2.0**-53


@figures_of.register
def pictures(trade: Trade, with_fast_math: bool = False) -> dict[str, Plot | str]:
    """Return errors over time, errors over operations for each model, and what is guaranteed."""
    plots: dict[str, Plot | str] = {}
    for model, measured in trade.measurements.items():
        for what in ("time", "operations"):
            title = f"{trade.machine.name}: worst error over {what} of {model}"
            draw = partial(_picture, measured, with_fast_math, what)
            plots[f"{model}_error_over_{what}"] = Plot(title, draw, size=(8.5, 5.0))
    return plots | {f"{x.model}_guaranteed": _of_curve(x) for x in trade.curves}


@figures_of.register
def _(result: GuaranteedCurve) -> dict[str, Plot | str]:
    return {f"{result.model}_guaranteed": _of_curve(result)}


def _of_curve(result: GuaranteedCurve) -> Plot:
    return Plot(f"{result.model} within {result.within}", partial(_draw_curve, result), size=(8.5, 5.0))


def _draw_curve(result: GuaranteedCurve, axis: Any) -> None:
    """Draw operations against guaranteed error, colours by precision, and the path."""
    path = [result.points[k] for k in result.path]
    times, totals = [x.time for x in path], [x.total for x in path]
    axis.step(totals, times, where="post", color=shades().grey, zorder=1)
    for k, precision in enumerate(PRECISIONS):
        some = [x for x in result.points if x.precision == precision and 0 < x.total < math.inf]
        if some:
            look = {"color": curve(k)["color"], "marker": marker(k), "s": 26}
            axis.scatter([x.total for x in some], [x.time for x in some], label=precision, **look)
    advised = result.advised
    if advised.unseen:
        axis.scatter(advised.unseen, advised.time, marker="x", color=shades().ink, label="advised, unseen states")
    axis.axvline(1.0, linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    logarithmic(axis, "x")
    axis.set_ylim(bottom=0)
    axis.set_xlabel("guaranteed error, of the tolerance")
    axis.set_ylabel("time of a call, operations in double precision")
    legend(axis)


def _picture(measured: Sequence[Measurement], with_fast_math: bool, what: str, axis: Any) -> None:
    """Draw worst errors over what they cost: colours by precision, full for batches, hollow for single calls."""
    if what == "time":
        on_front = front(measured, with_fast_math)
        line = {"where": "post", "color": shades().grey, "zorder": 1, "label": "best"}
        axis.step([f.ns for f in on_front], [_visible_error(f) for f in on_front], **line)
    for k, precision in enumerate(PRECISIONS):
        some = [f for f in measured if f.configuration.precision.name == precision and math.isfinite(f.error)]
        for j, m in enumerate(some):
            cost = m.ns if what == "time" else m.count.products + m.count.add
            axis.scatter(cost, _visible_error(m), label=precision if j == 0 else None, zorder=2, **_look(m, k))
    logarithmic(axis, "x", "y")
    axis.set_xlabel("time of a state, ns" if what == "time" else "operations of a call")
    axis.set_ylabel("worst error, relative to the largest entry")
    legend(axis, "full: batch\nhollow: single call\nsmall: numpy\ncross: -ffast-math")


def _visible_error(measurement: Measurement) -> float:
    """The error on a logarithmic scale, which has no zero."""
    return max(measurement.error, LEAST_DRAWN)


def _look(measurement: Measurement, k: int) -> dict[str, Any]:
    if not measurement.configuration.is_safe:
        return {"marker": "x", "color": shades().bad, "s": 30}
    colour, size = curve(k)["color"], 30 if measurement.configuration.build else 10
    full = colour if measurement.configuration.call == BATCH else "none"
    return {"marker": marker(k), "facecolors": full, "edgecolors": colour, "s": size}
