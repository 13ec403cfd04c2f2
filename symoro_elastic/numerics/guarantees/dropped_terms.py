"""Lemma 3, dropped terms: signed bounds of the difference between a reduced program and the full one.

Let z be the values of the nodes of the full program, z~ those of the changed one, where an addend t is dropped, a node
is frozen to a constant c, or a sine is replaced by its angle.

1. The differences d = z~ - z follow by recursion, as running errors do, but signed: d_x + d_y for a sum, less the
   dropped addend itself where it is gone; x d_y + y d_x + d_x d_y for a product; (d_x - z d_y)/y~ for a quotient.
2. Along the path that multiplies each dropped addend by 1 - s, s from 0 to 1, and mixes a frozen node and its constant,
   or a sine and its angle, in the same way, f moves at the rate sum a_i r_i with r_i = -t, c - z_i, x - sin x, where
   the adjoints a_i and all values are those of the path. So

       f_S - f is in sum [a_i] [r_i]

   with both over hulls of the path, and with signs: errors of opposite sign cancel.

A sign, and an arc tangent that may jump, mix both of their values on the path, as frozen nodes do: their rate is the
difference by 1.

The smaller bound counts in every sub-box. It bounds the exact reduced program; rounding is added to it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.guarantees.box import Parts
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval, meets_jump, not_bounded_where
from symoro_elastic.numerics.guarantees.largest_value import largest
from symoro_elastic.numerics.guarantees.mean_value import add_adjoint, unit_adjoint
from symoro_elastic.numerics.guarantees.polynomials import on_both_sides
from symoro_elastic.numerics.guarantees.running_error import Bounds
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.program import Program

ZERO = interval(0)
MOST_SUB_BOXES = 256
WORK = 5e9
"""Work for the polynomial of a result, values on grids, about ten seconds: the bound reached by then counts."""


@dataclass(frozen=True)
class ChangedNodes:
    """Changes of a program, by number of the node: dropped operands of sums, frozen nodes, sines that are angles."""

    dropped: frozenset[tuple[int, int]] = frozenset()
    frozen: Mapping[int, Fraction] = field(default_factory=dict)
    straightened: frozenset[int] = frozenset()

    def changes(self, node: Expression) -> bool:
        """Whether a change is made at a node."""
        gone = any((node.id, k) in self.dropped for k in range(2))
        return gone or node.id in self.frozen or node.id in self.straightened


Differences: TypeAlias = dict[int, Interval]
"""z~ - z of the nodes that differ, by number."""


def errors_of_changes(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, edits: ChangedNodes
) -> Array:
    """Bounds of |f_S - f| (results, sub-boxes); infinite where it is not bounded.

    `bounds` has the ranges of the nodes of the full program.
    """
    with np.errstate(all="ignore"):
        changed = _Recursion(bounds, edits, False)
        changed.run(nodes)
        by_recursion = np.array([np.broadcast_to(changed.of(x).magnitude, bounds.shape) for x in results])
        smaller: Array = np.minimum(by_recursion, _by_mean_value(nodes, results, bounds, edits))
    return smaller


class _Recursion:
    """Values of the changed program and differences from the full one, by node; hulls over the path with `path`."""

    def __init__(self, bounds: Bounds, edits: ChangedNodes, path: bool) -> None:
        self._bounds, self._edits, self._path = bounds, edits, path
        self.differences: Differences = {}
        self._values: dict[int, Interval] = {}
        self.rates: dict[int, Interval] = {}

    def run(self, nodes: Sequence[Expression]) -> None:
        """Evaluate all nodes in order."""
        for node in nodes:
            if self._edits.changes(node):
                self._keep(node, *self._change(node))
            elif node.operation != op.SYMBOL and any(self.of(x) is not ZERO for x in node.operands):
                self._keep(node, self._difference_from_operands(node), self._value_from_operands(node))
                if self._jumps(node):
                    self.rates[node.id] = self.differences[node.id]

    def of(self, x: Operand) -> Interval:
        """The difference of a node or a constant."""
        return self.differences.get(x.id, ZERO) if type(x) is Expression else ZERO

    def value(self, x: Operand) -> Interval:
        """The values of a node or a constant in the changed program, or on the path."""
        own_value = self._values.get(x.id) if type(x) is Expression else None
        return self._bounds.range_of(x) if own_value is None else own_value

    def is_gone(self, node: Expression, k: int) -> bool:
        """Whether an operand of a sum is dropped."""
        return (node.id, k) in self._edits.dropped

    def _jumps(self, node: Expression) -> bool:
        """Whether a node may jump on the path, in some sub-box."""
        if node.operation == op.ATAN2:
            return bool(np.any(meets_jump(*(self.value(x).hull(self._bounds.range_of(x)) for x in node.operands))))
        return node.operation == op.SIGN

    def _keep(self, node: Expression, difference: Interval, value: Interval) -> None:
        """Store difference and value, each narrowed by the other."""
        original = self._bounds.range_of(node)
        self._values[node.id] = values = value.meeting(original + difference)
        self.differences[node.id] = difference.meeting(values - original)

    def _difference_from_operands(self, node: Expression) -> Interval:
        """The difference of a node caused by its operands."""
        d = [self.of(x) for x in node.operands]
        original = [self._bounds.range_of(x) for x in node.operands]
        changed = [self.value(x) for x in node.operands]
        return _PASSED[node.operation](self._bounds.range_of(node), original, changed, d)

    def _value_from_operands(self, node: Expression, gone: bool = False) -> Interval:
        """The value of a node from its operands, without those that are `gone`."""
        x = [ZERO if gone and self.is_gone(node, k) else self.value(x) for k, x in enumerate(node.operands)]
        values: Interval = INTERVALS.operations[node.operation](*x)
        return values

    def _change(self, node: Expression) -> tuple[Interval, Interval]:
        """Difference from the full program, and value, of a node that itself is changed; on a path, stores its rate."""
        original = self._bounds.range_of(node)
        full = original if node.operation == op.SYMBOL else self._value_from_operands(node)
        if node.id in self._edits.frozen:
            end = interval(self._edits.frozen[node.id])
            difference, rate = end - original, end - full
        elif node.id in self._edits.straightened:
            x, end = node.operands[0], self.value(node.operands[0])
            low, high = (np.sign(x) * np.abs(x) ** 3 / 6 * (1 + 2.0**-48) for x in end)  # x - sin x: 0 to x^3 / 6
            rate = not_bounded_where(~end.is_bounded, Interval(np.minimum(low, 0.0), np.maximum(high, 0.0)))
            difference = self._difference_from_operands(node) + rate if self.of(x) is not ZERO else rate
        else:
            end = self._value_from_operands(node, gone=True)
            signs = [(k, -1 if node.operation == op.SUBTRACT and k else 1) for k in range(2)]
            rate = _sum(self.value(node.operands[k]) * -sign for k, sign in signs if self.is_gone(node, k))
            remaining = _sum(self.of(node.operands[k]) * sign for k, sign in signs if not self.is_gone(node, k))
            lost = _sum(self._bounds.range_of(node.operands[k]) * -sign for k, sign in signs if self.is_gone(node, k))
            difference = remaining + lost
        if not self._path:
            return difference, end
        self.rates[node.id] = rate
        propagated = ZERO if node.operation == op.SYMBOL else self._difference_from_operands(node)
        return propagated.hull(0) + rate.hull(0), full.hull(end)


def _sum(terms: Iterable[Interval]) -> Interval:
    """The sum of intervals, from zero on."""
    total = ZERO
    for term in terms:
        total = total + term
    return total


def _by_mean_value(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, edits: ChangedNodes
) -> Array:
    """Bound |sum a_i r_i| of the errors, by adjoints a and rates r on the path of changes (results, sub-boxes)."""
    path = _Recursion(bounds, edits, True)
    path.run(nodes)
    adjoints: dict[int, Interval] = {}
    for k, x in enumerate(results):
        if type(x) is Expression:
            add_adjoint(adjoints, x, unit_adjoint(k, len(results), bounds.shape))
    total = ZERO
    for node in reversed(nodes):
        adjoint = adjoints.pop(node.id, None)
        if adjoint is None:
            continue
        if node.id in path.rates:
            total = total + adjoint * path.rates[node.id]
            if not edits.changes(node):
                continue
        rule = op.OPERATIONS[node.operation].partials if node.operation != op.SYMBOL else None
        if rule is None or node.level == Level.CONSTANT:
            continue
        for operand, part in zip(node.operands, _partials(node, adjoint, path, edits), strict=True):
            if type(operand) is Expression:
                add_adjoint(adjoints, operand, part)
    return np.broadcast_to(total.magnitude, (len(results), *bounds.shape))


def _partials(node: Expression, adjoint: Interval, path: _Recursion, edits: ChangedNodes) -> list[Interval]:
    """The adjoints that a node propagates to its operands, over the path.

    A dropped addend, and operands of a frozen node, have a factor from 1 to 0; a sine that becomes its angle has a
    slope between those of both.
    """
    rule = op.OPERATIONS[node.operation].partials
    assert rule is not None
    parts = rule(INTERVALS.operations, path.value(node), [path.value(x) for x in node.operands]).back(adjoint)
    if node.id in edits.frozen:
        return [part.hull(0) for part in parts]
    if node.id in edits.straightened:
        return [part.hull(adjoint) for part in parts]
    return [part.hull(0) if path.is_gone(node, k) else part for k, part in enumerate(parts)]


Passed: TypeAlias = Callable[[Interval, Sequence[Interval], Sequence[Interval], Sequence[Interval]], Interval]
"""Function of a node's value, its operands' values in the full and in the changed program, and their differences."""


def _of_circle(function: str) -> Passed:
    """Return the rule for differences of sines or cosines: slope over the hull of the angles times their difference."""

    def difference(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
        slope: Interval = INTERVALS.operations[function](x[0].hull(y[0]))
        return slope * d[0]

    return difference


def _of_root(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    both: Interval = z + INTERVALS.operations[op.SQRT](y[0])
    return d[0] / both


def _of_arc(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    """Difference of an arc tangent by the mean value theorem; unbounded where the function may jump on the way."""
    ordinate, abscissa = (x[k].hull(y[k]) for k in range(2))
    difference = (abscissa * d[0] - ordinate * d[1]) / (ordinate.square() + abscissa.square())
    return not_bounded_where(meets_jump(ordinate, abscissa), difference)


def _of_extremum(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    """Difference of a minimum or maximum: it lies in the hull of the differences of both operands."""
    return d[0].hull(d[1])


_PASSED: Mapping[str, Passed] = {
    op.ADD: lambda z, x, y, d: d[0] + d[1],
    op.SUBTRACT: lambda z, x, y, d: d[0] - d[1],
    op.NEGATE: lambda z, x, y, d: -d[0],
    op.MULTIPLY: lambda z, x, y, d: x[0] * d[1] + x[1] * d[0] + d[0] * d[1],
    op.DIVIDE: lambda z, x, y, d: (d[0] - z * d[1]) / y[1],
    op.SIN: _of_circle(op.COS),
    op.COS: lambda z, x, y, d: -_of_circle(op.SIN)(z, x, y, d),
    op.SQRT: _of_root,
    op.ATAN2: _of_arc,
    op.SIGN: lambda z, x, y, d: not_bounded_where(True, z),
    op.MINIMUM: _of_extremum,
    op.MAXIMUM: _of_extremum,
}


@dataclass(frozen=True)
class ReducedErrors:
    """Error bounds of reduced programs against a full program, over its box."""

    whole: Subject
    progress: Progress = no_progress

    def __call__(self, program: Program, reduced: Program, changes: ChangedNodes) -> Mapping[str, Sequence[float]]:
        """Error bounds of the entries, by result, in their units; infinite where none is proven."""
        pairs = [
            (x, y)
            for output, reduced_output in zip(program.outputs, reduced.outputs, strict=True)
            for x, y in zip(output.entries, reduced_output.entries, strict=True)
        ]
        largest_errors = np.array(list(self._by_polynomials(pairs)))
        # Where x replaces sin x, polynomials treat both as independent: intervals of the difference may be tighter.
        if not np.isfinite(largest_errors).all() or any(on_both_sides(pair, self.whole.box) for pair in pairs):
            largest_errors = np.minimum(largest_errors, self._by_intervals(changes))
        ends = np.cumsum([len(output.entries) for output in program.outputs])[:-1]
        names = [output.name for output in program.outputs]
        return {name: part.tolist() for name, part in zip(names, np.split(largest_errors, ends), strict=True)}

    def _by_polynomials(self, pairs: Sequence[tuple[Operand, Operand]]) -> Iterator[float]:
        for k, (x, y) in enumerate(pairs):
            yield 0.0 if x is y else largest((x, y), self.whole.box, work=WORK).bound
            self.progress(k + 1, len(pairs))

    def _by_intervals(self, changes: ChangedNodes) -> Array:
        """The errors of all entries over sub-boxes, cut where that makes them smallest (lemma 3)."""

        def errors(parts: Parts) -> Array:
            return errors_of_changes(self.whole.nodes, self.whole.results, self.whole.bounds(parts), changes)

        return np.asarray(errors(self.whole.cut(errors, MOST_SUB_BOXES)).max(axis=1))
