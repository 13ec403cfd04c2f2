"""Crossings where a motion leaves the branch on which its loops start: they do not close any more, or branches meet.

Closed forms hold their branch by the sign of a root. Where the root is zero a motion passes smoothly to the other
branch, and the closed form turns back with a kink: continuation from sample to sample distinguishes the two.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.models.loops.continuation import continued_positions
from symoro_elastic.models.loops.open_loops import FLAT
from symoro_elastic.models.loops.plan import Form, LoopPlan, Plan

SAME = 1e-6
"""Distance of positions on one branch, rad or m: less than what a closed form loses next to a singular position."""


class BranchCrossings:
    """Detection of branch crossings, by the equations of loops that can be singular."""

    def __init__(self, plan: Plan) -> None:
        self.machine = plan.assembly.machine
        self.loops = tuple(loop for loop in plan.loops if loop.form is not Form.MAP and loop.dependent)
        self._assembly = plan.assembly.of_loops([loop.loop for loop in self.loops])
        needed_rows = {(loop.loop.name, row) for loop in self.loops for row in loop.kept}
        self._rows = [k for k, x in enumerate(self._assembly.equations) if (x.loop, x.row) in needed_rows]
        self.unknown = self._assembly.columns({j for loop in self.loops for j in loop.dependent})
        self.free = [k for k in range(len(self.machine.with_variable)) if k not in self.unknown]

    @cached_property
    def blocks(self) -> list[tuple[list[int], list[int]]]:
        """Rows and columns of W_d: of all loops together, and by loop that alone determines its joints."""
        own = [self.block(loop) for loop in self.loops if len(loop.kept) == len(loop.dependent)]
        return [([*range(len(self._rows))], self.unknown), *(own if len(self.loops) > 1 else [])]

    def block(self, loop: LoopPlan) -> tuple[list[int], list[int]]:
        """Rows and columns of the part of W_d of a loop."""
        names = [self._assembly.equations[k].loop for k in self._rows]
        return [i for i, name in enumerate(names) if name == loop.loop.name], self._assembly.columns(loop.dependent)

    def at(self, positions: Array) -> tuple[Array, Array]:
        """Closing errors (samples, rows) and W (samples, rows, variables) at positions (samples, variables)."""
        errors, W = self._assembly.at(positions)
        return errors[:, self._rows], W[:, self._rows]

    def first_lost(self, positions: Array) -> int | None:
        """Index of the first position (samples, variables) off the branch of its predecessors; None if none is."""
        finite: BoolArray = np.all(np.isfinite(positions), axis=1)
        count = len(positions) if finite.all() else int(np.argmin(finite))
        closed = positions[:count]
        singular = np.flatnonzero((self.distances(closed) < FLAT).any(axis=1)) if count else np.zeros(0, dtype=int)
        off_branch = np.flatnonzero(~self._follow(closed)) + 1
        first = min((*singular[:1].tolist(), *off_branch[:1].tolist(), count))
        return None if first == len(positions) else int(first)

    def ends_at(self, position: Array, q: Array) -> bool:
        """Whether the branch of a position (variables,) does not lead to other independent variables q (n,)."""
        beyond = position[None].copy()
        beyond[0, self._assembly.columns(self.machine.independent)] = q
        return bool(np.isnan(continued_positions(self, position[None], beyond[:, self.free])).any())

    def distances(self, positions: Array) -> Array:
        """Smallest singular values of the blocks of W_d (samples, blocks), columns of length 1."""
        W = self.at(positions)[1]
        return np.stack([_smallest(W[:, rows][:, :, columns]) for rows, columns in self.blocks], axis=1)

    def nearest(self, position: Array) -> list[str]:
        """Names of the loops that are nearest to singular at a position (variables,)."""
        W = self.at(position[None])[1]
        sizes = {}
        for loop in self.loops:
            rows, columns = self.block(loop)
            sizes[loop.loop.name] = float(_smallest(W[:, rows][:, :, columns])[0]) if rows else np.inf
        least = min(sizes.values())
        return [name for name, size in sizes.items() if size <= least]

    def _follow(self, positions: Array) -> BoolArray:
        """Whether each of positions after the first continues the one before it."""
        if len(positions) < 2:
            return np.ones(0, dtype=bool)
        differences = positions[1:] - continued_positions(self, positions[:-1].copy(), positions[1:, self.free])
        turning = [k for k, j in enumerate(self.machine.with_variable) if self.machine.joint(j).sigma == 0]
        differences[:, turning] -= 2 * np.pi * np.round(differences[:, turning] / (2 * np.pi))
        on_branch: BoolArray = np.all(np.abs(differences) < SAME, axis=1)
        return on_branch


def _smallest(W: Array) -> Array:
    """Smallest singular values of matrices (samples,), columns of length 1."""
    lengths = np.linalg.norm(W, axis=1, keepdims=True)
    sizes: Array = np.asarray(np.linalg.svd(W / np.where(lengths > 0, lengths, 1.0), compute_uv=False), dtype=float)
    return sizes[:, -1]
