"""A machine with loops as the tree that is left when they are cut, closed by multipliers, in double precision.

    [ A  -C^T ] [qdd]   [ tau + forces of springs and dampers - H ]
    [ C    0  ] [lam] = [ -Cd qd, or accelerations that are given ]

C are the rows of the velocities of the two ends of each loop, and those of joints that are moved as told. Loops close
as points, or in a plane at a joint that turns: there a row is zero, and the least of all solutions is taken. Nothing is
reduced to independent variables, so nothing of S and of closed forms is used. Loops drift apart by what an integrator
lets them: they must be integrated to many digits, and not for long.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Closing, Kind, Machine
from symoro_elastic.numerics.evaluation.values import given_values
from symoro_elastic.numerics.verification.implementations import numpy_model

DIFFERENCE = 1e-5
"""Of time, s, that rows are moved by to differentiate them: errors are of its square."""


class CutTree:
    """The motion of a machine whose cells are variables of their own."""

    def __init__(self, machine: Machine) -> None:
        turning = (machine.joint(loop.cut).sigma == 0 or loop.closes is Closing.POINT for loop in machine.loops)
        assert all(turning)
        rows = (replace(x, kind=Kind.FIXED, sigma=2) if x.kind is Kind.CUT else x for x in machine.joints)
        self.tree = replace(machine, joints=tuple(rows), loops=())
        self.names = [joint.name for joint in self.tree.independent_joints]
        ends = [machine.joint(j).name for loop in machine.loops for j in (loop.cut, loop.meets)]
        frames = {"jacobian": tuple(f"{name} in base" for name in ends)}
        self._model = numpy_model(self.tree, ("inertia_matrix", "bias_forces", "jacobian"), frames)
        values = given_values(machine)
        laws = [(x.spring.stiffness, x.spring.neutral, x.spring.damping) for x in self.tree.independent_joints]
        self.stiffness, self.neutral, self.damping = np.array([[x.value(values) for x in law] for law in laws]).T

    def accelerations(self, q: Array, qd: Array, tau: Array, moved: Array, told: Array) -> tuple[Array, Array]:
        """Return qdd (n,) and forces (k,) of what moves joints as told: entries `moved`, their accelerations `told`.

        tau (n,) are torques of motors.
        """
        after, before = (self._rows(q + sign * DIFFERENCE * qd) for sign in (1, -1))
        rates = (after - before) @ qd / (2 * DIFFERENCE)
        C = np.vstack([self._rows(q), np.eye(len(q))[moved]])
        A = self._model.inertia_matrix(q)
        forces = tau - self.stiffness * (q - self.neutral) - self.damping * qd - self._model.bias_forces(q, qd)
        matrix = np.block([[A, -C.T], [C, np.zeros((len(C), len(C)))]])
        found = np.linalg.lstsq(matrix, np.concatenate([forces, -rates, told]), rcond=None)[0]
        return found[: len(q)], found[len(q) + len(rates) :]

    def _rows(self, q: Array) -> Array:
        J = self._model.jacobian(q)
        found: Array = np.concatenate(J[0::2, :3] - J[1::2, :3])
        return found
