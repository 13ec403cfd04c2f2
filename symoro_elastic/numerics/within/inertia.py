"""Whether a machine keeps a positive definite inertia matrix when some of its parameters are zero."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from symoro_elastic.numerics.within.states import Bounds, Box
from symoro_elastic.numerics.within.tape import Tape, picked
from symoro_elastic.symbolic.program import Program

STATES = 300


class HasInertia:
    """A check at positions drawn from a box; its program has one output, the inertia matrix."""

    def __init__(self, inertia: Program, box: Box, seed: int) -> None:
        self._tape = Tape(inertia)
        self._states = Bounds.of(self._tape, box).draw(STATES, np.random.default_rng([seed, 5]))
        (output,) = inertia.outputs
        self._shape = output.shape

    def __call__(self, zero: Collection[str]) -> bool:
        """Whether all eigenvalues are positive where these parameters are zero."""
        states = self._states.copy()
        states[[number for number, name in enumerate(self._tape.symbols) if name in zero]] = 0.0
        entries = picked(self._tape.rows(states), self._tape.entries[0])
        matrices = entries.T.reshape(-1, *self._shape)
        return bool(np.isfinite(matrices).all() and (np.linalg.eigvalsh(matrices) > 0).all())
