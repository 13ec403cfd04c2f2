"""Resolution of the names in a scene."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import TypeVar

import numpy as np

from symoro_elastic.foundation.errors import TWICE, InputError, refusing
from symoro_elastic.machine.arguments import column_names
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import FrameNames, row_under
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import did_you_mean, no_such, quote, undeclared
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
from symoro_elastic.machine.restrict import refuse_locking
from symoro_elastic.machine.scene import Offer, Parts, RequestedPart, Scene
from symoro_elastic.machine.static_springs import Positions, without_spring
from symoro_elastic.machine.zeroed import refuse_unknown
from symoro_elastic.quantities.time_steps import TimeStep

Position = TypeVar("Position", bound=Formula | None)
Models = Mapping[str, Offer]
"""The models that there are, by name."""
LARGEST = 1e9
"""Of a position, a stroke or a force that is given, SI units."""
ROUNDED = 1e-12
"""Of a duration: sums of times are rounded."""
SAME_JOINT = "a joint is given twice, by two of its names: keep one"
NOT_TURNED = 1e-3
"""Of the numbers of a rotation: written with few digits they are still read as one."""
PERIODS = 2
"""Of a wobble: one to fade in, one to fade out."""
Fault = tuple[str, str]
"""The key of a number, and what is wrong with it."""
T = TypeVar("T")
MovingT = TypeVar("MovingT", Move, Wobble)


def resolve(scene: Scene, machine: Machine, models: Models | None = None, source: str = "") -> Scene:
    """The scene with joints by their names; raises `InputError` for unknown names.

    A joint may be called by its name, its variable or its number in the table. Without `models`, names of models and
    requests of them are unchanged.
    """
    source = source or scene.source or machine.label
    joints = joints_by_any_name(machine)
    if models is not None:
        for model in (*scene.models, *scene.outputs):
            _checked_name(model, models, "model", source, "models" if model in scene.models else "outputs")
    for name in () if isinstance(scene.fold, str) else scene.fold:
        _checked_name(name, [parameter.name for parameter in machine.parameters], "parameter", source, "fold")
    outputs = {
        model: tuple(_output(text, model, machine, source, models) for text in texts)
        for model, texts in scene.outputs.items()
    }
    if models is not None:
        _check_offered(scene.outputs, machine, models, source)
    locked = _by_name(scene.locked, joints, source, "locked")
    static = _by_name(scene.static, joints, source, "static")
    _check_locked(locked, machine, source)
    _check_static(static, locked, machine, source)
    refuse_unknown(machine, scene.zero, source)
    forces = _frames(scene.forces, machine, source)
    for name in scene.steps:
        _checked_name(name, list(TimeStep), "time step", source, "steps")
        if scene.steps.count(name) > 1:
            raise InputError(source, "scene, steps", f"{name} {TWICE}")
    return replace(scene, outputs=outputs, locked=locked, static=static, forces=forces, source=source)


def _frames(texts: Iterable[str], machine: Machine, source: str) -> tuple[str, ...]:
    """Frames, and points of them, on which wrenches act, by names of the machine."""
    frames = [_frame(text, machine, source) for text in texts]
    for text in frames:
        if frames.count(text) > 1:
            raise InputError(source, "scene, forces", f"{text} {TWICE}")
    return tuple(frames)


def _frame(text: str, machine: Machine, source: str) -> str:
    with refusing(source, "scene, forces", f"{quote(text)}: "):
        part = RequestedPart.parse(text)
    if part.seen_from or part.by or part.component:
        what = f"{quote(text)}: wrenches are in axes of frame 0: name a frame, or a point as 'tool at (0.1, 0, 0)'"
        raise InputError(source, "scene, forces", what)
    number = _number(part.name, machine, "frame", source, "forces")
    if reason := _why_not_loaded(machine, number):
        raise InputError(source, "scene, forces", reason)
    for coordinate in part.at or ():
        _check_value(coordinate, machine, source, "forces")
    return str(RequestedPart(FrameNames(machine).name(number), part.at))


def _why_not_loaded(machine: Machine, number: int) -> str:
    """Return why no force can act on a frame; empty for a frame that a body carries."""
    name = FrameNames(machine).name(number)
    if row_under(machine, number) == 0:
        return f"{name} is fixed to frame 0, where a force moves nothing"
    return _why_cut(machine, {number})


def _why_cut(machine: Machine, numbers: Collection[int | None]) -> str:
    """Return which of some frames is that of a cut joint, and the one to name instead; empty for none."""
    for loop in machine.loops:
        if loop.cut in numbers:
            cut, meets = map(FrameNames(machine).name, (loop.cut, loop.meets))
            return f"{cut} is the cut joint of loop {loop.name}: name the frame that it meets, {meets}"
    return ""


def _by_name(
    positions: Mapping[str, Position], joints: Mapping[str, str], source: str, key: str
) -> dict[str, Position]:
    """Positions by the names of joints, which may be called by their variables or numbers."""
    by_name = {joints[_checked_name(name, joints, "joint", source, key)]: value for name, value in positions.items()}
    if len(by_name) < len(positions) and any(positions.values()):
        raise InputError(source, f"scene, {key}", SAME_JOINT)
    return by_name


def _output(text: str, model: str, machine: Machine, source: str, models: Models | None) -> str:
    """A requested joint or frame in the form that `RequestedPart.parse` reads, with names of the machine."""
    part, key = _requested_part(text, model, source), f"outputs, {model}"
    if part.by and not part.name:
        return str(part)
    if models is not None and models[model].parts is Parts.JOINTS:
        row = _row(part.name, machine, source, key)
        return str(replace(part, name=machine.joint(row).name))
    names = FrameNames(machine)
    number = _number(part.name, machine, "frame", source, key, or_frame_0=part.seen_from is not None)
    for coordinate in part.at or ():
        _check_value(coordinate, machine, source, key)
    if part.seen_from is None:
        of_joint = machine.joint(number).name if number <= len(machine.joints) else ""
        return str(replace(part, name=of_joint if names.number(of_joint) == number else names.name(number)))
    place = _number(part.seen_from, machine, "frame", source, key, or_frame_0=True)
    return str(replace(part, name=names.name(number), seen_from=names.name(place)))


def _row(text: str, machine: Machine, source: str, key: str) -> int:
    """The number of a joint by any of its names."""
    names = FrameNames(machine, by_any_name=True)
    row = names.row(text)
    if row is None:
        raise _unknown(text, names.rows, "joint", source, key)
    return row


def _number(text: str, machine: Machine, what: str, source: str, key: str, or_frame_0: bool = False) -> int:
    """The number of a frame by any of its names."""
    names = FrameNames(machine, by_any_name=True)
    number = names.number(text, or_frame_0)
    if number is None:
        raise _unknown(text, names.choices(or_frame_0), what, source, key)
    if reason := machine.no_frame_of_mode(number):
        raise InputError(source, f"scene, {key}", f"{quote(text)}: {reason}")
    return number


def _check_offered(outputs: Mapping[str, Iterable[str]], machine: Machine, models: Models, source: str) -> None:
    """Refuse parts and columns that a model does not have."""
    of_frames = (Parts.FRAMES, Parts.POINTS, Parts.COMPONENTS)
    with_viewpoint = [name for name, offer in models.items() if offer.parts in of_frames]
    at_points = [name for name, offer in models.items() if offer.parts in (Parts.POINTS, Parts.COMPONENTS)]
    by_component = [name for name, offer in models.items() if offer.parts is Parts.COMPONENTS]
    differentiated = [name for name, offer in models.items() if offer.columns]
    for model, texts in outputs.items():
        for text in texts:
            part = _requested_part(text, model, source)
            if models[model].parts is not Parts.JOINTS:
                _check_not_cut(part, model, machine, source)
            for is_asked, offering, how in (
                (part.seen_from is not None, with_viewpoint, "as seen from a frame"),
                (part.at is not None, at_points, "at a point"),
                (bool(part.by), differentiated, "by names of columns"),
                (bool(part.component), by_component, "by components of twists"),
            ):
                if is_asked and model not in offering:
                    what = f"{quote(text)}: only {', '.join(offering)} can be requested {how}"
                    raise InputError(source, f"scene, outputs, {model}", what)
            if models[model].parts is Parts.WHOLE:
                what = "it has no parts for joints or frames: leave it out"
                raise InputError(source, f"scene, outputs, {model}", what)
            for name in part.by:
                _check_column(name, model, machine, models, source)


def _check_not_cut(part: RequestedPart, model: str, machine: Machine, source: str) -> None:
    """Refuse the frame of a cut joint, which is that of the row that it meets."""
    names, or_frame_0 = FrameNames(machine, by_any_name=True), part.seen_from is not None
    named = {names.number(text, or_frame_0) for text in (part.name, part.seen_from) if text}
    if reason := _why_cut(machine, named):
        raise InputError(source, f"scene, outputs, {model}", reason)


def _check_column(name: str, model: str, machine: Machine, models: Models, source: str) -> None:
    """Refuse a column that a model of derivatives does not have."""
    columns = {other: column_names(machine, offer.columns) for other, offer in models.items()}
    if name in columns[model]:
        return
    elsewhere = [other for other, names in columns.items() if name in names]
    way_out = f": it is a column of {', '.join(elsewhere)}" if elsewhere else did_you_mean(name, columns[model])
    raise InputError(source, f"scene, outputs, {model}", f"no column {quote(name)}{way_out}")


def _requested_part(text: str, model: str, source: str) -> RequestedPart:
    with refusing(source, f"scene, outputs, {model}", f"{quote(text)}: "):
        return RequestedPart.parse(text)


def coordinates(scene: Scene, source: str) -> Iterator[Formula]:
    """The formulas of all points that a scene asks for; raises `InputError` for one that cannot be read."""
    for model, texts in scene.outputs.items():
        for text in texts:
            yield from _requested_part(text, model, source).at or ()


def joints_by_any_name(machine: Machine) -> dict[str, str]:
    """Names of joints by every text that denotes one: name, variable or number; a name precedes a variable."""
    return {text: machine.joint(j).name for text, j in FrameNames(machine, by_any_name=True).joints.items()}


def _checked_name(name: str, choices: Iterable[str], what: str, source: str, key: str) -> str:
    choices = tuple(choices)
    if name not in choices:
        raise _unknown(name, [word for word in choices if not word.isdecimal()], what, source, key)
    return name


def _unknown(name: str, choices: Iterable[str], what: str, source: str, key: str) -> InputError:
    listed = "symoro-elastic models" if what == "model" else "symoro-elastic show"
    way_out = did_you_mean(name, choices) or f"; {listed} lists them"
    return InputError(source, f"scene, {key}", f"no {what} {quote(name)}{way_out}")


def _check_locked(locked: dict[str, Formula], machine: Machine, source: str) -> None:
    refuse_locking(machine, locked, source)
    for joint, value in locked.items():
        _check_value(value, machine, source, f"locked, {joint}")


def _check_static(static: Positions, locked: Mapping[str, Formula], machine: Machine, source: str) -> None:
    """Refuse static joints without a spring, and those that are locked."""
    rows = {joint.name: joint for joint in machine.joints}
    for name, value in static.items():
        reason = without_spring(machine, rows[name])
        if reason or name in locked:
            raise InputError(source, f"scene, static, {name}", reason or "it is locked too: remove one of the two")
        if value is not None:
            _check_value(value, machine, source, f"static, {name}")


def _check_value(value: Formula, machine: Machine, source: str, key: str) -> None:
    for name in sorted(value.names - machine.parameter_names):
        raise InputError(source, f"scene, {key}", undeclared(name, machine.parameter_names))
    if not value.names:
        with refusing(source, f"scene, {key}"):
            value.table_value()


def resolve_motion(motion: PrescribedMotion, machine: Machine) -> PrescribedMotion:
    """The motion with joints by their names, which may be written as variables or numbers of the table too.

    Raises `InputError`, with its place in the file, for unknown names and for numbers that no motion has.
    """
    names = _Names(machine, motion)
    resolved = replace(
        motion,
        start=names.starts(motion.start),
        moves=names.with_motors(motion.moves, "moves"),
        wobbles=names.with_motors(motion.wobbles, "wobbles"),
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

    def frame(self, name: str, key: str) -> str:
        """The name of a frame that a body carries."""
        names = FrameNames(self.machine, by_any_name=True)
        number = names.number(name)
        if number is None:
            raise self.fail(key, no_such("frame", name, names.choices()))
        frame = names.name(number)
        if reason := self.machine.no_frame_of_mode(number):
            raise self.fail(key, f"{frame}: {reason}")
        if reason := _why_not_loaded(self.machine, number):
            raise self.fail(key, reason)
        return frame

    def starts(self, start: Mapping[str, float]) -> dict[str, float]:
        """Start positions by joint."""
        named = {self._joint(name, "start", self.independent): x for name, x in start.items()}
        for joint in named:
            if joint not in self.independent:
                raise self.fail("start", self.machine.why_dependent(joint))
        return self._distinct(named, start, "start")

    def servos(self, servo: Mapping[str, Servo]) -> dict[str, Servo]:
        """Servos by motor."""
        return self._distinct({self._motor(name, "servo"): x for name, x in servo.items()}, servo, "servo")

    def with_motors(self, moving: Sequence[MovingT], key: str) -> tuple[MovingT, ...]:
        """Return moves or wobbles with their motors' names."""
        return tuple(replace(x, motor=self._motor(x.motor, f"{key} {k}, motor")) for k, x in enumerate(moving, 1))

    def _motor(self, name: str, key: str) -> str:
        joint = self._joint(name, key, self.motors)
        if joint not in self.motors:
            raise self.fail(key, self.machine.why_no_motor(joint))
        return joint

    def _joint(self, name: str, key: str, among: Sequence[str]) -> str:
        if name not in self.known:
            raise self.fail(key, no_such("joint", name, among))
        return self.known[name]

    def _distinct(self, named: dict[str, T], written: Mapping[str, T], key: str) -> dict[str, T]:
        if len(named) < len(written):
            raise self.fail(key, SAME_JOINT)
        return named


def _faults(motion: PrescribedMotion) -> Iterator[Fault]:
    """Faults of the numbers of a motion."""
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
    R = np.reshape(base.orientation, (3, 3))
    if not (np.abs(R @ R.T - np.eye(3)).max() <= NOT_TURNED and np.linalg.det(R) > 0):
        yield "base, orientation", "this is not a rotation: give a right-handed orthogonal matrix, row by row"


def _too_large(key: str, x: float) -> Iterator[Fault]:
    if not abs(x) <= LARGEST:
        yield key, f"{x:g} is out of range: give a number up to {LARGEST:g}"


def _outside(key: str, x: Move | AppliedForce, duration: float) -> Iterator[Fault]:
    """Faults of durations: zero, or beyond that of the motion."""
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
    """Raise `InputError` for requirements that no model can meet."""
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
