"""From samples at uneven times to an even clock and back, for filters of positions.

Both ways are linear in what is sampled: cubics between samples, with slopes of parabolas through neighbours, which is
right to the third order of the step and local, so that noise keeps its density in the band of the motion. Neighbours
too close to determine a slope are skipped. A cubic by least squares of the neighbours replaces missing samples.
Torques need no even clock: averages of both sides of tau = Y X are of the samples that there are.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, lru_cache

import numpy as np

from symoro_elastic.analysis.time_series.clocks import GAP
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.packages import for_identification

CUBIC = 4  # coefficients, the fewest samples at a gap
CLOSE = 0.3  # steps: closer samples determine no slope
FARTHEST = 3  # close samples that are skipped


def clock_of(t: Array, period: float) -> EvenClock:
    """Return the even clock of uneven times (N), s, from a cache of the last few."""
    return _clock(t.tobytes(), period)


@lru_cache(maxsize=4)
def _clock(t: bytes, period: float) -> EvenClock:
    return EvenClock(np.frombuffer(t), period)


class EvenClock:
    """Even times (K), s, over the span of uneven ones (N)."""

    def __init__(self, t: Array, period: float) -> None:
        self._at, self._period = t, period
        self.t: Array = t[0] + period * np.arange(int((t[-1] - t[0]) / period * (1 + 1e-12)) + 1)
        self._bridges = list(self._bridges_of_gaps(period))
        missing = [times for times, _, _ in self._bridges]
        self._times = np.concatenate([t, *missing])
        self._order = np.argsort(self._times, kind="stable")
        self._times = self._times[self._order]

    def evenly(self, x: Array) -> Array:
        """Return x (N, ...) at the even times."""
        flat = x.reshape(len(x), -1)
        inserted = [weights @ flat[neighbours] for _, neighbours, weights in self._bridges]
        samples = np.concatenate([flat, *inserted])[self._order]
        curve = for_identification("scipy.interpolate").CubicHermiteSpline(self._times, samples, self._slopes(samples))
        even: Array = curve(self.t)
        return even.reshape(len(self.t), *x.shape[1:])

    def at_samples(self, x: Array) -> Array:
        """Return x (K, ...), which is smooth, at the uneven times."""
        uneven: Array = for_identification("scipy.interpolate").CubicSpline(self.t, x)(self._at)
        return uneven

    def _slopes(self, x: Array) -> Array:
        """Return slopes (N, k) of parabolas through each sample and its neighbours."""
        (left, back), (right, on) = self._beside
        before, after = (x - x[left]) / back, (x[right] - x) / on
        slopes: Array = (on * before + back * after) / (back + on)
        return slopes

    @cached_property
    def _beside(self) -> list[tuple[AnyArray, Array]]:
        """Neighbours before and after each sample, and how far they are (N, 1); at the ends two on the same side."""
        t, last, found = self._times, len(self._times) - 1, []
        for side in (-1, 1):
            other = np.arange(last + 1) + side
            for _ in range(FARTHEST):
                inner = np.clip(other, 0, last)
                other += side * (np.abs(t[inner] - t) < CLOSE * self._period)
            other = np.where((other < 0) | (other > last), np.arange(last + 1) - 2 * side, other)
            found.append((other, side * (t[other] - t)[:, None]))
        return found

    def _bridges_of_gaps(self, period: float) -> Iterator[tuple[Array, slice, Array]]:
        """Yield times of missing samples, the slice of their neighbours, and the weights of these."""
        t = self._at
        steps = np.diff(t) / period
        for k in np.flatnonzero(steps > GAP):
            count = round(float(steps[k])) - 1
            if count < 1:
                continue
            reach = max(CUBIC, count + 1)
            neighbours = slice(max(0, k + 1 - reach), min(len(t), k + 1 + reach))
            times = t[k] + (t[k + 1] - t[k]) * np.arange(1, count + 1) / (count + 1)
            middle, size = (t[k] + t[k + 1]) / 2, reach * period
            powers = [np.vander((x - middle) / size, CUBIC) for x in (times, t[neighbours])]
            yield times, neighbours, powers[0] @ np.linalg.pinv(powers[1])
