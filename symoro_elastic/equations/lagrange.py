"""The Lagrange form Gamma = A(q) qdd + H(q, qd) [8]: the inertia matrix by composite inertias, and its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symoro_elastic.equations.elimination import SingularPivot
from symoro_elastic.equations.floating_base import solve_symmetric
from symoro_elastic.equations.kinematics import path
from symoro_elastic.equations.mechanism import Mechanism
from symoro_elastic.equations.spatial import NO_WRENCH, Axis, RigidInertia, Scalar, Twist, Vector, Wrench


@dataclass(frozen=True)
class InertiaMatrix:
    """A (n+1 by n+1, row and column 0 unused) and the composite inertias it is made of.

    `base`: wrenches on a base that is part of the machine for a unit of each joint's acceleration;
    those of its own acceleration are composite inertia 0.
    """

    composite: list[RigidInertia]
    f: list[Wrench]
    A: list[list[Scalar]]
    base: dict[int, Wrench]


def inertia_matrix(mechanism: Mechanism) -> InertiaMatrix:
    """A_ij = a_i^T (wrench at i that accelerates everything beyond j by a_j); Ia on the diagonal.

    Entries are zero where neither joint carries the other. Units kg m2, kg m or kg.
    """
    n = len(mechanism.links)
    composite = [mechanism.body or RigidInertia(), *(link.body for link in mechanism.links)]
    f = [NO_WRENCH] * (n + 1)
    A: list[list[Scalar]] = [[0] * (n + 1) for _ in range(n + 1)]
    base: dict[int, Wrench] = {}
    for j, link in mechanism.from_tips():
        if link.antecedent or mechanism.body is not None:
            composite[link.antecedent] += composite[j].to_antecedent(link.transform)
        if link.axis is Axis.NONE:
            continue
        f[j] = wrench = composite[j].spatial * link.axis
        A[j][j] = link.axis.T * wrench + link.rotor_inertia  # (8)
        i = j
        while mechanism.link(i).antecedent:
            wrench = mechanism.link(i).transform.T * wrench
            i = mechanism.link(i).antecedent
            axis = mechanism.link(i).axis
            A[i][j] = A[j][i] = 0 if axis is Axis.NONE else axis.T * wrench  # (8)
        if mechanism.body is not None:
            base[j] = mechanism.link(i).transform.T * wrench
    return InertiaMatrix(composite, f, A, base)


@dataclass(frozen=True)
class Factorization:
    """A = L^T D L by joint number: rows of L below its diagonal of ones, pivots D_j, their inverses.

    L_ji is zero where joint i does not carry joint j. D_j is H_j [28] of the backward recursion.
    """

    L: dict[int, dict[int, Scalar]]
    pivots: dict[int, Scalar]
    inverses: dict[int, Scalar]


def factorization(mechanism: Mechanism, A: list[list[Scalar]]) -> Factorization:
    """Factors of A = L^T D L from the tips to the base, without fill-in. Raises `SingularPivot`."""
    left = [list(row) for row in A]
    found = Factorization({}, {}, {})
    for j, link in mechanism.from_tips():
        if link.axis is Axis.NONE:
            continue
        carrying = [i for i in path(mechanism, j)[:-1] if mechanism.link(i).axis is not Axis.NONE]
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
    x = dict(right)  # (10): L^T D L x = right
    for j, row in factors.L.items():
        for i, entry in row.items():
            x[i] = x[i] - entry * x[j]
    for j, row in reversed(factors.L.items()):
        x[j] = x[j] * factors.inverses[j]
        for i, entry in row.items():
            x[j] = x[j] - entry * x[i]
    return x


def free_solution(
    factors: Factorization, found: InertiaMatrix, wrench: Wrench, right: Mapping[int, Scalar]
) -> tuple[Twist, dict[int, Scalar]]:
    """V'_0 and x of A (V'_0, x) = (wrench, right) on a floating base: the joints are eliminated, then its six rows.

    Raises `SingularPivot`.
    """
    held = solution(factors, right)
    pushed = [solution(factors, {j: found.base[j].entries[k] for j in right}) for k in range(6)]
    columns = zip(found.composite[0].spatial.rows, pushed, strict=True)
    left = [_without(found, _wrench(column), moved).entries for column, moved in columns]
    try:
        base = solve_symmetric(left, _without(found, wrench, held).entries)
    except ZeroDivisionError:
        raise SingularPivot(0) from None
    for k, acceleration in enumerate(base.x):
        held = {j: x - pushed[k][j] * acceleration for j, x in held.items()}
    return base.twist, held


def _wrench(entries: tuple[Scalar, ...]) -> Wrench:
    return Wrench(Vector(*entries[:3]), Vector(*entries[3:]))


def wrench_on_base(found: InertiaMatrix, wrench: Wrench, qdd: Mapping[int, Scalar]) -> Wrench:
    """Sum of a wrench on a floating base and of those that the accelerations of the joints require."""
    for j, x in qdd.items():
        force, moment = found.base[j]
        wrench = Wrench(wrench.force + x * force, wrench.moment + x * moment)
    return wrench


def _without(found: InertiaMatrix, wrench: Wrench, qdd: Mapping[int, Scalar]) -> Wrench:
    return wrench_on_base(found, wrench, {j: -x for j, x in qdd.items()})
