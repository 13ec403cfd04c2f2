"""Straight-line programs: the nodes that outputs need of a graph, in order, named after quantities."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import cached_property
from string import ascii_lowercase
from typing import NamedTuple, TypeAlias

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.factoring import factor_graph
from symoro_elastic.symbolic.operations import NEGATE, OPERATIONS, SYMBOL

MAX_INLINE_DEPTH = 8


@dataclass(frozen=True)
class OperationCount:
    """Operations of a program; a subtraction counts as `add`, a sign change as nothing."""

    mul: int = 0
    add: int = 0
    div: int = 0
    sincos: int = 0

    @property
    def products(self) -> int:
        """Products and divisions."""
        return self.mul + self.div

    def __add__(self, other: OperationCount) -> OperationCount:
        return OperationCount(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))


class Section(NamedTuple):
    """A part of a program, such as a joint's part of a recursion, with its equations."""

    title: str
    joint: int | None = None
    equations: str = ""


class Label(NamedTuple):
    """Name of the quantity that an expression is, and where it belongs."""

    name: str
    section: Section


@dataclass(frozen=True)
class Input:
    """An array argument: the symbols in its entries."""

    name: str
    symbols: tuple[str, ...]


@dataclass(frozen=True)
class Output:
    """An array result: shape and entries, last index fastest."""

    name: str
    shape: tuple[int, ...]
    entries: tuple[Operand, ...] = field(repr=False)


class Statement(NamedTuple):
    """`name = expression`, or `name = -expression` when `negative`."""

    name: str
    node: Expression
    negative: bool
    section: Section


@dataclass(frozen=True)
class NamedConstant:
    """A quantity whose value is a constant: it appears as a number in statements."""

    label: Label
    value: Operand


@dataclass(frozen=True)
class Program:
    """Statements in order of execution; `once` depend on parameters only, `constants` on nothing.

    `named_constants` are the named quantities that turned out constant, `quantities` all others by each of their names:
    a node has one variable, but may be several quantities.
    """

    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    once: tuple[Statement, ...]
    statements: tuple[Statement, ...]
    used: frozenset[str]
    count: OperationCount
    count_once: OperationCount
    constants: tuple[Expression, ...] = ()
    named_constants: tuple[NamedConstant, ...] = ()
    quantities: Mapping[str, Operand] = field(default_factory=dict, repr=False)

    def __repr__(self) -> str:
        """Return the numbers of statements in a line, for messages of failed tests."""
        outputs = ", ".join(output.name for output in self.outputs)
        return f"<Program of {outputs}: {len(self.once)} statements once, {len(self.statements)} each call>"

    @cached_property
    def nodes(self) -> list[Expression]:
        """Every node that the outputs need, operands before their users."""
        return reachable(x for output in self.outputs for x in output.entries)


class Names:
    """Names of expressions: the first name of a quantity is kept."""

    def __init__(self) -> None:
        self.labels: dict[int, tuple[Label, bool]] = {}
        self.order: dict[Section, int] = {}
        self.constants: dict[str, NamedConstant] = {}
        self.quantities: dict[str, Operand] = {}

    def reserve(self, section: Section) -> None:
        """Reserve the next place for a section in the order of the program."""
        self.order.setdefault(section, len(self.order))

    def give(self, x: Scalar, name: str, section: Section) -> None:
        """Name an expression; variables keep their names, and constants are recorded under the name."""
        self.reserve(section)
        if not isinstance(x, Expression):
            if isinstance(x, int | Fraction) and x:
                self.constants.setdefault(name, NamedConstant(Label(name, section), x))
            return
        if x.level == Level.CONSTANT:
            self.constants.setdefault(name, NamedConstant(Label(name, section), x))
        self.quantities.setdefault(name, x)
        negative = x.operation == NEGATE
        node = x.operands[0] if negative else x
        if node.operation != SYMBOL:
            self.labels.setdefault(node.id, (Label(name, section), negative))

    def moved(self, values: Mapping[int, Operand]) -> Names:
        """The names for new values of the nodes; other nodes keep their names unless a new value occupies them."""
        moved = Names()
        moved.order = dict(self.order)
        for number, (label, negative) in self.labels.items():
            if number in values:
                moved.give(-values[number] if negative else values[number], label.name, label.section)
        for number, label_and_sign in self.labels.items():
            if number not in values:
                moved.labels.setdefault(number, label_and_sign)
        moved.constants = self.constants | moved.constants
        moved.quantities = {name: _new_value(x, values) for name, x in self.quantities.items()}
        return moved


def _new_value(x: Operand, values: Mapping[int, Operand]) -> Operand:
    """The new value of a quantity, which may be the negation of a node."""
    if not isinstance(x, Expression):
        return x
    return -values[x.positive.id] if x.operation == NEGATE and x.positive.id in values else values.get(x.id, x)


