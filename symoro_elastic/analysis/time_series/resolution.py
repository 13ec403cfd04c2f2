"""Encoder resolution, detected from positions that are integer multiples of a step.

An encoder reads staircases. Where motion crosses steps more slowly than it is sampled, the error is a sawtooth of the
position: it is not white noise, and its spectrum is that of the staircase, not of the motion.
"""

from __future__ import annotations

import numpy as np

from symoro_elastic.foundation.array_types import Array

ROUNDING = 1e-12  # of positions: changes below are none
FEWEST_CHANGES = 20
WIDER = (2.5, 6.5, 20.5, 60.5, 200.5, np.inf)  # steps: changes up to here refine the step
OFF_STEPS = 0.1  # of a step, rms, that changes are off whole multiples; 0.29 without any step


def resolution_of(x: Array) -> float:
    """Return the step of which all changes of x (N) are integer multiples; zero if there is none.

    The step of values rounded to decimals is found, too, where it is several times their last digit.
    """
    changes = np.abs(np.diff(x))
    changes = changes[changes > ROUNDING * np.abs(x).max(initial=0.0)]
    if len(changes) < FEWEST_CHANGES:
        return 0.0
    step = float(changes.min())
    for reach in WIDER:
        near = changes[changes < reach * step]
        multiples = np.round(near / step)
        step = float(near @ multiples / (multiples @ multiples))
    off = changes / step - np.round(changes / step)
    return step if float(np.sqrt(np.mean(off**2))) < OFF_STEPS else 0.0


def staircase(x: Array, step: float, phase: float) -> Array:
    """Return the quantization error of an encoder step at positions x (N), offset by `phase` (0 to 1) of a step."""
    shifted = x / step + phase
    return np.asarray((np.round(shifted) - shifted) * step)


def density_of_staircase(x: Array, step: float) -> float:
    """Return the spectral density of the quantization error relative to white noise of variance 1, approximately.

    Its variance is step^2 / 12. Where motion crosses fewer steps than there are samples it is within a narrower band.
    """
    crossed = float(np.sqrt(np.mean(np.diff(x) ** 2))) / step
    return step**2 / 12 * max(1.0, 0.5 / crossed) if crossed else 0.0
