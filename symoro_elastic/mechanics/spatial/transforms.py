"""Transforms between frames, step by step about and along coordinate axes.

iTj = Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r) [1] is a product of three
axial transforms. Each rotates two components of a vector and leaves the third, so that a congruence
costs a few planar rotations instead of products of full matrices. With jAi and iPj of [1],

    jTi = [[jAi, -jAi hat(iPj)], [0, jAi]]                                              [5]

maps a twist from frame i to frame j, and its transpose a wrench from frame j to frame i.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.spatial.twists import SpatialVector, Twist, Wrench
from symoro_elastic.mechanics.spatial.vectors import ZERO, Matrix, Vector, X, Z, is_zero

Block = tuple[Scalar, Scalar, Scalar, Scalar]
Turn = tuple[Scalar, Scalar]
S = TypeVar("S", bound=SpatialVector)


class AxialTransform(NamedTuple):
    """Rotation about a coordinate axis (X or Z), then translation along it; R is its rotation, p its translation."""

    axis: int
    cosine: Scalar
    sine: Scalar
    shift: Scalar

    @property
    def permutes(self) -> bool:
        """Whether the rotation only exchanges components, or is the identity."""
        return is_zero(self.sine) or is_zero(self.cosine)

    @property
    def plane(self) -> tuple[int, int]:
        """The two components that rotate, in positive sense."""
        return (1, 2) if self.axis == X else (0, 1)

    @property
    def rotation(self) -> AxialTransform:
        """The rotation of this axial transform, without its translation."""
        return self._replace(shift=0)

    @property
    def translation(self) -> AxialTransform:
        """The translation of this axial transform, without its rotation."""
        return self._replace(cosine=1, sine=0)

    @property
    def along(self) -> Vector:
        """The translation p, the same in both frames."""
        return ZERO.with_entry(self.axis, self.shift)

    def rotate(self, v: Vector) -> Vector:
        """R v: components in the antecedent frame of a vector given in the moved frame."""
        x, y, z = v
        cosine, sine = self.cosine, self.sine
        if self.axis == X:
            return Vector(x, cosine * y - sine * z, sine * y + cosine * z)
        return Vector(cosine * x - sine * y, sine * x + cosine * y, z)

    def rotate_back(self, v: Vector) -> Vector:
        """R^T v: components in the moved frame of a vector given in the antecedent frame."""
        x, y, z = v
        cosine, sine = self.cosine, self.sine
        if self.axis == X:
            return Vector(x, cosine * y + sine * z, -(sine * y) + cosine * z)
        return Vector(cosine * x + sine * y, -(sine * x) + cosine * y, z)

    def rotate_rows(self, m: Matrix) -> Matrix:
        """The product M R of a matrix and the rotation."""
        return Matrix(self.rotate_back(m.x), self.rotate_back(m.y), self.rotate_back(m.z))

    def rotate_rows_back(self, m: Matrix) -> Matrix:
        """The product M R^T of a matrix and the rotation back."""
        return Matrix(self.rotate(m.x), self.rotate(m.y), self.rotate(m.z))

    def translate(self, point: Vector) -> Vector:
        """The point p + v."""
        return point.with_entry(self.axis, point[self.axis] + self.shift)

    def moment(self, force: Vector) -> Vector:
        """The moment p x force."""
        i, j = self.plane
        return ZERO.with_entry(i, -(self.shift * force[j])).with_entry(j, self.shift * force[i])

    def rotate_block(self, a: Scalar, b: Scalar, c: Scalar, d: Scalar) -> Block:
        """R [[a, b], [c, d]] R^T in the plane that rotates.

        The trace and b - c are invariant; one combination of a - d and b + c gives the changes. Quarter turns
        permute the entries. For a symmetric matrix b is c, and 2 cos(...) serves all its blocks.
        """
        cosine, sine = self.cosine, self.sine
        if is_zero(sine):
            return a, b, c, d
        if is_zero(cosine):
            return d, -c, -b, a
        h = sine * (a - d) + (2 * cosine * b if b is c else cosine * (b + c))
        return a - sine * h, cosine * h - c, cosine * h - b, d + sine * h


@dataclass(frozen=True)
class Rotation:
    """A change of axes at one origin, the same for twists and wrenches."""

    step: AxialTransform

    def __mul__(self, V: S) -> S:
        """The twist or wrench in the rotated axes."""
        return type(V)(self.step.rotate_back(V.linear), self.step.rotate_back(V.angular))

    @property
    def T(self) -> Rotation:
        """The rotation back."""
        return Rotation(self.step._replace(sine=-self.step.sine))


@dataclass(frozen=True)
class Transform:
    """jTi [5], from an antecedent frame i to a frame j: axial transforms in a row, from i to j."""

    steps: tuple[AxialTransform, ...]

    def __mul__(self, V: Twist) -> Twist:
        """The twist jTi V of a motion given in frame i."""
        linear, angular = V
        for step in self.steps:
            linear, angular = step.rotate_back(linear), step.rotate_back(angular)
            linear = linear - step.moment(angular)  # (5)
        return Twist(linear, angular)

    @property
    def T(self) -> TransposedTransform:
        """The transpose, which maps wrenches from frame j to frame i."""
        return TransposedTransform(self)

    def after(self, first: Transform) -> Transform:
        """The transform of two in a row, `first` the one nearer to the base."""
        return Transform((*first.steps, *self.steps))

    @property
    def permutes(self) -> bool:
        """Whether its rotation only exchanges components."""
        return all(step.permutes for step in self.steps)

    def to_child(self, v: Vector) -> Vector:
        """Components jAi v of a vector given in frame i."""
        for step in self.steps:
            v = step.rotate_back(v)
        return v

    def to_antecedent(self, v: Vector) -> Vector:
        """Components iAj v of a vector given in frame j."""
        for step in reversed(self.steps):
            v = step.rotate(v)
        return v

    @property
    def origin(self) -> Vector:
        """The origin iPj of frame j, in frame i."""
        point = ZERO
        for step in reversed(self.steps):
            point = step.rotate(step.translate(point))
        return point

    @property
    def origin_in_child(self) -> Vector:
        """The vector jAi iPj from the origin of frame i to that of frame j, in frame j."""
        point = ZERO
        for step in self.steps:
            point = step.translate(step.rotate_back(point))
        return point


@dataclass(frozen=True)
class TransposedTransform:
    """Transposed transform jTi^T [5], which maps wrenches from frame j to frame i."""

    of: Transform

    def __mul__(self, f: Wrench) -> Wrench:
        """The wrench jTi^T f: about the origin of frame i, in frame i."""
        force, moment = f
        for step in reversed(self.of.steps):
            moment = step.rotate(moment + step.moment(force))  # (5)
            force = step.rotate(force)
        return Wrench(force, moment)


def transform(steps: Iterable[AxialTransform]) -> Transform:
    """The transform of axial transforms in a row."""
    return Transform(tuple(steps))


def translation(v: Vector) -> Transform:
    """A translation: along z, and along x and y between two quarter turns."""
    x, y, z = v
    steps = ((Z, 0, 1, z), (X, 1, 0, y), (Z, 0, -1, 0), (X, 1, 0, x))
    return transform(AxialTransform(*step) for step in steps)


def roll_pitch_yaw(roll: Turn, pitch: Turn, yaw: Turn) -> Transform:
    """Rot(z, yaw) Rot(y, pitch) Rot(x, roll), angles as cosine and sine; y is z between two quarter turns about x."""
    turns = ((Z, *yaw), (X, 0, -1), (Z, *pitch), (X, 0, 1), (X, *roll))
    return transform(AxialTransform(*turn, 0) for turn in turns)
