"""Values of expressions: in double precision, in high precision, modulo a prime, or as other expressions."""

from __future__ import annotations

import math
import operator
import random
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial
from typing import Any, Generic, TypeVar

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Constant, Expression, Graph, Operand, quotient, reachable
from symoro_elastic.symbolic.finite_field import Point, Residue, circle_of_pi, circle_of_radians, random_radians

RATIONAL: op.Functions = {
    op.ADD: operator.add,
    op.SUBTRACT: operator.sub,
    op.MULTIPLY: operator.mul,
    op.DIVIDE: operator.truediv,
    op.NEGATE: operator.neg,
}
"""The operations that are operators of Python for all numbers."""


EXACT: op.Functions = {**RATIONAL, op.DIVIDE: quotient}
"""Operations of expressions and exact constants: the quotient of two integers is not a float."""


class Library(dict[str, Callable[..., op.Value]]):
    """Operations by name: the operators of Python, its `own` functions, and those that `find` returns by name."""

    def __init__(self, find: Callable[[str], Callable[..., op.Value]], own: op.Functions | None = None) -> None:
        super().__init__({**RATIONAL, **(own or {})})
        self._find = find

    def __missing__(self, operation: str) -> Callable[..., op.Value]:
        self[operation] = found = self._find(operation)
        return found


def library(module: Any, own: op.Functions | None = None) -> Library:
    """The functions of a module, or of anything else that has them as attributes."""
    return Library(partial(getattr, module), own)


Number = TypeVar("Number")


@dataclass(frozen=True)
class Arithmetic(Generic[Number]):
    """Conversion of exact rationals to numbers, and operations by name."""

    number: Callable[[Constant], Number]
    operations: op.Functions


def evaluate(
    roots: Iterable[Scalar],
    symbols: Mapping[str, Number],
    arithmetic: Arithmetic[Number],
    known_values: Mapping[int, Number] | None = None,
) -> Callable[[Scalar], Number]:
    """A function that returns the value of a root; `symbols` holds the values of the variables.

    `known_values` are values of nodes, by number, that are not computed.
    """
    return evaluate_nodes(reachable(roots), symbols, arithmetic, known_values)


def evaluate_nodes(
    nodes: Iterable[Expression],
    symbols: Mapping[str, Number],
    arithmetic: Arithmetic[Number],
    known_values: Mapping[int, Number] | None = None,
) -> Callable[[Scalar], Number]:
    """A function that returns the value of a node; `nodes` are in order, operands before users, as by `reachable`."""
    values, number, operations = dict(known_values or {}), arithmetic.number, arithmetic.operations
    for node in nodes:
        if node.id in values:
            continue
        if node.operation == op.SYMBOL:
            values[node.id] = symbols[node.operands[0]]
        elif len(node.operands) == 2:  # most nodes: written out, they take half of the time
            x, y = node.operands
            first = values[x.id] if type(x) is Expression else number(x)
            values[node.id] = operations[node.operation](first, values[y.id] if type(y) is Expression else number(y))
        else:
            operands = [values[x.id] if type(x) is Expression else number(x) for x in node.operands]
            values[node.id] = operations[node.operation](*operands)

    def value(x: op.Value) -> Number:
        return values[x.id] if type(x) is Expression else number(x)

    return value


def sign(x: op.Value) -> op.Value:
    """-1, 0 or 1, and NaN for NaN."""
    return 1 if x > 0 else -1 if x < 0 else x


def minimum(x: op.Value, y: op.Value) -> op.Value:
    """The lesser number; NaN where one is NaN."""
    return x if x < y else y if x >= y else x + y


def maximum(x: op.Value, y: op.Value) -> op.Value:
    """The larger number; NaN where one is NaN."""
    return x if x > y else y if x <= y else x + y


ORDERED: op.Functions = {op.SIGN: sign, op.MINIMUM: minimum, op.MAXIMUM: maximum}
"""Operations on numbers that can be compared."""


def _root(x: float) -> float:
    return math.nan if x < 0 else math.sqrt(x)


FLOATS: Arithmetic[float] = Arithmetic(
    float, library(math, {**ORDERED, op.SQRT: _root, op.PI: lambda: math.pi, op.COSPI: lambda x: math.cos(math.pi * x)})
)
"""Double precision; the root of a negative number is NaN."""


@cache
def multiprecision(digits: int = 50) -> Arithmetic[op.Value]:
    """Arithmetic with this many decimal digits; the root of a negative number is NaN."""
    import mpmath

    context = mpmath.MPContext()
    context.dps = digits

    def number(x: Constant | float) -> op.Value:
        if isinstance(x, float):
            return context.mpf(x)
        return context.mpf(Fraction(x).numerator) / Fraction(x).denominator

    def root(x: op.Value) -> op.Value:
        return context.nan if x < 0 else context.sqrt(x)

    return Arithmetic(number, library(context, {**ORDERED, op.SQRT: root, op.PI: lambda: +context.pi}))


def nodes(graph: Graph, own: op.Functions | None = None) -> Arithmetic[Operand]:
    """Arithmetic that builds expressions of a graph."""
    return Arithmetic(lambda x: x, Library(lambda operation: partial(graph.node, operation), {**EXACT, **(own or {})}))


class ModularAngles:
    """Values of expressions modulo a prime at random values of their variables.

    Variables that occur as angles are random points of the circle. An operation that is not rational has a random
    value for each of its operands.
    """

    def __init__(self, seed: int) -> None:
        self._source = random.Random(seed)
        self._angles: dict[int, Fraction] = {}
        self._points: dict[Operand, Point] = {}
        self._random: dict[int, int] = {}

    def values(self, roots: Iterable[Scalar]) -> Callable[[Scalar], Residue]:
        """A function that returns the residue of a root."""
        values: dict[int, Residue] = {}

        def value(x: op.Value) -> Residue:
            return values[x.id] if type(x) is Expression else Residue(x)

        for node in reachable(roots):
            if node.operation in RATIONAL:
                values[node.id] = RATIONAL[node.operation](*map(value, node.operands))
            elif node.operation in (op.SIN, op.COS):
                values[node.id] = Residue(self._point(node.operands[0])[node.operation == op.SIN])
            elif node.operation == op.COSPI:
                values[node.id] = Residue(circle_of_pi(node.operands[0])[0])
            else:
                values[node.id] = Residue(self._number(node))
        return value

    def _point(self, angle: Operand) -> Point:
        if angle not in self._points:
            self._points[angle] = circle_of_radians(self._radians(angle))
        return self._points[angle]

    def _radians(self, angle: Operand) -> Fraction:
        if not isinstance(angle, Expression):
            return Fraction(angle)
        if angle.operation == op.MULTIPLY and not isinstance(angle.operands[1], Expression):
            return self._angle(angle.operands[0]) * Fraction(angle.operands[1])
        return self._angle(angle)

    def _angle(self, node: Expression) -> Fraction:
        if node.id not in self._angles:
            self._angles[node.id] = random_radians(self._source)
        return self._angles[node.id]

    def _number(self, node: Expression) -> int:
        if node.id not in self._random:
            self._random[node.id] = self._source.randrange(1, 1 << 60)
        return self._random[node.id]
