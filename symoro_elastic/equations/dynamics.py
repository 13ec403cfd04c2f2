"""The dynamic models [12]-[61]: one backward recursion, in which a joint's rule is data.

Each joint has either its torque known (a motor in the direct model; an elastic or passive joint
always) or its acceleration known (a motor in the inverse model). A body reached from the base
through known accelerations only has its own acceleration known before the backward recursion,
and needs no articulated inertia: there the recursion is Newton and Euler's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from symoro_elastic.equations.kinematics import (
    Scalars,
    angular_velocities,
    carried_velocity,
    coriolis,
    squared_velocities,
    velocity_terms,
)
from symoro_elastic.equations.mechanism import Axis, Link, Mechanism
from symoro_elastic.equations.spatial import (
    ENTRY,
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
    to_child,
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
NOTHING: Pair = (ZERO, ZERO)


class SingularPivot(ZeroDivisionError):
    """H_j of a joint is exactly zero: nothing gives it an acceleration."""

    def __init__(self, joint: int) -> None:
        super().__init__(f"H{joint} is zero")
        self.joint = joint


@dataclass(frozen=True)
class Elimination:
    """What the backward recursion finds at joint j: f_j = K_j jTi V'_i + al_j [35].

    `ratio` is Ia / H, `residual` Gamma + a^T b*.
    """

    K: SpatialInertia
    al: Pair
    U: Pair = NOTHING
    UH: Pair = NOTHING
    H: Scalar = 0
    Hinv: Scalar = 0
    ratio: Scalar = 0
    residual: Scalar = 0


@dataclass(frozen=True)
class Dynamics:
    """All quantities of a dynamic model, by joint number; entry 0 is the base."""

    w: list[Vector]
    wd: dict[int, Vector]
    vd: dict[int, Vector]
    g: list[Pair]
    b: dict[int, Pair]
    bs: dict[int, Pair]
    Js: dict[int, SpatialInertia]
    eliminated: dict[int, Elimination]
    f: dict[int, Pair]
    qdd: dict[int, Scalar]
    Gamma: dict[int, Scalar]


def dynamics(mechanism: Mechanism, qd: Scalars, rules: Sequence[Rule | None]) -> Dynamics:
    """Accelerations and torques of every joint: the direct model [28]-[36], the paper's inverse
    model [50]-[61], the rigid inverse model, according to the rules; `rules[j]` belongs to joint j.

    Torques in N m or N, accelerations in rad/s2 or m/s2. Raises `SingularPivot`.
    """
    w = angular_velocities(mechanism, qd)
    squares = squared_velocities(w)
    g = velocity_terms(mechanism, qd, w, squares)
    state = Dynamics(w, {}, {}, g, {}, {}, {}, {}, {}, {}, {})
    _accelerate_known(mechanism, qd, rules, state)
    for j, link in mechanism.numbered():
        if j not in state.vd:
            state.b[j] = state.bs[j] = _bias(link, w[j], squares[j])
            state.Js[j] = SpatialInertia.of_body(link.body)
    _backward(mechanism, rules, state)
    _forward(mechanism, rules, state)
    return state


def _accelerate_known(mechanism: Mechanism, qd: Scalars, rules: Sequence[Rule | None], state: Dynamics) -> None:
    """V'_j [6] and Newton-Euler wrenches [12], [15] of the bodies whose acceleration is known beforehand."""
    state.vd[0], state.wd[0] = mechanism.acceleration
    turning: dict[int, Matrix] = {0: hat_plus_hat_squared(state.w[0], state.wd[0])}
    for j, link in mechanism.numbered():
        i, rule = link.antecedent, rules[j]
        if i not in turning or isinstance(rule, TorqueKnown):
            continue
        qdd = rule.qdd if rule else 0
        linear, angular = coriolis(link, carried_velocity(link, state.w[i]), qd[j])
        moved, turned = link.axis.screw(qdd)
        state.wd[j] = add(to_child(link.placement, state.wd[i]), add(angular, turned))
        carried = to_child(link.placement, add(state.vd[i], times(turning[i], origin(link.placement))))
        state.vd[j] = add(carried, add(linear, moved))
        turning[j] = hat_plus_hat_squared(state.w[j], state.wd[j])
        state.f[j] = _plus(newton_euler(link.body, state.w[j], state.wd[j], state.vd[j], turning[j]), link.wrench)


def newton_euler(body: RigidInertia, w: Vector, wd: Vector, vd: Vector, u: Matrix) -> Pair:
    """Wrench that gives a body its acceleration [12], about the origin of its frame.

    `u` is hat(wd) + hat(w) hat(w). The moment is SYMORO's form, 15 products.
    """
    force = add(scale(body.mass, vd), times(u, body.moments))
    return force, add(_euler(body.inertia, w, wd, u), cross(body.moments, vd))


