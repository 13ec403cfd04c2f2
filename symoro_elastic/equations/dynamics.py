"""The dynamic models [12]-[61]: one backward recursion, in which a joint's rule is data.

Each joint has either its torque known (a motor in the direct model; an elastic or passive joint
always) or its acceleration known (a motor in the inverse model). A body reached from the base
through known accelerations only has its own acceleration known before the backward recursion,
and needs no articulated inertia: there the recursion is Newton and Euler's. So it is with the base,
unless it floats under a known wrench.

Of the other bodies the recursion finds what `known_accelerations` leave of V'_j.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from symoro_elastic.equations.floating_base import Solution, WrenchKnown, base_acceleration
from symoro_elastic.equations.kinematics import (
    Scalars,
    angular_velocities,
    carried_velocity,
    coriolis,
    turning,
    velocity_terms,
)
from symoro_elastic.equations.known_accelerations import anticipate, with_unturned_tips
from symoro_elastic.equations.mechanism import Axis, Link, Mechanism
from symoro_elastic.equations.spatial import (
    ENTRY,
    NOTHING,
    ZERO,
    Matrix,
    Pair,
    RigidInertia,
    Scalar,
    SpatialInertia,
    Symmetric,
    Vector,
    Z,
    add,
    cross,
    dot,
    hat_plus_hat_squared,
    is_zero,
    origin,
    scale,
    screw_to_child,
    subtract,
    times,
    times_symmetric,
    to_child,
    transpose,
    turn,
    turn_back,
    wrench_to_antecedent,
)


@dataclass(frozen=True)
class TorqueKnown:
    """The joint's force or torque, friction and springs included, is given."""

    torque: Scalar


@dataclass(frozen=True)
class AccelerationKnown:
    """The joint's acceleration is given; always so, and zero, for a fixed frame."""

    qdd: Scalar


Rule: TypeAlias = TorqueKnown | AccelerationKnown


class SingularPivot(ZeroDivisionError):
    """H_j of a joint is exactly zero: nothing gives it an acceleration; joint 0 is a floating base."""

    def __init__(self, joint: int) -> None:
        super().__init__(f"H{joint} is zero")
        self.joint = joint


@dataclass(frozen=True)
class Elimination:
    """What the backward recursion finds at joint j: f_j = K_j jTi V'_i + al_j [35].

    K and al are seen from the frame that lacks the joint's turn, where g_j is shortest; U = J* a,
    `UH` = U / H, `ratio` = Ia / H, `residual` = Gamma + a^T b* and `free` = residual / H in frame j.
    """

    K: SpatialInertia
    al: Pair
    U: Pair = NOTHING
    UH: Pair = NOTHING
    H: Scalar = 0
    Hinv: Scalar = 0
    ratio: Scalar = 0
    residual: Scalar = 0
    free: Scalar = 0


@dataclass(frozen=True)
class Dynamics:
    """All quantities of a dynamic model, by joint number; entry 0 is the base, where it is part of the machine.

    `mechanism` is the given one, but for released bodies at the tips: they are seen from frames that lack the last
    turn. `known` and `rest` are the parts of V'_j, and g_j is what the rest has of it. `F` holds the wrenches that
    give bodies their own acceleration where it is known beforehand, `solved` the accelerations of a base under a
    known wrench.
    """

    mechanism: Mechanism
    w: list[Vector]
    wd: dict[int, Vector]
    vd: dict[int, Vector]
    U: dict[int, Matrix]
    g: list[Pair]
    b: dict[int, Pair]
    bs: dict[int, Pair]
    Js: dict[int, SpatialInertia]
    eliminated: dict[int, Elimination]
    f: dict[int, Pair]
    qdd: dict[int, Scalar]
    Gamma: dict[int, Scalar]
    F: dict[int, Pair] = field(default_factory=dict)
    known: dict[int, Pair] = field(default_factory=dict)
    rest: dict[int, Pair] = field(default_factory=dict)
    solved: dict[int, Solution] = field(default_factory=dict)


