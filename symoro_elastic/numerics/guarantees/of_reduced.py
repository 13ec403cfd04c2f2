"""Proven errors of reduced programs: by polynomials where results are such, else by intervals in sub-boxes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes, errors_of_changes
from symoro_elastic.numerics.guarantees.grid import largest
from symoro_elastic.numerics.guarantees.separated import on_both_sides
from symoro_elastic.numerics.guarantees.sub_boxes import Parts, cut
from symoro_elastic.symbolic.expression import Operand
from symoro_elastic.symbolic.program import Program

MOST_SUB_BOXES = 256
WORK = 5e9
"""For the polynomial of one result, about ten seconds: what is proven then counts."""


@dataclass(frozen=True)
class ReducedErrors:
    """How far the results of a reduced program are from those of a whole one, anywhere in the box of the latter."""

    whole: Subject
    progress: Progress = no_progress

    def __call__(self, program: Program, reduced: Program, changes: ChangedNodes) -> Mapping[str, Sequence[float]]:
        """The largest error of each entry, by result, in its unit; infinite where none is proven."""
        pairs = [
            (x, y)
            for one, other in zip(program.outputs, reduced.outputs, strict=True)
            for x, y in zip(one.entries, other.entries, strict=True)
        ]
        found = np.array(list(self._by_polynomials(pairs)))
        # Where x stands for sin x, polynomials take both as independent: intervals of the difference may be nearer.
        if not np.isfinite(found).all() or any(on_both_sides(pair, self.whole.box) for pair in pairs):
            found = np.minimum(found, self._by_intervals(changes))
        ends = np.cumsum([len(output.entries) for output in program.outputs])[:-1]
        names = [output.name for output in program.outputs]
        return {name: part.tolist() for name, part in zip(names, np.split(found, ends), strict=True)}

    def _by_polynomials(self, pairs: Sequence[tuple[Operand, Operand]]) -> Iterator[float]:
        for k, (x, y) in enumerate(pairs):
            yield 0.0 if x is y else largest((x, y), self.whole.box, work=WORK).bound
            self.progress(k + 1, len(pairs))

    def _by_intervals(self, changes: ChangedNodes) -> Array:
        """The errors of all entries over sub-boxes, cut where that makes them smallest (lemma 3)."""

        def errors(parts: Parts) -> Array:
            return errors_of_changes(self.whole.nodes, self.whole.results, self.whole.bounds(parts), changes)

        box = self.whole.box
        parts = box.of(name for name in box.ranges if name in self.whole.function.program.used).whole
        names = [name for name in parts if name in box.positions and name in box.open]
        worst: Array = errors(cut(parts, names, errors, MOST_SUB_BOXES)).max(axis=1)
        return worst
