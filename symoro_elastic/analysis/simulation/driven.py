"""Motions of motors with drives: states of controllers, current loops and filters beside q, qd.

    z_j' = A_j z_j + B_j (Kv (r - q_m) + kfv rd - qd_m) + B_a kfa rdd,    tau_j = tau_0 + C_j z_j + D_j (...)

q_m is the motor's position, or that of a load over what it changes with the motor at the start. Dead times are
approximations of Pade of order 2. tau_0 is the torque that holds the machine at the start, which an integral part or
the weight's compensation has then. Drives with a period are in `sampled_drives`.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from symoro_elastic.analysis.control.closed_loop import DriveSystem, drive_system
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.right_side import CompiledMotion
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.state import State


class Known(NamedTuple):
    """What drives know at times t (N,): how far motors are behind, their rates, rates of set points, all (N, m)."""

    t: Array
    behind: Array
    xd: Array
    rd: Array
    rdd: Array


class DrivenMotion(CompiledMotion):
    """The right side of a motion whose motors have drives; y = [q; qd; z], states of drives in order of motors."""

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        if reference.base:
            what = "drives of a machine on a floating base are not simulated: give servos"
            raise reference.prescribed.error("drives", what)
        super().__init__(reference, folder)
        self.drives = self.systems()
        ends = np.cumsum([0, *(len(one.A) for one in self.drives)]) + 2 * len(self.free)
        self.parts = [slice(first, last) for first, last in pairwise(ends)]
        names = tuple(load.signal for load in reference.loads if load)
        self._observer = Observer(reference.machine, reference, names) if names else None
        self._loaded = [k for k, load in enumerate(reference.loads) if load]
        self._ratios = np.array([load.ratio for load in reference.loads if load])

    def systems(self) -> list[DriveSystem]:
        """Return the drives as linear systems, in order of motors."""
        return [drive_system(one) for one in self.reference.drives]

    @property
    def start(self) -> Array:
        """y at the start: drives at rest."""
        return np.concatenate([super().start, np.zeros(sum(len(one.A) for one in self.drives))])

    @property
    def sizes(self) -> Array:
        """Sizes of the entries of y that errors are compared with."""
        return np.concatenate([np.ones(2 * len(self.free)), *(one.sizes for one in self.drives)])

    def states_of_joints(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y."""
        return super().states_of_joints(t, y[:, : 2 * len(self.free)])

    def torques(self, motion: Motion, y: Array) -> Array:
        """Return the torques (N, m) of the drives at y."""
        return self._torques(self._known(motion), y)

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return y'."""
        motion = self.states(np.array([t]), y[None], near)
        known = self._known(motion)
        qdd = self.call(self.dynamics, motion.with_blocks(tau=self._torques(known, y[None])))["qdd"][0]
        return np.concatenate([motion.qd[0], qdd, *self._rates(known, y)])

    def _rates(self, known: Known, y: Array) -> list[Array]:
        """Return the rates of the drives' states, in order of motors."""
        behind, faster, (rd,), (rdd,) = known.behind[0], known.xd[0], known.rd, known.rdd
        return [
            one.A @ y[part]
            + one.by_position * behind[k]
            - one.by_velocity * faster[k]
            + one.by_set_velocity * rd[k]
            + one.by_set_acceleration * rdd[k]
            for k, (one, part) in enumerate(zip(self.drives, self.parts, strict=True))
        ]

    def _known(self, motion: Motion) -> Known:
        x, xd = self.of_motors(motion)
        r, rd, rdd = self.reference.at(motion.t)
        return Known(motion.t, r - self.controlled(motion, x), xd, rd, rdd)

    def controlled(self, motion: Motion, x: Array) -> Array:
        """Return the positions (N, m) that are controlled: x of the motors, or of loads over their ratios."""
        if self._observer is None:
            return x
        start = self.reference.start
        blocks = {"q": np.vstack([start.q, motion.q]), "qd": np.vstack([start.qd, motion.qd])}
        found = self._observer.outputs(Motion(blocks, np.append(0.0, motion.t)))
        at_start = self.reference.motors_at_start
        x = x.copy()
        x[:, self._loaded] = at_start[self._loaded] + (found[1:] - found[0]) / self._ratios
        return x

    def _torques(self, known: Known, y: Array) -> Array:
        found = np.tile(self.reference.start.torques, (len(y), 1))
        for k, (one, part) in enumerate(zip(self.drives, self.parts, strict=True)):
            by_position, by_rate, by_acceleration = one.of_set_point
            found[:, k] += y[:, part] @ one.C + by_position * known.behind[:, k] - one.through[1] * known.xd[:, k]
            found[:, k] += by_rate * known.rd[:, k] + by_acceleration * known.rdd[:, k]
        return found

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return dy'/dy; of drives on dependent joints the change of S_m is left out, loads stand for their motors."""
        motion = self.states(np.array([t]), y[None], near)
        M, D, K = self.matrices(motion, y[None])
        n, S_m = len(M), self.slopes(motion)
        J = np.zeros((len(y), len(y)))
        J[:n, n : 2 * n] = np.eye(n)
        pushed = np.linalg.solve(M, np.hstack([S_m.T, K, D]))
        push, J[n : 2 * n, : 2 * n] = pushed[:, : len(S_m)], -pushed[:, len(S_m) :]
        for k, (one, part) in enumerate(zip(self.drives, self.parts, strict=True)):
            row = S_m[k]
            J[part, part] = one.A
            J[part, :n] = -np.outer(one.by_position, row)
            J[part, n : 2 * n] = -np.outer(one.by_velocity, row)
            J[n : 2 * n, part] = np.outer(push[:, k], one.C)
            J[n : 2 * n, :n] -= one.through[0] * np.outer(push[:, k], row)
            J[n : 2 * n, n : 2 * n] -= one.through[1] * np.outer(push[:, k], row)
        return J
