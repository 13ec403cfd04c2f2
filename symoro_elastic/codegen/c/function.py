"""A model as C: its arrays, the parts of its work, and their lines.

Numbers loaded where they are first needed and stored where they are found.

Vectors of many states fill one register each; processors have 16 or 32. Compilers leave loads and stores where they
stand: entries that are all loaded first, or stored last, are copied to the stack and back in the meantime.
"""

from __future__ import annotations

import itertools
import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from symoro_elastic.codegen.body import C, Indices, Writer, positions_by_name
from symoro_elastic.codegen.c.constants import Literals, declaration
from symoro_elastic.codegen.c.lines import INDENT, statement
from symoro_elastic.codegen.c.printers import CPrinter, Form, angles_of, printer_of
from symoro_elastic.codegen.c.rows import Stored, copies, repeated_rows
from symoro_elastic.codegen.c.rows import lines as result_lines
from symoro_elastic.codegen.outlined import SPILL, Outline, Place, outline
from symoro_elastic.codegen.outlining import OPERAND, Block, blocks
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.partition import Part, Step, partition
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Statement, by_section

SINCOS = ("sine", "cosine")
PER_JOINT, PER_MOTOR = ("q", "qd", "qdd", "H"), ("tau", "qdd_motor")
"""Arrays with an entry for each joint whose variable is independent, each motor."""
OUTLINED_FROM = 2000
"""Number of statements of a program of a single state above which repeated blocks become functions."""


class Around(NamedTuple):
    """Lines to insert before and after statements, by the name of the statement's variable."""

    before: Mapping[str, Sequence[str]]
    after: Mapping[str, Sequence[str]]


NOTHING = Around({}, {})


def near_use(
    steps: Sequence[Step], loads: Mapping[str, str], stores: Iterable[tuple[str, str]]
) -> tuple[Around, list[str]]:
    """Return lines to insert around statements, and lines for the end, that load and store close to the use.

    `loads` are lines by the name that they define, `stores` pairs of a value and the line that stores it, in which
    others may be computed.
    """
    positions = {step.statement.name: k for k, step in enumerate(steps)}
    stored: dict[int, list[tuple[str, str]]] = defaultdict(list)
    for value, line in stores:
        own = [positions[name] for name in OPERAND.findall(value) if name in positions]
        stored[max(own, default=len(steps))].append((value, line))
    remaining = dict(loads)

    def first_used(names: Iterable[str]) -> list[str]:
        return [remaining.pop(name) for name in sorted(names) if name in remaining]

    def in_order(stores: Iterable[tuple[str, str]]) -> list[str]:
        return [text for value, line in stores for text in (*first_used(OPERAND.findall(value)), line)]

    before, after = {}, {}
    for k, step in enumerate(steps):
        before[step.statement.name] = first_used(step.uses)
        after[step.statement.name] = in_order(stored[k])
    return Around(before, after), in_order(stored[len(steps)])


@dataclass(frozen=True)
class Array:
    """An array parameter of a C function: type, name, size as text, number of entries, whether it is written."""

    type: str
    name: str
    size: str
    entries: int
    is_written: bool = False

    def declared(self) -> str:
        """The array as a parameter with its size; C has no arrays of size zero."""
        return f"{self._type} {self.name}[{self.size}]" if self.entries else f"{self._type} *{self.name}"

    def pointer(self) -> str:
        """The array as a pointer, for a size that depends on the number of states."""
        return f"{self._type} *{self.name}"

    @property
    def _type(self) -> str:
        return self.type if self.is_written else f"const {self.type}"


@dataclass(frozen=True)
class PartText:
    """A part of a function's statements: its lines, and the arrays that it uses."""

    lines: list[str]
    arrays: list[Array]

    @property
    def body(self) -> str:
        """The lines as one text."""
        return "\n".join(self.lines).lstrip("\n")


class _Blocks(NamedTuple):
    """Statements (name, right side), and the alternative partitions into blocks that are compared."""

    texts: Sequence[tuple[str, str]]
    tried: Sequence[Sequence[Block]]


