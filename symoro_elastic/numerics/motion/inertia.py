"""Singular inertia matrices: joints that move without inertia, and remedies."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, enumeration
from symoro_elastic.machine.series_springs import springs_in_series
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion

MATRIX_ROUNDING = 100 * float(np.finfo(float).eps)
"""Rounding of an eigenvalue of the inertia matrix scaled to a diagonal of ones."""
MOVING_COMPONENT = 0.1
"""Component of a joint in a motion, of the largest one, above which the joint moves; scaled as M is."""


def refuse_singular(motion: EquationsOfMotion, M: Array, kept: Sequence[int], can_hold: bool = True) -> None:
    """Raise `InputError` where M (n, n) of the coordinates `kept` is not positive definite.

    The message names the joints that move without inertia and those that need some; `can_hold` offers --hold too.
    Springs in series become one by `condense`, or the message says why not.
    """
    idle, least = massless_rows(M)
    if not idle:
        return
    names = [motion.names[k] for k in kept]
    motors = {row for row, k in enumerate(kept) if k in motion.motors}
    culprits = rows_to_remove(M, motors)
    ways = [f"give {enumeration([names[row] for row in culprits])} an inertia"]
    if can_hold and motors.issuperset(culprits):
        ways.append(" ".join(f"--hold {names[row]}" for row in culprits))
    idle_names = [names[row] for row in idle]
    joined, obstacle = _condensing(motion, idle_names)
    ways += joined
    is_zero = least > -MATRIX_ROUNDING
    wrong = "singular here: nothing has inertia" if is_zero else "not positive here: the inertia is negative"
    what = f"{wrong} in a motion of {enumeration(idle_names)}; {' or '.join(ways)}{obstacle}"
    raise InputError(motion.source, "inertia matrix", what)


def _condensing(motion: EquationsOfMotion, idle: Collection[str]) -> tuple[list[str], str]:
    """Return advice to condense two idle springs in series into one, or the reason why that is not possible."""
    machine = motion.given
    for pair in springs_in_series(machine):
        if {machine.joint(j).name for j in (pair.first, pair.last)}.issubset(idle):
            if pair.obstacle:
                return [], f" (condense = true cannot make these springs in series one: {pair.obstacle})"
            return ["write condense = true in [scene], which makes these springs in series one"], ""
    return [], ""


def massless_rows(M: Array) -> tuple[list[int], float]:
    """Return the rows that take part in motions of zero or negative inertia, and the least eigenvalue of scaled M."""
    values, vectors = _scaled_eigenvalues(M)
    null = vectors[:, values <= MATRIX_ROUNDING]
    part = np.sqrt(np.sum(null**2, axis=1))
    moving = np.flatnonzero(part > MOVING_COMPONENT * part.max(initial=0.0))
    return moving.tolist(), float(values.min(initial=1.0))


def rows_to_remove(M: Array, preferred: Collection[int]) -> list[int]:
    """Return the fewest rows to remove for a positive definite M, `preferred` ones first."""
    rows, removed = list(range(len(M))), []
    while idle := [rows[k] for k in massless_rows(M[np.ix_(rows, rows)])[0]]:
        removed.append(next((row for row in idle if row in preferred), idle[0]))
        rows.remove(removed[-1])
    return removed


def _scaled_eigenvalues(M: Array) -> tuple[Array, Array]:
    """Return eigenvalues and vectors of M with a diagonal of ones, zeros unless it is positive beyond rounding."""
    diagonal = np.diag(M)
    least = MATRIX_ROUNDING**2 * np.abs(diagonal).max(initial=0.0)
    scale = 1 / np.sqrt(np.where(np.abs(diagonal) > least, np.abs(diagonal), 1.0))
    scale[np.abs(diagonal) <= least] = 0.0
    values, vectors = np.linalg.eigh((M + M.T) / 2 * np.outer(scale, scale))
    return values, vectors
