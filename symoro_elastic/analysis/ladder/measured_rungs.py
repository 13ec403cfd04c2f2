"""Rungs of a ladder, simulated: what leaving springs out costs, and what steps cost, by halving them."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.analysis.ladder.predicted_rungs import WHOLE, Prediction
from symoro_elastic.analysis.ladder.rung import Measured, Rung
from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps, Trajectory, reference_motion
from symoro_elastic.analysis.simulation.drive_torques import with_loads
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.prediction.loads import with_passed_loads
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.simulate import errors_by_halving
from symoro_elastic.codegen.integration.methods import METHODS
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.quantities.time_steps import TimeStep


class Measurement:
    """The errors of rungs on the motions that are worst for them; what is compiled serves again."""

    def __init__(self, prediction: Prediction) -> None:
        self.prediction = prediction
        self._simulated: dict[tuple[Any, int], SimulatedRung] = {}

    def errors(self, rung: Rung) -> Measured:
        """Return the errors of a rung on the motion that is worst for it: of its model, and of its steps by halving."""
        k = self.prediction.worst_motion(rung)
        fine = self.prediction.fine_steps(k)
        (_, whole), (_, outputs) = (self.simulated(one, k).run(TimeStep.W3, fine) for one in (WHOLE, rung))
        model = np.abs(outputs - whole).max(axis=0)
        steps, seconds = self._errors_of_steps(rung, k)
        return Measured(self._by_output(model), self._by_output(steps), seconds)

    def simulated(self, rung: Rung, k: int) -> SimulatedRung:
        """Return the simulation of a rung on a motion."""
        key = rung.model, k
        if key not in self._simulated:
            self._simulated[key] = SimulatedRung(self.prediction, rung, k)
        return self._simulated[key]

    def _errors_of_steps(self, rung: Rung, k: int) -> tuple[Array, float]:
        """Return the errors (outputs,) of the steps of a rung and the seconds that one takes; NaN where it has none."""
        outputs = len(self.prediction.tolerance)
        if rung.chosen is None:
            return np.full(outputs, np.nan), np.nan
        if not rung.chosen.method:
            return np.zeros(outputs), 0.0
        method, steps, simulated = METHODS[rung.chosen.method], rung.chosen.steps, self.simulated(rung, k)
        coarse, fine = simulated.run(method.name, steps), simulated.run(method.name, 2 * steps)
        return errors_by_halving(method, coarse, fine), coarse[0].seconds

    def _by_output(self, x: Array) -> dict[str, float]:
        return dict(zip(self.prediction.tolerance, x.tolist(), strict=True))


class SimulatedRung:
    """A rung on one motion of the whole machine, simulated by even steps."""

    def __init__(self, prediction: Prediction, rung: Rung, k: int) -> None:
        self.whole, self.reduced = prediction.references[k], prediction.reduced(rung, k)
        self._moves = prediction.moves(rung)
        self._observer = Observer(self.reduced.machine, self.reduced, ())
        self._observer_of_whole = Observer(prediction.machine, self.whole, tuple(prediction.tolerance))
        self._compiled: dict[tuple[str, str], CompiledSteps] = {}

    def run(self, method: str, steps: int, precision: Precision = DOUBLE) -> tuple[Trajectory, Array]:
        """Return the motion of the rung, and the outputs (N, names) of the whole machine that follow from it."""
        if self._moves:
            trajectory = self.compiled(method, precision).run(self.reduced, method, steps)
        else:
            trajectory = with_passed_loads(self.reduced, reference_motion(self.reduced, steps))
        motion = whole_motion(self.whole, self._observer, self._observer.motion(trajectory))
        return trajectory, self._observer_of_whole.outputs(motion)

    def compiled(self, method: str, precision: Precision = DOUBLE) -> CompiledSteps:
        """Return compiled steps of a method."""
        key = method, precision.name
        if key not in self._compiled:
            with TemporaryDirectory() as folder:
                self._compiled[key] = CompiledSteps(with_loads(self.reduced), [method], Path(folder), precision)
        return self._compiled[key]


def whole_motion(reference: Reference, reduced: Observer, motion: Motion) -> Motion:
    """Return the motion of the whole machine of a reference from that of a reduced one.

    Springs that are left out stay where the motion starts; those that are static deflect by the reactions.
    Springs that are static in the whole machine have no variable in its motion.
    """
    rows = {joint.name: k for k, joint in enumerate(reference.machine.independent_joints)}
    moved = [rows[joint.name] for joint in reduced.machine.independent_joints]
    static = [rows[joint.name] for joint in reduced.machine.static.values() if joint.name in rows]

    def spread(x: Array, start: Array) -> Array:
        found = np.tile(start, (len(x), 1))
        found[:, moved] = x
        return found

    still = np.zeros(len(rows))
    q, qd, qdd = spread(motion.q, reference.start.q), spread(motion.qd, still), spread(motion.qdd, still)
    if static:
        q[:, static] = reduced.deflections(motion)
    return Motion({"q": q, "qd": qd, "qdd": qdd, **motion.only(("tau", "f_ext"))}, motion.t)
