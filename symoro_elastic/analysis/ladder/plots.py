"""Plots of a ladder: predicted and measured errors by rung, and operations."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

from symoro_elastic.analysis.ladder.feed_forward import FeedForward
from symoro_elastic.analysis.ladder.reduced import Reduced
from symoro_elastic.analysis.ladder.rung import Budget
from symoro_elastic.analysis.ladder.rungs import Ladder
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, legend, logarithmic, marker, shades, shorten, y_label
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.machine.within import Evidence

MOST_TICKS = 40


@figures_of.register
def _(ladder: Ladder) -> dict[str, Plot | str]:
    """Return rungs, operations, and budget where a tolerance was expense on one path."""
    title = f"{ladder.machine.name}: error with springs left out"
    count = min(MOST_TICKS, len(ladder.rungs))
    drawn: dict[str, Plot | str] = {
        "rungs": Plot(title, partial(_rungs, ladder), size=(max(8.0, 3.0 + 0.25 * count), 5.0))
    }
    costs = f"{ladder.machine.name}: errors of rungs over operations of the motion"
    drawn["operations"] = Plot(costs, partial(_operations, ladder), size=(8.0, 5.0))
    return drawn | (_of_budget(ladder.budget) if ladder.budget else {})


@figures_of.register
def _(budget: Budget) -> dict[str, Plot | str]:
    return dict(_of_budget(budget))


@figures_of.register
def _(result: Reduced) -> dict[str, Plot | str]:
    """Return operations over error for each purpose."""
    budget = result.simulation.budget if result.simulation else None
    drawn: dict[str, Plot | str] = dict(_of_budget(budget)) if budget else {}
    if result.feed_forward:
        title = f"{result.machine.name}: operations of the inverse model over the error"
        drawn["feed_forward"] = Plot(title, partial(_feed_forward, result, result.feed_forward), size=(8.0, 5.0))
    return drawn


def _feed_forward(result: Reduced, feed: FeedForward, axes: Any) -> None:
    """Draw operations of a call against the predicted errors of the inverse models, and the measured error."""
    worst = max(result.tolerance, key=lambda name: max(x.predicted[name] for x in feed.tried) / result.tolerance[name])
    shown = [x for x in feed.tried if x.predicted[worst] > 0]
    axes.axhline(feed.full, linestyle=":", color=shades().ink, linewidth=0.9, label="full model")
    points = [(x.predicted[worst], x.operations) for x in shown]
    look = {"linestyle": "", "marker": "o", "color": curve(0)["color"]}
    axes.plot(*zip(*points, strict=True), label=str(Evidence.PREDICTED), **look)
    if feed.chosen and feed.chosen.measured:
        place = feed.chosen.measured[worst], feed.chosen.operations
        axes.plot(*place, "x", color=shades().ink, markersize=8, label=f"advised, {Evidence.MEASURED}")
    axes.axvline(result.tolerance[worst], linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    logarithmic(axes, "x")
    axes.set_ylim(0, 1.1 * feed.full)
    axes.set_xlabel(f"error of {shorten(worst)}, {unit_of(result.machine, worst)}")
    axes.set_ylabel("operations of a call")
    legend(axes)


def _of_budget(budget: Budget) -> dict[str, Plot]:
    title = f"{budget.machine.name}: operations of the motion over the error"
    return {"budget": Plot(title, partial(_budget, budget), size=(8.0, 5.0))}


def _budget(budget: Budget, axes: Any) -> None:
    """Draw operations of the motion against the sum of errors, a point per step, and the measured error."""
    worst = budget.worst_output
    tolerance, unit = budget.tolerance[worst], unit_of(budget.machine, worst)
    operations = [step.steps.cost for step in budget.path]
    axes.step([step.total[worst] for step in budget.path], operations, where="post", color=shades().grey, zorder=1)
    for k, expense in enumerate(dict.fromkeys(step.expense for step in budget.path)):
        points = [(step.total[worst], step.steps.cost) for step in budget.path if step.expense is expense]
        look = {"linestyle": "", "marker": marker(k), "color": curve(k)["color"]}
        axes.plot(*zip(*points, strict=True), label=f"{expense}, {Evidence.PREDICTED}", **look)
    said = f"the last one, {Evidence.MEASURED}"
    axes.plot(budget.measured.errors[worst], operations[-1], "x", color=shades().ink, markersize=8, label=said)
    axes.axvline(tolerance, linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    if budget.alone:
        axes.axhline(budget.alone.cost, linestyle=":", color=shades().ink, linewidth=0.9, label="springs alone")
    axes.set_xlim(0, 1.05 * max(tolerance, *(step.total[worst] for step in budget.path)))
    axes.set_ylim(0, 1.05 * max(operations))
    axes.set_xlabel(f"error of {shorten(worst)}, {unit}")
    axes.set_ylabel("operations of the motion")
    legend(axes)


def _operations(ladder: Ladder, axes: Any) -> None:
    """Draw predicted errors, of model and steps, of the rungs with sufficient steps over operations."""
    worst = ladder.worst_output
    stepped = [(k, rung, rung.chosen) for k, rung in enumerate(ladder.rungs) if rung.chosen]
    for j, locked in enumerate((False, True)):
        points = [(s.cost, r.predicted[worst] + s.predicted[worst]) for _, r, s in stepped if r.locked is locked]
        if points:
            look = {"linestyle": "", "marker": marker(j), "color": curve(j)["color"]}
            axes.plot(*zip(*points, strict=True), label="springs held" if locked else "springs static", **look)
    for k, rung, steps in stepped:
        if k == ladder.chosen:
            place = (steps.cost, rung.predicted[worst] + steps.predicted[worst])
            axes.plot(*place, "o", markersize=12, fillstyle="none", color=shades().ink, label="chosen")
    axes.axhline(ladder.tolerance[worst], linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    logarithmic(axes, "x", "y")
    axes.set_xlabel("operations of the motion")
    y_label(axes, f"error of {shorten(worst)}", unit_of(ladder.machine, worst))
    legend(axes)


def _rungs(ladder: Ladder, axes: Any) -> None:
    """Draw the errors of rungs, predicted as a line and measured as points, and the tolerance."""
    worst = ladder.worst_output
    static = [rung for rung in ladder.rungs if not rung.locked]
    places = [*range(len(static))]
    axes.plot(places, [rung.predicted[worst] or None for rung in static], label="predicted", **curve(0))
    measured = [(k, rung.measured.model[worst]) for k, rung in enumerate(static) if rung.measured and rung.left_out]
    if measured:
        look = {"linestyle": "", "marker": "o", "color": curve(1)["color"]}
        axes.plot(*zip(*measured, strict=True), label="measured", **look)
    axes.axhline(ladder.tolerance[worst], linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    if ladder.chosen is not None and ladder.chosen < len(static):
        axes.axvline(ladder.chosen, color=shades().grey, linewidth=3, alpha=0.5, zorder=1, label="chosen")
    new = [next(iter({*rung.left_out} - {*before.left_out}), "") for before, rung in pairwise(static)]
    every = 1 + len(static) // MOST_TICKS
    ticks = ["none", *(f"+ {shorten(name)}" for name in new)]
    look = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
    logarithmic(axes, "y")
    axes.set_xticks(places[::every], ticks[::every], **look)
    y_label(axes, f"error of {shorten(worst)}", unit_of(ladder.machine, worst))
    axes.set_xlabel("springs left out")
    legend(axes)
