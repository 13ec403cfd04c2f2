"""What is to be reduced, and what a search has made of it: a trial, with its errors at states and bounds on them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes
from symoro_elastic.numerics.within.candidates import candidates_of
from symoro_elastic.numerics.within.frequencies import FrequencyShifts, NaturalFrequencies
from symoro_elastic.numerics.within.left_out import left_out_of
from symoro_elastic.numerics.within.liveness import Liveness
from symoro_elastic.numerics.within.rebuild import rebuilt, with_values
from symoro_elastic.numerics.within.results import NOTHING, EntryError, ErrorBound, Reduction, Reserved, Tolerances
from symoro_elastic.numerics.within.search import NOTHING_TAKEN, Accepts, Sample, Search, Taken, accept_all
from symoro_elastic.numerics.within.states import Bounds, Box, joined
from symoro_elastic.numerics.within.tape import NO_CHANGES, Change, Changes, Kind, Tape
from symoro_elastic.numerics.within.tolerances import allowed_errors, reserved_of
from symoro_elastic.numerics.within.unseen import Unseen, unseen
from symoro_elastic.numerics.within.worst_states import climb
from symoro_elastic.symbolic.program import Names, Program, build

FIRST, AT_REST, FOR_SCALE = 1500, 32, 20_000
"""States of the first sample, states at rest, states at which results are largest."""
MORE, EACH = 60_000, 20
"""States that are looked at after each search, and how many of the worst may join the sample, for each result."""
UNSEEN = 1_000_000
JOINING = 0.95
"""States with such an error, of the tolerance, join the sample."""
SOME, MANY = 3, 4
"""Which states are drawn, beside the seed."""
SMALLEST = 1e-250
ZERO, STILL_ZERO, ROUNDING = 1e-12, 1e-9, 1e-12
"""Zero at rest, of the largest value; still zero, of the tolerance; rounding, of the largest value."""


@dataclass(frozen=True)
class Worst:
    """Errors by result that are too large, and states at which they are."""

    errors: Array
    states: list[Array]


class Task:
    """What is to be reduced, over which box, within which tolerances."""

    def __init__(
        self,
        program: Program,
        box: Box,
        tolerances: Tolerances,
        names: Names,
        positions: Collection[str],
        seed: int,
        reserved: Reserved = NOTHING,
    ) -> None:
        self.program, self.names, self.positions, self.seed = program, names, positions, seed
        self.tape = Tape(program, positions)
        self.box = Bounds.of(self.tape, box)
        self.largest = self._largest()
        self.tolerance = allowed_errors(program, self.tape, tolerances, self.largest)
        self.allowed = np.maximum(self.tolerance - reserved_of(program, self.tape, reserved), 0.0)
        self.weights = 1 / np.maximum(self.allowed, SMALLEST)
        self.judging = 1 / np.maximum(np.maximum(self.allowed, ROUNDING * self.largest), SMALLEST)
        self.candidates = candidates_of(self.tape, self.tape.rows(self._drawn(0, FIRST)))
        self._accepts: Accepts = accept_all
        self.shifts: FrequencyShifts | None = None

    def only_zeros_of(self, parameters: Collection[str], possible: Callable[[Collection[str]], bool] | None) -> None:
        """Let nothing change but parameters to zero; `possible` tells which may be zero together."""
        places = {place: name for name, place in self.tape.symbols.items() if name in parameters}
        self.candidates = [Change(Kind.FREEZE, place, constant=0.0) for place in places]
        if possible:
            self._accepts = lambda taken: possible({places[change.place] for change in taken})

    def keep_frequencies(self, asked: NaturalFrequencies) -> None:
        """Let natural frequencies be shifted by no more than their tolerance."""
        self.shifts = FrequencyShifts(asked, self.program, self.tape, self.box, self.seed)

    def only_at(self, nodes: Collection[int]) -> None:
        """Let nothing change but nodes with these numbers."""
        self.candidates = [change for change in self.candidates if self.tape.nodes[change.place].id in nodes]

    def _rng(self, purpose: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, purpose])

    def _drawn(self, purpose: int, states: int) -> Array:
        return self.box.draw(states, self._rng(purpose))

    def _largest(self) -> Array:
        """The largest value of each result; raises `ValueError` where one is not finite."""
        found: Array = np.abs(self.tape.values(self.tape.rows(self._drawn(1, FOR_SCALE)))).max(axis=1)
        if not np.isfinite(found).all():
            raise ValueError("a result is not finite at some states of the box: make it smaller")
        return found

    def farthest(self, errors: Array) -> str:
        """Return which result is farthest above its tolerance, and how many times."""
        k = int(np.argmax(np.nan_to_num(errors, nan=np.inf)))
        place = self.tape.results[k]
        pairs = zip(self.program.outputs, self.tape.entries, strict=True)
        name = next(f"{x.name}[{places.index(place)}]" for x, places in pairs if place in places)
        if not np.isfinite(errors[k]):
            return f"the error of {name} has no bound"
        return f"what is known of the error of {name} is {errors[k]:.2g} times what is allowed"

    def first_sample(self) -> Array:
        """Return random states, and states at rest."""
        return joined([self._drawn(0, FIRST), self.box.at_rest(AT_REST, self._rng(2))])

    def sample(self, states: Array, limits: Array) -> Sample:
        """Return states with limits: results that are zero at rest stay zero."""
        weights = np.repeat((self.weights / limits)[:, None], states.shape[1], axis=1)
        moving = self.box.is_moving
        if moving.any():
            rest = np.flatnonzero((states[moving] == 0).all(axis=0))
            values = self.tape.values(self.tape.rows(states[:, rest]))
            zero = np.abs(values) <= ZERO * self.largest[:, None]
            weights[:, rest] *= np.where(zero, 1 / STILL_ZERO, 1.0)
        return Sample(states, weights)

    def searched(self, states: Array, limits: Array, number: int, former: Taken = NOTHING_TAKEN) -> Trial:
        """Return what a search finds at these states, which goes on from a former one."""
        sample = self.sample(states, limits)
        found = Search(self.tape, self.candidates, sample, self._accepts, self.shifts).run(former)
        return Trial(self, found, states, number)

    def unchanged(self) -> Trial:
        """Return the program as it is."""
        return Trial(self, NOTHING_TAKEN, self.first_sample(), 0)


class Trial:
    """A reduced program, and its errors by result, of their tolerances."""

    def __init__(self, task: Task, found: Taken, states: Array, number: int) -> None:
        self.task, self.found, self._number = task, found, number
        self.taken = found.changes
        self.changes = Changes.of(self.taken)
        self.values = rebuilt(task.tape, self.changes)
        self.outputs = with_values(task.program, self.values)
        names = task.names.moved(self.values)
        self.reduced = build(task.program.inputs, self.outputs, names) if self.taken else task.program
        self.tape = Tape(self.reduced, task.positions)
        self.sampled = self.climbed = self.unseen = np.zeros(len(task.allowed))
        self.confident: Array | None = None
        self.bounded: Array | None = None
        self.shift: float | None = None
        if self.taken:
            self._compare(states)

    def _compare(self, states: Array) -> None:
        """Find errors at the states of the search, and where climbing leads from these."""
        tape, box, weights = self.task.tape, self.task.box, self.task.judging
        exact, changed = (tape.values(tape.rows(states, x)) for x in (NO_CHANGES, self.changes))
        errors = (changed - exact) * weights[:, None]
        self.sampled = np.abs(errors).max(axis=1)
        self._worst = climb(tape, box, self.changes, states, errors, weights)
        self.climbed = self._worst.largest

    def keeps_frequencies(self) -> bool:
        """Whether natural frequencies are within their tolerance; where not, the next search looks there, too."""
        if self.task.shifts is None:
            return True
        self.shift = self.task.shifts.judged(self.taken, self._number)
        return self.shift <= 1

    def raises_frequencies(self) -> bool:
        """Whether the next search has more room for shifts of natural frequencies."""
        return self.task.shifts is not None and self.shift is not None and self.task.shifts.raise_limit(self.shift)

    @property
    def cost(self) -> int:
        """Operations of a call, as a search counts them."""
        return Liveness(self.task.tape, self.taken).cost

    def too_large(self) -> Worst | None:
        """Return errors beyond the tolerances at climbed or at some unseen states."""
        seen = self._at_unseen(MORE, SOME)
        worst = np.maximum(self.climbed, seen.worst)
        if (worst <= 1).all():
            return None
        climbed = self._worst.states[:, np.abs(self._worst.errors) > JOINING]
        return Worst(worst, [climbed, seen.worst_states(self.task.box, EACH, JOINING)])

    def too_large_unseen(self, states: int, with_bound: bool) -> Worst | None:
        """Return errors beyond the tolerances at many unseen states; find the bound on as many more."""
        seen = self._at_unseen(states, MANY)
        self.unseen = seen.worst
        if with_bound:
            self.confident = seen.bounds(states)
        if (self.unseen <= 1).all():
            return None
        return Worst(self.unseen, [seen.worst_states(self.task.box, EACH, JOINING)])

    def _at_unseen(self, states: int, purpose: int) -> Unseen:
        task = self.task
        return unseen(task.tape, self.tape, task.box, task.judging, states, (task.seed, purpose, self._number))

    def apply(self, bound: ErrorBound) -> None:
        """Find bounds on all states of the box."""
        task, found = self.task, bound(self.task.program, self.reduced, self._changed_nodes())
        by_place: dict[int, float] = {}
        for output, places in zip(task.program.outputs, task.tape.entries, strict=True):
            by_place |= dict(zip(places, found[output.name], strict=True))
        self.bounded = np.array([by_place[place] for place in task.tape.results]) * task.judging

    def _changed_nodes(self) -> ChangedNodes:
        """The changes by the numbers of nodes."""
        nodes = self.task.tape.nodes
        return ChangedNodes(
            frozenset((nodes[place].id, operand) for place, operand in self.changes.dropped),
            {nodes[place].id: Fraction(constant) for place, constant in self.changes.frozen.items()},
            frozenset(nodes[place].id for place in self.changes.straightened),
        )

    def judged(self) -> Array:
        """Return the largest bound on each result's error, of its tolerance; the error that is known without one."""
        bounds = [x for x in (self.unseen, self.confident, self.bounded) if x is not None]
        largest: Array = np.max(bounds, axis=0)
        return largest

    def reduction(self, states: int) -> Reduction:
        """Return the result."""
        task = self.task
        left_out = left_out_of(task.program, task.tape, self.taken)
        errors = tuple(self._entry_errors())
        return Reduction(
            task.program, self.reduced, self.outputs, self.values, left_out, errors, states, task.seed, shift=self.shift
        )

    def _entry_errors(self) -> Iterator[EntryError]:
        task = self.task
        numbers = {place: number for number, place in enumerate(task.tape.results)}
        confident = self.confident
        if confident is not None:  # rare states that are known may be beyond what the tail tells
            confident = np.max([confident, self.sampled, self.climbed, self.unseen], axis=0)
        columns = (self.sampled, self.climbed, self.unseen, confident, self.bounded)
        unit = 1 / task.judging
        for output, places in zip(task.program.outputs, task.tape.entries, strict=True):
            for index, place in enumerate(places):
                if place in numbers:
                    k = numbers[place]
                    sizes = float(task.largest[k]), float(task.tolerance[k])
                    yield EntryError(output.name, index, *sizes, *(_at(column, k, unit) for column in columns))


def _at(column: Array | None, k: int, unit: Array) -> Any:
    return None if column is None else float(column[k] * unit[k])
