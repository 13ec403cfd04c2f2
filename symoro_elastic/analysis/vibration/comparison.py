"""Errors of Spong's reduced model and of the rigid limit on a machine and a motion, against the full model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.measurements import (
    Measurements,
    header_of,
    missing,
    named_columns,
    read_columns,
    read_measurements,
)
from symoro_elastic.analysis.vibration.beyond_limits import Beyond, beyond_limits, of_joints
from symoro_elastic.analysis.vibration.following import MotorCurve, motion_between_motors, refuse_swings
from symoro_elastic.analysis.vibration.inverse_model import InverseModel
from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, modes
from symoro_elastic.analysis.vibration.reference_trajectory import STROKE, ReferenceTrajectory, read_reference
from symoro_elastic.analysis.vibration.tracking import pair
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.reduced import reduced_model, with_ratios
from symoro_elastic.machine.restrict import rigid
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.motion.independent_joints import (
    line_on_undetermined,
    moved_by,
    with_independent,
    with_independent_motors,
)

PERIODS = 5.0  # of the first vibration, for a move
LARGEST_STROKE = 100.0  # rad or m
MOVE_SAMPLES, MOST_SAMPLES = 501, 5001
SPLINE_DEGREE = 5
COEFFICIENTS = (35.0, -84.0, 70.0, -20.0)
"""s = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7: velocity, acceleration and jerk are zero at both ends."""


class Compared(StrEnum):
    """Compared quantities of models: of motors and of springs."""

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
        """RMS and largest absolute value of the full model."""
        return _size(self.by_full)

    @property
    def reduced(self) -> tuple[float, float]:
        """RMS and largest error of the reduced model."""
        return _size(self.by_reduced - self.by_full)

    @property
    def rigid(self) -> tuple[float, float]:
        """RMS and largest error of the rigid limit."""
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
        """Whether no joint is elastic, so that the rigid limit is the machine."""
        return all(loss.quantity is Compared.TORQUE for loss in self.losses)

    @property
    def notes(self) -> tuple[str, ...]:
        """Lines on exceeded limits, and on motors that share a torque, in both models."""
        full, rigid = (
            line_on_undetermined(modal.linear.motion.machine, modal.linear.motion.followers) if modal else []
            for modal in (self.full, self.rigid)
        )
        return (*map(str, self.beyond), *full, *(f"rigid limit: {line}" for line in rigid if not full))

    @property
    def beyond(self) -> tuple[Beyond, ...]:
        """Limits of joints that the motion exceeds."""
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
    """Compare the full model, Spong's reduced model and the rigid limit in frequencies and on a motion.

    Frequencies with motors held or free, at equilibrium; torques and elastic accelerations on `trajectory`, a motion or
    its file (`read_comparison_motion`), by default that of `move` with `stroke` and `duration`. `ratios` are gear
    ratios of rotors (`with_ratios`). Raises `InputError`.
    """
    machine = with_independent_motors(machine)
    full_machine = with_ratios(with_values(machine, values or {}), ratios or {})
    less, stiff = reduced_model(with_values(machine, values or {})), rigid_limit(full_machine)
    motors = [joint.name for joint in machine.motor_joints]
    independent = {name: x for name, x in (at or {}).items() if name in _free(stiff)}
    full = modes_with(full_machine, at, motors if held else [])
    if isinstance(trajectory, str | Path):
        trajectory = read_comparison_motion(trajectory, machine, full_machine, progress)
    trajectory = trajectory or move(full_machine, at, slowest(full), stroke, duration, progress)
    return Comparison(
        full,
        pair(full, modes_with(less, at, motors if held else []))[0],
        modes_with(stiff, independent, motors if held else []) if stiff.independent else None,
        trajectory,
        tuple(losses(full_machine, less, stiff, trajectory)),
        full_machine == less,
        held,
    )


def rigid_limit(machine: Machine) -> Machine:
    """Return the rigid limit; raises `InputError` for loops with springs among the dependent joints."""
    free = with_independent(machine, machine.elastic)
    dependent = [free.joint(j).name for j in free.elastic if j in free.dependent]
    if dependent:
        what = "in the rigid limit it would be locked, and nothing else in its loop can yield: no rigid limit exists"
        raise machine.error(f"joint {', '.join(dependent)}", what)
    stiff = rigid(free)
    still = [stiff.joint(j).name for j in stiff.motors if j in stiff.dependent and not moved_by(stiff, j)]
    if still:
        what = "only springs let its motor move, so the rigid limit cannot move: there is nothing to compare with"
        raise machine.error(f"joint {', '.join(still)}", what)
    return stiff


def _free(machine: Machine) -> set[str]:
    """Return names and variables of the independent joints, if motors are chosen as independent."""
    joints = with_independent_motors(machine).independent_joints
    return {name for joint in joints for name in (joint.name, str(joint.variable))}


def losses(full_machine: Machine, less: Machine, stiff: Machine, trajectory: ComparisonMotion) -> list[Loss]:
    """Return torques of motors and accelerations of springs on one motion, by the three models."""
    tau, qdd = _inverse(full_machine, trajectory, full_machine)
    tau_less, qdd_less = _inverse(less, trajectory, full_machine)
    tau_stiff = _inverse(stiff, trajectory, full_machine)[0] if stiff.independent else np.zeros_like(tau)
    compared = [
        Loss(joint.name, Compared.TORQUE, joint.force_unit, tau[:, m], tau_less[:, m], tau_stiff[:, m])
        for m, joint in enumerate(full_machine.motor_joints)
    ]
    for j in full_machine.elastic:
        k, joint = full_machine.with_variable.index(j), full_machine.joint(j)
        full, less_exact = qdd[:, k], qdd_less[:, k]
        unit = f"{joint.unit}/s2"
        compared.append(Loss(joint.name, Compared.ACCELERATION, unit, full, less_exact, np.zeros_like(full)))
    return compared


def _inverse(machine: Machine, trajectory: ComparisonMotion, full_machine: Machine) -> tuple[Array, Array]:
    """Return torques of all motors and accelerations of all joint coordinates on a motion of the full machine."""
    motion = EquationsOfMotion(machine)
    model = InverseModel(motion)
    rows = list(full_machine.entries(motion.given.independent))
    q, qd, qdd_motor = trajectory.q[:, rows], trajectory.qd[:, rows], trajectory.qdd[:, rows][:, motion.motors]
    tau, qdd = model(q, qd, qdd_motor)
    return model.torques(q, tau), model.joint_coordinate_accelerations(q, qd, qdd)


def _size(x: Array) -> tuple[float, float]:
    """Return root mean square and largest absolute value."""
    return float(np.sqrt(np.mean(x**2))), float(np.max(np.abs(x)))


@dataclass(frozen=True)
class ComparisonMotion:
    """A motion of a machine: t (N,) s, q, qd, qdd (N, n), SI units, and its source."""

    t: Array
    q: Array
    qd: Array
    qdd: Array
    source: str


def modes_with(machine: Machine, at: Mapping[str, float] | None, locked: list[str]) -> Modes:
    """Return the modes at equilibrium with some motors held."""
    motion = EquationsOfMotion(machine)
    return modes(with_motors(linearize(motion, equilibrium(motion, at), (), ()), locked))


def usual_duration(machine: Machine, at: Mapping[str, float] | None = None) -> float:
    """Return five periods of the first vibration with motors held, s."""
    motors = [joint.name for joint in machine.motor_joints]
    return PERIODS / slowest(modes_with(machine, at, motors))


def slowest(modal: Modes) -> float:
    """Return the first frequency above 0, Hz; 1 Hz without vibration."""
    swinging = modal.frequencies[modal.frequencies > 0]
    return float(swinging.min()) if len(swinging) else 1.0


def move(
    machine: Machine,
    at: Mapping[str, float] | None = None,
    frequency: float = 1.0,
    stroke: float = STROKE,
    duration: float | None = None,
    progress: Progress = no_progress,
) -> ComparisonMotion:
    """Return a motion where all motors move by `stroke` (rad or m) from rest to rest and springs follow the full model.

    It lasts `duration` s, or five periods of `frequency` Hz. Raises `InputError`.
    """
    motion = EquationsOfMotion(machine)
    start = equilibrium(motion, at)
    duration = PERIODS / frequency if duration is None else duration
    refuse_swings(duration, _fastest(motion, at), motion.source, "--duration")
    if not 0 < duration < np.inf:
        raise InputError(motion.source, "--duration", f"{duration:g} s is not a duration: give a positive number")
    if not abs(stroke) <= LARGEST_STROKE:
        raise InputError(motion.source, "--stroke", f"{stroke:g}: give rad or m up to {LARGEST_STROKE:g}")
    strokes = stroke * np.ones(len(motion.motors))
    zero, scale = np.zeros((4, len(strokes))), duration ** -np.arange(7.0, 3.0, -1.0)
    rising = (np.array(COEFFICIENTS[::-1]) * scale)[:, None] * strokes
    zero[-1] = start.q[motion.motors]
    curve = MotorCurve(np.array([0.0, duration]), np.concatenate([rising, zero])[:, None])
    times = np.linspace(0.0, duration, MOVE_SAMPLES)
    source = f"{stroke:g} (rad or m) in {duration:.4g} s"
    return ComparisonMotion(times, *motion_between_motors(motion, start, curve, times, motion.source, progress), source)


def along(machine: Machine, reference: ReferenceTrajectory, progress: Progress = no_progress) -> ComparisonMotion:
    """Return the motion where motors move along a trajectory and springs follow the full model, from rest.

    Raises `InputError`.
    """
    motion = EquationsOfMotion(machine)
    names = [motion.names[k] for k in motion.motors]
    at = {name: float(reference.y[name][0, 0]) for name in names}
    t = reference.t
    refuse_swings(t[-1] - t[0], _fastest(motion, at), reference.source, "t")
    positions = np.stack([reference.y[name][0] for name in names], axis=1)
    times = t[:: -(-len(t) // MOST_SAMPLES)]
    curve = MotorCurve.through(t, positions, SPLINE_DEGREE)
    states = motion_between_motors(motion, equilibrium(motion, at), curve, times, reference.source, progress)
    return ComparisonMotion(times, *states, f"{reference.source}, springs follow")


def _fastest(motion: EquationsOfMotion, at: Mapping[str, float] | None) -> float:
    """Return the largest rate of motions with motors held, rad/s: the magnitude of their poles."""
    names = [motion.names[k] for k in motion.motors]
    return float(np.abs(modes_with(motion.given, at, names).poles).max(initial=0.0))


def comparison_motion(measured: Measurements) -> ComparisonMotion:
    """Return a measured or simulated motion; missing velocities and accelerations by differences."""
    qd = np.gradient(measured.q, measured.period, axis=0) if measured.qd is None else measured.qd
    qdd = np.gradient(qd, measured.period, axis=0) if measured.qdd is None else measured.qdd
    return ComparisonMotion(measured.t, measured.q, qd, qdd, measured.source)


def read_comparison_motion(
    path: str | Path, machine: Machine, full_machine: Machine, progress: Progress = no_progress
) -> ComparisonMotion:
    """Return the motion in a .csv or .npz file: of all joints with torques, or of the motors alone.

    A file without springs, such as `excite` writes, is a trajectory of the motors, and springs follow the model
    `full_machine`. Raises `InputError`.
    """
    columns = read_columns(path, machine)
    named, _ = named_columns(columns, machine, str(path))
    joints = {name for quantity, name in named if quantity == "q"}
    motors = {joint.name for joint in machine.motor_joints}
    if {joint.name for joint in machine.independent_joints} <= joints and any(x == "tau" for x, _ in named):
        return comparison_motion(read_measurements(path, machine))
    if joints - motors:
        lacking = [header_of(("q", j.name)) for j in machine.independent_joints if j.name not in joints]
        lacking += [header_of(("tau", name)) for name in sorted(motors) if ("tau", name) not in named]
        what = "give all joints and torques as measured, or a trajectory of the motors alone (t, q_<motor>)"
        raise missing(lacking, columns, str(path), what)
    return along(full_machine, read_reference(path, machine, usual=SPLINE_DEGREE), progress)
