"""Torques and energy as linear functions of the parameters: Gamma = Y X, E = h X.

The inertial parameters of link j are XX XY XZ YY YZ ZZ MX MY MZ M, about the origin of its frame.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.kinematics import Scalars, velocities
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.newton_euler import newton_euler
from symoro_elastic.mechanics.spatial import (
    ZERO,
    Axis,
    RigidInertia,
    Scalar,
    Symmetric,
    Twist,
    Vector,
    Wrench,
    cross,
    dot,
    is_zero,
)

INERTIA = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
MOMENTS = ("MX", "MY", "MZ")
INERTIAL = (*INERTIA, *MOMENTS, "M")
WRENCH = ("FX", "FY", "FZ", "CX", "CY", "CZ")

Column: TypeAlias = dict[int, Scalar]
"""Entries of a column of Y by joint; joints that are missing have a zero."""
Wanted: TypeAlias = Mapping[int, Sequence[str]]
"""Names of the requested parameters by link."""


def body_of(parameters: Mapping[str, Scalar]) -> RigidInertia:
    """The body with these inertial parameters; others are zero."""
    moments = Vector(*(parameters.get(name, 0) for name in MOMENTS))
    inertia = Symmetric(*(parameters.get(name, 0) for name in INERTIA))
    return RigidInertia(parameters.get("M", 0), moments, inertia)


def parameters_of(body: RigidInertia) -> dict[str, Scalar]:
    """The ten inertial parameters of a body, by name."""
    return dict(zip(INERTIAL, (*body.inertia, *body.moments, body.mass), strict=True))


def inertial_columns(mechanism: Mechanism, found: Dynamics, wanted: Wanted) -> Iterator[tuple[int, str, Column]]:
    """(j, parameter, column of Y): the torques per unit of an inertial parameter of link j.

    `found` are the velocities and accelerations [3], [6] of every link, all accelerations known.
    """
    for j, names in wanted.items():
        for name in names:
            wrench = newton_euler(body_of({name: 1}), found.w[j], found.wd[j], found.vd[j], found.U[j])  # (12)
            yield j, name, torques(mechanism, j, wrench)


def wrench_columns(mechanism: Mechanism, wanted: Wanted) -> Iterator[tuple[int, str, Column]]:
    """(j, component, column of Y): the torques for a unit wrench of link j on its surroundings."""
    for j, names in wanted.items():
        for name in names:
            unit = [int(name == component) for component in WRENCH]
            yield j, name, torques(mechanism, j, Wrench(Vector(*unit[:3]), Vector(*unit[3:])))


def torques(mechanism: Mechanism, j: int, wrench: Wrench) -> Column:
    """Torques a_k^T jTk^T f of every joint k on the path to link j that balance a wrench on it [15]."""
    column: Column = {}
    while j:
        link = mechanism.link(j)
        if link.axis is not Axis.NONE:
            column[j] = link.axis.T * wrench
        wrench = link.transform.T * wrench  # (15)
        j = link.antecedent
    return column


def energies(mechanism: Mechanism, qd: Scalars, gravity: Vector, wanted: Wanted) -> Iterator[tuple[int, str, Scalar]]:
    """(j, parameter, entry of h): kinetic and gravity energy per unit of an inertial parameter of link j.

    `gravity` is in frame 0. Energies are zero with every centre of mass at the origin of frame 0, at rest.
    """
    moving = velocities(mechanism, qd)
    fields: list[tuple[Vector, Scalar]] = [(gravity, 0)]
    for j, link in mechanism.from_base():
        field, depth = fields[link.antecedent]
        fields.append((link.transform.to_child(field), depth + dot(field, link.transform.origin)))
        entries = unit_energies(moving[j], *fields[j])
        yield from ((j, name, entries[name]) for name in wanted.get(j, ()))


def unit_energies(velocity: Twist, gravity: Vector = ZERO, depth: Scalar = 0) -> dict[str, Scalar]:
    """Derivatives of w^T J w / 2 + MS . (v x w) + M v^2 / 2 - g . (M P + MS) by the inertial parameters.

    Everything is in the frame of the body; `depth` is g . P.
    """
    v, w = velocity
    x, y, z = w
    turning = dict(zip(INERTIA, (_half(x * x), x * y, x * z, _half(y * y), y * z, _half(z * z)), strict=True))
    moments = cross(v, w) - gravity
    return {**turning, **dict(zip(MOMENTS, moments, strict=True)), "M": _half(dot(v, v)) - depth}


def _half(x: Scalar) -> Scalar:
    return 0 if is_zero(x) else x / 2
