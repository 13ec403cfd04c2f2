"""Certificates: ranges and error bounds of a generated function whose arguments are in a box."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple, TypeAlias

import numpy as np

from symoro_elastic.codegen.c.printers import angles_of
from symoro_elastic.codegen.package import Function
from symoro_elastic.codegen.printed_order import in_place_of, in_printed_order
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.within import Evidence
from symoro_elastic.numerics.evaluation.quantile_bound import CONFIDENCE, bound_of_more, share_beyond
from symoro_elastic.numerics.guarantees.box import Box, Parts, cut, points
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.linear_solver import Solver
from symoro_elastic.numerics.guarantees.mean_value import Forms, errors_by_adjoints, forms_of
from symoro_elastic.numerics.guarantees.running_error import Bounds, Known, Narrowing, Rounding, running_errors
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import DIVIDE, NEGATE

MOST_SUB_BOXES = 64
DRAWN, UNSEEN = 1000, 1_000_000
"""Number of random states with proven errors, and of unseen states for which a bound is extrapolated."""
MOST_TIMES = 1000.0
"""A proven error or range that exceeds that of random states by this factor is too loose to be reported."""
PIVOT = re.compile(r"H\d+")
"""Preferred name of a divisor with several names: the inertia that a joint moves."""
WITH_CONFIDENCE = (
    f"with {CONFIDENCE:.0%} confidence at {1 - share_beyond(DRAWN):.1%} of the states drawn at random in the box, "
    f"and at {UNSEEN} of them by the tail of the drawn errors"
)
"""`Evidence.CONFIDENT` in words."""


def evidence_text(evidence: Evidence) -> str:
    """Return the evidence of a certificate in words."""
    return WITH_CONFIDENCE if evidence is Evidence.CONFIDENT else str(evidence)


@dataclass(frozen=True)
class EntryBound:
    """Bounds of an entry of a result: its range in exact arithmetic, and the error of its computed value.

    `name` is that of the result, `entry` the label of the entry. `low`, `high` and `error` are proven; infinite
    where there is no proof, or bounds exceed the errors of random states `MOST_TIMES`. `likely` bounds the error at
    states drawn as `Box.states` draws them, with a probability of `CONFIDENCE`: at all but `share_beyond(DRAWN)` of
    them whatever the distribution of errors, at `UNSEEN` of them by the tail beyond `DRAWN` states, where
    the error is proven.
    """

    name: str
    entry: str
    low: float
    high: float
    error: float
    likely: float

    @property
    def guarantee(self) -> Evidence:
        """Evidence for the reported error."""
        if math.isfinite(self.error):
            return Evidence.PROVEN
        return Evidence.CONFIDENT if math.isfinite(self.likely) else Evidence.NONE

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
    """Guarantees of a model in a precision, for arguments in a `box`.

    `overflows`: an intermediate value may exceed the range of the precision; `sub_boxes` is the number of parts of the
    box.
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
        """Machine, model, precision and weakest guarantee, as text."""
        return f"Certificate of {self.machine}, {self.model}, {self.precision}: {evidence_text(self.guarantee)}"

    @property
    def guarantee(self) -> Evidence:
        """The weakest guarantee of all entries."""
        order = list(Evidence)
        return max((entry.guarantee for entry in self.entries), key=order.index, default=Evidence.PROVEN)


Knowledge: TypeAlias = Callable[[Parts], Known]
"""A function from sub-boxes to functions that narrow the intervals of nodes there."""


@dataclass(frozen=True)
class Subject:
    """The subject of a certificate: a function, its box, its rounding, and narrower ranges known for its nodes.

    `solver` bounds errors of the linear system that it solves, if any (lemma 8). `is_printed`: sums are in the order of
    the text already, which a second reordering would change.
    """

    function: Function
    box: Box
    rounding: Rounding
    knowledge: Knowledge = lambda parts: {}
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
        """The subject whose program has the order of operations of the printed text, which certificates require."""
        if self.is_printed:
            return self
        program, changed = in_printed_order(self.function.program)

        def knowledge(parts: Parts) -> Known:
            return dict(_of_positive(number, changed.get(number), x) for number, x in self.knowledge(parts).items())

        solver = self.solver and self.solver.of_program(partial(in_place_of, changed=changed), program)
        function = replace(self.function, program=program)
        return replace(self, function=function, knowledge=knowledge, solver=solver, is_printed=True)

    @cached_property
    def used_box(self) -> Box:
        """The box of the variables that the program uses."""
        return self.box.of(name for name in self.box.ranges if name in self.function.program.used)

    def cut(self, errors: Callable[[Parts], Array], most: int, progress: Progress = no_progress) -> Parts:
        """The sub-boxes, at most `most`, cut along positions where that makes errors smallest."""
        names = [name for name in self.used_box.open if name in self.box.positions]
        return cut(self.used_box.whole, names, errors, most, progress)

    def bounds(self, parts: Parts) -> Bounds:
        """Ranges and errors of all nodes over sub-boxes (lemma 1)."""
        return running_errors(self.nodes, parts, self.rounding, self._angles, self.knowledge(parts))

    def closer(self, bounds: Bounds, parts: Parts) -> tuple[Bounds, Forms | None]:
        """Ranges and errors of all nodes narrowed by affine forms (lemma 9), and the forms from these."""
        forms = forms_of(self.nodes, bounds, parts, len(self.results))
        if forms is None:
            return bounds, None
        closer = replace(self, knowledge=lambda parts: forms.narrowing()).bounds(parts)
        return closer, forms_of(self.nodes, closer, parts)

    def errors(self, bounds: Bounds, adjoints: bool = True, forms: Forms | None = None) -> Array:
        """Errors of results by sub-box: the lesser of running errors (lemma 1) and errors by adjoints (lemma 2)."""
        running = np.empty((len(self.results), *bounds.shape))
        for row, x in zip(running, self.results, strict=True):
            row[...] = bounds.error_of(x)
        if not adjoints or not len(running):
            return running
        by_adjoints: Array = errors_by_adjoints(self.nodes, self.results, bounds, forms)
        return np.asarray(np.minimum(running, by_adjoints))

    def solver_bounds(self, bounds: Bounds, parts: Parts, adjoints: bool = True) -> Bounds:
        """Ranges and errors of all nodes, narrowed by the bounds of the linear system (lemma 8)."""
        return self.solver(bounds, parts, adjoints) if self.solver else bounds


