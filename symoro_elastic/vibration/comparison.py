"""Errors of Spong's reduced model and of the rigid limit on a machine and a motion, against the full model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.reduced import reduced, rigid, with_ratios
from symoro_elastic.models.bind import Bound
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.progress import Progress, no_progress
from symoro_elastic.vibration.assembled_loops import refuse_assembled
from symoro_elastic.vibration.course import Course, modes_with, move, read_course, slowest
from symoro_elastic.vibration.independent_motors import refuse_dependent_motors
from symoro_elastic.vibration.modes import Modes
from symoro_elastic.vibration.reference_trajectory import STROKE
from symoro_elastic.vibration.tracking import pair


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


@dataclass(frozen=True)
class Comparison:
    """Frequencies (Hz) of the full and of the reduced model, paired, and of the rigid limit; losses on a motion.

    `alike`: no rotor is coupled, the reduced model is the full one.
    """

    full: Modes
    reduced: Modes
    rigid: Modes | None
    course: Course
    losses: tuple[Loss, ...]
    alike: bool

    @property
    def is_rigid(self) -> bool:
        """Whether no joint is elastic: the rigid limit is the machine itself."""
        return all(loss.quantity is Compared.TORQUE for loss in self.losses)


def compare(
    machine: Machine,
    values: Mapping[str, float] | None = None,
    at: Mapping[str, float] | None = None,
    ratios: Mapping[str, float] | None = None,
    held: bool = True,
    course: str | Path | Course | None = None,
    stroke: float = STROKE,
    duration: float | None = None,
    progress: Progress = no_progress,
) -> Comparison:
    """Compare the full model, Spong's reduced model and the rigid limit.

    Frequencies with motors held or free, at equilibrium; torques and elastic accelerations on `course`, a motion or
    its file (`read_course`), unless given that of `move` with `stroke` and `duration`. `ratios` are gear ratios of
    rotors (`with_ratios`). Raises `InputError`.
    """
    refuse_dependent_motors(machine)
    refuse_assembled(Bound(machine))
    whole = with_ratios(with_values(machine, values or {}), ratios or {})
    less, stiff = reduced(with_values(machine, values or {})), rigid(whole)
    motors = [joint.name for joint in machine.motor_joints]
    kept = {name: x for name, x in (at or {}).items() if name not in _springs(machine)}
    full = modes_with(whole, at, motors if held else [])
    if isinstance(course, str | Path):
        course = read_course(course, machine, whole, progress)
    course = course or move(whole, at, slowest(full), stroke, duration, progress)
    return Comparison(
        full,
        pair(full, modes_with(less, at, motors if held else []))[0],
        modes_with(stiff, kept, motors if held else []) if stiff.moving else None,
        course,
        tuple(losses(whole, less, stiff, course)),
        whole == less,
    )


def _springs(machine: Machine) -> set[str]:
    return {joint.name for joint in machine.joints if joint.kind is Kind.ELASTIC}


def losses(whole: Machine, less: Machine, stiff: Machine, course: Course) -> list[Loss]:
    """Return torques of motors and accelerations of springs on one motion, by the three models."""
    tau, qdd = _inverse(whole, course, range(len(whole.moving)))
    tau_less, qdd_less = _inverse(less, course, range(len(whole.moving)))
    rows = [whole.moving.index(j) for j in stiff.moving]
    tau_stiff = _inverse(stiff, course, rows)[0] if rows else np.zeros_like(tau)
    compared = [
        Loss(joint.name, Compared.TORQUE, joint.force_unit, tau[:, k], tau_less[:, k], tau_stiff[:, k])
        for k, joint in enumerate(whole.motor_joints)
    ]
    for k, joint in enumerate(whole.moving_joints):
        if joint.kind is Kind.ELASTIC:
            compared.append(
                Loss(
                    joint.name,
                    Compared.ACCELERATION,
                    f"{joint.unit}/s2",
                    qdd[:, k],
                    qdd_less[:, k],
                    np.zeros_like(qdd[:, k]),
                )
            )
    return compared


def _inverse(machine: Machine, course: Course, rows: Iterable[int]) -> tuple[Array, Array]:
    """Return motor torques and accelerations of all joints on a motion, by the paper's inverse model."""
    chosen = list(rows)
    model = numpy_model(machine, ("inverse_dynamics",))
    motors = [chosen[k] for k in machine.motor_entries]
    tau, qdd = model.inverse_dynamics(course.q[:, chosen], course.qd[:, chosen], course.qdd[:, motors])
    return np.asarray(tau), np.asarray(qdd)


def _size(x: Array) -> tuple[float, float]:
    """Return root mean square and largest absolute value."""
    return float(np.sqrt(np.mean(x**2))), float(np.max(np.abs(x)))