def dynamics(
    mechanism: Mechanism, qd: Scalars, rules: Sequence[Rule | None], base: WrenchKnown | None = None
) -> Dynamics:
    """Accelerations and torques of every joint: the direct model [28]-[36], the paper's inverse
    model [50]-[61], the rigid inverse model, according to the rules; `rules[j]` belongs to joint j.

    The mechanism holds the acceleration of the base, unless `base` says that the wrench on it is known.
    Torques in N m or N, accelerations in rad/s2 or m/s2. Raises `SingularPivot`.
    """
    released = _released(mechanism, rules, base)
    mechanism = with_unturned_tips(mechanism, released)
    w = angular_velocities(mechanism, qd)
    g = velocity_terms(mechanism, qd, w)
    state = Dynamics(mechanism, w, {}, {}, {}, g, {}, {}, {}, {}, {}, {}, {})
    if base is None:
        _accelerate_base(mechanism, state)
    else:
        state.known[0] = NOTHING
        _release(0, mechanism.body or RigidInertia(), NOTHING, state)
    _accelerate_known(mechanism, qd, rules, state)
    anticipate(mechanism, released, state.g, state.known)
    for j, link in mechanism.numbered():
        if j in released:
            _release(j, link.body, link.wrench, state)
    _backward(mechanism, rules, state)
    if base is not None:
        _accelerate_free_base(base, state)
    _forward(mechanism, rules, state)
    return state


def _released(mechanism: Mechanism, rules: Sequence[Rule | None], base: WrenchKnown | None) -> set[int]:
    """The bodies whose acceleration only the recursion finds: those beyond a joint whose torque is known."""
    released = set() if base is None else {0}
    for j, link in mechanism.numbered():
        if link.antecedent in released or isinstance(rules[j], TorqueKnown):
            released.add(j)
    return released


def _accelerate_base(mechanism: Mechanism, state: Dynamics) -> None:
    """The base whose acceleration is known, and the wrench that its own body needs [12]."""
    state.vd[0], state.wd[0] = mechanism.acceleration
    state.known[0], state.rest[0] = (state.vd[0], ZERO), (ZERO, state.wd[0])
    state.U[0] = hat_plus_hat_squared(state.w[0], state.wd[0])
    if mechanism.body is not None:
        state.f[0] = newton_euler(mechanism.body, state.w[0], state.wd[0], state.vd[0], state.U[0])


def _accelerate_free_base(base: WrenchKnown, state: Dynamics) -> None:
    """The base whose articulated inertia the backward recursion has found."""
    state.f[0] = base.wrench
    try:
        state.solved[0] = found = base_acceleration(state.Js[0], _plus(base.wrench, state.bs[0]))
    except ZeroDivisionError:
        raise SingularPivot(0) from None
    state.vd[0], state.wd[0] = state.rest[0] = found.pair


def _release(j: int, body: RigidInertia, wrench: Pair, state: Dynamics) -> None:
    """The start of J*_j and b*_j of a body whose acceleration is not known."""
    state.b[j] = state.bs[j] = _bias(body, wrench, state.w[j], state.known[j])
    state.Js[j] = SpatialInertia.of_body(body)


def _accelerate_known(mechanism: Mechanism, qd: Scalars, rules: Sequence[Rule | None], state: Dynamics) -> None:
    """V'_j [6] and Newton-Euler wrenches [12], [15] of the bodies whose acceleration is known beforehand."""
    for j, link in mechanism.numbered():
        i, rule = link.antecedent, rules[j]
        if i not in state.vd or isinstance(rule, TorqueKnown):
            continue
        qdd = rule.qdd if rule else 0
        linear, _ = coriolis(link, carried_velocity(link, state.w[i]), qd[j])
        moved, _ = link.axis.screw(qdd)
        if link.axis is Axis.REVOLUTE:
            state.wd[j], state.U[j] = turning(link, state.w[i], state.wd[i], state.U[i], state.w[j], qdd)
        else:
            state.wd[j] = to_child(link.placement, state.wd[i])
            state.U[j] = hat_plus_hat_squared(state.w[j], state.wd[j])
        carried = to_child(link.placement, add(state.vd[i], times(state.U[i], origin(link.placement[:-1]))))
        along = scale(link.placement[-1].shift, transpose(state.U[j])[Z])
        state.vd[j] = add(add(carried, along), add(linear, moved))
        state.known[j], state.rest[j] = (state.vd[j], ZERO), (ZERO, state.wd[j])
        state.F[j] = newton_euler(link.body, state.w[j], state.wd[j], state.vd[j], state.U[j])
        state.f[j] = _plus(state.F[j], link.wrench)


