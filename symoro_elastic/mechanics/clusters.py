"""Clusters: joints that share a coordinate, with all joints between them, eliminated together.

In the backward recursion a cluster replaces a joint: its bodies have received everything beyond them, and
what its antecedent o feels is

    f = K V'_o + alpha,   with   H udd = rho - U^T V'_o.

Symbols and equations (L22)-(L29) are those of docs/loop_equations.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from symoro_elastic.mechanics.coordinates import Rows, congruence, joint_accelerations, product
from symoro_elastic.mechanics.factorization import Factorization, factorization, share_or_one, solution
from symoro_elastic.mechanics.flexible_inertia import ModalMotion
from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import AT_REST, NO_WRENCH, ArticulatedInertia, Axis, Outer, Scalar, Twist, Wrench

NO_MODES: Mapping[int, ModalMotion] = MappingProxyType({})
NO_BIAS: Mapping[int, Twist] = MappingProxyType({})


@dataclass(frozen=True)
class Members:
    """Links of a cluster in the order of the table, and its antecedent, 0 for the base."""

    antecedent: int
    links: tuple[int, ...]


@dataclass(frozen=True)
class Cluster:
    """Joints with common coordinates, which are eliminated together: rows of S, gam by joint, forces on coordinates.

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
        """Numbers of all coordinates on which the joints of the cluster depend."""
        return tuple(sorted({k for j in self.members.links for k in self.S.get(j, ())}))


def clusters(mechanism: Mechanism, S: Rows) -> list[Members]:
    """The clusters: joints whose rows of S share a coordinate, modes of one body, and the joints between them.

    A joint that shares nothing is no cluster, but a mode is.
    """
    modal = mechanism.modes
    groups: list[set[int]] = [{j, *row, *({*modal[j].numbers} & {*S} if j in modal else ())} for j, row in S.items()]
    while True:
        merged = [_with_joints_between(mechanism, group) for group in _join(groups)]
        if merged == groups:
            break
        groups = merged
    together = [tuple(sorted(group)) for group in groups if len(group) > 1 or group & {*modal}]
    return [Members(_antecedent(mechanism, links), links) for links in sorted(together)]


def _join(groups: Iterable[set[int]]) -> list[set[int]]:
    """Groups that share a joint, united."""
    united: list[set[int]] = []
    for group in groups:
        apart = [other for other in united if not other & group]
        united = [*apart, group.union(*(other for other in united if other & group))]
    return united


def _with_joints_between(mechanism: Mechanism, group: set[int]) -> set[int]:
    if len(group) == 1:
        return group
    o = _antecedent(mechanism, tuple(sorted(group)))
    between = set(group)
    for j in group:
        carriers = [j, *_carriers(mechanism, j)]
        between.update(carriers[: carriers.index(o)])
    return between


def _antecedent(mechanism: Mechanism, links: Sequence[int]) -> int:
    """The nearest link that carries all these links and is not one of them."""
    paths = [_carriers(mechanism, j) for j in links]
    common = [i for i in paths[0] if all(i in path for path in paths)]
    return max((i for i in common if i not in links), default=0)


def _carriers(mechanism: Mechanism, j: int) -> list[int]:
    """Links that carry link j, from the nearest to the base."""
    return [0, *path(mechanism, j)[:-1]][::-1]


@dataclass(frozen=True)
class ClusterElimination:
    """K and alpha of a cluster in the frame of its antecedent, and the data of its accelerations (L25), (L26).

    U holds a wrench at the antecedent, eta and H forces by coordinate; `factors` are those of H of the free ones.
    """

    K: ArticulatedInertia
    alpha: Wrench
    U: Mapping[int, Wrench]
    H: Mapping[int, Mapping[int, Scalar]]
    factors: Factorization
    rho: Mapping[int, Scalar]
    eta: Mapping[int, Scalar]


