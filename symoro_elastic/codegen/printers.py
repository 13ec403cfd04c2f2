"""Statements of a program as C or Python assignments, which share their notation for arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import ClassVar, NamedTuple

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Program, Statement

SUM, PRODUCT, ATOM = 1, 2, 3
Rule = Callable[..., "Text"]
"""A function from whether the sign is reversed, and the texts of operands, to the text of an operation."""


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


def _negative(flipped: bool, inner: Text) -> Text:
    return Text(inner.negative == flipped, inner.text, inner.binding)


def _sum(flipped: bool, first: Text, second: Text, subtracted: bool = False) -> Text:
    minus_first = first.negative != flipped
    minus_second = (second.negative != subtracted) != flipped
    if minus_first == minus_second:
        return Text(minus_first, f"{first.text} + {second.text}", SUM)
    plus, minus = (second, first) if minus_first else (first, second)
    return Text(False, f"{plus.text} - {minus.factor(PRODUCT)}", SUM)


def _difference(flipped: bool, first: Text, second: Text) -> Text:
    return _sum(flipped, first, second, True)


def product(flipped: bool, first: Text, second: Text, times: str = "*") -> Text:
    """Text of a product, literals first."""
    negative = (first.negative != second.negative) != flipped
    if second.text[0].isdigit() and first.binding == ATOM:
        first, second = second, first
    return Text(negative, f"{first.factor(PRODUCT)}{times}{second.factor(ATOM)}", PRODUCT)


def quotient(flipped: bool, first: Text, second: Text, over: str = "/") -> Text:
    """Text of a quotient."""
    negative = (first.negative != second.negative) != flipped
    return Text(negative, f"{first.factor(PRODUCT)}{over}{second.factor(ATOM)}", PRODUCT)


OPERATORS: Mapping[str, Rule] = {
    NEGATE: _negative,
    ADD: _sum,
    SUBTRACT: _difference,
    MULTIPLY: product,
    DIVIDE: quotient,
}
"""Operations that are operators of C and Python."""


class Printed(NamedTuple):
    """Text of a statement's right side, and the names of variables and arguments in it."""

    text: str
    names: frozenset[str]


class Printer:
    """Prints the expressions of a program; assigned expressions appear by name.

    An operation is printed by its rule in `operators`, or as a call of a function: its name in `functions`, else its
    own. `referenced` collects the names that appear in what is printed.
    """

    operators: ClassVar[Mapping[str, Rule]] = OPERATORS

    def __init__(self, program: Program, literal_suffix: str = "", functions: Mapping[str, str] | None = None) -> None:
        self.literal_suffix = literal_suffix
        self.functions = functions or {}
        self.variables = {s.node.id: Text(s.negative, s.name, ATOM) for s in (*program.once, *program.statements)}
        self.referenced: set[str] = set()
        self.constants = constant_values(program.constants)
        self._printed: dict[int, Printed] = {}

    def right_side(self, statement: Statement) -> str:
        """Text of the expression that a statement assigns."""
        printed = self.text_of(statement)
        self.referenced |= printed.names
        return printed.text

    def text_of(self, statement: Statement) -> Printed:
        """The expression that a statement assigns, and the names in it; printed once."""
        number = statement.node.id
        if number not in self._printed:
            outside, self.referenced = self.referenced, set()
            text = self.operation(statement.node, statement.negative).signed()
            self._printed[number] = Printed(text, frozenset(self.referenced))
            self.referenced = outside
        return self._printed[number]

    def value(self, x: Operand) -> str:
        """Text of an expression with its sign, by name where it has one."""
        return self.text(x).signed()

    def text(self, x: Operand) -> Text:
        """Text of an expression with sign and binding, by name where it has one."""
        if not isinstance(x, Expression):
            return self.literal(float(x))
        text = self.variables.get(x.id)
        if text is not None:
            self.referenced.add(text.text)
            return text
        if x.id in self.constants:
            return self.literal(self.constants[x.id])
        return self.operation(x)

    def literal(self, value: float) -> Text:
        """Text of a number in double precision; raises `OverflowError` if it is out of range."""
        if not math.isfinite(value):
            raise OverflowError(f"{value} is not finite")
        return Text(value < 0, repr(abs(value)) + self.literal_suffix, ATOM)

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """Text of a node's operation, its sign reversed when `flipped`."""
        rule = self.operators.get(node.operation)
        if rule is None or len(node.needs) < 2:
            return self.other_operation(node, flipped)
        first, second = node.operands
        return rule(flipped, self.text(first), self.text(second))

    def other_operation(self, node: Expression, flipped: bool) -> Text:
        """The text of a symbol, a function, or an operator on an expression."""
        operation = node.operation
        if operation == SYMBOL:
            self.referenced.add(node.operands[0])
            return Text(flipped, node.operands[0], ATOM)
        texts = [self.text(x) for x in node.operands]
        rule = self.operators.get(operation)
        return rule(flipped, *texts) if rule else self.call(operation, flipped, texts)

    def call(self, operation: str, flipped: bool, texts: Sequence[Text]) -> Text:
        """Text of an operation as a function call."""
        name = self.functions.get(operation, operation)
        return Text(flipped, f"{name}({', '.join([text.signed() for text in texts])})", ATOM)


def constant_values(roots: Iterable[Scalar]) -> dict[int, float]:
    """Doubles nearest to the constant expressions below `roots`, by number."""
    constants = [node for node in reachable(roots) if node.level == Level.CONSTANT]
    if not constants:
        return {}
    value = evaluate(constants, {}, multiprecision(60))
    return {node.id: float(value(node)) for node in constants}
