"""What is observed of a simulated motion: accelerations, torques, and outputs by the names of signals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from inspect import signature
from types import ModuleType
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import BASE, Asked
from symoro_elastic.models.static_deflections import DEFLECTIONS, PLACED
from symoro_elastic.numerics.closed_positions import Followed
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.numerics.own_motion import OwnMotion
from symoro_elastic.numerics.values import given_values
from symoro_elastic.packages import for_vibrations
from symoro_elastic.simulation.compiled_steps import Trajectory
from symoro_elastic.simulation.moving_base import BaseStates, in_world, placed_in_world, rows
from symoro_elastic.simulation.reference import Reference
from symoro_elastic.vibration.signals import MOTOR_TORQUE, FrameSignal, JointSignal, Signal, inputs, outputs

FRAME_MODELS = ("geometric_model", "velocities", "accelerations")
"""Models by the order of the output that their results hold."""


@dataclass(frozen=True)
class Motion:
    """q, qd, qdd (N, n) of the independent joints and the torques tau (N, m) at times t (N,), SI units, radians.

    `q_dep` (N, d) are the joints that loops without a closed form determine, None where there are none; `base` are the
    states of a floating base, the wrench on it, and its accelerations V0d. `f_ext` (N, 6 w) are the wrenches on frames.
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    f_ext: Array
    q_dep: Array | None = None
    base: BaseStates = field(default_factory=dict)

    def given_to(self, model: Callable[..., Any], **others: Array) -> Any:
        """Return the results of a generated function at the states of the motion, with further arguments."""
        known = {"q": self.q, "qd": self.qd, "qdd": self.qdd, "tau": self.tau, "q_dep": self.q_dep, "f_ext": self.f_ext}
        known |= {**self.base, **others}
        return model(**{name: known[name] for name in signature(model).parameters if name in known})


class Observer:
    """Accelerations, torques and outputs of motions along a reference."""

    def __init__(self, machine: Machine, reference: Reference, names: Sequence[str]) -> None:
        """Raises `InputError` for signals that do not exist."""
        self.machine, self.reference, self.names = machine, reference, tuple(names)
        self.signals = tuple(_signal(machine, name) for name in names)

    def motion(self, found: Trajectory) -> Motion:
        """Return accelerations and torques with the states."""
        wrenches, _ = self.reference.wrenches(found.t)
        q, qd, still = found.q, found.qd, np.zeros_like(found.q)
        states = Motion(found.t, q, qd, still, found.tau, wrenches, found.q_dep, found.base)
        if self.reference.servo is None:
            _, _, ydd = self.reference.at(found.t)
            tau, *accelerations = states.given_to(self._dynamics.inverse_dynamics, qdd_motor=ydd)
        else:
            results = states.given_to(self._dynamics.direct_dynamics)
            tau, accelerations = found.tau, list(results) if found.base else [results]
        qdd, *of_base = accelerations
        base = {**found.base, **({"V0d": of_base[0]} if of_base else {})}
        return replace(states, qdd=qdd, tau=tau, base=base)

    def along_reference(self, t: Array) -> Array:
        """Return the outputs (N, names) where motors follow exactly and springs stay; NaN for torques."""
        q, v, a = self.reference.states(t)
        takes = "q_dep" in signature(getattr(self._dynamics, self._model)).parameters
        q_dep = Followed(self.machine, given_values(self.machine)).at(q) if takes else None
        torques, (wrenches, _) = np.full((len(t), len(self.reference.motors)), np.nan), self.reference.wrenches(t)
        return self.outputs(Motion(t, q, v, a, torques, wrenches, q_dep, rows(self.reference.base, len(t))))

    def outputs(self, motion: Motion) -> Array:
        """Return the outputs (N, names); rotations are vectors from the attitude at the start.

        In axes of frame 0, on a floating base in those of the world.
        """
        columns = [self._column(signal, motion) for signal in self.signals]
        return np.stack(columns, axis=1) if columns else np.zeros((len(motion.t), 0))

    def _column(self, signal: Signal, motion: Motion) -> Array:
        if isinstance(signal, JointSignal):
            return self._of_joint(signal, motion)
        if signal.order == 0:
            return _pose(placed_in_world(motion.base, self._placement(signal, motion)))[:, signal.component]
        return in_world(motion.base, self._twist(signal, motion))[:, signal.component]

    def _placement(self, signal: FrameSignal, motion: Motion) -> Array:
        """Return the placements (N, 4, 4) of a frame relative to frame 0."""
        if not signal.number:
            return np.tile(np.eye(4), (len(motion.t), 1, 1))
        return self._placements(motion)[:, self._frames.index(_in_base(self.machine, signal))]

    def _twist(self, signal: FrameSignal, motion: Motion) -> Array:
        """Return velocities or accelerations (N, 6) of a frame, in axes of frame 0."""
        if not signal.number:
            return motion.base["V0d" if signal.order == 2 else "V0"]
        found: Array = motion.given_to(getattr(self._frame_models, FRAME_MODELS[signal.order]))
        return found[:, self._frames.index(_in_base(self.machine, signal))]

    def _of_joint(self, signal: JointSignal, motion: Motion) -> Array:
        if signal.name.endswith(f".{MOTOR_TORQUE}"):
            return motion.tau[:, self.machine.motors.index(signal.number)]
        if signal.number in self.machine.moving:
            return (motion.q, motion.qd, motion.qdd)[signal.order][:, self.machine.moving.index(signal.number)]
        found = self._dependent(motion.q, motion.qd, motion.qdd, motion.q_dep)
        column: Array = found[signal.order][:, self._dependent.joints.index(signal.number)]
        return column

    @cached_property
    def _dependent(self) -> OwnMotion:
        """Motion of the joints among the outputs that follow from loops."""
        joints = {x.number for x in self.signals if isinstance(x, JointSignal)}
        return OwnMotion(self.machine, sorted(joints.difference(self.machine.moving)))

    def _placements(self, motion: Motion) -> Array:
        """Return the placements of frames (N, frames, 4, 4), static springs deflected."""
        models = self._frame_models
        if not self.machine.static:
            found: Array = motion.given_to(models.geometric_model)
            return found
        placed: Array = motion.given_to(models.geometric_model_with_deflections, q_static=self.deflections(motion))
        return placed

    def deflections(self, motion: Motion) -> Array:
        """Return the variables (N, s) of static springs, in table order, from the reactions there."""
        found: Array = motion.given_to(self._reactions.static_deflections)
        return found

    @cached_property
    def _frames(self) -> tuple[str, ...]:
        of_frames = (signal for signal in self.signals if isinstance(signal, FrameSignal) and signal.number)
        named = (_in_base(self.machine, signal) for signal in of_frames)
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
    (found,) = (inputs if name.rpartition(".")[2] == MOTOR_TORQUE else outputs)(machine, [name])
    return found


def _in_base(machine: Machine, signal: FrameSignal) -> str:
    return str(replace(Asked(machine.joints[signal.number - 1].name, signal.at), seen_from=BASE))


def _pose(T: Array) -> Array:
    """Return positions and rotation vectors (N, 6) of placements (N, 4, 4), rotations from the first; NaN of NaN."""
    turned = T[:, :3, :3] @ T[0, :3, :3].T
    rotation, finite = np.full((len(T), 3), np.nan), np.isfinite(turned).all(axis=(1, 2))
    if finite.any():
        rotations = for_vibrations("scipy.spatial.transform").Rotation.from_matrix(turned[finite])
        rotation[finite] = rotations.as_rotvec()
    found: Array = np.concatenate([T[:, :3, 3], rotation], axis=1)
    return found