def _euler(inertia: Symmetric, w: Vector, wd: Vector, u: Matrix) -> Vector:
    """J wd + w x (J w)."""
    xx, xy, xz, yy, yz, zz = inertia
    x2, y2, z2 = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    return (
        (y2 - z2) * yz + w[1] * w[2] * (zz - yy) + xz * u[1][0] - xy * u[2][0] + xx * wd[0],
        (z2 - x2) * xz + w[0] * w[2] * (xx - zz) - yz * u[0][1] + xy * u[2][1] + yy * wd[1],
        (x2 - y2) * xy + w[0] * w[1] * (yy - xx) + yz * u[0][2] - xz * u[1][2] + zz * wd[2],
    )


def _bias(link: Link, w: Vector, squared: Symmetric) -> Pair:
    """b_j = -[w x (w x MS); w x (J w)] - external wrench [14]."""
    u = hat_plus_hat_squared(w, ZERO)
    return _minus(_plus(newton_euler(link.body, w, ZERO, ZERO, u), link.wrench))


def _backward(mechanism: Mechanism, rules: Sequence[Rule | None], state: Dynamics) -> None:
    """From the tips to the base: [28]-[32], [50]-[56], and [15] where accelerations are known."""
    for j, link in reversed(list(mechanism.numbered())):
        i = link.antecedent
        if j not in state.vd:
            state.eliminated[j] = found = eliminate(j, link, rules[j], state.Js[j], state.bs[j], state.g[j])
            if i not in state.vd:
                state.Js[i] = state.Js[i] + found.K.to_antecedent(link.placement)
                state.bs[i] = _plus(state.bs[i], _minus(wrench_to_antecedent(link.placement, found.al)))
                continue
            state.f[j] = _plus(found.K.times(_carried(link, i, state)), found.al)
        if i:
            state.f[i] = _plus(state.f[i], wrench_to_antecedent(link.placement, state.f[j]))


def eliminate(j: int, link: Link, rule: Rule | None, Js: SpatialInertia, bs: Pair, g: Pair) -> Elimination:
    """Remove joint j's acceleration from f_j = J* V'_j - b* ([29]-[30], [51]-[54]).

    Where the torque is known, a^T al is written as a^T K g + (J Gamma - Ia a^T b*) / H with
    J = a^T J* a, which is Gamma itself for a joint without rotor inertia.
    """
    if not isinstance(rule, TorqueKnown):
        if rule is None:
            return Elimination(Js, _plus(Js.times(g), _minus(bs)))
        U = link.axis.column(Js)
        return Elimination(Js, _plus(_plus(Js.times(g), _scaled(rule.qdd, U)), _minus(bs)), U)
    U = link.axis.column(Js)
    H = link.axis.project(U) + link.rotor_inertia
    try:
        Hinv = 1 / H
    except ZeroDivisionError:
        raise SingularPivot(j) from None
    UH = _scaled(Hinv, U)
    ratio = link.rotor_inertia * Hinv
    K = _without_joint(link.axis, Js, U, UH, _scaled(ratio, U))
    Kg = K.times(g)
    residual = rule.torque + link.axis.project(bs)
    al = _plus(_plus(Kg, _scaled(residual, UH)), _minus(bs))
    share = 1 if is_zero(link.rotor_inertia) else link.axis.project(UH)
    along = link.axis.project(Kg) + (share * rule.torque - ratio * link.axis.project(bs))
    return Elimination(K, _with_entry(link.axis, al, along), U, UH, H, Hinv, ratio, residual)


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
        state.f[j] = _plus(found.K.times(carried), found.al)
    linear, angular = _plus(carried, state.g[j])
    qdd = rule.qdd if isinstance(rule, AccelerationKnown) else 0
    if isinstance(rule, TorqueKnown):
        qdd = (found.residual - dot(found.U[0], linear) - dot(found.U[1], angular)) * found.Hinv
        state.qdd[j], state.Gamma[j] = qdd, rule.torque
    state.vd[j], state.wd[j] = _plus((linear, angular), link.axis.screw(qdd))


def _carried(link: Link, i: int, state: Dynamics) -> Pair:
    """jTi V'_i [33]."""
    return screw_to_child(link.placement, (state.vd[i], state.wd[i]))


def _plus(p: Pair, q: Pair) -> Pair:
    return add(p[0], q[0]), add(p[1], q[1])


def _minus(p: Pair) -> Pair:
    return subtract(ZERO, p[0]), subtract(ZERO, p[1])


def _scaled(factor: Scalar, p: Pair) -> Pair:
    return scale(factor, p[0]), scale(factor, p[1])


def _with_entry(axis: Axis, wrench: Pair, along: Scalar) -> Pair:
    """A wrench whose component along the joint is written directly."""
    force, moment = wrench
    if axis is Axis.REVOLUTE:
        return force, (moment[0], moment[1], along)
    return (force[0], force[1], along), moment
