"""How much each change of a program shifts natural frequencies, of the first order.

With motors held, d qdd_p = -S dq_p where S = -(J_pp - B_p B_m^-1 J_mp) (`frequencies`). For S x = lambda x,
y' S = lambda y' and y' x = 1 an eigenvalue moves by d lambda = y' dS x, and

    -dS x = (dJ_pp - B_p B_m^-1 dJ_mp) x - (dB_p - B_p B_m^-1 dB_m) H x,        H = B_m^-1 J_mp,

so d lambda = -w' d(qdd_d): the change of the derivative of accelerations in the direction d (x for positions, -H x for
torques), weighted by w (y for passive joints, -y' B_p B_m^-1 for motors). With free motors S = -J, d = x and w = y.

A change that moves the value of its node by e moves w' qdd by a e, where a is the adjoint of w' qdd; the derivative of
that in the direction d is a central difference: effects are needed at two states for each mode and position, and one
sweep back along the tape finds those of all changes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.within.effects import Sweep, moved
from symoro_elastic.numerics.within.tape import Change, Changes, Tape

STEP = 1e-5
"""Of the central difference: radians or metres of the joint that moves most."""


@dataclass(frozen=True)
class Modes:
    """Modes at positions, (positions, modes, ...).

    `directions` are theirs by symbol, `weights` w by result of the tape, `scales` what multiplies a change of an
    eigenvalue: zero for modes that do not count.
    """

    directions: Array
    weights: Array
    scales: Array


class ShiftEffects:
    """Effects of changes on frequencies at positions: `states` are their equilibria (symbols, positions)."""

    def __init__(self, tape: Tape, states: Array, modes: Modes) -> None:
        self._tape = tape
        directions = STEP * modes.directions.transpose(2, 0, 1)
        ends = [states[:, :, None] + sign * directions for sign in (1, -1)]
        self._states = np.concatenate(ends, axis=1).reshape(len(states), -1)
        weights = modes.weights * (modes.scales / (-2 * STEP))[:, :, None]
        weights = weights.transpose(2, 0, 1).reshape(weights.shape[2], -1)
        self._seeds = np.concatenate([weights, -weights], axis=1)[None]
        count = self._states.shape[1]
        self._rows = tape.rows_in(np.empty((tape.count, count)))
        self._sweep = Sweep(tape, 1, count)

    def after(self, taken: Sequence[Change]) -> Callable[[Change], Array]:
        """Return the effect of one more change (positions * modes,) as a function; valid until the next call."""
        tape, rows, changes = self._tape, self._rows, Changes.of(taken)
        tape.fill(rows, tape.steps(changes), self._states)
        adjoints = self._sweep.adjoints(rows, self._seeds, changes)
        half = self._states.shape[1] // 2

        def effect(change: Change) -> Array:
            adjoint = adjoints[change.place]
            if adjoint is None:
                return np.zeros(half)
            ends: Array = adjoint[0] * moved(tape, rows, change)
            both: Array = ends[:half] + ends[half:]
            return both

        return effect
