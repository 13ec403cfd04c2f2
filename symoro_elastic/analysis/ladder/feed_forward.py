"""Torques that are fed forward by a reduced inverse model, whose omitted terms keep tolerances at the tool.

    1. Tolerances of outputs become tolerances of torques (`torque_tolerances`): each motor has its share.
    2. Terms of the inverse model are left out while its torques keep them over the operating range of the motion.
    3. The error of these torques along the motion, through the linear model of the controlled machine, is the error
       that is predicted at the outputs. Shares are for errors of any course, so this is less than the tolerance: all
       shares are scaled until it reaches it.
    4. The controlled machine is simulated with the torques of the full and of the reduced model.

The inverse model is that of motors: all other joints are locked where the motion starts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from symoro_elastic.analysis.ladder.predicted_rungs import WHOLE, Prediction
from symoro_elastic.analysis.ladder.rung import PREDICTED_FRACTION
from symoro_elastic.analysis.ladder.rungs import Measurement
from symoro_elastic.analysis.ladder.torque_tolerances import TorqueTolerance, added_torques, torque_tolerances
from symoro_elastic.analysis.simulation.motor_coordinates import InverseModelOfMotors
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.generation.reduced_models.search import reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.limits import JointLimits, Limits, Range
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import EXACT, Evidence, Tolerance, Within
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.budget import ErrorBudget
from symoro_elastic.quantities.time_steps import TimeStep
from symoro_elastic.symbolic.program import Program

MODEL = "inverse_dynamics"
WHOLE_SCENE = Scene()
CLOSE = 0.8
"""Of the tolerances: a prediction above it ends the search for a scale."""
MOST_SEARCHES = 6
LARGEST_FACTOR = 30.0
"""Between two scales of the shares."""
WIDENED = 1.1
"""The operating range is that of the motion, widened about its middle."""


@dataclass(frozen=True)
class ReducedTorques:
    """A reduced inverse model: the scale of its error shares, its torque errors, and the errors at outputs.

    `torque` (by motor) are the largest along the motions, `predicted` those of outputs by the linear model, `measured`
    by simulation, None where it was not simulated. `package` has the program.
    """

    scale: float
    model: ReducedModel
    package: Package
    torque: Mapping[str, float]
    predicted: Mapping[str, float]
    measured: Mapping[str, float] | None = None

    @property
    def operations(self) -> int:
        """Operations of a call."""
        return self.model.operations[1]


@dataclass(frozen=True)
class FeedForward:
    """The required torque accuracy, and reduced inverse models in the order of their search.

    `advised` is the number of the one with the fewest operations whose errors are within the tolerances, None where
    nothing can be left out.
    """

    references: tuple[Reference, ...]
    tolerances: tuple[TorqueTolerance, ...]
    tried: tuple[ReducedTorques, ...]
    advised: int | None
    full: int
    scene: Scene

    @property
    def chosen(self) -> ReducedTorques | None:
        """The advised model."""
        return None if self.advised is None else self.tried[self.advised]

    @property
    def operations(self) -> int:
        """Operations of a call of the advised model, or of the full one."""
        return self.chosen.operations if self.chosen else self.full


class FeedForwardSearch:
    """Search for a reduced inverse model for the motions of a prediction; `evidence` is required of torque errors.

    Torques are computed in `precision`, whose rounding errors are within the tolerances, too.
    """

    def __init__(
        self,
        prediction: Prediction,
        machine: DescribedMachine,
        scene: Scene = WHOLE_SCENE,
        evidence: Evidence = Evidence.CONFIDENT,
        precision: Precision = DOUBLE,
    ) -> None:
        """Prepare; raises `InputError` for exactly prescribed motors, and machines without inverse model."""
        self.prediction, self.evidence, first = prediction, evidence, prediction.references[0]
        self.precision = precision
        if first.servo is None:
            what = "motors follow exactly, so no torque error moves them: give servos or drives, or --for simulation"
            raise first.prescribed.error("servo", what)
        self.budget = ErrorBudget(prediction.tolerance, PREDICTED_FRACTION)
        self._references = prediction.references
        self.full = [InverseModelOfMotors(x.machine, x.start.q) for x in self._references]
        pairs = zip(first.machine.independent_joints, first.start.q.tolist(), strict=True)
        start = {joint.name: Formula.parse(x) for joint, x in pairs if joint.name not in first.motors}
        locked, condense = {**scene.locked, **start}, scene.condense or bool(prediction.condensed)
        plain = replace(scene, outputs={}, steps=(), forces=(), within=EXACT)
        self.scene = replace(plain, models=(MODEL,), locked=locked, condense=condense, fold=ALL)
        self.machine = replace(machine, limits=Limits(operating_range(self._references), machine.limits.parameters))

    @cached_property
    def tolerances(self) -> tuple[TorqueTolerance, ...]:
        """The torque accuracy by motor that the tolerances of outputs require."""
        pairs = zip(self.full, self._references, strict=True)
        torques = [np.abs(full(*x.at(_times(x)))).max(axis=0) for full, x in pairs]
        return torque_tolerances(self.prediction.paths, self.prediction.tolerance, np.max(torques, axis=0))

    def run(self, announce: Announce = announce_nothing) -> FeedForward:
        """Return reduced models at several scales of the shares, and the advised one, measured.

        Ctrl-C ends the search with what there is; raises `KeyboardInterrupt` where there is nothing yet.
        """
        announce("tolerances of torques")
        models: list[ReducedTorques] = []
        try:
            models.extend(self._models(announce))
        except KeyboardInterrupt:
            if not models:
                raise
        full = models[0].model.operations[0]
        announce("simulate with the torques of both models")
        return self._result(models, full)

    def _models(self, announce: Announce) -> Iterator[ReducedTorques]:
        """Yield reduced models until the shares are scaled so that the tolerance is nearly used."""
        low, high, scale = 0.0, np.inf, 1.0
        for _ in range(MOST_SEARCHES):
            first = self.tolerances[0]
            announce(f"leave terms out, torques within {scale * first.share:.3g} ({first.motor})")
            yield (reduced := self._model(scale))
            used = self.budget.used_fraction(reduced.predicted)
            low, high = (scale, high) if used <= PREDICTED_FRACTION else (low, scale)
            if CLOSE <= used <= PREDICTED_FRACTION or not reduced.operations or high <= low * (2 - CLOSE):
                return
            if low > 0 and np.isfinite(high):  # between the largest that fits and the least that does not
                scale = float(np.sqrt(low * high))
            else:
                towards = PREDICTED_FRACTION / max(used, 1e-300)
                scale *= float(np.clip(towards, 1 / LARGEST_FACTOR, LARGEST_FACTOR))

    def _model(self, scale: float) -> ReducedTorques:
        """Return the inverse model reduced within the error shares times `scale`; raises `InputError`."""
        shares = {x.motor: Tolerance(scale * x.share, relative=False) for x in self.tolerances if np.isfinite(x.share)}
        scene = replace(self.scene, within=Within(shares, guaranteed=self.evidence))
        traced, (model,) = reduced_models(self.machine, scene, programs, [ROUNDINGS[self.precision.name]])
        torques, outputs = [], []
        for reference, path in zip(self._references, self.prediction.paths, strict=True):
            errors = self._torque_errors(model, reference, path.t)
            forces = np.einsum("tnm,tm->tn", added_torques(path), errors)
            torques.append(np.abs(errors).max(axis=0))
            outputs.append(np.abs(path.outputs.of(path.without([()], forces))).max(axis=(0, 1)))
        torque = np.max(torques, axis=0)
        predicted = dict(zip(self.prediction.tolerance, np.max(outputs, axis=0).tolist(), strict=True))
        by_motor = dict(zip(self._references[0].motors, torque.tolist(), strict=True))
        return ReducedTorques(scale, model, traced.package, by_motor, predicted)

    def _torque_errors(self, model: ReducedModel, reference: Reference, t: Array) -> Array:
        """Return the torques (N, m) of a reduced model minus those of the full one."""
        before, after = (_torques(x, reference, t) for x in (model.reduction.program, model.reduction.reduced))
        return after - before

    def _result(self, models: list[ReducedTorques], full: int) -> FeedForward:
        """Return the result with the cheapest model whose predicted and measured errors are within the tolerances."""
        measurement = FedMeasurement(self.prediction, self.full)
        order = [k for k, x in enumerate(models) if x.operations < full and self.budget.fits(x.predicted)]
        advised = None
        for k in sorted(order, key=lambda k: models[k].operations):
            models[k] = replace(models[k], measured=measurement.errors(self.feed(models[k].model)))
            if self.budget.used_fraction(models[k].measured or {}) <= 1:
                advised = k
                break
        within = EXACT if advised is None else models[advised].model.within
        scene = replace(self.scene, within=within)
        return FeedForward(self._references, self.tolerances, tuple(models), advised, full, scene)

    def package_of(self, result: FeedForward) -> Package:
        """Return the program of the advised model, or of the full one."""
        return result.chosen.package if result.chosen else programs(self.machine, self.scene).package

    def feed(self, model: ReducedModel) -> Callable[[int, Array], Array]:
        """Return the function (number of a motion, times (N,)) -> torques (N, m) of a reduced model."""

        def torques(motion: int, t: Array) -> Array:
            reference = self._references[motion]
            return self.full[motion](*reference.at(t)) + self._torque_errors(model, reference, t)

        return torques


class FedMeasurement:
    """Simulations of the controlled machine with the torques of the full inverse model and of reduced ones."""

    def __init__(self, prediction: Prediction, full: Sequence[InverseModelOfMotors]) -> None:
        self.prediction, self._full = prediction, full
        self._exact: dict[int, Array] = {}

    def errors(self, torques: Any) -> dict[str, float]:
        """Return the largest change of each output if `torques(motion, t)` are fed forward, over all motions."""
        changes = []
        for k, reference in enumerate(self.prediction.references):
            full = self._full[k]
            if k not in self._exact:
                self._exact[k] = self._run(k, lambda t, full=full, reference=reference: full(*reference.at(t)))
            changes.append(np.abs(self._run(k, partial(torques, k)) - self._exact[k]).max(axis=0))
        return dict(zip(self.prediction.tolerance, np.max(changes, axis=0).tolist(), strict=True))

    def _run(self, k: int, feed: Any) -> Array:
        """Return outputs (N, names) of a motion with torques fed forward."""
        references = tuple(replace(x, feed=feed) if j == k else x for j, x in enumerate(self.prediction.references))
        fed = Prediction(self.prediction.machine, references, self.prediction.tolerance, self.prediction.request.period)
        _, outputs = Measurement(fed).simulation(WHOLE, k).run(TimeStep.W3, self.prediction.fine_steps(k))
        return outputs


def _torques(program: Program, reference: Reference, t: Array) -> Array:
    """Return the torques (N, m) of a program of the inverse model along the set points of a motion."""
    names = [joint.name for joint in reference.machine.independent_joints]
    order = [k for name in names for k in range(len(reference.motors)) if reference.motors[k] == name]
    blocks = dict(zip(("q", "qd", "qdd_motor", "qdd"), (*reference.at(t), reference.at(t)[2]), strict=True))
    symbols: dict[str, Any] = {}
    for argument in program.inputs:
        columns = blocks[argument.name]
        columns = columns if argument.name == "qdd_motor" else columns[:, order]
        symbols |= dict(zip(argument.symbols, columns.T, strict=True))
    (tau,) = (output for output in program.outputs if output.name == "tau")
    return values_along(tau.entries, symbols, len(t)).T


def _times(reference: Reference) -> Array:
    return np.linspace(0.0, reference.duration, 1001)


def operating_range(references: Sequence[Reference]) -> dict[str, JointLimits]:
    """Return positions, velocities and accelerations of the set points of all motions, by motor, widened."""
    blocks = np.concatenate([np.array(x.at(_times(x))) for x in references], axis=1)
    low, high = blocks.min(axis=1), blocks.max(axis=1)
    middle, half = (low + high) / 2, WIDENED * (high - low) / 2
    ends = np.stack([middle - half, middle + half], axis=-1).tolist()
    rows = [[Range(*pair) for pair in of_order] for of_order in ends]
    limits = [JointLimits(position=x, velocity=v, acceleration=a) for x, v, a in zip(*rows, strict=True)]
    return dict(zip(references[0].motors, limits, strict=True))
