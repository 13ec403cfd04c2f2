"""A program as function blocks of Structured Text: straight lines, in parts where the program is long."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from symoro_elastic.codegen.body import Dialect, Writer, c_continued
from symoro_elastic.codegen.package import Argument, Function, Package, ParameterValue, Result
from symoro_elastic.codegen.package_context import function_context
from symoro_elastic.codegen.partition import Part, Step, partition
from symoro_elastic.codegen.printers import ATOM, Printer, Text
from symoro_elastic.codegen.st.lines import INDENT, WIDTH, StNames, comment, declarations, in_comment, statement
from symoro_elastic.symbolic.operations import ATAN2, COS, MAXIMUM, MINIMUM, SIGN, SIN, SQRT
from symoro_elastic.symbolic.program import Statement, by_section, rename_variables

LONGEST_BLOCK = 4000
"""Statements of a function block: controllers limit the size of code."""
OWN_FUNCTIONS = (SIGN, ATAN2, MINIMUM, MAXIMUM)
"""Operations without a function in Structured Text, or with undefined NaN."""
PREPARED, WORK = "prepared", "work"
NEXT, START, AT_REST = "_next", "_start", "at_rest"
"""Suffixes of results that are arguments a period later, and of models of their start; name of the instance."""
ABSURD = 1e30
"""Initial value of a parameter without a value, which results make visible. It is within the range of REAL."""
ST = Dialect("", ";", lambda text: f"(* {in_comment(text)} *)", c_continued, {})


class StForm:
    """Number format of a Structured Text file, and its names of blocks, functions and array types."""

    def __init__(self, package: Package, type_: str, suffix: str) -> None:
        """Prepare the names; `type_` is LREAL or REAL; all names of the file end in `suffix`."""
        self.package, self.type, self.suffix = package, type_, suffix
        self.names = StNames()
        self.types: dict[int, str] = {}
        self._names_of_lengths = {
            len(package.dependent or ()): "dependent",
            len(package.motor_names): "motors",
            len(package.axes): "joints",
        }
        self.functions = {operation: self.name(operation) for operation in OWN_FUNCTIONS}
        self.called: set[str] = set()

    def name(self, what: str) -> str:
        """Return the full name of a block, a function or a type of the machine."""
        return self.names.give(f"{self.package.name}_{what}{self.suffix}")

    def array(self, length: int) -> str:
        """Return the type of arrays of a length; empty arrays have a type that is not used."""
        if length not in self.types:
            self.types[length] = self.name(self._names_of_lengths.get(length, f"x{length}"))
        return self.types[length]

    def number(self, x: float) -> str:
        """Return a literal with a decimal point, typed where compilers would assume LREAL."""
        digits, e, exponent = repr(abs(x)).partition("e")
        text = f"{digits if '.' in digits else f'{digits}.0'}{f'E{int(exponent)}' if e else ''}"
        return f"{'-' if x < 0 else ''}{'REAL#' if self.type == 'REAL' else ''}{text}"


@dataclass(frozen=True)
class StArray:
    """An array of a block: name, type, length, and its meaning, including its name in other targets."""

    name: str
    type: str
    length: int
    meaning: str = ""

    @property
    def declaration(self) -> list[str]:
        """Lines that declare the array, with its meaning as a comment after it or, if long, above it."""
        line = f"{INDENT * 2}{self.name} : {self.type};"
        if not self.meaning:
            return [line]
        with_meaning = f"{line} (* {self.meaning} *)"
        return [with_meaning] if len(with_meaning) <= WIDTH else [*comment(self.meaning, INDENT * 2), line]


@dataclass(frozen=True)
class StBlock:
    """Template data of a function block."""

    name: str
    about: tuple[str, ...]
    inputs: tuple[StArray, ...] = ()
    in_outs: tuple[StArray, ...] = ()
    results: tuple[StArray, ...] = ()
    given: tuple[str, ...] = ()
    parameters: tuple[str, ...] = ()
    variables: tuple[str, ...] = ()
    body: tuple[str, ...] = ()


class StPrinter(Printer):
    """Prints expressions as Structured Text: numbers with a decimal point, functions in capitals."""

    def __init__(self, function: Function, form: StForm) -> None:
        super().__init__(function.program, functions={SIN: "SIN", COS: "COS", SQRT: "SQRT", **form.functions})
        self.form = form

    def literal(self, value: float) -> Text:
        """Literal of a number in the type of the file."""
        plain = super().literal(value)
        return Text(plain.negative, self.form.number(abs(value)), ATOM)

    def call(self, operation: str, flipped: bool, texts: Sequence[Text]) -> Text:
        """Text of an operation as a function call."""
        self.form.called.add(operation)
        return super().call(operation, flipped, texts)


class StWriter(Writer):
    """Writer of statements in Structured Text."""

    def statements(self, statements: Sequence[Statement]) -> list[str]:
        """Lines of assignments below the headings of their sections, with few operators per line."""
        lines: list[str] = []
        for section, group in by_section(statements):
            lines += ["", *comment(self.heading(section), INDENT)]
            for assigned in group:
                lines += statement(f"{INDENT}{assigned.name} := ", self.printer.right_side(assigned))
        return lines


class StFunction:
    """A model as function blocks of Structured Text."""

    def __init__(self, form: StForm, function: Function, longest: int = LONGEST_BLOCK) -> None:
        """Prepare the blocks; `longest` is the maximum number of statements in a block."""
        self.form, self.package, self.longest = form, form.package, longest
        self.name, self.about = form.name(function.name), function_context(function)
        self.names = StNames((PREPARED, WORK, AT_REST), self.package.name)
        self.arguments = [*map(self._array, function.arguments)]
        self.results = [*map(self._array, function.results)]
        read = [p for p in self.package.parameters if p.symbol in function.program.used]
        self.parameters = {self.names.give(p.symbol): p for p in read}
        arguments = {argument.name: array for argument, array in zip(function.arguments, self.arguments, strict=True)}
        ends = zip(function.results, self.results, strict=True)
        same = {a.name: arguments.get(r.name.removesuffix(NEXT)) for r, a in ends if r.name.endswith(NEXT)}
        self.kept = {name: array for name, array in same.items() if array and array.length}
        """Arguments that are states kept by the block, by their results."""
        self.starting = next((f for f in self.package.functions if f.name == f"{function.name}{START}"), None)
        self.function = self._with_names(function)
        self.program = self.function.program
        self.printer = StPrinter(self.function, form)
        self.writer = StWriter(self.printer, ST, self.package.joint_names)

    def blocks(self) -> list[StBlock]:
        """Return the parts of a long model, then the block that users call."""
        steps = [Step(statement, self.printer.text_of(statement).names) for statement in self.program.statements]
        results = self._stores(in_parts=False)
        at_end = frozenset(self.printer.referenced)
        parts, slots = partition(steps, at_end, self.longest, self.longest)
        inputs = zip(self.arguments, self.program.inputs, strict=True)
        entries = {symbol: f"{a.name}[{k}]" for a, x in inputs for k, symbol in enumerate(x.symbols)}
        if len(parts) == 1:
            lines = [self._copy(symbol, entry) for symbol, entry in entries.items() if symbol in parts[0].uses]
            statements = self.program.statements
            body = [*self._start_lines(), *lines, *self._once(), *self.writer.statements(statements), *results]
            return [self._block(body, [*(x for x in entries if x in parts[0].uses), *(s.name for s in statements)])]
        return self._in_parts(parts, slots, entries, self._stores(in_parts=True))

    def _array(self, array: Argument | Result) -> StArray:
        length = array.size if isinstance(array, Argument) else math.prod(array.shape)
        name = self.names.give(array.name)
        meaning = array.meaning if name == array.name else f"{array.name}: {array.meaning}"
        return StArray(name, self.form.array(length), length, in_comment(meaning))

    def _with_names(self, function: Function) -> Function:
        """The function with valid Structured Text names for its variables."""
        program = function.program
        symbols = [*(p.symbol for p in self.parameters.values()), *(s for x in program.inputs for s in x.symbols)]
        changed = {name: self.names.give(name) for name in symbols if self.names.give(name) != name}
        program = rename_variables(program, changed) if changed else program

        def of(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
            return tuple(s._replace(name=self.names.give(s.name)) for s in statements)

        return replace(function, program=replace(program, once=of(program.once), statements=of(program.statements)))

    def _copy(self, to: str, source: str) -> str:
        return f"{INDENT}{to} := {source};"

    @property
    def missing(self) -> list[str]:
        """Names of the parameters without a value, which are inputs of the block."""
        return [name for name, p in self.parameters.items() if math.isnan(p.value)]

    def _once(self) -> list[str]:
        """Lines that compute parameter-only values: at the first call, unless some are inputs."""
        if not self.program.once:
            return []
        if self.missing:
            return self.writer.statements(self.program.once)
        inside = [f"{INDENT}{line}" for line in self.writer.statements(self.program.once)[1:]]
        return [f"{INDENT}IF NOT {PREPARED} THEN", *inside, f"{INDENT * 2}{PREPARED} := TRUE;", f"{INDENT}END_IF;"]

    def _start_lines(self) -> list[str]:
        """Lines that initialize the states of the block at rest on request."""
        if not self.kept or not self.starting:
            return []
        names = {x.name: array.name for x, array in zip(self.function.arguments, self.arguments, strict=True)}
        other = StFunction(self.form, self.starting)
        arguments = zip(self.starting.arguments, other.arguments, strict=True)
        call = ", ".join(f"{array.name} := {names[argument.name]}" for argument, array in arguments)
        lines = [f"{AT_REST}({call});", *(f"{array.name} := {AT_REST}.{array.name};" for array in self.kept.values())]
        flag = self.names.give(START[1:])
        return [f"{INDENT}IF {flag} THEN", *(f"{INDENT * 2}{line}" for line in lines), f"{INDENT}END_IF;"]

    @property
    def _state_lines(self) -> list[str]:
        """Declarations of the states of the block."""
        lines = [line for array in self.kept.values() for line in array.declaration]
        if self.kept and self.starting:
            lines.append(f"{INDENT * 2}{AT_REST} : {self.form.name(self.starting.name)};")
        return lines

    def _stores(self, *, in_parts: bool) -> list[str]:
        """Lines that store the results; states in their own array, unless they pass between parts."""
        lines = ["", f"{INDENT}(* Results. *)"]
        for array, output in zip(self.results, self.program.outputs, strict=True):
            for k, x in enumerate(output.entries):
                name = array.name if in_parts else self.kept.get(array.name, array).name
                lines += statement(f"{INDENT}{name}[{k}] := ", self.printer.value(x))
        return lines

    def _block(self, body: Iterable[str], names: Sequence[str], more: Sequence[str] = ()) -> StBlock:
        """The public block with statements `body`, variables `names` and `more` declarations."""
        once, missing = [s.name for s in self.program.once], self.missing
        variables = [*more, *self._state_lines, *declaration_of([*once, *names], self.form.type)]
        variables += [f"{INDENT * 2}{PREPARED} : BOOL := FALSE;"] if once and not missing else []
        return StBlock(
            self.name,
            self._about(),
            inputs=tuple(self._given()),
            results=tuple(a for a in self.results if a.length and a.name not in self.kept),
            given=tuple(parameter_line(x, p, self.form) for x, p in self.parameters.items() if x in missing),
            parameters=tuple(parameter_line(x, p, self.form) for x, p in self.parameters.items() if x not in missing),
            variables=tuple(variables),
            body=tuple(body),
        )

    def _given(self) -> Iterator[StArray]:
        """Yield the inputs of the block that users call."""
        if self._start_lines():
            meaning = "TRUE at the first call: states begin at rest at the set point, under the torque tau"
            yield StArray(self.names.give(START[1:]), "BOOL", 1, meaning)
        yield from (a for a in self.arguments if a.length and a not in self.kept.values())

    def _about(self) -> tuple[str, ...]:
        """Lines about the block: title, equations, operations, and remarks on arguments and results."""
        sentences: list[str] = []
        for line in self.about["documented"]:
            if ": " in line:
                sentences.append(line)
            elif sentences and sentences[-1].endswith(","):
                sentences[-1] += f" {line.strip()}"
        remarks = [line for line in sentences if not line.startswith("->")]
        own = {f"{a.name} (" for a in self.function.arguments}
        remarks = [line for line in remarks if not line.startswith(tuple(own))] if own else remarks
        return f"{self.about['title']} {self.about['equations']}.", self.about["counts"], *remarks

    # Parts of a long program, which hand on their variables in one array

    def _in_parts(
        self, parts: Sequence[Part], slots: int, entries: dict[str, str], results: Sequence[str]
    ) -> list[StBlock]:
        """Blocks for the parts and the block that calls them; arguments and parameters share the work array."""
        inputs = [*entries, *self.parameters, *(s.name for s in self.program.once)]
        used = frozenset().union(*(part.uses for part in parts))
        places = {name: slots + k for k, name in enumerate(x for x in inputs if x in used)}
        work = StArray(WORK, self.form.array(slots + len(places)), slots + len(places))
        blocks = [
            self._part(k, part, places, work, results if part is parts[-1] else [])
            for k, part in enumerate(parts, start=1)
        ]
        body = [f"{INDENT}{WORK}[{k}] := {entries.get(name, name)};" for name, k in places.items()]
        calls = [f"{INDENT}part{k}({WORK} := {WORK});" for k in range(1, len(blocks) + 1)]
        last = f"part{len(blocks)}"
        copied = [f"{INDENT}{self.kept.get(a.name, a).name} := {last}.{a.name};" for a in self.results if a.length]
        own = [f"{INDENT * 2}part{k} : {block.name};" for k, block in enumerate(blocks, start=1)]
        own += [f"{INDENT * 2}{WORK} : {work.type};"]
        return [*blocks, self._block([*self._start_lines(), *self._once(), *body, *calls, *copied], [], own)]

    def _part(self, number: int, part: Part, places: dict[str, int], work: StArray, results: Sequence[str]) -> StBlock:
        """Block of a part, which reads its inputs from the work array and writes variables for other parts there."""
        read = {**part.live_in, **{name: k for name, k in places.items() if name in part.uses}}
        statements = [step.statement for step in part.steps]
        lines = [self._copy(name, f"{WORK}[{k}]") for name, k in read.items()]
        lines += self.writer.statements(statements)
        lines += ["", *(self._copy(f"{WORK}[{k}]", name) for name, k in part.live_out.items())]
        return StBlock(
            self.form.name(f"{self.function.name}_p{number}"),
            (f"Part {number} of {self.name}.",),
            in_outs=(work,),
            results=tuple(a for a in self.results if a.length) if results else (),
            variables=tuple(declaration_of([*read, *(s.name for s in statements)], self.form.type)),
            body=(*lines, *results),
        )


def declaration_of(names: Sequence[str], type_: str) -> list[str]:
    """Return lines that declare variables of the same type."""
    return declarations(names, type_, INDENT * 2) if names else []


def parameter_line(name: str, parameter: ParameterValue, form: StForm) -> str:
    """Return the declaration of a parameter, with its value."""
    remarks = [parameter.name] if name != parameter.name else []
    remarks += [parameter.unit] if parameter.unit else []
    value = ABSURD if math.isnan(parameter.value) else parameter.value
    remark = f" (* {in_comment(', '.join(remarks))} *)" if remarks else ""
    return f"{INDENT * 2}{name} : {form.type} := {form.number(value)};{remark}"
