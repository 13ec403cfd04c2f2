"""The base as a body with six degrees of freedom: the last step of the backward recursion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.mechanics.spatial import ArticulatedInertia, Matrix, Scalar, Twist, Vector, Wrench, cross, dot

DEGREES = range(-6, 0)
"""Numbers of the degrees of freedom of a base, linear part first; joints are numbered from 1."""
HALF, QUARTER = Fraction(1, 2), Fraction(1, 4)


@dataclass(frozen=True)
class WrenchKnown:
    """The wrench of the surroundings on the base, in its frame, is known; weight is not part of it."""

    wrench: Wrench


@dataclass(frozen=True)
class Solution:
    """Solution x of M x = right by M = L D L^T: `left` holds L D below its diagonal D, `inverses` are 1/D,
    `reduced` is L^-1 right."""

    left: list[list[Scalar]]
    inverses: list[Scalar]
    reduced: list[Scalar]
    x: list[Scalar]

    @property
    def twist(self) -> Twist:
        """The six unknowns x as a twist."""
        a, b, c, d, e, f = self.x
        return Twist(Vector(a, b, c), Vector(d, e, f))


def base_acceleration(Js: ArticulatedInertia, wrench: Wrench) -> Solution:
    """V'_0 of J*_0 V'_0 = f_0 + b*_0: accelerations of the base, those of gravity subtracted.

    Raises `ZeroDivisionError` where a motion of the base meets no inertia.
    """
    return solve_symmetric(Js.rows, wrench.entries)


def solve_symmetric(matrix: Sequence[Sequence[Scalar]], right: Sequence[Scalar]) -> Solution:
    """x of M x = right for a symmetric positive definite M, by M = L D L^T: no square roots.

    Raises `ZeroDivisionError` for a pivot that is zero.
    """
    n = len(right)
    factors, reduced = [list(row) for row in matrix], list(right)
    inverses: list[Scalar] = []
    for k in range(n):
        inverses.append(1 / factors[k][k])
        for i in range(k + 1, n):
            factor = factors[i][k] * inverses[k]
            reduced[i] = reduced[i] - factor * reduced[k]
            for m in range(k + 1, i + 1):
                factors[i][m] = factors[i][m] - factor * factors[m][k]
    x = list(reduced)
    for k in reversed(range(n)):
        for i in range(k + 1, n):
            x[k] = x[k] - factors[i][k] * x[i]
        x[k] = x[k] * inverses[k]
    return Solution(factors, inverses, reduced, x)


def rotation_of(quaternion: Sequence[Scalar]) -> Matrix:
    """Rotation from the axes of the base to those of the world; the quaternion w x y z has length 1."""
    w, x, y, z = quaternion
    xx, yy, zz = 2 * (x * x), 2 * (y * y), 2 * (z * z)
    xy, xz, yz = 2 * (x * y), 2 * (x * z), 2 * (y * z)
    wx, wy, wz = 2 * (w * x), 2 * (w * y), 2 * (w * z)
    return Matrix(
        Vector(1 - (yy + zz), xy - wz, xz + wy),
        Vector(xy + wz, 1 - (xx + zz), yz - wx),
        Vector(xz - wy, yz + wx, 1 - (xx + yy)),
    )


def pose_rates(u: Vector, V: Twist) -> Twist:
    """Time derivatives s' and u' of displacement and rotation vector of the base, from u and its velocity V."""
    v, w = V
    across = cross(u, v)
    shift = v + (1 / _squared_length(u)) * (across + HALF * cross(u, across))
    return Twist(shift, w + HALF * cross(u, w) + (QUARTER * dot(u, w)) * u)


def velocity_rates(V: Twist, Vd: Twist) -> Twist:
    """Derivatives by time of the components of V, by the acceleration V' of the origin and of the turn [6]."""
    return Twist(Vd.linear - cross(V.angular, V.linear), Vd.angular)


def rotation_change(A_0: Matrix, u: Vector) -> Matrix:
    """A_0 (I + G/2) cay(u) - A_0 with G = I - A_0^T A_0, which corrects the rounding of the rotation A_0."""
    x, y, z = u
    f = 1 / _squared_length(u)
    xx, yy, zz = (HALF * (a * a) for a in u)
    xy, xz, yz = HALF * (x * y), HALF * (x * z), HALF * (y * z)
    turn = Matrix(
        Vector(-(yy + zz), xy - z, xz + y),
        Vector(xy + z, -(xx + zz), yz - x),
        Vector(xz - y, yz + x, -(xx + yy)),
    )  # fmt: skip
    E = Matrix(*(f * row for row in turn))
    lost = _half_lost(A_0)
    return _product(A_0, E + lost + _product(lost, E))


def quaternion_change(
    Q_0: Sequence[Scalar], u: Vector, square_root: Callable[[Scalar], Scalar]
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Q - Q_0 with Q = Q_0 (1, u/2) over its length, w x y z: of length 1 also where Q_0 lost it to rounding."""
    w, *vector = Q_0
    q, turn = Vector(*vector), HALF * u
    grown = QUARTER * dot(u, u)
    excess = (w * w + dot(q, q) - 1) * (1 + grown) + grown
    length = square_root(1 + excess)
    share = 1 / (length * (1 + length))
    inverse = (1 + length) * share
    a, b = -excess * share, inverse * turn
    x, y, z = a * q + w * b + cross(q, b)
    return a * w - dot(q, b), x, y, z


def shift(A_0: Matrix, s: Vector) -> Vector:
    """Displacement P - P_0 of the base in axes of the world, from s in axes of the start."""
    return A_0 * s


def _squared_length(u: Vector) -> Scalar:
    """1 + u.u / 4: square of the length of the quaternion (1, u/2)."""
    return 1 + QUARTER * dot(u, u)


def _half_lost(A: Matrix) -> Matrix:
    """(I - A^T A) / 2, zero for a rotation."""
    columns = A.T
    entries = [[(int(i == j) - dot(columns[min(i, j)], columns[max(i, j)])) * HALF for j in range(3)] for i in range(3)]
    return Matrix(*(Vector(*row) for row in entries))


def _product(A: Matrix, B: Matrix) -> Matrix:
    columns = B.T
    return Matrix(*(Vector(*(dot(row, column) for column in columns)) for row in A))
