"""Observed signals of a simulated motion: accelerations, torques, and outputs by the names of signals."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from types import ModuleType

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.moving_base import in_world, placed_in_world
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.kinematics.geometric import DEFLECTIONS, PLACED
from symoro_elastic.numerics.evaluation.closed_positions import JointCoordinates
from symoro_elastic.numerics.motion.signals import MOTOR_TORQUE, FrameSignal, JointSignal, Signal, inputs, outputs
from symoro_elastic.numerics.verification.implementations import numpy_model

FRAME_MODELS = ("geometric_model", "velocities", "accelerations")
"""Models by the order of the output that their results hold."""


def without_rates(motion: Motion, accelerations: Sequence[Array]) -> Sequence[Array]:
    """Return the results of a dynamic model, joints first, without rates of states of friction."""
    return [x for k, x in enumerate(accelerations) if k != 1 or not motion.z.shape[1]]


class Observer:
    """Accelerations, torques and outputs of motions along a reference."""

    def __init__(self, machine: Machine, reference: Reference, names: Sequence[str]) -> None:
        """Resolve the signals; raises `InputError` for unknown ones."""
        self.machine, self.reference, self.names = machine, reference, tuple(names)
        self.signals = tuple(_signal(machine, name) for name in names)

    def motion(self, trajectory: Trajectory) -> Motion:
        """Return accelerations and torques with the states."""
        f_ext, _ = self.reference.wrenches(trajectory.t)
        motion = Motion({**trajectory.blocks, "f_ext": f_ext}, trajectory.t)
        if self.reference.servo is None:
            _, _, ydd = self.reference.at(trajectory.t)
            tau, *accelerations = motion.results(self._dynamics.inverse_dynamics, qdd_motor=ydd)
        else:
            tau, accelerations = trajectory.tau, [*motion.results(self._dynamics.direct_dynamics)]
        rates = without_rates(motion, accelerations)
        return motion.with_blocks(tau=tau, **dict(zip(("qdd", "V0d"), rates, strict=False)))

    def outputs(self, motion: Motion) -> Array:
        """Return the outputs (N, names); rotations are vectors from the attitude at the start.

        In axes of frame 0, or of the world where the base moves in it.
        """
        columns = [self._column(signal, motion) for signal in self.signals]
        return np.stack(columns, axis=1) if columns else np.zeros((len(motion.t), 0))

    def _column(self, signal: Signal, motion: Motion) -> Array:
        if isinstance(signal, JointSignal):
            return self._of_joint(signal, motion)
        if signal.order == 0:
            return _pose(placed_in_world(motion, self._placement(signal, motion)))[:, signal.component]
        return in_world(motion, self._twist(signal, motion))[:, signal.component]

    def _placement(self, signal: FrameSignal, motion: Motion) -> Array:
        """Return the placements (N, 4, 4) of a frame relative to frame 0."""
        if not signal.number:
            return np.tile(np.eye(4), (len(motion.t), 1, 1))
        return self._placements(motion)[:, self._row(signal)]

    def _twist(self, signal: FrameSignal, motion: Motion) -> Array:
        """Return velocities or accelerations (N, 6) of a frame, in axes of frame 0."""
        if not signal.number:
            return motion.V0d if signal.order == 2 else motion.V0
        (twists,) = motion.results(getattr(self._frame_models, FRAME_MODELS[signal.order]))
        return twists[:, self._row(signal)]

    def _row(self, signal: FrameSignal) -> int:
        return self._frames.index(FrameNames(self.machine).in_base(signal.number, signal.at))

    def _of_joint(self, signal: JointSignal, motion: Motion) -> Array:
        if signal.name.endswith(f".{MOTOR_TORQUE}"):
            return motion.tau[:, self.machine.motors.index(signal.number)]
        if signal.number in self.machine.independent:
            return (motion.q, motion.qd, motion.qdd)[signal.order][:, self.machine.independent.index(signal.number)]
        coordinates = self._dependent(motion)
        return np.asarray(coordinates[signal.order][:, self._dependent.joints.index(signal.number)])

    @cached_property
    def _dependent(self) -> JointCoordinates:
        """Motion of the dependent joints among the outputs."""
        joints = {x.number for x in self.signals if isinstance(x, JointSignal)}
        return JointCoordinates(self.machine, sorted(joints.difference(self.machine.independent)))

    def _placements(self, motion: Motion) -> Array:
        """Return the placements of frames (N, frames, 4, 4), static springs deflected."""
        models = self._frame_models
        if not self.machine.static:
            (placements,) = motion.results(models.geometric_model)
        else:
            (placements,) = motion.results(models.geometric_model_with_deflections, q_static=self.deflections(motion))
        return placements

    def deflections(self, motion: Motion) -> Array:
        """Return the deflections (N, s) of static springs, in table order, from the reactions there."""
        (deflections,) = motion.results(self._reactions.static_deflections)
        return deflections

    @cached_property
    def _frames(self) -> tuple[str, ...]:
        of_frames = (signal for signal in self.signals if isinstance(signal, FrameSignal) and signal.number)
        named = (FrameNames(self.machine).in_base(signal.number, signal.at) for signal in of_frames)
        return tuple(dict.fromkeys(named))

    @cached_property
    def _frame_models(self) -> ModuleType:
        placing = (PLACED,) if self.machine.static else ()
        parts = dict.fromkeys((*FRAME_MODELS, *placing), self._frames)
        return numpy_model(self.reference.loaded, tuple(parts), parts)

    @cached_property
    def _reactions(self) -> ModuleType:
        return numpy_model(self.reference.loaded, (DEFLECTIONS,))

    @cached_property
    def _dynamics(self) -> ModuleType:
        return numpy_model(self.reference.loaded, (self._model,))

    @property
    def _model(self) -> str:
        return "inverse_dynamics" if self.reference.servo is None else "direct_dynamics"


def _signal(machine: Machine, name: str) -> Signal:
    (signal,) = (inputs if name.rpartition(".")[2] == MOTOR_TORQUE else outputs)(machine, [name])
    return signal


def _pose(T: Array) -> Array:
    """Return positions and rotation vectors (N, 6) of placements (N, 4, 4), rotations from the first; NaN of NaN."""
    turned = T[:, :3, :3] @ T[0, :3, :3].T
    rotation, finite = np.full((len(T), 3), np.nan), np.isfinite(turned).all(axis=(1, 2))
    if finite.any():
        rotations = for_vibrations("scipy.spatial.transform").Rotation.from_matrix(turned[finite])
        rotation[finite] = rotations.as_rotvec()
    return np.asarray(np.concatenate([T[:, :3, 3], rotation], axis=1))
