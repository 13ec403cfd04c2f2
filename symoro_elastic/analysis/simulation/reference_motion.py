"""The reference motion of a machine: what its motors are told to do, and where it starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import Bandwidth, Gains, PrescribedMotion, Servo
from symoro_elastic.machine.restrict import under_forces
from symoro_elastic.models.motor_coordinates import dependent_motors
from symoro_elastic.numerics.own_motion import OwnMotion
from symoro_elastic.simulation.motor_motion import Record, risen, wobble
from symoro_elastic.simulation.motor_view import MotorView, with_motors_that_follow_exactly
from symoro_elastic.simulation.moving_base import BaseStates, held_machine, start_of_base
from symoro_elastic.vibration.equations_of_motion import LARGEST_INPUT, EquationsOfMotion, State
from symoro_elastic.vibration.equilibrium import equilibrium
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
    Where motors are on dependent joints, `viewed` is where the coordinates of `view` start.
    """

    machine: Machine
    prescribed: PrescribedMotion
    start: State
    servo: tuple[Array, Array] | None
    record: Record | None = None
    base: BaseStates = field(default_factory=dict)
    view: MotorView | None = None
    viewed: Array | None = None

    @property
    def duration(self) -> float:
        """Time that is looked at, s."""
        return self.prescribed.duration

    @cached_property
    def motors(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(joint.name for joint in self.machine.motor_joints)

    @cached_property
    def loaded(self) -> Machine:
        """The machine whose models take the wrenches on frames as arguments; itself where no forces act."""
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
        motion[0] = self._motors_at_start if self.record is None else 0.0
        for column, motor in enumerate(self.motors):
            motion[:, :, column] += self._moved(motor, t)
        y, yd, ydd, yddd = motion
        return y, yd, ydd, yddd

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """Return q_r, v_r, a_r (N, n) at times (N,): motors on their motion, other joints where they start."""
        if self.view is None or self.viewed is None:
            return self._with_motors(self.machine, self.start.q, t)
        q, v, a = self.view.own(*self._with_motors(self.view.other, self.viewed, t))
        return q, v, a

    def of_motors(self, q: Array, qd: Array, q_dep: Array | None = None) -> tuple[Array, Array]:
        """Return positions and rates (N, m) of the variables of the motors at states (N, n)."""
        if not dependent_motors(self.machine):
            motors = list(self.machine.motor_entries)
            return q[:, motors], qd[:, motors]
        x, xd = self._own_motion(q, qd, q_dep=q_dep)
        return x, xd

    @cached_property
    def _own_motion(self) -> OwnMotion:
        return OwnMotion(self.machine, self.machine.motors)

    @cached_property
    def _motors_at_start(self) -> Array:
        x, _ = self.of_motors(self.start.q[None], self.start.qd[None])
        found: Array = x[0]
        return found

    def _with_motors(self, machine: Machine, start: Array, t: Array) -> tuple[Array, Array, Array]:
        """Return the states (N, n) of a machine at times (N,), its independent motors on their motion."""
        q, v, a = np.zeros((3, len(t), len(start)))
        q += start
        entries, columns = independent_motors(machine)
        for block, motion in zip((q, v, a), self.at(t), strict=True):
            block[:, entries] = motion[:, columns]
        return q, v, a

    def _moved(self, motor: str, t: Array) -> Array:
        """Return the sum of the motions of a motor, (4, N)."""
        given = self.prescribed
        parts = [x.by * risen(t, x.begins, x.lasts) for x in given.moves if x.motor == motor]
        parts += [wobble(t, x.amplitude, x.frequency, given.duration) for x in given.wobbles if x.motor == motor]
        parts += [self.record(motor, t)] if self.record else []
        return np.sum(parts, axis=0) if parts else np.zeros((4, len(t)))

    def wrenches(self, t: Array) -> tuple[Array, Array]:
        """Return the wrenches (N, 6 w) on the frames of `loaded` at times (N,), and their derivatives by time.

        Forces first, in axes of frame 0.
        """
        t, frames = np.asarray(t, dtype=float), list(dict.fromkeys(force.at for force in self.prescribed.forces))
        found = np.zeros((2, len(t), len(frames), 6))
        for force in self.prescribed.forces:
            grown = risen(t, force.begins, force.lasts)[:2]
            found[:, :, frames.index(force.at)] += grown[..., None] * np.array(force.wrench)
        wrenches, rates = found.reshape(2, len(t), 6 * len(frames))
        return wrenches, rates

    @cached_property
    def extent(self) -> float:
        """Largest position of a motor, or distance between two, rad or m."""
        y, _, _ = self.at(np.linspace(0.0, self.duration, SAMPLES))
        return float(max(np.abs(y).max(initial=0.0), np.ptp(y, axis=0).max(initial=0.0)))


def reference_of(
    machine: Machine, prescribed: PrescribedMotion, values: Mapping[str, float] | None = None
) -> Reference:
    """Return the reference of a motion, with joints locked as `machine` has them, for these values of parameters.

    Springs on a floating base start at the equilibrium of a base held there. Wrenches that act are those of the motion
    alone. Raises `InputError` for a base of known acceleration, motors that cannot all follow exactly, motors that the
    scene locks, servos of some motors only, records that are no motion of all motors, and joints that nothing supports.
    """
    machine = replace(machine, forces=()) if machine.forces else machine
    base = start_of_base(machine, prescribed)
    _refuse_locked(machine, prescribed)
    record = Record(prescribed.path, machine, prescribed.duration) if prescribed.file else None
    followed = machine if prescribed.servo else with_motors_that_follow_exactly(machine, prescribed)
    held = held_machine(followed, base)
    motion = EquationsOfMotion(held, values)
    view = None if motion.given.moving == machine.moving else MotorView(machine, motion.given)
    at = _positions(machine, prescribed, record)
    if view:
        at = view.positions(at) | _positions(machine, replace(prescribed, start={}), record)
    at = {name: x for name, x in at.items() if name in motion.names}
    refuse_soft_static(held, at, values)
    start = equilibrium(motion, at)
    if view and record and not start.sought:
        _refuse_other_start(view, prescribed, start)
    reference = Reference(followed, prescribed, start, _gains(motion, prescribed, start), record, base)
    if view and followed is machine:
        reference = replace(reference, start=_viewed(view, start), view=view, viewed=start.q)
    _refuse_large(reference)
    return _in_motion(reference, motion, start)


def _refuse_other_start(view: MotorView, prescribed: PrescribedMotion, start: State) -> None:
    """Raise `InputError` where the positions that are given are not those where the record of the motors begins."""
    q = view.own(start.q[None], start.qd[None], start.qdd[None])[0, 0]
    for joint, x in zip(view.machine.moving_joints, q.tolist(), strict=True):
        given = prescribed.start.get(joint.name, x)
        if abs(given - x) > SAME * max(1.0, abs(x)):
            what = f"{given:g} is not where {prescribed.file} puts it, {x:g}: leave it out"
            raise prescribed.error(f"start, {joint.name}", what)


def _viewed(view: MotorView, start: State) -> State:
    """Return a state at rest in the machine's own coordinates."""
    ((q,), qd, qdd) = view.own(start.q[None], start.qd[None], start.qdd[None])
    return replace(start, q=q, qd=qd[0], qdd=qdd[0], tau=view.forces(q, start.torques))


def _in_motion(reference: Reference, motion: EquationsOfMotion, start: State) -> Reference:
    """Return the reference with the motors at the velocities that their motion begins with."""
    qd = np.zeros_like(start.qd)
    entries, columns = independent_motors(motion.given)
    qd[entries] = reference.at(np.zeros(1))[1][0, columns]
    if reference.view:
        qd = reference.view.own(start.q[None], qd[None], start.qdd[None])[1][0]
    return replace(reference, start=replace(reference.start, qd=qd))


def independent_motors(machine: Machine) -> tuple[list[int], list[int]]:
    """Return the entries in q of the motors that own some, and their places among all motors."""
    columns = [k for k, j in enumerate(machine.motors) if j in machine.moving]
    return list(machine.motor_entries), columns


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
    """Return kp and kd of the motors (m,).

    Raises `InputError` for a bandwidth of a motor that nothing moves with, or that moves with other motors alone.
    """
    if not prescribed.servo:
        return None
    servos = {name: prescribed.servo[name] for name in motion.motor_names}
    inertia = dict.fromkeys(servos, 0.0)
    if any(isinstance(servo, Bandwidth) for servo in servos.values()):
        zero = np.zeros_like(start.q)
        (A,) = motion.matrices(["M"], start.q, zero, zero)
        inertia |= {motion.names[k]: float(A[k, k]) for k in motion.motors}
    joined = {j for one, others in motion.followers.items() for j in (one, *others)}
    shared = {motion.machine.joint(j).name for j in joined}
    for name, servo in servos.items():
        if isinstance(servo, Bandwidth) and name in shared:
            raise prescribed.error(f"servo, {name}", "other motors move the same inertia: give kp and kd")
        if isinstance(servo, Bandwidth) and not inertia[name] > 0:
            raise prescribed.error(f"servo, {name}", "the motor moves no inertia: give kp and kd")
    kp, kd = np.array([_law(servo, inertia[name]) for name, servo in servos.items()]).T
    return kp, kd


def _law(servo: Servo, m: float) -> tuple[float, float]:
    """Return kp and kd; kp = m (2 pi f)^2, kd = 2 zeta m (2 pi f)."""
    if isinstance(servo, Gains):
        return servo.kp, servo.kd
    omega = 2 * np.pi * servo.frequency
    return m * omega**2, 2 * servo.damping * m * omega
