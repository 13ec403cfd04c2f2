"""Bounds of the inverse of the inertia matrix: W without entry below zero, d' A^-1 d <= |d|' W |d| in a box.

Three ways to one, for `matrix_argument.py`:

1. **Rotors.** A - diag(Ia) is positive semidefinite where bodies can exist, so W = diag(1/Ia) (lemma 5). It never fails
   where each joint has a rotor, and never sees the bodies.
2. **Intervals.** A >= M - D in a sub-box (lemma 6), so W = |(M - D)^-1|.
3. **A grid.** Let A(q) be a matrix of polynomials. Between the points of a grid with steps h_j let P(q) be the mean of
   the A at the corners of the cell that interpolates them along one axis after another. Along one axis a function
   differs from its interpolation by h^2/8 times its largest second derivative, and means do not make that larger. For
   any x, with the coefficients C_k of A in functions of at most 1, whose second derivatives along axis j are at most
   w_kj,

       |x' d2A/dq_j2 x| <= sum w_kj |x' C_k x| <= x' G_j x,     G_j = sum w_kj |C_k|,   |C| = V |Lambda| V'

   so A(q) >= P(q) - sum h_j^2/8 G_j: a mean of matrices A(corner) - S. Now d' X^-1 d is convex in positive definite X,
   and falls as X rises, so it is at most the largest one at the corners: W_ik = max |(A(corner) - S)^-1|_ik.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.numerics.guarantees.axes import TURN, Axis, axis_of
from symoro_elastic.numerics.guarantees.box import FULL_TURN, Box
from symoro_elastic.numerics.guarantees.degrees import NotPolynomial, degrees
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors
from symoro_elastic.numerics.guarantees.surface import numbers_in
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import SYMBOL

MARGIN = 1e-9
"""Of matrices whose diagonal is 1: more than the rounding of what is computed with them here."""
OUTWARDS = 1 + 1e-6
MOST_NODES, AT_ONCE = 60_000, 20_000
SMALL_STEPS = 0.01
"""Loss of the grid, of matrices whose diagonal is 1: more points than this needs are not worth their time."""


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
class OnGrid:
    """W (n, n, 1), and a bound of d' A^-1 d for the d that was asked for."""

    W: Array
    squared: float


def on_grid(A: Sequence[Sequence[Operand]], box: Box, most: int, d: Array) -> OnGrid | None:
    """What a grid of at most so many points proves; None where entries are no polynomials, or nothing is proven."""
    entries = [x for row in A for x in row]
    try:
        axes = _axes(entries, box)
    except NotPolynomial:
        return None
    if math.prod(len(axis.nodes) for axis in axes) > MOST_NODES:
        return None
    size = len(A)
    at_nodes = _matrices(entries, size, box, {axis.name: axis.nodes for axis in axes})
    scale = 1 / np.sqrt(np.einsum("bii->bi", at_nodes).max(axis=0))
    both = scale[:, None] * scale
    curved = _curvatures((at_nodes * both).reshape(*(len(axis.nodes) for axis in axes), size, size), axes)
    steps, points = _steps(axes, box, [float(np.linalg.norm(G, 2)) for G in curved], most)
    lost = sum((h * h / 8 * G for h, G in zip(steps, curved, strict=True)), np.zeros((size, size))) * OUTWARDS
    lost = lost + (MARGIN + _rounding(entries, box, both)) * np.eye(size)
    W, squared, scaled = np.zeros((size, size)), 0.0, d * scale
    for part in _slabs(points):
        matrices = _matrices(entries, size, box, part) * both - lost
        inverses = _inverses(matrices)
        if not np.isfinite(inverses).all():
            return None
        W = np.maximum(W, np.abs(inverses).max(axis=0))
        squared = max(squared, float(np.einsum("i,bik,k->b", scaled, inverses, scaled).max()))
    # entries of inverses are rounded by less than MARGIN of their norm
    W = W + MARGIN * np.trace(W)
    return OnGrid(np.asarray((W * both)[..., None]), squared + MARGIN * float(np.trace(W) * (scaled**2).sum()))


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


def _curvatures(values: Array, axes: Sequence[Axis]) -> list[Array]:
    """G_j of each axis, from the matrices at the nodes of all axes."""
    for j, axis in enumerate(axes):
        values = np.moveaxis(np.tensordot(axis.from_values, values, axes=(1, j)), 0, j)
    eigenvalues, V = np.linalg.eigh(values)
    magnitudes = (V * np.abs(eigenvalues)[..., None, :]) @ np.swapaxes(V, -1, -2)
    found = []
    for j, axis in enumerate(axes):
        sums = magnitudes.sum(axis=tuple(k for k in range(len(axes)) if k != j))
        found.append(np.tensordot(_second_derivatives(axis), sums, axes=1) * OUTWARDS)
    return found


def _second_derivatives(axis: Axis) -> Array:
    """The largest second derivatives of the functions of a basis: of cos(k x), and of Chebyshev polynomials."""
    k = np.array(axis.orders, dtype=float)
    return k**2 if axis.kind == TURN else k**2 * (k**2 - 1) / 3 / (axis.half or 1.0) ** 2


def _steps(axes: Sequence[Axis], box: Box, curved: Sequence[float], most: int) -> tuple[list[float], dict[str, Array]]:
    """Steps and points of a grid over the box: each time more points along the axis that loses most."""
    widths = [(x := box.ranges[axis.name]).high - x.low for axis in axes]
    counts = [2] * len(axes)
    while axes:
        losses = [(w / (n - 1)) ** 2 * G / 8 for w, n, G in zip(widths, counts, curved, strict=True)]
        worst = int(np.argmax(losses))
        more = [n + (n // 8 + 1) * (j == worst) for j, n in enumerate(counts)]
        if sum(losses) < SMALL_STEPS or math.prod(more) > most:
            break
        counts = more
    points = {axis.name: _between(box.ranges[axis.name], n) for axis, n in zip(axes, counts, strict=True)}
    return [w / (n - 1) * OUTWARDS for w, n in zip(widths, counts, strict=True)], points


def _between(ends: Range, count: int) -> Array:
    return np.asarray(np.linspace(ends.low, ends.high, count))


def _slabs(points: Mapping[str, Array]) -> Iterator[Mapping[str, Array]]:
    """Parts of a grid, along its longest axis."""
    if not points:
        yield points
        return
    longest = max(points, key=lambda name: len(points[name]))
    step = max(1, AT_ONCE * len(points[longest]) // math.prod(map(len, points.values())))
    for start in range(0, len(points[longest]), step):
        yield {**points, longest: points[longest][start : start + step]}


def _rounding(entries: Sequence[Operand], box: Box, both: Array) -> float:
    """At least the errors of matrices that are computed in double precision, as a norm."""
    nodes = reachable(entries)
    used = [str(node.operands[0]) for node in nodes if node.operation == SYMBOL]
    bounds = running_errors(nodes, box.of(used).whole, ROUNDINGS["double"])
    errors = np.array([float(np.max(bounds.error_of(x))) for x in entries]).reshape(both.shape)
    return float(np.linalg.norm(errors * both)) * OUTWARDS
