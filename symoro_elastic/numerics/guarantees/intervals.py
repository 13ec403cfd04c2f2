"""Arrays of intervals of doubles, whose ends are rounded outwards.

An interval holds every value that an expression takes, in exact arithmetic, where its operands are in theirs. Each end
is computed to nearest and moved one number outwards, which is more than the half ulp that it may be off; sines and
cosines are moved by four ulp of one, since libraries are not that exact. What is not bounded (a quotient by an interval
with zero, an overflow, a NaN) has infinite ends, and so do all intervals that depend on it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias, final

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.symbolic.arithmetic import Arithmetic, Library
from symoro_elastic.symbolic.expression import Constant
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, MAXIMUM, MINIMUM, PI, SIGN, SIN, SQRT

Operand: TypeAlias = "Interval | int"
SLACK = 2.0**-50
"""4 ulp of 1, by which ends of sines and cosines are moved."""
TURN = 2 * math.pi


@final
class Interval:
    """Lower and upper ends, arrays of the same shape with an interval per sub-box."""

    __slots__ = ("high", "low")

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high = low, high

    def __add__(self, other: Operand) -> Interval:
        other = interval(other)
        return outwards(self.low + other.low, self.high + other.high)

    def __sub__(self, other: Operand) -> Interval:
        other = interval(other)
        return outwards(self.low - other.high, self.high - other.low)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __mul__(self, other: Operand) -> Interval:
        if type(other) is int and abs(other) == 1:
            return self if other == 1 else -self
        if other is self:
            return self.square()
        other = interval(other)
        ends = (self.low * other.low, self.low * other.high, self.high * other.low, self.high * other.high)
        least = np.minimum(np.minimum(ends[0], ends[1]), np.minimum(ends[2], ends[3]))
        return outwards(least, np.maximum(np.maximum(ends[0], ends[1]), np.maximum(ends[2], ends[3])))

    def __truediv__(self, other: Operand) -> Interval:
        return self * interval(other).reciprocal()

    def __rsub__(self, other: int) -> Interval:
        return -self + other

    __radd__ = __add__
    __rmul__ = __mul__

    def __rtruediv__(self, other: int) -> Interval:
        return interval(other) / self

    def __iter__(self) -> Iterator[Array]:
        """Lower, then upper ends."""
        return iter((self.low, self.high))

    def square(self) -> Interval:
        """The square of x, which is never negative."""
        low = np.where((self.low <= 0) & (self.high >= 0), 0.0, np.minimum(abs(self.low), abs(self.high)))
        square = outwards(low * low, self.magnitude**2)
        return Interval(np.where(np.isfinite(square.low), np.maximum(square.low, 0.0), square.low), square.high)

    def reciprocal(self) -> Interval:
        """1/x; not bounded where zero is a value of x."""
        with np.errstate(divide="ignore"):
            inverse = outwards(1.0 / self.high, 1.0 / self.low)
        return not_bounded_where((self.low <= 0) & (self.high >= 0), inverse)

    @property
    def magnitude(self) -> Array:
        """The largest absolute value."""
        return np.maximum(abs(self.low), abs(self.high))

    @property
    def least_magnitude(self) -> Array:
        """The least absolute value: 0 where zero is a value."""
        return np.maximum(0.0, np.maximum(self.low, -self.high))

    @property
    def is_bounded(self) -> Any:
        """Whether both ends are finite."""
        return np.isfinite(self.low) & np.isfinite(self.high)

    def widen(self, by: Array) -> Interval:
        """The interval extended by `by` at both ends."""
        return outwards(self.low - by, self.high + by)

    def hull(self, other: Operand) -> Interval:
        """The smallest interval that contains both."""
        other = interval(other)
        return Interval(np.minimum(self.low, other.low), np.maximum(self.high, other.high))

    def meeting(self, other: Interval) -> Interval:
        """The intersection of two intervals of the same quantity."""
        return Interval(np.maximum(self.low, other.low), np.minimum(self.high, other.high))


def interval(x: Operand | Constant) -> Interval:
    """The interval itself, or the interval of an exact number."""
    if type(x) is Interval:
        return x
    nearest = np.array(float(x))
    if float(x) == x:
        return Interval(nearest, nearest)
    return outwards(nearest, nearest)


def outwards(low: Array, high: Array) -> Interval:
    """The interval of ends rounded to nearest, moved outwards; not bounded where an end is not finite."""
    finite = np.isfinite(low) & np.isfinite(high)
    if np.all(finite):
        return Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))
    return not_bounded_where(~finite, Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf)))


def not_bounded_where(where: Any, of: Interval) -> Interval:
    """The intervals, unbounded at `where` and where an end is not finite."""
    where = where | ~of.is_bounded
    return Interval(np.where(where, -np.inf, of.low), np.where(where, np.inf, of.high))


def _cos(x: Interval) -> Interval:
    """The cosine of an interval: largest at whole turns, least half a turn on, monotonic between them."""
    at_low, at_high = np.cos(x.low), np.cos(x.high)
    low = np.where(_holds(x, math.pi), -1.0, np.minimum(at_low, at_high) - SLACK)
    high = np.where(_holds(x, 0.0), 1.0, np.maximum(at_low, at_high) + SLACK)
    return _of_circle(x, low, high)


def _sin(x: Interval) -> Interval:
    at_low, at_high = np.sin(x.low), np.sin(x.high)
    low = np.where(_holds(x, -math.pi / 2), -1.0, np.minimum(at_low, at_high) - SLACK)
    high = np.where(_holds(x, math.pi / 2), 1.0, np.maximum(at_low, at_high) + SLACK)
    return _of_circle(x, low, high)


def _of_circle(x: Interval, low: Array, high: Array) -> Interval:
    return not_bounded_where(~x.is_bounded, Interval(np.maximum(low, -1.0), np.minimum(high, 1.0)))


def _holds(x: Interval, angle: float) -> Any:
    """Whether an angle, up to full turns, may be in the interval, with a margin for rounding."""
    slack = SLACK * (1.0 + x.magnitude)
    return np.floor((x.high + slack - angle) / TURN) >= np.ceil((x.low - slack - angle) / TURN)


def _sqrt(x: Interval) -> Interval:
    """A root; not bounded where a value is negative."""
    root = outwards(np.sqrt(np.maximum(x.low, 0.0)), np.sqrt(np.maximum(x.high, 0.0)))
    return not_bounded_where(x.low < 0, Interval(np.maximum(root.low, 0.0), root.high))


def _sign(x: Interval) -> Interval:
    return not_bounded_where(~x.is_bounded, Interval(np.sign(x.low), np.sign(x.high)))


def _minimum(x: Interval, y: Interval) -> Interval:
    bounded = x.is_bounded & y.is_bounded
    return not_bounded_where(~bounded, Interval(np.minimum(x.low, y.low), np.minimum(x.high, y.high)))


def _atan2(y: Interval, x: Interval) -> Interval:
    """Arc tangent; a full turn where the half line of its jump, or the origin, is met."""
    corners = [np.arctan2(a, b) for a in (y.low, y.high) for b in (x.low, x.high)]
    jumps = meets_jump(y, x)
    low = np.where(jumps, -math.pi, np.min(np.broadcast_arrays(*corners), axis=0)) - 4 * SLACK
    high = np.where(jumps, math.pi, np.max(np.broadcast_arrays(*corners), axis=0)) + 4 * SLACK
    return not_bounded_where(~(y.is_bounded & x.is_bounded), Interval(low, high))


def meets_jump(y: Interval, x: Interval) -> Any:
    """Whether the half line at which an arc tangent jumps, or the origin, may be met."""
    return (x.low <= 0) & (y.low <= 0) & (y.high >= 0)


_PI = outwards(np.array(math.pi), np.array(math.pi))
_FUNCTIONS: dict[str, Callable[..., Interval]] = {
    SIN: _sin,
    COS: _cos,
    SQRT: _sqrt,
    SIGN: _sign,
    MINIMUM: _minimum,
    MAXIMUM: lambda x, y: -_minimum(-x, -y),
    ATAN2: _atan2,
    COSPI: lambda x: _cos(x * _PI),
    PI: lambda: _PI,
}

INTERVALS: Arithmetic[Interval] = Arithmetic(interval, Library(_FUNCTIONS.__getitem__))
"""Arithmetic of intervals."""
