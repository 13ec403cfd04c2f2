"""Time to generate, compile and call chains of n joints: `python -m tests.benchmarks.growth [--joints 6 25 ...]`.

The exponent is that of the power of n that fits best the times beyond 25 joints. A call is the best of many, in
nanoseconds for each joint. `--derivatives N` does the same for both models' derivatives of a general chain of N joints.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from symoro_elastic.codegen.compile import compile_library
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.symbolic.memory import no_collection
from tests.benchmarks.contest import COMPILERS
from tests.benchmarks.machines import chain
from tests.benchmarks.ours import Code, scalar
from tests.benchmarks.tables import print_table, progress, save_json
from tests.references.random_machines import chain as general_chain

T = TypeVar("T")

MODELS = ("inverse_dynamics", "direct_dynamics")
DERIVATIVES = ("inverse_dynamics_derivatives", "direct_dynamics_derivatives")
CALL = "ns a joint"
FIT_FROM = 25
ROUNDS = 200


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.growth", description=__doc__)
    parser.add_argument("--joints", type=int, nargs="+", default=[6, 10, 25, 50, 100, 200, 300])
    parser.add_argument("--derivatives", type=int, nargs="*", default=[10, 30], help="joints of chains derived")
    parser.add_argument("--most-compiled", type=int, default=300, help="longest chain that is compiled")
    parser.add_argument("--general", action="store_true", help="alpha, d and r symbolic in place of quarter turns")
    parser.add_argument("--level", default="-O2", help="of optimization: --level=-O1")
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    build = general_chain if arguments.general else chain
    wanted = [(model, build, n) for model in MODELS for n in arguments.joints]
    wanted += [(model, general_chain, n) for model in DERIVATIVES for n in arguments.derivatives]
    figures = [
        figures_of(model, made(n), n <= arguments.most_compiled, (arguments.level,))
        for model, made, n in progress(wanted, "generate, compile")
    ]
    steps = ["trace", "render", *COMPILERS, CALL]
    for model in (*MODELS, *DERIVATIVES):
        chosen = [figure for figure in figures if figure["model"] == model]
        rows = [[f"{f['joints']}", f"{f['operations']}", *(_seconds(f.get(step)) for step in steps)] for f in chosen]
        exponents = [_exponent(chosen, step) for step in ["operations", *steps]]
        rows.append(["exponent", *(f"{e:.2f}" if math.isfinite(e) else "-" for e in exponents)])
        print_table(
            f"{model} of a chain: seconds of the processor ({arguments.level})", ["joints", "operations", *steps], rows
        )
    if arguments.json:
        save_json(arguments.json, figures)


def figures_of(model: str, machine: Machine, compiles: bool, flags: Sequence[str]) -> dict[str, str | float]:
    """Seconds of the processor for each step; generation, without garbage collection, is the better of two runs."""
    scene, n = Scene(models=(model,)), len(machine.joints)
    package, traced = _timed(lambda: programs(machine, scene).package)
    made = Code(package, package.functions[0], DOUBLE)
    files, rendered = _timed(lambda: made.files)
    figures: dict[str, str | float] = {"model": model, "joints": n, "trace": traced, "render": rendered}
    figures["operations"] = made.operations.products + made.operations.add
    with tempfile.TemporaryDirectory() as folder:
        for compiler in COMPILERS if compiles else ():
            start = os.times()
            compile_library(files, Path(folder), (compiler,), flags)
            end = os.times()
            figures[compiler] = end.children_user + end.children_system - start.children_user - start.children_system
    if compiles and COMPILERS:
        figures[CALL] = _call(made, COMPILERS[0], flags) / n
    return figures


def _call(made: Code, compiler: str, flags: Sequence[str]) -> float:
    """Nanoseconds of a call, parameters prepared: the best of many rounds."""
    x = np.full((4, sum(made.inputs)), 0.3)
    contestant = scalar(made, x, "a call", compiler, flags)
    contestant.settle()
    return min(contestant.once(contestant.passes) for _ in range(ROUNDS))


@no_collection()
def _timed(step: Callable[[], T]) -> tuple[T, float]:
    best = math.inf
    for _ in range(2):
        start = time.process_time()
        result = step()
        best = min(best, time.process_time() - start)
    return result, best


def _exponent(figures: Sequence[dict[str, str | float]], step: str) -> float:
    points = [(float(f["joints"]), float(f[step])) for f in figures if step in f and float(f["joints"]) >= FIT_FROM]
    if len(points) < 2:
        return math.nan
    n, seconds = np.log(np.array(points)).T
    return float(np.polyfit(n, seconds, 1)[0])


def _seconds(value: str | float | None) -> str:
    return "-" if value is None else f"{float(value):.3g}"


if __name__ == "__main__":
    main()
