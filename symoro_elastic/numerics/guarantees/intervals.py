"""Intervals of doubles, many at once, whose ends are rounded outwards.

An interval holds every value that an expression takes, in exact arithmetic, where its operands are in theirs. Each end
is computed to nearest and moved one number outwards, which is more than the half ulp that it may be off; sines and
cosines are moved by four ulp of one, since libraries are not that exact. What is not bounded (a quotient by an interval
with zero, an overflow, a NaN) has infinite ends, and so has all that is computed from it.
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
"""Four ulp of one."""
TURN = 2 * math.pi


@final
class Interval:
    """Lower and upper ends, arrays of one shape: one interval for each sub-box."""

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

    def __radd__(self, other: int) -> Interval:
        return self + other

    def __rsub__(self, other: int) -> Interval:
        return -self + other

    def __rmul__(self, other: int) -> Interval:
        return self * other

    def __rtruediv__(self, other: int) -> Interval:
        return interval(other) / self

    def __iter__(self) -> Iterator[Array]:
        """Lower, then upper ends."""
        return iter((self.low, self.high))

    def square(self) -> Interval:
        """x x of one x: never negative."""
        low = np.where((self.low <= 0) & (self.high >= 0), 0.0, np.minimum(abs(self.low), abs(self.high)))
        found = outwards(low * low, self.magnitude**2)
        return Interval(np.where(np.isfinite(found.low), np.maximum(found.low, 0.0), found.low), found.high)

    def reciprocal(self) -> Interval:
        """1/x; not bounded where zero is a value of x."""
        with np.errstate(divide="ignore"):
            found = outwards(1.0 / self.high, 1.0 / self.low)
        return not_bounded_where((self.low <= 0) & (self.high >= 0), found)

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

    def widened(self, by: Array) -> Interval:
        """All values that are at most `by` away from one of the interval."""
        return outwards(self.low - by, self.high + by)

    def hull(self, other: Operand) -> Interval:
        """The values of both, and all between them."""
        other = interval(other)
        return Interval(np.minimum(self.low, other.low), np.maximum(self.high, other.high))

    def meeting(self, other: Interval) -> Interval:
        """The values that are in both, which hold the same quantity."""
        return Interval(np.maximum(self.low, other.low), np.minimum(self.high, other.high))


def interval(x: Operand | Constant) -> Interval:
    """The interval itself, or the one of an exact number."""
    if type(x) is Interval:
        return x
    nearest = np.array(float(x))
    if float(x) == x:
        return Interval(nearest, nearest)
    return outwards(nearest, nearest)


def outwards(low: Array, high: Array) -> Interval:
    """The interval of ends that were computed to nearest; not bounded where one is infinite or no number."""
    finite = np.isfinite(low) & np.isfinite(high)
    if np.all(finite):
        return Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf))
    return not_bounded_where(~finite, Interval(np.nextafter(low, -np.inf), np.nextafter(high, np.inf)))


def not_bounded_where(where: Any, of: Interval) -> Interval:
    """The intervals, without bounds where that is said, and where an end is infinite or no number."""
    where = where | ~of.is_bounded
    return Interval(np.where(where, -np.inf, of.low), np.where(where, np.inf, of.high))


def _cos(x: Interval) -> Interval:
    """A cosine is largest at whole turns, least half a turn on; between them it is monotonic."""
    near, far = np.cos(x.low), np.cos(x.high)
    low = np.where(_holds(x, math.pi), -1.0, np.minimum(near, far) - SLACK)
    high = np.where(_holds(x, 0.0), 1.0, np.maximum(near, far) + SLACK)
    return _of_circle(x, low, high)


def _sin(x: Interval) -> Interval:
    near, far = np.sin(x.low), np.sin(x.high)
    low = np.where(_holds(x, -math.pi / 2), -1.0, np.minimum(near, far) - SLACK)
    high = np.where(_holds(x, math.pi / 2), 1.0, np.maximum(near, far) + SLACK)
    return _of_circle(x, low, high)


def _of_circle(x: Interval, low: Array, high: Array) -> Interval:
    return not_bounded_where(~x.is_bounded, Interval(np.maximum(low, -1.0), np.minimum(high, 1.0)))


def _holds(x: Interval, angle: float) -> Any:
    """Whether an angle, or one that is whole turns from it, may be in the interval: yes in cases of doubt."""
    slack = SLACK * (1.0 + x.magnitude)
    return np.floor((x.high + slack - angle) / TURN) >= np.ceil((x.low - slack - angle) / TURN)


def _sqrt(x: Interval) -> Interval:
    """A root; not bounded where a value is negative."""
    found = outwards(np.sqrt(np.maximum(x.low, 0.0)), np.sqrt(np.maximum(x.high, 0.0)))
    return not_bounded_where(x.low < 0, Interval(np.maximum(found.low, 0.0), found.high))


def _sign(x: Interval) -> Interval:
    return not_bounded_where(~x.is_bounded, Interval(np.sign(x.low), np.sign(x.high)))


def _minimum(x: Interval, y: Interval) -> Interval:
    bounded = x.is_bounded & y.is_bounded
    return not_bounded_where(~bounded, Interval(np.minimum(x.low, y.low), np.minimum(x.high, y.high)))


def _atan2(y: Interval, x: Interval) -> Interval:
    """Arc tangent; a whole turn where the half line of its jump, or the origin, is met."""
    corners = [np.arctan2(a, b) for a in (y.low, y.high) for b in (x.low, x.high)]
    jumps = meets_jump(y, x)
    low = np.where(jumps, -math.pi, np.min(np.broadcast_arrays(*corners), axis=0)) - 4 * SLACK
    high = np.where(jumps, math.pi, np.max(np.broadcast_arrays(*corners), axis=0)) + 4 * SLACK
    return not_bounded_where(~(y.is_bounded & x.is_bounded), Interval(low, high))


def meets_jump(y: Interval, x: Interval) -> Any:
    """Whether the half line at which an arc tangent jumps, or the origin, may be met."""
    return (x.low <= 0) & (y.low <= 0) & (y.high >= 0)


def _cospi(x: Interval) -> Interval:
    return _cos(x * _pi())


def _pi() -> Interval:
    return outwards(np.array(math.pi), np.array(math.pi))


_FUNCTIONS: dict[str, Callable[..., Interval]] = {
    SIN: _sin,
    COS: _cos,
    SQRT: _sqrt,
    SIGN: _sign,
    MINIMUM: _minimum,
    MAXIMUM: lambda x, y: -_minimum(-x, -y),
    ATAN2: _atan2,
    COSPI: _cospi,
    PI: _pi,
}

INTERVALS: Arithmetic[Interval] = Arithmetic(interval, Library(_FUNCTIONS.__getitem__))
"""Arithmetic of intervals."""
