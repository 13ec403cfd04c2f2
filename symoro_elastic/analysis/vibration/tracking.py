"""Modes over a grid of positions, paired from each position to the next by their shapes.

The criterion is MAC_ij = (phi_i^T M phi_j)^2 with the mean mass matrix of both positions; of a repeated frequency
only the subspace counts, and its shapes are turned to those they are paired with.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.array_types import AnyArray, Array
from symoro_elastic.errors import InputError
from symoro_elastic.packages import for_vibrations
from symoro_elastic.progress import Progress, no_progress
from symoro_elastic.results import Part, Result, Titled
from symoro_elastic.sizes import refuse_numbers
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion
from symoro_elastic.vibration.equilibrium import equilibrium
from symoro_elastic.vibration.linearization import linearize, with_motors
from symoro_elastic.vibration.modes import Modes, clusters, modes, refuse_rigid

DOUBTFUL_MAC = 0.5
MOST_POSITIONS = 10_000
MATRICES = 8  # of the order of the joints, at each position
Grid = Mapping[str, Sequence[float]]


@dataclass(frozen=True, repr=False)
class Tracked(Result):
    """Modes at every position of a grid, column k of all being one mode.

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
        """Hz, (points, m)."""
        return np.array([each.frequencies for each in self.modes])

    @property
    def growth(self) -> Array:
        """1/s at which modes grow that are unstable there, (points, m); 0 for all others."""
        return np.array([each.growth for each in self.modes])

    @property
    def doubtful(self) -> list[tuple[int, int]]:
        """(point, mode) of pairs with a MAC below one half: the grid is too coarse there."""
        return [(int(i), int(k)) for i, k in np.argwhere(self.mac < DOUBTFUL_MAC)]

    @property
    def headline(self) -> str:
        """Machine, modes and positions."""
        name = self.modes[0].linear.motion.machine.name
        return f"Modes of {name} at {len(self.modes)} positions of {', '.join(self.joints)}"

    def parts(self) -> list[Part]:
        """Return the table of frequencies, and where they are lowest and highest."""
        from symoro_elastic.vibration.tables import tracked_conclusion, tracked_table

        name = self.modes[0].linear.motion.machine.name
        return [Titled(tracked_table(self), f"{name}: frequencies, Hz"), tracked_conclusion(self)]

    def as_json(self) -> dict[str, Any]:
        """Return positions and frequencies as plain data."""
        from symoro_elastic.vibration.tables import tracked_json

        return tracked_json(self)

    def arrays(self) -> dict[str, AnyArray]:
        """Return positions, frequencies, growth, shapes by name."""
        from symoro_elastic.vibration.export import tracked_arrays

        return tracked_arrays(self)

    def columns(self) -> dict[str, AnyArray]:
        """Return a row for each position: the joints, and the frequency of each mode, Hz."""
        places = dict(zip(self.joints, self.positions.T, strict=True))
        return {**places, **{f"mode {k + 1}": f for k, f in enumerate(self.frequencies.T)}}


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
    """Return the modes at the equilibrium of every position of a grid, paired along it; the last joint varies fastest.

    `grid` gives positions (rad or m) by joint, `at` those of other joints; `torques`, `held` and `gains` are
    those of `equilibrium` and `with_motors`, and so is `carried`. Raises `InputError`.
    """
    joints, lengths = tuple(grid), tuple(len(places) for places in grid.values())
    refuse_grid(lengths, motion.source)
    what = f"{math.prod(lengths)} positions of {len(motion.joints)} joints"
    numbers = MATRICES * math.prod(lengths) * len(motion.joints) ** 2
    refuse_numbers(numbers, what, motion.source, "--over", "give fewer positions")
    refuse_unheld(motion, joints, torques or {})
    if len({motion.index(name, "--over") for name in joints}) < len(joints):
        raise InputError(motion.source, "--over", f"{' and '.join(joints)} are not joints of their own: name each once")
    positions = np.array(list(product(*grid.values())), dtype=float)
    before = [_previous(index, lengths) for index in np.ndindex(*lengths)]
    tracked: list[Modes] = []
    alike = []
    for point, place in enumerate(positions):
        moved = dict(zip(joints, place.tolist(), strict=True))
        with _named(moved):
            state = equilibrium(motion, {**(at or {}), **moved}, torques, carried)
            linear = with_motors(linearize(motion, state, (), ()), held, gains)
            refuse_rigid(linear)
            here = modes(linear)
        paired, mac = pair(tracked[before[point]], here) if point else (here, np.ones(len(here.eigenvalues)))
        tracked.append(paired)
        alike.append(mac)
        progress(point + 1, len(positions))
    return Tracked(joints, lengths, positions, tuple(tracked), np.array(alike), tuple(before))


def refuse_unheld(motion: EquationsOfMotion, joints: Sequence[str], torques: Mapping[str, float]) -> None:
    """Raise `InputError` for a joint that an equilibrium does not leave where it is put."""
    for name in joints:
        if motion.index(name, "--over") not in motion.motors or name in torques:
            what = f"{name} is not held, so the equilibrium decides where it is: go over motors"
            raise InputError(motion.source, "--over", what)


def refuse_grid(lengths: Sequence[int], source: str) -> None:
    """Raise `InputError` for a grid without positions, or with more than can be computed; lengths by joint."""
    count = math.prod(lengths) if lengths else 0
    if not 0 < count <= MOST_POSITIONS:
        what = f"{count} positions: name joints, and at most {MOST_POSITIONS} positions"
        raise InputError(source, "--over", what)


@contextmanager
def _named(place: Mapping[str, float]) -> Iterator[None]:
    """Add the position to the messages of errors."""
    try:
        yield
    except InputError as error:
        where = ", ".join(f"{name} = {x:g}" for name, x in place.items())
        raise InputError(error.file, f"{error.place} at {where}", error.what) from None


def _previous(index: tuple[int, ...], lengths: tuple[int, ...]) -> int:
    """Return the neighbour of a point that comes before it; the first point's own number."""
    moved = list(index)
    for axis in reversed(range(len(lengths))):
        if moved[axis]:
            moved[axis] -= 1
            break
    return int(np.ravel_multi_index(moved, lengths))


def pair(before: Modes, here: Modes) -> tuple[Modes, Array]:
    """Return the modes `here` in the order of those `before`, and the MAC of each pair (m,)."""
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
        left, _, right = np.linalg.svd(overlap)
        shapes[:, cluster] = shapes[:, cluster] @ (left @ right)
    alike = np.sum(old * (mass @ _normal(shapes, mass)), axis=0) ** 2
    moved = replace(here, eigenvalues=values, shapes=shapes, damping_ratios=here.damping_ratios[order])
    return moved, np.minimum(alike, 1.0)


def _normal(shapes: Array, mass: Array) -> Array:
    normal: Array = shapes / np.sqrt(np.einsum("im,ij,jm->m", shapes, mass, shapes))
    return normal


def _indices(eigenvalues: Array) -> list[NDArray[np.intp]]:
    """Return the modes of each repeated frequency."""
    order = np.argsort(eigenvalues, kind="stable")
    return [order[cluster] for cluster in clusters(eigenvalues[order])]
