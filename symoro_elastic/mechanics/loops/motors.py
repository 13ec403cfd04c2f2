"""Motors on dependent joints, and more motors than freedoms: the inverse model as a linear system (L30), (L31)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.coordinates import Row, product
from symoro_elastic.mechanics.factorization import factorization, share_or_one, solution
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.mechanics.spatial import Scalar

Vector = Mapping[int, Scalar]


@dataclass(frozen=True)
class Driven:
    """Accelerations of the independent variables, and torques of motors, by joint number."""

    udd: Vector
    tau: Vector


def driven_motion(A: Mapping[int, Row], rest: Vector, S_m: Mapping[int, Row], wanted: Vector) -> Driven:
    """Solve A udd + rest = S_m^T tau, S_m udd = wanted (L30); rows of S_m belong to motors and are independent."""
    if len(S_m) == len(A):
        return _as_many_as_freedoms(A, rest, S_m, wanted)
    order = sorted(A, reverse=True)
    factors = factorization(order, A, share_or_one)
    free = solution(factors, {k: -rest[k] for k in order})
    pushed = {m: solution(factors, {k: row.get(k, 0) for k in order}) for m, row in S_m.items()}
    mobility = {m: {n: product(row, pushed[n]) for n in S_m} for m, row in S_m.items()}
    small = factorization(sorted(S_m, reverse=True), mobility)
    tau = solution(small, {m: wanted[m] - product(row, free) for m, row in S_m.items()})
    udd = {k: free[k] + product({m: pushed[m][k] for m in tau}, tau) for k in order}
    return Driven(udd, tau)


def _as_many_as_freedoms(A: Mapping[int, Row], rest: Vector, S_m: Mapping[int, Row], wanted: Vector) -> Driven:
    """Solve for as many motors as degrees of freedom: udd = S_m^-1 wanted, tau = S_m^-T (A udd + rest)."""
    motors, k = list(S_m), list(A)
    columns = [[S_m[m].get(i, 0) for m in motors] for i in k]
    (found,) = solve(columns, [[wanted[m] for m in motors]])
    udd = dict(zip(k, found, strict=True))
    needed = [product(A[i], udd) + rest[i] for i in k]
    rows = [[S_m[m].get(i, 0) for i in k] for m in motors]
    (tau,) = solve(rows, [needed])
    return Driven(udd, dict(zip(motors, tau, strict=True)))


def shared_torques(rows: Mapping[int, Row], kept: Sequence[int], tau: Vector, shares: Vector) -> Vector:
    """Torques of all motors equivalent to those of the `kept` motors, with the least sum of tau^2 / share (L31).

    `rows` are those of S_m of all motors; those of the kept ones span them.
    """
    gram = [[product(rows[m], rows[n]) for m in kept] for n in kept]
    mixing = solve(gram, [[product(row, rows[n]) for n in kept] for row in rows.values()])
    B = {m: dict(zip(kept, column, strict=True)) for m, column in zip(rows, mixing, strict=True)}
    weighted = [[sum_of(shares[m] * B[m][a] * B[m][b] for m in rows) for a in kept] for b in kept]
    (y,) = solve(weighted, [[tau[m] for m in kept]])
    return {m: shares[m] * product(B[m], dict(zip(kept, y, strict=True))) for m in rows}
