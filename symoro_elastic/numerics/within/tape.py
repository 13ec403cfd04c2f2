"""A program as rows of operations on arrays; addends, functions and nodes may be left out.

A *place* is a row of numbers, one for each state: places 0 ... n - 1 are the nodes that are not constant, operands
before their users; the places after these are constants. What is left out of the program are *changes*:

    drop        an operand of a sum becomes zero                       x + y  ->  x
    freeze      a node that depends on positions only is a number c    cos q  ->  1
    straighten  a sine is its angle                                    sin q  ->  q

Between the program (s = 1) and the changed program (s = 0) lies a homotopy: a dropped operand is multiplied by s, a
frozen node is c + s (z - c), a straightened sine q + s (sin q - q).

Terms can be switched off: each operand of the sums of a program is multiplied by a symbol of its own, one.

Whatever is derived from the results of such a program, by derivatives or by solving for something, depends on the same
symbols: where one of them becomes zero, its term is left out of all that is derived.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.arithmetic import EXACT, FLOATS, evaluate
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, maximum, minimum, sign, square_root
from symoro_elastic.symbolic.program import Output, Program

SUMS = (op.ADD, op.SUBTRACT)
_UFUNCS: dict[str, Callable[..., Any]] = {
    op.ADD: np.add,
    op.SUBTRACT: np.subtract,
    op.MULTIPLY: np.multiply,
    op.DIVIDE: np.divide,
    op.NEGATE: np.negative,
}
OF_NUMBERS: dict[str, Callable[..., Operand]] = {
    op.SQRT: square_root,
    op.SIGN: sign,
    op.ATAN2: arc_tangent,
    op.MINIMUM: minimum,
    op.MAXIMUM: maximum,
}
"""Functions that are exact for some numbers."""
PREFIX = "kept_"


class Kind(Enum):
    """Kind of a change of a node: drop an operand, freeze the value, or replace a sine by its angle."""

    DROP = "drop"
    FREEZE = "freeze"
    STRAIGHTEN = "straighten"


class Change(NamedTuple):
    """A change of the node at a place: `operand` 0 or 1 of a sum is dropped, or it is frozen to `constant`."""

    kind: Kind
    place: int
    operand: int = 0
    constant: float = 0.0


@dataclass(frozen=True)
class Changes:
    """Changes by the place that they change."""

    dropped: frozenset[tuple[int, int]]
    frozen: dict[int, float]
    straightened: frozenset[int]

    @classmethod
    def of(cls, changes: Iterable[Change]) -> Changes:
        """Sort changes by kind."""
        changes = list(changes)
        return cls(
            frozenset((c.place, c.operand) for c in changes if c.kind is Kind.DROP),
            {c.place: c.constant for c in changes if c.kind is Kind.FREEZE},
            frozenset(c.place for c in changes if c.kind is Kind.STRAIGHTEN),
        )


NO_CHANGES = Changes.of(())
Rows = list[Array]
"""For each place its numbers, (states,)."""


class Step(NamedTuple):
    """A function of one or two rows that fills a row: places of its operands, the second -1 if none, and its own."""

    function: Callable[..., Any]
    first: int
    second: int
    place: int


class Tape:
    """The operations of a program, in order; `results` are the places of the results that it computes, without repeats.

    `entries` are the places of the entries by output, arguments and constants too.
    """

    def __init__(self, program: Program, positions: Collection[str] = ("q",)) -> None:
        """`positions` are the names of the arguments that hold positions."""
        self.nodes = [node for node in program.nodes if node.level != Level.CONSTANT]
        self.count = len(self.nodes)
        self._places = {node.id: place for place, node in enumerate(self.nodes)}
        self._constants: dict[Operand, int] = {}
        self.operations = [node.operation for node in self.nodes]
        self.operands = [() if x.operation == op.SYMBOL else tuple(map(self.place, x.operands)) for x in self.nodes]
        self.entries = [[self.place(x) for x in output.entries] for output in program.outputs]
        returned = dict.fromkeys(x for places in self.entries for x in places)
        self.results = [x for x in returned if x < self.count and self.operands[x]]
        self.symbols = {str(x.operands[0]): place for place, x in enumerate(self.nodes) if x.operation == op.SYMBOL}
        value = evaluate(self._constants, {}, FLOATS)
        self.constants = [float(value(x)) for x in self._constants]
        places = {symbol for argument in program.inputs if argument.name in positions for symbol in argument.symbols}
        self.is_position = [name in places for name in self.symbols]
        self.of_positions = self._of_positions()

    def place(self, x: Operand) -> int:
        """The place of a node or a constant."""
        if isinstance(x, Expression) and x.level != Level.CONSTANT:
            return self._places[x.id]
        return self._constants.setdefault(x, self.count + len(self._constants))

    def _of_positions(self) -> list[bool]:
        """For each node whether it depends on positions only."""
        symbols = dict(zip(self.symbols.values(), self.is_position, strict=True))
        depends: list[bool] = []
        for place, operands in enumerate(self.operands):
            depends.append(symbols.get(place, True) and all(x >= self.count or depends[x] for x in operands))
        return depends

    def rows_in(self, numbers: Array) -> Rows:
        """Return rows for all places, those of nodes in an array (nodes, states)."""
        return [*numbers, *(np.broadcast_to(x, numbers.shape[1]) for x in self.constants)]

    def rows(self, states: Array, changes: Changes = NO_CHANGES, s: float = 0.0) -> Rows:
        """Return the values of all places at states (symbols, states), the program with changes at s."""
        rows = self.rows_in(np.empty((self.count, states.shape[1])))
        self.fill(rows, self.steps(changes, s), states)
        return rows

    def fill(self, rows: Rows, steps: Sequence[Step], states: Array) -> None:
        """Fill rows at states (symbols, states) by steps."""
        for place, values in zip(self.symbols.values(), states, strict=True):
            rows[place][:] = values
        with np.errstate(all="ignore"):
            for function, first, second, place in steps:
                if second < 0:
                    function(rows[first], rows[place])
                else:
                    function(rows[first], rows[second], rows[place])

    def values(self, rows: Rows) -> Array:
        """Return the values of the results (results, states)."""
        return rows_at(rows, self.results)

    def steps(self, changes: Changes = NO_CHANGES, s: float = 0.0, roots: Iterable[int] | None = None) -> list[Step]:
        """Return the steps of the program with changes: all, or those that the places `roots` depend on."""
        steps = []
        changed = {place for place, _ in changes.dropped} | changes.straightened
        for place in range(self.count) if roots is None else sorted(self._required_places(roots, changes)):
            if place in changes.frozen:
                steps.append(self._frozen(place, changes.frozen[place], s))
            elif place in changed:
                steps.append(self._step(place, changes, s))
            elif self.operands[place]:
                steps.append(self._whole[place])
        return steps

    @cached_property
    def _whole(self) -> dict[int, Step]:
        """Steps of the program without changes, by place."""
        return {place: self._step(place, NO_CHANGES, 0.0) for place, x in enumerate(self.operands) if x}

    def _step(self, place: int, changes: Changes, s: float) -> Step:
        first, second = (*self.operands[place], -1)[:2]
        return Step(self._function(place, changes, s), first, second, place)

    def _required_places(self, roots: Iterable[int], changes: Changes) -> set[int]:
        """Return the places that `roots` depend on in the program with changes."""
        needed: set[int] = set()
        pending = [*roots]
        while pending:
            place = pending.pop()
            if place < self.count and place not in needed:
                needed.add(place)
                operands = () if place in changes.frozen else self.operands[place]
                pending += [x for k, x in enumerate(operands) if (place, k) not in changes.dropped]
        return needed

    def _function(self, place: int, changes: Changes, s: float) -> Callable[..., Any]:
        operation = self.operations[place]
        function = _UFUNCS.get(operation) or arithmetic(np.float64).operations[operation]
        if place in changes.straightened:
            return _between(function, np.positive, s)
        first, second = (s if (place, k) in changes.dropped else 1.0 for k in (0, 1))
        if first == second == 1.0:
            return function
        return _weighted(first, -second if operation == op.SUBTRACT else second)

    def _frozen(self, place: int, constant: float, s: float) -> Step:
        first, second = (*self.operands[place], -1, -1)[:2]
        if first < 0:  # a symbol, whose row holds its value
            return Step(_between(np.positive, _number(constant), s), place, -1, place)
        return Step(_between(self._function(place, NO_CHANGES, s), _number(constant), s), first, second, place)


def rows_at(rows: Rows, places: Sequence[int]) -> Array:
    """Return the rows at some places, (places, states)."""
    return np.array([rows[place] for place in places]).reshape(len(places), len(rows[0]) if rows else 0)


def _number(constant: float) -> Callable[..., Any]:
    return lambda *rows: np.copyto(rows[-1], constant)


def _weighted(first: float, second: float) -> Callable[..., Any]:
    """A sum of two rows, multiplied by these numbers."""
    if first == 0.0 and second == 0.0:
        return _number(0.0)
    if first == 1.0 and second == 0.0:
        return lambda x, y, z: np.copyto(z, x)
    if first == 0.0 and abs(second) == 1.0:
        return lambda x, y, z: np.multiply(y, second, z)
    return lambda x, y, z: np.copyto(z, first * x + second * y)


def _between(exact: Callable[..., Any], changed: Callable[..., Any], s: float) -> Callable[..., Any]:
    """The homotopy from a changed function (s = 0) to the exact one."""
    if not s:
        return changed

    def between(*rows: Array) -> None:
        exact_values = np.empty_like(rows[-1])
        exact(*rows[:-1], exact_values)
        changed(*rows)
        rows[-1][:] += s * (exact_values - rows[-1])

    return between


def changed_values(tape: Tape, changes: Changes) -> dict[int, Operand]:
    """Return the new values of the nodes of the program, by number."""
    values: dict[int, Operand] = {}
    for place, node in enumerate(tape.nodes):
        values[node.id] = _value(place, node, changes, values)
    return values


def with_values(program: Program, values: Mapping[int, Operand]) -> tuple[Output, ...]:
    """Return the outputs of a program with new values of its nodes."""
    return tuple(Output(x.name, x.shape, tuple(_new(entry, values) for entry in x.entries)) for x in program.outputs)


def _new(x: Operand, values: Mapping[int, Operand]) -> Operand:
    return values.get(x.id, x) if isinstance(x, Expression) else x


def _value(place: int, node: Expression, changes: Changes, values: Mapping[int, Operand]) -> Operand:
    if place in changes.frozen:
        return Fraction(changes.frozen[place])
    operands = [_new(x, values) for x in node.operands]
    if place in changes.straightened:
        return operands[0]
    dropped = [(place, k) in changes.dropped for k in (0, 1)]
    if any(dropped):
        first, second = (0 if gone else x for gone, x in zip(dropped, operands, strict=True))
        changed: Operand = EXACT[node.operation](first, second)
        return changed
    return _rebuilt(node, operands, _function)


def _rebuilt(
    node: Expression, operands: Sequence[Operand], function: Callable[[Expression, Sequence[Operand]], Operand]
) -> Operand:
    """A node of other operands; `function` makes one that is no sum, product or quotient."""
    if all(new is old for new, old in zip(operands, node.operands, strict=True)):
        return node
    operation = EXACT.get(node.operation)
    value: Operand = operation(*operands) if operation else function(node, operands)
    return value


def _function(node: Expression, operands: Sequence[Operand]) -> Operand:
    """A function of changed operands: exact for numbers, signs carried outwards."""
    graph, name, x = node.graph, node.operation, operands[0]
    if name in OF_NUMBERS:
        return OF_NUMBERS[name](graph, *operands)
    if name not in (op.SIN, op.COS):
        return graph.node(name, *operands)
    if not isinstance(x, Expression):
        return cosine_sine(graph, x)[name == op.SIN]
    wave = graph.node(name, x.positive)
    return -wave if x is not x.positive and name == op.SIN else wave


@dataclass(frozen=True)
class SwitchedProgram:
    """The results of a program with switches, and the change that a switch makes, by its name."""

    program: Program
    tape: Tape
    entries: tuple[Operand, ...]
    changes: Mapping[str, Change]

    def without(self, names: Sequence[str]) -> tuple[Output, ...]:
        """Return the outputs of the program with these switches at zero and all others at one."""
        return with_values(self.program, self.values_without(names))

    def values_without(self, names: Sequence[str]) -> dict[int, Operand]:
        """Return the values of all nodes, by number, with these switches at zero and all others at one."""
        return changed_values(self.tape, Changes.of(self.changes[name] for name in names))


def with_switches(program: Program, positions: Sequence[str] = ("q",)) -> SwitchedProgram:
    """Return a program with switches at the operands of all sums that depend on the state."""
    tape, changes = Tape(program, positions), dict[str, Change]()
    values: dict[int, Operand] = {}
    for place, node in enumerate(tape.nodes):
        operands = [_new(x, values) for x in node.operands]
        if tape.operations[place] in SUMS and node.level == Level.STATE:
            for k in (0, 1):
                name = f"{PREFIX}{len(changes)}"
                changes[name] = Change(Kind.DROP, place, k)
                operands[k] = node.graph.symbol(name, Level.PARAMETER) * operands[k]
        values[node.id] = _rebuilt(node, operands, lambda node, x: node.graph.node(node.operation, *x))
    results = tuple(x for output in with_values(program, values) for x in output.entries)
    return SwitchedProgram(program, tape, results, changes)
