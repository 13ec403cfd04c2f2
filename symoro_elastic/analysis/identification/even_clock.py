"""From samples at uneven times to an even clock and back, for filters of positions.

Both ways are linear in what is sampled: cubics between samples, with slopes of parabolas through neighbours, which is
right to the third order of the step and local, so that noise keeps its density in the band of the motion. Neighbours
too close to tell a slope are passed over. Where samples are missing a cubic by least squares of those beside stands in.
Torques need no even clock: averages of both sides of tau = Y X are of the samples that there are.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, lru_cache

import numpy as np

from symoro_elastic.analysis.time_series.clocks import GAP
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.packages import for_identification

CUBIC = 4  # coefficients, the fewest samples beside a gap
CLOSE, FARTHEST = 0.3, 3  # steps: closer samples tell no slope; how many are passed over


def clock_of(t: Array, period: float) -> EvenClock:
    """Return the even clock beside uneven times (N), s; the last few are kept."""
    return _clock(t.tobytes(), period)


@lru_cache(maxsize=4)
def _clock(t: bytes, period: float) -> EvenClock:
    return EvenClock(np.frombuffer(t), period)


class EvenClock:
    """Even times (K), s, beside uneven ones (N)."""

    def __init__(self, t: Array, period: float) -> None:
        self._at, self._period = t, period
        self.t: Array = t[0] + period * np.arange(int((t[-1] - t[0]) / period * (1 + 1e-12)) + 1)
        self._bridges = list(self._bridged(period))
        missing = [times for times, _, _ in self._bridges]
        self._times = np.concatenate([t, *missing])
        self._order = np.argsort(self._times, kind="stable")
        self._times = self._times[self._order]

    def evenly(self, x: Array) -> Array:
        """Return x (N, ...) at the even times."""
        flat = x.reshape(len(x), -1)
        inserted = [weights @ flat[beside] for _, beside, weights in self._bridges]
        whole = np.concatenate([flat, *inserted])[self._order]
        curve = for_identification("scipy.interpolate").CubicHermiteSpline(self._times, whole, self._slopes(whole))
        found: Array = curve(self.t)
        return found.reshape(len(self.t), *x.shape[1:])

    def at_samples(self, x: Array) -> Array:
        """Return x (K, ...), which is smooth, at the uneven times."""
        found: Array = for_identification("scipy.interpolate").CubicSpline(self.t, x)(self._at)
        return found

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

    def _bridged(self, period: float) -> Iterator[tuple[Array, slice, Array]]:
        """Yield times of samples that are missing, those beside them, and the weights that these have in them."""
        t = self._at
        steps = np.diff(t) / period
        for k in np.flatnonzero(steps > GAP):
            count = round(float(steps[k])) - 1
            if count < 1:
                continue
            reach = max(CUBIC, count + 1)
            beside = slice(max(0, k + 1 - reach), min(len(t), k + 1 + reach))
            times = t[k] + (t[k + 1] - t[k]) * np.arange(1, count + 1) / (count + 1)
            middle, size = (t[k] + t[k + 1]) / 2, reach * period
            powers = [np.vander((x - middle) / size, CUBIC) for x in (times, t[beside])]
            yield times, beside, powers[0] @ np.linalg.pinv(powers[1])
