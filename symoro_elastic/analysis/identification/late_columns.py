"""Columns of a log that lag the others by whole samples, as those of a buffered channel do: found, and moved back.

Positions of a joint that are late by d make torques later by d sum of d(Y X)/dt by that joint alone, a torque that is
late is one with -d dtau/dt: a column each beside those of the parameters. The one that explains most of the residuals
is late, if a delay of all torques (`sensors`) explains clearly less, and if what is left is of whole samples. Measured
velocities are compared with the derivatives of positions; no parameters are needed for that.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.identification.equations import Equations, Sampled
from symoro_elastic.analysis.identification.filtering import Filter, differentiate, smooth
from symoro_elastic.analysis.identification.noise import usual_correlation
from symoro_elastic.analysis.identification.sensors import Columns, solved
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine

CLEAR, BETTER = 6.0, 1.5  # standard deviations from zero; times the fall of squares by a delay of all torques
LEAST, WHOLE, SIGNIFICANT = 0.6, 0.25, 4.0  # samples that are late at least, beside whole ones; standard deviations
LONGEST, DOUBTED = 50, 0.2  # samples that are late at most; standard deviation that is said
ROUNDS = 6
LIKE = 0.1  # of velocities: what derivatives of positions leave of them at most, where only delays part them
JOINT, POSITION, VELOCITY, TORQUE = ("q", "qd", "qdd"), ("q",), ("qd", "qdd"), ("tau",)


@dataclass(frozen=True)
class Late:
    """Columns of a joint or motor (by place) that are late by so many samples; the first one names them."""

    quantities: tuple[str, ...]
    place: int
    samples: float
    std: float = 0.0

    @property
    def key(self) -> tuple[tuple[str, ...], int]:
        """Which columns they are."""
        return self.quantities, self.place

    @property
    def whole(self) -> int:
        """The nearest number of samples."""
        return round(self.samples)

    @property
    def is_whole(self) -> bool:
        """Whether it is late by whole samples, within its doubt."""
        return self.whole != 0 and abs(self.samples - self.whole) < max(WHOLE, SIGNIFICANT * self.std)

    def header(self, machine: Machine) -> str:
        """Return the name of the first column."""
        joints = machine.motor_joints if self.quantities == TORQUE else machine.independent_joints
        return f"{self.quantities[0]}_{joints[self.place].name}"

    def moved_back(self, record: Measurements) -> Measurements:
        """Return a record whose columns are at their time; as many samples are lost at one end."""
        k, size = self.whole, len(record.t) - abs(self.whole)
        own, late = slice(max(-k, 0), max(-k, 0) + size), slice(max(k, 0), max(k, 0) + size)

        def moved(name: str, x: Array) -> Array:
            found = x[own].copy()
            if name in self.quantities:
                found[:, self.place] = x[late, self.place]
            return found

        qd = None if record.qd is None else moved("qd", record.qd)
        qdd = None if record.qdd is None else moved("qdd", record.qdd)
        q, tau = moved("q", record.q), moved("tau", record.tau)
        return replace(record, t=record.t[own], q=q, tau=tau, qd=qd, qdd=qdd)


def late_velocities(record: Measurements, chosen: Filter) -> list[Late]:
    """Return measured velocities that lag derivatives of their positions by whole samples, and positions that lag."""
    if record.qd is None or not record.is_even:
        return []
    found = []
    q, qd = smooth(record.q, chosen), smooth(record.qd, chosen)
    inner = slice(chosen.trim + LONGEST, len(q) - chosen.trim - LONGEST)
    if inner.stop - inner.start < LONGEST:
        return []
    for k in range(q.shape[1]):
        one = _lag(q[:, k], qd[:, k], record.period, inner)
        if one is not None and abs(one) < LONGEST:
            found.append(Late(VELOCITY, k, one) if one > 0 else Late(POSITION, k, -one))
    return [one for one in found if one.is_whole]


def _lag(q: Array, qd: Array, period: float, inner: slice) -> float | None:
    """Return by how many samples a velocity lags the derivative of its position; None where they are not alike."""
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
    left = np.interp(t + samples, t, qd) - rate
    alike = np.linalg.norm(left[inner]) < LIKE * np.linalg.norm(rate[inner])
    return samples if alike else None


def moved_back(record: Measurements, late: Iterable[Late]) -> Measurements:
    """Return a record with late columns at their times."""
    for one in late:
        record = one.moved_back(record)
    return record


@dataclass(frozen=True)
class Delays:
    """How late each column is, were it alone, and over its standard deviation how late all torques are."""

    each: tuple[Late, ...]
    every: float

    @property
    def clear(self) -> Late | None:
        """The column whose delay explains most, if it does so clearly."""
        best = max(self.each, key=lambda one: abs(one.samples / one.std))
        fall = (best.samples / best.std) ** 2
        is_clear = fall > CLEAR**2 and fall > BETTER * self.every**2
        return best if is_clear and LEAST < abs(best.samples) < LONGEST else None

    def now(self, late: Late) -> Late:
        """Return how late a column is that was moved back; in time if nothing is known of it."""
        return next((one for one in self.each if one.key == late.key), replace(late, samples=0.0))

    def leaves(self, late: Late) -> bool:
        """Whether a column that was moved back is in time now."""
        now = self.now(late)
        return abs(now.samples) < max(WHOLE, SIGNIFICANT * now.std)


def delays_of(equations: Equations, records: Sequence[Sampled], columns: Columns) -> Delays:
    """Return how late columns are, by one Gauss-Newton step beside parameters and offsets of torques."""
    motors, count = range(columns.offsets.shape[2]), columns.Y.shape[2]
    tau, slope = columns.torques(0.0)
    kept, base = solved(columns, motors, None, tau)
    Y, X = columns.joined(motors, None)[0][:, :, kept], np.zeros(count + len(motors))
    X[kept] = base.X
    correlation = usual_correlation(columns.correlation)
    sigma = base.sigma * base.raised * np.sqrt(2 * sum(correlation) - correlation[0])
    Q = np.linalg.qr((Y / sigma[:, None]).reshape(-1, len(kept)))[0]
    rest = (base.residuals / sigma).ravel()

    def seen(column: Array) -> tuple[float, float]:
        c = (column / sigma).ravel()
        c = c - Q @ (Q.T @ c)
        energy = float(c @ c)
        if energy == 0.0:
            return 0.0, np.inf
        return float(c @ rest) / energy / columns.sampling, energy**-0.5 / columns.sampling

    positions = np.concatenate([_of_positions(equations, sampled, X[:count]) for sampled in records], axis=1)
    torques = np.concatenate([_of_torques(equations, sampled) for sampled in records], axis=1)
    found = [
        Late(quantity, k, *seen(column))
        for quantity, each in ((JOINT, positions), (TORQUE, torques))
        for k, column in enumerate(each)
    ]
    samples, std = seen(-slope)
    return Delays(tuple(found), samples / std)


def _of_positions(equations: Equations, sampled: Sampled, X: Array) -> Array:
    """Return what Y X changes by as positions of a joint are read later, (joints, rows, n), a second."""
    motion, period = sampled.motion, sampled.record.period
    every = max(1, sampled.every // 2)
    some = slice(every // 2, None, every)
    q, qd, qdd = motion.part(some)
    jerk = np.gradient(motion.qdd, period, axis=0)[some]
    found = []
    for k in range(q.shape[1]):
        one = np.arange(q.shape[1]) == k
        later, earlier = (
            equations.Y.torques(q + h * one * qd, qd + h * one * qdd, qdd + h * one * jerk, equations.kept, X)
            for h in (period, -period)
        )
        found.append(sampled.averages_of_few((later - earlier) / (2 * period), every))
    return np.array(found)


def _of_torques(equations: Equations, sampled: Sampled) -> Array:
    """Return what torques of a motor lose as they are read later, (motors, rows, n), a second."""
    slopes = sampled.torques(0.0)[1]
    ones = np.eye(slopes.shape[1])
    return np.array([-sampled.averages(equations.Y.joint_torques(sampled.motion.q, slopes * one)) for one in ones])


def said_of_late(late: Sequence[Late], machine: Machine) -> list[str]:
    """Return a line for each late column."""
    lines = []
    for one in late:
        samples = f"{abs(one.whole)} sample{'' if abs(one.whole) == 1 else 's'}"
        way = "late" if one.whole > 0 else "early"
        doubt = f" (+- {one.std:.1g})" if one.std > DOUBTED else ""
        what = f"is {samples} {way}{doubt} beside the other columns, as that of a buffered channel: it is moved back"
        lines.append(f"{one.header(machine)} {what}")
    return lines
