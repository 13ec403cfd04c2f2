"""Borders of stability of a cut by the phase of its response: one for each number of waves, at every spindle speed.

Real and imaginary part of 1 + K b (1 - e^(-i w T)) L(w) = 0 are, with a(w) the argument of -L,

    b = -1/(2 K Re L),   w T - 2 a(w) = (2 n + 1) pi,   Re L < 0,

n + 1/2 - a/pi being the waves between two teeth (Tlusty). L depends on the machine alone: its eigenvalues are computed
once, over frequencies so close that Re L and a are monotone between them, zeros and minima of Re L included. At a speed
the phase at two neighbouring frequencies shows which borders lie between them; of several the one next to the lower
Re L counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symoro_elastic.analysis.control.largest_gain import refined_minimum
from symoro_elastic.analysis.control.loops import roots
from symoro_elastic.foundation.array_types import Array, ComplexArray, IndexArray

SMOOTH = 1e-5
"""Relative distance of a value from the cubic through its four neighbours, above which frequencies get closer."""
MOST_HALVED, NARROWEST = 40, 1e-11
"""Halvings of an interval of frequencies, and its relative width below which differences of values are rounding."""
FLAT = 1e-11
"""Relative depth of a minimum below its neighbours that is rounding."""
BESIDE = 1e-9
"""Relative step of the last correction of a frequency by a secant."""
SPEEDS_AT_ONCE = 32
"""Bounds the memory of a table of speeds and frequencies."""


class Borders(NamedTuple):
    """The border with the most negative Re L at each speed: Re L, 0 without a border; its frequency, Hz, else NaN."""

    reals: Array
    frequencies: Array


@dataclass(frozen=True)
class Branch:
    """One eigenvalue over ascending frequencies in Hz: `values` (n,); `of` computes all of them at frequencies."""

    of: Callable[[Array], ComplexArray]
    frequencies: Array
    values: ComplexArray

    def at(self, f: Array) -> ComplexArray:
        """Return the eigenvalue (k,) at frequencies: the one next to the line between neighbouring values."""
        k = np.clip(np.searchsorted(self.frequencies, f) - 1, 0, len(self.frequencies) - 2)
        low, high = self.frequencies[k], self.frequencies[k + 1]
        expected = self.values[k] + (f - low) / (high - low) * (self.values[k + 1] - self.values[k])
        values = self.of(f)
        nearest = np.abs(values - expected[:, None]).argmin(axis=1)[:, None]
        return np.asarray(np.take_along_axis(values, nearest, axis=1)[:, 0], dtype=complex)

    @property
    def least(self) -> tuple[float, float]:
        """The least real part and its frequency."""
        k = int(self.values.real.argmin())
        return float(self.values.real[k]), float(self.frequencies[k])

    def with_zeros_and_minima(self) -> Branch:
        """Return the branch with the frequencies at which its real part is zero, and at which it is least."""
        f, x = self.frequencies, self.values.real
        k = np.flatnonzero(np.sign(x[:-1]) * np.sign(x[1:]) < 0)
        zeros = roots(lambda f: self.at(f).real, f[k], f[k + 1]) if len(k) else np.zeros(0)
        before, after = x[:-2] - x[1:-1], x[2:] - x[1:-1]
        is_low = (np.minimum(before, after) >= 0) & (np.maximum(before, after) > -FLAT * x[1:-1]) & (x[1:-1] < 0)
        low = (1 + np.flatnonzero(is_low)).tolist()
        minima = [refined_minimum(lambda f: self.at(f).real, f, k)[1] for k in low]
        return self.with_more(np.setdiff1d([*zeros, *minima], f))

    def with_more(self, more: Array) -> Branch:
        """Return the branch with more frequencies."""
        at = np.searchsorted(self.frequencies, more)
        return Branch(self.of, np.insert(self.frequencies, at, more), np.insert(self.values, at, self.at(more)))

    def with_extreme(self, period: Array, sign: float) -> Branch:
        """Return the branch with a frequency added at which `sign` times `waves` peaks among its three frequencies."""
        _, place = refined_minimum(lambda f: -sign * self.waves(f, self.at(f), period), self.frequencies, 1)
        return self if place in self.frequencies else self.with_more(np.array([place]))

    def waves(self, f: Array, values: ComplexArray, periods: Array) -> Array:
        """Return w T/(2 pi) - arg(-L)/pi - 1/2 of eigenvalues L at frequencies; it is an integer at a border."""
        return np.asarray(f * periods - np.angle(-values) / np.pi - 0.5)


def branches(of: Callable[[Array], ComplexArray], frequencies: Array) -> list[Branch]:
    """Return the branches of the eigenvalues (n, m) that `of` computes, starting from those at the given frequencies.

    Frequencies get closer where eigenvalues with a negative real part are not smooth.
    """
    f, values, rough = frequencies, track_eigenvalues(of(frequencies)), np.arange(len(frequencies) - 1)
    for _ in range(MOST_HALVED):
        rough = rough[f[rough + 1] - f[rough] > NARROWEST * f[rough + 1]]
        if not len(rough):
            break
        middle = (f[rough] + f[rough + 1]) / 2
        expected = _cubic(f, values, rough, middle)
        exact = of(middle)
        same, crossed = (np.abs(x - expected).sum(axis=1) for x in (exact, exact[:, ::-1]))
        exact = np.where((crossed < same)[:, None], exact[:, ::-1], exact)
        is_rough = np.abs(exact - expected) > SMOOTH * np.abs(exact)
        is_rough &= np.minimum(np.minimum(values[rough].real, values[rough + 1].real), exact.real) < 0
        f, values = np.insert(f, rough + 1, middle), track_eigenvalues(np.insert(values, rough + 1, exact, axis=0))
        halved = (rough + np.arange(len(rough)))[is_rough.any(axis=1)]
        rough = np.sort(np.concatenate([halved, halved + 1]))
    return [Branch(of, f, column).with_zeros_and_minima() for column in values.T]


def _cubic(f: Array, values: ComplexArray, k: IndexArray, at: Array) -> ComplexArray:
    """Return the values (k, m) of cubics through four neighbours of intervals k."""
    near, own = np.clip(k - 1, 0, len(f) - 4)[:, None] + np.arange(4), np.eye(4, dtype=bool)
    x = f[near]
    above = np.where(own, 1, at[:, None, None] - x[:, None, :])
    below = np.where(own, 1, x[:, :, None] - x[:, None, :])
    return np.asarray(np.einsum("ki,kim->km", (above / below).prod(axis=2), values[near]), dtype=complex)


def track_eigenvalues(values: ComplexArray) -> ComplexArray:
    """Return eigenvalues (frequencies, m), m <= 2, swapped so that each changes least between frequencies."""
    if values.shape[1] == 1:
        return values
    same, crossed = (np.abs(values[1:] - values[:-1, order]).sum(axis=1) for order in ([0, 1], [1, 0]))
    is_crossed = np.concatenate([[False], np.cumsum(crossed < same) % 2 == 1])
    return np.where(is_crossed[:, None], values[:, ::-1], values)


class _Crossings(NamedTuple):
    """Borders between neighbouring frequencies: indices of periods and of frequencies, integers of `Branch.waves`.

    `bounds` are the lower Re L of both frequencies, `likely` are estimates at the border by a straight line.
    """

    period: IndexArray
    k: IndexArray
    waves: Array
    bounds: Array
    likely: Array

    def part(self, at: IndexArray) -> _Crossings:
        """Return the crossings with these indices."""
        return _Crossings(self.period[at], self.k[at], self.waves[at], self.bounds[at], self.likely[at])


def _crossings(branch: Branch, periods: Array) -> _Crossings:
    """Return the borders of a branch; of several between two frequencies, the one at the lower Re L."""
    x, waves = branch.values.real, branch.waves(branch.frequencies, branch.values, periods[:, None])
    is_left = x[:-1] <= x[1:]
    start, end = np.where(is_left, waves[:, :-1], waves[:, 1:]), np.where(is_left, waves[:, 1:], waves[:, :-1])
    integer = np.where(end >= start, np.ceil(start), np.floor(start))
    low, high = np.minimum(x[:-1], x[1:]), np.maximum(x[:-1], x[1:])
    period, k = np.nonzero(((integer - start) * (integer - end) <= 0) & (low < 0))
    start, end, integer = start[period, k], end[period, k], integer[period, k]
    fraction = np.divide(integer - start, end - start, out=np.zeros(len(k)), where=end != start)
    return _Crossings(period, k, integer, low[k], low[k] + fraction * (high - low)[k])


def least_deep(of: Sequence[Branch], periods: Array) -> Borders:
    """Return the borders with the most negative Re L for tooth periods, s."""
    borders = Borders(np.zeros(len(periods)), np.full(len(periods), np.nan))
    for first in range(0, len(periods), SPEEDS_AT_ONCE):
        part = slice(first, first + SPEEDS_AT_ONCE)
        best, times = Borders(borders.reals[part], borders.frequencies[part]), periods[part]
        pairs = [(branch, _crossings(branch, times)) for branch in of]
        for branch, crossings in pairs:
            order = np.lexsort((crossings.likely, crossings.period))
            likeliest = order[np.unique(crossings.period[order], return_index=True)[1]]
            _solve(best, branch, times, crossings.part(likeliest))
        for branch, crossings in pairs:
            _solve(best, branch, times, crossings.part(np.flatnonzero(crossings.bounds < best.reals[crossings.period])))
            _solve_turns(best, branch, times)
    return borders


def _solve(best: Borders, branch: Branch, periods: Array, crossings: _Crossings) -> None:
    """Refine crossings to borders, and store those with a lower Re L in `best`."""
    if not len(crossings.k):
        return

    def residual(f: Array) -> Array:
        return branch.waves(f, branch.at(f), periods[crossings.period]) - crossings.waves

    f = roots(residual, branch.frequencies[crossings.k], branch.frequencies[crossings.k + 1])
    # Next to a zero of Re L the last digits of the frequency count.
    here, there = residual(f), residual(f * (1 + BESIDE))
    f = f - np.divide(f * BESIDE * here, there - here, out=np.zeros_like(f), where=there != here)
    reals = branch.at(f).real
    for i in np.argsort(-reals):
        if reals[i] < best.reals[crossings.period[i]]:
            best.reals[crossings.period[i]], best.frequencies[crossings.period[i]] = reals[i], f[i]


def _solve_turns(best: Borders, branch: Branch, periods: Array) -> None:
    """Solve for pairs of borders about an extreme of `waves` between frequencies, which their values do not show."""
    f, x = branch.frequencies, branch.values.real
    waves = branch.waves(f, branch.values, periods[:, None])
    before, after, middle = np.diff(waves)[:, :-1], np.diff(waves)[:, 1:], waves[:, 1:-1]
    # The extreme is beyond the value in the middle by less than the larger difference.
    beyond = middle + np.sign(before) * np.maximum(np.abs(before), np.abs(after))
    lowest, highest = (bound(bound(x[:-2], x[1:-1]), x[2:]) for bound in (np.minimum, np.maximum))
    turns = (before * after < 0) & (np.floor(middle) != np.floor(beyond)) & (highest <= 0)
    for i, k in np.argwhere(turns & (lowest < best.reals[:, None])):
        period, sign = periods[i : i + 1], float(np.sign(before[i, k]))
        near = Branch(branch.of, f[k : k + 3], branch.values[k : k + 3]).with_extreme(period, sign)
        _solve(Borders(best.reals[i : i + 1], best.frequencies[i : i + 1]), near, period, _crossings(near, period))
