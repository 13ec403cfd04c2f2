"""The search for the changes that save most within a limit: greedy, by signed effects, with growing limits.

One pass orders the candidates by their largest effect on a result, over all states, for each operation that they save,
and proposes them in this order while the *signed sum* of effects stays within the limit everywhere: effects of opposite
sign cancel. Effects are of the first order, so true errors are computed after the pass, and the latest fifth of the
proposal is dropped until they are within the limit. Then adjoints, effects and savings are computed anew for the next
pass, until a pass proposes nothing; where all of a proposal was dropped, the next pass omits its first candidate. The
limit grows in steps: cheap changes come first, with effects that are still nearly exact. `MoreErrors` (shifts of
natural frequencies) are ordered, summed and checked together with the results.

A change of a part that has died meanwhile would use up the tolerance twice: uses are counted after each change
(`liveness`), and a candidate that no longer saves anything is skipped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.within.budget import Item, by_gain
from symoro_elastic.numerics.within.effects import Adjoints, Sweep, node_shift
from symoro_elastic.numerics.within.liveness import Liveness
from symoro_elastic.numerics.within.tape import Change, Changes, Rows, Tape
from symoro_elastic.symbolic.operations import DIVIDE

LIMITS = (0.3, 0.6, 0.8, 0.92, 1.0)
"""Fractions of the limits, step by step."""
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
class AcceptedChanges:
    """The changes that a search accepted, in order, and their number at the end of each step."""

    changes: Sequence[Change] = ()
    steps: Sequence[int] = ()


NO_CHANGES_ACCEPTED = AcceptedChanges()


Accepts = Callable[[Sequence[Change]], bool]
"""Whether changes are possible together."""


class MoreErrors(Protocol):
    """Errors of other quantities than the results, as fractions of their limits."""

    def errors(self, accepted: Sequence[Change]) -> Array:
        """Return the signed errors by all these changes; infinite or NaN where there are none."""

    def effects(self, accepted: Sequence[Change]) -> Callable[[Change], Array]:
        """Return the function from a further change to its effects on the errors, to first order."""


class Search:
    """The search on one tape and sample."""

    def __init__(
        self,
        tape: Tape,
        candidates: Sequence[Change],
        sample: Sample,
        accepts: Accepts = lambda changes: True,
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

    def run(self, former: AcceptedChanges = NO_CHANGES_ACCEPTED) -> AcceptedChanges:
        """Return the accepted changes: errors are within the limits at all states of the sample.

        It goes on from a `former` search, as far as that is within the limits here.
        """
        accepted, steps = self._still_within(former)
        state = self._pass_state(accepted)
        for share in LIMITS[len(steps) :]:
            refused: set[Change] = set()
            for _ in range(MOST_PASSES):
                with np.errstate(all="ignore"):
                    proposed = self._proposed_changes(state, refused, share)
                if not proposed:
                    break
                accepted_now = self._accepted_prefix(accepted, proposed, share)
                accepted = [*accepted, *accepted_now]
                state = self._pass_state(accepted)
                if not accepted_now:
                    refused.add(proposed[0])
            steps.append(len(accepted))
        return AcceptedChanges(accepted, steps)

    def _still_within(self, former: AcceptedChanges) -> tuple[list[Change], list[int]]:
        """Return the changes of a former search up to its latest step that is within its limit here, and the steps.

        Its last step is searched anew.
        """
        before = list(zip(former.steps, LIMITS, strict=True))[:-1] if former.changes else []
        for number, (count, limit) in reversed(list(enumerate(before))):
            accepted = list(former.changes[:count])
            if accepted and self._is_within(accepted, limit) and self._accepts(accepted):
                return accepted, list(former.steps[: number + 1])
        return [], []

    def errors(self, accepted: list[Change]) -> Array:
        """Return signed errors (results, states) as fractions of the limits; rows get the values with these changes."""
        if accepted != self._computed:
            changes, self._computed = Changes.of(accepted), accepted
            roots = [*self._tape.results, *self._denominators]
            self._tape.fill(self._rows, self._tape.steps(changes, roots=roots), self._sample.states)
            with np.errstate(all="ignore"):
                self._errors = (self._tape.values(self._rows) - self._exact) * self._sample.weights
        return self._errors

    def further(self, accepted: list[Change]) -> Array:
        """Return signed errors of other quantities than the results."""
        if self._more and accepted != self._further[0]:
            self._further = accepted, self._more.errors(accepted)
        return self._further[1]

    def _pass_state(self, accepted: list[Change]) -> PassState:
        """Return errors, effects and possible candidates after these changes."""
        errors, live = [self.errors(accepted), self.further(accepted)], Liveness(self._tape, accepted)
        adjoints = self._sweep.adjoints(self._rows, self._sample.weights, Changes.of(accepted))
        effects = _Effects(self._tape, self._rows, adjoints, self._more.effects(accepted) if self._more else None)
        possible = [change for change in self._candidates if live.is_possible(change)]
        with np.errstate(all="ignore"):
            sizes = [effects.largest(change) for change in possible]
        return PassState(accepted, live, errors, effects, dict(zip(possible, sizes, strict=True)))

    def _accepted_prefix(self, accepted: Sequence[Change], proposed: Sequence[Change], limit: float) -> list[Change]:
        """Return the longest prefix of a proposal that true errors allow."""
        prefix = [*proposed]
        while prefix and not self._is_within([*accepted, *prefix], limit):
            del prefix[-max(1, len(prefix) // GIVEN_BACK) :]
        return prefix

    def _is_within(self, accepted: list[Change], limit: float) -> bool:
        """Whether errors are within the limit, and denominators near the exact ones; False if one is NaN."""
        errors = self.errors(accepted)
        if not largest(errors) <= limit:
            return False
        for place, exact in zip(self._denominators, self._pivots, strict=True):
            with np.errstate(all="ignore"):
                if not (np.abs(self._rows[place] - exact) <= PIVOT_CHANGE * np.abs(exact)).all():
                    return False
        return largest(self.further(accepted)) <= limit

    def _proposed_changes(self, state: PassState, refused: Collection[Change], limit: float) -> list[Change]:
        """Return the candidates of a pass, in order, while the sum of errors and effects is within the limit.

        A rejected candidate is not tried again: more changes would hardly make it possible.
        """
        total, top, live = state.errors, largest(*state.errors), state.live
        proposed: list[Change] = []
        for item in state.by_gain({*refused, *self._unacceptable}, limit + top):
            change = item.what
            if item.adds > limit + top or not live.is_possible(change) or live.saved_by(change) <= 0:
                continue
            trial = [errors + effect for errors, effect in zip(total, state.effects.of(change), strict=True)]
            if not (reached := largest(*trial)) <= limit:
                continue
            if self._accepts([*state.accepted, *proposed, change]):
                total, top = trial, reached
                live.apply(change)
                proposed.append(change)
            else:
                self._unacceptable.add(change)
        return proposed


class _Effects:
    """Effects of changes on the results and on `further` errors, to first order, as fractions of the limits."""

    def __init__(
        self, tape: Tape, rows: Rows, adjoints: Adjoints, further: Callable[[Change], Array] | None = None
    ) -> None:
        self._tape, self._rows, self._adjoints = tape, rows, adjoints
        self._further = further or (lambda change: NONE)
        self._most: dict[int, Array] = {}
        adjoint = next(x for x in adjoints if x is not None)
        self._product = np.empty_like(adjoint)

    def of(self, change: Change) -> list[Array]:
        """Return the effects on results (results, states) and further errors, valid until the next call."""
        adjoint = self._adjoints[change.place]
        if adjoint is None:
            self._product[:] = 0.0
        else:
            np.multiply(adjoint, node_shift(self._tape, self._rows, change), self._product)
        return [self._product, self._further(change)]

    def largest(self, change: Change) -> float:
        """Return the largest magnitude of the effects; on results by the largest adjoint at every state."""
        adjoint, further = self._adjoints[change.place], self._further(change)
        if adjoint is None:
            return largest(further)
        if (most := self._most.get(id(adjoint))) is None:
            most = self._most[id(adjoint)] = np.maximum(adjoint.max(axis=0), -adjoint.min(axis=0))
        return largest(most * node_shift(self._tape, self._rows, change), further)


@dataclass(frozen=True)
class PassState:
    """Accepted changes, and errors and effects of the program with them.

    `sizes` are the largest effects of the candidates that are possible.
    """

    accepted: Sequence[Change]
    live: Liveness
    errors: Sequence[Array]
    effects: _Effects
    sizes: Mapping[Change, float]
    saved: dict[Change, int] = field(default_factory=dict)

    def by_gain(self, refused: Collection[Change], most: float) -> list[Item[Change]]:
        """Candidates that save and whose largest effect is not above the most, by gain."""
        items = []
        for change, size in self.sizes.items():
            if size <= most and change not in refused:
                if (saved := self.saved.get(change)) is None:
                    saved = self.saved[change] = self.live.saved_by(change)
                if saved > 0:
                    items.append(Item(change, float(saved), size))
        return by_gain(items)


def largest(*errors: Array) -> float:
    """Return the largest magnitude, NaN where one is NaN."""
    magnitudes = [x for x_errors in errors if x_errors.size for x in (float(x_errors.max()), -float(x_errors.min()))]
    return math.nan if any(map(math.isnan, magnitudes)) else max(magnitudes, default=0.0)
