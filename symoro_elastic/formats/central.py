"""Inertial parameters about the centre of mass and about the origin of any frame; numbers stay exact."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from symoro_elastic.formats.polynomials import Polynomial, vector_of
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body

ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Entries of a tensor in the order of a table."""
ROUNDING = 64 * 2.0**-52
"""Part of the largest entry of a turned tensor below which an entry is zero."""


def about_origin(body: Body) -> Body:
    """Return the body with first moments and inertia about the origin of its frame.

    Raises `FormulaError` where an expression grows beyond what is read.
    """
    if not body.central:
        return body
    mass, center = Polynomial.of(body.mass), vector_of(body.moments)
    return _with(replace(body, central=False), center * mass, _tensor(body) + _shift(center, center * mass) / 2)


def normal(body: Body) -> Body:
    """Return the body with its columns in the normal form that `about_origin` writes."""
    return _with(body, vector_of(body.moments), _tensor(body))


def moved_body(body: Body, place: Placement) -> Body:
    """Return a body, given in a frame at `place`, in the reference frame; raises `FormulaError` as `about_origin`."""
    turn, t, mass = place.rotation, vector_of(place.translation), Polynomial.of(body.mass)
    inertia, moments = turn @ _tensor(body) @ turn.T, turn @ vector_of(body.moments)
    if body.central:
        return _with(body, moments + t, inertia)
    return _with(body, moments + t * mass, inertia + _shift(moments, t) + _shift(t, t * mass) / 2)


def _tensor(body: Body) -> Any:
    xx, xy, xz, yy, yz, zz = vector_of(body.inertia)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=object)


def _shift(moments: Any, t: Any) -> Any:
    """Return the change of the inertia tensor with first moments by a displacement t of the frame's origin."""
    outer = np.multiply.outer(moments, t)
    unit = np.eye(3) * (moments @ t)
    return unit + unit - outer - outer.T


def _with(body: Body, moments: Any, inertia: Any) -> Body:
    """Return the body with first moments and inertia from these polynomials, without rounding errors."""
    least = ROUNDING * max(abs(x.constant or 0.0) for x in inertia.flat)
    x, y, z = (cell.formula for cell in moments)
    xx, xy, xz, yy, yz, zz = (_formula(inertia[entry], least) for entry in ENTRIES)
    return replace(body, moments=(x, y, z), inertia=(xx, xy, xz, yy, yz, zz))


def _formula(cell: Polynomial, least: float) -> Formula:
    constant = cell.constant
    return ZERO if constant is not None and abs(constant) <= least else cell.formula
