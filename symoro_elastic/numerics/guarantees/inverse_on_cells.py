"""Bounds of the entries of the inverse of a matrix of polynomials, over cells of a box of positions.

With any C and G >= |1 - C A|, A^-1 = C + (1 - C A) A^-1 has |A^-1| <= |C| + G |A^-1|. Hence

    W > 0,   W - G W >= |C|        proves that A is regular, and |A^-1| <= W

for 1 - G is an M-matrix then, whose inverse has no entry below zero; likewise y - G y >= |C d| that |A^-1 d| <= y.

**Cells.** Let A(q) be a matrix of polynomials, and C near its inverse in the middle m of a cell with half widths h_j.
Along each axis A is its value at m and a sum of functions that are at most b in the cell: for turns sin k(q - m) with
b = sin(k h), and cos k(q - m) - 1 with b = 1 - cos(k h), for slides ((q - m)/h)^k with b = 1. With A_S the coefficients
of products of such functions, other axes being at m,

    |1 - C A| <= |1 - C A(m)| + sum b |C A_S|  (one function)  +  |C| sum b b' |A_S|  (two)  +  |C| R  (more)

Signs of what moves with one angle count, so the determinant does; wrist angles may have wide cells. R is the same in
all cells: sum |c_k| times products of three or more of the most by which functions of the basis differ from those at m.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.polynomial import chebyshev

from symoro_elastic.foundation.array_types import Array, IndexArray
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.axes import TURN, Axis
from symoro_elastic.numerics.guarantees.intervals import Interval

SLACK = 1e-6
"""Relative margin of W, against the rounding of its inequality."""
ROUNDING = 1e-12
AT_ONCE = 4000
"""Cells that are evaluated together."""
SAMPLED, WORST = 3, 48
"""Sampled positions along an axis, and worst cells among them, from which numbers of cells are chosen."""
SMALL = 0.3
"""Spectral radius of G below which cells are not divided further."""


def verified_bounds(C: Array, G: Array, right: Array) -> Array:
    """W (.., n, m) with W - G W >= |right|, for matrices (.., n, n); infinite where none is found."""
    bounds = np.full_like(right, np.inf)
    able = np.flatnonzero(np.isfinite(G).all(axis=(1, 2)) & np.isfinite(C).all(axis=(1, 2)))
    able = able[np.abs(np.linalg.eigvals(G[able])).max(axis=1, initial=0.0) < 1 - SLACK]
    G, right = G[able], np.abs(right[able])
    more = right * (1 + SLACK) + SLACK * right.max(axis=(1, 2), keepdims=True, initial=0.0)
    W = np.linalg.solve(np.eye(G.shape[-1]) - G, more)
    residual = W - G @ W * (1 + ROUNDING)
    proven = np.min((W > 0) & (residual >= right * (1 + ROUNDING)), axis=(1, 2))
    bounds[able[proven]] = W[proven]
    return bounds


def near_inverses(matrices: Array, least: float = 0.0) -> Array:
    """Approximate inverses of matrices (.., n, n); infinite where an eigenvalue is not above `least`."""
    inverses = np.full_like(matrices, np.inf)
    able = np.flatnonzero(np.isfinite(matrices).all(axis=(1, 2)))
    able = able[np.linalg.eigvalsh(matrices[able])[:, 0] > least]
    inverses[able] = np.linalg.inv(matrices[able])
    return inverses


Product: TypeAlias = tuple[tuple[int, int], ...]
"""A product of functions of a cell, by axis and number; empty: 1."""
Products: TypeAlias = Mapping[Product, Array]
"""Coefficients (cells, n, n) by product."""


@dataclass(frozen=True)
class _Parts:
    """Matrices by cell: approximate inverses C, |C A_S| for single functions S, |A_S| for products S of two."""

    C: Array
    ones: Products
    twos: Products

    def select(self, cells: IndexArray) -> _Parts:
        """The matrices of some cells."""
        ones, twos = ({key: x[cells] for key, x in of.items()} for of in (self.ones, self.twos))
        return _Parts(self.C[cells], ones, twos)


@dataclass(frozen=True)
class Cells:
    """A matrix of polynomials by its coefficients (functions of each axis, n, n), and a box of positions.

    `off` bounds the errors of its entries, which are at most 1.
    """

    coefficients: Array
    axes: Sequence[Axis]
    box: Sequence[Range]
    off: float

    @classmethod
    def of(cls, at_nodes: Array, axes: Sequence[Axis], box: Sequence[Range], off: float) -> Cells:
        """The cells of a matrix given by its values at the nodes of all axes."""
        values = at_nodes
        for j, axis in enumerate(axes):
            values = np.moveaxis(np.tensordot(axis.from_values, values, axes=(1, j)), 0, j)
        return cls(values, axes, box, off)

    def bounds(self, most: int, d: Array) -> Array | None:
        """Bounds of |A^-1| and, in the last column, of |A^-1 d|, with at most `most` cells; None without proof."""
        counts = self._counts(most)
        if counts is None:
            return None
        halves = self._halves(counts)
        middles = [self._middles(j, h, n) for j, (h, n) in enumerate(zip(halves, counts, strict=True))]
        largest = np.zeros((len(d), len(d) + 1))
        for part in _slabs(middles):
            parts = self._parts(part)
            right = np.concatenate([parts.C, (parts.C @ d)[..., None]], axis=2)
            W = verified_bounds(parts.C, self._G(parts, halves), right)
            if not np.isfinite(W).all():
                return None
            largest = np.maximum(largest, W.max(axis=0))
        return largest

    def _middles(self, j: int, half: float, count: int) -> Array:
        return np.asarray(self.box[j].low + (2 * np.arange(count) + 1) * half, dtype=float)

    def _halves(self, counts: Sequence[int]) -> list[float]:
        return [(x.high - x.low) / 2 / n * (1 + ROUNDING) for x, n in zip(self.box, counts, strict=True)]

    def _counts(self, most: int) -> Sequence[int] | None:
        """Numbers of cells by axis, increased along the axis along which G falls most; None where G stays large."""
        part = (np.arange(SAMPLED) + 0.5) / SAMPLED
        parts = self._parts([x.low + (x.high - x.low) * part for x in self.box])
        parts = parts.select(np.argsort(np.abs(parts.C).max(axis=(1, 2)))[-WORST:])

        def radius(counts: Sequence[int]) -> float:
            G = self._G(parts, self._halves(counts))
            return float(np.abs(np.linalg.eigvals(G)).max()) if np.isfinite(G).all() else math.inf

        counts = [1] * len(self.axes)
        best = radius(counts)
        while counts and SMALL < best < math.inf:
            more = [[n + (n // 2 + 1) * (i == j) for i, n in enumerate(counts)] for j in range(len(counts))]
            radii = [radius(candidate) for candidate in more]
            gains = [
                math.log(best / r) / math.log(new[j] / counts[j])
                for j, (r, new) in enumerate(zip(radii, more, strict=True))
            ]
            j = int(np.argmax(gains))
            if math.prod(more[j]) > most:
                break
            counts, best = more[j], radii[j]
        return counts if best < 1 else None

    def _parts(self, middles: Sequence[Array]) -> _Parts:
        size = self.coefficients.shape[-1]
        local = [_local(axis, x) for axis, x in zip(self.axes, middles, strict=True)]
        by_product = {key: x.reshape(-1, size, size) for key, x in _products(self.coefficients, local)}
        C = near_inverses(by_product[()])
        ones: dict[Product, Array] = {key: np.abs(C @ x) for key, x in by_product.items() if len(key) == 1}
        ones[()] = np.abs(np.eye(size) - C @ by_product[()]) + self.off * np.abs(C).sum(axis=2, keepdims=True)
        return _Parts(C, ones, {key: np.abs(x) for key, x in by_product.items() if len(key) == 2})

    def _G(self, parts: _Parts, halves: Sequence[float]) -> Array:
        """A bound of |1 - C A| in cells with the given half widths."""
        b = [_largest(axis, h) for axis, h in zip(self.axes, halves, strict=True)]

        def weighted_sum(of: Products) -> Array:
            return sum((math.prod(b[j][k] for j, k in key) * x for key, x in of.items()), np.zeros_like(parts.C))

        G: Array = weighted_sum(parts.ones) + np.abs(parts.C) @ (weighted_sum(parts.twos) + self._of_more(halves))
        more: Array = ROUNDING * np.abs(parts.C).sum(axis=2, keepdims=True)
        return G * (1 + ROUNDING) + more

    def _of_more(self, halves: Sequence[float]) -> Array:
        """Bound R of the contribution of products of three or more functions, in any cell."""
        orders = [np.asarray(x) for x in (1.0, 0.0, 0.0, 0.0)]
        for j, (axis, h) in enumerate(zip(self.axes, halves, strict=True)):
            change = _change(axis, h).reshape([-1 if i == j else 1 for i in range(len(self.axes))])
            none, one, two, more = orders
            orders = [none, one + none * change, two + one * change, more * (1 + change) + two * change]
        axes = tuple(range(len(self.axes)))
        return np.asarray((np.abs(self.coefficients) * orders[3][..., None, None]).sum(axis=axes))


def _products(values: Array, local: Sequence[Array]) -> Iterator[tuple[Product, Array]]:
    """Yield products of up to two functions of a cell, each with its coefficients in all cells (cells, entries)."""
    coefficients: list[tuple[Product, Array]] = [((), values.reshape(1, -1))]
    for j, functions in enumerate(local):
        coefficients = [
            (key + ((j, k),) * (k > 0), np.matmul(functions[:, k], rows).reshape(len(rows) * len(functions), -1))
            for key, x in coefficients
            for rows in [x.reshape(len(x), functions.shape[2], -1)]
            for k in range(functions.shape[1] if len(key) < 2 else 1)
        ]
    yield from coefficients


def _local(axis: Axis, middles: Array) -> Array:
    """Functions of a basis in terms of 1 and the functions of a cell: (points, functions of the cell, of the basis).

    For slides ((q - m)/half)^k: the width of the cell is a factor in `_largest`.
    """
    if axis.kind != TURN:
        y = (middles - axis.middle) / axis.half
        basis = np.eye(axis.degree + 1)
        parts = [chebyshev.chebval(y, chebyshev.chebder(basis, k)) / math.factorial(k) for k in range(axis.degree + 1)]
        return np.moveaxis(np.array(parts), -1, 0)
    orders = np.array(axis.orders)
    is_sine = np.arange(len(orders)) > axis.degree
    phase = orders * middles[:, None] - np.where(is_sine, np.pi / 2, 0.0)
    parts = [np.cos(phase)]
    for k in range(1, axis.degree + 1):
        parts += [np.where(orders == k, -np.sin(phase), 0.0), np.where(orders == k, np.cos(phase), 0.0)]
    return np.stack(parts, axis=1)


def _largest(axis: Axis, half: float) -> list[float]:
    """Largest magnitudes in a cell about its middle: of powers, or (full turns) of sin k x and 1 - cos k x."""
    if axis.kind != TURN:
        return [(half / axis.half) ** k for k in range(axis.degree + 1)]
    bounds = [1.0]
    for k in range(1, axis.degree + 1):
        bounds += [math.sin(min(k * half, math.pi / 2)), 1 - math.cos(min(k * half, math.pi))]
    return bounds


def _change(axis: Axis, half: float) -> Array:
    """The largest change of the functions of the basis from the middle of a cell."""
    k = np.array(axis.orders, dtype=float)
    if axis.kind != TURN:
        return np.minimum(2.0, k**2 * half / axis.half)
    return np.asarray(2 * np.sin(np.minimum(k * half, math.pi) / 2))


def _slabs(points: Sequence[Array]) -> Iterator[Sequence[Array]]:
    """Parts of a grid along its longest axis, of at most `AT_ONCE` points."""
    if not points:
        yield points
        return
    j = max(range(len(points)), key=lambda k: len(points[k]))
    step = max(1, AT_ONCE * len(points[j]) // math.prod(map(len, points)))
    for start in range(0, len(points[j]), step):
        yield [*points[:j], points[j][start : start + step], *points[j + 1 :]]


def largest_solutions(A: Interval, e: Array) -> Array:
    """A bound of |x_i| for all A x = d with |d| <= e, by sub-box (n, sub-boxes); infinite where nothing is proven.

    `A` (n, n, sub-boxes) holds the matrix, `e` (n,) the bounds of the right side.
    """
    low, high = (np.moveaxis(end, -1, 0) for end in A)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        radius = np.maximum(high - middle, middle - low) * (1 + ROUNDING)
        diagonal = np.einsum("bii->bi", middle)
        by_diagonal = np.where(diagonal > 0, 1 / diagonal, np.inf)[..., None] * np.eye(len(e))
        bounds = [_solution_bounds(C, middle, radius, e) for C in (by_diagonal, near_inverses(middle))]
    return np.asarray(np.minimum(*bounds).T)


def widened(A: Interval, by: Array) -> Interval:
    """The interval matrix A extended by `by` (n, n) in its entries."""
    more = by[..., None] * (1 + ROUNDING)
    return Interval(np.nextafter(A.low - more, -np.inf), np.nextafter(A.high + more, np.inf))


def allowed_right_sides(A: Interval, most: Array) -> Array:
    """The largest right sides e (n,) for which the |x_i| of A x = d, |d| <= e, stay below `most`.

    Zero where nothing is proven. The components of x get equal shares of their bounds.
    """
    unit = np.array([largest_solutions(A, column).max(axis=1) for column in np.eye(len(most))]).T
    if not np.isfinite(unit).all():
        return np.zeros(len(most))
    share = most / unit.sum(axis=1)
    return np.asarray(share * float((most / largest_solutions(A, share).max(axis=1)).min()) * (1 - SLACK))


def _solution_bounds(C: Array, middle: Array, radius: Array, e: Array) -> Array:
    """Return bounds (sub-boxes, n) of |x| for A x = d, |d| <= e, A = middle +- radius; infinite where not proven."""
    magnitude = np.abs(C)
    G = (np.abs(np.eye(len(e)) - C @ middle) + magnitude @ radius) * (1 + ROUNDING)
    G += ROUNDING * magnitude @ np.abs(middle)
    if not e.any():
        return np.where(np.isfinite(G).all(axis=2), 0.0, np.inf)
    return verified_bounds(C, G, (magnitude @ e * (1 + ROUNDING))[..., None])[..., 0]
