"""The ladder as tables, as data for JSON, and as sentences of advice."""

from __future__ import annotations

from typing import Any

from symoro_elastic.analysis.ladder import budget_views
from symoro_elastic.analysis.ladder.climbed import Ladder
from symoro_elastic.analysis.ladder.greedy import SpringFigures
from symoro_elastic.analysis.ladder.rung import MODEL_SHARE, Rung, Steps
from symoro_elastic.analysis.simulation.periods import period_line, quantity
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.foundation.results import Field, Part, Table, columns_of, declare, parts_of, table_of
from symoro_elastic.machine.described import Wanted

ARITHMETIC_SHARE = 0.05
"""Of a tolerance that arithmetic may take."""
LEAST_SAVING = 1.05
"""Operations of the whole machine with RK4 over those of a rung, from which they are reported."""
EACH_SPRING = "each spring by itself, which does not show its cost together with others"

declare(Steps, Field("method"), Field("steps"), Field("operations"))
declare(
    SpringFigures,
    Field("name", head="spring"),
    Field("alone", head="error if static, relative to tolerance", form=".2g"),
    Field("activity", head="activity", text=lambda x: quantity(x.activity, "J")),
    Field("frequency", head="natural frequency, all else locked", text=lambda x: quantity(x.frequency, "Hz")),
)


@parts_of.register
def _(found: Ladder) -> list[Part]:
    springs = [springs_table(found)] if found.springs else []
    lines = [*found.condensed, advice(found), arithmetic_line(found)]
    budget = budget_views.budget_parts(found.budget) if found.budget else []
    return [ladder_table(found, found.headline), *springs, *filter(None, lines), *budget]


@columns_of.register
def _(found: Ladder) -> dict[str, list[Any]]:
    """Return a row for each rung, as in JSON."""
    rungs = found.as_json()["rungs"]
    return {key: [rung[key] for rung in rungs] for key in rungs[0]}


def ladder_table(found: Ladder, title: str = "") -> Table:
    """Return a row for each rung: what is left out more, errors, steps, cost against the whole machine with RK4."""
    worst = found.worst_output
    unit = unit_of(found.machine, worst)
    heads = "springs left out", f"predicted ({worst})", "measured", "method", "step", "time", "against full", ""
    table = Table(heads, title=title)
    before: set[str] = set()
    for k, rung in enumerate(found.rungs):
        measured = rung.measured.model[worst] if rung.measured else None
        table.add_row(
            _name(rung, before),
            quantity(rung.predicted[worst], unit),
            "-" if measured is None else quantity(measured, unit),
            rung.chosen.method if rung.chosen else "-",
            quantity(found.step_of(rung), "s") if rung.chosen else "-",
            quantity(rung.measured.seconds * rung.chosen.steps, "s") if rung.measured and rung.chosen else "-",
            f"{found.full.cost / rung.chosen.cost:.3g}" if rung.chosen else "-",
            _verdict(found, k),
        )
        before = set(rung.left_out)
    return table


def springs_table(found: Ladder) -> Table:
    """Return a row for each spring: what it costs alone, its activity and its frequency."""
    return table_of(SpringFigures, found.springs, EACH_SPRING)


def advice(found: Ladder) -> str:
    """Return one sentence: what to keep, what may follow statically, and with which steps."""
    within = ", ".join(
        f"{name} within {quantity(x, unit_of(found.machine, name))}" for name, x in found.tolerance.items()
    )
    if found.chosen is None:
        nearest = min(found.rungs, key=lambda rung: relative(rung.predicted, found.tolerance))
        what = f"{within}: no rung is good enough; the closest, {_described(found, nearest)}"
        return f"{what}, {_shortfall(found, nearest)}"
    rung = found.rungs[found.chosen]
    assert rung.chosen is not None
    many = "this motion" if len(found.references) == 1 else f"these {len(found.references)} motions"
    what = f"{within} over {many}: {_described(found, rung)}"
    if not rung.chosen.method:
        return f"{what}; nothing is left to integrate, because motors follow exactly"
    steps = f"{rung.chosen.method}, {rung.chosen.steps} steps of {quantity(found.step_of(rung), 's')}"
    if found.saving < LEAST_SAVING:
        return f"{what}; {steps}"
    return f"{what}; {steps}, {found.saving:.3g} times fewer operations than the whole machine with RK4"


