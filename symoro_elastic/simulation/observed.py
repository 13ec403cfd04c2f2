"""What is observed of a simulated motion: accelerations, torques, and outputs by the names of signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import BASE, Asked
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.packages import for_vibrations
from symoro_elastic.simulation.compiled_steps import Trajectory
from symoro_elastic.simulation.reference import Reference
from symoro_elastic.vibration.signals import MOTOR_TORQUE, FrameSignal, JointSignal, Signal, entry_of, inputs, outputs

FRAME_MODELS = ("geometric_model", "velocities", "accelerations")
"""Models by the order of the output that their results hold."""


@dataclass(frozen=True)
class Motion:
    """q, qd, qdd (N, n) of the independent joints and the torques tau (N, m) at times t (N,), SI units, radians."""

    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array


class Observer:
    """Accelerations, torques and outputs of motions along a reference."""

    def __init__(self, machine: Machine, reference: Reference, names: Sequence[str]) -> None:
        """Raises `InputError` for signals that do not exist."""
        self.machine, self.reference, self.names = machine, reference, tuple(names)
        self.signals = tuple(_signal(machine, name) for name in names)

    def motion(self, found: Trajectory) -> Motion:
        """Return accelerations and torques with the states."""
        if self.reference.servo is None:
            _, _, ydd = self.reference.at(found.t)
            tau, qdd = self._dynamics.inverse_dynamics(found.q, found.qd, ydd)
            return Motion(found.t, found.q, found.qd, qdd, tau)
        qdd = self._dynamics.direct_dynamics(found.q, found.qd, found.tau)
        return Motion(found.t, found.q, found.qd, qdd, found.tau)

    def outputs(self, motion: Motion) -> Array:
        """Return the outputs (N, names); rotations are vectors from the attitude at the start, in axes of frame 0."""
        columns = [self._column(signal, motion) for signal in self.signals]
        return np.stack(columns, axis=1) if columns else np.zeros((len(motion.t), 0))

    def _column(self, signal: Signal, motion: Motion) -> Array:
        if isinstance(signal, JointSignal):
            k = entry_of(self.machine, signal)
            if signal.name.endswith(f".{MOTOR_TORQUE}"):
                return motion.tau[:, self.machine.motor_entries.index(k)]
            return (motion.q, motion.qd, motion.qdd)[signal.order][:, k]
        row = self._frames.index(_in_base(self.machine, signal))
        if signal.order == 0:
            return _pose(self._frame_models.geometric_model(motion.q)[:, row])[:, signal.component]
        states = (motion.q, motion.qd, motion.qdd)[: signal.order + 1]
        found: Array = getattr(self._frame_models, FRAME_MODELS[signal.order])(*states)[:, row, signal.component]
        return found

    @cached_property
    def _frames(self) -> tuple[str, ...]:
        named = (_in_base(self.machine, signal) for signal in self.signals if isinstance(signal, FrameSignal))
        return tuple(dict.fromkeys(named))

    @cached_property
    def _frame_models(self) -> ModuleType:
        return numpy_model(self.machine, FRAME_MODELS, dict.fromkeys(FRAME_MODELS, self._frames))

    @cached_property
    def _dynamics(self) -> ModuleType:
        return numpy_model(self.machine, ("direct_dynamics", "inverse_dynamics"))


def _signal(machine: Machine, name: str) -> Signal:
    (found,) = (inputs if name.rpartition(".")[2] == MOTOR_TORQUE else outputs)(machine, [name])
    return found


def _in_base(machine: Machine, signal: FrameSignal) -> str:
    return str(replace(Asked(machine.joints[signal.number - 1].name, signal.at), seen_from=BASE))


def _pose(T: Array) -> Array:
    """Return positions and rotation vectors (N, 6) of placements (N, 4, 4), rotations from the first."""
    turned = T[:, :3, :3] @ T[0, :3, :3].T
    rotation = for_vibrations("scipy.spatial.transform").Rotation.from_matrix(turned).as_rotvec()
    found: Array = np.concatenate([T[:, :3, 3], rotation], axis=1)
    return found
