"""Derivatives of expressions: one pass over the nodes that depend on a variable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

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
    Scalar,
    reachable,
)


@dataclass(frozen=True)
class Tangents:
    """Derivatives of expressions by one variable, by the number of their node; zero for all others."""

    of_nodes: dict[int, Scalar]

    def of(self, x: Scalar) -> Scalar:
        """Derivative of an expression."""
        return self.of_nodes.get(x.id, 0) if isinstance(x, Expression) else 0


class Differentiation:
    """Derivatives of some expressions by any of their variables; shared nodes are differentiated once."""

    def __init__(self, roots: Iterable[Scalar]) -> None:
        self.roots = list(roots)
        self._users: dict[int, list[Expression]] = {}
        for node in reachable(self.roots):
            for operand in node.operands:
                if isinstance(operand, Expression):
                    self._users.setdefault(operand.id, []).append(node)

    def by(self, variable: Expression) -> Tangents:
        """Derivatives of the roots and of what they are made of; that of a sign is zero."""
        tangents = Tangents({variable.id: 1})
        for node in self._depending_on(variable):
            tangents.of_nodes[node.id] = RULES[node.operation](node, *node.operands, *map(tangents.of, node.operands))
        return tangents

    def _depending_on(self, variable: Expression) -> list[Expression]:
        """Nodes that are made of a variable, operands before their users."""
        found: dict[int, Expression] = {}
        stack = list(self._users.get(variable.id, ()))
        while stack:
            node = stack.pop()
            if node.id not in found:
                found[node.id] = node
                stack += self._users.get(node.id, ())
        return [found[number] for number in sorted(found)]


def _quotient(node: Expression, x: Scalar, y: Scalar, dx: Scalar, dy: Scalar) -> Scalar:
    """1/y has no other division than its own."""
    return -(node * dy * node / x) if not isinstance(x, Expression) else (dx - node * dy) / y


RULES: Mapping[str, Callable[..., Scalar]] = {
    ADD: lambda node, x, y, dx, dy: dx + dy,
    SUBTRACT: lambda node, x, y, dx, dy: dx - dy,
    NEGATE: lambda node, x, dx: -dx,
    MULTIPLY: lambda node, x, y, dx, dy: dx * y + x * dy,
    DIVIDE: _quotient,
    SIN: lambda node, x, dx: node.graph.node(COS, x) * dx,
    COS: lambda node, x, dx: -(node.graph.node(SIN, x) * dx),
    SQRT: lambda node, x, dx: dx / (2 * node),
    ATAN2: lambda node, y, x, dy, dx: (x * dy - y * dx) / (x * x + y * y),
    SIGN: lambda node, x, dx: 0,
}
"""Derivative of a node from its operands and their derivatives."""


def substituted(graph: Graph, roots: Iterable[Scalar], values: Mapping[str, Scalar]) -> list[Scalar]:
    """Expressions with some variables replaced."""
    roots = list(roots)
    symbols: dict[str, Any] = {x.operands[0]: x for x in reachable(roots) if x.operation == SYMBOL}

    def node(operation: str) -> Callable[..., Scalar]:
        return lambda *operands: graph.node(operation, *operands)

    functions = {name: node(name) for name in (SIN, COS, SQRT, SIGN, ATAN2, PI, COSPI)}
    value = evaluate(roots, symbols | dict(values), Arithmetic(lambda x: x, {**RATIONAL, **functions}))
    return [value(x) for x in roots]
