"""Assembled positions reached from others by continuation: small steps that stay on the branch where they begin.

A step goes along the tangent -W_d^-1 W_u du, then Newton's method corrects it. It counts where the second correction
is far shorter than the first, so that no other solution is as near, and where no loop has turned over: det W_d, which
is zero where branches meet, keeps its sign. Else the step is halved.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Protocol

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray

STEP, HALVINGS = 0.1, 12
"""Longest step of an independent variable, rad or m, and the maximum number of halvings."""
LONGEST = 0.5
"""Longest step of a dependent variable, rad or m."""
CONTRACTION = 0.25
"""Maximum ratio of a correction to the previous correction."""
SETTLED, CORRECTIONS = 1e-9, 6
"""A correction of Newton's method after which the next is rounding, rad or m; their number."""
CLOSED, SMALLEST = 1e-11, 1e-9
"""Largest error of a loop that is closed; singular values of W_d, relative, that count as zero."""
TURNED = 1e-15
"""Relative product of determinants that counts as zero: their signs are rounding next to a singular position."""


class Equations(Protocol):
    """The equations of all loops at positions, which are values of all variables."""

    @property
    def free(self) -> Sequence[int]:
        """Columns of independent variables."""

    @property
    def unknown(self) -> Sequence[int]:
        """Columns of dependent variables."""

    @property
    def blocks(self) -> Sequence[tuple[Sequence[int], Sequence[int]]]:
        """Rows and columns of the parts of W_d whose determinants keep their signs."""

    def at(self, positions: Array) -> tuple[Array, Array]:
        """Return closing errors (samples, rows) and W (samples, rows, variables) at positions (samples, variables)."""


def continued_positions(loops: Equations, start: Array, targets: Array) -> Array:
    """Return positions (samples, variables) at `targets` (samples, free), reached from `start`; NaN where they end."""
    positions, origin, ways = start.copy(), start[:, loops.free], targets - start[:, loops.free]
    longest = 1 / np.maximum(1, np.ceil(np.abs(ways).max(axis=1, initial=0.0) / STEP))
    done, step = np.zeros(len(targets)), longest.copy()
    W, going = loops.at(positions)[1], np.arange(len(targets))
    while len(going):
        ahead = np.minimum(1, done[going] + step[going])
        here = origin[going] + ahead[:, None] * ways[going]
        candidates, W_candidates, good = _step(loops, positions[going], W[going], here)
        accepted, stuck = going[good], going[~good]
        positions[accepted], W[accepted], done[accepted] = candidates[good], W_candidates[good], ahead[good]
        step[accepted] = np.minimum(2 * step[accepted], longest[accepted])
        step[stuck] /= 2
        lost: BoolArray = step[going] < longest[going] / 2**HALVINGS
        positions[going[lost]] = np.nan
        going = going[~lost & (done[going] < 1)]
    return positions


def _step(loops: Equations, positions: Array, W: Array, here: Array) -> tuple[Array, Array, BoolArray]:
    """Positions at other independent variables, W there, and whether they stay on the branch."""
    along = W[:, :, loops.free] @ (here - positions[:, loops.free])[:, :, None]
    candidates = positions.copy()
    candidates[:, loops.free] = here
    candidates[:, loops.unknown] -= _solution(W[:, :, loops.unknown], along)
    candidates, W_candidates, good = _correct(loops, candidates)
    good &= (np.abs(candidates - positions)[:, loops.unknown] < LONGEST).all(axis=1)
    for rows, columns in loops.blocks:
        good &= _turning(W[:, rows][:, :, columns], W_candidates[:, rows][:, :, columns]) > -TURNED
    return candidates, W_candidates, good


def _solution(W: Array, right: Array) -> Array:
    """x (samples, unknown) of W x = right, least squares where equations repeat each other."""
    solution: Array
    if W.shape[1] == W.shape[2]:
        with suppress(np.linalg.LinAlgError):
            solution = np.asarray(np.linalg.solve(W, right)[:, :, 0], dtype=float)
            return solution
    finite: BoolArray = np.all(np.isfinite(W), axis=(1, 2))
    solution = (np.linalg.pinv(np.where(finite[:, None, None], W, 0.0), rcond=SMALLEST) @ right)[:, :, 0]
    solution[~finite] = np.nan
    return solution


def _correct(loops: Equations, candidates: Array) -> tuple[Array, Array, BoolArray]:
    """Positions after Newton's method, W there, and whether they are closed and no correction went far."""
    before = np.full(len(candidates), np.inf)
    good: BoolArray = np.ones(len(candidates), dtype=bool)
    for _ in range(CORRECTIONS):
        errors, W = loops.at(candidates)
        change = _solution(W[:, :, loops.unknown], errors[:, :, None])
        candidates = candidates.copy()
        candidates[:, loops.unknown] -= change
        length = np.abs(change).max(axis=1, initial=0.0)
        good &= length <= np.maximum(CONTRACTION * before, SETTLED)
        before = length
        if (length[good] < SETTLED).all():
            break
    return candidates, W, good & (np.abs(errors).max(axis=1, initial=0.0) < CLOSED)


def _turning(first: Array, second: Array) -> Array:
    """det(A' B) of two matrices with columns scaled to length 1: negative where the branch has changed."""
    lengths = (np.linalg.norm(W, axis=1, keepdims=True) for W in (first, second))
    first, second = (W / np.where(length > 0, length, 1.0) for W, length in zip((first, second), lengths, strict=True))
    products: Array = np.linalg.det(np.swapaxes(first, 1, 2) @ second)
    return products
