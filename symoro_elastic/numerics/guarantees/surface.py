"""A polynomial over a box, made small: coefficients of its motion in a basis of its positions, and what is left out.

The values at the nodes of all axes determine the polynomial (degrees by syntax). Of its coefficients, those of orders
that hardly occur are left out: each function of the basis is at most 1, so what is left out is at most the sum of the
magnitudes of their coefficients, the *tail*. This finds the true degrees, for nothing: syntax counts what cancels.
Rounding: the polynomial that the computed coefficients stand for misses the values at the nodes by the errors of these
values and the computed residual, which interpolation amplifies at most by the product of `Axis.amplification`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.axes import UNIT, Axis, axis_of
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.coefficients import (
    Monomial,
    Polynomial,
    number,
    polynomials,
    symbols_of,
    variable,
)
from symoro_elastic.numerics.guarantees.degrees import Degrees, NotPolynomial, degrees
from symoro_elastic.numerics.guarantees.separated import separated
from symoro_elastic.symbolic.expression import Operand

Target: TypeAlias = "Operand | tuple[Operand, Operand]"
"""An expression, or two, of one graph or of two, whose difference is meant."""

POINTS_AT_ONCE = 20_000
MOST_POINTS = 1_000_000
LEAST_SHARE = 0.002
"""Orders are left out as long as the tail of each axis is at most this part of the largest value at the nodes."""


@dataclass(frozen=True)
class Surface:
    """Coefficients by product of s and, for each axis, by function of its basis; `left_out` bounds all that is missing.

    `orders` are those of the axes, as far as kept. `motion` are the variables of the motion, by number of s.
    """

    axes: tuple[Axis, ...]
    orders: tuple[int, ...]
    monomials: tuple[Monomial, ...]
    coefficients: Array
    left_out: float
    motion: tuple[str, ...]

    @property
    def kept(self) -> tuple[Axis, ...]:
        """The axes on which the kept polynomial depends."""
        return tuple(axis for axis, order in zip(self.axes, self.orders, strict=True) if order)


def numbers_in(box: Box) -> dict[str, float]:
    """Return the values of the variables whose range is one number."""
    return {name: x.low for name, x in box.ranges.items() if x.low == x.high}


def parts(target: Target) -> list[Operand]:
    """Return the expressions of a target."""
    return list(target) if isinstance(target, tuple) else [target]


def degrees_of(target: Target, box: Box) -> Degrees:
    """Return the degrees of a target; raises `NotPolynomial`."""
    numbers = numbers_in(box)
    found = [degrees([x], numbers)[0] for x in parts(target)]
    both = reduce(lambda x, y: x + y, found)
    if missing := sorted(name for name in both.variables if name not in box.ranges):
        raise NotPolynomial(f"the box has no range for {', '.join(missing)}")
    if mixed := sorted(both.angles.keys() & both.powers.keys()):
        raise NotPolynomial(f"{mixed[0]} occurs inside of a sine or cosine and outside of it")
    return both


def axes_of(found: Degrees, box: Box) -> tuple[Axis, ...]:
    """Return the axes of angles and of those other variables that are positions."""
    angles = [axis_of(name, n, box.ranges[name], angle=True) for name, n in sorted(found.angles.items())]
    slides = [(name, n) for name, n in sorted(found.powers.items()) if name in box.positions]
    return (*angles, *(axis_of(name, n, box.ranges[name], angle=False) for name, n in slides))


def surface(target: Target, box: Box) -> Surface:
    """Return a target as a surface over a box; raises `NotPolynomial`."""
    roots, box = separated(parts(target), box)
    target = roots[0] if len(roots) == 1 else (roots[0], roots[1])
    found = degrees_of(target, box)
    axes = axes_of(found, box)
    if (points := math.prod(len(axis.nodes) for axis in axes)) > MOST_POINTS:
        raise NotPolynomial(f"{points} positions determine it: {MOST_POINTS} are the most")
    names = {axis.name for axis in axes}
    motion = tuple(name for name in sorted(found.powers) if name not in names)
    values, error = _at_nodes(target, box, axes, motion)
    monomials = tuple(values)
    if not monomials:
        return Surface(axes, (0,) * len(axes), ((),), np.zeros((1, *(1 for _ in axes))), 0.0, motion)
    stacked = np.stack([values[key] for key in monomials])
    coefficients = _transformed(stacked, [axis.from_values for axis in axes])
    missing = _missing(stacked, coefficients, axes, error)
    kept, orders, tail = _truncated(coefficients, axes, float(np.abs(stacked).sum(axis=0).max()))
    return Surface(axes, orders, monomials, kept, (missing + tail) * (1 + 1e-12), motion)


def _at_nodes(
    target: Target, box: Box, axes: Sequence[Axis], motion: Sequence[str]
) -> tuple[dict[Monomial, Array], float]:
    """Return the coefficients of the motion at the nodes of all axes, and the error of each."""
    shape = tuple(len(axis.nodes) for axis in axes)
    values: dict[Monomial, Array] = {}
    error = 0.0
    for part, points in _slabs(axes, shape):
        found = _difference(target, box, points, motion)
        error = max(error, found.error)
        for key, x in found.terms.items():
            values.setdefault(key, np.zeros(shape))[part] = x
    return values, error


def _slabs(
    axes: Sequence[Axis], shape: Sequence[int]
) -> Iterator[tuple[slice | tuple[slice, ...], dict[str, Polynomial]]]:
    """Yield parts of the grid of nodes along the first axis, and the positions there."""
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


def _difference(target: Target, box: Box, points: Mapping[str, Polynomial], motion: Sequence[str]) -> Polynomial:
    numbers = numbers_in(box)
    found = []
    for root in parts(target):
        moving = {name: variable(k, box.ranges[name]) for k, name in enumerate(motion)}
        unused = {name: number(0.0) for name in symbols_of([root])}
        found += polynomials([root], unused | moving | dict(points), numbers)
    return found[0] - found[1] if len(found) == 2 else found[0]


def _transformed(values: Array, matrices: Sequence[Array]) -> Array:
    """Return values with a matrix applied along each axis but the first."""
    for j, matrix in enumerate(matrices, start=1):
        values = np.moveaxis(np.tensordot(values, matrix, axes=(j, 1)), -1, j)
    return values


def _missing(values: Array, coefficients: Array, axes: Sequence[Axis], error: float) -> float:
    """Return at least the largest error of the polynomial of the computed coefficients, added over the motion."""
    back = _transformed(coefficients, [axis.at_nodes for axis in axes])
    sums = np.abs(coefficients).reshape(len(values), -1).sum(axis=1)
    rounding = sum(axis.basis_error + 4 * len(axis.orders) * UNIT for axis in axes) * 2
    residual = np.abs(values - back).reshape(len(values), -1).max(axis=1)
    return float((error + residual + rounding * sums).sum()) * math.prod(axis.amplification for axis in axes)


def _truncated(coefficients: Array, axes: Sequence[Axis], scale: float) -> tuple[Array, tuple[int, ...], float]:
    """Return the coefficients without orders that hardly occur, the orders that are left, and the tail."""
    tail, orders = 0.0, []
    for j, axis in enumerate(axes, start=1):
        sums = np.abs(coefficients).sum(axis=tuple(k for k in range(coefficients.ndim) if k != j))
        own = np.array(axis.orders)
        order = next(m for m in sorted(set(axis.orders)) if sums[own > m].sum() <= LEAST_SHARE * scale)
        tail += float(sums[own > order].sum())
        coefficients = np.compress(own <= order, coefficients, axis=j)
        orders.append(order)
    return coefficients, tuple(orders), tail
