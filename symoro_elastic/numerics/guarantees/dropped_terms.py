"""Lemma 3, dropped terms: how far a program with terms left out is from the whole one, with signs.

Let z be the values of the nodes of the whole program, z~ those of the changed one, where an addend t is dropped, a node
is frozen to a constant c, or a sine is replaced by its angle.

1. The differences d = z~ - z follow by recursion, as running errors do, but signed: d_x + d_y for a sum, less the
   dropped addend itself where it is gone; x d_y + y d_x + d_x d_y for a product; (d_x - z d_y)/y~ for a quotient.
2. Along the path that multiplies each dropped addend by 1 - s, s from 0 to 1, and mixes a frozen node and its constant,
   or a sine and its angle, in the same way, f moves at the rate sum a_i r_i with r_i = -t, c - z_i, x - sin x, where
   the adjoints a_i and all values are those of the path. So

       f_S - f is in sum [a_i] [r_i]

   with both over hulls of the path, and with signs: errors of opposite sign make room for each other.

A sign, and an arc tangent that may jump, mix both of their values on the path, as frozen nodes do: their rate is the
difference by 1.

The smaller of both is taken in each sub-box. It is the error of the exact reduced program; its rounding comes on top.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval, meets_jump, not_bounded_where
from symoro_elastic.numerics.guarantees.running_error import Bounds
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import (
    ADD,
    ATAN2,
    COS,
    DIVIDE,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    OPERATIONS,
    SIGN,
    SIN,
    SQRT,
    SUBTRACT,
    SYMBOL,
)

ZERO = interval(0)


@dataclass(frozen=True)
class ChangedNodes:
    """Changes of a program, by number of the node: dropped operands of sums, frozen nodes, sines that are angles."""

    dropped: frozenset[tuple[int, int]] = frozenset()
    frozen: Mapping[int, Fraction] = field(default_factory=dict)
    straightened: frozenset[int] = frozenset()

    def changes(self, node: Expression) -> bool:
        """Whether a node is changed itself."""
        gone = any((node.id, k) in self.dropped for k in range(2))
        return gone or node.id in self.frozen or node.id in self.straightened


Differences: TypeAlias = dict[int, Interval]
"""z~ - z of each node that differs, by number."""


def errors_of_changes(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, edits: ChangedNodes
) -> Array:
    """The largest |f_S - f| of each result by sub-box (results, sub-boxes); infinite where it is not bounded.

    `bounds` has the ranges of the nodes of the whole program.
    """
    with np.errstate(all="ignore"):
        changed = _Recursion(bounds, edits, False)
        changed.run(nodes)
        found = np.array([np.broadcast_to(changed.of(x).magnitude, bounds.shape) for x in results])
        smaller: Array = np.minimum(found, _by_mean_value(nodes, results, bounds, edits))
    return smaller


class _Recursion:
    """Values of the changed program and their differences from the whole one, in order; of all the way on a `path`."""

    def __init__(self, bounds: Bounds, edits: ChangedNodes, path: bool) -> None:
        self._bounds, self._edits, self._path = bounds, edits, path
        self.differences: Differences = {}
        self._values: dict[int, Interval] = {}
        self.rates: dict[int, Interval] = {}

    def run(self, nodes: Sequence[Expression]) -> None:
        """Follow all nodes."""
        for node in nodes:
            if self._edits.changes(node):
                self._keep(node, *self._changed(node))
            elif node.operation != SYMBOL and any(self.of(x) is not ZERO for x in node.operands):
                self._keep(node, self._passed(node), self._computed(node))
                if self._jumps(node):
                    self.rates[node.id] = self.differences[node.id]

    def of(self, x: Operand) -> Interval:
        """The difference of a node or a constant."""
        return self.differences.get(x.id, ZERO) if type(x) is Expression else ZERO

    def value(self, x: Operand) -> Interval:
        """The values of a node or a constant in the changed program, or on the path."""
        known = self._values.get(x.id) if type(x) is Expression else None
        return self._bounds.range_of(x) if known is None else known

    def is_gone(self, node: Expression, k: int) -> bool:
        """Whether an operand of a sum is dropped."""
        return (node.id, k) in self._edits.dropped

    def _jumps(self, node: Expression) -> bool:
        """Whether a node may jump on the path, in some sub-box."""
        if node.operation == ATAN2:
            return bool(np.any(meets_jump(*(self.value(x).hull(self._bounds.range_of(x)) for x in node.operands))))
        return node.operation == SIGN

    def _keep(self, node: Expression, difference: Interval, value: Interval) -> None:
        """Note both, each as far as the other allows."""
        whole = self._bounds.range_of(node)
        self._values[node.id] = found = value.meeting(whole + difference)
        self.differences[node.id] = difference.meeting(found - whole)

    def _passed(self, node: Expression) -> Interval:
        """The difference that a node has from its operands."""
        d = [self.of(x) for x in node.operands]
        whole = [self._bounds.range_of(x) for x in node.operands]
        changed = [self.value(x) for x in node.operands]
        return _PASSED[node.operation](self._bounds.range_of(node), whole, changed, d)

    def _computed(self, node: Expression, gone: bool = False) -> Interval:
        """The value of a node from its operands, without those that are `gone`."""
        x = [ZERO if gone and self.is_gone(node, k) else self.value(x) for k, x in enumerate(node.operands)]
        found: Interval = INTERVALS.operations[node.operation](*x)
        return found

    def _changed(self, node: Expression) -> tuple[Interval, Interval]:
        """Difference and value of a node that is changed itself; its rate on the path is noted."""
        whole = self._bounds.range_of(node)
        full = whole if node.operation == SYMBOL else self._computed(node)
        if node.id in self._edits.frozen:
            end = interval(self._edits.frozen[node.id])
            difference, rate = end - whole, end - full
        elif node.id in self._edits.straightened:
            x, end = node.operands[0], self.value(node.operands[0])
            rate = _angle_less_sine(end)
            difference = self._passed(node) + rate if self.of(x) is not ZERO else rate
        else:
            end = self._computed(node, gone=True)
            signed = [(k, -1 if node.operation == SUBTRACT and k else 1) for k in range(2)]
            rate = _sum(self.value(node.operands[k]) * -sign for k, sign in signed if self.is_gone(node, k))
            kept = _sum(self.of(node.operands[k]) * sign for k, sign in signed if not self.is_gone(node, k))
            lost = _sum(self._bounds.range_of(node.operands[k]) * -sign for k, sign in signed if self.is_gone(node, k))
            difference = kept + lost
        if not self._path:
            return difference, end
        self.rates[node.id] = rate
        passed = ZERO if node.operation == SYMBOL else self._passed(node)
        return passed.hull(0) + rate.hull(0), full.hull(end)


def _sum(terms: Iterable[Interval]) -> Interval:
    """The sum of intervals, from zero on."""
    total = ZERO
    for term in terms:
        total = total + term
    return total


def _by_mean_value(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, edits: ChangedNodes
) -> Array:
    """|sum a_i r_i| of each result by sub-box."""
    path = _Recursion(bounds, edits, True)
    path.run(nodes)
    adjoints: dict[int, Interval] = {}
    for k, x in enumerate(results):
        if type(x) is Expression:
            one = np.zeros((len(results), *bounds.shape))
            one[k] = 1.0
            _add(adjoints, x, Interval(one, one))
    zero = np.zeros((len(results), *bounds.shape))
    total = Interval(zero, zero)
    for node in reversed(nodes):
        adjoint = adjoints.pop(node.id, None)
        if adjoint is None:
            continue
        if node.id in path.rates:
            total = total + adjoint * path.rates[node.id]
            if not edits.changes(node):
                continue
        rule = OPERATIONS[node.operation].partials if node.operation != SYMBOL else None
        if rule is None or node.level == Level.CONSTANT:
            continue
        for operand, part in zip(node.operands, _partials(node, adjoint, path, edits), strict=True):
            if type(operand) is Expression:
                _add(adjoints, operand, part)
    return total.magnitude


def _partials(node: Expression, adjoint: Interval, path: _Recursion, edits: ChangedNodes) -> list[Interval]:
    """The adjoints that a node hands on to its operands, over the path.

    A dropped addend has a share of 1 to 0 of its own, operands of a frozen node likewise; a sine on its way to its
    angle has the slope of one of both, or between.
    """
    rule = OPERATIONS[node.operation].partials
    assert rule is not None
    parts = rule(INTERVALS.operations, path.value(node), [path.value(x) for x in node.operands]).back(adjoint)
    if node.id in edits.frozen:
        return [part.hull(0) for part in parts]
    if node.id in edits.straightened:
        return [part.hull(adjoint) for part in parts]
    return [part.hull(0) if path.is_gone(node, k) else part for k, part in enumerate(parts)]


def _add(adjoints: dict[int, Interval], x: Expression, part: Interval) -> None:
    adjoints[x.id] = adjoints[x.id] + part if x.id in adjoints else part


def _angle_less_sine(x: Interval) -> Interval:
    """x - sin x, which grows with x, and is at most |x|^3 / 6."""
    low, high = (np.sign(end) * np.abs(end) ** 3 / 6 * (1 + 2.0**-48) for end in x)
    return not_bounded_where(~x.is_bounded, Interval(np.minimum(low, 0.0), np.maximum(high, 0.0)))


Passed: TypeAlias = Callable[[Interval, Sequence[Interval], Sequence[Interval], Sequence[Interval]], Interval]
"""From a node's value in the whole program, those of its operands there, in the changed one, and their differences."""


