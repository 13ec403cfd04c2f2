"""Bounds of the inverse of the inertia matrix: W without entry below zero, d' A^-1 d <= |d|' W |d| in a box.

Three ways to one, for `matrix_argument.py`:

1. **Rotors.** A - diag(Ia) is positive semidefinite where bodies can exist, so W = diag(1/Ia) (lemma 5). It never fails
   where each joint has a rotor, and never sees the bodies.
2. **Intervals.** A >= M - D in a sub-box (lemma 6), so W = |(M - D)^-1|.
3. **Entries.** |A^-1| <= W is such a W, too: in all cells of a box (`inverse_on_cells.py`), or from intervals of A.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.numerics.guarantees.axes import Axis, axis_of
from symoro_elastic.numerics.guarantees.box import FULL_TURN, Box
from symoro_elastic.numerics.guarantees.degrees import NotPolynomial, degrees
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.inverse_on_cells import Cells, near_inverses, verified
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors
from symoro_elastic.numerics.guarantees.surface import numbers_in
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import SYMBOL

MARGIN = 1e-9
"""Of matrices whose diagonal is 1: more than the rounding of what is computed with them here."""
OUTWARDS = 1 + 1e-6
MOST_NODES = 60_000


def by_rotors(least: Mapping[int, Array], joints: Sequence[int]) -> Array:
    """W (n, n, 1) from rotors by joint; infinite where a joint has none."""
    with np.errstate(divide="ignore"):
        inverse = OUTWARDS / np.array([float(least.get(j, np.zeros(1)).flat[0]) for j in joints])
    return _diagonal(inverse)


def _diagonal(values: Array) -> Array:
    found = np.zeros((len(values), len(values), 1))
    found[range(len(values)), range(len(values)), 0] = values
    return found


def by_intervals(A: Interval) -> Array:
    """W (n, n, sub-boxes) from the intervals of a matrix; infinite where it may be singular."""
    low, high = (np.moveaxis(end, -1, 0) for end in A)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        scale = 1 / np.sqrt(np.einsum("bii->bi", middle))
        radius = np.maximum(high - middle, middle - low) * OUTWARDS
        spread = np.einsum("bik,bk->bi", radius, scale) * scale
        scaled = middle * scale[:, :, None] * scale[:, None, :] - _on_diagonal(spread + MARGIN)
        inverses = np.abs(_inverses(scaled))
        inverses += MARGIN * np.trace(inverses, axis1=1, axis2=2)[:, None, None]
        return np.moveaxis(inverses * scale[:, :, None] * scale[:, None, :], 0, -1)


def entries_by_intervals(A: Interval) -> Array:
    """A bound of all entries of A^-1 (n, n, sub-boxes) from the intervals of A; infinite where none is proven."""
    low, high = (np.moveaxis(end, -1, 0) for end in A)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        scale = 1 / np.sqrt(np.einsum("bii->bi", middle))
        both = scale[:, :, None] * scale[:, None, :]
        radius = np.maximum(high - middle, middle - low) * both * OUTWARDS + MARGIN
        C = near_inverses(middle * both)
        G = np.abs(np.eye(len(A.low)) - C @ (middle * both)) + np.abs(C) @ radius
        return np.moveaxis(verified(C, G, C) * both, 0, -1)


def _on_diagonal(values: Array) -> Array:
    return values[..., None] * np.eye(values.shape[-1])


def _inverses(matrices: Array) -> Array:
    """Inverses of matrices (.., n, n), infinite where one is not positive definite."""
    found = np.full_like(matrices, np.inf)
    able = np.flatnonzero(np.isfinite(matrices).all(axis=(1, 2)))
    able = able[np.linalg.eigvalsh(matrices[able])[:, 0] > 1e3 * MARGIN]
    found[able] = np.linalg.inv(matrices[able])
    return found


@dataclass(frozen=True)
class OnCells:
    """W (n, n, 1), a bound of all entries of A^-1, and one of |A^-1 d| (n, 1) for the d that was asked for."""

    W: Array
    solution: Array


def on_cells(A: Sequence[Sequence[Operand]], box: Box, most: int, d: Array) -> OnCells | None:
    """What at most so many cells of positions prove; None where entries are no polynomials, or nothing is proven."""
    entries = [x for row in A for x in row]
    try:
        axes = _axes(entries, box)
    except NotPolynomial:
        return None
    if math.prod(len(axis.nodes) for axis in axes) > MOST_NODES:
        return None
    at_nodes = _matrices(entries, len(A), box, {axis.name: axis.nodes for axis in axes})
    scale = 1 / np.sqrt(np.einsum("bii->bi", at_nodes).max(axis=0))
    both = scale[:, None] * scale
    values = (at_nodes * both).reshape(*(len(axis.nodes) for axis in axes), *both.shape)
    off = MARGIN + _rounding(entries, box, both)
    found = Cells.of(values, axes, [box.ranges[axis.name] for axis in axes], off).bounds(most, d * scale)
    if found is None:
        return None
    return OnCells((found[:, :-1] * both)[..., None], (found[:, -1] * scale)[:, None])


def _axes(entries: Sequence[Operand], box: Box) -> list[Axis]:
    """The axes of all entries, angles as whole turns; raises `NotPolynomial`."""
    moving = [x for x in entries if isinstance(x, Expression)]
    found = degrees(moving, numbers_in(box))
    both = reduce(lambda x, y: x + y, found) if found else None
    if both is None:
        return []
    turning = [axis_of(name, n, FULL_TURN, angle=True) for name, n in sorted(both.angles.items())]
    return turning + [axis_of(name, n, box.ranges[name], angle=False) for name, n in sorted(both.powers.items())]


def _matrices(entries: Sequence[Operand], size: int, box: Box, axes: Mapping[str, Array]) -> Array:
    """The matrices (points, n, n) at all combinations of values of the axes."""
    grid = np.meshgrid(*axes.values(), indexing="ij")
    states = {name: x.ravel() for name, x in zip(axes, grid, strict=True)}
    count = math.prod(len(x) for x in axes.values())
    value = evaluate(entries, {**numbers_in(box), **states}, arithmetic(np.float64))
    columns = [np.broadcast_to(np.asarray(value(x), dtype=float), count) for x in entries]
    return np.moveaxis(np.array(columns).reshape(size, size, count), -1, 0)


def _rounding(entries: Sequence[Operand], box: Box, both: Array) -> float:
    """At least the errors of matrices that are computed in double precision, as a norm."""
    nodes = reachable(entries)
    used = [str(node.operands[0]) for node in nodes if node.operation == SYMBOL]
    bounds = running_errors(nodes, box.of(used).whole, ROUNDINGS["double"])
    errors = np.array([float(np.max(bounds.error_of(x))) for x in entries]).reshape(both.shape)
    return float(np.linalg.norm(errors * both)) * OUTWARDS
