"""The effect of one choice by itself: measurements of configurations that differ in nothing else, compared."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median

from symoro_elastic.analysis.trade_off.builds import CONTRACTED, FAST_MATH, PAIRED, PLAIN, SEPARATE, WITH_LIBM
from symoro_elastic.analysis.trade_off.configurations import BATCH, SINGLE_CALL, Configuration, Measurement
from symoro_elastic.analysis.trade_off.formulations import BY_MATRIX, RECURSION

Levels = Mapping[str, Hashable]
"""The level of every factor in a configuration, by its name."""
FACTOR_FLAGS = (FAST_MATH, WITH_LIBM, PAIRED, SEPARATE, *CONTRACTED.values())
"""Flags that are factors by themselves."""


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
        """Whether a configuration has made the choice."""
        return self._applies(levels) and levels[self.name] == self.chosen

    def is_counterpart(self, levels: Levels) -> bool:
        """Whether a configuration has the other level."""
        level = levels[self.name]
        others = level != self.chosen if self.instead_of is None else level == self.instead_of
        return self._applies(levels) and others

    def others(self, levels: Levels) -> tuple[Hashable, ...]:
        """Return the levels of all other factors: equal for configurations that can be compared."""
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
    Factor(
        "-O2 instead of what the source recommends",
        "optimisation",
        PLAIN,
        None,
        {FAST_MATH: False, WITH_LIBM: False, SEPARATE: False},
    ),
)


def effects(measurements: Sequence[Measurement]) -> list[Effect]:
    """Return the effect of every choice for which there are configurations to compare."""
    measured = [(levels_of(one.configuration), one) for one in measurements]
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
    """Yield every compiler against the first."""
    builds = [one.configuration.build for one in measurements]
    first, *others = dict.fromkeys(build.compiler[0] for build in builds if build) or [None]
    for name in others:
        yield Factor(f"{name} instead of {first}", "compiler", name, first)


def _ratios(measured: Sequence[tuple[Levels, Measurement]], factor: Factor) -> Iterator[tuple[float, float]]:
    """Yield the ratios of time and error of each configuration with the choice to its counterpart."""
    counterparts = {factor.others(levels): one for levels, one in measured if factor.is_counterpart(levels)}
    for levels, one in measured:
        other = counterparts.get(factor.others(levels)) if factor.is_chosen(levels) else None
        if other and math.isfinite(one.error) and other.error > 0:
            yield one.ns / other.ns, one.error / other.error
