"""Joint positions as functions of independent coordinates u: q = F(u), with S = dq/du.

    qd = S ud,   qdd = S udd + gam,   Gamma_u = S^T Gamma                                  (L1)-(L3)

gam is what qdd is for udd = 0. Rows of S belong to joints, its columns to the joints that own a coordinate. In a tree
without couplings S is the identity and gam is zero.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias

from symoro_elastic.mechanics.spatial import Scalar, is_zero

Row: TypeAlias = Mapping[int, Scalar]
"""Entries of a row of S that are not zero, by column."""
Rows: TypeAlias = Mapping[int, Row]
"""Rows of S by joint."""


def combination(terms: Iterable[tuple[Scalar, Row]]) -> dict[int, Scalar]:
    """Sum of rows, each with its factor."""
    found: dict[int, Scalar] = {}
    for factor, row in terms:
        for k, x in row.items():
            found[k] = found.get(k, 0) + factor * x
    return {k: x for k, x in found.items() if not is_zero(x)}


def image(S: Rows, rates: Mapping[int, Scalar], added: Mapping[int, Scalar] | None = None) -> dict[int, Scalar]:
    """S times a vector of the coordinates, by joint: qd = S ud; with `added` gam, qdd = S udd + gam (L2)."""
    return {j: product(row, rates) + (added or {}).get(j, 0) for j, row in S.items()}


def product(row: Row, column: Mapping[int, Scalar]) -> Scalar:
    """Row times column."""
    total: Scalar = 0
    for k, x in row.items():
        total = total + x * column.get(k, 0)
    return total


def projection(S: Rows, Gamma: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """S^T Gamma: what generalized forces of the joints do on the coordinates, by virtual power (L3)."""
    return combination((force, S[j]) for j, force in Gamma.items() if j in S)


def congruence(S: Rows, A: Mapping[int, Mapping[int, Scalar]], columns: Iterable[int]) -> dict[int, dict[int, Scalar]]:
    """S^T A S of a symmetric A, by the coordinates (L21)."""
    columns = tuple(columns)
    AS = {i: combination((x, S[j]) for j, x in A[i].items() if j in S) for i in S}
    found: dict[int, dict[int, Scalar]] = {k: {} for k in columns}
    for m, k in enumerate(columns):
        for other in columns[: m + 1]:
            total: Scalar = 0
            for i, row in S.items():
                if k in row and other in AS[i]:
                    total = total + row[k] * AS[i][other]
            found[k][other] = found[other][k] = total
    return found


def change_of_variables(C: Rows, order: Iterable[int], Gamma: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Joint forces lam of Gamma_x = (1 + C)^T lam, where every joint owns a variable (L5).

    Row i of C holds the derivatives of the formula in the cell of joint i by the own variables of other joints;
    `order` lists followers before the joints they follow.
    """
    lam: dict[int, Scalar] = {}
    for j in order:
        followed = ((i, row[j]) for i, row in C.items() if j in row)
        lam[j] = Gamma.get(j, 0)
        for i, factor in followed:
            lam[j] = lam[j] - factor * lam[i]  # (L5)
    return lam
