"""A model whose congruent limbs are lanes of vectors: one statement for the quantities of two or four limbs.

Vectors are an extension of GCC and Clang; their operators accept a number for all lanes. A vector has the name of its
first lane, so statements read as those of the first limb; `x[1]` is the quantity of the second. Sums are carried out
as without vectors, so results have the same bits where products and sums are not fused.
"""

from __future__ import annotations

import heapq
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from graphlib import TopologicalSorter

from symoro_elastic.codegen.body import Indices
from symoro_elastic.codegen.c.function import CFunction, CWriter, PartText, of_use
from symoro_elastic.codegen.c.lines import INDENT, statement
from symoro_elastic.codegen.c.printers import FUNCTIONS, CPrinter
from symoro_elastic.codegen.c.rows import Stored
from symoro_elastic.codegen.outlined import SPILL
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.partition import Part, Step, partition
from symoro_elastic.codegen.printers import ATOM, PRODUCT, Printed, Text
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.operations import NEGATE, SYMBOL
from symoro_elastic.symbolic.program import Program, Section, Statement, free_name, names_in
from symoro_elastic.symbolic.symmetry import WIDTHS, Vector, lanes_of

WORTH = 0.8
"""Part of the operations without vectors that is left where vectors are written: gathers cost what less would save."""
TYPE = "lanes{}"
"""The name in C of a vector of so many numbers."""
OPERATORS = re.compile(r" [-+] |[*/]")


def in_lanes(function: CFunction, kind: type[LanesFunction] | None = None) -> LanesFunction | None:
    """The model with congruent limbs as lanes of vectors; None where that saves less than a fifth of its operations."""
    if not function.package.congruent or function.precision.is_pair:
        return None
    lanes = (kind or LanesFunction)(function)
    return lanes if lanes.lanes.vectors and operations(lanes) <= WORTH * operations(function) else None


def operations(function: CFunction) -> int:
    """Number of multiplications, divisions and additions in the text of a call, on vectors or numbers."""
    return sum(len(OPERATORS.findall(function.printer.text_of(step.statement).text)) for step in function.steps)


