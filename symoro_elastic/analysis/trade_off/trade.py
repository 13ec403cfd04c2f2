"""Time and error of every configuration, and the drift that the format of the state causes."""

from __future__ import annotations

import hashlib
import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from symoro_elastic.analysis.trade_off.advice import Advice, advice
from symoro_elastic.analysis.trade_off.builds import EXHAUSTIVE, QUICK, USUAL, Build, builds, compilers, flag_sets
from symoro_elastic.analysis.trade_off.compilation import Ready, compiled_configurations, numpy_configurations
from symoro_elastic.analysis.trade_off.configurations import BATCH, Measurement, judged_in
from symoro_elastic.analysis.trade_off.drift import Drift, drifts
from symoro_elastic.analysis.trade_off.formulations import (
    BY_MATRIX,
    Formulation,
    asked_models,
    formulations,
    refuse_stateless,
)
from symoro_elastic.analysis.trade_off.guaranteed import GuaranteedCurve
from symoro_elastic.analysis.trade_off.timing import ROUNDS, time_runs
from symoro_elastic.codegen.compile import CompilerMissing
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.progress import Progress, StepProgress, no_step_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.foundation.sizes import refuse_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.values import parameter_values
from symoro_elastic.numerics.verification.accuracy import Errors, Reference, measure
from symoro_elastic.numerics.verification.forms import MODEL, Choice, chosen_form
from symoro_elastic.numerics.verification.states import States, extreme_states, moderate_states

MEASURED_STATES, COMPARED_STATES = 20_000, 1000
PATIENCE = 60.0  # s of compiling, unless every combination is tried


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
    with tempfile.TemporaryDirectory() as folder:
        ready = _made(machine, written, states, request, Path(folder), notes, watched("compile"))
        times = time_runs([one.run for one in ready], request.rounds, watched("time"))
        errors = _measured(ready, states, request.seed, watched("measure"))
        for one, time, error in zip(ready, times, errors, strict=True):
            measurements[one.configuration.model].append(Measurement(one.configuration, time, error))
        moved = _drifts(machine, scene, values, Path(folder), notes, watched("move"))
    chosen = chosen_form(machine, scene, with_errors=True) if MODEL in measurements else None
    return Trade(machine, request, measurements, moved, notes, chosen)


def _refuse_large(machine: Machine, written: Sequence[Formulation], states: int) -> None:
    """Raise `InputError` where the results of a model at all states have no room."""
    for function in written[0].package.functions:
        each = sum(math.prod(result.shape) for result in function.results)
        what = f"{states} states with {each} results of {function.name}"
        refuse_numbers(states * each, what, machine.label, "--states", "give fewer, or one joint of the model (--only)")


def _within_bound(machine: Machine, scene: Scene, request: Request) -> tuple[Scene, list[str]]:
    """Return the scene, without sums of angles where states are beyond their bound, and notes."""
    if scene.merge_angles is None:
        return scene, []
    if request.extreme:
        return replace(scene, merge_angles=None), ["angles are not merged: extreme states exceed any bound"]
    if scene.merge_angles < math.pi:
        what = f"angles of the states tried reach pi: a bound of {scene.merge_angles:g} rad needs 3.15 or more"
        raise machine.error("--merge-angles", what)
    return scene, []


def _made(
    machine: Machine,
    written: Sequence[Formulation],
    states: States,
    request: Request,
    folder: Path,
    notes: list[str],
    progress: Progress,
) -> list[Ready]:
    jobs = _jobs(written, request.effort, notes)
    patience = float("inf") if request.effort == EXHAUSTIVE else PATIENCE
    try:
        compiled, failed = compiled_configurations(jobs, states, folder, patience, progress)
        notes += failed
        plain = [form for form in written if form.way != BY_MATRIX]
        return compiled + [
            p for k, form in enumerate(plain) for p in numpy_configurations(form, states, folder / f"numpy{k}")
        ]
    except MemoryError:
        what = "not enough memory for so large a model: ask for one --model, for fewer --states, or --effort quick"
        raise machine.error("trade", what) from None


def _jobs(written: Sequence[Formulation], effort: str, notes: list[str]) -> list[tuple[Formulation, Build]]:
    """Return the builds to compile, the most informative first."""
    try:
        commands = compilers()
    except CompilerMissing as error:
        notes.append(f"numpy only: {error}")
        return []
    jobs: list[tuple[Formulation, Build]] = []
    for command in commands if effort != QUICK else commands[:1]:
        sets, lacking = flag_sets(command)
        notes += lacking
        for form in written:
            some = builds(command, sets, effort, form is written[0], form.way == BY_MATRIX)
            jobs += [(form, build) for build in some]
    return sorted(jobs, key=lambda job: job[1].precision.is_pair)


def _measured(ready: Sequence[Ready], states: States, seed: int, progress: Progress) -> list[Errors]:
    """Return the errors of each configuration; codes that give equal results at some states are measured once.

    Calls of numpy for one state that differ from its batches, and double-double, are measured at some of the states.
    """
    some = states[:COMPARED_STATES]
    known: dict[tuple[int, str, str, bytes], Errors] = {}
    exact: dict[tuple[int, str], Reference] = {}
    errors: dict[int, Errors] = {}
    batches_first = sorted(range(len(ready)), key=lambda k: ready[k].configuration.call != BATCH)
    for done, k in enumerate(batches_first, start=1):
        one, configuration = ready[k], ready[k].configuration
        form, traced = configuration.form, configuration.form.traced[configuration.model]
        results = one.results(traced, some)
        digest = hashlib.sha256(b"".join(results[name].tobytes() for name in sorted(results))).digest()
        key = (id(form), configuration.model, configuration.precision.name, digest)
        if key not in known:
            reference = exact.setdefault(key[:2], Reference(traced, states, form.values))
            slow = configuration.is_slow
            given = some if slow else states
            found, precision = results if slow else one.results(traced, states), judged_in(configuration.precision)
            known[key] = measure(
                traced,
                found,
                given,
                form.values,
                precision,
                seed=seed,
                reference=reference,
                cancelling=not configuration.precision.is_pair,
            )
        errors[k] = known[key]
        progress(done, len(ready))
    return [errors[k] for k in range(len(ready))]


def _drifts(
    machine: Machine, scene: Scene, values: dict[str, float], folder: Path, notes: list[str], progress: Progress
) -> list[Drift]:
    kept = restrict(machine, scene)
    if "direct_dynamics" not in asked_models(scene) or not kept.independent:
        return []
    if machine.degrees_of_base:
        notes.append("the base floats: base parameters and the drift of a motion are left out")
        return []
    try:
        return drifts(kept, values, folder / "motion", progress)
    except CompilerMissing:
        return []
    except InputError as error:
        notes.append(f"no motion: {error}")
        return []
