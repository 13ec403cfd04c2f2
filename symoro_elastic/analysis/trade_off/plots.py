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
    found: dict[str, Plot | str] = {}
    for model, measured in trade.measurements.items():
        for what in ("time", "operations"):
            title = f"{trade.machine.name}: worst error over {what} of {model}"
            draw = partial(_picture, measured, with_fast_math, what)
            found[f"{model}_error_over_{what}"] = Plot(title, draw, size=(8.5, 5.0))
    return found | {f"{each.model}_guaranteed": _of_curve(each) for each in trade.curves}


@figures_of.register
def _(found: GuaranteedCurve) -> dict[str, Plot | str]:
    return {f"{found.model}_guaranteed": _of_curve(found)}


def _of_curve(found: GuaranteedCurve) -> Plot:
    return Plot(f"{found.model} within {found.within}", partial(_guaranteed, found), size=(8.5, 5.0))


def _guaranteed(found: GuaranteedCurve, axis: Any) -> None:
    """Draw operations against guaranteed error, colours by precision, and the path."""
    path = [found.points[k] for k in found.path]
    times, totals = [one.time for one in path], [one.total for one in path]
    axis.step(totals, times, where="post", color=shades().grey, zorder=1)
    for k, precision in enumerate(PRECISIONS):
        some = [one for one in found.points if one.precision == precision and 0 < one.total < math.inf]
        if some:
            look = {"color": curve(k)["color"], "marker": marker(k), "s": 26}
            axis.scatter([one.total for one in some], [one.time for one in some], label=precision, **look)
    advised = found.advised
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
        axis.step([f.ns for f in on_front], [_drawn(f) for f in on_front], **line)
    for k, precision in enumerate(PRECISIONS):
        some = [f for f in measured if f.configuration.precision.name == precision and math.isfinite(f.error)]
        for j, one in enumerate(some):
            axis.scatter(_cost(one, what), _drawn(one), label=precision if j == 0 else None, zorder=2, **_look(one, k))
    logarithmic(axis, "x", "y")
    axis.set_xlabel("time of a state, ns" if what == "time" else "operations of a call")
    axis.set_ylabel("worst error, relative to the largest entry")
    legend(axis, "full: batch\nhollow: single call\nsmall: numpy\ncross: -ffast-math")


def _cost(one: Measurement, what: str) -> float:
    return one.ns if what == "time" else one.count.products + one.count.add


def _drawn(one: Measurement) -> float:
    """The error on a logarithmic scale, which has no zero."""
    return max(one.error, LEAST_DRAWN)


def _look(one: Measurement, k: int) -> dict[str, Any]:
    if not one.configuration.is_safe:
        return {"marker": "x", "color": shades().bad, "s": 30}
    colour, size = curve(k)["color"], 30 if one.configuration.build else 10
    full = colour if one.configuration.call == BATCH else "none"
    return {"marker": marker(k), "facecolors": full, "edgecolors": colour, "s": size}
