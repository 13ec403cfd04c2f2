"""A task: a program to be reduced within tolerances; and its trials: reduced programs, their errors and bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes
from symoro_elastic.numerics.within.effects import Sweep
from symoro_elastic.numerics.within.frequencies import FrequencyShifts, NaturalFrequencies
from symoro_elastic.numerics.within.liveness import SIMPLE, Liveness
from symoro_elastic.numerics.within.results import EntryError, ErrorBound, Reduction, Reserved, Tolerances, left_out_of
from symoro_elastic.numerics.within.search import NO_CHANGES_ACCEPTED, AcceptedChanges, Accepts, Sample, Search
from symoro_elastic.numerics.within.states import Bounds, Box, Unseen, unseen
from symoro_elastic.numerics.within.tape import (
    NO_CHANGES,
    SUMS,
    Change,
    Changes,
    Kind,
    Rows,
    Tape,
    changed_values,
    with_values,
)
from symoro_elastic.symbolic.expression import Level
from symoro_elastic.symbolic.operations import SIN
from symoro_elastic.symbolic.program import Names, Output, Program, build

FIRST, AT_REST, FOR_SCALE = 1500, 32, 20_000
"""States of the first sample, states at rest, states at which results are largest."""
MORE, EACH = 60_000, 20
"""States evaluated after each search, and the number of the worst by result that may join the sample."""
UNSEEN = 1_000_000
MOST_UNPROVEN = 3
"""Searches with a bound that is far above a tolerance, each with fewer changes: then the program stays full."""
JOINING = 0.95
"""States with such an error, of the tolerance, join the sample."""
SOME, MANY = 3, 4
"""Numbers of the streams of random states, in addition to the seed."""
SMALLEST = 1e-250
ZERO, STILL_ZERO, ROUNDING = 1e-12, 1e-9, 1e-12
"""Zero at rest, of the largest value; still zero, of the tolerance; rounding, of the largest value."""
NEAR = 0.5
"""Of its range: how far 0, 1 or -1 may lie beyond the values of a node that is frozen there."""
DIGITS = 50
"""Into how many parts the half width of the values is divided for a round number in the middle."""
STARTS, STEPS = 24, 24
FIRST_STEP, LONGER, SHORTER = 0.1, 1.6, 0.4
"""Of the width of the box; by what it grows and shrinks."""
MOVES = 3
"""Of each step."""


@dataclass(frozen=True)
class Worst:
    """Errors by result that are too large, and states at which they are."""

    errors: Array
    states: list[Array]


@dataclass(frozen=True)
class Requirements:
    """Requirements of a reduced program other than its tolerances, and how its errors are judged.

    `positions` name the arguments that hold positions, `names` are the quantities that keep their names. With
    `confident` the bound on errors at `states` more states is within the tolerances too, with `bound` that bound.
    `frequencies` have a tolerance of their own; what is `reserved` for rounding is not used. Only nodes with numbers in
    `changing` change, if given. After `most_unproven` searches that are far from a proof, the program stays whole.
    `announce` is called with the name of each stage.
    """

    names: Names = field(default_factory=Names)
    positions: Sequence[str] = ("q",)
    seed: int = 0
    states: int = UNSEEN
    confident: bool = True
    bound: ErrorBound | None = None
    changing: Collection[int] | None = None
    frequencies: NaturalFrequencies | None = None
    reserved: Reserved = field(default_factory=dict)
    announce: Announce = announce_nothing
    most_unproven: int = MOST_UNPROVEN


class Task:
    """A program to be reduced over a box within tolerances."""

    def __init__(self, program: Program, box: Box, tolerances: Tolerances, required: Requirements) -> None:
        self.program, self.required, self.seed = program, required, required.seed
        self.tape = Tape(program, required.positions)
        self.box = Bounds.of(self.tape, box)
        self.largest = self._largest()
        self.tolerance, self.allowed, self.is_rounding = allowed_errors(
            program, self.tape, tolerances, self.largest, required.reserved
        )
        self.weights = 1 / np.maximum(self.allowed, SMALLEST)
        self.judging = 1 / np.maximum(np.maximum(self.allowed, ROUNDING * self.largest), SMALLEST)
        self.candidates = candidates_of(self.tape, self.tape.rows(self._random_states(0, FIRST)))
        if (nodes := required.changing) is not None:
            self.candidates = [change for change in self.candidates if self.tape.nodes[change.place].id in nodes]
        self._accepts: Accepts = lambda changes: True
        self.shifts: FrequencyShifts | None = None
        if required.frequencies:
            self.shifts = FrequencyShifts(required.frequencies, program, self.tape, self.box, self.seed)

    def only_zeros_of(self, parameters: Collection[str], possible: Callable[[Collection[str]], bool] | None) -> None:
        """Restrict the candidates to parameters that become zero; `possible` is a predicate of those zero together."""
        places = {place: name for name, place in self.tape.symbols.items() if name in parameters}
        self.candidates = [Change(Kind.FREEZE, place, constant=0.0) for place in places]
        if possible:
            self._accepts = lambda accepted: possible({places[change.place] for change in accepted})

    def _rng(self, purpose: int) -> np.random.Generator:
        return np.random.default_rng([self.seed, purpose])

    def _random_states(self, purpose: int, states: int) -> Array:
        return self.box.draw(states, self._rng(purpose))

    def _largest(self) -> Array:
        """The largest values by result; raises `ValueError` where one is not finite."""
        largest: Array = np.abs(self.tape.values(self.tape.rows(self._random_states(1, FOR_SCALE)))).max(axis=1)
        if not np.isfinite(largest).all():
            raise ValueError("a result is not finite at some states of the box: make it smaller")
        return largest

    def farthest(self, errors: Array) -> str:
        """Return which result is farthest above its tolerance, and how many times."""
        k = int(np.argmax(np.nan_to_num(errors, nan=np.inf)))
        place = self.tape.results[k]
        pairs = zip(self.program.outputs, self.tape.entries, strict=True)
        name = next(f"{x.name}[{places.index(place)}]" for x, places in pairs if place in places)
        if not np.isfinite(errors[k]):
            return f"the error of {name} has no bound"
        return f"the bound on the error of {name} is {errors[k]:.2g} times its tolerance"

    def entries(self) -> Iterator[tuple[str, int, int]]:
        """Yield output, index, and number of the result, of all entries that are results."""
        numbers = {place: number for number, place in enumerate(self.tape.results)}
        for output, places in zip(self.program.outputs, self.tape.entries, strict=True):
            yield from ((output.name, k, numbers[x]) for k, x in enumerate(places) if x in numbers)

    def first_sample(self) -> Array:
        """Return random states, and states at rest."""
        return np.concatenate([self._random_states(0, FIRST), self.box.at_rest(AT_REST, self._rng(2))], axis=1)

    def sample(self, states: Array, limits: Array) -> Sample:
        """Return states with limits of errors, far smaller ones at rest for results that are zero there."""
        weights = np.repeat((self.weights / limits)[:, None], states.shape[1], axis=1)
        moving = self.box.is_moving
        if moving.any():
            at_rest = np.flatnonzero((states[moving] == 0).all(axis=0))
            values = self.tape.values(self.tape.rows(states[:, at_rest]))
            zero = np.abs(values) <= ZERO * self.largest[:, None]
            weights[:, at_rest] *= np.where(zero, 1 / STILL_ZERO, 1.0)
        return Sample(states, weights)

    def search(self, states: Array, limits: Array, number: int, former: AcceptedChanges = NO_CHANGES_ACCEPTED) -> Trial:
        """Return the trial of a search at these states that goes on from a former one."""
        sample = self.sample(states, limits)
        accepted = Search(self.tape, self.candidates, sample, self._accepts, self.shifts).run(former)
        return Trial(self, accepted, states, number)

    def without_changes(self) -> Trial:
        """Return the trial without changes."""
        return Trial(self, NO_CHANGES_ACCEPTED, self.first_sample(), 0)


class Trial:
    """A reduced program, and its errors by result as fractions of the tolerances."""

    def __init__(self, task: Task, accepted: AcceptedChanges, states: Array, number: int) -> None:
        self.task, self.accepted, self._number = task, accepted, number
        self.changes = Changes.of(self.accepted.changes)
        self.values = changed_values(task.tape, self.changes)
        self.outputs = with_values(task.program, self.values)
        names = task.required.names.moved(self.values)
        self.reduced = build(task.program.inputs, self.outputs, names) if self.accepted.changes else task.program
        self.tape = Tape(self.reduced, task.required.positions)
        self.sampled = self.climbed = self.unseen = np.zeros(len(task.allowed))
        self.confident: Array | None = None
        self.bounded: Array | None = None
        self.shift: float | None = None
        if self.accepted.changes:
            self._compare(states)

    def _compare(self, states: Array) -> None:
        """Compute errors at the states of the search, and at those reached from there by climbing."""
        tape, box, weights = self.task.tape, self.task.box, self.task.judging
        exact, changed = (tape.values(tape.rows(states, x)) for x in (NO_CHANGES, self.changes))
        errors = (changed - exact) * weights[:, None]
        self.sampled = np.abs(errors).max(axis=1)
        self._worst = climb(tape, box, self.changes, states, errors, weights)
        self.climbed = self._worst.largest

    def keeps_frequencies(self) -> bool:
        """Whether natural frequencies are within their tolerance; if not, the next search watches the worst states."""
        if self.task.shifts is None:
            return True
        self.shift = self.task.shifts.bound(self.accepted.changes, self._number)
        return self.shift <= 1

    def raises_frequencies(self) -> bool:
        """Raise the limit of frequency shifts for the next search, if they are small; return whether it rose."""
        return self.task.shifts is not None and self.shift is not None and self.task.shifts.raise_limit(self.shift)

    @property
    def cost(self) -> int:
        """Operations of a call, as a search counts them."""
        return Liveness(self.task.tape, self.accepted.changes).cost

    def too_large(self) -> Worst | None:
        """Return errors and worst states if tolerances are exceeded at climbed or some unseen states; else None."""
        errors_at_unseen = self._at_unseen(MORE, SOME)
        worst = np.maximum(self.climbed, errors_at_unseen.worst)
        if (worst <= 1).all():
            return None
        climbed = self._worst.states[:, np.abs(self._worst.errors) > JOINING]
        return Worst(worst, [climbed, errors_at_unseen.worst_states(self.task.box, EACH, JOINING)])

    def too_large_unseen(self) -> Worst | None:
        """Return errors and worst states if tolerances are exceeded at many unseen states; bounds further errors."""
        required = self.task.required
        errors_at_unseen = self._at_unseen(required.states, MANY)
        self.unseen = errors_at_unseen.worst
        if required.confident:
            self.confident = errors_at_unseen.bounds(required.states)
        if (self.unseen <= 1).all():
            return None
        return Worst(self.unseen, [errors_at_unseen.worst_states(self.task.box, EACH, JOINING)])

    def _at_unseen(self, states: int, purpose: int) -> Unseen:
        task = self.task
        return unseen(task.tape, self.tape, task.box, task.judging, states, (task.seed, purpose, self._number))

    def apply(self, bound: ErrorBound) -> None:
        """Compute bounds on the errors over the box."""
        task, changes = self.task, self.changes
        nodes = [node.id for node in task.tape.nodes]
        changed_nodes = ChangedNodes(
            frozenset((nodes[place], operand) for place, operand in changes.dropped),
            {nodes[place]: Fraction(constant) for place, constant in changes.frozen.items()},
            frozenset(nodes[place] for place in changes.straightened),
        )
        bounds = bound(task.program, self.reduced, changed_nodes)
        by_place: dict[int, float] = {}
        for output, places in zip(task.program.outputs, task.tape.entries, strict=True):
            by_place |= dict(zip(places, bounds[output.name], strict=True))
        self.bounded = np.array([by_place[place] for place in task.tape.results]) * task.judging

    def error_bounds(self) -> Array:
        """Return the largest bound on each result's error as a fraction of its tolerance; else its largest error.

        Proofs of a result that is zero but for rounding are rounding themselves: they do not count.
        """
        proven = None if self.bounded is None else np.where(self.task.is_rounding, 0.0, self.bounded)
        bounds = [x for x in (self.unseen, self.confident, proven) if x is not None]
        return np.asarray(np.max(bounds, axis=0))

    def reduction(self) -> Reduction:
        """Return the reduction: the reduced program, the omitted terms, and the errors."""
        task = self.task
        left_out = left_out_of(task.program, task.tape, self.accepted.changes)
        errors, states = tuple(self._entry_errors()), task.required.states
        return Reduction(
            task.program, self.reduced, self.outputs, self.values, left_out, errors, states, task.seed, shift=self.shift
        )

    def _entry_errors(self) -> Iterator[EntryError]:
        task, confident = self.task, self.confident
        if confident is not None:  # rare states may be beyond the bound from the tail
            confident = np.max([confident, self.sampled, self.climbed, self.unseen], axis=0)
        columns = (self.sampled, self.climbed, self.unseen, confident, self.bounded)
        unit = 1 / task.judging
        for output, index, k in task.entries():
            errors = [None if x is None else float(x[k] * unit[k]) for x in columns]
            values: list[Any] = [float(task.largest[k]), float(task.tolerance[k]), *errors, bool(task.is_rounding[k])]
            yield EntryError(output, index, *values)


def allowed_errors(
    program: Program, tape: Tape, tolerances: Tolerances, largest: Array, reserved: Reserved
) -> tuple[Array, Array, BoolArray]:
    """Return by result its tolerance, the part of it for omitted terms, and whether it is zero but for rounding.

    A result that is several entries has the least tolerance, of which the `reserved` part is not for terms. `largest`
    are the largest values of the results; one that is zero but for rounding may be off by its rounding.
    Raises `ValueError` for an output without a tolerance.
    """
    number = {place: k for k, place in enumerate(tape.results)}
    tolerance, left = np.full(len(number), math.inf), np.full(len(number), math.inf)
    is_rounding = np.zeros(len(number), dtype=bool)
    for output, places in zip(program.outputs, tape.entries, strict=True):
        kept_back = reserved.get(output.name, [0.0] * len(places))
        for place, entry, part in zip(places, _of_entries(output, tolerances), kept_back, strict=True):
            if (k := number.get(place)) is None:
                continue
            size, is_rounding[k] = float(largest[k]), entry.is_rounding(float(largest[k]))
            allowed = entry.rounding + part if is_rounding[k] else entry.value * (size if entry.relative else 1.0)
            tolerance[k], left[k] = min(tolerance[k], allowed), min(left[k], max(allowed - part, 0.0))
    return tolerance, left, is_rounding


def _of_entries(output: Output, tolerances: Tolerances) -> list[Tolerance]:
    if output.name not in tolerances:
        raise ValueError(f"no tolerance for {output.name}: give one for each of the results")
    shared = tolerances[output.name]
    entries = [shared] * len(output.entries) if isinstance(shared, Tolerance) else list(shared)
    if len(entries) != len(output.entries):
        raise ValueError(f"{len(entries)} tolerances for the {len(output.entries)} entries of {output.name}")
    for tolerance in entries:
        if not 0 <= tolerance.value < math.inf:
            raise ValueError(f"{tolerance.value} is not a tolerance of {output.name}: a number from 0 on")
    return entries


def candidates_of(tape: Tape, rows: Rows) -> list[Change]:
    """Return all candidates; `rows` are values over the box. Arguments that are results themselves stay."""
    candidates: list[Change] = []
    returned = {x for places in tape.entries for x in places}
    for place, node in enumerate(tape.nodes):
        if node.level != Level.STATE:
            continue
        if tape.operations[place] in SUMS:
            candidates += (Change(Kind.DROP, place, k) for k in (0, 1))
        if tape.of_positions[place] and (tape.operands[place] or place not in returned):
            candidates += (Change(Kind.FREEZE, place, constant=x) for x in constants_for(rows[place]))
        if tape.operations[place] == SIN:
            candidates.append(Change(Kind.STRAIGHTEN, place))
    return candidates


def constants_for(values: Array) -> Iterator[float]:
    """The numbers at which a node with these values may be frozen."""
    low, high = float(values.min()), float(values.max())
    if not math.isfinite(low + high):
        return
    margin = NEAR * (high - low)
    simple = [x for x in SIMPLE if low - margin <= x <= high + margin]
    yield from simple
    middle = short_number((low + high) / 2, (high - low) / 2 / DIGITS)
    if middle not in simple:
        yield middle


def short_number(x: float, step: float) -> float:
    """Return the number with fewest decimals within about a step of x."""
    if not step:
        return x
    decimals = -math.floor(math.log10(step))
    return round(x, decimals) + 0.0


@dataclass(frozen=True)
class ClimbedStates:
    """States (symbols, states), the error of a result there as a fraction of its tolerance, the largest by result."""

    states: Array
    errors: Array
    largest: Array


def climb(tape: Tape, bounds: Bounds, changes: Changes, states: Array, errors: Array, weights: Array) -> ClimbedStates:
    """Return the states reached by climbing from the worst of these.

    `errors` (results, states) are those at `states`, `weights` (results,) their reciprocal tolerances.
    """
    starts = min(STARTS, states.shape[1])
    worst = np.argpartition(-np.abs(errors), starts - 1, axis=1)[:, :starts]
    climber = _Climber(tape, bounds, changes, np.repeat(weights, starts), np.repeat(np.arange(len(errors)), starts))
    worst_states = climber.climb(states[:, worst.ravel()])
    return ClimbedStates(worst_states, climber.error, np.abs(climber.error).reshape(len(errors), starts).max(axis=1))


class _Climber:
    """A climb with many states at once, each by the error of its result."""

    def __init__(self, tape: Tape, bounds: Bounds, changes: Changes, weights: Array, result: Array) -> None:
        self._tape, self._bounds, self._changes = tape, bounds, changes
        self._weights, self._result = weights, result.astype(int)
        self._states = np.arange(len(weights))
        self._sweep = Sweep(tape, 1, len(weights))
        self._numbers = [[np.zeros((tape.count, n * len(weights))) for _ in range(2)] for n in (1, MOVES)]
        self._rows = [[tape.rows_in(numbers) for numbers in both] for both in self._numbers]
        self._steps = [tape.steps(x, roots=tape.results) for x in (NO_CHANGES, changes)]
        self.error = np.zeros(len(weights))

    def climb(self, at: Array) -> Array:
        """Return the states that steps of increasing error reach from states `at`."""
        step = np.full(at.shape[1], FIRST_STEP)
        self.error = self._errors(at)
        for _ in range(STEPS):
            at, moved = self._best(at, self._moves(at, self._gradient(), step))
            step = np.where(moved, step * LONGER, step * SHORTER)
        return at

    def _moves(self, at: Array, gradient: Array, step: Array) -> list[Array]:
        """The corner, the state along the gradient, and positions along the gradient with all else at the corner."""
        low, high, is_position = self._bounds.low, self._bounds.high, self._bounds.is_position
        slope = gradient * (high - low)
        steepest = np.abs(slope).max(axis=0, initial=0.0)
        along = self._bounds.inside(at + step * (high - low) * slope / np.where(steepest > 0, steepest, 1.0))
        corner = np.where(gradient > 0, high, np.where(gradient < 0, low, at))
        return [np.where(is_position, at, corner), along, np.where(is_position, along, corner)]

    def _best(self, at: Array, moves: Sequence[Array]) -> tuple[Array, BoolArray]:
        """The worst states among the moves, and which have moved in position; rows get the values at the worst."""
        errors = self._errors(np.concatenate(moves, axis=1), MOVES).reshape(MOVES, -1)
        chosen = np.full(at.shape[1], -1)
        for number, (other, error) in enumerate(zip(moves, errors, strict=True)):
            worse = np.abs(error) > np.abs(self.error)
            self.error = np.where(worse, error, self.error)
            at, chosen = np.where(worse, other, at), np.where(worse, number, chosen)
        better = np.flatnonzero(chosen >= 0)
        for numbers, of_moves in zip(*self._numbers, strict=True):
            numbers[:, better] = of_moves[:, chosen[better] * len(chosen) + better]
        return at, chosen > 0

    def _errors(self, at: Array, times: int = 1) -> Array:
        """Signed errors of every state's result, `times` all states; rows get the values at `at`."""
        both = self._rows[times > 1]
        for rows, steps in zip(both, self._steps, strict=True):
            self._tape.fill(rows, steps, at)
        places = np.tile(self._result, times), np.arange(at.shape[1])
        exact, changed = (self._tape.values(rows)[places] for rows in both)
        return np.asarray((changed - exact) * np.tile(self._weights, times))

    def _gradient(self) -> Array:
        """The derivatives of the magnitude of the error (symbols, states)."""
        sign = np.sign(self.error)
        seeds = np.zeros((1, len(self._tape.results), len(sign)))
        seeds[0, self._result, self._states] = sign * self._weights
        gradient = np.zeros((len(self._tape.symbols), len(sign)))
        for k, (rows, changes) in enumerate(zip(self._rows[0], (NO_CHANGES, self._changes), strict=True)):
            adjoints = self._sweep.adjoints(rows, seeds, changes)
            for symbol, place in enumerate(self._tape.symbols.values()):
                adjoint = adjoints[place]
                if adjoint is not None and place not in changes.frozen:
                    gradient[symbol] += adjoint[0] if k else -adjoint[0]
        return np.asarray(np.nan_to_num(gradient))
