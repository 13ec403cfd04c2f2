"""Clusters: joints that share a coordinate, with all joints between them, eliminated together.

In the backward recursion a cluster takes the place of a joint: its bodies have received everything beyond them, and
what it hands on to its antecedent p is K and al of (L26). With accelerations of the antecedent taken out,

    H udd = Gamma_u - S^T (a^T p + Ia gam) - U^T V'_p.                                               (L25), (L28)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from symoro_elastic.mechanics.coordinates import Rows, congruence, image, product
from symoro_elastic.mechanics.factorization import Factorization, factorization, share_or_one, solution
from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    NO_WRENCH,
    ArticulatedInertia,
    Axis,
    Scalar,
    Twist,
    Wrench,
)


@dataclass(frozen=True)
class Members:
    """Links of a cluster in the order of the table, and its antecedent, 0 for the base."""

    antecedent: int
    links: tuple[int, ...]


@dataclass(frozen=True)
class Cluster:
    """A cluster with its coordinates: rows of S and gam by joint, forces on the free coordinates.

    Coordinates whose acceleration is known have a column in S, and their share in `gam`, but are not `free`.
    """

    members: Members
    S: Rows
    gam: Mapping[int, Scalar]
    free: tuple[int, ...]
    Gamma: Mapping[int, Scalar]

    @property
    def first(self) -> int:
        """The link nearest to the base."""
        return self.members.links[0]

    @property
    def coordinates(self) -> tuple[int, ...]:
        """All its coordinates."""
        return tuple(sorted({k for j in self.members.links for k in self.S.get(j, ())}))


def clusters(mechanism: Mechanism, S: Rows) -> list[Members]:
    """The clusters of more than one joint: joints whose rows of S share a coordinate, and those between them."""
    groups: list[set[int]] = [{j, *row} for j, row in S.items()]
    while True:
        merged = [_with_joints_between(mechanism, group) for group in _joined(groups)]
        if merged == groups:
            break
        groups = merged
    found = [tuple(sorted(group)) for group in groups if len(group) > 1]
    return [Members(_antecedent(mechanism, links), links) for links in sorted(found)]


def _joined(groups: Iterable[set[int]]) -> list[set[int]]:
    """Groups that share a joint, united."""
    found: list[set[int]] = []
    for group in groups:
        apart = [other for other in found if not other & group]
        found = [*apart, group.union(*(other for other in found if other & group))]
    return found


def _with_joints_between(mechanism: Mechanism, group: set[int]) -> set[int]:
    if len(group) == 1:
        return group
    p = _antecedent(mechanism, tuple(sorted(group)))
    between = set(group)
    for j in group:
        carriers = [j, *_carriers(mechanism, j)]
        between.update(carriers[: carriers.index(p)])
    return between


def _antecedent(mechanism: Mechanism, links: Sequence[int]) -> int:
    """The nearest link that carries all these links and is none of them."""
    paths = [_carriers(mechanism, j) for j in links]
    common = [i for i in paths[0] if all(i in path for path in paths)]
    return max((i for i in common if i not in links), default=0)


def _carriers(mechanism: Mechanism, j: int) -> list[int]:
    """Links that carry link j, from the nearest to the base."""
    return [0, *path(mechanism, j)[:-1]][::-1]


@dataclass(frozen=True)
class Eliminated:
    """K and al of a cluster in the frame of its antecedent, and what its accelerations are found from.

    U holds the wrenches at the antecedent for a unit of each coordinate's acceleration, `rest` the force that each
    coordinate needs with the free accelerations and those of the antecedent zero; the latter count already where the
    cluster is `started` from them.
    """

    K: ArticulatedInertia
    alpha: Wrench
    U: Mapping[int, Wrench]
    H: Mapping[int, Mapping[int, Scalar]]
    factors: Factorization
    rho: Mapping[int, Scalar]
    rest: Mapping[int, Scalar]
    started: bool


@dataclass(frozen=True)
class Moved:
    """Accelerations of the free coordinates and of the joints, forces on coordinates of known acceleration."""

    udd: Mapping[int, Scalar]
    qdd: Mapping[int, Scalar]
    Gamma_u: Mapping[int, Scalar]


@dataclass
class _Reduction:
    """Quantities by link while a cluster is reduced."""

    J: dict[int, ArticulatedInertia] = field(default_factory=dict)
    p: dict[int, Wrench] = field(default_factory=dict)
    A: dict[int, dict[int, Scalar]] = field(default_factory=dict)
    Phi: dict[int, Wrench] = field(default_factory=dict)


def eliminate_cluster(
    mechanism: Mechanism,
    cluster: Cluster,
    Js: Mapping[int, ArticulatedInertia],
    betas: Mapping[int, Wrench],
    gamma: Sequence[Twist],
    start: Twist | None = None,
) -> Eliminated:
    """Eliminate the free coordinates of a cluster (L22)-(L27).

    `start` is the acceleration of the antecedent where it is known. Raises `ZeroDivisionError` where H is singular.
    """
    links, p = cluster.members.links, cluster.members.antecedent
    r = _Reduction()
    B = _bias_accelerations(mechanism, cluster, gamma, start or AT_REST)
    for j in links:
        r.J[j], r.p[j] = Js[j], Js[j] * B[j] - betas[j]
    K, alpha = ArticulatedInertia.zero(), NO_WRENCH
    for j in reversed(links):
        link = mechanism.link(j)
        i = link.antecedent
        _columns(mechanism, r, j, p)
        moved = r.J[j].rotated_back(link.joint_rotation).to_antecedent(link.before)
        push = link.transform.T * r.p[j]
        if i == p:
            K, alpha = K + moved, alpha + push
        else:
            r.J[i], r.p[i] = r.J[i] + moved, r.p[i] + push  # (L23)
    return _solved(mechanism, cluster, r, K, alpha, start is not None)


def _bias_accelerations(
    mechanism: Mechanism, cluster: Cluster, gamma: Sequence[Twist], start: Twist
) -> dict[int, Twist]:
    B = {cluster.members.antecedent: start}
    for j in cluster.members.links:
        link = mechanism.link(j)
        moved = link.before * B[link.antecedent] + gamma[j]
        B[j] = link.joint_rotation * moved + cluster.gam.get(j, 0) * link.axis  # (L22)
    return B


def _columns(mechanism: Mechanism, r: _Reduction, j: int, p: int) -> None:
    """Column j of A, and the wrench at the antecedent p for a unit of the joint's acceleration (L24)."""
    link = mechanism.link(j)
    r.A.setdefault(j, {})
    if link.axis is Axis.NONE:
        return
    F = r.J[j] * link.axis
    r.A[j][j] = link.axis.T * F + link.rotor_inertia
    i = j
    while (carrier := mechanism.link(i).antecedent) != p:
        F, i = mechanism.link(i).transform.T * F, carrier
        axis = mechanism.link(i).axis
        if axis is not Axis.NONE:
            r.A.setdefault(i, {})[j] = r.A[j][i] = axis.T * F
    r.Phi[j] = mechanism.link(i).transform.T * F


