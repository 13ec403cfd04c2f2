"""Drives of a machine: the cascade of controllers at each motor, between its set point and its torque.

    e     = Kv (r - q_m) + kfv rd - qd_m                               position controller
    tau_u = Kp (e + (1/Tn) int e dt) + kfa J rdd + tau_ff              velocity controller, inverse model
    tau   = e^(-s Td) hold(s) / (1 + lag s) sat(filters(s) tau_u)      limit, dead time, sampling, current loop

r is the set point behind its own filter. At the limit of the torque the integral part gives way (back-calculation):

    xi'   = e + (tau_lim - filters tau_u) Tn/(Kp Tt)

They are separate from mechanics, as limits are: models do not depend on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Joint, Machine, Vector3

ONE = Formula.parse(1)
MOTOR = "motor"
"""Stands for the encoder of the motor itself."""


class Sought(Enum):
    """The word in place of a gain that tuning is to compute."""

    TUNED = "tuned"

    def __str__(self) -> str:
        return self.value


TUNED = Sought.TUNED
NO_NUMBER = f'"{TUNED}", which is no number: symoro-elastic tune MACHINE --save FILE writes values'
"""The end of a message about a gain, "... is ", where it needs a value."""
SAME = 1e-9
"""Relative deviation of a dead time from a period that counts as rounding."""
Gain = Formula | Sought


@dataclass(frozen=True)
class Notch:
    """(s^2 + 2 depth w s + w^2) / (s^2 + 2 width w s + w^2), with w = 2 pi times the frequency in Hz."""

    frequency: Formula
    depth: Formula
    width: Formula


@dataclass(frozen=True)
class LowPass:
    """w/(s + w), or w^2/(s^2 + sqrt(2) w s + w^2) of order 2, with w = 2 pi times the frequency in Hz."""

    frequency: Formula
    order: int = 1


@dataclass(frozen=True)
class Average:
    """The mean of the samples of a set point over a `time`, s, the latest among them; of sampled controllers."""

    time: Formula


Filter = Notch | LowPass
SetPointFilter = LowPass | Average


@dataclass(frozen=True)
class CurrentControl:
    """u = kp (i_w - i + (1/ti) int (i_w - i) dt) + compensation Ke w: `kp` V/A, `ti` s, w the rotor's velocity."""

    kp: Formula
    ti: Formula
    compensation: Formula = ZERO


@dataclass(frozen=True)
class Drive:
    """The cascade of a motor; gains belong to the variable of its joint, not to the axis of its rotor.

    `Kv` 1/s, `Kp` N m s/rad or N s/m, `Tn` s (None: no integral part), `lag` s of the current loop, `dead_time` s
    (None: a period where there is one), `period` s of a sampled controller. `measured` is the signal of the position
    that is controlled, `MOTOR` for the encoder of the motor; its velocity is always that of the motor. `torque_limit`
    N m or N (None: no limit) with the time `windup` s in which the integral part gives way there (None: Tn).
    `set_point` filters the set point of the position. With `torque_forward` the torque that the machine needs for the
    set points of all motors, with its springs as they are at the start, is fed forward. `current` is the controller of
    the current, in place of the `lag`; `current_limit` A and `voltage_limit` V belong to it.
    """

    Kv: Gain
    Kp: Gain
    Tn: Gain | None = None
    lag: Formula = ZERO
    velocity_forward: Formula = ONE
    acceleration_forward: Formula = ZERO
    torque_forward: bool = False
    filters: tuple[Filter, ...] = ()
    measured: str = MOTOR
    dead_time: Formula | None = None
    period: Formula | None = None
    torque_limit: Formula | None = None
    windup: Formula | None = None
    set_point: SetPointFilter | None = None
    current: CurrentControl | None = None
    current_limit: Formula | None = None
    voltage_limit: Formula | None = None

    @property
    def power_stage(self) -> Drive:
        """The power stage of a sampled drive at constant torque: its lag, or its winding with the controller."""
        nothing, limit = Drive(ZERO, ZERO, velocity_forward=ZERO), self.voltage_limit
        return replace(nothing, lag=self.lag, current=self.current, voltage_limit=limit)

    @property
    def formulas(self) -> Iterator[tuple[str, Formula]]:
        """Formulas of the drive, by their keys in a file."""
        gains = (("Kv", self.Kv), ("Kp", self.Kp), ("Tn", self.Tn))
        yield from ((key, gain) for key, gain in gains if isinstance(gain, Formula))
        yield "current, lag", self.lag
        if self.current:
            yield from ((f"current, {key}", getattr(self.current, key)) for key in ("kp", "ti", "compensation"))
        yield "feed_forward, velocity", self.velocity_forward
        yield "feed_forward, acceleration", self.acceleration_forward
        for k, stage in enumerate(self.filters, start=1):
            of_filter = ("frequency", "depth", "width") if isinstance(stage, Notch) else ("frequency",)
            yield from ((f"filter {k}, {key}", getattr(stage, key)) for key in of_filter)
        timed = (("dead_time", self.dead_time), ("period", self.period))
        limits = (("limits, torque", self.torque_limit), ("limits, windup", self.windup))
        electric = (("limits, current", self.current_limit), ("limits, voltage", self.voltage_limit))
        yield from ((key, x) for key, x in (*timed, *limits, *electric) if x is not None)
        if isinstance(self.set_point, LowPass):
            yield "set_point, frequency", self.set_point.frequency
        elif self.set_point:
            yield "set_point, average", self.set_point.time


