"""Elimination of a joint in the backward recursion.

f_j = J*_j V'_j - beta*_j with V'_j = V + qdd_j a_j + gamma_j and V = jTi V'_i becomes

    f_j = K_j V + alpha_j                                                          [35]

where qdd_j is found from the known torque, or put in where it is known. `eliminate` and `joint_acceleration` are
[28]-[30] and [34] in forms that cost less and lose fewer digits; the `..._as_printed` functions are the printed ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from symoro_elastic.mechanics.mechanism import Link
from symoro_elastic.mechanics.spatial import NO_WRENCH, ArticulatedInertia, Outer, Scalar, Twist, Wrench, dot, is_zero


@dataclass(frozen=True)
class TorqueKnown:
    """The joint's force or torque is known, friction and springs included."""

    torque: Scalar


@dataclass(frozen=True)
class AccelerationKnown:
    """The joint's acceleration is known."""

    qdd: Scalar


Rule: TypeAlias = TorqueKnown | AccelerationKnown


class SingularPivot(ZeroDivisionError):
    """H_j of a joint is exactly zero, so that its acceleration is undetermined; joint 0 is the base."""

    def __init__(self, joint: int) -> None:
        super().__init__(f"H{joint} is zero")
        self.joint = joint


@dataclass(frozen=True)
class Elimination:
    """Quantities of joint j in the backward recursion, which eliminates its acceleration.

    K and alpha are in the frame before the joint's rotation. In frame j: U = J* a, `UH` = U / H (its entry along the
    joint is the coupling a^T U / H), `rotor_share` = Ia / H, `tau_bias` = Gamma + a^T beta*, `qdd_bias` = tau_bias / H.
    """

    K: ArticulatedInertia
    alpha: Wrench
    U: Wrench = NO_WRENCH
    UH: Wrench = NO_WRENCH
    H: Scalar = 0
    Hinv: Scalar = 0
    rotor_share: Scalar = 0
    tau_bias: Scalar = 0
    qdd_bias: Scalar = 0


def prescribe(link: Link, qdd: Scalar, Js: ArticulatedInertia, betas: Wrench, gamma: Twist) -> Elimination:
    """K and alpha of a joint whose acceleration is known [53], [54]."""
    R, U = link.joint_rotation, Js * link.axis
    K, push = Js.rotated_back(R), U * qdd  # (53)
    alpha = K * gamma + R.T * (push - betas)  # (54)
    return Elimination(K, alpha, U)


def eliminate(link: Link, torque: Scalar, Js: ArticulatedInertia, betas: Wrench, gamma: Twist) -> Elimination:
    """Inertia K and wrench alpha that link j passes to its antecedent at known joint torque [28]-[30], [50]-[52].

    K a = U - U (a^T U) / H = U Ia / H is exactly zero where there is no rotor: the subtraction would leave rounding
    errors there, and cost products. So the component of alpha along the joint is

        a^T alpha = a^T K gamma + (a^T U / H) Gamma - (Ia / H) a^T beta*,

    which is Gamma itself for a joint without rotor inertia. Raises `ZeroDivisionError` where H is exactly zero.
    """
    a, R, Ia = link.axis, link.joint_rotation, link.rotor_inertia
    U = Js * a
    H = a.T * U + Ia  # (28), (50)
    Hinv = 1 / H
    rotor_share, beta_a = Ia * Hinv, a.T * betas
    coupling = 1 if is_zero(Ia) else a.T * U * Hinv
    UH = a.with_entry(U * Hinv, coupling)
    Ka = U * rotor_share
    K = (Js - Outer(U, UH)).with_entry(a, Ka).rotated_back(R)  # (29), (51)
    tau_bias, K_gamma = torque + beta_a, K * gamma
    qdd_bias = tau_bias * Hinv
    alpha = K_gamma + R.T * (U * qdd_bias - betas)  # (30), (52)
    alpha = a.with_entry(alpha, a.T * K_gamma + (coupling * torque - rotor_share * beta_a))
    return Elimination(K, alpha, U, UH, H, Hinv, rotor_share, tau_bias, qdd_bias)


def joint_acceleration(link: Link, e: Elimination, V: Twist) -> tuple[Twist, Scalar]:
    """V'_j [36] and qdd_j [34] from V = jTi V'_i + gamma_j, in frame j.

    qdd = qdd_bias - UH^T V. Without rotor inertia UH is 1 along the joint, and the component of V'_j there does not
    depend on that of V: it is qdd without it.
    """
    a = link.axis
    across, along = a.with_entry(e.UH, 0), a.T * V
    free = e.qdd_bias - dot(across.linear, V.linear) - dot(across.angular, V.angular)
    qdd = free - a.T * e.UH * along  # (34), (59)
    return a.with_entry(V, free if is_zero(link.rotor_inertia) else along + qdd), qdd  # (36), (60)


def eliminate_as_printed(
    link: Link, torque: Scalar, Js: ArticulatedInertia, betas: Wrench, gamma: Twist
) -> tuple[ArticulatedInertia, Wrench]:
    """K and alpha [29], [30] term by term, all quantities in frame j."""
    a, U = link.axis, Js * link.axis
    H = a.T * U + link.rotor_inertia  # (28)
    Hinv = 1 / H
    K = Js - Outer(U, U * Hinv)  # (29)
    return K, K * gamma + U * Hinv * (torque + a.T * betas) - betas  # (30)


def joint_acceleration_as_printed(
    link: Link, torque: Scalar, Js: ArticulatedInertia, betas: Wrench, V: Twist
) -> tuple[Twist, Scalar]:
    """V'_j [36] and qdd_j [34] term by term, from V = jTi V'_i + gamma_j in frame j."""
    a = link.axis
    H = a.T * (Js * a) + link.rotor_inertia  # (28)
    qdd = 1 / H * (-(a.T * (Js * V)) + torque + a.T * betas)  # (34)
    return V + qdd * a, qdd  # (36)
