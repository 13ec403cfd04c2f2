"""Screws, wrenches and inertias by blocks, moved from frame to frame by elementary screws.

Screws and wrenches are linear part first: V = [v; w], f = [force; moment]. A placement
iTj = Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r) [1] is a product of
three screws about and along a coordinate axis; each turns two coordinates of a vector and leaves
the third, so a congruence costs a few planar turns instead of products of full matrices.

Scalars may be anything with + - * /; the exact integers 0 and 1 stand for structure.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

Scalar = Any
Vector = tuple[Scalar, Scalar, Scalar]
Matrix = tuple[Vector, Vector, Vector]
Pair = tuple[Vector, Vector]
Symmetric = tuple[Scalar, Scalar, Scalar, Scalar, Scalar, Scalar]

ZERO: Vector = (0, 0, 0)
NOTHING: Pair = (ZERO, ZERO)
ENTRY = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
X, Z = 0, 2


class Screw(NamedTuple):
    """Turn about a coordinate axis (X or Z) and shift along it."""

    axis: int
    cosine: Scalar
    sine: Scalar
    shift: Scalar

    @property
    def turns_by_quarters(self) -> bool:
        """Whether the turn only exchanges coordinates, or is none."""
        return is_zero(self.sine) or is_zero(self.cosine)

    @property
    def plane(self) -> tuple[int, int]:
        """The two coordinates that turn, in positive sense."""
        return (1, 2) if self.axis == X else (0, 1)


Placement = tuple[Screw, ...]


def translation(v: Vector) -> Placement:
    """A shift without a turn: along z, and along x and y between two quarter turns."""
    x, y, z = v
    return Screw(Z, 0, 1, z), Screw(X, 1, 0, y), Screw(Z, 0, -1, 0), Screw(X, 1, 0, x)


def add(u: Vector, v: Vector) -> Vector:
    """Sum of two vectors."""
    return (u[0] + v[0], u[1] + v[1], u[2] + v[2])


def subtract(u: Vector, v: Vector) -> Vector:
    """Difference of two vectors."""
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


def scale(factor: Scalar, v: Vector) -> Vector:
    """Product of a scalar and a vector."""
    return (factor * v[0], factor * v[1], factor * v[2])


def dot(u: Vector, v: Vector) -> Scalar:
    """Scalar product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Vector, v: Vector) -> Vector:
    """Vector product u x v."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def times(m: Matrix, v: Vector) -> Vector:
    """Product of a 3x3 matrix and a vector."""
    return (dot(m[0], v), dot(m[1], v), dot(m[2], v))


def times_symmetric(s: Symmetric, v: Vector) -> Vector:
    """Product of a symmetric 3x3 matrix and a vector."""
    return times(full(s), v)


def full(s: Symmetric) -> Matrix:
    """All nine entries of a symmetric matrix given by its upper triangle."""
    return ((s[0], s[1], s[2]), (s[1], s[3], s[4]), (s[2], s[4], s[5]))


def transpose(m: Matrix) -> Matrix:
    """Transpose of a 3x3 matrix."""
    return ((m[0][0], m[1][0], m[2][0]), (m[0][1], m[1][1], m[2][1]), (m[0][2], m[1][2], m[2][2]))


def hat_plus_hat_squared(w: Vector, wd: Vector, along: Vector | None = None) -> Matrix:
    """U = hat(wd) + hat(w) hat(w), the acceleration of points of a turning body by where they are.

    `along` is U z where it is known.
    """
    x, y, z = w
    xx, xy, xz, yy, yz, zz = x * x, x * y, x * z, y * y, y * z, z * z
    along_x = -(yy + zz) if along is None else (xx - zz) + along[2]
    along_z = (xz + wd[1], yz - wd[0], -(xx + yy)) if along is None else along
    return (
        (along_x, xy - wd[2], along_z[0]),
        (xy + wd[2], -(xx + zz), along_z[1]),
        (xz - wd[1], yz + wd[0], along_z[2]),
    )


def turn(screw: Screw, v: Vector) -> Vector:
    """Components in the antecedent frame of a vector given in the moved frame."""
    return _turned(screw, v, screw.sine)


def turn_back(screw: Screw, v: Vector) -> Vector:
    """Components in the moved frame of a vector given in the antecedent frame."""
    return _turned(screw, v, -screw.sine)


def _turned(screw: Screw, v: Vector, sine: Scalar) -> Vector:
    i, j = screw.plane
    turned = list(v)
    turned[i] = screw.cosine * v[i] - sine * v[j]
    turned[j] = sine * v[i] + screw.cosine * v[j]
    return (turned[0], turned[1], turned[2])


def to_child(placement: Placement, v: Vector) -> Vector:
    """jAi v."""
    for screw in placement:
        v = turn_back(screw, v)
    return v


def to_antecedent(placement: Placement, v: Vector) -> Vector:
    """iAj v."""
    for screw in reversed(placement):
        v = turn(screw, v)
    return v


def origin(placement: Placement) -> Vector:
    """iPj, origin of the moved frame in the antecedent frame."""
    point = ZERO
    for screw in reversed(placement):
        point = turn(screw, shifted(screw, point))
    return point


def arm(placement: Placement) -> Vector:
    """Origin of the moved frame seen from that of the antecedent frame, in the moved frame."""
    point = ZERO
    for screw in placement:
        point = shifted(screw, turn_back(screw, point))
    return point


def shifted(screw: Screw, point: Vector) -> Vector:
    """A point moved along the axis of a screw."""
    moved = list(point)
    moved[screw.axis] = moved[screw.axis] + screw.shift
    return (moved[0], moved[1], moved[2])


def lever(screw: Screw, force: Vector) -> Vector:
    """Moment (shift along the axis) x force."""
    i, j = screw.plane
    moment: list[Scalar] = [0, 0, 0]
    moment[i] = -(screw.shift * force[j])
    moment[j] = screw.shift * force[i]
    return (moment[0], moment[1], moment[2])


def screw_to_child(placement: Placement, motion: Pair) -> Pair:
    """jTi V: a screw of the antecedent frame taken at the moved frame [5]."""
    linear, angular = motion
    for screw in placement:
        linear, angular = turn_back(screw, linear), turn_back(screw, angular)
        linear = subtract(linear, lever(screw, angular))
    return linear, angular


def wrench_to_antecedent(placement: Placement, wrench: Pair) -> Pair:
    """jTi^T f: a wrench of the moved frame taken at the antecedent frame."""
    force, moment = wrench
    for screw in reversed(placement):
        moment = turn(screw, add(moment, lever(screw, force)))
        force = turn(screw, force)
    return force, moment


def is_zero(x: Scalar) -> bool:
    """Whether a scalar is the exact zero of structure."""
    return isinstance(x, int | Fraction) and x == 0


def _turned_block(screw: Screw, a: Scalar, b: Scalar, c: Scalar, d: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """R [[a, b], [c, d]] R^T for the planar turn R of a screw.

    The trace and b - c do not change; what does follows from one combination of a - d and b + c.
    Quarter turns permute the entries. Of a symmetric matrix b and c are one, and 2 C serves all its blocks.
    """
    cosine, sine = screw.cosine, screw.sine
    if is_zero(sine):
        return a, b, c, d
    if is_zero(cosine):
        return d, -c, -b, a
    h = sine * (a - d) + (2 * cosine * b if b is c else cosine * (b + c))
    return a - sine * h, cosine * h - c, cosine * h - b, d + sine * h


def turn_symmetric(screw: Screw, s: Symmetric) -> Symmetric:
    """R S R^T of a symmetric matrix."""
    i, j = screw.plane
    k = screw.axis
    turned: list[Scalar] = list(s)
    ii, ij, jj = ENTRY[i][i], ENTRY[i][j], ENTRY[j][j]
    turned[ii], turned[ij], _, turned[jj] = _turned_block(screw, s[ii], s[ij], s[ij], s[jj])
    column = turn(screw, tuple(0 if n == k else s[ENTRY[n][k]] for n in range(3)))  # type: ignore[arg-type]
    turned[ENTRY[i][k]], turned[ENTRY[j][k]] = column[i], column[j]
    return tuple(turned)


def turn_matrix(screw: Screw, m: Matrix) -> Matrix:
    """R M R^T of a general matrix."""
    i, j = screw.plane
    k = screw.axis
    turned = [list(row) for row in m]
    turned[i][i], turned[i][j], turned[j][i], turned[j][j] = _turned_block(screw, m[i][i], m[i][j], m[j][i], m[j][j])
    column = turn(screw, (m[0][k], m[1][k], m[2][k]))
    row = turn(screw, m[k])
    turned[i][k], turned[j][k] = column[i], column[j]
    turned[k][i], turned[k][j] = row[i], row[j]
    return tuple(tuple(row) for row in turned)  # type: ignore[return-value]


@dataclass(frozen=True)
class RigidInertia:
    """Mass, first moments MS and inertia J of a rigid body about the origin of its frame [13]."""

    mass: Scalar = 0
    moments: Vector = ZERO
    inertia: Symmetric = (0, 0, 0, 0, 0, 0)

    @classmethod
    def about_center(cls, mass: Scalar, center: Vector, inertia: Symmetric) -> RigidInertia:
        """From the centre of mass and the inertia about it, by the parallel-axis theorem."""
        (x, y, z), (mx, my, mz) = center, scale(mass, center)
        xx, xy, xz, yy, yz, zz = inertia
        xm, ym, zm = x * mx, y * my, z * mz
        about_origin = (xx + ym + zm, xy - x * my, xz - x * mz, yy + xm + zm, yz - y * mz, zz + xm + ym)
        return cls(mass, (mx, my, mz), about_origin)

    def __add__(self, other: RigidInertia) -> RigidInertia:
        inertia: Any = tuple(a + b for a, b in zip(self.inertia, other.inertia, strict=True))
        return RigidInertia(self.mass + other.mass, add(self.moments, other.moments), inertia)

    def to_antecedent(self, placement: Placement) -> RigidInertia:
        """The same body, taken at the antecedent frame."""
        body = self
        for screw in reversed(placement):
            body = body._shifted(screw)
            body = RigidInertia(body.mass, turn(screw, body.moments), turn_symmetric(screw, body.inertia))
        return body

    def _shifted(self, screw: Screw) -> RigidInertia:
        """Parallel-axis theorem along a coordinate axis."""
        i, j = screw.plane
        k, shift = screw.axis, screw.shift
        moments = shifted(Screw(k, 1, 0, shift * self.mass), self.moments)
        inertia: list[Scalar] = list(self.inertia)
        growth = shift * (self.moments[k] + moments[k])
        inertia[ENTRY[i][i]] = inertia[ENTRY[i][i]] + growth
        inertia[ENTRY[j][j]] = inertia[ENTRY[j][j]] + growth
        inertia[ENTRY[i][k]] = inertia[ENTRY[i][k]] - shift * self.moments[i]
        inertia[ENTRY[j][k]] = inertia[ENTRY[j][k]] - shift * self.moments[j]
        return RigidInertia(self.mass, moments, tuple(inertia))


@dataclass(frozen=True)
class SpatialInertia:
    """Symmetric 6x6 inertia [[A, B], [B^T, D]]: force = A v + B w, moment = B^T v + D w."""

    A: Symmetric
    B: Matrix
    D: Symmetric

    @classmethod
    def of_body(cls, body: RigidInertia) -> SpatialInertia:
        """[[M I3, -hat(MS)], [hat(MS), J]] [13]."""
        m, (x, y, z) = body.mass, body.moments
        return cls((m, 0, 0, m, 0, m), ((0, z, -y), (-z, 0, x), (y, -x, 0)), body.inertia)

    def __add__(self, other: SpatialInertia) -> SpatialInertia:
        a: Any = tuple(p + q for p, q in zip(self.A, other.A, strict=True))
        b: Any = tuple(add(p, q) for p, q in zip(self.B, other.B, strict=True))
        d: Any = tuple(p + q for p, q in zip(self.D, other.D, strict=True))
        return SpatialInertia(a, b, d)

    def times(self, motion: Pair) -> Pair:
        """Product with a screw, a wrench."""
        v, w = motion
        force = add(times_symmetric(self.A, v), times(self.B, w))
        return force, add(times(transpose(self.B), v), times_symmetric(self.D, w))

    def linear_column(self) -> Pair:
        """Column of a translation along z."""
        return full(self.A)[Z], self.B[Z]

    def angular_column(self) -> Pair:
        """Column of a rotation about z."""
        return transpose(self.B)[Z], full(self.D)[Z]

    def to_antecedent(self, placement: Placement) -> SpatialInertia:
        """jTi^T K jTi, screw by screw [32]; turned before it is shifted, K keeps its zeros longer."""
        moved = self
        for screw in reversed(placement):
            moved = moved.turned(screw)._shifted(screw)
        return moved

    def turned(self, screw: Screw) -> SpatialInertia:
        """The same inertia in axes turned back by a screw, about the same origin."""
        return SpatialInertia(turn_symmetric(screw, self.A), turn_matrix(screw, self.B), turn_symmetric(screw, self.D))

    def _shifted(self, screw: Screw) -> SpatialInertia:
        """Shift by p along a coordinate axis: B - A hat(p), D + (hat(p) B)^T + hat(p) (B - A hat(p))."""
        i, j = screw.plane
        k, p = screw.axis, screw.shift
        a, b, d = full(self.A), [list(row) for row in self.B], list(self.D)
        for n in range(3):
            b[n][i] = b[n][i] - p * a[n][j]
            b[n][j] = b[n][j] + p * a[n][i]
        d[ENTRY[i][k]] = d[ENTRY[i][k]] - p * b[j][k]
        d[ENTRY[j][k]] = d[ENTRY[j][k]] + p * b[i][k]
        d[ENTRY[i][i]] = d[ENTRY[i][i]] - p * (self.B[j][i] + b[j][i])
        d[ENTRY[j][j]] = d[ENTRY[j][j]] + p * (self.B[i][j] + b[i][j])
        d[ENTRY[i][j]] = d[ENTRY[i][j]] + p * (self.B[i][i] - b[j][j])
        return SpatialInertia(self.A, tuple(tuple(row) for row in b), tuple(d))  # type: ignore[arg-type]
