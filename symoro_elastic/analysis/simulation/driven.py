"""Motions with drives: states of controllers, current loops and filters in addition to q, qd and friction.

    z_j' = A_j z_j + B_j u_j + w_j sigma_j,    tau_j = C_j z_j + D_j u_j + d_j sigma_j

are the laws of `drive_torques`, sigma the excess of a torque over its limit. The position that is controlled is the
motor's, or that of a load over what it changes with the motor at the start. Dead times are approximations of Pade of
order 2. tau_0 among u is the torque that holds the machine at the start, which an integral part or the weight's
compensation has then. Drives with a period are in `sampled_drives`.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.control.drive_laws import XD, DriveLaw, X, law_of
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.right_side import CompiledMotion
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine, drives_of, without_drives
from symoro_elastic.machine.drives import LoadPosition
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.state import State
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs


class DrivenMotion(CompiledMotion):
    """The right-hand side of a motion with drives; y = [q; qd; z], z has states of friction, then of drives."""

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Compile the motion; raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        if reference.base:
            what = "drives of a machine on a floating base are not simulated: give servos"
            raise reference.prescribed.error("drives", what)
        super().__init__(reference, folder)
        self.drives = self.laws()
        ends = np.cumsum([0, *(len(law.A) for law in self.drives)]) + self.bristles.stop
        self.parts = [slice(first, last) for first, last in pairwise(ends)]
        self.controlled = ControlledPositions(reference)

    def laws(self) -> list[DriveLaw]:
        """Return the laws of the drives, in order of motors."""
        return [law_of(drive) for drive in self.reference.drives]

    @property
    def start(self) -> Array:
        """The state y at the start, with drives in steady state."""
        y = super().start
        motion = self.states(np.zeros(1), y[None], self.reference.at_start)
        (u,) = self.inputs(motion)
        return np.concatenate([y, *(law.steady @ x for law, x in zip(self.drives, u, strict=True))])

    @property
    def sizes(self) -> Array:
        """Scales of the entries of y for relative errors."""
        return np.concatenate([super().sizes, *(law.sizes for law in self.drives)])

    def torques(self, motion: Motion, y: Array) -> Array:
        """Return the torques (N, m) of the drives at states y."""
        return self._torques(self.inputs(motion), y)

    def _torques(self, u: Array, y: Array) -> Array:
        laws = zip(self.drives, self.parts, strict=True)
        return np.stack([law.torques(y[:, part], u[:, k]) for k, (law, part) in enumerate(laws)], axis=1)

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return the time derivative y' of the state."""
        motion = self.states(np.array([t]), y[None], near)
        u = self.inputs(motion)
        rates_of_motion = self.under_loads(motion.with_blocks(tau=self._torques(u, y[None])))
        rates = [law.rates(y[part], x) for law, part, x in zip(self.drives, self.parts, u[0], strict=True)]
        return np.concatenate([motion.qd[0], rates_of_motion["qdd"][0], *rates_of_motion.get("zd", ()), *rates])

    def inputs(self, motion: Motion) -> Array:
        """Return the inputs (N, m, 6) of the drive laws."""
        x, xd = self.of_motors(motion)
        return inputs_of(self.reference, motion, self.controlled(motion, x), xd)

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return the Jacobian dy'/dy; changes of S_m are neglected, load positions count as those of their motors."""
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
        for k, (law, part) in enumerate(zip(self.drives, self.parts, strict=True)):
            row = S_m[k]
            J[part, part], B, C, D = law.slopes(y[part], u[k])
            J[part, :n] = np.outer(B[:, X], row)
            J[part, n : 2 * n] = np.outer(B[:, XD], row)
            J[n : 2 * n, part] = np.outer(push[:, k], C)
            J[n : 2 * n, :n] += D[X] * np.outer(push[:, k], row)
            J[n : 2 * n, n : 2 * n] += D[XD] * np.outer(push[:, k], row)
        return J


def inputs_of(reference: Reference, motion: Motion, controlled: Array, xd: Array) -> Array:
    """Return the inputs (N, m, 6) of all drives along a motion, with the controlled positions (N, m)."""
    fed = reference.fed_torques(motion.t)
    return np.stack([*reference.at(motion.t), controlled, xd, fed], axis=-1)


class ControlledPositions:
    """Positions that the drives of a reference control: of their motors, or of loads over their ratios."""

    def __init__(self, reference: Reference) -> None:
        self.reference = reference
        names = tuple(load.signal for load in reference.loads if load)
        self._observer = Observer(reference.machine, reference, names) if names else None
        self._loaded = [k for k, load in enumerate(reference.loads) if load]
        self._ratios = np.array([load.ratio for load in reference.loads if load])

    def __call__(self, motion: Motion, x: Array) -> Array:
        """Return the controlled positions (N, m) from those of the motors, x."""
        if self._observer is None:
            return x
        start = self.reference.start
        blocks = {"q": np.vstack([start.q, motion.q]), "qd": np.vstack([start.qd, motion.qd])}
        positions = self._observer.outputs(Motion(blocks, np.append(0.0, motion.t)))
        at_start = self.reference.motors_at_start
        x = x.copy()
        x[:, self._loaded] = at_start[self._loaded] + (positions[1:] - positions[0]) / self._ratios
        return x


def with_loads(reference: Reference) -> Machine:
    """Return the machine of a reference for steps, with the load positions added that its drives measure."""
    machine = reference.loaded if reference.drives else without_drives(reference.loaded)
    signals = tuple(load.signal for load in reference.loads if load)
    if not signals:
        return machine
    start = Motion({"q": reference.start.q[None], "qd": reference.start.qd[None]}, np.zeros(1))
    values = iter(Observer(reference.machine, reference, signals).outputs(start)[0].tolist())
    loads = {}
    for name, load, x in zip(reference.motors, reference.loads, reference.motors_at_start.tolist(), strict=True):
        if load:
            (signal,) = outputs(reference.machine, [load.signal])
            axis, at = (signal.component, signal.at) if isinstance(signal, FrameSignal) else (None, None)
            loads[name] = LoadPosition(signal.number, axis, at, next(values), load.ratio, x)
    return replace(DescribedMachine.of(machine), drives=replace(drives_of(machine), loads=loads))
