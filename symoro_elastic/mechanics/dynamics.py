"""The dynamic models [12]-[61]: one backward recursion, in which a joint's rule is data.

Each joint has either its torque known (a motor in the direct model; an elastic or passive joint always) or its
acceleration known (a motor in the inverse model), or belongs to a cluster or an elastic cell. Where all accelerations
from the base to a body are known, its own is known before the backward recursion and [12], [15] give its wrench; the
recursion over articulated inertias is for the others. The base is one of the former, unless it floats under a known
wrench.

In place of V' the recursion finds its remainder beyond a bias that is known beforehand (`bias_acceleration`). K, alpha
and gamma are in the frame before the joint's rotation, where gamma is shortest; R rotates them to frame j.
"""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.mechanics.base_body import WrenchKnown, base_acceleration
from symoro_elastic.mechanics.bias_acceleration import bias_accelerations, with_tips_in_frames_before
from symoro_elastic.mechanics.clusters import Cluster
from symoro_elastic.mechanics.dynamic_quantities import Dynamics, Rules
from symoro_elastic.mechanics.elastic_cells import ElasticCell, join_bodies
from symoro_elastic.mechanics.elimination import (
    AccelerationKnown,
    Elimination,
    Rule,
    SingularPivot,
    TorqueKnown,
    eliminate,
    joint_acceleration,
    prescribe,
)
from symoro_elastic.mechanics.flexible_inertia import Modes
from symoro_elastic.mechanics.joint_groups import follow, follow_cell, reduce, suspend
from symoro_elastic.mechanics.kinematics import Scalars, angular_motion, angular_velocities, coriolis, velocity_terms
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.newton_euler import bias_wrench, newton_euler
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    ZERO,
    Matrix,
    RigidInertia,
    Scalar,
    Transform,
    Twist,
    Vector,
    Wrench,
    hat_plus_hat_squared,
)

__all__ = ["AccelerationKnown", "Dynamics", "Rule", "Rules", "SingularPivot", "TorqueKnown", "dynamics"]


def dynamics(mechanism: Mechanism, qd: Scalars, rules: Rules, base: WrenchKnown | None = None) -> Dynamics:
    """Accelerations and torques of every joint; `rules[j]` belongs to joint j, `None` to a fixed frame.

    Torque known everywhere: the direct model [28]-[36]. Accelerations of motors known: the inverse model [50]-[61]. All
    known: the rigid inverse model. The mechanism holds the acceleration of the base, unless `base` says that the
    wrench on it is known. N m or N, rad/s2 or m/s2. Raises `SingularPivot`.
    """
    unknown = unknown_accelerations(mechanism, rules, base)
    ends = {rule.end for rule in rules if isinstance(rule, ElasticCell)}
    in_cells = {j for j in unknown if isinstance(rules[j], ElasticCell)}
    mechanism = with_tips_in_frames_before(join_bodies(mechanism, ends), unknown - in_cells)
    w = angular_velocities(mechanism, qd)
    s = Dynamics(mechanism, w, velocity_terms(mechanism, qd, w))
    for j, link in mechanism.from_base():
        if link.modes is not None:
            s.flexible.update(dict.fromkeys(link.modes.numbers, link.modes.motion(w[j], qd)))
    _start(s, base)
    _forward_known(s, qd, rules)
    s.bias.update(dict.fromkeys(in_cells, AT_REST))
    bias, gamma = bias_accelerations(mechanism, unknown - in_cells, s.bias, s.gamma)
    s = replace(s, bias=bias, gamma=gamma)
    for j, link in mechanism.from_base():
        if j in unknown:
            wrench = link.wrench if link.modes is None else link.wrench + _of_modes(s, link.modes, rules)
            _begin(s, j, RigidInertia() if j in in_cells else link.body, wrench)
    _backward(s, rules)
    if base is not None:
        _solve_base(s, base)
    _forward(s, qd, rules)
    return s


