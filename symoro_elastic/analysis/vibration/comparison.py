"""Errors of Spong's reduced model and of the rigid limit on a machine and a motion, against the full model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.vibration.beyond_limits import Beyond, beyond_limits, of_joints
from symoro_elastic.analysis.vibration.comparison_motion import (
    ComparisonMotion,
    modes_with,
    move,
    read_comparison_motion,
    slowest,
)
from symoro_elastic.analysis.vibration.inverse_model import InverseModel
from symoro_elastic.analysis.vibration.modes import Modes
from symoro_elastic.analysis.vibration.reference_trajectory import STROKE
from symoro_elastic.analysis.vibration.tracking import pair
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.reduced import reduced_model, rigid, with_ratios
from symoro_elastic.numerics.independent_joints import moved_by, with_independent, with_independent_motors
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.shared_motors import line_on_undetermined


class Compared(StrEnum):
    """The quantities that models are compared by: of motors and of springs."""

    TORQUE = "torque"
    ACCELERATION = "acceleration"


@dataclass(frozen=True)
class Loss:
    """A quantity over a motion (N,) by the full, the reduced and the rigid model; N m, N, rad/s2 or m/s2."""

    joint: str
    quantity: Compared
    unit: str
    by_full: Array
    by_reduced: Array
    by_rigid: Array

    @property
    def full(self) -> tuple[float, float]:
        """Root mean square and largest absolute value."""
        return _size(self.by_full)

    @property
    def reduced(self) -> tuple[float, float]:
        """Root mean square and largest error of the reduced model."""
        return _size(self.by_reduced - self.by_full)

    @property
    def rigid(self) -> tuple[float, float]:
        """Root mean square and largest error of the rigid limit."""
        return _size(self.by_rigid - self.by_full)


@dataclass(frozen=True, repr=False)
class Comparison(Result):
    """Frequencies (Hz) of the full and of the reduced model, paired, and of the rigid limit; losses on a motion.

    `alike`: no rotor is coupled, the reduced model is the full one. `held`: frequencies are those with motors held.
    """

    full: Modes
    reduced: Modes
    rigid: Modes | None
    trajectory: ComparisonMotion
    losses: tuple[Loss, ...]
    alike: bool
    held: bool = True

    @property
    def is_rigid(self) -> bool:
        """Whether no joint is elastic: the rigid limit is the machine itself."""
        return all(loss.quantity is Compared.TORQUE for loss in self.losses)

    @property
    def notes(self) -> tuple[str, ...]:
        """Lines on limits that the motion leaves, and on motors whose torques are shared out, in both models."""
        full, rigid = (
            line_on_undetermined(modal.linear.motion.machine, modal.linear.motion.followers) if modal else []
            for modal in (self.full, self.rigid)
        )
        return (*map(str, self.beyond), *full, *(f"rigid limit: {line}" for line in rigid if not full))

    @property
    def beyond(self) -> tuple[Beyond, ...]:
        """The limits of joints that the motion leaves."""
        machine, motion = self.full.linear.motion.machine, self.trajectory
        blocks = of_joints(machine.independent_joints, motion.q, motion.qd, motion.qdd)
        return beyond_limits(machine, motion.t, dict(blocks))

    @property
    def headline(self) -> str:
        """Machine and motion."""
        return f"Comparison of {self.full.linear.motion.machine.name} with simpler models on {self.trajectory.source}"


def compare(
    machine: Machine,
    values: Mapping[str, float] | None = None,
    at: Mapping[str, float] | None = None,
    ratios: Mapping[str, float] | None = None,
    held: bool = True,
    trajectory: str | Path | ComparisonMotion | None = None,
    stroke: float = STROKE,
    duration: float | None = None,
    progress: Progress = no_progress,
) -> Comparison:
    """Compare the full model, Spong's reduced model and the rigid limit.

    Frequencies with motors held or free, at equilibrium; torques and elastic accelerations on `trajectory`, a motion or
    its file (`read_comparison_motion`), by default that of `move` with `stroke` and `duration`. `ratios` are gear
    ratios of rotors (`with_ratios`). Raises `InputError`.
    """
    machine = with_independent_motors(machine)
    whole = with_ratios(with_values(machine, values or {}), ratios or {})
    less, stiff = reduced_model(with_values(machine, values or {})), rigid_limit(whole)
    motors = [joint.name for joint in machine.motor_joints]
    kept = {name: x for name, x in (at or {}).items() if name in _free(stiff)}
    full = modes_with(whole, at, motors if held else [])
    if isinstance(trajectory, str | Path):
        trajectory = read_comparison_motion(trajectory, machine, whole, progress)
    trajectory = trajectory or move(whole, at, slowest(full), stroke, duration, progress)
    return Comparison(
        full,
        pair(full, modes_with(less, at, motors if held else []))[0],
        modes_with(stiff, kept, motors if held else []) if stiff.independent else None,
        trajectory,
        tuple(losses(whole, less, stiff, trajectory)),
        whole == less,
        held,
    )


def rigid_limit(machine: Machine) -> Machine:
    """Return the rigid limit, its loops in coordinates of which springs are some; raises `InputError` without one."""
    free = with_independent(machine, machine.elastic)
    held = [free.joint(j).name for j in free.elastic if j in free.dependent]
    if held:
        what = "in the rigid limit it would be locked, and nothing else in its loop can yield: there is no rigid limit"
        raise machine.error(f"joint {', '.join(held)}", what)
    stiff = rigid(free)
    still = [stiff.joint(j).name for j in stiff.motors if j in stiff.dependent and not moved_by(stiff, j)]
    if still:
        what = "only springs let its motor move, so the rigid limit cannot move: there is nothing to compare with"
        raise machine.error(f"joint {', '.join(still)}", what)
    return stiff


def _free(machine: Machine) -> set[str]:
    """Return names and variables of the independent joints, once motors are."""
    joints = with_independent_motors(machine).independent_joints
    return {name for joint in joints for name in (joint.name, str(joint.variable))}


def losses(whole: Machine, less: Machine, stiff: Machine, trajectory: ComparisonMotion) -> list[Loss]:
    """Return torques of motors and accelerations of springs on one motion, by the three models."""
    tau, qdd = _inverse(whole, trajectory, whole)
    tau_less, qdd_less = _inverse(less, trajectory, whole)
    tau_stiff = _inverse(stiff, trajectory, whole)[0] if stiff.independent else np.zeros_like(tau)
    compared = [
        Loss(joint.name, Compared.TORQUE, joint.force_unit, tau[:, m], tau_less[:, m], tau_stiff[:, m])
        for m, joint in enumerate(whole.motor_joints)
    ]
    for j in whole.elastic:
        k, joint = whole.with_variable.index(j), whole.joint(j)
        full, less_exact = qdd[:, k], qdd_less[:, k]
        unit = f"{joint.unit}/s2"
        compared.append(Loss(joint.name, Compared.ACCELERATION, unit, full, less_exact, np.zeros_like(full)))
    return compared


def _inverse(machine: Machine, trajectory: ComparisonMotion, whole: Machine) -> tuple[Array, Array]:
    """Return torques of all motors and accelerations of all joint coordinates on a motion of the whole machine."""
    motion = EquationsOfMotion(machine)
    model = InverseModel(motion)
    rows = list(whole.entries(motion.given.independent))
    q, qd, qdd_motor = trajectory.q[:, rows], trajectory.qd[:, rows], trajectory.qdd[:, rows][:, motion.motors]
    tau, qdd = model(q, qd, qdd_motor)
    return model.torques(q, tau), model.joint_coordinate_accelerations(q, qd, qdd)


def _size(x: Array) -> tuple[float, float]:
    """Return root mean square and largest absolute value."""
    return float(np.sqrt(np.mean(x**2))), float(np.max(np.abs(x)))