def newton_euler(body: RigidInertia, w: Vector, wd: Vector, vd: Vector, u: Matrix) -> Pair:
    """Wrench that gives a body its acceleration [12], about the origin of its frame.

    `u` is hat(wd) + hat(w) hat(w). The moment is SYMORO's form, 15 products. Its terms that may cancel weight
    against acceleration come first, so that little is rounded before they do.
    """
    force = add(scale(body.mass, vd), times(u, body.moments))
    (x, y, z), (xx, _, _, yy, _, zz) = body.moments, body.inertia
    accelerated = (
        xx * wd[0] + y * vd[2] - z * vd[1],
        yy * wd[1] + z * vd[0] - x * vd[2],
        zz * wd[2] + x * vd[1] - y * vd[0],
    )
    return force, add(accelerated, _euler(body.inertia, w, u))


def _euler(inertia: Symmetric, w: Vector, u: Matrix) -> Vector:
    """J wd + w x (J w), the products of J's diagonal and wd apart."""
    xx, xy, xz, yy, yz, zz = inertia
    return (
        (u[1][1] - u[2][2]) * yz + w[1] * w[2] * (zz - yy) + xz * u[1][0] - xy * u[2][0],
        (w[2] * w[2] - w[0] * w[0]) * xz + w[0] * w[2] * (xx - zz) - yz * u[0][1] + xy * u[2][1],
        (u[0][0] - u[1][1]) * xy + w[0] * w[1] * (yy - xx) + yz * u[0][2] - xz * u[1][2],
    )


def _bias(body: RigidInertia, wrench: Pair, w: Vector, known: Pair) -> Pair:
    """b_j = -[w x (w x MS); w x (J w)] - external wrench [14] - JJ_j known_j."""
    force = cross(w, cross(w, body.moments))
    moment = cross(w, times_symmetric(body.inertia, w))
    turning = _plus((force, moment), SpatialInertia.of_body(body).times(known))
    return _minus(_plus(turning, wrench))


def _backward(mechanism: Mechanism, rules: Sequence[Rule | None], state: Dynamics) -> None:
    """From the tips to the base: [28]-[32], [50]-[56], and [15] where accelerations are known."""
    for j, link in reversed(list(mechanism.numbered())):
        i = link.antecedent
        if j in state.vd:
            carried = wrench_to_antecedent(link.placement, state.f[j])
        else:
            state.eliminated[j] = found = eliminate(j, link, rules[j], state.Js[j], state.bs[j], state.g[j])
            if i not in state.vd:
                state.Js[i] = state.Js[i] + found.K.to_antecedent(link.unturned)
                state.bs[i] = _plus(state.bs[i], _minus(wrench_to_antecedent(link.unturned, found.al)))
                continue
            unturned = _plus(found.K.times(_carried(link, i, state)), found.al)
            state.f[j] = _turned_back(link, unturned)
            carried = wrench_to_antecedent(link.unturned, unturned)
        if i in state.f:
            state.f[i] = _plus(state.f[i], carried)


def eliminate(j: int, link: Link, rule: Rule | None, Js: SpatialInertia, bs: Pair, g: Pair) -> Elimination:
    """Remove joint j's acceleration from f_j = J* V'_j - b* ([29]-[30], [51]-[54]).

    Where the torque is known, a^T al is written as a^T K g + (J Gamma - Ia a^T b*) / H with
    J = a^T J* a, which is Gamma itself for a joint without rotor inertia.
    """
    U = link.axis.column(Js)
    if not isinstance(rule, TorqueKnown):
        K, push = Js.turned(link.last_turn), _scaled(rule.qdd if rule else 0, U)
        return Elimination(K, _plus(K.times(g), _turned(link, _plus(push, _minus(bs)))), U)
    H = link.axis.project(U) + link.rotor_inertia
    try:
        Hinv = 1 / H
    except ZeroDivisionError:
        raise SingularPivot(j) from None
    ratio, velocity_force = link.rotor_inertia * Hinv, link.axis.project(bs)
    share = 1 if is_zero(link.rotor_inertia) else link.axis.project(U) * Hinv
    UH = link.axis.with_along(_scaled(Hinv, U), share)
    K = _without_joint(link.axis, Js, U, UH, _scaled(ratio, U)).turned(link.last_turn)
    residual, Kg = rule.torque + velocity_force, K.times(g)
    free = residual * Hinv
    al = _plus(Kg, _turned(link, _plus(_scaled(free, U), _minus(bs))))
    along = link.axis.project(Kg) + (share * rule.torque - ratio * velocity_force)
    return Elimination(K, link.axis.with_along(al, along), U, UH, H, Hinv, ratio, residual, free)


