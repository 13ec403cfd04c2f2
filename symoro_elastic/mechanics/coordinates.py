"""Joint positions as functions of independent coordinates u: q = F(x), x = (u, d(u)), with S = dq/du.

    qd = S ud,   qdd = S udd + gam,   Gamma_u = S^T Gamma                                  (L1)-(L3)

gam is qdd where udd = 0. Rows of S belong to joints, its columns to the joints that own a coordinate. In a tree
without couplings S is the identity and gam is zero. Symbols are those of docs/loop_equations.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.spatial import Scalar, is_zero

Row: TypeAlias = Mapping[int, Scalar]
"""Entries of a row of S that are not zero, by column."""
Rows: TypeAlias = Mapping[int, Row]
"""Rows of S by joint."""


def combination(terms: Iterable[tuple[Scalar, Row]]) -> dict[int, Scalar]:
    """Sum of rows, each with its factor."""
    total: dict[int, Scalar] = {}
    for factor, row in terms:
        for k, x in row.items():
            total[k] = total.get(k, 0) + factor * x
    return {k: x for k, x in total.items() if not is_zero(x)}


def joint_rates(S: Rows, ud: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Rates of the joints, qd = S ud."""
    return {j: product(row, ud) for j, row in S.items()}  # (L2)


def joint_accelerations(S: Rows, udd: Mapping[int, Scalar], gam: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Accelerations of the joints, qdd = S udd + gam."""
    return {j: product(row, udd) + gam.get(j, 0) for j, row in S.items()}  # (L2)


def product(row: Row, column: Mapping[int, Scalar]) -> Scalar:
    """Row times column."""
    return sum_of(x * column.get(k, 0) for k, x in row.items())


def projection(S: Rows, Gamma: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Forces on the coordinates by those of the joints, Gamma_u = S^T Gamma, by virtual power."""
    return combination((force, S[j]) for j, force in Gamma.items() if j in S)  # (L3)


def congruence(S: Rows, A: Mapping[int, Mapping[int, Scalar]], columns: Iterable[int]) -> dict[int, dict[int, Scalar]]:
    """S^T A S of a symmetric A, by the coordinates (L21), (L25)."""
    columns = tuple(columns)
    AS = {i: combination((x, S[j]) for j, x in A[i].items() if j in S) for i in S}
    SAS: dict[int, dict[int, Scalar]] = {k: {} for k in columns}
    for m, k in enumerate(columns):
        for other in columns[: m + 1]:
            both = [i for i, row in S.items() if k in row and other in AS[i]]
            SAS[k][other] = SAS[other][k] = sum_of(S[i][k] * AS[i][other] for i in both)
    return SAS


def transmission_forces(C: Rows, order: Iterable[int], Gamma_x: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Joint forces lam of an elastic transmission, Gamma_x = (1 + C)^T lam, where every joint owns a variable.

    Row i of C holds the derivatives of the formula in the cell of joint i by the joint coordinates of other joints;
    `order` lists followers before the joints they follow.
    """
    lam: dict[int, Scalar] = {}
    for j in order:
        lam[j] = Gamma_x.get(j, 0)
        for i, c in ((i, row[j]) for i, row in C.items() if j in row):
            lam[j] = lam[j] - c * lam[i]  # (L5)
    return lam
