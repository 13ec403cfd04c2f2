"""A package as C: one header and one source for each precision."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from symoro_elastic.codegen.body import C, Dialect, Indices, Writer, numbered
from symoro_elastic.codegen.c_printers import FUNCTIONS, CPrinter, angles_of, printer_of
from symoro_elastic.codegen.described import Files, described, shared
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.parts import Part, Step, cut
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.templates import render
from symoro_elastic.symbolic.expression import Expression, reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Statement

CIRCLES = ("sine", "cosine")
LARGE_STACK = 64_000


def render_c(package: Package, precision: Precision = DOUBLE) -> Files:
    """`<name>.h` and `<name>.c`, the precision in their names unless it is double."""
    names = [precision.function(package.name, function.name) for function in package.functions]
    package = replace(package, name=package.name + precision.suffix)
    functions = [
        _CFunction(package, function, precision, name).described()
        for function, name in zip(package.functions, names, strict=True)
    ]
    text = "\n".join(line for f in functions for part in (*f["prepare_parts"], *f["parts"]) for line in part["lines"])
    context = shared(package) | {
        "precision": precision,
        "macro": package.name.upper(),
        "functions": functions,
        "parameters": [
            {"name": p.name, "unit": in_comment(p.unit), "c_value": _number(p.value)} for p in package.parameters
        ],
        "mark": zlib.crc32(text.encode()),
        "functions_of_one": [name for name in FUNCTIONS if f"OF({precision.functions.get(name, name)})" in text],
        "uses_circles": any(f["angles"] for f in functions),
        "advances": precision.state == "float" and any(f.name == "direct_dynamics" for f in package.functions),
    }
    return {
        f"{package.name}.h": render("c/model.h.j2", **context),
        f"{package.name}.c": render("c/model.c.j2", **context),
    }


def in_comment(text: str) -> str:
    """A user's text as it may stand in a comment of C: one line that does not end the comment."""
    line = "".join(character if character.isprintable() else " " for character in text)
    return line.replace("*/", "* /").replace("/*", "/ *")


@dataclass(frozen=True)
class Array:
    """An array of a function: type, name, entries of one state, whether it is written, whether each state has one."""

    type: str
    name: str
    size: int = 0
    is_written: bool = False
    is_of_states: bool = True

    def declared(self, qualifier: str = "") -> str:
        """As in a signature."""
        return f"{'' if self.is_written else 'const '}{self.type} *{qualifier}{self.name}"


