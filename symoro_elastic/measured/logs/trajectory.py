"""An exciting motion as a trajectory for a controller: from rest, some periods, to rest, evenly sampled."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.writing import write_columns
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import MOST_IN_FILES, MOST_SAMPLES, NO_RANGE, InputError, refuse_numbers
from symoro_elastic.foundation.output_files import permission
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine import described
from symoro_elastic.machine import limits as of_joints
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import no_such
from symoro_elastic.measured.logs.excitation import Excitation
from symoro_elastic.measured.logs.fourier_motion import Limits, Started

POSITION_OPTION = "--position"
LEAST_SAMPLES = 20  # in a period of the fastest harmonic


@dataclass(frozen=True)
class Trajectory:
    """Evenly sampled motion of the motors: t (N) s, q, qd, qdd (N, m) rad or m; `start` is its run-up, s."""

    t: Array
    q: Array
    qd: Array
    qdd: Array
    start: float


def limits_of(machine: Machine, options: Mapping[str, Mapping[str, tuple[float, float]]]) -> Limits:
    """Return limits of each motor from ranges by option and name of motor or variable; "" is all others.

    What no option gives is taken from the limits of the machine. Raises `InputError` for a motor without limits, or a
    name that is not a motor's.
    """
    motors, names, own = machine.motor_joints, machine.motors_by_name, described.limits_of(machine)
    ranges: dict[str, list[tuple[float, float]]] = {}
    for option, by_name in options.items():
        for name in by_name:
            if name and name not in names:
                raise InputError("symoro-elastic", option, no_such("motor", name, names))
        limits = {names[name]: limit for name, limit in by_name.items() if name}
        _refuse_without_room(option, by_name)
        quantity = option.removeprefix("--")
        if "" not in by_name:
            limits = _of_machine(own, quantity) | limits
        missing = [joint.name for joint in motors if joint.name not in limits and "" not in by_name]
        if missing:
            what = f"no limit for {', '.join(missing)}: give one for all, or {missing[0]}=..."
            raise InputError("symoro-elastic", option, f"{what}, or {quantity} in [limits] of the machine")
        ranges[option] = [limits[joint.name] if joint.name in limits else by_name[""] for joint in motors]
    position, velocity, acceleration = ranges.values()
    low, high = zip(*position, strict=True) if position else ((), ())
    limits_of_motors = Limits.of(low, high, [v for _, v in velocity], [a for _, a in acceleration])
    torque = tuple(own.of(joint.name).torque for joint in motors)
    for joint, allowed in zip(motors, torque, strict=True):
        if allowed is not None and not allowed.low < allowed.high:
            raise machine.error(f"limits, {joint.name}, torque", "there is no room in it for a motion")
    return replace(limits_of_motors, torque=torque) if any(torque) else limits_of_motors


def _of_machine(limits: of_joints.Limits, quantity: str) -> dict[str, tuple[float, float]]:
    """Return the limits of a quantity by joint; of rates, the smaller of both directions, symmetric."""
    by_joint = {name: getattr(limit, quantity) for name, limit in limits.joints.items()}
    ranges = {name: limit for name, limit in by_joint.items() if limit is not None}
    if quantity == of_joints.LIMITED[0]:
        return {name: (limit.low, limit.high) for name, limit in ranges.items()}
    either_way = {name: min(-limit.low, limit.high) for name, limit in ranges.items()}
    return {name: (-x, x) for name, x in either_way.items()}


def _refuse_without_room(option: str, by_name: Mapping[str, tuple[float, float]]) -> None:
    for name, (low, high) in by_name.items():
        if not (low < high and math.isfinite(high - low)):
            raise InputError("symoro-elastic", option, f"{name or 'all'}={NO_RANGE.format(low, high)}")
        if option != POSITION_OPTION and low != -high:
            raise InputError("symoro-elastic", option, f"{name or 'all'}: one number, the largest either way")


def trajectory(motion: Started, rate: float) -> Trajectory:
    """Return the motion from rest to rest, sampled at `rate` Hz; raises `InputError`."""
    refuse_rate(rate, motion.motion.frequency, motion.motion.a.shape[1], motion.periods, len(motion.motion.a))
    _refuse_long(motion.period, rate, len(motion.motion.a))
    t: Array = np.arange(int(np.floor(motion.period * rate * (1 + 1e-12))) + 1) / rate
    return Trajectory(t, *motion.at(t), motion.start)


def refuse_rate(rate: float, frequency: float, harmonics: int, periods: int, motors: int) -> None:
    """Raise `InputError` for a rate (Hz) too low for the fastest harmonic, or too high for the memory."""
    fastest = frequency * harmonics
    if rate < LEAST_SAMPLES * fastest:
        what = f"{rate:g} Hz is slow for harmonics up to {fastest:g} Hz: sample at {LEAST_SAMPLES * fastest:g} Hz"
        raise InputError("symoro-elastic", "--sample-rate", what)
    _refuse_long((periods + 2) / frequency, rate, motors)


def _refuse_long(seconds: float, rate: float, motors: int) -> None:
    """Raise `InputError` for a trajectory with more samples than a file may have."""
    samples, way_out = seconds * rate, "fewer periods, or a lower rate"
    if samples > MOST_SAMPLES:
        what = f"{rate:g} Hz makes {samples:.2g} samples, {MOST_SAMPLES:.0e} is the limit: {way_out}"
        raise InputError("symoro-elastic", "--sample-rate", what)
    what = f"{samples:.3g} samples of {motors} motors"
    refuse_numbers(int(samples) * (1 + 3 * motors), what, "symoro-elastic", "--sample-rate", way_out, MOST_IN_FILES)


@dataclass(frozen=True)
class MotorRange:
    """Ranges of a motor in a trajectory, its limits, and centre and coefficients of its series; SI units."""

    name: str
    position: tuple[float, float]
    position_limits: tuple[float, float]
    velocity: float
    velocity_limit: float
    acceleration: float
    acceleration_limit: float
    centre: float
    a: Array
    b: Array
    torque: tuple[float, float] | None = None
    torque_limits: tuple[float, float] | None = None


@dataclass(frozen=True, repr=False)
class ExcitingTrajectory(Result):
    """An exciting trajectory: the optimized Fourier series, its samples with start and stop, the limits it keeps."""

    machine: Machine
    best: Excitation
    sampled: Trajectory
    limits: Limits
    payloads: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def motors(self) -> tuple[MotorRange, ...]:
        """Range of each motor in the trajectory, with its limits."""
        q, qd, qdd = self.sampled.q, np.abs(self.sampled.qd), np.abs(self.sampled.qdd)
        limits, motion = self.limits, self.best.motion
        torque = limits.torque or (None,) * len(limits.low)
        return tuple(
            MotorRange(
                joint.name,
                (float(q[:, k].min()), float(q[:, k].max())),
                (float(limits.low[k]), float(limits.high[k])),
                float(qd[:, k].max()),
                float(limits.velocity[k]),
                float(qdd[:, k].max()),
                float(limits.acceleration[k]),
                float(motion.centre[k]),
                motion.a[k],
                motion.b[k],
                self.best.torques[k] if self.best.torques else None,
                (allowed.low, allowed.high) if (allowed := torque[k]) else None,
            )
            for k, joint in enumerate(self.machine.motor_joints)
        )

    @property
    def headline(self) -> str:
        """Machine, duration, condition number."""
        condition = f"condition {self.best.condition:.4g}"
        return f"Exciting trajectory of {self.machine.name}: {self.sampled.t[-1]:g} s, {condition}"

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write t, q_<motor>, qd_, qdd_ to a .csv or .npz file, and return its path; raises `InputError`."""
        with permission(force=force):
            self.save(path)
        return Path(path)

    def save(self, path: str | Path) -> None:
        """Write the file of `write`, replacing an existing file if permitted; raises `InputError`."""
        units = {"t": "s"}
        for quantity, per in (("q", ""), ("qd", "/s"), ("qdd", "/s2")):
            units |= {f"{quantity}_{joint.name}": joint.unit + per for joint in self.machine.motor_joints}
        write_columns(self.arrays(), path, units)
