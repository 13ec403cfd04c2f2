"""An exciting motion as a trajectory for a controller: from rest, some periods, to rest, evenly sampled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.identification.excitation import Excitation, FourierMotion, Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import did_you_mean
from symoro_elastic.sizes import MOST_IN_FILES, MOST_SAMPLES, refuse_numbers
from symoro_elastic.time_series.writing import columns_of, write_columns

POSITION_OPTION = "--position"
LEAST_SAMPLES = 20  # in a period of the fastest harmonic
LONGEST_START = 8  # periods
SLOWED = np.linspace(0.0, 1.0, 400)
ALLOWED = 1 + 1e-9  # of the limits


@dataclass(frozen=True)
class Trajectory:
    """Evenly sampled motion of the motors: t (N) s, q, qd, qdd (N, m) rad or m; `start` is its run-up, s."""

    t: Array
    q: Array
    qd: Array
    qdd: Array
    start: float


def refuse_without_motors(machine: Machine) -> None:
    """Raise `InputError` for a machine without motors."""
    if not machine.motors:
        raise machine.error(
            "joints", "no joint has a motor, so nothing can be excited: give one the kind motor (mu = 1)"
        )


def limits_of(machine: Machine, given: Mapping[str, Mapping[str, tuple[float, float]]]) -> Limits:
    """Return limits of each motor from ranges by option and name of motor or variable; "" is all others.

    Raises `InputError` for a motor without limits, or a name that is no motor's.
    """
    motors = machine.motor_joints
    known = {joint.name: joint.name for joint in motors} | {str(joint.variable): joint.name for joint in motors}
    ranges: dict[str, list[tuple[float, float]]] = {}
    for option, by_name in given.items():
        for name in by_name:
            if name and name not in known:
                raise InputError("symoro-elastic", option, f"no motor {name!r}{did_you_mean(name, known)}")
        limits = {known[name]: limit for name, limit in by_name.items() if name}
        _refuse_without_room(option, by_name)
        missing = [joint.name for joint in motors if joint.name not in limits and "" not in by_name]
        if missing:
            what = f"no limit for {', '.join(missing)}: give one for all, or {missing[0]}=..."
            raise InputError("symoro-elastic", option, what)
        ranges[option] = [limits[joint.name] if joint.name in limits else by_name[""] for joint in motors]
    position, velocity, acceleration = ranges.values()
    low, high = zip(*position, strict=True) if position else ((), ())
    return Limits.of(low, high, [v for _, v in velocity], [a for _, a in acceleration])


def _refuse_without_room(option: str, by_name: Mapping[str, tuple[float, float]]) -> None:
    for name, (low, high) in by_name.items():
        if not low < high:
            what = f"{name or 'all'}: no room between {low:g} and {high:g}"
            raise InputError("symoro-elastic", option, what)
        if option != POSITION_OPTION and low != -high:
            raise InputError("symoro-elastic", option, f"{name or 'all'}: one number, the largest either way")


def trajectory(motion: FourierMotion, limits: Limits, periods: int, rate: float) -> Trajectory:
    """Return the motion with its time started and stopped smoothly, sampled at `rate` Hz.

    The machine stays on the path of the motion. Positions and velocities keep the limits because no sample is
    faster than the motion; the start is made as long as accelerations need. Raises `InputError`.
    """
    refuse_rate(rate, motion.frequency, motion.a.shape[1], periods, len(motion.a))
    start = _start(motion, limits)
    end = 2 * start + periods * motion.period
    _refuse_long(end, rate, len(motion.a))
    t: Array = np.arange(int(np.floor(end * rate * (1 + 1e-12))) + 1) / rate
    pace = np.minimum(1.0, np.minimum(t, end - t) / start)
    elapsed = np.where(t < end / 2, _elapsed(pace, start), end - start - _elapsed(pace, start))
    elapsed = np.where(pace == 1.0, t - start / 2, elapsed)
    turning = np.where(t < end / 2, 1.0, -1.0) * 6 * pace * (1 - pace) / start
    return Trajectory(t, *_slowed(motion, elapsed, 3 * pace**2 - 2 * pace**3, turning), start)


def refuse_rate(rate: float, frequency: float, harmonics: int, periods: int, motors: int) -> None:
    """Raise `InputError` for a rate (Hz) too low for the fastest harmonic, or too high for the memory."""
    fastest = frequency * harmonics
    if rate < LEAST_SAMPLES * fastest:
        what = f"{rate:g} Hz is slow for harmonics up to {fastest:g} Hz: sample at {LEAST_SAMPLES * fastest:g} Hz"
        raise InputError("symoro-elastic", "--rate", what)
    _refuse_long((periods + 2) / frequency, rate, motors)


def _refuse_long(seconds: float, rate: float, motors: int) -> None:
    """Raise `InputError` for a trajectory that no file has room for."""
    samples, way_out = seconds * rate, "fewer periods, or a lower rate"
    if samples > MOST_SAMPLES:
        what = f"{rate:g} Hz makes {samples:.2g} samples, {MOST_SAMPLES:.0e} are the most: {way_out}"
        raise InputError("symoro-elastic", "--rate", what)
    what = f"{samples:.3g} samples of {motors} motors"
    refuse_numbers(int(samples) * (1 + 3 * motors), what, "symoro-elastic", "--rate", way_out, MOST_IN_FILES)


def _elapsed(pace: Array, start: float) -> Array:
    """Return the time of the motion after a part of the start: the integral of 3 x^2 - 2 x^3."""
    elapsed: Array = start * (pace**3 - pace**4 / 2)
    return elapsed


def _slowed(motion: FourierMotion, elapsed: Array, pace: Array, turning: Array) -> tuple[Array, Array, Array]:
    """Return q, qd, qdd for a pace of time and its rate of change."""
    q, qd, qdd = motion.at(elapsed)
    return q, qd * pace[:, None], qdd * pace[:, None] ** 2 + qd * turning[:, None]


def _start(motion: FourierMotion, limits: Limits) -> float:
    """Return the duration of the start, whole periods so that the motion ends where it began."""
    for periods in range(1, LONGEST_START + 1):
        start = periods * motion.period
        pace, turning = 3 * SLOWED**2 - 2 * SLOWED**3, 6 * SLOWED * (1 - SLOWED) / start
        both = [
            _slowed(motion, elapsed, pace, sign * turning)[2]
            for sign, elapsed in ((1, _elapsed(SLOWED, start)), (-1, -_elapsed(SLOWED, start)))
        ]
        if (np.abs(np.concatenate(both)) <= ALLOWED * limits.acceleration).all():
            break
    return start


def write(trajectory: Trajectory, machine: Machine, path: str | Path) -> None:
    """Write t, q_<motor>, qd_<motor>, qdd_<motor> as .csv, with units, or .npz; raises `InputError`."""
    units = {"t": "s"}
    for quantity, per in (("q", ""), ("qd", "/s"), ("qdd", "/s2")):
        units |= {f"{quantity}_{joint.name}": joint.unit + per for joint in machine.motor_joints}
    write_columns(columns(trajectory, machine), path, units)


def columns(trajectory: Trajectory, machine: Machine) -> dict[str, Array]:
    """Return t, q_<motor>, qd_<motor>, qdd_<motor>, a row a sample."""
    names = [joint.name for joint in machine.motor_joints]
    blocks = (("q", trajectory.q, names), ("qd", trajectory.qd, names), ("qdd", trajectory.qdd, names))
    return columns_of(trajectory.t, *blocks)


def figures(excitation: Excitation, sampled: Trajectory, limits: Limits, machine: Machine) -> dict[str, Any]:
    """Return condition numbers, and by motor the extremes with their limits and the coefficients of its series."""
    motion, motors = excitation.motion, {}
    for k, joint in enumerate(machine.motor_joints):
        q, qd, qdd = sampled.q[:, k], sampled.qd[:, k], sampled.qdd[:, k]
        motors[joint.name] = {
            "position": [float(q.min()), float(q.max())],
            "position_limits": [float(limits.low[k]), float(limits.high[k])],
            "velocity": float(np.abs(qd).max()),
            "velocity_limit": float(limits.velocity[k]),
            "acceleration": float(np.abs(qdd).max()),
            "acceleration_limit": float(limits.acceleration[k]),
            "centre": float(motion.centre[k]),
            "a": motion.a[k].tolist(),
            "b": motion.b[k].tolist(),
        }
    return {
        "condition_before": excitation.before,
        "condition": excitation.condition,
        "parameters": list(excitation.columns),
        "frequency": motion.frequency,
        "duration": float(sampled.t[-1]),
        "start": sampled.start,
        "samples": len(sampled.t),
        "motors": motors,
    }


def table(reached: Mapping[str, Any]) -> Any:
    """Return a table of the extremes of each motor and their limits, from `figures`."""
    from rich.table import Table

    drawn = Table("motor", "position", "of", "velocity", "of", "acceleration", "of")
    for name, motor in reached["motors"].items():
        (low, high), (lowest, highest) = motor["position"], motor["position_limits"]
        cells = [f"{low:.4g} : {high:.4g}", f"{lowest:.4g} : {highest:.4g}"]
        cells += [f"{motor[key]:.4g}" for key in ("velocity", "velocity_limit", "acceleration", "acceleration_limit")]
        drawn.add_row(name, *cells)
    return drawn


def lines(reached: Mapping[str, Any]) -> list[str]:
    """Return condition numbers and duration in words, from `figures`."""
    start, end = reached["start"], reached["duration"]
    return [
        f"condition number of the regressor: {reached['condition_before']:.4g} at the first random motion, "
        f"{reached['condition']:.4g} now",
        f"for {len(reached['parameters'])} parameters: {', '.join(reached['parameters'])}",
        *_sought_friction(reached["parameters"]),
        f"{end:g} s, {reached['samples']} samples: start and stop {start:g} s each, at rest where it ends",
    ]


def _sought_friction(parameters: Sequence[str]) -> list[str]:
    """Return a line on friction that is sought."""
    friction = [label for label in parameters if label.startswith(("FV", "FS"))]
    what = "are sought for every motor, whether or not its table gives friction, for every motor has some"
    return [f"FV, FS (viscous, dry friction) {what}: leave them out by --known {friction[0]} ..."] if friction else []
