"""Derivatives of accelerations by linear systems in the inertia matrix, A x = right.

Where nothing else changes, a change `right` of the torques makes one of x of the accelerations. Short
trees are solved by the factors of A, where nothing fills in; long chains by the articulated inertias
that the motion was found with, in a number of operations that grows as the number of joints. A base
under a known wrench comes last, by its articulated inertia.

The same factors give the motion itself from one without accelerations of joints, where these are not
yet known: composite bodies and rows, which derivatives need anyway, give the contributions of accelerations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.base_body import DEGREES, solve_symmetric
from symoro_elastic.mechanics.derivatives.torques import Entries, TorqueDerivatives
from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.elimination import joint_acceleration
from symoro_elastic.mechanics.factorization import Factorization, factorization, solution
from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    IDENTITY,
    NO_WRENCH,
    ArticulatedInertia,
    Axis,
    Matrix,
    Scalar,
    Twist,
    Wrench,
    cross,
)

LONG = 16
"""Joints before a joint, on average, from which on the recursion needs fewer operations than the factors."""


Solve: TypeAlias = Callable[[Mapping[int, Scalar]], dict[int, Scalar]]


def solving(mechanism: Mechanism, A: Entries, found: Dynamics) -> Solve:
    """Solver of A x = right, by joint number: the one that needs fewer operations."""
    if is_short(mechanism):
        factors = factors_of(mechanism, A)
        return lambda right: solution(factors, right)
    return lambda right: _by_recursion(mechanism, found, right)


def is_short(mechanism: Mechanism) -> bool:
    """Whether the factors of A need fewer operations than the recursion."""
    moving = {j for j, link in mechanism.from_base() if link.axis is not Axis.NONE}
    before = sum(len(moving.intersection(path(mechanism, j))) - 1 for j in moving)
    return before <= LONG * len(moving)


def with_accelerations(held: Dynamics, made: TorqueDerivatives, qdd: Mapping[int, Scalar]) -> Dynamics:
    """The dynamics `held` at zero joint accelerations, with the accelerations `qdd` of the joints added.

    They add V to V'_j, and to f_j what accelerates all beyond joint j as one body and in the joints within.
    """
    V, U = {0: AT_REST}, {}
    f = {j: held.f[j] for j, _ in held.mechanism.from_base()}
    for j, link in held.mechanism.from_base():
        V[j] = link.transform * V[link.antecedent] + qdd.get(j, 0) * link.axis  # (6)
        U[j] = held.U[j] + Matrix(*(cross(V[j].angular, e) for e in IDENTITY)).T
        f[j] = f[j] + made.composites[j].inertia.spatial * V[j]  # (15)
    for (k, j), row in made.rows.items():
        if k != j:
            f[j] = f[j] + qdd[k] * row.of_acceleration
    vd = {j: held.vd[j] + V[j].linear for j in f}
    return replace(held, vd=vd, U=U, f=f, remainder=V, qdd=dict(qdd))


def solving_with_base(A: Entries, Js: ArticulatedInertia, joints: Sequence[int], solve: Solve) -> Solve:
    """Solver of A x = right for a base and these joints, given that of the joints alone.

    `Js` is the articulated inertia of the base where the accelerations of the other joints are known.
    """
    pushed = {m: solve({j: A[m, j] for j in joints}) for m in DEGREES}
    rows = Js.rows

    def solve_all(right: Mapping[int, Scalar]) -> dict[int, Scalar]:
        x = solve({j: right[j] for j in joints})
        rhs = [right[m] - sum_of(A[m, j] * x[j] for j in joints) for m in DEGREES]
        base = dict(zip(DEGREES, solve_symmetric(rows, rhs).x, strict=True))
        return base | {j: x[j] - sum_of(pushed[m][j] * base[m] for m in DEGREES) for j in joints}

    return solve_all


def changes(given: Entries, A: Entries, numbers: Sequence[int], free: Sequence[int], solve: Solve) -> Entries:
    """Derivatives, by columns of `given`, of the accelerations of `free` joints and of the torques of the others.

    `given` are those of all torques at constant accelerations.
    """
    columns: Entries = {}
    for c in dict.fromkeys(c for _, c in given):
        x = solve({i: -given.get((i, c), 0) for i in free})  # (11)
        columns |= {(i, c): x[i] if i in free else _moving(given, A, (i, c), x) for i in numbers}
    return columns


def changes_by_known(A: Entries, numbers: Sequence[int], free: Sequence[int], solve: Solve) -> Entries:
    """Derivatives of unknowns by the torques of `free` joints and by the accelerations of the other joints."""
    entries = inverse(free, solve)
    for c in numbers:
        if c in free:
            x = {f: entries[f, c] for f in free}
            entries |= {(i, c): _moving({}, A, (i, c), x) for i in numbers if i not in free}
            continue
        x = solve({i: -A.get((i, c), 0) for i in free})  # (11)
        for i in numbers:
            mirrored = (c, i) in entries and i not in free
            entries[i, c] = x[i] if i in free else entries[c, i] if mirrored else _moving(A, A, (i, c), x)
    return entries


def _moving(given: Entries, A: Entries, place: tuple[int, int], x: Mapping[int, Scalar]) -> Scalar:
    """Entry `place` of `given` + A x."""
    return sum_of((given.get(place, 0), *(A.get((place[0], f), 0) * value for f, value in x.items())))


def inverse(joints: Sequence[int], solve: Solve) -> Entries:
    """The inverse of A, one triangle computed."""
    entries: Entries = {}
    for k in joints:
        column = solve({j: int(j == k) for j in joints})
        entries |= {place: column[j] for j in joints if j <= k for place in ((j, k), (k, j))}
    return entries


def factors_of(mechanism: Mechanism, A: Entries) -> Factorization:
    """A = L^T D L."""
    numbered = [0, *(j for j, _ in mechanism.from_base())]
    from_tips = tuple(j for j, link in mechanism.from_tips() if link.axis is not Axis.NONE)
    return factorization(from_tips, [[A.get((i, j), 0) for j in numbered] for i in numbered])


def _by_recursion(mechanism: Mechanism, found: Dynamics, right: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Accelerations by the recursions [28]-[36] without velocities, gravity and wrenches."""
    alone = _lone_accelerations(mechanism, found, right)
    V: dict[int, Twist] = {}
    qdd: dict[int, Scalar] = {}
    for j, link in mechanism.from_base():
        V[j] = link.transform * V.get(link.antecedent, AT_REST)  # (33)
        if j in alone:
            here = replace(found.eliminated[j], qdd_bias=alone[j])
            V[j], qdd[j] = joint_acceleration(link, here, V[j])  # (34), (36)
    return qdd


def _lone_accelerations(mechanism: Mechanism, found: Dynamics, right: Mapping[int, Scalar]) -> dict[int, Scalar]:
    """Accelerations of joints whose antecedents do not accelerate [30], [31]."""
    wrenches: dict[int, Wrench] = {}
    alone: dict[int, Scalar] = {}
    for j, link in mechanism.from_tips():
        alpha, a = wrenches.get(j, NO_WRENCH), link.axis
        if j in right:
            here, along = found.eliminated[j], a.T * alpha
            alone[j] = (right[j] - along) * here.Hinv
            alpha = alpha + alone[j] * here.U  # (30)
            alpha = a.with_entry(alpha, a.T * here.UH * right[j] + here.rotor_share * along)
        before = wrenches.get(link.antecedent, NO_WRENCH)
        wrenches[link.antecedent] = before + link.transform.T * alpha  # (31)
    return alone
