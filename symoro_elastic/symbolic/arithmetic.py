"""Values of expressions: in double precision, in high precision, modulo a prime."""

from __future__ import annotations

import math
import operator
import random
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from symoro_elastic.symbolic.expression import ATAN2, COS, COSPI, PI, SIGN, SIN, SQRT, SYMBOL, Expression, reachable

Operations = Mapping[str, Callable[..., Any]]
RATIONAL: Operations = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "neg": operator.neg,
}


@dataclass(frozen=True)
class Arithmetic:
    """How to make a number of an exact rational, and what each operation does."""

    number: Callable[[Fraction | int], Any]
    operations: Operations


def evaluate(
    roots: Iterable[Any], symbols: Mapping[str, Any], arithmetic: Arithmetic, known: Mapping[int, Any] | None = None
) -> Callable[[Any], Any]:
    """A function giving the value of each root; `symbols` holds the values of the variables.

    `known` holds values of nodes, by number, that are not to be computed.
    """
    roots = list(roots)
    values = dict(known or {})

    def value(x: Any) -> Any:
        return values[x.id] if isinstance(x, Expression) else arithmetic.number(x)

    for node in reachable(roots):
        if node.id in values:
            continue
        if node.operation == SYMBOL:
            values[node.id] = symbols[node.operands[0]]
        else:
            values[node.id] = arithmetic.operations[node.operation](*map(value, node.operands))
    return value


def sign(x: Any) -> Any:
    """-1, 0 or 1, and NaN for NaN."""
    return 1 if x > 0 else -1 if x < 0 else x


FLOATS = Arithmetic(
    float,
    {
        **RATIONAL,
        SIN: math.sin,
        COS: math.cos,
        SQRT: math.sqrt,
        SIGN: sign,
        ATAN2: math.atan2,
        PI: lambda: math.pi,
        COSPI: lambda x: math.cos(math.pi * x),
    },
)


@cache
def multiprecision(digits: int = 50) -> Arithmetic:
    """Arithmetic with this many decimal digits."""
    import mpmath

    context = mpmath.MPContext()
    context.dps = digits

    def number(x: Fraction | int | float) -> Any:
        if isinstance(x, float):
            return context.mpf(x)
        return context.mpf(Fraction(x).numerator) / Fraction(x).denominator

    return Arithmetic(
        number,
        {
            **RATIONAL,
            SIN: context.sin,
            COS: context.cos,
            SQRT: context.sqrt,
            SIGN: sign,
            ATAN2: context.atan2,
            PI: lambda: +context.pi,
            COSPI: context.cospi,
        },
    )


@cache
def constant_value(node: Expression) -> float:
    """Double nearest to a constant expression."""
    return float(evaluate([node], {}, multiprecision(60))(node))


class ModularAngles:
    """Values of expressions modulo a prime at random values of their variables.

    Variables that occur as angles are random points of the circle.
    """

    def __init__(self, seed: int) -> None:
        self._source = random.Random(seed)
        self._angles: dict[int, Fraction] = {}
        self._symbols: dict[int, Any] = {}

    def values(self, roots: Iterable[Any]) -> Callable[[Any], Any]:
        """A function giving the residue of each root."""
        from symoro_elastic.symbolic.finite_field import Residue, circle_of_pi

        values: dict[int, Any] = {}

        def value(x: Any) -> Any:
            return values[x.id] if isinstance(x, Expression) else Residue(x)

        for node in reachable(roots):
            if node.operation in RATIONAL:
                values[node.id] = RATIONAL[node.operation](*map(value, node.operands))
            elif node.operation in (SIN, COS):
                values[node.id] = Residue(self._point(node.operands[0])[node.operation == SIN])
            elif node.operation == COSPI:
                values[node.id] = Residue(circle_of_pi(node.operands[0])[0])
            else:
                values[node.id] = Residue(self._random(node))
        return value

    def _point(self, angle: Expression | Fraction) -> tuple[int, int]:
        from symoro_elastic.symbolic.finite_field import circle_of_radians

        if not isinstance(angle, Expression):
            return circle_of_radians(Fraction(angle))
        if angle.operation == "*" and not isinstance(angle.operands[1], Expression):
            return circle_of_radians(self._angle(angle.operands[0]) * angle.operands[1])
        return circle_of_radians(self._angle(angle))

    def _angle(self, node: Expression) -> Fraction:
        from symoro_elastic.symbolic.finite_field import random_radians

        return self._angles.setdefault(node.id, random_radians(self._source))

    def _random(self, node: Expression) -> int:
        return int(self._symbols.setdefault(node.id, self._source.randrange(1, 1 << 60)))
