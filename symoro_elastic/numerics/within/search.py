"""The search for the changes that save most within a limit: greedy, by signed effects, with growing limits.

One pass orders the candidates by their largest effect on a result, over all states, for each operation that they save,
and takes one after the other while the *signed sum* of effects stays within the limit everywhere: effects of opposite
sign make room for each other. Effects are of the first order, so that true errors are computed after the pass, and the
latest fifth of it is given back until they are within the limit. Then adjoints, effects and savings are computed anew
for the next pass, until a pass takes nothing; where all of a pass was given back, the next does without its first
candidate. The limit grows in steps: what is cheap is taken first, with effects that are still nearly exact. What else
has limits (`MoreErrors`: shifts of natural frequencies) is ordered, summed and checked together with the results.

What is taken out of a part that has died meanwhile would use up the tolerance twice: uses are counted after each change
(`liveness`), and a candidate that saves nothing any more is skipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.within.effects import Adjoints, Sweep, moved
from symoro_elastic.numerics.within.liveness import Liveness
from symoro_elastic.numerics.within.tape import Change, Changes, Rows, Tape
from symoro_elastic.symbolic.operations import DIVIDE

LIMITS = (0.3, 0.6, 0.8, 0.92, 1.0)
"""Of the limits, one for each step."""
GIVEN_BACK = 5
MOST_PASSES = 12
PIVOT_CHANGE = 0.1
"""Largest relative change of a denominator."""
NONE = np.zeros(0)


@dataclass(frozen=True)
class Sample:
    """States (symbols, states), and by result the reciprocal of its limit there (results, states)."""

    states: Array
    weights: Array


@dataclass(frozen=True)
class Taken:
    """The changes that a search took, in order, and how many it had at the end of each step."""

    changes: Sequence[Change] = ()
    steps: Sequence[int] = ()


NOTHING_TAKEN = Taken()


Accepts = Callable[[Sequence[Change]], bool]
"""Whether changes are possible together."""


def accept_all(changes: Sequence[Change]) -> bool:
    """All are."""
    return True


class MoreErrors(Protocol):
    """Errors beside those of the results, of their limits."""

    def errors(self, taken: Sequence[Change]) -> Array:
        """Return those of changes together, with signs; infinite or NaN where there is no such number."""

    def effects(self, taken: Sequence[Change]) -> Callable[[Change], Array]:
        """Return by how much one more change moves them, to first order."""


class Search:
    """The search on one tape and sample."""

    def __init__(
        self,
        tape: Tape,
        candidates: Sequence[Change],
        sample: Sample,
        accepts: Accepts = accept_all,
        more: MoreErrors | None = None,
    ) -> None:
        self._accepts, self._more = accepts, more
        states = sample.states.shape[1]
        self._tape, self._candidates, self._sample = tape, candidates, sample
        self._rows = tape.rows_in(np.empty((tape.count, states)))
        self._sweep = Sweep(tape, len(tape.results), states)
        tape.fill(self._rows, tape.steps(), sample.states)
        self._exact = tape.values(self._rows)
        self._unacceptable: set[Change] = set()
        self._computed: list[Change] = []
        self._errors = np.zeros(self._exact.shape)
        self._further: tuple[list[Change], Array] = [], more.errors([]) if more else NONE
        self._denominators = sorted({tape.operands[k][1] for k, x in enumerate(tape.operations) if x == DIVIDE})
        self._pivots = [self._rows[k].copy() for k in self._denominators]

    def run(self, former: Taken = NOTHING_TAKEN) -> Taken:
        """Return the changes taken: errors are within the limits at all states of the sample.

        It goes on from a `former` search, as far as that is within the limits here.
        """
        taken, steps = self._still_within(former)
        begun = self._begun(taken)
        for share in LIMITS[len(steps) :]:
            refused: set[Change] = set()
            for _ in range(MOST_PASSES):
                with np.errstate(all="ignore"):
                    tried = self._filled(begun, refused, share)
                if not tried:
                    break
                found = self._kept(taken, tried, share)
                taken = [*taken, *found]
                begun = self._begun(taken)
                if not found:
                    refused.add(tried[0])
            steps.append(len(taken))
        return Taken(taken, steps)

    def _still_within(self, former: Taken) -> tuple[list[Change], list[int]]:
        """Return what a former search had taken at the end of a step, of the last one that is within its limit here.

        The last step of all is searched anew.
        """
        before = list(zip(former.steps, LIMITS, strict=True))[:-1] if former.changes else []
        for number, (count, limit) in reversed(list(enumerate(before))):
            taken = list(former.changes[:count])
            if taken and self._is_within(taken, limit) and self._accepts(taken):
                return taken, list(former.steps[: number + 1])
        return [], []

    def errors(self, taken: list[Change]) -> Array:
        """Return signed errors of results (results, states), of their limits; rows have the values of these changes."""
        if taken != self._computed:
            changes, self._computed = Changes.of(taken), taken
            roots = [*self._tape.results, *self._denominators]
            self._tape.fill(self._rows, self._tape.steps(changes, roots=roots), self._sample.states)
            with np.errstate(all="ignore"):
                self._errors = (self._tape.values(self._rows) - self._exact) * self._sample.weights
        return self._errors

    def further(self, taken: list[Change]) -> Array:
        """Return signed errors beside those of the results."""
        if self._more and taken != self._further[0]:
            self._further = taken, self._more.errors(taken)
        return self._further[1]

    def _begun(self, taken: list[Change]) -> _Begun:
        """What the next passes choose from."""
        errors, live = [self.errors(taken), self.further(taken)], Liveness(self._tape, taken)
        adjoints = self._sweep.adjoints(self._rows, self._sample.weights, Changes.of(taken))
        effects = _Effects(self._tape, self._rows, adjoints, self._more.effects(taken) if self._more else None)
        possible = [change for change in self._candidates if live.is_possible(change)]
        with np.errstate(all="ignore"):
            sizes = [effects.largest(change) for change in possible]
        return _Begun(taken, live, errors, effects, dict(zip(possible, sizes, strict=True)))

    def _kept(self, taken: Sequence[Change], tried: Sequence[Change], limit: float) -> list[Change]:
        """Return the first of the changes, as many as true errors allow."""
        found = [*tried]
        while found and not self._is_within([*taken, *found], limit):
            del found[-max(1, len(found) // GIVEN_BACK) :]
        return found

    def _is_within(self, taken: list[Change], limit: float) -> bool:
        """Whether errors are within the limit, and no denominator has changed by much: not where one is NaN."""
        errors = self.errors(taken)
        if not largest(errors) <= limit:
            return False
        for place, exact in zip(self._denominators, self._pivots, strict=True):
            with np.errstate(all="ignore"):
                if not (np.abs(self._rows[place] - exact) <= PIVOT_CHANGE * np.abs(exact)).all():
                    return False
        return largest(self.further(taken)) <= limit

    def _filled(self, begun: _Begun, refused: Collection[Change], limit: float) -> list[Change]:
        """Return what a pass takes: candidates in order while the sum of errors and effects is within the limit.

        What is not accepted is not tried again: more changes would hardly make it so.
        """
        total, top, live = begun.errors, largest(*begun.errors), begun.live
        found: list[Change] = []
        for change, size in begun.ordered({*refused, *self._unacceptable}, limit + top):
            if size > limit + top or not live.is_possible(change) or live.saved_by(change) <= 0:
                continue
            trial = [one + effect for one, effect in zip(total, begun.effects.of(change), strict=True)]
            if not (reached := largest(*trial)) <= limit:
                continue
            if self._accepts([*begun.taken, *found, change]):
                total, top = trial, reached
                live.apply(change)
                found.append(change)
            else:
                self._unacceptable.add(change)
        return found


class _Effects:
    """Effects of changes on the results, and on `further` errors, first order, of their limits."""

    def __init__(
        self, tape: Tape, rows: Rows, adjoints: Adjoints, further: Callable[[Change], Array] | None = None
    ) -> None:
        self._tape, self._rows, self._adjoints = tape, rows, adjoints
        self._further = further or (lambda change: NONE)
        self._most: dict[int, Array] = {}
        found = next(x for x in adjoints if x is not None)
        self._product = np.empty_like(found)

    def of(self, change: Change) -> list[Array]:
        """Return the effects on results (results, states) and further errors, valid until the next call."""
        adjoint = self._adjoints[change.place]
        if adjoint is None:
            self._product[:] = 0.0
        else:
            np.multiply(adjoint, moved(self._tape, self._rows, change), self._product)
        return [self._product, self._further(change)]

    def largest(self, change: Change) -> float:
        """Return the largest magnitude of the effects; on results that of the largest adjoint of each state."""
        adjoint, further = self._adjoints[change.place], self._further(change)
        if adjoint is None:
            return largest(further)
        if (most := self._most.get(id(adjoint))) is None:
            most = self._most[id(adjoint)] = np.maximum(adjoint.max(axis=0), -adjoint.min(axis=0))
        return largest(most * moved(self._tape, self._rows, change), further)


@dataclass(frozen=True)
class _Begun:
    """Changes taken, and what is known of the program with them, until one of `sizes` is taken, too.

    `sizes` are the largest effects of the candidates that are possible.
    """

    taken: Sequence[Change]
    live: Liveness
    errors: Sequence[Array]
    effects: _Effects
    sizes: Mapping[Change, float]
    saved: dict[Change, int] = field(default_factory=dict)

    def ordered(self, refused: Collection[Change], most: float) -> list[tuple[Change, float]]:
        """Candidates with their largest effects, not above the most, by effect for each operation saved."""
        found = []
        for number, (change, size) in enumerate(self.sizes.items()):
            if size <= most and change not in refused:
                if (saved := self.saved.get(change)) is None:
                    saved = self.saved[change] = self.live.saved_by(change)
                if saved > 0:
                    found.append((size / saved, number, change, size))
        return [(change, size) for _, _, change, size in sorted(found)]


def largest(*errors: Array) -> float:
    """Return the largest magnitude, NaN where one is NaN."""
    found = [x for each in errors if each.size for x in (float(each.max()), -float(each.min()))]
    return math.nan if any(map(math.isnan, found)) else max(found, default=0.0)