def build(inputs: Iterable[Input], outputs: Iterable[Output], names: Names) -> Program:
    """The program of some outputs: pruned, then scheduled."""
    return schedule(inputs, prune(outputs, names))


@dataclass(frozen=True)
class Pruned:
    """Outputs, the names of quantities, and the nodes that the outputs need, operands before their users."""

    outputs: tuple[Output, ...]
    names: Names
    nodes: Sequence[Expression]

    @property
    def numbers(self) -> int:
        """A number above those of all nodes."""
        return self.nodes[-1].id + 1 if self.nodes else 0


def prune(outputs: Iterable[Output], names: Names) -> Pruned:
    """Remove nodes that no output needs, and compute the others with fewer products."""
    outputs = tuple(outputs)
    values, nodes = factor_graph([x for output in outputs for x in output.entries], names.labels.keys())
    entries = (tuple(values[x.id] if isinstance(x, Expression) else x for x in output.entries) for output in outputs)
    changed = tuple(replace(output, entries=x) for output, x in zip(outputs, entries, strict=True))
    return Pruned(changed, names.moved(values), nodes)


def schedule(inputs: Iterable[Input], pruned: Pruned) -> Program:
    """Put the work in the order of the sections, name and count it."""
    statements = name(pruned, _schedule(pruned))
    constant, parameter, state = Level
    return Program(
        tuple(inputs),
        pruned.outputs,
        tuple([s for s in statements if s.node.level == parameter]),
        tuple([s for s in statements if s.node.level == state]),
        frozenset(n.operands[0] for n in pruned.nodes if n.operation == SYMBOL),
        count(pruned.nodes, state),
        count(pruned.nodes, parameter),
        tuple([node for node in pruned.nodes if node.level == constant]),
        tuple(pruned.names.constants.values()),
        pruned.names.quantities,
    )


def count(nodes: Iterable[Expression], level: Level) -> OperationCount:
    """Operations of the nodes of a level."""
    totals = {field.name: 0 for field in fields(OperationCount)}
    times = Counter(node.operation for node in nodes if node.level == level and node.operation != SYMBOL)
    for operation, n in times.items():
        kind = OPERATIONS[operation].counted_as
        if kind:
            totals[kind] += n
    return OperationCount(**totals)


Scheduled: TypeAlias = Sequence[tuple[int, Expression]]
"""The nodes that become statements, in order, with the position of their section."""


def _schedule(pruned: Pruned) -> Scheduled:
    """Return the nodes in the order of their sections, or of their earliest users' sections where those are earlier."""
    own = {number: pruned.names.order[label.section] for number, (label, _) in pruned.names.labels.items()}
    ranks, assigned = _earliest(pruned, own, len(pruned.names.order)), _assigned_nodes(pruned)
    pairs = [(ranks[node.id], node) for node in pruned.nodes if node.id in assigned]
    return sorted(pairs, key=lambda ranked: ranked[0])  # nodes are in order, and the sort is stable


def _earliest(pruned: Pruned, own: Mapping[int, int], last: int) -> list[int]:
    """Positions of nodes: their own or that of the first user, whichever is earlier; `last` without any."""
    positions = [last] * pruned.numbers
    for node in reversed(pruned.nodes):
        position = positions[node.id]
        if own.get(node.id, last) < position:
            positions[node.id] = position = own[node.id]
        for x in node.needs:
            if positions[x.id] > position:  # noqa: PLR1730  (`min` takes twice as long)
                positions[x.id] = position
    return positions


def _assigned_nodes(pruned: Pruned) -> set[int]:
    """Nodes that get a variable: named, shared, needed at the next level, or nested too deeply."""
    labels, shared, constant = pruned.names.labels, _shared_nodes(pruned), Level.CONSTANT
    assigned: set[int] = set()
    depth = [0] * pruned.numbers
    for node in pruned.nodes:
        deepest = 0
        for x in node.needs:
            if depth[x.id] > deepest:  # noqa: PLR1730  (`max` takes twice as long)
                deepest = depth[x.id]
        if node.operation not in (SYMBOL, NEGATE) and node.level != constant:
            deepest += 1
            if node.id in labels or node.id in shared or deepest > MAX_INLINE_DEPTH:
                assigned.add(node.id)
                deepest = 0
        depth[node.id] = deepest
    return assigned


def _shared_nodes(pruned: Pruned) -> set[int]:
    """Nodes that are used more than once, by work of a higher level, or as a result that depends on parameters only.

    A use of -x is one of x.
    """
    results = [x for output in pruned.outputs for x in output.entries if type(x) is Expression]
    shared = {x.id for x in results if x.level == Level.PARAMETER}
    uses = [0] * pruned.numbers
    for x in results:
        uses[x.id] += 1
    for node in reversed(pruned.nodes):
        if uses[node.id] > 1:
            shared.add(node.id)
        if node.operation == NEGATE:
            inner = node.operands[0].id
            uses[inner] += uses[node.id]
            if node.id in shared:
                shared.add(inner)
            continue
        for x in node.needs:
            uses[x.id] += 1
            if x.level < node.level:
                shared.add(x.id)
    return shared