@dataclass(frozen=True)
class ClusterMotion:
    """Accelerations of the free coordinates and of the joints, forces on coordinates of known acceleration."""

    udd: Mapping[int, Scalar]
    qdd: Mapping[int, Scalar]
    Gamma_u: Mapping[int, Scalar]


@dataclass(frozen=True)
class _Tree:
    """Composite inertias J^c and wrenches p of the links of a cluster, matrix A and wrenches Phi of its joints."""

    Jc: dict[int, ArticulatedInertia]
    p: dict[int, Wrench]
    A: dict[int, dict[int, Scalar]]
    Phi: dict[int, Wrench]


def eliminate_cluster(
    mechanism: Mechanism,
    cluster: Cluster,
    Js: Mapping[int, ArticulatedInertia],
    betas: Mapping[int, Wrench],
    gamma: Sequence[Twist],
    B_o: Twist,
    flexible: Mapping[int, ModalMotion] = NO_MODES,
    bias: Mapping[int, Twist] = NO_BIAS,
) -> ClusterElimination:
    """Eliminate the free coordinates of a cluster.

    `B_o` is the acceleration of the antecedent o that is known, zero where none is. `flexible` are the motions of
    modes by number, `bias` the parts of the bodies' accelerations that B does not have. Raises `ZeroDivisionError`
    where H is singular.
    """
    B = _bias_accelerations(mechanism, cluster, gamma, B_o)
    tree = _tree(mechanism, cluster, Js, betas, B, flexible)
    H, U, eta = _of_coordinates(mechanism, cluster, tree)
    for j, force in _on_modes(mechanism, cluster, B, flexible, bias).items():
        for k, x in cluster.S[j].items():
            eta[k] = eta[k] + x * force  # (L55)
    rho = {k: cluster.Gamma[k] - eta[k] for k in cluster.free}  # (L25)
    factors = factorization(sorted(cluster.free, reverse=True), H, share_or_one)
    K, alpha = tree.Jc[cluster.members.antecedent], tree.p[cluster.members.antecedent]
    UL = {k: U[k] for k in cluster.free}
    for k, row in factors.L.items():
        for i, x in row.items():
            UL[i] = UL[i] - x * UL[k]  # columns of U L^-1
        K = K - Outer(UL[k], UL[k] * factors.inverses[k])  # (L26)
    for k, x in solution(factors, rho).items():
        alpha = alpha + U[k] * x  # (L26)
    return ClusterElimination(K, alpha, U, H, factors, rho, eta)


def _bias_accelerations(mechanism: Mechanism, cluster: Cluster, gamma: Sequence[Twist], B_o: Twist) -> dict[int, Twist]:
    B = {cluster.members.antecedent: B_o}
    for j in cluster.members.links:
        link = mechanism.link(j)
        jB_i = link.before * B[link.antecedent] + gamma[j]
        B[j] = link.joint_rotation * jB_i + cluster.gam.get(j, 0) * link.axis  # (L22)
    return B


def _tree(
    mechanism: Mechanism,
    cluster: Cluster,
    Js: Mapping[int, ArticulatedInertia],
    betas: Mapping[int, Wrench],
    B: Mapping[int, Twist],
    flexible: Mapping[int, ModalMotion],
) -> _Tree:
    o, links = cluster.members.antecedent, cluster.members.links
    Jc = {o: ArticulatedInertia.zero(), **{j: Js[j] for j in links}}
    p = {o: NO_WRENCH, **{j: Js[j] * B[j] - betas[j] for j in links}}
    for j in flexible.keys() & {*links} & cluster.gam.keys():
        carrier = mechanism.link(j).antecedent
        p[carrier] = p[carrier] + cluster.gam[j] * flexible[j].U[j]  # (L55)
    tree = _Tree(Jc, p, {}, {})
    for j in reversed(links):
        link = mechanism.link(j)
        i = link.antecedent
        _add_joint(mechanism, tree, j, o, flexible)
        Jc_at_i = Jc[j].rotated_back(link.joint_rotation).to_antecedent(link.before)
        p_at_i = link.transform.T * p[j]
        Jc[i], p[i] = Jc[i] + Jc_at_i, p[i] + p_at_i  # (L23)
    return tree