def unknown_accelerations(mechanism: Mechanism, rules: Rules, base: WrenchKnown | None) -> set[int]:
    """Numbers of the bodies with unknown acceleration: those beyond a joint of known torque."""
    unknown = set() if base is None else {0}
    for j, link in mechanism.from_base():
        if link.antecedent in unknown or isinstance(rules[j], TorqueKnown | Cluster | ElasticCell):
            unknown.add(j)
    return unknown


def _start(s: Dynamics, base: WrenchKnown | None) -> None:
    """Acceleration of the base where it is known, with the wrench on its body; else its articulated inertia."""
    body = s.mechanism.body
    if base is not None:
        s.bias[0] = AT_REST
        _begin(s, 0, body or RigidInertia(), s.mechanism.wrench)
        return
    s.vd[0], s.wd[0] = s.mechanism.acceleration
    s.bias[0], s.remainder[0] = Twist(s.vd[0], ZERO), Twist(ZERO, s.wd[0])
    s.U[0] = hat_plus_hat_squared(s.w[0], s.wd[0])
    if body is not None:
        s.f[0] = newton_euler(body, s.w[0], s.wd[0], s.vd[0], s.U[0]) + s.mechanism.wrench  # (12)


def _begin(s: Dynamics, j: int, body: RigidInertia, wrench: Wrench) -> None:
    """Initial values of the backward recursion."""
    s.beta[j] = s.betas[j] = bias_wrench(body, s.w[j], s.bias[j]) - wrench  # (14)
    s.Js[j] = body.spatial  # (13)


def _forward_known(s: Dynamics, qd: Scalars, rules: Rules) -> None:
    """Accelerations [6] and wrenches [12] of bodies before any unknown acceleration."""
    for j, link in s.mechanism.from_base():
        i, rule = link.antecedent, rules[j]
        if i not in s.vd or isinstance(rule, TorqueKnown | Cluster | ElasticCell):
            continue
        qdd = rule.qdd if rule else 0
        gamma, gain = coriolis(link, s.w[i], qd[j]).linear, (qdd * link.axis).linear
        s.wd[j], s.U[j] = angular_motion(j, link, s.w, s.wd, s.U, qdd)
        s.vd[j] = _origin_acceleration(link, s.vd[i], s.U[i], s.U[j]) + (gamma + gain)  # (6)
        s.bias[j], s.remainder[j] = Twist(s.vd[j], ZERO), Twist(ZERO, s.wd[j])
        s.F[j] = newton_euler(link.body, s.w[j], s.wd[j], s.vd[j], s.U[j])  # (12)
        if link.modes is not None:
            s.F[j] = s.F[j] + _of_modes(s, link.modes, rules)
        s.f[j] = s.F[j] + link.wrench


def _of_modes(s: Dynamics, modes: Modes, rules: Rules) -> Wrench:
    """The wrench that velocities and known accelerations of modes require on their body (L52), (L53), (L55)."""
    return s.flexible[modes.numbers[0]].wrench(_known_of_modes(modes, rules))


def _known_of_modes(modes: Modes, rules: Rules) -> dict[int, Scalar]:
    pairs = ((j, rules[j]) for j in modes.numbers)
    return {j: rule.qdd for j, rule in pairs if isinstance(rule, AccelerationKnown)}


def _origin_acceleration(link: Link, vd_i: Vector, U_i: Matrix, U_j: Matrix) -> Vector:
    """jAi (v'_i + U_i iPj), its part along z_j taken with U_j."""
    *steps, last = link.transform.steps
    to_axis = Transform(tuple(steps)).origin
    return link.transform.to_child(vd_i + U_i * to_axis) + last.shift * U_j.T.z


