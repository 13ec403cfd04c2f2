"""Time and error of every configuration, and the drift that the format of the state causes."""

from __future__ import annotations

import ctypes
import hashlib
import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.trade_off.advice import Advice, advice
from symoro_elastic.analysis.trade_off.builds import EXHAUSTIVE, QUICK, USUAL, Build, builds, compilers, flag_sets
from symoro_elastic.analysis.trade_off.configurations import (
    BATCH,
    CALLS,
    ROUNDS,
    SINGLE_CALL,
    Configuration,
    Measurement,
    Run,
    time_runs,
)
from symoro_elastic.analysis.trade_off.drift import Drift, drifts
from symoro_elastic.analysis.trade_off.formulations import (
    BY_MATRIX,
    Formulation,
    asked_models,
    formulations,
    refuse_stateless,
)
from symoro_elastic.analysis.trade_off.guaranteed import GuaranteedCurve
from symoro_elastic.codegen.c.calls import wrapper_context
from symoro_elastic.codegen.compile import (
    TYPES,
    CompilationFailed,
    CompiledPackage,
    CompilerMissing,
    compile_library,
    function_in,
    load_library,
)
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.foundation.errors import InputError, refuse_numbers
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.progress import Progress, StepProgress, no_step_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.programs.catalogue import TracedModel
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.accuracy import Errors, Reference, measure, round_states, rounded_values
from symoro_elastic.numerics.verification.forms import MODEL, Choice, chosen_form
from symoro_elastic.numerics.verification.implementations import Implementation, c_code, import_package, numpy_code
from symoro_elastic.numerics.verification.states import States, extreme_states, moderate_states

MEASURED_STATES, COMPARED_STATES = 20_000, 1000
PATIENCE = 60.0  # s of compiling, unless every combination is tried
TIMED_STATES, CACHED_NUMBERS = 240, 1_000_000
NUMPY_STATES = 4096


@dataclass(frozen=True)
class Request:
    """The extent of a comparison: `effort` quick, usual or all; states to measure errors at; rounds of timing."""

    effort: str = USUAL
    states: int = MEASURED_STATES
    extreme: bool = False
    rounds: int = ROUNDS
    seed: int = 0


@dataclass(frozen=True, repr=False)
class Trade(Result):
    """Measurements of every configuration by model, drifts where motion was computed, and notes.

    `form` is the form of direct_dynamics that `generate --form auto` takes, where that is among the models. `curves`
    are operations against guaranteed error, where tolerances were given.
    """

    machine: Machine
    request: Request
    measurements: dict[str, list[Measurement]]
    drifts: list[Drift] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    form: Choice | None = None
    curves: tuple[GuaranteedCurve, ...] = ()

    @property
    def headline(self) -> str:
        """Machine, models and ways to compute them."""
        count = sum(map(len, self.measurements.values()))
        return f"Trade of {self.machine.name}: {count} ways to compute {', '.join(self.measurements)}"

    def advice(self, tolerance: float = 1e-12, *, fast_math: bool = False) -> Advice:
        """Return the fastest build for all models within a relative error; raises `InputError` if there is none."""
        return advice(self.measurements, self.machine.label, tolerance, fast_math)


def trade(
    machine: Machine, scene: Scene, request: Request | None = None, watched: StepProgress = no_step_progress
) -> Trade:
    """Time and measure every way to compute the models that a scene asks of a machine.

    Parameters without value get a plausible one. Without a compiler there is numpy only, and a note.
    Raises `InputError`, `NoValues`.
    """
    request = request or Request()
    import_optional("flint", "measuring errors", "accuracy")
    refuse_stateless(machine, scene)
    scene, unmerged = _within_bound(machine, scene, request)
    values = parameter_values(machine, request.seed)
    written, notes = formulations(machine, scene, values)
    notes += unmerged
    _refuse_large(machine, written, request.states)
    draw = extreme_states if request.extreme else moderate_states
    states = draw(restrict(machine, scene), request.states, request.seed, values)
    measurements: dict[str, list[Measurement]] = {name: [] for name in asked_models(scene)}
    with temporary_folder() as folder:
        try:
            ready = _ready(written, states, request, Path(folder), notes, watched("compile"))
        except MemoryError:
            what = "not enough memory for so large a model: ask for one --model, for fewer --states, or --effort quick"
            raise machine.error("trade", what) from None
        times = time_runs([code.run for code in ready], request.rounds, watched("time"))
        errors = _errors(ready, states, request.seed, watched("measure"))
        for code, time, error in zip(ready, times, errors, strict=True):
            measurements[code.configuration.model].append(Measurement(code.configuration, time, error))
        drift_rows = _drifts(machine, scene, values, Path(folder), notes, watched("move"))
    chosen = chosen_form(machine, scene, with_errors=True) if MODEL in measurements else None
    return Trade(machine, request, measurements, drift_rows, notes, chosen)