def _add_joint(mechanism: Mechanism, tree: _Tree, j: int, o: int, flexible: Mapping[int, ModalMotion]) -> None:
    """Add column j of the matrix A of a cluster, and the wrench Phi_j at the antecedent o."""
    link, A = mechanism.link(j), tree.A
    A.setdefault(j, {})
    if link.axis is Axis.NONE:
        return
    i = j
    if j in flexible:
        F, i = flexible[j].U[j], link.antecedent
        A[j].update(flexible[j].modes.masses(j))  # (L55)
        if i == o:
            tree.Phi[j] = F
            return
        axis = mechanism.link(i).axis
        if axis is not Axis.NONE:
            A.setdefault(i, {})[j] = A[j][i] = axis.T * F
    else:
        F = tree.Jc[j] * link.axis
        A[j][j] = link.axis.T * F + link.rotor_inertia  # (L24)
    while (carrier := mechanism.link(i).antecedent) != o:
        F, i = mechanism.link(i).transform.T * F, carrier
        axis = mechanism.link(i).axis
        if axis is not Axis.NONE:
            A.setdefault(i, {})[j] = A[j][i] = axis.T * F  # (L24)
    tree.Phi[j] = mechanism.link(i).transform.T * F  # (L24)


def _of_coordinates(
    mechanism: Mechanism, cluster: Cluster, tree: _Tree
) -> tuple[dict[int, dict[int, Scalar]], dict[int, Wrench], dict[int, Scalar]]:
    """H, U and eta of a cluster over its coordinates: H = S^T A S, and the projections of Phi and p (L25)."""
    H = congruence(cluster.S, tree.A, cluster.coordinates)
    U = dict.fromkeys(cluster.coordinates, NO_WRENCH)
    eta: dict[int, Scalar] = dict.fromkeys(cluster.coordinates, 0)
    for j, row in cluster.S.items():
        a, Ia = mechanism.link(j).axis, mechanism.link(j).rotor_inertia
        force = a.T * tree.p[j] + Ia * cluster.gam.get(j, 0)
        for k, x in row.items():
            U[k] = U[k] + x * tree.Phi[j]  # (L25)
            eta[k] = eta[k] + x * force  # (L25)
    return H, U, eta


def _on_modes(
    mechanism: Mechanism,
    cluster: Cluster,
    B: Mapping[int, Twist],
    flexible: Mapping[int, ModalMotion],
    bias: Mapping[int, Twist],
) -> dict[int, Scalar]:
    """Forces on the modes of a cluster by velocities and known accelerations, by number."""
    forces: dict[int, Scalar] = {}
    for j in flexible.keys() & {*cluster.members.links}:
        carrier = mechanism.link(j).antecedent
        V = B[carrier] + bias.get(carrier, AT_REST)
        edd = {k: cluster.gam[k] for k in flexible[j].modes.numbers if k in cluster.gam}
        forces[j] = flexible[j].force(j, V, edd)
    return forces


def motion(e: ClusterElimination, cluster: Cluster, V_o: Twist) -> ClusterMotion:
    """Accelerations of a cluster, and forces on its coordinates of known acceleration.

    `V_o` is the acceleration of the antecedent o, zero where B started from it.
    """
    UV = {k: U.dot(V_o) for k, U in e.U.items()}
    udd = solution(e.factors, {k: rho - UV[k] for k, rho in e.rho.items()})  # (L28)
    fixed = [k for k in cluster.coordinates if k not in udd]
    Gamma = {k: e.eta[k] + UV[k] + product({f: e.H[k][f] for f in udd}, udd) for k in fixed}  # (L29)
    return ClusterMotion(udd, joint_accelerations(cluster.S, udd, cluster.gam), Gamma)