@dataclass(frozen=True)
class LoadPosition:
    """The load position that a drive controls instead of its motor's: motor + (s - start)/ratio.

    s is that of the joint `number`, or of the frame `number`, at the point `at` of its body, along an `axis` (0, 1, 2)
    of frame 0; `start` and `motor` are s and the position of the motor at the start.
    """

    number: int
    axis: int | None
    at: Vector3 | None
    start: float
    ratio: float
    motor: float


@dataclass(frozen=True)
class Drives:
    """Drives by the names of their motors' joints; `loads` are positions that only a motion knows."""

    by_motor: Mapping[str, Drive] = field(default_factory=dict)
    loads: Mapping[str, LoadPosition] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Whether there is any drive."""
        return bool(self.by_motor)


def within_motors(drives: Drives, machine: Machine) -> Drives:
    """Return the drives of the motors that are still in a machine."""
    names = {joint.name for joint in machine.motor_joints}
    return Drives({name: drive for name, drive in drives.by_motor.items() if name in names}, drives.loads)


def gain_unit(key: str, joint: Joint) -> str:
    """Return the unit of a gain, "Kv", "Kp" or "Tn", of the drive of a joint."""
    slides = joint.sigma == 1
    return {"Kv": "1/s", "Kp": "N s/m" if slides else "N m s/rad", "Tn": "s"}[key]


def dead_time_within(period: float, dead: float, motor: str, source: str) -> float:
    """Return the dead time (s) of a sampled drive, at most its period; raises `InputError` for a longer one."""
    if dead > period * (1 + SAME):
        what = f"{dead:g} s is longer than the period, {period:g} s: give at most one period"
        raise InputError(source, f"drives, {motor}, dead_time", what)
    return period if dead > period * (1 - SAME) else dead


POSITIVE = (
    *("Kv", "Kp", "Tn", "period", "limits, torque", "limits, windup", "set_point, average"),
    *("current, kp", "current, ti", "limits, current", "limits, voltage"),
)
"""Keys whose numbers are above zero; frequencies and widths of filters, too. No other is negative."""


def why_wrong(key: str, x: float) -> str:
    """Return why x is impossible as the number under `key` of a drive; empty for a valid one."""
    if (key in POSITIVE or key.endswith(("frequency", "width"))) and not x > 0:
        return f"{x:g} is not above zero"
    if key == "current, compensation" and x > 1:
        return f"{x:g} is above one: it is the share of the back-EMF that is compensated"
    return f"{x:g} is negative" if x < 0 else ""


def fault_of(drive: Drive, joint: Joint) -> tuple[str, str]:
    """Return the key of a drive's first fault, and why, with the way out; ("", "") for a valid drive."""
    reason = why_no_current_loop(drive, joint) or why_not_fed(drive) or _why_idle(drive)
    key, _, what = reason.partition(": ")
    return key, what


def _why_idle(drive: Drive) -> str:
    """Return why an entry of a drive has no effect, or is invalid; empty otherwise."""
    if drive.windup is not None:
        for name, is_there in (("torque", drive.torque_limit or drive.current_limit), ("Tn", drive.Tn)):
            if is_there is None:
                return f"limits, windup: it belongs to {name}, which is missing: give {name}, or leave windup out"
    if isinstance(drive.set_point, Average) and drive.period is None:
        return "set_point, average: is a mean of samples: give the drive a period, or use lowpass"
    places = [(f"filter {k}", stage) for k, stage in enumerate(drive.filters, start=1)]
    for place, stage in (*places, ("set_point", drive.set_point)):
        if isinstance(stage, LowPass) and stage.order not in (1, 2):
            return f"{place}, order: {stage.order}: a low-pass filter is of order 1 or 2"
    return ""


def why_not_fed(drive: Drive) -> str:
    """Return why a drive cannot feed the inverse model forward, with the way out; empty where it can."""
    if not drive.torque_forward:
        return ""
    if drive.acceleration_forward != ZERO:
        return "feed_forward, acceleration: conflicts with torque = true, which has the inertia: remove one of the two"
    if drive.set_point:
        return "feed_forward, torque: is of the set point before its filter: leave set_point out, or torque"
    return ""


NEEDED = ("resistance", "inductance", "torque_constant")
"""Keys of the motor that a controller of its current needs."""


def why_no_current_loop(drive: Drive, joint: Joint) -> str:
    """Return why a drive can have no controller of the current, with the way out; empty where it can."""
    if drive.current is None:
        limits = (("current", drive.current_limit), ("voltage", drive.voltage_limit))
        key = next((key for key, x in limits if x is not None), "")
        return f"limits, {key}: belongs to a current loop with kp and ti: give them, or limits, torque" if key else ""
    missing = [key for key in NEEDED if getattr(joint.electrics, key).is_zero]
    if missing:
        what = f"give {', '.join(missing)} of {joint.name} below [motors], or current = {{ lag = 2e-4 }}"
        return f"current, kp: needs the winding of the motor: {what}"
    return ""
