"""Decimal numbers: functions of them are those of mpmath with more digits; fewer digits are refused."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import mpmath
import pytest

from symoro_elastic.symbolic.arithmetic import FLOATS
from symoro_elastic.symbolic.decimals import decimals, in_digits
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, DIVIDE, OPERATIONS, PI, SIN, SQRT, SYMBOL, Operation


@pytest.mark.parametrize("x", [Fraction(1, 3), Fraction(-7, 5), Fraction(10**6) + Fraction(1, 7)])
def test_functions_have_all_digits(x: Fraction) -> None:
    many = decimals(50)
    with in_digits(50), mpmath.workdps(90):
        number, exact = many.number(x), mpmath.mpf(x.numerator) / x.denominator
        wanted = {SIN: mpmath.sin(exact), COS: mpmath.cos(exact), COSPI: mpmath.cospi(exact)}
        found = {name: many.operations[name](number) for name in wanted}
        found[ATAN2], wanted[ATAN2] = many.operations[ATAN2](number, many.number(3)), mpmath.atan2(exact, 3)
        found[PI], wanted[PI] = many.operations[PI](), +mpmath.pi
        for name, y in found.items():
            tolerance = mpmath.mpf("1e-43") if abs(x) > 10 else mpmath.mpf("1e-48")  # x itself is rounded to 50 digits
            assert abs(mpmath.mpf(str(y)) - wanted[name]) < tolerance, name
        assert many.operations[SQRT](number * number) == abs(number)


def test_fewer_digits_and_division_by_zero_are_refused() -> None:
    many = decimals(50)
    with pytest.raises(RuntimeError, match="outside"):
        many.number(1)
    with in_digits(50):
        assert many.operations[SQRT](Decimal(-1)).is_nan()
        with pytest.raises(ZeroDivisionError):
            many.operations[DIVIDE](Decimal(0), Decimal(0))


@pytest.mark.parametrize("row", [row for row in OPERATIONS.values() if row.name != SYMBOL], ids=lambda row: row.name)
def test_every_operation_has_decimals(row: Operation) -> None:
    numbers = (Fraction(1, 3), Fraction(2, 7))[: row.arity]
    with in_digits(50):
        found = decimals(50).operations[row.name](*map(decimals(50).number, numbers))
    assert float(found) == pytest.approx(FLOATS.operations[row.name](*map(float, numbers)), rel=1e-15)
