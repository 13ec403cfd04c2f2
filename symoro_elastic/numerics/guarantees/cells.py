"""Branch and bound over cells of positions: an upper bound that falls until it is close to a value that is taken on.

Some axes are cut into cells, the others have a grid in each cell (lemma 4, `axes.py`). Where the largest value is taken
on lies in some cell, of half widths d_j. With its middle c, N_j points and orders m_j:

    largest value <= (largest over the grid at c) . product of 1/cos(pi m_j/N_j) . 1/cos(sum m_j d_j)

so the largest of these over all cells is a bound. The cell that has it gets a finer grid, or is cut in two along each
axis. One may stop at any time. A value below what bounds the largest anyway need not be known better.
"""

from __future__ import annotations

import heapq
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from symoro_elastic.numerics.guarantees.axes import Axis

OUTWARDS = 1 + 1e-12
FEWEST_CELLS = 8
"""Cells over the order of the polynomial, along an axis: 1/cos of pi over it is what a cell loses, by one axis."""


class Cell(NamedTuple):
    """Minus its bound (heaps have the least first), a number, the middle in phi, how often it was cut, and its grid.

    `grid` is the number of the grid in `Search.factors`, -1 before any.
    """

    minus: float
    number: int
    middle: tuple[float, ...]
    cuts: int
    grid: int


class Search(ABC):
    """The cells of some axes, worst first, with orders; and the factors of grids of the others, from coarse to fine."""

    def __init__(self, axes: Sequence[Axis], orders: Sequence[int], factors: Sequence[float], total: float) -> None:
        self.axes, self.orders, self.factors, self.total = axes, orders, factors, total
        self.least = max(FEWEST_CELLS, 3 * len(axes))
        self.lower = 0.0
        self._numbers = itertools.count()
        middles = itertools.product(*(a.cells(2 * (self.least * m // 2)) for a, m in zip(axes, orders, strict=True)))
        self.cells = [Cell(-total, next(self._numbers), tuple(map(float, middle)), 0, -1) for middle in middles]
        heapq.heapify(self.cells)

    @abstractmethod
    def value(self, middle: tuple[float, ...], grid: int, least: float) -> float:
        """Return the largest value over a grid in a cell, with its rounding, or `least` if that is larger."""

    @property
    def upper(self) -> float:
        """A bound of the largest value."""
        return -self.cells[0].minus * OUTWARDS

    def steps(self, closeness: float) -> Iterator[float]:
        """Improve the bound cell by cell until it is at most `closeness` times `lower`; yields the bound."""
        while self.upper > closeness * self.lower:
            cell = self.cells[0]
            finer = cell.grid + 1 < len(self.factors)
            if not finer and not self.axes:
                return
            heapq.heappop(self.cells)
            if finer and (cell.grid < 0 or self.factors[cell.grid] >= self._loss(cell.cuts)):
                self._push(cell.middle, cell.cuts, cell.grid + 1, -cell.minus)
            else:
                for middle in self._halves(cell):
                    self._push(middle, cell.cuts + 1, 0, -cell.minus)
            yield self.upper

    def _push(self, middle: tuple[float, ...], cuts: int, grid: int, known: float) -> None:
        factor = self.factors[grid] * self._loss(cuts)
        bound = factor * self.value(middle, grid, self.lower / factor)
        heapq.heappush(self.cells, Cell(-min(bound, known), next(self._numbers), middle, cuts, grid))

    def _loss(self, cuts: int) -> float:
        """1/cos of the sum of orders times half widths; all axes have the same share."""
        return OUTWARDS / math.cos(sum(m * half for m, half in zip(self.orders, self._widths(cuts), strict=True)))

    def _widths(self, cuts: int) -> list[float]:
        return [math.pi / (2 * (self.least * m // 2) * 2**cuts) for m in self.orders]

    def _halves(self, cell: Cell) -> Iterator[tuple[float, ...]]:
        widths = self._widths(cell.cuts + 1)
        for signs in itertools.product((-1, 1), repeat=len(self.axes)):
            yield tuple(x + s * half for x, s, half in zip(cell.middle, signs, widths, strict=True))
