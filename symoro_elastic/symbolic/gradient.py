"""Derivatives of a weighted sum of expressions by all its symbols, in one sweep from the sum to the symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate_nodes
from symoro_elastic.symbolic.expression import Expression, reachable
from symoro_elastic.symbolic.operations import OPERATIONS, SYMBOL, Value


def gradient(
    roots: Sequence[Scalar], weights: Sequence[Value], symbols: Mapping[str, Value], arithmetic: Arithmetic[Value]
) -> dict[str, Value]:
    """d(sum of weights roots)/d(symbol), by symbol, in any arithmetic; symbols without influence are left out.

    Over duals the tangent of a derivative is that of its change along their direction. The derivative of `sign` is
    zero. The values of all nodes are computed first; then each node hands its derivative on to its operands.
    """
    nodes = reachable(roots)
    value = evaluate_nodes(nodes, symbols, arithmetic)
    found: dict[int, Value] = {}
    for root, weight in zip(roots, weights, strict=True):
        _add(found, root, weight)
    by_symbol = {}
    for node in reversed(nodes):
        if node.id not in found:
            continue
        weight = found.pop(node.id)
        if node.operation == SYMBOL:
            by_symbol[node.operands[0]] = weight
            continue
        partials = OPERATIONS[node.operation].partials
        if partials is not None:
            operands = [value(x) for x in node.operands]
            passed = partials(arithmetic.operations, value(node), operands).back(weight)
            for operand, part in zip(node.operands, passed, strict=True):
                _add(found, operand, part)
    return by_symbol


def _add(found: dict[int, Value], x: Scalar, weight: Value) -> None:
    if isinstance(x, Expression):
        found[x.id] = found[x.id] + weight if x.id in found else weight
