"""Reference trajectories beyond the springs, with time derivatives: from files, splines, moves from rest to rest.

The coordinate y of a motor is its own plus those of the springs behind it. A motion gives k derivatives where the
first that jumps is the k-th: the next one would be infinite. A spline of degree k gives k.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series.measurements import missing, named_columns, read_columns
from symoro_elastic.analysis.time_series.reading import place_of_sample
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import MOST_SAMPLES, InputError, refuse_numbers
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import no_such
from symoro_elastic.numerics.motion.equations_of_motion import LARGEST_INPUT
from symoro_elastic.quantities import HIGHEST_DERIVATIVE

RATE = 1000.0  # samples/s
STROKE = 0.1  # rad or m
JUMP = 1e-6  # of the largest value of a derivative
DOUBTFUL_CHANGE = 0.1  # of a derivative
ROUNDED = 1e-5  # of the largest value, in a file with few digits


Doubt = tuple[int, str]


@dataclass(frozen=True)
class ReferenceTrajectory:
    """t (N,) s; by motor y and its derivatives, (orders + 1, N), rad or m; their source.

    `columns` is the letter of its columns in a file, empty for splines; `doubts` gives by motor the first
    doubtful derivative, and why.
    """

    t: Array
    y: Mapping[str, Array]
    source: str
    columns: str = ""
    doubts: Mapping[str, Doubt] = field(default_factory=dict)

    def order(self, motor: str) -> int:
        """Return the number of derivatives of a motor."""
        return len(self.y[motor]) - 1


def read_reference(
    path: str | Path, machine: Machine, degree: int | None = None, usual: int = 5, rate: float | None = None
) -> ReferenceTrajectory:
    """Read columns t, y_<motor>, yd_<motor>, ydd_<motor> ... of a .csv or .npz file, or q_, qd_ ... as `excite` writes.

    Splines of a degree go through the positions where it is given, and where there are positions only (`usual`);
    they are sampled at `rate` Hz. Raises `InputError`.
    """
    samples = read_samples(path, machine)
    has_positions_only = not samples.doubts and all(len(rows) == 1 for rows in samples.y.values())
    if degree is not None or has_positions_only:
        positions = {name: rows[0] for name, rows in samples.y.items()}
        return through(samples.t, positions, usual if degree is None else degree, rate, samples.source)
    if rate is not None:
        what = "its derivatives are already sampled: leave out --sample-rate, or give --degree"
        raise InputError(samples.source, "--sample-rate", what)
    return samples


def read_samples(path: str | Path, machine: Machine) -> ReferenceTrajectory:
    """Read the samples of a file unchanged, with those of its derivatives that are consistent.

    Raises `InputError`.
    """
    source = str(path)
    columns = read_columns(path, machine)
    named, _ = named_columns(columns, machine, source)
    if ("t", "") not in named:
        raise missing(["t"], columns, source, "give the time of each sample, s")
    t, letters = _time(named["t", ""], source), {quantity[0] for quantity, _ in named}
    letter = "q" if "q" in letters and "y" not in letters else "y"
    y = _by_motor(named, letter, machine, columns, source)
    jumps = {name: _first_jump(t, rows) for name, rows in y.items()}
    finite = {name: rows[: jumps[name][0] + 1] for name, rows in y.items()}
    doubts = {name: (k + 1, why) for name, (k, why) in jumps.items() if why}
    return ReferenceTrajectory(t, finite, source, letter, doubts)


def through(
    t: Array, positions: Mapping[str, Array], degree: int, rate: float | None = None, source: str = "motion"
) -> ReferenceTrajectory:
    """Return interpolating splines through positions by motor, sampled at `rate` Hz. Raises `InputError`."""
    _refuse_degree(degree, source)
    if len(t) <= degree:
        what = f"{len(t)} points are too few for a spline of degree {degree}: give {degree + 1} or more"
        raise InputError(source, "t", what)
    make = for_vibrations("scipy.interpolate").make_interp_spline
    curves = {name: make(t, y, k=degree) for name, y in positions.items()}
    trajectory = along(curves, times(t[0], t[-1], rate), source)
    if len(t) <= 2 * degree:
        return trajectory
    coarse = along({name: make(t[::2], y[::2], k=degree) for name, y in positions.items()}, trajectory.t)
    return replace(trajectory, doubts=dict(_doubts(trajectory, coarse)))


def _doubts(fine: ReferenceTrajectory, coarse: ReferenceTrajectory) -> Iterator[tuple[str, Doubt]]:
    """Yield, by motor, the first derivative that changes if half of the points are used, away from the ends."""
    inside = slice(len(fine.t) // 10, -(len(fine.t) // 10) or None)
    for name, rows in fine.y.items():
        change, size = (np.abs(x[:-1, inside]).max(axis=1) for x in (rows - coarse.y[name], rows))
        if (change > DOUBTFUL_CHANGE * size).any():
            k = int(np.argmax(change > DOUBTFUL_CHANGE * size))
            what = f"derivative {k} of its spline changes by {change[k] / size[k]:.0%} with half the points"
            yield name, (k, f"{what}: they are too few, or too many for their digits")


def move(
    machine: Machine, start: Mapping[str, float], strokes: Mapping[str, float], duration: float, degree: int,
    rate: float | None = None,
) -> ReferenceTrajectory:  # fmt: skip
    """Return a move of all motors from rest to rest in `duration` s: velocity is a B-spline.

    Of degree 2 it has a triangle of velocity, of degree 3 limited jerk. Raises `InputError`.
    """
    source = f"{machine.label}, move"
    _refuse_degree(degree, source)
    if not 0 < duration < np.inf:
        raise InputError(source, "--duration", f"{duration:g} s is not a duration: give a positive number")
    names = [joint.name for joint in machine.motor_joints]
    first, far = (_of_motors(x, machine, place) for x, place in ((start, "--start"), (strokes, "--stroke")))
    knots = duration / degree * np.arange(-degree - 1, 2 * degree + 2)
    rising = np.repeat([0.0, 1.0], degree + 1)
    spline = for_vibrations("scipy.interpolate").BSpline
    curves = {name: spline(knots, first[name] + far[name] * rising, degree) for name in names}
    return along(curves, times(0.0, duration, rate, beyond=True), source)


def along(curves: Mapping[str, Any], t: Array, source: str = "motion") -> ReferenceTrajectory:
    """Return curves by motor at times (N,) s, each a `BSpline` or a piecewise polynomial (`PPoly`) of scipy.

    As many derivatives as the curve has before one jumps. Raises `InputError` for more than there is room for.
    """
    what = f"{len(t)} samples of {len(curves)} motors with {HIGHEST_DERIVATIVE} derivatives"
    numbers = len(t) * len(curves) * (HIGHEST_DERIVATIVE + 1)
    refuse_numbers(numbers, what, source, "--sample-rate", "give a lower rate, or a shorter motion")
    orders = {name: range(1, _smoothness(curve) + 1) for name, curve in curves.items()}
    y = {
        name: np.array([curve(t), *(curve.derivative(k)(t) for k in orders[name])], dtype=float)
        for name, curve in curves.items()
    }
    return ReferenceTrajectory(t, y, source)


def times(first: float, last: float, rate: float | None = None, beyond: bool = False) -> Array:
    """Return sample times from `first` to `last` s, or to the next one `beyond`, at `rate` Hz. Raises `InputError`."""
    rate = RATE if rate is None else rate
    count = (last - first) * rate
    if not 0 < rate < np.inf or count > MOST_SAMPLES:
        what = f"{rate:g} Hz for {last - first:g} s: give a positive rate, and at most {MOST_SAMPLES:.0g} samples"
        raise InputError("symoro-elastic", "--sample-rate", what)
    steps = np.ceil(count * (1 - 1e-12)) if beyond else np.floor(count * (1 + 1e-12))
    return np.asarray(first + np.arange(int(steps) + 1) / rate)


def _smoothness(curve: Any) -> int:
    """Return the order of the first derivative that jumps, up to the highest usable one."""
    if hasattr(curve, "t"):
        inside = curve.t[(curve.t > curve.t[curve.k]) & (curve.t < curve.t[-curve.k - 1])]
        most = int(np.unique(inside, return_counts=True)[1].max(initial=1)) if len(inside) else 1
        return min(int(curve.k) - most + 1, HIGHEST_DERIVATIVE)
    for k in range(HIGHEST_DERIVATIVE):
        slope = curve.derivative(k) if k else curve
        ends = np.diff(slope.x[:-1])
        before = np.array([np.polyval(c, h) for c, h in zip(slope.c[:, :-1].T, ends, strict=True)])
        after = slope.c[-1, 1:]
        if (np.abs(after - before) > JUMP * max(np.abs(before).max(initial=0), np.abs(after).max(initial=0))).any():
            return k
    return HIGHEST_DERIVATIVE


def _refuse_degree(degree: int, source: str) -> None:
    if not 1 <= degree <= HIGHEST_DERIVATIVE + 1:
        what = f"{degree} is not a degree of a spline here: give 1 to {HIGHEST_DERIVATIVE + 1}"
        raise InputError(source, "--degree", what)


def _of_motors(numbers: Mapping[str, float], machine: Machine, place: str) -> dict[str, float]:
    """Return numbers by motor; the entry "" applies to all other motors. Raises `InputError`."""
    by_name = machine.motors_by_name
    for name, x in numbers.items():
        if name and name not in by_name:
            raise InputError(machine.label, place, no_such("motor", name, by_name))
        if not abs(x) <= LARGEST_INPUT:
            raise machine.error(place, f"{x:g} is out of range: give a number up to {LARGEST_INPUT:g}")
    named = {by_name[name]: x for name, x in numbers.items() if name}
    return {joint.name: named.get(joint.name, numbers.get("", 0.0)) for joint in machine.motor_joints}


def _time(t: Array, source: str) -> Array:
    bad = ~np.isfinite(t) | ~(np.diff(t, prepend=-np.inf) > 0)
    if bad.any():
        k = int(np.argmax(bad))
        where = f"{place_of_sample(source, k)} ({t[k]:g} s)"
        raise InputError(source, "t", f"does not increase at {where}: drop repeated lines")
    return t


def _by_motor(
    named: Mapping[tuple[str, str], Array], letter: str, machine: Machine, columns: Iterable[str], source: str
) -> dict[str, Array]:
    """Return y and its derivatives without gap, by motor. Raises `InputError`."""
    motors = [joint.name for joint in machine.motor_joints]
    foreign = [f"{quantity}_{name}" for quantity, name in named if name and name not in motors]
    if foreign:
        what = "only motors and their springs have a trajectory, other joints do not"
        raise InputError(source, foreign[0], f"{what}: give y_<motor>, yd_<motor> ... alone")
    trajectories = {}
    for name in motors:
        orders = [k for k in range(HIGHEST_DERIVATIVE + 1) if (letter + "d" * k, name) in named]
        if orders != list(range(len(orders))) or not orders:
            lacking = next(k for k in range(HIGHEST_DERIVATIVE + 2) if k not in orders)
            raise missing([f"{letter}{'d' * lacking}_{name}"], columns, source, "give it in a column of this name")
        trajectories[name] = np.array([named[letter + "d" * k, name] for k in orders])
        finite = np.isfinite(trajectories[name]).all(axis=0)
        if not finite.all():
            where = place_of_sample(source, int(np.argmin(finite)))
            what = f"NaN or infinity in the motion or its derivatives, {where}"
            raise InputError(source, f"{letter}_{name}", what)
    return trajectories


def _first_jump(t: Array, rows: Array) -> tuple[int, str]:
    """Return the first derivative that is not the integral of the next one, and the reason; by default the last.

    The trapezoidal rule misses h y'' / 12 of a smooth derivative, and half a jump of the last one.
    """
    h = np.diff(t)
    for k, (below, slope) in enumerate(pairwise(rows)):
        changed, integrated = np.diff(below), h * (slope[1:] + slope[:-1]) / 2
        bent = np.abs(np.diff(slope, 2, prepend=slope[0], append=slope[-1]))
        off = np.abs(changed - integrated) - h * np.maximum(bent[1:], bent[:-1]) - ROUNDED * np.abs(below).max()
        if (off > 0).any():
            at = int(np.argmax(off))
            jump = f"derivative {k} changes by {changed[at]:.3g} at {t[at]:.4g} s, the integral of the next one by"
            return k, f"{jump} {integrated[at]:.3g}: it jumps, units differ, or samples are too far apart"
    return len(rows) - 1, ""
