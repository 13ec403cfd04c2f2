"""Truncated power series in one variable t, with coefficients of many digits.

With x + e t a function's coefficient 1 is its derivative along e; with the motion x(t) coefficients 1 and 2 are
its rate and half its acceleration.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath
from mpmath import mpf


class Series:
    """c0 + c1 t + c2 t^2 + ..., as long as its list of coefficients; a number stands for a constant series."""

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Sequence[Any]) -> None:
        self.coefficients = list(coefficients)

    def __add__(self, other: Any) -> Series:
        return Series([a + b for a, b in zip(self.coefficients, self.like(other), strict=True)])

    def __sub__(self, other: Any) -> Series:
        return Series([a - b for a, b in zip(self.coefficients, self.like(other), strict=True)])

    def __mul__(self, other: Any) -> Series:
        if not isinstance(other, Series):
            return Series([a * other for a in self.coefficients])
        a, b = self.coefficients, other.coefficients
        return Series([sum((a[i] * b[n - i] for i in range(1, n + 1)), a[0] * b[n]) for n in range(len(a))])

    def __truediv__(self, other: Any) -> Series:
        if not isinstance(other, Series):
            return Series([a / other for a in self.coefficients])
        a, b = self.coefficients, other.coefficients
        quotient: list[Any] = []
        for n in range(len(a)):
            quotient.append((a[n] - sum((quotient[i] * b[n - i] for i in range(n)), mpf(0))) / b[0])
        return Series(quotient)

    def __neg__(self) -> Series:
        return Series([-a for a in self.coefficients])

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: Any) -> Series:
        return -self + other

    def __rtruediv__(self, other: Any) -> Series:
        return Series(self.like(other)) / self

    def like(self, other: Any) -> list[Any]:
        """Coefficients of another series or number, as many as here."""
        if isinstance(other, Series):
            return other.coefficients
        return [other, *[mpf(0)] * (len(self.coefficients) - 1)]

    def derivative(self) -> list[Any]:
        """Coefficients of the derivative by t, one fewer."""
        return [n * c for n, c in enumerate(self.coefficients)][1:]


def coefficient(value: Any, order: int) -> Any:
    """Coefficient of t^order of a series or a number."""
    if isinstance(value, Series):
        return value.coefficients[order]
    return mpf(value) if not order else mpf(0)


def sin(x: Any) -> Any:
    return _sin_cos(x)[0] if isinstance(x, Series) else mpmath.sin(x)


def cos(x: Any) -> Any:
    return _sin_cos(x)[1] if isinstance(x, Series) else mpmath.cos(x)


def tan(x: Any) -> Any:
    return sin(x) / cos(x)


def sqrt(x: Any) -> Any:
    """From root^2 = x, coefficient by coefficient."""
    if not isinstance(x, Series):
        return mpmath.sqrt(x)
    c = x.coefficients
    root = [mpmath.sqrt(c[0])]
    for n in range(1, len(c)):
        root.append((c[n] - sum((root[i] * root[n - i] for i in range(1, n)), mpf(0))) / (2 * root[0]))
    return Series(root)


def atan2(y: Any, x: Any) -> Any:
    """Its derivative is (x y' - y x') / (x^2 + y^2)."""
    if not isinstance(y, Series) and not isinstance(x, Series):
        return mpmath.atan2(y, x)
    size = len((y if isinstance(y, Series) else x).coefficients)
    constant = Series([mpf(0)] * size)
    y, x = constant + y, constant + x
    yd, xd = Series([*y.derivative(), mpf(0)]), Series([*x.derivative(), mpf(0)])
    slope = ((x * yd - y * xd) / (x * x + y * y)).coefficients
    first = mpmath.atan2(y.coefficients[0], x.coefficients[0])
    return Series([first, *(slope[n - 1] / n for n in range(1, size))])


def _sin_cos(x: Series) -> tuple[Series, Series]:
    """s' = c x', c' = -s x'."""
    slopes = x.derivative()
    s, c = [mpmath.sin(x.coefficients[0])], [mpmath.cos(x.coefficients[0])]
    for n in range(1, len(x.coefficients)):
        s.append(sum((slopes[i] * c[n - 1 - i] for i in range(n)), mpf(0)) / n)
        c.append(-sum((slopes[i] * s[n - 1 - i] for i in range(n)), mpf(0)) / n)
    return Series(s), Series(c)


FUNCTIONS: dict[str, Callable[..., Any]] = {"sin": sin, "cos": cos, "tan": tan, "sqrt": sqrt, "atan2": atan2}
