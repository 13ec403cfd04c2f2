"""Closed chains by multipliers: the tree with all its joints free, couplings and loops as constraints.

Coordinates y = (z, x): z the values of all joints, cut ones too, and x the own variables. Constraints

    q_j - F_j(x) = 0 for every joint of the tree,   0T_e(z) = 0T_m(z) for every loop

and their multipliers lam: M zdd + h = C_z^T lam, 0 = Gamma_x + C_x^T lam, C ydd + phi = 0. M, h and the rows of
loops come from the Jacobians and accelerations in frame 0 of `multiprecision`. Rows of loops that depend on the
others are left out: those in the axes of m, forces before moments, the free direction of the cut joint last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from mpmath import mpf

from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Closing, Friction, Joint, Kind, Loop, Machine, Spring
from tests.references import multiprecision
from tests.references.closed_chains import Array, Chain, Number, State, along, exact, in_many_digits
from tests.references.elimination import identity, independent_rows, solve, zeros
from tests.references.numbers_of_machine import numbers_of
from tests.references.series import coefficient


class Multipliers:
    """A machine at one state. Vectors are in table order: `z` of joints that move, `x` of own variables."""

    @in_many_digits
    def __init__(self, machine: Machine, state: State, number: Number = exact) -> None:
        chain = self.chain = Chain(machine, number=number)
        self.at = chain.assemble(state)
        self.x = np.array([self.at[name] for name in chain.own], dtype=object)
        self.tree = numbers_of(free_tree(chain), chain.arithmetic, chain.values)
        self.z_rows = [j for j, joint in enumerate(machine.joints) if joint.sigma != 2]
        self.coupled_entries = [self.z_rows.index(j) for j in chain.articulated]
        joint_values = chain.joint_values(chain.numbers(self.at), self.at)
        self.z = np.array([joint_values[j] for j in self.z_rows], dtype=object)
        self.frames = multiprecision._frames(self.tree, list(self.z), derivatives=0)
        self._constrain()
        self._move(np.array([mpf(rate) for rate in state.ud], dtype=object))
        self.inertia_of_tree = multiprecision._inertia_matrix(self.tree, self.frames)
        self.bias_of_tree = self._forces(zeros(len(self.z)))

    # Constraints

    def _constrain(self) -> None:
        """C, and S_y = dy/du of C S_y = 0."""
        cells = self.chain.gradient(self._cells, self.at, self.chain.own)
        couplings = np.concatenate([identity(len(self.z))[self.coupled_entries], -cells], axis=1)
        loops = self._loop_rows()
        columns = [k for k in range(len(self.z)) if k not in self.coupled_entries]
        reduced = np.concatenate([loops[:, self.coupled_entries] @ cells, loops[:, columns]], axis=1)
        self.kept = independent_rows(reduced)
        on_own = zeros(len(self.kept), len(self.x))
        self.C = np.concatenate([couplings, np.concatenate([loops[self.kept], on_own], axis=1)], axis=0)
        own = [len(self.z) + k for k in range(len(self.x))]
        self.u_entries = [own[self.chain.own.index(name)] for name in self.chain.independent]
        self.other_entries = [k for k in range(self.C.shape[1]) if k not in self.u_entries]
        self.S_y = zeros(self.C.shape[1], len(self.u_entries))
        self.S_y[self.u_entries] = identity(len(self.u_entries))
        self.S_y[self.other_entries] = -solve(self.C[:, self.other_entries], self.C[:, self.u_entries])

    def _cells(self, variables: Any) -> list[Any]:
        found = self.chain.joint_values(self.chain.numbers(variables), variables)
        return [found[j] for j in self.chain.articulated]

    def _loop_rows(self) -> Array:
        """R_m^T (V_e - V_m) by zd, rows of all loops below each other."""
        blocks = [zeros(0, len(self.z))]
        for loop in self.chain.machine.loops:
            e, m = (multiprecision._jacobian(self.tree, self.frames, j - 1) for j in (loop.cut, loop.meets))
            axes = self.frames[loop.meets - 1].rotation.T
            rows = np.concatenate([axes @ (a - b) for a, b in zip(e, m, strict=True)], axis=0)
            blocks.append(rows[self._order(loop)])
        return np.concatenate(blocks, axis=0)

    def _order(self, loop: Loop) -> list[int]:
        if loop.closes is Closing.POINT:
            return [0, 1, 2]
        return [0, 1, 3, 4, 5, 2] if self.chain.machine.joint(loop.cut).sigma == 1 else [0, 1, 2, 3, 4, 5]

    def _move(self, ud: Array) -> None:
        """Rates, and gam_y: accelerations of y where udd = 0."""
        rates = self.S_y @ ud
        self.zd, self.xd = rates[: len(self.z)], rates[len(self.z) :]
        motion = along(self.at, dict(zip(self.chain.own, self.xd, strict=True)), {})
        couplings = [-2 * coefficient(cell, 2) for cell in self._cells(motion)]
        frames = multiprecision._frames(self.tree, list(self.z), list(self.zd))
        loops: list[Any] = []
        for loop in self.chain.machine.loops:
            e, m = frames[loop.cut - 1], frames[loop.meets - 1]
            entries = [*(m.rotation.T @ (e.a - m.a)), *(m.rotation.T @ (e.wd - m.wd))]
            loops.extend(entries[k] for k in self._order(loop))
        self.phi = np.array([*couplings, *(loops[k] for k in self.kept)], dtype=object)
        self.gam_y = zeros(len(rates))
        self.gam_y[self.other_entries] = -solve(self.C[:, self.other_entries], self.phi)

    # Mechanics

    def _forces(self, zdd: Array) -> Array:
        return multiprecision._generalized_forces(self.tree, list(self.z), list(self.zd), list(zdd))

    def _passive_forces(self) -> Array:
        """On own variables: springs, dampers and friction."""
        return self.chain.spring_forces(self.at, self.xd) + self.chain.friction(self.at, self.xd)

    def _solve(
        self, on_own: Array, motors: Sequence[int] = (), wanted: Sequence[Any] = ()
    ) -> tuple[Array, Array, Array]:
        """(ydd, lam, torques): torques of the motors (entries of x) keep their accelerations as wanted."""
        z, x, rows, m = len(self.z), len(self.x), len(self.C), len(motors)
        matrix = zeros(z + x + rows + m, z + x + rows + m)
        matrix[:z, :z] = self.inertia_of_tree
        matrix[: z + x, z + x : z + x + rows] = -self.C.T
        matrix[z + x : z + x + rows, : z + x] = self.C
        for k, entry in enumerate(motors):
            matrix[z + entry, z + x + rows + k] = mpf(-1)
            matrix[z + x + rows + k, z + entry] = mpf(1)
        found = solve(matrix, np.array([*-self.bias_of_tree, *on_own, *-self.phi, *wanted], dtype=object))
        return found[: z + x], found[z + x : z + x + rows], found[z + x + rows :]

    @in_many_digits
    def direct(self, tau: Sequence[Any]) -> Array:
        """xdd of all own variables under the torques of the motors."""
        ydd, _, _ = self._solve(self._passive_forces() + self.chain.spread_motors(tau))
        return ydd[len(self.z) :]

    @in_many_digits
    def inverse(self, qdd_motor: Sequence[Any]) -> tuple[Array, Array]:
        """(tau of all motors, xdd) where the motors' variables have these accelerations."""
        entries = [self.chain.own.index(name) for name in self.chain.motors]
        rows = self.S_x[entries]
        kept = independent_rows(rows)
        wanted = [mpf(qdd_motor[k]) for k in kept]
        ydd, _, torques = self._solve(self._passive_forces(), [entries[k] for k in kept], wanted)
        return self.chain.shared(rows, torques), ydd[len(self.z) :]

    def _driven(self, udd: Sequence[Any], tau: Sequence[Any]) -> tuple[Array, Array]:
        """(ydd, lam) where u has these accelerations, whatever acts on it; tau holds on motors that depend."""
        entries = [entry - len(self.z) for entry in self.u_entries]
        forces = self._passive_forces() + self.chain.spread_motors(tau)
        ydd, multipliers, _ = self._solve(forces, entries, [mpf(x) for x in udd])
        return ydd, multipliers

    @in_many_digits
    def constraint_forces(self, udd: Sequence[Any], tau: Sequence[Any]) -> tuple[list[list[Any]], list[Any]]:
        """(mu, lam) in a motion, under these torques of motors that depend.

        mu: of each loop the wrench of m's body on e's body where they meet, in axes of m; 0 on rows left out.
        lam: force on each coupled joint that keeps it to its formula.
        """
        _, multipliers = self._driven(udd, tau)
        joints = [self.chain.machine.joints[j] for j in self.chain.articulated]
        on_joints = zip(joints, multipliers[: len(joints)], strict=True)
        lam = [force for joint, force in on_joints if joint.kind is Kind.COUPLED]
        of_loops = iter(multipliers[len(joints) :])
        count = sum(len(self._order(loop)) for loop in self.chain.machine.loops)
        entries = [next(of_loops) if k in self.kept else mpf(0) for k in range(count)]
        wrenches: list[list[Any]] = []
        for loop in self.chain.machine.loops:
            order = self._order(loop)
            wrench, entries = dict(zip(order, entries[: len(order)], strict=True)), entries[len(order) :]
            wrenches.append([wrench.get(k, mpf(0)) for k in range(6)])
        return wrenches, lam

    @in_many_digits
    def reaction_wrenches(self, udd: Sequence[Any], tau: Sequence[Any]) -> list[list[Any]]:
        """f_j of every row [35]: all that is carried to body j, loops' wrenches taken as external on both bodies."""
        ydd, _ = self._driven(udd, tau)
        frames = multiprecision._frames(self.tree, list(self.z), list(self.zd), list(ydd[: len(self.z)]))
        needed = []
        for row, frame in zip(self.tree.joints, frames, strict=True):
            force, moment = multiprecision._needed_wrench(row, frame, self.tree.base)
            needed.append((force, moment + multiprecision._cross(frame.p, force)))
        for loop, mu in zip(self.chain.machine.loops, self.constraint_forces(udd, tau)[0], strict=True):
            m, e = loop.meets - 1, loop.cut - 1
            force, moment = (frames[m].rotation @ np.array(part, dtype=object) for part in (mu[:3], mu[3:]))
            moment = moment + multiprecision._cross(frames[m].p, force)
            needed[e] = (needed[e][0] - force, needed[e][1] - moment)
            needed[m] = (needed[m][0] + force, needed[m][1] + moment)
        return [self._carried(needed, frames, j) for j in range(len(frames))]

    def _carried(self, needed: list[tuple[Array, Array]], frames: list[Any], j: int) -> list[Any]:
        """Sum of the wrenches that bodies beyond row j need, in its frame, about its origin."""
        beyond = [i for i in range(len(frames)) if j in multiprecision._path(self.tree, i)]
        force, moment = (sum((needed[i][part] for i in beyond), zeros(3)) for part in (0, 1))
        moment = moment - multiprecision._cross(frames[j].p, force)
        turned = frames[j].rotation.T
        return [*(turned @ force), *(turned @ moment)]

    # Reduced to the independent variables

    @property
    def S_x(self) -> Array:
        """dx/du."""
        return self.S_y[len(self.z) :]

    @property
    def gam_x(self) -> Array:
        return self.gam_y[len(self.z) :]

    @property
    def S(self) -> Array:
        """dq/du of the joints of the tree."""
        return self.S_y[self.coupled_entries]

    @property
    def gam(self) -> Array:
        return self.gam_y[self.coupled_entries]

    @in_many_digits
    def inertia(self) -> Array:
        """A_u = S^T A S."""
        S_z = self.S_y[: len(self.z)]
        return S_z.T @ self.inertia_of_tree @ S_z

    @in_many_digits
    def bias(self) -> Array:
        """H_u = S^T H(q, qd, gam) and friction, without springs."""
        on_tree = self._forces(self.gam_y[: len(self.z)])
        return self.S_y[: len(self.z)].T @ on_tree - self.S_x.T @ self.chain.friction(self.at, self.xd)

    @in_many_digits
    def right_side(self) -> Array:
        """H_u, springs and dampers: A udd + right side = S_m^T tau."""
        return self.bias() - self.S_x.T @ self.chain.spring_forces(self.at, self.xd)

    @in_many_digits
    def energies(self) -> list[Any]:
        """Kinetic, of gravity, and of the springs."""
        rotors = zip((self.tree.joints[j].rotor_inertia for j in self.z_rows), self.zd, strict=True)
        kinetic, gravity = sum((inertia * rate * rate / 2 for inertia, rate in rotors), mpf(0)), mpf(0)
        frames = multiprecision._frames(self.tree, list(self.z), list(self.zd))
        for body, frame in zip((row.body for row in self.tree.joints), frames, strict=True):
            v, w = frame.rotation.T @ frame.v, frame.rotation.T @ frame.w
            coupling = v @ multiprecision._cross(w, body.first_moment)
            kinetic = kinetic + body.mass * (v @ v) / 2 + coupling + w @ body.inertia @ w / 2
            gravity = gravity - self.tree.base.gravity @ (body.mass * frame.p + frame.rotation @ body.first_moment)
        return [kinetic, gravity, self.chain.spring_energy(self.at)]


def free_tree(chain: Chain, cut_joints: bool = True) -> Machine:
    """The tree whose joints are free, coupled and (if asked) cut ones too; friction of coupled joints stays."""
    return replace(chain.machine, joints=tuple(_free(joint, cut_joints) for joint in chain.machine.joints), loops=())


def _free(joint: Joint, cut_joints: bool) -> Joint:
    """A passive joint without spring; a cut joint that is not free is a fixed frame where its variable is zero."""
    if joint.sigma == 2 or (joint.kind is Kind.CUT and not cut_joints):
        return replace(joint, kind=Kind.FIXED, sigma=2)
    cell = {"r": ZERO} if joint.sigma == 1 else {"theta": ZERO}
    friction = joint.friction if joint.kind is Kind.COUPLED else Friction()
    return replace(joint, kind=Kind.PASSIVE, spring=Spring(), friction=friction, **cell)
