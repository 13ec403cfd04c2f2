"""Plots of time against worst error of every configuration, and the front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from symoro_elastic.analysis.trade_off.configurations import BATCH, Measurement, front
from symoro_elastic.analysis.trade_off.guaranteed import GuaranteedCurve
from symoro_elastic.analysis.trade_off.trade import Trade
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.numerics.verification.accuracy import LEAST_ERROR

PRECISION_COLOURS = {"double": "#14365d", "single": "#d98e04", "mixed": "#2a7f62", "double-double": "#8b2f6b"}
LEAST_DRAWN = LEAST_ERROR * 2.0**-53
UNSAFE, FRONT_COLOUR = "#c0392b", "#9aa5b1"


@figures_of.register
def pictures(trade: Trade, with_fast_math: bool = False) -> dict[str, Any]:
    """Return a figure for each model."""
    return {
        model: picture(f"{trade.machine.name}: {model}", measurements, with_fast_math)
        for model, measurements in trade.measurements.items()
    } | {f"{curve.model}_guaranteed": curve_picture(curve) for curve in trade.curves}


@figures_of.register
def _(curve: GuaranteedCurve) -> dict[str, Any]:
    return {f"{curve.model}_guaranteed": curve_picture(curve)}


def curve_picture(curve: GuaranteedCurve) -> Any:
    """Return a figure: operations against guaranteed error, colours by precision, and the path."""
    figure = new_figure(8.0, 5.0)
    axis = figure.add_subplot()
    path = [curve.points[k] for k in curve.path]
    axis.step([one.total for one in path], [one.time for one in path], where="post", color=FRONT_COLOUR, zorder=1)
    for precision, colour in PRECISION_COLOURS.items():
        some = [one for one in curve.points if one.precision == precision and 0 < one.total < math.inf]
        if some:
            axis.scatter([one.total for one in some], [one.time for one in some], color=colour, label=precision)
    advised = curve.advised
    if advised.unseen:
        axis.scatter(advised.unseen, advised.time, marker="x", color="k", label="terms of the advised, unseen states")
    axis.axvline(1.0, linestyle="--", color="0.4", label="tolerance")
    axis.set_xscale("log")
    axis.set_ylim(bottom=0)
    axis.set_xlabel("guaranteed error, of the tolerance")
    axis.set_ylabel("time of a call, operations in double precision")
    axis.set_title(f"{curve.model} within {curve.within}")
    axis.legend(fontsize="small", frameon=False)
    return figure


def picture(title: str, measurements: Sequence[Measurement], with_fast_math: bool = False) -> Any:
    """Return a figure: colours by precision, full for batches, hollow for single calls, squares for numpy."""
    figure = new_figure(8.0, 5.0)
    axis = figure.add_subplot()
    on_front = front(measurements, with_fast_math)
    axis.step([f.ns for f in on_front], [_drawn(f) for f in on_front], where="post", color=FRONT_COLOUR, zorder=1)
    for precision, colour in PRECISION_COLOURS.items():
        some = [f for f in measurements if f.configuration.precision.name == precision and math.isfinite(f.error)]
        for k, one in enumerate(some):
            axis.scatter(one.ns, _drawn(one), label=precision if k == 0 else None, zorder=2, **_style(one, colour))
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("ns a state")
    axis.set_ylabel("worst error, relative to the largest entry")
    axis.set_title(title)
    axis.legend(
        fontsize="small", frameon=False, title="full: batch, hollow: single call\nsquare: numpy, cross: -ffast-math"
    )
    return figure


def _drawn(one: Measurement) -> float:
    """The error on a logarithmic scale, which has no zero."""
    return max(one.error, LEAST_DRAWN)


def _style(one: Measurement, colour: str) -> dict[str, Any]:
    if not one.configuration.is_safe:
        return {"marker": "x", "color": UNSAFE, "s": 30}
    full = colour if one.configuration.call == BATCH else "none"
    return {"marker": "o" if one.configuration.build else "s", "facecolors": full, "edgecolors": colour, "s": 30}
