"""Statements as C: operators on numbers, or functions on sums of two doubles; sines and cosines come from an array."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from symoro_elastic.codegen.precision import Precision
from symoro_elastic.codegen.printers import ATOM, Printer, Text
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.operations import (
    ADD,
    ATAN2,
    COS,
    DIVIDE,
    MULTIPLY,
    NEGATE,
    SIGN,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
)
from symoro_elastic.symbolic.program import Program

FUNCTIONS = (SIN, COS, SQRT, SIGN, ATAN2)
PAIR_FUNCTIONS = {
    ADD: "pair_sum",
    SUBTRACT: "pair_difference",
    MULTIPLY: "pair_product",
    DIVIDE: "pair_quotient",
    SIN: "pair_sine",
    COS: "pair_cosine",
    SQRT: "pair_square_root",
    SIGN: "pair_sign",
    ATAN2: "pair_arc_tangent",
}


def angles_of(program: Program) -> list[Expression]:
    """Angles whose sines and cosines are found before all else: joint variables, their multiples and sums."""
    roots: list[Operand] = [s.node for s in program.statements] + [x for o in program.outputs for x in o.entries]
    found: dict[int, Expression] = {}
    for node in reachable(roots):
        if node.operation in (SIN, COS) and node.level == Level.STATE and _is_given(node.operands[0]):
            found.setdefault(node.operands[0].id, node.operands[0])
    return list(found.values())


def _is_given(angle: Expression) -> bool:
    return all(node.level == Level.STATE and _is_linear(node) for node in reachable([angle]))


def _is_linear(node: Expression) -> bool:
    multiple = node.operation == MULTIPLY and not isinstance(node.operands[1], Expression)
    return multiple or node.operation in (SYMBOL, ADD, SUBTRACT)


class CPrinter(Printer):
    """Numbers of the language and their operators."""

    def __init__(self, program: Program, precision: Precision, angles: Sequence[Expression]) -> None:
        of_numbers = {name: f"OF({precision.functions.get(name, name)})" for name in FUNCTIONS}
        super().__init__(program, precision.literal_suffix, of_numbers)
        self.read_circle = "NARROW({})" if precision.is_mixed else "{}"
        self.circles = {angle.id: k for k, angle in enumerate(angles)}

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """The operation of a node written out; the sine or cosine of a given angle is an entry of an array."""
        if node.operation in (SIN, COS) and node.operands[0].id in self.circles:
            return Text(flipped, self.entry(node), ATOM)
        return super().operation(node, flipped)

    def entry(self, node: Expression) -> str:
        """`sine[2]`, and the array counts as used."""
        array = "sine" if node.operation == SIN else "cosine"
        self.referenced.add(array)
        return self.read_circle.format(f"{array}[{self.circles[node.operands[0].id]}]")


class PairPrinter(CPrinter):
    """Sums of two doubles and the functions on them; signs are functions too."""

    def literal(self, value: float) -> Text:
        """A double as a pair."""
        return Text(False, f"pair({value!r}, 0.0)", ATOM)

    def text(self, x: Operand) -> Text:
        """An expression, by name where it has one; constants with twice the digits of a double."""
        if not isinstance(x, Expression) or x.level == Level.CONSTANT:
            return Text(False, _pair(x), ATOM)
        found = super().text(x)
        return _negated(found.text) if found.negative else found

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """The operation of a node as a call."""
        if node.operation == SYMBOL:
            self.referenced.add(node.operands[0])
            plain = Text(False, node.operands[0], ATOM)
        elif node.operation == NEGATE:
            plain = _negated(self.text(node.operands[0]).text)
        elif node.operation in (SIN, COS) and node.operands[0].id in self.circles:
            plain = Text(False, self.entry(node), ATOM)
        else:
            inside = ", ".join(self.text(x).text for x in node.operands)
            plain = Text(False, f"{PAIR_FUNCTIONS[node.operation]}({inside})", ATOM)
        return _negated(plain.text) if flipped else plain


def _negated(text: str) -> Text:
    return Text(False, f"pair_negative({text})", ATOM)


def _pair(x: Operand) -> str:
    """A constant rounded to a sum of two doubles."""
    exact: Any = evaluate([x], {}, multiprecision(60))(x) if isinstance(x, Expression) else Fraction(x)
    high = float(exact)
    if high in (float("inf"), float("-inf")):
        raise OverflowError(f"{exact} is out of the range of doubles")
    low = float(exact - (Fraction(high) if isinstance(exact, Fraction) else high))
    return f"pair({high!r}, {low!r})"


def printer_of(program: Program, precision: Precision, angles: Iterable[Expression]) -> CPrinter:
    """The printer for a precision."""
    return (PairPrinter if precision.is_pair else CPrinter)(program, precision, list(angles))
