"""Velocities and accelerations from sampled positions, and decimation to the information in them.

The way of practitioners (Gautier 1997; Janot, Vandanjon and Gautier 2014): positions through a zero-phase
Butterworth filter well above the motion, central differences, then one low-pass filter for both sides of
tau = Y X ("parallel decimation") and one sample in `factor` kept. Filtering both sides alike changes no
parameter; it removes torque ripple and makes the residuals nearly white, which standard deviations need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.array_types import AnyArray, Array, BoolArray
from symoro_elastic.errors import InputError
from symoro_elastic.packages import for_identification
from symoro_elastic.time_series.measurements import Measurements

ORDER = 4
ABOVE_MOTION = 5.0  # Butterworth cut-off over the motion's bandwidth
QUARTILE = 0.75  # of the joints are slower
KEPT_BAND = 2.0  # band kept by decimation over the motion's bandwidth
ENERGY = 0.99  # of the velocities lies within the motion's bandwidth
OVER_NOISE = 30.0  # what counts as motion, over the spectrum's floor
RIPPLE, DECIMATION_ORDER, OF_NYQUIST = 0.05, 8, 0.8  # as scipy.signal.decimate
EDGE = 6  # kept samples
SLOW, REVERSAL_REACH = 0.02, 1.5  # of the largest velocity; in kept samples
HIGHEST_CUTOFF = 0.9  # of the Nyquist frequency


@dataclass(frozen=True)
class Filter:
    """Settings: sampling, bandwidth of the motion and Butterworth cut-off in Hz; one sample in `factor` is kept."""

    sampling: float
    motion: float
    cutoff: float
    factor: int
    order: int = ORDER

    @property
    def kept_band(self) -> float:
        """Cut-off of the decimation filter, Hz."""
        return OF_NYQUIST * self.sampling / (2 * self.factor)

    @property
    def trim(self) -> int:
        """Samples dropped at each end: the transients of the Butterworth filter and of the differences."""
        return int(np.ceil(2 * self.sampling / self.cutoff)) + 2

    def described(self) -> list[str]:
        """Return the settings as lines."""
        return [
            f"sampled at {self.sampling:.6g} Hz; {100 * ENERGY:g} % of the motion is below {self.motion:.3g} Hz",
            f"positions: zero-phase Butterworth, order {self.order}, {self.cutoff:.3g} Hz; "
            "central differences of fourth order",
            f"both sides: zero-phase low-pass at {self.kept_band:.3g} Hz, one sample in {self.factor} kept",
            f"{self.trim} samples dropped at each end",
        ]


@dataclass(frozen=True)
class FilteredMotion:
    """q, qd, qdd (N, n) of the moving joints, tau (N, m) of the motors; SI units, radians.

    `still` are joints (0-based) that do not move beyond the noise of their sensor: qd = qdd = 0. `noise` (n) is
    the standard deviation of white sensor noise in the unfiltered positions.
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    still: tuple[int, ...] = ()
    noise: Array | None = None

    def disturbed(self, chosen: Filter, sign: float, seed: int = 0) -> FilteredMotion:
        """Return the motion with as much sensor noise added, through the same filter; still joints stay."""
        if self.noise is None:
            return self
        rng = np.random.default_rng(seed)
        samples = len(self.t) + 2 * chosen.trim
        white = smooth(sign * self.noise * rng.standard_normal((samples, self.q.shape[1])), chosen)
        white[:, list(self.still)] = 0.0
        velocity, acceleration = differentiate(white, 1 / chosen.sampling)
        cut, inner = (
            slice(chosen.trim - 2, len(velocity) - (chosen.trim - 2)),
            slice(chosen.trim, samples - chosen.trim),
        )
        return replace(self, q=self.q + white[inner], qd=self.qd + velocity[cut], qdd=self.qdd + acceleration[cut])


def default_filter(measured: Measurements, motors: Sequence[int] = (), bandwidth: float | None = None) -> Filter:
    """Return cut-offs at 5 (Butterworth) and 2 (decimation) times the bandwidth of the motion (rule of Janot).

    The motion's bandwidth is that of the fastest motor, or of the upper quartile of the joints if that is more: a
    local mode that rings does not set it. `motors` are 0-based; `bandwidth` in Hz replaces what is found.
    """
    sampling = 1 / measured.period
    motion = bandwidth or _bandwidth(measured, motors)
    if not 0 < motion <= HIGHEST_CUTOFF * sampling / 2:
        what = f"motion up to {motion:.4g} Hz is sampled at {sampling:.4g} Hz: sample at least {5 * motion:.4g} Hz"
        raise InputError(measured.source, "t", what)
    cutoff = min(ABOVE_MOTION * motion, HIGHEST_CUTOFF * sampling / 2)
    factor = max(1, int(OF_NYQUIST * sampling / 2 / (KEPT_BAND * motion)))
    return Filter(sampling, motion, cutoff, factor)


def _bandwidth(measured: Measurements, motors: Sequence[int]) -> float:
    each = [bandwidth_of(measured.q[:, k], measured.period) for k in range(measured.q.shape[1])]
    return max([sorted(each)[int(QUARTILE * len(each))], *(each[k] for k in motors)])


