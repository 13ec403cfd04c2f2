"""The program with the fewest operations that stays within tolerances over a box of arguments.

    1. Draw states; the largest values of the results there give their tolerances.
    2. Search the changes that save most, within the limits at these states.
    3. Climb to the worst states of the reduced program, and evaluate more random ones. Where a tolerance is exceeded,
       these states join the sample, and the search starts again, from as many of its changes as are within limits.
    4. Judge it: by the largest error at a million new states, by the bound on those at a million more, and, where there
       is one, by a bound on all states of the box. Where this exceeds a tolerance, the limit of that result is lowered
       by as much, and the search starts again.

The guarantee is that of the judges: "95 % confidence at 1e6 states" drawn as `box.drawn` says, or with `bound` what
it proves. States at rest are in the sample with limits of nearly zero for results that are zero there: these stay zero.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.within.results import Reduction, Tolerances
from symoro_elastic.numerics.within.search import NO_CHANGES_ACCEPTED
from symoro_elastic.numerics.within.states import Bounds, Box
from symoro_elastic.numerics.within.tape import Tape, rows_at
from symoro_elastic.numerics.within.trials import Requirements, Task, Trial, Worst
from symoro_elastic.symbolic.program import Program

MOST_SEARCHES, WITH_STATES = 20, 5
"""After so many searches limits are lowered, too, where errors at other states are too large."""
FAR = 10.0
"""Times a tolerance: a bound above it is far from a proof."""
SLACK, LEAST_FACTOR, LEAST_OF_FAR = 0.98, 0.4, 0.03
"""What a limit is lowered to, of what would do if errors were proportional to it; at least by this factor."""
MOST_IMPROVED, LEFT_OVER = 2, 0.9
"""Further searches with higher limits, where all errors together leave more than a tenth of every tolerance."""
STATES = 300


def reduce_program(
    program: Program, box: Box, tolerances: Tolerances, required: Requirements | None = None
) -> Reduction:
    """Return the reduced program with the fewest operations whose errors are within the tolerances over the box.

    `program` depends on symbols of the box only: parameters are numbers. Where nothing can be left out, the program
    stays. Ctrl-C ends the search with the best program so far. Raises `ValueError` for a symbol without an interval, an
    output without a tolerance, results that are not finite; `KeyboardInterrupt` where there is no such program yet.
    """
    return _reduction(Task(program, box, tolerances, required or Requirements()))


def without_parameters(
    program: Program,
    box: Box,
    tolerances: Tolerances,
    values: Mapping[str, float],
    inertia: Program | None = None,
    required: Requirements | None = None,
) -> Reduction:
    """Return the program with as many parameters set to zero as the tolerances allow, as `reduce_program` does.

    `values` are those of the parameters, which are symbols of the program: base inertial parameters, none of them zero.
    `inertia` is the program of the inertia matrix, with the same symbols: it stays positive definite. Whatever
    parameters are zero, models that have them keep all their structure. `left_out` names these parameters; the reduced
    program holds the symbols of the others.
    """
    box = {**box, **{name: Range(value, value) for name, value in values.items()}}
    task = Task(program, box, tolerances, required or Requirements())
    task.only_zeros_of(values, HasInertia(inertia, box, task.seed) if inertia else None)
    return _reduction(task)


def _reduction(task: Task) -> Reduction:
    """Search, look for states where errors are too large, judge; again until a tolerance is nowhere exceeded.

    The program is then improved by higher limits. Where the user ends the search, the best one that was judged is
    returned; raises `KeyboardInterrupt` where there is none.
    """
    best = Best()
    try:
        _search(task, best)
    except KeyboardInterrupt:
        if best.trial is None:
            raise
        return replace(best.trial.reduction(), ended=True)
    trial = best.trial or task.without_changes()
    return replace(trial.reduction(), unproven="" if best.trial else best.unproven)


def _search(task: Task, best: Best) -> None:
    """Note the best trial."""
    sample, limits, far, improved = task.first_sample(), np.ones(len(task.allowed)), 0, 0
    former = NO_CHANGES_ACCEPTED
    for number in range(MOST_SEARCHES if task.candidates and len(limits) else 0):
        task.required.announce(f"leave out, search {number + 1}")
        trial = task.search(sample, limits, number, former)
        former = trial.accepted
        if not trial.accepted.changes:
            return
        worst = _worst_of(trial, task.required)
        if worst:
            sample = np.concatenate([sample, *worst.states], axis=1)
            limits = _lower_limits(limits, trial.sampled, worst.errors) if number >= WITH_STATES else limits
            continue
        errors = trial.error_bounds()
        if (errors <= 1).all() and not trial.keeps_frequencies():
            if best.trial:
                return
            continue
        if (errors <= 1).all():
            best.note(trial)
            improved += 1
            factor = np.where((errors > 0) & (errors < LEFT_OVER), SLACK / np.maximum(errors, SLACK / 2), 1.0)
            raised = np.minimum(limits * factor, 1.0)
            if improved > MOST_IMPROVED or not (trial.raises_frequencies() or (raised > limits).any()):
                return
            limits = raised
            continue
        best.unproven = task.farthest(errors)
        far += not (errors <= FAR).all()
        if best.trial or far >= task.required.most_unproven:
            return
        limits = _lower_limits(limits, trial.sampled, errors)


@dataclass
class Best:
    """The best trial so far that all judges accept, and why there is none."""

    trial: Trial | None = None
    unproven: str = ""

    def note(self, trial: Trial) -> None:
        """Keep a trial that saves more than the one before."""
        if self.trial is None or trial.cost < self.trial.cost:
            self.trial = trial


def _worst_of(trial: Trial, required: Requirements) -> Worst | None:
    """Return the errors of a trial that are too large, with the states; None where it is within the tolerances."""
    worst = trial.too_large()
    if worst:
        return worst
    if required.bound:
        required.announce("prove")
        trial.apply(required.bound)
    if (trial.error_bounds() <= 1).all():
        required.announce("look at unseen states")
        return trial.too_large_unseen()
    return None


def _lower_limits(limits: Array, sampled: Array, errors: Array) -> Array:
    """Lower the limits of results with errors above 1 to less than what the search has reached at its sample.

    Errors are of the tolerances; where one is NaN, its limit is lowered by a factor.
    """
    least = np.where(errors <= FAR, LEAST_FACTOR, LEAST_OF_FAR)
    factor = np.maximum(SLACK / np.maximum(np.nan_to_num(errors, nan=np.inf), SLACK), least)
    reached = np.where(sampled > 0, np.minimum(limits, sampled), limits)
    return np.where(errors <= 1, limits, reached * factor)


class HasInertia:
    """A check at positions drawn from a box; its program has one output, the inertia matrix."""

    def __init__(self, inertia: Program, box: Box, seed: int) -> None:
        self._tape = Tape(inertia)
        self._states = Bounds.of(self._tape, box).draw(STATES, np.random.default_rng([seed, 5]))
        (output,) = inertia.outputs
        self._shape = output.shape

    def __call__(self, zero: Collection[str]) -> bool:
        """Whether all eigenvalues are positive where these parameters are zero."""
        states = self._states.copy()
        states[[number for number, name in enumerate(self._tape.symbols) if name in zero]] = 0.0
        entries = rows_at(self._tape.rows(states), self._tape.entries[0])
        matrices = entries.T.reshape(-1, *self._shape)
        return bool(np.isfinite(matrices).all() and (np.linalg.eigvalsh(matrices) > 0).all())
