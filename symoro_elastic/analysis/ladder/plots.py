"""Plots of a ladder: predicted and measured errors by rung, and operations."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from symoro_elastic.analysis.ladder.budget import Budget, Word
from symoro_elastic.analysis.ladder.climbed import Ladder
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.pictures import new_figure
from symoro_elastic.foundation.results import figures_of


@figures_of.register
def _(found: Ladder) -> dict[str, Any]:
    return {"rungs": rungs(found)} | ({"budget": budget(found.budget)} if found.budget else {})


@figures_of.register
def _(found: Budget) -> dict[str, Any]:
    return {"budget": budget(found)}


def budget(found: Budget) -> Any:
    """Draw operations of the motion against the sum of errors, a point for each step, and what was measured."""
    figure = new_figure(8.0, 5.0)
    axes = figure.add_subplot()
    worst = found.worst_output
    tolerance, unit = found.tolerance[worst], unit_of(found.machine, worst)
    operations = [step.steps.cost for step in found.path]
    axes.step([step.total[worst] for step in found.path], operations, where="post", color="0.8", zorder=0)
    for spent in dict.fromkeys(step.spent for step in found.path):
        points = [(step.total[worst], step.steps.cost) for step in found.path if step.spent is spent]
        axes.plot(*zip(*points, strict=True), "o", label=f"{spent}, {Word.PREDICTED}")
    axes.plot(found.measured.errors[worst], operations[-1], "kx", label=f"the last one, {Word.MEASURED}")
    axes.axvline(tolerance, linestyle="--", color="0.4", label="tolerance")
    if found.alone:
        axes.axhline(found.alone.cost, linestyle=":", color="0.4", label="springs alone")
    axes.set_xlim(0, 1.05 * max(tolerance, *(step.total[worst] for step in found.path)))
    axes.set_ylim(0, 1.05 * max(operations))
    axes.set_xlabel(f"error of {worst}, {unit}")
    axes.set_ylabel("operations of the motion")
    axes.legend()
    return figure


def rungs(found: Ladder) -> Any:
    """Draw the error of each rung, predicted as a line and measured as points, and the tolerance."""
    figure = new_figure(8.0, 5.0)
    axes = figure.add_subplot()
    worst = found.worst_output
    static = [rung for rung in found.rungs if not rung.locked]
    places = range(len(static))
    axes.semilogy(places, [rung.predicted[worst] or None for rung in static], "-", label="predicted")
    measured = [(k, rung.measured.model[worst]) for k, rung in enumerate(static) if rung.measured and rung.left_out]
    if measured:
        axes.semilogy(*zip(*measured, strict=True), "o", label="measured")
    axes.axhline(found.tolerance[worst], linestyle="--", color="0.4", label="tolerance")
    if found.chosen is not None and found.chosen < len(static):
        axes.axvline(found.chosen, color="0.8", zorder=0, label="chosen")
    new = [next(iter({*rung.left_out} - {*before.left_out}), "") for before, rung in pairwise(static)]
    axes.set_xticks(list(places), ["none", *(f"+ {name}" for name in new)], rotation=45, ha="right")
    axes.set_ylabel(f"error of {worst}, {unit_of(found.machine, worst)}")
    axes.set_xlabel("springs left out")
    axes.legend()
    return figure
