"""The ladder of models of a machine for a motion: their springs, errors and operations, measured.

A rung omits springs, static or locked; the cheapest method and step that suffice are predicted for it. The rung that is
chosen, its neighbour and the full machine are simulated, and predicted errors are compared with measured ones.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.ladder.budget_path import BudgetPath
from symoro_elastic.analysis.ladder.greedy import SpringFigures, spring_figures
from symoro_elastic.analysis.ladder.predicted_rungs import WHOLE, Prediction, held_springs, zeros_of
from symoro_elastic.analysis.ladder.rung import (
    PREDICTED_FRACTION,
    Budget,
    Expense,
    Measured,
    MeasuredEnd,
    PathStep,
    Rung,
    Steps,
)
from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps, Trajectory, reference_motion, refuse_still
from symoro_elastic.analysis.simulation.driven import with_loads
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.prediction.output_matrices import is_torque
from symoro_elastic.analysis.simulation.prediction.path import with_passed_loads
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference, reference_of
from symoro_elastic.analysis.simulation.simulate import Simulating, errors_by_halving, refuse_period
from symoro_elastic.analysis.simulation.tolerances import refuse_rounding
from symoro_elastic.codegen.integration.tableaus import METHODS, RK4
from symoro_elastic.codegen.precision import DOUBLE, MIXED, Precision
from symoro_elastic.formats.toml.kept_text import in_text_of
from symoro_elastic.formats.toml.motions import motions_of, wanted_of
from symoro_elastic.formats.toml.reading import scene_in
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.formats.toml.writing import write_scene
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import permission, temporary_folder, write_text
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.checks import require_fixed_base
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.series_springs import Condensed, condense
from symoro_elastic.machine.static_springs import held_positions
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs
from symoro_elastic.quantities.time_steps import TimeStep

COUNT, SEED = 20, 0
WAY_OUT = "leave it out, or name a frame beyond them"
FASTER = 0.95
"""Largest ratio of the times of a step in mixed and in double precision that is worth the error."""
ROUNDS, TIMED_STEPS = 15, 2000


def ladder_of_prediction(
    prediction: Prediction,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
    spent: Collection[Expense] = frozenset(Expense),
) -> Ladder:
    """Return the ladder of a prediction, with a budget if `spent` names simplifications; raises `InputError`."""
    rungs = prediction.rungs(progress, announce)
    announce("measure")
    measurement = Measurement(prediction)
    ladder = measured_ladder(measurement, rungs)
    return replace(ladder, budget=budget_of(measurement, ladder, spent, announce, progress)) if spent else ladder


def prediction_of(
    machine: Machine, motions: Sequence[PrescribedMotion], tolerance: Mapping[str, float], period: float | None = None
) -> Prediction:
    """Return the prediction of rungs of a machine, springs in series condensed; raises `InputError`."""
    require_fixed_base(machine, "ladder")
    series = with_springs_joined(machine, motions, tolerance)
    references = tuple(reference_of(series.machine, motion) for motion in motions)
    prediction = Prediction(series.machine, references, tolerance, period, series.notes)
    for reference in references:
        refuse_still(reference)
        refuse_rounding(prediction.tolerance, reference)
        refuse_period(Simulating(reference, prediction.request))
    return prediction


def measured_ladder(measurement: Measurement, rungs: Sequence[Rung]) -> Ladder:
    """Return the ladder: the cheapest rung whose measured errors agree with prediction, its neighbour measured too."""
    prediction, measured, distrusted, chosen = measurement.prediction, list(rungs), list[int](), None
    costs = {k: rung.chosen.cost for k, rung in enumerate(rungs) if rung.chosen}
    for k in sorted(costs, key=lambda k: costs[k]):
        measured[k] = replace(measured[k], measured=measurement.errors(measured[k]))
        if measured[k].is_trusted(prediction.tolerance):
            chosen = k
            break
        distrusted.append(k)
    if chosen is not None and chosen + 1 < len(measured) and not measured[chosen + 1].locked:
        measured[chosen + 1] = replace(measured[chosen + 1], measured=measurement.errors(measured[chosen + 1]))
    return Ladder(
        prediction.machine,
        prediction.references,
        prediction.tolerance,
        tuple(measured),
        chosen,
        prediction.steps_of(measured[0], (RK4.name,)),
        tuple(distrusted),
        {} if chosen is None else prediction.arithmetic(measured[chosen]),
        spring_figures(prediction.paths, prediction.tolerance),
        prediction.condensed,
    )


def with_springs_joined(
    machine: Machine, motions: Sequence[PrescribedMotion], signals: Iterable[str]
) -> Condensed[Machine]:
    """Return the machine with springs in series merged, which is exact, and notes on the merged springs.

    Raises `InputError` for motions and signals that name what merging changes: the variables of the joints, and frames
    between them.
    """
    condensed = condense(machine)
    for motion in motions:
        for name in condensed.variables.intersection(motion.start):
            what = f"{name} is one of two springs in series, which are merged: {WAY_OUT}"
            raise motion.error(f"start, {name}", what)
        for k, force in enumerate(motion.forces, 1):
            if force.at in condensed.between:
                what = f"{force.at} is between two springs in series, which are merged: {WAY_OUT}"
                raise motion.error(f"forces {k}, at", what)
    for name in signals:
        if _changes(machine, condensed, name):
            what = f"{name} belongs to two springs in series, which are merged: {WAY_OUT}"
            raise machine.error("wanted, tolerance", what)
    return condensed


def _changes(machine: Machine, condensed: Condensed[Machine], name: str) -> bool:
    """Whether a signal belongs to a variable or a frame that merging springs changes."""
    if not condensed.variables or is_torque(name):
        return False
    (signal,) = outputs(machine, [name])
    joint = machine.joint(signal.number).name
    return joint in (condensed.between if isinstance(signal, FrameSignal) else condensed.variables)


def starts(box: Mapping[str, tuple[float, float]], count: int = COUNT, seed: int = SEED) -> list[dict[str, float]]:
    """Return positions by joint in a box of ranges by joint, rad or m: a Latin hypercube, the same for a seed.

    Each range is divided into `count` parts, and each part holds one position.
    """
    shares = for_vibrations("scipy.stats.qmc").LatinHypercube(len(box), seed=seed).random(count)
    low, high = np.array([*box.values()]).reshape(-1, 2).T
    return [dict(zip(box, row, strict=True)) for row in (low + shares * (high - low)).tolist()]


def budget_of(
    measurement: Measurement,
    ladder: Ladder,
    spent: Collection[Expense] = frozenset(Expense),
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Budget:
    """Return the budget of a ladder; raises `InputError`.

    Steps at the end of the path that a simulation does not confirm are rejected: measured errors that are beyond the
    tolerances.
    """
    prediction = measurement.prediction
    announce("spend the tolerance")
    rungs = [replace(rung, measured=None) for rung in ladder.rungs]
    path = list(BudgetPath(prediction, rungs, spent).run(progress))
    announce("simulate the model at the end")
    dropped: list[PathStep] = []
    while True:
        errors = measured_errors(measurement, path[-1].rung)
        if relative(errors, prediction.tolerance) <= 1 or len(path) == 1:
            break
        dropped.insert(0, path.pop())
    seconds, mixed = times(measurement, path[-1].rung)
    in_mixed = measured_errors(measurement, path[-1].rung, MIXED)
    is_faster = Expense.PRECISION in spent and mixed <= FASTER * seconds
    if is_faster and relative(in_mixed, prediction.tolerance) <= 1:
        last, added = path[-1], prediction.arithmetic(path[-1].rung)
        total = {name: x + added[name] for name, x in last.total.items()}
        if relative(total, prediction.tolerance) <= PREDICTED_FRACTION:
            path.append(PathStep(Expense.PRECISION, (), added, total, last.rung))
    errors = in_mixed if path[-1].expense is Expense.PRECISION else errors
    end = MeasuredEnd(errors, in_mixed, seconds, mixed)
    alone = None if ladder.chosen is None else ladder.rungs[ladder.chosen].chosen
    return Budget(prediction.machine, prediction.tolerance, tuple(path), end, ladder.full, alone, tuple(dropped))


def measured_errors(measurement: Measurement, rung: Rung, precision: Precision = DOUBLE) -> dict[str, float]:
    """Return the errors of outputs against the full machine, on the motion that is worst for a rung's springs.

    The full machine has steps that need little of the tolerances, the rung its own: errors include those of steps.
    """
    assert rung.chosen is not None
    prediction, k = measurement.prediction, measurement.prediction.worst_motion(rung)
    fine, steps, method = prediction.fine_steps(k), rung.chosen.steps, rung.chosen.method
    steps = steps if method else fine
    (exact, outputs_of_full) = measurement.simulation(WHOLE, k).run(TimeStep.W3, steps * -(-fine // steps))
    (run, outputs_of_rung) = measurement.simulation(rung, k).run(method, steps, precision)
    places, fine_places = (np.round(x.t / exact.step).astype(np.int64) for x in (run, exact))
    _, here, there = np.intersect1d(places, fine_places, return_indices=True)
    with np.errstate(invalid="ignore"):
        apart = np.abs(outputs_of_rung[here] - outputs_of_full[there]).max(axis=0)
    return dict(zip(prediction.tolerance, np.where(np.isfinite(apart), apart, np.inf).tolist(), strict=True))


def times(measurement: Measurement, rung: Rung) -> tuple[float, float]:
    """Return the least computing time of a step in double and in mixed precision, s, timed alternately."""
    assert rung.chosen is not None
    method, steps = rung.chosen.method, rung.chosen.steps
    if not method:
        return 0.0, 0.0
    simulated = measurement.simulation(rung, 0)
    compiled = [simulated.steps_by(method, precision) for precision in (DOUBLE, MIXED)]
    steps *= max(1, TIMED_STEPS // steps)
    rounds = [[x.run(simulated.reduced, method, steps).seconds for x in compiled] for _ in range(ROUNDS)]
    double, mixed = np.min(rounds, axis=0).tolist()
    return double, mixed


class Measurement:
    """Measurement of the errors of rungs, each on its worst motion; compiled steps are reused."""

    def __init__(self, prediction: Prediction) -> None:
        self.prediction = prediction
        self._simulated: dict[tuple[Any, int], SimulatedRung] = {}

    def errors(self, rung: Rung) -> Measured:
        """Return the errors of a rung on its worst motion: of its model, and of its steps by halving."""
        k = self.prediction.worst_motion(rung)
        fine = self.prediction.fine_steps(k)
        (_, outputs_of_full), (_, outputs) = (self.simulation(x, k).run(TimeStep.W3, fine) for x in (WHOLE, rung))
        model = np.abs(outputs - outputs_of_full).max(axis=0)
        steps, seconds = self._errors_of_steps(rung, k)
        return Measured(self._by_output(model), self._by_output(steps), seconds)

    def simulation(self, rung: Rung, k: int) -> SimulatedRung:
        """Return the simulation of a rung on a motion."""
        key = rung.model, k
        if key not in self._simulated:
            self._simulated[key] = SimulatedRung(self.prediction, rung, k)
        return self._simulated[key]

    def _errors_of_steps(self, rung: Rung, k: int) -> tuple[Array, float]:
        """Return the errors (outputs,) of the steps of a rung, and the time of a step, s; NaN where it has none."""
        outputs = len(self.prediction.tolerance)
        if rung.chosen is None:
            return np.full(outputs, np.nan), np.nan
        if not rung.chosen.method:
            return np.zeros(outputs), 0.0
        method, steps, simulated = METHODS[rung.chosen.method], rung.chosen.steps, self.simulation(rung, k)
        coarse, fine = simulated.run(method.name, steps), simulated.run(method.name, 2 * steps)
        return errors_by_halving(method, coarse, fine), coarse[0].seconds

    def _by_output(self, x: Array) -> dict[str, float]:
        return dict(zip(self.prediction.tolerance, x.tolist(), strict=True))


class SimulatedRung:
    """A rung on one motion of the whole machine, simulated by even steps."""

    def __init__(self, prediction: Prediction, rung: Rung, k: int) -> None:
        self.whole, self.reduced = prediction.references[k], prediction.reduced_reference(rung, k)
        self._moves = prediction.moves(rung)
        self._observer = Observer(self.reduced.machine, self.reduced, ())
        self._observer_of_whole = Observer(prediction.machine, self.whole, tuple(prediction.tolerance))
        self._compiled: dict[tuple[str, str], CompiledSteps] = {}

    def run(self, method: str, steps: int, precision: Precision = DOUBLE) -> tuple[Trajectory, Array]:
        """Return the simulated motion of the rung, and the outputs (N, names) of the full machine computed from it."""
        if self._moves:
            trajectory = self.steps_by(method, precision).run(self.reduced, method, steps)
        else:
            trajectory = with_passed_loads(self.reduced, reference_motion(self.reduced, steps))
        motion = whole_motion(self.whole, self._observer, self._observer.motion(trajectory))
        return trajectory, self._observer_of_whole.outputs(motion)

    def steps_by(self, method: str, precision: Precision = DOUBLE) -> CompiledSteps:
        """Return compiled steps of a method."""
        key = method, precision.name
        if key not in self._compiled:
            with temporary_folder() as folder:
                self._compiled[key] = CompiledSteps(with_loads(self.reduced), [method], Path(folder), precision)
        return self._compiled[key]


def whole_motion(reference: Reference, reduced: Observer, motion: Motion) -> Motion:
    """Return the motion of a reference's full machine from that of a reduced machine.

    Springs that are left out stay where the motion starts; those that are static deflect by the reactions.
    Springs that are static in the whole machine have no variable in its motion.
    """
    rows = {joint.name: k for k, joint in enumerate(reference.machine.independent_joints)}
    moved = [rows[joint.name] for joint in reduced.machine.independent_joints]
    static = [rows[joint.name] for joint in reduced.machine.static_springs.values() if joint.name in rows]

    def spread(x: Array, start: Array) -> Array:
        rows_of_full = np.tile(start, (len(x), 1))
        rows_of_full[:, moved] = x
        return rows_of_full

    still = np.zeros(len(rows))
    q, qd, qdd = spread(motion.q, reference.start.q), spread(motion.qd, still), spread(motion.qdd, still)
    if static:
        q[:, static] = reduced.deflections(motion)
    return Motion({"q": q, "qd": qd, "qdd": qdd, **motion.only(("tau", "f_ext"))}, motion.t)


@dataclass(frozen=True)
class Asked:
    """The full machine, its scene and requirements; `file` is the scene's file, if it has one."""

    machine: Machine
    scene: Scene
    wanted: Wanted | None
    file: str | Path | None = None


