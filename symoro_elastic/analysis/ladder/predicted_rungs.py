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
from symoro_elastic.codegen.integration.methods import METHODS
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.quantities.time_steps import TimeStep

FINE = 0.01
"""Of the tolerance that steps take where a model is measured."""
WHOLE = Rung((), False, {})
"""No spring is left out."""
ROUNDINGS = 4.0
"""Roundings of a force in generated code, as they add up."""


class Prediction:
    """What the linear models of a machine along its motions say of rungs; motions have numbers k."""

    def __init__(
        self,
        machine: Machine,
        references: tuple[Reference, ...],
        tolerance: Mapping[str, float],
        period: float | None = None,
        condensed: tuple[str, ...] = (),
    ) -> None:
        """`condensed` are lines on springs in series that the machine has as one."""
        self.machine, self.references, self.tolerance = machine, references, dict(tolerance)
        self.condensed = condensed
        self.request = Request(tuple(tolerance), tolerance, period=period)

    @cached_property
    def paths(self) -> tuple[LinearPath, ...]:
        """The linear models along the motions."""
        return tuple(resolved_path(reference, self.tolerance) for reference in self.references)

    def rungs(self, progress: Progress = no_progress) -> tuple[Rung, ...]:
        """Return all rungs, those that fit with method and steps."""
        found = backward_greedy(self.paths, self.tolerance, progress)
        rungs = [Rung(one.left_out, False, one.static) for one in found]
        rungs += [Rung(found[-1].left_out, True, found[-1].locked)] if found[-1].left_out else []
        return tuple(replace(rung, chosen=self.steps_of(rung)) if self.fits(rung) else rung for rung in rungs)

    def fits(self, rung: Rung) -> bool:
        """Whether the predicted errors of a rung leave room for those of steps, and its springs hold their loads."""
        if relative(rung.predicted, self.tolerance) > MODEL_SHARE:
            return False
        return self.holds(rung)

    def holds(self, rung: Rung) -> bool:
        """Whether the springs that a rung leaves out hold their loads."""
        return rung.locked or all(self._holds_along(rung, path) for path in self.paths)

    @staticmethod
    def _holds_along(rung: Rung, path: LinearPath) -> bool:
        """Whether the stiffness of the springs left out, with gravity and loads, is positive along a motion."""
        rows = list(Prediction._springs(rung, path))
        block = path.K[:, rows][:, :, rows]
        symmetric = (block + block.transpose(0, 2, 1)) / 2
        return not rows or bool(np.linalg.eigvalsh(symmetric).min() > 0)

    def moves(self, rung: Rung) -> bool:
        """Whether anything is left whose motion is not prescribed."""
        path = self.paths[0]
        return bool({*path.names(path.moved)} - {*rung.left_out})

    def steps_of(
        self, rung: Rung, only: Iterable[str] = (), tolerance: Mapping[str, float] | None = None, share: float = SHARE
    ) -> Steps:
        """Return the cheapest method and steps that suffice for all motions, with a share of the tolerances."""
        tolerance = tolerance or self.tolerance
        if not self.moves(rung):
            return Steps("", 1, dict.fromkeys(self.tolerance, 0.0), 1)
        each = [self._simulating(rung, k) for k in range(len(self.references))]
        best: Steps | None = None
        for name in only or each[0].candidates():
            method = METHODS[name]
            operations = each[0].cost.of(method)
            least = max(simulating.stable_steps(method) for simulating in each)
            if best and least * operations >= best.cost:
                continue
            found = [enough_steps(simulating, method, tolerance, share) for simulating in each]
            one = Steps(name, *max(found, key=lambda pair: pair[0]), operations)
            best = one if best is None or one.cost < best.cost else best
        assert best is not None
        return best

    def operations_of(self, rung: Rung, method: str) -> int:
        """Return the weighted operations of a step of a rung by a method."""
        return self._simulating(rung, 0).cost.of(METHODS[method]) if method else 1

    def fine_steps(self, k: int) -> int:
        """Return steps of w3 that take little of the tolerance, the same for all rungs of a motion."""
        limits = {name: FINE * limit for name, limit in self.tolerance.items()}
        return enough_steps(self._simulating(WHOLE, k), METHODS[TimeStep.W3], limits, 1.0)[0]

    def worst_motion(self, rung: Rung) -> int:
        """Return the number of the motion on which the model of a rung is worst."""
        entries = tuple(map(self.paths[0].joints.index, rung.left_out))
        each = [spring_errors([Deviations(path)], [entries])[0] for path in self.paths]
        errors = [relative(one.locked if rung.locked else one.static, self.tolerance) for one in each]
        return int(np.argmax(errors))

    def arithmetic(self, rung: Rung) -> dict[str, float]:
        """Return what single precision of the accelerations adds to the errors of a rung, largest over the motions."""
        if not self.moves(rung) or rung.chosen is None:
            return dict.fromkeys(self.tolerance, 0.0)
        each = [
            single_precision_errors(self._path(rung, k), rung.chosen.steps, self._springs(rung, path))
            for k, path in enumerate(self.paths)
        ]
        return {name: max(errors[name] for errors in each) for name in self.tolerance}

    def reduced(self, rung: Rung, k: int) -> Reference:
        """Return a motion of the machine of a rung, its springs held where the motion of the whole machine starts."""
        reference, joints = self.references[k], self.machine.independent_joints
        kept = [row for row, joint in enumerate(joints) if joint.name not in rung.left_out]
        state = reference.start
        start = replace(state, q=state.q[kept], qd=state.qd[kept], qdd=state.qdd[kept], tau=state.tau[kept])
        machine, drives = reduced_machine(self.machine, reference, rung), without_parts(reference.drives, rung.left_out)
        return replace(reference, machine=machine, start=start, drives=drives)

    def _simulating(self, rung: Rung, k: int) -> Simulating:
        linear = self._path(rung, k), self._springs(rung, self.paths[k])
        return Simulating(self.reduced(rung, k), self.request, linear)

    def _path(self, rung: Rung, k: int) -> LinearPath:
        """Return the linear model of a rung on one motion."""
        path, springs = self.paths[k], self._springs(rung, self.paths[k])
        path = path.without_parts([name for name in rung.left_out if name not in path.names(springs)])
        return path if rung.locked else path.recovering(springs)

    @staticmethod
    def _springs(rung: Rung, path: LinearPath) -> tuple[int, ...]:
        """Return the entries of q that a rung leaves out."""
        known = {path.joints[k]: k for k in path.springs}
        return tuple(known[name] for name in rung.left_out if name in known)


