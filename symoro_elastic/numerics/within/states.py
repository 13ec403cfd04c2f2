"""States of a box of arguments, drawn at random, half of them with all but positions at corners of the box.

There are errors of a changed program at many states that its search has not seen, and a bound on those at as many more:
both programs are evaluated, in blocks whose rows fit the processor's cache: places use them one after the other. Each
block is drawn from a seed of its own, so that the worst states can be drawn again instead of being stored.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.evaluation.quantile_bound import bound_of_more
from symoro_elastic.numerics.guarantees.box import drawn
from symoro_elastic.numerics.within.tape import Rows, Tape, rows_at

BLOCK = 2048
LEAST = 1e-300


Box = Mapping[str, Range]
"""By the name of a symbol."""


@dataclass(frozen=True)
class Bounds:
    """The box in the order of the symbols of a tape, (symbols, 1)."""

    low: Array
    high: Array
    is_position: BoolArray

    @classmethod
    def of(cls, tape: Tape, box: Box) -> Bounds:
        """Return the bounds of a tape's symbols; raises `ValueError` for a missing or unbounded interval."""
        missing = [name for name in tape.symbols if name not in box]
        if missing:
            raise ValueError(f"no values over the box: {', '.join(missing)}; give them, and numbers to all parameters")
        ends = np.array([(box[name].low, box[name].high) for name in tape.symbols], dtype=float).reshape(-1, 2)
        for name, (low, high) in zip(tape.symbols, ends, strict=True):
            if not (np.isfinite([low, high]).all() and low <= high):
                raise ValueError(f"{name}: from {low} to {high} is not an interval")
        return cls(ends[:, :1], ends[:, 1:], np.array(tape.is_position, dtype=bool)[:, None])

    @property
    def is_moving(self) -> BoolArray:
        """Where symbols are neither positions nor points."""
        return np.asarray((~self.is_position & (self.low < self.high))[:, 0])

    def draw(self, states: int, rng: np.random.Generator) -> Array:
        """Return states (symbols, states)."""
        return drawn(self.low, self.high, self.is_position, states, rng)

    def at_rest(self, states: int, rng: np.random.Generator) -> Array:
        """Return states at random positions, the first at the origin; other symbols are as near to zero as possible."""
        drawn_states = self.draw(states, rng)
        least = np.clip(0.0, self.low, self.high)
        drawn_states[:, :1] = least
        return np.where(self.is_position, drawn_states, least)

    def inside(self, states: Array) -> Array:
        """Return states moved into the box."""
        return np.clip(states, self.low, self.high)


@dataclass(frozen=True)
class Unseen:
    """Errors (results, states) at states drawn with a seed, as fractions of the tolerances."""

    errors: Array
    seed: tuple[int, ...]

    @property
    def worst(self) -> Array:
        """The largest error by result, NaN where one is."""
        return np.asarray(np.abs(self.errors).max(axis=1, initial=0.0))

    def bounds(self, more: int) -> Array:
        """Return bounds on the errors by result at `more` states drawn likewise (`quantile_bound.py`)."""
        sizes = np.abs(self.errors)
        return np.array([bound_of_more(np.maximum(x, LEAST), more) if x.any() else 0.0 for x in sizes])

    def worst_states(self, bounds: Bounds, count: int, above: float) -> Array:
        """Return, by result, its worst `count` states with errors `above` this (symbols, states)."""
        numbers: set[int] = set()
        for errors in np.abs(np.nan_to_num(self.errors, nan=np.inf)):
            worst = np.argpartition(-errors, min(count, len(errors) - 1))[:count]
            numbers |= {int(number) for number in worst if errors[number] > above}
        states = [_block(bounds, self.seed, number // BLOCK)[:, number % BLOCK] for number in sorted(numbers)]
        return np.array(states).reshape(len(states), len(bounds.low)).T


def unseen(exact: Tape, reduced: Tape, bounds: Bounds, weights: Array, states: int, seed: tuple[int, ...]) -> Unseen:
    """Return the errors of a reduced program at states; `weights` (results,) are reciprocal tolerances."""
    errors = np.empty((len(weights), states))
    both = [_Evaluated(exact, exact), _Evaluated(exact, reduced)]
    for number, start in enumerate(range(0, states, BLOCK)):
        at = _block(bounds, seed, number)
        first, second = (evaluated.values(at) for evaluated in both)
        width = min(BLOCK, states - start)
        with np.errstate(all="ignore"):
            errors[:, start : start + width] = ((second - first) * weights[:, None])[:, :width]
    return Unseen(errors, seed)


def _block(bounds: Bounds, seed: tuple[int, ...], number: int) -> Array:
    return bounds.draw(BLOCK, np.random.default_rng([*seed, number]))


class _Evaluated:
    """Results in the order of `exact`, computed by a program with the same outputs and some of its symbols."""

    def __init__(self, exact: Tape, tape: Tape) -> None:
        self._tape, self._steps = tape, tape.steps()
        order = {name: number for number, name in enumerate(exact.symbols)}
        self._symbols = [order[name] for name in tape.symbols]
        places: dict[int, int] = {}
        for exact_places, own_places in zip(exact.entries, tape.entries, strict=True):
            places |= dict(zip(exact_places, own_places, strict=True))
        self._places: Sequence[int] = [places[place] for place in exact.results]
        self._rows = _shared_rows(tape, self._places)

    def values(self, states: Array) -> Array:
        """Return the results (results, states) at states in the order of the exact tape."""
        self._tape.fill(self._rows, self._steps, states[self._symbols])
        return rows_at(self._rows, self._places)


def _shared_rows(tape: Tape, results: Sequence[int]) -> Rows:
    """Return rows by place, reused after the last use of a place; rows of `results` keep their values to the end."""
    last = {x: place for place, operands in enumerate(tape.operands) for x in (place, *operands)}
    last |= dict.fromkeys(results, tape.count)
    symbols = {place: np.empty(BLOCK) for place in tape.symbols.values()}
    rows: Rows = tape.rows_in(np.empty((tape.count, BLOCK)))
    free: Rows = []
    for place, operands in enumerate(tape.operands):
        rows[place] = symbols[place] if place in symbols else free.pop() if free else np.empty(BLOCK)
        free += [rows[x] for x in {place, *operands} if last[x] == place and x < tape.count]
    return rows
