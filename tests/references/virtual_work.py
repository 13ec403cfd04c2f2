"""Closed chains by d'Alembert's principle on 4x4 placements: the virtual work of inertia, weight and joint forces.

    sum_j tr(dT_j/du_a P_j (T_j'' - g)^T) + sum_j Ia_j dq_j/du_a q_j'' - forces on x . dx/du_a = 0 for every u_a

T_j'' are coefficients of T_j(t) along the motion, whose dependent variables close the loops coefficient by
coefficient; P_j is the 4x4 second moment of the body's mass. No screw, no Jacobian of a body, no multiplier.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from mpmath import mpf

from symoro_elastic.machine.machine import Machine
from tests.references.closed_chains import Array, Chain, Number, State, along, exact, in_many_digits
from tests.references.elimination import identity, independent_rows, least_squares, solve, zeros
from tests.references.numbers_of_machine import BaseNumbers, BodyNumbers, JointNumbers
from tests.references.series import Series, coefficient

STEP = mpf(10) ** -20


class VirtualWork:
    """A machine at one state. Vectors are in table order: `x` of own variables, `q` of joints that move."""

    @in_many_digits
    def __init__(self, machine: Machine, state: State, number: Number = exact) -> None:
        chain = self.chain = Chain(machine, number=number)
        self.at = chain.assemble(state)
        self.rows = chain.numbers(self.at)
        self.masses = [_second_moments(row.body) for row in self.rows.joints]
        self.ud = np.array([mpf(rate) for rate in state.ud], dtype=object)
        self.names = [*chain.independent, *chain.dependent, *chain.cuts]
        by_own = chain.gradient(chain.gaps, self.at, [*chain.independent, *chain.dependent, *chain.cuts])
        self.by_others = by_own[:, len(self.ud) :]
        followers = -least_squares(self.by_others, by_own[:, : len(self.ud)])
        self.slopes = np.concatenate([identity(len(self.ud)), followers], axis=0)
        self.S_x = self.slopes[[self.names.index(name) for name in chain.own]]
        self._displace()

    def _displace(self) -> None:
        """Derivatives of placements and joint values by each u."""
        self.displaced, columns = [], []
        for column in self.slopes.T:
            shifted = along(self.at, dict(zip(self.names, column, strict=True)))
            self.displaced.append([_coefficients(frame, 1) for frame in self.chain.placements(shifted)])
            columns.append([coefficient(q, 1) for q in self.chain.joint_values(self.chain.numbers(shifted), shifted)])
        self.joint_slopes = np.array(columns, dtype=object).T

    @property
    def S(self) -> Array:
        """dq/du of the joints of the tree."""
        return self.joint_slopes[self.chain.articulated]

    # Motion

    def _motion(self, udd: Array) -> dict[str, Any]:
        """All variables to the second order in time; second coefficients of followers close the loops."""
        rates = dict(zip(self.names, self.slopes @ self.ud, strict=True))
        halves = dict(zip(self.chain.independent, udd / 2, strict=True))
        gaps = [coefficient(gap, 2) for gap in self.chain.gaps(along(self.at, rates, halves))]
        followers = -least_squares(self.by_others, np.array(gaps, dtype=object))
        halves |= dict(zip(self.names[len(udd) :], followers, strict=True))
        return along(self.at, rates, halves)

    def accelerations(self, udd: Array) -> Array:
        """xdd of all own variables."""
        motion = self._motion(udd)
        return np.array([2 * coefficient(motion[name], 2) for name in self.chain.own], dtype=object)

    @property
    @in_many_digits
    def xd(self) -> Array:
        return self.S_x @ self.ud

    @property
    @in_many_digits
    def gam_x(self) -> Array:
        return self.accelerations(zeros(len(self.ud)))

    @property
    @in_many_digits
    def gam(self) -> Array:
        motion = self._motion(zeros(len(self.ud)))
        found = self.chain.joint_values(self.chain.numbers(motion), motion)
        return np.array([2 * coefficient(found[j], 2) for j in self.chain.articulated], dtype=object)

    # Virtual work

    @in_many_digits
    def inertia(self) -> Array:
        """A_u, of which u^T A u / 2 is the kinetic energy."""
        rotors = np.diag([row.rotor_inertia for row in self.rows.joints])
        matrix = self.joint_slopes.T @ rotors @ self.joint_slopes
        for a, of_a in enumerate(self.displaced):
            for b, of_b in enumerate(self.displaced):
                work = sum(_trace(p, P, q) for p, P, q in zip(of_a, self.masses, of_b, strict=True))
                matrix[a, b] = matrix[a, b] + work
        return matrix

    @in_many_digits
    def bias(self) -> Array:
        """H_u: virtual work of inertia where udd = 0, weight, wrenches and friction, without springs."""
        return self._work_against(zeros(len(self.ud)))

    def _work_against(self, udd: Array) -> Array:
        """Virtual work that inertia, weight, wrenches and friction need, by u."""
        motion = self._motion(udd)
        frames = self.chain.placements(motion, _base_motion(self.rows.base))
        weight = np.concatenate([zeros(4, 3), np.array([[*self.rows.base.gravity, 0]], dtype=object).T], axis=1)
        falls = [2 * _coefficients(frame, 2) - weight for frame in frames]
        values = self.chain.joint_values(self.chain.numbers(motion), motion)
        on_joints = [self._on_joint(*of_joint) for of_joint in zip(self.rows.joints, values, strict=True)]
        work = self.joint_slopes.T @ np.array(on_joints, dtype=object)
        work = work - self.S_x.T @ self.chain.friction(self.at, self.S_x @ self.ud)
        places = [_coefficients(frame, 0) for frame in frames]
        for a, displaced in enumerate(self.displaced):
            for row, P, fall, place, shift in zip(self.rows.joints, self.masses, falls, places, displaced, strict=True):
                work[a] = work[a] + _trace(shift, P, fall) + _work_of_wrench(row, place, shift)
        return work

    def _on_joint(self, row: JointNumbers, value: Any) -> Any:
        """Of the rotor, and of friction where a joint is coupled."""
        inertial = row.rotor_inertia * 2 * coefficient(value, 2)
        if row.kind != "coupled":
            return inertial
        return inertial + row.friction(coefficient(value, 1))

    # Results

    def _springs(self) -> Array:
        return self.S_x.T @ self.chain.spring_forces(self.at, self.S_x @ self.ud)

    @in_many_digits
    def right_side(self) -> Array:
        """H_u, springs and dampers: A udd + right side = S_m^T tau."""
        return self.bias() - self._springs()

    @in_many_digits
    def residual(self, udd: Sequence[Any], tau: Sequence[Any]) -> Array:
        """What is missing to equilibrium by u: inertia, weight, friction and springs less the motors' torques."""
        accelerations = np.array([mpf(x) for x in udd], dtype=object)
        return self._work_against(accelerations) - self._springs() - self.S_x.T @ self.chain.spread_motors(tau)

    @in_many_digits
    def direct(self, tau: Sequence[Any]) -> Array:
        """xdd of all own variables under the torques of the motors."""
        on_u = self.S_x.T @ self.chain.spread_motors(tau) - self.right_side()
        return self.accelerations(solve(self.inertia(), on_u))

    @in_many_digits
    def inverse(self, qdd_motor: Sequence[Any]) -> tuple[Array, Array]:
        """(tau of all motors, xdd) where the motors' variables have these accelerations (L30)."""
        entries = [self.chain.own.index(name) for name in self.chain.motors]
        rows, wanted = self.S_x[entries], np.array([mpf(x) for x in qdd_motor], dtype=object)
        kept = independent_rows(rows)
        moved = rows[kept]
        above = np.concatenate([self.inertia(), -moved.T], axis=1)
        below = np.concatenate([moved, zeros(len(kept), len(kept))], axis=1)
        right = [*-self.right_side(), *(wanted - self.gam_x[entries])[kept]]
        found = solve(np.concatenate([above, below], axis=0), np.array(right, dtype=object))
        return self.chain.shared(rows, found[len(self.ud) :]), self.accelerations(found[: len(self.ud)])