def held_springs(machine: Machine, reference: Reference, rung: Rung) -> dict[str, Formula]:
    """Return by joint where the springs that a rung leaves out are held: where a motion starts, or they are neutral."""
    rows = {joint.name: (k, joint) for k, joint in enumerate(machine.independent_joints)}
    springs = [name for name in rung.left_out if name in rows]
    held = {name: Formula.parse(float(reference.start.q[rows[name][0]])) for name in springs}
    return held | {name: rows[name][1].spring.neutral for name in rung.neutral}


def reduced_machine(machine: Machine, reference: Reference, rung: Rung) -> Machine:
    """Return the machine with the springs that a rung leaves out held, without the numbers and parts of drives."""
    held = held_springs(machine, reference, rung)
    zero = zeros_of(rung, held)
    if rung.locked:
        return restrict(machine, Scene(locked=held, zero=zero))
    return restrict(machine, Scene(static=dict(held), zero=zero))


def zeros_of(rung: Rung, held: Collection[str]) -> tuple[str, ...]:
    """Return the parts of drives and the numbers that a rung leaves out, beside the springs that are held."""
    return (*(name for name in rung.left_out if name not in held), *rung.zero)


def single_precision_errors(path: LinearPath, steps: int, left_out: Collection[int] = ()) -> dict[str, float]:
    """Return the errors of outputs, by name, where accelerations are rounded at every step of a motion.

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
    """Return what rounding to single precision changes."""
    changed: Array = x.astype(np.float32).astype(float) - x
    return changed
