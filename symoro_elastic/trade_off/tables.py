"""Results of the comparison as tables for the terminal, and as plain data for `--json`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from symoro_elastic.models.tables import count_json, operations
from symoro_elastic.numerics.forms import Choice
from symoro_elastic.results import Part, Titled
from symoro_elastic.trade_off.advice import Advice, commands, sentence
from symoro_elastic.trade_off.configurations import Measurement
from symoro_elastic.trade_off.drift import Drift
from symoro_elastic.trade_off.factors import Effect, effects
from symoro_elastic.trade_off.front import front
from symoro_elastic.trade_off.trade import Trade


def measurements_table(measurements: Sequence[Measurement], on_front: Sequence[Measurement]) -> Any:
    """Return a table of configurations, fastest first, with a mark on the front and on those that are not advised."""
    from rich.table import Table

    table = Table(
        "", "ns a state", "worst error", "bound", "in u", "typical, u", "one ulp of inputs, u", "operations", "by"
    )
    for one in sorted(measurements, key=lambda f: f.ns):
        errors = one.errors
        mark = "*" if any(one is other for other in on_front) else "" if one.configuration.is_safe else "not advised"
        ulps = (_figure(errors.worst), _figure(errors.typical), _figure(errors.input_effect))
        table.add_row(
            mark,
            f"{one.ns:.3g}",
            f"{one.error:.1e}",
            f"{one.bound:.1e}",
            *ulps,
            operations(one.count),
            one.configuration.words,
        )
    return table


def _figure(units: float) -> str:
    return f"{units:.2g}" if units < 10 else f"{units:.0f}" if units < 1e4 else f"{units:.1e}"


def effects_table(compared: Sequence[Effect]) -> Any:
    """Return a table of the effects of single choices."""
    from rich.table import Table

    table = Table("choice", "time", "worst error", "points compared")
    for one in compared:
        table.add_row(one.words, f"x {one.time:.2f}", f"x {one.error:.2g}", str(one.pairs))
    return table


def drifts_table(drifts: Sequence[Drift]) -> Any:
    """Return a table of the drift of energy in a free motion, by the format of the state."""
    from rich.table import Table

    table = Table("right-hand side and state", "drift of energy, J", "of kinetic and elastic energy")
    for one in drifts:
        share = one.drift / one.energy if one.energy else math.inf
        table.add_row(one.title, f"{one.drift:.1e}", f"{share:.1e}")
    return table


def forms_table(choice: Choice) -> Any:
    """Return a table of the forms of direct_dynamics: operations and predicted errors."""
    from rich.table import Table

    table = Table("form", "operations", "predicted error, u", "")
    for one in choice.forms:
        predicted = f"{one.error:.3g}" if math.isfinite(one.error) else "-"
        table.add_row(one.name, operations(one.count), predicted, "taken" if one.name == choice.chosen else "")
    return table


def trade_parts(trade: Trade, with_fast_math: bool = False, every: bool = False) -> list[Part]:
    """Return tables of what none beats (or of `every` point), of what a choice does by itself, and of drifts."""
    kind = "extreme" if trade.request.extreme else "moderate"
    of = "every point" if every else "none is faster and as accurate"
    parts: list[Part] = []
    for model, figures in trade.measurements.items():
        best = front(figures, with_fast_math)
        title = f"{trade.machine.name}, {model}: {of}, {trade.request.states} {kind} states"
        parts.append(Titled(measurements_table(figures if every else best, best), title))
        parts.append(Titled(effects_table(effects(figures)), f"{model}: what a choice does by itself"))
    if trade.form:
        parts += [
            Titled(forms_table(trade.form), "direct_dynamics: what generate --form auto takes"),
            trade.form.sentence,
        ]
    if trade.drifts:
        steps = f"{trade.drifts[0].steps} steps of {trade.drifts[0].step:.1e} s"
        parts.append(Titled(drifts_table(trade.drifts), f"free motion without losses, {steps}"))
    return parts


def trade_json(
    trade: Trade, advised: Advice | None, words: Sequence[str], with_fast_math: bool = False
) -> dict[str, Any]:
    """Return everything as plain data; null stands for numbers that are not finite."""
    return {
        "machine": trade.machine.name,
        "states": "extreme" if trade.request.extreme else "moderate",
        "models": {
            model: _model_json(measurements, with_fast_math) for model, measurements in trade.measurements.items()
        },
        "drift": [_drift_json(one) for one in trade.drifts],
        "form": trade.form.as_json() if trade.form else None,
        "notes": trade.notes,
        "advice": _advice_json(advised, words) if advised else None,
    }


def _model_json(measurements: Sequence[Measurement], with_fast_math: bool) -> dict[str, Any]:
    on_front = front(measurements, with_fast_math)
    configurations = [
        _configuration_json(one) | {"front": any(one is other for other in on_front)} for one in measurements
    ]
    compared = [
        {"choice": one.words, "time": one.time, "error": _finite(one.error), "points": one.pairs}
        for one in effects(measurements)
    ]
    return {"points": configurations, "choices": compared}


def _configuration_json(one: Measurement) -> dict[str, Any]:
    configuration, errors = one.configuration, one.errors
    return {
        "equations": configuration.form.way,
        "base": configuration.form.base,
        "folded": configuration.form.folded,
        "angles_summed": configuration.form.merged,
        "precision": configuration.precision.name,
        "compiler": " ".join(configuration.build.compiler) if configuration.build else None,
        "flags": list(configuration.build.options(configuration.form.package.name)) if configuration.build else [],
        "call": configuration.call,
        "advisable": configuration.is_safe,
        "ns": one.ns,
        "best_ns": one.time.best,
        "operations": count_json(one.count),
        "u": errors.u,
        "worst": _finite(one.error),
        "bound": _finite(one.bound),
        "worst_u": _finite(errors.worst),
        "typical_u": _finite(errors.typical),
        "input_effect_u": _finite(errors.input_effect),
        "judged": errors.judged,
    }


def _drift_json(one: Drift) -> dict[str, Any]:
    return {
        "state": one.title,
        "drift": _finite(one.drift),
        "energy": one.energy,
        "steps": one.steps,
        "step": one.step,
    }


def _advice_json(advised: Advice, words: Sequence[str]) -> dict[str, Any]:
    return {
        "sentence": sentence(advised),
        "tolerance": advised.tolerance,
        "commands": commands(advised.fastest, words),
        "fastest": {one.configuration.model: _configuration_json(one) for one in advised.fastest},
        "one_state": {one.configuration.model: _configuration_json(one) for one in advised.one_state},
    }


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None
