"""Sines and cosines of sums of angles, in place of the products that make them.

Consecutive joints with parallel axes give cos a cos b - sin a sin b where cos(a + b) would do. The sum is rounded: far
from zero, where an ulp of an angle is large, that costs digits that the products keep.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias, TypeGuard

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate, nodes
from symoro_elastic.symbolic.expression import Expression, Graph, Level, Operand, reachable
from symoro_elastic.symbolic.functions import arc_tangent, maximum, minimum, sign, square_root

CircularProduct: TypeAlias = tuple[str, Expression, str, Expression]
"""A product of sines and cosines as (function, angle, function, angle), cosines first."""


def with_angle_sums(graph: Graph, roots: Iterable[Scalar]) -> Callable[[Scalar], Operand]:
    """New values of the expressions that the roots need, with sums of angles for products where they apply.

    Angles that depend on the state are added; sums are added further.
    """
    roots = list(roots)
    symbols: dict[str, Operand] = {node.operands[0]: node for node in reachable(roots) if node.operation == op.SYMBOL}
    return evaluate(roots, symbols, _arithmetic(graph))


def _arithmetic(graph: Graph) -> Arithmetic[Operand]:
    """Arithmetic that rebuilds expressions."""

    def add(x: Operand, y: Operand) -> Operand:
        total = _by_addition_theorem(graph, x, y, 1)
        return x + y if total is None else total

    def subtract(x: Operand, y: Operand) -> Operand:
        difference = _by_addition_theorem(graph, x, y, -1)
        return x - y if difference is None else difference

    anew: dict[str, Callable[..., Operand]] = {
        op.ADD: add,
        op.SUBTRACT: subtract,
        op.SIN: lambda x: _sine(graph, x),
        op.COS: lambda x: _cosine(graph, x),
        op.SQRT: lambda x: square_root(graph, x),
        op.SIGN: lambda x: sign(graph, x),
        op.MINIMUM: lambda x, y: minimum(graph, x, y),
        op.MAXIMUM: lambda x, y: maximum(graph, x, y),
        op.ATAN2: lambda y, x: arc_tangent(graph, y, x),
    }
    return nodes(graph, anew)


def _by_addition_theorem(graph: Graph, x: Operand, y: Operand, sense: int) -> Operand | None:
    """x + y, or x - y, by the addition theorem; None where it does not apply."""
    if _is_negative(y):
        return _by_addition_theorem(graph, x, y.operands[0], -sense)
    if _is_negative(x):
        negative = _by_addition_theorem(graph, x.operands[0], y, -sense)
        return None if negative is None else -negative
    first, second = _product(x), _product(y)
    if first is None or second is None:
        return None
    (f, a, g, b), (h, c, k, d) = first, second
    if (f, g, h, k) == (op.COS, op.SIN, op.COS, op.SIN) and (a, b) == (d, c):
        return _sine(graph, b + a if sense > 0 else b - a)
    if {a.id, b.id} != {c.id, d.id}:
        return None
    if (f, g, h, k) == (op.COS, op.COS, op.SIN, op.SIN):
        return _cosine(graph, a - b if sense > 0 else a + b)
    if (f, g, h, k) == (op.SIN, op.SIN, op.COS, op.COS):
        return _cosine(graph, a - b) if sense > 0 else -_cosine(graph, a + b)
    return None


def _is_negative(x: Operand) -> TypeGuard[Expression]:
    return isinstance(x, Expression) and x.operation == op.NEGATE


def _product(x: Operand) -> CircularProduct | None:
    if not isinstance(x, Expression) or x.operation != op.MULTIPLY or x.level != Level.STATE:
        return None
    factors = sorted((factor for factor in x.operands if _is_circular(factor)), key=lambda factor: factor.operation)
    if len(factors) != 2:
        return None
    first, second = factors
    return first.operation, first.operands[0], second.operation, second.operands[0]


def _is_circular(x: Operand) -> TypeGuard[Expression]:
    return isinstance(x, Expression) and x.operation in (op.SIN, op.COS) and x.level == Level.STATE


def _sine(graph: Graph, angle: Operand) -> Operand:
    if not isinstance(angle, Expression):
        return graph.node(op.SIN, angle) if angle else 0
    return -graph.node(op.SIN, angle.operands[0]) if angle.operation == op.NEGATE else graph.node(op.SIN, angle)


def _cosine(graph: Graph, angle: Operand) -> Operand:
    if not isinstance(angle, Expression):
        return graph.node(op.COS, angle) if angle else 1
    return graph.node(op.COS, angle.operands[0] if angle.operation == op.NEGATE else angle)
