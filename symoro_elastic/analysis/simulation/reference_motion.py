"""The reference motion of a machine: the motions of its motors, and its start."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval

from symoro_elastic.analysis.control.cascade import Cascade, cascade_of
from symoro_elastic.analysis.control.driven_machine import load_ratio, measured_positions
from symoro_elastic.analysis.simulation.motor_coordinates import (
    InverseModelOfMotors,
    MotorCoordinates,
    with_motors_that_follow_exactly,
)
from symoro_elastic.analysis.simulation.moving_base import held_machine, rows, start_of_base
from symoro_elastic.analysis.time_series.preparation import LONGEST_GAP
from symoro_elastic.analysis.time_series.reading import place_of_sample
from symoro_elastic.analysis.vibration.comparison import COEFFICIENTS, SPLINE_DEGREE
from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.analysis.vibration.reference_trajectory import ReferenceTrajectory, read_samples
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR, NO_NUMBER
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Bandwidth, Gains, PrescribedMotion, Servo
from symoro_elastic.machine.restrict import under_forces
from symoro_elastic.models.bound.state import DEPENDENT
from symoro_elastic.models.bound.state import State as Blocks
from symoro_elastic.models.steps.time_steps import dependent_motors
from symoro_elastic.numerics.evaluation.closed_positions import JointCoordinates, with_dependent
from symoro_elastic.numerics.motion.equations_of_motion import LARGEST_INPUT, EquationsOfMotion, State
from symoro_elastic.numerics.motion.equilibrium import equilibrium, refuse_soft_static
from symoro_elastic.numerics.motion.signals import outputs, points_of_signals

Curve = Callable[[Array], Array]
RISE = Polynomial([0.0] * 4 + list(COEFFICIENTS))
RATES = np.stack([np.pad(RISE.deriv(k).coef, (0, k)) for k in range(4)], axis=1)
"""Coefficients (8, 4) of the rise and its derivatives."""
REACHED = 1e-9
"""Of a duration: how far a record may end before it."""
EVEN, MISSING = 0.9, 1.5
"""Share of the steps of a record on an even clock that are the usual one, and a step in which a sample is missing."""

SAMPLES = 1001
SAME = 1e-9
"""Of a position, rad or m: that of `start` and of a record."""


@dataclass(frozen=True)
class Motion(Blocks):
    """States at times t (N,), s, by block of the models, including torques and accelerations."""

    t: Array

    def __getitem__(self, samples: Any) -> Self:
        return replace(super().__getitem__(samples), t=self.t[samples])


@dataclass(frozen=True)
class MeasuredLoad:
    """A load position that a drive controls instead of its motor's: the signal, and its ratio to the motor."""

    signal: str
    ratio: float


