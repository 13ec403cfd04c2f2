"""Sines and cosines of sums of angles, in place of the products that make them.

Consecutive joints with parallel axes give cos a cos b - sin a sin b where cos(a + b) would do. The sum is rounded: far
from zero, where an ulp of an angle is large, that costs digits that the products keep.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, evaluate
from symoro_elastic.symbolic.expression import (
    ADD,
    ATAN2,
    COS,
    COSPI,
    DIVIDE,
    MULTIPLY,
    NEGATE,
    PI,
    SIGN,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
    Expression,
    Graph,
    Level,
    Scalar,
    reachable,
)
from symoro_elastic.symbolic.functions import arc_tangent, sign, square_root

Found = tuple[str, Expression, str, Expression]
"""A product of two of sine and cosine: which, of which angle; cosines first."""


def merged_angles(graph: Graph, roots: Iterable[Scalar]) -> Callable[[Scalar], Scalar]:
    """For each expression that the roots need the same value, with sums of angles wherever they can stand.

    Angles that depend on the state are merged; sums merge further.
    """
    roots = list(roots)
    symbols = {node.operands[0]: node for node in reachable(roots) if node.operation == SYMBOL}
    return evaluate(roots, symbols, _arithmetic(graph))


def _arithmetic(graph: Graph) -> Arithmetic:
    """Arithmetic that builds expressions anew."""

    def added(x: Scalar, y: Scalar) -> Scalar:
        found = _merged(graph, x, y, 1)
        return x + y if found is None else found

    def subtracted(x: Scalar, y: Scalar) -> Scalar:
        found = _merged(graph, x, y, -1)
        return x - y if found is None else found

    anew: dict[str, Callable[..., Scalar]] = {
        ADD: added,
        SUBTRACT: subtracted,
        DIVIDE: lambda x, y: x / y if isinstance(x, Expression) or isinstance(y, Expression) else Fraction(x) / y,
        SIN: lambda x: _sine(graph, x),
        COS: lambda x: _cosine(graph, x),
        SQRT: lambda x: square_root(graph, x),
        SIGN: lambda x: sign(graph, x),
        ATAN2: lambda y, x: arc_tangent(graph, y, x),
        PI: lambda: graph.pi,
        COSPI: lambda x: graph.node(COSPI, x),
    }
    return Arithmetic(lambda x: x, {**RATIONAL, **anew})


def _merged(graph: Graph, x: Scalar, y: Scalar, sense: int) -> Scalar | None:
    """x + y, or x - y, by the addition theorem; None where it does not apply."""
    if _is_negative(y):
        return _merged(graph, x, y.operands[0], -sense)
    if _is_negative(x):
        found = _merged(graph, x.operands[0], y, -sense)
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


def _is_negative(x: Scalar) -> bool:
    return isinstance(x, Expression) and x.operation == NEGATE


def _product(x: Scalar) -> Found | None:
    if not isinstance(x, Expression) or x.operation != MULTIPLY or x.level != Level.STATE:
        return None
    factors = sorted((factor for factor in x.operands if _is_circular(factor)), key=lambda factor: factor.operation)
    if len(factors) != 2:
        return None
    first, second = factors
    return first.operation, first.operands[0], second.operation, second.operands[0]


def _is_circular(x: Scalar) -> bool:
    return isinstance(x, Expression) and x.operation in (SIN, COS) and x.level == Level.STATE


def _sine(graph: Graph, angle: Scalar) -> Scalar:
    if not isinstance(angle, Expression):
        return graph.node(SIN, angle) if angle else 0
    return -graph.node(SIN, angle.operands[0]) if angle.operation == NEGATE else graph.node(SIN, angle)


def _cosine(graph: Graph, angle: Scalar) -> Scalar:
    if not isinstance(angle, Expression):
        return graph.node(COS, angle) if angle else 1
    return graph.node(COS, angle.operands[0] if angle.operation == NEGATE else angle)
