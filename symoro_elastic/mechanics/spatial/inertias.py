"""Inertias: of a rigid body by its ten parameters, and articulated ones by blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.spatial.axes import Axis
from symoro_elastic.mechanics.spatial.transforms import AxialTransform, Rotation, Transform
from symoro_elastic.mechanics.spatial.twists import Twist, Wrench
from symoro_elastic.mechanics.spatial.vectors import ENTRY, NONE, ZERO, Matrix, Symmetric, Vector, Z


@dataclass(frozen=True)
class RigidInertia:
    """Mass M, first moments MS and inertia J of a rigid body about the origin of its frame [13]."""

    mass: Scalar = 0
    moments: Vector = ZERO
    inertia: Symmetric = NONE

    @classmethod
    def about_center(cls, mass: Scalar, center: Vector, inertia: Symmetric) -> RigidInertia:
        """The inertia of a body from its centre of mass and the inertia about it, by the parallel-axis theorem."""
        (x, y, z), (mx, my, mz) = center, mass * center
        xx, xy, xz, yy, yz, zz = inertia
        xm, ym, zm = x * mx, y * my, z * mz
        about_origin = (xx + ym + zm, xy - x * my, xz - x * mz, yy + xm + zm, yz - y * mz, zz + xm + ym)
        return cls(mass, Vector(mx, my, mz), Symmetric(*about_origin))

    def __add__(self, other: RigidInertia) -> RigidInertia:
        inertia = self.inertia + other.inertia
        return RigidInertia(self.mass + other.mass, self.moments + other.moments, inertia)

    @property
    def spatial(self) -> ArticulatedInertia:
        """JJ = [[M I3, -hat(MS)], [hat(MS), J]]."""
        m, (x, y, z) = self.mass, self.moments
        B = Matrix(Vector(0, z, -y), Vector(-z, 0, x), Vector(y, -x, 0))
        return ArticulatedInertia(Symmetric(m, 0, 0, m, 0, m), B, self.inertia)  # (13)

    def to_antecedent(self, transform: Transform) -> RigidInertia:
        """The same body, described in the antecedent frame."""
        body = self
        for step in reversed(transform.steps):
            body = body._translate(step)
            body = RigidInertia(body.mass, step.rotate(body.moments), _rotated_symmetric(step, body.inertia))
        return body

    def _translate(self, step: AxialTransform) -> RigidInertia:
        """Parallel-axis theorem along a coordinate axis."""
        i, j = step.plane
        k, shift = step.axis, step.shift
        moments = self.moments.with_entry(k, self.moments[k] + shift * self.mass)
        inertia = list(self.inertia)
        growth = shift * (self.moments[k] + moments[k])
        inertia[ENTRY[i][i]] = inertia[ENTRY[i][i]] + growth
        inertia[ENTRY[j][j]] = inertia[ENTRY[j][j]] + growth
        inertia[ENTRY[i][k]] = inertia[ENTRY[i][k]] - shift * self.moments[i]
        inertia[ENTRY[j][k]] = inertia[ENTRY[j][k]] - shift * self.moments[j]
        return RigidInertia(self.mass, moments, Symmetric(*inertia))


class Outer(NamedTuple):
    """The product U V^T of two wrenches."""

    U: Wrench
    V: Wrench


@dataclass(frozen=True)
class ArticulatedInertia:
    """Symmetric 6x6 inertia [[A, B], [B^T, D]]: force = A v + B w, moment = B^T v + D w."""

    A: Symmetric
    B: Matrix
    D: Symmetric

    @classmethod
    def zero(cls) -> ArticulatedInertia:
        """No inertia."""
        return cls(NONE, Matrix(ZERO, ZERO, ZERO), NONE)

    def __add__(self, other: ArticulatedInertia) -> ArticulatedInertia:
        return ArticulatedInertia(self.A + other.A, self.B + other.B, self.D + other.D)

    def __mul__(self, V: Twist | Axis) -> Wrench:
        """The wrench that gives this inertia an acceleration V, or a unit acceleration along a joint."""
        if V is Axis.REVOLUTE:
            return Wrench(self.B.T[Z], self.D.full[Z])
        if isinstance(V, Axis):
            return Wrench(self.A.full[Z], self.B[Z])
        v, w = V
        force = self.A * v + self.B * w
        return Wrench(force, self.B.T * v + self.D * w)

    @property
    def rows(self) -> list[tuple[Scalar, ...]]:
        """All entries, row by row."""
        upper = [(*a, *b) for a, b in zip(self.A.full, self.B, strict=True)]
        return [*upper, *((*b, *d) for b, d in zip(self.B.T, self.D.full, strict=True))]

    def __sub__(self, other: Outer) -> ArticulatedInertia:
        """J - U V^T, one triangle computed; symmetric where V is a multiple of U."""
        (U, V), A, B, D = other, list(self.A), [list(row) for row in self.B], list(self.D)
        for m in range(3):
            for n in range(3):
                B[m][n] = B[m][n] - U.force[m] * V.moment[n]
                if m <= n:
                    A[ENTRY[m][n]] = A[ENTRY[m][n]] - U.force[m] * V.force[n]
                    D[ENTRY[m][n]] = D[ENTRY[m][n]] - U.moment[m] * V.moment[n]
        return ArticulatedInertia(Symmetric(*A), Matrix(*(Vector(*row) for row in B)), Symmetric(*D))

    def with_entry(self, axis: Axis, column: Wrench) -> ArticulatedInertia:
        """The inertia with another row and column of a joint."""
        A, B, D = list(self.A), [list(row) for row in self.B], list(self.D)
        for m in range(3):
            if axis is Axis.REVOLUTE:
                B[m][Z], D[ENTRY[m][Z]] = column.force[m], column.moment[m]
            else:
                A[ENTRY[m][Z]], B[Z][m] = column.force[m], column.moment[m]
        return ArticulatedInertia(Symmetric(*A), Matrix(*(Vector(*row) for row in B)), Symmetric(*D))

    def to_antecedent(self, transform: Transform) -> ArticulatedInertia:
        """The congruence jTi^T K jTi, step by step; rotated before it is translated, K keeps its zeros longer."""
        moved = self
        for step in reversed(transform.steps):
            moved = moved._rotated_back(step)._translate(step)
        return moved

    def rotated_back(self, rotation: Rotation) -> ArticulatedInertia:
        """R^T J R: the same inertia in the axes before a rotation."""
        return self._rotated_back(rotation.step)

    def _rotated_back(self, step: AxialTransform) -> ArticulatedInertia:
        A, B = _rotated_symmetric(step, self.A), rotated_matrix(step, self.B)
        return ArticulatedInertia(A, B, _rotated_symmetric(step, self.D))

    def _translate(self, step: AxialTransform) -> ArticulatedInertia:
        """Translation by p along a coordinate axis: B - A hat(p), D + (hat(p) B)^T + hat(p) (B - A hat(p))."""
        i, j = step.plane
        k, p = step.axis, step.shift
        a, b, d = self.A.full, [list(row) for row in self.B], list(self.D)
        for n in range(3):
            b[n][i] = b[n][i] - p * a[n][j]
            b[n][j] = b[n][j] + p * a[n][i]
        d[ENTRY[i][k]] = d[ENTRY[i][k]] - p * b[j][k]
        d[ENTRY[j][k]] = d[ENTRY[j][k]] + p * b[i][k]
        d[ENTRY[i][i]] = d[ENTRY[i][i]] - p * (self.B[j][i] + b[j][i])
        d[ENTRY[j][j]] = d[ENTRY[j][j]] + p * (self.B[i][j] + b[i][j])
        d[ENTRY[i][j]] = d[ENTRY[i][j]] + p * (self.B[i][i] - b[j][j])
        return ArticulatedInertia(self.A, Matrix(*(Vector(*row) for row in b)), Symmetric(*d))


def _rotated_symmetric(step: AxialTransform, s: Symmetric) -> Symmetric:
    """R S R^T of a symmetric matrix."""
    i, j = step.plane
    k = step.axis
    rotated = list(s)
    ii, ij, jj = ENTRY[i][i], ENTRY[i][j], ENTRY[j][j]
    rotated[ii], rotated[ij], _, rotated[jj] = step.rotate_block(s[ii], s[ij], s[ij], s[jj])
    column = step.rotate(Vector(*(0 if n == k else s[ENTRY[n][k]] for n in range(3))))
    rotated[ENTRY[i][k]], rotated[ENTRY[j][k]] = column[i], column[j]
    return Symmetric(*rotated)


def rotated_matrix(step: AxialTransform, m: Matrix) -> Matrix:
    """R M R^T of a general matrix."""
    i, j = step.plane
    k = step.axis
    rotated = [list(row) for row in m]
    rotated[i][i], rotated[i][j], rotated[j][i], rotated[j][j] = step.rotate_block(m[i][i], m[i][j], m[j][i], m[j][j])
    column = step.rotate(Vector(m[0][k], m[1][k], m[2][k]))
    row = step.rotate(m[k])
    rotated[i][k], rotated[j][k] = column[i], column[j]
    rotated[k][i], rotated[k][j] = row[i], row[j]
    return Matrix(*(Vector(*entries) for entries in rotated))
