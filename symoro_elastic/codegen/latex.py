"""The equations of a function as LaTeX: customised variables section by section, then the results."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

from symoro_elastic.codegen.notation import Notation, user_symbol
from symoro_elastic.codegen.package import Function, Package, Result
from symoro_elastic.codegen.printers import ATOM, PRODUCT, Printer, Text
from symoro_elastic.quantities import Quantity
from symoro_elastic.quantities.frames import BASE, JOINT, ROW
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Constant, Expression, Operand
from symoro_elastic.symbolic.program import Output, Program, Section, Statement, by_section

MATRIX = 8
LONG = 60
NUMBER = re.compile(r"(?:\\frac\{)?\d")
NAMED = {
    op.SIN: r"\sin",
    op.COS: r"\cos",
    op.SIGN: r"\operatorname{sign}",
    op.ATAN2: r"\operatorname{atan2}",
    op.COSPI: r"\cos",
    op.MINIMUM: r"\min",
    op.MAXIMUM: r"\max",
}


@dataclass(frozen=True)
class Equation:
    """`left = right` in LaTeX; a sum may be broken before ` + ` and ` - ` outside braces."""

    left: str
    right: str


@dataclass(frozen=True)
class Stretch:
    """A section of a program with its equations."""

    section: Section
    equations: tuple[Equation, ...]


@dataclass(frozen=True)
class Solution:
    """A function as equations: those for a parameter set, those for a call, and results."""

    once: tuple[Stretch, ...]
    steps: tuple[Stretch, ...]
    results: tuple[Equation, ...]
    notation: Notation


@dataclass(frozen=True)
class Array:
    """A result in LaTeX: symbols of its entries and of its vector or matrices, and the number of columns."""

    output: Output
    entries: tuple[str, ...]
    wholes: tuple[str, ...]
    columns: int

    @property
    def fits(self) -> bool:
        """Whether the vector or matrices are small enough to be shown."""
        rows = len(self.entries) // max(1, len(self.wholes) * self.columns)
        return 0 < rows <= MATRIX and self.columns <= MATRIX

    def matrices(self, texts: Sequence[str]) -> Iterator[tuple[str, Sequence[str]]]:
        """Symbol and entries of each matrix of the result."""
        size = len(texts) // max(1, len(self.wholes))
        for k, whole in enumerate(self.wholes):
            yield whole, texts[k * size : (k + 1) * size]


def solution(package: Package, function: Function) -> Solution:
    """Return the program of a package's function as LaTeX equations."""
    program = function.program
    notation = Notation(program)
    printer = LatexPrinter(program, notation)
    results = [line for array in arrays(package, function) for line in _result(printer, array)]
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
        """Equation of a statement; a function of a single symbol is written without brackets."""
        node = statement.node
        if node.operation in (op.SIN, op.COS, op.SIGN) and not statement.negative:
            argument = self.text(node.operands[0])
            if argument.binding == ATOM and not argument.negative:
                return Equation(self.notation[statement.name], f"{NAMED[node.operation]} {argument.text}")
        return Equation(self.notation[statement.name], self.right_side(statement))

    def text(self, x: Operand) -> Text:
        """LaTeX of an expression, by its symbol where it has one."""
        return super().text(x) if isinstance(x, Expression) else number(x)

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """LaTeX of a node's operation, its sign reversed when `flipped`."""
        operation, operands = node.operation, node.operands
        if operation == op.SYMBOL:
            return Text(flipped, self.notation[operands[0]], ATOM)
        if operation == op.PI:
            return Text(flipped, r"\pi", ATOM)
        if operation == op.MULTIPLY:
            return product(self.text(operands[0]), self.text(operands[1]), flipped)
        if operation == op.DIVIDE:
            over, under = map(self.text, operands)
            return Text((over.negative != under.negative) != flipped, rf"\frac{{{over.text}}}{{{under.text}}}", ATOM)
        if operation == op.SQRT:
            return Text(flipped, rf"\sqrt{{{self.value(operands[0])}}}", ATOM)
        if operation in NAMED:
            arguments = [self.value(x) for x in operands]
            if operation == op.COSPI:
                arguments = [_turn(operands[0])]
            return Text(flipped, f"{NAMED[operation]}({', '.join(arguments)})", ATOM)
        return super().operation(node, flipped)


def product(first: Text, second: Text, flipped: bool = False) -> Text:
    """Product of two printed factors: numbers in front, equal factors squared where that reads well."""
    negative = (first.negative != second.negative) != flipped
    if NUMBER.match(second.text):
        first, second = second, first
    before, after = first.factor(PRODUCT), second.factor(PRODUCT)
    if before == after and "^" not in before and first.binding != PRODUCT:
        return Text(negative, f"{before}^{{2}}", ATOM)
    return Text(negative, rf"{before} \cdot {after}" if NUMBER.match(after) else rf"{before}\,{after}", PRODUCT)


