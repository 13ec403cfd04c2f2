"""What a point of a sweep costs, and what several processes gain: `python -m tests.benchmarks.sweeps`.

The speed-up is that of the time on the clock, least of several runs that take turns; beside it that which the processor
times allow, which other work of the machine does not change: all of one process over what each of several takes.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import symoro_elastic as se
from symoro_elastic.machine.machine import Machine
from tests.command_line import EXAMPLES

RUNS = 2
COUNT = 1000
OVER = {"ram.k": "1e6:1e8:50,log", "motor_y": "0:0.2:20"}
ANALYSES: dict[str, dict[str, Any]] = {
    "modes": {},
    "response": {"of": "response", "inputs": ["tool.fx"], "outputs": ["tool.x"], "damping": 0.02},
}


def processor(work: Callable[[], object]) -> float:
    """Processor time of this process, s, least of several runs."""
    return min(_processor(work) for _ in range(RUNS))


def _processor(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def points(machine: Machine) -> None:
    """Print what a point costs, traced anew and in a sweep."""
    few = {"ram.k": "1e6:1e8:20,log"}
    for name, given in ANALYSES.items():
        many = processor(partial(se.sweep, machine, over=few, hold=["all"], **given))
        one = processor(partial(se.sweep, machine, over={"ram.k": [1e6]}, hold=["all"], **given))
        each = (many - one) / 19
        print(f"{name:10} first point {1e3 * one:6.1f} ms, each other {1e3 * each:6.2f} ms, {1 / each:5.0f} a second")


def workers(machine: Machine, folder: Path) -> None:
    """Print the times of one and of two processes, and whether they write the same bytes."""
    clock: dict[int, list[float]] = {1: [], 2: []}
    used: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(RUNS):
        for count in (1, 2):
            began, before = time.perf_counter(), os.times()
            found = se.sweep(machine, over=OVER, hold=["all"], workers=count)
            clock[count].append(time.perf_counter() - began)
            own, others = ((after - first) for after, first in zip(_summed(os.times()), _summed(before), strict=True))
            used[count].append(own + others / count)
            found.write(folder / f"{count}.csv", force=True)
    same = (folder / "1.csv").read_bytes() == (folder / "2.csv").read_bytes()
    first, second = (min(clock[count]) for count in (1, 2))
    print(f"{COUNT} points of modes: {first:.1f} s by one process, {second:.1f} s by two: {first / second:.2f} times")
    print(f"by processor times {min(used[1]) / min(used[2]):.2f} times; {'the same' if same else 'OTHER'} bytes")


def _summed(times: os.times_result) -> tuple[float, float]:
    """Processor time of this process, and of those that it began and that have ended."""
    return times.user + times.system, times.children_user + times.children_system


def beginnings(machine: Machine) -> None:
    """Print how long it takes until two processes have computed a little."""
    for name, start in (("copies of this one", _copies), ("a local Dask cluster", _dask)):
        began = time.perf_counter()
        start(machine)
        print(f"4 points by two processes, {name:20}: {time.perf_counter() - began:5.2f} s")


def _copies(machine: Machine) -> None:
    se.sweep(machine, over={"ram.k": "1e6:1e8:4,log"}, hold=["all"], workers=2)


def _dask(machine: Machine) -> None:
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, protocol="tcp", dashboard_address=":0") as local:
        se.sweep(machine, over={"ram.k": "1e6:1e8:4,log"}, hold=["all"], scheduler=local.scheduler_address)


def main() -> None:
    """Print all figures."""
    machine = se.read(EXAMPLES / "two_axis.toml", warn=lambda line: None)
    print(f"{os.cpu_count()} cores; {os.getloadavg()[0]:.1f} processes at work on average in the last minute")
    points(machine)
    with tempfile.TemporaryDirectory() as folder:
        workers(machine, Path(folder))
    beginnings(machine)


if __name__ == "__main__":
    main()
