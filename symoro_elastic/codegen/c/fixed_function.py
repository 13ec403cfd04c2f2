"""A model as C in fixed point: integers, products of 64 bits, shifts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from symoro_elastic.codegen.body import C, Writer
from symoro_elastic.codegen.c.lines import INDENT, statement, with_arguments
from symoro_elastic.codegen.c.printers import angles_of
from symoro_elastic.codegen.fixed_point import (
    LONGEST_OF_PRODUCT,
    LONGEST_SHIFT,
    OF_CIRCLE,
    TURN,
    TURN_BITS,
    FixedPoint,
    is_any_angle,
    number_of,
    power_of_two,
    quantize,
    symbols_of,
    turn_factor,
    whole_units,
)
from symoro_elastic.codegen.guaranteed import EntryRange
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.package_context import function_context
from symoro_elastic.codegen.printers import ATOM, PRODUCT, Printer, Text
from symoro_elastic.symbolic.expression import Expression, Operand
from symoro_elastic.symbolic.operations import ADD, MAXIMUM, MINIMUM, MULTIPLY, NEGATE, SIGN, SIN, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Statement


class FixedPrinter(Printer):
    """Prints expressions as C on integers with individual units; `called` are the helper functions needed."""

    def __init__(self, function: Function, fixed: FixedPoint, name: str) -> None:
        super().__init__(function.program)
        self.fixed, self.name = fixed, name
        self.angles = {angle.id: k for k, angle in enumerate(angles_of(function.program))}
        self.called: set[str] = set()

    def bits(self, x: Operand) -> int:
        """Number of bits after the binary point of an operand."""
        number = number_of(x)
        if number is not None:
            return quantize(number).bits
        return self.fixed.bits[x.id] if isinstance(x, Expression) else OF_CIRCLE

    def text(self, x: Operand) -> Text:
        """Text of an operand in its own unit."""
        number = number_of(x)
        return super().text(x) if number is None else self.whole(quantize(number).value)

    def whole(self, value: int) -> Text:
        """Text of an integer."""
        return Text(value < 0, str(abs(value)), ATOM)

    def operation(self, node: Expression, flipped: bool = False) -> Text:
        """Text of a node's operation, its sign reversed when `flipped`."""
        if node.operation in (SYMBOL, NEGATE):
            return super().operation(node, flipped)
        if node.operation in (ADD, SUBTRACT):
            first, second = (self.align(x, self.bits(node)) for x in node.operands)
            return self.operators[node.operation](flipped, first, second)
        if node.operation == MULTIPLY:
            return self.product(node, flipped)
        if node.operation == SIGN:
            return self.call_of(flipped, "sign", self.text(node.operands[0]).signed())
        if node.operation in (MINIMUM, MAXIMUM):
            return self.call_of(
                flipped, node.operation, *(self.align(x, self.bits(node)).signed() for x in node.operands)
            )
        return self.circle(node, flipped)

    def align(self, x: Operand, bits: int) -> Text:
        """Text of an operand rounded to fewer bits; an unnamed product is rounded only once."""
        number = number_of(x)
        if number is not None:
            return self.whole(quantize(number, bits).value)
        if isinstance(x, Expression) and x.id not in self.variables and x.operation == MULTIPLY:
            return self.product(x, False, self.bits(x) - bits)
        text, shift = self.text(x), self.bits(x) - bits
        if not shift:
            return text
        return self.shift_right(text, shift)

    def shift_right(self, x: Text, shift: int) -> Text:
        """Text of a number shifted right with rounding; zero where no bits remain."""
        if shift > LONGEST_SHIFT:
            return Text(False, f"0*{x.factor(ATOM)}", PRODUCT)
        return self.call_of(x.negative, "shifted", x.text, f"{shift}U")

    def product(self, node: Expression, flipped: bool, fewer: int = 0) -> Text:
        """Text of a product with `fewer` bits than its node; a factor that is a power of two only changes the unit."""
        x, y = node.operands
        first, second = self.text(x), self.text(y)
        if power_of_two(y) is not None:
            product = Text(first.negative != (second.negative != flipped), first.text, first.binding)
            return self.shift_right(product, fewer) if fewer else product
        shift = self.bits(x) + self.bits(y) - self.bits(node) + fewer
        negative = (first.negative != second.negative) != flipped
        if shift > LONGEST_OF_PRODUCT:
            return Text(False, f"0*{first.factor(ATOM)}*{second.factor(ATOM)}", PRODUCT)
        if not shift:
            return Text(negative, f"{first.factor(PRODUCT)}*{second.factor(ATOM)}", PRODUCT)
        return self.call_of(negative, "product", first.text, second.text, f"{shift}U")

    def circle(self, node: Expression, flipped: bool) -> Text:
        """Text of a sine or cosine: an array entry where its angle is an argument, else a call."""
        angle = node.operands[0]
        if angle.id in self.angles:
            array = "sine" if node.operation == SIN else "cosine"
            return Text(flipped, f"{array}[{self.angles[angle.id]}]", ATOM)
        return self.call_of(flipped, "sine" if node.operation == SIN else "cosine", self.angle(angle))

    def angle(self, x: Expression) -> str:
        """Text of an angle as a fraction of a turn."""
        if x.id in self.fixed.turns:
            return self.turn(x).signed()
        factor = turn_factor(self.bits(x))
        return self.call_of(False, "turns", self.text(x).signed(), str(factor.value), f"{factor.bits}U").text

    def turn(self, x: Expression) -> Text:
        """Text of a sum of fractions of a turn, as an unsigned integer that wraps around."""
        if x.operation == SYMBOL:
            return Text(False, f"(uint32_t){x.operands[0]}", ATOM)
        if x.operation == MULTIPLY:
            inner, times = self.turn(x.operands[0]), int(x.operands[1])
            return Text(inner.negative != (times < 0), f"{abs(times)}U*{inner.factor(ATOM)}", PRODUCT)
        return self.operators[x.operation](False, *(self.turn(y) for y in x.needs))

    def call_of(self, negative: bool, function: str, *arguments: str) -> Text:
        """Text of a call of a helper function of the file, which is recorded in `called`."""
        self.called.add(function)
        return Text(negative, f"{self.name}_{function}({', '.join(arguments)})", ATOM)


