"""The reference motion of a machine: what its motors are told to do, and where it starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Bandwidth, Gains, PrescribedMotion, Servo
from symoro_elastic.simulation.motor_motion import Record, risen, wobble
from symoro_elastic.simulation.moving_base import BaseStates, held_machine, start_of_base
from symoro_elastic.vibration.equations_of_motion import LARGEST_INPUT, EquationsOfMotion, State
from symoro_elastic.vibration.equilibrium import equilibrium
from symoro_elastic.vibration.shared_motors import refuse_dependent_motors
from symoro_elastic.vibration.soft_springs import refuse_soft_static

SAMPLES = 1001
SAME = 1e-9
"""Of a position, rad or m: that of `start` and of a record."""


@dataclass(frozen=True)
class Reference:
    """Wanted motion of the motors of `machine`, in the order of tau, over `duration` s from 0. SI units, radians.

    `start` has the springs at their equilibrium, and the motors at the position and the velocity of the motion.
    `servo` holds the gains kp and kd (m,), in N m/rad and N m s/rad or N/m and N s/m; None where motors follow exactly.
    `base` is the start of a floating base and the wrench on it, empty where the base is fixed.
    """

    machine: Machine
    prescribed: PrescribedMotion
    start: State
    servo: tuple[Array, Array] | None
    record: Record | None = None
    base: BaseStates = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """Time that is looked at, s."""
        return self.prescribed.duration

    @cached_property
    def motors(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(joint.name for joint in self.machine.motor_joints)

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of the frames on which the forces act."""
        return tuple(force.at for force in self.prescribed.forces)

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Return y, yd, ydd (N, m) of the variables of the motors at times (N,)."""
        t = np.asarray(t, dtype=float)
        motion = np.zeros((3, len(t), len(self.motors)))
        motion[0] = self.start.q[list(self.machine.motor_entries)] if self.record is None else 0.0
        for column, motor in enumerate(self.motors):
            motion[:, :, column] += self._moved(motor, t)
        y, yd, ydd = motion
        return y, yd, ydd

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """Return q_r, v_r, a_r (N, n) at times (N,): motors on their motion, other joints where they start."""
        q, v, a = np.zeros((3, len(t), len(self.start.q)))
        q += self.start.q
        motors = list(self.machine.motor_entries)
        q[:, motors], v[:, motors], a[:, motors] = self.at(t)
        return q, v, a

    def _moved(self, motor: str, t: Array) -> Array:
        """Return the sum of the motions of a motor, (3, N)."""
        given = self.prescribed
        parts = [x.by * risen(t, x.begins, x.lasts) for x in given.moves if x.motor == motor]
        parts += [wobble(t, x.amplitude, x.frequency, given.duration) for x in given.wobbles if x.motor == motor]
        parts += [self.record(motor, t)] if self.record else []
        return np.sum(parts, axis=0) if parts else np.zeros((3, len(t)))

    def forces_at(self, t: Array) -> Array:
        """Return the wrenches (N, forces, 6) on `frames`, in axes of frame 0, forces first, at times (N,)."""
        t, forces = np.asarray(t, dtype=float), self.prescribed.forces
        wrenches = np.zeros((len(t), len(forces), 6))
        for k, force in enumerate(forces):
            wrenches[:, k] = risen(t, force.begins, force.lasts)[0][:, None] * np.array(force.wrench)
        return wrenches

    @cached_property
    def extent(self) -> float:
        """Largest position of a motor, or distance between two, rad or m."""
        y, _, _ = self.at(np.linspace(0.0, self.duration, SAMPLES))
        return float(max(np.abs(y).max(initial=0.0), np.ptp(y, axis=0).max(initial=0.0)))


def reference_of(
    machine: Machine, prescribed: PrescribedMotion, values: Mapping[str, float] | None = None
) -> Reference:
    """Return the reference of a motion, with joints locked as `machine` has them, for these values of parameters.

    Springs on a floating base start at the equilibrium of a base held there. Raises `InputError` for a base of known
    acceleration, motors on dependent joints, motors that the scene locks, servos of some motors only, records that are
    no motion of all motors, and joints that nothing supports.
    """
    base = start_of_base(machine, prescribed)
    refuse_dependent_motors(machine)
    _refuse_locked(machine, prescribed)
    record = Record(prescribed.path, machine, prescribed.duration) if prescribed.file else None
    held = held_machine(machine, base)
    motion = EquationsOfMotion(held, values)
    at = _positions(machine, prescribed, record)
    refuse_soft_static(held, at, values)
    start = equilibrium(motion, at)
    reference = Reference(machine, prescribed, start, _gains(motion, prescribed, start), record, base)
    qd = np.zeros_like(start.qd)
    qd[motion.motors] = reference.at(np.zeros(1))[1][0]
    _refuse_large(reference)
    return replace(reference, start=replace(start, qd=qd))


def _refuse_large(reference: Reference) -> None:
    """Raise `InputError` for a motor that gets farther or faster than numbers given by hand may be."""
    motions = reference.at(np.linspace(0.0, reference.duration, SAMPLES))[:2]
    for what, unit, x in zip(("position", "velocity"), ("", "/s"), motions, strict=True):
        largest = np.abs(x).max(axis=0)
        for name, reached in zip(reference.motors, largest, strict=True):
            if not reached <= LARGEST_INPUT:
                told = f"its {what} reaches {reached:.3g} rad or m{unit}: {LARGEST_INPUT:g} is the most"
                raise reference.prescribed.error(name, told)


def _refuse_locked(machine: Machine, prescribed: PrescribedMotion) -> None:
    """Raise `InputError` for a motor, or a joint in `start`, that moves no more, and for motors without a servo."""
    motors = [joint.name for joint in machine.motor_joints]
    moving = [joint.name for joint in machine.moving_joints]
    named = [("start", name, moving) for name in prescribed.start]
    named += [(f"moves {k}", move.motor, motors) for k, move in enumerate(prescribed.moves, 1)]
    named += [(f"wobbles {k}", move.motor, motors) for k, move in enumerate(prescribed.wobbles, 1)]
    named += [("servo", name, motors) for name in prescribed.servo]
    for key, name, there in named:
        if name not in there:
            raise prescribed.error(key, f"{name} is locked by the scene: leave it out of one of both")
    without = [name for name in motors if name not in prescribed.servo]
    if prescribed.servo and without:
        what = f"{', '.join(without)} without a servo: give one to all motors, or to none, which then follow exactly"
        raise prescribed.error("servo", what)


def _positions(machine: Machine, prescribed: PrescribedMotion, record: Record | None) -> dict[str, float]:
    """Return the positions at the start that are given, by joint. Raises `InputError` where a record has others."""
    if record is None:
        return prescribed.start
    recorded = {joint.name: float(record(joint.name, np.zeros(1))[0, 0]) for joint in machine.motor_joints}
    for name, x in recorded.items():
        given = prescribed.start.get(name, x)
        if abs(given - x) > SAME * max(1.0, abs(x)):
            what = f"{given:g} is not where {prescribed.file} begins, {x:g}: leave it out"
            raise prescribed.error(f"start, {name}", what)
    return {**prescribed.start, **recorded}


def _gains(motion: EquationsOfMotion, prescribed: PrescribedMotion, start: State) -> tuple[Array, Array] | None:
    """Return kp and kd of the motors (m,); raises `InputError` for a bandwidth of a motor that nothing moves with."""
    if not prescribed.servo:
        return None
    servos = {name: prescribed.servo[name] for name in (motion.names[k] for k in motion.motors)}
    inertia = np.zeros(len(servos))
    if any(isinstance(servo, Bandwidth) for servo in servos.values()):
        zero = np.zeros_like(start.q)
        (A,) = motion.matrices(["M"], start.q, zero, zero)
        inertia = np.diag(A)[motion.motors]
    for (name, servo), m in zip(servos.items(), inertia, strict=True):
        if isinstance(servo, Bandwidth) and not m > 0:
            raise prescribed.error(f"servo, {name}", "the motor moves no inertia: give kp and kd")
    kp, kd = np.array([_law(servo, float(m)) for servo, m in zip(servos.values(), inertia, strict=True)]).T
    return kp, kd


def _law(servo: Servo, m: float) -> tuple[float, float]:
    """Return kp and kd; kp = m (2 pi f)^2, kd = 2 zeta m (2 pi f)."""
    if isinstance(servo, Gains):
        return servo.kp, servo.kd
    omega = 2 * np.pi * servo.frequency
    return m * omega**2, 2 * servo.damping * m * omega
