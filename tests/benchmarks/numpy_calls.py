"""Time generated numpy against the same expressions on arrays: `python -m tests.benchmarks.numpy_calls [--json FILE]`.

6R arm, inverse model. Processor time; each contestant has a process of its own. What plain arrays cost depends on the
heap: one that keeps the memory of freed arrays, as glibc's does once a large array has been freed, or one that gives
it back to the system, as a young process's does. Both are set by glibc's variables and timed. So are two parts of a
batch that numpy cannot do without: as many calls of its operations, on one number each, and the sines and cosines.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from symoro_elastic.machine.scene import Scene
from tests.benchmarks.contest import Times
from tests.benchmarks.machines import arm_6
from tests.benchmarks.tables import print_table, save_json
from tests.generated_code import imported, rendered

MODEL = "inverse_dynamics"
STATES = 4096
ROUND_NS = 3e7
ON_ARRAYS = SimpleNamespace(sin=np.sin, cos=np.cos, sqrt=np.sqrt, sign=np.sign, atan2=np.arctan2)
# What glibc does with the memory of freed arrays.
HEAPS = {
    "keeps": {"MALLOC_TRIM_THRESHOLD_": str(2**30), "MALLOC_MMAP_THRESHOLD_": str(2**25)},
    "gives back": {"MALLOC_TRIM_THRESHOLD_": str(2**17), "MALLOC_MMAP_THRESHOLD_": str(2**17)},
}
TARGETS = {1: 9.0, STATES: 4.0}

Call = Callable[[], Any]
Array = np.ndarray[Any, Any]


def plainly(module: Any, states: Array) -> Call:
    """Every variable a new array, the constants of the parameters at hand."""
    model = getattr(module, f"_{MODEL}").model
    constants = model.constants(ON_ARRAYS, module.DEFAULTS.tolist())

    def call() -> Any:
        results = model.program(ON_ARRAYS, *(x.T for x in states), constants)
        return [np.stack(entries, axis=-1) for entries in results]

    return call


def directly(module: Any, states: Array) -> Call:
    q, qd, qdd = states[:, 0] if len(states[0]) == 1 else states
    return lambda: module.inverse_dynamics(q, qd, qdd)


def bare(module: Any, states: Array) -> Call:
    """As many calls of numpy's operations as its blocks take, each on arrays of one number."""
    steps = getattr(module, f"_{MODEL}").model.steps
    operations = [operation for operation, *_ in steps.steps] * (STATES // steps.block_length(STATES, states.dtype))
    first, second, result = np.ones((3, 1), states.dtype)

    def call() -> None:
        for operation in operations:
            operation(first, second, result)

    return call


def sines(module: Any, states: Array) -> Call:
    """Of all angles but the first, which the model does not need."""
    angles, result = np.ascontiguousarray(states[0].T[1:]), np.empty(STATES, states.dtype)

    def call() -> None:
        for angle in angles:
            np.sin(angle, result)
            np.cos(angle, result)

    return call


WORK = {
    "plain arrays": plainly,
    "generated": directly,
    "its calls, on one number": bare,
    "its sines and cosines": sines,
}


class Contestant(NamedTuple):
    """Who does what: a key of WORK, the number of states, the name of their type, a key of HEAPS."""

    work: str
    states: int
    dtype: str
    heap: str

    def against(self) -> Contestant:
        return self._replace(work="plain arrays")

    def wanted(self) -> str:
        return f"{TARGETS[self.states]:g}" if self.work == "generated" and self.dtype == "float64" else ""


CONTESTANTS = [
    *(Contestant(work, 1, "float64", "keeps") for work in ("plain arrays", "generated")),
    *(
        Contestant(work, STATES, dtype, heap)
        for dtype in ("float64", "float32")
        for heap in HEAPS
        for work in WORK
        if heap == "keeps" or WORK[work] in (plainly, directly)
    ),
]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.numpy_calls", description=__doc__)
    parser.add_argument("--json", type=Path, help="write the figures here too")
    parser.add_argument("--rounds", type=int, default=25)
    arguments = parser.parse_args()
    times = take_turns(arguments.rounds)
    figures = [figure(times, contestant) for contestant in CONTESTANTS]
    rows = [
        [str(f["work"]), str(f["states"]), str(f["dtype"]), str(f["heap"]), f"{f['ns']:.0f}", f"{f['ratio']:.1f}"]
        for f in figures
    ]
    columns = ["", "states", "type", "freed memory", "ns a state", "times faster than plain arrays", "wanted"]
    wanted = [contestant.wanted() for contestant in CONTESTANTS]
    print_table(f"numpy, 6R arm, {MODEL}", columns, [[*row, w] for row, w in zip(rows, wanted, strict=True)])
    if arguments.json:
        save_json(arguments.json, {"figures": figures})


def figure(times: Times, contestant: Contestant) -> dict[str, str | float]:
    name, plain = str(contestant), str(contestant.against())
    return {**contestant._asdict(), "ns": times.median(name), "ratio": times.ratio(plain, name)}


def take_turns(rounds: int) -> Times:
    """Nanoseconds a state, each contestant in its own process, one at a time."""
    context = get_context("spawn")
    pipes = []
    with tempfile.TemporaryDirectory() as folder:
        for name, text in rendered(arm_6(), Scene((MODEL,)), ("numpy",)).items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for contestant in CONTESTANTS:
            here, there = context.Pipe()
            with patch.dict(os.environ, HEAPS[contestant.heap]):
                context.Process(target=compete, args=(there, folder, contestant), daemon=True).start()
            here.recv()
            pipes.append(here)
        ns = np.array([[turn(pipe) for pipe in pipes] for _ in range(rounds)])
        for pipe in pipes:
            pipe.send(False)
    return Times(tuple(map(str, CONTESTANTS)), ns)


def turn(pipe: Connection) -> float:
    pipe.send(True)
    return float(pipe.recv())


def compete(pipe: Connection, folder: str, contestant: Contestant) -> None:
    """Wait for a turn, call often enough for the clock, send nanoseconds a state."""
    module, count = imported(Path(folder)), contestant.states
    states = np.random.default_rng(0).uniform(-2.0, 2.0, (3, count, 6)).astype(contestant.dtype)
    call = WORK[contestant.work](module, states)
    calls = max(1, round(ROUND_NS / once(call, 3)))
    pipe.send(True)
    while pipe.recv():
        pipe.send(once(call, calls) / count)


def once(call: Call, calls: int) -> float:
    start = time.process_time_ns()
    for _ in range(calls):
        call()
    return max(1, time.process_time_ns() - start) / calls


if __name__ == "__main__":
    main()
