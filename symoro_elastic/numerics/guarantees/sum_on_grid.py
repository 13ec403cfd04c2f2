"""The largest value of a sum of magnitudes of polynomials, sum w_i |f_i|, which is less than the sum of their largest.

**Lemma.** Let f_i(x, y, s) be polynomials of positions x, of positions y and of the motion s. Each is a sum, over the
products of s and over the harmonics of y, of polynomials c_ik(x). With |c|_k the magnitude of the coefficients of one
harmonic (for turns the root of the sum of squares of those of cosine and sine; each other function is at most 1),

    sum w_i |f_i(x, y, s)| <= S(x) = sum_i w_i sum_k |c_ik(x)|  <=  product of 1/cos(pi m_j/N_j) max of S over a grid

where x_j is an axis of order m_j with N_j points. *Proof.* The first part are the triangle inequality and that of
Cauchy. Each |c|_k is the largest of linear combinations of its coefficients, so S is the largest of a family of fixed
linear combinations of polynomials of x, which are polynomials of the same orders: lemma 4 holds for it (`axes.py`).

Few x are enough: those for which the sum falls most, as a sample of the f_i shows, and as many as are worth their work.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.numerics.guarantees.axes import TURN, Axis, of_harmonics
from symoro_elastic.numerics.guarantees.coefficients import Polynomial

RATIOS = (8, 10, 12, 16)
"""Points of a grid over the order of the axis: factors of 1.08, 1.05, 1.04 and 1.02."""
MOST_WORK, PRICE = 5e9, 0.05
"""Values of coefficients on grids; work that is twice as much has to make a bound smaller by 3 % (2^-0.05)."""
MOST_AXES = 3
AT_ONCE = 2**18
"""Values of coefficients that fit the processor's cache."""
ONE = np.ones((1, 1), np.float32)
"""The basis of an axis that polynomials do not depend on."""
SINGLE_UNIT = 2.0**-24
OUTWARDS = 1 + 1e-6


