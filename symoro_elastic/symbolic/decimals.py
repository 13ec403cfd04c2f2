"""Numbers of many decimal digits: Python's own, with sums and products five times as fast as mpmath's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal, DivisionByZero, getcontext, localcontext
from fractions import Fraction
from functools import cache
from typing import Any

from symoro_elastic.symbolic.arithmetic import ORDERED, Arithmetic, library
from symoro_elastic.symbolic.expression import Constant
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, DIVIDE, PI, SIN, SQRT

GUARD = 20
"""Guard digits of functions: they are sufficient for an angle of 1e20."""


@contextmanager
def in_digits(digits: int) -> Iterator[None]:
    """Compute with so many digits, as a context or a decorator; undefined values are NaN."""
    with localcontext(Context(prec=digits, Emin=MIN_EMIN, Emax=MAX_EMAX, traps=[DivisionByZero])):
        yield


@cache
def decimals(digits: int) -> Arithmetic[Any]:
    """Arithmetic with this many decimal digits, within `in_digits`; the root of a negative number is NaN."""
    import mpmath

    context = mpmath.MPContext()
    context.dps = digits + GUARD

    def number(x: Constant) -> Decimal:
        if getcontext().prec < digits:
            raise RuntimeError(f"numbers of {digits} digits outside of in_digits({digits})")
        above, below = Fraction(x).as_integer_ratio()
        return Decimal(above) / below

    def of(function: Callable[..., Any]) -> Callable[..., Decimal]:
        return lambda *xs: +Decimal(context.nstr(function(*(context.mpf(str(x)) for x in xs)), context.dps))

    own = {name: of(getattr(context, name)) for name in (SIN, COS, ATAN2, COSPI)}
    return Arithmetic(
        number, library(context, {**own, **ORDERED, SQRT: _root, DIVIDE: _quotient, PI: of(lambda: +context.pi)})
    )


def _root(x: Decimal) -> Decimal:
    return Decimal("NaN") if x < 0 else x.sqrt()


def _quotient(x: Decimal, y: Decimal) -> Decimal:
    if y == 0:
        raise ZeroDivisionError("division by zero")
    return x / y
