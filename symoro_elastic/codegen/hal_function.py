"""A model as a function of C for components of LinuxCNC: little stack, parameters by their values."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from symoro_elastic.codegen.body import C, Writer
from symoro_elastic.codegen.c.lines import INDENT, WIDTH, comment, in_comment, statement, with_arguments
from symoro_elastic.codegen.c.printers import OWN_FUNCTIONS
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.printers import Printer
from symoro_elastic.symbolic.program import Statement, by_section

LARGEST_FRAME = 2560
"""Stack limit of a realtime function of LinuxCNC, bytes."""
OTHERS = 560
"""Bytes reserved for registers and calls."""


class HalWriter(Writer):
    """Writer of C assignments to variables that are declared beforehand."""

    def statements(self, statements: Sequence[Statement]) -> list[str]:
        """Assignments below the headings of their sections."""
        lines: list[str] = []
        for section, group in by_section(statements):
            lines += ["", comment(self.heading(section), INDENT)]
            lines += [statement(f"{INDENT}{s.name} = ", f"{self.printer.right_side(s)};") for s in group]
        return lines


class HalFunction:
    """A model of a package as a static function: `<name>_<model>(arguments, results)`."""

    def __init__(self, package: Package, function: Function, static: bool | None = None) -> None:
        """Prepare the function; `static` makes variables static; None: only those of a large model."""
        self.package, self.function = package, function
        self.name = f"{package.name}_{function.name}"
        self.own = {operation: f"{package.name}_{operation}" for operation in OWN_FUNCTIONS}
        self.printer = Printer(function.program, functions=self.own)
        self.writer = HalWriter(self.printer, C, package.joint_names)
        program, writer = function.program, self.writer
        self.lines = [*writer.statements(program.once), *writer.statements(program.statements), *self._stores()]
        self.entries = {symbol: f"{x.name}[{k}]" for x in program.inputs for k, symbol in enumerate(x.symbols)}
        self.read = [symbol for symbol in self.entries if symbol in self.printer.referenced]
        self.variables = [*self.read, *(s.name for s in (*program.once, *program.statements))]
        self.is_static = 8 * len(self.variables) > LARGEST_FRAME - OTHERS if static is None else static

    @property
    def called(self) -> set[str]:
        """The operations that need a helper function of the file."""
        return {key for key, name in self.own.items() if any(f"{name}(" in line for line in self.lines)}

    def text(self) -> str:
        """Return the definition of the C function."""
        copies = [f"{INDENT}{symbol} = {self.entries[symbol]};" for symbol in self.read]
        body = [*self._declarations(), *self._unread(), "", *copies, *self.lines]
        return "\n".join([*self._head(), "{", *body, "}"])

    def _stores(self) -> list[str]:
        lines = ["", f"{INDENT}/* Results. */"]
        for output in self.function.program.outputs:
            for k, x in enumerate(output.entries):
                lines.append(statement(f"{INDENT}{output.name}[{k}] = ", f"{self.printer.value(x)};"))
        return lines

    def _head(self) -> Iterator[str]:
        about = f"{self.function.title[:1].upper()}{self.function.title[1:]} {self.function.equations}."
        yield comment(in_comment(about))
        arrays = [f"const double {a.name}[{a.size}]" for a in self.function.arguments if a.size]
        arrays += [f"double {x.name}[{len(x.entries)}]" for x in self.function.program.outputs if x.entries]
        yield with_arguments(f"static void {self.name}", arrays)

    def _declarations(self) -> Iterator[str]:
        """Lines that define the used parameters as constants and declare the variables, several per line."""
        for p in self.package.parameters:
            if p.symbol in self.printer.referenced:
                about = ", ".join(x for x in (p.name if p.name != p.symbol else "", p.unit) if x)
                remark = f" /* {in_comment(about)} */" if about else ""
                yield f"{INDENT}static const double {p.symbol} = {p.value!r};{remark}"
        kind = "static double" if self.is_static else "double"
        names = ", ".join(self.variables)
        for line in textwrap.wrap(names, WIDTH - len(kind) - len(INDENT) - 2) if names else []:
            yield f"{INDENT}{kind} {line.rstrip(',')};"

    def _unread(self) -> Iterator[str]:
        """Lines that mark unread arguments for the compiler."""
        for argument in self.function.program.inputs:
            if argument.symbols and not {*argument.symbols} & {*self.read}:
                yield f"{INDENT}(void){argument.name};"
