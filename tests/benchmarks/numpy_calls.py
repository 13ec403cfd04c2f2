"""Time generated numpy against the same expressions on arrays: `python -m tests.benchmarks.numpy_calls [--json FILE]`.

6R arm, inverse model. Processor time; each contestant has a process of its own, as what plain arrays cost depends on
what the process has allocated before.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace
from typing import Any

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
# Number of states, their type, whether on plain arrays.
CONTESTANTS = {
    "one state, plain arrays": (1, np.float64, True),
    "one state": (1, np.float64, False),
    f"{STATES} states, plain arrays": (STATES, np.float64, True),
    f"{STATES} states": (STATES, np.float64, False),
    f"{STATES} states, float32, plain arrays": (STATES, np.float32, True),
    f"{STATES} states, float32": (STATES, np.float32, False),
}
TARGETS = {"one state": 9.0, f"{STATES} states": 4.0}


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.numpy_calls", description=__doc__)
    parser.add_argument("--json", type=Path, help="write the figures here too")
    parser.add_argument("--rounds", type=int, default=25)
    arguments = parser.parse_args()
    times = take_turns(arguments.rounds)
    figures = [figure(times, name) for name in CONTESTANTS]
    rows = [
        [str(f["contestant"]), f"{f['ns']:.0f}", f"{f['ratio']:.1f}", wanted(str(f["contestant"]))] for f in figures
    ]
    print_table(f"numpy, 6R arm, {MODEL}", ["", "ns a state", "times faster than plain arrays", "wanted"], rows)
    if arguments.json:
        save_json(arguments.json, {"figures": figures})


def figure(times: Times, name: str) -> dict[str, str | float]:
    plain = f"{name.removesuffix(', plain arrays')}, plain arrays"
    return {"contestant": name, "ns": times.median(name), "ratio": times.ratio(plain, name)}


def wanted(name: str) -> str:
    return f"{TARGETS[name]:g}" if name in TARGETS else ""


def take_turns(rounds: int) -> Times:
    """Nanoseconds a state, each contestant in its own process, one at a time."""
    context = get_context("spawn")
    pipes = []
    with tempfile.TemporaryDirectory() as folder:
        for name, text in rendered(arm_6(), Scene((MODEL,)), ("numpy",)).items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        for name in CONTESTANTS:
            here, there = context.Pipe()
            context.Process(target=contestant, args=(there, folder, name), daemon=True).start()
            here.recv()
            pipes.append(here)
        ns = np.array([[turn(pipe) for pipe in pipes] for _ in range(rounds)])
        for pipe in pipes:
            pipe.send(False)
    return Times((*CONTESTANTS,), ns)


def turn(pipe: Connection) -> float:
    pipe.send(True)
    return float(pipe.recv())


def contestant(pipe: Connection, folder: str, name: str) -> None:
    """Wait for a turn, call often enough for the clock, send nanoseconds a state."""
    count, dtype, plain = CONTESTANTS[name]
    module = imported(Path(folder))
    states = np.random.default_rng(0).uniform(-2.0, 2.0, (3, count, 6)).astype(dtype)
    call = plainly(module, states) if plain else directly(module, states)
    calls = max(1, round(ROUND_NS / once(call, 3)))
    pipe.send(True)
    while pipe.recv():
        pipe.send(once(call, calls) / count)


def once(call: Callable[[], Any], calls: int) -> float:
    start = time.process_time_ns()
    for _ in range(calls):
        call()
    return max(1, time.process_time_ns() - start) / calls


def directly(module: Any, states: np.ndarray[Any, Any]) -> Callable[[], Any]:
    q, qd, qdd = states[:, 0] if len(states[0]) == 1 else states
    return lambda: module.inverse_dynamics(q, qd, qdd)


def plainly(module: Any, states: np.ndarray[Any, Any]) -> Callable[[], Any]:
    """Every variable a new array, the constants of the parameters at hand."""
    model = getattr(module, f"_{MODEL}").model
    constants = model.constants(ON_ARRAYS, module.DEFAULTS.tolist())

    def call() -> Any:
        results = model.program(ON_ARRAYS, *(x.T for x in states), constants)
        return [np.stack(entries, axis=-1) for entries in results]

    return call


if __name__ == "__main__":
    main()
