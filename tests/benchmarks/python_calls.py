"""Time calls from Python: `python -m tests.benchmarks.python_calls [--json FILE] [--rounds N]`.

For machines with all ten inertial parameters, numbers folded: a call at one state, and a state of a call at many, by
backend c, by ctypes, by numpy and by Pinocchio's binding, which take turns in one process; the least of all rounds,
as other processes only add time. Numbers are compared first. Then what the import of an installed package takes.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import sysconfig
import tempfile
import timeit
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.api.loaded import _by_ctypes, load
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.extension import FLAGS
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.python import render_python
from symoro_elastic.foundation.output_files import fill_folder, temporary_folder
from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import Array
from tests.benchmarks.machines import MACHINES, with_base_parameters
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.tables import print_table, save_json

MODELS = {"inverse_dynamics": "rnea", "direct_dynamics": "aba"}
STATES = 1000
ROUND_S = 2e-3
OURS, CTYPES, NUMPY, PINOCCHIO = "backend c", "by ctypes", "numpy", "Pinocchio"
BY_STATES = {1: (OURS, CTYPES, NUMPY, PINOCCHIO), STATES: (OURS, CTYPES, NUMPY)}
"""Who is timed; Pinocchio's binding takes one state a call."""

Call = Callable[[], Any]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.python_calls", description=__doc__)
    parser.add_argument("--json", type=Path, help="write the figures here too")
    parser.add_argument("--rounds", type=int, default=60)
    arguments = parser.parse_args()
    require_pinocchio()
    figures = [figure for name in MACHINES for model in MODELS for figure in figures_of(name, model, arguments.rounds)]
    columns = ["", "model", "states", OURS, CTYPES, NUMPY, PINOCCHIO, "times faster than Pinocchio", "import, ms"]
    print_table("ns a state, called from Python", columns, map(row, figures))
    if arguments.json:
        save_json(arguments.json, {"figures": figures})


def row(figure: dict[str, Any]) -> list[str]:
    times = [f"{figure[name]:.0f}" for name in (OURS, CTYPES, NUMPY, PINOCCHIO)]
    ratio, imported = f"{figure['ratio']:.1f}", f"{figure['import_ms']:.1f}"
    return [figure["machine"], figure["model"], str(figure["states"]), *times, ratio, imported]


def figures_of(name: str, model: str, rounds: int) -> list[dict[str, Any]]:
    """The least time of a state, ns, by contestant, for one state a call and for many."""
    machine = with_base_parameters(MACHINES[name]())
    loaded = {OURS: load(machine, model, backend="c", fold=["all"]), NUMPY: load(machine, model, fold=["all"])}
    package = loaded[OURS].package
    figures: list[dict[str, Any]] = []
    imported = import_ms(package)
    with temporary_folder() as folder:
        code = compile_package(package, Path(folder), flags=FLAGS)
    (function,) = package.functions
    functions = {key: getattr(of, model) for key, of in loaded.items()}
    functions[CTYPES] = _by_ctypes(code, package, function, functions[NUMPY])
    rng = np.random.default_rng(0)
    for count, contestants in BY_STATES.items():
        lead = () if count == 1 else (count,)
        values = [rng.uniform(-1.0, 1.0, (*lead, argument.size)) for argument in function.arguments]
        calls: dict[str, Call] = {key: partial(functions[key], *values) for key in contestants if key in functions}
        expected = first(calls[NUMPY]())
        if PINOCCHIO in contestants:
            calls[PINOCCHIO] = of_pinocchio(MACHINES[name](), model, values, first(calls[OURS]()))
        assert all(np.allclose(first(calls[key]()), expected, rtol=1e-10, atol=1e-10) for key in functions)
        ns = {key: value / count for key, value in take_turns(calls, rounds).items()}
        alone = ns.get(PINOCCHIO) or figures[0][PINOCCHIO]
        about: dict[str, Any] = {"machine": name, "model": model, "states": count, "import_ms": imported}
        figures.append({**about, **ns, PINOCCHIO: alone, "ratio": alone / ns[OURS]})
    return figures


def first(results: Any) -> Array:
    return results[0] if isinstance(results, tuple) else results


def of_pinocchio(machine: Machine, model: str, values: list[Array], expected: Array) -> Call:
    """A call of its binding with the forces of springs added before, and the same result where it has the same."""
    import pinocchio as pin

    from tests.references import pinocchio_model

    built = pinocchio_model._build(machine, None)
    q, qd, third = values
    if model == "direct_dynamics":
        forces = pinocchio_model._joint_forces(built, q, qd)
        forces[built.numbers.motors] += third
        third = forces
    else:
        whole = np.zeros(len(q))
        whole[built.numbers.motors] = third
        third = whole
    x = [np.ascontiguousarray(pinocchio_model._put(built, array)) for array in (q, qd, third)]
    algorithm, description, data = getattr(pin, MODELS[model]), built.model, built.model.createData()
    found = np.array(algorithm(description, data, *x))[built.order]
    if model == "direct_dynamics" or len(found) == len(expected):
        assert np.allclose(found, expected, rtol=1e-9, atol=1e-9)
    return partial(algorithm, description, data, *x)


def take_turns(calls: dict[str, Call], rounds: int) -> dict[str, float]:
    """The least time of a call, ns."""
    timers = {name: timeit.Timer("call()", globals={"call": call}) for name, call in calls.items()}
    numbers = {name: max(1, round(ROUND_S / min(timer.repeat(3, 3)) * 3)) for name, timer in timers.items()}
    least = dict.fromkeys(calls, np.inf)
    for _ in range(rounds):
        for name, timer in timers.items():
            least[name] = min(least[name], timer.timeit(numbers[name]) / numbers[name] * 1e9)
    return least


def import_ms(package: Package) -> float:
    """The least time that the import of the built package takes in a fresh process that has numpy, ms."""
    with tempfile.TemporaryDirectory() as folder:
        files, place = render_python(package), Path(folder)
        (place / package.name).mkdir()
        fill_folder(place, files)
        sources = [name for name in files if name.endswith(".c")]
        flags = ["-O1", "-fPIC", "-shared", f"-DTABLE={package.name}_table", f"-I{sysconfig.get_path('include')}"]
        command = ["gcc", *flags, *sources, "-lm", "-o", f"{package.name}/_calls.so"]
        subprocess.run(command, cwd=place, check=True, timeout=600)
        script = f"import numpy, time; t = time.perf_counter(); import {package.name}; print(time.perf_counter() - t)"
        runs = [
            subprocess.run([sys.executable, "-c", script], cwd=place, check=True, capture_output=True, text=True)
            for _ in range(7)
        ]
    return 1e3 * min(float(run.stdout) for run in runs)


if __name__ == "__main__":
    main()
