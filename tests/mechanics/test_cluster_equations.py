"""Equations (L22)-(L29) of docs/loop_equations.md, in dense matrices, beside `clusters`: equal in the finite field."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from symoro_elastic.mechanics.clusters import Cluster, clusters, eliminate_cluster, motion
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import AT_REST, ArticulatedInertia, Axis, Twist, Wrench
from tests.mechanics.test_printed_forms import Draw, articulated, drawing, link, residues, vector

ANTECEDENTS = (0, 1, 2, 1, 4)
"""Of links 1 to 5: two branches, 2-3 and 4-5, on link 1."""
AXES = (Axis.PRISMATIC, Axis.REVOLUTE, Axis.PRISMATIC, Axis.NONE, Axis.REVOLUTE)
JOINTS, FREE, KNOWN = (2, 3, 5), (2, 3), 5
Dense = np.ndarray[Any, np.dtype[Any]]


def tree(draw: Draw) -> Mechanism:
    rows = zip(ANTECEDENTS, AXES, strict=True)
    return Mechanism(tuple(replace(link(draw, axis, draw()), antecedent=i) for i, axis in rows))


def transform(of: Link) -> Dense:
    """jTi as a 6x6 matrix."""
    units = (Twist(*map(type(AT_REST.linear)._make, (row[:3], row[3:]))) for row in np.eye(6, dtype=int).tolist())
    return np.array([(of.transform * unit).entries for unit in units], dtype=object).T


def axis(of: Link) -> Dense:
    return np.array((1 * of.axis).entries, dtype=object)


class Printed(NamedTuple):
    K: Dense
    alpha: Dense
    udd: Dense
    qdd: dict[int, Any]
    Gamma: Any


def as_printed(
    mechanism: Mechanism,
    S: Dense,
    gam: dict[int, Any],
    Gamma: Dense,
    Js: dict[int, ArticulatedInertia],
    betas: dict[int, Wrench],
    gamma: list[Twist],
    B_o: Twist,
    V_o: Twist,
) -> Printed:
    links = {j: mechanism.link(j) for j in range(2, 6)}
    X, a = {j: transform(of) for j, of in links.items()}, {j: axis(of) for j, of in links.items()}
    B, p, Jc = {1: np.array(B_o.entries, dtype=object)}, {}, {}
    for j, of in links.items():
        gamma_j = np.array((of.joint_rotation * gamma[j]).entries, dtype=object)
        B[j] = X[j] @ B[of.antecedent] + gamma_j + a[j] * gam.get(j, 0)  # (L22)
    for j in reversed(links):
        J = np.array(Js[j].rows, dtype=object)
        carried = [c for c, other in links.items() if other.antecedent == j]
        p[j] = J @ B[j] - np.array(betas[j].entries, dtype=object) + sum(X[c].T @ p[c] for c in carried)  # (L23)
        Jc[j] = J + sum(X[c].T @ Jc[c] @ X[c] for c in carried)  # (L23)
    to_o = {2: X[2], 3: X[3] @ X[2], 5: X[5] @ X[4]}
    A = np.array([[a[j] @ Jc[j] @ a[j] + links[j].rotor_inertia if i == j else 0 for j in JOINTS] for i in JOINTS])
    A[0, 1] = A[1, 0] = a[2] @ X[3].T @ Jc[3] @ a[3]  # (L24)
    Phi = np.array([to_o[j].T @ Jc[j] @ a[j] for j in JOINTS]).T  # (L24)
    H, U = S.T @ A @ S, Phi @ S  # (L25)
    eta = S.T @ np.array([a[j] @ p[j] + links[j].rotor_inertia * gam[j] for j in JOINTS])  # (L25)
    (b, c), (_, d), Hf, Uf = H[0, :2], H[1, :2], H[:2, :2], U[:, :2]
    Hinv = np.array([[d, -c], [-c, b]]) * (1 / (b * d - c * c))
    assert residues(*(Hf @ Hinv).ravel()) == [1, 0, 0, 1]
    rho = Gamma - eta[:2]  # (L25)
    roots = (2, 4)
    K = sum(X[r].T @ Jc[r] @ X[r] for r in roots) - Uf @ Hinv @ Uf.T  # (L26)
    alpha = sum(X[r].T @ p[r] for r in roots) + Uf @ Hinv @ rho  # (L26)
    V = np.array(V_o.entries, dtype=object)
    udd = Hinv @ (rho - Uf.T @ V)  # (L28)
    qdd = {j: row @ udd + gam[j] for j, row in zip(JOINTS, S[:, :2], strict=True)}  # (L28)
    return Printed(K, alpha, udd, qdd, eta[2] + U[:, 2] @ V + H[2, :2] @ udd)  # (L29)


@pytest.mark.parametrize("started", [False, True], ids=["unknown", "known beforehand"])
@pytest.mark.parametrize("seed", range(5))
def test_clusters_are_equations_22_to_29(seed: int, started: bool) -> None:
    """Three joints on two branches, two free coordinates and one of known acceleration, which `gam` holds."""
    draw = drawing(seed)
    mechanism = tree(draw)
    S = np.array([[draw() for _ in JOINTS] for _ in JOINTS], dtype=object)
    rows = {j: dict(zip(JOINTS, row, strict=True)) for j, row in zip(JOINTS, S, strict=True)}
    (members,) = clusters(mechanism, rows)
    assert (members.antecedent, members.links) == (1, (2, 3, 4, 5))
    gam, Gamma = {j: draw() for j in JOINTS}, {k: draw() for k in FREE}
    Js, betas = ({j: made() for j in range(1, 6)} for made in (lambda: articulated(draw), lambda: wrench(draw)))
    gamma, V_o = [twist(draw) for _ in range(6)], twist(draw)
    B_o, beyond = (V_o, AT_REST) if started else (AT_REST, V_o)

    cluster = Cluster(members, rows, gam, FREE, Gamma)
    e = eliminate_cluster(mechanism, cluster, Js, betas, gamma, B_o)
    moved = motion(e, cluster, beyond)
    forces = np.array([*Gamma.values()], dtype=object)
    printed = as_printed(mechanism, S, gam, forces, Js, betas, gamma, B_o, beyond)
    assert residues(*(tuple(row) for row in e.K.rows)) == residues(*printed.K.ravel())
    assert residues(*e.alpha.entries) == residues(*printed.alpha)
    assert residues(*(moved.udd[k] for k in FREE)) == residues(*printed.udd)
    assert residues(*moved.qdd.values()) == residues(*printed.qdd.values())
    assert residues(moved.Gamma_u[KNOWN]) == residues(printed.Gamma)


def twist(draw: Draw) -> Twist:
    return Twist(vector(draw), vector(draw))


def wrench(draw: Draw) -> Wrench:
    return Wrench(vector(draw), vector(draw))
