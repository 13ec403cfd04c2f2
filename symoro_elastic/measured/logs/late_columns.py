"""Columns of a log that lag the others by whole samples, as those of a buffered channel do, which are shifted back.

Positions of a joint that are late by d make torques later by d sum of d(Y X)/dt by that joint alone, a torque that is
late adds -d dtau/dt: columns in addition to those of the parameters. By the criterion of `corrections`, a column is
late if that explains the residuals far better than a delay of all torques (`sensors`), or what this delay leaves of
them. It is shifted if the delay is of integer samples; else it is a systematic error of the estimates. Measured
velocities are compared with the derivatives of positions; no parameters are needed for that.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.corrections import VERY_STRONG
from symoro_elastic.measured.fitting.estimates import SIGNIFICANT
from symoro_elastic.measured.logs.equations import Equations, Sampled
from symoro_elastic.measured.logs.filtering import Filter, differentiate, smooth
from symoro_elastic.measured.logs.noise import usual_correlation
from symoro_elastic.measured.logs.sensors import ROUNDS, Columns, delay_of

CLEAR = 2 * VERY_STRONG  # difference of BIC
WHOLE = 0.25  # samples from an integer that a column may be late after it was shifted, which is reported
LONGEST = 50  # samples
EXACT = 1e-12  # of squares of residuals, which rounding leaves
LIKE = 0.1  # of velocities: largest difference from derivatives of positions that a delay explains
JOINT, POSITION, VELOCITY, TORQUE = ("q", "qd", "qdd"), ("q",), ("qd", "qdd"), ("tau",)


@dataclass(frozen=True)
class Late:
    """Columns of a joint or motor (by place) that are late by so many samples; the first one names them.

    `evidence` is the fall of BIC below the best hypothesis without it; `torques` (rows, n) are the errors of torques
    by that delay where columns are not shifted.
    """

    quantities: tuple[str, ...]
    place: int
    samples: float
    std: float = 0.0
    evidence: float = 0.0
    torques: Array | None = field(default=None, compare=False, repr=False)

    @property
    def key(self) -> tuple[tuple[str, ...], int]:
        """Identity of the columns: their quantities and the index of their joint or motor."""
        return self.quantities, self.place

    @property
    def whole(self) -> int:
        """Delay rounded to an integer number of samples."""
        return round(self.samples)

    @property
    def is_whole(self) -> bool:
        """Whether the delay is an integer number of samples, not zero, within its uncertainty."""
        return self.whole != 0 and abs(self.samples - self.whole) < max(WHOLE, SIGNIFICANT * self.std)

    def header(self, machine: Machine) -> str:
        """Return the name of the first late column, `<quantity>_<joint>`."""
        joints = machine.motor_joints if self.quantities == TORQUE else machine.independent_joints
        return f"{self.quantities[0]}_{joints[self.place].name}"

    def moved_back(self, record: Measurements) -> Measurements:
        """Return a record whose columns are at their time; as many samples are lost at one end."""
        k, size = self.whole, len(record.t) - abs(self.whole)
        own, late = slice(max(-k, 0), max(-k, 0) + size), slice(max(k, 0), max(k, 0) + size)

        def shift(name: str, x: Array) -> Array:
            shifted = x[own].copy()
            if name in self.quantities:
                shifted[:, self.place] = x[late, self.place]
            return shifted

        qd = None if record.qd is None else shift("qd", record.qd)
        qdd = None if record.qdd is None else shift("qdd", record.qdd)
        q, tau = shift("q", record.q), shift("tau", record.tau)
        return replace(record, t=record.t[own], q=q, tau=tau, qd=qd, qdd=qdd)


def late_velocities(record: Measurements, chosen: Filter) -> list[Late]:
    """Return measured velocities that lag derivatives of their positions by whole samples, and positions that lag."""
    if record.qd is None or not record.is_even:
        return []
    late = []
    q, qd = smooth(record.q, chosen), smooth(record.qd, chosen)
    inner = slice(chosen.trim + LONGEST, len(q) - chosen.trim - LONGEST)
    if inner.stop - inner.start < LONGEST:
        return []
    for k in range(q.shape[1]):
        lag = _lag(q[:, k], qd[:, k], record.period, inner)
        if lag is not None and abs(lag) < LONGEST:
            late.append(Late(VELOCITY, k, lag) if lag > 0 else Late(POSITION, k, -lag))
    return [column for column in late if column.is_whole]


def _lag(q: Array, qd: Array, period: float, inner: slice) -> float | None:
    """Return the lag, in samples, of a velocity behind its position's derivative; None if they differ otherwise."""
    rate = np.pad(differentiate(q, period)[0], 2, mode="edge")
    samples, t = 0.0, np.arange(len(q))
    for _ in range(ROUNDS):
        moved = np.interp(t + samples, t, qd)
        slope = np.gradient(moved)
        energy = float(slope[inner] @ slope[inner])
        if energy == 0.0:
            return None
        step = -float((moved - rate)[inner] @ slope[inner]) / energy
        samples += step
        if not abs(samples) < LONGEST:
            return None
    difference = np.interp(t + samples, t, qd) - rate
    alike = np.linalg.norm(difference[inner]) < LIKE * np.linalg.norm(rate[inner])
    return samples if alike else None


