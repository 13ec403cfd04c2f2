"""The pose of the base within a time step, in coordinates x = (s, u) that are zero at its start.

    P = P_0 + A_0 s,    A = A_0 cay(u),    cay(u) = I + (hat(u) + hat(u)^2 / 2) / (1 + u.u / 4)

A_0 is the rotation from the axes of the base to those of the world at the start, u = 2 tan(angle/2) times the axis of
the turn since. Rates of x are polynomials of V = (v, w), in axes of the base:

    s' = cay(u) v,    u' = w + u x w / 2 + (u.w) u / 4

A method that carries x keeps its order, and cay(u) is a rotation whatever its error is: Hairer, Lubich and Wanner,
Geometric Numerical Integration, section IV.8.3. There is no branch, sine or cosine; half a turn in a step is out of
reach. As a quaternion the turn is (1, u/2) over its length.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from symoro_elastic.mechanics.spatial import Matrix, Scalar, Twist, Vector, cross, dot

HALF, QUARTER = Fraction(1, 2), Fraction(1, 4)


def pose_rates(u: Vector, V: Twist) -> Twist:
    """s' and u' at a turn u and the velocity V of the base."""
    v, w = V
    across = cross(u, v)
    shift = v + (1 / _squared_length(u)) * (across + HALF * cross(u, across))
    return Twist(shift, w + HALF * cross(u, w) + (QUARTER * dot(u, w)) * u)


def velocity_rates(V: Twist, Vd: Twist) -> Twist:
    """Derivatives by time of the components of V, by the acceleration V' of the origin and of the turn [6]."""
    return Twist(Vd.linear - cross(V.angular, V.linear), Vd.angular)


def rotation_change(A_0: Matrix, u: Vector) -> Matrix:
    """A_0 (I + G/2) cay(u) - A_0 with G = I - A_0^T A_0: what rounding took of a rotation is given back."""
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
    """P - P_0, in axes of the world."""
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
