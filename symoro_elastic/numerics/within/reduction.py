"""The program with the fewest operations that stays within tolerances over a box of arguments.

    1. Draw states; find how large each result is, and from that its tolerance.
    2. Search the changes that save most, within the limits at these states.
    3. Climb to the worst states of what was found, and look at more random ones. Where a tolerance is exceeded, these
       states join the sample, and the search starts again, from as much of what was found as still is within limits.
    4. Judge it: by the largest error at a million states that no search has seen, by the bound on those at a million
       more, and, where one is given, by a bound on all states of the box. Where this exceeds a tolerance, the limit of
       that result is lowered by as much, and the search starts again.

The guarantee is that of the judges: "95 % confidence at 1e6 states" drawn as `box.drawn` says, or with `bound` what
it proves. States at rest are in the sample with limits of nearly zero for results that are zero there: these stay zero.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.numerics.within.frequencies import NaturalFrequencies
from symoro_elastic.numerics.within.inertia import HasInertia
from symoro_elastic.numerics.within.results import NOTHING, ErrorBound, Reduction, Reserved, Tolerances
from symoro_elastic.numerics.within.search import NOTHING_TAKEN
from symoro_elastic.numerics.within.states import Box, Point, joined
from symoro_elastic.numerics.within.trials import UNSEEN, Task, Trial, Worst
from symoro_elastic.symbolic.program import Names, Program

MOST_SEARCHES, WITH_STATES = 20, 5
"""After so many searches limits are lowered, too, where errors at other states are too large."""
MOST_UNPROVEN, FAR = 3, 10.0
"""Searches with a bound so many times above a tolerance, each with less left out: then the program stays whole."""
SLACK, LEAST_FACTOR, LEAST_OF_FAR = 0.98, 0.4, 0.03
"""What a limit is lowered to, of what would do if errors were proportional to it; at least by this factor."""
MOST_IMPROVED, LEFT_OVER = 2, 0.9
"""Further searches with higher limits, where all errors together leave more than a tenth of each tolerance."""


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
    frequencies: NaturalFrequencies | None = None,
    reserved: Reserved = NOTHING,
    watched: Announce = announce_nothing,
    most_unproven: int = MOST_UNPROVEN,
) -> Reduction:
    """Return the program with the fewest operations found whose errors are within the tolerances over the box.

    `program` depends on symbols of the box only: parameters are numbers. `positions` name the arguments that hold
    positions, `names` are the quantities that keep their names. With `confident` the bound on errors at `states` more
    states is within the tolerances too, with `bound` that bound. `frequencies` have a tolerance of their own; what is
    `reserved` for rounding is not used. Only nodes with numbers in `changing` change, if given. Where nothing can be
    left out, the program stays, as after `most_unproven` searches that are far from a proof. `watched` is called with
    the name of each stage. Ctrl-C ends the search with the best program so far. Raises `ValueError` for a symbol
    without an interval, an output without a tolerance, results that are not finite; `KeyboardInterrupt` where a search
    is ended with nothing found.
    """
    task = Task(program, box, tolerances, names or Names(), positions, seed, reserved)
    if changing is not None:
        task.only_at(changing)
    if frequencies:
        task.keep_frequencies(frequencies)
    return _reduction(task, Judges(states, confident, bound, watched, most_unproven))


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
    frequencies: NaturalFrequencies | None = None,
    reserved: Reserved = NOTHING,
    watched: Announce = announce_nothing,
) -> Reduction:
    """Return the program with as many parameters set to zero as the tolerances allow, as `reduce_program` does.

    `values` are those of the parameters, which are symbols of the program: base inertial parameters, none of them zero.
    `inertia` is the program of the inertia matrix, with the same symbols: it stays positive definite. Whatever
    parameters are zero, models that have them keep all their structure. `left_out` names these parameters; the reduced
    program holds the symbols of the others.
    """
    box = {**box, **{name: Point(value) for name, value in values.items()}}
    has_inertia = HasInertia(inertia, box, seed) if inertia else None
    task = Task(program, box, tolerances, names or Names(), positions, seed, reserved)
    task.only_zeros_of(values, has_inertia)
    if frequencies:
        task.keep_frequencies(frequencies)
    return _reduction(task, Judges(states, confident, bound, watched, MOST_UNPROVEN))


def _reduction(task: Task, judges: Judges) -> Reduction:
    """Search, look for states where errors are too large, judge; again until a tolerance is nowhere exceeded.

    What is found then is improved by higher limits. Where the user ends the search, the best one that was judged is
    returned; raises `KeyboardInterrupt` where there is none.
    """
    best = Best()
    try:
        _search(task, judges, best)
    except KeyboardInterrupt:
        if best.trial is None:
            raise
        return replace(best.trial.reduction(judges.states), ended=True)
    found = best.trial or task.unchanged()
    return replace(found.reduction(judges.states), unproven="" if best.trial else best.unproven)


def _search(task: Task, judges: Judges, best: Best) -> None:
    """Note the best trial."""
    sample, limits, far, improved = task.first_sample(), np.ones(len(task.allowed)), 0, 0
    former = NOTHING_TAKEN
    for number in range(MOST_SEARCHES if task.candidates and len(limits) else 0):
        judges.watched(f"leave out, search {number + 1}")
        trial = task.searched(sample, limits, number, former)
        former = trial.found
        if not trial.taken:
            return
        worst = judges.worst_of(trial)
        if worst:
            sample = joined([sample, *worst.states])
            limits = _lowered(limits, trial.sampled, worst.errors) if number >= WITH_STATES else limits
            continue
        errors = trial.judged()
        if (errors <= 1).all() and not trial.keeps_frequencies():
            if best.trial:
                return
            continue
        if (errors <= 1).all():
            best.note(trial)
            improved += 1
            raised = _raised(limits, errors)
            if improved > MOST_IMPROVED or not (trial.raises_frequencies() or (raised > limits).any()):
                return
            limits = raised
            continue
        best.unproven = task.farthest(errors)
        far += not (errors <= FAR).all()
        if best.trial or far >= judges.most_unproven:
            return
        limits = _lowered(limits, trial.sampled, errors)


@dataclass
class Best:
    """The best trial so far that all judges accept, and why there is none."""

    trial: Trial | None = None
    unproven: str = ""

    def note(self, trial: Trial) -> None:
        """Keep a trial that saves more than the one before."""
        if self.trial is None or trial.cost < self.trial.cost:
            self.trial = trial


@dataclass(frozen=True)
class Judges:
    """What a trial has to stand: errors at so many unseen `states`, a bound on more of them, a bound on all states."""

    states: int
    confident: bool
    bound: ErrorBound | None
    watched: Announce
    most_unproven: int

    def worst_of(self, trial: Trial) -> Worst | None:
        """Find errors of a trial; return states at which they are too large."""
        worst = trial.too_large()
        if worst:
            return worst
        if self.bound:
            self.watched("prove")
            trial.apply(self.bound)
        if (trial.judged() <= 1).all():
            self.watched("look at unseen states")
            return trial.too_large_unseen(self.states, self.confident)
        return None


def _raised(limits: Array, errors: Array) -> Array:
    """Raise the limits of results whose errors leave a part of their tolerances."""
    factor = np.where((errors > 0) & (errors < LEFT_OVER), SLACK / np.maximum(errors, SLACK / 2), 1.0)
    return np.minimum(limits * factor, 1.0)


def _lowered(limits: Array, sampled: Array, errors: Array) -> Array:
    """Lower the limits of results with errors above 1 to less than what the search has reached at its sample.

    Errors are of the tolerances; where one is NaN, its limit is lowered by a factor.
    """
    least = np.where(errors <= FAR, LEAST_FACTOR, LEAST_OF_FAR)
    factor = np.maximum(SLACK / np.maximum(np.nan_to_num(errors, nan=np.inf), SLACK), least)
    reached = np.where(sampled > 0, np.minimum(limits, sampled), limits)
    return np.where(errors <= 1, limits, reached * factor)
