"""Errors of Spong's reduced model and of the rigid limit on a machine and a motion, against the full model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.reduced import reduced, rigid, with_ratios
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.packages import for_vibrations
from symoro_elastic.time_series.measurements import Measurements
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion
from symoro_elastic.vibration.equilibrium import equilibrium
from symoro_elastic.vibration.linearization import linearize, with_motors
from symoro_elastic.vibration.modes import Modes, modes
from symoro_elastic.vibration.reference_trajectory import STROKE
from symoro_elastic.vibration.tracking import pair

PERIODS = 5.0  # of the first vibration, for a move
LARGEST_STROKE = 100.0  # rad or m
MOST_SWINGS = 20_000
MOVE_SAMPLES = 501
COEFFICIENTS = (35.0, -84.0, 70.0, -20.0)
"""s = 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7: velocity, acceleration and jerk are zero at both ends."""


class Compared(StrEnum):
    """The quantities that models are compared by: of motors and of springs."""

    TORQUE = "torque"
    ACCELERATION = "acceleration"


@dataclass(frozen=True)
class Course:
    """A motion of a machine: t (N,) s, q, qd, qdd (N, n), SI units, and its source."""

    t: Array
    q: Array
    qd: Array
    qdd: Array
    source: str


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


def compare(
    machine: Machine,
    values: Mapping[str, float] | None = None,
    at: Mapping[str, float] | None = None,
    ratios: Mapping[str, float] | None = None,
    held: bool = True,
    course: Course | None = None,
    stroke: float = STROKE,
    duration: float | None = None,
) -> Comparison:
    """Compare the full model, Spong's reduced model and the rigid limit.

    Frequencies with motors held or free, at equilibrium; torques and elastic accelerations on `course`, unless
    given that of `move` with `stroke` and `duration`. `ratios` are gear ratios of rotors (`with_ratios`).
    Raises `InputError`.
    """
    whole = with_ratios(with_values(machine, values or {}), ratios or {})
    less, stiff = reduced(with_values(machine, values or {})), rigid(whole)
    motors = [joint.name for joint in machine.motor_joints]
    kept = {name: x for name, x in (at or {}).items() if name not in _springs(machine)}
    full = _modes(whole, at, motors if held else [])
    course = course or move(whole, at, _slowest(full), stroke, duration)
    return Comparison(
        full,
        pair(full, _modes(less, at, motors if held else []))[0],
        _modes(stiff, kept, motors if held else []) if stiff.moving else None,
        course,
        tuple(losses(whole, less, stiff, course)),
        whole == less,
    )


def _springs(machine: Machine) -> set[str]:
    return {joint.name for joint in machine.joints if joint.kind is Kind.ELASTIC}


def _modes(machine: Machine, at: Mapping[str, float] | None, held: list[str]) -> Modes:
    motion = EquationsOfMotion(machine)
    return modes(with_motors(linearize(motion, equilibrium(motion, at), (), ()), held))


def usual_duration(machine: Machine, at: Mapping[str, float] | None = None) -> float:
    """Return five periods of the first vibration with motors held, s."""
    motors = [joint.name for joint in machine.motor_joints]
    return PERIODS / _slowest(_modes(machine, at, motors))


def _slowest(modal: Modes) -> float:
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

    It takes `duration` s, or five periods of `frequency` Hz; integrated by an 8th-order Runge-Kutta method.
    Raises `InputError`.
    """
    motion = EquationsOfMotion(machine)
    start = equilibrium(motion, at)
    duration = PERIODS / frequency if duration is None else duration
    fastest = float(_modes(machine, at, [motion.names[k] for k in motion.motors]).frequencies.max(initial=0.0))
    _refuse_move(motion.source, duration, stroke, fastest)
    n, motors = len(motion.joints), motion.motors
    others = [k for k in range(n) if k not in motors]
    model = numpy_model(machine, ("inverse_dynamics",))

    def placed(t: float, y: Array) -> tuple[Array, Array, Array]:
        q, qd, qdd = start.q.copy(), np.zeros(n), np.zeros(n)
        q[motors] += stroke * _shape(t / duration, 0)
        qd[motors] = stroke / duration * _shape(t / duration, 1)
        qdd[motors] = stroke / duration**2 * _shape(t / duration, 2)
        q[others], qd[others] = y[: len(others)], y[len(others) :]
        qdd = model.inverse_dynamics(q, qd, qdd[motors])[1]
        return q, qd, qdd

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[len(others) :], placed(t, y)[2][others]])

    times = np.linspace(0.0, duration, MOVE_SAMPLES)
    rest = np.concatenate([start.q[others], np.zeros(len(others))])
    solve = for_vibrations("scipy.integrate").solve_ivp
    states = (
        solve(rate, (0.0, duration), rest, "DOP853", times, rtol=1e-7, atol=1e-12).y.T
        if others
        else [rest] * MOVE_SAMPLES
    )
    q, qd, qdd = (np.array(block) for block in zip(*map(placed, times, states), strict=True))
    return Course(times, q, qd, qdd, f"{stroke:g} (rad or m) in {duration:.4g} s")


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
