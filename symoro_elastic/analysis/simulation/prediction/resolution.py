"""The linear model at times close enough to resolve a motion, and the vibrations in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from symoro_elastic.analysis.simulation.periods import rounded_down
from symoro_elastic.analysis.simulation.prediction.path import SAMPLES, LinearPath, linear_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array

IN_DETAIL = 20
"""Samples in the shortest move, rise of a force or period of a wobble."""
OF_TOLERANCE, OF_DEVIATION = 0.1, 5e-3
"""Difference to every second sample that is allowed, the larger counts: it is sixteen times that of the samples."""
WINDOWS = 20
"""Parts of a motion whose largest deviations are compared: how late a long vibration is does not count."""
MOST_SAMPLES = 16 * SAMPLES
SLOW = 1e-6
"""Typical time of a step, s, to estimate that of many."""
MOST_IN_DETAIL = 5_000_000
"""Most steps that resolve all parts of a motion: they are halved, and refined, to measure errors."""


def resolved_path(reference: Reference, tolerance: Mapping[str, float]) -> LinearPath:
    """Return the linear model along a motion, with rows for the outputs that have a tolerance.

    Raises `InputError` for motions that are too long.
    """
    path = path_if_resolved(reference, tolerance)
    if path is None:
        what = f"{reference.duration:g} s are too long for the short moves or vibrations in it: shorten it"
        raise reference.prescribed.error("duration", what)
    return path


def path_if_resolved(reference: Reference, tolerance: Mapping[str, float]) -> LinearPath | None:
    """Return the linear model along a motion; None for motions that are too long.

    Its samples are doubled until every second sample gives the same outputs.
    """
    samples = max(SAMPLES, in_detail(reference))
    while samples <= MOST_SAMPLES:
        path = linear_path(reference, tuple(tolerance), samples)
        if is_resolved(path, tolerance):
            return path
        samples *= 2
    return None


def in_detail(reference: Reference) -> int:
    """Return an even number of samples that resolves the shortest part of a motion."""
    shortest = min(_times(reference), default=reference.duration)
    return 2 * int(np.ceil(IN_DETAIL / 2 * reference.duration / shortest))


def refuse_unresolved(reference: Reference) -> None:
    """Raise `InputError` for motions whose shortest part requires more steps than the limit."""
    steps = in_detail(reference)
    if steps > MOST_IN_DETAIL:
        what = f"its shortest move, rise of a force or period of an oscillation lasts {min(_times(reference)):.3g} s: "
        what = f"{what}{steps:.3g} steps, some {steps * SLOW / 3600:.2g} h, {MOST_IN_DETAIL:.0e} is the limit; "
        most = rounded_down(reference.duration * MOST_IN_DETAIL / steps)
        what += f"give at most {most} s, or leave that part out"
        raise reference.prescribed.error("duration", what)


def _times(reference: Reference) -> Iterator[float]:
    """Durations of the parts of a motion, s: moves, rises of forces, periods, and samples of a record."""
    yield from (move.lasts for move in reference.prescribed.moves)
    yield from (force.lasts for force in reference.prescribed.forces)
    yield from (1 / wobble.frequency for wobble in reference.prescribed.wobbles)
    if reference.record is not None:
        yield IN_DETAIL * float(np.median(np.diff(reference.record.t)))


def is_resolved(path: LinearPath, tolerance: Mapping[str, float]) -> bool:
    """Whether every second sample gives the same outputs."""
    full, half = (_largest(Deviations(x).outputs) for x in (path, path.every_second))
    apart = np.abs(full - half).max(axis=0)
    allowed = OF_TOLERANCE * np.array([tolerance.get(name, 0.0) for name in path.outputs.names])
    return bool((apart <= np.maximum(OF_DEVIATION * full.max(axis=0), allowed)).all())


def _largest(outputs: Array) -> Array:
    """Return the largest absolute values (WINDOWS, outputs) in consecutive windows of a motion."""
    ends = np.linspace(0, len(outputs) - 1, WINDOWS + 1).astype(int)
    return np.array([np.abs(outputs[first : last + 1]).max(axis=0) for first, last in pairwise(ends)])