def _solved(
    mechanism: Mechanism, cluster: Cluster, r: _Reduction, K: ArticulatedInertia, alpha: Wrench, started: bool
) -> Eliminated:
    S, free = cluster.S, cluster.free
    H = congruence(S, r.A, cluster.coordinates)
    U = dict.fromkeys(cluster.coordinates, NO_WRENCH)
    rest: dict[int, Scalar] = dict.fromkeys(cluster.coordinates, 0)
    for j, row in S.items():
        link = mechanism.link(j)
        needed = link.axis.T * r.p[j] + link.rotor_inertia * cluster.gam.get(j, 0)
        for k, x in row.items():
            U[k] = U[k] + x * r.Phi[j]
            rest[k] = rest[k] + x * needed
    rho = {k: cluster.Gamma[k] - rest[k] for k in free}
    factors = factorization(sorted(free, reverse=True), H, share_or_one)
    reduced = {k: U[k] for k in free}
    for k, row in factors.L.items():
        for i, x in row.items():
            reduced[i] = reduced[i] - x * reduced[k]
        K = K.without_outer(reduced[k], reduced[k] * factors.inverses[k])
    for k, x in solution(factors, rho).items():
        alpha = alpha + U[k] * x
    return Eliminated(K, alpha, U, H, factors, rho, rest, started)


def motion(e: Eliminated, cluster: Cluster, V: Twist) -> Moved:
    """Accelerations of the cluster from that of its antecedent, forces on its other coordinates (L28), (L29)."""
    pushed: Mapping[int, Scalar] = dict.fromkeys(e.U, 0) if e.started else {k: U.dot(V) for k, U in e.U.items()}
    udd = solution(e.factors, {k: x - pushed[k] for k, x in e.rho.items()})  # (L28)
    known = [k for k in cluster.coordinates if k not in udd]
    needed = {k: e.rest[k] + pushed[k] + product({i: e.H[k][i] for i in udd}, udd) for k in known}  # (L29)
    return Moved(udd, image(cluster.S, udd, cluster.gam), needed)