def _refuse_large(machine: Machine, written: Sequence[Formulation], states: int) -> None:
    """Raise `InputError` if the results of a model at all states exceed the memory."""
    for function in written[0].package.functions:
        size = sum(math.prod(result.shape) for result in function.results)
        what = f"{states} states with {size} results of {function.name}"
        refuse_numbers(states * size, what, machine.label, "--states", "give fewer, or one joint of the model (--only)")


def _within_bound(machine: Machine, scene: Scene, request: Request) -> tuple[Scene, list[str]]:
    """Return the scene, without merged angles if states exceed their bound, and notes."""
    if scene.merge_angles is None:
        return scene, []
    if request.extreme:
        return replace(scene, merge_angles=None), ["angles are not merged: extreme states exceed any bound"]
    if scene.merge_angles < math.pi:
        what = f"angles of the states tried reach pi: a bound of {scene.merge_angles:g} rad needs 3.15 or more"
        raise machine.error("--merge-angles", what)
    return scene, []


def _ready(
    written: Sequence[Formulation], states: States, request: Request, folder: Path, notes: list[str], progress: Progress
) -> list[Ready]:
    """Return all configurations of the formulations, compiled or for numpy."""
    jobs = _jobs(written, request.effort, notes)
    patience = float("inf") if request.effort == EXHAUSTIVE else PATIENCE
    compiled, failed = compiled_configurations(jobs, states, folder, patience, progress)
    notes += failed
    plain = [form for form in written if form.way != BY_MATRIX]
    of_numpy = (numpy_configurations(form, states, folder / f"numpy{k}") for k, form in enumerate(plain))
    return [*compiled, *(x for configurations in of_numpy for x in configurations)]


def _jobs(written: Sequence[Formulation], effort: str, notes: list[str]) -> list[tuple[Formulation, Build]]:
    """Return the builds to compile, the most informative first."""
    try:
        commands = compilers()
    except CompilerMissing as error:
        notes.append(f"numpy only: {error.what}")
        return []
    jobs: list[tuple[Formulation, Build]] = []
    for command in commands if effort != QUICK else commands[:1]:
        sets, lacking = flag_sets(command)
        notes += lacking
        for form in written:
            some = builds(command, sets, effort, form is written[0], form.way == BY_MATRIX)
            jobs += [(form, build) for build in some]
    return sorted(jobs, key=lambda job: job[1].precision.is_pair)


def _errors(ready: Sequence[Ready], states: States, seed: int, progress: Progress) -> list[Errors]:
    """Return the errors of configurations; codes that give equal results at some states are measured once.

    Calls of numpy for one state that differ from its batches, and double-double, are measured at some of the states.
    """
    some = states[:COMPARED_STATES]
    errors_by_code: dict[tuple[int, str, str, bytes], Errors] = {}
    exact: dict[tuple[int, str], Reference] = {}
    errors: dict[int, Errors] = {}
    batches_first = sorted(range(len(ready)), key=lambda k: ready[k].configuration.call != BATCH)
    for done, k in enumerate(batches_first, start=1):
        code, configuration = ready[k], ready[k].configuration
        form, traced = configuration.form, configuration.form.traced[configuration.model]
        results = code.results(traced, some)
        digest = hashlib.sha256(b"".join(results[name].tobytes() for name in sorted(results))).digest()
        key = (id(form), configuration.model, configuration.precision.name, digest)
        if key not in errors_by_code:
            reference = exact.setdefault(key[:2], Reference(traced, states, form.values))
            computed = results if configuration.is_slow else code.results(traced, states)
            is_pair, count = configuration.precision.is_pair, len(some) if configuration.is_slow else None
            judged = DOUBLE if is_pair else configuration.precision  # a pair returns doubles
            errors_by_code[key] = measure(reference, computed, judged, count=count, seed=seed, cancelling=not is_pair)
        errors[k] = errors_by_code[key]
        progress(done, len(ready))
    return [errors[k] for k in range(len(ready))]


def _drifts(
    machine: Machine, scene: Scene, values: dict[str, float], folder: Path, notes: list[str], progress: Progress
) -> list[Drift]:
    restricted = restrict(machine, scene)
    if "direct_dynamics" not in asked_models(scene) or not restricted.independent:
        return []
    if machine.degrees_of_base:
        notes.append("the base floats: base parameters and the drift of a motion are left out")
        return []
    try:
        return drifts(restricted, values, folder / "motion", progress)
    except CompilerMissing:
        return []
    except InputError as error:
        notes.append(f"no motion: {error}")
        return []


