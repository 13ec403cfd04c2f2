"""Proven largest values of results over a box, and of the differences between two programs (lemma 4, `axes.py`).

**A surface** is the polynomial made small: coefficients of its motion in a basis of its positions. The values at the
nodes of all axes determine it (degrees by syntax). Of its coefficients, those of orders that hardly occur are left out:
functions of the basis are at most 1, so the dropped part is at most the sum of the magnitudes of their coefficients,
the *tail*. This finds the true degrees at no cost: syntax counts terms that cancel. Rounding: the polynomial of the
computed coefficients differs from the values at the nodes by the errors of the values and the computed residual,
which interpolation amplifies at most by the product of `Axis.amplification`.

**The motion**, exactly in the signs: f = g + sum a_k s_k + sum c_kl s_k s_l + ..., all s in [-1, 1]. Variables that
occur alone only (accelerations) take either sign freely: sum |a_k|. For the others, f without squares is linear in
each, so its largest value is at a corner of signs. A square c s^2 adds at most max(c, 0) to f, and max(-c, 0) to -f.
All else adds |c|. *Lemma.* The bound is, at each position, the largest of a family of fixed linear combinations of the
coefficients, with factors of at most 1, and their negatives: lemma 4 holds for it.

**Positions**, by branch and bound: some axes are cut into cells, the others have a grid in each cell. Where the largest
value is reached lies in some cell, of half widths d_j. With its middle c, N_j points and orders m_j:

    largest value <= (largest over the grid at c) . product of 1/cos(pi m_j/N_j) . 1/cos(sum m_j d_j)

so the largest right side over all cells is a bound. The cell that has it gets a finer grid, or is halved along all
axes. The search may stop at any time. Cells with lower bounds are not refined.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.numerics.guarantees.axes import UNIT, Axis, axis_of
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.polynomials import (
    Degrees,
    Monomial,
    NotPolynomial,
    Polynomial,
    degrees_of,
    polynomials,
    separate_sides,
    variable,
)
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Operand

Target: TypeAlias = "Operand | tuple[Operand, Operand]"
"""An expression, or a pair of expressions (of the same or different graphs) whose difference is the target."""

POINTS_AT_ONCE = 20_000
MOST_NODES = 1_000_000
LEAST_SHARE = 0.002
"""Orders are dropped while the tails of axes are at most this fraction of the largest value at the nodes."""
MOST_SIGNED = 9
AT_ONCE = 2048
OUTWARDS = 1 + 1e-12
FEWEST_CELLS = 8
"""Cells over the order of the polynomial, along an axis: 1/cos of pi over it is what a cell loses, by one axis."""
CLOSENESS = 1.05
RATIOS = (8, 12, 16, 24, 48, 96)
"""Points of grids over the order of the polynomial, from coarse to fine: factors of 1.08 to 1.0005 an axis."""
MOST_POINTS = 150_000
WORK = 5e8
"""Work (values of coefficients on grids) for the range of an entry: about a second."""
LEAST_WORK = 1e5
"""Least work that a grid counts."""
SINGLE_UNIT = 2.0**-24


@dataclass(frozen=True)
class Surface:
    """A polynomial's coefficients by product of s and by basis function of each axis; `left_out` bounds the rest.

    `orders` are those of the axes, without those left out. `motion` are the variables of the motion, by number of s.
    """

    axes: tuple[Axis, ...]
    orders: tuple[int, ...]
    monomials: tuple[Monomial, ...]
    coefficients: Array
    left_out: float
    motion: tuple[str, ...]


def parts(target: Target) -> list[Operand]:
    """Return the expressions of a target."""
    return list(target) if isinstance(target, tuple) else [target]


def axes_of(degrees: Degrees, box: Box) -> tuple[Axis, ...]:
    """Return the axes of angles, then of other variables that are positions."""
    angles = [axis_of(name, n, box.ranges[name], angle=True) for name, n in sorted(degrees.angles.items())]
    slides = [(name, n) for name, n in sorted(degrees.powers.items()) if name in box.positions]
    return (*angles, *(axis_of(name, n, box.ranges[name], angle=False) for name, n in slides))


def surface(target: Target, box: Box) -> Surface:
    """Return a target as a surface over a box; raises `NotPolynomial`."""
    roots, box = separate_sides(parts(target), box)
    degrees = degrees_of(roots, box)
    axes = axes_of(degrees, box)
    if (points := math.prod(len(axis.nodes) for axis in axes)) > MOST_NODES:
        raise NotPolynomial(f"{points} positions determine it: {MOST_NODES} are the most")
    names = {axis.name for axis in axes}
    motion = tuple(name for name in sorted(degrees.powers) if name not in names)
    values, error = _at_nodes(roots, box, axes, motion)
    monomials = tuple(values)
    if not monomials:
        return Surface(axes, (0,) * len(axes), ((),), np.zeros((1, *(1 for _ in axes))), 0.0, motion)
    stacked = np.stack([values[key] for key in monomials])
    coefficients = _transform(stacked, [axis.from_values for axis in axes])
    missing = _missing(stacked, coefficients, axes, error)
    remaining, orders, tail = _truncate(coefficients, axes, float(np.abs(stacked).sum(axis=0).max()))
    return Surface(axes, orders, monomials, remaining, (missing + tail) * (1 + 1e-12), motion)


def _at_nodes(
    roots: Sequence[Operand], box: Box, axes: Sequence[Axis], motion: Sequence[str]
) -> tuple[dict[Monomial, Array], float]:
    """Return the coefficients of the motion at the nodes of all axes, and a bound of their errors."""
    shape = tuple(len(axis.nodes) for axis in axes)
    values: dict[Monomial, Array] = {}
    error = 0.0
    moving = {name: variable(k, box.ranges[name]) for k, name in enumerate(motion)}
    for part, points in _slabs(axes, shape):
        polynomial, *subtracted = (polynomials([root], moving | points, box.numbers)[0] for root in roots)
        polynomial = polynomial - subtracted[0] if subtracted else polynomial
        error = max(error, polynomial.error)
        for key, x in polynomial.terms.items():
            values.setdefault(key, np.zeros(shape))[part] = x
    return values, error


def _slabs(
    axes: Sequence[Axis], shape: Sequence[int]
) -> Iterator[tuple[slice | tuple[slice, ...], dict[str, Polynomial]]]:
    """Yield parts of the grid of nodes along the first axis, with their positions as polynomials."""
    if not axes:
        yield (), {}
        return
    step = max(1, POINTS_AT_ONCE // max(1, math.prod(shape[1:])))
    for start in range(0, shape[0], step):
        points = {}
        for j, axis in enumerate(axes):
            nodes = axis.nodes[start : start + step] if j == 0 else axis.nodes
            values = nodes.reshape([-1 if k == j else 1 for k in range(len(axes))])
            points[axis.name] = Polynomial({(): values}, float(np.abs(nodes).max()), 0)
        yield slice(start, start + step), points


def _transform(values: Array, matrices: Sequence[Array]) -> Array:
    """Return values with a matrix applied along each axis but the first."""
    for j, matrix in enumerate(matrices, start=1):
        values = np.moveaxis(np.tensordot(values, matrix, axes=(j, 1)), -1, j)
    return values


def _missing(values: Array, coefficients: Array, axes: Sequence[Axis], error: float) -> float:
    """Return a bound of interpolation and rounding errors of coefficients, summed over products of the motion."""
    back = _transform(coefficients, [axis.at_nodes for axis in axes])
    sums = np.abs(coefficients).reshape(len(values), -1).sum(axis=1)
    rounding = sum(axis.basis_error + 4 * len(axis.orders) * UNIT for axis in axes) * 2
    residual = np.abs(values - back).reshape(len(values), -1).max(axis=1)
    return float((error + residual + rounding * sums).sum()) * math.prod(axis.amplification for axis in axes)


def _truncate(coefficients: Array, axes: Sequence[Axis], scale: float) -> tuple[Array, tuple[int, ...], float]:
    """Return the coefficients without negligible orders, the remaining orders, and the tail."""
    tail, orders = 0.0, []
    for j, axis in enumerate(axes, start=1):
        sums = np.abs(coefficients).sum(axis=tuple(k for k in range(coefficients.ndim) if k != j))
        axis_orders = np.array(axis.orders)
        order = next(m for m in sorted(set(axis.orders)) if sums[axis_orders > m].sum() <= LEAST_SHARE * scale)
        tail += float(sums[axis_orders > order].sum())
        coefficients = np.compress(axis_orders <= order, coefficients, axis=j)
        orders.append(order)
    return coefficients, tuple(orders), tail


@dataclass(frozen=True)
class Signs:
    """Rows of coefficients by how their sum is maximized over s: free signs, signs of corners, squares, the constant.

    `corners` are the values of the `signed` rows at the corners, without opposite corners where all products are even;
    `at` are the corners, (corners, variables).
    """

    free: Array
    signed: Array
    squares: Array
    constant: Array
    corners: AnyArray
    at: Array
    variables: tuple[int, ...]

    def simple(self, values: AnyArray) -> AnyArray:
        """Return sums of magnitudes of coefficients by position: fast upper bounds of `largest`."""
        sums, ones = np.empty(values.shape[1], values.dtype), np.ones(len(values), values.dtype)
        for start in range(0, len(sums), AT_ONCE):
            part = slice(start, start + AT_ONCE)
            np.matmul(ones, np.abs(values[:, part]), out=sums[part])
        return sums

    def largest(self, values: AnyArray) -> AnyArray:
        """Return the largest |f| at each position, for coefficients (rows, positions)."""
        free = np.abs(values[self.free]).sum(axis=0)
        constant = values[self.constant].sum(axis=0)
        squares = values[self.squares]
        mixed = self.corners @ values[self.signed] if len(self.signed) else np.zeros((1, values.shape[1]), values.dtype)
        above = constant + mixed.max(axis=0) + np.maximum(squares, 0).sum(axis=0)
        below = -constant - mixed.min(axis=0) + np.maximum(-squares, 0).sum(axis=0)
        return np.asarray(free + np.maximum(above, below))

    def above(self, values: AnyArray, least: float) -> tuple[float, int]:
        """Return the largest value above `least` and its position; `least` and -1 without one."""
        simple = self.simple(values)
        candidates = np.flatnonzero(simple > least)
        candidates = candidates[np.argsort(-simple[candidates])]
        best, where = least, -1
        for start in range(0, len(candidates), AT_ONCE):
            chunk = candidates[start : start + AT_ONCE]
            if simple[chunk[0]] <= best:
                break
            exact = self.largest(values[:, chunk])
            k = int(exact.argmax())
            if exact[k] > best:
                best, where = float(exact[k]), int(chunk[k])
        return best, where

    def worst(self, values: Array, monomials: Sequence[Monomial], motion: int) -> Array:
        """Return the values s of the variables of the motion at which |f| is (nearly) largest, at a given position."""
        largest, worst = -1.0, np.ones(motion)
        mixed = self.corners @ values[self.signed] if len(self.signed) else np.zeros(1)
        constant = float(values[self.constant].sum())
        for sense in (1.0, -1.0):
            s = np.ones(motion)
            s[list(self.variables)] = self.at[int((sense * mixed).argmax())]
            for row in self.free:
                if len(monomials[row]) == 1:
                    s[monomials[row][0]] = sense if values[row] >= 0 else -sense
            total = abs(constant + sum(values[k] * np.prod(s[list(m)]) for k, m in enumerate(monomials) if m))
            if total > largest:
                largest, worst = float(total), s
        return worst


def signs_of(monomials: Sequence[Monomial]) -> Signs:
    """Return the summation of coefficients of products."""
    together = Counter(k for m in monomials if len(m) > 1 for k in set(m))
    variables = tuple(sorted(together)) if len(together) <= MOST_SIGNED else ()
    rows: dict[str, list[int]] = {"free": [], "signed": [], "squares": [], "constant": []}
    for row, m in enumerate(monomials):
        rows[_kind(m, variables)].append(row)
    signed = [monomials[row] for row in rows["signed"]]
    even = all(len(m) % 2 == 0 for m in signed)
    first = [(1.0,)] if even and variables else []
    choices = [*first, *([(1.0, -1.0)] * (len(variables) - len(first)))]
    corners_of = list(itertools.product(*choices))
    at = np.array(corners_of, dtype=np.float64).reshape(len(corners_of), len(variables))
    place = {k: j for j, k in enumerate(variables)}
    columns = [np.prod(at[:, [place[k] for k in m]], axis=1) for m in signed]
    corners = np.stack(columns, axis=1).astype(np.float32) if columns else np.zeros((len(at), 0), np.float32)
    indices = {name: np.array(numbers, dtype=np.intp) for name, numbers in rows.items()}
    return Signs(**indices, corners=corners, at=at, variables=variables)  # type: ignore[arg-type]


def _kind(m: Monomial, variables: Sequence[int]) -> str:
    if not m:
        return "constant"
    if any(k not in variables for k in m):
        return "free"
    if len(set(m)) == len(m):
        return "signed"
    return "squares" if len(m) == 2 else "free"


class Cell(NamedTuple):
    """A cell: minus its bound (for a heap), a number, its middle in phi, number of cuts, and its grid.

    `grid` is the number of the grid in `_Search.factors`, -1 before any.
    """

    minus: float
    number: int
    middle: tuple[float, ...]
    cuts: int
    grid: int


@dataclass(frozen=True)
class Largest:
    """A proven bound of |f| over a box, the largest |f| found, its state, and whether the bound is close enough.

    `bound` is infinite, and `reason` says why, where f is not a polynomial.
    """

    bound: float
    found: float
    state: Mapping[str, float] = field(default_factory=dict)
    finished: bool = True
    reason: str = ""


def largest(target: Target, box: Box, *, closeness: float = CLOSENESS, work: float = math.inf) -> Largest:
    """Return a bound of the largest |f| over a box; positions of the box that are not angles are slides.

    The search ends when the bound is at most `closeness` times a value that is reached, apart from the dropped part of
    the surface, or after so much `work` (values of coefficients on grids, which is independent of the computer), with
    the bound proven by then. All other variables belong to the motion. A variable inside and outside of sines counts as
    two variables (`polynomials.py`).
    """
    try:
        polynomial = surface(target, box)
    except NotPolynomial as error:
        return Largest(math.inf, 0.0, finished=False, reason=str(error))
    search = _Search(polynomial)
    for _ in search.steps(closeness):
        if search.work > work:
            break
    state = search.state(box)
    close = search.upper <= closeness * search.lower
    bound = (search.upper * search.scale + polynomial.left_out) * OUTWARDS
    return Largest(bound, value_at(target, state, box), state, close)


def value_at(target: Target, state: Mapping[str, float], box: Box) -> float:
    """Return |f| at a state, in double precision."""
    symbols = {**box.numbers, **state}
    values = [evaluate([x], symbols, FLOATS)(x) for x in parts(target)]
    return abs(values[0] - values[1] if len(values) == 2 else values[0])


class _Search:
    """Branch and bound: cells of some axes, worst first, and grids of the others, ever finer, in single precision.

    Values are over `scale`; `place` is where the largest of them, `lower`, is reached.
    """

    def __init__(self, surface: Surface) -> None:
        self.surface, self.signs, self.work = surface, signs_of(surface.monomials), 0.0
        self.scale = float(np.abs(surface.coefficients).max()) or 1.0
        points = {j: 24 * m // (1 + surface.axes[j].is_even) + 1 for j, m in enumerate(surface.orders) if m}
        order = sorted(points, key=lambda j: -points[j])
        cut = next(k for k in range(len(order) + 1) if math.prod(points[j] for j in order[k:]) <= MOST_POINTS)
        self.cut, self.gridded = order[:cut], order[cut:]
        self.coefficients = self._arrange(surface.coefficients / self.scale)
        grids = [[self.surface.axes[j].grid(ratio, self.surface.orders[j]) for j in self.gridded] for ratio in RATIOS]
        self.grids = [grid for k, grid in enumerate(grids) if k == 0 or math.prod(map(len, grid)) <= MOST_POINTS]
        pairs = [zip(self.gridded, grid, strict=True) for grid in self.grids]
        self.bases = [[self._basis(j, phi).astype(np.float32) for j, phi in pair] for pair in pairs]
        self.place: tuple[tuple[float, ...], int, int] = ((), 0, 0)
        total = float(np.abs(surface.coefficients).sum()) / self.scale * OUTWARDS
        self.rounding = self._rounding(total)
        power = -len(self.gridded)
        self.factors = [OUTWARDS * math.cos(math.pi / ratio) ** power for ratio in RATIOS[: len(self.grids)]]
        self.orders = [surface.orders[j] for j in self.cut]
        self.least = max(FEWEST_CELLS, 3 * len(self.cut))
        self.lower = 0.0
        self._numbers = itertools.count()
        cells = (surface.axes[j].cells(2 * (self.least * surface.orders[j] // 2)) for j in self.cut)
        middles = itertools.product(*cells)
        self.cells = [Cell(-total, next(self._numbers), tuple(map(float, middle)), 0, -1) for middle in middles]
        heapq.heapify(self.cells)

    @property
    def upper(self) -> float:
        """A bound of the largest value."""
        return -self.cells[0].minus * OUTWARDS

    def steps(self, closeness: float) -> Iterator[float]:
        """Improve the bound cell by cell until it is at most `closeness` times `lower`; yields the bound."""
        while self.upper > closeness * self.lower:
            cell = self.cells[0]
            finer = cell.grid + 1 < len(self.factors)
            if not finer and not self.cut:
                return
            heapq.heappop(self.cells)
            if finer and (cell.grid < 0 or self.factors[cell.grid] >= self._loss(cell.cuts)):
                self._push(cell.middle, cell.cuts, cell.grid + 1, -cell.minus)
            else:
                for middle in self._halves(cell):
                    self._push(middle, cell.cuts + 1, 0, -cell.minus)
            yield self.upper

    def _push(self, middle: tuple[float, ...], cuts: int, grid: int, before: float) -> None:
        factor = self.factors[grid] * self._loss(cuts)
        bound = factor * self.value(middle, grid, self.lower / factor)
        heapq.heappush(self.cells, Cell(-min(bound, before), next(self._numbers), middle, cuts, grid))

    def _loss(self, cuts: int) -> float:
        """Factor 1/cos(sum of orders times half widths) from values at the middle of a cell to a bound in the cell."""
        return OUTWARDS / math.cos(sum(m * half for m, half in zip(self.orders, self._widths(cuts), strict=True)))

    def _widths(self, cuts: int) -> list[float]:
        return [math.pi / (2 * (self.least * m // 2) * 2**cuts) for m in self.orders]

    def _halves(self, cell: Cell) -> Iterator[tuple[float, ...]]:
        widths = self._widths(cell.cuts + 1)
        for signs in itertools.product((-1, 1), repeat=len(self.cut)):
            yield tuple(x + s * half for x, s, half in zip(cell.middle, signs, widths, strict=True))

    def value(self, middle: tuple[float, ...], grid: int, least: float) -> float:
        """Return the largest value over a grid in a cell, with its rounding, or `least` if that is larger."""
        values = self._in_cell(middle)
        for basis in reversed(self.bases[grid]):
            values = np.matmul(basis, values)
            values = values.reshape(*values.shape[:-2], -1)
        self.work += values.size + LEAST_WORK
        best, where = self.signs.above(values.reshape(len(values), -1), least)
        if where >= 0 and best > self.lower:
            self.lower, self.place = best, (middle, grid, where)
        return best + self.rounding

    def state(self, box: Box) -> dict[str, float]:
        """Return the state at which `lower` is reached, variables without influence at the middle of their ranges."""
        middle, grid, where = self.place
        surface = self.surface
        phases = dict(zip(self.cut, middle or [0.0] * len(self.cut), strict=True))
        indices = np.unravel_index(where, [len(phi) for phi in self.grids[grid]]) if self.gridded else ()
        phases |= {j: phi[k] for j, phi, k in zip(self.gridded, self.grids[grid], indices, strict=True)}
        positions = {axis.name: axis.middle for axis in surface.axes}
        positions |= {
            surface.axes[j].name: float(surface.axes[j].positions(np.array(phi))) for j, phi in phases.items()
        }
        values = surface.coefficients
        for j in reversed(range(len(surface.axes))):
            values = values @ self._basis(j, np.array(phases.get(j, 0.0)))
        s = self.signs.worst(values, surface.monomials, len(surface.motion))
        motion = [(box.ranges[name], name, k) for name, k in zip(surface.motion, s, strict=True) if name in box.ranges]
        return positions | {name: x.low + (x.high - x.low) * (1 + k) / 2 for x, name, k in motion}

    def _arrange(self, coefficients: Array) -> AnyArray:
        """Return coefficients with axes in the order: cells, motion, grids, and an axis of length 1."""
        searched = [*self.cut, *self.gridded]
        others = [j for j in range(len(self.surface.axes)) if j not in searched]
        order = [*(j + 1 for j in self.cut), 0, *(j + 1 for j in (*self.gridded, *others))]
        moved = coefficients.transpose(order)
        return np.ascontiguousarray(moved.reshape(*moved.shape[: 1 + len(searched)], 1), dtype=np.float32)

    def _basis(self, j: int, phi: AnyArray) -> Array:
        """Return the basis functions of an axis up to the order of the surface."""
        axis = self.surface.axes[j]
        return np.compress(np.array(axis.orders) <= self.surface.orders[j], axis.basis(phi), axis=-1)

    def _in_cell(self, middle: Sequence[float]) -> AnyArray:
        """Return the coefficients of the grid's axes at the middle of a cell."""
        values = self.coefficients
        for j, phi in zip(self.cut, middle, strict=True):
            basis = self._basis(j, np.array(phi)).astype(np.float32)
            values = (basis @ values.reshape(len(values), -1)).reshape(values.shape[1:])
        return values

    def _rounding(self, total: float) -> float:
        """Bound of the rounding error of values: products and sums in single precision, functions of the basis."""
        sizes = sum(len(self.surface.axes[j].orders) + 2 for j in (*self.cut, *self.gridded))
        steps = sizes + 2 * len(self.surface.monomials) + 16
        basis = sum(axis.basis_error for axis in self.surface.axes)
        return (steps * SINGLE_UNIT * (1 + 1e-3) + 2 * basis) * total
