"""Exact first derivatives along with values: numbers `value + slope e` with e^2 = 0.

A slope is a number for one direction, or an array for many. Duals nest: where value and slope are
duals themselves, the slope of the slope is a second derivative.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic
from symoro_elastic.symbolic.expression import ATAN2, COS, COSPI, PI, SIGN, SIN, SQRT


class Dual:
    """A value and its slope; other numbers are constants beside it."""

    __slots__ = ("slope", "value")
    __array_ufunc__ = None  # an array beside a dual is a constant, and no array of duals

    def __init__(self, value: Any, slope: Any) -> None:
        self.value, self.slope = value, slope

    def __add__(self, other: Any) -> Dual:
        if other.__class__ is Dual:
            return Dual(self.value + other.value, self.slope + other.slope)
        return Dual(self.value + other, self.slope)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Dual:
        if other.__class__ is Dual:
            return Dual(self.value - other.value, self.slope - other.slope)
        return Dual(self.value - other, self.slope)

    def __rsub__(self, other: Any) -> Dual:
        return Dual(other - self.value, -self.slope)

    def __mul__(self, other: Any) -> Dual:
        if other.__class__ is Dual:
            return Dual(self.value * other.value, self.value * other.slope + other.value * self.slope)
        return Dual(self.value * other, self.slope * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        if other.__class__ is Dual:
            ratio = self.value / other.value
            return Dual(ratio, (self.slope - ratio * other.slope) / other.value)
        return Dual(self.value / other, self.slope / other)

    def __rtruediv__(self, other: Any) -> Dual:
        ratio = other / self.value
        return Dual(ratio, -(ratio / self.value) * self.slope)

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.slope)

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, {self.slope!r})"


def differentiating(arithmetic: Arithmetic) -> Arithmetic:
    """An arithmetic of duals over another one; `sign` has slope zero, at a jump too.

    Constants stay numbers of the other arithmetic. Symbols may be given as numbers, or as duals, all of
    one depth. Raises `ZeroDivisionError` for the slope of a square root or of an angle at zero.
    """
    base = arithmetic.operations
    sine, cosine, root, arc = base[SIN], base[COS], base[SQRT], base[ATAN2]

    def sin(x: Any) -> Any:
        return Dual(sin(x.value), cos(x.value) * x.slope) if x.__class__ is Dual else sine(x)

    def cos(x: Any) -> Any:
        return Dual(cos(x.value), -sin(x.value) * x.slope) if x.__class__ is Dual else cosine(x)

    def sqrt(x: Any) -> Any:
        if x.__class__ is not Dual:
            return root(x)
        value = sqrt(x.value)
        return Dual(value, x.slope / (2 * value))

    def atan2(y: Any, x: Any) -> Any:
        if y.__class__ is not Dual and x.__class__ is not Dual:
            return arc(y, x)
        (y, dy), (x, dx) = _parts(y), _parts(x)
        return Dual(atan2(y, x), (x * dy - y * dx) / (x * x + y * y))

    functions: dict[str, Callable[..., Any]] = {SIN: sin, COS: cos, SQRT: sqrt, ATAN2: atan2}
    steps = {SIGN: lambda x: base[SIGN](_innermost(x)), PI: base[PI], COSPI: base[COSPI]}
    return Arithmetic(arithmetic.number, {**RATIONAL, **functions, **steps})


def _parts(x: Any) -> tuple[Any, Any]:
    return (x.value, x.slope) if x.__class__ is Dual else (x, 0)


def _innermost(x: Any) -> Any:
    while x.__class__ is Dual:
        x = x.value
    return x
