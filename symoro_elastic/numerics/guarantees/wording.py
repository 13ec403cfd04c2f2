"""Bounds in words: numbers rounded outwards, and remarks on divisors and on the range of numbers."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

from symoro_elastic.numerics.guarantees.box import DRAWN_AS
from symoro_elastic.numerics.guarantees.certificate import Certificate, EntryBound, Guarantee


def at_most(x: float, digits: int = 2) -> str:
    """An upper bound as text, rounded upwards."""
    return _rounded(x, digits, ROUND_CEILING)


def at_least(x: float, digits: int = 2) -> str:
    """A lower bound as text, rounded downwards."""
    return _rounded(x, digits, ROUND_FLOOR)


def _rounded(x: float, digits: int, way: str) -> str:
    if not math.isfinite(x):
        return Guarantee.NONE
    return format(float(Context(prec=digits, rounding=way).create_decimal(Decimal(x))), f".{digits}g")


def range_text(entry: EntryBound) -> str:
    """The range of an entry as text, its ends rounded outwards."""
    if not math.isfinite(entry.magnitude):
        return Guarantee.NONE
    return f"{at_least(entry.low, 4)} to {at_most(entry.high, 4)}"


def error_text(error: float) -> str:
    """The bound of an error as text."""
    return at_most(error) if error else "exact"


def confidence(word: str) -> str:
    """Return what a word for a confident bound means, in a sentence."""
    return f"{word}: {Guarantee.CONFIDENT}, {DRAWN_AS}"


def divisors(one: Certificate) -> str:
    """Return what is known of the divisors of a model, in a sentence."""
    least = min(one.pivots, key=lambda pivot: pivot.least, default=None)
    if least is None:
        return "it divides by nothing that moves"
    if not least.least > 0:
        return f"not bounded: {least.name} may be zero in the box"
    return f"no divisor is zero: the least is {least.name}, at least {at_least(least.least, 3)}"


def overflow(one: Certificate) -> str:
    """Return whether values stay within the range of the precision, in a sentence."""
    return "a value may be out of the range of numbers" if one.overflows else "nothing overflows and nothing is NaN"
