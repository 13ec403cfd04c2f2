"""Filtered records as rows of tau = Y X: averages of both sides, and the noise that is in them."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.time_series.column_faults import neighbourhood, stays
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.logs import filtering
from symoro_elastic.measured.logs.noise import masked_correlation
from symoro_elastic.measured.logs.possible import Linear
from symoro_elastic.numerics.linear.regressor import Regressor

ENTRIES = 1_000_000  # entries of Y evaluated at a time, about
SIGNS = (1.0, -1.0)
CLOSE = 4.0  # samples in a period of the Butterworth cut-off


@dataclass(frozen=True)
class Rows:
    """Rows of tau = Y X of a record, averaged and scaled to unit noise: Y, fixed torques `given`, columns of torque
    offsets, joints at rest, correlation of torque noise with that 0, 1, 2 ... rows later (lags, rows, n), and
    noise of Y from noise records like that of the positions."""

    t: Array
    Y: Array
    given: Array
    offsets: Array
    still: tuple[int, ...]
    correlation: Array
    noise: tuple[Array, ...] = ()


@dataclass(frozen=True)
class Sampled:
    """A filtered record: its motion, a mask of the samples that count in the row of each joint (N, n), the filter.

    Rows are divided by the standard deviation that white noise of torques has in them, relative to that of rows from
    whole windows.
    """

    record: Measurements
    motion: filtering.FilteredMotion
    counted: BoolArray
    chosen: filtering.Filter | None
    staying: BoolArray
    """Samples (N, m) at which torques of motors stay at an end of their range, or do not change."""

    @property
    def pieces(self) -> list[slice]:
        """Pieces of the record that hold whole windows, without large intermediate arrays."""
        samples, joints = self.motion.q.shape
        return _pieces(samples, self.chosen, max(1, ENTRIES // (10 * joints**2)))

    @cached_property
    def _shared_noise(self) -> Array:
        """Covariances, due to white noise, of rows 0, 1, 2 ... apart, (lags, rows, n), before rows are scaled."""
        return filtering.shared_noise(self.counted, self.chosen) if self.chosen else self.counted[None].astype(float)

    @cached_property
    def scale(self) -> Array:
        """1 / std of white noise in each row (rows, n), 1 for whole windows, 0 for rows left out."""
        variance = self._shared_noise[0]
        used = variance >= filtering.FEWEST_OPEN
        return np.where(used, 1 / np.sqrt(np.where(used, variance, 1.0)), 0.0)

    @property
    def correlation(self) -> Array:
        """Correlation of white noise in rows, where some samples of a window do not count, too, (lags, rows, n)."""
        return masked_correlation(self._shared_noise, self.scale)

    @property
    def every(self) -> int:
        """Downsampling factor that keeps all frequencies which the Butterworth filter passes."""
        return max(1, int(self.chosen.sampling / (CLOSE * self.chosen.cutoff))) if self.chosen else 1

    @cached_property
    def draws(self) -> list[tuple[Array, Array, Array]]:
        """Many noise records of q, qd, qdd, including the zeros of encoders, which are known to half a step at best."""
        return filtering.noises_like(self.record, self.chosen, filtering.DRAWS, zeros=True)[0] if self.chosen else []

    def averages_of_few(self, x: Array, every: int) -> Array:
        """Return averages of x (M, n), whose entries represent `every` samples, the last one the remaining ones."""
        repeated = np.pad(np.repeat(x, every, axis=0), ((0, every), (0, 0)), mode="edge")
        return self.averages(repeated[: len(self.motion.t)])

    def averages(self, x: Array) -> Array:
        """Return filtered averages of x (N, n) over the samples that count, scaled to unit noise."""
        used = x * self.counted
        rows: Array = (filtering.average(used, self.chosen) if self.chosen else used) * self.scale
        return rows

    def torques(self, delay: float) -> tuple[Array, Array]:
        """Return torques of motors (N, m) that are read `delay` s later than positions, and their time derivatives."""
        record, at = self.record, self.motion.t + delay
        smoothed = filtering.smooth(record.tau, self.chosen, record) if self.chosen else record.tau
        step = record.period if record.is_even else record.t
        slopes = np.gradient(smoothed, step, axis=0) if smoothed.size else smoothed
        late, slope = (np.array([np.interp(at, record.t, x) for x in y.T]).T for y in (record.tau, slopes))
        shape = (len(at), record.tau.shape[1])
        return late.reshape(shape), slope.reshape(shape)


@dataclass(frozen=True)
class Equations:
    """The equations tau = Y X of a machine: its regressor, and how its columns are grouped."""

    machine: Machine
    Y: Regressor
    linear: Linear

    @property
    def estimated_columns(self) -> tuple[int, ...]:
        """Numbers of the regressor columns to estimate."""
        return tuple(self.linear.sought[c] for c in self.linear.structure.kept)

    @property
    def fixed(self) -> Mapping[int, float]:
        """Fixed values of columns that are not estimated, by number."""
        return self.linear.known

    def sample(self, record: Measurements, chosen: filtering.Filter | None, trusted: Collection[int] = ()) -> Sampled:
        """Return a filtered record. Samples at which a joint's dry friction reverses do not count in its rows.

        Nor do those at which torques stay at an end of their range, nor their neighbours that filters blur, except for
        `trusted` motors (0-based).
        """
        motion = filtering.filtered_motion(record, chosen) if chosen else filtering.as_measured(record)
        self._refuse_open(motion, record.source)
        counted = self._counted_samples(motion, chosen)
        counted[:, list(self.unmeasured_joints(record, motion.still))] = False
        columns = [stays(x) & (m not in trusted) for m, x in enumerate(motion.tau.T)]
        staying = np.array(columns, dtype=bool).reshape(motion.tau.shape[::-1]).T
        for m in np.flatnonzero(staying.any(axis=0)):
            felt = self.effects(motion.q, int(m)).any(axis=0)
            counted[:, felt] &= ~neighbourhood(staying[:, m], 1 + (chosen.reach // 4 if chosen else 0))[:, None]
        return Sampled(record, motion, counted, chosen, staying)

    def effects(self, q: Array, motor: int) -> Array:
        """Return the joint torques (N, n) for a unit torque of a motor."""
        return self.Y.joint_torques(q, np.eye(len(self.machine.motors))[np.full(len(q), motor)])

    def unmeasured_joints(self, record: Measurements, still: Sequence[int]) -> tuple[int, ...]:
        """Return the joints at rest whose torques are zero at all samples, so that no sensor measures them."""
        motors, joints = self.machine.motors, self.machine.independent
        silent = {joints.index(j) for j, tau in zip(motors, record.tau.T, strict=True) if j in joints and not tau.any()}
        return tuple(k for k in still if k in silent)

    def rows(self, sampled: Sampled) -> Rows:
        """Return the rows of Y X of a record, and its torques of loads and fixed parameters."""
        motion, chosen = sampled.motion, sampled.chosen
        averages = zip(*(self._averages(sampled, piece) for piece in sampled.pieces), strict=True)
        right, given, *noise = (np.concatenate(x) for x in averages)
        scaled = [x * sampled.scale[:, :, None] for x in (right, *noise)]
        effects = (self.effects(motion.q, m) for m in range(sampled.record.tau.shape[1]))
        offsets = [sampled.averages(x) for x in effects]
        t = filtering.average(motion.t, chosen) if chosen else motion.t
        stacked = np.stack(offsets, axis=2) if offsets else np.zeros((*given.shape, 0))
        rows = scaled[0], given * sampled.scale, stacked
        return Rows(t, *rows, motion.still, sampled.correlation, tuple(scaled[1:]))

    def torques(self, sampled: Sampled, delay: float = 0.0) -> tuple[Array, Array]:
        """Return averages of the motors' joint torques, read `delay` s later than positions, and their derivatives."""
        late, slope = (self.Y.joint_torques(sampled.motion.q, x) for x in sampled.torques(delay))
        return sampled.averages(late), sampled.averages(slope)

    def draws(self, sampled: Sampled, X: Array) -> list[Array]:
        """Return changes of Y X for drawn quantization errors of encoders, at samples as close as filters need."""
        motion = sampled.motion
        is_moving = np.array([k not in motion.still for k in range(motion.q.shape[1])])
        some = slice(sampled.every // 2, None, sampled.every)
        q, qd, qdd = motion.part(some)
        rows = []
        for noise in sampled.draws:
            dq, dqd, dqdd = (x[some] * is_moving for x in noise)
            more, less = (
                self.Y.torques(q + sign * dq, qd + sign * dqd, qdd + sign * dqdd, self.estimated_columns, X)
                for sign in SIGNS
            )
            rows.append(sampled.averages_of_few((more - less) / 2, sampled.every))
        return rows

    def _refuse_open(self, motion: filtering.FilteredMotion, source: str) -> None:
        """Raise `InputError` for positions at which the loops do not close."""
        open_samples = np.flatnonzero(~self.Y.closes(motion.q))
        if len(open_samples):
            where = f"at {len(open_samples)} of {len(motion.t)} samples, first at t = {motion.t[open_samples[0]]:g} s"
            what = "do positions have the zero of the machine's file, in rad and m?"
            raise InputError(source, "q", f"loops do not close, or jump to another branch, {where}: {what}")

    def _counted_samples(self, motion: filtering.FilteredMotion, chosen: filtering.Filter | None) -> BoolArray:
        """Return a mask of samples (N, n) that count in the rows of a joint."""
        dry = [self.Y.columns[c].row for c in self.estimated_columns if self.Y.columns[c].quantity == "FS"]
        rates, *noises = (self.Y.rates(dry, motion.q, qd) for qd in (motion.qd, *(x[1] for x in motion.twins)))
        fast, counted = filtering.moving(rates, noises, chosen), np.ones(motion.q.shape, dtype=bool)
        for k, row in enumerate(dry):
            counted[:, [i for i in self.Y.felt_by(row) if i not in motion.still]] &= fast[:, [k]]
        return counted

    def fixed_torques(self, motion: tuple[Array, Array, Array]) -> Array:
        """Return the torques of loads and fixed parameters at samples (N, n)."""
        fixed_torques: Array = self.Y.evaluate(*motion, list(self.fixed)) @ np.array(list(self.fixed.values()))
        return fixed_torques + self.Y.loads(motion[0])

    def _averages(self, sampled: Sampled, piece: slice) -> list[Array]:
        """Return averages of Y, of load and fixed torques, and of half the differences of Y between opposite noises."""
        motion, chosen = sampled.motion, sampled.chosen
        motions = [motion.part(piece)]
        for twin, sign in itertools.product(motion.twins, SIGNS):
            q, qd, qdd = (x + sign * dx[piece] for x, dx in zip(motions[0], twin, strict=True))
            motions.append((q, qd, qdd))
        columns = [self.Y.evaluate(*x, self.estimated_columns) for x in motions]
        halves = [(plus - minus) / 2 for plus, minus in zip(columns[1::2], columns[2::2], strict=True)]
        used = sampled.counted[piece].astype(float)
        fixed_torques = self.fixed_torques(motions[0]) * used
        both = [columns[0] * used[:, :, None], fixed_torques, *(x * used[:, :, None] for x in halves)]
        return [filtering.average(x, chosen) if chosen else x for x in both]


def _pieces(samples: int, chosen: filtering.Filter | None, most: int) -> list[slice]:
    """Return pieces of a record of about `most` samples that hold whole windows."""
    if chosen is None:
        return [slice(k, k + most) for k in range(0, samples, most)]
    starts, each = chosen.starts(samples), max(1, max(most, 2 * chosen.window) // chosen.step)
    firsts = [starts[k : k + each] for k in range(0, len(starts), each)]
    return [slice(some[0], some[-1] + chosen.window) for some in firsts]
