"""Affine forms: arrays of numbers that record how they depend on the variables of a box.

An interval ignores dependence: x c - x d, with c and d nearly equal, is as wide as |x| (|c| + |d|).
An affine form is c + sum a_k e_k + r, |e_k| <= 1, |r| <= error, with one e_k for each variable of a box: x in
[-X, X] is X e_1, and x c - x d is (c - d) X e_1 and an error of as much as c and d vary. So what cancels at every state
cancels here, up to products of widths (J. Stolfi, L. de Figueiredo, Self-validated numerical methods, 1997).

    product    c1 c2 + (sum a1_k a2_k)/2 + sum (c1 a2_k + c2 a1_k) e_k,   error |c1| r2 + |c2| r1 + R1 R2 - h

with R = sum |a_k| + error and h = (sum |a1_k a2_k|)/2: each e_k^2 lies in [0, 1], all other products are at most 1.
Convex and concave functions f of y in [a, b] are p y + m +- d, p the slope of the chord (Chebyshev): for 1/y and roots
f - p y is largest and least at both ends and where f' = p. Arc tangents, signs and extrema are intervals.

**Sines and cosines** of m + t, |t| <= h <= pi, are sums of products with cos t and sin t:

    cos t = 1 - u + u e,   u = (1 - cos h)/2,       sin t = p t + g e',   p = (sin h)/h,   g = sin t' - p t', cos t' = p

for the sine is concave from 0 to pi, and odd. With own variables e and e', which are the same wherever the angle
occurs, the error is rounding only; else they are part of the error.

Where an interval of the same quantity is known, it counts for ranges of functions. Numbers are computed to nearest: the
error includes `ROUNDING` times the sizes of all terms, hundreds of times their rounding.
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
"""Bound of the relative rounding of a sum of terms, for at most a few hundred variables."""
TINY = 1e-300
"""Bound of the underflow of products."""
NO_SLOPES = np.zeros(1)
MOST_OF_CIRCLE = 3.14
"""Largest half width h of an angle, rad: the sine of a wider one is an interval."""


@final
class Affine:
    """Center and error bound (...), slopes (..., variables); `enclosure` is a known interval of the same quantity."""

    __slots__ = ("center", "enclosure", "error", "of_circle", "radius", "slopes")

    def __init__(self, center: Array, slopes: Array, error: Array, enclosure: Interval | None = None) -> None:
        self.center, self.slopes, self.error, self.enclosure = center, slopes, error, enclosure
        self.of_circle: tuple[int, int] | None = None
        self.radius = np.abs(slopes).sum(axis=-1) * (1 + ROUNDING) + error

    def __add__(self, other: Operand) -> Affine:
        y = affine(other)
        error = self.error + y.error + ROUNDING * (self.size + y.size)
        return Affine(self.center + y.center, self.slopes + y.slopes, error)

    def __sub__(self, other: Operand) -> Affine:
        y = affine(other)
        error = self.error + y.error + ROUNDING * (self.size + y.size)
        return Affine(self.center - y.center, self.slopes - y.slopes, error)

    def __neg__(self) -> Affine:
        return Affine(-self.center, -self.slopes, self.error, self.enclosure and -self.enclosure)

    def __mul__(self, other: Operand) -> Affine:
        if type(other) is int and abs(other) == 1:
            return self if other == 1 else -self
        x, y = self, affine(other)
        squares = x.slopes * y.slopes
        slopes = x.center[..., None] * y.slopes + y.center[..., None] * x.slopes
        error = abs(x.center) * y.error + abs(y.center) * x.error + x.radius * y.radius - abs(squares).sum(axis=-1) / 2
        return Affine(x.center * y.center + squares.sum(axis=-1) / 2, slopes, error + ROUNDING * x.size * y.size + TINY)

    def __truediv__(self, other: Operand) -> Affine:
        return self * affine(other).reciprocal()

    def __rsub__(self, other: int) -> Affine:
        return -self + other

    __radd__ = __add__
    __rmul__ = __mul__

    def __rtruediv__(self, other: int) -> Affine:
        return affine(other) / self

    @property
    def size(self) -> Array:
        """At least the sum of the magnitudes of all terms."""
        return np.asarray(abs(self.center) + self.radius)

    @property
    def range(self) -> Interval:
        """The interval of all values."""
        more = self.radius + ROUNDING * self.size
        values = not_bounded_where(np.isnan(more), Interval(self.center - more, self.center + more))
        return values.meeting(self.enclosure) if self.enclosure else values

    @property
    def magnitude(self) -> Array:
        """The largest absolute value."""
        return np.asarray(self.range.magnitude)

    def line(self, slope: Array, constant: Array, off: Array, size: Array) -> Affine:
        """slope x + constant +- off; `size` bounds the terms of both coefficients, for their rounding."""
        error = abs(slope) * self.error + off + ROUNDING * (abs(slope) * self.size + size) + TINY
        return Affine(slope * self.center + constant, slope[..., None] * self.slopes, error)

    def reciprocal(self) -> Affine:
        """1/x; not bounded where zero is a value of x."""
        values = self.range
        low, high = np.minimum(abs(values.low), abs(values.high)), values.magnitude
        low = np.where((values.low > 0) | (values.high < 0), low, np.nan)
        sign, most, least = np.sign(values.high), 1 / low + 1 / high, 2 / np.sqrt(low) / np.sqrt(high)
        return self.line(-1 / low / high, sign * (most + least) / 2, (most - least) / 2, 4 * most)

    def widen(self, by: Array) -> Affine:
        """The form with its error increased by `by`."""
        return Affine(self.center, self.slopes, (self.error + by) * (1 + ROUNDING))

    def at_most(self, other: Interval) -> Affine:
        """The form of a quantity that also lies in an interval, which replaces the form where it is narrower."""
        of = of_interval(other)
        alone = of.error <= np.nan_to_num(self.error, nan=np.inf)
        slopes = np.where(alone[..., None], 0.0, self.slopes)
        return Affine(np.where(alone, of.center, self.center), slopes, np.where(alone, of.error, self.error), other)


def affine(x: Operand | Constant) -> Affine:
    """The form itself, or the form of an exact number."""
    return x if type(x) is Affine else of_interval(interval(x))


def of_interval(x: Interval) -> Affine:
    """The form of an interval, independent of the variables."""
    bounded = np.isfinite(x.low) & np.isfinite(x.high)
    center = np.where(bounded, x.low / 2 + x.high / 2, 0.0)
    error = np.where(bounded, np.maximum(x.high - center, center - x.low) * (1 + ROUNDING), np.inf)
    return Affine(center, NO_SLOPES, error, x)


def variable(x: Interval, number: int, count: int) -> Affine:
    """The form of variable `number` of `count`, with the range x."""
    center = x.low / 2 + x.high / 2
    slopes = np.zeros((*np.shape(center), count))
    slopes[..., number] = np.maximum(x.high - center, center - x.low) * (1 + ROUNDING)
    return Affine(center, slopes, np.zeros_like(center), x)


def _circle(x: Affine, name: str) -> Affine:
    """The sine or cosine of x = m + t, |t| <= h, from products of cos t and sin t with constants."""
    values = x.range
    bounds: Interval = INTERVALS.operations[name](values)
    middle = values.low / 2 + values.high / 2
    half = np.maximum(values.high - middle, middle - values.low) * (1 + ROUNDING)
    half = np.where(half <= MOST_OF_CIRCLE, half, np.nan)
    even, odd = (np.sin(middle), np.cos(middle)) if name == SIN else (np.cos(middle), -np.sin(middle))
    chord = np.where(half > 0, np.sin(half) / np.where(half > 0, half, 1.0), 1.0)
    above = np.sin(at := np.arccos(np.minimum(chord, 1.0))) - chord * at + ROUNDING
    up = (1 - np.cos(half)) / 2 + ROUNDING
    line = x.line(odd * chord, even * (1 - up) - odd * chord * middle, np.zeros_like(even), 4 + abs(middle))
    return _with(line, x.of_circle, (abs(even) * up, even * up), (abs(odd) * above, odd * above)).at_most(bounds)


def _with(x: Affine, numbers: tuple[int, int] | None, *more: tuple[Array, Array]) -> Affine:
    """Return a form plus terms (magnitude, slope) of the variables `numbers`; without numbers its error widens."""
    if numbers is None:
        return x.widen(sum((size for size, _ in more), start=np.zeros_like(x.center)))
    slopes = x.slopes.copy()
    for number, (_, slope) in zip(numbers, more, strict=True):
        slopes[..., number] += slope
    return Affine(x.center, slopes, x.error)


def _sqrt(x: Affine) -> Affine:
    values = x.range
    low, high = np.sqrt(values.low), np.sqrt(values.high)
    slope = 1 / (low + high)
    ends, inside = low * high * slope, 1 / (4 * slope)
    return x.line(slope, (inside + ends) / 2, (inside - ends) / 2, 4 * high)


def _by_interval(name: str) -> Callable[..., Affine]:
    def of(*x: Affine) -> Affine:
        return of_interval(INTERVALS.operations[name](*(operand.range for operand in x)))

    return of


_FUNCTIONS: dict[str, Callable[..., Affine]] = {
    SIN: lambda x: _circle(x, SIN),
    COS: lambda x: _circle(x, COS),
    SQRT: _sqrt,
    **{name: _by_interval(name) for name in (SIGN, MINIMUM, MAXIMUM, ATAN2, COSPI, PI)},
}

AFFINE: Arithmetic[Affine] = Arithmetic(affine, Library(_FUNCTIONS.__getitem__))
"""Arithmetic of affine forms."""
