"""Configurations under comparison, compiled one way or run by numpy, and the Pareto front of their time and error."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter

from symoro_elastic.analysis.trade_off.builds import Build
from symoro_elastic.analysis.trade_off.formulations import Formulation
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.verification.accuracy import Errors
from symoro_elastic.symbolic.program import OperationCount

MATTERS = 1.25
"""Ratio of worst errors over random states above which the difference is significant."""

SINGLE_CALL, BATCH = "single call", "batch"
CALLS = (SINGLE_CALL, BATCH)
BURST = 1e-3  # s
ROUNDS = 15
MOST_TIMES = 1 << 20


@dataclass(frozen=True)
class Configuration:
    """One way to compute a model; `build` is None for numpy."""

    model: str
    form: Formulation
    build: Build | None
    precision: Precision = field(hash=False)
    call: str

    @property
    def made_by(self) -> str:
        """Compiler and flags, or numpy."""
        return self.build.words if self.build else "numpy"

    @property
    def words(self) -> str:
        """Formulation, precision, compiler and call as text for a table."""
        return f"{self.form.words}; {self.precision.name}; {self.made_by}; {self.call}"

    @property
    def is_safe(self) -> bool:
        """Whether the configuration may be advised: not with -ffast-math."""
        return self.build is None or self.build.is_safe

    @property
    def is_slow(self) -> bool:
        """Whether the configuration, or the computation of its errors, is too slow for tens of thousands of states."""
        return self.precision.is_pair or (self.build is None and self.call == SINGLE_CALL)


@dataclass(frozen=True)
class Measurement:
    """Time and errors of a configuration.

    Errors are those of the results that a user gets who has inputs and parameters in double precision.
    """

    configuration: Configuration
    time: Time
    errors: Errors

    @property
    def build(self) -> Build | None:
        """Compiler and flags of the configuration; None for numpy."""
        return self.configuration.build

    @property
    def ns(self) -> float:
        """Median time per state, ns."""
        return self.time.median

    @property
    def error(self) -> float:
        """Worst error relative to the largest entry of a result."""
        return self.errors.relative

    @property
    def bound(self) -> float:
        """Bound on the errors at untested states, relative to the largest entry of a result."""
        return self.errors.bound

    @property
    def count(self) -> OperationCount:
        """Operations of a call."""
        return self.configuration.form.count(self.configuration.model)


def front(measurements: Iterable[Measurement], with_fast_math: bool = False) -> list[Measurement]:
    """Return the Pareto front of time and error, fastest first; nearly equal accuracy counts as equal.

    Configurations with -ffast-math are on it only if `with_fast_math` allows them.
    """
    best: list[Measurement] = []
    for x in sorted(_advisable(measurements, with_fast_math), key=lambda f: (f.ns, f.error)):
        if math.isfinite(x.error) and (not best or x.error * MATTERS < best[-1].error):
            best.append(x)
    return best


def fastest_within(
    measurements: Iterable[Measurement], tolerance: float, with_fast_math: bool = False
) -> Measurement | None:
    """Return the fastest configuration whose error bound at untested states is within a tolerance, or None."""
    good = [x for x in _advisable(measurements, with_fast_math) if x.bound <= tolerance]
    return min(good, key=lambda x: x.ns, default=None)


def most_accurate(measurements: Iterable[Measurement], with_fast_math: bool = False) -> Measurement:
    """Return the configuration with the smallest error bound, the fastest if several have it."""
    advisable = _advisable(measurements, with_fast_math)
    return min(advisable, key=lambda x: (math.inf if math.isnan(x.bound) else x.bound, x.ns))


def _advisable(measurements: Iterable[Measurement], with_fast_math: bool) -> list[Measurement]:
    return [x for x in measurements if with_fast_math or x.configuration.is_safe]


@dataclass(frozen=True)
class Run:
    """Work to be timed: `carry_out(times)` repeats it for `states` states."""

    carry_out: Callable[[int], None]
    states: int


@dataclass(frozen=True)
class Time:
    """Time per state, ns: median and best of the rounds."""

    median: float
    best: float


def time_runs(runs: Sequence[Run], rounds: int = ROUNDS, progress: Progress = no_progress) -> list[Time]:
    """Return the times of all runs; a round lasts about `BURST` seconds for every run."""
    times = []
    for run in runs:
        run.carry_out(1)
        times.append(min(MOST_TIMES, math.ceil(BURST / max(_seconds(run, 1), 1e-9))))
    samples: list[list[float]] = [[] for _ in runs]
    for done in range(rounds):
        for run, often, sample in zip(runs, times, samples, strict=True):
            sample.append(_seconds(run, often) / (often * run.states) * 1e9)
        progress(done + 1, rounds)
    return [Time(median(sample), min(sample)) for sample in samples]


def _seconds(run: Run, times: int) -> float:
    start = perf_counter()
    run.carry_out(times)
    return perf_counter() - start
