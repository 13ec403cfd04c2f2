"""Rungs of a ladder by prediction: springs are left out one by one, each rung has the cheapest steps that suffice.

Where accelerations are in single precision and states in double, the roundings act on the machine as forces.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.ladder.greedy import backward_greedy
from symoro_elastic.analysis.ladder.rung import MODEL_SHARE, Rung, Steps
from symoro_elastic.analysis.simulation.prediction.loops import without_parts
from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.resolution import resolved_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative, spring_errors
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.simulate import SHARE, Request, Simulating, enough_steps
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.quantities.time_steps import TimeStep

FINE = 0.01
"""Fraction of the tolerance for steps where a model is measured."""
WHOLE = Rung((), False, {})
"""No spring is left out."""
ROUNDINGS = 4.0
"""Roundings of a force in generated code, as they add up."""


class Prediction:
    """Predicted errors and time steps of reduced models (rungs), by linear models of a machine along its motions."""

    def __init__(
        self,
        machine: Machine,
        references: tuple[Reference, ...],
        tolerance: Mapping[str, float],
        period: float | None = None,
        condensed: tuple[str, ...] = (),
    ) -> None:
        """Prepare the prediction; `condensed` are notes on springs in series that were merged."""
        self.machine, self.references, self.tolerance = machine, references, dict(tolerance)
        self.condensed = condensed
        self.request = Request(tuple(tolerance), tolerance, period=period)

    @cached_property
    def paths(self) -> tuple[LinearPath, ...]:
        """The linear models along the motions."""
        return tuple(resolved_path(reference, self.tolerance) for reference in self.references)

    def rungs(self, progress: Progress = no_progress, announce: Announce = announce_nothing) -> tuple[Rung, ...]:
        """Return all rungs, with method and steps for those whose predicted errors fit."""
        errors = backward_greedy(self.paths, self.tolerance, progress)
        rungs = [Rung(x.left_out, False, x.static) for x in errors]
        rungs += [Rung(errors[-1].left_out, True, errors[-1].locked)] if errors[-1].left_out else []
        announce("predict time steps")
        for k, rung in enumerate(rungs):
            rungs[k] = replace(rung, chosen=self.steps_of(rung)) if self.fits(rung) else rung
            progress(k + 1, len(rungs))
        return tuple(rungs)

    def fits(self, rung: Rung) -> bool:
        """Whether a rung's predicted errors leave slack for errors of steps, and omitted springs carry their loads."""
        return relative(rung.predicted, self.tolerance) <= MODEL_SHARE and self.holds(rung)

    def holds(self, rung: Rung) -> bool:
        """Whether the springs that a rung omits can carry their loads."""
        for path in () if rung.locked else self.paths:
            rows = list(self._springs(rung, path))
            block = path.K[:, rows][:, :, rows]  # with gravity and loads
            if rows and not np.linalg.eigvalsh((block + block.transpose(0, 2, 1)) / 2).min() > 0:
                return False
        return True

    def moves(self, rung: Rung) -> bool:
        """Whether any joint remains whose motion is not prescribed."""
        path = self.paths[0]
        return bool({*path.names(path.moved)} - {*rung.left_out})

    def steps_of(
        self, rung: Rung, only: Iterable[str] = (), tolerance: Mapping[str, float] | None = None, share: float = SHARE
    ) -> Steps:
        """Return the cheapest method and steps that suffice for all motions, within a `share` of the tolerances."""
        tolerance = tolerance or self.tolerance
        if not self.moves(rung):
            return Steps("", 1, dict.fromkeys(self.tolerance, 0.0), 1)
        simulations = [self._simulating(rung, k) for k in range(len(self.references))]
        best: Steps | None = None
        for name in only or simulations[0].candidates():
            method = METHODS[name]
            operations = simulations[0].cost.of(method)
            least = max(simulating.stable_steps(method) for simulating in simulations)
            if best and least * operations >= best.cost:
                continue
            sufficient = [enough_steps(simulating, method, tolerance, share) for simulating in simulations]
            candidate = Steps(name, *max(sufficient, key=lambda pair: pair[0]), operations)
            best = candidate if best is None or candidate.cost < best.cost else best
        assert best is not None
        return best

    def operations_of(self, rung: Rung, method: str) -> int:
        """Return the weighted operations of a step of a rung by a method."""
        return self._simulating(rung, 0).cost.of(METHODS[method]) if method else 1

    def fine_steps(self, k: int) -> int:
        """Return the number of W3 steps whose error is a small fraction of the tolerance, for all rungs of motion k."""
        limits = {name: FINE * limit for name, limit in self.tolerance.items()}
        return enough_steps(self._simulating(WHOLE, k), METHODS[TimeStep.W3], limits, 1.0)[0]

    def worst_motion(self, rung: Rung) -> int:
        """Return the number of the motion with the largest predicted error of a rung."""
        entries = tuple(map(self.paths[0].joints.index, rung.left_out))
        by_motion = [spring_errors([Deviations(path)], [entries])[0] for path in self.paths]
        errors = [relative(x.locked if rung.locked else x.static, self.tolerance) for x in by_motion]
        return int(np.argmax(errors))

    def arithmetic(self, rung: Rung) -> dict[str, float]:
        """Return the errors that single precision of the accelerations adds to a rung, largest over the motions."""
        if not self.moves(rung) or rung.chosen is None:
            return dict.fromkeys(self.tolerance, 0.0)
        by_motion = [
            single_precision_errors(self._path(rung, k), rung.chosen.steps, self._springs(rung, path))
            for k, path in enumerate(self.paths)
        ]
        return {name: max(errors[name] for errors in by_motion) for name in self.tolerance}

    def reduced_reference(self, rung: Rung, k: int) -> Reference:
        """Return motion k for the machine of a rung, its omitted springs fixed at the start of the motion."""
        reference, joints = self.references[k], self.machine.independent_joints
        rows = [row for row, joint in enumerate(joints) if joint.name not in rung.left_out]
        state = reference.start
        start = replace(state, q=state.q[rows], qd=state.qd[rows], qdd=state.qdd[rows], tau=state.tau[rows])
        machine, drives = reduced_machine(self.machine, reference, rung), without_parts(reference.drives, rung.left_out)
        return replace(reference, machine=machine, start=start, drives=drives)

    def _simulating(self, rung: Rung, k: int) -> Simulating:
        linear = self._path(rung, k), self._springs(rung, self.paths[k])
        return Simulating(self.reduced_reference(rung, k), self.request, linear)

    def _path(self, rung: Rung, k: int) -> LinearPath:
        """Return the linear model of a rung on one motion."""
        path, springs = self.paths[k], self._springs(rung, self.paths[k])
        path = path.without_parts([name for name in rung.left_out if name not in path.names(springs)])
        return path if rung.locked else path.recovering(springs)

    @staticmethod
    def _springs(rung: Rung, path: LinearPath) -> tuple[int, ...]:
        """Return the entries in q of the springs that a rung omits."""
        entries = {path.joints[k]: k for k in path.springs}
        return tuple(entries[name] for name in rung.left_out if name in entries)