@dataclass(frozen=True)
class FixedArray:
    """An array argument of a function: name, size as text, and units of its entries by their binary exponents.

    Bits are None of an entry that is not used, `TURN_BITS` with `turns` True of a part of a turn.
    """

    name: str
    size: str
    bits: tuple[int | None, ...]
    turns: tuple[bool, ...]

    @property
    def units(self) -> tuple[str, ...]:
        """The units of the entries as C literals, SI; 0 for unused entries."""
        pairs = zip(self.bits, self.turns, strict=True)
        return tuple(
            repr(float(TURN)) if turns else "0.0" if bits is None else repr(math.ldexp(1.0, -bits))
            for bits, turns in pairs
        )

    @property
    def units_in_words(self) -> str:
        """The units of the entries as text."""
        parts = [
            f"{self.name}[{k}] " + (f"2^-{TURN_BITS} turn" if turns else "not used" if bits is None else f"2^{-bits}")
            for k, (bits, turns) in enumerate(zip(self.bits, self.turns, strict=True))
        ]
        return ", ".join(parts)


@dataclass(frozen=True)
class FixedText:
    """Template data of a model in fixed-point C."""

    name: str
    title: str
    counts: str
    documented: tuple[str, ...]
    arguments: tuple[FixedArray, ...]
    results: tuple[FixedArray, ...]
    prototype: str
    body: str
    in_box: str
    conditions: str
    in_si: str
    of_si: tuple[str, ...]
    called: frozenset[str]

    @property
    def arrays(self) -> tuple[FixedArray, ...]:
        """All arrays of the function: arguments, then results."""
        return (*self.arguments, *self.results)


