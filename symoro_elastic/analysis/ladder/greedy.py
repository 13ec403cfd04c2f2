"""The order in which springs and parts of drives are omitted: rung by rung the spring that costs least."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, Errors, relative, spring_errors
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.within.budget import Item, spend

ALL_TRIED = 10
"""Springs up to which every remaining one is tried at every rung."""
BEST_TRIED = 6
"""Of more springs, those tried that cost least when they were tried last."""


@dataclass(frozen=True)
class SpringFigures:
    """Error if static alone, work and frequency of a spring; for information, not used for decisions.

    `alone`: error relative to the tolerance where only this spring is static. `activity`: work that passes through it,
    J. `frequency`: of the spring with all other joints held, Hz.
    """

    name: str
    alone: float
    activity: float
    frequency: float


def backward_greedy(
    paths: Sequence[LinearPath], tolerance: Mapping[str, float], progress: Progress = no_progress
) -> tuple[Errors, ...]:
    """Return the errors of every rung, from nothing left out to all springs and parts of drives.

    Errors are the largest over the motions. At each rung that goes which costs least where it follows statically,
    relative to the tolerances of outputs. Errors are not monotone: a later rung may be better than an earlier one.
    """
    deviations = [Deviations(path) for path in paths]
    candidates = paths[0].candidates
    costs, full = dict.fromkeys(candidates, 0.0), tuple[int, ...]()
    errors = {full: spring_errors(deviations, [full])[0]}

    def items(left_out: tuple[int, ...]) -> Iterator[Item[int]]:
        candidates_now = [k for k in candidates if k not in left_out]
        if left_out and len(costs) > ALL_TRIED:
            candidates_now = sorted(candidates_now, key=lambda k: costs[k])[:BEST_TRIED]
        sets = [(*left_out, k) for k in candidates_now]
        errors.update(zip(sets, spring_errors(deviations, sets) if sets else (), strict=True))
        costs.update({k: relative(errors[*left_out, k].static, tolerance) for k in candidates_now})
        yield from (Item(k, 1.0, costs[k]) for k in candidates_now)

    order = [full]
    for left_out in spend(full, items, lambda before, k: (*before, k)):
        order.append(left_out)
        progress(len(left_out), len(candidates))
    return tuple(errors[left_out] for left_out in order)


def spring_figures(paths: Sequence[LinearPath], tolerance: Mapping[str, float]) -> tuple[SpringFigures, ...]:
    """Return the errors of springs alone, their activities and frequencies: largest over the motions."""
    deviations, springs = [Deviations(path) for path in paths], paths[0].springs
    if not springs:
        return ()
    alone = [relative(errors.static, tolerance) for errors in spring_errors(deviations, [(k,) for k in springs])]
    activity = np.max([_activity(x) for x in deviations], axis=0)
    rates = [np.sqrt(path.stiffness / np.diagonal(path.M[0])) for path in paths]  # at the start
    frequency = np.max(rates, axis=0) / (2 * np.pi)
    names = paths[0].names(springs)
    return tuple(
        SpringFigures(name, cost, float(activity[k]), float(frequency[k]))
        for name, cost, k in zip(names, alone, springs, strict=True)
    )


def _activity(deviations: Deviations) -> Array:
    """Return int |k d d'| dt (n,) over the motion."""
    path, motion = deviations.path, deviations.whole
    power = np.abs(path.stiffness * motion.d[:, 0] * motion.dd[:, 0])
    return np.asarray(path.h * (power.sum(axis=0) - (power[0] + power[-1]) / 2))
