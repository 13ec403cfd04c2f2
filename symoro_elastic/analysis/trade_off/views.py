"""Results of the comparison as tables, as columns of a data frame, and as plain data for `--json`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import Any

from symoro_elastic.analysis.trade_off.advice import Advice, commands, sentence
from symoro_elastic.analysis.trade_off.configurations import Measurement, front
from symoro_elastic.analysis.trade_off.drift import Drift
from symoro_elastic.analysis.trade_off.factors import Effect, effects
from symoro_elastic.analysis.trade_off.guaranteed_views import guaranteed_parts
from symoro_elastic.analysis.trade_off.trade import Trade
from symoro_elastic.codegen.package_context import count_json, operations
from symoro_elastic.foundation.results import Field, Part, Table, declare, json_of, parts_of, plain, table_of
from symoro_elastic.numerics.verification.forms import Choice


def _units(of: str) -> Any:
    def text(one: Measurement) -> str:
        units: float = getattr(one.errors, of)
        return f"{units:.2g}" if units < 10 else f"{units:.0f}" if units < 1e4 else f"{units:.1e}"

    return text


def _compiler(one: Measurement) -> str | None:
    build = one.configuration.build
    return " ".join(build.compiler) if build else None


def _flags(one: Measurement) -> Sequence[str]:
    build = one.configuration.build
    return build.options(one.configuration.form.package.name) if build else []


declare(
    Measurement,
    Field("model", "configuration.model", json=False, column="model"),
    Field("way", "configuration.words", json=False, column="way"),
    Field("equations", "configuration.form.way"),
    Field("base", "configuration.form.base"),
    Field("folded", "configuration.form.folded"),
    Field("angles_summed", "configuration.form.merged"),
    Field("precision", "configuration.precision.name"),
    Field("compiler", _compiler),
    Field("flags", _flags),
    Field("call", "configuration.call"),
    Field("advisable", "configuration.is_safe"),
    Field("ns", head="ns a state", form=".3g", column="ns"),
    Field("best_ns", "time.best"),
    Field("worst", "error", "worst error", form=".1e", column="error"),
    Field("bound", head="bound", form=".1e", column="bound"),
    Field("u", "errors.u"),
    Field("worst_u", "errors.worst", "in u", text=_units("worst")),
    Field("typical_u", "errors.typical", "typical, u", text=_units("typical")),
    Field("input_effect_u", "errors.input_effect", "one ulp of inputs, u", text=_units("input_effect")),
    Field("operations", lambda x: count_json(x.count), "operations", text=lambda x: operations(x.count)),
    Field("judged", "errors.judged"),
    Field("by", "configuration.words", "by", json=False),
)
declare(
    Effect,
    Field("choice", "words", "choice"),
    Field("time", head="time", text=lambda x: f"x {x.time:.2f}"),
    Field("error", head="worst error", text=lambda x: f"x {x.error:.2g}"),
    Field("points", "pairs", "points compared"),
)
declare(
    Drift,
    Field("state", "title", "right-hand side and state"),
    Field("drift", head="drift of energy, J", form=".1e"),
    Field(
        "share",
        lambda x: x.drift / x.energy if x.energy else math.inf,
        "of kinetic and elastic energy",
        form=".1e",
        json=False,
    ),
    Field("energy"),
    Field("steps"),
    Field("step"),
)


def _measurements_table(measurements: Sequence[Measurement], on_front: Sequence[Measurement], title: str) -> Table:
    """Return a table of configurations, fastest first, with a mark on the front and on those that are not advised."""
    fastest = sorted(measurements, key=lambda one: one.ns)
    table = table_of(Measurement, fastest, title)
    marks = ["*" if _is_in(one, on_front) else "" if one.configuration.is_safe else "not advised" for one in fastest]
    rows = [(mark, *row) for mark, row in zip(marks, table.rows, strict=True)]
    return Table(("", *table.heads), rows, title)


def _is_in(one: Measurement, measurements: Sequence[Measurement]) -> bool:
    return any(one is other for other in measurements)


def _forms_table(choice: Choice) -> Table:
    """Return a table of the forms of direct_dynamics: operations and predicted errors."""
    table = Table(
        ("form", "operations", "predicted error, u", ""), title="direct_dynamics: what generate --form auto takes"
    )
    for one in choice.forms:
        predicted = f"{one.error:.3g}" if math.isfinite(one.error) else "-"
        table.add_row(one.name, operations(one.count), predicted, "taken" if one.name == choice.chosen else "")
    return table


def _kind(trade: Trade) -> str:
    return "extreme" if trade.request.extreme else "moderate"


@parts_of.register
def trade_parts(trade: Trade, with_fast_math: bool = False, every: bool = False) -> list[Part]:
    """Return tables of what none beats (or of `every` point), of what a choice does by itself, and of drifts."""
    of = "every point" if every else "none is faster and as accurate"
    parts: list[Part] = []
    for model, figures in trade.measurements.items():
        best = front(figures, with_fast_math)
        title = f"{trade.machine.name}, {model}: {of}, {trade.request.states} {_kind(trade)} states"
        parts.append(_measurements_table(figures if every else best, best, title))
        parts.append(table_of(Effect, effects(figures), f"{model}: effect of each choice by itself"))
    if trade.form:
        parts += [_forms_table(trade.form), trade.form.sentence]
    if trade.drifts:
        steps = f"{trade.drifts[0].steps} steps of {trade.drifts[0].step:.1e} s"
        parts.append(table_of(Drift, trade.drifts, f"free motion without losses, {steps}"))
    return parts + [part for curve in trade.curves for part in guaranteed_parts(curve)]


def trade_json(
    trade: Trade, advised: Advice | None, words: Sequence[str], with_fast_math: bool = False
) -> dict[str, Any]:
    """Return everything as plain data, with the advice and its commands; null for numbers that are not finite."""
    models = {model: _model_json(measured, with_fast_math) for model, measured in trade.measurements.items()}
    return {**trade.as_json(), "models": models, "advice": _advice_json(advised, words) if advised else None}


def _model_json(measurements: Sequence[Measurement], with_fast_math: bool = False) -> dict[str, Any]:
    on_front = front(measurements, with_fast_math)
    points = [json_of(one) | {"front": _is_in(one, on_front)} for one in measurements]
    return {"points": points, "choices": plain(effects(measurements))}


def _advice_json(advised: Advice, words: Sequence[str]) -> dict[str, Any]:
    return {
        "sentence": sentence(advised),
        "tolerance": advised.tolerance,
        "commands": commands(advised.fastest, words),
        "fastest": {one.configuration.model: json_of(one) for one in advised.fastest},
        "one_state": {one.configuration.model: json_of(one) for one in advised.one_state},
    }


declare(
    Trade,
    Field("machine", "machine.name"),
    Field("states", _kind),
    Field("models", lambda x: {model: _model_json(measured) for model, measured in x.measurements.items()}),
    Field("measurements", lambda x: [*chain(*x.measurements.values())], rows=Measurement, json=False),
    Field("drift", "drifts"),
    Field("form"),
    Field("notes"),
    Field("curves"),
)
