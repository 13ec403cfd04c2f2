"""Motions of a machine that models are compared on: measured ones, and motor motions that springs follow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.packages import for_vibrations
from symoro_elastic.time_series.columns import header_of, named_columns, read_columns
from symoro_elastic.time_series.measurements import Measurements, read_measurements
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.vibration.equilibrium import equilibrium
from symoro_elastic.vibration.linearization import linearize, with_motors
from symoro_elastic.vibration.modes import Modes, modes
from symoro_elastic.vibration.reference_trajectory import STROKE, ReferenceTrajectory, read_reference

PERIODS = 5.0  # of the first vibration, for a move
LARGEST_STROKE = 100.0  # rad or m
MOST_SWINGS = 20_000
MOVE_SAMPLES, MOST_SAMPLES = 501, 5001
SPLINE_DEGREE = 5
COEFFICIENTS = (35.0, -84.0, 70.0, -20.0)
"""s = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7: velocity, acceleration and jerk are zero at both ends."""

MotorMotion = Callable[[float], tuple[Array, Array, Array]]
"""q, qd, qdd of the motors at a time."""


@dataclass(frozen=True)
class Course:
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
) -> Course:
    """Return a motion where all motors move by `stroke` (rad or m) from rest to rest and springs follow the full model.

    It takes `duration` s, or five periods of `frequency` Hz. Raises `InputError`.
    """
    motion = EquationsOfMotion(machine)
    start = equilibrium(motion, at)
    duration = PERIODS / frequency if duration is None else duration
    _refuse_move(motion.source, duration, stroke, _fastest(motion, at))
    before = start.q[motion.motors]

    def moved(t: float) -> tuple[Array, Array, Array]:
        x = t / duration
        whole = np.ones_like(before)
        rates = (stroke / duration**k * _shape(x, k) * whole for k in (1, 2))
        return before + stroke * _shape(x, 0), *rates  # type: ignore[return-value]

    times = np.linspace(0.0, duration, MOVE_SAMPLES)
    return _followed(motion, start, moved, times, f"{stroke:g} (rad or m) in {duration:.4g} s")


def along(machine: Machine, reference: ReferenceTrajectory) -> Course:
    """Return the motion where motors move along a trajectory and springs follow the full model, from rest.

    Raises `InputError`.
    """
    motion = EquationsOfMotion(machine)
    names = [motion.names[k] for k in motion.motors]
    at = {name: float(reference.y[name][0, 0]) for name in names}
    t, fastest = reference.t, _fastest(motion, at)
    if (t[-1] - t[0]) * fastest > MOST_SWINGS:
        what = (
            f"{t[-1] - t[0]:.4g} s at {fastest:.4g} Hz is too long to follow: cut it to {MOST_SWINGS / fastest:.3g} s"
        )
        raise InputError(reference.source, "t", what)
    positions = np.stack([reference.y[name][0] for name in names], axis=1)
    spline = for_vibrations("scipy.interpolate").make_interp_spline(t, positions, k=SPLINE_DEGREE)
    curves = [spline, spline.derivative(1), spline.derivative(2)]

    def moved(time: float) -> tuple[Array, Array, Array]:
        q, qd, qdd = (curve(time) for curve in curves)
        return q, qd, qdd

    kept = t[:: -(-len(t) // MOST_SAMPLES)]
    return _followed(motion, equilibrium(motion, at), moved, kept, f"{reference.source}, springs follow")


def _fastest(motion: EquationsOfMotion, at: Mapping[str, float] | None) -> float:
    """Return the highest frequency with motors held, Hz."""
    names = [motion.names[k] for k in motion.motors]
    return float(modes_with(motion.given, at, names).frequencies.max(initial=0.0))


def _followed(motion: EquationsOfMotion, start: State, moved: MotorMotion, times: Array, source: str) -> Course:
    """Return the motion of all joints at times, springs from rest by an 8th-order Runge-Kutta method."""
    n, motors = len(motion.joints), motion.motors
    others = [k for k in range(n) if k not in motors]
    model = numpy_model(motion.given, ("inverse_dynamics",))

    def placed(t: float, y: Array) -> tuple[Array, Array, Array]:
        q, qd = start.q.copy(), np.zeros(n)
        q[motors], qd[motors], accelerations = moved(t)
        q[others], qd[others] = y[: len(others)], y[len(others) :]
        return q, qd, model.inverse_dynamics(q, qd, accelerations)[1]

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[len(others) :], placed(t, y)[2][others]])

    rest = np.concatenate([start.q[others], np.zeros(len(others))])
    solve = for_vibrations("scipy.integrate").solve_ivp
    states = (
        solve(rate, (times[0], times[-1]), rest, "DOP853", times, rtol=1e-7, atol=1e-12).y.T
        if others
        else [rest] * len(times)
    )
    q, qd, qdd = (np.array(block) for block in zip(*map(placed, times, states), strict=True))
    return Course(times, q, qd, qdd, source)


def _refuse_move(source: str, duration: float, stroke: float, fastest: float) -> None:
    """Raise `InputError` for a move that takes no time or too many periods of the fastest mode, or goes too far."""
    if duration * fastest > MOST_SWINGS:
        what = f"{duration:g} s at {fastest:.4g} Hz is too long to follow: at most {MOST_SWINGS / fastest:.3g} s"
        raise InputError(source, "--duration", what)
    if not 0 < duration < np.inf:
        raise InputError(source, "--duration", f"{duration:g} s is no time to move in: give a positive number")
    if not abs(stroke) <= LARGEST_STROKE:
        raise InputError(source, "--stroke", f"{stroke:g}: give rad or m up to {LARGEST_STROKE:g}")


def _shape(x: float, derivative: int) -> float:
    """Return the move from 0 to 1, or a derivative of it by x."""
    polynomial = np.polynomial.Polynomial([0.0, 0.0, 0.0, 0.0, *COEFFICIENTS])
    return float(polynomial.deriv(derivative)(x) if derivative else polynomial(x))


def course_of(measured: Measurements) -> Course:
    """Return a measured or simulated motion; velocities and accelerations by differences where it has none."""
    qd = np.gradient(measured.q, measured.period, axis=0) if measured.qd is None else measured.qd
    qdd = np.gradient(qd, measured.period, axis=0) if measured.qdd is None else measured.qdd
    return Course(measured.t, measured.q, qd, qdd, measured.source)


def read_course(path: str | Path, machine: Machine, whole: Machine) -> Course:
    """Return the motion in a .csv or .npz file: of all joints with torques, or of the motors alone.

    A file without springs, such as `excite` writes, is a trajectory of the motors, and springs follow the model
    `whole`. Raises `InputError`.
    """
    named, _ = named_columns(read_columns(path, machine), machine, str(path))
    joints = {name for quantity, name in named if quantity == "q"}
    motors = {joint.name for joint in machine.motor_joints}
    if {joint.name for joint in machine.moving_joints} <= joints and any(x == "tau" for x, _ in named):
        return course_of(read_measurements(path, machine))
    if joints - motors:
        lacking = [header_of(("q", j.name)) for j in machine.moving_joints if j.name not in joints]
        lacking += [header_of(("tau", name)) for name in sorted(motors) if ("tau", name) not in named]
        what = "missing: give all joints and torques as measured, or a trajectory of the motors alone (t, q_<motor>)"
        raise InputError(str(path), ", ".join(lacking), what)
    return along(whole, read_reference(path, machine, usual=SPLINE_DEGREE))
