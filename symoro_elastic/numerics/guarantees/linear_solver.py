"""What is known of the linear system of a program, and what lemma 8 makes of it (`matrix_argument.py`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.linear_system import LinearSystem
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.grid import WORK, largest
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.least_inertia import by_intervals, entries_by_intervals, on_cells
from symoro_elastic.numerics.guarantees.matrix_argument import OUTWARDS, Given, solved
from symoro_elastic.numerics.guarantees.mean_value import errors_by_adjoints
from symoro_elastic.numerics.guarantees.running_error import Bounds, running_errors
from symoro_elastic.numerics.guarantees.sub_boxes import Parts
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.program import Program

MOST_CELLS, MORE_CELLS = 5_000, 100_000
"""Of positions; with polynomials."""
DRAWN = 500
"""States whose middle value is where the range of an entry of b is looked for."""


@dataclass(frozen=True)
class Solver:
    """The linear system of a program in a box, and W from its rotors; `polynomials` takes some seconds more."""

    system: LinearSystem
    box: Box
    rotors: Array
    polynomials: bool = False

    def moved(self, to: Callable[[Operand], Operand], program: Program) -> Solver | None:
        """The same of a program whose sums have another order; None where it does not have all entries of A and b."""
        system, present = self.system.moved(to), {node.id for node in program.nodes}
        missing = any(isinstance(x, Expression) and x.positive.id not in present for x in system.given)
        return None if missing else replace(self, system=system)

    @cached_property
    def _everywhere(self) -> tuple[Array, Array]:
        """Bounds of all entries of the inverse, and of |A^-1 m|, m the middle of the right side, in the whole box."""
        size = len(self.system.joints)
        found = on_cells(self.system.A, self.box, MORE_CELLS if self.polynomials else MOST_CELLS, self._right[0])
        return (found.W, found.solution) if found else (np.full((size, size, 1), np.inf), np.full((size, 1), np.inf))

    @cached_property
    def _right(self) -> tuple[Array, Array]:
        """Middles and half widths of the entries of b, by polynomials."""
        right = self.system.right
        if not self.polynomials:
            return np.zeros(len(right)), np.full(len(right), np.inf)
        states = self.box.states(DRAWN, np.random.default_rng(0))
        value = evaluate(right, states, arithmetic(np.float64))
        drawn = [np.asarray(value(x), dtype=float) for x in right]
        middles = np.array([float(np.min(x) / 2 + np.max(x) / 2) for x in drawn])
        pairs = zip(right, map(Fraction, middles), strict=True)
        return middles, np.array([largest(pair, self.box, work=WORK).bound for pair in pairs])

    @cached_property
    def _inner(self) -> list[Expression]:
        """The nodes of the elimination, in order, and signs that the program may not have."""
        before = {node.id for node in reachable(self.system.given)}
        return [node for node in reachable([*self.system.x, *self.system.pivots]) if node.id not in before]

    def __call__(self, bounds: Bounds, parts: Parts, adjoints: bool) -> Bounds:
        """Bounds of all nodes, from those by operations; `adjoints` takes lemma 2 to the entries of A and b."""
        given = Given.of(self.system, self._closer(bounds) if adjoints else bounds)
        entries, solution = self._everywhere
        middle, half = (x[:, None] for x in self._right)
        b = given.b.meeting(Interval(middle - half * OUTWARDS, middle + half * OUTWARDS))
        with np.errstate(invalid="ignore"):
            most = np.fmin(
                given.x, solution + (entries * Interval(b.low - middle, b.high - middle).magnitude).sum(axis=1)
            )
            entries = np.fmin(entries, entries_by_intervals(given.A))
        given = replace(given, b=b, x=most * OUTWARDS)
        found = solved(self.system, given, [self.rotors, by_intervals(given.A)], entries, bounds.rounding)
        inner = [node for node in self._inner if node.id in bounds.range]
        ranges = {node.id: bounds.range[node.id] for node in inner}
        proven: dict[int, Array] = {}
        for x, most, error in zip(self.system.x, found.magnitude, found.error, strict=True):
            if isinstance(x, Expression) and x.positive.id in ranges:
                ranges[x.positive.id] = ranges[x.positive.id].meeting(Interval(-most, most))
                proven[x.positive.id] = error
        for x, error in zip(self.system.pivots, found.pivot_error, strict=True):
            if isinstance(x, Expression):
                proven[x.positive.id] = error
        known = {number: partial(Interval.meeting, x) for number, x in ranges.items()}
        before = bounds.without(inner)
        return running_errors(inner, parts, bounds.rounding, known=known, before=before, proven=proven)

    def _closer(self, bounds: Bounds) -> Bounds:
        """Bounds with errors of the entries of A and b that are smaller by lemma 2."""
        entries = [*{x.positive.id: x.positive for x in self.system.given if isinstance(x, Expression)}.values()]
        errors = errors_by_adjoints(reachable(entries), entries, bounds)
        smaller = {x.id: np.minimum(bounds.error[x.id], error) for x, error in zip(entries, errors, strict=True)}
        return replace(bounds, error={**bounds.error, **smaller})
