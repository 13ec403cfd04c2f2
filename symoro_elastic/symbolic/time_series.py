"""Expressions as functions of time: coefficients x_k of x(t) = sum of x_k t^k, so that x_k is x^(k) / k!.

A single pass over the nodes of a graph computes, from the coefficients of its variables, those of everything they
make: a product is a convolution, a quotient and a square root solve one, sine, cosine and the angle of a
point follow from their differential equations. Coefficients of the order k need k operations, not 2^k as derivatives of
derivatives do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Expression, Graph, Level, Operand, operand, quotient, reachable
from symoro_elastic.symbolic.functions import maximum, minimum, sign

VariableCoefficient: TypeAlias = Callable[[int], Scalar]
"""Coefficient k of a variable."""
Coefficient: TypeAlias = Callable[[int], Operand]
"""Coefficient k of an expression."""
Coefficients: TypeAlias = Sequence[Operand]


class TimeSeries:
    """Taylor coefficients in time of expressions, from those of their variables; other symbols are constant.

    The sign of a velocity is taken to be constant. Shared nodes are followed once, as far as they are needed.
    """

    def __init__(self, variables: Mapping[str, VariableCoefficient]) -> None:
        self.variables = variables
        self.found: dict[int, list[Operand]] = {}
        self._circles: dict[int, tuple[list[Operand], list[Operand]]] = {}

    def of(self, x: Scalar, order: int) -> list[Operand]:
        """Coefficients 0 to `order` of an expression."""
        for node in reachable([x]):
            if node.level is Level.STATE:
                coefficients = self.found.setdefault(node.id, [])
                while len(coefficients) <= order:
                    coefficients.append(self._next(node, len(coefficients), coefficients))
        return [self._coefficients(operand(x))(k) for k in range(order + 1)]

    def _coefficients(self, x: Operand) -> Coefficient:
        if isinstance(x, Expression) and x.level is Level.STATE:
            return self.found[x.id].__getitem__
        return lambda k: 0 if k else x

    def _next(self, node: Expression, k: int, known: Coefficients) -> Operand:
        """Coefficient k of a node, from those of its operands."""
        if node.operation == op.SYMBOL:
            return operand(self.variables[node.operands[0]](k))
        if node.operation in (op.SIN, op.COS):
            return self._on_circle(node.operands[0], k)[node.operation == op.SIN]
        if node.operation == op.MULTIPLY and node.operands[0] is node.operands[1]:
            return _square(k, self._coefficients(node.operands[0]))
        return RECURRENCES[node.operation](node.graph, k, known, *map(self._coefficients, node.operands))

    def _on_circle(self, angle: Expression, k: int) -> tuple[Operand, Operand]:
        """Coefficient k of cosine and sine: c' = -s x', s' = c x'."""
        cosine, sine = self._circles.setdefault(angle.id, ([], []))
        x = self._coefficients(angle)
        if not cosine:
            start = x(0)
            cosine.append(_function(op.COS, start))
            sine.append(_function(op.SIN, start))
        while len(cosine) <= k:
            n = len(cosine)
            rates = [i * x(i) for i in range(n + 1)]
            turned = [_total(rates[i] * point[n - i] for i in range(1, n + 1)) for point in (sine, cosine)]
            cosine.append(-(turned[0] * Fraction(1, n)))
            sine.append(turned[1] * Fraction(1, n))
        return cosine[k], sine[k]


def _function(operation: str, x: Operand) -> Operand:
    """Sine or cosine with the sign of the angle taken out; an angle that is a plain number can only be 0."""
    if isinstance(x, Expression) and x.operation == op.NEGATE:
        inner = x.graph.node(operation, x.operands[0])
        return -inner if operation == op.SIN else inner
    return x.graph.node(operation, x) if isinstance(x, Expression) else int(operation == op.COS)


def _total(terms: Iterable[Operand]) -> Operand:
    total: Operand = 0
    for term in terms:
        total = total + term
    return total


def _product(graph: Graph, k: int, known: Coefficients, x: Coefficient, y: Coefficient) -> Operand:
    return _total(x(i) * y(k - i) for i in range(k + 1))


def _square(k: int, x: Coefficient) -> Operand:
    """Coefficient k of a square: each product of two different coefficients occurs twice."""
    twice = 2 * _total(x(i) * x(k - i) for i in range((k + 1) // 2))
    return twice if k % 2 else twice + x(k // 2) * x(k // 2)


def _quotient(graph: Graph, k: int, known: Coefficients, x: Coefficient, y: Coefficient) -> Operand:
    """Coefficient k of the quotient z = x / y, from y z = x."""
    remainder = x(k) - _total(y(i) * known[k - i] for i in range(1, k + 1))
    return quotient(remainder, y(0))


def _root(graph: Graph, k: int, known: Coefficients, x: Coefficient) -> Operand:
    """Coefficient k of the square root z of x, from z z = x."""
    if k == 0:
        return graph.node(op.SQRT, x(0))
    remainder = x(k) - _total(known[i] * known[k - i] for i in range(1, k))
    return quotient(remainder, 2 * known[0])


def _angle(graph: Graph, k: int, known: Coefficients, y: Coefficient, x: Coefficient) -> Operand:
    """Coefficient k of z = atan2(y, x), from (x x + y y) z' = x y' - y x'."""
    if k == 0:
        return graph.node(op.ATAN2, y(0), x(0))
    turned = _total(i * (x(k - i) * y(i) - y(k - i) * x(i)) for i in range(1, k + 1))
    remainder = turned - _total(i * known[i] * (_square(k - i, x) + _square(k - i, y)) for i in range(1, k))
    return quotient(remainder, k * (_square(0, x) + _square(0, y)))


def _by_side(side: Operand, first: Operand, second: Operand) -> Operand:
    """The first value where the side is -1, the second where it is 1, their mean where it is 0."""
    return operand(((1 - side) * first + (1 + side) * second) * Fraction(1, 2))


def _lesser(graph: Graph, k: int, _: Coefficients, x: Coefficient, y: Coefficient) -> Operand:
    return _by_side(sign(graph, x(0) - y(0)), x(k), y(k)) if k else minimum(graph, x(0), y(0))


def _greater(graph: Graph, k: int, _: Coefficients, x: Coefficient, y: Coefficient) -> Operand:
    return _by_side(sign(graph, x(0) - y(0)), y(k), x(k)) if k else maximum(graph, x(0), y(0))


RECURRENCES: Mapping[str, Callable[..., Operand]] = {
    op.ADD: lambda graph, k, known, x, y: x(k) + y(k),
    op.SUBTRACT: lambda graph, k, known, x, y: x(k) - y(k),
    op.NEGATE: lambda graph, k, known, x: -x(k),
    op.MULTIPLY: _product,
    op.DIVIDE: _quotient,
    op.SQRT: _root,
    op.ATAN2: _angle,
    op.SIGN: lambda graph, k, known, x: 0 if k else graph.node(op.SIGN, x(0)),
    op.MINIMUM: _lesser,
    op.MAXIMUM: _greater,
}
"""Coefficient k of operations from earlier ones and those of their operands; sine and cosine are computed together."""
