"""Lemma 5, pivots are at least the inertia that a joint moves by itself.

The recursion divides by H_j, the Schur complement of entry j of the inertia matrix over the joints beyond j that are
solved for. With the inertia J_j of body j about the origin of its frame, e_j the axis of the joint, Ia_j its rotor:

    H_j >= Ia_j + e_j' J_j e_j

Proof: what joint c hands on, K_c - K_c e e' K_c / H_c, is positive semidefinite where K_c is, for H_c >= e' K_c e; so
K_j >= J_j by induction from the tips. It needs bodies that can exist, where there are rotors, too: no mass and no
central inertia below zero. Where joints are coupled, H_j >= Ia_j is left: the rotors of independent joints add a
diagonal matrix to one that is positive semidefinite. The whole bound holds where all joints from the base to j are
independent and solved for after j: H_j is the least energy 2 G with qdd_j = 1 and coordinates still to be solved for at
rest (`knowledge.py`), so the antecedent of body j is at rest, and body j alone has e_j' J_j e_j.

It holds at every position, and it costs nothing. Base inertial parameters are not those of bodies: grouping does not
change H_j, so the lemma is applied to the machine before.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import Axis, RigidInertia
from symoro_elastic.models.tree import Tree
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval, interval
from symoro_elastic.symbolic.arithmetic import RATIONAL, Arithmetic, evaluate
from symoro_elastic.symbolic.expression import Expression

RATIONALS: Arithmetic[Fraction] = Arithmetic(Fraction, RATIONAL)


def own_inertias(machine: Machine, box: Mapping[str, Interval], from_rest: Collection[int]) -> dict[int, Array]:
    """A lower bound of H_j by joint, where the machine has one above zero; empty where bodies cannot exist.

    `machine` has the inertial parameters of bodies; `box` has its parameters; `from_rest` are the joints whose body has
    an antecedent at rest where the joint is solved for.
    """
    mechanism = Tree(machine).mechanism
    links = {j: mechanism.link(j) for j in machine.independent}
    found: dict[int, Array] = {}
    if not _can_exist(mechanism, box):
        return found
    for j, link in links.items():
        least = _low(link.rotor_inertia, box)
        if j in from_rest:
            least = least + _low(_about_axis(link), box)
        if np.all(least > 0):
            found[j] = np.nextafter(least, -np.inf)
    return found


def _about_axis(link: Link) -> Scalar:
    """e' J e: the inertia of the own body about the axis of its joint, or its mass where the joint slides."""
    return link.body.inertia[5] if link.axis is Axis.REVOLUTE else link.body.mass


def _low(x: Scalar, box: Mapping[str, Interval]) -> Array:
    """The least value of an expression of parameters, not below zero."""
    with np.errstate(all="ignore"):
        value = evaluate([x], box, INTERVALS)(x) if isinstance(x, Expression) else interval(_exact(x))
    return np.maximum(np.where(np.isfinite(value.low), value.low, 0.0), 0.0)


def _exact(x: Scalar) -> Any:
    return x if isinstance(x, int | Fraction) else Fraction(x)  # type: ignore[arg-type]


def _can_exist(mechanism: Mechanism, box: Mapping[str, Interval]) -> bool:
    """Whether every body may exist: masses and central tensors that are positive semidefinite, in exact arithmetic."""
    bodies = [link.body for link in mechanism.links] + ([mechanism.body] if mechanism.body else [])
    return all(_is_possible(body, box) for body in bodies)


def _is_possible(body: RigidInertia, box: Mapping[str, Interval]) -> bool:
    """Whether m >= 0, and the central tensor has no negative principal minor; by intervals where they have ranges."""
    entries = (body.mass, *body.moments, *body.inertia)
    exact = {name: Fraction(float(x.low.flat[0])) for name, x in box.items() if np.all(x.low == x.high)}
    try:
        value: Callable[[Scalar], Any] = evaluate(entries, exact, RATIONALS)
        mass, mx, my, mz, xx, xy, xz, yy, yz, zz = map(value, entries)
    except KeyError:
        value = evaluate(entries, box, INTERVALS)
        mass, mx, my, mz, xx, xy, xz, yy, yz, zz = (interval(value(x)) for x in entries)
    if isinstance(mass, Fraction | int) and mass <= 0:
        return mass == 0 and not (mx or my or mz) and _is_semidefinite(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    if not _least(mass) > 0:
        return False
    x, y, z = mx / mass, my / mass, mz / mass
    central = (
        (xx - my * y - mz * z, xy + mx * y, xz + mx * z),
        (xy + mx * y, yy - mx * x - mz * z, yz + my * z),
        (xz + mx * z, yz + my * z, zz - mx * x - my * y),
    )
    return _is_semidefinite(central)


def _least(x: Any) -> Any:
    return np.min(x.low) if isinstance(x, Interval) else x


def _is_semidefinite(matrix: tuple[tuple[Any, ...], ...]) -> bool:
    """Whether all principal minors of a symmetric matrix are zero or positive."""
    sizes = range(1, len(matrix) + 1)
    kept = (rows for size in sizes for rows in combinations(range(len(matrix)), size))
    return all(_least(_determinant([[matrix[i][k] for k in rows] for i in rows])) >= 0 for rows in kept)


def _determinant(matrix: list[list[Any]]) -> Any:
    if len(matrix) == 1:
        return matrix[0][0]
    first, *rest = matrix
    minors = ([row[:k] + row[k + 1 :] for row in rest] for k in range(len(first)))
    signed = ((-1) ** k * x for k, x in enumerate(first))
    return sum((x * _determinant(minor) for x, minor in zip(signed, minors, strict=True)), Fraction(0))
