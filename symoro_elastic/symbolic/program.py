"""Straight-line programs: what some outputs need of a graph, in order, named after quantities."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import count
from string import ascii_lowercase

from symoro_elastic.symbolic.expression import (
    ADD,
    COS,
    DIVIDE,
    MULTIPLY,
    NEGATE,
    SIN,
    SUBTRACT,
    SYMBOL,
    Expression,
    Level,
    Scalar,
    reachable,
)
from symoro_elastic.symbolic.factoring import factored

MAX_INLINE_DEPTH = 8

_COUNTED = {ADD: "add", SUBTRACT: "add", MULTIPLY: "mul", DIVIDE: "div", SIN: "sincos", COS: "sincos"}


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


@dataclass(frozen=True)
class Section:
    """A stretch of a program: one joint's part of one recursion, with the equations it carries out."""

    title: str
    joint: int | None = None
    equations: str = ""


@dataclass(frozen=True)
class Label:
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
    entries: tuple[Scalar, ...]


@dataclass(frozen=True)
class Statement:
    """`name = expression`, or `name = -expression` when `negative`."""

    name: str
    node: Expression
    negative: bool
    section: Section


@dataclass(frozen=True)
class Program:
    """Statements to be carried out in order; `once` depend on parameters only."""

    inputs: tuple[Input, ...]
    outputs: tuple[Output, ...]
    once: tuple[Statement, ...]
    statements: tuple[Statement, ...]
    used: frozenset[str]
    count: OperationCount
    count_once: OperationCount


class Names:
    """The names of expressions: the first name given to a quantity stays."""

    def __init__(self) -> None:
        self.labels: dict[int, tuple[Label, bool]] = {}
        self.order: dict[Section, int] = {}

    def reserve(self, section: Section) -> None:
        """Give a section its place in the order of the program."""
        self.order.setdefault(section, len(self.order))

    def give(self, x: Scalar, name: str, section: Section) -> None:
        """Name an expression; constants and variables keep theirs."""
        self.reserve(section)
        if not isinstance(x, Expression):
            return
        negative = x.operation == NEGATE
        node = x.operands[0] if negative else x
        if node.operation != SYMBOL:
            self.labels.setdefault(node.id, (Label(name, section), negative))

    def moved(self, values: Mapping[int, Scalar]) -> Names:
        """The same names for new values of the nodes."""
        moved = Names()
        for section in self.order:
            moved.reserve(section)
        for number, (label, negative) in self.labels.items():
            if number in values:
                moved.give(-values[number] if negative else values[number], label.name, label.section)
        for number, label_and_sign in self.labels.items():
            if number not in values:
                moved.labels.setdefault(number, label_and_sign)
        return moved


def build(inputs: Iterable[Input], outputs: Iterable[Output], names: Names) -> Program:
    """Prune what the outputs do not need, schedule the rest by section, name and count it."""
    outputs = tuple(outputs)
    values = factored((x for o in outputs for x in o.entries), names.labels)
    outputs = tuple(_with_values(output, values) for output in outputs)
    names = names.moved(values)
    nodes = reachable(x for o in outputs for x in o.entries)
    plan = _Plan(nodes, outputs, names)
    statements = plan.statements()
    return Program(
        tuple(inputs),
        outputs,
        tuple(s for s in statements if s.node.level == Level.PARAMETER),
        tuple(s for s in statements if s.node.level == Level.STATE),
        frozenset(n.operands[0] for n in nodes if n.operation == SYMBOL),
        _count(n for n in nodes if n.level == Level.STATE),
        _count(n for n in nodes if n.level == Level.PARAMETER),
    )


def _with_values(output: Output, values: Mapping[int, Scalar]) -> Output:
    entries = tuple(values[x.id] if isinstance(x, Expression) else x for x in output.entries)
    return Output(output.name, output.shape, entries)


def _count(nodes: Iterable[Expression]) -> OperationCount:
    totals = {"mul": 0, "add": 0, "div": 0, "sincos": 0}
    for node in nodes:
        if node.operation in _COUNTED:
            totals[_COUNTED[node.operation]] += 1
    return OperationCount(**totals)