def _backward(s: Dynamics, rules: Rules) -> None:
    """Recursion from the tips to the base: [28]-[32], [50]-[56], and [15] where accelerations are known."""
    for j, link in s.mechanism.from_tips():
        i, X, R, rule = link.antecedent, link.before, link.joint_rotation, rules[j]
        if j in s.vd:
            f = link.transform.T * s.f[j]
        elif isinstance(rule, Cluster):
            if j == rule.first:
                reduce(s, j, i, rule)
            continue
        elif isinstance(rule, ElasticCell):
            if j == rule.end:
                suspend(s, j, s.mechanism.link(rule.links[0]).antecedent, rule)
            continue
        else:
            s.eliminated[j] = e = _eliminate(s, j, link, rule)
            if i not in s.vd:
                s.Js[i] = s.Js[i] + e.K.to_antecedent(X)  # (32), (56)
                s.betas[i] = s.betas[i] - X.T * e.alpha  # (31), (55)
                continue
            f = e.K * (X * s.remainder[i]) + e.alpha  # (35), (58)
            s.f[j], f = R * f, X.T * f
        if i in s.f:
            s.f[i] = s.f[i] + f  # (15)


def _eliminate(s: Dynamics, j: int, link: Link, rule: Rule | None) -> Elimination:
    if not isinstance(rule, TorqueKnown):
        return prescribe(link, rule.qdd if rule else 0, s.Js[j], s.betas[j], s.gamma[j])
    try:
        return eliminate(link, rule.torque, s.Js[j], s.betas[j], s.gamma[j])
    except ZeroDivisionError:
        raise SingularPivot(j) from None


def _solve_base(s: Dynamics, base: WrenchKnown) -> None:
    """Acceleration of a base under a known wrench, by its articulated inertia."""
    s.f[0] = base.wrench
    try:
        s.solved[0] = solution = base_acceleration(s.Js[0], base.wrench + s.betas[0])
    except ZeroDivisionError:
        raise SingularPivot(0) from None
    s.vd[0], s.wd[0] = s.remainder[0] = solution.twist


def _forward(s: Dynamics, qd: Scalars, rules: Rules) -> None:
    """Recursion from the base to the tips: [33]-[36], [57]-[61]."""
    for j, link in s.mechanism.from_base():
        rule = rules[j]
        if isinstance(rule, Cluster):
            follow(s, j, link, rule)
        elif isinstance(rule, ElasticCell):
            follow_cell(s, j, link, rule, qd)
        elif j not in s.vd:
            _accelerate(s, j, link, rule)
        if isinstance(rule, AccelerationKnown):
            s.qdd[j] = rule.qdd
            s.Gamma[j] = link.axis.T * s.f[j] + link.rotor_inertia * rule.qdd  # (17), (61)
            if j in s.flexible:
                s.Gamma[j] = s.Gamma[j] + force_on_mode(s, j, rules)


def force_on_mode(s: Dynamics, j: int, rules: Rules) -> Scalar:
    """The force on mode j that the known accelerations of its body and modes require (L55)."""
    i = s.mechanism.link(j).antecedent
    return s.flexible[j].force(j, (s.vd[i], s.wd[i]), _known_of_modes(s.flexible[j].modes, rules))


def _accelerate(s: Dynamics, j: int, link: Link, rule: Rule | None) -> None:
    """Wrench and acceleration of a body beyond a joint of known torque."""
    e, X, R = s.eliminated[j], link.before, link.joint_rotation
    V = X * s.remainder[link.antecedent]  # (33), (57)
    if j not in s.f:
        s.f[j] = R * (e.K * V + e.alpha)  # (35), (58)
    V = R * (V + s.gamma[j])
    if isinstance(rule, TorqueKnown):
        s.remainder[j], s.qdd[j] = joint_acceleration(link, e, V)  # (34), (36), (59), (60)
        s.Gamma[j] = rule.torque
    else:
        s.remainder[j] = V + (rule.qdd if rule else 0) * link.axis  # (36), (60)
    s.vd[j], s.wd[j] = s.bias[j] + s.remainder[j]
