"""Elastic cells: six elastic joints between two bodies, with no mass and no rotor between them, eliminated together.

Three slides along perpendicular axes carry three turns about axes through one point O. Their springs and dampers
determine the wrench on both bodies, whatever the accelerations are: K of the cell is exactly zero, and the carried body
accelerates by its own articulated inertia.

Symbols and equations (L43)-(L49) are those of docs/loop_equations.md.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from symoro_elastic.mechanics.base_body import Solution, base_acceleration, solve_symmetric
from symoro_elastic.mechanics.kinematics import coriolis
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.newton_euler import bias_wrench
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    EZ,
    NO_WRENCH,
    ArticulatedInertia,
    Axis,
    RigidInertia,
    Scalar,
    Symmetric,
    Transform,
    Twist,
    Vector,
    Wrench,
    cross,
    dot,
    hat_plus_hat_squared,
    is_zero,
)

MASSLESS = RigidInertia()


@dataclass(frozen=True)
class ElasticCell:
    """Six elastic joints from the base outwards, and the forces of their springs, dampers and friction by joint."""

    links: tuple[int, ...]
    Gamma: Mapping[int, Scalar]

    @property
    def end(self) -> int:
        """Number of the last link of the cell, which has the mass."""
        return self.links[-1]


def elastic_cells(mechanism: Mechanism, elastic: Collection[int]) -> list[tuple[int, ...]]:
    """Links of every cell among the elastic joints, by structure that holds for all values of the parameters."""
    children: dict[int, list[int]] = {}
    for j, link in mechanism.from_base():
        children.setdefault(link.antecedent, []).append(j)
    cells: list[tuple[int, ...]] = []
    for j, _ in mechanism.from_base():
        links = [j]
        while len(links) < 6 and len(children.get(links[-1], ())) == 1:
            links += children[links[-1]]
        if len(links) == 6 and {*links} <= {*elastic} and _is_cell([mechanism.link(k) for k in links]):
            cells.append(tuple(links))
    return cells


def _is_cell(links: Sequence[Link]) -> bool:
    if [link.axis for link in links] != [Axis.PRISMATIC] * 3 + [Axis.REVOLUTE] * 3:
        return False
    if any(link.body != MASSLESS or link.wrench != NO_WRENCH for link in links[:-1]):
        return False
    _, second, third, _, *turns = links
    across = third.before.to_child(second.transform.to_child(EZ)).z
    cosines = (across, *(link.before.to_child(EZ).z for link in (second, third, *turns)))
    shifts = (step.shift for link in turns for step in link.before.steps)
    zeros = (*cosines, *shifts, *(link.rotor_inertia for link in links))
    return all(map(is_zero, zeros)) and all(link.before.permutes for link in turns)


def join_bodies(mechanism: Mechanism, ends: Collection[int]) -> Mechanism:
    """The mechanism in which bodies on fixed frames belong to the bodies at ends of cells that they are fixed to.

    The inertia of a body that carries nothing else then is constant.
    """
    rigid, links = {*ends}, list(mechanism.links)
    rigid.update(j for j, link in mechanism.from_base() if link.axis is Axis.NONE and link.antecedent in rigid)
    for j, link in mechanism.from_tips():
        if j in rigid and j not in ends:
            i = link.antecedent - 1
            body = links[i].body + links[j - 1].body.to_antecedent(link.transform)
            links[i], links[j - 1] = replace(links[i], body=body), replace(links[j - 1], body=MASSLESS)
    return replace(mechanism, links=tuple(links))


@dataclass(frozen=True)
class CellGeometry:
    """An elastic cell at a position: transform `to_point` from antecedent o to O, past the slides, `turns` to body j.

    `axes` are z_1, z_2, z_3 in frame o, u is z_4 in the frame before the second turn, v is z_6 in the frame after it.
    """

    links: tuple[Link, ...]
    axes: tuple[Vector, ...]
    to_point: Transform
    turns: Transform
    u: Vector
    v: Vector
    s: Scalar
    h: Scalar


@dataclass(frozen=True)
class CentralInertia:
    """A rigid body by its centre of mass c and the inertia J about it, constant in its frame, and their inverses."""

    Minv: Scalar
    c: Vector
    J: Symmetric
    Jinv: Symmetric


@dataclass(frozen=True)
class CellElimination:
    """Wrenches that a cell exerts on its antecedent and on the body it carries, and the acceleration of this body."""

    geometry: CellGeometry
    alpha: Wrench
    f: Wrench
    inertia: CentralInertia | Solution
    V: Twist


def eliminate_cell(
    mechanism: Mechanism, cell: ElasticCell, w: Sequence[Vector], Js: ArticulatedInertia, betas: Wrench
) -> CellElimination:
    """Wrenches of a cell (L43)-(L45), and the acceleration of its carried body (L46), (L47).

    `Js` and `betas` are what bodies beyond the carried one add to it. Raises `ZeroDivisionError` where a motion of the
    carried body meets no inertia.
    """
    g = _geometry(mechanism, cell)
    force, before, after = _wrench(g, [cell.Gamma[j] for j in cell.links])
    on_o = Wrench(force, g.to_point.to_antecedent(before) + cross(g.to_point.origin, force))  # (L45)
    f = Wrench(g.turns.to_child(g.to_point.to_child(force)), g.links[5].transform.to_child(after))  # (L45)
    body, w_j = g.links[5].body, w[cell.end]
    if all(is_zero(x) for row in Js.rows for x in row):
        central = _central(body)
        return CellElimination(g, on_o, f, central, _alone(central, w_j, f + betas))
    solution = base_acceleration(body.spatial + Js, f + betas + bias_wrench(body, w_j, AT_REST))  # (L46)
    return CellElimination(g, on_o, f, solution, solution.twist)


def _geometry(mechanism: Mechanism, cell: ElasticCell) -> CellGeometry:
    links = tuple(mechanism.link(j) for j in cell.links)
    fourth, fifth, sixth = links[3:]
    slides = [Transform(tuple(step for link in links[:k] for step in link.transform.steps)) for k in (1, 2, 3)]
    turns = Transform((fourth.joint_rotation.step, *fifth.transform.steps, *sixth.transform.steps))
    u, v = fifth.before.to_child(EZ), sixth.before.to_antecedent(EZ)
    z_6 = fifth.joint_rotation.step.rotate(v)
    s, h = dot(z_6, u), 1 / dot(z_6, cross(EZ, u))  # (L44)
    axes = tuple(slide.to_antecedent(EZ) for slide in slides)
    return CellGeometry(links, axes, fourth.before.after(slides[2]), turns, u, v, s, h)


def _wrench(g: CellGeometry, Gamma: Sequence[Scalar]) -> tuple[Vector, Vector, Vector]:
    """Force in frame o, moment before the first turn, and the same moment after the second turn."""
    force = _combination(Gamma, g.axes)  # (L43)
    Gamma_4, Gamma_5, Gamma_6 = Gamma[3:]
    along = Gamma_5 * EZ
    before = along + Gamma_4 * g.u + g.h * (Gamma_6 - g.s * Gamma_4) * cross(EZ, g.u)  # (L44)
    after = along + Gamma_6 * g.v - g.h * (Gamma_4 - g.s * Gamma_6) * cross(EZ, g.v)  # (L44)
    return force, g.links[3].joint_rotation.step.rotate(g.links[4].before.to_antecedent(before)), after


def _combination(x: Sequence[Scalar], axes: Sequence[Vector]) -> Vector:
    return x[0] * axes[0] + x[1] * axes[1] + x[2] * axes[2]


def _central(body: RigidInertia) -> CentralInertia:
    Minv = 1 / body.mass
    c = Minv * body.moments
    J = RigidInertia.about_center(-body.mass, c, body.inertia).inertia
    columns = [solve_symmetric(J.full, e).x for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = columns
    return CentralInertia(Minv, c, J, Symmetric(xx, xy, xz, yy, yz, zz))


def _alone(body: CentralInertia, w: Vector, f: Wrench) -> Twist:
    """Acceleration of a body that carries nothing but cells, under the wrench f, by that of its centre of mass."""
    wd = body.Jinv * (f.moment - cross(body.c, f.force) - cross(w, body.J * w))  # (L47)
    return Twist(body.Minv * f.force - hat_plus_hat_squared(w, wd) * body.c, wd)  # (L47)


def cell_qdd(
    cell: ElasticCell, e: CellElimination, w: Sequence[Vector], qd: Sequence[Scalar], V_o: Twist
) -> dict[int, Scalar]:
    """Accelerations of the six joints from those of the carried body and of the antecedent, without gravity."""
    rates = [qd[j] for j in cell.links]
    qdd = (*_of_slides(e, w, rates, V_o), *_of_turns(e, w, rates, V_o.angular))
    return dict(zip(cell.links, qdd, strict=True))


def _of_slides(e: CellElimination, w: Sequence[Vector], qd: Sequence[Scalar], V_o: Twist) -> list[Scalar]:
    g, w_o, rate = e.geometry, w[e.geometry.links[0].antecedent], _combination(qd, e.geometry.axes)
    carried = V_o.linear + hat_plus_hat_squared(w_o, V_o.angular) * g.to_point.origin + cross(w_o, rate + rate)
    relative = g.to_point.to_antecedent(g.turns.to_antecedent(e.V.linear)) - carried
    return [dot(axis, relative) for axis in g.axes]  # (L49)


def _of_turns(e: CellElimination, w: Sequence[Vector], qd: Sequence[Scalar], wd_o: Vector) -> tuple[Scalar, ...]:
    g, sixth, wd = e.geometry, e.geometry.links[5], wd_o
    for link, rate in zip(g.links[:5], qd, strict=False):
        wd = link.transform.to_child(wd) + coriolis(link, w[link.antecedent], rate).angular
    by_last = coriolis(sixth, w[sixth.antecedent], qd[5]).angular
    d = sixth.transform.to_antecedent(e.V.angular - by_last) - wd
    first = -g.h * dot(d, cross(EZ, g.v))
    return first, d.z, dot(d, g.v) - g.s * first  # (L48)
