"""What sensors add to both sides of tau = Y X: constant offsets of torques, and a delay of torques behind positions.

tau(t) measured = tau(t - delay) + offset. Offsets are columns of ones; a delay d + x, near d, is the column of x beside
torques read d later: tau(t + d) = Y X - x dtau/dt. Where they are estimated, all standard deviations include theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import CORRELATED, SIGNIFICANT, Estimate, Unknown, Verdict
from symoro_elastic.measured.logs.estimation import Estimation, LeastSquares, independent_solution
from symoro_elastic.measured.logs.noise import RowNoise

AUTO, ALWAYS, NEVER = "auto", "always", "never"
"""When offsets or a delay are sought: as data say, always, never."""
DELAY, OFFSET = "DELAY", "OFF"
USUAL = 0.02  # of the largest torque of the joint: offsets that sensors have
LEAST_OFFSET = 1e-4  # of the largest torque of the joint: smaller offsets do not count
LEAST_DELAY = 0.01  # of a sampling period: smaller delays and steps to them do not count
ROUNDS = 6  # steps to a delay
LARGEST_STEP = 0.1  # of a period of the fastest motion


class _Offset(NamedTuple):
    """An offset, its standard deviation, and its largest correlation with a parameter of the machine."""

    value: float
    std: float
    correlation: float


Torques = Callable[[float], tuple[Array, Array]]
"""From a delay, left sides of torques read so much later, and their slopes, each (rows, n)."""


@dataclass(frozen=True)
class Columns:
    """Equations of a log: Y (rows, n, c) of the machine, columns of torque offsets (rows, n, motors), torques as a
    function of delay, noise in rows, sampling period and period of the fastest motion in s."""

    Y: Array
    offsets: Array
    torques: Torques
    noise: RowNoise
    sampling: float
    motion: float

    @property
    def correlation(self) -> Array:
        """Correlation of the noise of torques (lags, rows, n)."""
        return self.noise.correlation_in(self.Y)

    def with_sensor_columns(self, motors: Sequence[int], slope: Array | None) -> tuple[Array, RowNoise]:
        """Return Y and its noise with columns of the offsets of some motors and of a delay."""
        more = [self.offsets[:, :, list(motors)], *([] if slope is None else [-slope[:, :, None]])]
        return np.concatenate([self.Y, *more], axis=2), self.noise.with_exact(sum(x.shape[2] for x in more))

    def solution(self, motors: Sequence[int], slope: Array | None, tau: Array) -> tuple[list[int], LeastSquares]:
        """Return the independent columns of the machine, offsets and a delay, and their solution."""
        Y, noise = self.with_sensor_columns(motors, slope)
        return independent_solution(Y, tau, noise)


@dataclass(frozen=True)
class Sensors:
    """Sensor terms to estimate: torque offsets of motors (0-based among motors), and whether a delay of torques,
    whose column is linear about `delay` s. `undetermined` are motors whose offset the motion does not
    distinguish from gravity, with its assumed standard deviation.
    """

    offsets: tuple[int, ...] = ()
    has_delay: bool = False
    delay: float = 0.0
    undetermined: Mapping[int, float] = field(default_factory=dict)

    def doubts(self, columns: Columns) -> list[Array]:
        """Return torque errors (rows, n) by one standard deviation of each offset that the motion cannot determine."""
        return [s * columns.offsets[:, :, m] for m, s in self.undetermined.items()]

    def unknowns(self, machine: Machine) -> list[Unknown]:
        """Return offsets, then the delay, as unknowns."""
        labels, rows = ParameterLabels(machine), machine.motors
        joints = [machine.joint(rows[m]) for m in self.offsets]
        named = [labels(rows[m], OFFSET) for m in self.offsets]
        offsets = [
            Unknown(x, joint.force_unit, formula=x, joint=joint.name, quantity=OFFSET)
            for x, joint in zip(named, joints, strict=True)
        ]
        free = next(x for x in ("delay", "delay_", "delay__", "torque_delay") if x not in labels.taken)
        return [
            *offsets,
            *([Unknown(free, "s", formula=free, quantity=DELAY, about=self.delay)] if self.has_delay else []),
        ]


def shows(e: Estimate) -> bool:
    """Whether an estimate differs from zero by more than chance."""
    return abs(e.value) > SIGNIFICANT * e.std


def sought_sensors(columns: Columns, offsets: str, delay: str) -> Sensors:
    """Return the sensor terms to estimate: offsets and a delay, as requested or where data require them."""
    motors = [] if offsets == NEVER else list(range(columns.offsets.shape[2]))
    if delay == NEVER:
        return _sensors(columns, motors, offsets, None)
    late = delay_of(columns, motors)
    least = LEAST_DELAY * columns.sampling
    is_late = late is not None and (delay == ALWAYS or abs(late[0]) > max(SIGNIFICANT * late[1], least))
    return _sensors(columns, motors, offsets, late[0] if late and is_late else None)


def sensors_of_short_record(columns: Columns, offsets: str, delay: str) -> Sensors:
    """Return the sensor terms of a short record: all offsets unless never, and a delay only if always."""
    motors = () if offsets == NEVER else tuple(range(columns.offsets.shape[2]))
    return Sensors(motors, delay == ALWAYS)


def _sensors(columns: Columns, motors: Sequence[int], seek: str, delay: float | None) -> Sensors:
    """Return the sensor terms with this delay: offsets to estimate, and those that cannot be determined."""
    tau, slope = columns.torques(delay or 0.0)
    estimated, undetermined = _offsets(columns, motors, None if delay is None else slope, tau, seek)
    return Sensors(estimated, delay is not None, delay or 0.0, undetermined)


def delay_of(columns: Columns, motors: Sequence[int]) -> tuple[float, float] | None:
    """Return the delay and its standard deviation by Gauss-Newton steps; None where the motion does not show it."""
    delay, most = 0.0, LARGEST_STEP * columns.motion
    last = columns.Y.shape[2] + len(motors)
    for _ in range(ROUNDS):
        tau, slope = columns.torques(delay)
        independent, solution = columns.solution(motors, slope, tau)
        if last not in independent:
            return None
        step, std = float(solution.X[-1]), float(solution.std[-1])
        if abs(delay + step) <= max(SIGNIFICANT * std, LEAST_DELAY * columns.sampling):
            return delay + step, std
        delay += float(np.clip(step, -most, most))
        if abs(step) <= LEAST_DELAY * columns.sampling:
            break
    return delay, std


def _offsets(
    columns: Columns, motors: Sequence[int], slope: Array | None, tau: Array, seek: str
) -> tuple[tuple[int, ...], dict[int, float]]:
    """Return the motors whose offsets are estimated, and assumed offsets of motors where gravity hides them.

    One that does not show may be there all the same, as large as some of its standard deviations, and pulls parameters
    with which it is correlated by as many of theirs: it is left out only where it pulls none. Sensors of a machine are
    alike, so offsets are taken to be as large, beside the largest torque of their joint, as the largest one that shows,
    or as sensors usually have: of a larger standard deviation, data say nothing of it.
    """
    if not motors:
        return (), {}
    every = _estimated_offsets(columns, motors, slope, tau)
    if seek == ALWAYS:
        return tuple(every), {}
    on_joints = {m: columns.offsets[:, :, m].any(axis=0) for m in motors}
    largest = {m: float(np.abs(tau[:, joints]).max(initial=0.0)) for m, joints in on_joints.items()}
    determined = [m for m, x in every.items() if x.std <= USUAL * largest[m]]
    offsets = every if len(determined) == len(motors) else _estimated_offsets(columns, determined, slope, tau)
    least = {m: LEAST_OFFSET * x for m, x in largest.items()}
    significant = [m for m, x in offsets.items() if abs(x.value) > max(SIGNIFICANT * x.std, least[m])]
    usual_fraction = max([USUAL, *(abs(offsets[m].value) / largest[m] for m in significant)])
    usual = {m: usual_fraction * largest[m] for m in motors}
    most = {m: abs(x.value) + SIGNIFICANT * x.std for m, x in offsets.items()}
    small = [m for m, x in offsets.items() if x.correlation <= CORRELATED or most[m] <= least[m]]
    harmless = [m for m in small if m not in significant]
    sought = tuple(m for m, x in every.items() if x.std <= usual[m] and m not in harmless)
    return sought, {m: usual[m] for m in motors if m not in sought and m not in harmless}


def _estimated_offsets(columns: Columns, motors: Sequence[int], slope: Array | None, tau: Array) -> dict[int, _Offset]:
    """Return estimated offsets by motor, of those whose columns are linearly independent."""
    own = columns.Y.shape[2]
    independent, solution = columns.solution(motors, slope, tau)
    places = {m: independent.index(own + k) for k, m in enumerate(motors) if own + k in independent}
    of_machine = [k for k, c in enumerate(independent) if c < own]
    correlation = np.abs(solution.covariance / np.outer(solution.std, solution.std))
    most = {m: float(correlation[k, of_machine].max(initial=0.0)) for m, k in places.items()}
    return {m: _Offset(float(solution.X[k]), float(solution.std[k]), most[m]) for m, k in places.items()}


def notes_on_sensors(estimation: Estimation, sensors: Sensors, machine: Machine) -> list[str]:
    """Return notes on offsets of torques and on their delay."""
    notes = []
    for e in estimation.estimates:
        if e.unknown.quantity == OFFSET and e.verdict is not Verdict.NOT:
            notes.append(_of_offset(e))
        if e.unknown.quantity == DELAY and e.verdict is not Verdict.NOT:
            late, others = ("torques", "behind positions") if e.value > 0 else ("positions", "behind torques")
            what = f"{late} are {1e3 * abs(e.value):.4g} ms (std {1e3 * e.std:.2g} ms) {others}"
            notes.append(f"{what}: compensated, and estimated with the parameters")
    for m, size in sensors.undetermined.items():
        joint = machine.motor_joints[m]
        what, below = f"an offset of the torque of {joint.name}", f"{size:.2g} {joint.force_unit}"
        what += f" is not distinguishable from gravity by this motion: standard deviations include {below} (usual)"
        notes.append(f"{what}; move it farther, or give --offsets never if its sensor has none")
    return notes


def _of_offset(e: Estimate) -> str:
    """Return a note on an estimated offset: its value, or the bound below which it cannot be excluded."""
    if shows(e):
        what = f"torque of {e.unknown.joint} has an offset of {e.value:.4g} {e.unknown.unit} (std {e.std:.2g})"
        return f"{what}: estimated with the parameters"
    most = abs(e.value) + SIGNIFICANT * e.std
    what = f"torque offsets of {e.unknown.joint} below {most:.2g} {e.unknown.unit} cannot be excluded"
    return f"{what}, so one is estimated (--offsets never if its sensor has none)"
