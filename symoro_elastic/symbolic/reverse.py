"""Slopes of a weighted sum of expressions by all its symbols, in one sweep from the sum to the symbols."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate
from symoro_elastic.symbolic.expression import (
    ADD,
    ATAN2,
    COS,
    DIVIDE,
    MULTIPLY,
    NEGATE,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
    Expression,
    Scalar,
    reachable,
)

Rule = Callable[[Any, Any, Sequence[Any], Arithmetic], Sequence[Any]]
"""From the slope by a node, its value and its operands: the slopes by its operands."""


def _quotient(slope: Any, value: Any, x: Sequence[Any], _: Arithmetic) -> Sequence[Any]:
    over = slope / x[1]
    return over, -(over * value)


def _angle(slope: Any, _value: Any, x: Sequence[Any], _: Arithmetic) -> Sequence[Any]:
    over = slope / (x[0] * x[0] + x[1] * x[1])
    return over * x[1], -(over * x[0])


RULES: dict[str, Rule] = {
    ADD: lambda slope, value, x, a: (slope, slope),
    SUBTRACT: lambda slope, value, x, a: (slope, -slope),
    NEGATE: lambda slope, value, x, a: (-slope,),
    MULTIPLY: lambda slope, value, x, a: (slope * x[1], slope * x[0]),
    DIVIDE: _quotient,
    SIN: lambda slope, value, x, a: (slope * a.operations[COS](x[0]),),
    COS: lambda slope, value, x, a: (-(slope * a.operations[SIN](x[0])),),
    SQRT: lambda slope, value, x, a: (slope / (2 * value),),
    ATAN2: _angle,
}


def slopes(
    roots: Sequence[Scalar], weights: Sequence[Any], symbols: Mapping[str, Any], arithmetic: Arithmetic
) -> dict[str, Any]:
    """d(sum of weights roots)/d(symbol), by symbol, in any arithmetic; symbols without influence are left out.

    Over duals the slope of a slope is that of the change along their direction. `sign` has slope zero.
    """
    value = evaluate(roots, symbols, arithmetic)
    found: dict[int, Any] = {}
    for root, weight in zip(roots, weights, strict=True):
        if isinstance(root, Expression):
            found[root.id] = found[root.id] + weight if root.id in found else weight
    by_symbol = {}
    for node in reversed(reachable(roots)):
        if node.id not in found:
            continue
        if node.operation == SYMBOL:
            by_symbol[node.operands[0]] = found[node.id]
        for operand, slope in _passed_on(node, found.pop(node.id), value, arithmetic):
            found[operand.id] = found[operand.id] + slope if operand.id in found else slope
    return by_symbol


def _passed_on(
    node: Expression, slope: Any, value: Callable[[Any], Any], arithmetic: Arithmetic
) -> Iterator[tuple[Expression, Any]]:
    """What a node gives to each operand that is no constant."""
    rule = RULES.get(node.operation)
    if rule is None:
        return
    passed = rule(slope, value(node), [value(x) for x in node.operands], arithmetic)
    for operand, part in zip(node.operands, passed, strict=True):
        if isinstance(operand, Expression):
            yield operand, part
