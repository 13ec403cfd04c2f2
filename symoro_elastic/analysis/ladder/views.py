"""The ladder as tables, as data for JSON, and as sentences of advice."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import groupby
from typing import Any

from symoro_elastic.analysis.ladder.feed_forward import FeedForward
from symoro_elastic.analysis.ladder.greedy import SpringFigures
from symoro_elastic.analysis.ladder.reduced import ProcessorCosts, Reduced
from symoro_elastic.analysis.ladder.rung import (
    MODEL_SHARE,
    Budget,
    Expense,
    MeasuredEnd,
    PathStep,
    Rung,
    Steps,
    springs_text,
)
from symoro_elastic.analysis.ladder.rungs import Ladder
from symoro_elastic.analysis.ladder.torque_tolerances import TorqueTolerance
from symoro_elastic.analysis.simulation.periods import period_line, quantity
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.errors import some_of
from symoro_elastic.foundation.results import Field, Part, Table, columns_of, declare, parts_of, table_of
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.within import Evidence

ARITHMETIC_SHARE = 0.05
"""Of a tolerance that arithmetic may take."""
LEAST_SAVING = 1.05
"""Operations of the full machine with RK4 over those of a rung, from which they are reported."""
EACH_SPRING = "springs one by one, which does not show their cost together"

declare(Steps, *map(Field, ("method", "steps", "operations")))
declare(
    SpringFigures,
    Field("name", head="spring"),
    Field("alone", head="error if quasi-static alone, x tolerance", form=".2g"),
    Field("activity", head="activity", text=lambda x: quantity(x.activity, "J")),
    Field("frequency", head="natural frequency, all else locked", text=lambda x: quantity(x.frequency, "Hz")),
)
MOST_NAMED = 4
EXACT_COUNTS = 10_000
"""Numbers of operations from which three digits are printed."""
NAMES = "--json lists the lags and dead times that are left out"
EVIDENCE_LINE = "errors are predicted by the linear model along the motion, not proven; the last model is simulated"


@parts_of.register
def _(ladder: Ladder) -> list[Part]:
    springs = [springs_table(ladder)] if ladder.springs else []
    lines = [*ladder.condensed, advice(ladder), arithmetic_line(ladder)]
    budget = budget_parts(ladder.budget) if ladder.budget else []
    return [ladder_table(ladder, ladder.headline), *springs, *filter(None, lines), *budget]


@columns_of.register
def _(ladder: Ladder) -> dict[str, list[Any]]:
    """Return columns with a row per rung, as in JSON."""
    rungs = ladder.as_json()["rungs"]
    return {key: [rung[key] for rung in rungs] for key in rungs[0]}


def ladder_table(ladder: Ladder, title: str = "") -> Table:
    """Return a row per rung: the newly omitted springs, errors, steps, cost against the full machine with RK4."""
    worst = ladder.worst_output
    unit = unit_of(ladder.machine, worst)
    heads = "left out", f"predicted ({worst})", "measured", "method", "step", "time", "against full", ""
    table = Table(heads, title=title)
    before: set[str] = set()
    for k, rung in enumerate(ladder.rungs):
        measured = rung.measured.model[worst] if rung.measured else None
        table.add_row(
            _name(rung, before),
            quantity(rung.predicted[worst], unit),
            "-" if measured is None else quantity(measured, unit),
            rung.chosen.method if rung.chosen else "-",
            quantity(ladder.step_of(rung), "s") if rung.chosen else "-",
            quantity(rung.measured.seconds * rung.chosen.steps, "s") if rung.measured and rung.chosen else "-",
            f"{ladder.full.cost / rung.chosen.cost:.3g}" if rung.chosen else "-",
            _verdict(ladder, k),
        )
        before = set(rung.left_out)
    return table


def springs_table(ladder: Ladder) -> Table:
    """Return a row per spring: its error alone, its activity and its frequency."""
    return table_of(SpringFigures, ladder.springs, EACH_SPRING)


def _within(machine: Machine, tolerance: Mapping[str, float]) -> str:
    return ", ".join(f"{name} within {quantity(x, unit_of(machine, name))}" for name, x in tolerance.items())


def advice(ladder: Ladder) -> str:
    """Return a sentence: the springs to keep, those that may be quasi-static, and the steps."""
    within = _within(ladder.machine, ladder.tolerance)
    if ladder.chosen is None:
        nearest = min(ladder.rungs, key=lambda rung: relative(rung.predicted, ladder.tolerance))
        what = f"{within}: no rung is good enough; the closest, {_rung_text(ladder, nearest)}"
        return f"{what}, {_shortfall(ladder, nearest)}"
    rung = ladder.rungs[ladder.chosen]
    assert rung.chosen is not None
    many = "this motion" if len(ladder.references) == 1 else f"these {len(ladder.references)} motions"
    what = f"{within} over {many}: {_rung_text(ladder, rung)}"
    if not rung.chosen.method:
        return f"{what}; nothing remains to integrate, because motors follow exactly"
    steps = f"{rung.chosen.method}, {rung.chosen.steps} steps of {quantity(ladder.step_of(rung), 's')}"
    if ladder.saving < LEAST_SAVING:
        return f"{what}; {steps}"
    return f"{what}; {steps}, {ladder.saving:.3g} times fewer operations than the full machine with RK4"


def _shortfall(ladder: Ladder, rung: Rung) -> str:
    """Return why a rung exceeds the tolerances: model errors, step errors, or springs that cannot carry their loads."""
    lost = relative(rung.predicted, ladder.tolerance)
    if rung.chosen is None and lost <= MODEL_SHARE:
        return f"uses {lost:.0%} of that, but its springs do not hold their loads"
    if rung.measured is None or rung.chosen is None:
        return f"uses {lost:.0%} of that"
    model, steps = (relative(x, ladder.tolerance) for x in (rung.measured.model, rung.measured.steps))
    steps_text = f"{rung.chosen.steps} steps of {rung.chosen.method}"
    predicted = relative(rung.chosen.predicted, ladder.tolerance)
    return f"uses {model:.0%} of that; its {steps_text} use {steps:.0%} where {predicted:.0%} were predicted"


def arithmetic_line(ladder: Ladder) -> str:
    """Return a line on accelerations in single precision, states in double; empty where no rung is chosen."""
    if ladder.chosen is None:
        return ""
    worst = max(ladder.tolerance, key=lambda name: ladder.arithmetic[name] / ladder.tolerance[name])
    added = quantity(ladder.arithmetic[worst], unit_of(ladder.machine, worst))
    enough = ladder.arithmetic[worst] <= ARITHMETIC_SHARE * ladder.tolerance[worst]
    verdict = "mixed precision is enough" if enough else "use double precision"
    return f"accelerations in single precision add about {added} to {worst}: {verdict}"


def _rung_text(ladder: Ladder, rung: Rung) -> str:
    elastic = [joint.name for joint in ladder.machine.independent_joints if joint.kind == "elastic"]
    springs = [name for name in elastic if name not in rung.left_out]
    if not rung.left_out:
        return "keep every spring"
    omitted = springs_text(rung.left_out, "locked" if rung.locked else "quasi-static")
    return f"keep {', '.join(springs)} as springs, {omitted}" if springs else omitted


def period_of(ladder: Ladder, wanted: Wanted) -> str:
    """Return a line on the computing time of a period on the chosen rung; empty without a rung or its time."""
    rung = ladder.rungs[ladder.chosen] if ladder.chosen is not None else None
    return period_line(wanted, ladder.step_of(rung), rung.measured.seconds) if rung and rung.measured else ""


def _rung_json(ladder: Ladder, k: int, rung: Rung) -> dict[str, Any]:
    measured = rung.measured
    return {
        "left_out": list(rung.left_out),
        "locked": rung.locked,
        "predicted": dict(rung.predicted),
        "measured": dict(measured.model) if measured else None,
        "method": rung.chosen.method if rung.chosen else None,
        "steps": rung.chosen.steps if rung.chosen else None,
        "step": ladder.step_of(rung) if rung.chosen else None,
        "operations": rung.chosen.operations if rung.chosen else None,
        "step_errors_predicted": dict(rung.chosen.predicted) if rung.chosen else None,
        "step_errors_measured": dict(measured.steps) if measured and rung.chosen else None,
        "seconds_per_step": measured.seconds if measured and rung.chosen else None,
        "verdict": _verdict(ladder, k),
    }


def _name(rung: Rung, before: set[str]) -> str:
    if rung.locked:
        return "all, locked"
    new = [name for name in rung.left_out if name not in before]
    return f"+ {', '.join(new)}" if new else "none"


def _verdict(ladder: Ladder, k: int) -> str:
    if k == ladder.chosen:
        return "<- chosen"
    return "prediction failed" if k in ladder.distrusted else ""


declare(
    Ladder,
    Field("tolerance"),
    Field("rungs", lambda x: [_rung_json(x, k, rung) for k, rung in enumerate(x.rungs)]),
    *map(Field, ("chosen", "distrusted", "full", "arithmetic", "springs", "condensed")),
    Field("advice", advice),
    Field("budget"),
)


@parts_of.register
def budget_parts(budget: Budget) -> list[Part]:
    """Return the table of the path, the advice, the measured errors, and the times of a step."""
    hides = any("." in name for name in budget.advised.rung.left_out)
    lines = [advice_on_budget(budget), measured_line(budget), times_line(budget), *_rejected_line(budget)]
    return [_path_table(budget.machine, budget.tolerance, budget), *lines, *[NAMES] * hides, EVIDENCE_LINE]


def advice_on_budget(budget: Budget) -> str:
    """Return a sentence: what the advised model omits, and the fraction of operations that this saves."""
    rung, steps = budget.advised.rung, budget.advised.steps
    parts = [springs_text(rung.left_out, "quasi-static")] if rung.left_out else []
    parts += [f"held where they are neutral: {', '.join(rung.neutral)}"] if rung.neutral else []
    parts += [f"without {', '.join(rung.zero)}"] if rung.zero else []
    parts += [f"{steps.steps} steps of {steps.method}"] if steps.method else []
    parts += ["mixed precision"] if budget.advised.expense is Expense.PRECISION else []
    than = "the full machine" if budget.alone is None else "with springs alone left out"
    saved = f"{budget.saved:.0%}" if budget.saved > 0 else "no"
    return f"{'; '.join(parts) or 'nothing is left out'}: {saved} fewer operations than {than}"


def measured_line(budget: Budget) -> str:
    """Return a line on the errors of the last model against the full machine, and the predicted sums."""
    errors = [
        f"{name} {quantity(x, unit_of(budget.machine, name))} off, at most "
        f"{quantity(budget.advised.total[name], unit_of(budget.machine, name))} by prediction"
        for name, x in budget.measured.errors.items()
    ]
    verdict = "within the tolerance" if budget.is_within else "beyond the tolerance"
    return f"simulated against the full machine: {', '.join(errors)}: {verdict}"


def times_line(budget: Budget) -> str:
    """Return a line on the times of a step in both precisions, and which is chosen."""
    times = budget.measured
    if not times.seconds:
        return "nothing remains to integrate"
    precision = "mixed" if budget.advised.expense is Expense.PRECISION else "double"
    worst = budget.worst_output
    off = quantity(times.errors_mixed[worst], unit_of(budget.machine, worst))
    both = f"{quantity(times.seconds, 's')} in double, {quantity(times.mixed, 's')} in mixed precision"
    return f"time of a step: {both} ({worst} then {off} off) on this computer: {precision} precision"


def _rejected_line(budget: Budget) -> list[str]:
    """Return a line on steps of the path that simulation rejected."""
    names = [name for step in budget.dropped for name in (step.names or (str(step.expense),))]
    return [f"rejected, because the simulation exceeded the tolerance: {some_of(names, MOST_NAMED)}"] if names else []


def _step_json(step: PathStep) -> dict[str, Any]:
    return {
        "spent": str(step.expense),
        "names": list(step.names),
        "added": dict(step.added),
        "word": str(step.evidence),
        "total": dict(step.total),
        "method": step.steps.method,
        "steps": step.steps.steps,
        "operations": step.steps.operations,
        "cost": step.steps.cost,
    }


of_precisions = Field("seconds_double", "seconds"), Field("seconds_mixed", "mixed")
declare(MeasuredEnd, Field("errors"), Field("errors_mixed"), *of_precisions)
declare(
    Budget,
    Field("tolerance"),
    Field("path", lambda x: [_step_json(step) for step in x.path]),
    Field("static", "advised.rung.left_out"),
    Field("neutral", "advised.rung.neutral"),
    Field("zero", "advised.rung.zero"),
    Field("measured"),
    Field("within", "is_within"),
    Field("saved"),
    Field("dropped", lambda x: [_step_json(step) for step in x.dropped]),
    Field("advice", advice_on_budget),
)


def _tolerance_text(error: float, form: str = ".3g") -> str:
    """Torque tolerance as text; unlimited for a motor whose torque moves no output."""
    return "any" if math.isinf(error) else f"{error:{form}}"


declare(ProcessorCosts, *map(Field, ("processor", "precision", "torques", "step")))
PREDICTED = str(Evidence.PREDICTED)
declare(
    TorqueTolerance,
    Field("motor", head="torque accuracy of"),
    Field("any", head="any course", text=lambda x: _tolerance_text(x.any)),
    Field("share", head="all motors at once", text=lambda x: _tolerance_text(x.share)),
    Field("constant", head="constant", text=lambda x: _tolerance_text(x.constant)),
    Field("sinusoid", head="worst sinusoid", text=lambda x: _tolerance_text(x.sinusoid)),
    Field("frequency", head="at", text=lambda x: "" if math.isinf(x.any) else quantity(x.frequency, "Hz")),
    Field("largest", head="largest torque", form=".3g"),
    Field("relative", head="of it", text=lambda x: _tolerance_text(x.relative, ".2%")),
    Field("output", head="limited by", text=lambda x: "" if math.isinf(x.any) else x.output),
)


def _chosen_torques(result: Reduced) -> dict[str, Any] | None:
    """Return the model that is advised to feed forward, for JSON."""
    if not result.feed_forward:
        return None
    feed, none = result.feed_forward, dict.fromkeys(result.tolerance, 0.0)
    chosen = feed.chosen
    return {
        "operations": feed.operations,
        "operations_whole": feed.full,
        "left_out": [f"{x.quantity}: {x.term}" for x in chosen.model.reduction.left_out] if chosen else [],
        "predicted": dict(chosen.predicted) if chosen else none,
        "measured": dict(chosen.measured or {}) if chosen else none,
        "evidence": str(chosen.model.within.guaranteed) if chosen else "",
    }


def _chosen_model(result: Reduced) -> dict[str, Any] | None:
    """Return the model that is advised to simulate, for JSON; operations are those over the motion."""
    budget = result.simulation.budget if result.simulation else None
    if budget is None:
        return None
    rung = budget.advised.rung
    return {
        "operations": budget.advised.steps.cost,
        "operations_whole": budget.full.cost,
        "left_out": [*rung.left_out, *rung.zero],
        "predicted": dict(budget.advised.total),
        "measured": dict(budget.measured.errors),
        "evidence": PREDICTED,
    }


def _points(result: Reduced) -> list[dict[str, Any]]:
    """Return all models tried for simulation and feed-forward: operations, largest error as a fraction of tolerance."""
    feed, budget = result.feed_forward, result.simulation.budget if result.simulation else None
    steps = budget.path if budget else ()
    points = [("simulation", str(x.expense), x.steps.cost, x.total, str(x.evidence)) for x in steps]
    points += [("feed-forward", "terms", x.operations, x.predicted, PREDICTED) for x in (feed.tried if feed else ())]
    keys = "for", "left_out", "operations", "error", "evidence"
    rows = [(*point[:3], relative(point[3], result.tolerance), point[4]) for point in points]
    return [dict(zip(keys, row, strict=True)) for row in rows]


declare(
    Reduced,
    Field("tolerance"),
    Field("torques", lambda x: {y.motor: y.share for y in x.feed_forward.tolerances} if x.feed_forward else {}),
    Field("torque_tolerances", lambda x: x.feed_forward.tolerances if x.feed_forward else []),
    Field("accelerations"),
    Field("points", _points),
    Field("chosen", lambda x: _chosen_torques(x) or _chosen_model(x)),
    Field("feed_forward", _chosen_torques),
    Field("simulation", _chosen_model),
    Field("within", "is_within"),
    Field("costs"),
    Field("advice", lambda x: " ".join(_sentences(x))),
)


@parts_of.register
def reduced_parts(result: Reduced) -> list[Part]:
    """Return the advice, the required torque accuracy, the table of omitted parts, and remarks on the evidence."""
    parts: list[Part] = [*_sentences(result)]
    if result.feed_forward:
        unit = " and ".join(sorted({"N m" if x.sigma == 0 else "N" for x in result.machine.motor_joints}))
        title = f"torque errors within the tolerance, {unit}"
        parts.append(table_of(TorqueTolerance, result.feed_forward.tolerances, title))
    if result.accelerations:
        table = Table(("acceleration error of", "any course, rad/s2 or m/s2"))
        for name, x in result.accelerations.items():
            table.add_row(name, f"{x:.3g}")
        parts.append(table)
    budget = result.simulation.budget if result.simulation else None
    return [*parts, _path_table(result.machine, result.tolerance, budget, result.feed_forward), *_remarks(result)]


def _sentences(result: Reduced) -> list[str]:
    """Return sentences: the required torque accuracy, and the parts that either purpose may omit."""
    within, sentences = _within(result.machine, result.tolerance), []
    if result.feed_forward:
        units = {x.name: "N m" if x.sigma == 0 else "N" for x in result.machine.motor_joints}
        limited = [x for x in result.feed_forward.tolerances if not math.isinf(x.share)]
        needed = ", ".join(f"{x.motor} {x.share:.3g} {units[x.motor]} ({x.relative:.2%})" for x in limited)
        sentences.append(f"{within}: torques of all motors may be wrong by {needed}")
        sentences.append(f"feed-forward: {_advice_on_torques(result, result.feed_forward)}")
    if result.simulation and result.simulation.budget:
        sentences.append(f"simulation: {advice_on_budget(result.simulation.budget)}")
    return sentences


def _advice_on_torques(result: Reduced, feed: FeedForward) -> str:
    chosen = feed.chosen
    if chosen is None:
        return f"all {feed.full} operations of the inverse model are needed"
    count = len(chosen.model.reduction.left_out)
    saved = f"{chosen.operations} of {feed.full} operations without {count} terms"
    saved = saved if chosen.operations else f"constant torques are enough, none of {feed.full} operations is needed"
    worst = max(result.tolerance, key=lambda name: chosen.predicted[name] / result.tolerance[name])
    both = (chosen.predicted[worst], (chosen.measured or {})[worst])
    predicted, measured = (quantity(x, unit_of(result.machine, worst)) for x in both)
    return f"{saved}; {worst} {predicted} off by prediction, {measured} measured"


def _path_table(
    machine: Machine, tolerance: Mapping[str, float], budget: Budget | None, feed: FeedForward | None = None
) -> Table:
    """Return a table with a row for every omitted part: the error that it adds, its evidence, and operations."""
    heads = "for", "left out", "adds, of the tolerance", "evidence", "sum", "operations", "of full"
    table = Table(heads, title=f"{machine.name}: what the tolerance allows to leave out")
    rows: list[tuple[str, str, float, Evidence, float, int, int]] = []
    if budget:
        for expense, group in groupby(budget.path, key=lambda step: step.expense):
            steps = list(group)
            names = [name for step in steps for name in step.names]
            added = relative({name: sum(step.added[name] for step in steps) for name in tolerance}, tolerance)
            is_long = expense is Expense.SPRINGS and len(names) > MOST_NAMED
            listed = springs_text(names, "quasi-static", named=False) if is_long else some_of(names, MOST_NAMED)
            name = f"{expense}: {listed}" if names else str(expense)
            total, cost = relative(steps[-1].total, tolerance), (steps[-1].steps.cost, budget.full.cost)
            rows.append(("simulation", name, added, Evidence.PREDICTED, total, *cost))
        used, cost = relative(budget.measured.errors, tolerance), (budget.advised.steps.cost, budget.full.cost)
        rows.append(("simulation", "all together", used, Evidence.MEASURED, used, *cost))
    if feed and feed.chosen:
        used, cost = relative(feed.chosen.measured or {}, tolerance), (feed.chosen.operations, feed.full)
        terms = f"{len(feed.chosen.model.reduction.left_out)} terms"
        rows.append(("feed-forward", terms, used, Evidence.MEASURED, used, *cost))
    for purpose, name, adds, evidence, total, operations, full in rows:
        count = str(operations) if operations < EXACT_COUNTS else f"{operations:.3g}"
        table.add_row(purpose, name, f"{adds:.1%}", str(evidence), f"{total:.1%}", count, f"{operations / full:.1%}")
    return table


def _costs_lines(result: Reduced) -> list[str]:
    """Return a line on the instructions, stack and code of torques and of a step on a processor."""
    if result.costs is None:
        return []
    named = {f"torques in {result.costs.precision} precision": result.costs.torques, "a step": result.costs.step}
    texts = []
    for name, cost in ((name, x.cost) for name, x in named.items() if x):
        calls = sum((cost.calls or {}).values())
        instructions = f"{cost.instructions} instructions" + (f" and {calls} calls of libraries" if calls else "")
        texts.append(f"{name} at most {instructions}, {cost.stack} bytes of stack, {cost.code} bytes of code")
    return [f"on {result.costs.processor}: {'; '.join(texts)}"] if texts else []


def _remarks(result: Reduced) -> list[str]:
    """Return lines on the evidence for torque errors, the work of a controller, and the simulation."""
    lines = []
    if result.feed_forward and result.feed_forward.chosen:
        chosen = result.feed_forward.chosen
        kind = "proven" if chosen.model.within.guaranteed is Evidence.PROVEN else "95 % confidence"
        lines.append(f"torque errors: {kind} over the operating range of the motion; their effect: predicted, measured")
    if result.feed_forward and result.rate:
        rate = result.rate * result.feed_forward.operations
        lines.append(f"at {result.rate:g} Hz the torques cost {rate:.3g} operations/s")
    lines += _costs_lines(result)
    if result.simulation and result.simulation.budget:
        budget = result.simulation.budget
        lines += [times_line(budget), *_rejected_line(budget), *_rigid_line(result)]
    return lines


def _rigid_line(result: Reduced) -> list[str]:
    """Return a line on the predicted error of the machine with all springs locked."""
    rungs = [x for x in result.simulation.rungs if x.locked] if result.simulation else []
    if not rungs:
        return []
    worst = max(result.tolerance, key=lambda name: rungs[-1].predicted[name] / result.tolerance[name])
    used = relative(rungs[-1].predicted, result.tolerance)
    off = quantity(rungs[-1].predicted[worst], unit_of(result.machine, worst))
    return [f"for comparison: the rigid machine, all springs locked: {worst} {off} off, {used:.3g} times the tolerance"]
