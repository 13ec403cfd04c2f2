"""Errors by springs that are omitted in a motion: locked where they start, or quasi-static.

E are the springs that are left out, R the coordinates that stay, d the small motion of all, d_R that of R alone.

    locked     e = max_t |C (d - d_R)|
    static     e = max_t |C (d - [d_R; d_E])|,    d_E = (R_E - M_ER d_R'' - D_ER d_R' - K_ER d_R) / k_E

The deflection of a static spring is that of the reaction on its joint where it starts, so k_E is its own stiffness.
It takes part in outputs, not in the motion: torques of motors are those of locked springs.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.simulation.prediction.loops import by_parts
from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.small_motion import SmallMotion
from symoro_elastic.foundation.array_types import Array


@dataclass(frozen=True)
class Errors:
    """The largest errors of outputs, by name, over all motions, with locked and with static springs."""

    left_out: tuple[str, ...]
    locked: Mapping[str, float]
    static: Mapping[str, float]


def relative(errors: Mapping[str, float], tolerance: Mapping[str, float]) -> float:
    """Return the largest error relative to the tolerance of its output."""
    return max((errors[name] / most for name, most in tolerance.items()), default=0.0)


@dataclass(frozen=True)
class Deviations:
    """Small motions of a machine along one path, with springs omitted as required."""

    path: LinearPath

    @cached_property
    def whole(self) -> SmallMotion:
        """Small motion d, d', d'' (N, 1, n) with all springs."""
        return self.path.without([()])

    @cached_property
    def outputs(self) -> Array:
        """Output changes dy (N, outputs) with all springs."""
        return self._with_offsets(self.path.outputs.of(self.whole))[:, 0]

    def errors(self, sets: Sequence[Collection[int]]) -> tuple[Array, Array]:
        """Return errors (sets, outputs) of locked and of static springs; omitted parts of drives act without delay."""
        outputs = self.outputs[:, None]
        locked, static = np.zeros((2, len(sets), outputs.shape[-1]))
        for parts, rows in by_parts(sets, self.path.parts):
            springs = [tuple(k for k in sets[row] if k not in parts) for row in rows]
            reduced = Deviations(self.path.without_parts(self.path.names(parts))).with_springs(springs)
            locked[rows], static[rows] = (np.abs(outputs - x).max(axis=0) for x in reduced)
        return locked, static

    def with_springs(self, sets: Sequence[Collection[int]]) -> tuple[Array, Array]:
        """Return output changes dy (N, sets, outputs) with springs locked, and with springs static."""
        path, reduced = self.path, self.path.without(sets)
        locked = path.outputs.of(reduced)
        recovered = path.outputs.of(replace(reduced, d=reduced.d + self.static_deflections(reduced, sets)))
        static = np.where(path.outputs.follows, recovered, locked)
        return self._with_offsets(locked), self._with_offsets(static)

    def _with_offsets(self, dy: Array) -> Array:
        """Return output changes dy (N, sets, outputs) plus the outputs at zero deviation."""
        return dy if self.path.offsets is None else dy + self.path.offsets[:, None]

    def under(self, forces: Array, left_out: Collection[int]) -> Array:
        """Return output changes dy (N, sets, outputs) under several forces (N, sets, n), same springs static."""
        path, reduced = self.path, self.path.driven_by(forces, left_out)
        deflected = self.static_deflections(reduced, [left_out] * forces.shape[1], forces)
        recovered = path.outputs.of(replace(reduced, d=reduced.d + deflected))
        return np.asarray(np.where(path.outputs.follows, recovered, path.outputs.of(reduced)))

    def static_deflections(
        self, reduced: SmallMotion, sets: Sequence[Collection[int]], forces: Array | None = None
    ) -> Array:
        """Return static deflections d_E (N, sets, n), zero for moving coordinates; under R, or forces (N, sets, n)."""
        driving = self.path.R[:, None] if forces is None else forces
        path, left_out = self.path, np.zeros((len(sets), len(self.path.joints)))
        for row, chosen in enumerate(sets):
            left_out[row, list(chosen)] = 1.0
        terms = ((path.M, reduced.ddd), (path.D, reduced.dd), (path.K, reduced.d))
        load = driving - sum(np.einsum("tij,tsj->tsi", matrix, x) for matrix, x in terms)
        return np.asarray(load * left_out / np.where(path.stiffness, path.stiffness, np.inf))


def spring_errors(paths: Sequence[Deviations], sets: Sequence[Collection[int]]) -> list[Errors]:
    """Return the errors of sets of springs (entries of q, sets equally large): the largest over all motions."""
    by_motion = [deviations.errors(sets) for deviations in paths]
    locked, static = (np.max([errors[kind] for errors in by_motion], axis=0) for kind in range(2))
    path = paths[0].path
    return [
        Errors(path.names(sorted(left_out)), *(dict(zip(path.outputs.names, x.tolist(), strict=True)) for x in pair))
        for left_out, *pair in zip(sets, locked, static, strict=True)
    ]
