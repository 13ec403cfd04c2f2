"""Kinetic, gravity and elastic energy; their sum changes only by what motors, friction, dampers and wrenches do.

So it is for a base at rest: the motion of another base takes part too.
"""

from __future__ import annotations

from fractions import Fraction

from symoro_elastic.equations.kinematics import Scalars, velocities
from symoro_elastic.equations.mechanism import Mechanism
from symoro_elastic.equations.spatial import Scalar, Vector, cross, dot, origin, times_symmetric, to_child


def kinetic_energy(mechanism: Mechanism, qd: Scalars) -> Scalar:
    """(sum of V_j^T JJ_j V_j + Ia_j qd_j^2) / 2, in J, where V^T JJ V = M v^2 + 2 MS . (v x w) + w^T J w."""
    twice: Scalar = 0
    for (j, link), (v, w) in zip(mechanism.numbered(), velocities(mechanism, qd)[1:], strict=True):
        body = link.body
        turning = dot(w, times_symmetric(body.inertia, w))
        twice = twice + body.mass * dot(v, v) + 2 * dot(body.moments, cross(v, w)) + turning
        twice = twice + link.rotor_inertia * (qd[j] * qd[j])
    return half(twice)


def gravity_energy(mechanism: Mechanism, gravity: Vector) -> Scalar:
    """- sum of g . (M_j 0P_j + 0A_j MS_j), in J; zero with every centre of mass at the origin of frame 0.

    `gravity` is in frame 0 and carried into the frames: g . 0P_j is the depth of frame j.
    """
    energy: Scalar = 0
    fields: list[tuple[Vector, Scalar]] = [(gravity, 0)]
    for _, link in mechanism.numbered():
        field, depth = fields[link.antecedent]
        depth = depth + dot(field, origin(link.placement))
        field = to_child(link.placement, field)
        fields.append((field, depth))
        energy = energy - (link.body.mass * depth + dot(field, link.body.moments))
    return energy


def elastic_energy(k: Scalar, delta_q: Scalar) -> Scalar:
    """k delta_q^2 / 2, in J."""
    return half(k * (delta_q * delta_q))


def half(x: Scalar) -> Scalar:
    """x / 2; exact for the numbers of structure."""
    return Fraction(x, 2) if isinstance(x, int) else x / 2
