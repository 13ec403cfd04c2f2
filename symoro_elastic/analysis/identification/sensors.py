"""What sensors add to both sides of tau = Y X: constant offsets of torques, and a delay of torques behind positions.

tau(t) measured = tau(t - delay) + offset. Offsets are columns of ones; a delay d + x, near d, is the column of x beside
torques read d later: tau(t + d) = Y X - x dtau/dt. Where they are sought, their doubt is in all standard deviations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.analysis.identification.estimation import (
    FROM_DATA,
    Draws,
    LeastSquares,
    Unknown,
    balanced,
    of_columns,
    solve,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.independence import independent_columns

AUTO, ALWAYS, NEVER = "auto", "always", "never"
"""When offsets or a delay are sought: where data show one, always, never."""
DELAY, OFFSET = "DELAY", "OFF"
SIGNIFICANT = 4.0  # standard deviations from zero
MOST_DOUBT = 0.02  # of the largest torque of the joint: an offset with more does not say whether there is one
LEAST_OFFSET = 1e-4  # of the largest torque of the joint
LEAST_DELAY = 0.01  # of a sampling period
ROUNDS, CONVERGED = 6, 0.02  # of a sampling period
LARGEST_STEP = 0.1  # of a period of the fastest motion

Torques = Callable[[float], tuple[Array, Array]]
"""From a delay, left sides of torques read so much later, and their slopes, each (rows, n)."""


@dataclass(frozen=True)
class Columns:
    """Rows to be explained: Y (rows, n, c) of the machine, noises of Y, columns of offsets (rows, n, motors), left
    sides by delay, correlation of the noise of torques (lags, rows, n), sampling period and period of the fastest
    motion in s, whether noises of Y repeat with the motion, and draws of such noises."""

    Y: Array
    noise: tuple[Array, ...]
    offsets: Array
    torques: Torques
    correlation: Array
    sampling: float
    motion: float
    repeating: bool = False
    draws: Draws | None = None

    def joined(self, motors: Sequence[int], slope: Array | None) -> tuple[Array, list[Array]]:
        """Return Y and its noises with columns of the offsets of some motors and of a delay."""
        more = [self.offsets[:, :, list(motors)], *([] if slope is None else [-slope[:, :, None]])]
        none = np.zeros((*self.Y.shape[:2], sum(x.shape[2] for x in more)))
        return np.concatenate([self.Y, *more], axis=2), [np.concatenate([D, none], axis=2) for D in self.noise]


@dataclass(frozen=True)
class Sensors:
    """What is sought beside a machine's parameters: offsets of motors (0-based among motors), and whether a delay,
    whose column is linear about `delay` s. `untold` are motors whose offset the motion does not tell from gravity, with
    the standard deviation that it is taken to have; where no motor shows an offset it is that of what would not show.
    """

    offsets: tuple[int, ...] = ()
    has_delay: bool = False
    delay: float = 0.0
    untold: Mapping[int, float] = field(default_factory=dict)

    def doubts(self, columns: Columns) -> list[Array]:
        """Return what offsets that are not sought, although others have one, do to left sides: one std, (rows, n)."""
        return [s * columns.offsets[:, :, m] for m, s in self.untold.items()] if self.offsets else []

    def unknowns(self, machine: Machine) -> list[Unknown]:
        """Return offsets, then the delay, as unknowns."""
        labels, rows = ParameterLabels(machine), machine.motors
        joints = [machine.joint(rows[m]) for m in self.offsets]
        named = [labels(rows[m], OFFSET) for m in self.offsets]
        offsets = [Unknown(x, x, joint.force_unit, joint.name, OFFSET) for x, joint in zip(named, joints, strict=True)]
        free = next(x for x in ("delay", "delay_", "delay__", "torque_delay") if x not in labels.taken)
        return [*offsets, *([Unknown(free, free, "s", "", DELAY, about=self.delay)] if self.has_delay else [])]


def sought_sensors(columns: Columns, offsets: str, delay: str) -> Sensors:
    """Return which offsets are sought, and whether a delay, by data where so asked."""
    motors = [] if offsets == NEVER else list(range(columns.offsets.shape[2]))
    if delay == NEVER:
        return _sensors(columns, motors, offsets, None)
    late = _delay(columns, motors)
    lasting = late is not None and (delay == ALWAYS or _is_late(late, columns))
    return _sensors(columns, motors, offsets, late[0] if late and lasting else None)


def sensors_of_few(columns: Columns, offsets: str, delay: str) -> Sensors:
    """Return what is sought where rows are too few to show it: offsets, which are small, and no delay unless always."""
    motors = () if offsets == NEVER else tuple(range(columns.offsets.shape[2]))
    return Sensors(motors, delay == ALWAYS)


def _sensors(columns: Columns, motors: Sequence[int], seek: str, delay: float | None) -> Sensors:
    """Return the offsets that are sought beside a delay."""
    tau, slope = columns.torques(delay or 0.0)
    found, untold = _offsets(columns, motors, None if delay is None else slope, tau, seek)
    return Sensors(found, delay is not None, delay or 0.0, untold)


def _is_late(late: tuple[float, float], columns: Columns) -> bool:
    return abs(late[0]) > max(SIGNIFICANT * late[1], LEAST_DELAY * columns.sampling)


def _solved(columns: Columns, motors: Sequence[int], slope: Array | None, tau: Array) -> tuple[list[int], LeastSquares]:
    """Return the columns that are independent, and the solution of these."""
    Y, noise = columns.joined(motors, slope)
    kept = list(independent_columns(balanced(Y), FROM_DATA).kept)
    noise = [D[:, :, kept] for D in noise]
    draws = of_columns(columns.draws, kept, Y.shape[2]) if columns.draws else None
    correlation, repeating = columns.correlation, columns.repeating
    return kept, solve(Y[:, :, kept], tau, noise=noise, correlation=correlation, repeating=repeating, draws=draws)


def _delay(columns: Columns, motors: Sequence[int]) -> tuple[float, float] | None:
    """Return the delay and its standard deviation by Gauss-Newton steps; None where the motion does not show it."""
    delay, most = 0.0, LARGEST_STEP * columns.motion
    last = columns.Y.shape[2] + len(motors)
    for _ in range(ROUNDS):
        tau, slope = columns.torques(delay)
        kept, solution = _solved(columns, motors, slope, tau)
        if last not in kept:
            return None
        step, std = float(solution.X[-1]), float(solution.std[-1])
        if abs(delay + step) <= max(SIGNIFICANT * std, LEAST_DELAY * columns.sampling):
            return delay + step, std
        delay += float(np.clip(step, -most, most))
        if abs(step) <= CONVERGED * columns.sampling:
            break
    return delay, std


def _offsets(
    columns: Columns, motors: Sequence[int], slope: Array | None, tau: Array, seek: str
) -> tuple[tuple[int, ...], dict[int, float]]:
    """Return the motors whose offsets are sought, and of the others what they may have or what would not show.

    Where one shows, sought are those that data tell better than what is found suggests: sensors of a machine are alike,
    so offsets are taken to be at most as large, beside the largest torque of their joint, as the largest one found.
    """
    if not motors:
        return (), {}
    every = _offset_deviations(columns, motors, slope, tau)
    if seek == ALWAYS:
        return tuple(every), {}
    largest = {m: _largest(columns, m, tau) for m in motors}
    told = [m for m, (_, std) in every.items() if std <= MOST_DOUBT * largest[m]]
    found = every if len(told) == len(motors) or not told else _offset_deviations(columns, told, slope, tau)
    shown = [abs(x) / largest[m] for m, (x, std) in found.items() if _shows(x, std, largest[m])]
    if not shown:
        doubt = {m: SIGNIFICANT * every[m][1] if m in every else largest[m] for m in motors}
        return (), {m: x for m, x in doubt.items() if x > MOST_DOUBT * largest[m]}
    usual = {m: max(shown) * largest[m] for m in motors}
    sought = tuple(m for m, (_, std) in every.items() if std < usual[m])
    return sought, {m: usual[m] for m in motors if m not in sought}


def _shows(offset: float, std: float, largest: float) -> bool:
    return abs(offset) > max(SIGNIFICANT * std, LEAST_OFFSET * largest)


def _largest(columns: Columns, motor: int, tau: Array) -> float:
    """Return the largest torque of the joints on which a motor acts."""
    return float(np.abs(tau[:, columns.offsets[:, :, motor].any(axis=0)]).max(initial=0.0))


def _offset_deviations(
    columns: Columns, motors: Sequence[int], slope: Array | None, tau: Array
) -> dict[int, tuple[float, float]]:
    """Return offsets and their standard deviations by motor, where they are independent of all else."""
    own = columns.Y.shape[2]
    kept, solution = _solved(columns, motors, slope, tau)
    places = {m: kept.index(own + k) for k, m in enumerate(motors) if own + k in kept}
    return {m: (float(solution.X[k]), float(solution.std[k])) for m, k in places.items()}
