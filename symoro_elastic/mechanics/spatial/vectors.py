"""Vectors and matrices of three dimensions; the exact integers 0 and 1 denote structure."""

from __future__ import annotations

from fractions import Fraction
from typing import ClassVar, NamedTuple

from symoro_elastic.foundation.scalar import Scalar

X, Y, Z = 0, 1, 2


class _Components(NamedTuple):
    x: Scalar
    y: Scalar
    z: Scalar


class Vector(_Components):
    """Vector of three components."""

    __slots__ = ()
    __array_ufunc__: ClassVar[None] = None  # an array on the left is one scalar

    def __add__(self, other: Vector) -> Vector:  # type: ignore[override]
        return Vector(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y, self.z - other.z)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y, -self.z)

    def __mul__(self, factor: Scalar) -> Vector:  # type: ignore[override]
        return Vector(factor * self.x, factor * self.y, factor * self.z)

    def __rmul__(self, factor: Scalar) -> Vector:  # type: ignore[override]
        return self * factor

    def with_entry(self, index: int, component: Scalar) -> Vector:
        """The vector with another component at this index."""
        entries = [*self]
        entries[index] = component
        return Vector(*entries)


ZERO = Vector(0, 0, 0)
EX, EY, EZ = Vector(1, 0, 0), Vector(0, 1, 0), Vector(0, 0, 1)


def dot(u: Vector, v: Vector) -> Scalar:
    """Scalar product."""
    return u.x * v.x + u.y * v.y + u.z * v.z


def cross(u: Vector, v: Vector) -> Vector:
    """Vector product u x v."""
    return Vector(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x)


class Matrix(NamedTuple):
    """Matrix of three rows."""

    x: Vector
    y: Vector
    z: Vector

    @property
    def T(self) -> Matrix:
        """The transpose; its rows are the columns."""
        return Matrix(*(Vector(a, b, c) for a, b, c in zip(*self, strict=True)))

    def __add__(self, other: Matrix) -> Matrix:  # type: ignore[override]
        return Matrix(self.x + other.x, self.y + other.y, self.z + other.z)

    def __mul__(self, v: Vector) -> Vector:  # type: ignore[override]
        return Vector(dot(self.x, v), dot(self.y, v), dot(self.z, v))


IDENTITY = Matrix(EX, EY, EZ)


class Symmetric(NamedTuple):
    """The upper triangle of a symmetric matrix: each entry is computed once."""

    xx: Scalar
    xy: Scalar
    xz: Scalar
    yy: Scalar
    yz: Scalar
    zz: Scalar

    @property
    def full(self) -> Matrix:
        """The full 3 x 3 matrix."""
        xx, xy, xz, yy, yz, zz = self
        return Matrix(Vector(xx, xy, xz), Vector(xy, yy, yz), Vector(xz, yz, zz))

    def __add__(self, other: Symmetric) -> Symmetric:  # type: ignore[override]
        return Symmetric(*(a + b for a, b in zip(self, other, strict=True)))

    def __mul__(self, v: Vector) -> Vector:  # type: ignore[override]
        return self.full * v


NONE = Symmetric(0, 0, 0, 0, 0, 0)
ENTRY = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
"""Position of entry (m, n) in a `Symmetric`."""


def is_zero(x: Scalar) -> bool:
    """Whether a scalar is the exact zero of structure."""
    return isinstance(x, int | Fraction) and x == 0


def hat_plus_hat_squared(w: Vector, wd: Vector, along_z: Vector | None = None) -> Matrix:
    """U = hat(wd) + hat(w) hat(w): U p is the acceleration of a point at p of a rotating body, relative to its origin.

    `along_z` is U z where it is known; the trace of hat(w) hat(w) then gives U_xx without y^2.
    """
    x, y, z = w
    xx, xy, xz, yy, yz, zz = x * x, x * y, x * z, y * y, y * z, z * z
    Uxx = -(yy + zz) if along_z is None else (xx - zz) + along_z.z
    Uz = Vector(xz + wd.y, yz - wd.x, -(xx + yy)) if along_z is None else along_z
    return Matrix(
        Vector(Uxx, xy - wd.z, Uz.x),
        Vector(xy + wd.z, -(xx + zz), Uz.y),
        Vector(xz - wd.y, yz + wd.x, Uz.z),
    )  # fmt: skip
