"""Kinetic, gravity and elastic energy; their sum changes only by the work of motors, friction, dampers and wrenches.

So it is for a base at rest: the motion of another base takes part too.
"""

from __future__ import annotations

from fractions import Fraction

from symoro_elastic.mechanics.flexible_inertia import Modes
from symoro_elastic.mechanics.kinematics import Scalars, velocities
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import RigidInertia, Scalar, Twist, Vector, cross, dot


def kinetic_energy(mechanism: Mechanism, qd: Scalars) -> Scalar:
    """(sum of V_j^T JJ_j V_j + Ia_j qd_j^2) / 2, in J, where V^T JJ V = M v^2 + 2 MS . (v x w) + w^T J w."""
    base, *moving = velocities(mechanism, qd)
    twice: Scalar = 0 if mechanism.body is None else _with_body(0, mechanism.body, base)
    for (j, link), velocity in zip(mechanism.from_base(), moving, strict=True):
        twice = _with_body(twice, link.body, velocity)
        twice = twice + link.rotor_inertia * (qd[j] * qd[j])
        twice = twice if link.modes is None else _with_modes(twice, link.modes, velocity, qd)
    return half(twice)


def _with_body(twice: Scalar, body: RigidInertia, velocity: Twist) -> Scalar:
    """Twice the kinetic energy with that of a further body."""
    v, w = velocity
    turning = dot(w, body.inertia * w)
    return twice + body.mass * dot(v, v) + 2 * dot(body.moments, cross(v, w)) + turning


def _with_modes(twice: Scalar, modes: Modes, velocity: Twist, qd: Scalars) -> Scalar:
    """Twice the kinetic energy with that of modes: 2 U_k^T V ed_k + Mee_kl ed_k ed_l."""
    for j, U in modes.wrenches().items():
        along = U.dot(velocity)
        twice = twice + (along + along) * qd[j]
        for k, x in modes.masses(j).items():
            twice = twice + x * (qd[j] * qd[k])
    return twice


def gravity_energy(mechanism: Mechanism, gravity: Vector, depth: Scalar = 0) -> Scalar:
    """Gravity energy -sum of g . (M_j 0P_j + 0A_j MS_j), J; zero with all centres of mass at the origin of frame 0.

    `gravity` is in frame 0 and carried into the frames: g . 0P_j is the depth of frame j. `depth` is that of frame 0.
    """
    body = mechanism.body or RigidInertia()
    energy: Scalar = 0 - (body.mass * depth + dot(gravity, body.moments))
    fields: list[tuple[Vector, Scalar]] = [(gravity, depth)]
    for _, link in mechanism.from_base():
        field, depth = fields[link.antecedent]
        depth = depth + dot(field, link.transform.origin)
        field = link.transform.to_child(field)
        fields.append((field, depth))
        energy = energy - (link.body.mass * depth + dot(field, link.body.moments))
    return energy


def elastic_energy(k: Scalar, delta_q: Scalar) -> Scalar:
    """k delta_q^2 / 2, in J."""
    return half(k * (delta_q * delta_q))


def half(x: Scalar) -> Scalar:
    """x / 2; exact for the numbers of structure."""
    return Fraction(x, 2) if isinstance(x, int) else x / 2
