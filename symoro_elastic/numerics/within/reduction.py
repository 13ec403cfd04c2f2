"""The program with the fewest operations that stays within tolerances over a box of arguments.

    1. Draw states; find how large each result is, and from that its tolerance.
    2. Search the changes that save most, within the limits at these states.
    3. Climb to the worst states of what was found, and look at more random ones. Where a tolerance is exceeded, these
       states join the sample, and the search starts again.
    4. Judge it: by the largest error at a million states that no search has seen, by the bound on those at a million
       more, and, where one is given, by a bound on all states of the box. Where this exceeds a tolerance, the limit of
       that result is lowered by as much, and the search starts again.

The guarantee is that of the judges: "95 % confidence at 1e6 states" drawn as `states.WORDS` says, or with `bound` what
it proves. States at rest are in the sample with limits of nearly zero for results that are zero there: these stay zero.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.within.inertia import HasInertia
from symoro_elastic.numerics.within.results import ErrorBound, Reduction, Tolerances
from symoro_elastic.numerics.within.states import Box, Point, joined
from symoro_elastic.numerics.within.trials import UNSEEN, Task
from symoro_elastic.symbolic.program import Names, Program

MOST_SEARCHES, WITH_STATES = 20, 5
"""After so many searches limits are lowered, too, where errors at other states are too large."""
MOST_UNPROVEN = 3
"""Searches of which nothing is proven, each with less left out than the one before: then the program stays whole."""
SLACK, LEAST_FACTOR = 0.98, 0.4
"""What a limit is lowered to, of what would do if errors were proportional to it; at least by this factor."""


def reduce_program(
    program: Program,
    box: Box,
    tolerances: Tolerances,
    *,
    names: Names | None = None,
    positions: Collection[str] = ("q",),
    seed: int = 0,
    states: int = UNSEEN,
    confident: bool = True,
    bound: ErrorBound | None = None,
    changing: Collection[int] | None = None,
) -> Reduction:
    """Return the program with the fewest operations found whose errors are within the tolerances over the box.

    `program` depends on symbols of the box only: parameters are numbers. `positions` name the arguments that hold
    positions, `names` are the quantities that keep their names. With `confident` the bound on errors at `states` more
    states is within the tolerances too, with `bound` that bound. Only nodes with numbers in `changing` change, if given. Where nothing can be left out, the program stays.
    Raises `ValueError` for a symbol without an interval, an output without a tolerance, results that are not finite.
    """
    task = Task(program, box, tolerances, names or Names(), positions, seed)
    if changing is not None:
        task.only_at(changing)
    return _reduction(task, states, confident, bound)


def without_parameters(
    program: Program,
    box: Box,
    tolerances: Tolerances,
    values: Mapping[str, float],
    *,
    inertia: Program | None = None,
    names: Names | None = None,
    positions: Collection[str] = ("q",),
    seed: int = 0,
    states: int = UNSEEN,
    confident: bool = True,
    bound: ErrorBound | None = None,
) -> Reduction:
    """Return the program with as many parameters set to zero as the tolerances allow, as `reduce_program` does.

    `values` are those of the parameters, which are symbols of the program: base inertial parameters, none of them zero.
    `inertia` is the program of the inertia matrix, with the same symbols: it stays positive definite. Whatever
    parameters are zero, models that have them keep all their structure. `left_out` names these parameters; the reduced
    program holds the symbols of the others.
    """
    box = {**box, **{name: Point(value) for name, value in values.items()}}
    has_inertia = HasInertia(inertia, box, seed) if inertia else None
    task = Task(program, box, tolerances, names or Names(), positions, seed)
    task.only_zeros_of(values, has_inertia)
    return _reduction(task, states, confident, bound)


def _reduction(task: Task, states: int, confident: bool, bound: ErrorBound | None) -> Reduction:
    """Search, look for states where errors are too large, judge; again until a tolerance is nowhere exceeded."""
    sample, limits, unproven = task.first_sample(), np.ones(len(task.allowed)), 0
    for number in range(MOST_SEARCHES if task.candidates and len(limits) else 0):
        trial = task.searched(sample, limits, number)
        if not trial.taken:
            break
        worst = trial.too_large()
        if bound and not worst:
            trial.apply(bound)
            unproven += not np.isfinite(trial.judged()).all()
        if not worst and (trial.judged() <= 1).all():
            worst = trial.too_large_unseen(states, confident)
        if worst:
            sample = joined([sample, *worst.states])
            limits = _lowered(limits, trial.sampled, worst.errors) if number >= WITH_STATES else limits
            continue
        errors = trial.judged()
        if (errors <= 1).all():
            return trial.reduction(states)
        if unproven >= MOST_UNPROVEN:
            break
        limits = _lowered(limits, trial.sampled, errors)
    return task.unchanged().reduction(states)


def _lowered(limits: Array, sampled: Array, errors: Array) -> Array:
    """Lower the limits of results with errors above 1 to less than what the search has reached at its sample.

    Errors are of the tolerances; where one is NaN, its limit is lowered by a factor.
    """
    factor = np.maximum(SLACK / np.maximum(np.nan_to_num(errors, nan=np.inf), SLACK), LEAST_FACTOR)
    reached = np.where(sampled > 0, np.minimum(limits, sampled), limits)
    return np.where(errors <= 1, limits, reached * factor)
