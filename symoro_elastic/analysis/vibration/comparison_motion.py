"""Motions of a machine that models are compared on: measured ones, and motor motions that springs follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements, read_measurements
from symoro_elastic.analysis.time_series.named_columns import header_of, named_columns, read_columns
from symoro_elastic.analysis.vibration.following import MotorCurve, motion_between_motors, refuse_swings
from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import Modes, modes
from symoro_elastic.analysis.vibration.reference_trajectory import STROKE, ReferenceTrajectory, read_reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium

PERIODS = 5.0  # of the first vibration, for a move
LARGEST_STROKE = 100.0  # rad or m
MOVE_SAMPLES, MOST_SAMPLES = 501, 5001
SPLINE_DEGREE = 5
COEFFICIENTS = (35.0, -84.0, 70.0, -20.0)
"""s = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7: velocity, acceleration and jerk are zero at both ends."""


@dataclass(frozen=True)
class ComparisonMotion:
    """A motion of a machine: t (N,) s, q, qd, qdd (N, n), SI units, and its source."""

    t: Array
    q: Array
    qd: Array
    qdd: Array
    source: str


def modes_with(machine: Machine, at: Mapping[str, float] | None, held: list[str]) -> Modes:
    """Return the modes at equilibrium with some motors held."""
    motion = EquationsOfMotion(machine)
    return modes(with_motors(linearize(motion, equilibrium(motion, at), (), ()), held))


def usual_duration(machine: Machine, at: Mapping[str, float] | None = None) -> float:
    """Return five periods of the first vibration with motors held, s."""
    motors = [joint.name for joint in machine.motor_joints]
    return PERIODS / slowest(modes_with(machine, at, motors))


def slowest(modal: Modes) -> float:
    """Return the first frequency above 0, Hz; 1 Hz where nothing vibrates."""
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

    It takes `duration` s, or five periods of `frequency` Hz. Raises `InputError`.
    """
    motion = EquationsOfMotion(machine)
    start = equilibrium(motion, at)
    duration = PERIODS / frequency if duration is None else duration
    _refuse_move(motion.source, duration, stroke, _fastest(motion, at))
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
    kept = t[:: -(-len(t) // MOST_SAMPLES)]
    curve = MotorCurve.through(t, positions, SPLINE_DEGREE)
    found = motion_between_motors(motion, equilibrium(motion, at), curve, kept, reference.source, progress)
    return ComparisonMotion(kept, *found, f"{reference.source}, springs follow")


def _fastest(motion: EquationsOfMotion, at: Mapping[str, float] | None) -> float:
    """Return the largest rate of motions with motors held, rad/s: the magnitude of their poles."""
    names = [motion.names[k] for k in motion.motors]
    return float(np.abs(modes_with(motion.given, at, names).poles).max(initial=0.0))


def _refuse_move(source: str, duration: float, stroke: float, fastest: float) -> None:
    """Raise `InputError` for a move that takes no time or too many periods of the fastest mode, or goes too far."""
    refuse_swings(duration, fastest, source, "--duration")
    if not 0 < duration < np.inf:
        raise InputError(source, "--duration", f"{duration:g} s is not a duration: give a positive number")
    if not abs(stroke) <= LARGEST_STROKE:
        raise InputError(source, "--stroke", f"{stroke:g}: give rad or m up to {LARGEST_STROKE:g}")


def comparison_motion(measured: Measurements) -> ComparisonMotion:
    """Return a measured or simulated motion; velocities and accelerations by differences where it has none."""
    qd = np.gradient(measured.q, measured.period, axis=0) if measured.qd is None else measured.qd
    qdd = np.gradient(qd, measured.period, axis=0) if measured.qdd is None else measured.qdd
    return ComparisonMotion(measured.t, measured.q, qd, qdd, measured.source)


def read_comparison_motion(
    path: str | Path, machine: Machine, whole: Machine, progress: Progress = no_progress
) -> ComparisonMotion:
    """Return the motion in a .csv or .npz file: of all joints with torques, or of the motors alone.

    A file without springs, such as `excite` writes, is a trajectory of the motors, and springs follow the model
    `whole`. Raises `InputError`.
    """
    named, _ = named_columns(read_columns(path, machine), machine, str(path))
    joints = {name for quantity, name in named if quantity == "q"}
    motors = {joint.name for joint in machine.motor_joints}
    if {joint.name for joint in machine.independent_joints} <= joints and any(x == "tau" for x, _ in named):
        return comparison_motion(read_measurements(path, machine))
    if joints - motors:
        lacking = [header_of(("q", j.name)) for j in machine.independent_joints if j.name not in joints]
        lacking += [header_of(("tau", name)) for name in sorted(motors) if ("tau", name) not in named]
        what = "missing: give all joints and torques as measured, or a trajectory of the motors alone (t, q_<motor>)"
        raise InputError(str(path), ", ".join(lacking), what)
    return along(whole, read_reference(path, machine, usual=SPLINE_DEGREE), progress)
