"""Proven largest values of results over a box, and of the differences between two programs (lemma 4, `axes.py`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.cells import OUTWARDS, Search
from symoro_elastic.numerics.guarantees.degrees import NotPolynomial
from symoro_elastic.numerics.guarantees.motion_extremes import signs_of
from symoro_elastic.numerics.guarantees.surface import Surface, Target, numbers_in, parts, surface
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

CLOSENESS = 1.05
RATIOS = (8, 12, 16, 24, 48, 96)
"""Points of grids over the order of the polynomial, from coarse to fine: factors of 1.08 to 1.0005 an axis."""
MOST_POINTS = 150_000
WORK, LEAST_WORK = 5e8, 1e5
"""For the range of one entry, about a second; what a grid takes at least."""
SINGLE_UNIT = 2.0**-24


@dataclass(frozen=True)
class Largest:
    """A proven bound of |f| over a box, the largest |f| found, and the state where; whether the bound is close enough.

    `bound` is infinite, and `reason` says why, where f is no polynomial.
    """

    bound: float
    found: float
    state: Mapping[str, float] = field(default_factory=dict)
    finished: bool = True
    reason: str = ""


def largest(target: Target, box: Box, *, closeness: float = CLOSENESS, work: float = math.inf) -> Largest:
    """Return a bound of the largest |f| over a box; positions of the box that are no angles are slides.

    The work ends when the bound is at most `closeness` times a value that is taken on, but for what the surface leaves
    out, or after so much `work`, values of coefficients on grids, with what is proven then: the same on every
    computer, however busy it is. All other variables are taken as those of the motion. A
    variable that stands inside of sines and outside of them is two, in what is close to a value (`separated.py`).
    """
    try:
        found = surface(target, box)
    except NotPolynomial as error:
        return Largest(math.inf, 0.0, finished=False, reason=str(error))
    search = _Values(found)
    for _ in search.steps(closeness):
        if search.work > work:
            break
    state = search.state(box)
    close = search.upper <= closeness * search.lower
    bound = (search.upper * search.scale + found.left_out) * OUTWARDS
    return Largest(bound, value_at(target, state, box), state, close)


def value_at(target: Target, state: Mapping[str, float], box: Box) -> float:
    """Return |f| at a state, in double precision."""
    symbols = {**numbers_in(box), **state}
    values = [evaluate([x], symbols, FLOATS)(x) for x in parts(target)]
    return abs(values[0] - values[1] if len(values) == 2 else values[0])


class _Values(Search):
    """Largest values of a surface, over `scale`, with grids in single precision; `place` is where `lower` was found."""

    def __init__(self, found: Surface) -> None:
        self.found, self.signs, self.work = found, signs_of(found.monomials), 0.0
        self.scale = float(np.abs(found.coefficients).max()) or 1.0
        points = {j: 24 * m // (1 + found.axes[j].is_even) + 1 for j, m in enumerate(found.orders) if m}
        order = sorted(points, key=lambda j: -points[j])
        cut = next(k for k in range(len(order) + 1) if math.prod(points[j] for j in order[k:]) <= MOST_POINTS)
        self.cut, self.gridded = order[:cut], order[cut:]
        self.coefficients = self._arranged(found.coefficients / self.scale)
        grids = [self._grids(ratio) for ratio in RATIOS]
        self.grids = [one for k, one in enumerate(grids) if k == 0 or math.prod(map(len, one)) <= MOST_POINTS]
        pairs = [zip(self.gridded, one, strict=True) for one in self.grids]
        self.bases = [[self._basis(j, phi).astype(np.float32) for j, phi in one] for one in pairs]
        self.place: tuple[tuple[float, ...], int, int] = ((), 0, 0)
        total = float(np.abs(found.coefficients).sum()) / self.scale * OUTWARDS
        axes, orders = [found.axes[j] for j in self.cut], [found.orders[j] for j in self.cut]
        self.rounding = self._rounding(total)
        factors = [OUTWARDS * math.cos(math.pi / ratio) ** -len(self.gridded) for ratio in RATIOS[: len(self.grids)]]
        super().__init__(axes, orders, factors, total)

    def value(self, middle: tuple[float, ...], grid: int, least: float) -> float:
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
        """Return the state at which `lower` was found; what has no influence is in the middle of its range."""
        middle, grid, where = self.place
        found = self.found
        phases = dict(zip(self.cut, middle or [0.0] * len(self.cut), strict=True))
        indices = np.unravel_index(where, [len(phi) for phi in self.grids[grid]]) if self.gridded else ()
        phases |= {j: phi[k] for j, phi, k in zip(self.gridded, self.grids[grid], indices, strict=True)}
        positions = {axis.name: axis.middle for axis in found.axes}
        positions |= {found.axes[j].name: float(found.axes[j].positions(np.array(phi))) for j, phi in phases.items()}
        values = found.coefficients
        for j in reversed(range(len(found.axes))):
            values = values @ self._basis(j, np.array(phases.get(j, 0.0)))
        s = self.signs.worst(values, found.monomials, len(found.motion))
        motion = [(box.ranges[name], name, k) for name, k in zip(found.motion, s, strict=True) if name in box.ranges]
        return positions | {name: x.low + (x.high - x.low) * (1 + k) / 2 for x, name, k in motion}

    def _arranged(self, coefficients: Array) -> AnyArray:
        """Return coefficients with the axes of cells first, then the motion, the axes of grids, and one more."""
        kept = [*self.cut, *self.gridded]
        others = [j for j in range(len(self.found.axes)) if j not in kept]
        order = [*(j + 1 for j in self.cut), 0, *(j + 1 for j in (*self.gridded, *others))]
        moved = coefficients.transpose(order)
        return np.ascontiguousarray(moved.reshape(*moved.shape[: 1 + len(kept)], 1), dtype=np.float32)

    def _grids(self, ratio: int) -> list[Array]:
        return [self.found.axes[j].grid(ratio, self.found.orders[j]) for j in self.gridded]

    def _basis(self, j: int, phi: AnyArray) -> Array:
        """Return the functions of an axis that are kept."""
        axis = self.found.axes[j]
        return np.compress(np.array(axis.orders) <= self.found.orders[j], axis.basis(phi), axis=-1)

    def _in_cell(self, middle: Sequence[float]) -> AnyArray:
        """Return the coefficients of the grid's axes at the middle of a cell."""
        values = self.coefficients
        for j, phi in zip(self.cut, middle, strict=True):
            basis = self._basis(j, np.array(phi)).astype(np.float32)
            values = (basis @ values.reshape(len(values), -1)).reshape(values.shape[1:])
        return values

    def _rounding(self, total: float) -> float:
        """At least the rounding error of values: products and sums in single precision, functions of the basis."""
        sizes = sum(len(self.found.axes[j].orders) + 2 for j in (*self.cut, *self.gridded))
        steps = sizes + 2 * len(self.found.monomials) + 16
        basis = sum(axis.basis_error for axis in self.found.axes)
        return (steps * SINGLE_UNIT * (1 + 1e-3) + 2 * basis) * total
