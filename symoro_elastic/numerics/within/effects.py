"""How much each change moves each result, at many states at once.

A change of a node moves its value z by e; to first order it moves a result f by a e, where the *adjoint* a = df/dz.
One sweep from the results back to the arguments finds the adjoints of all results at all nodes: the adjoint of a node
is the sum, over its users, of the user's adjoint times the user's partial derivative. Effects keep their signs, so that
those of several changes may cancel.
"""

from __future__ import annotations

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.within.tape import NO_CHANGES, SUMS, Change, Changes, Kind, Rows, Tape
from symoro_elastic.symbolic.operations import ADD, MULTIPLY, NEGATE, OPERATIONS, SUBTRACT

Adjoints = list[Array | None]
"""For each node (results, states), None where no result depends on it."""


class Sweep:
    """Sweeps back along a tape; its arrays are used again."""

    def __init__(self, tape: Tape, results: int, states: int) -> None:
        self._tape = tape
        self._numbers = np.empty((tape.count, results, states))
        self._product = np.empty((results, states))
        self._found: Adjoints = []

    def adjoints(self, rows: Rows, seeds: Array, changes: Changes = NO_CHANGES) -> Adjoints:
        """Return the adjoints of the changed program, valid until the next call.

        `seeds` (results, states) multiply each result, or are (roots, results, states): by each result of the tape.
        """
        tape, self._found = self._tape, [None] * self._tape.count
        for k, place in enumerate(tape.results):
            self._found[place] = own = self._numbers[place]
            own[:] = 0.0
            if seeds.ndim == 2:
                own[k] = seeds[k]
            else:
                own[:] = seeds[:, k]
        with np.errstate(all="ignore"):
            for place in range(tape.count - 1, -1, -1):
                adjoint = self._found[place]
                if adjoint is not None and place not in changes.frozen:
                    self._back(place, adjoint, rows, changes)
        return self._found

    def _add(self, place: int, adjoint: Array) -> None:
        """Add to the adjoint of a place; the first one is not copied."""
        if place >= self._tape.count:
            return
        former = self._found[place]
        self._found[place] = adjoint if former is None else np.add(former, adjoint, self._numbers[place])

    def _subtract(self, place: int, adjoint: Array) -> None:
        if place >= self._tape.count:
            return
        former, own = self._found[place], self._numbers[place]
        self._found[place] = np.negative(adjoint, own) if former is None else np.subtract(former, adjoint, own)

    def _add_product(self, place: int, adjoint: Array, factor: Array) -> None:
        if place >= self._tape.count:
            return
        if self._found[place] is None:
            self._found[place] = np.multiply(adjoint, factor, self._numbers[place])
        else:
            self._add(place, np.multiply(adjoint, factor, self._product))

    def _back(self, place: int, adjoint: Array, rows: Rows, changes: Changes) -> None:
        operation, operands = self._tape.operations[place], self._tape.operands[place]
        if place in changes.straightened:
            self._add(operands[0], adjoint)
        elif operation in SUMS:
            if (place, 0) not in changes.dropped:
                self._add(operands[0], adjoint)
            if (place, 1) not in changes.dropped:
                (self._add if operation == ADD else self._subtract)(operands[1], adjoint)
        elif operation == MULTIPLY:
            first, second = operands
            self._add_product(first, adjoint, rows[second])
            self._add_product(second, adjoint, rows[first])
        elif operation == NEGATE:
            self._subtract(operands[0], adjoint)
        elif operands and (rule := OPERATIONS[operation].partials):
            partials = rule(arithmetic(np.float64).operations, rows[place], [rows[x] for x in operands])
            for operand, partial in zip(operands, partials.back(1.0), strict=True):
                self._add_product(operand, adjoint, np.asarray(partial))


def node_shift(tape: Tape, rows: Rows, change: Change) -> Array:
    """Return by how much a change moves the value of its node, (states,)."""
    if change.kind is Kind.FREEZE:
        return np.subtract(change.constant, rows[change.place])
    value = rows[tape.operands[change.place][change.operand]]
    if change.kind is Kind.STRAIGHTEN:
        return np.subtract(value, rows[change.place])
    is_subtracted = change.operand == 1 and tape.operations[change.place] == SUBTRACT
    return value if is_subtracted else -value
