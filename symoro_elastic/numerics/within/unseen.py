"""Errors of a changed program at many states that its search has not seen, and a bound on those at as many more.

Both programs are evaluated, in blocks whose rows fit the processor's cache: places use them one after the other. Each
block is drawn from a seed of its own, so that the worst states can be drawn again instead of being stored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.quantile_bound import bound_of_more
from symoro_elastic.numerics.within.states import Bounds
from symoro_elastic.numerics.within.tape import Rows, Tape, picked

BLOCK = 2048
LEAST = 1e-300


@dataclass(frozen=True)
class Unseen:
    """Errors (results, states) at states drawn with a seed, of their tolerances."""

    errors: Array
    seed: tuple[int, ...]

    @property
    def worst(self) -> Array:
        """The largest error of each result, NaN where one is."""
        worst: Array = np.abs(self.errors).max(axis=1, initial=0.0)
        return worst

    def bounds(self, more: int) -> Array:
        """Return bounds on the errors of each result at `more` states drawn likewise (`numerics/quantile_bound.py`)."""
        return np.array([_bound(np.abs(errors), more) for errors in self.errors])

    def worst_states(self, bounds: Bounds, each: int, above: float) -> Array:
        """Return the worst states of each result with larger errors (symbols, states)."""
        found: set[int] = set()
        for errors in np.abs(np.nan_to_num(self.errors, nan=np.inf)):
            worst = np.argpartition(-errors, min(each, len(errors) - 1))[:each]
            found |= {int(number) for number in worst if errors[number] > above}
        states = [_block(bounds, self.seed, number // BLOCK)[:, number % BLOCK] for number in sorted(found)]
        return np.array(states).reshape(len(states), len(bounds.low)).T


def unseen(exact: Tape, reduced: Tape, bounds: Bounds, weights: Array, states: int, seed: tuple[int, ...]) -> Unseen:
    """Return the errors of a reduced program at states; `weights` (results,) are reciprocal tolerances."""
    errors = np.empty((len(weights), states))
    both = [_Evaluated(exact, exact), _Evaluated(exact, reduced)]
    for number, start in enumerate(range(0, states, BLOCK)):
        at = _block(bounds, seed, number)
        first, second = (one.values(at) for one in both)
        width = min(BLOCK, states - start)
        with np.errstate(all="ignore"):
            errors[:, start : start + width] = ((second - first) * weights[:, None])[:, :width]
    return Unseen(errors, seed)


def _block(bounds: Bounds, seed: tuple[int, ...], number: int) -> Array:
    return bounds.draw(BLOCK, np.random.default_rng([*seed, number]))


class _Evaluated:
    """The results of `exact`, computed by a program with the same outputs whose symbols are among its own."""

    def __init__(self, exact: Tape, tape: Tape) -> None:
        self._tape, self._steps = tape, tape.steps()
        order = {name: number for number, name in enumerate(exact.symbols)}
        self._symbols = [order[name] for name in tape.symbols]
        places: dict[int, int] = {}
        for found, own in zip(exact.entries, tape.entries, strict=True):
            places |= dict(zip(found, own, strict=True))
        self._places: Sequence[int] = [places[place] for place in exact.results]
        self._rows = _shared_rows(tape, self._places)

    def values(self, states: Array) -> Array:
        """Return the results (results, states) at states in the order of the exact tape."""
        self._tape.fill(self._rows, self._steps, states[self._symbols])
        return picked(self._rows, self._places)


def _shared_rows(tape: Tape, kept: Sequence[int]) -> Rows:
    """Rows that are used again after the last use of a place; those of `kept` hold their values to the end."""
    last = {x: place for place, operands in enumerate(tape.operands) for x in (place, *operands)}
    last |= dict.fromkeys(kept, tape.count)
    symbols = {place: np.empty(BLOCK) for place in tape.symbols.values()}
    rows: Rows = tape.rows_in(np.empty((tape.count, BLOCK)))
    free: Rows = []
    for place, operands in enumerate(tape.operands):
        rows[place] = symbols[place] if place in symbols else free.pop() if free else np.empty(BLOCK)
        free += [rows[x] for x in {place, *operands} if last[x] == place and x < tape.count]
    return rows


def _bound(errors: Array, more: int) -> float:
    if not errors.any():
        return 0.0
    return bound_of_more(np.maximum(errors, LEAST), more)