class CWriter(Writer):
    """Writer of C statements; named numbers are declared in the section that first uses them."""

    def __init__(self, printer: CPrinter, type_: str, number: str, joints: Sequence[str]) -> None:
        """Prepare the writer; `type_` is the C type of variables, `number` that of named numbers."""
        super().__init__(printer, replace(C, declare=f"const {type_} "), joints)
        self.c_printer, self.number = printer, number

    def statements(
        self, statements: Sequence[Statement], known: Iterable[str] = (), around: Around = NOTHING
    ) -> list[str]:
        """Lines of the assignments, below the headings of their sections; numbers in `known` are declared already."""
        lines: list[str] = []
        declared = {*known}
        before, after = around
        for section, group in by_section(statements):
            assignments = [
                line for s in group for line in (*before.get(s.name, ()), self.assignment(s), *after.get(s.name, ()))
            ]
            used = {literal.name: literal for statement in group for literal in self.c_printer.named_numbers(statement)}
            numbers = [declaration(literal, self.number) for name, literal in used.items() if name not in declared]
            declared |= used.keys()
            lines += ["", f"{INDENT}/* {self.heading(section)} */", *itertools.chain(*numbers), *assignments]
        return lines

    def assignment(self, statement_: Statement) -> str:
        """Lines of a statement, broken where it is long."""
        head = f"{INDENT}{self.dialect.declare}{statement_.name} = "
        return statement(head, f"{self.printer.right_side(statement_)};")


