"""Results of the comparison as tables, as columns of a data frame, and as plain data for `--json`."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from statistics import median
from typing import Any

from symoro_elastic.analysis.trade_off.advice import Advice, commands, sentence
from symoro_elastic.analysis.trade_off.builds import CONTRACTED, FAST_MATH, PAIRED, PLAIN, SEPARATE, WITH_LIBM
from symoro_elastic.analysis.trade_off.configurations import BATCH, SINGLE_CALL, Configuration, Measurement, front
from symoro_elastic.analysis.trade_off.drift import Drift
from symoro_elastic.analysis.trade_off.formulations import BY_MATRIX, RECURSION
from symoro_elastic.analysis.trade_off.guaranteed import GuaranteedCurve, GuaranteedPoint
from symoro_elastic.analysis.trade_off.trade import Trade
from symoro_elastic.codegen.package_context import count_json, operations
from symoro_elastic.foundation.results import Field, Part, Table, declare, json_of, parts_of, plain, table_of
from symoro_elastic.machine.within import Evidence
from symoro_elastic.numerics.guarantees.header import at_most, confidence
from symoro_elastic.numerics.verification.forms import Choice
from symoro_elastic.numerics.within.budget import Error

Levels = Mapping[str, Hashable]
"""The level of every factor in a configuration, by its name."""
FACTOR_FLAGS = (FAST_MATH, WITH_LIBM, PAIRED, SEPARATE, *CONTRACTED.values())
"""Flags that are factors by themselves."""
declare(Error, Field("error", "value"), Field("word", lambda x: str(x.evidence)))
declare(
    GuaranteedPoint,
    *map(Field, ("form", "precision", "share", "left_out")),
    Field("operations", lambda x: count_json(x.operations)),
    *map(Field, ("rounding", "terms", "total", "unseen", "time")),
)
declare(GuaranteedCurve, *map(Field, ("model", "within", "points", "path", "saved")))


@dataclass(frozen=True)
class Factor:
    """A choice between two levels of one factor, `chosen` and `instead_of` (None: any other level).

    `where` restricts it to configurations that have these levels of other factors.
    """

    words: str
    name: str
    chosen: Hashable
    instead_of: Hashable
    where: Levels = field(default_factory=dict)

    def is_chosen(self, levels: Levels) -> bool:
        """Whether a configuration has the chosen level of the factor."""
        return self._applies(levels) and levels[self.name] == self.chosen

    def is_counterpart(self, levels: Levels) -> bool:
        """Whether a configuration has the other level of the factor."""
        level = levels[self.name]
        has_other_level = level != self.chosen if self.instead_of is None else level == self.instead_of
        return self._applies(levels) and has_other_level

    def others(self, levels: Levels) -> tuple[Hashable, ...]:
        """Return the levels of all other factors, which comparable configurations share."""
        return tuple(level for name, level in levels.items() if name != self.name)

    def _applies(self, levels: Levels) -> bool:
        return all(levels[name] == level for name, level in self.where.items())


@dataclass(frozen=True)
class Effect:
    """The effect of a choice: medians of the ratios of time and of worst error over `pairs` of configurations."""

    words: str
    time: float
    error: float
    pairs: int


FACTORS = (
    Factor("a batch instead of single calls", "call", BATCH, SINGLE_CALL),
    Factor("single instead of double", "precision", "single", "double"),
    Factor("mixed instead of double", "precision", "mixed", "double"),
    Factor("double-double instead of double", "precision", "double-double", "double"),
    Factor("base parameters", "base", True, False),
    Factor("constants folded", "folded", True, False),
    Factor("A^-1 instead of the recursion", "way", BY_MATRIX, RECURSION),
    Factor("angles summed", "merged", True, False),
    Factor("batches on vectors in pairs", PAIRED, True, False, {"call": BATCH}),
    Factor("libm's sine and cosine", WITH_LIBM, True, False, {FAST_MATH: False}),
    Factor("products and sums apart (no FMA)", SEPARATE, True, False, {FAST_MATH: False}),
    Factor("-ffast-math, libm's sine and cosine", FAST_MATH, True, False, {WITH_LIBM: True}),
    Factor("-ffast-math, inline sine and cosine", FAST_MATH, True, False, {WITH_LIBM: False}),
    Factor("-O2 instead of what the source recommends", "optimisation", PLAIN, None,
           {FAST_MATH: False, WITH_LIBM: False, SEPARATE: False}),
)  # fmt: skip


def effects(measurements: Sequence[Measurement]) -> list[Effect]:
    """Return the effect of every choice for which there are configurations to compare."""
    measured = [(levels_of(x.configuration), x) for x in measurements]
    compared = []
    for factor in (*FACTORS, *_compilers(measurements)):
        ratios = list(_ratios(measured, factor))
        if ratios:
            times, errors = zip(*ratios, strict=True)
            compared.append(Effect(factor.words, median(times), median(errors), len(ratios)))
    return compared


def levels_of(configuration: Configuration) -> Levels:
    """Return the levels of all factors in a configuration."""
    form, build = configuration.form, configuration.build
    flags = build.flags if build else ()
    return {
        "model": configuration.model,
        "way": form.way,
        "base": form.base,
        "folded": form.folded,
        "merged": form.merged,
        "compiler": build.compiler[0] if build else None,
        "optimisation": tuple(flag for flag in flags if flag not in FACTOR_FLAGS),
        FAST_MATH: FAST_MATH in flags,
        WITH_LIBM: WITH_LIBM in flags,
        PAIRED: PAIRED in flags,
        SEPARATE: SEPARATE in flags,
        "precision": configuration.precision.name,
        "call": configuration.call,
    }


def _compilers(measurements: Sequence[Measurement]) -> Iterator[Factor]:
    """Yield the choice of each compiler instead of the first."""
    builds = [x.configuration.build for x in measurements]
    first, *others = dict.fromkeys(build.compiler[0] for build in builds if build) or [None]
    for name in others:
        yield Factor(f"{name} instead of {first}", "compiler", name, first)


def _ratios(measured: Sequence[tuple[Levels, Measurement]], factor: Factor) -> Iterator[tuple[float, float]]:
    """Yield the ratios of time and error of configurations with the choice to their counterparts."""
    counterparts = {factor.others(levels): m for levels, m in measured if factor.is_counterpart(levels)}
    for levels, m in measured:
        other = counterparts.get(factor.others(levels)) if factor.is_chosen(levels) else None
        if other and math.isfinite(m.error) and other.error > 0:
            yield m.ns / other.ns, m.error / other.error


def _units(of: str) -> Any:
    def text(measurement: Measurement) -> str:
        units: float = getattr(measurement.errors, of)
        return f"{units:.2g}" if units < 10 else f"{units:.0f}" if units < 1e4 else f"{units:.1e}"

    return text


declare(
    Measurement,
    Field("model", "configuration.model", json=False, column="model"),
    Field("way", "configuration.words", json=False, column="way"),
    Field("equations", "configuration.form.way"),
    Field("base", "configuration.form.base"),
    Field("folded", "configuration.form.folded"),
    Field("angles_summed", "configuration.form.merged"),
    Field("precision", "configuration.precision.name"),
    Field("compiler", lambda x: " ".join(x.build.compiler) if x.build else None),
    Field("flags", lambda x: x.build.options(x.configuration.form.package.name) if x.build else []),
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
    Field("share", lambda x: x.drift / x.energy if x.energy else math.inf, "of kinetic and elastic energy",
          form=".1e", json=False),
    *map(Field, ("energy", "steps", "step")),
)  # fmt: skip


def _measurements_table(measurements: Sequence[Measurement], on_front: Sequence[Measurement], title: str) -> Table:
    """Return a table of configurations, fastest first, with a mark on the front and on those that are not advised."""
    fastest = sorted(measurements, key=lambda x: x.ns)
    table = table_of(Measurement, fastest, title)
    marks = ["*" if _is_in(x, on_front) else "" if x.configuration.is_safe else "not advised" for x in fastest]
    rows = [(mark, *row) for mark, row in zip(marks, table.rows, strict=True)]
    return Table(("", *table.heads), rows, title)


def _is_in(measurement: Measurement, measurements: Sequence[Measurement]) -> bool:
    return any(measurement is other for other in measurements)


def _forms_table(choice: Choice) -> Table:
    """Return a table of the forms of direct_dynamics: operations and predicted errors."""
    title = "direct_dynamics: what generate --form auto takes"
    table = Table(("form", "operations", "predicted error, u", ""), title=title)
    for form in choice.forms:
        predicted = f"{form.error:.3g}" if math.isfinite(form.error) else "-"
        table.add_row(form.name, operations(form.count), predicted, "taken" if form.name == choice.chosen else "")
    return table


def _kind(trade: Trade) -> str:
    return "extreme" if trade.request.extreme else "moderate"


@parts_of.register
def trade_parts(trade: Trade, with_fast_math: bool = False, every: bool = False) -> list[Part]:
    """Return tables of the Pareto front (or of `every` point), of the effects of single choices, and of drifts."""
    of = "every point" if every else "none is faster and as accurate"
    parts: list[Part] = []
    for model, figures in trade.measurements.items():
        best = front(figures, with_fast_math)
        title = f"{trade.machine.name}, {model}: {of}, {trade.request.states} {_kind(trade)} states"
        parts.append(_measurements_table(figures if every else best, best, title))
        parts.append(table_of(Effect, effects(figures), f"{model}: effects of single choices"))
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
    points = [json_of(x) | {"front": _is_in(x, on_front)} for x in measurements]
    return {"points": points, "choices": plain(effects(measurements))}


def _advice_json(advised: Advice, words: Sequence[str]) -> dict[str, Any]:
    return {
        "sentence": sentence(advised),
        "tolerance": advised.tolerance,
        "commands": commands(advised.fastest, words),
        "fastest": {x.configuration.model: json_of(x) for x in advised.fastest},
        "one_state": {x.configuration.model: json_of(x) for x in advised.one_state},
    }


declare(
    Trade,
    Field("machine", "machine.name"),
    Field("states", _kind),
    Field("models", lambda x: {model: _model_json(measured) for model, measured in x.measurements.items()}),
    Field("measurements", lambda x: [*chain(*x.measurements.values())], rows=Measurement, json=False),
    Field("drift", "drifts"),
    *map(Field, ("form", "notes", "curves")),
)


@parts_of.register
def guaranteed_parts(curve: GuaranteedCurve) -> list[Part]:
    """Return a table with a row per step of the path, the advice, and notes on the evidence."""
    title = f"{curve.model} within {curve.within}: operations against guaranteed error, of the tolerance"
    heads = ("form", "precision", "terms left out", "operations", "time", "rounding", "", "terms", "", "sum")
    table = Table(heads, title=title)
    first, total = curve.points[0], 0.0
    for point in (curve.points[k] for k in curve.path):
        total = max(total, point.total)
        program = (point.form, point.precision, str(point.left_out), operations(point.operations))
        errors = (*_contribution(point.rounding), *_contribution(point.terms), _share(total))
        table.add_row(*program, f"{point.time / first.time:.0%}", *errors)
    words = {part.evidence for k in curve.path for part in (curve.points[k].rounding, curve.points[k].terms)}
    return [table, advice(curve), *[confidence("95 %")] * (Evidence.CONFIDENT in words)]


def advice(curve: GuaranteedCurve) -> str:
    """Return a sentence: the end of the path, and its largest error at unseen states."""
    point, less = curve.advised, f"{curve.saved:.0%} less time than the full model in double precision"
    what = f"{curve.model} within {curve.within}: {point.form}, {point.precision} precision"
    if not point.left_out:
        return f"{what}, nothing omitted: {less}"
    terms = f"{point.left_out} terms left out for {point.share:.0%} of the tolerance"
    return f"{what}, {terms}: {less}; at a million unseen states they use at most {point.unseen:.0%} of it"


def _contribution(part: Error) -> tuple[str, str]:
    short = {Evidence.PROVEN: "proven", Evidence.CONFIDENT: "95 %", Evidence.NONE: ""}
    return _share(part.value), short[part.evidence] if part.value else ""


def _share(x: float) -> str:
    return at_most(x) if x else "0"
