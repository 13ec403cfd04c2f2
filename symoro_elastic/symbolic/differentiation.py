"""Derivatives of expressions: one pass over the nodes that depend on a variable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import evaluate, nodes
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, operand, quotient, reachable
from symoro_elastic.symbolic.operations import DIVIDE, OPERATIONS, SYMBOL


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
        """Derivatives of the roots and of what they are made of; that of a sign is zero."""
        return self.along({variable: 1})

    def along(self, direction: Mapping[Expression, Scalar]) -> Tangents:
        """The same where some variables move together, each by so much."""
        tangents = Tangents({variable.id: operand(x) for variable, x in direction.items()})
        for node in self._depending_on(direction):
            tangents.of_nodes[node.id] = _derivative(node, [tangents.of(x) for x in node.operands])
        return tangents

    def _depending_on(self, variables: Iterable[Expression]) -> list[Expression]:
        """Nodes that are made of some variables, operands before their users."""
        found: dict[int, Expression] = {}
        stack = [user for variable in variables for user in self._users.get(variable.id, ())]
        while stack:
            node = stack.pop()
            if node.id not in found:
                found[node.id] = node
                stack += self._users.get(node.id, ())
        return [found[number] for number in sorted(found)]


def _derivative(node: Expression, tangents: list[Operand]) -> Operand:
    if node.operation == DIVIDE and not isinstance(node.operands[0], Expression):
        return _derivative_of_reciprocal(node, tangents[1])
    partials = OPERATIONS[node.operation].partials
    if partials is None:
        return 0
    found: Operand = partials(nodes(node.graph).operations, node, node.operands).along(tangents)
    return found


def _derivative_of_reciprocal(node: Expression, tangent: Operand) -> Operand:
    """z' = -z y' z / c of z = c / y: no division but that of z itself."""
    return -quotient(node * tangent * node, node.operands[0])


def substitute(graph: Graph, roots: Iterable[Scalar], values: Mapping[str, Scalar]) -> list[Operand]:
    """Expressions with some variables replaced."""
    roots = list(roots)
    symbols: dict[str, Operand] = {x.operands[0]: x for x in reachable(roots) if x.operation == SYMBOL}
    value = evaluate(roots, symbols | {name: operand(x) for name, x in values.items()}, nodes(graph))
    return [value(x) for x in roots]
