"""Sweeps by several processes: the same bytes, and nothing lost where one dies."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.sweeps import running
from symoro_elastic.analysis.sweeps.running import Processes
from symoro_elastic.analysis.sweeps.tasks import Task
from symoro_elastic.api.options import Sweeping
from symoro_elastic.api.sweeps import plan
from symoro_elastic.formats import write_machine
from tests.analysis.sweeps.machines import SLIDE, squared

ROOT = Path(__file__).parents[3]
DYING = """
from pathlib import Path
import symoro_elastic as se
from symoro_elastic.analysis.sweeps.sweep import save
from tests.analysis.sweeps.machines import SLIDE, squared_unless_killed
found = se.sweep(SLIDE, over={"m": "1:30:30"}, of=squared_unless_killed, workers=2, journal="journal")
save(found, "found.npz")
print(*found.reasons, sep="|")
"""


def python(folder: Path, *arguments: str) -> str:
    """Python in a process of its own, in which no thread runs beside it."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "SWEEP_TEST": str(folder)}
    ran = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return ran.stdout


@pytest.mark.thorough
def test_two_processes_write_the_bytes_of_one(tmp_path: Path) -> None:
    write_machine(se.read(SLIDE), tmp_path / "slide.toml")
    found = se.sweep(
        SLIDE, over={"m": "1:3:4", "load.k": "1e4:1e5:3,log"}, of="response", hold=["all"],
        outputs=["load.z"], inputs=["load.fz"],
    )  # fmt: skip
    over = ("--over", "m=1:3:4", "--over", "load.k=1e4:1e5:3,log", "--hold", "all")
    signals = ("--of", "response", "--input", "load.fz", "--output", "load.z")
    python(
        tmp_path, "-m", "symoro_elastic", "sweep", "slide.toml", *over, *signals, "--workers", "2", "--out", "two.csv"
    )
    assert found.write(tmp_path / "one.csv").read_bytes() == (tmp_path / "two.csv").read_bytes()
    assert not (tmp_path / "two.csv.journal").exists()


def test_a_process_that_dies_loses_nothing(tmp_path: Path) -> None:
    """The point 5 ends its process once, 13 each time: that one is given up, all others are there."""
    reasons = python(tmp_path, "-c", DYING).strip().split("|")
    with np.load(tmp_path / "found.npz") as arrays:
        squares = arrays["squared"]
    assert {m: reason for m, reason in enumerate(reasons, 1) if reason} == {13: running.DIED}
    assert np.isnan(squares[12])
    assert [x for m, x in enumerate(squares, 1) if m != 13] == [m**2 for m in range(1, 31) if m != 13]
    points = [json.loads(line)["point"] for line in (tmp_path / "journal").read_text().splitlines()[1:]]
    assert sorted(points) == list(range(30))


@pytest.mark.thorough
def test_processes_that_begin_anew_compute_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """They do where other threads run, which a copy of this process would not have."""
    monkeypatch.setattr(running.threading, "active_count", lambda: 2)
    assert running._context().get_start_method() == "spawn"
    planned = plan(se.read(SLIDE), Sweeping(over={"m": "1:2:3"}, of=squared))
    rows = list(enumerate(planned.design.points.tolist()))
    found = [pair for some in Processes(Task(planned.swept, planned.quantities), 1).outcomes(rows) for pair in some]
    assert {k: one.figures for k, one in found} == {0: {"squared": 1.0}, 1: {"squared": 2.25}, 2: {"squared": 4.0}}