class Variables:
    """The variables of a program in lanes: vectors, named after their first lanes, and the remaining numbers.

    `statements` are those of both. `gathered` are the lanes of vectors of arguments, or of what depends on parameters
    only, with their signs. `of_vectors` and `of_numbers` are the texts of all that has a name.
    """

    def __init__(self, program: Program, package: Package, number: str) -> None:
        """Find and name the vectors; `number` is the C type of a number."""
        self.lanes, self.number = lanes_of(program.nodes, package.congruent), number
        self._package = package
        self._own = {s.node.id: s for s in (*program.once, *program.statements)}
        self.of_numbers = {number: Text(s.negative, s.name, ATOM) for number, s in self._own.items()}
        self.of_vectors: dict[Vector, Text] = {}
        self.vectors: dict[str, Vector] = {}
        self.gathered: dict[str, dict[str, str]] = {}
        self.statements: list[Statement] = []
        self._names = names_in(program)
        self._name_gathered(program)
        self._name_statements(program)

    def _name_gathered(self, program: Program) -> None:
        """Create vectors of congruent arguments, parameters and parameter-only values."""
        names = {x.id: (x.operands[0], False) for x in program.nodes if x.operation == SYMBOL}
        names |= {s.node.id: (s.name, s.negative) for s in program.once}
        for number, (name, negative) in names.items():
            lane = self.lanes.get(number)
            if lane and lane.number == 0 and all(x.id in names for x in lane.vector.nodes):
                lanes = [(*names[x.id], sign < 0) for x, sign in zip(lane.vector.nodes, lane.vector.signs, strict=True)]
                self.gathered[name] = {x: "-" if minus ^ flipped ^ negative else "" for x, minus, flipped in lanes}
                self._declare(lane.vector, name, negative)

    def _name_statements(self, program: Program) -> None:
        """Create vectors of congruent statements, and of congruent subexpressions of other statements and results."""
        for s in program.statements:
            lane = self.lanes.get(s.node.id)
            if lane is None:
                self._name_within(s.node.needs, s.name, s.section)
                self.statements.append(s)
            elif lane.vector not in self.of_vectors:
                self._name(lane.vector, s)
        for output in program.outputs:
            entries = [x for x in output.entries if isinstance(x, Expression)]
            self._name_within(entries, output.name, Section("Results"))

    def _name_within(self, roots: Iterable[Expression], name: str, section: Section) -> None:
        """Create vectors for the largest subexpressions of `roots` that are lanes of unnamed vectors."""
        stack = [*roots]
        while stack:
            node = stack.pop()
            lane = self.lanes.get(node.id)
            if node.id in self.of_numbers or node.operation in (SYMBOL, *FUNCTIONS):
                continue
            if lane is None or node.operation == NEGATE:
                stack += node.needs
            else:
                self._name(lane.vector, Statement(free_name(f"{name}_of_limbs", self._names), node, False, section))

    def _name(self, vector: Vector, s: Statement) -> None:
        """Name a vector after its first lane, or after statement `s` if that lane has no name."""
        first, is_own = vector.nodes[0], self.is_own(vector)
        s = self._own.get(first.id, s) if is_own else s
        self._name_operands(vector, s)
        negative = s.negative and s.node is first
        self._declare(vector, s.name, negative)
        self.statements.append(Statement(s.name, first, negative, self._of_all(s.section)))

    def _name_operands(self, vector: Vector, s: Statement) -> None:
        """Create vectors of operands whose lanes are also used as single numbers."""
        for x in vector.operands:
            if isinstance(x, Vector) and x not in self.of_vectors:
                if self.is_own(x):
                    self._name_operands(x, s)
                else:
                    self._name(x, Statement(free_name(f"{s.name}_of_limbs", self._names), x.nodes[0], False, s.section))

    def is_own(self, vector: Vector) -> bool:
        """Whether the numbers in this vector are computed as its lanes only."""
        lane = self.lanes.get(vector.nodes[0].id)
        return lane is not None and lane.vector is vector

    def _declare(self, vector: Vector, name: str, negative: bool) -> None:
        self.vectors[name] = vector
        self.of_vectors[vector] = Text(negative, name, ATOM)
        for k, (node, sign) in enumerate(zip(vector.nodes, vector.signs, strict=True)):
            if self.is_own(vector):
                self.of_numbers[node.id] = Text((sign < 0) != negative, f"{name}[{k}]", ATOM)

    def _of_all(self, section: Section) -> Section:
        """Section of a limb with its title extended by the congruent joints of the other limbs."""
        joints = next((joints for joints in self._package.limbs if section.joint in joints), ())
        names = self._package.joint_names
        texts = [f"{j} ({names[j - 1]})" for j in joints if j != section.joint]
        return section._replace(equations=f"with {', '.join(texts)} {section.equations}") if texts else section

    def type_of(self, name: str) -> str:
        """The type of a variable in C."""
        return TYPE.format(self.vectors[name].width) if name in self.vectors else self.number

    @property
    def width(self) -> int:
        """Number of lanes of the longest vectors."""
        return max((vector.width for vector in self.vectors.values()), default=min(WIDTHS))

    def width_of(self, name: str) -> int:
        """Number of lanes of a variable, 1 of a number."""
        return self.vectors[name].width if name in self.vectors else 1

    def from_spill(self, name: str, slot: str) -> str:
        """Text of a variable read from a slot of the spill array, whose slots have the width of the longest vector."""
        lanes = self._in_slot(name, slot)
        return f"{{{', '.join(lanes)}}}" if len(lanes) > 1 else lanes[0]

    def to_spill(self, name: str, slot: str) -> str:
        """The line that stores a variable in a slot of the spill array."""
        lanes = self._in_slot(name, slot)
        values = [f"{name}[{k}]" for k in range(len(lanes))] if len(lanes) > 1 else [name]
        return INDENT + " ".join(f"{lane} = {value};" for lane, value in zip(lanes, values, strict=True))

    def _in_slot(self, name: str, slot: str) -> list[str]:
        """Text of a slot, or of the numbers in it if a variable is narrower than the longest vectors."""
        width, place = self.width_of(name), f"{SPILL}[{slot}]"
        return [place] if width == self.width else [f"{place}[{k}]" for k in range(width)]


class LanesPrinter(CPrinter):
    """Prints vector statements by their first lanes, and statements on numbers, which may be lanes of vectors."""

    lanes: Variables

    def text_of(self, statement: Statement) -> Printed:
        """The expression that a statement assigns, and the names in it, those of all lanes of gathered vectors too."""
        vector = self.lanes.vectors.get(statement.name)
        if vector is None:
            printed = super().text_of(statement)
            return printed._replace(names=self.names(printed.names))
        self._statement, outside, self.referenced = statement, self.referenced, set()
        text = self._vector(vector, statement.negative).signed()
        printed = Printed(
            text if vector.operands else text.replace(f"({TYPE.format(vector.width)})", ""), self.names(self.referenced)
        )
        self._statement, self.referenced = None, outside
        return printed

    def names(self, printed: Iterable[str]) -> frozenset[str]:
        """Names of variables in printed texts such as `v[0]`, with the names of all lanes of gathered vectors."""
        names = {name.partition("[")[0] for name in printed}
        return frozenset(names.union(*(self.lanes.gathered.get(name, ()) for name in names)))

    def _vector(self, vector: Vector, flipped: bool = False) -> Text:
        """Text of the operation of a vector."""
        operation = vector.nodes[0].operation
        if not vector.operands:
            texts = [self.operation(x) if self.lanes.is_own(vector) else self.text(x) for x in vector.nodes]
            return Text(flipped, f"({TYPE.format(vector.width)}){{{', '.join(x.signed() for x in texts)}}}", ATOM)
        texts = [self._operand(vector, k) for k in range(len(vector.operands))]
        return self.operators[operation](flipped, *texts)

    def _operand(self, vector: Vector, k: int) -> Text:
        """Text of operand k of a vector, by name where it has one."""
        x, flips = vector.operands[k], vector.flips if k else ()
        if isinstance(x, Vector):
            text = self.lanes.of_vectors.get(x)
            self.referenced |= {text.text} if text else set()
            text = text or self._vector(x)
        elif isinstance(x, tuple):
            values = [self.constants[y.id] if isinstance(y, Expression) else float(y) for y in x]
            signed = [sign * value for sign, value in zip(flips or (1,) * vector.width, values, strict=True)]
            return Text(False, self._numbers(vector.width, signed), ATOM)
        else:
            text = self.text(x)
        if not flips:
            return text
        return Text(text.negative, f"{self._numbers(vector.width, flips)}*{text.factor(ATOM)}", PRODUCT)

    def _numbers(self, width: int, values: Iterable[float]) -> str:
        return f"({TYPE.format(width)}){{{', '.join(self._number(float(value)).signed() for value in values)}}}"


