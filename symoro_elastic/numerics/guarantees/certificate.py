"""Certificates: what a generated function guarantees where its arguments are in a box."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property, partial
from typing import NamedTuple, TypeAlias

import numpy as np

from symoro_elastic.codegen.c.printers import angles_of
from symoro_elastic.codegen.package import Function
from symoro_elastic.codegen.printed_order import in_place_of, in_printed_order
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.numerics.guarantees.affine_bounds import Forms, forms_of
from symoro_elastic.numerics.guarantees.box import Box, points
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.linear_solver import Solver
from symoro_elastic.numerics.guarantees.mean_value import errors_by_adjoints
from symoro_elastic.numerics.guarantees.running_error import Bounds, Known, Narrowing, Rounding, running_errors
from symoro_elastic.numerics.guarantees.sub_boxes import Parts, cut
from symoro_elastic.numerics.quantile_bound import CONFIDENCE, bound_of_more, share_beyond
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import DIVIDE, NEGATE

MOST_SUB_BOXES = 64
DRAWN, UNSEEN = 1000, 1_000_000
"""States at which errors are proven, and unseen ones that a bound is estimated for."""
MOST_TIMES = 1000.0
"""A proven error or range that is so many times that of drawn states says nothing of the code: it is not reported."""
PIVOT = re.compile(r"H\d+")
"""What the inertia that a joint moves is called, where a divisor has several names."""


class Guarantee(StrEnum):
    """What stands behind a bound; never one for another."""

    PROVEN = "proven"
    CONFIDENT = (
        f"with {CONFIDENCE:.0%} confidence at {1 - share_beyond(DRAWN):.1%} of the states drawn at random in the box, "
        f"and at {UNSEEN} of them by the tail of the drawn errors"
    )
    NONE = "not bounded"


@dataclass(frozen=True)
class EntryBound:
    """Of one entry of a result: its range in exact arithmetic, and the error of its computed value.

    `name` is that of the result, `entry` what the entry belongs to. `low`, `high` and `error` are proven; infinite
    where nothing is, or what is proven is more than `MOST_TIMES` what drawn states have. `likely` bounds the error at
    states drawn as `Box.states` draws them, with a probability of `CONFIDENCE`: at all but `share_beyond(DRAWN)` of
    them whatever the distribution of errors, at `UNSEEN` of them by the tail beyond `DRAWN` states, at each of which
    the error is proven.
    """

    name: str
    entry: str
    low: float
    high: float
    error: float
    likely: float

    @property
    def guarantee(self) -> Guarantee:
        """What stands behind the error that is reported."""
        if math.isfinite(self.error):
            return Guarantee.PROVEN
        return Guarantee.CONFIDENT if math.isfinite(self.likely) else Guarantee.NONE

    @property
    def magnitude(self) -> float:
        """The largest absolute value in the range."""
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True)
class PivotBound:
    """A divisor, and its least magnitude over the box: 0 where it may be zero."""

    name: str
    least: float


@dataclass(frozen=True, repr=False)
class Certificate(Result):
    """What one model guarantees in one precision where its arguments are in a `box`.

    `overflows` tells that an intermediate value may be out of the range of the precision; `sub_boxes` is how many the
    box was cut into.
    """

    machine: str
    model: str
    precision: str
    box: Box = field(repr=False)
    entries: tuple[EntryBound, ...]
    pivots: tuple[PivotBound, ...]
    overflows: bool
    sub_boxes: int

    @property
    def headline(self) -> str:
        """Model, and what is guaranteed of it."""
        return f"Certificate of {self.machine}, {self.model}, {self.precision}: {self.guarantee}"

    @property
    def guarantee(self) -> Guarantee:
        """The weakest guarantee of all entries."""
        order = list(Guarantee)
        return max((entry.guarantee for entry in self.entries), key=order.index, default=Guarantee.PROVEN)


Knowledge: TypeAlias = Callable[[Parts], Known]
"""From sub-boxes to what is known of nodes there."""


def nothing_known(parts: Parts) -> Known:
    """Nothing but what intervals say."""
    return {}


@dataclass(frozen=True)
class Subject:
    """A function, its rounding, and what is known of its nodes: what a certificate is made of.

    `solver` bounds errors of the linear system that it solves, where it does (lemma 8). `is_printed` tells that sums
    are in the order of the text: put in that order twice, they would have another one.
    """

    function: Function
    box: Box
    rounding: Rounding
    knowledge: Knowledge = nothing_known
    solver: Solver | None = None
    is_printed: bool = False

    @cached_property
    def nodes(self) -> list[Expression]:
        """The operations of the function, in order."""
        return self.function.program.nodes

    @cached_property
    def results(self) -> list[Operand]:
        """All entries of its results."""
        return [x for output in self.function.program.outputs for x in output.entries]

    @cached_property
    def _angles(self) -> frozenset[int]:
        return frozenset(node.id for node in reachable(angles_of(self.function.program)))

    def as_printed(self) -> Subject:
        """The same of the program as its text is carried out, which is what a certificate is of."""
        if self.is_printed:
            return self
        program, changed = in_printed_order(self.function.program)

        def knowledge(parts: Parts) -> Known:
            found = {number: (changed.get(number), x) for number, x in self.knowledge(parts).items()}
            return dict(_of_positive(number, new, x) for number, (new, x) in found.items())

        solver = self.solver and self.solver.moved(partial(in_place_of, changed=changed), program)
        function = replace(self.function, program=program)
        return replace(self, function=function, knowledge=knowledge, solver=solver, is_printed=True)

    def bounds(self, parts: Parts) -> Bounds:
        """Ranges and errors of all nodes over sub-boxes (lemma 1)."""
        return running_errors(self.nodes, parts, self.rounding, self._angles, self.knowledge(parts))

    def closer(self, bounds: Bounds, parts: Parts) -> tuple[Bounds, Forms | None]:
        """Smaller ranges and errors of all nodes from affine forms (lemma 9), and the forms with these."""
        forms = forms_of(self.nodes, bounds, parts, len(self.results))
        if forms is None:
            return bounds, None
        closer = replace(self, knowledge=lambda parts: forms.narrowing()).bounds(parts)
        return closer, forms_of(self.nodes, closer, parts)

    def errors(self, bounds: Bounds, adjoints: bool = True, forms: Forms | None = None) -> Array:
        """The error of each result by sub-box: the smaller one of lemmas 1 and 2, this with adjoints of forms, too."""
        running = np.empty((len(self.results), *bounds.shape))
        for row, x in zip(running, self.results, strict=True):
            row[...] = bounds.error_of(x)
        if not adjoints or not len(running):
            return running
        by_adjoints: Array = errors_by_adjoints(self.nodes, self.results, bounds, forms)
        smaller: Array = np.minimum(running, by_adjoints)
        return smaller

    def solved(self, bounds: Bounds, parts: Parts, adjoints: bool = True) -> Bounds:
        """Smaller ranges and errors, of all nodes, from those of the system that is solved (lemma 8)."""
        return self.solver(bounds, parts, adjoints) if self.solver else bounds


def _of_positive(number: int, new: Expression | None, x: Narrowing) -> tuple[int, Narrowing]:
    """Number of a node, or of what stands in its place without its sign, and what is known of that."""
    if new is None:
        return number, x
    return new.positive.id, (lambda found: -x(-found)) if new.operation == NEGATE else x


def certify(
    subject: Subject,
    machine: str,
    most_sub_boxes: int = MOST_SUB_BOXES,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Certificate:
    """What a function guarantees over its box, which is cut into at most so many sub-boxes."""
    subject = subject.as_printed()
    return certificate_over(subject, machine, sub_boxes_of(subject, most_sub_boxes, progress), seed)


def certificate_over(subject: Subject, machine: str, parts: Parts, seed: int = 0) -> Certificate:
    """What a function guarantees over its box, from these sub-boxes of it."""
    subject = subject.as_printed()
    bounds, forms = subject.closer(subject.bounds(parts), parts)
    by_operations = subject.errors(bounds, forms=forms)
    bounds = subject.solved(bounds, parts)
    errors = np.minimum(by_operations, subject.errors(bounds, adjoints=False)).max(axis=1, initial=0.0)
    drawn = _drawn(subject, np.random.default_rng(seed))
    entries = [
        _entry(name, entry, bounds.range_of(x), float(error), often)
        for (name, entry), x, error, often in zip(labels(subject.function), subject.results, errors, drawn, strict=True)
    ]
    largest = max((float(np.max(bounds.computed(node).magnitude)) for node in subject.nodes), default=0.0)
    return Certificate(
        machine,
        subject.function.name,
        subject.rounding.name,
        subject.box,
        tuple(entries),
        tuple(_pivots(subject, bounds)),
        not largest <= subject.rounding.largest,
        len(next(iter(parts.values())).low) if parts else 1,
    )


class _Drawn(NamedTuple):
    """At drawn states: the largest magnitude of a result, and the bound on errors at more of them."""

    largest: float
    error: float


def _entry(name: str, entry: str, found: Interval, error: float, drawn: _Drawn) -> EntryBound:
    """What is proven of an entry, as far as it is near what drawn states have, and what these say."""
    low, high = float(np.min(found.low)), float(np.max(found.high))
    if _is_far(max(abs(low), abs(high)), drawn.largest):
        low, high = -math.inf, math.inf
    told = math.inf if _is_far(error, drawn.error) else error
    return EntryBound(name, entry, low, high, told, min(drawn.error, error))


def _is_far(proven: float, drawn: float) -> bool:
    return 0 < drawn < proven / MOST_TIMES


def sub_boxes_of(subject: Subject, most: int, progress: Progress = no_progress) -> Parts:
    """The sub-boxes in which errors are bounded, at most so many."""
    parts = subject.box.of(name for name in subject.box.ranges if name in subject.function.program.used).whole
    names = [name for name in parts if name in subject.box.positions and name in subject.box.open]

    def errors(tried: Parts) -> Array:
        return subject.errors(subject.solved(subject.bounds(tried), tried, adjoints=False), adjoints=False)

    return cut(parts, names, errors, most, progress)


def _drawn(subject: Subject, rng: np.random.Generator) -> list[_Drawn]:
    """Values at drawn states, and bounds on errors at states that are not drawn, from proven ones at drawn states."""
    used = subject.box.of(name for name in subject.box.ranges if name in subject.function.program.used)
    if not used.ranges:
        return [_Drawn(0.0, 0.0)] * len(subject.results)
    states = points(used.states(DRAWN, rng))
    bounds = subject.solved(subject.bounds(states), states, adjoints=False)
    largest = [float(np.max(bounds.range_of(x).magnitude)) for x in subject.results]
    errors = [bound_of_more(row, UNSEEN) if np.any(row) else 0.0 for row in subject.errors(bounds, adjoints=False)]
    return [_Drawn(value, error) for value, error in zip(largest, errors, strict=True)]


def labels(function: Function) -> Iterator[tuple[str, str]]:
    """Name of the result, and what the entry belongs to, of all entries."""
    for result in function.results:
        for index in np.ndindex(*result.shape):
            axes = (result.rows, result.columns or result.rows) if len(index) > 1 else (result.rows or result.columns,)
            words = [axis[k] if k < len(axis) else str(k + 1) for axis, k in zip((*axes, ()), index, strict=False)]
            yield result.name, ", ".join(words)


def _pivots(subject: Subject, bounds: Bounds) -> Iterator[PivotBound]:
    """The divisors that depend on the state, by their names."""
    program = subject.function.program
    named = [(name, x.positive.id) for name, x in program.quantities.items() if isinstance(x, Expression)]
    named = [(s.name, s.node.id) for s in (*program.once, *program.statements)] + named
    named += [(name, number) for name, number in named if PIVOT.fullmatch(name)]
    names = {number: name for name, number in named}
    divisors = (node.operands[1] for node in subject.nodes if node.operation == DIVIDE)
    for k, x in enumerate(dict.fromkeys(x.positive for x in divisors if isinstance(x, Expression))):
        least = np.min(bounds.computed(x).least_magnitude)
        yield PivotBound(names.get(x.id, f"divisor {k + 1}"), float(least))
