"""Torques of a joint itself: elasticity [9] and friction."""

from __future__ import annotations

from symoro_elastic.mechanics.spatial import Scalar


def elastic_torque(k: Scalar, delta_q: Scalar, d: Scalar, qd: Scalar) -> Scalar:
    """Gamma = -k delta_q - d qd [9], N m or N; delta_q = q - q0 is the deflection."""
    return -(k * delta_q) - d * qd  # (9), (18)


def smooth_sign(qd: Scalar, speed: Scalar) -> Scalar:
    """qd / sqrt(qd^2 + vs^2), a smooth sign(qd); speed = sqrt(qd^2 + vs^2), where vs is the creep velocity."""
    return qd / speed


def friction_slope(viscous: Scalar, coulomb: Scalar, creep: Scalar, speed: Scalar) -> Scalar:
    """Derivative of smooth friction by qd: Fv + Fs vs^2 / (qd^2 + vs^2)^(3/2), N m s/rad or N s/m."""
    return viscous + coulomb * (creep * creep) / (speed * speed * speed)


def friction(viscous: Scalar, coulomb: Scalar, qd: Scalar, sign_qd: Scalar) -> Scalar:
    """Fs sign(qd) + Fv qd, opposing motion, N m or N."""
    return coulomb * sign_qd + viscous * qd
