"""Affine forms: numbers that keep in mind how they depend on the variables of a box, many at once.

An interval forgets where its values come from: x c - x d, with c and d nearly the same, is as wide as |x| (|c| + |d|).
An affine form is c + sum a_k e_k + r, |e_k| <= 1, |r| <= rest, with one e_k for each variable of a box: x in
[-X, X] is X e_1, and x c - x d is (c - d) X e_1 and a rest of as much as c and d vary. So what cancels at every state
cancels here, up to products of widths (J. Stolfi, L. de Figueiredo, Self-validated numerical methods, 1997).

    product    c1 c2 + (sum a1_k a2_k)/2 + sum (c1 a2_k + c2 a1_k) e_k,   rest |c1| r2 + |c2| r1 + R1 R2 - h

with R = sum |a_k| + rest and h = (sum |a1_k a2_k|)/2: each e_k^2 lies in [0, 1], all other products are at most 1.
Convex and concave functions f of y in [a, b] are p y + m +- d, p the slope of the chord (Chebyshev): for 1/y and roots
f - p y is largest and least at both ends and where f' = p. What is left (arc tangents, signs, extrema) is an interval.

**Sines and cosines** of m + t, |t| <= h <= pi, are sums of products with cos t and sin t:

    cos t = 1 - u + u e,   u = (1 - cos h)/2,       sin t = p t + g e',   p = (sin h)/h,   g = sin t' - p t', cos t' = p

for the sine is concave from 0 to pi, and odd. With variables e and e' of their own, which are the same wherever the
angle is, nothing is left but rounding; else they are part of the rest.

Where an interval of the same quantity is known, it counts for ranges of functions. Numbers are computed to nearest: the
rest takes `ROUNDING` of the sizes of all terms, hundreds of times what they may be off.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias, final

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval, not_bounded_where
from symoro_elastic.symbolic.arithmetic import Arithmetic, Library
from symoro_elastic.symbolic.expression import Constant
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, MAXIMUM, MINIMUM, PI, SIGN, SIN, SQRT

Operand: TypeAlias = "Affine | int"
ROUNDING = 2.0**-44
"""Of the sizes of all terms, of at most some hundred variables."""
TINY = 1e-300
"""More than what products lose below the smallest numbers."""
NO_SLOPES = np.zeros(1)
MOST_OF_CIRCLE = 3.14
"""Of h, the half width of an angle: beyond, its sine is an interval."""


@final
class Affine:
    """Center and rest (...), slopes (..., variables); `known` is an interval of the same quantity, if there is one."""

    __slots__ = ("center", "known", "of_circle", "radius", "rest", "slopes")

    def __init__(self, center: Array, slopes: Array, rest: Array, known: Interval | None = None) -> None:
        self.center, self.slopes, self.rest, self.known = center, slopes, rest, known
        self.of_circle: tuple[int, int] | None = None
        self.radius = np.abs(slopes).sum(axis=-1) * (1 + ROUNDING) + rest

    def __add__(self, other: Operand) -> Affine:
        y = affine(other)
        rest = self.rest + y.rest + ROUNDING * (self.size + y.size)
        return Affine(self.center + y.center, self.slopes + y.slopes, rest)

    def __sub__(self, other: Operand) -> Affine:
        y = affine(other)
        rest = self.rest + y.rest + ROUNDING * (self.size + y.size)
        return Affine(self.center - y.center, self.slopes - y.slopes, rest)

    def __neg__(self) -> Affine:
        return Affine(-self.center, -self.slopes, self.rest, self.known and -self.known)

    def __mul__(self, other: Operand) -> Affine:
        if type(other) is int and abs(other) == 1:
            return self if other == 1 else -self
        x, y = self, affine(other)
        squares = x.slopes * y.slopes
        slopes = x.center[..., None] * y.slopes + y.center[..., None] * x.slopes
        rest = abs(x.center) * y.rest + abs(y.center) * x.rest + x.radius * y.radius - abs(squares).sum(axis=-1) / 2
        return Affine(x.center * y.center + squares.sum(axis=-1) / 2, slopes, rest + ROUNDING * x.size * y.size + TINY)

    def __truediv__(self, other: Operand) -> Affine:
        return self * affine(other).reciprocal()

    def __radd__(self, other: int) -> Affine:
        return self + other

    def __rsub__(self, other: int) -> Affine:
        return -self + other

    def __rmul__(self, other: int) -> Affine:
        return self * other

    def __rtruediv__(self, other: int) -> Affine:
        return affine(other) / self

    @property
    def size(self) -> Array:
        """At least the sum of the magnitudes of all terms."""
        size: Array = abs(self.center) + self.radius
        return size

    @property
    def range(self) -> Interval:
        """All values."""
        more = self.radius + ROUNDING * self.size
        found = not_bounded_where(np.isnan(more), Interval(self.center - more, self.center + more))
        return found.meeting(self.known) if self.known else found

    @property
    def magnitude(self) -> Array:
        """The largest absolute value."""
        largest: Array = self.range.magnitude
        return largest

    def line(self, slope: Array, constant: Array, off: Array, size: Array) -> Affine:
        """slope x + constant +- off; `size` is that of the terms of which these numbers are."""
        rest = abs(slope) * self.rest + off + ROUNDING * (abs(slope) * self.size + size) + TINY
        return Affine(slope * self.center + constant, slope[..., None] * self.slopes, rest)

    def reciprocal(self) -> Affine:
        """1/x; not bounded where zero is a value of x."""
        found = self.range
        low, high = np.minimum(abs(found.low), abs(found.high)), found.magnitude
        low = np.where((found.low > 0) | (found.high < 0), low, np.nan)
        sign, most, least = np.sign(found.high), 1 / low + 1 / high, 2 / np.sqrt(low) / np.sqrt(high)
        return self.line(-1 / low / high, sign * (most + least) / 2, (most - least) / 2, 4 * most)

    def widened(self, by: Array) -> Affine:
        """All values that are at most `by` away from one of these."""
        return Affine(self.center, self.slopes, (self.rest + by) * (1 + ROUNDING))

    def at_most(self, other: Interval) -> Affine:
        """The same quantity, which lies in an interval: that alone where it is not wider than the rest."""
        of = of_interval(other)
        alone = of.rest <= np.nan_to_num(self.rest, nan=np.inf)
        slopes = np.where(alone[..., None], 0.0, self.slopes)
        return Affine(np.where(alone, of.center, self.center), slopes, np.where(alone, of.rest, self.rest), other)


def affine(x: Operand | Constant) -> Affine:
    """The form itself, or the one of an exact number."""
    return x if type(x) is Affine else of_interval(interval(x))


def of_interval(x: Interval) -> Affine:
    """A form that does not depend on the variables."""
    bounded = np.isfinite(x.low) & np.isfinite(x.high)
    center = np.where(bounded, x.low / 2 + x.high / 2, 0.0)
    rest = np.where(bounded, np.maximum(x.high - center, center - x.low) * (1 + ROUNDING), np.inf)
    return Affine(center, NO_SLOPES, rest, x)


def variable(x: Interval, number: int, count: int) -> Affine:
    """The form of one of so many variables, which takes all values of an interval."""
    center = x.low / 2 + x.high / 2
    slopes = np.zeros((*np.shape(center), count))
    slopes[..., number] = np.maximum(x.high - center, center - x.low) * (1 + ROUNDING)
    return Affine(center, slopes, np.zeros_like(center), x)


def _circle(x: Affine, name: str) -> Affine:
    """A sine or a cosine of x = m + t, |t| <= h: of both parts in (cos m cos t, sin m sin t), up to signs."""
    found = x.range
    bounds: Interval = INTERVALS.operations[name](found)
    middle = found.low / 2 + found.high / 2
    half = np.maximum(found.high - middle, middle - found.low) * (1 + ROUNDING)
    half = np.where(half <= MOST_OF_CIRCLE, half, np.nan)
    even, odd = (np.sin(middle), np.cos(middle)) if name == SIN else (np.cos(middle), -np.sin(middle))
    chord = np.where(half > 0, np.sin(half) / np.where(half > 0, half, 1.0), 1.0)
    above = np.sin(at := np.arccos(np.minimum(chord, 1.0))) - chord * at + ROUNDING
    up = (1 - np.cos(half)) / 2 + ROUNDING
    line = x.line(odd * chord, even * (1 - up) - odd * chord * middle, np.zeros_like(even), 4 + abs(middle))
    return _with(line, x.of_circle, (abs(even) * up, even * up), (abs(odd) * above, odd * above)).at_most(bounds)


def _with(x: Affine, numbers: tuple[int, int] | None, *more: tuple[Array, Array]) -> Affine:
    """A form with terms (magnitude, slope) of variables with these numbers; in its rest where there are none."""
    if numbers is None:
        return x.widened(sum((size for size, _ in more), start=np.zeros_like(x.center)))
    slopes = x.slopes.copy()
    for number, (_, slope) in zip(numbers, more, strict=True):
        slopes[..., number] += slope
    return Affine(x.center, slopes, x.rest)


def _sqrt(x: Affine) -> Affine:
    found = x.range
    low, high = np.sqrt(found.low), np.sqrt(found.high)
    slope = 1 / (low + high)
    ends, inside = low * high * slope, 1 / (4 * slope)
    return x.line(slope, (inside + ends) / 2, (inside - ends) / 2, 4 * high)


def _by_interval(name: str) -> Callable[..., Affine]:
    def of(*x: Affine) -> Affine:
        return of_interval(INTERVALS.operations[name](*(each.range for each in x)))

    return of


_FUNCTIONS: dict[str, Callable[..., Affine]] = {
    SIN: lambda x: _circle(x, SIN),
    COS: lambda x: _circle(x, COS),
    SQRT: _sqrt,
    **{name: _by_interval(name) for name in (SIGN, MINIMUM, MAXIMUM, ATAN2, COSPI, PI)},
}

AFFINE: Arithmetic[Affine] = Arithmetic(affine, Library(_FUNCTIONS.__getitem__))
"""Arithmetic of affine forms."""
