"""How benchmarks print, store and compare their figures."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple, TypeVar

from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table

T = TypeVar("T")
DATA = Path(__file__).parent / "data"
P_95 = 0.95
Z_95 = 1.96  # standard deviations
IDENTIFIED_RATIO = 0.1  # of the number of identified parameters: verdicts near their bound flip
MEDIAN_RATIO = 1.5
"""Three standard deviations of the median of 50 independent absolute values of normal errors, over that median."""
WORST_RATIO = 2.0
"""Of largest errors: twice the standard deviation, or another minimum."""
METRICS = 0.02  # relative difference of metrics, chi2 among them, of fits that are in one minimum


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Text to the left, figures to the right."""
    table = Table(title=title, box=box.SIMPLE_HEAD, title_justify="left")
    for k, column in enumerate(columns):
        table.add_column(column, justify="right" if k else "left")
    for row in rows:
        table.add_row(*row)
    Console(highlight=False, width=None if sys.stdout.isatty() else 180).print(table)


def met(is_met: bool) -> str:
    """Whether a goal is met, in words."""
    return "met" if is_met else "NOT MET"


def save_json(file: Path, figures: Any) -> None:
    file.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


def progress(items: Sequence[T], title: str) -> Iterable[T]:
    """The items, with a bar on a terminal's stderr."""
    console = Console(stderr=True)
    return track(items, title, console=console, disable=not console.is_terminal, transient=True)


class Run(NamedTuple):
    """A run of a stored table: a verdict, numbers of parameters, and relative errors of identified ones.

    `accepted` is what the program reports without a remark on what disturbs the data, `reported` with one, `rejected`
    an `InputError`. `covered` of the intervals of 95 % contain the truth. `metrics` are those of a benchmark alone.
    """

    seed: int
    verdict: str
    parameters: int = 0
    identified: int = 0
    intervals: int = 0
    covered: int = 0
    median_error: float = 0.0
    worst_error: float = 0.0
    metrics: Sequence[float] = ()


Runs = Mapping[str, Sequence[Run]]
"""Runs by row of a table."""
RunOf = Callable[[str, int], Run]
"""Returns the run of a row with a seed."""


def run_of(seed: int, verdict: str, errors: Iterable[Error], metrics: Iterable[float] = ()) -> Run:
    """Return a run of estimates; their relative errors and metrics are rounded to four digits."""
    errors = list(errors)
    intervals = [error for error in errors if math.isfinite(error.std)]
    sizes = [abs(error.error) / error.size for error in intervals if error.is_identified and error.size]
    rounded = [float(f"{x:.4g}") for x in (median(sizes or [0.0]), max(sizes, default=0.0), *metrics)]
    identified = sum(bool(error.is_identified) for error in errors)
    covered = sum(bool(abs(error.error) < Z_95 * error.std) for error in intervals)
    return Run(seed, verdict, len(errors), identified, len(intervals), covered, rounded[0], rounded[1], rounded[2:])


class Error(NamedTuple):
    """Estimate minus truth, its standard deviation, the size that it is relative to, and whether it is identified."""

    error: float
    std: float
    size: float
    is_identified: bool


def stored(name: str) -> dict[str, list[Run]]:
    """Return the runs of a table in `data`, by row."""
    rows = json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))
    return {title: [Run(*run) for run in runs] for title, runs in rows.items()}


def store(name: str, rows: Runs) -> None:
    """Write rows of a table to `data`, a row a line; its other rows stay."""
    file = DATA / f"{name}.json"
    rows = {**(stored(name) if file.exists() else {}), **rows}
    lines = [f"{json.dumps(title)}: {json.dumps(runs)}" for title, runs in sorted(rows.items())]
    file.write_text("{\n " + ",\n ".join(lines) + "\n}\n", encoding="utf-8")


def coverage(runs: Sequence[Run]) -> float:
    """Return the fraction of intervals that contain the truth; NaN without any."""
    intervals = sum(run.intervals for run in runs)
    return sum(run.covered for run in runs) / intervals if intervals else math.nan


def sampling_error(rows: Runs, runs: Sequence[Run]) -> float:
    """Return three standard deviations of the coverage of runs of a table, whose estimates of a run are correlated.

    The binomial variance, times the ratio of variances between runs of all rows to binomial ones.
    """
    between, binomial, least = 0.0, 0.0, P_95 * (1 - P_95)
    for row in rows.values():
        p = coverage(row)
        if len(row) > 1 and p >= P_95 - 0.1:
            squares = sum((run.covered - p * run.intervals) ** 2 for run in row)
            between += squares * len(row) / (len(row) - 1)
            binomial += sum(run.intervals for run in row) * least
    intervals = sum(run.intervals for run in runs)
    return 3 * math.sqrt(max(between / (binomial or 1.0), 1.0) * least / intervals) if intervals else 1.0


