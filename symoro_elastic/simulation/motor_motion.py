"""Motions of a motor in closed form: each is y, y', y'', y''' as an array (4, N) at times (N,)."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.polynomial import Polynomial

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.packages import for_vibrations
from symoro_elastic.time_series.preparation import LONGEST_GAP
from symoro_elastic.time_series.reading import place_of_sample
from symoro_elastic.vibration.course import COEFFICIENTS, SPLINE_DEGREE
from symoro_elastic.vibration.reference_trajectory import ReferenceTrajectory, read_samples

RISE = Polynomial([0.0] * 4 + list(COEFFICIENTS))
RATES = (RISE, RISE.deriv(), RISE.deriv(2), RISE.deriv(3))
Curve = Callable[[Array], Array]
REACHED = 1e-9
"""Of a duration: how far a record may end before it."""
EVEN, MISSING = 0.9, 1.5
"""Share of the steps of a record on an even clock that are the usual one, and a step in which a sample is missing."""


def risen(t: Array, begins: float, lasts: float) -> Array:
    """Return the rise from 0 to 1, 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7 with x = (t - begins) / lasts, constant beyond."""
    x = np.clip((t - begins) / lasts, 0.0, 1.0)
    return np.array([rate(x) / lasts**k for k, rate in enumerate(RATES)])


def wobble(t: Array, amplitude: float, frequency: float, duration: float) -> Array:
    """Return amplitude sin(2 pi frequency t), faded in over the first period and out over the last of the duration."""
    omega, period = 2 * np.pi * frequency, 1 / frequency
    sine, cosine = np.sin(omega * t), np.cos(omega * t)
    swing = amplitude * np.array([sine, omega * cosine, -(omega**2) * sine, -(omega**3) * cosine])
    falling = risen(duration - t, 0.0, period) * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    return _product(_product(risen(t, 0.0, period), falling), swing)


def _product(f: Array, g: Array) -> Array:
    """Return f g and its derivatives."""
    return np.array([sum(math.comb(n, k) * f[n - k] * g[k] for k in range(n + 1)) for n in range(len(f))])


class Record:
    """The motion of all motors in a file: polynomials of degree 5 between its samples.

    They have its velocities and accelerations where the file gives both, else they are a spline through its positions.
    """

    def __init__(self, path: Path, machine: Machine, duration: float) -> None:
        """Raises `InputError` for a file that is no motion of all motors, and does not last as long."""
        samples = read_samples(path, machine)
        self.t = samples.t
        _refuse_parts(samples, duration)
        self.curves = {name: _curves(samples, name) for name in samples.y}

    def __call__(self, motor: str, t: Array) -> Array:
        """Return the motion of a motor; beyond the record it stays where it was."""
        inside = np.clip(t, self.t[0], self.t[-1])
        return np.array([curve(inside) for curve in self.curves[motor]])


def _refuse_parts(samples: ReferenceTrajectory, duration: float) -> None:
    """Raise `InputError` for a record with a gap, or that does not reach from 0 to the end of the motion."""
    t, source = samples.t, samples.source
    if len(t) <= SPLINE_DEGREE:
        raise InputError(source, "t", f"{len(t)} samples are too few for a motion: give {SPLINE_DEGREE + 1} or more")
    if t[0] > REACHED * duration or t[-1] < duration * (1 - REACHED):
        what = f"it has {t[0]:g} to {t[-1]:g} s, the motion 0 to {duration:g} s: record all of it, or change duration"
        raise InputError(source, "t", what)
    steps = np.diff(t)
    usual = float(np.median(steps))
    is_even = np.mean(np.abs(steps - usual) < (MISSING - 1) * usual) >= EVEN
    gaps = steps > (MISSING if is_even else LONGEST_GAP) * usual
    if gaps.any():
        k = int(np.argmax(gaps))
        what = f"gap of {steps[k]:g} s after {t[k]:g} s, {place_of_sample(source, k)}: give samples there"
        raise InputError(source, "t", what)


def _curves(samples: ReferenceTrajectory, motor: str) -> list[Curve]:
    """Return piecewise polynomials y, y', y'', y''' through the samples of a motor. Raises `InputError`."""
    if motor in samples.doubts and samples.order(motor) < 2:
        what = f"{samples.doubts[motor][1]}; give positions alone, and a spline goes through them"
        raise InputError(samples.source, f"{samples.columns}_{motor}", what)
    interpolate = for_vibrations("scipy.interpolate")
    if samples.order(motor) < 2:
        y = interpolate.make_interp_spline(samples.t, samples.y[motor][0], k=SPLINE_DEGREE)
    else:
        y = interpolate.BPoly(_between(samples.t, samples.y[motor]), samples.t)
    return [y, *(y.derivative(order) for order in (1, 2, 3))]


def _between(t: Array, rows: Array) -> Array:
    """Return the Bernstein coefficients (6, N - 1) of the polynomials with y, y', y'' of `rows` at both ends."""
    h, (y, yd, ydd) = np.diff(t), rows[:3]
    first = (y[:-1], y[:-1] + h * yd[:-1] / 5, y[:-1] + 2 * h * yd[:-1] / 5 + h**2 * ydd[:-1] / 20)
    last = (y[1:] - 2 * h * yd[1:] / 5 + h**2 * ydd[1:] / 20, y[1:] - h * yd[1:] / 5, y[1:])
    return np.array([*first, *last])
