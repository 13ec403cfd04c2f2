"""A flexible body by linear modes: its inertia in deformed shape, and what its modes add to the equations of motion.

A point x of the body is at r = x + phi_k e_k + s_kl e_k e_l/2 in frame j, with modes phi_k that vanish at the joint and
foreshortening s_kl. The arrays of integrals over the mass,

    Ct0_k = int phi_k,   Ct1_kl = int s_kl,   T0_k = int x phi_k^T,   T1_kl = int (phi_l phi_k^T + x s_kl^T),
    Mee_kl = int phi_k . phi_l,

give at a deflection e and its rate ed

    Ct_k = Ct0_k + Ct1_kl e_l,   R_k = T0_k + T1_kl e_l,                                              (L50)
    MS(e) = MS + (Ct0_k + Ct_k) e_k/2,   P(e) = P + sym(T0_k + R_k) e_k/2,   J = tr(P) 1 - P,         (L51)

where sym(X) = X + X^T. Beside the rigid body with M, MS(e) and J(e), a mode k has the wrench U_k = [Ct_k; ax(R_k)] per
unit of its acceleration, ax(r phi^T) = r x phi, and

    F = 2 w x Ct_k ed_k + Ct1_kl ed_k ed_l,                                                           (L52)
    N = 2 ed_k (tr(R_k) 1 - R_k^T) w + ax(T1_kl) ed_k ed_l,                                           (L53)
    f_k = w^T R_k^T w - (w.w) tr(R_k) + w . ax(T1_kl - T1_lk) ed_l,                                   (L54)
    U_k^T V' + Mee_kl edd_l + f_k = what its spring and damper exert.                                 (L55)

Exact in e for s = 0; with foreshortening of beams to the second order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.mechanics.spatial import (
    ZERO,
    Matrix,
    RigidInertia,
    Scalar,
    Symmetric,
    Vector,
    Wrench,
    cross,
    dot,
    is_zero,
)


@dataclass(frozen=True)
class Modes:
    """The modes of a flexible body, rows of the table by number, with their integrals over the mass, and deflections e.

    `Ct1`, `T1` and `Mee` have rows k and columns l. Units with e in m: kg m^(..) as of the integrals.
    """

    numbers: tuple[int, ...]
    e: tuple[Scalar, ...]
    Ct0: tuple[Vector, ...]
    Ct1: tuple[tuple[Vector, ...], ...]
    T0: tuple[Matrix, ...]
    T1: tuple[tuple[Matrix, ...], ...]
    Mee: tuple[tuple[Scalar, ...], ...]

    @property
    def Ct(self) -> tuple[Vector, ...]:
        """First moments of the modes at the deflections e."""
        return tuple(Ct0 + _sum(self.Ct1[k], self.e, ZERO) for k, Ct0 in enumerate(self.Ct0))  # (L50)

    @property
    def R(self) -> tuple[Matrix, ...]:
        """Second moments of positions and modes at e."""
        return tuple(T0 + _matrix_sum(self.T1[k], self.e) for k, T0 in enumerate(self.T0))  # (L50)

    def deformed(self, body: RigidInertia) -> RigidInertia:
        """Inertia of the rigid body that results from `body` when its modes are fixed at the deflections e."""
        halves = [x / 2 if not is_zero(x) else 0 for x in self.e]
        moments = [Ct0 + Ct for Ct0, Ct in zip(self.Ct0, self.Ct, strict=True)]
        P = _matrix_sum([T0 + R for T0, R in zip(self.T0, self.R, strict=True)], halves)
        xx, yy, zz = P.x.x + P.x.x, P.y.y + P.y.y, P.z.z + P.z.z
        J = Symmetric(yy + zz, -(P.x.y + P.y.x), -(P.x.z + P.z.x), xx + zz, -(P.y.z + P.z.y), xx + yy)
        return RigidInertia(body.mass, body.moments + _sum(moments, halves, ZERO), body.inertia + J)  # (L51)

    def wrenches(self) -> dict[int, Wrench]:
        """Wrenches U_k by number of the mode: per unit acceleration of mode k, about the origin of frame j."""
        return {j: Wrench(Ct, ax(R)) for j, Ct, R in zip(self.numbers, self.Ct, self.R, strict=True)}

    def masses(self, j: int) -> dict[int, Scalar]:
        """Modal masses of mode j with all modes of the body, a row of Mee, by number."""
        return dict(zip(self.numbers, self.Mee[self.numbers.index(j)], strict=True))

    def motion(self, w: Vector, qd: Sequence[Scalar]) -> ModalMotion:
        """Modal forces at the velocities w and ed: wrench [F; N] of the Coriolis terms, and f_k of each mode."""
        ed = [qd[j] for j in self.numbers]
        Ct, R = self.Ct, self.R
        along = _sum(Ct, ed, ZERO)
        force = cross(w, along + along) + _quadratic(self.Ct1, ed)  # (L52)
        moment = _turned(_matrix_sum(R, ed), w) * 2 + _quadratic([[ax(T) for T in row] for row in self.T1], ed)  # (L53)
        f = {j: self._force(k, w, ed, R[k]) for k, j in enumerate(self.numbers)}
        return ModalMotion(self, self.wrenches(), Wrench(force, moment), f)

    def _force(self, k: int, w: Vector, ed: Sequence[Scalar], R: Matrix) -> Scalar:
        """Velocity force f_k on mode k, by the entries of w w^T - (w.w) 1: few operations if a single joint turns."""
        xx, yy, zz = w.x * w.x, w.y * w.y, w.z * w.z
        diagonal = R.x.x * (yy + zz) + R.y.y * (xx + zz) + R.z.z * (xx + yy)
        mixed = sum_of(((R.x.y + R.y.x) * (w.x * w.y), (R.x.z + R.z.x) * (w.x * w.z), (R.y.z + R.z.y) * (w.y * w.z)))
        swept = [ax(self.T1[k][m]) - ax(self.T1[m][k]) for m in range(len(ed))]
        return (mixed - diagonal) + dot(w, _sum(swept, ed, ZERO))  # (L54)

    def scalars(self) -> Iterator[Scalar]:
        """All scalars that `map` converts, in its order."""
        yield from self.e
        yield from (x for v in self.Ct0 for x in v)
        yield from (x for row in self.Ct1 for v in row for x in v)
        yield from (x for T in self.T0 for v in T for x in v)
        yield from (x for row in self.T1 for T in row for v in T for x in v)
        yield from (x for row in self.Mee for x in row)

    def map(self, convert: Callable[[Scalar], Scalar]) -> Modes:
        """The modes in another arithmetic."""

        def vector(v: Vector) -> Vector:
            return Vector(*map(convert, v))

        def matrix(T: Matrix) -> Matrix:
            return Matrix(*map(vector, T))

        return Modes(
            self.numbers,
            tuple(map(convert, self.e)),
            tuple(map(vector, self.Ct0)),
            tuple(tuple(map(vector, row)) for row in self.Ct1),
            tuple(map(matrix, self.T0)),
            tuple(tuple(map(matrix, row)) for row in self.T1),
            tuple(tuple(map(convert, row)) for row in self.Mee),
        )


@dataclass(frozen=True)
class ModalMotion:
    """Modes in a motion: U_k by number, the wrench [F; N] about the origin of frame j, and f_k by number."""

    modes: Modes
    U: Mapping[int, Wrench]
    bias: Wrench
    f: Mapping[int, Scalar]

    def wrench(self, edd: Mapping[int, Scalar]) -> Wrench:
        """The wrench on the body beyond that of the deformed rigid one, for accelerations of modes by number."""
        total = self.bias
        for j, x in edd.items():
            total = total + x * self.U[j]
        return total

    def force(self, j: int, V: tuple[Vector, Vector], edd: Mapping[int, Scalar]) -> Scalar:
        """The force on mode j that accelerations of the body, linear and angular, and of modes require (L55)."""
        masses, U = self.modes.masses(j), self.U[j]
        inertial = sum_of(masses[k] * x for k, x in edd.items())
        return (dot(U.force, V[0]) + dot(U.moment, V[1])) + inertial + self.f[j]


def _turned(T: Matrix, w: Vector) -> Vector:
    """(tr(T) 1 - T^T) w, without what cancels on the diagonal."""
    x = (T.y.y + T.z.z) * w.x - (T.y.x * w.y + T.z.x * w.z)
    y = (T.x.x + T.z.z) * w.y - (T.x.y * w.x + T.z.y * w.z)
    return Vector(x, y, (T.x.x + T.y.y) * w.z - (T.x.z * w.x + T.y.z * w.y))


def ax(T: Matrix) -> Vector:
    """The vector of r x phi summed over T = sum of r phi^T."""
    return Vector(T.y.z - T.z.y, T.z.x - T.x.z, T.x.y - T.y.x)


def _sum(vectors: Sequence[Vector], factors: Sequence[Scalar], start: Vector) -> Vector:
    for v, x in zip(vectors, factors, strict=True):
        if not (all(map(is_zero, v)) or is_zero(x)):
            start = start + v * x
    return start


def _matrix_sum(matrices: Sequence[Matrix], factors: Sequence[Scalar]) -> Matrix:
    x, y, z = (_sum([T[row] for T in matrices], factors, ZERO) for row in range(3))
    return Matrix(x, y, z)


def _quadratic(vectors: Sequence[Sequence[Vector]], rates: Sequence[Scalar]) -> Vector:
    """Sum of v_kl ed_k ed_l over all pairs of modes, where v_kl are vectors; both orders of a pair are added first."""
    total = ZERO
    for k, x in enumerate(rates):
        for m in range(k + 1):
            both = vectors[k][m] if m == k else vectors[k][m] + vectors[m][k]
            if not all(map(is_zero, both)):
                total = total + both * (x * rates[m])
    return total
