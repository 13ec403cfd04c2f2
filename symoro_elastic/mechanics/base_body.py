"""The base as a body with six degrees of freedom: the last step of the backward recursion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symoro_elastic.mechanics.spatial import ArticulatedInertia, Matrix, Scalar, Twist, Vector, Wrench

DEGREES = range(-6, 0)
"""Numbers of the degrees of freedom of a base, linear part first; joints are numbered from 1."""


@dataclass(frozen=True)
class WrenchKnown:
    """The wrench that the surroundings exert on the base, in its frame, is given; its weight is not part of it."""

    wrench: Wrench


@dataclass(frozen=True)
class Solution:
    """x of M x = right by M = L D L^T: `left` holds L D below its diagonal D, `inverses` are those of D,
    `reduced` is L^-1 right."""

    left: list[list[Scalar]]
    inverses: list[Scalar]
    reduced: list[Scalar]
    x: list[Scalar]

    @property
    def twist(self) -> Twist:
        """Six unknowns as a twist."""
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
    left, reduced = [list(row) for row in matrix], list(right)
    inverses: list[Scalar] = []
    for k in range(n):
        inverses.append(1 / left[k][k])
        for i in range(k + 1, n):
            factor = left[i][k] * inverses[k]
            reduced[i] = reduced[i] - factor * reduced[k]
            for m in range(k + 1, i + 1):
                left[i][m] = left[i][m] - factor * left[m][k]
    x = list(reduced)
    for k in reversed(range(n)):
        for i in range(k + 1, n):
            x[k] = x[k] - left[i][k] * x[i]
        x[k] = x[k] * inverses[k]
    return Solution(left, inverses, reduced, x)


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
