"""Configurations compiled or imported, ready to be timed and to give results."""

from __future__ import annotations

import ctypes
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.trade_off.builds import Build
from symoro_elastic.analysis.trade_off.configurations import BATCH, CALLS, SINGLE_CALL, Configuration
from symoro_elastic.analysis.trade_off.formulations import Formulation
from symoro_elastic.analysis.trade_off.timing import Run
from symoro_elastic.codegen.c.wrappers import wrapper_context
from symoro_elastic.codegen.compile import TYPES, CompilationFailed, CompiledPackage, compile_library, load_library
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.foundation.progress import Progress
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.models.state import State
from symoro_elastic.numerics.implementations import Implementation, c_code, import_package, numpy_code
from symoro_elastic.numerics.verification.accuracy import round_states, rounded_values
from symoro_elastic.numerics.verification.states import States

TIMED_STATES, CACHED_NUMBERS = 240, 1_000_000
NUMPY_STATES = 4096


@dataclass(frozen=True)
class Ready:
    """A configuration that can be run: `results` gives its results at states, `run` is timed."""

    configuration: Configuration
    results: Implementation
    run: Run


def compiled_configurations(
    jobs: Sequence[tuple[Formulation, Build]], states: States, folder: Path, seconds: float, progress: Progress
) -> tuple[list[Ready], list[str]]:
    """Compile all jobs, as many at a time as there are processors; return them with notes on those that failed.

    Jobs that have not begun after `seconds` are left out.
    """
    started, ready, notes, late = time.monotonic(), [], [], 0
    sources: dict[tuple[Formulation, str], Mapping[str, str]] = {}
    for form, build in jobs:
        if (form, build.precision.name) not in sources:
            sources[form, build.precision.name] = _sources(form.package, build.precision)

    def made(number: int) -> list[Ready] | str | None:
        form, build = jobs[number]
        if time.monotonic() - started > seconds:
            return None
        try:
            return _made(form, build, sources[form, build.precision.name], states, folder / str(number))
        except CompilationFailed as error:
            return f"{build.words}, {build.precision.name}: left out, {error}"

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for done, one in enumerate(pool.map(made, range(len(jobs))), start=1):
            progress(done, len(jobs))
            if isinstance(one, str):
                notes.append(one)
            elif one is None:
                late += 1
            else:
                ready += one
    if late:
        what = f"{late} of {len(jobs)} builds left out after {seconds:.0f} s of compiling"
        notes.append(f"{what}: --effort all waits for them")
    return ready, notes


def _sources(package: Package, precision: Precision) -> Mapping[str, str]:
    files = render_c_batch(package, precision)
    name = package.name + precision.suffix
    functions = [_repeated(package, function, files[f"{name}.h"], precision) for function in package.functions]
    repeat = render("c/repeat.c.j2", name=name, real=precision.type_of_real(package.name), functions=functions)
    return files | {f"{name}_repeat.c": repeat}


def _repeated(package: Package, function: Function, header: str, precision: Precision) -> dict[str, Any]:
    """Return the context of a function in the template."""
    macro = f"{package.name}{precision.suffix}_{function.name}_CONSTANTS".upper()
    has_constants = f"#define {macro} " in header
    after_p = ("c",) if has_constants else ()
    return wrapper_context(package, function, precision, after_p) | {"constants": macro if has_constants else ""}


def _made(form: Formulation, build: Build, sources: Mapping[str, str], states: States, folder: Path) -> list[Ready]:
    library = compile_library(sources, folder, build.compiler, build.options(form.package.name))
    compiled = CompiledPackage(form.package, library, build.precision)
    loaded = load_library(library)
    p = parameters(form, build.precision)
    ready = []
    for model in form.traced:
        for call in CALLS:
            configuration = Configuration(model, form, build, build.precision, call)
            run = _c_run(loaded, configuration, form.package.functions, states, p)
            ready.append(Ready(configuration, c_code(compiled, p, call == BATCH), run))
    return ready


def parameters(form: Formulation, precision: Precision) -> AnyArray:
    """Return the array p of a formulation."""
    values = rounded_values(form.values, precision)
    return np.array([values[p.name] for p in form.package.parameters], dtype=float)


def _c_run(
    loaded: ctypes.CDLL, configuration: Configuration, functions: Sequence[Function], states: States, p: AnyArray
) -> Run:
    """Return the timed call of a configuration; it keeps its arrays alive."""
    traced, precision = configuration.form.traced[configuration.model], configuration.precision
    function = next(f for f in functions if f.name == traced.model.name)
    batch = configuration.call == BATCH
    entry = loaded[f"{precision.function(configuration.form.package.name, function.name)}_repeat{'_batch' * batch}"]
    dtype = TYPES[precision.state]
    some = states[: _timed_states(function)]
    inputs = [getattr(some, argument.name).astype(dtype) for argument in function.arguments]
    arrays = [np.ascontiguousarray(x.T if batch else x) for x in inputs]
    results = [np.zeros((len(some), math.prod(result.shape)), dtype) for result in function.results]
    arrays += [p.astype(dtype), *results]
    entry.argtypes = [ctypes.c_size_t] * 2 + [ctypes.c_void_p] * len(arrays)
    entry.restype = None

    def carry_out(times: int) -> None:
        entry(times, len(some), *(array.ctypes.data for array in arrays))

    return Run(carry_out, len(some))


def _timed_states(function: Function) -> int:
    """Return how many states fit into the caches of a processor."""
    numbers = sum(a.size for a in function.arguments) + sum(math.prod(r.shape) for r in function.results)
    return max(1, min(TIMED_STATES, CACHED_NUMBERS // max(1, numbers)))


def numpy_configurations(form: Formulation, states: States, folder: Path) -> list[Ready]:
    """Return the generated numpy package: one state on floats, many in double and in single precision."""
    module = import_package(render_numpy(form.package), folder)
    ready = []
    for precision, call in ((DOUBLE, SINGLE_CALL), (DOUBLE, BATCH), (SINGLE, BATCH)):
        p = parameters(form, precision)
        code = _in_type(numpy_code(module, p, call == BATCH), precision)
        for model, traced in form.traced.items():
            function = getattr(module, traced.model.name)
            run = _numpy_run(function, traced, states, p, precision, call)
            ready.append(Ready(Configuration(model, form, None, precision, call), code, run))
    return ready


def _in_type(code: Implementation, precision: Precision) -> Implementation:
    """Return the implementation on arrays of the precision."""
    dtype = TYPES[precision.state]

    def run(traced: TracedModel, states: State) -> dict[str, AnyArray]:
        return code(traced, states.map(lambda block: block.astype(dtype)))

    return run


def _numpy_run(
    function: Callable[..., Any], traced: TracedModel, states: States, p: AnyArray, precision: Precision, call: str
) -> Run:
    arrays = [getattr(round_states(states, precision), name) for name in traced.model.arguments]
    arrays = [x.astype(TYPES[precision.state]) for x in arrays]
    if call == BATCH:
        stacked = [np.resize(x, (NUMPY_STATES, x.shape[1])) for x in arrays]
        return Run(lambda times: _repeat(times, lambda: function(*stacked, p=p)), NUMPY_STATES)
    rows = list(zip(*(x[:TIMED_STATES] for x in arrays), strict=True))
    return Run(lambda times: _repeat(times, lambda: [function(*row, p=p) for row in rows]), len(rows))


def _repeat(times: int, work: Callable[[], Any]) -> None:
    for _ in range(times):
        work()
