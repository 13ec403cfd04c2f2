"""The scalars of the equations: numbers, symbols, residues of a finite field, or anything else with + - * /."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Protocol, TypeAlias


class Element(Protocol):
    """An element of a field that also calculates with exact numbers."""

    def __add__(self, other: Scalar, /) -> Scalar: ...
    def __radd__(self, other: Scalar, /) -> Scalar: ...
    def __sub__(self, other: Scalar, /) -> Scalar: ...
    def __rsub__(self, other: Scalar, /) -> Scalar: ...
    def __mul__(self, other: Scalar, /) -> Scalar: ...
    def __rmul__(self, other: Scalar, /) -> Scalar: ...
    def __truediv__(self, other: Scalar, /) -> Scalar: ...
    def __rtruediv__(self, other: Scalar, /) -> Scalar: ...
    def __neg__(self) -> Scalar: ...


Scalar: TypeAlias = int | float | Fraction | Element
"""An element of any field; the exact integers 0 and 1 are structure."""


def sum_of(terms: Iterable[Scalar]) -> Scalar:
    """Return the sum of terms, from the first to the last; `sum` adds floats otherwise from Python 3.12 on."""
    total: Scalar = 0
    for term in terms:
        total = total + term
    return total


def quotient(x: Scalar, y: Scalar) -> Scalar:
    """Return x / y, exact where both are integers, which Python divides as floats."""
    if isinstance(x, int) and isinstance(y, int):
        exact = Fraction(x, y)
        return exact.numerator if exact.denominator == 1 else exact
    return x / y
