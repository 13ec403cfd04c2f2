"""The linear model at times so close that it tells the vibrations of a motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.errors import InputError
from symoro_elastic.ladder.path import SAMPLES, LinearPath, linear_path
from symoro_elastic.ladder.spring_errors import Deviations
from symoro_elastic.simulation.reference import Reference

AGREED = 0.1
"""Difference to every second sample, of the largest deviation or of a tolerance: sixteen times that of the samples."""
MOST_SAMPLES = 16 * SAMPLES


def resolved_path(reference: Reference, tolerance: Mapping[str, float]) -> LinearPath:
    """Return the linear model along a motion, with rows for the outputs that have a tolerance.

    Its samples are doubled until every second one tells the same. Raises `InputError` for motions that are too long.
    """
    samples = SAMPLES
    while samples <= MOST_SAMPLES:
        path = linear_path(reference, tuple(tolerance), samples)
        if is_resolved(path, tolerance):
            return path
        samples *= 2
    what = f"{reference.duration:g} s are too long for the vibrations in it: shorten it, or lock the fastest springs"
    raise InputError(reference.machine.label, f"{reference.prescribed.place}, duration", what)


def is_resolved(path: LinearPath, tolerance: Mapping[str, float]) -> bool:
    """Whether every second sample gives the same outputs."""
    found, half = Deviations(path).outputs, Deviations(path.thinned).outputs
    apart = np.abs(found[::2] - half).max(axis=0)
    allowed = [tolerance.get(name, 0.0) for name in path.outputs.names]
    return bool((apart <= AGREED * np.maximum(np.abs(found).max(axis=0), allowed)).all())