class LanesWriter(CWriter):
    """Writer of C statements on vectors and numbers."""

    lanes: Variables

    def assignment(self, statement_: Statement) -> str:
        """A statement, preceded by the type of its variable."""
        head = f"{INDENT}const {self.lanes.type_of(statement_.name)} {statement_.name} = "
        return statement(head, f"{self.printer.right_side(statement_)};")

    def unpack_lines(
        self, arguments: Mapping[str, Indices], used: Iterable[str], read: Mapping[str, str] | None = None
    ) -> dict[str, str]:
        """The lines that unpack entries of arrays, those of congruent joints into a vector."""
        lanes, used = self.lanes, {*used}
        if SPILL in arguments:
            spilled = {name: lanes.from_spill(name, k) for name, k in arguments[SPILL].items() if name in used}
            return {name: f"{INDENT}const {lanes.type_of(name)} {name} = {value};" for name, value in spilled.items()}
        gathered = {name: names for name, names in lanes.gathered.items() if name in used}
        hidden = {name for names in gathered.values() for name in names}
        lines = super().unpack_lines(arguments, used, read)
        right = {name: line.partition(" = ")[2].rstrip(";") for name, line in lines.items()}
        for name in gathered.keys() & lines.keys():
            of_lanes = ", ".join(sign + right[x] for x, sign in gathered[name].items())
            lines[name] = f"{INDENT}const {lanes.type_of(name)} {name} = {{{of_lanes}}};"
        return {name: line for name, line in lines.items() if name in gathered or name not in hidden}


class LanesFunction(CFunction):
    """A model as C on one state, congruent limbs in lanes of vectors; `scalar` is the version without vectors."""

    variables = Variables

    def __init__(self, scalar: CFunction) -> None:
        self.scalar, self.lanes = scalar, self.variables(scalar.function.program, scalar.package, scalar.form.number)
        form = replace(scalar.form, number=TYPE.format(self.lanes.width), outlined=0)
        super().__init__(scalar.package, scalar.function, scalar.precision, form)

    def _begin_text(self) -> None:
        self.printer = self.in_lanes = LanesPrinter(self.function.program, self.precision, self.angles, self.form)
        self.in_lanes.lanes, self.in_lanes.variables = self.lanes, self.lanes.of_numbers
        self.writer = self.once_writer = LanesWriter(
            self.printer, self.form.real, self.form.real, self.package.joint_names
        )
        self.writer.lanes = self.lanes

    def _partition(self) -> None:
        steps = _in_order(self._steps(self.lanes.statements))
        self.stored, at_end = self._stores()
        self.steps = of_use(steps, at_end)
        self.used = at_end.union(*(step.uses for step in self.steps))
        self.constants, self.c, self.outline = self.scalar.constants, self.scalar.c, None
        self.once_slots = self.scalar.once_slots
        self.parts, self.slots = partition(self.steps, at_end, self.form.part)

    def once_texts(self) -> list[PartText]:
        """The parts of the computation that depends on parameters only, without vectors, as text."""
        return self.scalar.once_texts()

    def _stores(self) -> tuple[list[Stored], frozenset[str]]:
        stored, names = super()._stores()
        return stored, self.in_lanes.names(names)

    def _to_spill(self, part: Part) -> list[tuple[str, str]]:
        return [(name, self.lanes.to_spill(name, str(k))) for name, k in part.live_out.items()]


def _in_order(steps: Sequence[Step]) -> list[Step]:
    """Steps in an order in which each follows the steps that it uses; otherwise their order is kept."""
    places = {step.statement.name: k for k, step in enumerate(steps)}
    sorter = TopologicalSorter({k: [places[x] for x in step.uses if x in places] for k, step in enumerate(steps)})
    sorter.prepare()
    ready, result = sorted(sorter.get_ready()), []
    while ready:
        k = heapq.heappop(ready)
        result.append(steps[k])
        sorter.done(k)
        for following in sorter.get_ready():
            heapq.heappush(ready, following)
    return result
