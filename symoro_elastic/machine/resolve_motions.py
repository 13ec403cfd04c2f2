"""Resolution of the names in a motion, and refusal of numbers that no motion has."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from operator import mul
from typing import TypeVar

from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.prescribed_motion import (
    WRENCH,
    AppliedForce,
    BaseStart,
    Gains,
    Move,
    PrescribedMotion,
    Servo,
    Wobble,
)
from symoro_elastic.machine.resolve import joints_by_any_name

LARGEST = 1e9
"""Of a position, a stroke or a force that is given, SI units."""
ROUNDED = 1e-12
"""Of a duration: sums of times are rounded."""
NOT_TURNED = 1e-3
"""Of the numbers of a rotation: written with few digits they are still read as one."""
PERIODS = 2
"""Of a wobble: one to fade in, one to fade out."""
Fault = tuple[str, str]
"""The key of a number, and what is wrong with it."""
T = TypeVar("T")
MovingT = TypeVar("MovingT", Move, Wobble)


def resolve_motion(motion: PrescribedMotion, machine: Machine) -> PrescribedMotion:
    """The motion with joints by their names, which may be written as variables or numbers of the table too.

    Raises `InputError`, with its place in the file, for unknown names and for numbers that no motion has.
    """
    names = _Names(machine, motion)
    resolved = replace(
        motion,
        start=names.starts(motion.start),
        moves=names.moved(motion.moves, "moves"),
        wobbles=names.moved(motion.wobbles, "wobbles"),
        servo=names.servos(motion.servo),
        forces=tuple(replace(x, at=names.frame(x.at, f"forces {k}, at")) for k, x in enumerate(motion.forces, 1)),
    )
    if motion.base and machine.floating is None:
        raise motion.error("base", "the base of the machine is fixed: leave it out, or give floating in [base]")
    for key, what in _faults(resolved):
        raise motion.error(key, what)
    return resolved


class _Names:
    """Names of the joints of a machine, for a motion."""

    def __init__(self, machine: Machine, motion: PrescribedMotion) -> None:
        self.fail, self.known, self.machine = motion.error, joints_by_any_name(machine), machine
        self.independent = [joint.name for joint in machine.independent_joints]
        self.motors = [joint.name for joint in machine.motor_joints]
        self.cut = [joint.name for joint in machine.joints if joint.kind is Kind.CUT]

    def frame(self, name: str, key: str) -> str:
        """The joint that carries a frame."""
        names = FrameNames(self.machine, by_any_name=True)
        number = names.number(name)
        if number is None:
            raise self.fail(key, f"no joint {quote(name)}{did_you_mean(name, names.choices())}")
        joint = self.machine.joint(number).name
        if joint in self.cut:
            raise self.fail(key, f"{joint} is the cut joint of a loop: name the frame that it meets")
        return joint

    def starts(self, start: Mapping[str, float]) -> dict[str, float]:
        """Positions by joint."""
        named = {self._joint(name, "start", self.independent): x for name, x in start.items()}
        for joint in named:
            if joint not in self.independent:
                what = f"{joint} does not move by itself: independent joints are {', '.join(self.independent)}"
                raise self.fail("start", what)
        return self._distinct(named, start, "start")

    def servos(self, servo: Mapping[str, Servo]) -> dict[str, Servo]:
        """Servos by motor."""
        return self._distinct({self._motor(name, "servo"): x for name, x in servo.items()}, servo, "servo")

    def moved(self, moving: Sequence[MovingT], key: str) -> tuple[MovingT, ...]:
        """Moves or wobbles with the names of their motors."""
        return tuple(replace(x, motor=self._motor(x.motor, f"{key} {k}, motor")) for k, x in enumerate(moving, 1))

    def _motor(self, name: str, key: str) -> str:
        joint = self._joint(name, key, self.motors)
        if joint not in self.motors:
            raise self.fail(key, f"{joint} has no motor: motors are {', '.join(self.motors) or 'missing here'}")
        return joint

    def _joint(self, name: str, key: str, among: Sequence[str]) -> str:
        if name not in self.known:
            raise self.fail(key, f"no joint {quote(name)}{did_you_mean(name, among)}")
        return self.known[name]

    def _distinct(self, named: dict[str, T], given: Mapping[str, T], key: str) -> dict[str, T]:
        if len(named) < len(given):
            raise self.fail(key, "a joint is named twice, by two of its names")
        return named


def _faults(motion: PrescribedMotion) -> Iterator[Fault]:
    """What is wrong with the numbers of a motion."""
    if not motion.duration > 0:
        yield "duration", f"{motion.duration:g} s is not a duration: give a positive number"
    for name, x in motion.start.items():
        yield from _too_large(f"start, {name}", x)
    for k, move in enumerate(motion.moves, 1):
        yield from _too_large(f"moves {k} ({move.motor}), by", move.by)
        yield from _outside(f"moves {k} ({move.motor})", move, motion.duration)
    for k, wobble in enumerate(motion.wobbles, 1):
        yield from _of_wobble(f"wobbles {k} ({wobble.motor})", wobble, motion.duration)
    for name, servo in motion.servo.items():
        yield from _of_servo(f"servo, {name}", servo)
    for k, force in enumerate(motion.forces, 1):
        if not any(force.wrench):
            yield f"forces {k} ({force.at})", f"it has no component: give {', '.join(WRENCH)}, or leave it out"
        yield from (fault for x in force.wrench for fault in _too_large(f"forces {k} ({force.at})", x))
        yield from _outside(f"forces {k} ({force.at})", force, motion.duration)
    yield from _of_base(motion.base or BaseStart())


def _of_base(base: BaseStart) -> Iterator[Fault]:
    for field in fields(base):
        yield from (fault for x in getattr(base, field.name) for fault in _too_large(f"base, {field.name}", x))
    if len(base.orientation) == 4:
        length = math.hypot(*base.orientation)
        if not abs(length - 1) <= NOT_TURNED:
            yield "base, orientation", f"the length of the quaternion is {length:.4g}: make it 1"
        return
    rows = [base.orientation[k : k + 3] for k in (0, 3, 6)]
    worst = max(abs(sum(map(mul, a, b)) - (a is b)) for a in rows for b in rows)
    a, b, c = rows
    volume = sum(a[k] * (b[k - 2] * c[k - 1] - b[k - 1] * c[k - 2]) for k in range(3))
    if not (worst <= NOT_TURNED and volume > 0):
        yield "base, orientation", "this is not a rotation: give a right-handed orthogonal matrix, row by row"


def _too_large(key: str, x: float) -> Iterator[Fault]:
    if not abs(x) <= LARGEST:
        yield key, f"{x:g} is out of range: give a number up to {LARGEST:g}"


def _outside(key: str, x: Move | AppliedForce, duration: float) -> Iterator[Fault]:
    """What takes no time, or does not lie within the duration."""
    if not x.lasts > 0:
        yield f"{key}, in", f"{x.lasts:g} s is not a duration: give a positive number"
    if x.begins < 0:
        yield f"{key}, from", f"{x.begins:g} s is before the motion, which begins at 0"
    if x.begins + x.lasts > duration * (1 + ROUNDED):
        what = f"it ends at {x.begins + x.lasts:g} s, the motion at {duration:g} s: move it, or give a longer duration"
        yield f"{key}, in", what


def _of_wobble(key: str, wobble: Wobble, duration: float) -> Iterator[Fault]:
    yield from _too_large(f"{key}, amplitude", wobble.amplitude)
    if not wobble.frequency > 0:
        yield f"{key}, frequency", f"{wobble.frequency:g} Hz is not a frequency: give a positive number"
    elif wobble.frequency * duration < PERIODS * (1 - ROUNDED):
        what = f"{wobble.frequency:g} Hz has {wobble.frequency * duration:.3g} periods in {duration:g} s"
        yield f"{key}, frequency", f"{what}, it needs {PERIODS} to fade in and out: give a longer duration"


def _of_servo(key: str, servo: Servo) -> Iterator[Fault]:
    if isinstance(servo, Gains):
        for name, x in (("kp", servo.kp), ("kd", servo.kd)):
            if not x >= 0:
                yield f"{key}, {name}", f"{x:g} is negative: such a servo destabilizes the motor"
        return
    if not servo.frequency > 0:
        yield f"{key}, bandwidth", f"{servo.frequency:g} Hz is not a bandwidth: give a positive number"
    if not servo.damping >= 0:
        yield f"{key}, damping", f"{servo.damping:g} is negative: negative damping makes the servo unstable"


def refuse_unfulfillable(wanted: Wanted) -> None:
    """Raise `InputError` for numbers that nothing can fulfil."""
    for key, what in _of_wanted(wanted):
        raise wanted.error(key, what)


def _of_wanted(wanted: Wanted) -> Iterator[Fault]:
    tolerance = wanted.tolerance
    by_signal = tolerance if isinstance(tolerance, dict) else {} if tolerance is None else {"": tolerance}
    for signal, x in by_signal.items():
        if not x > 0:
            yield f"tolerance, {signal}".removesuffix(", "), f"{x:g} is not a tolerance: give a positive number"
    for key, time in (("period", wanted.period), ("time", wanted.time)):
        if time is not None and not time > 0:
            yield key, f"{time:g} s is not a duration: give a positive number"
    if wanted.time is not None and wanted.period is None:
        yield "time", "it is that of the steps of a period: give period too"
    if wanted.time is not None and wanted.period is not None and wanted.time > wanted.period:
        yield "time", f"{wanted.time:g} s is more than the period of {wanted.period:g} s: no controller keeps up"
