"""The ladder of models of a machine for a motion: what each leaves out, what that costs and saves, measured.

A rung leaves springs out, static or locked; the cheapest method and step that suffice are predicted for it. The rung
that is chosen, its neighbour and the whole machine are simulated, and the prediction is compared with what is measured.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.integration.methods import METHODS
from symoro_elastic.integration.tableaus import RK4
from symoro_elastic.machine.checks import refuse_floating
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.restrict import restricted
from symoro_elastic.machine.scene import Scene
from symoro_elastic.model_ladder.arithmetic import single_precision_errors
from symoro_elastic.model_ladder.greedy import SpringFigures, backward_greedy, spring_figures
from symoro_elastic.model_ladder.path import LinearPath
from symoro_elastic.model_ladder.recovery import whole_motion
from symoro_elastic.model_ladder.resolution import resolved_path
from symoro_elastic.model_ladder.rung import Measured, Rung, Steps
from symoro_elastic.model_ladder.series import with_springs_joined
from symoro_elastic.model_ladder.simulate import Request, Simulating, enough_steps, errors_by_halving, refuse_period
from symoro_elastic.model_ladder.spring_errors import Deviations, relative, spring_errors
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.quantities.time_steps import TimeStep
from symoro_elastic.results import Part, Result, Titled
from symoro_elastic.simulation.compiled_steps import CompiledSteps, Trajectory, prescribed, refuse_still
from symoro_elastic.simulation.observed import Observer
from symoro_elastic.simulation.reference import Reference, reference_of
from symoro_elastic.simulation.tolerances import refuse_rounding

MODEL_SHARE = 0.7
"""Of the tolerance that the springs left out may take; steps take a quarter, arithmetic the rest."""
FINE = 0.01
"""Of the tolerance that steps take where a model is measured."""
EACH_SPRING = "each spring by itself, which does not tell what it costs with others"


@dataclass(frozen=True, repr=False)
class Ladder(Result):
    """All rungs of a machine for its motions, the rung that is chosen, and the whole machine with RK4 to compare with.

    `chosen` is None where no rung fits the tolerances. `distrusted` are rungs whose prediction failed. `arithmetic` are
    errors by output that the chosen one has more where accelerations are in single precision; empty without one.
    `springs` are what is usually asked of each, `condensed` lines on springs in series that the machine has as one.
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

    def parts(self) -> list[Part]:
        """Return the tables of rungs and springs, the advice, and what single precision costs."""
        from symoro_elastic.model_ladder.tables import advice, arithmetic_line, ladder_table, springs_table

        lines = [*self.condensed, advice(self), arithmetic_line(self)]
        springs = [Titled(springs_table(self), EACH_SPRING)] if self.springs else []
        return [Titled(ladder_table(self), self.headline), *springs, *(line for line in lines if line)]

    def as_json(self) -> dict[str, Any]:
        """Return all rungs as plain data."""
        from symoro_elastic.model_ladder.tables import ladder_json

        return ladder_json(self)

    def columns(self) -> dict[str, list[Any]]:
        """Return a row for each rung, as in `as_json`."""
        rungs = self.as_json()["rungs"]
        return {key: [rung[key] for rung in rungs] for key in rungs[0]}