def _shortfall(found: Ladder, rung: Rung) -> str:
    """Return why a rung is not good enough: its model, its steps as measured, or springs that do not hold."""
    lost = relative(rung.predicted, found.tolerance)
    if rung.chosen is None and lost <= MODEL_SHARE:
        return f"takes {lost:.0%} of that, but its springs do not hold their loads"
    if rung.measured is None or rung.chosen is None:
        return f"takes {lost:.0%} of that"
    model, steps = (relative(x, found.tolerance) for x in (rung.measured.model, rung.measured.steps))
    taken = f"{rung.chosen.steps} steps of {rung.chosen.method}"
    predicted = relative(rung.chosen.predicted, found.tolerance)
    return f"takes {model:.0%} of that; its {taken} take {steps:.0%} where {predicted:.0%} were predicted"


def predicted_line(found: Ladder) -> str:
    """Return the advice on one line with the error that is predicted of the output that is worst."""
    if found.chosen is None:
        return advice(found)
    predicted = found.rungs[found.chosen].predicted
    worst = max(found.tolerance, key=lambda name: predicted[name] / found.tolerance[name])
    error = quantity(predicted[worst], unit_of(found.machine, worst))
    return f"{advice(found)}; error of {worst} by prediction {error}"


def arithmetic_line(found: Ladder) -> str:
    """Return a line on accelerations in single precision, states in double; empty where no rung is chosen."""
    if found.chosen is None:
        return ""
    worst = max(found.tolerance, key=lambda name: found.arithmetic[name] / found.tolerance[name])
    added = quantity(found.arithmetic[worst], unit_of(found.machine, worst))
    enough = found.arithmetic[worst] <= ARITHMETIC_SHARE * found.tolerance[worst]
    verdict = "mixed precision is enough" if enough else "use double precision"
    return f"accelerations in single precision add about {added} to {worst}: {verdict}"


def _described(found: Ladder, rung: Rung) -> str:
    kept = [
        joint.name
        for joint in found.machine.independent_joints
        if joint.kind == "elastic" and joint.name not in rung.left_out
    ]
    if not rung.left_out:
        return "keep every spring"
    how = "are locked" if rung.locked else "follow statically"
    left = f"{len(rung.left_out)} {how} ({', '.join(rung.left_out)})"
    return f"keep {', '.join(kept)} as springs, {left}" if kept else f"all springs, {left}"


def period_of(found: Ladder, wanted: Wanted) -> str:
    """Return how long the steps of a period take on the chosen rung; empty where there is neither."""
    rung = found.rungs[found.chosen] if found.chosen is not None else None
    return period_line(wanted, found.step_of(rung), rung.measured.seconds) if rung and rung.measured else ""


def _rung_json(found: Ladder, k: int, rung: Rung) -> dict[str, Any]:
    measured = rung.measured
    return {
        "left_out": list(rung.left_out),
        "locked": rung.locked,
        "predicted": dict(rung.predicted),
        "measured": dict(measured.model) if measured else None,
        "method": rung.chosen.method if rung.chosen else None,
        "steps": rung.chosen.steps if rung.chosen else None,
        "step": found.step_of(rung) if rung.chosen else None,
        "operations": rung.chosen.operations if rung.chosen else None,
        "step_errors_predicted": dict(rung.chosen.predicted) if rung.chosen else None,
        "step_errors_measured": dict(measured.steps) if measured and rung.chosen else None,
        "seconds_per_step": measured.seconds if measured and rung.chosen else None,
        "verdict": _verdict(found, k),
    }


def _name(rung: Rung, before: set[str]) -> str:
    if rung.locked:
        return "all, locked"
    new = [name for name in rung.left_out if name not in before]
    return f"+ {', '.join(new)}" if new else "none"


def _verdict(found: Ladder, k: int) -> str:
    if k == found.chosen:
        return "<- chosen"
    return "prediction failed" if k in found.distrusted else ""


declare(
    Ladder,
    Field("tolerance"),
    Field("rungs", lambda x: [_rung_json(x, k, rung) for k, rung in enumerate(x.rungs)]),
    Field("chosen"),
    Field("distrusted"),
    Field("full"),
    Field("arithmetic"),
    Field("springs"),
    Field("condensed"),
    Field("advice", advice),
    Field("budget"),
)
