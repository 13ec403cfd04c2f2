"""Polynomials of named lengths and inertias, from which placements are computed exactly.

Numbers are exact while they are decimals times whole numbers; a sum of rounded ones that is zero within rounding is
zero. Arrays of numpy hold polynomials as they hold numbers, so placements with names pass through the same arithmetic.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import FUNCTIONS, SMALLEST, Formula, FormulaError

ROUNDING = 64 * 2.0**-52
"""Part of the larger of two rounded numbers below which their sum is zero."""
MOST_TERMS = 300
"""Of a sum, as many as a formula may have."""

Product = tuple[str, ...]
"""Factors in alphabetical order: names, and functions and quotients of them."""


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A polynomial in names and functions: products with coefficients, fractions or rounded numbers."""

    terms: Mapping[Product, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, formula: Formula, values: Mapping[str, float] | None = None) -> Polynomial:
        """Expand a formula, with names among `values` as numbers; raises `FormulaError` if it gets too long."""
        names = {name: cls({(name,): Fraction(1)}) for name in (*formula.names, "pi")}
        names |= {name: cls.number(x) for name, x in (values or {}).items()}
        polynomial: Polynomial = formula.evaluate(names, {name: _function(name) for name in FUNCTIONS}, cls.number)
        return polynomial

    @classmethod
    def number(cls, x: Any) -> Polynomial:
        """The constant polynomial of a number, exact for integers and fractions."""
        exact = x if isinstance(x, Fraction) or x != int(x) else Fraction(int(x))
        return cls({(): exact} if exact else {})

    @property
    def constant(self) -> float | None:
        """Value of a constant polynomial, else None."""
        return float(self.terms.get((), 0)) if self.terms.keys() <= {()} else None

    @property
    def formula(self) -> Formula:
        """The polynomial as a formula; raises `FormulaError` if it exceeds the length limit."""
        return Formula.parse(self.text)

    @property
    def text(self) -> str:
        """Text of the polynomial, positive terms first, each in the order of names: equal polynomials have equal texts.

        Products of tiny numbers that no cell may hold are zero.
        """
        written = (term for term in self.terms.items() if abs(term[1]) >= SMALLEST)
        ordered = sorted(written, key=lambda term: (term[1] < 0, term[0]))
        signed_terms = " ".join(("- " if x < 0 else "+ ") + _term(abs(x), factors) for factors, x in ordered)
        return signed_terms.removeprefix("+ ").replace("- ", "-", signed_terms.startswith("- ")) or "0"

    def without_rounding(self, least: float) -> Polynomial:
        """The polynomial without rounding errors: an inexact constant up to `least`, coefficients up to `ROUNDING`."""
        terms = self.terms.items()
        return Polynomial(
            {key: x for key, x in terms if isinstance(x, Fraction) or abs(x) > (ROUNDING if key else least)}
        )

    def __add__(self, other: Any) -> Polynomial:
        sums = dict(self.terms)
        for factors, x in _polynomial(other).terms.items():
            total = (before := sums.get(factors, Fraction(0))) + x
            least = 0 if isinstance(total, Fraction) else ROUNDING * max(abs(before), abs(x))
            sums[factors] = total if abs(total) > least else 0
        if len(sums) > MOST_TERMS:
            raise FormulaError(f"a sum of more than {MOST_TERMS} terms")
        return Polynomial({factors: x for factors, x in sums.items() if x})

    __radd__ = __add__

    def __neg__(self) -> Polynomial:
        return Polynomial({factors: -x for factors, x in self.terms.items()})

    def __sub__(self, other: Any) -> Polynomial:
        return self + -_polynomial(other)

    def __rsub__(self, other: Any) -> Polynomial:
        return _polynomial(other) + -self

    def __mul__(self, other: Any) -> Polynomial:
        product, by = Polynomial(), _polynomial(other).terms
        for factors, x in self.terms.items():
            product += Polynomial({tuple(sorted((*factors, *others))): x * y for others, y in by.items()})
        return product

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Polynomial:
        below = _polynomial(other)
        if below.terms.keys() == {()}:
            return self * Polynomial({(): 1 / below.terms[()]})
        return self * Polynomial({(f"(1/({below.text}))",): Fraction(1)})


def _polynomial(x: Any) -> Polynomial:
    return x if isinstance(x, Polynomial) else Polynomial.number(x)


def _function(name: str) -> Any:
    def value(*arguments: Polynomial) -> Polynomial:
        text = f"{name}({', '.join(x.text for x in arguments)})"
        is_number = all(x.constant is not None for x in arguments)
        return Polynomial.number(Formula.parse(text).value()) if is_number else Polynomial({(text,): Fraction(1)})

    return value


def _term(x: Any, factors: Product) -> str:
    """Text of a product; a number is a decimal of 15 digits or of its exact value, else a quotient."""
    product, number = "*".join(factors), f"{float(x):.15g}"
    if isinstance(x, Fraction):
        if factors and x.numerator == 1:
            return f"{product}/{x.denominator}" if x != 1 else product
        number = number if Fraction(number) == x else str(x)
    elif abs(float(number) - x) > ROUNDING * x / 16:
        number = repr(float(x))
    return (product if number == "1" else f"{number}*{product}") if factors else number


def vector_of(cells: Iterable[Formula | float | Polynomial]) -> Any:
    """The array (n,) of the polynomials of formulas, or numbers."""
    return np.array([Polynomial.of(x) if isinstance(x, Formula) else _polynomial(x) for x in cells], dtype=object)


def direction_and_length(vector: Array) -> tuple[Array, Any] | None:
    """Split a vector into numbers (n,) and a common factor; None if its entries have no common formula.

    The factor is 1 where the vector is numbers.
    """
    if vector.dtype != object:
        return vector, 1.0
    entries = [_polynomial(x) for x in vector]
    if all(x.constant is not None for x in entries):
        return np.array([x.constant for x in entries]), 1.0
    unit = next(x for x in entries if x.terms)
    factors, first = next(iter(unit.terms.items()))
    unit = unit if first > 0 else -unit
    ratios = [x.terms.get(factors, Fraction(0)) / abs(first) for x in entries]
    if any((x - unit * Polynomial.number(ratio)).terms for x, ratio in zip(entries, ratios, strict=True)):
        return None
    return np.array([*map(float, ratios)]), unit
