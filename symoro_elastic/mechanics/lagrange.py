"""The Lagrange form Gamma = A(q) qdd + H(q, qd) [8]: the inertia matrix by composite inertias, and its solution."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from symoro_elastic.mechanics.base_body import solve_symmetric
from symoro_elastic.mechanics.coordinates import Rows, congruence
from symoro_elastic.mechanics.elimination import SingularPivot
from symoro_elastic.mechanics.factorization import Factorization, solution
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import NO_WRENCH, Axis, RigidInertia, Scalar, Twist, Vector, Wrench


@dataclass(frozen=True)
class InertiaMatrix:
    """Inertia matrix A (n+1 by n+1, row and column 0 unused) and the composite inertias it is made of.

    `base`: wrenches on a base that is part of the machine per unit of joint acceleration;
    those of its own acceleration are composite inertia 0.
    """

    composite: list[RigidInertia]
    f: list[Wrench]
    A: list[list[Scalar]]
    base: dict[int, Wrench]


def inertia_matrix(mechanism: Mechanism) -> InertiaMatrix:
    """Inertia matrix: A_ij = a_i^T (wrench at i that accelerates all bodies beyond j by a_j); Ia on the diagonal.

    Entries are zero where neither joint carries the other. Units kg m2, kg m or kg.
    """
    n, modal = len(mechanism.links), mechanism.modes
    composite = [mechanism.body or RigidInertia(), *(link.body for link in mechanism.links)]
    f = [NO_WRENCH] * (n + 1)
    A: list[list[Scalar]] = [[0] * (n + 1) for _ in range(n + 1)]
    base: dict[int, Wrench] = {}
    for j, link in mechanism.from_tips():
        if link.antecedent or mechanism.body is not None:
            composite[link.antecedent] += composite[j].to_antecedent(link.transform)
        if link.axis is Axis.NONE:
            continue
        if j in modal:
            f[j], i = modal[j].wrenches()[j], link.antecedent
            A[j][: n + 1] = [modal[j].masses(j).get(k, x) for k, x in enumerate(A[j])]  # (L55)
            axis = mechanism.link(i).axis
            A[i][j] = A[j][i] = 0 if axis is Axis.NONE else axis.T * f[j]
        else:
            f[j], i = composite[j].spatial * link.axis, j
            A[j][j] = link.axis.T * f[j] + link.rotor_inertia  # (8)
        wrench = f[j]
        while mechanism.link(i).antecedent:
            wrench = mechanism.link(i).transform.T * wrench
            i = mechanism.link(i).antecedent
            axis = mechanism.link(i).axis
            A[i][j] = A[j][i] = 0 if axis is Axis.NONE else axis.T * wrench  # (8)
        if mechanism.body is not None:
            base[j] = mechanism.link(i).transform.T * wrench
    return InertiaMatrix(composite, f, A, base)


def free_solution(
    factors: Factorization, matrix: InertiaMatrix, wrench: Wrench, right: Mapping[int, Scalar]
) -> tuple[Twist, dict[int, Scalar]]:
    """V'_0 and x of A (V'_0, x) = (wrench, right) on a base that moves: the joints are eliminated, then its six rows.

    Raises `SingularPivot`.
    """
    qdd = solution(factors, right)
    pushed = [solution(factors, {j: matrix.base[j].entries[k] for j in right}) for k in range(6)]
    columns = zip(matrix.composite[0].spatial.rows, pushed, strict=True)
    wrenches = ((Wrench(Vector(*column[:3]), Vector(*column[3:])), moved) for column, moved in columns)
    reduced = [_without(matrix, column, moved).entries for column, moved in wrenches]
    try:
        base = solve_symmetric(reduced, _without(matrix, wrench, qdd).entries)
    except ZeroDivisionError:
        raise SingularPivot(0) from None
    for k, acceleration in enumerate(base.x):
        qdd = {j: x - pushed[k][j] * acceleration for j, x in qdd.items()}
    return base.twist, qdd


def of_coordinates(found: InertiaMatrix, S: Rows, coordinates: Iterable[int]) -> InertiaMatrix:
    """S^T A S, and wrenches on the base per unit of acceleration of the coordinates (L21)."""
    size = len(found.A)
    A = congruence(S, {i: dict(enumerate(row)) for i, row in enumerate(found.A)}, coordinates)
    full = [[A.get(i, {}).get(j, 0) for j in range(size)] for i in range(size)]
    base: dict[int, Wrench] = {}
    for j, wrench in found.base.items():
        for k, x in S[j].items():
            base[k] = base.get(k, NO_WRENCH) + x * wrench
    return InertiaMatrix(found.composite, found.f, full, base)


def wrench_on_base(found: InertiaMatrix, wrench: Wrench, qdd: Mapping[int, Scalar]) -> Wrench:
    """Sum of a wrench on the base and of the wrenches that the accelerations of the joints require."""
    for j, x in qdd.items():
        force, moment = found.base[j]
        wrench = Wrench(wrench.force + x * force, wrench.moment + x * moment)
    return wrench


def _without(found: InertiaMatrix, wrench: Wrench, qdd: Mapping[int, Scalar]) -> Wrench:
    return wrench_on_base(found, wrench, {j: -x for j, x in qdd.items()})
