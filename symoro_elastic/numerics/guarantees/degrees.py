"""Degrees by syntax: of an expression as a trigonometric polynomial of angles and a polynomial of all else.

A sine or cosine of k q + ... has the trigonometric degree |k| in q; a product has the sum of its factors' degrees, a
sum the largest of its terms'. The true degree is that or less: what cancels is not seen. Expressions that are no such
polynomial are refused: those with a quotient, a root, a sign or an arc tangent of what depends on the state, and those
in which a variable occurs inside of a sine and outside of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, Library, evaluate_nodes
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import ATAN2, COS, COSPI, MAXIMUM, MINIMUM, PI, SIGN, SIN, SQRT, SYMBOL


class NotPolynomial(Exception):
    """An expression is no polynomial of sines, cosines and other variables; the message says why."""


@dataclass(frozen=True)
class Degrees:
    """Of an expression: trigonometric degree by angle, degree by other variable; its variables are their names.

    `multiples` are the factors of variables where the expression is a sum of multiples of them and of a constant,
    `number` is its value where it is a rational number.
    """

    angles: Mapping[str, int] = field(default_factory=dict)
    powers: Mapping[str, int] = field(default_factory=dict)
    multiples: Mapping[str, Fraction] | None = None
    number: Fraction | None = None

    @property
    def is_constant(self) -> bool:
        """Whether it depends on no variable."""
        return not self.angles and not self.powers

    def __add__(self, other: Degrees) -> Degrees:
        return self._sum(other, 1)

    def __sub__(self, other: Degrees) -> Degrees:
        return self._sum(other, -1)

    def __neg__(self) -> Degrees:
        return self._times(Fraction(-1))

    def __mul__(self, other: Degrees) -> Degrees:
        if self.number is not None:
            return other._times(self.number)
        if other.number is not None:
            return self._times(other.number)
        constant: dict[str, Fraction] | None = {} if self.is_constant and other.is_constant else None
        return Degrees(_added(self.angles, other.angles), _added(self.powers, other.powers), constant)

    def __truediv__(self, other: Degrees) -> Degrees:
        if not other.is_constant:
            raise NotPolynomial(f"a quotient by what depends on {', '.join(other.variables)}")
        return (
            self._times(1 / other.number) if other.number else replace(self, multiples={} if self.is_constant else None)
        )

    @property
    def variables(self) -> list[str]:
        """Names of all variables that it depends on."""
        return sorted({*self.angles, *self.powers})

    def _times(self, factor: Fraction) -> Degrees:
        multiples = None if self.multiples is None else {name: factor * x for name, x in self.multiples.items()}
        return Degrees(self.angles, self.powers, multiples, None if self.number is None else factor * self.number)

    def _sum(self, other: Degrees, sense: int) -> Degrees:
        multiples = None
        if self.multiples is not None and other.multiples is not None:
            names, zero = {*self.multiples, *other.multiples}, Fraction(0)
            multiples = {x: self.multiples.get(x, zero) + sense * other.multiples.get(x, zero) for x in names}
        number = None if self.number is None or other.number is None else self.number + sense * other.number
        return Degrees(_largest(self.angles, other.angles), _largest(self.powers, other.powers), multiples, number)


def degrees(roots: Iterable[Scalar], numbers: Iterable[str] = ()) -> list[Degrees]:
    """Return the degrees of expressions; variables in `numbers` are constants. Raises `NotPolynomial`."""
    roots, constants = list(roots), frozenset(numbers)
    nodes = reachable(roots)
    names = [node.operands[0] for node in nodes if node.operation == SYMBOL]
    value = evaluate_nodes(nodes, {name: _symbol(name, name in constants) for name in names}, _ARITHMETIC)
    found = [value(root) for root in roots]
    for one in found:
        if both := sorted(one.angles.keys() & one.powers.keys()):
            raise NotPolynomial(f"{both[0]} occurs inside of a sine or cosine and outside of it")
    return found


def _symbol(name: str, constant: bool) -> Degrees:
    return Degrees(multiples={}) if constant else Degrees({}, {name: 1}, {name: Fraction(1)})


def _circular(x: Degrees) -> Degrees:
    if x.multiples is None:
        raise NotPolynomial(f"a sine or cosine of more than a sum of multiples of {', '.join(x.variables)}")
    for name, factor in sorted(x.multiples.items()):
        if factor.denominator != 1:
            raise NotPolynomial(f"a sine or cosine of {factor} {name}")
    return Degrees({name: abs(int(factor)) for name, factor in x.multiples.items() if factor}, multiples=_constant(x))


def _constant(x: Degrees) -> dict[str, Fraction] | None:
    return {} if x.is_constant else None


def _function(name: str) -> Callable[..., Degrees]:
    def of_constants(*operands: Degrees) -> Degrees:
        for x in operands:
            if not x.is_constant:
                raise NotPolynomial(f"{name} of what depends on {', '.join(x.variables)}")
        return Degrees(multiples={})

    return of_constants


def _added(x: Mapping[str, int], y: Mapping[str, int]) -> Mapping[str, int]:
    return {name: x.get(name, 0) + y.get(name, 0) for name in {*x, *y}} if x and y else x or y


def _largest(x: Mapping[str, int], y: Mapping[str, int]) -> Mapping[str, int]:
    return {name: max(x.get(name, 0), y.get(name, 0)) for name in {*x, *y}} if x and y else x or y


_FUNCTIONS = {
    SIN: _circular,
    COS: _circular,
    PI: _function("pi"),
    COSPI: _function("a cosine"),
    SQRT: _function("a square root"),
    SIGN: _function("a sign"),
    ATAN2: _function("an arc tangent"),
    MINIMUM: _function("a minimum"),
    MAXIMUM: _function("a maximum"),
}
_ARITHMETIC: Arithmetic[Degrees] = Arithmetic(
    lambda x: Degrees(multiples={}, number=Fraction(x)), Library(_function, _FUNCTIONS)
)
