"""Scalar expressions, interned: equal expressions of a graph are one object.

Exact rational constants are plain `int` and `Fraction` objects, so they fold by themselves, and
zero and one disappear as soon as they meet an expression. Signs are carried outwards: `-x` is a
node of its own, and no operand of a product or of a sum is one.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum
from fractions import Fraction
from typing import Any, TypeAlias

Constant: TypeAlias = int | Fraction
Scalar: TypeAlias = Any
"""An `Expression` or a `Constant`."""

ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE = "+", "-", "*", "/", "neg"
SYMBOL, PI, COSPI = "symbol", "pi", "cospi"
SIN, COS, SQRT, SIGN, ATAN2 = "sin", "cos", "sqrt", "sign", "atan2"


class Level(IntEnum):
    """What the value of an expression depends on."""

    CONSTANT = 0
    PARAMETER = 1
    STATE = 2


class Graph:
    """The expressions of one trace; they live as long as it does."""

    def __init__(self) -> None:
        self._interned: dict[tuple[Any, ...], Expression] = {}
        self._symbols: dict[str, Expression] = {}
        self.pi = self.node(PI)

    def __len__(self) -> int:
        return len(self._interned)

    def symbol(self, name: str, level: Level = Level.STATE) -> Expression:
        """The variable of this name."""
        if name not in self._symbols:
            self._symbols[name] = Expression(self, SYMBOL, (name,), len(self._interned), level)
            self._interned[SYMBOL, name] = self._symbols[name]
        return self._symbols[name]

    def pair(self, operation: str, first: Expression, second: Expression) -> Expression:
        """The node of an operation on two expressions, as `node` gives it; most nodes are made here."""
        key = (operation, first.id, second.id)
        found = self._interned.get(key)
        if found is None:
            level = first.level if first.level > second.level else second.level
            found = self._interned[key] = Expression(self, operation, (first, second), len(self._interned), level)
        return found

    def node(self, operation: str, *operands: Any) -> Expression:
        """The node of this operation on these operands, already in normal form."""
        key = (operation, *[o.id if o.__class__ is Expression else Fraction(o).as_integer_ratio() for o in operands])
        found = self._interned.get(key)
        if found is None:
            level = max((o.level for o in operands if o.__class__ is Expression), default=Level.CONSTANT)
            found = self._interned[key] = Expression(self, operation, operands, len(self._interned), level)
        return found


class Expression:
    """A node: an operation on operands, which are older nodes or constants."""

    __slots__ = ("graph", "id", "level", "operands", "operation")

    def __init__(self, graph: Graph, operation: str, operands: tuple[Any, ...], number: int, level: Level) -> None:
        self.graph, self.operation, self.operands, self.id, self.level = graph, operation, operands, number, level

    def __add__(self, other: Scalar) -> Scalar:
        if other.__class__ is not Expression:
            return _add_constant(self, other)
        if self.operation == NEGATE:
            return other - self.operands[0]
        if other.operation == NEGATE:
            return self - other.operands[0]
        alike = _combine(self, other, 1)
        if alike is not None:
            return alike
        first, second = (self, other) if self.id < other.id else (other, self)
        return self.graph.pair(ADD, first, second)

    def __sub__(self, other: Scalar) -> Scalar:
        if other.__class__ is not Expression:
            return _add_constant(self, -other)
        if other.operation == NEGATE:
            return self + other.operands[0]
        if self.operation == NEGATE:
            return -(self.operands[0] + other)
        alike = _combine(self, other, -1)
        if alike is not None:
            return alike
        if self.id < other.id:
            return self.graph.pair(SUBTRACT, self, other)
        return -self.graph.pair(SUBTRACT, other, self)

    def __mul__(self, other: Scalar) -> Scalar:
        if other.__class__ is not Expression:
            return _scale(self, other) if isinstance(other, int | float | Fraction) else NotImplemented
        if self.operation == NEGATE:
            return -(self.operands[0] * other)
        if other.operation == NEGATE:
            return -(self * other.operands[0])
        first, second = (self, other) if self.id < other.id else (other, self)
        return self.graph.pair(MULTIPLY, first, second)

    def __truediv__(self, other: Scalar) -> Scalar:
        if other.__class__ is not Expression:
            return _scale(self, 1 / Fraction(other))
        if self is other:
            return Fraction(1)
        if self.operation == NEGATE:
            return -(self.operands[0] / other)
        if other.operation == NEGATE:
            return -(self / other.operands[0])
        return self.graph.pair(DIVIDE, self, other)

    def __neg__(self) -> Expression:
        return self.operands[0] if self.operation == NEGATE else self.graph.node(NEGATE, self)

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Constant) -> Scalar:
        return -_add_constant(self, -other)

    def __rtruediv__(self, other: Constant) -> Scalar:
        if other == 0:
            return 0
        if other < 0:
            return -((-other) / self)
        if self.operation == NEGATE:
            return -(other / self.operands[0])
        return self.graph.node(DIVIDE, other, self)

    def __repr__(self) -> str:
        return f"{self.operation}{self.operands}"


def _add_constant(x: Expression, constant: Constant) -> Scalar:
    if constant == 0:
        return x
    if x.operation == NEGATE:
        return -_add_constant(x.operands[0], -constant)
    if x.operation == ADD and x.operands[1].__class__ is not Expression:
        return _add_constant(x.operands[0], x.operands[1] + constant)
    return x.graph.node(ADD, x, constant)


def _scale(x: Expression, factor: Constant) -> Scalar:
    if factor == 0:
        return 0
    if x.operation == NEGATE or factor < 0:
        return -_scale(-x if x.operation == NEGATE else x, factor if x.operation == NEGATE else -factor)
    if factor == 1:
        return x
    if x.operation == MULTIPLY and x.operands[1].__class__ is not Expression:
        return _scale(x.operands[0], x.operands[1] * factor)
    return x.graph.node(MULTIPLY, x, factor)


def _multiple(x: Expression) -> tuple[Expression, Constant]:
    if x.operation == MULTIPLY and x.operands[1].__class__ is not Expression:
        return x.operands
    return x, 1


def _combine(x: Expression, y: Expression, sign: int) -> Scalar | None:
    """`x + sign y` where both are constant multiples of one expression."""
    (base_x, factor_x), (base_y, factor_y) = _multiple(x), _multiple(y)
    return base_x * (factor_x + sign * factor_y) if base_x is base_y else None


def reachable(roots: Iterable[Scalar]) -> list[Expression]:
    """Every node the roots need, operands before their users."""
    found: dict[int, Expression] = {}
    stack = [root for root in roots if isinstance(root, Expression)]
    while stack:
        node = stack.pop()
        if node.id not in found:
            found[node.id] = node
            stack.extend(o for o in node.operands if o.__class__ is Expression)
    return [found[number] for number in sorted(found)]