def _of_positive(number: int, new: Expression | None, x: Narrowing) -> tuple[int, Narrowing]:
    """Return number and narrowing of the node that replaces a node; the narrowing is mirrored if the sign changes."""
    if new is None:
        return number, x
    return new.positive.id, (lambda values: -x(-values)) if new.operation == NEGATE else x


def certify(
    subject: Subject,
    machine: str,
    most_sub_boxes: int = MOST_SUB_BOXES,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Certificate:
    """The certificate of a function over its box, in at most `most_sub_boxes` sub-boxes."""
    subject = subject.as_printed()
    return certificate_over(subject, machine, sub_boxes_of(subject, most_sub_boxes, progress), seed)


def certificate_over(subject: Subject, machine: str, parts: Parts, seed: int = 0) -> Certificate:
    """The certificate of a function from given sub-boxes of its box."""
    subject = subject.as_printed()
    bounds, forms = subject.closer(subject.bounds(parts), parts)
    by_operations = subject.errors(bounds, forms=forms)
    bounds = subject.solver_bounds(bounds, parts)
    errors = np.minimum(by_operations, subject.errors(bounds, adjoints=False)).max(axis=1, initial=0.0)
    samples = _samples(subject, np.random.default_rng(seed))
    rows = zip(labels(subject.function), subject.results, errors, samples, strict=True)
    entries = [_entry(*of, bounds.range_of(x), float(error), sample) for of, x, error, sample in rows]
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


class _Sample(NamedTuple):
    """Largest magnitude of a result at random states, and a confident bound of errors at unseen states."""

    largest: float
    error: float


def _entry(name: str, entry: str, values: Interval, error: float, sample: _Sample) -> EntryBound:
    """Bounds of an entry: proven ones unless they are too loose against random states, and confident ones."""
    low, high = float(np.min(values.low)), float(np.max(values.high))
    if _is_far(max(abs(low), abs(high)), sample.largest):
        low, high = -math.inf, math.inf
    reported = math.inf if _is_far(error, sample.error) else error
    return EntryBound(name, entry, low, high, reported, min(sample.error, error))


def _is_far(proven: float, sampled: float) -> bool:
    return 0 < sampled < proven / MOST_TIMES


def sub_boxes_of(subject: Subject, most: int, progress: Progress = no_progress) -> Parts:
    """The sub-boxes, at most `most`, that make error bounds smallest."""

    def errors(parts: Parts) -> Array:
        return subject.errors(subject.solver_bounds(subject.bounds(parts), parts, adjoints=False), adjoints=False)

    return subject.cut(errors, most, progress)


def _samples(subject: Subject, rng: np.random.Generator) -> list[_Sample]:
    """Magnitudes at random states, and confident bounds of errors at unseen states from proven errors at these."""
    if not subject.used_box.ranges:
        return [_Sample(0.0, 0.0)] * len(subject.results)
    states = points(subject.used_box.states(DRAWN, rng))
    bounds = subject.solver_bounds(subject.bounds(states), states, adjoints=False)
    largest = [float(np.max(bounds.range_of(x).magnitude)) for x in subject.results]
    errors = [bound_of_more(row, UNSEEN) if np.any(row) else 0.0 for row in subject.errors(bounds, adjoints=False)]
    return [_Sample(value, error) for value, error in zip(largest, errors, strict=True)]


def labels(function: Function) -> Iterator[tuple[str, str]]:
    """Names of results and labels of entries, entry by entry."""
    for result in function.results:
        for index in np.ndindex(*result.shape):
            axes = (result.rows, result.columns or result.rows) if len(index) > 1 else (result.rows or result.columns,)
            words = [axis[k] if k < len(axis) else str(k + 1) for axis, k in zip((*axes, ()), index, strict=False)]
            yield result.name, ", ".join(words)


def _pivots(subject: Subject, bounds: Bounds) -> Iterator[PivotBound]:
    """The divisors that depend on the state, by their names."""
    program = subject.function.program
    pairs = [(name, x.positive.id) for name, x in program.quantities.items() if isinstance(x, Expression)]
    pairs = [(s.name, s.node.id) for s in (*program.once, *program.statements)] + pairs
    pairs += [(name, number) for name, number in pairs if PIVOT.fullmatch(name)]
    names = {number: name for name, number in pairs}
    divisors = (node.operands[1] for node in subject.nodes if node.operation == DIVIDE)
    for k, x in enumerate(dict.fromkeys(x.positive for x in divisors if isinstance(x, Expression))):
        least = np.min(bounds.computed(x).least_magnitude)
        yield PivotBound(names.get(x.id, f"divisor {k + 1}"), float(least))
