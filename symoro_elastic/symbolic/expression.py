"""Scalar expressions, interned: equal expressions of a graph are one object.

Exact rational constants are plain `int` and `Fraction` objects, so they fold by themselves, and
zero and one disappear as soon as they meet an expression. A `float` is taken as the rational number
that it is. Signs are carried outwards: `-x` is a node of its own, and no operand of a product or of a
sum is one. Operands of other types are left to their own operators, as Python does.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum
from fractions import Fraction
from numbers import Rational
from typing import Any, TypeAlias, final

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, PI, SUBTRACT, SYMBOL

Constant: TypeAlias = int | Fraction
Operand: TypeAlias = "Expression | int | Fraction"
"""An expression or an exact constant."""
_Key: TypeAlias = "tuple[str | int | tuple[int, int], ...]"


class Level(IntEnum):
    """Kind of values on which an expression depends."""

    CONSTANT = 0
    PARAMETER = 1
    STATE = 2


class Graph:
    """The expressions of a trace, which live as long as the graph."""

    def __init__(self) -> None:
        self._interned: dict[_Key, Expression] = {}
        self._symbols: dict[str, Expression] = {}
        self.pi = self.node(PI)

    def __len__(self) -> int:
        return len(self._interned)

    @property
    def nodes(self) -> list[Expression]:
        """All nodes, by number."""
        return list(self._interned.values())

    def symbol(self, name: str, level: Level = Level.STATE) -> Expression:
        """The variable of this name."""
        if name not in self._symbols:
            self._symbols[name] = Expression(self, SYMBOL, (name,), (), len(self._interned), level)
            self._interned[SYMBOL, name] = self._symbols[name]
        return self._symbols[name]

    def node(self, operation: str, *operands: Operand) -> Expression:
        """The node of this operation on these operands, already in normal form."""
        key = (operation, *[o.id if type(o) is Expression else o.as_integer_ratio() for o in operands])
        node = self._interned.get(key)
        if node is None:
            needs = tuple([o for o in operands if type(o) is Expression])
            level = max([x.level for x in needs], default=Level.CONSTANT)
            node = self._interned[key] = Expression(self, operation, operands, needs, len(self._interned), level)
        return node

    def pair(self, operation: str, first: Expression, second: Expression) -> Expression:
        """The node of an operation on two expressions, as `node` gives it; most nodes are made here."""
        key = (operation, first.id, second.id)
        node = self._interned.get(key)
        if node is None:
            level, both = first.level if first.level > second.level else second.level, (first, second)
            node = self._interned[key] = Expression(self, operation, both, both, len(self._interned), level)
        return node

    def negative(self, x: Expression) -> Expression:
        """The node -x of an expression without a sign."""
        key = (NEGATE, x.id)
        node = self._interned.get(key)
        if node is None:
            node = self._interned[key] = Expression(self, NEGATE, (x,), (x,), len(self._interned), x.level)
        return node


@final
class Expression:
    """A node: an operation on operands, which are older nodes or constants; the operand of a symbol is its name.

    `needs` are the nodes among the operands.
    """

    __slots__ = ("graph", "id", "level", "needs", "operands", "operation")

    def __init__(
        self,
        graph: Graph,
        operation: str,
        operands: tuple[Any, ...],
        needs: tuple[Expression, ...],
        number: int,
        level: Level,
    ) -> None:
        self.graph = graph
        self.operation = operation
        self.operands = operands
        self.needs = needs
        self.id = number
        self.level = level

    def __add__(self, other: Scalar) -> Operand:
        if type(other) is not Expression:
            constant = exact(other)
            return NotImplemented if constant is None else _add_constant(self, constant)
        if self.operation == NEGATE:
            return other - self.positive
        if other.operation == NEGATE:
            return self - other.positive
        if _base(self) is _base(other):
            return _base(self) * (_factor(self) + _factor(other))
        return self.graph.pair(ADD, self, other) if self.id < other.id else self.graph.pair(ADD, other, self)

    def __sub__(self, other: Scalar) -> Operand:
        if type(other) is not Expression:
            constant = exact(other)
            return NotImplemented if constant is None else _add_constant(self, -constant)
        if other.operation == NEGATE:
            return self + other.positive
        if self.operation == NEGATE:
            return -(self.positive + other)
        if _base(self) is _base(other):
            return _base(self) * (_factor(self) - _factor(other))
        if self.id < other.id:
            return self.graph.pair(SUBTRACT, self, other)
        return -self.graph.pair(SUBTRACT, other, self)

    def __mul__(self, other: Scalar) -> Operand:
        if type(other) is not Expression:
            constant = exact(other)
            return NotImplemented if constant is None else _scale(self, constant)
        if self.operation == NEGATE:
            return -(self.positive * other)
        if other.operation == NEGATE:
            return -(self * other.positive)
        return self.graph.pair(MULTIPLY, self, other) if self.id < other.id else self.graph.pair(MULTIPLY, other, self)

    def __truediv__(self, other: Scalar) -> Operand:
        if type(other) is not Expression:
            constant = exact(other)
            return NotImplemented if constant is None else _scale(self, 1 / Fraction(constant))
        if self is other:
            return Fraction(1)
        if self.operation == NEGATE:
            return -(self.positive / other)
        if other.operation == NEGATE:
            return -(self / other.positive)
        return self.graph.pair(DIVIDE, self, other)

    def __neg__(self) -> Expression:
        return self.positive if self.operation == NEGATE else self.graph.negative(self)

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Scalar) -> Operand:
        constant = exact(other)
        return NotImplemented if constant is None else -_add_constant(self, -constant)

    def __rtruediv__(self, other: Scalar) -> Operand:
        constant = exact(other)
        return NotImplemented if constant is None else _reciprocal(constant, self)

    @property
    def positive(self) -> Expression:
        """x of the node -x, or the node itself."""
        inner: Expression = self.operands[0] if self.operation == NEGATE else self
        return inner

    def __repr__(self) -> str:
        """The expression as text: `(x + 2*y)`."""
        return _written(self)


def exact(x: Scalar) -> Constant | None:
    """An exact constant; None for other values than numbers of Python."""
    if type(x) is int or type(x) is Fraction:
        return x
    return Fraction(x) if isinstance(x, float | Rational) else None


def operand(x: Scalar) -> Operand:
    """An expression, or an exact constant; raises `TypeError` for any other scalar."""
    if type(x) is Expression:
        return x
    constant = exact(x)
    if constant is None:
        raise TypeError(f"no expression and no exact constant: {type(x).__name__}")
    return constant


def is_constant(x: Scalar) -> bool:
    """Whether a scalar is the same at every state."""
    return not isinstance(x, Expression) or x.level < Level.STATE


def quotient(x: Operand, y: Operand) -> Operand:
    """x/y, exact where both are constants."""
    return x / y if type(x) is Expression else Fraction(x) / y if type(y) is not Expression else x / y


def _add_constant(x: Expression, constant: Constant) -> Operand:
    if constant == 0:
        return x
    if x.operation == NEGATE:
        return -_add_constant(x.positive, -constant)
    if x.operation == ADD and type(x.operands[1]) is not Expression:
        return _add_constant(x.operands[0], x.operands[1] + constant)
    return x.graph.node(ADD, x, constant)


def _scale(x: Expression, factor: Constant) -> Operand:
    if factor == 0:
        return 0
    if factor == 1:
        return x
    if x.operation == NEGATE:
        return -_scale(x.positive, factor)
    if factor < 0:
        return -_scale(x, -factor)
    if x.operation == MULTIPLY and type(x.operands[1]) is not Expression:
        return _scale(x.operands[0], x.operands[1] * factor)
    return x.graph.node(MULTIPLY, x, factor)


def _reciprocal(constant: Constant, x: Expression) -> Operand:
    if constant == 0:
        return 0
    if constant < 0:
        return -_reciprocal(-constant, x)
    if x.operation == NEGATE:
        return -_reciprocal(constant, x.positive)
    return x.graph.node(DIVIDE, constant, x)


def _base(x: Expression) -> Expression:
    """x without a constant factor."""
    scaled = x.operation == MULTIPLY and type(x.operands[1]) is not Expression
    base: Expression = x.operands[0] if scaled else x
    return base


def _factor(x: Expression) -> Constant:
    """The constant factor of x."""
    factor: Constant = 1 if _base(x) is x else x.operands[1]
    return factor


def _written(x: Operand) -> str:
    if type(x) is not Expression:
        return str(x)
    if x.operation == SYMBOL:
        return str(x.operands[0])
    operands = [_written(o) for o in x.operands]
    if x.operation == NEGATE:
        return f"-{operands[0]}"
    if x.operation == MULTIPLY:
        return f"({'*'.join(operands)})"
    if x.operation == DIVIDE:
        return f"({'/'.join(operands)})"
    if x.operation in (ADD, SUBTRACT):
        return f"({f' {x.operation} '.join(operands)})"
    return f"{x.operation}({', '.join(operands)})"


def reachable(roots: Iterable[Scalar]) -> list[Expression]:
    """Every node the roots need, operands before their users."""
    nodes: dict[int, Expression] = {root.id: root for root in roots if type(root) is Expression}
    stack = list(nodes.values())
    while stack:
        for x in stack.pop().needs:
            if x.id not in nodes:
                nodes[x.id] = x
                stack.append(x)
    return [nodes[number] for number in sorted(nodes)]