@dataclass(frozen=True)
class Reference:
    """Prescribed motion of the motors of `machine`, in the order of tau, over `duration` s from 0. SI units, radians.

    `start` has the springs at their equilibrium, and the motors at the position and the velocity of the motion.
    `servo` holds the gains kp and kd (m,), in N m/rad and N m s/rad or N/m and N s/m; None where motors follow exactly.
    `drives` are those of the motors if the motion uses them; then gains are zero. `loads` are what they measure in
    place of their motors.
    `base` holds the blocks of the base at the start, and the wrench on it; none where it is fixed.
    Where motors are on dependent joints, `viewed` is where the coordinates of `view` start. `feed` gives torques (N, m)
    by time that motors are given in place of those that hold the start, or of those of the inverse model.
    """

    machine: Machine
    prescribed: PrescribedMotion
    start: State
    servo: tuple[Array, Array] | None
    record: Record | None = None
    drives: tuple[Cascade, ...] = ()
    loads: tuple[MeasuredLoad | None, ...] = ()
    base: Mapping[str, Array] = field(default_factory=dict)
    view: MotorCoordinates | None = None
    viewed: Array | None = None
    feed: Curve | None = field(default=None, compare=False)

    @property
    def duration(self) -> float:
        """Simulated time, s."""
        return self.prescribed.duration

    @cached_property
    def motors(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(joint.name for joint in self.machine.motor_joints)

    @cached_property
    def loaded(self) -> Machine:
        """The machine whose models have wrenches on frames as arguments; unchanged without forces."""
        return under_forces(self.machine, (force.at for force in self.prescribed.forces))

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Return y, yd, ydd (N, m) of the variables of the motors at times (N,)."""
        y, yd, ydd, _ = self._motions(t)
        return y, yd, ydd

    def jerks(self, t: Array) -> Array:
        """Return yddd (N, m) at times (N,)."""
        _, _, _, yddd = self._motions(t)
        return yddd

    def _motions(self, t: Array) -> tuple[Array, Array, Array, Array]:
        """Return y, yd, ydd, yddd (N, m) at times (N,)."""
        t = np.asarray(t, dtype=float)
        motion = np.zeros((4, len(t), len(self.motors)))
        motion[0] = self.motors_at_start if self.record is None else 0.0
        for column, motor in enumerate(self.motors):
            motion[:, :, column] += self._motion_of(motor, t)
        y, yd, ydd, yddd = motion
        return y, yd, ydd, yddd

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """Return q_r, v_r, a_r (N, n) at times (N,): motors on their motion, other joints at their start."""
        if self.view is None or self.viewed is None:
            return self._with_motors(self.machine, self.start.q, t)
        q, v, a = self.view.own(*self._with_motors(self.view.other, self.viewed, t))
        return q, v, a

    def motion(self, t: Array) -> Motion:
        """Return the motion at times (N,) with motors on their reference and all else at rest; torques are NaN."""
        q, qd, qdd = self.states(t)
        tau, (f_ext, _) = np.full((len(t), len(self.motors)), np.nan), self.wrenches(t)
        blocks = {"q": q, "qd": qd, "qdd": qdd, "tau": tau, "f_ext": f_ext, **rows(self.base, len(t))}
        return with_dependent(self.machine, Motion(blocks, t))

    @cached_property
    def at_start(self) -> Blocks:
        """The state at the start, by block."""
        moved = with_dependent(self.machine, Blocks({"q": self.start.q[None], "qd": self.start.qd[None]}))
        return moved[0].with_blocks(**self.base)

    def of_motors(self, state: Blocks) -> tuple[Array, Array]:
        """Return positions and rates (N, m) of the variables of the motors at states."""
        if not dependent_motors(self.machine):
            motors = list(self.machine.motor_entries)
            return state.q[:, motors], state.qd[:, motors]
        x, xd = self._joint_coordinates(Blocks(state.only(("q", "qd", DEPENDENT))))
        return x, xd

    @cached_property
    def _joint_coordinates(self) -> JointCoordinates:
        return JointCoordinates(self.machine, self.machine.motors)

    @cached_property
    def motors_at_start(self) -> Array:
        """Positions (m,) of the motors at the start."""
        x, _ = self.of_motors(Blocks({"q": self.start.q[None], "qd": self.start.qd[None]}))
        return np.asarray(x[0])

    def _with_motors(self, machine: Machine, start: Array, t: Array) -> tuple[Array, Array, Array]:
        """Return the states (N, n) of a machine at times (N,), its independent motors on their motion."""
        q, v, a = np.zeros((3, len(t), len(start)))
        q += start
        entries, columns = independent_motors(machine)
        for block, motion in zip((q, v, a), self.at(t), strict=True):
            block[:, entries] = motion[:, columns]
        return q, v, a

    def _motion_of(self, motor: str, t: Array) -> Array:
        """Return the sum of the motions of a motor, (4, N)."""
        moves, wobbles, duration = self.prescribed.moves, self.prescribed.wobbles, self.prescribed.duration
        parts = [x.by * risen(t, x.begins, x.lasts) for x in moves if x.motor == motor]
        parts += [wobble(t, x.amplitude, x.frequency, duration) for x in wobbles if x.motor == motor]
        parts += [self.record(motor, t)] if self.record else []
        return np.sum(parts, axis=0) if parts else np.zeros((4, len(t)))

    def wrenches(self, t: Array) -> tuple[Array, Array]:
        """Return the wrenches (N, 6 w) on the frames of `loaded` at times (N,), and their derivatives by time.

        Forces first, in axes of frame 0.
        """
        t, frames = np.asarray(t, dtype=float), list(dict.fromkeys(force.at for force in self.prescribed.forces))
        blocks = np.zeros((2, len(t), len(frames), 6))
        for force in self.prescribed.forces:
            grown = risen(t, force.begins, force.lasts)[:2]
            blocks[:, :, frames.index(force.at)] += grown[..., None] * np.array(force.wrench)
        wrenches, rates = blocks.reshape(2, len(t), 6 * len(frames))
        return wrenches, rates

    def fed_torques(self, t: Array) -> Array:
        """Return the torques (N, m) fed to motors at times (N,): those at the start, or of the inverse model."""
        if self.feed is not None:
            return self.feed(t)
        torques = np.tile(self.start.torques, (len(t), 1))
        fed = [k for k, drive in enumerate(self.drives) if drive.torque_forward]
        if fed:
            torques[:, fed] = self._inverse_model(*self.at(t))[:, fed]
        return torques

    @cached_property
    def _inverse_model(self) -> InverseModelOfMotors:
        return InverseModelOfMotors(self.machine, self.start.q)

    @cached_property
    def extent(self) -> float:
        """Largest position of a motor, or distance between two positions, rad or m."""
        y, _, _ = self.at(np.linspace(0.0, self.duration, SAMPLES))
        return float(max(np.abs(y).max(initial=0.0), np.ptp(y, axis=0).max(initial=0.0)))


def reference_of(
    machine: Machine, prescribed: PrescribedMotion, values: Mapping[str, float] | None = None
) -> Reference:
    """Return the reference of a motion, with joints locked as `machine` has them, for these values of parameters.

    Springs start at their equilibrium on a base that is held at its start. Wrenches that act are those of the motion
    alone. Raises `InputError` for a base of known acceleration, motors that cannot all follow exactly, motors that the
    scene locks, servos of some motors only, records without all motors, and joints that nothing supports.
    """
    machine = replace(machine, forces=()) if machine.forces else machine
    base = start_of_base(machine, prescribed)
    _refuse_locked(machine, prescribed)
    record = Record(prescribed.path, machine, prescribed.duration) if prescribed.file else None
    has_servos = prescribed.servo or prescribed.drives
    followed = machine if has_servos else with_motors_that_follow_exactly(machine, prescribed)
    locked = held_machine(followed, base)
    motion = EquationsOfMotion(locked, values)
    view = None if motion.given.independent == machine.independent else MotorCoordinates(machine, motion.given)
    at = _positions(machine, prescribed, record)
    if view:
        at = view.positions(at) | _positions(machine, replace(prescribed, start={}), record)
    at = {name: x for name, x in at.items() if name in motion.names}
    refuse_soft_static(locked, at, values)
    start = equilibrium(motion, at)
    if view and record and not start.sought:
        _refuse_other_start(view, prescribed, start)
    drives = tuple(_drives(machine, motion, prescribed)) if prescribed.drives else ()
    loads = tuple(_loads(machine, motion, start)) if drives else ()
    servo = (np.zeros(len(drives)), np.zeros(len(drives))) if drives else _gains(motion, prescribed, start)
    reference = Reference(followed, prescribed, start, servo, record, drives, loads, base)
    if view and followed is machine:
        (q,), (qd,), (qdd,) = view.own(start.q[None], start.qd[None], start.qdd[None])
        own_start = replace(start, q=q, qd=qd, qdd=qdd, tau=view.forces(q, start.torques))
        reference = replace(reference, start=own_start, view=view, viewed=start.q)
    _refuse_large(reference)
    _refuse_weak(reference)
    return _in_motion(reference, motion, start)


def _refuse_other_start(view: MotorCoordinates, prescribed: PrescribedMotion, start: State) -> None:
    """Raise `InputError` for stated positions that differ from the start of the motors' record."""
    q = view.own(start.q[None], start.qd[None], start.qdd[None])[0, 0]
    for joint, x in zip(view.machine.independent_joints, q.tolist(), strict=True):
        stated = prescribed.start.get(joint.name, x)
        if abs(stated - x) > SAME * max(1.0, abs(x)):
            what = f"{stated:g} is not where {prescribed.file} puts it, {x:g}: leave it out"
            raise prescribed.error(f"start, {joint.name}", what)


def _refuse_weak(reference: Reference) -> None:
    """Raise `InputError` for a torque limit below the holding torque at the start, where no steady state exists."""
    for k, drive in enumerate(reference.drives):
        needed, by_voltage = abs(float(reference.start.torques[k])), np.inf
        if drive.current and drive.current.resistance > 0:
            by_voltage = drive.voltage_limit / drive.current.resistance
        most, key = min((drive.torque_limit, "limits"), (by_voltage, "limits, voltage"))
        if needed > most:
            gives = "its torque at rest, " if key == "limits, voltage" else ""
            end = "," if gives else ""
            what = f"{gives}{most:.4g}{end} does not hold the machine at the start, which needs {needed:.4g}: raise it"
            raise reference.machine.error(f"drives, {drive.motor}, {key}", what)


def _in_motion(reference: Reference, motion: EquationsOfMotion, start: State) -> Reference:
    """Return the reference with the initial velocities of the motors' motion."""
    qd = np.zeros_like(start.qd)
    entries, columns = independent_motors(motion.given)
    qd[entries] = reference.at(np.zeros(1))[1][0, columns]
    if reference.view:
        qd = reference.view.own(start.q[None], qd[None], start.qdd[None])[1][0]
    return replace(reference, start=replace(reference.start, qd=qd))


def independent_motors(machine: Machine) -> tuple[list[int], list[int]]:
    """Return the entries in q of independent motors, and their indices among all motors."""
    columns = [k for k, j in enumerate(machine.motors) if j in machine.independent]
    return list(machine.motor_entries), columns


def _refuse_large(reference: Reference) -> None:
    """Raise `InputError` for a motor with a larger position or velocity than files may state."""
    motions = reference.at(np.linspace(0.0, reference.duration, SAMPLES))[:2]
    for what, unit, x in zip(("position", "velocity"), ("", "/s"), motions, strict=True):
        largest = np.abs(x).max(axis=0)
        for name, reached in zip(reference.motors, largest, strict=True):
            if not reached <= LARGEST_INPUT:
                message = f"its {what} reaches {reached:.3g} rad or m{unit}: {LARGEST_INPUT:g} is the largest allowed"
                raise reference.prescribed.error(name, message)


def _refuse_locked(machine: Machine, prescribed: PrescribedMotion) -> None:
    """Raise `InputError` for a locked motor, or a locked joint in `start`, and for motors without a servo."""
    motors = [joint.name for joint in machine.motor_joints]
    moving = [joint.name for joint in machine.independent_joints]
    named = [("start", name, moving) for name in prescribed.start]
    named += [(f"moves {k}", move.motor, motors) for k, move in enumerate(prescribed.moves, 1)]
    named += [(f"wobbles {k}", move.motor, motors) for k, move in enumerate(prescribed.wobbles, 1)]
    named += [("servo", name, motors) for name in prescribed.servo]
    for key, name, there in named:
        if name not in there:
            raise prescribed.error(key, f"{name} is locked by the scene: remove one of the two")
    without = [name for name in motors if name not in prescribed.servo]
    if prescribed.servo and without:
        what = f"{', '.join(without)} without a servo: give one to all motors, or to none, which then follow exactly"
        raise prescribed.error("servo", what)


def _positions(machine: Machine, prescribed: PrescribedMotion, record: Record | None) -> dict[str, float]:
    """Return the stated start positions, by joint. Raises `InputError` for those that differ from a record."""
    if record is None:
        return prescribed.start
    recorded = {joint.name: float(record(joint.name, np.zeros(1))[0, 0]) for joint in machine.motor_joints}
    for name, x in recorded.items():
        stated = prescribed.start.get(name, x)
        if abs(stated - x) > SAME * max(1.0, abs(x)):
            what = f"{stated:g} is not where {prescribed.file} begins, {x:g}: leave it out"
            raise prescribed.error(f"start, {name}", what)
    return {**prescribed.start, **recorded}


def _gains(motion: EquationsOfMotion, prescribed: PrescribedMotion, start: State) -> tuple[Array, Array] | None:
    """Return the servo gains kp and kd (m,) of the motors; None without a servo.

    Raises `InputError` for a bandwidth of a motor that nothing moves with, or that moves with other motors alone.
    """
    if not prescribed.servo:
        return None
    servos = {name: prescribed.servo[name] for name in motion.motor_names}
    inertia = dict.fromkeys(servos, 0.0)
    if any(isinstance(servo, Bandwidth) for servo in servos.values()):
        (A,) = motion.matrices("M", start.q)
        inertia |= {motion.names[k]: float(A[k, k]) for k in motion.motors}
    joined = {j for leader, followers in motion.followers.items() for j in (leader, *followers)}
    shared = {motion.machine.joint(j).name for j in joined}
    for name, servo in servos.items():
        if isinstance(servo, Bandwidth) and name in shared:
            raise prescribed.error(f"servo, {name}", "other motors move the same inertia: give kp and kd")
        if isinstance(servo, Bandwidth) and not inertia[name] > 0:
            raise prescribed.error(f"servo, {name}", "the motor moves no inertia: give kp and kd")
    kp, kd = np.array([_law(servo, inertia[name]) for name, servo in servos.items()]).T
    return kp, kd


def _drives(machine: Machine, motion: EquationsOfMotion, prescribed: PrescribedMotion) -> Iterator[Cascade]:
    """Yield the drives of all motors; raises `InputError` for motors without one, and for gains without value."""
    by_motor, joints = drives_of(machine).by_motor, {joint.name: joint for joint in machine.joints}
    for name in motion.motor_names:
        if name not in by_motor:
            raise prescribed.error("drives", f"{name} has none: give one to all motors below [drives]")
        drive = cascade_of(joints[name], by_motor[name], motion.parameters, machine.label)
        if drive.tuned_gains:
            raise machine.error(f"drives, {name}, {', '.join(drive.tuned_gains)}", f"is {NO_NUMBER}")
        yield drive


def _loads(machine: Machine, motion: EquationsOfMotion, start: State) -> Iterator[MeasuredLoad | None]:
    """Yield the load positions that drives measure, None for motor positions; raises `InputError`."""
    by_motor = drives_of(machine).by_motor
    signals = [by_motor[name].measured for name in motion.motor_names]
    loads = [name for name in dict.fromkeys(signals) if name != MOTOR]
    if not loads:
        yield from [None] * len(signals)
        return
    if motion.machine.is_coupled:
        raise machine.error("drives, measured", "positions of the load are not simulated where joints are coupled")
    measured_positions(machine)
    points = points_of_signals(motion.given, outputs(motion.given, loads))
    motion = EquationsOfMotion(motion.given, motion.given_values, points)
    linear = linearize(motion, start, (), loads)
    for name, signal, velocity in zip(motion.motor_names, signals, linear.motors, strict=True):
        yield None if signal == MOTOR else MeasuredLoad(signal, load_ratio(linear, name, velocity, signal))


def _law(servo: Servo, m: float) -> tuple[float, float]:
    """Return the servo gains kp = m (2 pi f)^2 and kd = 2 zeta m (2 pi f)."""
    if isinstance(servo, Gains):
        return servo.kp, servo.kd
    omega = 2 * np.pi * servo.frequency
    return m * omega**2, 2 * servo.damping * m * omega


def risen(t: Array, begins: float, lasts: float) -> Array:
    """Return the smooth rise 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7 from 0 to 1, x = (t - begins) / lasts, within 0 to 1."""
    x = np.clip((t - begins) / lasts, 0.0, 1.0)
    return np.asarray((polyval(x, RATES).T / [lasts**k for k in range(4)]).T)


def wobble(t: Array, amplitude: float, frequency: float, duration: float) -> Array:
    """Return amplitude sin(2 pi frequency t), faded in over the first period and out over the last of the duration."""
    omega, period = 2 * np.pi * frequency, 1 / frequency
    sine, cosine = np.sin(omega * t), np.cos(omega * t)
    swing = amplitude * np.array([sine, omega * cosine, -(omega**2) * sine, -(omega**3) * cosine])
    falling = risen(duration - t, 0.0, period) * np.array([[1.0], [-1.0], [1.0], [-1.0]])
    return _product(_product(risen(t, 0.0, period), falling), swing)


def _product(f: Array, g: Array) -> Array:
    """Return the product f g and its derivatives, from those of f and g."""
    return np.array([sum(math.comb(n, k) * f[n - k] * g[k] for k in range(n + 1)) for n in range(len(f))])


class Record:
    """The motion of all motors in a file: polynomials of degree 5 between its samples.

    They have its velocities and accelerations where the file gives both, else they are a spline through its positions.
    """

    def __init__(self, path: Path, machine: Machine, duration: float) -> None:
        """Read the record; raises `InputError` for a file without all motors, or of another duration."""
        samples = read_samples(path, machine)
        self.t = samples.t
        _refuse_parts(samples, duration)
        self.curves = {name: _curves(samples, name) for name in samples.y}

    def __call__(self, motor: str, t: Array) -> Array:
        """Return y, yd, ydd, yddd of a motor at times t; constant outside the record."""
        inside = np.clip(t, self.t[0], self.t[-1])
        return np.array([curve(inside) for curve in self.curves[motor]])


def _refuse_parts(samples: ReferenceTrajectory, duration: float) -> None:
    """Raise `InputError` for a record with a gap, or one that does not cover the motion."""
    t, source = samples.t, samples.source
    if len(t) <= SPLINE_DEGREE:
        raise InputError(source, "t", f"{len(t)} samples are too few for a motion: give {SPLINE_DEGREE + 1} or more")
    if t[0] > REACHED * duration or t[-1] < duration * (1 - REACHED):
        what = f"it has {t[0]:g} to {t[-1]:g} s, the motion 0 to {duration:g} s: record all of it, or change duration"
        raise InputError(source, "t", what)
    steps = np.diff(t)
    usual = float(np.median(steps))
    is_even = np.mean(np.abs(steps - usual) < (MISSING - 1) * usual) >= EVEN
    gaps = steps > (MISSING if is_even else LONGEST_GAP) * usual
    if gaps.any():
        k = int(np.argmax(gaps))
        what = f"gap of {steps[k]:g} s after {t[k]:g} s, {place_of_sample(source, k)}: give samples there"
        raise InputError(source, "t", what)


def _curves(samples: ReferenceTrajectory, motor: str) -> list[Curve]:
    """Return piecewise polynomials y, y', y'', y''' through the samples of a motor. Raises `InputError`."""
    if motor in samples.doubts and samples.order(motor) < 2:
        what = f"{samples.doubts[motor][1]}; give positions alone, and a spline goes through them"
        raise InputError(samples.source, f"{samples.columns}_{motor}", what)
    interpolate = for_vibrations("scipy.interpolate")
    if samples.order(motor) < 2:
        y = interpolate.make_interp_spline(samples.t, samples.y[motor][0], k=SPLINE_DEGREE)
    else:
        y = interpolate.BPoly(_between(samples.t, samples.y[motor]), samples.t)
    return [y, *(y.derivative(order) for order in (1, 2, 3))]


def _between(t: Array, rows: Array) -> Array:
    """Return the Bernstein coefficients (6, N - 1) of the polynomials with y, y', y'' of `rows` at both ends."""
    h, (y, yd, ydd) = np.diff(t), rows[:3]
    first = (y[:-1], y[:-1] + h * yd[:-1] / 5, y[:-1] + 2 * h * yd[:-1] / 5 + h**2 * ydd[:-1] / 20)
    last = (y[1:] - 2 * h * yd[1:] / 5 + h**2 * ydd[1:] / 20, y[1:] - h * yd[1:] / 5, y[1:])
    return np.array([*first, *last])
