"""Generated MATLAB code run by GNU Octave: many calls and lines of code in one process, arrays through .mat files."""

from __future__ import annotations

import inspect
import math
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import loadmat, savemat

from symoro_elastic.codegen.matlab_function import LISTS, matlab_name
from symoro_elastic.codegen.package import Function, Package, Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.states import moderate_states

Array = NDArray[np.float64]

OCTAVE = shutil.which("octave-cli")
needs_octave = pytest.mark.skipif(OCTAVE is None, reason="needs octave-cli (package octave)")
needs_mkoctfile = pytest.mark.skipif(shutil.which("mkoctfile") is None, reason="needs mkoctfile (package octave-dev)")


@dataclass(frozen=True)
class Call:
    """A call: the function as Octave says it (`arm.jacobian(`, `arm_mex('jacobian', `), arrays, number of results."""

    function: str
    arguments: Sequence[Array]
    results: int = 1


@dataclass(frozen=True)
class Answer:
    """What a call gave: its results, or its error."""

    results: tuple[Array, ...]
    error: str


def octave(calls: Sequence[Call], folder: Path, paths: Sequence[Path] = (), before: str = "") -> list[Answer]:
    """Return what Octave answers to each call, in one process with `paths`, after the lines `before`."""
    folder.mkdir(parents=True, exist_ok=True)
    given = np.empty((len(calls), 1), dtype=object)
    for k, call in enumerate(calls):
        given[k, 0] = np.empty((1, len(call.arguments)), dtype=object)
        for j, argument in enumerate(call.arguments):
            given[k, 0][0, j] = argument
    savemat(folder / "in.mat", {"given": given})
    lines = [*(f"addpath('{path}');" for path in paths), before]
    lines += ["load('in.mat');", f"answers = cell({len(calls)}, 1); errors = repmat({{''}}, {len(calls)}, 1);"]
    for k, call in enumerate(calls, start=1):
        lines += ["try", f"r = cell(1, {call.results}); a = given{{{k}}};"]
        lines += [f"[r{{:}}] = {call.function}a{{:}});", f"answers{{{k}}} = r;", "catch e"]
        lines += [f"errors{{{k}}} = e.message;", "end_try_catch"]
    lines += ["save('-v6', 'out.mat', 'answers', 'errors');"]
    run_octave("\n".join(lines), folder)
    found = loadmat(folder / "out.mat")
    errors = ["".join(x[0].tolist()) for x in found["errors"]]
    return [
        Answer(tuple(x[0].ravel().tolist()) if not error else (), error)
        for x, error in zip(found["answers"], errors, strict=True)
    ]


def run_octave(text: str, folder: Path) -> str:
    """Return what Octave prints of lines of code, run in a folder."""
    assert OCTAVE
    (folder / "calls.m").write_text(text + "\n")
    command = [OCTAVE, "--no-history", "--no-init-file", "--no-gui", "--quiet", "calls.m"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    return run.stdout


def written(files: Mapping[str, str], folder: Path) -> Path:
    """Return the folder, with generated files in it."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def as_argument(name: str, array: Array) -> Array:
    """States (N, entries) as columns; a placement T, a rotation R0 as pages of matrices."""
    rows = {"T": 4, "R0": 3}.get(name, 0)
    if rows:
        return np.moveaxis(array.reshape(-1, rows, rows), 0, -1)
    return array.T


def as_result(array: Array, result: Result) -> Array:
    """A result (N, ...) of numpy as MATLAB has it: frames, then states, last."""
    if len(result.shape) > 1 and result.quantity.axes[0] in LISTS:
        array = np.moveaxis(array, 1, -1)
    return np.moveaxis(array, 0, -1)


def arguments_of(function: Function, machine: Machine, count: int, module: Any, p: Array) -> dict[str, Array]:
    """Moderate states for each argument of a function; targets of inverse models are placements of the last frame."""
    states = moderate_states(machine, count)
    found = {}
    for argument in function.arguments:
        if argument.name in ("T", "P"):
            own = [x for x in (states.q, states.q_dep) if x.size][
                : len(inspect.signature(module.geometric_model).parameters) - 1
            ]
            T = module.geometric_model(*own, p=p)[:, -1]
            found[argument.name] = T.reshape(count, 16) if argument.name == "T" else T[:, :3, 3]
        elif hasattr(states, argument.name):
            found[argument.name] = getattr(states, argument.name)
        else:
            found[argument.name] = np.random.default_rng(0).uniform(0.1, 1, (count, argument.size))
    return found


def by_numpy(module: Any, function: Function, arguments: Mapping[str, Array], p: Array) -> list[Array]:
    """Results (N, ...) of the numpy package, one state a call: on plain floats, with the sines of the C library."""
    model = getattr(module, function.name)
    count = len(next(iter(arguments.values()), [0]))
    found = []
    for k in range(count):
        results = model(**{name: array[k] for name, array in arguments.items()}, p=p)
        results = results if isinstance(results, tuple) else (results,)
        if any(np.isnan(result).any() for result in results):
            results = _by_program(getattr(module, f"_{function.name}").model, [x[k] for x in arguments.values()], p)
        found.append(results)
    return [np.stack(each) for each in zip(*found, strict=True)]


def _guarded(function: Any) -> Any:
    """A function of the C library, NaN where it has no value."""

    def call(*x: float) -> np.float64:
        try:
            return np.float64(function(*x))
        except ValueError:
            return np.float64(np.nan)

    return call


ON_NUMBERS = SimpleNamespace(
    **{name: _guarded(getattr(math, name)) for name in ("sin", "cos", "sqrt", "atan2")}, sign=np.sign
)


def _by_program(model: Any, state: Sequence[Array], p: Array) -> tuple[Array, ...]:
    """What the numpy package leaves to operations on arrays, whose sines are others: states at which NaN occurs."""
    with np.errstate(all="ignore"):
        constants = model.constants(ON_NUMBERS, [*p])
        entries = model.program(ON_NUMBERS, *map(list, state), constants)
    return tuple(np.array(x, float).reshape(shape) for x, shape in zip(entries, model.shapes, strict=True))


def ulps(found: Array, wanted: Array) -> float:
    """Largest difference in units in the last place of the wanted entries; infinite where shapes or NaN differ."""
    if found.shape != wanted.shape or (np.isnan(found) != np.isnan(wanted)).any():
        return np.inf
    with np.errstate(invalid="ignore"):
        apart = np.where(found == wanted, 0.0, np.abs(found - wanted) / np.spacing(np.abs(wanted)))
    return float(np.nanmax(apart, initial=0.0))


def calls_of(
    package: Package, machine: Machine, module: Any, count: int
) -> tuple[list[Call], list[Call], list[list[Array]]]:
    """Calls of all functions, `.m` and MEX, and what numpy makes of them."""
    own, mex, wanted = [], [], []
    values = parameter_values(machine)
    p = np.array([values[name] for name in module.PARAMETERS])
    for function in package.functions:
        arguments = arguments_of(function, machine, count, module, p)
        arrays = [*(as_argument(name, array) for name, array in arguments.items()), p[:, None]]
        results = len(function.results)
        own.append(Call(f"{matlab_name(package.name)}.{function.name}(", arrays, results))
        mex.append(Call(f"{package.name}_mex('{function.name}', ", arrays, results))
        found = by_numpy(module, function, arguments, p)
        wanted.append([as_result(array, r) for array, r in zip(found, function.results, strict=True)])
    return own, mex, wanted
