"""The fastest configuration within a tolerance as a sentence, and the commands that build it."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symoro_elastic.analysis.trade_off.configurations import (
    BATCH,
    SINGLE_CALL,
    Measurement,
    fastest_within,
    most_accurate,
)
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.evaluation.quantile_bound import CONFIDENCE
from symoro_elastic.numerics.verification.accuracy import UNSEEN

STANDARD = "-std=c99"


@dataclass(frozen=True)
class Advice:
    """The fastest configurations of one build within a tolerance, by model; also for calls with one state.

    `one_state` is empty where the fastest are such calls, or where no such call is within the tolerance.
    """

    tolerance: float
    fastest: tuple[Measurement, ...]
    one_state: tuple[Measurement, ...]


def advice(
    measured: Mapping[str, Sequence[Measurement]], source: str, tolerance: float, with_fast_math: bool = False
) -> Advice:
    """Return the fastest build for all models together, from measurements by model.

    Raises `InputError` about the `source` that names the nearest if there is none.
    """
    for model, measurements in measured.items():
        if fastest_within(measurements, tolerance, with_fast_math) is None:
            nearest = most_accurate(measurements, with_fast_math)
            what = f"none of the ways tried to compute {model} keeps {_promise(tolerance)}: nearest is "
            what += f"{_nearest(nearest, tolerance)}, with "
            raise InputError(source, "--tolerance", what + nearest.configuration.words)
    flat = [x for measurements in measured.values() for x in measurements]
    models = list(measured)
    fastest = _of_one_build(flat, models, tolerance, with_fast_math)
    if not fastest:
        what = f"no build is within {tolerance:.1e} for all of {', '.join(models)}: ask for one --model at a time"
        raise InputError(source, "--tolerance", what)
    single = [x for x in flat if x.configuration.call == SINGLE_CALL]
    batch = fastest[0].configuration.call == BATCH
    return Advice(tolerance, fastest, _of_one_build(single, models, tolerance, with_fast_math) if batch else ())


def _nearest(measurement: Measurement, tolerance: float) -> str:
    """Return the error bound as text, with the measured error if only the latter is within the tolerance."""
    if not math.isfinite(measurement.bound):
        return "without a bound (measure at more --states)"
    within = f" (worst of {measurement.errors.judged} states {measurement.error:.1e}: measure at more --states)"
    return f"{measurement.bound:.1e}{within if measurement.error <= tolerance else ''}"


def _of_one_build(
    measurements: Iterable[Measurement], models: Sequence[str], tolerance: float, with_fast_math: bool
) -> tuple[Measurement, ...]:
    """Return the fastest configurations by model, all of one package and library; empty if no build has all."""
    groups: dict[Any, list[Measurement]] = {}
    for x in measurements:
        c, form = x.configuration, x.configuration.form
        key = form.base, form.folded, form.merged, c.build, c.precision.name, c.call
        groups.setdefault(key, []).append(x)
    complete = []
    for group in groups.values():
        by_model = [[x for x in group if x.configuration.model == model] for model in models]
        best = [fastest_within(some, tolerance, with_fast_math) for some in by_model]
        if all(best):
            complete.append(tuple(x for x in best if x))
    return min(complete, key=lambda some: sum(x.ns for x in some), default=())


def sentence(advised: Advice) -> str:
    """Return the advice as one sentence."""
    text = f"{_promise(advised.tolerance, 'W')}, the fastest is {_text(advised.fastest)}"
    return text + (f"; for one state a call, {_text(advised.one_state)}." if advised.one_state else ".")


def _promise(tolerance: float, w: str = "w") -> str:
    """Return a tolerance and its evidence as text."""
    evidence = f"with {CONFIDENCE:.0%} confidence at {UNSEEN} unseen states by the tail of the errors"
    return f"{w}ithin a relative error of {tolerance:.1e}, {evidence}, inputs in double"


def _text(measurements: Sequence[Measurement]) -> str:
    configuration = measurements[0].configuration
    options = ["base parameters"] * configuration.form.base + ["folded constants"] * configuration.form.folded
    options += ["angles summed"] * configuration.form.merged
    models = " and ".join(
        f"{x.configuration.model} by {x.configuration.form.way} in {x.ns:.3g} ns a state "
        f"(worst of {x.errors.judged} states {x.error:.1e}, bound {x.bound:.1e})"
        for x in measurements
    )
    how = ", ".join([configuration.precision.name, configuration.made_by, configuration.call, *options])
    return f"{how}: {models}"


def commands(measurements: Sequence[Measurement], words: Sequence[str]) -> list[str]:
    """Return the command lines that generate and compile one build; `words` are the machine and its options."""
    configuration = measurements[0].configuration
    form, name = configuration.form, configuration.form.package.name
    models = [x.configuration.form.traced[x.configuration.model].model.name for x in measurements]
    words_of_call = [*words, *(word for name in models for word in ("--model", name))]
    words_of_call += ["--base"] if form.base and "--base" not in words else []
    words_of_call += ["--fold", "all"] if form.folded and "all" not in words else []
    words_of_call += ["--merge-angles", f"{form.bound:g}"] if form.merged else []
    target = "c-batch" if configuration.call == BATCH else "c"
    words_of_call += ["--target", target if configuration.build else "numpy"]
    has_suffix = configuration.build and configuration.precision.suffix
    words_of_call += ["--precision", configuration.precision.name] if has_suffix else []
    generate = shlex.join(["symoro-elastic", "generate", *words_of_call])
    if configuration.build is None:
        return [generate]
    stem = f"{name}{configuration.precision.suffix}"
    flags = [*configuration.build.compiler, STANDARD, *configuration.build.options(name)]
    sources = [f"generated/{name}/{stem}.c"]
    sources += [f"generated/{name}/{stem}_batch.c"] if configuration.call == BATCH else []
    return [generate, shlex.join([*flags, "-c", *sources])]
