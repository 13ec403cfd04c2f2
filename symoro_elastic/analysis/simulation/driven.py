"""Motions of motors with drives: states of controllers, current loops and filters behind q, qd and those of friction.

    z_j' = A_j z_j + B_j u_j + w_j sigma_j,    tau_j = C_j z_j + D_j u_j + d_j sigma_j

are the laws of `drive_torques`, sigma what the limit of a torque takes away. The position that is controlled is the
motor's, or that of a load over what it changes with the motor at the start. Dead times are approximations of Pade of
order 2. tau_0 among u is the torque that holds the machine at the start, which an integral part or the weight's
compensation has then. Drives with a period are in `sampled_drives`.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.control.drive_laws import XD, DriveLaw, X, law_of
from symoro_elastic.analysis.simulation.drive_torques import ControlledPositions, inputs_of
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.right_side import CompiledMotion
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.state import State


class DrivenMotion(CompiledMotion):
    """The right side of a motion whose motors have drives; y = [q; qd; z], z of friction, then of drives."""

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        if reference.base:
            what = "drives of a machine on a floating base are not simulated: give servos"
            raise reference.prescribed.error("drives", what)
        super().__init__(reference, folder)
        self.drives = self.laws()
        ends = np.cumsum([0, *(len(one.A) for one in self.drives)]) + self.bristles.stop
        self.parts = [slice(first, last) for first, last in pairwise(ends)]
        self.controlled = ControlledPositions(reference)

    def laws(self) -> list[DriveLaw]:
        """Return the laws of the drives, in order of motors."""
        return [law_of(one) for one in self.reference.drives]

    @property
    def start(self) -> Array:
        """y at the start: drives have given the torques that hold the machine for long."""
        y = super().start
        motion = self.states(np.zeros(1), y[None], self.reference.at_start)
        (u,) = self.inputs(motion)
        return np.concatenate([y, *(one.rest @ x for one, x in zip(self.drives, u, strict=True))])

    @property
    def sizes(self) -> Array:
        """Sizes of the entries of y that errors are compared with."""
        return np.concatenate([super().sizes, *(one.sizes for one in self.drives)])

    def torques(self, motion: Motion, y: Array) -> Array:
        """Return the torques (N, m) of the drives at y."""
        return self._torques(self.inputs(motion), y)

    def _torques(self, u: Array, y: Array) -> Array:
        laws = zip(self.drives, self.parts, strict=True)
        return np.stack([one.torques(y[:, part], u[:, k]) for k, (one, part) in enumerate(laws)], axis=1)

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return y'."""
        motion = self.states(np.array([t]), y[None], near)
        u = self.inputs(motion)
        found = self.under_loads(motion.with_blocks(tau=self._torques(u, y[None])))
        rates = [one.rates(y[part], x) for one, part, x in zip(self.drives, self.parts, u[0], strict=True)]
        return np.concatenate([motion.qd[0], found["qdd"][0], *found.get("zd", ()), *rates])

    def inputs(self, motion: Motion) -> Array:
        """Return the inputs (N, m, 6) of the laws."""
        x, xd = self.of_motors(motion)
        return inputs_of(self.reference, motion, self.controlled(motion, x), xd)

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return dy'/dy; of drives on dependent joints the change of S_m is left out, loads stand for their motors."""
        if not self.has_linear_model:
            return self.differences(t, y, near)
        motion = self.states(np.array([t]), y[None], near)
        M, D, K = self.matrices(motion, y[None])
        n, S_m = len(M), self.slopes(motion)
        J = np.zeros((len(y), len(y)))
        J[:n, n : 2 * n] = np.eye(n)
        pushed = np.linalg.solve(M, np.hstack([S_m.T, K, D]))
        push, J[n : 2 * n, : 2 * n] = pushed[:, : len(S_m)], -pushed[:, len(S_m) :]
        (u,) = self.inputs(motion)
        for k, (one, part) in enumerate(zip(self.drives, self.parts, strict=True)):
            row = S_m[k]
            J[part, part], B, C, D = one.slopes(y[part], u[k])
            J[part, :n] = np.outer(B[:, X], row)
            J[part, n : 2 * n] = np.outer(B[:, XD], row)
            J[n : 2 * n, part] = np.outer(push[:, k], C)
            J[n : 2 * n, :n] += D[X] * np.outer(push[:, k], row)
            J[n : 2 * n, n : 2 * n] += D[XD] * np.outer(push[:, k], row)
        return J
