"""Statements of a program as C or Python assignments, which share their notation for arithmetic."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Level, reachable
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Program, Statement

SUM, PRODUCT, ATOM = 1, 2, 3


class Text(NamedTuple):
    """A printed expression: its sign, its text without the sign, and how tightly it binds."""

    negative: bool
    text: str
    binding: int

    def signed(self) -> str:
        """The text with its sign."""
        if not self.negative:
            return self.text
        return f"-({self.text})" if self.binding == SUM else f"-{self.text}"

    def factor(self, binding: int) -> str:
        """The unsigned text as an operand that must bind at least this tightly."""
        return self.text if self.binding >= binding else f"({self.text})"


class Printer:
    """Prints the expressions of one program; assigned expressions appear by name."""

    def __init__(self, program: Program, literal_suffix: str = "", functions: Mapping[str, str] | None = None) -> None:
        self.literal_suffix = literal_suffix
        self.functions = functions or {}
        self.variables = {s.node.id: Text(s.negative, s.name, ATOM) for s in (*program.once, *program.statements)}
        self.referenced: set[str] = set()
        self.constants = constant_values(x for o in program.outputs for x in o.entries)

    def right_side(self, statement: Statement) -> str:
        """The expression that a statement assigns."""
        return self.operation(statement.node, statement.negative).signed()

    def value(self, x: Scalar) -> str:
        """An expression by name where it has one."""
        return self.text(x).signed()

    def text(self, x: Scalar) -> Text:
        """An expression, by name where it has one."""
        if not isinstance(x, Expression):
            return self.literal(float(x))
        found = self.variables.get(x.id)
        if found is not None:
            self.referenced.add(found.text)
            return found
        if x.id in self.constants:
            return self.literal(self.constants[x.id])
        return self.operation(x)

    def literal(self, value: float) -> Text:
        """A number in double precision; raises `OverflowError` where there is none."""
        if not math.isfinite(value):
            raise OverflowError(f"{value} is not finite")
        return Text(value < 0, repr(abs(value)) + self.literal_suffix, ATOM)

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """The operation of a node written out, its sign reversed when `flipped`."""
        operation, operands = node.operation, node.operands
        if operation == SYMBOL:
            self.referenced.add(operands[0])
            return Text(flipped, operands[0], ATOM)
        if operation == NEGATE:
            inner = self.text(operands[0])
            return Text(inner.negative == flipped, inner.text, inner.binding)
        texts = [self.text(x) for x in operands]
        if operation in (ADD, SUBTRACT):
            return _sum(texts[0], texts[1], operation == SUBTRACT, flipped)
        if operation == MULTIPLY:
            return _product(texts[0], texts[1], flipped)
        if operation == DIVIDE:
            negative = (texts[0].negative != texts[1].negative) != flipped
            return Text(negative, f"{texts[0].factor(PRODUCT)}/{texts[1].factor(ATOM)}", PRODUCT)
        name = self.functions.get(operation, operation)
        return Text(flipped, f"{name}({', '.join(t.signed() for t in texts)})", ATOM)


def _sum(first: Text, second: Text, subtracted: bool, flipped: bool) -> Text:
    minus_first = first.negative != flipped
    minus_second = (second.negative != subtracted) != flipped
    if minus_first == minus_second:
        return Text(minus_first, f"{first.text} + {second.text}", SUM)
    plus, minus = (second, first) if minus_first else (first, second)
    return Text(False, f"{plus.text} - {minus.factor(PRODUCT)}", SUM)


def _product(first: Text, second: Text, flipped: bool) -> Text:
    negative = (first.negative != second.negative) != flipped
    if second.text[0].isdigit() and first.binding == ATOM:
        first, second = second, first
    return Text(negative, f"{first.factor(PRODUCT)}*{second.factor(ATOM)}", PRODUCT)


def constant_values(roots: Iterable[Scalar]) -> dict[int, float]:
    """Doubles nearest to the constant expressions that occur."""
    constants = [node for node in reachable(roots) if node.level == Level.CONSTANT]
    if not constants:
        return {}
    value = evaluate(constants, {}, multiprecision(60))
    return {node.id: float(value(node)) for node in constants}