@dataclass
class SumOnGrid:
    """The sum over a grid of some axes: number of the axis and points over its order.

    What is added as a weight and a polynomial is computed in single precision; `off` bounds that rounding. Errors of
    the coefficients themselves are not part of it.
    """

    axes: Sequence[Axis]
    ratios: Mapping[int, int]
    total: AnyArray = field(default_factory=lambda: np.zeros(()))
    off: float = 0.0

    def __post_init__(self) -> None:
        found = ((j, axis, self.ratios.get(j)) for j, axis in enumerate(self.axes))
        self._bases = {j: axis.basis(axis.grid(r, max(axis.orders))).astype(np.float32) for j, axis, r in found if r}

    @property
    def factor(self) -> float:
        """By which the sum may be above its largest value on the grid."""
        return math.prod(1 / math.cos(math.pi / ratio) for ratio in self.ratios.values()) * OUTWARDS

    @property
    def bound(self) -> float:
        """At least the largest value of all that was added."""
        return (float(self.total.max()) + self.off) * self.factor

    def add(self, weight: float, coefficients: AnyArray) -> None:
        """Add polynomials of one shape, by their coefficients (polynomials, functions of each axis)."""
        for one in coefficients:
            self._add(weight, one)

    def _add(self, weight: float, coefficients: AnyArray) -> None:
        scale = float(np.abs(coefficients).max()) or 1.0
        weight, sums = weight * scale, float(np.abs(coefficients).sum()) / scale
        gridded = sorted(self._bases)
        others = [j for j in range(len(self.axes)) if j not in self._bases]
        ordered = (coefficients / scale).transpose(*others, *gridded)
        shape = [*ordered.shape]
        values: AnyArray = np.ascontiguousarray(ordered, dtype=np.float32)
        bases = [self._bases[j] if coefficients.shape[j] > 1 else ONE for j in gridded] or [ONE]
        for place, basis in reversed([*enumerate(bases[1:], start=len(others) + 1)]):
            if shape[place] > 1:
                values = np.matmul(basis, values.reshape(math.prod(shape[:place]), shape[place], -1))
                shape[place] = len(basis)
        values = values.reshape(*shape[: len(others)], len(bases[0].T), -1)
        rows, found = self._summed(values, bases[0], others)
        points = (len(bases[0]), *shape[len(others) + 1 :]) if gridded else ()
        steps = 4 + sum(len(self.axes[j].orders) + 4 for j in gridded if coefficients.shape[j] > 1)
        self.total = self.total + weight * (1 + (rows + 16) * SINGLE_UNIT) * found.reshape(points).astype(float)
        self.off += weight * steps * SINGLE_UNIT * sums * OUTWARDS

    def _summed(self, values: AnyArray, basis: AnyArray, others: Sequence[int]) -> tuple[int, AnyArray]:
        """Return how many magnitudes are added, and their sum (points of the first axis of the grid, other points).

        `values` are (functions of each of the other axes, of the first axis, other points).
        """
        *lead, _, rest = values.shape
        found = np.empty((len(basis), rest), np.float32)
        step = max(1, AT_ONCE // (math.prod(lead) * rest))
        for start in range(0, len(basis), step):
            part = basis[start : start + step]
            squares = np.matmul(part, values).reshape(*lead, -1)
            np.multiply(squares, squares, out=squares)
            for place, j in enumerate(others):
                if self.axes[j].kind == TURN:
                    squares = of_harmonics(squares, place)
            magnitudes = np.sqrt(squares, out=squares)
            found[start : start + step] = magnitudes.sum(axis=tuple(range(len(others)))).reshape(-1, rest)
        return math.prod(magnitudes.shape[:-1]), found


def coefficients_of(x: Polynomial, axes: Sequence[Axis]) -> Iterator[AnyArray]:
    """Yield the coefficients of a polynomial, from its values at the nodes of axes, stacked by shape.

    Each axis in turn is the first one, and then the last.
    """
    shapes: defaultdict[tuple[int, ...], list[AnyArray]] = defaultdict(list)
    for values in map(np.asarray, x.terms.values()):
        shape = values.shape or (1,) * len(axes)
        shapes[shape].append(values.reshape(shape))
    for alike in shapes.values():
        found = np.stack(alike, axis=-1)
        for axis in axes:
            rows = found.reshape(len(found), -1)
            rows = axis.from_values @ rows if len(rows) > 1 else rows
            found = rows.T.reshape(*found.shape[1:], len(rows))
        yield found


Sample = Sequence[tuple[float, Sequence[AnyArray]]]
"""Weights, and coefficients of polynomials by shape."""


def best_ratios(axes: Sequence[Axis], sample: Sample, numbers: Mapping[tuple[int, ...], int]) -> Mapping[int, int]:
    """Return the grid whose bound of a sample is worth its work, within `MOST_WORK`; empty where none has gain.

    `numbers` says how many polynomials of each shape are to be added.
    """
    best, least = {}, _bound_on(axes, {}, sample) * _work(axes, {}, numbers) ** PRICE
    chosen: dict[int, int] = {}
    for _ in range(min(MOST_AXES, len(axes))):
        more = [chosen | {j: RATIOS[0]} for j, axis in enumerate(axes) if j not in chosen and max(axis.orders)]
        tried = [(_bound_on(axes, one, sample), one) for one in more if _work(axes, one, numbers) <= MOST_WORK]
        if not tried:
            break
        found, chosen = min(tried, key=lambda pair: pair[0])
        for ratio in RATIOS:
            finer = dict.fromkeys(chosen, ratio)
            work = _work(axes, finer, numbers)
            bound = found * SumOnGrid(axes, finer).factor / SumOnGrid(axes, chosen).factor * work**PRICE
            if bound < least and work <= MOST_WORK:
                best, least = finer, bound
    return best


def _bound_on(axes: Sequence[Axis], ratios: Mapping[int, int], sample: Sample) -> float:
    grid = SumOnGrid(axes, ratios)
    for weight, parts in sample:
        for part in parts:
            grid.add(weight, part)
    return grid.bound


def _work(axes: Sequence[Axis], ratios: Mapping[int, int], numbers: Mapping[tuple[int, ...], int]) -> float:
    """How many values of coefficients polynomials of these shapes have on a grid."""
    points = {j: len(axes[j].grid(ratio, max(axes[j].orders))) for j, ratio in ratios.items()}
    sizes = (
        count * math.prod(points.get(j, n) if n > 1 else 1 for j, n in enumerate(shape))
        for shape, count in numbers.items()
    )
    return float(sum(sizes))


def heaviest(weights: Iterable[float], share: float) -> list[int]:
    """Return the places of the largest weights that make up a share of their sum, largest first."""
    found = np.array([*weights])
    order = np.argsort(-found)
    sums = np.cumsum(found[order])
    count = int(np.searchsorted(sums, share * sums[-1])) + 1 if len(found) else 0
    return [int(k) for k in itertools.islice(order, count)]