def ladder(
    machine: Machine,
    motions: Sequence[PrescribedMotion],
    tolerance: Mapping[str, float],
    period: float | None = None,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Ladder:
    """Return the ladder of a machine for some motions and tolerances by output; raises `InputError`."""
    climb, rungs = _predicted(machine, motions, tolerance, period, announce, progress)
    announce("measure")
    return climb.measured(rungs, progress)


def predicted_ladder(
    machine: Machine, motions: Sequence[PrescribedMotion], tolerance: Mapping[str, float], period: float | None = None
) -> Ladder:
    """Return the ladder with the rung chosen that is cheapest by prediction, nothing measured; raises `InputError`."""
    climb, rungs = _predicted(machine, motions, tolerance, period, announce_nothing, no_progress)
    return climb.by_prediction(rungs)


def _predicted(
    machine: Machine,
    motions: Sequence[PrescribedMotion],
    tolerance: Mapping[str, float],
    period: float | None,
    announce: Announce,
    progress: Progress,
) -> tuple[_Climb, tuple[Rung, ...]]:
    """Return the rungs of a machine, springs in series condensed, with predicted errors and steps."""
    refuse_floating(machine, "ladder")
    announce("predict")
    series = with_springs_joined(machine, motions, tolerance)
    references = tuple(reference_of(series.machine, motion) for motion in motions)
    climb = _Climb(series.machine, references, tolerance, period, series.notes)
    for reference in references:
        refuse_still(reference)
        refuse_rounding(climb.tolerance, reference)
        refuse_period(Simulating(reference, climb.request))
    return climb, climb.rungs(progress)


class _Climb:
    """Rungs of a machine for its motions."""

    def __init__(
        self,
        machine: Machine,
        references: tuple[Reference, ...],
        tolerance: Mapping[str, float],
        period: float | None,
        condensed: tuple[str, ...] = (),
    ) -> None:
        """`condensed` are lines on springs in series that the machine has as one."""
        self.machine, self.references, self.tolerance = machine, references, dict(tolerance)
        self.condensed = condensed
        self.request = Request(tuple(tolerance), tolerance, period=period)
        self._libraries: dict[tuple[tuple[str, ...], int, str], CompiledSteps] = {}
        self._observers: dict[tuple[tuple[str, ...], bool, int], Observer] = {}

    @cached_property
    def paths(self) -> tuple[LinearPath, ...]:
        """The linear models along the motions."""
        return tuple(resolved_path(reference, self.tolerance) for reference in self.references)

    def rungs(self, progress: Progress) -> tuple[Rung, ...]:
        """Return all rungs, those that fit with method and steps."""
        found = backward_greedy(self.paths, self.tolerance, progress)
        rungs = [Rung(one.left_out, False, one.static) for one in found]
        rungs += [Rung(found[-1].left_out, True, found[-1].locked)] if found[-1].left_out else []
        return tuple(replace(rung, chosen=self.steps_of(rung)) if self.fits(rung) else rung for rung in rungs)

    def fits(self, rung: Rung) -> bool:
        """Whether the predicted errors of a rung leave room for those of steps, and its springs hold their loads."""
        if relative(rung.predicted, self.tolerance) > MODEL_SHARE:
            return False
        return rung.locked or all(self._holds(rung, path) for path in self.paths)

    @staticmethod
    def _holds(rung: Rung, path: LinearPath) -> bool:
        """Whether the stiffness of the springs left out, with gravity and loads, is positive along a motion."""
        rows = [path.joints.index(name) for name in rung.left_out]
        block = path.K[:, rows][:, :, rows]
        symmetric = (block + block.transpose(0, 2, 1)) / 2
        return not rows or bool(np.linalg.eigvalsh(symmetric).min() > 0)

    def reduced(self, rung: Rung, reference: Reference) -> Simulating:
        """Return the machine of a rung on one motion, springs held where the whole machine starts."""
        return Simulating(self._reduced_reference(rung, reference), self.request, self._path(rung, reference))

    def _path(self, rung: Rung, reference: Reference) -> tuple[LinearPath, tuple[int, ...]]:
        """Return the linear model of a rung on one motion, and the entries of q that it leaves out."""
        path = self.paths[self._number(reference)]
        left_out = tuple(path.joints.index(name) for name in rung.left_out)
        return path if rung.locked else path.recovering(left_out), left_out

    def _number(self, reference: Reference) -> int:
        return next(k for k, one in enumerate(self.references) if one is reference)

    def _reduced_reference(self, rung: Rung, reference: Reference) -> Reference:
        machine = reduced_machine(self.machine, reference, rung)
        kept = [k for k, joint in enumerate(self.machine.moving_joints) if joint.name not in rung.left_out]
        state = reference.start
        start = replace(state, q=state.q[kept], qd=state.qd[kept], qdd=state.qdd[kept], tau=state.tau[kept])
        return replace(reference, machine=machine, start=start)

    def steps_of(self, rung: Rung, only: Iterable[str] = ()) -> Steps:
        """Return the cheapest method and steps that suffice for all motions."""
        each = [self.reduced(rung, reference) for reference in self.references]
        if not self._moves(rung):
            return Steps("", 1, dict.fromkeys(self.tolerance, 0.0), 1)
        best: Steps | None = None
        for name in only or each[0].candidates():
            method = METHODS[name]
            operations = each[0].cost.of(method)
            least = max(simulating.stable_steps(method) for simulating in each)
            if best and least * operations >= best.cost:
                continue
            found = [enough_steps(simulating, method, self.tolerance) for simulating in each]
            one = Steps(name, *max(found, key=lambda pair: pair[0]), operations)
            best = one if best is None or one.cost < best.cost else best
        assert best is not None
        return best

    def _moves(self, rung: Rung) -> bool:
        """Whether anything is left whose motion is not prescribed."""
        path = self.paths[0]
        return bool({*path.names(path.moved)} - {*rung.left_out})

    def measured(self, rungs: tuple[Rung, ...], progress: Progress) -> Ladder:
        """Return the ladder with the chosen rung and its neighbour measured; down to one whose prediction holds."""
        found, distrusted, chosen = list(rungs), list[int](), None
        for k in _by_cost(rungs):
            found[k] = replace(found[k], measured=self._measured(found[k]))
            if found[k].is_trusted(self.tolerance):
                chosen = k
                break
            distrusted.append(k)
        if chosen is not None and chosen + 1 < len(found) and not found[chosen + 1].locked:
            found[chosen + 1] = replace(found[chosen + 1], measured=self._measured(found[chosen + 1]))
        return self._ladder(found, chosen, distrusted)

    def by_prediction(self, rungs: tuple[Rung, ...]) -> Ladder:
        """Return the ladder with the cheapest rung chosen."""
        return self._ladder(rungs, next(iter(_by_cost(rungs)), None))

    def _ladder(self, rungs: Sequence[Rung], chosen: int | None, distrusted: Sequence[int] = ()) -> Ladder:
        return Ladder(
            self.machine,
            self.references,
            self.tolerance,
            tuple(rungs),
            chosen,
            self.steps_of(rungs[0], (RK4.name,)),
            tuple(distrusted),
            {} if chosen is None else self._arithmetic(rungs[chosen]),
            spring_figures(self.paths, self.tolerance),
            self.condensed,
        )

    def _measured(self, rung: Rung) -> Measured:
        """Return the errors of a rung on the motion that is worst for it: of its model, and of its steps by halving."""
        reference = self.references[self._worst(rung)]
        names, fine = tuple(self.tolerance), self._fine(reference)
        _, whole = self._observed(Rung((), False, {}), reference, TimeStep.W3, fine)
        _, outputs = self._observed(rung, reference, TimeStep.W3, fine)
        model = np.abs(outputs - whole).max(axis=0)
        steps, seconds = (
            self._errors_of_steps(rung, reference) if rung.chosen else (dict.fromkeys(names, np.nan), np.nan)
        )
        return Measured(dict(zip(names, model.tolist(), strict=True)), steps, seconds)

    def _arithmetic(self, rung: Rung) -> dict[str, float]:
        """Return what single precision of the accelerations adds to the errors of a rung, largest over the motions."""
        if not self._moves(rung) or rung.chosen is None:
            return dict.fromkeys(self.tolerance, 0.0)
        steps = rung.chosen.steps
        paths = [self._path(rung, reference) for reference in self.references]
        each = [single_precision_errors(path, steps, left_out) for path, left_out in paths]
        return {name: max(errors[name] for errors in each) for name in self.tolerance}

    def _worst(self, rung: Rung) -> int:
        """Return the number of the motion on which the model of a rung is predicted to be worst."""
        entries = [tuple(path.joints.index(name) for name in rung.left_out) for path in self.paths]
        each = [spring_errors([Deviations(path)], [left])[0] for path, left in zip(self.paths, entries, strict=True)]
        errors = [relative(one.locked if rung.locked else one.static, self.tolerance) for one in each]
        return int(np.argmax(errors))

    def _fine(self, reference: Reference) -> int:
        """Return steps that take little of the tolerance, the same for all rungs of a motion."""
        simulating = self.reduced(Rung((), False, {}), reference)
        limits = {name: FINE * limit for name, limit in self.tolerance.items()}
        return enough_steps(simulating, METHODS[TimeStep.W3], limits, 1.0)[0]

    def _observed(self, rung: Rung, reference: Reference, method: str, steps: int) -> tuple[Trajectory, Array]:
        observer = self._observer(rung, reference)
        if self._moves(rung):
            trajectory = self._compiled(rung, reference, method).run(observer.reference, method, steps)
        else:
            trajectory = prescribed(observer.reference, steps)
        whole = whole_motion(reference, observer, observer.motion(trajectory))
        return trajectory, self._whole[self._number(reference)].outputs(whole)

    def _observer(self, rung: Rung, reference: Reference) -> Observer:
        key = rung.left_out, rung.locked, self._number(reference)
        if key not in self._observers:
            reduced = self._reduced_reference(rung, reference)
            self._observers[key] = Observer(reduced.machine, reduced, ())
        return self._observers[key]

    @cached_property
    def _whole(self) -> tuple[Observer, ...]:
        return tuple(Observer(self.machine, reference, tuple(self.tolerance)) for reference in self.references)

    def _compiled(self, rung: Rung, reference: Reference, method: str) -> CompiledSteps:
        key = rung.left_out, self._number(reference), method
        if key not in self._libraries:
            machine = self._observer(rung, reference).reference.loaded
            with TemporaryDirectory() as folder:
                self._libraries[key] = CompiledSteps(machine, [method], Path(folder))
        return self._libraries[key]

    def _errors_of_steps(self, rung: Rung, reference: Reference) -> tuple[dict[str, float], float]:
        assert rung.chosen is not None
        if not rung.chosen.method:
            return dict.fromkeys(self.tolerance, 0.0), 0.0
        method = METHODS[rung.chosen.method]
        coarse = self._observed(rung, reference, method.name, rung.chosen.steps)
        fine = self._observed(rung, reference, method.name, 2 * rung.chosen.steps)
        errors = errors_by_halving(method, coarse, fine)
        return dict(zip(self.tolerance, errors.tolist(), strict=True)), coarse[0].seconds


def reduced_machine(machine: Machine, reference: Reference, rung: Rung) -> Machine:
    """Return the machine with the springs that a rung leaves out held where a motion starts, static or locked."""
    rows = {joint.name: k for k, joint in enumerate(machine.moving_joints)}
    positions = {name: Formula.parse(float(reference.start.q[rows[name]])) for name in rung.left_out}
    return restricted(machine, Scene(locked=positions) if rung.locked else Scene(static=dict(positions)))


def _by_cost(rungs: Sequence[Rung]) -> list[int]:
    """Return the numbers of the rungs that fit, the cheapest first."""
    costs = {k: rung.chosen.cost for k, rung in enumerate(rungs) if rung.chosen}
    return sorted(costs, key=lambda k: costs[k])
