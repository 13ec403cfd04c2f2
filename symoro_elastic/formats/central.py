"""Inertial parameters about the centre of mass, converted to the origin of the frame, as .par files need them."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction

from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body


def about_origin(body: Body) -> Body:
    """The same body with first moments and inertia about the origin; numbers stay exact.

    Raises `FormulaError` where an expression grows beyond what is read.
    """
    if not body.central:
        return body
    m, (x, y, z) = body.mass, body.moments
    xx, xy, xz, yy, yz, zz = body.inertia
    return Body(
        mass=m,
        moments=(_product(m, x), _product(m, y), _product(m, z)),
        inertia=(
            _sum(xx, [_product(m, y, y), _product(m, z, z)]),
            _difference(xy, _product(m, x, y)),
            _difference(xz, _product(m, x, z)),
            _sum(yy, [_product(m, x, x), _product(m, z, z)]),
            _difference(yz, _product(m, y, z)),
            _sum(zz, [_product(m, x, x), _product(m, y, y)]),
        ),
    )


def _number(formula: Formula) -> Fraction | None:
    value = formula.tree[1] if formula.tree[0] == "number" else None
    return value if isinstance(value, Fraction) else None


def _decimal(value: Fraction) -> Formula:
    """A finite decimal fraction, written out exactly."""
    places = 0
    while (value * 10**places).denominator != 1:
        places += 1
    digits = value * 10**places
    return Formula.parse(str(Decimal(f"{digits}E-{places}")))


def _product(*factors: Formula) -> Formula:
    numbers = [_number(factor) for factor in factors]
    if Fraction(0) in numbers:
        return ZERO
    constant = Fraction(1)
    for number in numbers:
        constant *= 1 if number is None else number
    names = [_bracketed(factor) for factor, number in zip(factors, numbers, strict=True) if number is None]
    if not names:
        return _decimal(constant)
    return Formula.parse("*".join(names if constant == 1 else [_bracketed(_decimal(constant)), *names]))


def _sum(first: Formula, others: Iterable[Formula]) -> Formula:
    terms = [term for term in (first, *others) if not term.is_zero]
    numbers = [_number(term) for term in terms]
    total = sum((number for number in numbers if number is not None), Fraction(0))
    named = [_bracketed(term) for term, number in zip(terms, numbers, strict=True) if number is None]
    if not named:
        return _decimal(total) if len(terms) > 1 else (terms or [ZERO])[0]
    return Formula.parse(" + ".join([*named, _bracketed(_decimal(total))] if total else named))


def _difference(first: Formula, second: Formula) -> Formula:
    number = _number(second)
    if number is not None:
        return _sum(first, [] if number == 0 else [_decimal(-number)])
    return Formula.parse(f"{'' if first.is_zero else _bracketed(first) + ' '}- {_bracketed(second)}")


def _bracketed(formula: Formula) -> str:
    """The text of a formula, in brackets unless it is a name, a product of names or a plain number."""
    plain = formula.text.replace("_", "").replace("*", "").replace(".", "").isalnum() and "**" not in formula.text
    return formula.text if plain else f"({formula.text})"