def _base_motion(base: BaseNumbers) -> Array:
    """Frame 0 in the axes in which it is now: 1 + T' t + T'' t^2 / 2."""
    spin = _cross_matrix(base.angular_velocity)
    first, second = zeros(4, 4), zeros(4, 4)
    first[:3, :3], first[:3, 3] = spin, base.velocity
    second[:3, :3], second[:3, 3] = _cross_matrix(base.angular_acceleration) + spin @ spin, base.acceleration
    entries = zip(identity(4).ravel(), first.ravel(), second.ravel() / 2, strict=True)
    return np.array([Series(one) for one in entries], dtype=object).reshape(4, 4)


def _cross_matrix(a: Array) -> Array:
    o = mpf(0)
    return np.array([[o, -a[2], a[1]], [a[2], o, -a[0]], [-a[1], a[0], o]], dtype=object)


def _coefficients(matrix: Array, order: int) -> Array:
    return np.array([[coefficient(entry, order) for entry in row] for row in matrix], dtype=object)


def _trace(displacement: Array, masses: Array, acceleration: Array) -> Any:
    """tr(dT P T''^T): virtual work of a body."""
    return ((displacement @ masses) * acceleration).sum()


def _work_of_wrench(row: JointNumbers, place: Array, shift: Array) -> Any:
    """Virtual work of the wrench that the body exerts; dR R^T holds the small rotation."""
    turn = shift[:3, :3] @ place[:3, :3].T
    rotation = np.array([turn[2, 1], turn[0, 2], turn[1, 0]], dtype=object)
    return (place[:3, :3] @ row.force) @ shift[:3, 3] + (place[:3, :3] @ row.moment) @ rotation


def _second_moments(body: BodyNumbers) -> Array:
    """Integral of [r; 1] [r; 1]^T dm; that of r r^T is tr(J)/2 I - J."""
    moments = zeros(4, 4)
    moments[:3, :3] = identity(3) * (sum(body.inertia[i, i] for i in range(3)) / 2) - body.inertia
    moments[:3, 3] = moments[3, :3] = body.first_moment
    moments[3, 3] = body.mass
    return moments


@in_many_digits
def small_motions(
    machine: Machine, state: State, tau: Sequence[Any], number: Number = exact
) -> tuple[Array, Array, Array]:
    """(M, D, K) of M d'' + D d' + K d = 0 for small changes d of u about a state of the direct model, tau held.

    Central differences of `residual`, loops closed anew at each: some 40 digits stay.
    """
    at = VirtualWork(machine, state, number)
    udd = at.direct(tau)[[at.chain.own.index(name) for name in at.chain.independent]]

    def forces(u: Array, ud: Array) -> Array:
        return VirtualWork(machine, State(list(u), list(ud), at.at), number).residual(udd, tau)

    u, ud = (np.array([mpf(x) for x in entries], dtype=object) for entries in (state.u, state.ud))
    steps = identity(len(u)) * STEP
    D = [(forces(u, ud + step) - forces(u, ud - step)) / (2 * STEP) for step in steps]
    K = [(forces(u + step, ud) - forces(u - step, ud)) / (2 * STEP) for step in steps]
    return at.inertia(), np.array(D, dtype=object).T, np.array(K, dtype=object).T