def _of_quotient(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    return (d[0] - z * d[1]) / y[1]


def _of_circle(function: str) -> Passed:
    """A mean value of the slope over the hull, times the difference of the angle."""

    def passed(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
        slope: Interval = INTERVALS.operations[function](x[0].hull(y[0]))
        return slope * d[0]

    return passed


def _of_root(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    both: Interval = z + INTERVALS.operations[SQRT](y[0])
    return d[0] / both


def _of_arc(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    """A mean value of the slope over the hull, unless the arc tangent jumps there."""
    one, other = (x[k].hull(y[k]) for k in range(2))
    found = (other * d[0] - one * d[1]) / (one.square() + other.square())
    return not_bounded_where(meets_jump(one, other), found)


def _none(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    """No bound: the step of what has changed is not followed."""
    return not_bounded_where(True, z)


def _of_extremum(z: Interval, x: Sequence[Interval], y: Sequence[Interval], d: Sequence[Interval]) -> Interval:
    """The lesser and the larger of two numbers change by no more, and no less, than these do."""
    return d[0].hull(d[1])


_PASSED: Mapping[str, Passed] = {
    ADD: lambda z, x, y, d: d[0] + d[1],
    SUBTRACT: lambda z, x, y, d: d[0] - d[1],
    NEGATE: lambda z, x, y, d: -d[0],
    MULTIPLY: lambda z, x, y, d: x[0] * d[1] + x[1] * d[0] + d[0] * d[1],
    DIVIDE: _of_quotient,
    SIN: _of_circle(COS),
    COS: lambda z, x, y, d: -_of_circle(SIN)(z, x, y, d),
    SQRT: _of_root,
    ATAN2: _of_arc,
    SIGN: _none,
    MINIMUM: _of_extremum,
    MAXIMUM: _of_extremum,
}