def _without_joint(axis: Axis, Js: SpatialInertia, U: Pair, UH: Pair, Ka: Pair) -> SpatialInertia:
    """K = J* - U U^T / H [29], its row and column a written exactly as K a = U Ia / H."""
    A, D = list(Js.A), list(Js.D)
    B = [list(row) for row in Js.B]
    for m in range(3):
        for n in range(3):
            B[m][n] = B[m][n] - U[0][m] * UH[1][n]
            if m <= n:
                A[ENTRY[m][n]] = A[ENTRY[m][n]] - U[0][m] * UH[0][n]
                D[ENTRY[m][n]] = D[ENTRY[m][n]] - U[1][m] * UH[1][n]
    for m in range(3):
        if axis is Axis.REVOLUTE:
            B[m][Z], D[ENTRY[m][Z]] = Ka[0][m], Ka[1][m]
        else:
            A[ENTRY[m][Z]], B[Z][m] = Ka[0][m], Ka[1][m]
    return SpatialInertia(tuple(A), tuple(tuple(row) for row in B), tuple(D))  # type: ignore[arg-type]


def _forward(mechanism: Mechanism, rules: Sequence[Rule | None], state: Dynamics) -> None:
    """From the base to the tips: [33]-[36], [57]-[61]."""
    for j, link in mechanism.numbered():
        rule = rules[j]
        if rule is None and j in state.vd:
            continue
        if j not in state.vd:
            _accelerate_found(j, link, rule, state)
        if isinstance(rule, AccelerationKnown):
            state.qdd[j] = rule.qdd
            state.Gamma[j] = link.axis.project(state.f[j]) + link.rotor_inertia * rule.qdd


def _accelerate_found(j: int, link: Link, rule: Rule | None, state: Dynamics) -> None:
    """qdd_j [34], f_j [35] and V'_j [36] of a body beyond a joint whose torque is known."""
    found = state.eliminated[j]
    carried = _carried(link, link.antecedent, state)
    if j not in state.f:
        state.f[j] = _turned_back(link, _plus(found.K.times(carried), found.al))
    motion = _turned_back(link, _plus(carried, state.g[j]))
    if isinstance(rule, TorqueKnown):
        state.rest[j], state.qdd[j] = _moved(link, found, motion)
        state.Gamma[j] = rule.torque
    else:
        state.rest[j] = _plus(motion, link.axis.screw(rule.qdd if rule else 0))
    state.vd[j], state.wd[j] = _plus(state.known[j], state.rest[j])


def _moved(link: Link, found: Elimination, motion: Pair) -> tuple[Pair, Scalar]:
    """rest_j from what it is without the joint, and qdd_j.

    Without rotor inertia U / H is 1 along the joint, and V'_j there does not depend on V'_i there.
    """
    linear, angular = link.axis.with_along(found.UH, 0)
    left = found.free - dot(linear, motion[0]) - dot(angular, motion[1])
    before = link.axis.project(motion)
    qdd = left - link.axis.project(found.UH) * before
    after = left if is_zero(link.rotor_inertia) else before + qdd
    return link.axis.with_along(motion, after), qdd


def _carried(link: Link, i: int, state: Dynamics) -> Pair:
    """jTi rest_i [33]."""
    return screw_to_child(link.unturned, state.rest[i])


def _turned(link: Link, p: Pair) -> Pair:
    return turn(link.last_turn, p[0]), turn(link.last_turn, p[1])


def _turned_back(link: Link, p: Pair) -> Pair:
    return turn_back(link.last_turn, p[0]), turn_back(link.last_turn, p[1])


def _plus(p: Pair, q: Pair) -> Pair:
    return add(p[0], q[0]), add(p[1], q[1])


def _minus(p: Pair) -> Pair:
    return subtract(ZERO, p[0]), subtract(ZERO, p[1])


def _scaled(factor: Scalar, p: Pair) -> Pair:
    return scale(factor, p[0]), scale(factor, p[1])