@dataclass(frozen=True)
class Ready:
    """An executable configuration: `results` computes results at states, `run` is timed."""

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

    def compile_job(number: int) -> list[Ready] | str | None:
        form, build = jobs[number]
        if time.monotonic() - started > seconds:
            return None
        try:
            return _in_c(form, build, sources[form, build.precision.name], states, folder / str(number))
        except CompilationFailed as error:
            return f"{build.words}, {build.precision.name}: left out, {error.what}"

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for done, outcome in enumerate(pool.map(compile_job, range(len(jobs))), start=1):
            progress(done, len(jobs))
            if isinstance(outcome, str):
                notes.append(outcome)
            elif outcome is None:
                late += 1
            else:
                ready += outcome
    if late:
        what = f"{late} of {len(jobs)} builds left out after {seconds:.0f} s of compiling"
        notes.append(f"{what}: --effort all waits for them")
    return ready, notes


def _sources(package: Package, precision: Precision) -> Mapping[str, str]:
    files = render_c_batch(package, precision)
    name = package.name + precision.suffix
    functions = [_repeat_context(package, function, files[f"{name}.h"], precision) for function in package.functions]
    repeat = render("c/repeat.c.j2", name=name, real=precision.type_of_real(package.name), functions=functions)
    return files | {f"{name}_repeat.c": repeat}


def _repeat_context(package: Package, function: Function, header: str, precision: Precision) -> dict[str, Any]:
    """Return the template context of a function that repeats calls for timing."""
    macro = f"{package.name}{precision.suffix}_{function.name}_CONSTANTS".upper()
    has_constants = f"#define {macro} " in header
    after_p = ("c",) if has_constants else ()
    return wrapper_context(package, function, precision, after_p) | {"constants": macro if has_constants else ""}


def _in_c(form: Formulation, build: Build, sources: Mapping[str, str], states: States, folder: Path) -> list[Ready]:
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
    """Return the parameter array p of a formulation in a precision."""
    values = rounded_values(form.values, precision)
    return np.array([values[p.name] for p in form.package.parameters], dtype=float)


def _c_run(
    loaded: ctypes.CDLL, configuration: Configuration, functions: Sequence[Function], states: States, p: AnyArray
) -> Run:
    """Return the timed call of a compiled configuration; it keeps its arrays alive."""
    traced, precision = configuration.form.traced[configuration.model], configuration.precision
    function = next(f for f in functions if f.name == traced.model.name)
    batch = configuration.call == BATCH
    in_c = precision.function(configuration.form.package.name, function.name)
    entry = function_in(loaded, f"{in_c}_repeat{'_batch' * batch}")
    dtype = TYPES[precision.state]
    numbers = sum(a.size for a in function.arguments) + sum(math.prod(r.shape) for r in function.results)
    some = states[: max(1, min(TIMED_STATES, CACHED_NUMBERS // max(1, numbers)))]  # fit into a processor's caches
    inputs = [getattr(some, argument.name).astype(dtype) for argument in function.arguments]
    arrays = [np.ascontiguousarray(x.T if batch else x) for x in inputs]
    results = [np.zeros((len(some), math.prod(result.shape)), dtype) for result in function.results]
    arrays += [p.astype(dtype), *results]
    entry.argtypes = [ctypes.c_size_t] * 2 + [ctypes.c_void_p] * len(arrays)
    entry.restype = None

    def carry_out(times: int) -> None:
        entry(times, len(some), *(array.ctypes.data for array in arrays))

    return Run(carry_out, len(some))


def numpy_configurations(form: Formulation, states: States, folder: Path) -> list[Ready]:
    """Return the generated numpy package: one state on floats, many in double and in single precision."""
    module = import_package(render_numpy(form.package), folder)
    ready = []
    for precision, call in ((DOUBLE, SINGLE_CALL), (DOUBLE, BATCH), (SINGLE, BATCH)):
        p = parameters(form, precision)
        code = partial(_in_type, numpy_code(module, p, call == BATCH), precision)
        for model, traced in form.traced.items():
            function = getattr(module, traced.model.name)
            run = _numpy_run(function, traced, states, p, precision, call)
            ready.append(Ready(Configuration(model, form, None, precision, call), code, run))
    return ready


def _in_type(code: Implementation, precision: Precision, traced: TracedModel, states: State) -> dict[str, AnyArray]:
    """Return the results of an implementation on arrays in the type of a precision."""
    return code(traced, states.map(lambda block: block.astype(TYPES[precision.state])))


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
