"""The budget of a ladder: its path, whose end is simulated beside the whole machine, in double and mixed precision."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.analysis.ladder.budget import Budget, MeasuredEnd, PathStep, Spent
from symoro_elastic.analysis.ladder.budget_path import FILLED, BudgetPath
from symoro_elastic.analysis.ladder.measured_rungs import Measurement
from symoro_elastic.analysis.ladder.predicted_rungs import WHOLE, Prediction
from symoro_elastic.analysis.ladder.rung import Rung, Steps
from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.codegen.precision import DOUBLE, MIXED, Precision
from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.quantities.time_steps import TimeStep

FASTER = 0.95
"""Of the time of a step in double precision: what a step in mixed precision takes at most, to be worth its error."""
ROUNDS, TIMED_STEPS = 15, 2000


def budget_of(
    measurement: Measurement, rungs: Sequence[Rung], full: Steps, alone: Steps | None, progress: Progress = no_progress
) -> Budget:
    """Return the budget of a ladder; `alone` are the time steps where springs alone are left out. Raises `InputError`.

    Steps at the end of the path that a simulation does not confirm are taken back: measured errors that are beyond the
    tolerances.
    """
    prediction = measurement.prediction
    path = list(BudgetPath(prediction, rungs).run(progress))
    dropped: list[PathStep] = []
    while True:
        errors = measured_errors(measurement, path[-1].rung)
        if relative(errors, prediction.tolerance) <= 1 or len(path) == 1:
            break
        dropped.insert(0, path.pop())
    seconds, mixed = times(measurement, path[-1].rung)
    in_mixed = measured_errors(measurement, path[-1].rung, MIXED)
    if mixed <= FASTER * seconds and relative(in_mixed, prediction.tolerance) <= 1:
        path += _in_mixed_precision(prediction, path[-1])
    errors = in_mixed if path[-1].spent is Spent.PRECISION else errors
    end = MeasuredEnd(errors, in_mixed, seconds, mixed)
    return Budget(prediction.machine, prediction.tolerance, tuple(path), end, full, alone, tuple(dropped))


def measured_errors(measurement: Measurement, rung: Rung, precision: Precision = DOUBLE) -> dict[str, float]:
    """Return how far outputs are from those of the whole machine, on the motion that is worst for a rung's springs.

    The whole machine takes steps that need little of the tolerances, the rung its own: errors are of everything.
    """
    assert rung.chosen is not None
    prediction, k = measurement.prediction, measurement.prediction.worst_motion(rung)
    fine, steps, method = prediction.fine_steps(k), rung.chosen.steps, rung.chosen.method
    steps = steps if method else fine
    (exact, whole) = measurement.simulated(WHOLE, k).run(TimeStep.W3, steps * -(-fine // steps))
    (run, found) = measurement.simulated(rung, k).run(method, steps, precision)
    _, here, there = np.intersect1d(_places(run, exact), _places(exact, exact), return_indices=True)
    with np.errstate(invalid="ignore"):
        apart = np.abs(found[here] - whole[there]).max(axis=0)
    return dict(zip(prediction.tolerance, np.where(np.isfinite(apart), apart, np.inf).tolist(), strict=True))


def _places(run: Trajectory, fine: Trajectory) -> AnyArray:
    """Return the numbers of the fine steps at which states of a run were kept."""
    return np.round(run.t / fine.step).astype(np.int64)


def times(measurement: Measurement, rung: Rung) -> tuple[float, float]:
    """Return the least time of a step in double and in mixed precision, s, by turns."""
    assert rung.chosen is not None
    method, steps = rung.chosen.method, rung.chosen.steps
    if not method:
        return 0.0, 0.0
    simulated = measurement.simulated(rung, 0)
    each = [simulated.compiled(method, precision) for precision in (DOUBLE, MIXED)]
    steps *= max(1, TIMED_STEPS // steps)
    rounds = [[one.run(simulated.reduced, method, steps).seconds for one in each] for _ in range(ROUNDS)]
    double, mixed = np.min(rounds, axis=0).tolist()
    return double, mixed


def _in_mixed_precision(prediction: Prediction, last: PathStep) -> list[PathStep]:
    """Return the same model in mixed precision; nothing where its rounding has no room."""
    added = prediction.arithmetic(last.rung)
    total = {name: x + added[name] for name, x in last.total.items()}
    if any(total[name] > FILLED * limit for name, limit in prediction.tolerance.items()):
        return []
    return [PathStep(Spent.PRECISION, (), added, total, last.rung)]
