"""Stored tables of Monte Carlo runs of everything that is estimated from measurements."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest

pytest.importorskip("scipy")

from tests.benchmarks import identification, joint, logs, possible, ring_downs, sensors, tables, updating
from tests.benchmarks.tables import RunOf

TABLES: dict[str, tuple[Mapping[str, int], RunOf]] = {
    module.__name__.rpartition(".")[2]: (module.TABLE, module.table_run)
    for module in (identification, joint, logs, possible, ring_downs, sensors, updating)
}
RECOMPUTED = [
    ("identification", "cylindrical arm, coarse encoders, spikes", 6),
    ("identification", "large load friction", 2),
    ("identification", "very large load friction", 4),
    ("joint", "elastic arm", 2),  # the second begins far from the log, whose narrow valley the fit has to reach
    ("logs", "mistake: minutes", 3),
    ("logs", "delay of 6 ms", 6),
    ("possible", "6 s, with file", 4),
    ("ring_downs", "damping 5 %", 40),
    ("sensors", "3 % spikes", 4),
    ("updating", "spikes: lathe", 4),
    ("updating", "slightly late: lathe", 4),
    ("updating", "undisturbed: ball_screw under its drive", 8),
    ("updating", "undisturbed: lathe under its drives", 8),
]
"""Tables, rows and numbers of runs that are computed again; two of ring-downs in the test command."""
KNOWN: dict[str, set[str]] = {}
"""Rows whose intervals are too narrow in some runs without a remark."""


@pytest.mark.parametrize("name", list(TABLES))
def test_stored_tables_are_those_of_their_benchmarks(name: str) -> None:
    """Rows and numbers of runs; counts that include each other."""
    rows, sizes = tables.stored(name), TABLES[name][0]
    assert {title: len(runs) for title, runs in rows.items()} == dict(sizes)
    for runs in rows.values():
        assert [run.seed for run in runs] == list(range(len(runs)))
        for run in runs:
            assert run.verdict in ("accepted", "reported", "rejected")
            assert 0 <= run.covered <= run.intervals <= run.parameters and run.identified <= run.intervals
            assert 0 <= run.median_error <= run.worst_error and all(map(math.isfinite, run.metrics))


@pytest.mark.parametrize("name", list(TABLES))
def test_stored_intervals_cover_the_truth_or_the_program_reports_why(name: str) -> None:
    """95 %, but for three standard deviations of so many correlated intervals; rows known to be wrong are listed."""
    rows = tables.stored(name)
    assert {title for title in rows if tables.is_silently_wrong(rows, title)} == KNOWN.get(name, set())


@pytest.mark.parametrize(
    ("name", "title", "count"),
    [("ring_downs", "noise 0.03", 2), *(pytest.param(*row, marks=pytest.mark.thorough) for row in RECOMPUTED)],
)
def test_runs_are_those_of_stored_tables(name: str, title: str, count: int) -> None:
    """But for sampling errors of counts and coverage, and stated ratios of errors."""
    rows, runs = tables.stored(name), tables.stored(name)[title][:count]
    assert not tables.differences(rows, runs, [TABLES[name][1](title, run.seed) for run in runs])


def test_differences_beyond_sampling_errors_are_reported() -> None:
    """Coverage, verdicts, numbers, errors and metrics of a table of 10 runs of 20 intervals."""
    runs = [tables.Run(seed, "accepted", 20, 20, 20, 19, 0.01, 0.1, [1.0]) for seed in range(10)]
    rows = {"row": runs}
    assert tables.differences(rows, runs, runs) == []
    for change, text in (
        ({"verdict": "rejected"}, "rejected 10 of 10, 0 stored"),
        ({"covered": 16}, "coverage 0.800, 0.950 stored"),
        ({"identified": 15}, "identified: 150, 200 stored"),
        ({"intervals": 15, "covered": 15}, "intervals: 150, 200 stored"),
        ({"median_error": 0.02}, "median error 0.02, 0.01 stored"),
        ({"worst_error": 0.3}, "worst error 0.3, 0.1 stored"),
        ({"metrics": [1.1]}, "seed 0: [1.1], [1.0] stored"),
    ):
        assert text in tables.differences(rows, runs, [run._replace(**change) for run in runs])  # type: ignore[arg-type]
    less = [run._replace(covered=19 - run.seed % 2) for run in runs]
    assert tables.differences(rows, runs, less) == []
    assert not tables.is_silently_wrong({"row": less}, "row")
    assert tables.is_silently_wrong({"row": [run._replace(covered=16) for run in runs]}, "row")