class CFunction:
    """A model as a C function, for one state or for many in parallel, according to its form."""

    def __init__(
        self, package: Package, function: Function, precision: Precision, form: Form, twin: CFunction | None = None
    ) -> None:
        """Prepare the function; `twin` is the model in another form, whose text is reused where it is equal."""
        self.package, self.function, self.precision, self.form = package, function, precision, form
        self.name = precision.function(package.name, function.name)
        self.macro = (package.name + precision.suffix).upper()
        self.angles = angles_of(function.program)
        self._begin_text()
        self._declare_arrays()
        self._name_numbers()
        self._found: _Blocks | None = twin._found if twin and self._shares(twin) else None
        self._partition()

    def _begin_text(self) -> None:
        form, joints = self.form, self.package.joint_names
        self.printer = printer_of(self.function.program, self.precision, self.angles, form)
        self.writer = CWriter(self.printer, form.number, form.real, joints)
        self.once_writer = CWriter(self.printer, form.real, form.real, joints)

    def _declare_arrays(self) -> None:
        package, function, state = self.package, self.function, self.precision.state
        joints, motors = {len(package.axes): f"{self.macro}_JOINTS"}, {len(package.motor_names): f"{self.macro}_MOTORS"}
        dependent = {len(package.dependent or ()): f"{self.macro}_DEPENDENT"}
        named = dict.fromkeys(PER_JOINT, joints) | dict.fromkeys(PER_MOTOR, motors)
        named |= {f"{block.name}{end}": dependent for block in package.assembled for end in ("", "_out")}
        named |= {"p": {len(package.parameters): f"{self.macro}_PARAMETERS"}}
        self.indices = {p.symbol: f"{self.macro}_P_{p.name}" for p in package.parameters}
        *self.inputs, self.p = (
            Array(state, name, named.get(name, {}).get(size, str(size)), size)
            for name, size in package.inputs(function).items()
        )
        self.results = [
            Array(state, r.name, _size(r.shape, named.get(r.name, {})), math.prod(r.shape), True)
            for r in function.results
        ]
        self.entries: dict[str, Indices] = {a.name: positions_by_name(a.symbols) for a in function.program.inputs}

    def _partition(self) -> None:
        program = self.function.program
        self.stored, at_end = self._stores()
        self.steps = of_use(self._steps(program.statements), at_end)
        self.used = at_end.union(*(step.uses for step in self.steps))
        self.constants = [s.name for s in program.once if s.name in self.used]
        self.outline = self._outline(at_end)
        if self.outline:
            self.parts, self.slots = self.outline.parts, self.outline.slots
        else:
            self.parts, self.slots = partition(self.steps, at_end, self.form.part, apart=self.form.near_use)
        self.once_parts, self.once_slots = partition(self._steps(program.once), self.constants)
        size = f"{self.macro}_{self.function.name.upper()}_CONSTANTS"
        self.c = [Array(self.form.real, "c", size, len(self.constants))] if self.constants else []

    def _outline(self, at_end: frozenset[str]) -> Outline | None:
        """Outline with repeated blocks as functions, or None for short programs and for forms without outlining."""
        if not self.form.outlined or len(self.steps) < self.form.outlined * OUTLINED_FROM:
            return None
        texts = [(step.statement.name, self.printer.text_of(step.statement).text) for step in self.steps]
        named = [literal for step in self.steps for literal in self.printer.named_numbers(step.statement)]
        self.literals = {literal.name: literal for literal in named}
        places = self._places()
        self.operands = frozenset({*places, *self.literals, *(name for name, _ in texts)})
        sections = [step.statement.section for step in self.steps]
        if self._found is None or self._found.texts != texts:
            self._found = _Blocks(texts, blocks(texts, sections, self.operands))
        outlines = [outline(self.steps, cut, places, self.literals, at_end) for cut in self._found.tried]
        shortest = min(outlines, key=lambda outline: outline.length)
        return shortest if shortest.functions else None

    def _shares(self, twin: CFunction) -> bool:
        """Reuse the printed text of a twin and return True, or False if it prints numbers differently."""
        is_same = self.function.program is twin.function.program and self.precision is twin.precision
        is_same = is_same and self.form.narrow == twin.form.narrow and not self.precision.is_pair
        if is_same:
            self.printer.share(twin.printer)
        return is_same

    def _places(self) -> dict[str, Place]:
        """Array and index of each argument, constant, sine and cosine that statements read."""
        arrays: dict[str, Iterable[str]] = {**self.entries, "p": self.indices, "c": self.constants}
        arrays |= {array: [f"{array}[{k}]" for k in range(len(self.angles))] for array in SINCOS}
        return {name: Place(array, k) for array, names in arrays.items() for k, name in enumerate(names)}

    def _name_numbers(self) -> None:
        program, package = self.function.program, self.package
        used = {s.name for s in (*program.once, *program.statements)} | program.used
        used |= {x for a in program.inputs for x in (a.name, *a.symbols)} | {a.name for a in self.signature}
        used |= {p.symbol for p in package.parameters} | {*SINCOS, "angle", SPILL, "c"}
        written, constants = self.printer.written, self.function.constants
        self.printer.literals = Literals(constants, written, used, package.joint_names, package.antecedents)

    def type_of(self, array: str) -> str:
        """C type of the entries of an array that is passed to functions for repeated blocks."""
        types = {array.name: array.type for array in self.read} | {SPILL: self.form.number}
        return types.get(array, self.form.real)

    @property
    def c_written(self) -> list[Array]:
        """The array `c` of parameter-only values, as an output."""
        return [replace(array, is_written=True) for array in self.c]

    @property
    def arrays(self) -> list[Array]:
        """All arrays of the function variant that receives parameter-only values as an argument."""
        return [*self.inputs, self.p, *self.c, *self.results]

    @property
    def signature(self) -> list[Array]:
        """All arrays of the function that users call."""
        return [*self.inputs, self.p, *self.results]

    @property
    def read(self) -> list[Array]:
        """The arrays that the statements read, once sines and cosines are computed."""
        sincos = [Array(self.form.angle, name, str(len(self.angles)), 1) for name in SINCOS]
        return [*self.inputs, self.p, *self.c, *sincos]

    def part_texts(self) -> list[PartText]:
        """The parts of the computation after the sines and cosines, as text."""
        spill = Array(self.form.number, SPILL, str(self.slots), 1, True)
        arrays = [*self.read, spill, *self.results]
        last = self.parts[-1]
        return [self._part(part, arrays, self.stored if part is last else []) for part in self.parts]

    def once_texts(self) -> list[PartText]:
        """The parts of the computation that depends on parameters only, as text."""
        last = self.once_parts[-1]
        return [self._once_part(part, self.constants if part is last else []) for part in self.once_parts]

    def angle_texts(self) -> list[str]:
        """Texts of the angles whose sines and cosines are computed first."""
        program, entries = self.function.program, self.entries
        read = {
            symbol: self.form.load_angle.format(array=array, k=k)
            for array, group in entries.items()
            for symbol, k in group.items()
        }
        wide = replace(self.precision, literal_suffix="f" if self.precision.angle == "float" else "")
        printer = printer_of(program, wide, [], self.form)
        printer.variables.clear()
        texts = [printer.text(angle).signed() for angle in self.angles]
        self.printer.called |= printer.called
        return [re.sub(r"\b[A-Za-z_]\w*\b", lambda match: read.get(match[0], match[0]), text) for text in texts]

    def unused_arrays(self) -> Iterator[str]:
        """Names of arguments that no statement reads, and of results without stored entries."""
        symbols = {node.operands[0] for node in reachable(self.angles) if node.operation == SYMBOL} | self.used
        groups: dict[str, Indices] = {**self.entries, "p": self.indices}
        yield from (a.name for a in (*self.inputs, self.p) if not symbols & groups[a.name].keys())
        in_rows = {rows.result: len(rows.entries) for rows in self.rows}
        yield from (r.name for r in self.results if r.entries == in_rows.get(r.name, 0))

    def stack(self) -> int:
        """Size of the work arrays of a call, bytes."""
        sizes = {"double": 8, "float": 4, "double_double": 16}
        return self.slots * sizes[self.precision.real] + 3 * len(self.angles) * sizes[self.precision.angle]

    def _steps(self, statements: Sequence[Statement]) -> list[Step]:
        return [Step(statement, self.printer.text_of(statement).names) for statement in statements]

    def _stores(self) -> tuple[list[Stored], frozenset[str]]:
        """The result entries to store, and the names of the variables in their values."""
        outputs, value = self.function.program.outputs, self.printer.value
        self.rows = repeated_rows(outputs, value) if self.form.leaves_rows else []
        in_rows = {rows.result: rows.entries for rows in self.rows}
        self.printer.referenced.clear()
        stored = [
            Stored(output.name, k, value(x))
            for output in outputs
            for k, x in enumerate(output.entries)
            if k not in in_rows.get(output.name, ())
        ]
        return stored, frozenset(self.printer.referenced)

    def _part(self, part: Part, arrays: Sequence[Array], stored: Sequence[Stored]) -> PartText:
        copied = copies(stored, part.live_in) if self.form.outlined else {}
        results = result_lines(stored, copied, self.form.store, SPILL)
        part = self._without_copied(part, results) if copied else part
        c = positions_by_name(self.constants)
        groups: dict[str, Indices] = {**self.entries, "p": self.indices, "c": c}
        used = {name for name, group in groups.items() if part.uses & group.keys()} | (part.uses & set(SINCOS))
        used |= {SPILL} if part.spills or copied else set()
        used |= {r.name for r in self.results} - set(self.unused_arrays()) if stored else set()
        loads = self.writer.unpack_lines(self.entries, part.uses, dict.fromkeys(self.entries, self.form.load))
        loads |= self._of_parameters({"p": self.indices, "c": c}, part.uses)
        values = [entry.value for entry in stored]
        if self.form.near_use and not copied:
            lines, results = self._near_use(part, loads, zip(values, results, strict=True))
        else:
            lines = [*loads.values(), *self._lines(part, self.writer)]
        lines += ["", f"{INDENT}/* Results. */", *results] if stored else []
        return PartText(lines, [a for a in arrays if a.name in used])

    def _near_use(
        self, part: Part, loads: Mapping[str, str], results: Iterable[tuple[str, str]]
    ) -> tuple[list[str], list[str]]:
        """Lines of a part with loads and stores close to their use, and lines for the end."""
        loads = {**loads, **self._from_spill(part, self.writer)}
        around, at_end = near_use([*part.steps], loads, [*self._to_spill(part), *results])
        return self.writer.statements([step.statement for step in part.steps], around=around), at_end

    def _without_copied(self, part: Part, results: Sequence[str]) -> Part:
        """The part, restricted to the spilled variables that its statements and result lines read."""
        named = frozenset().union(*(step.uses for step in part.steps))
        named |= {word for line in results for word in OPERAND.findall(line)}
        return replace(part, live_in={name: slot for name, slot in part.live_in.items() if name in named})

    def _once_part(self, part: Part, constants: Sequence[str]) -> PartText:
        loads = self._of_parameters({"p": self.indices}, part.uses)
        lines = [*loads.values(), *self._lines(part, self.once_writer)]
        lines += ["", *(f"{INDENT}c[{k}] = {name};" for k, name in enumerate(constants))] if constants else []
        arrays = [self.p] if part.uses & self.indices.keys() else []
        arrays += [Array(self.form.real, SPILL, str(self.once_slots), 1, True)] if part.spills else []
        arrays += self.c_written if constants else []
        return PartText(lines, arrays)

    def _lines(self, part: Part, writer: CWriter) -> list[str]:
        """Lines of a part: variables read from the spill array, statements, variables written to it."""
        read = self._from_spill(part, writer).values()
        lines = [*read, *writer.statements([s.statement for s in part.steps])]
        spilled = [line for _, line in self._to_spill(part)]
        return [*lines, "", *spilled] if spilled else lines

    def _to_spill(self, part: Part) -> list[tuple[str, str]]:
        """Variables that later parts need, and the lines that store them in the spill array."""
        return [(name, f"{INDENT}{SPILL}[{k}] = {name};") for name, k in part.live_out.items()]

    def _from_spill(self, part: Part, writer: CWriter) -> dict[str, str]:
        """Lines that load variables of earlier parts from the spill array, by name."""
        return writer.unpack_lines({SPILL: {name: str(k) for name, k in part.live_in.items()}}, part.uses)

    def _of_parameters(self, groups: Mapping[str, Indices], used: Iterable[str]) -> dict[str, str]:
        """Lines that load parameters and parameter-only values, by name."""
        return self.once_writer.unpack_lines(groups, used, {"p": self.form.load_parameter})


def _size(shape: Sequence[int], names: Mapping[int, str]) -> str:
    """Size of a result as C text, a product for a matrix."""
    return "*".join(names.get(n, str(n)) if len(shape) == 1 else str(n) for n in shape) or "1"


def of_use(steps: Sequence[Step], needed_at_end: Iterable[str]) -> list[Step]:
    """Steps whose variables other steps or results use; unused ones, such as angles, are dropped."""
    needed, kept = set(needed_at_end), []
    for step in reversed(steps):
        if step.statement.name in needed:
            needed |= step.uses
            kept.append(step)
    return kept[::-1]
