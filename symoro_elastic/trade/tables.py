"""The trade as tables for the terminal, and as plain data for `--json`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from symoro_elastic.report.tables import count_json, operations
from symoro_elastic.trade.advice import Advice, commands, sentence
from symoro_elastic.trade.choices import Choice, choices
from symoro_elastic.trade.drift import Drift
from symoro_elastic.trade.front import front
from symoro_elastic.trade.points import Figures
from symoro_elastic.trade.trade import Trade


def points_table(figures: Sequence[Figures], on_front: Sequence[Figures]) -> Any:
    """Points, fastest first; those on the front have a star, those that are not advised a word."""
    from rich.table import Table

    table = Table("", "ns a state", "worst error", "in u", "typical, u", "one ulp of inputs, u", "operations", "by")
    for one in sorted(figures, key=lambda f: f.ns):
        errors = one.errors
        mark = "*" if any(one is other for other in on_front) else "" if one.point.is_safe else "not advised"
        ulps = (_figure(errors.worst), _figure(errors.typical), _figure(errors.input_effect))
        table.add_row(mark, f"{one.ns:.3g}", f"{one.error:.1e}", *ulps, operations(one.count), one.point.words)
    return table


def _figure(units: float) -> str:
    return f"{units:.2g}" if units < 10 else f"{units:.0f}" if units < 1e4 else f"{units:.1e}"


def choices_table(found: Sequence[Choice]) -> Any:
    """What one choice does by itself."""
    from rich.table import Table

    table = Table("choice", "time", "worst error", "points compared")
    for one in found:
        table.add_row(one.words, f"x {one.time:.2f}", f"x {one.error:.2g}", str(one.pairs))
    return table


def drifts_table(drifts: Sequence[Drift]) -> Any:
    """Energy that a free motion loses, by the form of the state."""
    from rich.table import Table

    table = Table("right-hand side and state", "drift of energy, J", "of what moves")
    for one in drifts:
        share = one.drift / one.energy if one.energy else math.inf
        table.add_row(one.title, f"{one.drift:.1e}", f"{share:.1e}")
    return table


def trade_json(
    found: Trade, advised: Advice | None, words: Sequence[str], with_fast_math: bool = False
) -> dict[str, Any]:
    """Everything as plain data; null stands for what is not finite."""
    return {
        "machine": found.machine.name,
        "states": "extreme" if found.request.extreme else "moderate",
        "models": {model: _model_json(figures, with_fast_math) for model, figures in found.figures.items()},
        "drift": [_drift_json(one) for one in found.drifts],
        "notes": found.notes,
        "advice": _advice_json(advised, words) if advised else None,
    }


def _model_json(figures: Sequence[Figures], with_fast_math: bool) -> dict[str, Any]:
    on_front = front(figures, with_fast_math)
    points = [_point_json(one) | {"front": any(one is other for other in on_front)} for one in figures]
    compared = [
        {"choice": one.words, "time": one.time, "error": _finite(one.error), "points": one.pairs}
        for one in choices(figures)
    ]
    return {"points": points, "choices": compared}


def _point_json(one: Figures) -> dict[str, Any]:
    point, errors = one.point, one.errors
    return {
        "equations": point.form.way,
        "base": point.form.base,
        "folded": point.form.folded,
        "angles_summed": point.form.merged,
        "precision": point.precision.name,
        "compiler": " ".join(point.build.compiler) if point.build else None,
        "flags": list(point.build.flags) if point.build else [],
        "call": point.call,
        "advisable": point.is_safe,
        "ns": one.ns,
        "best_ns": one.time.best,
        "operations": count_json(one.count),
        "u": errors.u,
        "worst": _finite(one.error),
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
        "fastest": {one.point.model: _point_json(one) for one in advised.fastest},
        "one_state": {one.point.model: _point_json(one) for one in advised.one_state},
    }


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None