def bandwidth_of(x: Array, period: float) -> float:
    """Return the frequency in Hz below which 99 % of the energy of x's derivative lies, noise left out.

    The floor of the spectrum is its median over the upper half of the frequencies.
    """
    n = len(x)
    line = np.linspace(x[0], x[-1], n)
    spectrum = np.abs(np.fft.rfft((x - line) * np.hanning(n))) ** 2
    frequencies = np.fft.rfftfreq(n, period)
    floor = float(np.median(spectrum[len(spectrum) // 2 :]))
    power = np.where(spectrum > OVER_NOISE * floor, spectrum, 0.0) * frequencies**2
    lowest = float(frequencies[min(2, len(frequencies) - 1)])
    if not power.any():
        return lowest
    reached = np.searchsorted(np.cumsum(power), ENERGY * power.sum())
    return max(lowest, float(frequencies[min(int(reached), n // 2)]))


def differentiate(x: Array, period: float) -> tuple[Array, Array]:
    """Return two derivatives of x (N, ...) by central differences of fourth order; two samples lost each end."""
    before2, before, here, after, after2 = x[:-4], x[1:-3], x[2:-2], x[3:-1], x[4:]
    first = (8 * (after - before) - (after2 - before2)) / (12 * period)
    second = (16 * (after + before) - (after2 + before2) - 30 * here) / (12 * period**2)
    return first, second


def smooth(x: Array, chosen: Filter) -> Array:
    """Return x (N, ...) through the zero-phase Butterworth filter."""
    signal = for_identification("scipy.signal")
    sections = signal.butter(chosen.order, chosen.cutoff, fs=chosen.sampling, output="sos")
    return _both_ways(signal, sections, x, chosen)


def decimate(x: Array, chosen: Filter) -> Array:
    """Return x (N, ...) through the filter of scipy.signal.decimate, zero phase, one sample in `factor`.

    By second-order sections, which stay accurate at large factors. Edges are trimmed.
    """
    if chosen.factor == 1:
        return x
    signal = for_identification("scipy.signal")
    sections = signal.cheby1(DECIMATION_ORDER, RIPPLE, OF_NYQUIST / chosen.factor, output="sos")
    filtered = _both_ways(signal, sections, x, chosen) * 10 ** (RIPPLE / 10)
    return thin(filtered, chosen)


def reverses(qd: Array, chosen: Filter | None) -> BoolArray:
    """Return a mask of kept samples (samples, n) near which a joint is too slow for Fs sign(qd) + Fv qd.

    Slow is less than 2 % of the joint's largest velocity, within the reach of the decimation filter.
    """
    slow: BoolArray = np.asarray(np.abs(qd) <= SLOW * np.abs(qd).max(axis=0))
    if chosen is None or chosen.factor == 1:
        return slow
    reach = int(REVERSAL_REACH * chosen.factor)
    near: NDArray[np.int_] = np.cumsum(np.pad(slow, ((reach + 1, reach), (0, 0))), axis=0)
    slow_nearby: BoolArray = np.asarray(near[2 * reach + 1 :] > near[: -2 * reach - 1])
    return thin(slow_nearby, chosen)


def thin(x: AnyArray, chosen: Filter) -> AnyArray:
    """Return one sample in `factor`, without the transients of the decimation filter at both ends."""
    if chosen.factor == 1:
        return x
    kept: AnyArray = x[:: chosen.factor]
    edge = min(EDGE, len(kept) // 8)
    return kept[edge : len(kept) - edge]


def _both_ways(signal: Any, sections: Array, x: Array, chosen: Filter) -> Array:
    padding = min(len(x) - 1, max(int(3 * chosen.factor), 3 * (2 * len(sections) + 1)))
    filtered: Array = signal.sosfiltfilt(sections, x, axis=0, padlen=padding)
    return filtered


def filtered_motion(record: Measurements, chosen: Filter) -> FilteredMotion:
    """Return filtered positions, their derivatives, and the unfiltered torques of the same samples.

    Measured velocities and accelerations take the place of differences, through the same filter. Joints whose
    filtered motion is within the noise that the filter removed are held still, so that noise is no excitation.
    """
    q = smooth(record.q, chosen)
    velocity, acceleration = differentiate(q, record.period)
    inner = slice(2, len(q) - 2)
    if record.qd is not None:
        measured = smooth(record.qd, chosen)
        velocity, acceleration = measured[inner], differentiate(measured, record.period)[0]
    if record.qdd is not None:
        acceleration = smooth(record.qdd, chosen)[inner]
    cut = slice(chosen.trim - 2, len(velocity) - (chosen.trim - 2))
    if len(velocity[cut]) < 2:
        what = f"{len(record.t)} samples are too few to filter at {chosen.cutoff:.3g} Hz: measure longer"
        raise InputError(record.source, "t", what)
    positions, rates, rates2 = q[inner][cut], velocity[cut].copy(), acceleration[cut].copy()
    removed = record.q[inner][cut] - positions
    still = _still(positions, removed)
    noise = removed.std(axis=0) / np.sqrt(1 - 2 * chosen.cutoff / chosen.sampling)
    for k in still:
        positions[:, k] = positions[:, k].mean()
        rates[:, k] = rates2[:, k] = 0.0
    return FilteredMotion(record.t[inner][cut], positions, rates, rates2, record.tau[inner][cut], still, noise)


def as_measured(measured: Measurements) -> FilteredMotion:
    """Return measurements without filter; velocities and accelerations are differences where not measured."""
    velocity, acceleration = differentiate(measured.q, measured.period)
    inner = slice(2, len(measured.q) - 2)
    velocity = velocity if measured.qd is None else measured.qd[inner]
    acceleration = acceleration if measured.qdd is None else measured.qdd[inner]
    q = measured.q[inner]
    still = _still(q, np.zeros_like(q))
    return FilteredMotion(measured.t[inner], q, velocity, acceleration, measured.tau[inner], still)


def _still(smoothed: Array, removed: Array) -> tuple[int, ...]:
    moved, noise = smoothed.std(axis=0), removed.std(axis=0)
    rounding = 1e-12 * np.abs(smoothed).max(axis=0)
    return tuple(int(k) for k in np.flatnonzero(moved <= np.maximum(noise, rounding)))
