"""Modes over a grid of positions, matched from each position to the next by their shapes.

The criterion is MAC_ij = (phi_i^T M phi_j)^2 with the mean mass matrix of both positions; of a repeated frequency
only the subspace counts, and its shapes are turned to those they are paired with.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, clusters, modes, refuse_rigid
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, refuse_numbers
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium

DOUBTFUL_MAC = 0.5
ALONG = "--along"
MOST_POSITIONS = 10_000
MATRICES = 8  # of the order of the joints, at each position
Grid = Mapping[str, Sequence[float]]


@dataclass(frozen=True, repr=False)
class Tracked(Result):
    """Modes at every position of a grid; column k is the same mode everywhere.

    `positions` (points, joints of the grid), `modes` those there, `mac` (points, m) how alike each is to the
    mode that it was paired with, `before` the point that each was paired with (itself at the first).
    """

    joints: tuple[str, ...]
    lengths: tuple[int, ...]
    positions: Array
    modes: tuple[Modes, ...]
    mac: Array
    before: tuple[int, ...]

    @property
    def frequencies(self) -> Array:
        """Frequencies in Hz, (points, m)."""
        return np.array([modal.frequencies for modal in self.modes])

    @property
    def growth(self) -> Array:
        """Growth rates of unstable modes in 1/s, (points, m); 0 for all others."""
        return np.array([modal.growth for modal in self.modes])

    @property
    def doubtful(self) -> list[tuple[int, int]]:
        """Pairs (point, mode) with a MAC below one half: the grid is too coarse there."""
        return [(int(i), int(k)) for i, k in np.argwhere(self.mac < DOUBTFUL_MAC)]

    @property
    def headline(self) -> str:
        """Machine, modes and positions."""
        name = self.modes[0].linear.motion.machine.name
        return f"Modes of {name} at {len(self.modes)} positions of {', '.join(self.joints)}"


def over_grid(
    motion: EquationsOfMotion,
    grid: Grid,
    at: Mapping[str, float] | None = None,
    torques: Mapping[str, float] | None = None,
    held: Sequence[str] = (),
    gains: Mapping[str, tuple[float, float]] | None = None,
    progress: Progress = no_progress,
    carried: bool = False,
) -> Tracked:
    """Return the modes at the equilibrium of every position of a grid, matched along it; the last joint is fastest.

    `grid` gives positions (rad or m) by joint, `at` those of other joints; `torques`, `held` and `gains` are
    those of `equilibrium` and `with_motors`, and so is `carried`. Raises `InputError`.
    """
    joints, lengths = tuple(grid), tuple(len(places) for places in grid.values())
    refuse_grid(lengths, motion.source)
    what = f"{math.prod(lengths)} positions of {len(motion.joints)} joints"
    numbers = MATRICES * math.prod(lengths) * len(motion.joints) ** 2
    refuse_numbers(numbers, what, motion.source, ALONG, "give fewer positions")
    refuse_unheld(motion, joints, torques or {})
    refuse_twice(motion, joints, at or {})
    positions = np.array(list(product(*grid.values())), dtype=float)
    before = [_previous(index, lengths) for index in np.ndindex(*lengths)]
    tracked: list[Modes] = []
    alike = []
    for point, place in enumerate(positions):
        moved = dict(zip(joints, place.tolist(), strict=True))
        with _at_place(moved):
            state = equilibrium(motion, {**(at or {}), **moved}, torques, carried)
            linear = with_motors(linearize(motion, state, (), ()), held, gains)
            refuse_rigid(linear)
            here = modes(linear)
        paired, mac = pair(tracked[before[point]], here) if point else (here, np.ones(len(here.eigenvalues)))
        tracked.append(paired)
        alike.append(mac)
        progress(point + 1, len(positions))
    return Tracked(joints, lengths, positions, tuple(tracked), np.array(alike), tuple(before))


def places_of(
    motion: EquationsOfMotion, along: Mapping[str, Sequence[float]], at: Mapping[str, float]
) -> list[dict[str, float]]:
    """Return the positions of a grid of motors, or the single stated position; raises `InputError`."""
    if along:
        refuse_grid([len(positions) for positions in along.values()], motion.source)
        refuse_unheld(motion, [*along], {})
    refuse_twice(motion, along, at)
    return [dict(zip(along, place, strict=True)) for place in product(*along.values())] if along else [dict(at)]


def refuse_unheld(
    motion: EquationsOfMotion, joints: Sequence[str], torques: Mapping[str, float], option: str = ALONG
) -> None:
    """Raise `InputError` for a joint whose position the equilibrium changes."""
    for name in joints:
        if motion.index(name, option) not in motion.motors or name in torques:
            what = f"{name} is not held, so its position is that of the equilibrium: give motors instead"
            raise InputError(motion.source, option, what)


def refuse_twice(motion: EquationsOfMotion, joints: Collection[str], at: Mapping[str, float]) -> None:
    """Raise `InputError` for a joint with both a grid and a single position, or twice in a grid."""
    fixed = {motion.index(name, "--at"): x for name, x in at.items()}
    for name in joints:
        x = fixed.get(motion.index(name, ALONG))
        if x is not None:
            raise InputError(motion.source, ALONG, f"{name} is at {x:g} by --at: remove one of the two")
    if len({motion.index(name, ALONG) for name in joints}) < len(joints):
        raise InputError(motion.source, ALONG, f"{' and '.join(joints)} are the same joint: name each once")


def refuse_grid(lengths: Sequence[int], source: str) -> None:
    """Raise `InputError` for a grid without positions, or with more than the limit; lengths by joint."""
    count = math.prod(lengths) if lengths else 0
    if not 0 < count <= MOST_POSITIONS:
        what = f"{count} positions: name joints, and at most {MOST_POSITIONS} positions"
        raise InputError(source, ALONG, what)


@contextmanager
def _at_place(place: Mapping[str, float]) -> Iterator[None]:
    """Add the position to the messages of errors raised within the context."""
    try:
        yield
    except InputError as error:
        where = ", ".join(f"{name} = {x:g}" for name, x in place.items())
        raise InputError(error.file, f"{error.place} at {where}", error.what) from None


def _previous(index: tuple[int, ...], lengths: tuple[int, ...]) -> int:
    """Return the index of the preceding neighbour of a grid point; for the first point, its own index."""
    moved = list(index)
    for axis in reversed(range(len(lengths))):
        if moved[axis]:
            moved[axis] -= 1
            break
    return int(np.ravel_multi_index(moved, lengths))


def pair(before: Modes, here: Modes) -> tuple[Modes, Array]:
    """Return the modes `here` in the order of the modes `before`, and the MAC of the pairs (m,)."""
    mass = (before.linear.M + here.linear.M) / 2
    old, new = _normal(before.shapes, mass), _normal(here.shapes, mass)
    criterion = (old.T @ mass @ new) ** 2
    subspaces = criterion.copy()
    for cluster in _indices(before.eigenvalues):
        subspaces[cluster] = subspaces[cluster].sum(axis=0)
    for cluster in _indices(here.eigenvalues):
        subspaces[:, cluster] = subspaces[:, cluster].sum(axis=1, keepdims=True)
    _, order = for_vibrations("scipy.optimize").linear_sum_assignment(-np.minimum(subspaces, 1.0) - 1e-6 * criterion)
    shapes, values = here.shapes[:, order].copy(), here.eigenvalues[order]
    for cluster in _indices(values):
        overlap = shapes[:, cluster].T @ mass @ old[:, cluster]
        U, _, right = np.linalg.svd(overlap)
        shapes[:, cluster] = shapes[:, cluster] @ (U @ right)
    alike = np.sum(old * (mass @ _normal(shapes, mass)), axis=0) ** 2
    moved = replace(here, eigenvalues=values, shapes=shapes, damping_ratios=here.damping_ratios[order])
    return moved, np.minimum(alike, 1.0)


def _normal(shapes: Array, mass: Array) -> Array:
    return np.asarray(shapes / np.sqrt(np.einsum("im,ij,jm->m", shapes, mass, shapes)))


def _indices(eigenvalues: Array) -> list[NDArray[np.intp]]:
    """Return the indices of the modes of each distinct frequency."""
    order = np.argsort(eigenvalues, kind="stable")
    return [order[cluster] for cluster in clusters(eigenvalues[order])]
