"""What a quantity is swept over, as text: steps LOW:HIGH:COUNT, values X1,X2,..., or a distribution to draw from.

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
from symoro_elastic.foundation.errors import InputError
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
        """How many there are."""
        return len(self.given)

    def values(self) -> list[float]:
        """Return the values."""
        return list(self.given)


@dataclass(frozen=True)
class Uniform:
    """A quantity of which all values, or all logarithms, from low to high are equally likely."""

    low: float
    high: float
    log: bool = False

    def quantiles(self, shares: Array) -> Array:
        """Return the values below which these shares of all lie."""
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** shares)
        return np.asarray(self.low + shares * (self.high - self.low))


@dataclass(frozen=True)
class Normal:
    """A quantity of a normal distribution, or whose logarithm has one: then `middle` is its median."""

    middle: float
    deviation: float
    log: bool = False

    def quantiles(self, shares: Array) -> Array:
        """Return the values below which these shares of all lie."""
        z = import_optional("scipy.special", "a sample", "sweep").ndtri(shares)
        if self.log:
            return np.asarray(self.middle * np.exp(self.deviation * z))
        return np.asarray(self.middle + self.deviation * z)


@dataclass(frozen=True)
class OfMachine:
    """A quantity in the range that the machine gives, the `word` says which: in `count` steps, or to draw from."""

    word: str
    count: int | None = None

    def between(self, given: Range) -> Steps | Uniform:
        """Return the axis over a range."""
        return Uniform(given.low, given.high) if self.count is None else Steps(given.low, given.high, self.count)


Listed: TypeAlias = Steps | Values
Spread: TypeAlias = Uniform | Normal
Axis: TypeAlias = Listed | Spread | OfMachine
AxisLike: TypeAlias = str | float | Sequence[float]


def axis(name: str, given: AxisLike) -> Axis:
    """Return what a quantity is swept over; raises `InputError` for what is not an axis."""
    try:
        found = _of_text(given) if isinstance(given, str) else Values(_numbers(given))
        _refuse(found)
    except (ValueError, OverflowError) as error:
        what = f"{name}={given}" if isinstance(given, str) else f"{name}: {shown(given)}"
        raise InputError("symoro-elastic", OPTION, f"{quote(what)}: {error}") from None
    return found


def shown(given: object) -> str:
    """Return how Python writes a value, on one line of at most 60 characters."""
    text = " ".join(repr(given).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _numbers(given: float | Sequence[float]) -> tuple[float, ...]:
    """Return numbers of Python or numpy; raises `ValueError`."""
    each = np.ravel(given).tolist() if isinstance(given, np.ndarray) else given
    listed = [each] if isinstance(each, Real) else each
    if isinstance(listed, Mapping) or not isinstance(listed, Sequence):
        raise ValueError(f"is not a list of numbers; {FORMS}")
    for x in listed:
        if isinstance(x, bool) or not isinstance(x, Real):
            raise ValueError(f"{shown(x)} is not a number")
    return tuple(float(x) for x in listed)


def _of_text(text: str) -> Axis:
    """Return the axis that a text writes; raises `ValueError`."""
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


def _refuse(found: Axis) -> None:
    """Raise `ValueError` for invalid values: not numbers, out of range, not in order or given twice."""
    match found:
        case OfMachine():
            return
        case Values(given):
            if not given:
                raise ValueError("there is no value: an empty grid has no points")
            if len(set(given)) < len(given):
                raise ValueError("a value is given twice")
            ends: tuple[float, ...] = given
        case Steps(low, high, count) | Uniform(low, high, count):
            ends = (low, high)
            if not (low < high or (low == high and isinstance(found, Steps) and count == 1)):
                raise ValueError(f"{low:g}:{high:g} is not a range: give LOW:HIGH, LOW first")
        case Normal(middle, deviation):
            ends = (middle, deviation)
            if not 0 < deviation < math.inf:
                raise ValueError(f"{deviation:g} is not a standard deviation: give a positive one")
    for x in ends:
        if not math.isfinite(x):
            raise ValueError(f"{x:g} is not a number to compute with")
        refuse_range(x)
    if not isinstance(found, Values) and found.log and ends[0] <= 0:
        raise ValueError(f"{ends[0]:g} has no logarithm: give positive numbers")
