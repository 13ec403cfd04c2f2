"""Motions of motors: finite Fourier series within limits, and the same from rest to rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.limits import Range

SAMPLES_PER_PERIOD = 12  # of the fastest harmonic
FINER = 4  # samples where peaks are sought
BETWEEN = 1.0025  # samples miss 1 - cos(pi / 48) of a peak of the fastest harmonic
LONGEST_START = 8  # periods
ENDS = 1.0002  # samples of a start miss 1 - cos(pi / 192) of a peak
SMALLER = 0.98  # of a motion that is tried next where no start keeps the limits
MOST_SMALLER = 200  # trials


@dataclass(frozen=True)
class Limits:
    """Limits of each motor: lowest and highest position (rad or m), velocity and acceleration (per s, per s2).

    `torque` are ranges of torques, N m or N, None for motors without; empty where no motor has one.
    """

    low: Array
    high: Array
    velocity: Array
    acceleration: Array
    torque: tuple[Range | None, ...] = ()

    @classmethod
    def of(cls, low: Sequence[float], high: Sequence[float], velocity: Sequence[float],
           acceleration: Sequence[float]) -> Limits:  # fmt: skip
        """Return limits from sequences by motor; raises `InputError` for limits without room."""
        arrays = [np.atleast_1d(np.array(x, dtype=float)) for x in (low, high, velocity, acceleration)]
        if len({len(x) for x in arrays}) > 1:
            raise InputError(
                "limits", "motors", "give as many low, high, velocity and acceleration limits as there are motors"
            )
        for k, (a, b, v, d) in enumerate(zip(*arrays, strict=True)):
            if not (a < b and v > 0 and d > 0):
                what = f"no room: low {a:g}, high {b:g}, velocity {v:g}, acceleration {d:g}"
                raise InputError("limits", f"motor {k + 1}", what)
        return cls(arrays[0], arrays[1], arrays[2], arrays[3])


@dataclass(frozen=True)
class FourierMotion:
    """A periodic motion of motors: fundamental frequency (Hz), centre (m), a and b (m, harmonics), rad/s or m/s."""

    frequency: float
    centre: Array
    a: Array
    b: Array

    @property
    def period(self) -> float:
        """Period, s."""
        return 1 / self.frequency

    def at(self, t: float | Array) -> tuple[Array, Array, Array]:
        """Return q, qd, qdd (..., m) of the motors at times t (...)."""
        harmonics = np.arange(1, self.a.shape[1] + 1) * 2 * np.pi * self.frequency
        phase = np.multiply.outer(np.asarray(t, dtype=float), harmonics)
        sine, cosine = np.sin(phase), np.cos(phase)
        q = self.centre + sine @ (self.a / harmonics).T - cosine @ (self.b / harmonics).T
        qd = cosine @ self.a.T + sine @ self.b.T
        qdd = cosine @ (self.b * harmonics).T - sine @ (self.a * harmonics).T
        return q, qd, qdd

    def smaller(self, share: float) -> FourierMotion:
        """Return the motion made smaller about its centre."""
        return replace(self, a=self.a * share, b=self.b * share)

    def times(self, finer: int = 1) -> Array:
        """Return the times of a period at which limits are checked."""
        count = finer * SAMPLES_PER_PERIOD * self.a.shape[1]
        times: Array = np.arange(count) * self.period / count
        return times


@dataclass(frozen=True)
class Started:
    """A motion from rest to rest: its time starts and stops smoothly in `start` s each, between are `periods` of it.

    It stays on the path of the motion, and no sample is faster.
    """

    motion: FourierMotion
    start: float
    periods: int = 1

    @property
    def period(self) -> float:
        """Duration, s: it ends where it began."""
        return 2 * self.start + self.periods * self.motion.period

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Return q, qd, qdd (N, m) of the motors at times t (N)."""
        remaining = self.period - t
        part = np.minimum(1.0, np.minimum(t, remaining) / self.start)
        early = self.start * (part**3 - part**4 / 2)  # the integral of 3 x^2 - 2 x^3
        elapsed = np.where(t < remaining, early, self.period - self.start - early)
        q, qd, qdd = self.motion.at(np.where(part == 1.0, t - self.start / 2, elapsed))
        pace = (3 * part**2 - 2 * part**3)[:, None]
        turning = (np.where(t < remaining, 6.0, -6.0) * part * (1 - part) / self.start)[:, None]
        return q, qd * pace, qdd * pace**2 + qd * turning

    def times(self, finer: int = 1) -> Array:
        """Return the times at which limits are checked, as close together as those of the periodic motion."""
        step = self.motion.period / len(self.motion.times(finer))
        count = round(self.period / step)
        times: Array = np.arange(count) * self.period / count
        return times


Periodic = FourierMotion | Started
"""A motion of motors that ends where it begins."""


def within(motion: FourierMotion, limits: Limits) -> FourierMotion:
    """Return the motion scaled and centred to the limits; smaller motions stay as they are."""
    q, qd, qdd = replace(motion, centre=np.zeros_like(motion.centre)).at(motion.times(FINER))
    low, high = BETWEEN * q.min(axis=0), BETWEEN * q.max(axis=0)
    ratios = ((high - low) / (limits.high - limits.low), BETWEEN * np.abs(qd).max(axis=0) / limits.velocity,
              BETWEEN * np.abs(qdd).max(axis=0) / limits.acceleration)  # fmt: skip
    scale = 1 / np.maximum(1.0, np.max(ratios, axis=0))
    centre = np.clip(motion.centre, limits.low - scale * low, limits.high - scale * high)
    return replace(motion, centre=centre, a=motion.a * scale[:, None], b=motion.b * scale[:, None])


def random_motion(limits: Limits, frequency: float, harmonics: int, seed: int = 0) -> FourierMotion:
    """Return a random motion that fills the limits."""
    rng = np.random.default_rng(seed)
    motors = len(limits.low)
    a, b = rng.standard_normal((2, motors, harmonics)) * 10 * np.max(limits.velocity)
    return within(FourierMotion(frequency, (limits.low + limits.high) / 2, a, b), limits)


def from_rest(
    motion: FourierMotion, limits: Limits, keeps: Callable[[Started], bool] = lambda _: True
) -> Started | None:
    """Return the motion with the shortest start from rest, whole periods, that acceleration limits and `keeps` allow;
    made smaller where no start is long enough, None where that does not help."""
    for k in range(MOST_SMALLER):
        smaller = motion.smaller(SMALLER**k)
        for periods in range(1, LONGEST_START + 1):
            candidate = Started(smaller, periods * motion.period)
            qdd = candidate.at(candidate.times(FINER * FINER))[2]
            if (ENDS * np.abs(qdd) <= limits.acceleration).all() and keeps(candidate):
                return candidate
    return None


def with_neighbours(x: Array) -> Array:
    """Return samples (N, ...) of a period with those before and after them, (3, N, ...)."""
    return np.stack([np.roll(x, 1, axis=0), x, np.roll(x, -1, axis=0)])


def rise(x: Array) -> Array:
    """Return how far a smooth curve can exceed the samples (N, ...) of a period: twice h^2 |x''| / 8."""
    before, here, after = with_neighbours(x)
    most: Array = with_neighbours(np.abs(before - 2 * here + after)).max(axis=0)
    return most / 4