def is_silently_wrong(rows: Runs, title: str) -> bool:
    """Whether intervals of a row contain the truth too seldom, and the program accepts some of the runs."""
    runs = [run for run in rows[title] if run.verdict == "accepted"]
    return coverage(runs) < P_95 - sampling_error(rows, runs)


def differences(rows: Runs, runs: Sequence[Run], again: Sequence[Run]) -> list[str]:
    """Return how runs of the same seeds differ by more than their sampling error from stored ones, of these rows."""
    parts, n = [], len(runs)
    for verdict in sorted({run.verdict for run in (*runs, *again)}):
        before, now = (sum(run.verdict == verdict for run in table) for table in (runs, again))
        p = (before + 0.5) / (n + 1)
        if abs(now - before) > 3 * math.sqrt(n * p * (1 - p)):
            parts.append(f"{verdict} {now} of {n}, {before} stored")
    for what in ("identified", "intervals"):
        before, now = (sum(getattr(run, what) for run in table) for table in (runs, again))
        if abs(now - before) > IDENTIFIED_RATIO * before:
            parts.append(f"{what}: {now}, {before} stored")
    if abs(coverage(again) - coverage(runs)) > sampling_error(rows, runs):
        parts.append(f"coverage {coverage(again):.3f}, {coverage(runs):.3f} stored")
    quantiles = [[median(run.median_error for run in x), max(run.worst_error for run in x)] for x in (runs, again)]
    for what, ratio, old, new in zip(("median", "worst"), (MEDIAN_RATIO, WORST_RATIO), *quantiles, strict=True):
        if not old / ratio <= new <= old * ratio:
            parts.append(f"{what} error {new:.3g}, {old:.3g} stored")
    for run, other in zip(runs, again, strict=True):
        if any(abs(a - b) > METRICS * abs(a) for a, b in zip(run.metrics, other.metrics, strict=True)):
            parts.append(f"seed {run.seed}: {list(other.metrics)}, {list(run.metrics)} stored")
    return parts


def line(title: str, rows: Runs) -> str:
    """Return the counts and quantiles of a row of a table."""
    runs = rows[title]
    verdicts = ", ".join(f"{verdict} {count}" for verdict, count in sorted(Counter(x.verdict for x in runs).items()))
    sums = [sum(column) for column in zip(*(run[2:6] for run in runs), strict=True)]
    worst = max(run.worst_error for run in runs)
    metrics = "".join(f", {median(x):.4g}" for x in zip(*(run.metrics for run in runs), strict=True))
    return (
        f"{title}: {verdicts}; {sums[1]} of {sums[0]} identified; coverage {coverage(runs):.3f} +- "
        f"{sampling_error(rows, runs):.3f} of {sums[2]}; errors: median "
        f"{100 * median(run.median_error for run in runs):.3g} %, worst {100 * worst:.3g} %"
        + (f"; medians of metrics: {metrics[2:]}" if metrics else "")
    )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add --store, --stored and --row."""
    parser.add_argument("--store", action="store_true", help="write the table of counts and errors to `data`")
    parser.add_argument("--stored", action="store_true", help="compare with that table; exit 1 where it differs")
    parser.add_argument("--row", action="append", help="of --store and --stored, rows whose titles begin so")


def has_table_run(given: argparse.Namespace, name: str, seeds: Mapping[str, int], one_run: RunOf) -> bool:
    """Whether options request the stored table `name`: runs are stored or compared then, `seeds` of them by row."""
    rows: dict[str, list[Run]] = {} if given.store else stored(name)
    count, begun = 0, time.process_time()
    for title in seeds if given.store or given.stored else ():
        if given.row and not any(title.startswith(row) for row in given.row):
            continue
        before = rows.get(title, [])
        numbers = range(seeds[title]) if given.store else [run.seed for run in before]
        runs = [one_run(title, seed) for seed in progress(numbers, title)]
        parts = [] if given.store else differences(rows, before, runs)
        rows |= {title: runs} if given.store else {}
        count += bool(parts)
        print(line(title, {**rows, title: runs}) + "".join(f"\n    DIFFERS: {part}" for part in parts), flush=True)
    if given.store:
        store(name, rows)
    if given.store or given.stored:
        print(f"{count} of {len(rows)} rows differ; {time.process_time() - begun:.0f} s of processor")
    if count:
        sys.exit(1)
    return bool(given.store or given.stored)


def print_or_run_table(name: str, seeds: Mapping[str, int], one_run: RunOf) -> None:
    """Store or compare a table as the command line requests, or print the stored one."""
    parser = argparse.ArgumentParser(prog=f"python -m tests.benchmarks.{name}")
    add_options(parser)
    if not has_table_run(parser.parse_args(), name, seeds, one_run):
        rows = stored(name)
        print("\n".join(line(title, rows) for title in rows))
