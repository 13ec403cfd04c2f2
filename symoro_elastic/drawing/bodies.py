"""Bodies as boxes of equal inertia: the same mass, centre of mass and inertia tensor, evenly filled."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body

TENSOR = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
"""Entries XX XY XZ YY YZ ZZ of a symmetric tensor, by row and column."""
ROUNDING = 1e-9
"""Of a principal moment, by the largest: what a square may be below zero."""


@dataclass(frozen=True)
class Box:
    """A box in the frame of its body: `placement` (4, 4) of its centre, its axes the principal ones, `edges` (3,) m.

    `is_exact` is False where no evenly filled box has this inertia; the edge that would be imaginary is then 0.
    """

    placement: Array
    edges: Array
    mass: float
    is_exact: bool = True


def box_of(body: Body, values: Mapping[str, float]) -> Box | None:
    """Return the box of equal inertia; None for a body without mass, or with numbers that are none.

    The edges a, b, c fulfil I_x = m (b^2 + c^2) / 12 and so on about the principal axes.
    """
    cells = (body.mass, *body.moments, *body.inertia)
    if not all(cell.names <= values.keys() for cell in cells):
        return None
    mass, *others = (_number(cell, values) for cell in cells)
    if not (mass > 0 and np.isfinite(others).all()):
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        centre, tensor = _about_centre(body, mass, np.array(others))
    if not np.isfinite(tensor).all():
        return None
    moments, axes = np.linalg.eigh(tensor)
    squares = 6 * (moments.sum() - 2 * moments) / mass
    placement = np.eye(4)
    placement[:3, :3], placement[:3, 3] = _along_frame(axes), centre
    squares = squares[_order(axes)]
    least = -ROUNDING * float(np.abs(squares).max(initial=0.0))
    return Box(placement, np.sqrt(np.maximum(squares, 0.0)), mass, bool((squares >= least).all()))


def _number(formula: Formula, values: Mapping[str, float]) -> float:
    try:
        return formula.value(values)
    except (ArithmeticError, ValueError):
        return math.nan


def _about_centre(body: Body, mass: float, others: Array) -> tuple[Array, Array]:
    """Return the centre of mass (3,) and the inertia tensor (3, 3) about it, in the frame of the body."""
    tensor = others[3:][np.array(TENSOR)]
    if body.central:
        return others[:3], tensor
    centre: Array = others[:3] / mass
    shifted: Array = tensor - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return centre, shifted


def _order(axes: Array) -> list[int]:
    """Return which principal axis is nearest to x, to y, to z of the frame."""
    order: list[int] = []
    for row in np.abs(np.round(axes, 9)):
        order.append(max((k for k in range(3) if k not in order), key=lambda k: (row[k], -k)))
    return order


def _along_frame(axes: Array) -> Array:
    """Return the principal axes (columns) in the order and the sense of those of the frame, right-handed."""
    ordered = axes[:, _order(axes)]
    ordered = ordered * np.where(np.diag(ordered) < 0, -1.0, 1.0)
    turned: Array = ordered * np.array([1.0, 1.0, np.sign(np.linalg.det(ordered))])
    return turned
