"""Rails of a finite-element body: straight lines along which a carriage slides, and follows the body there.

Modes along a rail are polynomials of the distance s, fitted to the displacements of its nodes, which lie around a line
along an axis a of the frame:

    u(s) + turn(s) x (x - x(s)),    turn(s) = a x u'(s) + roll(s) a

Loads that are distributed along it as polynomials of s give the static modes with which it yields at all its places.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Legendre

from symoro_elastic.formats.modes_file import Rail
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError

LOADS = 3
"""Polynomials of the loads along a rail: constant, linear, quadratic; three forces and a moment each."""
DEGREES = range(3, 9)
FITTED = 0.01
"""Of the largest displacement on the rail: the mean error of polynomials that suffice."""
SLENDER = 3.0
"""Least length of a rail by the width of its nodes."""

NEAR = 1e-6
"""Of the length of a rail: the width of one line of nodes."""


def line_of(x: Array, name: str, source: str) -> tuple[int, Array, Array]:
    """Return the axis of the frame along which nodes x (n, 3) lie, and both ends (3,) of the line in their middle.

    Raises `InputError` for nodes that are not spread along an axis.
    """
    low, high = x.min(axis=0), x.max(axis=0)
    along = int(np.argmax(high - low))
    width = np.delete(high - low, along).max()
    if high[along] - low[along] < SLENDER * width or len(x) < 2 * DEGREES.stop:
        what = f"{len(x)} nodes within {np.array2string(high - low, precision=3)} m: a rail is a strip along x, y or z"
        raise InputError(source, f"--rail {name}", f"{what}, {SLENDER:g} times as long as wide")
    if width <= NEAR * (high[along] - low[along]):
        what = f"{len(x)} nodes on one line: name nodes beside it, which show its roll"
        raise InputError(source, f"--rail {name}", what)
    middle = (low + high) / 2
    ends = (np.where(np.arange(3) == along, side, middle) for side in (low, high))
    return (along, *ends)


def loads_along(x: Array, nodes: AnyArray, name: str, source: str) -> Array:
    """Return forces (3 n, 4 LOADS) on nodes (indices): along and across, and moments about the line, by polynomials."""
    along, start, end = line_of(x[nodes], name, source)
    s = x[nodes, along]
    arms = x[nodes] - start
    arms[:, along] = 0.0
    forces = [np.tile(axis, (len(nodes), 1)) for axis in np.eye(3)]
    forces.append(np.cross(np.eye(3)[along], arms))
    loads = np.zeros((len(x), 3, 4 * LOADS))
    for k in range(LOADS):
        shape = Legendre.basis(k, domain=[start[along], end[along]])(s)
        for column, force in enumerate(forces, 4 * k):
            loads[nodes, :, column] = shape[:, None] * force
    return loads.reshape(3 * len(x), -1)


def rail_of(x: Array, nodes: AnyArray, phi: Array, stiffness: Array, name: str, source: str) -> tuple[Rail, float]:
    """Return the rail of nodes (indices) on a body with modes phi (m, n, 3), and the error of its polynomials.

    The error is the root mean square over the nodes, of the largest displacement, of modes that yield as by a unit of
    energy each: phi_k / sqrt(K_k).
    """
    along, start, end = line_of(x[nodes], name, source)
    a, length = np.eye(3)[along], float(end[along] - start[along])
    arms = (x[nodes] - start) / length
    places = arms[:, along].copy()
    arms[:, along] = 0.0
    moved = phi[:, nodes].reshape(len(phi), -1).T
    yields = 1 / np.sqrt(stiffness)
    largest = np.linalg.norm(moved * yields, axis=1).max()
    for degree in DEGREES:
        basis = _basis(places, arms, a, degree)
        factors = np.linalg.lstsq(basis, moved, rcond=None)[0]
        error = float(np.linalg.norm((basis @ factors - moved) * yields) / np.sqrt(len(moved)) / largest)
        if error <= FITTED:
            break
    *u, roll = factors.reshape(4, degree + 1, -1)
    slopes = np.zeros((3, degree + 1, len(phi)))
    slopes[:, :-1] = np.array(u)[:, 1:] * np.arange(1, degree + 1)[:, None]
    turn = np.einsum("bnk,ba->nka", slopes, np.cross(a, np.eye(3))) + roll[:, :, None] * a
    powers = length ** -np.arange(degree + 1.0)[:, None, None]
    return Rail(start, end, np.moveaxis(np.array(u), 0, 2) * powers, turn * powers / length), error


def _basis(places: Array, arms: Array, a: Array, degree: int) -> Array:
    """Displacements (3 n, 4 (degree + 1)) at nodes per polynomial coefficient of translation and of scaled roll."""
    numbers = np.arange(degree + 1)
    powers = places[:, None] ** numbers
    slopes = numbers * places[:, None] ** np.maximum(numbers - 1, 0)
    powers, slopes = powers[:, :, None], slopes[:, :, None]
    columns = [powers * axis + slopes * np.cross(np.cross(a, axis), arms)[:, None] for axis in np.eye(3)]
    columns.append(powers * np.cross(a, arms)[:, None])
    return np.concatenate(columns, axis=1).transpose(0, 2, 1).reshape(3 * len(places), -1)
