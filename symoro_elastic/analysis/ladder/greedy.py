"""The order in which springs and parts of drives are left out: one more at each rung, the one that costs least."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, Errors, relative, spring_errors
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress

ALL_TRIED = 10
"""Springs up to which every remaining one is tried at every rung."""
BEST_TRIED = 6
"""Of more springs, those tried that cost least when they were tried last."""


@dataclass(frozen=True)
class SpringFigures:
    """What is usually asked of a spring, none of which says whether it matters.

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
    rungs, costs = [spring_errors(deviations, [()])[0]], dict.fromkeys(candidates, 0.0)
    left_out: tuple[int, ...] = ()
    while len(left_out) < len(candidates):
        tried = _tried([k for k in candidates if k not in left_out], costs, first=not left_out)
        found = spring_errors(deviations, [(*left_out, k) for k in tried])
        costs |= {k: relative(errors.static, tolerance) for k, errors in zip(tried, found, strict=True)}
        least = min(range(len(tried)), key=lambda row: costs[tried[row]])
        left_out = (*left_out, tried[least])
        rungs.append(found[least])
        progress(len(left_out), len(candidates))
    return tuple(rungs)


def _tried(remaining: list[int], costs: Mapping[int, float], *, first: bool) -> list[int]:
    """Return the springs to try: all at first, and where there are few."""
    if first or len(costs) <= ALL_TRIED:
        return remaining
    return sorted(remaining, key=lambda k: costs[k])[:BEST_TRIED]


def spring_figures(paths: Sequence[LinearPath], tolerance: Mapping[str, float]) -> tuple[SpringFigures, ...]:
    """Return what each spring costs alone, its activity and its frequency: largest over the motions."""
    deviations, springs = [Deviations(path) for path in paths], paths[0].springs
    if not springs:
        return ()
    alone = [relative(errors.static, tolerance) for errors in spring_errors(deviations, [(k,) for k in springs])]
    activity = np.max([_activity(each) for each in deviations], axis=0)
    frequency = np.max([_frequency(path) for path in paths], axis=0)
    names = paths[0].names(springs)
    return tuple(
        SpringFigures(name, cost, float(activity[k]), float(frequency[k]))
        for name, cost, k in zip(names, alone, springs, strict=True)
    )


def _activity(deviations: Deviations) -> Array:
    """Return int |k d d'| dt (n,) over the motion."""
    path, motion = deviations.path, deviations.whole
    power = np.abs(path.stiffness * motion.d[:, 0] * motion.dd[:, 0])
    activity: Array = path.h * (power.sum(axis=0) - (power[0] + power[-1]) / 2)
    return activity


def _frequency(path: LinearPath) -> Array:
    """Return sqrt(k / M_jj) (n,) at the start, Hz."""
    frequency: Array = np.sqrt(path.stiffness / np.diagonal(path.M[0])) / (2 * np.pi)
    return frequency
