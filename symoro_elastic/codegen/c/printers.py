"""Statements as C: operators on numbers, or functions on sums of two doubles; sines and cosines come from an array."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from symoro_elastic.codegen.c.constants import Literal, Literals
from symoro_elastic.codegen.partition import LONGEST_PART
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.codegen.printers import ATOM, PRODUCT, Printed, Printer, Text
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.program import Program, Statement

OWN_FUNCTIONS = (op.SIGN, op.MINIMUM, op.MAXIMUM)
"""Functions that C has not, or whose NaN is another."""
FUNCTIONS = dict.fromkeys((op.SIN, op.COS, op.SQRT, op.ATAN2, *OWN_FUNCTIONS))
OF_PAIRS = {
    op.ADD: "sum",
    op.SUBTRACT: "difference",
    op.MULTIPLY: "product",
    op.DIVIDE: "quotient",
    op.NEGATE: "negative",
    op.SIN: "sin",
    op.COS: "cos",
    op.SQRT: "sqrt",
    op.SIGN: "sign",
    op.ATAN2: "atan2",
    op.MINIMUM: "minimum",
    op.MAXIMUM: "maximum",
}


@dataclass(frozen=True)
class Form:
    """How a C function handles numbers: types, reading and writing of array entries, names of functions.

    `real` is the type of what depends on parameters only; `sincos` gives the lines that find those of angles
    before so many statements; `pair` begins the names of functions on sums of two doubles. Functions on many `states`
    are given their number. `operand` is how an operand of a function is written, if not a variable. Blocks that repeat
    in long programs are functions, whose arguments are places in arrays: from `outlined` times as many statements on as
    for one state, nowhere if it is 0. Functions that leave rows do not store entries that repeat others, where these
    are many: rows of many states are written after them. Where numbers are `near_use` they are loaded before the
    statement that needs them first and stored after the one that finds them. `part` are the statements of parts of long
    programs.
    """

    number: str
    angle: str
    real: str
    load: str
    load_angle: str
    store: str
    narrow: str
    functions: Mapping[str, str]
    load_parameter: str
    sincos: Callable[[Sequence[str], int], Iterable[str]]
    pair: str = ""
    states: str = ""
    operand: str = "{}"
    outlined: int = 0
    leaves_rows: bool = False
    near_use: bool = False
    part: int = LONGEST_PART


def angles_of(program: Program) -> list[Expression]:
    """Angles whose sines and cosines are computed first: joint variables, their multiples and sums."""
    roots: list[Operand] = [s.node for s in program.statements] + [x for o in program.outputs for x in o.entries]
    angles: dict[int, Expression] = {}
    for node in reachable(roots):
        if node.operation in (op.SIN, op.COS) and node.level == Level.STATE and is_given(node.operands[0]):
            angles.setdefault(node.operands[0].id, node.operands[0])
    return list(angles.values())


def is_given(angle: Expression) -> bool:
    """Whether an angle is a sum of multiples of joint variables, to be computed in the type of angles."""
    return all(node.level == Level.STATE and _is_linear(node) for node in reachable([angle]))


def _is_linear(node: Expression) -> bool:
    multiple = node.operation == op.MULTIPLY and not isinstance(node.operands[1], Expression)
    return multiple or node.operation in (op.SYMBOL, op.ADD, op.SUBTRACT)


class CPrinter(Printer):
    """Prints expressions as C with native numbers and operators.

    `called` holds the functions that were printed. Numbers in statements appear by their names in `literals`.
    """

    def __init__(self, program: Program, precision: Precision, angles: Sequence[Expression], form: Form) -> None:
        super().__init__(program, functions=form.functions)
        self.form, self.precision = form, precision
        self.angles = {angle.id: k for k, angle in enumerate(angles)}
        self.called: dict[str, None] = {}
        self.literals: Literals | None = None
        self._statement: Statement | None = None
        self._named: dict[str, dict[str, Literal]] = {}
        self._calling: set[int] = set()

    def text_of(self, statement: Statement) -> Printed:
        """The expression that a statement assigns, and the names in it; printed once."""
        self._statement = statement
        text = super().text_of(statement)
        self._statement = None
        return text

    def named_numbers(self, statement: Statement) -> Iterable[Literal]:
        """The named numbers in a statement."""
        return self._named.get(statement.name, {}).values()

    def share(self, other: CPrinter) -> None:
        """Reuse the text of a printer of the same program and numbers, for statements without function calls."""
        self._printed = {number: text for number, text in other._printed.items() if number not in other._calling}
        self._named = dict(other._named)

    def literal(self, value: float) -> Text:
        """Text of a number, by its name where it has one."""
        return self.by_name(self._number(value))

    def by_name(self, number: Text) -> Text:
        """Text of a number replaced by its name; unchanged if it has none."""
        if self.literals is None or self._statement is None:
            return number
        literal = self.literals.find(self._statement.section.joint, number.text)
        if literal is None:
            return number
        self._named.setdefault(self._statement.name, {}).setdefault(literal.name, literal)
        return Text(number.negative, literal.name, ATOM)

    def written(self, x: Operand) -> Text | None:
        """Text of a constant of the program; None for any other operand."""
        if not isinstance(x, Expression):
            return self._number(float(x))
        return self._number(self.constants[x.id]) if x.id in self.constants else None

    def _number(self, value: float) -> Text:
        """Text of a number in the precision; raises `OverflowError` if it is out of range."""
        number = super().literal(value)
        return number._replace(text=self.precision.number(number.text))

    def other_operation(self, node: Expression, flipped: bool) -> Text:
        """Text of a symbol, a function, or an operator on an expression; precomputed sines are array entries."""
        if node.operation in FUNCTIONS:
            if node.operation in (op.SIN, op.COS) and node.operands[0].id in self.angles:
                return Text(flipped, self.entry(node), ATOM)
            self.called.setdefault(node.operation)
        elif node.operation == op.MULTIPLY and len(node.needs) == 1:
            return self.multiple(self.text(node.operands[0]), self.text(node.operands[1]), flipped)
        return super().other_operation(node, flipped)

    def call(self, operation: str, flipped: bool, texts: Sequence[Text]) -> Text:
        """Text of an operation as a call of a C function."""
        if self._statement is not None:
            self._calling.add(self._statement.node.id)
        plain = [text.binding == ATOM and not text.negative for text in texts]
        operands = [
            text if is_plain else Text(False, self.form.operand.format(text.signed()), ATOM)
            for text, is_plain in zip(texts, plain, strict=True)
        ]
        return super().call(operation, flipped, operands)

    def multiple(self, x: Text, number: Text, flipped: bool) -> Text:
        """Text of a number times an expression, the number first unless the expression is in brackets."""
        first, second = (number, x) if x.binding == ATOM else (x, number)
        negative = (x.negative != number.negative) != flipped
        return Text(negative, f"{first.factor(PRODUCT)}*{second.factor(ATOM)}", PRODUCT)

    def entry(self, node: Expression) -> str:
        """Text of the array entry of a sine or cosine, as `sine[2]`; records that the array is used."""
        array = "sine" if node.operation == op.SIN else "cosine"
        self.referenced.add(array)
        return self.form.narrow.format(f"{array}[{self.angles[node.operands[0].id]}]")


class PairPrinter(CPrinter):
    """Prints expressions as C on sums of two doubles; operators and signs are function calls."""

    def text(self, x: Operand) -> Text:
        """Text of an expression, by name where it has one; constants have twice the digits of a double."""
        if not isinstance(x, Expression) or x.level == Level.CONSTANT:
            named_numbers = self.by_name(self.written(x))
            if named_numbers.text == self.written(x).text:
                return Text(False, self.pair_of(*_two_doubles(x)), ATOM)
            return self.negation(named_numbers.text) if named_numbers.negative else named_numbers
        text = super().text(x)
        return self.negation(text.text) if text.negative else text

    def pair_of(self, high: float, low: float) -> str:
        """Text of a pair of two numbers, high and low part."""
        self.called.setdefault("make")
        return f"{self.form.pair}make({high!r}, {low!r})"

    def written(self, x: Operand) -> Text:
        """Text of a constant as a pair, its sign separate."""
        high, low = _two_doubles(x)
        negative = high < 0
        return Text(negative, self.pair_of(abs(high), -low if negative else low), ATOM)

    def negation(self, text: str) -> Text:
        """Text of a pair with its sign reversed."""
        self.called.setdefault(OF_PAIRS[op.NEGATE])
        return Text(False, f"{self.form.pair}negative({text})", ATOM)

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """Text of the operation of a node as a function call."""
        if node.operation == op.SYMBOL:
            plain = Printer.operation(self, node)
        elif node.operation == op.NEGATE:
            plain = self.negation(self.text(node.operands[0]).text)
        elif node.operation in (op.SIN, op.COS) and node.operands[0].id in self.angles:
            plain = Text(False, self.entry(node), ATOM)
        else:
            inside = ", ".join(self.text(x).text for x in node.operands)
            self.called.setdefault(OF_PAIRS[node.operation])
            plain = Text(False, f"{self.form.pair}{OF_PAIRS[node.operation]}({inside})", ATOM)
        return self.negation(plain.text) if flipped else plain


def _two_doubles(x: Operand) -> tuple[float, float]:
    """Round a constant to a sum of two doubles; raises `OverflowError`."""
    exact: Any = evaluate([x], {}, multiprecision(60))(x) if isinstance(x, Expression) else Fraction(x)
    high = float(exact)
    if high in (float("inf"), float("-inf")):
        raise OverflowError(f"{exact} is out of the range of doubles")
    return high, float(exact - (Fraction(high) if isinstance(exact, Fraction) else high))


def printer_of(program: Program, precision: Precision, angles: Sequence[Expression], form: Form) -> CPrinter:
    """The printer of expressions for a precision."""
    return (PairPrinter if precision.is_pair else CPrinter)(program, precision, angles, form)
