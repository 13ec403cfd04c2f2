"""The Lagrange form Gamma = A(q) qdd + H(q, qd) [8]: the inertia matrix by composite inertias, and its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symoro_elastic.equations.dynamics import SingularPivot
from symoro_elastic.equations.kinematics import path
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


@dataclass(frozen=True)
class Factorization:
    """A = L^T D L by joint number: rows of L below its diagonal of ones, pivots D_j, their inverses.

    L_ji is zero where joint i does not carry joint j. D_j is H_j [28] of the backward recursion.
    """

    L: dict[int, dict[int, Scalar]]
    pivots: dict[int, Scalar]
    inverses: dict[int, Scalar]


def factorization(mechanism: Mechanism, A: list[list[Scalar]]) -> Factorization:
    """A = L^T D L from the tips to the base, where nothing fills in. Raises `SingularPivot`."""
    left = [list(row) for row in A]
    found = Factorization({}, {}, {})
    for j, link in reversed(list(mechanism.numbered())):
        if link.axis is Axis.NONE:
            continue
        carrying = [i for i in path(mechanism, j)[:-1] if mechanism.links[i - 1].axis is not Axis.NONE]
        try:
            inverse = 1 / left[j][j]
        except ZeroDivisionError:
            raise SingularPivot(j) from None
        found.pivots[j], found.inverses[j] = left[j][j], inverse
        found.L[j] = {i: left[j][i] * inverse for i in carrying}
        for i in carrying:
            for k in carrying[: carrying.index(i) + 1]:
                left[i][k] = left[i][k] - found.L[j][i] * left[j][k]
    return found


def solution(factors: Factorization, right: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """x of A x = right, by joint number."""
    x = dict(right)
    for j, row in factors.L.items():
        for i, entry in row.items():
            x[i] = x[i] - entry * x[j]
    for j, row in reversed(factors.L.items()):
        x[j] = x[j] * factors.inverses[j]
        for i, entry in row.items():
            x[j] = x[j] - entry * x[i]
    return x
