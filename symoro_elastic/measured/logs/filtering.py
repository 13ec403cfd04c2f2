"""Velocities and accelerations from sampled positions, and averages of both sides of tau = Y X.

The way of practitioners (Gautier 1997; Janot, Vandanjon and Gautier 2014): positions through a zero-phase
Butterworth filter well above the motion, central differences, then the same low-pass filter for both sides of
tau = Y X: averages under a Hann window, one row for each third of it. Averaging both sides alike changes no
parameter. The window ends, so samples where dry friction reverses can be left out of both sides exactly, and samples
need not be even: positions are filtered on an even clock, averages are of the samples that there are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.analysis.time_series.clocks import GAP, with_change
from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.analysis.time_series.resolution import density_of_staircase, resolution_of, staircase
from symoro_elastic.foundation.array_types import AnyArray, Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_identification

ORDER = 4  # of the Butterworth filter
ABOVE_MOTION = 5.0  # Butterworth cut-off over the motion's bandwidth
QUARTILE = 0.75  # of the joints are slower
KEPT_BAND = 2.0  # -6 dB of the averages over the motion's bandwidth: one over the length of the window
ROWS_IN_WINDOW = 3  # averages begin in each window
ENERGY = 0.99  # of the velocities lies within the motion's bandwidth
OVER_NOISE = 30.0  # what counts as motion, over the spectrum's floor
SLOW = 0.02  # of the largest velocity: dry friction may reverse
OVER_RATE_NOISE = 5.0  # standard deviations of the noise of velocities: the same
REVERSAL_REACH = 0.5  # periods of the Butterworth cut-off
FEWEST_OPEN = 0.2  # of the window that is not left out
HIGHEST_CUTOFF = 0.9  # of the Nyquist frequency
TWINS = (0.5, 0.25)  # of the sampling frequency: modulation that makes noise of the same law
STAIRCASES = 3  # twins of an encoder's staircase
DRAWS = 24  # of staircases, for standard deviations
FEWEST_STEPS = 6.0  # of an encoder that motion crosses in a period of the Butterworth cut-off
MOST_BESIDE = 2.0  # variance of an encoder's noise over that of its staircase alone
CLEAR_OF_MOTION = 4.0  # modulations over the Butterworth cut-off
CUBIC = 4  # coefficients, the fewest samples at a gap
CLOSE = 0.3  # steps: samples that are closer to the one before determine no slope, and are left out


@dataclass(frozen=True)
class Filter:
    """Settings: sampling, bandwidth of the motion and Butterworth cut-off in Hz; averages are of `window` samples,
    one every `step`."""

    sampling: float
    motion: float
    cutoff: float
    window: int
    step: int
    order: int = ORDER

    @property
    def trim(self) -> int:
        """Samples dropped at each end: the transients of the Butterworth filter and of the differences."""
        return int(np.ceil(2 * self.sampling / self.cutoff)) + 2

    @property
    def reach(self) -> int:
        """Samples on either side of a reversal that the Butterworth filter blurs."""
        return int(np.ceil(REVERSAL_REACH * self.sampling / self.cutoff))

    @property
    def correlation(self) -> tuple[float, ...]:
        """Correlation of averages of white noise under whole windows with those 0, 1, 2 ... rows later."""
        return tuple(float(x.sum()) for x in self.shared_weights)

    @cached_property
    def shared_weights(self) -> list[Array]:
        """Products of the weights of each sample that windows 0, 1, 2 ... rows apart share, over the sum of squares."""
        h = self.weights
        return [h[k:] * h[: len(h) - k] / (h @ h) for k in range(0, len(h), self.step)]

    @cached_property
    def weights(self) -> Array:
        """Hann window of sum 1."""
        hann: Array = 1 - np.cos(2 * np.pi * (np.arange(self.window) + 0.5) / self.window)
        weights: Array = hann / hann.sum()
        return weights

    @cached_property
    def sections(self) -> Array:
        """Sections of second order of the Butterworth filter."""
        design = for_identification("scipy.signal").butter
        sections: Array = design(self.order, self.cutoff, fs=self.sampling, output="sos")
        return sections

    def starts(self, samples: int) -> range:
        """Return the first samples of the averages."""
        return range(0, max(samples - self.window + 1, 0), self.step)

    def description(self) -> list[str]:
        """Return the settings as lines."""
        return [
            f"sampled at {self.sampling:.6g} Hz; {100 * ENERGY:g} % of the motion is below {self.motion:.3g} Hz",
            f"positions: zero-phase Butterworth, order {self.order}, {self.cutoff:.3g} Hz; "
            "central differences of fourth order",
            f"both sides: averages under a Hann window of {self.window} samples, one every {self.step}",
            f"{self.trim} samples dropped at each end",
        ]


@dataclass(frozen=True)
class FilteredMotion:
    """q, qd, qdd (N, n) of the moving joints, tau (N, m) of the motors; SI units, radians.

    `still` are joints (0-based) that do not move beyond the noise of their sensor: qd = qdd = 0. `twins` are noises
    of q, qd, qdd of the same law as that which the filter left in them, and independent of it; of joints in
    `staircases` they are those of encoders, which repeat with the motion.
    """

    t: Array
    q: Array
    qd: Array
    qdd: Array
    tau: Array
    still: tuple[int, ...] = ()
    twins: tuple[tuple[Array, Array, Array], ...] = ()
    staircases: tuple[int, ...] = ()

    def part(self, piece: slice) -> tuple[Array, Array, Array]:
        """Return the samples `piece` of q, qd, qdd."""
        return self.q[piece], self.qd[piece], self.qdd[piece]


def default_filter(measured: Measurements, motors: Sequence[int] = (), bandwidth: float | None = None) -> Filter:
    """Return cut-offs at 5 (Butterworth) and 2 (averages) times the bandwidth of the motion (rule of Janot).

    The motion's bandwidth is that of the fastest motor, or of the upper quartile of the joints if that is more: a
    local mode that rings does not set it. `motors` are 0-based; `bandwidth` in Hz replaces the estimate.
    """
    sampling = 1 / measured.period
    motion = bandwidth or _bandwidth(measured, motors)
    if not 0 < motion <= HIGHEST_CUTOFF * sampling / 2:
        what = f"motion up to {motion:.4g} Hz is sampled at {sampling:.4g} Hz: sample at least {5 * motion:.4g} Hz"
        if bandwidth is None:
            what += ", or give --bandwidth, that of the motion, if this is noise of positions"
        raise InputError(measured.source, "t", what)
    cutoff = min(ABOVE_MOTION * motion, HIGHEST_CUTOFF * sampling / 2)
    window = max(1, round(sampling / (KEPT_BAND * motion)))
    return Filter(sampling, motion, cutoff, window, max(1, round(window / ROWS_IN_WINDOW)))


def _bandwidth(measured: Measurements, motors: Sequence[int]) -> float:
    q = measured.q if measured.is_even else EvenClock(measured.t, measured.period).evenly(measured.q)
    bandwidths = [bandwidth_of(q[:, k], measured.period) for k in range(q.shape[1])]
    return max([sorted(bandwidths)[int(QUARTILE * len(bandwidths))], *(bandwidths[k] for k in motors)])


def bandwidth_of(x: Array, period: float) -> float:
    """Return the frequency in Hz below which 99 % of the energy of x's derivative lies, noise left out.

    The floor of the spectrum is its median over the upper half of the frequencies, or that of the encoder's staircase.
    """
    n = len(x)
    line = np.linspace(x[0], x[-1], n)
    spectrum = np.abs(np.fft.rfft((x - line) * np.hanning(n))) ** 2
    frequencies = np.fft.rfftfreq(n, period)
    floor = float(np.median(spectrum[len(spectrum) // 2 :]))
    if step := resolution_of(x):
        crowded = _crowding(spectrum[len(spectrum) // 2 :])
        floor = max(floor, crowded * density_of_staircase(x, step) * float((np.hanning(n) ** 2).sum()))
    power = np.where(spectrum > OVER_NOISE * floor, spectrum, 0.0) * frequencies**2
    lowest = float(frequencies[min(2, len(frequencies) - 1)])
    if not power.any():
        return lowest
    reached = np.searchsorted(np.cumsum(power), ENERGY * power.sum())
    return max(lowest, float(frequencies[min(int(reached), n // 2)]))


def _crowding(spectrum: Array) -> float:
    """Return the ratio of mean square to squared mean of a noise spectrum: 1 if white, more with few peaks."""
    mean = float(spectrum.mean())
    return max(1.0, float((spectrum**2).mean()) / (2 * mean**2)) if mean else 1.0


def differentiate(x: Array, period: float) -> tuple[Array, Array]:
    """Return two derivatives of x (N, ...) by central differences of fourth order; two samples lost each end."""
    before2, before, here, after, after2 = x[:-4], x[1:-3], x[2:-2], x[3:-1], x[4:]
    first = (8 * (after - before) - (after2 - before2)) / (12 * period)
    second = (16 * (after + before) - (after2 + before2) - 30 * here) / (12 * period**2)
    return first, second


def smooth(x: Array, chosen: Filter, record: Measurements | None = None) -> Array:
    """Return x (N, ...) through the zero-phase Butterworth filter, at the times of a record or even ones."""
    if record is None or record.is_even:
        return _butterworth(x, chosen)
    clock = EvenClock(record.t, 1 / chosen.sampling)
    return clock.at_samples(_butterworth(clock.evenly(x), chosen))


def _butterworth(x: Array, chosen: Filter) -> Array:
    signal, padded = for_identification("scipy.signal"), min(len(x) - 1, 2 * chosen.trim)
    filtered: Array = signal.sosfiltfilt(chosen.sections, x, axis=0, padlen=padded)
    return filtered


def average(x: AnyArray, chosen: Filter) -> Array:
    """Return averages of x (N, ...) under the window, (rows, ...)."""
    flat = x.reshape(len(x), -1)
    weights, window = chosen.weights, chosen.window
    rows = [weights @ flat[k : k + window] for k in chosen.starts(len(x))]
    return np.array(rows).reshape(len(rows), *x.shape[1:])


def shared_noise(counted: BoolArray, chosen: Filter) -> Array:
    """Return covariances of averages of white noise in the samples (N, n) that count with those 0, 1, 2 ... rows later,
    relative to the variance under whole windows, (lags, rows, n)."""
    starts = chosen.starts(len(counted))
    covariances = np.zeros((len(chosen.shared_weights), len(starts), counted.shape[1]))
    for lag, both in enumerate(chosen.shared_weights):
        for row, k in enumerate(starts[lag:]):
            covariances[lag, row] = both @ counted[k : k + len(both)]
    return covariances


def moving(rates: Array, noises: Sequence[Array], chosen: Filter | None) -> BoolArray:
    """Return a mask of samples (N, n) at which a joint is fast enough for Fs sign(qd) + Fv qd, from rates (N, n).

    Slow is less than 2 % of the joint's largest velocity or 5 standard deviations of the velocity's noise, within
    the reach of the Butterworth filter.
    """
    least = SLOW * np.abs(rates).max(axis=0)
    for noise in noises:
        least = np.maximum(least, OVER_RATE_NOISE * noise.std(axis=0))
    slow: BoolArray = np.asarray(np.abs(rates) <= least)
    if chosen is None:
        return ~slow
    reach = chosen.reach
    near: NDArray[np.int_] = np.cumsum(np.pad(slow, ((reach + 1, reach), (0, 0))), axis=0)
    fast: BoolArray = np.asarray(near[2 * reach + 1 :] == near[: -2 * reach - 1])
    return fast


def filtered_motion(record: Measurements, chosen: Filter) -> FilteredMotion:
    """Return filtered positions, their derivatives, and the unfiltered torques of the same samples.

    Measured velocities and accelerations replace differences, through the same filter. Joints whose
    filtered motion is within the noise that the filter removed are held still, so that noise is not excitation.
    """
    if len(record.t) < 2 * chosen.trim + 2:
        what = f"{len(record.t)} samples are too few to filter at {chosen.cutoff:.3g} Hz: measure longer"
        raise InputError(record.source, "t", what)
    cut = slice(chosen.trim, len(record.t) - chosen.trim)
    q, qd, qdd = _derivatives(record, chosen)
    twins, staircases = noises_like(record, chosen)
    still = list(still_joints(q, record.q[cut] - q))
    q[:, still] = q[:, still].mean(axis=0)
    for rates in (qd, qdd, *(x for twin in twins for x in twin)):
        rates[:, still] = 0.0
    return FilteredMotion(record.t[cut], q, qd, qdd, record.tau[cut], tuple(still), tuple(twins), staircases)


def _derivatives(record: Measurements, chosen: Filter) -> tuple[Array, Array, Array]:
    """Return filtered q, qd, qdd, without the transients at both ends."""
    if record.is_even:
        return _even_derivatives(record, chosen, chosen.trim)
    clock = EvenClock(record.t, 1 / chosen.sampling)
    lost = 2  # by differences
    even = _even_derivatives(with_change(record, clock.t, clock.evenly), chosen, lost)
    cut = slice(chosen.trim, len(record.t) - chosen.trim)
    q, qd, qdd = (clock.at_samples(np.pad(x, ((lost, lost), (0, 0)), mode="edge"))[cut] for x in even)
    return q, qd, qdd


def _even_derivatives(record: Measurements, chosen: Filter, trim: int) -> tuple[Array, Array, Array]:
    """Return filtered q, qd, qdd of even samples but for `trim` at each end."""
    cut, inner = slice(trim, len(record.t) - trim), slice(trim - 2, len(record.t) - trim - 2)
    q = _butterworth(record.q, chosen)
    qd, qdd = (x[inner] for x in differentiate(q, record.period))
    if record.qd is not None:
        measured = _butterworth(record.qd, chosen)
        qd, qdd = measured[cut], differentiate(measured, record.period)[0][inner]
    if record.qdd is not None:
        qdd = _butterworth(record.qdd, chosen)[cut]
    return q[cut], qd, qdd


def _carriers(chosen: Filter) -> list[float]:
    """Return the modulation frequencies, relative to sampling, that lie above the band of the motion."""
    return [share for share in TWINS if share * chosen.sampling >= CLEAR_OF_MOTION * chosen.cutoff]


def noises_like(
    record: Measurements, chosen: Filter, count: int = STAIRCASES, zeros: bool = False
) -> tuple[list[tuple[Array, Array, Array]], tuple[int, ...]]:
    """Return independent noise records of q, qd, qdd with the law of a record's noise, and joints with staircases.

    Where the staircase of an encoder is most of the noise they are `count` ones of other zeros along the same motion;
    with `zeros` their errors contain those of the zeros, at most half a step.
    """
    smoothed, carriers = smooth(record.q, chosen, record), _carriers(chosen)
    joints = range(record.q.shape[1])
    stairs = {k: _staircases(record, k, smoothed[:, k], chosen, count, zeros) for k in joints}
    stairs = {k: errors for k, errors in stairs.items() if errors}
    if not stairs:
        return [_derivatives(_modulated_record(record, chosen, share), chosen) for share in carriers], ()
    twins = []
    for i in range(count):
        twin = _modulated_record(record, chosen, carriers[i % len(carriers)]) if carriers else _silent(record)
        for k, errors in stairs.items():
            twin.q[:, k] = errors[i]
        twins.append(_derivatives(twin, chosen))
    return twins, tuple(stairs)


def _silent(record: Measurements) -> Measurements:
    """Return a record that is zero."""
    qd, qdd = (None if x is None else np.zeros_like(x) for x in (record.qd, record.qdd))
    return replace(record, q=np.zeros_like(record.q), qd=qd, qdd=qdd)


def _staircases(
    record: Measurements, joint: int, smoothed: Array, chosen: Filter, count: int, zeros: bool
) -> list[Array]:
    """Return errors of an encoder of the same steps and other zeros; none where there is more noise than its staircase.

    Errors are scaled up by a little additional noise.
    """
    q = record.q[:, joint]
    step = resolution_of(q)
    if not step:
        return []
    rng = np.random.default_rng(joint)
    phases = (rng.permutation(count) + rng.uniform()) / count
    errors = [staircase(smoothed, step, phase) for phase in phases]
    cut = slice(chosen.trim, len(q) - chosen.trim)
    variance = float((q - smoothed)[cut].var())
    alone = float(np.mean([(error - smooth(error, chosen, record))[cut].var() for error in errors]))
    if not alone or variance > MOST_BESIDE * alone:
        return []
    larger, zero = np.sqrt(max(variance / alone, 1.0)), step * (phases - np.round(phases)) * zeros
    return [error * larger + off for error, off in zip(errors, zero, strict=True)]


def _modulated_record(record: Measurements, chosen: Filter, share: float) -> Measurements:
    """Return the record modulated by `share` times the sampling frequency, faded in and out.

    Noise of the same density replaces the motion in the filter's band. Where sampling is uneven
    modulation would smear the motion over all frequencies, so what the filter passes is taken away before.
    """
    if not record.is_even:
        record = with_change(record, record.t, lambda x: x - smooth(x, chosen, record))
    k = np.arange(len(record.t))
    ramp = np.minimum(1.0, 2 * np.minimum(k, k[::-1]) / chosen.trim)
    carrier = (np.sqrt(2) * np.cos(2 * np.pi * share * k + np.pi / 4) * np.sin(np.pi / 2 * ramp) ** 2)[:, None]
    qd, qdd = (None if x is None else x * carrier for x in (record.qd, record.qdd))
    return replace(record, q=record.q * carrier, qd=qd, qdd=qdd)


def as_measured(measured: Measurements) -> FilteredMotion:
    """Return even measurements without filter; velocities and accelerations are differences where not measured."""
    velocity, acceleration = differentiate(measured.q, measured.period)
    inner = slice(2, len(measured.q) - 2)
    velocity = velocity if measured.qd is None else measured.qd[inner]
    acceleration = acceleration if measured.qdd is None else measured.qdd[inner]
    q = measured.q[inner]
    still = still_joints(q, np.zeros_like(q))
    return FilteredMotion(measured.t[inner], q, velocity, acceleration, measured.tau[inner], still)


def still_joints(smoothed: Array, removed: Array) -> tuple[int, ...]:
    """Return joints whose filtered motion is within the noise that was removed."""
    moved, noise = smoothed.std(axis=0), removed.std(axis=0)
    rounding = 1e-12 * np.abs(smoothed).max(axis=0)
    return tuple(int(k) for k in np.flatnonzero(moved <= np.maximum(noise, rounding)))


def notes_on_encoders(
    record: Measurements, motion: FilteredMotion, chosen: Filter | None, joints: Sequence[str]
) -> list[str]:
    """Return notes on joints whose noise is the staircase of their encoder, and on steps too coarse for a motion."""
    moved = [k for k in motion.staircases if k not in motion.still]
    if not moved or chosen is None:
        return []
    steps = {k: resolution_of(record.q[:, k]) for k in moved}
    rates = {k: float(np.sqrt(np.mean(motion.qd[:, k] ** 2))) / steps[k] for k in moved}
    named = ", ".join(f"{joints[k]} {steps[k]:.3g}" for k in moved)
    notes = [f"positions are whole steps of encoders, whose staircase is their noise: {named} (rad or m)"]
    for k in moved:
        if rates[k] < FEWEST_STEPS * chosen.cutoff:
            few = rates[k] / chosen.cutoff
            what = f"encoder of {joints[k]}: {few:.2g} steps pass in a period of {chosen.cutoff:.3g} Hz"
            way = "move it faster or farther, or measure it with a finer encoder"
            notes.append(f"{what}, so standard deviations are too small where they rest on this joint: {way}")
    return notes


class EvenClock:
    """Even times (K), s, over the span of uneven ones (N).

    Both ways are linear in what is sampled: cubics between samples, with slopes of parabolas through neighbours, right
    to the third order of the step and local, so that noise keeps its density in the band of the motion. Samples too
    close to determine a slope are left out. A cubic by least squares of the neighbours replaces missing samples.
    """

    def __init__(self, t: Array, period: float) -> None:
        self._at = t
        self.t: Array = t[0] + period * np.arange(int((t[-1] - t[0]) / period * (1 + 1e-12)) + 1)
        self._bridges = list(self._bridges_of_gaps(period))
        missing = [times for times, _, _ in self._bridges]
        times = np.concatenate([t, *missing])
        order = np.argsort(times, kind="stable")
        self._order = order[np.diff(times[order], prepend=-np.inf) >= CLOSE * period]
        self._times = times[self._order]

    def evenly(self, x: Array) -> Array:
        """Return x (N, ...) at the even times."""
        flat = x.reshape(len(x), -1)
        inserted = [weights @ flat[neighbours] for _, neighbours, weights in self._bridges]
        samples = np.concatenate([flat, *inserted])[self._order]
        slopes = np.gradient(samples, self._times, axis=0, edge_order=2)
        even: Array = for_identification("scipy.interpolate").CubicHermiteSpline(self._times, samples, slopes)(self.t)
        return even.reshape(len(self.t), *x.shape[1:])

    def at_samples(self, x: Array) -> Array:
        """Return x (K, ...), which is smooth, at the uneven times."""
        uneven: Array = for_identification("scipy.interpolate").CubicSpline(self.t, x)(self._at)
        return uneven

    def _bridges_of_gaps(self, period: float) -> Iterator[tuple[Array, slice, Array]]:
        """Yield times of missing samples, the slice of their neighbours, and the weights of these."""
        t = self._at
        steps = np.diff(t) / period
        for k in np.flatnonzero(steps > GAP):
            count = round(float(steps[k])) - 1
            if count < 1:
                continue
            reach = max(CUBIC, count + 1)
            neighbours = slice(max(0, k + 1 - reach), min(len(t), k + 1 + reach))
            times = t[k] + (t[k + 1] - t[k]) * np.arange(1, count + 1) / (count + 1)
            middle, size = (t[k] + t[k + 1]) / 2, reach * period
            powers = [np.vander((x - middle) / size, CUBIC) for x in (times, t[neighbours])]
            yield times, neighbours, powers[0] @ np.linalg.pinv(powers[1])
