"""Times of many functions, measured in turn so that other load on the computer affects all alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter

from symoro_elastic.foundation.progress import Progress, no_progress

BURST = 1e-3  # s
ROUNDS = 15
MOST_TIMES = 1 << 20


@dataclass(frozen=True)
class Run:
    """Work to be timed: `carry_out(times)` repeats it for `states` states."""

    carry_out: Callable[[int], None]
    states: int


@dataclass(frozen=True)
class Time:
    """ns a state: median and best of the rounds."""

    median: float
    best: float


def time_runs(runs: Sequence[Run], rounds: int = ROUNDS, progress: Progress = no_progress) -> list[Time]:
    """Return the times of all runs; each round takes about `BURST` seconds of each of them."""
    times = [_often_enough(run) for run in runs]
    samples: list[list[float]] = [[] for _ in runs]
    for done in range(rounds):
        for run, often, sample in zip(runs, times, samples, strict=True):
            sample.append(_seconds(run, often) / (often * run.states) * 1e9)
        progress(done + 1, rounds)
    return [Time(median(sample), min(sample)) for sample in samples]


def _often_enough(run: Run) -> int:
    """Return how often to repeat a run so that a burst is long enough to be timed."""
    run.carry_out(1)
    seconds = max(_seconds(run, 1), 1e-9)
    return min(MOST_TIMES, max(1, math.ceil(BURST / seconds)))


def _seconds(run: Run, times: int) -> float:
    start = perf_counter()
    run.carry_out(times)
    return perf_counter() - start