def held_springs(machine: Machine, reference: Reference, rung: Rung) -> dict[str, Formula]:
    """Return positions, by joint, at which a rung fixes omitted springs: initial, or neutral where it says so."""
    rows = {joint.name: (k, joint) for k, joint in enumerate(machine.independent_joints)}
    springs = [name for name in rung.left_out if name in rows]
    starts = {name: Formula.parse(float(reference.start.q[rows[name][0]])) for name in springs}
    return starts | {name: rows[name][1].spring.neutral for name in rung.neutral}


def reduced_machine(machine: Machine, reference: Reference, rung: Rung) -> Machine:
    """Return the machine of a rung: its springs static or locked, its omitted numbers and parts of drives zero."""
    positions = held_springs(machine, reference, rung)
    zero = zeros_of(rung, positions)
    if rung.locked:
        return restrict(machine, Scene(locked=positions, zero=zero))
    return restrict(machine, Scene(static=dict(positions), zero=zero))


def zeros_of(rung: Rung, static: Collection[str]) -> tuple[str, ...]:
    """Return the parts of drives and the numbers that a rung omits; not the static springs."""
    return (*(name for name in rung.left_out if name not in static), *rung.zero)


def single_precision_errors(path: LinearPath, steps: int, left_out: Collection[int] = ()) -> dict[str, float]:
    """Return the errors of outputs, by name, if accelerations are rounded to single precision at every step.

    The forces of inertia and of springs are rounded to single precision; what is lost drives the same linear model.
    """
    path = path.finer(steps + 1)
    motion = path.without([left_out])
    accelerations = path.states(path.t)[2] + motion.ddd[:, 0]
    forces = np.einsum("tij,tj->ti", path.M, accelerations)
    springs = path.stiffness * motion.d[:, 0] + path.preload
    lost = ROUNDINGS * (_rounding(forces) + _rounding(springs))
    changes = path.outputs.of(path.without([left_out], lost))[:, 0]
    return dict(zip(path.outputs.names, np.abs(changes).max(axis=0).tolist(), strict=True))


def _rounding(x: Array) -> Array:
    """Return the rounding errors of single precision, float32(x) - x."""
    return np.asarray(x.astype(np.float32).astype(float) - x)
