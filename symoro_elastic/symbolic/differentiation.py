"""Derivatives of expressions: one pass over the nodes that depend on a variable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate, evaluate_nodes, nodes
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, operand, quotient, reachable
from symoro_elastic.symbolic.operations import DIVIDE, OPERATIONS, SYMBOL, Value


@dataclass(frozen=True)
class Tangents:
    """Derivatives of expressions by one variable, by the number of their node; zero for all others."""

    of_nodes: dict[int, Operand]

    def of(self, x: Scalar) -> Operand:
        """Derivative of an expression."""
        return self.of_nodes.get(x.id, 0) if isinstance(x, Expression) else 0


class Differentiation:
    """Derivatives of some expressions by any of their variables; shared nodes are differentiated once."""

    def __init__(self, roots: Iterable[Scalar]) -> None:
        self.roots = list(roots)
        self._users: dict[int, list[Expression]] = {}
        for node in reachable(self.roots):
            for x in node.operands:
                if isinstance(x, Expression):
                    self._users.setdefault(x.id, []).append(node)

    def by(self, variable: Expression) -> Tangents:
        """Derivatives of the roots and of their subexpressions; that of a sign is zero."""
        return self.along({variable: 1})

    def along(self, direction: Mapping[Expression, Scalar]) -> Tangents:
        """Derivatives along a direction, in which variables change together."""
        tangents = Tangents({variable.id: operand(x) for variable, x in direction.items()})
        for node in self._depending_on(direction):
            tangents.of_nodes[node.id] = _derivative(node, [tangents.of(x) for x in node.operands])
        return tangents

    def _depending_on(self, variables: Iterable[Expression]) -> list[Expression]:
        """Nodes that depend on the given variables, operands before their users."""
        nodes: dict[int, Expression] = {}
        stack = [user for variable in variables for user in self._users.get(variable.id, ())]
        while stack:
            node = stack.pop()
            if node.id not in nodes:
                nodes[node.id] = node
                stack += self._users.get(node.id, ())
        return [nodes[number] for number in sorted(nodes)]


def _derivative(node: Expression, tangents: list[Operand]) -> Operand:
    if node.operation == DIVIDE and not isinstance(node.operands[0], Expression):
        # z' = -z y' z / c of z = c / y: no division except that of z itself
        return -quotient(node * tangents[1] * node, node.operands[0])
    partials = OPERATIONS[node.operation].partials
    if partials is None:
        return 0
    derivative: Operand = partials(nodes(node.graph).operations, node, node.operands).along(tangents)
    return derivative


def substitute(graph: Graph, roots: Iterable[Scalar], values: Mapping[str, Scalar]) -> list[Operand]:
    """Expressions with some variables replaced."""
    roots = list(roots)
    symbols: dict[str, Operand] = {x.operands[0]: x for x in reachable(roots) if x.operation == SYMBOL}
    value = evaluate(roots, symbols | {name: operand(x) for name, x in values.items()}, nodes(graph))
    return [value(x) for x in roots]


def gradient(
    roots: Sequence[Scalar], weights: Sequence[Value], symbols: Mapping[str, Value], arithmetic: Arithmetic[Value]
) -> dict[str, Value]:
    """d(sum of weights roots)/d(symbol), by symbol, in any arithmetic; symbols without influence are omitted.

    Over duals the tangent of a derivative is that of its change along their direction. The derivative of `sign` is
    zero. The values of all nodes are computed first; then each node hands its derivative on to its operands.
    """
    nodes = reachable(roots)
    value = evaluate_nodes(nodes, symbols, arithmetic)
    values: dict[int, Value] = {}
    for root, weight in zip(roots, weights, strict=True):
        _add(values, root, weight)
    by_symbol = {}
    for node in reversed(nodes):
        if node.id not in values:
            continue
        weight = values.pop(node.id)
        if node.operation == SYMBOL:
            by_symbol[node.operands[0]] = weight
            continue
        partials = OPERATIONS[node.operation].partials
        if partials is not None:
            operands = [value(x) for x in node.operands]
            passed = partials(arithmetic.operations, value(node), operands).back(weight)
            for operand, part in zip(node.operands, passed, strict=True):
                _add(values, operand, part)
    return by_symbol


def _add(found: dict[int, Value], x: Scalar, weight: Value) -> None:
    if isinstance(x, Expression):
        found[x.id] = found[x.id] + weight if x.id in found else weight