@dataclass(frozen=True, repr=False)
class Ladder(Result):
    """All rungs of a machine for its motions, the chosen rung, and the full machine with RK4 for comparison.

    `chosen` is None where no rung fits the tolerances. `distrusted` are rungs whose prediction failed. `arithmetic` are
    errors by output that the chosen one has more where accelerations are in single precision; empty without one.
    `springs` are usual measures of springs, `condensed` lines on merged springs in series.
    `budget` is the path on which numbers, steps and precision share the tolerances with springs, where it is asked for.
    `asked` is what the scene asked of the whole machine, from which `write` makes the reduced one.
    """

    machine: Machine
    references: tuple[Reference, ...]
    tolerance: Mapping[str, float]
    rungs: tuple[Rung, ...]
    chosen: int | None
    full: Steps
    distrusted: tuple[int, ...] = ()
    arithmetic: Mapping[str, float] = field(default_factory=dict)
    springs: tuple[SpringFigures, ...] = ()
    condensed: tuple[str, ...] = ()
    budget: Budget | None = None
    asked: Asked | None = None

    @property
    def advised(self) -> Rung | None:
        """The model that is advised: the end of the budget, or the chosen rung; None where no rung fits."""
        if self.budget:
            return self.budget.advised.rung
        return None if self.chosen is None else self.rungs[self.chosen]

    @property
    def saving(self) -> float:
        """Operations of the whole machine with RK4 over those of the chosen rung."""
        rung = self.rungs[self.chosen or 0]
        return self.full.cost / rung.chosen.cost if rung.chosen else 1.0

    @property
    def headline(self) -> str:
        """Machine, rungs and the chosen one."""
        choice = "none fits" if self.chosen is None else f"{self.chosen} chosen, {self.saving:.3g} times less work"
        return f"Ladder of {self.machine.name}: {len(self.rungs)} rungs, {choice}"

    @property
    def worst_output(self) -> str:
        """The output whose error is the largest part of its tolerance, over all rungs."""
        return max(self.tolerance, key=lambda name: max(x.predicted[name] for x in self.rungs) / self.tolerance[name])

    def step_of(self, rung: Rung) -> float:
        """Return the shortest step of a rung that fits over all motions, s."""
        assert rung.chosen is not None
        return min(reference.duration for reference in self.references) / rung.chosen.steps

    def write(self, file: str | Path, *, force: bool = False) -> Path:
        """Write the scene of the advised model to a .toml file and return its path, as the command does by --save.

        Raises `InputError` for a file that exists unless `force`, and for a ladder that no scene asked for.
        """
        with permission(force=force):
            self.save(file)
        return Path(file)

    def save(self, file: str | Path) -> str:
        """Write the scene as `write` does, where files may be replaced as the command line says.

        It has the comments of the file of the scene; returned is a line on those that are lost.
        """
        if self.asked is None:
            raise InputError(self.machine.label, "ladder", "no scene asked for it: use se.ladder")
        motions = [reference.prescribed for reference in self.references]
        reduced = reduced_scene(self, self.asked.machine, self.asked.scene)
        advice = (self.budget or self).as_json()["advice"]
        text, lost = in_text_of(self.asked.file, write_scene(reduced, motions, self.asked.wanted), self._normal)
        write_text(f"# {advice}\n\n{text}", file, "--save")
        return lost

    def _normal(self, text: str) -> str:
        """Return the text of a scene file in the normal form of this program."""
        assert self.asked is not None
        top, machine = load(text, str(self.asked.file)), self.asked.machine
        return write_scene(scene_in(top, machine, MODELS), motions_of(top, machine), wanted_of(top))


def reduced_scene(ladder: Ladder, whole: Machine, scene: Scene) -> Scene:
    """Return the scene of the full machine with the advised method, springs made static and numbers omitted."""
    rung, reference = ladder.advised, ladder.references[0]
    if rung is None:
        return scene
    assert rung.chosen is not None
    positions = held_springs(ladder.machine, reference, rung)
    steps = tuple(dict.fromkeys((*scene.steps, *filter(None, (rung.chosen.method,)))))
    forces = dict.fromkeys((*scene.forces, *(str(x) for motion in ladder.references for x in motion.loaded.forces)))
    zero = tuple(dict.fromkeys((*scene.zero, *zeros_of(rung, positions))))
    condense = scene.condense or bool(ladder.condensed)
    scene = replace(scene, forces=tuple(forces), steps=steps, condense=condense, zero=zero)
    if rung.locked:
        return replace(scene, locked={**scene.locked, **positions})
    return replace(scene, static={**held_positions(whole, scene.static), **positions})
