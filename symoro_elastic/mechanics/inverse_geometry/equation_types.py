"""The types of equations that Paul's method meets, each with all its solutions.

Every unknown angle comes out of one arc tangent of two arguments, in (-pi, pi]; solutions are told
apart by the sign of a square root. The square root is NaN where its argument is negative by more
than rounding, and NaN stays NaN in all that follows, so what cannot be reached has no value.

Sources: Paul, Robot Manipulators (1981); Khalil and Dombre, Modeling, Identification and Control of
Robots (2002), chapter 4, whose numbers the types have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from symoro_elastic.mechanics.spatial import IDENTITY, ZERO, AxialTransform, Matrix, Scalar, Vector, Z, dot

ROUNDING = Fraction(1, 2**40)
SMALL = Fraction(1, 2**70)
SIGNS = (1, -1)


@dataclass(frozen=True)
class Functions:
    """Operations that the equations need in addition to + - * /.

    `turn` gives the angle of a point (x, y) of known distance from the origin, its cosine and its sine. `is_zero` tells
    what is zero for all values of the variables, `is_fixed` what the place to be reached does not change.
    """

    square_root: Callable[[Scalar], Scalar]
    turn: Callable[[Scalar, Scalar, Scalar], tuple[Scalar, Scalar, Scalar]]
    sign: Callable[[Scalar], Scalar]
    is_zero: Callable[[Scalar], bool]
    is_fixed: Callable[[Scalar], bool]


class Miss(NamedTuple):
    """Reason why two neighbouring axes have no closed form: "parallel", "apart" or, meeting a third, "elsewhere".

    `joint` is the second of the two in the table; where they meet others elsewhere, the one between.
    """

    joint: int
    how: str


class NoClosedForm(Exception):
    """Raised where a closed form does not exist, with the reason and the numbers of the joints that cause it.

    `condition` is the part of the method that failed, `miss` the relation of the axes.
    """

    def __init__(self, joints: tuple[int, ...], reason: str, miss: Miss | None = None, condition: str = "") -> None:
        super().__init__(reason)
        self.joints, self.reason, self.miss, self.condition = joints, reason, miss, condition


class Found(NamedTuple):
    """A solution for one joint: its variable (rad or m), the motion it makes, and the joint's number.

    `measure` is zero where the solution is singular, one where that cannot happen.
    """

    joint: int
    variable: Scalar
    motion: AxialTransform
    measure: Scalar = 1

    def from_other_end(self) -> Found:
        """The solution of the joint passed from its far side."""
        cosine, sine, shift = self.motion[1:]
        return Found(self.joint, -self.variable, AxialTransform(Z, cosine, -sine, -shift), self.measure)

    def point(self, v: Vector) -> Vector:
        """A point of the moved frame in the frame before the joint."""
        x, y, z = self.motion.rotate(v)
        return Vector(x, y, z + self.motion.shift)

    def point_back(self, v: Vector) -> Vector:
        """A point of the frame before the joint in the moved frame."""
        return self.motion.rotate_back(Vector(v.x, v.y, v.z - self.motion.shift))


class Pose(NamedTuple):
    """Orientation and origin of a frame in another: iTj."""

    rotation: Matrix
    origin: Vector

    def point(self, v: Vector) -> Vector:
        """Coordinates in frame i of a point given in frame j."""
        return self.rotation * v + self.origin

    def point_back(self, v: Vector) -> Vector:
        """Coordinates in frame j of a point given in frame i."""
        return self.rotation.T * (v - self.origin)

    def then(self, other: Pose) -> Pose:
        """The product iTj jTk."""
        columns = Matrix(*(self.rotation * column for column in other.rotation.T))
        return Pose(columns.T, self.point(other.origin))

    def moved(self, step: AxialTransform) -> Pose:
        """iTj followed by a screw about an axis of frame j."""
        rows = self.rotation
        origin = self.origin + (step.shift * rows.T[step.axis])
        return Pose(step.rotate_rows(rows), origin)

    def inverse(self) -> Pose:
        """The inverse pose jTi."""
        back = self.rotation.T
        return Pose(back, -(back * self.origin))


STILL = Pose(IDENTITY, ZERO)


def along(shift: Scalar) -> Vector:
    """A point of the z axis."""
    return Vector(0, 0, shift)


def plane_dot(u: Vector, v: Vector) -> Scalar:
    """Scalar product of the parts normal to z."""
    return u[0] * v[0] + u[1] * v[1]


def plane_cross(u: Vector, v: Vector) -> Scalar:
    """z component of the vector product."""
    return u[0] * v[1] - u[1] * v[0]


def is_along_z(f: Functions, v: Vector) -> bool:
    """Whether a vector is parallel to z for all values of the variables."""
    return f.is_zero(v[0]) and f.is_zero(v[1])


def distance(f: Functions, v: Vector) -> Scalar:
    """Distance from the z axis; its sign has no meaning."""
    x, y = (0 if f.is_zero(x) else x for x in v[:2])
    return y if f.is_zero(x) else x if f.is_zero(y) else f.square_root(x * x + y * y)


def turned_to(f: Functions, joint: int, x: Scalar, y: Scalar, distance: Scalar, measure: Scalar = 1) -> Found:
    """A revolute joint at the angle of the point (x, y), which has this distance from the origin."""
    angle, cosine, sine = f.turn(x, y, distance)
    return Found(joint, angle, AxialTransform(Z, cosine, sine, 0), measure)


def shifted_by(joint: int, length: Scalar, measure: Scalar = 1) -> Found:
    """A prismatic joint at a length, m."""
    return Found(joint, length, AxialTransform(Z, 1, 0, length), measure)


def only_where(f: Functions, positive: Scalar) -> Scalar:
    """One where a number is positive and NaN where it is negative: a divisor."""
    return f.sign(f.square_root(positive))


def real_root(f: Functions, x: Scalar, size: Scalar, scale: Scalar = 0) -> Scalar:
    """Square root of x; zero where x is negative by rounding, else NaN.

    `size` is what x is compared with where it vanishes, `scale` that of its terms where `size` vanishes too.
    """
    positive_part = x * (1 + f.sign(x)) * Fraction(1, 2)
    return f.square_root(positive_part) / only_where(f, x + (ROUNDING * size + SMALL * scale))


class Difference(NamedTuple):
    """The difference size - part^2, where size is not negative; `scale` is the scale of the terms of part^2."""

    size: Scalar
    part: Scalar
    scale: Scalar

    @property
    def value(self) -> Scalar:
        """The value of size - part^2."""
        return self.size - self.part * self.part

    def root(self, f: Functions) -> Scalar:
        """The square root of size - part^2: zero where it is negative by rounding, NaN where it is more negative."""
        if f.is_zero(self.part):
            return f.square_root(self.size)
        return real_root(f, self.value, self.size, self.scale)


def type_2(f: Functions, joint: int, x: Scalar, y: Scalar, z: Scalar, root: Scalar) -> list[Found]:
    """Solve X cos q + Y sin q = Z: two angles, one where X^2 + Y^2 = Z^2.

    `root` is D = sqrt(X^2 + Y^2 - Z^2), in the form that loses the fewest digits; then
    q = atan2(Y Z + e X D, X Z - e Y D) with e = 1 and -1, and D is the measure.
    """
    if f.is_zero(z):
        measure = f.square_root(x * x + y * y)
        return [turned_to(f, joint, -e * y, e * x, measure, measure) for e in SIGNS]
    points = [(x * z - e * (y * root), y * z + e * (x * root)) for e in SIGNS]
    return [turned_to(f, joint, *point, x * x + y * y, root) for point in points]


def type_3(f: Functions, joint: int, v: Vector, u: Vector, measure: Scalar = 1) -> Found:
    """Solve Rot(z, q) v = u, two equations in cos q and sin q: one angle, any where v lies on z."""
    fixed = v if f.is_fixed(plane_dot(v, v)) else u
    return turned_to(f, joint, plane_dot(v, u), plane_cross(v, u), plane_dot(fixed, fixed), measure)


def quadratic(f: Functions, joint: int, a: Scalar, h: Scalar, root: Scalar) -> list[Found]:
    """Solve a r^2 + 2 h r + c = 0 with `root` = sqrt(h^2 - a c): two lengths."""
    return [shifted_by(joint, (e * root - h) / a, root) for e in SIGNS]


def heron(f: Functions, a: Scalar, b: Scalar, c: Scalar) -> Scalar:
    """Four times the area of a triangle with these sides, NaN where they make none (type 8)."""
    x = (a + b + c) * (a + b - c) * ((c + a - b) * (c - a + b))
    return real_root(f, x, a * a * (b * b), (a * a + b * b) * (a * a + b * b))


class Quadric(NamedTuple):
    """Surface of the points x with x.S x + 2 b.x + k = 0."""

    S: Matrix
    b: Vector
    k: Scalar

    def value(self, x: Vector) -> Scalar:
        """Value of x.S x + 2 b.x + k, zero for points of the surface."""
        return dot(x, self.S * x) + 2 * dot(self.b, x) + self.k

    def seen_from(self, pose: Pose) -> Quadric:
        """The same surface in the frame in which `pose` places its own."""
        R, p = pose
        columns = Matrix(*(R * row for row in self.S))
        S = Matrix(*(R * row for row in columns.T))
        b = R * self.b
        k = self.k - 2 * dot(b, p) + dot(p, S * p)
        return Quadric(S, b - S * p, k)


def plane(normal: Vector, height: Scalar) -> Quadric:
    """The plane normal.x = height."""
    return Quadric(Matrix(ZERO, ZERO, ZERO), Fraction(1, 2) * normal, -height)
