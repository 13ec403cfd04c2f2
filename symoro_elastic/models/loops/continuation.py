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
"""Longest step of an independent variable, rad or m, and how often it is halved at most."""
LONGEST = 0.5
"""Of a step of a dependent variable, rad or m."""
CONTRACTION = 0.25
"""Of a correction to the one before it, at most."""
SETTLED, CORRECTIONS = 1e-9, 6
"""A correction of Newton's method after which the next is rounding, rad or m; their number."""
CLOSED, SMALLEST = 1e-11, 1e-9
"""Largest error of a loop that is closed; singular values of W_d, relative, that count as zero."""
TURNED = 1e-15
"""A product of determinants that is zero, relative: next to a singular position their signs tell nothing."""


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
    found, origin, ways = start.copy(), start[:, loops.free], targets - start[:, loops.free]
    longest = 1 / np.maximum(1, np.ceil(np.abs(ways).max(axis=1, initial=0.0) / STEP))
    done, step = np.zeros(len(targets)), longest.copy()
    W, going = loops.at(found)[1], np.arange(len(targets))
    while len(going):
        ahead = np.minimum(1, done[going] + step[going])
        here = origin[going] + ahead[:, None] * ways[going]
        near, W_near, good = _stepped(loops, found[going], W[going], here)
        kept, stuck = going[good], going[~good]
        found[kept], W[kept], done[kept] = near[good], W_near[good], ahead[good]
        step[kept] = np.minimum(2 * step[kept], longest[kept])
        step[stuck] /= 2
        lost: BoolArray = step[going] < longest[going] / 2**HALVINGS
        found[going[lost]] = np.nan
        going = going[~lost & (done[going] < 1)]
    return found


def _stepped(loops: Equations, found: Array, W: Array, here: Array) -> tuple[Array, Array, BoolArray]:
    """Positions at other independent variables, W there, and whether each is on the branch of the one before."""
    along = W[:, :, loops.free] @ (here - found[:, loops.free])[:, :, None]
    near = found.copy()
    near[:, loops.free] = here
    near[:, loops.unknown] -= _solved(W[:, :, loops.unknown], along)
    near, W_near, good = _corrected(loops, near)
    good &= (np.abs(near - found)[:, loops.unknown] < LONGEST).all(axis=1)
    for rows, columns in loops.blocks:
        good &= _turning(W[:, rows][:, :, columns], W_near[:, rows][:, :, columns]) > -TURNED
    return near, W_near, good


def _solved(W: Array, right: Array) -> Array:
    """x (samples, unknown) of W x = right, least squares where equations repeat each other."""
    found: Array
    if W.shape[1] == W.shape[2]:
        with suppress(np.linalg.LinAlgError):
            found = np.asarray(np.linalg.solve(W, right)[:, :, 0], dtype=float)
            return found
    finite: BoolArray = np.all(np.isfinite(W), axis=(1, 2))
    found = (np.linalg.pinv(np.where(finite[:, None, None], W, 0.0), rcond=SMALLEST) @ right)[:, :, 0]
    found[~finite] = np.nan
    return found


def _corrected(loops: Equations, near: Array) -> tuple[Array, Array, BoolArray]:
    """Positions after Newton's method, W there, and whether they are closed and no correction went far."""
    before = np.full(len(near), np.inf)
    good: BoolArray = np.ones(len(near), dtype=bool)
    for _ in range(CORRECTIONS):
        errors, W = loops.at(near)
        change = _solved(W[:, :, loops.unknown], errors[:, :, None])
        near = near.copy()
        near[:, loops.unknown] -= change
        length = np.abs(change).max(axis=1, initial=0.0)
        good &= length <= np.maximum(CONTRACTION * before, SETTLED)
        before = length
        if (length[good] < SETTLED).all():
            break
    return near, W, good & (np.abs(errors).max(axis=1, initial=0.0) < CLOSED)


def _turning(one: Array, other: Array) -> Array:
    """The product of both determinants, columns of length 1; of all square parts where there are more rows."""
    lengths = (np.linalg.norm(W, axis=1, keepdims=True) for W in (one, other))
    one, other = (W / np.where(length > 0, length, 1.0) for W, length in zip((one, other), lengths, strict=True))
    found: Array = np.linalg.det(np.swapaxes(one, 1, 2) @ other)
    return found
