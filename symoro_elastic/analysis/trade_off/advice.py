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
    Configuration,
    Measurement,
    fastest_within,
    most_accurate,
)
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.quantile_bound import CONFIDENCE
from symoro_elastic.numerics.verification.accuracy import UNSEEN

STANDARD = "-std=c99"


@dataclass(frozen=True)
class Advice:
    """The fastest configurations within a tolerance, one for each model, all of one build; those of one state a call.

    `one_state` is empty where the fastest are such calls, or where none of these is within the tolerance.
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
    every = [one for measurements in measured.values() for one in measurements]
    models = list(measured)
    fastest = _of_one_build(every, models, tolerance, with_fast_math)
    if not fastest:
        what = f"no build is within {tolerance:.1e} for all of {', '.join(models)}: ask for one --model at a time"
        raise InputError(source, "--tolerance", what)
    single = [one for one in every if one.configuration.call == SINGLE_CALL]
    batch = fastest[0].configuration.call == BATCH
    return Advice(tolerance, fastest, _of_one_build(single, models, tolerance, with_fast_math) if batch else ())


def _nearest(one: Measurement, tolerance: float) -> str:
    """Return a bound that is above a tolerance; what was measured, where only that is within it."""
    if not math.isfinite(one.bound):
        return "without a bound (measure at more --states)"
    within = f" (worst of {one.errors.judged} states {one.error:.1e}: measure at more --states)"
    return f"{one.bound:.1e}{within if one.error <= tolerance else ''}"


def _of_one_build(
    measurements: Iterable[Measurement], models: Sequence[str], tolerance: float, with_fast_math: bool
) -> tuple[Measurement, ...]:
    """Return the fastest configurations, one a model, of one package and one library; none where no build has all."""
    groups: dict[Any, list[Measurement]] = {}
    for one in measurements:
        configuration = one.configuration
        key = (
            configuration.form.base,
            configuration.form.folded,
            configuration.form.merged,
            configuration.build,
            configuration.precision.name,
            configuration.call,
        )
        groups.setdefault(key, []).append(one)
    complete = []
    for group in groups.values():
        best = [
            fastest_within([one for one in group if one.configuration.model == model], tolerance, with_fast_math)
            for model in models
        ]
        if all(best):
            complete.append(tuple(one for one in best if one))
    return min(complete, key=lambda some: sum(one.ns for one in some), default=())


def sentence(advised: Advice) -> str:
    """Return the advice as one sentence."""
    said = f"{_promise(advised.tolerance, 'W')}, the fastest is {_said(advised.fastest)}"
    return said + (f"; for one state a call, {_said(advised.one_state)}." if advised.one_state else ".")


def _promise(tolerance: float, w: str = "w") -> str:
    """Return what a tolerance means."""
    held = f"with {CONFIDENCE:.0%} confidence at {UNSEEN} states that were not tried by the tail of the errors"
    return f"{w}ithin a relative error of {tolerance:.1e}, {held}, inputs in double"


def _said(measurements: Sequence[Measurement]) -> str:
    configuration = measurements[0].configuration
    options = ["base parameters"] * configuration.form.base + ["folded constants"] * configuration.form.folded
    options += ["angles summed"] * configuration.form.merged
    models = " and ".join(
        f"{chosen.model} by {chosen.form.way} in {one.ns:.3g} ns a state "
        f"(worst of {one.errors.judged} states {one.error:.1e}, bound {one.bound:.1e})"
        for chosen, one in ((one.configuration, one) for one in measurements)
    )
    how = ", ".join([configuration.precision.name, configuration.made_by, configuration.call, *options])
    return f"{how}: {models}"


def commands(measurements: Sequence[Measurement], words: Sequence[str]) -> list[str]:
    """Return the command lines that generate and compile one build; `words` are the machine and its options."""
    configuration = measurements[0].configuration
    form, name = configuration.form, configuration.form.package.name
    asked = [*words, *(word for one in measurements for word in ("--model", _written(one.configuration)))]
    asked += ["--base"] if form.base and "--base" not in words else []
    asked += ["--fold", "all"] if form.folded and "all" not in words else []
    asked += ["--merge-angles", f"{form.bound:g}"] if form.merged else []
    target = "c-batch" if configuration.call == BATCH else "c"
    asked += ["--target", target if configuration.build else "numpy"]
    asked += (
        ["--precision", configuration.precision.name] if configuration.build and configuration.precision.suffix else []
    )
    generate = shlex.join(["symoro-elastic", "generate", *asked])
    if configuration.build is None:
        return [generate]
    stem = f"{name}{configuration.precision.suffix}"
    flags = [*configuration.build.compiler, STANDARD, *configuration.build.options(name)]
    sources = [f"generated/{name}/{stem}.c"]
    sources += [f"generated/{name}/{stem}_batch.c"] if configuration.call == BATCH else []
    return [generate, shlex.join([*flags, "-c", *sources])]


def _written(configuration: Configuration) -> str:
    return configuration.form.traced[configuration.model].model.name
