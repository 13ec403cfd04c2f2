"""Sines and cosines of sums of angles, in place of the products that make them.

Consecutive joints with parallel axes give cos a cos b - sin a sin b where cos(a + b) would do. The sum is rounded: far
from zero, where an ulp of an angle is large, that costs digits that the products keep.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeAlias, TypeGuard

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate, nodes
from symoro_elastic.symbolic.expression import Expression, Graph, Level, Operand, reachable
from symoro_elastic.symbolic.functions import arc_tangent, maximum, minimum, sign, square_root
from symoro_elastic.symbolic.operations import (
    ADD,
    ATAN2,
    COS,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    SIGN,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
)

CircularProduct: TypeAlias = tuple[str, Expression, str, Expression]
"""A product of two of sine and cosine: which, of which angle; cosines first."""


def with_angle_sums(graph: Graph, roots: Iterable[Scalar]) -> Callable[[Scalar], Operand]:
    """The same value of each expression that the roots need, with sums of angles in place of products.

    Angles that depend on the state are added; sums are added further.
    """
    roots = list(roots)
    symbols: dict[str, Operand] = {node.operands[0]: node for node in reachable(roots) if node.operation == SYMBOL}
    return evaluate(roots, symbols, _arithmetic(graph))


def _arithmetic(graph: Graph) -> Arithmetic[Operand]:
    """Arithmetic that builds expressions anew."""

    def added(x: Operand, y: Operand) -> Operand:
        found = _by_addition_theorem(graph, x, y, 1)
        return x + y if found is None else found

    def subtracted(x: Operand, y: Operand) -> Operand:
        found = _by_addition_theorem(graph, x, y, -1)
        return x - y if found is None else found

    anew: dict[str, Callable[..., Operand]] = {
        ADD: added,
        SUBTRACT: subtracted,
        SIN: lambda x: _sine(graph, x),
        COS: lambda x: _cosine(graph, x),
        SQRT: lambda x: square_root(graph, x),
        SIGN: lambda x: sign(graph, x),
        MINIMUM: lambda x, y: minimum(graph, x, y),
        MAXIMUM: lambda x, y: maximum(graph, x, y),
        ATAN2: lambda y, x: arc_tangent(graph, y, x),
    }
    return nodes(graph, anew)


def _by_addition_theorem(graph: Graph, x: Operand, y: Operand, sense: int) -> Operand | None:
    """x + y, or x - y, by the addition theorem; None where it does not apply."""
    if _is_negative(y):
        return _by_addition_theorem(graph, x, y.operands[0], -sense)
    if _is_negative(x):
        found = _by_addition_theorem(graph, x.operands[0], y, -sense)
        return None if found is None else -found
    one, other = _product(x), _product(y)
    if one is None or other is None:
        return None
    (f, a, g, b), (h, c, k, d) = one, other
    if (f, g, h, k) == (COS, SIN, COS, SIN) and (a, b) == (d, c):
        return _sine(graph, b + a if sense > 0 else b - a)
    if {a.id, b.id} != {c.id, d.id}:
        return None
    if (f, g, h, k) == (COS, COS, SIN, SIN):
        return _cosine(graph, a - b if sense > 0 else a + b)
    if (f, g, h, k) == (SIN, SIN, COS, COS):
        return _cosine(graph, a - b) if sense > 0 else -_cosine(graph, a + b)
    return None


def _is_negative(x: Operand) -> TypeGuard[Expression]:
    return isinstance(x, Expression) and x.operation == NEGATE


def _product(x: Operand) -> CircularProduct | None:
    if not isinstance(x, Expression) or x.operation != MULTIPLY or x.level != Level.STATE:
        return None
    factors = sorted((factor for factor in x.operands if _is_circular(factor)), key=lambda factor: factor.operation)
    if len(factors) != 2:
        return None
    first, second = factors
    return first.operation, first.operands[0], second.operation, second.operands[0]


def _is_circular(x: Operand) -> TypeGuard[Expression]:
    return isinstance(x, Expression) and x.operation in (SIN, COS) and x.level == Level.STATE


def _sine(graph: Graph, angle: Operand) -> Operand:
    if not isinstance(angle, Expression):
        return graph.node(SIN, angle) if angle else 0
    return -graph.node(SIN, angle.operands[0]) if angle.operation == NEGATE else graph.node(SIN, angle)


def _cosine(graph: Graph, angle: Operand) -> Operand:
    if not isinstance(angle, Expression):
        return graph.node(COS, angle) if angle else 1
    return graph.node(COS, angle.operands[0] if angle.operation == NEGATE else angle)
