"""Time the generated numpy code against its own expressions on plain arrays: `python -m tests.benchmarks.arrays`."""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np

from symoro_elastic.codegen.python import render_numpy
from symoro_elastic.numerics.candidates import import_package
from tests.benchmarks.contest import Array, Contestant, contest, difference
from tests.benchmarks.machines import MACHINES, rigid, with_base_parameters
from tests.benchmarks.ours import code
from tests.benchmarks.tables import print_table, progress, save_json

BATCH = 4096
MODELS = ("inverse_dynamics", "direct_dynamics")
ARRAYS = SimpleNamespace(sin=np.sin, cos=np.cos, sqrt=np.sqrt, sign=np.sign, atan2=np.arctan2)
AIMS = {1: 9.0, BATCH: 4.0}
"""States: how many times faster than plain arrays the inverse model of the 6R arm is to be."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.arrays", description=__doc__)
    parser.add_argument("--rounds", type=int, default=51)
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    wanted = [(title, model, n) for title in MACHINES for model in MODELS for n in AIMS]
    figures = [figures_of(*one, arguments.rounds) for one in progress(wanted, "generate and time")]
    columns = ["", "model", "states", "plain, us a state", "ours", "single", "times faster", "single", "difference"]
    print_table("Generated numpy code against the same expressions on plain arrays", columns, map(_row, figures))
    for figure in figures:
        if (figure["machine"], figure["model"]) == ("6R arm", "inverse_dynamics"):
            aim, ratio = AIMS[int(figure["states"])], float(figure["ratio"])
            enough = "ok" if ratio >= aim else "not met"
            print(f"{figure['machine']}, {figure['states']} states: wanted x{aim:g}, x{ratio:.3g}: {enough}")
    if arguments.json:
        save_json(arguments.json, figures)


def figures_of(title: str, model: str, states: int, rounds: int) -> dict[str, str | float]:
    machine = MACHINES[title]()
    machine = with_base_parameters(rigid(machine) if model == "inverse_dynamics" else machine)
    with tempfile.TemporaryDirectory() as folder:
        package = code(machine, model).package
        module = import_package(render_numpy(package), Path(folder) / "numpy")
        rng = np.random.default_rng(0)
        inputs = [rng.uniform(-2, 2, (states, argument.size)) for argument in package.functions[0].arguments]
        plain = _contestant("plain", partial(_plain, module, model), inputs)
        double = _contestant("double", getattr(module, model), inputs)
        single = _contestant("single", getattr(module, model), [x.astype(np.float32) for x in inputs])
        apart = difference(double.results(), plain.results())
        times = contest([plain, double, single], rounds)
    return {
        "machine": title,
        "model": model,
        "states": states,
        **{name: times.median(name) for name in times.names},
        "ratio": times.ratio("plain", "double"),
        "ratio single": times.ratio("plain", "single"),
        "difference": apart,
    }


def _plain(module: ModuleType, model: str, *inputs: Array) -> Array:
    """The first result, from the lines of the program on one array a quantity."""
    lines = getattr(module, f"_{model}")
    constants = lines.constants(ARRAYS, ())
    entries = lines.program(ARRAYS, *(np.moveaxis(x, -1, 0) for x in inputs), constants)[0]
    return np.stack([np.broadcast_to(entry, inputs[0].shape[:-1]) for entry in entries], axis=-1)


def _contestant(name: str, function: Callable[..., object], inputs: list[Array]) -> Contestant:
    """A function of stacked states; one state is given without the leading axis, but to plain arrays."""
    states = len(inputs[0])
    given = [x[0] if states == 1 and name != "plain" else x for x in inputs]

    def run(passes: int, *_: object) -> float:
        start = time.perf_counter_ns()
        for _ in range(passes):
            function(*given)
        return time.perf_counter_ns() - start

    def columns(_: Array) -> Array:
        result = function(*given)
        first = result[0] if isinstance(result, tuple) else result
        return np.asarray(first, float).reshape(states, -1)

    nothing = np.empty(0)
    return Contestant(name, run, nothing, nothing, columns, states)


def _row(figure: dict[str, str | float]) -> list[str]:
    times = [f"{float(figure[name]) / 1e3:.3g}" for name in ("plain", "double", "single")]
    ratios = [f"x{float(figure[name]):.3g}" for name in ("ratio", "ratio single")]
    words = [str(figure[name]) for name in ("machine", "model", "states")]
    return [*words, *times, *ratios, f"{figure['difference']:.0e}"]


if __name__ == "__main__":
    main()
