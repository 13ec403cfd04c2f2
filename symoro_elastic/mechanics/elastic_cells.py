"""Elastic cells: six elastic joints in a row without masses or rotors between them, eliminated together.

Three slides along perpendicular axes carry three turns about axes that meet in one point O. As nothing between the
antecedent o and the carried body j has inertia, forces of springs and dampers determine the wrench on both, whatever
the accelerations are: K of the cell is exactly zero, and body j accelerates by its own articulated inertia.

Symbols and equations (E1)-(E8) are those of docs/elastic_cells.md.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from symoro_elastic.mechanics.base_body import base_acceleration, solve_symmetric
from symoro_elastic.mechanics.elimination import SingularPivot
from symoro_elastic.mechanics.kinematics import coriolis
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.newton_euler import bias_wrench
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    EZ,
    NO_WRENCH,
    ZERO,
    ArticulatedInertia,
    Axis,
    RigidInertia,
    Scalar,
    Transform,
    Twist,
    Vector,
    Wrench,
    cross,
    dot,
    hat_plus_hat_squared,
    is_zero,
)

Six = tuple[int, int, int, int, int, int]
SLIDES, TURNS = slice(0, 3), slice(3, 6)


@dataclass(frozen=True)
class ElasticCell:
    """Six elastic joints, slides before turns, and the forces of their springs, dampers and friction."""

    links: Six
    Gamma: Mapping[int, Scalar]

    @property
    def first(self) -> int:
        """The link nearest to the base."""
        return self.links[0]

    @property
    def last(self) -> int:
        """The carried body."""
        return self.links[-1]


@dataclass(frozen=True)
class CellElimination:
    """Wrench on the antecedent in its frame, wrench and acceleration of the carried body in the frame of that.

    `inverse` is h and `sine` sigma of (E2).
    """

    on_antecedent: Wrench
    f: Wrench
    V: Twist
    inverse: Scalar
    sine: Scalar


def elastic_cells(mechanism: Mechanism, elastic: Collection[int]) -> list[Six]:
    """The cells among the elastic joints, by structure: what holds for all values of the parameters."""
    children: dict[int, list[int]] = {}
    for j, link in mechanism.from_base():
        children.setdefault(link.antecedent, []).append(j)
    cells: list[Six] = []
    for first, _ in mechanism.from_base():
        links = [first]
        while len(links) < 6 and len(children.get(links[-1], ())) == 1:
            links += children[links[-1]]
        taken = any(first in cell for cell in cells)
        if len(links) == 6 and not taken and {*links} <= {*elastic} and _is_cell(mechanism, links):
            a, b, c, d, e, f = links
            cells.append((a, b, c, d, e, f))
    return cells


def _is_cell(mechanism: Mechanism, numbers: Sequence[int]) -> bool:
    links = [mechanism.link(j) for j in numbers]
    axes = [link.axis for link in links]
    massless = all(link.body == RigidInertia() and link.wrench == NO_WRENCH for link in links[:-1])
    if axes != [Axis.PRISMATIC] * 3 + [Axis.REVOLUTE] * 3 or not massless:
        return False
    if not all(is_zero(link.rotor_inertia) for link in links):
        return False
    meet = all(is_zero(step.shift) for link in links[4:] for step in link.before.steps)
    perpendicular = all(is_zero(link.before.to_child(EZ).z) for link in (*links[1:3], *links[4:]))
    across = links[2].before.to_child(links[1].transform.to_child(EZ))
    quarter = all(link.before.permutes for link in links[4:])
    return meet and perpendicular and quarter and is_zero(across.z)


def eliminate_cell(
    mechanism: Mechanism, cell: ElasticCell, w: Sequence[Vector], Js: ArticulatedInertia, betas: Wrench
) -> CellElimination:
    """Wrenches of a cell, and the acceleration of the body that it carries.

    `Js` and `betas` are what the links beyond add to the body's own inertia and velocity terms. Raises `SingularPivot`
    where a motion of the body meets no inertia.
    """
    links, Gamma = [mechanism.link(j) for j in cell.links], [cell.Gamma[j] for j in cell.links]
    force = ZERO
    for link, push in zip(links[SLIDES], Gamma[SLIDES], strict=True):
        force = link.transform.to_child(force) + push * EZ  # (E1)
    G4, G5, G6 = Gamma[TURNS]
    u, v = _fixed_axes(links)
    z6 = links[4].joint_rotation.T * Twist(v, v)
    e, n = cross(EZ, u), cross(EZ, v)
    h, sine = 1 / dot(z6.linear, e), dot(z6.linear, u)
    before = G4 * u + G5 * EZ + h * (G6 - sine * G4) * e  # (E2)
    after = G6 * v + G5 * EZ - h * (G4 - sine * G6) * n  # (E2)
    carried = force
    for link in links[TURNS]:
        carried = link.transform.to_child(carried)
    f = Wrench(carried, links[5].transform.to_child(after))  # (E3)
    moment = links[3].transform.to_antecedent(links[4].before.to_antecedent(before))
    on_o = Wrench(links[3].transform.to_antecedent(links[3].transform.to_child(force)), moment)
    on_o = Wrench(links[3].before.to_antecedent(links[3].before.to_child(force)), moment)
    return CellElimination(_at_antecedent(links, force, moment), f, _acceleration(links[5], cell.last, w[cell.last], Js, f + betas), h, sine)


def _at_antecedent(links: Sequence[Link], force: Vector, moment: Vector) -> Wrench:
    shift = Transform(links[3].before.steps)
    to_o = Transform(tuple(step for link in links[:3] for step in link.transform.steps))
    return to_o.T * Wrench(force, moment + cross(shift.origin, force))


def _fixed_axes(links: Sequence[Link]) -> tuple[Vector, Vector]:
    """z_4 in the frame before the second turn, and z_6 in the frame after it: constant, perpendicular to z_5."""
    return links[4].before.to_child(EZ), links[5].before.to_antecedent(EZ)


def _acceleration(link: Link, j: int, w: Vector, Js: ArticulatedInertia, f: Wrench) -> Twist:
    try:
        if all(is_zero(x) for row in Js.rows for x in row):
            return _of_rigid_body(link.body, w, f)
        return base_acceleration(link.body.spatial + Js, f + bias_wrench(link.body, w, AT_REST)).twist  # (E4)
    except ZeroDivisionError:
        raise SingularPivot(j) from None


def _of_rigid_body(body: RigidInertia, w: Vector, f: Wrench) -> Twist:
    """Acceleration of a body under the wrench f alone, by its inertia about the centre of mass, which is constant."""
    c = (1 / body.mass) * body.moments
    (x, y, z), (mx, my, mz) = c, body.moments
    xx, xy, xz, yy, yz, zz = body.inertia
    rows = (
        (xx - (y * my + z * mz), xy + x * my, xz + x * mz),
        (xy + x * my, yy - (x * mx + z * mz), yz + y * mz),
        (xz + x * mz, yz + y * mz, zz - (x * mx + y * my)),
    )
    columns = [solve_symmetric(rows, e).x for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    J_w = Vector(*(dot(Vector(*row), w) for row in rows))
    moment = f.moment - cross(c, f.force) - cross(w, J_w)
    wd = Vector(*(dot(Vector(*(columns[max(i, k)][min(i, k)] for k in range(3))), moment) for i in range(3)))  # (E5)
    return Twist((1 / body.mass) * f.force - hat_plus_hat_squared(w, wd) * c, wd)  # (E5)


def joint_accelerations(
    mechanism: Mechanism, cell: ElasticCell, e: CellElimination, w: Sequence[Vector], qd: Sequence[Scalar], Vd_o: Twist
) -> dict[int, Scalar]:
    """Accelerations of the six joints from those of the carried body and of the antecedent o, gravity subtracted."""
    links, rates = [mechanism.link(j) for j in cell.links], [qd[j] for j in cell.links]
    o = links[0].antecedent
    qdd = _of_turns(links, [w[link.antecedent] for link in links], rates, e, Vd_o.angular)
    point = e.V.linear
    for link in reversed(links[TURNS]):
        point = link.transform.to_antecedent(point)
    steps = tuple(step for link in (*links[SLIDES], replace(links[3], transform=links[3].before)) for step in link.transform.steps)
    p, slide = Transform(steps).origin, ZERO
    for link, rate in zip(links[SLIDES], rates[SLIDES], strict=True):
        slide = link.transform.to_child(slide) + rate * EZ
    for link in reversed(links[SLIDES]):
        point, slide = link.transform.to_antecedent(point), link.transform.to_antecedent(slide)
    left = point - Vd_o.linear - hat_plus_hat_squared(w[o], Vd_o.angular) * p - cross(w[o], slide + slide)  # (E7)
    along = []
    for link in links[SLIDES]:
        left = link.transform.to_child(left)
        along.append(left.z)
    return dict(zip(cell.links, (*along, *qdd), strict=True))


def _of_turns(
    links: Sequence[Link], w: Sequence[Vector], qd: Sequence[Scalar], e: CellElimination, wd_o: Vector
) -> tuple[Scalar, Scalar, Scalar]:
    wd = wd_o
    for link, w_i, rate in zip(links[:5], w, qd, strict=False):
        wd = link.transform.to_child(wd) + coriolis(link, w_i, rate).angular
    last = links[5]
    delta = last.transform.to_antecedent(e.V.angular - coriolis(last, w[5], qd[5]).angular) - wd
    _, v = _fixed_axes(links)
    first = -e.inverse * dot(delta, cross(EZ, v))
    return first, delta.z, dot(delta, v) - e.sine * first  # (E6)