def name(pruned: Pruned, scheduled: Scheduled) -> list[Statement]:
    """Statements with the names of their quantities; parts of a quantity are named after it."""
    labels = pruned.names.labels
    sections = [*pruned.names.order, Section("Results")]
    home = _homes(pruned, scheduled)
    letters: dict[str, itertools.count[int]] = {}
    result = []
    for rank, node in scheduled:
        label, negative = labels.get(node.id, (None, False))
        result.append(
            Statement(label.name if label else _part_name(home[node.id], letters), node, negative, sections[rank])
        )
    times = Counter(node.operands[0] for node in pruned.nodes if node.operation == SYMBOL)
    times.update(statement.name for statement in result)
    if repeated := [name for name, n in times.items() if n > 1]:
        raise ValueError(f"one name for two quantities: {', '.join(repeated)}")
    return result


def _homes(pruned: Pruned, scheduled: Scheduled) -> dict[int, str]:
    """Names of the first quantities that need scheduled nodes without a name."""
    labels, last = pruned.names.labels, len(scheduled)
    names = {k: labels[node.id][0].name for k, (_, node) in enumerate(scheduled) if node.id in labels}
    names[last] = "result_"
    first = _earliest(pruned, {scheduled[k][1].id: k for k in names if k < last}, last)
    return {node.id: names[first[node.id]] for _, node in scheduled if node.id not in labels}


def _part_name(home: str, letters: dict[str, itertools.count[int]]) -> str:
    """`Js5_33a`, `Js5_33b`...: parts of a quantity that are used more than once."""
    number = next(letters.setdefault(home, itertools.count()))
    suffix = ""
    while True:
        suffix = ascii_lowercase[number % 26] + suffix
        number = number // 26 - 1
        if number < 0:
            return home + suffix


def by_section(statements: Iterable[Statement]) -> list[tuple[Section, list[Statement]]]:
    """Statements grouped by section, in order."""
    groups: list[tuple[Section, list[Statement]]] = []
    for statement in statements:
        if not groups or groups[-1][0] != statement.section:
            groups.append((statement.section, []))
        groups[-1][1].append(statement)
    return groups


def saving(whole: OperationCount, asked: OperationCount) -> Mapping[str, int]:
    """Operations by kind that `asked` saves."""
    return {f.name: getattr(whole, f.name) - getattr(asked, f.name) for f in fields(whole)}


def names_in(program: Program) -> set[str]:
    """Names of the variables of a program, and of its arguments, their entries and its results."""
    arrays = {x.name for x in program.inputs} | {x.name for x in program.outputs}
    return arrays.union(program.used, (s.name for s in (*program.once, *program.statements)))


def free_name(stem: str, names: set[str]) -> str:
    """The stem, with a number where it is among `names`, to which it is added."""
    name = next(x for x in (f"{stem}{k or ''}" for k in itertools.count()) if x not in names)
    names.add(name)
    return name


def rename_variables(program: Program, names: Mapping[str, str]) -> Program:
    """Return the program with variables renamed; expressions without them are unchanged."""
    statements = (*program.once, *program.statements)
    entries = [x for output in program.outputs for x in output.entries]
    copies = _copies([*(statement.node for statement in statements), *entries], names)

    def copy_of(x: Operand) -> Operand:
        return copies.get(x.id, x) if isinstance(x, Expression) else x

    def of(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
        return tuple(statement._replace(node=copies.get(statement.node.id, statement.node)) for statement in statements)

    return replace(
        program,
        inputs=tuple(replace(x, symbols=tuple(names.get(s, s) for s in x.symbols)) for x in program.inputs),
        outputs=tuple(replace(x, entries=tuple(map(copy_of, x.entries))) for x in program.outputs),
        once=of(program.once),
        statements=of(program.statements),
        used=frozenset(names.get(name, name) for name in program.used),
    )


def _copies(roots: list[Operand], names: Mapping[str, str]) -> dict[int, Expression]:
    """Copies, with the same numbers, of the nodes that depend on renamed variables."""
    copies: dict[int, Expression] = {}
    for node in reachable(roots):
        operands = tuple(copies.get(x.id, x) if isinstance(x, Expression) else x for x in node.operands)
        if node.operation == SYMBOL:
            operands = tuple(names.get(name, name) for name in node.operands)
        if any(new is not old for new, old in zip(operands, node.operands, strict=True)):
            needs = tuple([x for x in operands if isinstance(x, Expression)])
            copies[node.id] = Expression(node.graph, node.operation, operands, needs, node.id, node.level)
    return copies
