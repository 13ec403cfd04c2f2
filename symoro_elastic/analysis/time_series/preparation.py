"""Preparation of logs: cut to a time span, resampled evenly, motor currents converted to torques."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.analysis.time_series.clocks import part_of, tidy, with_change
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.resolution import resolution_of
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import MOST_IN_FILES, MOST_SAMPLES, NOT_FINITE, InputError, refuse_numbers
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import no_such

LONGEST_GAP = 10.0  # of the usual step, that is interpolated where samples are made anew
FEW_STEPS = 10.0  # of an encoder, crossed from one sample to the next
FASTER = 1.01  # than measured


@dataclass(frozen=True)
class Preparation:
    """Options to prepare a record: first and last time (s), sampling frequency (Hz), torque per unit by motor."""

    first: float | None = None
    last: float | None = None
    rate: float | None = None
    gains: Mapping[str, float] = field(default_factory=dict)

    def refuse(self, machine: Machine) -> None:
        """Raise `InputError` for options that are invalid whatever the record."""
        for name, gain in self.gains.items():
            motors = [joint.name for joint in machine.motor_joints]
            if name not in motors:
                raise InputError("symoro-elastic", "--gain", no_such("motor", name, motors))
            if not math.isfinite(gain) or gain == 0:
                what = f"{name}={gain:g}: give the torque per unit of the column, not zero"
                raise InputError("symoro-elastic", "--gain", what)
        for option, x in (("--after", self.first), ("--before", self.last), ("--resample", self.rate)):
            if x is not None and not math.isfinite(x):
                raise InputError("symoro-elastic", option, f"{x} {NOT_FINITE}")
        if self.rate is not None and self.rate <= 0:
            raise InputError("symoro-elastic", "--resample", "give a positive frequency, Hz")
        if self.first is not None and self.last is not None and self.first >= self.last:
            what = f"{self.last:g} s is not later than --after {self.first:g} s"
            raise InputError("symoro-elastic", "--before", what)

    def __call__(self, record: Measurements, machine: Machine) -> Measurements:
        """Return the prepared record. Raises `InputError`."""
        gains = [self.gains.get(joint.name, 1.0) for joint in machine.motor_joints]
        cut = self._cut(replace(record, tau=record.tau * np.array(gains)))
        return self._sample_evenly(tidy(cut, machine), machine)

    def _cut(self, record: Measurements) -> Measurements:
        t = record.t
        low, high = -math.inf if self.first is None else self.first, math.inf if self.last is None else self.last
        if low == -math.inf and high == math.inf:
            return record
        inside = (t >= low) & (t <= high)
        if not inside.any():
            what = f"the record has {t.min():g} to {t.max():g} s: --after and --before leave nothing of it"
            raise InputError(record.source, "t", what)
        return part_of(record, inside)

    def _sample_evenly(self, record: Measurements, machine: Machine) -> Measurements:
        if self.rate is None or len(record.t) < 2:
            return record
        steps = np.diff(record.t)
        usual = float(np.median(steps)) if len(steps) else 0.0
        duration = float(record.t[-1]) - float(record.t[0])
        if duration * self.rate > MOST_SAMPLES:
            what = f"{self.rate:g} Hz makes {duration * self.rate:.2g} samples, {MOST_SAMPLES:.0e} is the limit"
            raise InputError("symoro-elastic", "--resample", what)
        columns = 1 + sum(x.shape[1] for x in (record.q, record.tau, record.qd, record.qdd) if x is not None)
        what = f"{columns} columns at {self.rate:g} Hz"
        numbers = int(columns * duration * self.rate)
        refuse_numbers(numbers, what, "symoro-elastic", "--resample", "use a lower frequency", MOST_IN_FILES)
        wide = 1 / self.rate if usual * self.rate < 1 else 0.0
        count = int(max(duration - wide, 0.0) * self.rate * (1 + 1e-12) + 1e-9) + 1
        t = float(record.t[0]) + wide / 2 + np.arange(count) / self.rate
        t = t[~_in_gaps(record.t, t, LONGEST_GAP * usual, wide)]
        done = with_change(record, t, lambda x: _resample(record.t, x, t, wide))
        warnings = [*record.warnings]
        if usual * self.rate > FASTER:
            what = f"--resample {self.rate:g} is faster than the {1 / usual:.4g} Hz of the record"
            warnings.append(f"{what}: noise is then no longer white, and standard deviations are too small")
        return replace(done, warnings=(*warnings, *_coarse(record, machine)))


def _coarse(record: Measurements, machine: Machine) -> list[str]:
    """Return a warning if an encoder resolution is coarse compared with the motion per sample."""
    steps = [resolution_of(q) for q in record.q.T]
    crossed = np.sqrt(np.mean(np.diff(record.q, axis=0) ** 2, axis=0))
    joints = machine.independent_joints
    few = [joint.name for joint, s, x in zip(joints, steps, crossed, strict=True) if 0 < x < FEW_STEPS * s]
    if not few:
        return []
    what = f"positions of {', '.join(few)} are whole steps of an encoder, and resampled they are so no longer"
    so = "their noise is taken for white, so standard deviations may be too small; --bandwidth may be needed"
    return [f"{what}: {so}"]


def _in_gaps(old: Array, new: Array, longest: float, wide: float) -> BoolArray:
    """Return a mask of new times, or of averaging windows of `wide` s, in gaps too long for interpolation."""
    inside, margin = np.zeros(len(new), dtype=bool), 1e-6 * longest
    for k in np.flatnonzero(np.diff(old) > longest):
        inside |= (new + wide / 2 > old[k] + margin) & (new - wide / 2 < old[k + 1] - margin)
    return inside


def _resample(old: Array, x: Array, new: Array, wide: float) -> Array:
    """Return x (N, k) at new times by linear interpolation, or its means over windows of `wide` s."""
    if not wide:
        columns = [np.interp(new, old, column) for column in x.T]
        return np.array(columns).T.reshape(len(new), x.shape[1])
    means = np.zeros((len(new), x.shape[1]))
    for k, column in enumerate(x.T):
        steps = np.diff(old) * (column[1:] + column[:-1]) / 2
        area = np.concatenate([[0.0], np.cumsum(steps)])
        means[:, k] = (_area(old, column, area, new + wide / 2) - _area(old, column, area, new - wide / 2)) / wide
    return means


def _area(t: Array, x: Array, area: Array, at: Array) -> Array:
    """Return the integral of the linear interpolant, from the first sample to each time."""
    k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    part = at - t[k]
    slope = (x[k + 1] - x[k]) / (t[k + 1] - t[k])
    return np.asarray(area[k] + part * x[k] + part**2 / 2 * slope)
