"""Operations that a change saves: those that nothing needs any more.

Each node counts its uses. A change removes uses; a node without uses is dead, and so may its operands be. A sum with a
single operand needs no operation, a product with zero is zero, a function of numbers is a number: what follows upwards
is carried out, too. All changes of the lists are logged, so that a change can be tried and undone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from symoro_elastic.numerics.within.tape import SUMS, Change, Kind, Tape
from symoro_elastic.symbolic.arithmetic import FLOATS
from symoro_elastic.symbolic.expression import Level
from symoro_elastic.symbolic.operations import DIVIDE, MULTIPLY, OPERATIONS

COSTS = {"add": 1, "mul": 1, "div": 1, "sincos": 8}
"""Cost of an operation, by how it is counted; a sine or a cosine lasts as long as eight products."""
SIMPLE = (0.0, 1.0, -1.0)
"""Factors of products that need no operation."""
_GONE = -1


class Liveness:
    """Uses and costs of the nodes of a tape with some changes; `cost` is the sum over the nodes in use."""

    def __init__(self, tape: Tape, changes: Iterable[Change] = ()) -> None:
        self._tape = tape
        self._log: list[tuple[list[object], int, object]] = []
        self._pending: list[int] = []
        self._operands: list[list[int]] = [list(x) for x in tape.operands]
        self._constant: list[float | None] = [None] * tape.count + list(tape.constants)
        self._costs = [_cost(tape, place) for place in range(tape.count)]
        self._uses = [0] * tape.count
        self._users: list[list[int]] = [[] for _ in range(tape.count)]
        for place in [x for entries in tape.entries for x in entries if x < tape.count]:
            self._uses[place] += 1
        for place, operands in enumerate(tape.operands):
            for x in operands:
                if x < tape.count:
                    self._uses[x] += 1
                    self._users[x].append(place)
        self.cost = sum(self._costs)
        for change in changes:
            self.apply(change)

    def is_possible(self, change: Change) -> bool:
        """Whether a used node can still be changed so, by its operands; a constant can only become 0, 1 or -1."""
        place = change.place
        if not self._uses[place]:
            return False
        if self._constant[place] is not None:
            return change.kind is Kind.FREEZE and self._constant[place] not in SIMPLE and change.constant in SIMPLE
        if change.kind is Kind.DROP:
            return self._operands[place][change.operand] != _GONE
        return change.kind is Kind.FREEZE or self._costs[place] > 0

    def saved_by(self, change: Change) -> int:
        """Return how many operations a change would save, without applying it."""
        before, start = self.cost, len(self._log)
        self.apply(change)
        saved = before - self.cost
        while len(self._log) > start:
            of, index, value = self._log.pop()
            of[index] = value
        self.cost = before
        return saved

    def apply(self, change: Change) -> None:
        """Carry out a change that is possible."""
        if change.kind is Kind.FREEZE:
            self._set_constant(change.place, change.constant)
        elif change.kind is Kind.STRAIGHTEN:
            self._set_free(change.place)
        else:
            self._drop_operand(change.place, change.operand)
            self._simplify(change.place)
        while self._pending:
            place = self._pending.pop()
            if self._uses[place] and self._constant[place] is None:
                self._simplify(place)

    def _set(self, of: list, index: int, value: object) -> None:  # type: ignore[type-arg]
        self._log.append((of, index, of[index]))
        of[index] = value

    def _set_free(self, place: int) -> None:
        """Set the cost of a node to zero: its value needs no operation any more."""
        if self._costs[place]:
            self.cost -= self._costs[place] if self._uses[place] else 0
            self._set(self._costs, place, 0)

    def _drop_operand(self, place: int, slot: int) -> None:
        """Remove one operand of a node, and the nodes that are unused without it."""
        operand = self._operands[place][slot]
        operands = list(self._operands[place])
        operands[slot] = _GONE
        self._set(self._operands, place, operands)
        lost = [operand]
        while lost:
            x = lost.pop()
            if x == _GONE or x >= self._tape.count:
                continue
            self._set(self._uses, x, self._uses[x] - 1)
            if not self._uses[x]:
                self.cost -= self._costs[x]
                lost += self._operands[x]

    def _set_constant(self, place: int, constant: float) -> None:
        """Make a node a constant: release its operands, and mark its users for simplification."""
        self._set(self._constant, place, constant)
        self._set_free(place)
        for slot in range(len(self._operands[place])):
            if self._operands[place][slot] != _GONE:
                self._drop_operand(place, slot)
        self._pending += self._users[place]

    def _simplify(self, place: int) -> None:
        """Carry out what follows from operands that are numbers, or gone."""
        constants = [0.0 if x == _GONE else self._constant[x] for x in self._operands[place]]
        operation = self._tape.operations[place]
        if all(x is not None for x in constants):
            self._set_constant(place, _constant_value(operation, [x for x in constants if x is not None]))
        elif operation in SUMS:
            if 0.0 in constants:
                self._set_free(place)
        elif operation == MULTIPLY:
            if 0.0 in constants:
                self._set_constant(place, 0.0)
            elif 1.0 in constants or -1.0 in constants:
                self._set_free(place)
        elif operation == DIVIDE:
            if constants[0] == 0.0:
                self._set_constant(place, 0.0)
            elif constants[1] in (1.0, -1.0):
                self._set_free(place)


def _cost(tape: Tape, place: int) -> int:
    node = tape.nodes[place]
    if not tape.operands[place] or node.level != Level.STATE:
        return 0
    return COSTS.get(OPERATIONS[node.operation].counted_as, 0)


def _constant_value(operation: str, constants: Sequence[float]) -> float:
    """The result of an operation on constants, in double precision; NaN where it has none."""
    try:
        return float(FLOATS.operations[operation](*constants))
    except ArithmeticError:
        return math.nan