class _Plan:
    """Which nodes become statements, in which section, under which name."""

    def __init__(self, nodes: Sequence[Expression], outputs: Sequence[Output], names: Names) -> None:
        self.nodes = nodes
        self.names = names
        self.last = len(names.order)
        self.users: dict[int, list[Expression]] = {n.id: [] for n in nodes}
        for node in nodes:
            for operand in node.operands:
                if operand.__class__ is Expression:
                    self.users[operand.id].append(node)
        self.asked = Counter(x.id for o in outputs for x in o.entries if isinstance(x, Expression))
        self.rank = self._ranks()
        self.assigned = self._assigned()

    def _ranks(self) -> dict[int, int]:
        """Position of the section of each node: its own, or its earliest user's if that is earlier."""
        rank: dict[int, int] = {}
        for node in reversed(self.nodes):
            own = self.names.labels.get(node.id)
            earliest = self.names.order[own[0].section] if own else self.last
            for user in self.users[node.id]:
                earliest = min(earliest, rank[user.id])
            rank[node.id] = earliest
        return rank

    def _assigned(self) -> set[int]:
        """Nodes that get a variable: named, shared, per-set work for the per-call part, or deep."""
        assigned: set[int] = set()
        depth: dict[int, int] = {}
        for node in self.nodes:
            if node.operation in (SYMBOL, NEGATE) or node.level == Level.CONSTANT:
                depth[node.id] = max((depth[o.id] for o in node.operands if o.__class__ is Expression), default=0)
                continue
            depth[node.id] = 1 + max((depth[o.id] for o in node.operands if o.__class__ is Expression), default=0)
            if node.id in self.names.labels or self._shared(node) or depth[node.id] > MAX_INLINE_DEPTH:
                assigned.add(node.id)
                depth[node.id] = 0
        return assigned

    def _shared(self, node: Expression) -> bool:
        uses, hoisted = 0, False
        stack = [node]
        while stack:
            current = stack.pop()
            uses += self.asked[current.id]
            hoisted |= node.level == Level.PARAMETER and current.id in self.asked
            for user in self.users[current.id]:
                if user.operation == NEGATE:
                    stack.append(user)
                else:
                    uses += 1
                hoisted |= user.level > node.level
        return uses > 1 or hoisted

    def statements(self) -> list[Statement]:
        scheduled = sorted((n for n in self.nodes if n.id in self.assigned), key=lambda n: (self.rank[n.id], n.id))
        sections = [*self.names.order, Section("Results")]
        home = self._homes(scheduled)
        letters: dict[str, count[int]] = {}
        result = []
        for node in scheduled:
            label, negative = self.names.labels.get(node.id, (None, False))
            name = label.name if label else _part_name(home[node.id], letters)
            result.append(Statement(name, node, negative, sections[self.rank[node.id]]))
        twice = [name for name, times in Counter(s.name for s in result).items() if times > 1]
        if twice:
            raise ValueError(f"one name for two quantities: {', '.join(twice)}")
        return result

    def _homes(self, scheduled: Sequence[Expression]) -> dict[int, str]:
        """For each node the name of the first quantity that needs it."""
        position = {n.id: k for k, n in enumerate(scheduled)}
        home: dict[int, tuple[int, str]] = {}
        for node in reversed(self.nodes):
            users = [home[u.id] for u in self.users[node.id]]
            found = min(users, default=(len(position), "result_"))
            label = self.names.labels.get(node.id)
            home[node.id] = (position[node.id], label[0].name) if label and node.id in position else found
        return {number: name for number, (_, name) in home.items()}


def _part_name(home: str, letters: dict[str, count[int]]) -> str:
    """`Js5_33a`, `Js5_33b`...: parts of a quantity that are used more than once."""
    number = next(letters.setdefault(home, count()))
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


def saved(whole: OperationCount, asked: OperationCount) -> Mapping[str, int]:
    """Operations of each kind that `asked` does without."""
    return {f.name: getattr(whole, f.name) - getattr(asked, f.name) for f in fields(whole)}