class _CFunction:
    """One model: its arrays, its parts, and what the templates are told."""

    def __init__(self, package: Package, function: Function, precision: Precision, name: str) -> None:
        self.package, self.function, self.precision, self.name = package, function, precision, name
        self.angles = angles_of(function.program)
        self.printer = printer_of(function.program, precision, self.angles)
        self.writer = Writer(self.printer, _declaring("NUMBER"), package.joint_names)
        self.of_parameters = Writer(self.printer, _declaring(precision.real), package.joint_names)
        state = precision.state
        macro = package.name.upper()
        self.indices = {p.name: f"{macro}_P_{p.name}" for p in package.parameters}
        self.inputs = [Array(state, a.name, a.size) for a in function.arguments]
        self.results = [Array(state, r.name, math.prod(r.shape), True) for r in function.results]
        self.parameters = [Array(state, "p", is_of_states=False)] if package.parameters else []
        self.constants_array = Array(precision.real, "c", is_of_states=False)
        self.entries: dict[str, Indices] = {
            a.name: {s: f"{k}*stride" for k, s in enumerate(a.symbols)} for a in function.program.inputs
        }

    def described(self) -> dict[str, Any]:
        """What the templates are told."""
        program = self.function.program
        stored, at_end = self._stored()
        parts, places = cut(_of_use(self._steps(program.statements), at_end), at_end)
        used = frozenset().union(*(part.uses for part in parts))
        constants = [s.name for s in program.once if s.name in used]
        prepare_parts, prepare_places = cut(self._steps(program.once), constants)
        live = Array("NUMBER", "live", places, True, False)
        arrays = [*self.inputs, *self.parameters, self.constants_array, *self._circles(), live, *self.results]
        of_constants = [self.constants_array] if constants else []
        at = [*self.inputs, *self.parameters, *of_constants, *self.results]
        last = len(parts) - 1
        return described(self.function) | {
            "c_name": self.name,
            "signature": _signature([*self.inputs, *self.parameters, *self.results]),
            "at_signature": _signature(at),
            "at_arrays": at,
            "inputs": self.inputs,
            "constants": constants,
            "constants_macro": f"{self.package.name.upper()}_{self.function.name.upper()}_CONSTANTS",
            "angles": len(self.angles),
            "angle_part": self._angle_part(),
            "places": places,
            "stack": self._stack(places),
            "prepare_places": prepare_places,
            "prepare_parts": _named(
                f"{self.name}_constants",
                [self._prepare_part(part, constants if part is prepare_parts[-1] else []) for part in prepare_parts],
            ),
            "parts": _named(
                f"{self.name}_state",
                [self._part(part, arrays, constants, stored if k == last else []) for k, part in enumerate(parts)],
            ),
            "unused": [a.name for a in (*self.inputs, *self.parameters) if not self._uses(a.name, used)],
            "empty": [r.name for r in self.results if not r.size],
        }

    def _stack(self, places: int) -> str:
        """Work arrays of one call and of a batch in kB, where they are large; empty elsewhere."""
        sizes = {"double": 8, "float": 4, "double_double": 16}
        one = places * sizes[self.precision.real] + 3 * len(self.angles) * sizes[self.precision.circle]
        batch = one * self.precision.widest
        return f"{max(1, one // 1000)} kB of stack, {batch // 1000} kB in a batch" if batch > LARGE_STACK else ""

    def _steps(self, statements: Sequence[Statement]) -> list[Step]:
        steps = []
        for statement in statements:
            self.printer.referenced.clear()
            self.printer.right_side(statement)
            steps.append(Step(statement, frozenset(self.printer.referenced)))
        return steps

    def _stored(self) -> tuple[list[str], frozenset[str]]:
        """Lines that store the results, and the names of the variables that these are."""
        self.printer.referenced.clear()
        lines = [
            f"    STORE({output.name} + {k}*stride, {self.printer.value(x)});"
            for output in self.function.program.outputs
            for k, x in enumerate(output.entries)
        ]
        return lines, frozenset(self.printer.referenced)

    def _circles(self) -> list[Array]:
        return [Array("ANGLE", name, len(self.angles), is_of_states=False) for name in CIRCLES]

    def _uses(self, array: str, used: frozenset[str]) -> bool:
        """Whether the work of a call needs an array."""
        if array == "p":
            return bool(used & self.indices.keys())
        angles = {symbol for angle in self.angles for symbol in _symbols(angle)}
        return bool((used | angles) & self.entries[array].keys())

    def _part(
        self, part: Part, arrays: Sequence[Array], constants: Sequence[str], stored: Sequence[str]
    ) -> dict[str, Any]:
        """Lines of a part and the arrays it uses."""
        groups: dict[str, Indices] = {**self.entries, "p": self.indices, "c": numbered(constants)}
        used = {name for name, group in groups.items() if part.uses & group.keys()} | (part.uses & set(CIRCLES))
        used |= {"live"} if part.taken or part.left else set()
        used |= {r.name for r in self.results if r.size} if stored else set()
        lines = [
            *self.writer.unpack(self.entries, part.uses, self._loaded("LOAD")),
            *self._of_parameters({"p": self.indices, "c": groups["c"]}, part.uses),
            *self._lines(part, self.writer),
        ]
        lines += ["", "    /* Results. */", *stored] if stored else []
        return _part_context(lines, [a for a in arrays if a.name in used])

    def _prepare_part(self, part: Part, constants: Sequence[str]) -> dict[str, Any]:
        real = self.precision.real
        lines = [*self._of_parameters({"p": self.indices}, part.uses), *self._lines(part, self.of_parameters)]
        lines += ["", *(f"    c[{k}] = {name};" for k, name in enumerate(constants))] if constants else []
        arrays = [*self.parameters] if part.uses & self.indices.keys() else []
        arrays += [Array(real, "live", 1, True, False)] if part.taken or part.left else []
        arrays += [Array(real, "c", 1, True, False)] if constants else []
        return _part_context(lines, arrays)

    def _lines(self, part: Part, writer: Writer) -> list[str]:
        """Statements, and what comes from earlier parts and goes on to later ones."""
        taken = writer.unpack({"live": {name: str(k) for name, k in part.taken.items()}}, part.uses)
        lines = [*taken, *writer.statements([s.statement for s in part.steps])]
        left = [f"    live[{k}] = {name};" for name, k in part.left.items()]
        return [*lines, "", *left] if left else lines

    def _of_parameters(self, groups: Mapping[str, Indices], used: Iterable[str]) -> list[str]:
        """Parameters and what depends on them only, by name; numbers of the caller become pairs."""
        given = {"p": "pair({array}[{k}], 0.0)"} if self.precision.is_pair else {}
        return self.of_parameters.unpack(groups, used, given)

    def _loaded(self, macro: str) -> dict[str, str]:
        """How entries of a state are found."""
        return dict.fromkeys(self.entries, f"{macro}({{array}} + {{k}})")

    def _angle_part(self) -> dict[str, Any]:
        """The part that finds the angles."""
        wide = replace(self.precision, real=self.precision.circle)
        printer: CPrinter = printer_of(self.function.program, wide, [])
        printer.variables.clear()
        lines = [f"    angle[{k}] = {printer.text(a).signed()};" for k, a in enumerate(self.angles)]
        symbols = {symbol for angle in self.angles for symbol in _symbols(angle)}
        writer = Writer(printer, _declaring("ANGLE"), self.package.joint_names)
        head = writer.unpack(self.entries, symbols, self._loaded("LOAD_ANGLE" if self.precision.is_mixed else "LOAD"))
        arrays = [a for a in self.inputs if symbols & self.entries[a.name].keys()]
        return _part_context([*head, *lines], [*arrays, Array("ANGLE", "angle", 1, True, False)])


def _symbols(angle: Expression) -> list[str]:
    return [node.operands[0] for node in reachable([angle]) if node.operation == SYMBOL]


def _of_use(steps: Sequence[Step], needed_at_end: Iterable[str]) -> list[Step]:
    """Steps that others or the results need: no sums whose sines and cosines are all that is asked of them."""
    needed, kept = set(needed_at_end), []
    for step in reversed(steps):
        if step.statement.name in needed:
            needed |= step.uses
            kept.append(step)
    return kept[::-1]


def _declaring(type_: str) -> Dialect:
    return replace(C, declare=f"const {type_} ")


def _part_context(lines: list[str], arrays: Sequence[Array]) -> dict[str, Any]:
    return {
        "lines": lines,
        "body": "\n".join(lines),
        "arrays": arrays,
        "signature": _signature(arrays, "restrict "),
    }


def _named(stem: str, parts: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Parts with names: the stem, numbered where there are several."""
    return [part | {"name": f"{stem}{k}" if len(parts) > 1 else stem} for k, part in enumerate(parts, start=1)]


def _signature(arrays: Sequence[Array], qualifier: str = "") -> str:
    return ", ".join(a.declared(qualifier) for a in arrays)


def _number(value: float) -> str:
    return "NAN" if math.isnan(value) else repr(value)