def moved_back(record: Measurements, late: Iterable[Late]) -> Measurements:
    """Return a record with each late column moved back by its delay; samples at the ends are lost."""
    for column in late:
        record = column.moved_back(record)
    return record


@dataclass(frozen=True)
class Delays:
    """Delays of columns, each estimated as the only one, in addition to a delay of all torques if data show one.

    `rivals` are positions that explain as much as torques that are all ahead of positions, as no torque is.
    """

    columns: tuple[Late, ...]
    rivals: tuple[Late, ...] = ()

    @property
    def clear(self) -> Late | None:
        """The column whose delay clearly explains the residuals; among equal ones a late column before an early one."""
        certain = [x for x in self.likely if x.whole and abs(x.samples) < LONGEST]
        return max(certain, key=lambda x: (x.samples > 0, x.evidence), default=None)

    @property
    def likely(self) -> list[Late]:
        """Columns whose delay the residuals indicate, the best and those that are nearly as good."""
        best = max((x.evidence for x in self.columns), default=0.0)
        return [x for x in self.columns if x.evidence > max(best - CLEAR, CLEAR)]

    def still(self, shifted: Iterable[Late]) -> Late | None:
        """Return a shifted column that is still late by half a sample or more, since its shift was rounded."""
        later = (self.now(x) for x in shifted)
        return next((x for x in later if x.evidence > 0 and x.whole), None)

    def now(self, late: Late) -> Late:
        """Return the remaining delay of a shifted column; zero if none was estimated."""
        return next((column for column in self.columns if column.key == late.key), replace(late, samples=0.0))

    def leaves(self, late: Late) -> bool:
        """Whether a shifted column has no significant delay any more."""
        now = self.now(late)
        return abs(now.samples) < max(WHOLE, SIGNIFICANT * now.std)


def delays_of(equations: Equations, records: Sequence[Sampled], columns: Columns) -> Delays:
    """Return the delays of columns, by Gauss-Newton steps together with parameters and torque offsets.

    Where a delay of all torques explains as much as the best column, they are late in addition to that delay.
    """
    alone, every = _delays(equations, records, columns, None)
    delay = delay_of(columns, range(columns.offsets.shape[2]))
    compared = [replace(x, evidence=x.evidence - max(every, 0.0)) for x in alone]
    if delay is None or every < CLEAR or max(x.evidence for x in compared) > CLEAR:
        return Delays(tuple(compared))
    rivals = [x for x in compared if delay[0] < 0 and x.quantities == JOINT and x.evidence > -CLEAR]
    return Delays(tuple(_delays(equations, records, columns, delay[0])[0]), tuple(rivals))


