"""Kinetic, gravity and elastic energy; their sum changes only by what motors, friction and dampers do."""

from __future__ import annotations

from symoro_elastic.equations.kinematics import Scalars, velocities
from symoro_elastic.equations.mechanism import Mechanism
from symoro_elastic.equations.spatial import Matrix, Scalar, SpatialInertia, Vector, add, dot, scale, times


def kinetic_energy(mechanism: Mechanism, qd: Scalars) -> Scalar:
    """(sum of V_j^T JJ_j V_j + Ia_j qd_j^2) / 2, in J."""
    twice: Scalar = 0
    for (j, link), (v, w) in zip(mechanism.numbered(), velocities(mechanism, qd)[1:], strict=True):
        force, moment = SpatialInertia.of_body(link.body).times((v, w))
        twice = twice + (dot(v, force) + dot(w, moment)) + link.rotor_inertia * (qd[j] * qd[j])
    return twice / 2


def gravity_energy(mechanism: Mechanism, placed: list[tuple[Matrix, Vector]], gravity: Vector) -> Scalar:
    """- sum of g . (M_j 0P_j + 0A_j MS_j), in J; zero with every centre of mass at the origin of frame 0."""
    first_moments: Vector = (0, 0, 0)
    for j, link in mechanism.numbered():
        rotation, position = placed[j]
        moments = add(scale(link.body.mass, position), times(rotation, link.body.moments))
        first_moments = add(first_moments, moments)
    return -dot(gravity, first_moments)


def elastic_energy(k: Scalar, delta_q: Scalar) -> Scalar:
    """k delta_q^2 / 2, in J."""
    return k * (delta_q * delta_q) / 2
