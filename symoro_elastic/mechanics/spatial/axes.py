"""The spatial axis a_j of a joint [4]."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar, TypeVar

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.spatial.twists import AT_REST, SpatialVector, Twist
from symoro_elastic.mechanics.spatial.vectors import ZERO, Z

S = TypeVar("S", bound=SpatialVector)


class Axis(Enum):
    """a_j = [0 0 s1 | 0 0 s0]^T [4]: along z, linear or angular, or none."""

    REVOLUTE = 0
    PRISMATIC = 1
    NONE = 2

    __array_ufunc__: ClassVar[None] = None  # an array on the left is one scalar

    def __rmul__(self, rate: Scalar) -> Twist:
        """The twist rate a_j."""
        if self is Axis.NONE:
            return AT_REST
        along = ZERO.with_entry(Z, rate)
        return Twist(along, ZERO) if self is Axis.PRISMATIC else Twist(ZERO, along)  # (4)

    @property
    def T(self) -> TransposedAxis:
        """The transpose, which selects the component along the joint."""
        return TransposedAxis(self)

    def with_entry(self, V: S, along: Scalar) -> S:
        """The twist or wrench with another component along the joint."""
        if self is Axis.REVOLUTE:
            return type(V)(V.linear, V.angular.with_entry(Z, along))
        return type(V)(V.linear.with_entry(Z, along), V.angular)


@dataclass(frozen=True)
class TransposedAxis:
    """Transposed joint axis a_j^T [4], which selects the component along the joint."""

    of: Axis

    def __mul__(self, f: SpatialVector) -> Scalar:
        """The component of a wrench or twist along the joint."""
        return (f.angular if self.of is Axis.REVOLUTE else f.linear).z
