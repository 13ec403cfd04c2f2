"""Twists and wrenches, linear part first: V = [v; w], f = [force; moment]."""

from __future__ import annotations

from typing import ClassVar, NamedTuple, Self

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.spatial.vectors import ZERO, Vector, dot


class _Parts(NamedTuple):
    linear: Vector
    angular: Vector


class SpatialVector(_Parts):
    """The six entries of a twist or a wrench in two vectors, linear part first."""

    __slots__ = ()
    __array_ufunc__: ClassVar[None] = None  # an array on the left is one scalar

    def __add__(self, other: Self) -> Self:  # type: ignore[override]
        return type(self)(self.linear + other.linear, self.angular + other.angular)

    def __sub__(self, other: Self) -> Self:
        return type(self)(self.linear - other.linear, self.angular - other.angular)

    def __neg__(self) -> Self:
        return type(self)(-self.linear, -self.angular)

    def __mul__(self, factor: Scalar) -> Self:  # type: ignore[override]
        return type(self)(self.linear * factor, self.angular * factor)

    def __rmul__(self, factor: Scalar) -> Self:  # type: ignore[override]
        return self * factor

    @property
    def entries(self) -> tuple[Scalar, ...]:
        """The six entries, linear part first."""
        return (*self.linear, *self.angular)


class Twist(SpatialVector):
    """A velocity or an acceleration: of the origin of a frame (m/s, m/s2), and the angular one (rad/s, rad/s2)."""

    __slots__ = ()


class Wrench(SpatialVector):
    """A force (N) and its moment about the origin of a frame (N m)."""

    __slots__ = ()

    @property
    def force(self) -> Vector:
        """The force, N."""
        return self.linear

    @property
    def moment(self) -> Vector:
        """The moment about the origin of the frame, N m."""
        return self.angular

    def dot(self, V: Twist) -> Scalar:
        """Power on a twist in the same frame: f^T V."""
        return dot(self.linear, V.linear) + dot(self.angular, V.angular)


AT_REST = Twist(ZERO, ZERO)
NO_WRENCH = Wrench(ZERO, ZERO)
