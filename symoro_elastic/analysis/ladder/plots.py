"""Plots of a ladder: predicted and measured errors by rung, and operations."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

from symoro_elastic.analysis.ladder.budget import Budget, Word
from symoro_elastic.analysis.ladder.climbed import Ladder
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import curve, legend, logarithmic, marker, shades, shortened, y_label
from symoro_elastic.foundation.results import figures_of

MOST_TICKS = 40


@figures_of.register
def _(found: Ladder) -> dict[str, Plot | str]:
    """Return rungs, operations, and budget where a tolerance was spent on one path."""
    title = f"{found.machine.name}: error with springs left out"
    count = min(MOST_TICKS, len(found.rungs))
    drawn: dict[str, Plot | str] = {
        "rungs": Plot(title, partial(_rungs, found), size=(max(8.0, 3.0 + 0.25 * count), 5.0))
    }
    costs = f"{found.machine.name}: error of each rung over operations of the motion"
    drawn["operations"] = Plot(costs, partial(_operations, found), size=(8.0, 5.0))
    return drawn | (_of_budget(found.budget) if found.budget else {})


@figures_of.register
def _(found: Budget) -> dict[str, Plot | str]:
    return dict(_of_budget(found))


def _of_budget(found: Budget) -> dict[str, Plot]:
    title = f"{found.machine.name}: operations of the motion over the error"
    return {"budget": Plot(title, partial(_budget, found), size=(8.0, 5.0))}


def _budget(found: Budget, axes: Any) -> None:
    """Draw operations of the motion against the sum of errors, a point for each step, and what was measured."""
    worst = found.worst_output
    tolerance, unit = found.tolerance[worst], unit_of(found.machine, worst)
    operations = [step.steps.cost for step in found.path]
    axes.step([step.total[worst] for step in found.path], operations, where="post", color=shades().grey, zorder=1)
    for k, spent in enumerate(dict.fromkeys(step.spent for step in found.path)):
        points = [(step.total[worst], step.steps.cost) for step in found.path if step.spent is spent]
        look = {"linestyle": "", "marker": marker(k), "color": curve(k)["color"]}
        axes.plot(*zip(*points, strict=True), label=f"{spent}, {Word.PREDICTED}", **look)
    said = f"the last one, {Word.MEASURED}"
    axes.plot(found.measured.errors[worst], operations[-1], "x", color=shades().ink, markersize=8, label=said)
    axes.axvline(tolerance, linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    if found.alone:
        axes.axhline(found.alone.cost, linestyle=":", color=shades().ink, linewidth=0.9, label="springs alone")
    axes.set_xlim(0, 1.05 * max(tolerance, *(step.total[worst] for step in found.path)))
    axes.set_ylim(0, 1.05 * max(operations))
    axes.set_xlabel(f"error of {shortened(worst)}, {unit}")
    axes.set_ylabel("operations of the motion")
    legend(axes)


def _operations(found: Ladder, axes: Any) -> None:
    """Draw predicted errors, of model and steps, of the rungs with sufficient steps over operations."""
    worst = found.worst_output
    stepped = [(k, rung, rung.chosen) for k, rung in enumerate(found.rungs) if rung.chosen]
    for j, locked in enumerate((False, True)):
        points = [(s.cost, r.predicted[worst] + s.predicted[worst]) for _, r, s in stepped if r.locked is locked]
        if points:
            look = {"linestyle": "", "marker": marker(j), "color": curve(j)["color"]}
            axes.plot(*zip(*points, strict=True), label="springs held" if locked else "springs static", **look)
    for k, rung, steps in stepped:
        if k == found.chosen:
            place = (steps.cost, rung.predicted[worst] + steps.predicted[worst])
            axes.plot(*place, "o", markersize=12, fillstyle="none", color=shades().ink, label="chosen")
    axes.axhline(found.tolerance[worst], linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    logarithmic(axes, "x", "y")
    axes.set_xlabel("operations of the motion")
    y_label(axes, f"error of {shortened(worst)}", unit_of(found.machine, worst))
    legend(axes)


def _rungs(found: Ladder, axes: Any) -> None:
    """Draw the error of each rung, predicted as a line and measured as points, and the tolerance."""
    worst = found.worst_output
    static = [rung for rung in found.rungs if not rung.locked]
    places = [*range(len(static))]
    axes.plot(places, [rung.predicted[worst] or None for rung in static], label="predicted", **curve(0))
    measured = [(k, rung.measured.model[worst]) for k, rung in enumerate(static) if rung.measured and rung.left_out]
    if measured:
        look = {"linestyle": "", "marker": "o", "color": curve(1)["color"]}
        axes.plot(*zip(*measured, strict=True), label="measured", **look)
    axes.axhline(found.tolerance[worst], linestyle="--", color=shades().ink, linewidth=0.9, label="tolerance")
    if found.chosen is not None and found.chosen < len(static):
        axes.axvline(found.chosen, color=shades().grey, linewidth=3, alpha=0.5, zorder=1, label="chosen")
    new = [next(iter({*rung.left_out} - {*before.left_out}), "") for before, rung in pairwise(static)]
    every = 1 + len(static) // MOST_TICKS
    ticks = ["none", *(f"+ {shortened(name)}" for name in new)]
    look = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
    logarithmic(axes, "y")
    axes.set_xticks(places[::every], ticks[::every], **look)
    y_label(axes, f"error of {shortened(worst)}", unit_of(found.machine, worst))
    axes.set_xlabel("springs left out")
    legend(axes)