class FixedFunction:
    """Builder of the fixed-point C text of a model."""

    def __init__(self, package: Package, function: Function, name: str) -> None:
        """Prepare the builder; `name` begins the C names; raises `ValueError` for a function without scales."""
        if function.fixed is None:
            raise ValueError(f"{function.name} has no scales")
        self.package, self.function, self.fixed = package, function, function.fixed
        self.prefix, self.name, self.macro = name, f"{name}_{function.name}", name.upper()
        self.printer = FixedPrinter(function, self.fixed, name)
        self.symbols = symbols_of(function.program)

    def text(self) -> FixedText:
        """Return the template data of the model."""
        about = function_context(self.function)
        arguments, results = tuple(self._arguments()), tuple(self._results())
        body = "\n".join(self._body())
        units = (f"units: {'; '.join(array.units_in_words for array in (*arguments, *results))}",)
        guaranteed = self.function.guaranteed.get("fixed-point")
        return FixedText(
            name=self.name,
            title=f"{about['title']} {about['equations']}.",
            counts=about["counts"],
            documented=(*about["documented"], *units, *(guaranteed.lines if guaranteed else ())),
            arguments=arguments,
            results=results,
            prototype=self._head("void", "", "int32_t", (*arguments, *results), len(arguments)),
            body=body,
            in_box=self._head("int", "_in_box", "int32_t", arguments, len(arguments)),
            conditions="\n".join(self._conditions(arguments, guaranteed.ranges if guaranteed else ())),
            in_si=self._head("void", "_si", "double", (*arguments, *results), len(arguments)),
            of_si=tuple(self._in_si(arguments, results)),
            called=frozenset(self.printer.called) | ({"sincos"} if self.printer.angles else set()),
        )

    def _head(self, result: str, end: str, type_: str, arrays: Sequence[FixedArray], read: int) -> str:
        declared = [
            f"{'const ' if k < read else ''}{type_} "
            + (f"{array.name}[{array.size}]" if array.bits else f"*{array.name}")
            for k, array in enumerate(arrays)
        ]
        return with_arguments(f"{result} {self.name}{end}", declared)

    def _arguments(self) -> Iterator[FixedArray]:
        symbols = {argument.name: argument.symbols for argument in self.function.program.inputs}
        for argument in self.function.arguments:
            names = [*symbols.get(argument.name, ())]
            units = [self._unit(name) for name in names] + [(None, False)] * (argument.size - len(names))
            bits, turns = zip(*units, strict=True) if units else ((), ())
            yield FixedArray(argument.name, str(argument.size), bits, turns)

    def _unit(self, name: str) -> tuple[int | None, bool]:
        """Number of bits after the point of a variable, and whether it is a fraction of a turn."""
        node, limited = self.symbols.get(name), self.fixed.only_limited
        turns = node.id in self.fixed.turns if node else name in limited and limited[name] is None
        return TURN_BITS if turns else self.fixed.bits[node.id] if node else limited.get(name), turns

    def _results(self) -> Iterator[FixedArray]:
        for output in self.function.program.outputs:
            size = "*".join(map(str, output.shape)) or "1"
            bits = tuple(map(self.printer.bits, output.entries))
            yield FixedArray(output.name, size, bits, (False,) * len(bits))

    def _body(self) -> Iterator[str]:
        program, printer = self.function.program, self.printer
        entries = {x.name: {symbol: str(k) for k, symbol in enumerate(x.symbols)} for x in program.inputs}
        lines = Writer(printer, replace(C, declare="const int32_t "), self.package.joint_names)
        used = {node.operands[0] for node in program.nodes if node.operation == SYMBOL}
        writer = _FixedWriter(lines)
        yield from (
            f"{INDENT}(void){a.name};" for a in self.function.arguments if not used & {*entries.get(a.name, ())}
        )
        yield from lines.unpack(entries, used)
        yield from self._angles()
        statements = [s for s in (*program.once, *program.statements) if s.node.id not in self.fixed.turns]
        yield from writer.statements(statements)
        yield ""
        for output in program.outputs:
            for k, x in enumerate(output.entries):
                yield statement(f"{INDENT}{output.name}[{k}] = ", f"{printer.value(x)};")

    def _angles(self) -> Iterator[str]:
        angles = angles_of(self.function.program)
        if angles:
            names, self.printer.variables = self.printer.variables, {}
            texts = ", ".join(map(self.printer.angle, angles))
            self.printer.variables = names
            count = len(angles)
            yield statement(f"{INDENT}const uint32_t angle[{count}] = ", f"{{{texts}}};")
            yield f"{INDENT}int32_t sine[{count}];"
            yield f"{INDENT}int32_t cosine[{count}];"
            yield f"{INDENT}for (size_t k = 0U; k < {count}U; k++) {{"
            yield f"{INDENT * 2}{self.prefix}_sincos(angle[k], &sine[k], &cosine[k]);"
            yield f"{INDENT}}}"

    def _conditions(self, arguments: Sequence[FixedArray], ranges: Sequence[EntryRange]) -> Iterator[str]:
        texts = []
        arrays = {array.name: array for array in arguments}
        for span in (span for span in ranges if span.argument in arrays):
            array = arrays[span.argument]
            if (bits := array.bits[span.entry]) is not None:
                texts += inside(f"{span.argument}[{span.entry}]", span, bits, array.turns[span.entry])
        named = " ".join(texts)
        yield from (f"{INDENT}(void){array.name};" for array in arguments if f"{array.name}[" not in named)
        yield f"{INDENT}return {f'{chr(10)}{INDENT * 2}&& '.join(texts) or '1'};"

    def _in_si(self, arguments: Sequence[FixedArray], results: Sequence[FixedArray]) -> Iterator[str]:
        yield from (f"{INDENT}(void){array.name};" for array in arguments if not any(map(float, array.units)))
        for array in (*arguments, *results):
            yield f"{INDENT}int32_t {array.name}_n[{max(len(array.bits), 1)}];"
        for array in arguments:
            for k, (unit, turns) in enumerate(zip(array.units, array.turns, strict=True)):
                of = f"{self.prefix}_of_angle({array.name}[{k}])"
                of = of if turns else f"{self.prefix}_of_number({array.name}[{k}], {unit})"
                yield f"{INDENT}{array.name}_n[{k}] = {of if unit != '0.0' else '0'};"
        yield with_arguments(f"{INDENT}{self.name}", [f"{array.name}_n" for array in (*arguments, *results)], ");")
        for array in results:
            for k, unit in enumerate(array.units):
                yield f"{INDENT}{array.name}[{k}] = {unit}*{array.name}_n[{k}];"


class _FixedWriter:
    """Prints statements with their units as comments."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer

    def statements(self, statements: Sequence[Statement]) -> list[str]:
        """Lines of the assignments, below the headings of their sections."""
        printer = self.writer.printer
        assert isinstance(printer, FixedPrinter)
        lines, section = [], None
        for s in statements:
            if s.section != section:
                section = s.section
                lines += ["", f"{INDENT}/* {self.writer.heading(section)} */"]
            right = f"{printer.right_side(s)}; /* 2^{-printer.bits(s.node)} */"
            lines.append(f"{INDENT}const int32_t {s.name} = {right}")
        return lines


def inside(entry: str, span: EntryRange, bits: int, turns: bool) -> list[str]:
    """C comparisons that test whether an integer entry is in a range; none for a full turn, "0" for an empty range."""
    first, last = whole_units(span.low, span.high, TURN if turns else Fraction(2) ** -bits)
    if first > last:
        return ["0"]
    if not turns:
        return [f"{entry} >= {first}", f"{entry} <= {last}"]
    if is_any_angle(span.low, span.high):
        return []
    return [f"(uint32_t){entry} - {first % 2**TURN_BITS}U <= {last - first}U"]
