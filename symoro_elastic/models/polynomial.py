"""Polynomials over names, for formulas that people read: sums of products, written out as in the books."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from fractions import Fraction

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, Library
from symoro_elastic.symbolic.expression import Constant, exact
from symoro_elastic.symbolic.operations import COS, COSPI, PI

Monomial = tuple[str, ...]
"""Its factors in order, repeated where they are powers: names and functions, as they are written."""
ONE: Monomial = ()
MAX_DIGITS = 17


class Polynomial:
    """Exact coefficients of monomials."""

    __slots__ = ("terms",)

    def __init__(self, terms: Mapping[Monomial, Fraction]) -> None:
        self.terms = {monomial: x for monomial, x in terms.items() if x}

    @classmethod
    def factor(cls, text: str) -> Polynomial:
        """A name, a function, or anything else that can stand as a factor."""
        return cls({(text,): Fraction(1)})

    @classmethod
    def of(cls, x: Polynomial | Constant) -> Polynomial:
        """A constant as a polynomial."""
        return x if isinstance(x, Polynomial) else cls({ONE: Fraction(x)})

    def __add__(self, other: Scalar) -> Polynomial:
        right = _polynomial(other)
        if right is None:
            return NotImplemented
        terms = dict(self.terms)
        for monomial, x in right.terms.items():
            terms[monomial] = terms.get(monomial, Fraction(0)) + x
        return Polynomial(terms)

    def __mul__(self, other: Scalar) -> Polynomial:
        right = _polynomial(other)
        if right is None:
            return NotImplemented
        terms: dict[Monomial, Fraction] = {}
        for first, x in self.terms.items():
            for second, y in right.terms.items():
                monomial = tuple(sorted((*first, *second)))
                terms[monomial] = terms.get(monomial, Fraction(0)) + x * y
        return Polynomial(terms)

    def __neg__(self) -> Polynomial:
        return self * -1

    def __sub__(self, other: Scalar) -> Polynomial:
        right = _polynomial(other)
        return NotImplemented if right is None else self + -right

    def __truediv__(self, other: Scalar) -> Polynomial:
        divisor = _polynomial(other)
        if divisor is None:
            return NotImplemented
        if set(divisor.terms) == {ONE}:
            return self * (1 / divisor.terms[ONE])
        if self.terms == divisor.terms:
            return Polynomial.of(1)
        return self * Polynomial.factor(f"(1/({polynomial_text(divisor)}))")

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Scalar) -> Polynomial:
        left = _polynomial(other)
        return NotImplemented if left is None else left - self

    def __rtruediv__(self, other: Scalar) -> Polynomial:
        left = _polynomial(other)
        return NotImplemented if left is None else left / self

    def __bool__(self) -> bool:
        return bool(self.terms)


def _polynomial(x: Scalar) -> Polynomial | None:
    """A polynomial or an exact constant as one; None for anything else."""
    if isinstance(x, Polynomial):
        return x
    constant = exact(x)
    return None if constant is None else Polynomial.of(constant)


def polynomial_text(p: Polynomial, sources: Collection[str] = ()) -> str:
    """The text of a polynomial, in the grammar of machine files.

    What multiplies one product of other factors is put in brackets where it is linear in `sources`:
    `D4^2*(M4 + M5 + M6)`.
    """
    groups: dict[Monomial, dict[Monomial, Fraction]] = {}
    for monomial, x in p.terms.items():
        outer = tuple(name for name in monomial if name not in sources)
        inner = tuple(name for name in monomial if name in sources)
        groups.setdefault(outer, {})[inner] = x
    terms = [term for outer, inner in groups.items() for term in _group(outer, inner)]
    return _sum(terms)


def _group(outer: Monomial, inner: dict[Monomial, Fraction]) -> list[tuple[Fraction, str]]:
    """Terms with one outer factor: one bracket where there are several and the factor is not 1."""
    if outer == ONE or len(inner) == 1:
        return [(x, "*".join(_powers((*outer, *monomial), x))) for monomial, x in inner.items()]
    first = next(iter(inner.values()))
    common = first if len({abs(x) for x in inner.values()}) == 1 else Fraction(1 if first > 0 else -1)
    bracket = _sum([(x / common, "*".join(_powers(monomial, x / common))) for monomial, x in inner.items()])
    return [(common, "*".join([*_powers(outer, common), f"({bracket})"]))]


def _powers(monomial: Monomial, coefficient: Fraction) -> list[str]:
    """Factors of a term without its sign, powers written as such."""
    size = abs(coefficient)
    times = [(name, monomial.count(name)) for name in dict.fromkeys(monomial)]
    factors = [name if n == 1 else f"{name}^{n}" for name, n in times]
    return factors if size == 1 and factors else [_number(size), *factors]


def _sum(terms: list[tuple[Fraction, str]]) -> str:
    text = "".join(f" {'+' if x > 0 else '-'} {term}" for x, term in terms)
    return "0" if not terms else text[3:] if text.startswith(" + ") else f"-{text[3:]}"


def _number(x: Fraction) -> str:
    """A positive number: a fraction or a decimal, rounded to a double where it is long."""
    if x.denominator == 1 and len(str(x)) <= MAX_DIGITS:
        return str(x)
    short = repr(float(x))
    if Fraction(short) == x or len(str(x)) > MAX_DIGITS:
        return short
    return str(x)


def _function(name: str) -> Callable[..., Polynomial]:
    return lambda *operands: Polynomial.factor(f"{name}({', '.join(map(polynomial_text, operands))})")


POLYNOMIALS: Arithmetic[Polynomial] = Arithmetic(
    Polynomial.of,
    Library(
        _function,
        {PI: lambda: Polynomial.factor("pi"), COSPI: lambda halves: _function(COS)(halves * Polynomial.factor("pi"))},
    ),
)
