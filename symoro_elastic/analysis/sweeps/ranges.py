"""Axes of a sweep as text: steps LOW:HIGH:COUNT, values X1,X2,..., or a random distribution.

Or the range that the machine gives: tolerance of a parameter, limits of a position.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import NO_RANGE, NOT_FINITE, TWICE, InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.machine.formula import FormulaError, number, refuse_range
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.names import quote

OPTION = "--over"
LOG = "log"
TOLERANCE, LIMITS = "tolerance", "limits"
"""Words for a range that the machine gives: of a parameter, and of a position."""
FORMS = (
    "give LOW:HIGH:COUNT[,log] or X1,X2,...; with --samples LOW:HIGH[,log], normal:MEAN:DEVIATION or "
    "lognormal:MEDIAN:DEVIATION of the logarithm; tolerance[:COUNT], limits[:COUNT] for the range in the machine file"
)


@dataclass(frozen=True)
class Steps:
    """Values of a quantity in a grid: `count` of them from low to high, evenly spaced, or on a logarithmic scale."""

    low: float
    high: float
    count: int
    log: bool = False

    def values(self) -> list[float]:
        """Return the values."""
        if self.log:
            spaced: list[float] = np.geomspace(self.low, self.high, self.count).tolist()
            return spaced
        return [self.low + (self.high - self.low) * k / max(self.count - 1, 1) for k in range(self.count)]


@dataclass(frozen=True)
class Values:
    """Values of a quantity in a grid."""

    given: tuple[float, ...]

    @property
    def count(self) -> int:
        """Number of values."""
        return len(self.given)

    def values(self) -> list[float]:
        """Return the values."""
        return list(self.given)


@dataclass(frozen=True)
class Uniform:
    """A quantity with a uniform distribution of its values, or of their logarithms, from low to high."""

    low: float
    high: float
    log: bool = False

    def quantiles(self, shares: Array) -> Array:
        """Return the quantiles at probabilities (N,)."""
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** shares)
        return np.asarray(self.low + shares * (self.high - self.low))


@dataclass(frozen=True)
class Normal:
    """A quantity with a normal or log-normal distribution; `middle` is the mean or the median."""

    middle: float
    deviation: float
    log: bool = False

    def quantiles(self, shares: Array) -> Array:
        """Return the quantiles at probabilities (N,)."""
        z = import_optional("scipy.special", "a sample", "sweep").ndtri(shares)
        if self.log:
            return np.asarray(self.middle * np.exp(self.deviation * z))
        return np.asarray(self.middle + self.deviation * z)


@dataclass(frozen=True)
class OfMachine:
    """A quantity over the machine's range named by `word`: in `count` steps, or uniformly distributed."""

    word: str
    count: int | None = None

    def between(self, bounds: Range) -> Steps | Uniform:
        """Return steps or a uniform distribution over a range."""
        return Uniform(bounds.low, bounds.high) if self.count is None else Steps(bounds.low, bounds.high, self.count)


Listed: TypeAlias = Steps | Values
Spread: TypeAlias = Uniform | Normal
Axis: TypeAlias = Listed | Spread | OfMachine
AxisLike: TypeAlias = str | float | Sequence[float]


def axis(name: str, written: AxisLike) -> Axis:
    """Return the axis (steps, values or distribution) of a quantity; raises `InputError` for an invalid one."""
    try:
        parsed = _of_text(written) if isinstance(written, str) else Values(_numbers(written))
        _refuse(parsed)
    except (ValueError, OverflowError) as error:
        what = f"{name}={written}" if isinstance(written, str) else f"{name}: {python_text(written)}"
        raise InputError("symoro-elastic", OPTION, f"{quote(what)}: {error}") from None
    return parsed


def python_text(value: object) -> str:
    """Return a value as Python source, on one line of at most 60 characters."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _numbers(written: float | Sequence[float]) -> tuple[float, ...]:
    """Return a number, a sequence or an array as a tuple of floats; raises `ValueError`."""
    values = np.ravel(written).tolist() if isinstance(written, np.ndarray) else written
    listed = [values] if isinstance(values, Real) else values
    if isinstance(listed, Mapping) or not isinstance(listed, Sequence):
        raise ValueError(f"is not a list of numbers; {FORMS}")
    for x in listed:
        if isinstance(x, bool) or not isinstance(x, Real):
            raise ValueError(f"{python_text(x)} is not a number")
    return tuple(float(x) for x in listed)


def _of_text(text: str) -> Axis:
    """Return the axis described by a text, as on the command line; raises `ValueError`."""
    *words, last = (word.strip() for word in text.split(","))
    log = last == LOG
    words = words if log else [*words, last]
    parts = [part.strip() for part in words[0].split(":")] if len(words) == 1 else []
    if parts and parts[0] in ("normal", "lognormal"):
        if log or len(parts) != 3:
            raise ValueError(f"give {parts[0]}:{'MEDIAN' if parts[0] == 'lognormal' else 'MEAN'}:DEVIATION")
        return Normal(_number(parts[1]), _number(parts[2]), parts[0] == "lognormal")
    if parts and parts[0] in (TOLERANCE, LIMITS):
        if log or len(parts) > 2:
            raise ValueError(f"give {parts[0]} or {parts[0]}:COUNT")
        count = _count(parts[1]) if len(parts) == 2 else None
        if count == 1:
            raise ValueError("one value is not a range: give a COUNT from 2")
        return OfMachine(parts[0], count)
    if len(parts) == 3:
        return Steps(_number(parts[0]), _number(parts[1]), _count(parts[2]), log)
    if len(parts) == 2:
        return Uniform(_number(parts[0]), _number(parts[1]), log)
    if log or len(parts) > 3 or not words:
        raise ValueError(FORMS)
    return Values(tuple(map(_number, words)))


def _number(text: str) -> float:
    try:
        return number(text)
    except FormulaError as error:
        raise ValueError(f"{quote(text)} is not a number ({error}); {FORMS}") from None


def _count(text: str) -> int:
    count = _number(text)
    if count != int(count) or count < 1:
        raise ValueError("give LOW:HIGH:COUNT, numbers and a count from 1")
    return int(count)


def _refuse(over: Axis) -> None:
    """Raise `ValueError` for invalid values: not numbers, out of range, not in order or repeated."""
    match over:
        case OfMachine():
            return
        case Values(given):
            if not given:
                raise ValueError("the list is empty: a grid needs at least one value")
            if len(set(given)) < len(given):
                raise ValueError(f"a value {TWICE}")
            ends: tuple[float, ...] = given
        case Steps(low, high, count) | Uniform(low, high, count):
            ends = (low, high)
            if not (low < high or (low == high and isinstance(over, Steps) and count == 1)):
                raise ValueError(NO_RANGE.format(low, high))
        case Normal(middle, deviation):
            ends = (middle, deviation)
            if not 0 < deviation < math.inf:
                raise ValueError(f"{deviation:g} is not a standard deviation: give a positive one")
    for x in ends:
        if not math.isfinite(x):
            raise ValueError(f"{x:g} {NOT_FINITE}")
        refuse_range(x)
    if not isinstance(over, Values) and over.log and ends[0] <= 0:
        raise ValueError(f"{ends[0]:g} has no logarithm: give positive numbers")