def _turn(halves: Constant) -> str:
    """LaTeX of a multiple of pi, from the multiple of pi/2."""
    over, under = Fraction(halves).as_integer_ratio()
    return rf"\frac{{{'' if over == 1 else over}\pi}}{{{under}}}"


def number(value: Constant) -> Text:
    r"""LaTeX of a constant: integer, decimal as in double precision, m \cdot 10^{e}, or a fraction of small terms."""
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


def arrays(package: Package, function: Function) -> list[Array]:
    """The results of a function with the symbols for LaTeX."""
    pairs = zip(function.program.outputs, function.results, strict=True)
    return [_array(package, output, result) for output, result in pairs]


def _array(package: Package, output: Output, result: Result) -> Array:
    names, quantity = result.rows, result.quantity
    joints, frames = _numbers(package)
    numbers = frames if quantity.axes[0] == "frames" else joints
    rows = [_row(quantity, names[k] if k < len(names) else "", k + 1, numbers) for k in range(output.shape[0])]
    entries = rows
    for axis, size in enumerate(output.shape[1:], start=2):
        indices = [str(k + 1) for k in range(size)]
        if axis == len(output.shape):
            indices = _columns(package, result, joints) or indices
        entries = [f"{entry},{index}" for entry in entries for index in indices]
    wholes = [f"{row}}}" for row in rows] if len(output.shape) == 3 else [quantity.symbol]
    columns = output.shape[-1] if len(output.shape) > 1 else 1
    return Array(output, tuple(f"{entry}}}" for entry in entries), tuple(wholes), columns)


def _numbers(package: Package) -> tuple[dict[str, str], dict[str, str]]:
    """Numbers of joints by joint name, and numbers of frames by frame name."""
    numbered = [(name, str(j)) for j, name in enumerate(package.joint_names, start=1)]
    rows, others = numbered[: len(package.antecedents)], numbered[len(package.antecedents) :]
    joints = {f"{what}{name}": j for name, j in rows for what in ("", f"{JOINT} ", f"{ROW} ")}
    return joints, {name: j for name, j in joints.items() if name != BASE} | dict(others)


def _columns(package: Package, result: Result, numbers: Mapping[str, str]) -> list[str]:
    """Indices of the columns of an array: labels of derivatives, or joints; none where they follow neither."""
    if result.quantity.is_derivative and result.columns:
        return [user_symbol(label) for label in result.columns]
    if result.quantity.columns_follow_rows:
        return [numbers.get(name, f"0,{k}") for k, name in enumerate(result.rows, start=1)]
    names = {"n": [axis.name for axis in package.axes], "m": package.motor_names}.get(result.quantity.axes[-1], ())
    return [numbers[name] for name in names] if len(result.shape) > 1 else []


def _row(quantity: Quantity, name: str, count: int, numbers: Mapping[str, str]) -> str:
    """Symbol and first index of an entry, by joint or frame; the observer frame is the left superscript.

    The index of a degree of freedom of the base is 0, and its number.
    """
    if name == BASE:
        return f"{quantity.symbol}_{{0,{count}"
    name, _, place = name.partition(" in ")
    home = "0" if quantity.frame0 else ""
    observer = numbers.get(place, "0") if place else home
    index = numbers.get(name, "0" if place else str(count))
    first = f"{quantity.index}," if quantity.index else ""
    return (f"{{}}^{{{observer}}}" if observer else "") + f"{quantity.symbol}_{{{first}{index}"


def _result(printer: LatexPrinter, array: Array) -> Iterator[Equation]:
    """Equations of a result: entries that are not a named variable, then its vector or matrices if small."""
    texts = [printer.value(x) for x in array.output.entries]
    inside = array.fits and len(array.output.shape) == 3
    for k, symbol in enumerate(array.entries):
        if texts[k] not in (symbol, "0") and not (inside and len(texts[k]) <= LONG):
            yield Equation(symbol, texts[k])
            texts[k] = symbol
    if array.fits:
        for whole, entries in array.matrices(texts):
            yield Equation(whole, matrix(entries, array.columns))


def matrix(entries: Sequence[str], columns: int) -> str:
    """LaTeX of a matrix of printed entries."""
    rows = [" & ".join(entries[k : k + columns]) for k in range(0, len(entries), columns)]
    return r"\begin{pmatrix} " + r" \\ ".join(rows) + r" \end{pmatrix}"