def _delays(
    equations: Equations, records: Sequence[Sampled], columns: Columns, delay: float | None
) -> tuple[list[Late], float]:
    """Return the delays of columns, with or without a delay of all torques, and the BIC fall by that delay.

    Squares of n independent residuals that fall by a share make -2 ln of the likelihood fall by -n ln(1 - share).
    """
    motors, count = range(columns.offsets.shape[2]), columns.Y.shape[2]
    tau, slope = columns.torques(delay or 0.0)
    independent, base = columns.solution(motors, None if delay is None else slope, tau)
    Y = columns.with_sensor_columns(motors, None if delay is None else slope)[0]
    X = np.zeros(Y.shape[2])
    X[independent] = base.X
    correlation = usual_correlation(columns.correlation)
    sigma = base.sigma * base.raised * np.sqrt(2 * sum(correlation) - correlation[0])
    Q = np.linalg.qr((Y[:, :, independent] / sigma[:, None]).reshape(-1, len(independent)))[0]
    residuals = (base.residuals / sigma).ravel()
    n = max(float(residuals @ residuals), np.finfo(float).tiny)

    def delay_by(column: Array, rivals: int) -> tuple[float, float, float]:
        c = (column / sigma).ravel()
        c = c - Q @ (Q.T @ c)
        energy = float(c @ c)
        if energy == 0.0:
            return 0.0, np.inf, 0.0
        share = min(float(c @ residuals) ** 2 / energy / n, 1 - EXACT)
        fall = -n * np.log1p(-share) - np.log(max(n, 1.0)) - 2 * np.log(rivals)
        return float(c @ residuals) / energy / columns.sampling, energy**-0.5 / columns.sampling, float(fall)

    kinds = (JOINT,) if any(x.record.qd is None for x in records) else (JOINT, POSITION, VELOCITY)
    blocks = [(kind, [_of_positions(equations, x, X[:count], kind) for x in records]) for kind in kinds]
    blocks.append((TORQUE, [_of_torques(equations, x, delay or 0.0) for x in records]))
    of_columns = [(kind, k, x) for kind, block in blocks for k, x in enumerate(np.concatenate(block, axis=1))]
    delays = [(quantity, k, x, delay_by(x, len(of_columns))) for quantity, k, x in of_columns]
    late = [Late(quantity, k, *by, by[0] * columns.sampling * x) for quantity, k, x, by in delays]
    return late, delay_by(-slope, 1)[2]


def _of_positions(equations: Equations, sampled: Sampled, X: Array, quantities: Collection[str]) -> Array:
    """Return derivatives of Y X by the delay of quantities of each joint, per second (joints, rows, n)."""
    motion, period = sampled.motion, sampled.record.period
    every = max(1, sampled.every // 2)
    some = slice(every // 2, None, every)
    q, qd, qdd = motion.part(some)
    jerk = np.gradient(motion.qdd, period, axis=0)[some]
    rates = [x * (name in quantities) for name, x in zip(JOINT, (qd, qdd, jerk), strict=True)]
    slopes = []
    for k in range(q.shape[1]):
        unit = np.arange(q.shape[1]) == k
        shifts = ([h * unit * x for x in rates] for h in (period, -period))
        columns = equations.estimated_columns
        later, earlier = (equations.Y.torques(q + a, qd + b, qdd + c, columns, X) for a, b, c in shifts)
        slopes.append(sampled.averages_of_few((later - earlier) / (2 * period), every))
    return np.array(slopes)


def _of_torques(equations: Equations, sampled: Sampled, delay: float) -> Array:
    """Return derivatives of joint torques by the delay of each motor's torque, per second (motors, rows, n)."""
    slopes = sampled.torques(delay)[1]
    units = np.eye(slopes.shape[1])
    return np.array([-sampled.averages(equations.Y.joint_torques(sampled.motion.q, slopes * unit)) for unit in units])


def notes_on_late_columns(late: Sequence[Late], machine: Machine) -> list[str]:
    """Return a line for each column that was shifted, and one for those that were not."""
    lines, unshifted = [], []
    for column in late:
        way = "late" if column.samples > 0 else "early"
        if column.torques is not None:
            unshifted.append(f"{column.header(machine)} is {abs(column.samples):.3g} samples {way}")
            continue
        samples = f"{abs(column.whole)} sample{'' if abs(column.whole) == 1 else 's'}"
        doubt = f" (+- {column.std:.1g})" if column.std > WHOLE else ""
        what = f"is {samples} {way}{doubt} relative to the other columns (buffered channel?): shifted back"
        lines.append(f"{column.header(machine)} {what}")
    if unshifted:
        what = "relative to the other columns (buffered channel?), not shifted: standard deviations include this"
        lines.append(f"{', or '.join(unshifted)} {what}")
    return lines
