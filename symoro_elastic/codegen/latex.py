"""The equations of a function as LaTeX: customised variables section by section, then the results."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

from symoro_elastic.codegen.notation import RESULTS, Notation, literal
from symoro_elastic.codegen.package import Function
from symoro_elastic.codegen.printers import ATOM, PRODUCT, Printer, Text
from symoro_elastic.symbolic.expression import (
    ATAN2,
    COS,
    COSPI,
    DIVIDE,
    MULTIPLY,
    PI,
    SIGN,
    SIN,
    SQRT,
    SYMBOL,
    Constant,
    Expression,
    Scalar,
)
from symoro_elastic.symbolic.program import Output, Program, Section, Statement, by_section

MATRIX = 8
LONG = 60
NUMBER = re.compile(r"(?:\\frac\{)?\d")
NAMED = {SIN: r"\sin", COS: r"\cos", SIGN: r"\operatorname{sign}", ATAN2: r"\operatorname{atan2}", COSPI: r"\cos"}


@dataclass(frozen=True)
class Equation:
    """`left = right`, both LaTeX; a sum may be broken before ` + ` and ` - ` outside braces."""

    left: str
    right: str


@dataclass(frozen=True)
class Stretch:
    """The equations of one section of a program."""

    section: Section
    equations: tuple[Equation, ...]


@dataclass(frozen=True)
class Solution:
    """A function as equations: work for each parameter set, work for each call, results."""

    once: tuple[Stretch, ...]
    steps: tuple[Stretch, ...]
    results: tuple[Equation, ...]
    notation: Notation


def solution(function: Function, joints: Sequence[str]) -> Solution:
    """Print a function's program; `joints` are the names of the machine's joints in table order."""
    program = function.program
    notation = Notation(program)
    printer = LatexPrinter(program, notation)
    rows = result_rows(function, joints)
    results = [line for output in program.outputs for line in _result(printer, output, rows[output.name])]
    return Solution(
        tuple(_stretches(printer, program.once)),
        tuple(_stretches(printer, program.statements)),
        tuple(results),
        notation,
    )


class LatexPrinter(Printer):
    """Prints expressions as LaTeX, names by their symbols, constants exactly where that is short."""

    def __init__(self, program: Program, notation: Notation) -> None:
        super().__init__(program)
        self.notation = notation
        self.constants = {}
        for number, text in self.variables.items():
            self.variables[number] = text._replace(text=notation[text.text])

    def equation(self, statement: Statement) -> Equation:
        """A statement; a function of a lone symbol needs no brackets there."""
        node = statement.node
        if node.operation in (SIN, COS, SIGN) and not statement.negative:
            argument = self.text(node.operands[0])
            if argument.binding == ATOM and not argument.negative:
                return Equation(self.notation[statement.name], f"{NAMED[node.operation]} {argument.text}")
        return Equation(self.notation[statement.name], self.right_side(statement))

    def text(self, x: Scalar) -> Text:
        """An expression, by its symbol where it has one."""
        return super().text(x) if isinstance(x, Expression) else number(x)

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """The operation of a node written out, its sign reversed when `flipped`."""
        operation, operands = node.operation, node.operands
        if operation == SYMBOL:
            return Text(flipped, self.notation[operands[0]], ATOM)
        if operation == PI:
            return Text(flipped, r"\pi", ATOM)
        if operation == MULTIPLY:
            return product(self.text(operands[0]), self.text(operands[1]), flipped)
        if operation == DIVIDE:
            over, under = map(self.text, operands)
            return Text((over.negative != under.negative) != flipped, rf"\frac{{{over.text}}}{{{under.text}}}", ATOM)
        if operation == SQRT:
            return Text(flipped, rf"\sqrt{{{self.value(operands[0])}}}", ATOM)
        if operation in NAMED:
            arguments = [self.value(x) for x in operands]
            if operation == COSPI:
                arguments = [_turn(operands[0])]
            return Text(flipped, f"{NAMED[operation]}({', '.join(arguments)})", ATOM)
        return super().operation(node, flipped)


def product(first: Text, second: Text, flipped: bool = False) -> Text:
    """Product of two printed factors: numbers in front, equal factors squared where that reads well."""
    negative = (first.negative != second.negative) != flipped
    if NUMBER.match(second.text):
        first, second = second, first
    left, right = first.factor(PRODUCT), second.factor(PRODUCT)
    if left == right and "^" not in left and first.binding != PRODUCT:
        return Text(negative, f"{left}^{{2}}", ATOM)
    return Text(negative, rf"{left} \cdot {right}" if NUMBER.match(right) else rf"{left}\,{right}", PRODUCT)


def _turn(halves: Constant) -> str:
    """A multiple of pi."""
    over, under = Fraction(halves).as_integer_ratio()
    return rf"\frac{{{'' if over == 1 else over}\pi}}{{{under}}}"


def number(value: Constant) -> Text:
    r"""A constant: whole, decimal as in double precision, m \cdot 10^{e}, or a fraction with small terms."""
    size = abs(Fraction(value))
    decimal = Decimal(repr(float(size))).normalize()
    if Fraction(decimal) != size and max(size.numerator, size.denominator) < 1000:
        return Text(value < 0, rf"\frac{{{size.numerator}}}{{{size.denominator}}}", ATOM)
    exponent = decimal.adjusted()
    if not size or -4 <= exponent < 6:
        return Text(value < 0, f"{decimal:f}", ATOM)
    mantissa = decimal.scaleb(-exponent)
    power = f"10^{{{exponent}}}"
    return Text(value < 0, power if mantissa == 1 else rf"{mantissa:f} \cdot {power}", PRODUCT)


def _stretches(printer: LatexPrinter, statements: Sequence[Statement]) -> Iterator[Stretch]:
    for section, group in by_section(statements):
        yield Stretch(section, tuple(printer.equation(statement) for statement in group))


def result_rows(function: Function, joints: Sequence[str]) -> dict[str, list[str]]:
    """For each result the numbers along its first axis: of joints, or counted from 1."""
    numbers = {name: str(j) for j, name in enumerate(joints, start=1)}
    rows = {}
    for result in function.results:
        names = result.rows if len(result.rows) == result.shape[0] else range(1, result.shape[0] + 1)
        rows[result.name] = [numbers.get(str(name), str(k)) for k, name in enumerate(names, start=1)]
    return rows


def entry_symbols(output: Output, rows: Sequence[str]) -> list[str]:
    """Symbols of the entries of a result, last index fastest."""
    below = list(rows)
    for depth, size in enumerate(output.shape[1:]):
        columns = rows if size == output.shape[0] else [str(k) for k in range(1, size + 1)]
        below = [f"{row}{'' if depth else ','}{column}" for row in below for column in columns]
    return [f"{_base(output)}_{{{index}}}" for index in below]


def array_symbols(output: Output, rows: Sequence[str]) -> list[str]:
    """Symbols of the vector, the matrix or the matrices that a result is."""
    return [f"{_base(output)}_{{{row}}}" for row in rows] if len(output.shape) == 3 else [_base(output)]


def _base(output: Output) -> str:
    return RESULTS.get(output.name) or literal(output.name)


def _result(printer: LatexPrinter, output: Output, rows: Sequence[str]) -> Iterator[Equation]:
    """The entries that are not a named variable already, then the arrays that are not too large."""
    texts = [printer.value(x) for x in output.entries]
    columns = output.shape[-1] if len(output.shape) > 1 else 1
    stacked = len(output.shape) == 3
    for k, symbol in enumerate(entry_symbols(output, rows)):
        if texts[k] not in (symbol, "0") and (len(texts[k]) > LONG or not stacked):
            yield Equation(symbol, texts[k])
            texts[k] = symbol
    arrays = array_symbols(output, rows)
    size = len(texts) // max(len(arrays), 1)
    for k, name in enumerate(arrays):
        if 0 < size <= MATRIX * columns and columns <= MATRIX:
            yield Equation(name, matrix(texts[k * size : (k + 1) * size], columns))


def matrix(entries: Sequence[str], columns: int) -> str:
    """A matrix of printed entries."""
    rows = [" & ".join(entries[k : k + columns]) for k in range(0, len(entries), columns)]
    return r"\begin{pmatrix} " + r" \\ ".join(rows) + r" \end{pmatrix}"
