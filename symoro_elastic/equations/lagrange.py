"""The Lagrange form Gamma = A(q) qdd + H(q, qd) [8]: the inertia matrix by composite inertias."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.equations.mechanism import Axis, Mechanism
from symoro_elastic.equations.spatial import Pair, RigidInertia, Scalar, SpatialInertia, wrench_to_antecedent


@dataclass(frozen=True)
class InertiaMatrix:
    """A (n+1 by n+1, row and column 0 unused) and the composite inertias it is made of."""

    composite: list[RigidInertia]
    f: list[Pair]
    A: list[list[Scalar]]


def inertia_matrix(mechanism: Mechanism) -> InertiaMatrix:
    """A_ij = a_i^T (wrench at i that accelerates everything beyond j by a_j); Ia on the diagonal.

    Entries are zero where neither joint carries the other. Units kg m2, kg m or kg.
    """
    n = len(mechanism.links)
    composite = [RigidInertia(), *(link.body for link in mechanism.links)]
    f: list[Pair] = [((0, 0, 0), (0, 0, 0))] * (n + 1)
    A: list[list[Scalar]] = [[0] * (n + 1) for _ in range(n + 1)]
    for j, link in reversed(list(mechanism.numbered())):
        if link.antecedent:
            composite[link.antecedent] += composite[j].to_antecedent(link.placement)
        if link.axis is Axis.NONE:
            continue
        f[j] = wrench = link.axis.column(SpatialInertia.of_body(composite[j]))
        A[j][j] = link.axis.project(wrench) + link.rotor_inertia
        i = j
        while mechanism.links[i - 1].antecedent:
            wrench = wrench_to_antecedent(mechanism.links[i - 1].placement, wrench)
            i = mechanism.links[i - 1].antecedent
            axis = mechanism.links[i - 1].axis
            A[i][j] = A[j][i] = 0 if axis is Axis.NONE else axis.project(wrench)
    return InertiaMatrix(composite, f, A)
