"""The states of a box at which a changed program is farthest from the exact one, found by climbing.

From the worst of the states that are known, for each result, each step looks at three states along the gradient of the
error, which adjoints of both programs give, and takes the worst: all arguments moved by a step that grows while it
helps and shrinks where it does not; all but positions at the corner of the box that the gradient shows, as errors are
of the first degree in accelerations and torques and of the second in velocities; and both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.numerics.within.effects import Sweep
from symoro_elastic.numerics.within.states import Bounds
from symoro_elastic.numerics.within.tape import NO_CHANGES, Changes, Tape

STARTS, STEPS = 24, 24
FIRST_STEP, LONGER, SHORTER = 0.1, 1.6, 0.4
"""Of the width of the box; by what it grows and shrinks."""
MOVES = 3
"""Of each step."""


@dataclass(frozen=True)
class Found:
    """States (symbols, states), and the error of one result at each, of its tolerance; the largest of each result."""

    states: Array
    errors: Array
    largest: Array


def climb(tape: Tape, bounds: Bounds, changes: Changes, states: Array, errors: Array, weights: Array) -> Found:
    """Return the worst states found from the worst of these.

    `errors` (results, states) are those at `states`, `weights` (results,) their reciprocal tolerances.
    """
    starts = min(STARTS, states.shape[1])
    worst = np.argpartition(-np.abs(errors), starts - 1, axis=1)[:, :starts]
    climber = _Climber(tape, bounds, changes, np.repeat(weights, starts), np.repeat(np.arange(len(errors)), starts))
    at = states[:, worst.ravel()]
    found = climber.climbed(at)
    return Found(found, climber.error, np.abs(climber.error).reshape(len(errors), starts).max(axis=1))


class _Climber:
    """Climbs with many states at once, each by the error of one result."""

    def __init__(self, tape: Tape, bounds: Bounds, changes: Changes, weights: Array, result: Array) -> None:
        self._tape, self._bounds, self._changes = tape, bounds, changes
        self._weights, self._result = weights, result.astype(int)
        self._states = np.arange(len(weights))
        self._sweep = Sweep(tape, 1, len(weights))
        self._numbers = [[np.zeros((tape.count, n * len(weights))) for _ in range(2)] for n in (1, MOVES)]
        self._rows = [[tape.rows_in(numbers) for numbers in both] for both in self._numbers]
        self._steps = [tape.steps(x, roots=tape.results) for x in (NO_CHANGES, changes)]
        self.error = np.zeros(len(weights))

    def climbed(self, at: Array) -> Array:
        """Return the states that are reached."""
        step = np.full(at.shape[1], FIRST_STEP)
        self.error = self._errors(at)
        for _ in range(STEPS):
            at, moved = self._best(at, self._moves(at, self._gradient(), step))
            step = np.where(moved, step * LONGER, step * SHORTER)
        return at

    def _moves(self, at: Array, gradient: Array, step: Array) -> list[Array]:
        """To the corner, along the gradient, and both: positions along the gradient, all else to the corner."""
        low, high, is_position = self._bounds.low, self._bounds.high, self._bounds.is_position
        slope = gradient * (high - low)
        steepest = np.abs(slope).max(axis=0, initial=0.0)
        along = self._bounds.inside(at + step * (high - low) * slope / np.where(steepest > 0, steepest, 1.0))
        corner = np.where(gradient > 0, high, np.where(gradient < 0, low, at))
        return [np.where(is_position, at, corner), along, np.where(is_position, along, corner)]

    def _best(self, at: Array, moves: Sequence[Array]) -> tuple[Array, BoolArray]:
        """The worst state of these for each, and where its positions have moved; the rows are those at the worst."""
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
        """Errors of the own result of each state, signed, so many times all states; the rows are those at `at`."""
        both = self._rows[times > 1]
        for rows, steps in zip(both, self._steps, strict=True):
            self._tape.fill(rows, steps, at)
        places = np.tile(self._result, times), np.arange(at.shape[1])
        exact, changed = (self._tape.values(rows)[places] for rows in both)
        errors: Array = (changed - exact) * np.tile(self._weights, times)
        return errors

    def _gradient(self) -> Array:
        """The derivatives of the magnitude of the error (symbols, states)."""
        sign = np.sign(self.error)
        seeds = np.zeros((1, len(self._tape.results), len(sign)))
        seeds[0, self._result, self._states] = sign * self._weights
        found = np.zeros((len(self._tape.symbols), len(sign)))
        for k, (rows, changes) in enumerate(zip(self._rows[0], (NO_CHANGES, self._changes), strict=True)):
            adjoints = self._sweep.adjoints(rows, seeds, changes)
            for symbol, place in enumerate(self._tape.symbols.values()):
                adjoint = adjoints[place]
                if adjoint is not None and place not in changes.frozen:
                    found[symbol] += adjoint[0] if k else -adjoint[0]
        finite: Array = np.nan_to_num(found)
        return finite
