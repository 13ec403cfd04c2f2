"""Clusters and elastic cells in place of joints: their part in both recursions of `dynamics`."""

from __future__ import annotations

from symoro_elastic.mechanics.clusters import Cluster, eliminate_cluster, motion
from symoro_elastic.mechanics.dynamic_quantities import Dynamics
from symoro_elastic.mechanics.elastic_cells import ElasticCell, cell_qdd, eliminate_cell
from symoro_elastic.mechanics.elimination import SingularPivot
from symoro_elastic.mechanics.kinematics import Scalars
from symoro_elastic.mechanics.mechanism import Link
from symoro_elastic.mechanics.spatial import AT_REST, Twist


def reduce(s: Dynamics, j: int, o: int, rule: Cluster) -> None:
    """Eliminate a cluster in the backward recursion, in place of joint j; o is its antecedent."""
    B_o = s.remainder.get(o, AT_REST)
    s.reduced[j] = e = eliminate_cluster(s.mechanism, rule, s.Js, s.betas, s.gamma, B_o, s.flexible, s.bias)
    if o not in s.vd:
        s.Js[o], s.betas[o] = s.Js[o] + e.K, s.betas[o] - e.alpha  # (L27)
    elif o in s.f:
        s.f[o] = s.f[o] + e.alpha  # (15)


def suspend(s: Dynamics, j: int, o: int, cell: ElasticCell) -> None:
    """Eliminate an elastic cell in the backward recursion; j is the body that it carries, o its antecedent."""
    try:
        s.cells[j] = e = eliminate_cell(s.mechanism, cell, s.w, s.Js[j], s.betas[j])
    except ZeroDivisionError:
        raise SingularPivot(j) from None
    s.f[j] = e.f
    if o not in s.vd:
        s.betas[o] = s.betas[o] - e.alpha  # (L45)
    elif o in s.f:
        s.f[o] = s.f[o] + e.alpha  # (15)


def follow(s: Dynamics, j: int, link: Link, cluster: Cluster) -> None:
    """Set the acceleration of a body of a cluster; at the first link, those of all coordinates of the cluster."""
    if j == cluster.first:
        o = cluster.members.antecedent
        s.moved[j] = motion(s.reduced[j], cluster, s.remainder[o] if o in s.Js else AT_REST)
        s.qdd.update(s.moved[j].qdd)
    _move(s, j, link)


def follow_cell(s: Dynamics, j: int, link: Link, cell: ElasticCell, qd: Scalars) -> None:
    """Set the acceleration of a body of an elastic cell; at the first link, those of all joints of the cell."""
    e, o = s.cells[cell.end], link.antecedent
    if j == cell.links[0]:
        s.qdd.update(cell_qdd(cell, e, s.w, qd, Twist(s.vd[o], s.wd[o])))
        s.Gamma.update(cell.Gamma)
    if j == cell.end:
        s.vd[j], s.wd[j] = s.remainder[j] = e.V
    else:
        _move(s, j, link)


def _move(s: Dynamics, j: int, link: Link) -> None:
    """Set the acceleration of a body whose joint acceleration is known."""
    V = link.before * s.remainder[link.antecedent] + s.gamma[j]
    s.remainder[j] = link.joint_rotation * V + s.qdd.get(j, 0) * link.axis  # (L28)
    s.vd[j], s.wd[j] = s.bias[j] + s.remainder[j]
