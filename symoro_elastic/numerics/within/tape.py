"""A program as rows of operations on arrays, some of whose addends, functions and nodes may be left out.

A *place* is a row of numbers, one for each state: places 0 ... n - 1 are the nodes that are not constant, operands
before their users; the places after these are constants. What is left out of the program are *changes*:

    drop        an operand of a sum becomes zero                       x + y  ->  x
    freeze      a node that depends on positions only is a number c    cos q  ->  1
    straighten  a sine is its angle                                    sin q  ->  q

Between the program (s = 1) and the changed program (s = 0) lies a homotopy: a dropped operand is multiplied by s, a
frozen node is c + s (z - c), a straightened sine q + s (sin q - q).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Program

SUMS = (ADD, SUBTRACT)
_UFUNCS: dict[str, Callable[..., Any]] = {
    ADD: np.add,
    SUBTRACT: np.subtract,
    MULTIPLY: np.multiply,
    DIVIDE: np.divide,
    NEGATE: np.negative,
}


class Kind(Enum):
    """What is done to a node."""

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
    """A function of one or two rows that fills a row: places of its operands, the second -1 for one, and its own."""

    function: Callable[..., Any]
    first: int
    second: int
    place: int


class Tape:
    """The operations of a program, in order; `results` are the places of those of its results that it computes.

    Each is there once. `entries` are the places of the entries of each output, arguments and constants too.
    """

    def __init__(self, program: Program, positions: Collection[str] = ("q",)) -> None:
        """`positions` are the names of the arguments that hold positions."""
        self.nodes = [node for node in program.nodes if node.level != Level.CONSTANT]
        self.count = len(self.nodes)
        self._places = {node.id: place for place, node in enumerate(self.nodes)}
        self._constants: dict[Operand, int] = {}
        self.operations = [node.operation for node in self.nodes]
        self.operands = [() if x.operation == SYMBOL else tuple(map(self.place, x.operands)) for x in self.nodes]
        self.entries = [[self.place(x) for x in output.entries] for output in program.outputs]
        found = dict.fromkeys(x for places in self.entries for x in places)
        self.results = [x for x in found if x < self.count and self.operands[x]]
        self.symbols = {str(x.operands[0]): place for place, x in enumerate(self.nodes) if x.operation == SYMBOL}
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
        found: list[bool] = []
        for place, operands in enumerate(self.operands):
            found.append(symbols.get(place, True) and all(x >= self.count or found[x] for x in operands))
        return found

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
        return picked(rows, self.results)

    def steps(self, changes: Changes = NO_CHANGES, s: float = 0.0, roots: Iterable[int] | None = None) -> list[Step]:
        """Return what fills the rows of the program with changes: all, or those that the places `roots` need."""
        found = []
        changed = {place for place, _ in changes.dropped} | changes.straightened
        for place in range(self.count) if roots is None else sorted(self._needed(roots, changes)):
            if place in changes.frozen:
                found.append(self._frozen(place, changes.frozen[place], s))
            elif place in changed:
                found.append(self._step(place, changes, s))
            elif self.operands[place]:
                found.append(self._whole[place])
        return found

    @cached_property
    def _whole(self) -> dict[int, Step]:
        """What fills the rows of the program without changes."""
        return {place: self._step(place, NO_CHANGES, 0.0) for place, x in enumerate(self.operands) if x}

    def _step(self, place: int, changes: Changes, s: float) -> Step:
        first, second = (*self.operands[place], -1)[:2]
        return Step(self._function(place, changes, s), first, second, place)

    def _needed(self, roots: Iterable[int], changes: Changes) -> set[int]:
        """Return the places that the rows of `roots` need in the program with changes."""
        found: set[int] = set()
        pending = [*roots]
        while pending:
            place = pending.pop()
            if place < self.count and place not in found:
                found.add(place)
                operands = () if place in changes.frozen else self.operands[place]
                pending += [x for k, x in enumerate(operands) if (place, k) not in changes.dropped]
        return found

    def _function(self, place: int, changes: Changes, s: float) -> Callable[..., Any]:
        operation = self.operations[place]
        function = _UFUNCS.get(operation) or arithmetic(np.float64).operations[operation]
        if place in changes.straightened:
            return _between(function, np.positive, s)
        one, two = (s if (place, k) in changes.dropped else 1.0 for k in (0, 1))
        if one == two == 1.0:
            return function
        return _weighted(one, -two if operation == SUBTRACT else two)

    def _frozen(self, place: int, constant: float, s: float) -> Step:
        first, second = (*self.operands[place], -1, -1)[:2]
        if first < 0:  # a symbol, whose row holds its value
            return Step(_between(np.positive, _number(constant), s), place, -1, place)
        return Step(_between(self._function(place, NO_CHANGES, s), _number(constant), s), first, second, place)


def picked(rows: Rows, places: Sequence[int]) -> Array:
    """Return the rows at some places, (places, states)."""
    return np.array([rows[place] for place in places]).reshape(len(places), len(rows[0]) if rows else 0)


def _number(constant: float) -> Callable[..., Any]:
    return lambda *rows: np.copyto(rows[-1], constant)


def _weighted(one: float, two: float) -> Callable[..., Any]:
    """A sum of two rows, multiplied by these numbers."""
    if one == 0.0 and two == 0.0:
        return _number(0.0)
    if one == 1.0 and two == 0.0:
        return lambda x, y, z: np.copyto(z, x)
    if one == 0.0 and abs(two) == 1.0:
        return lambda x, y, z: np.multiply(y, two, z)
    return lambda x, y, z: np.copyto(z, one * x + two * y)


def _between(exact: Callable[..., Any], changed: Callable[..., Any], s: float) -> Callable[..., Any]:
    """The homotopy from a changed function (s = 0) to the exact one."""
    if not s:
        return changed

    def between(*rows: Array) -> None:
        whole = np.empty_like(rows[-1])
        exact(*rows[:-1], whole)
        changed(*rows)
        rows[-1][:] += s * (whole - rows[-1])

    return between
