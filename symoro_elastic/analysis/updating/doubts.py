"""What is wrong with a model or a test: bands where the model lacks something, signs, units, cross talk."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.updating.measured import VibrationTest
from symoro_elastic.analysis.updating.misfit import Fit, Lines
from symoro_elastic.analysis.updating.predictions import Predicted
from symoro_elastic.analysis.updating.windows import Window, WindowKind
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations

LACKING = 3.0
"""Mean square of residuals in a band above which the model lacks something there."""
OPPOSITE, MIRRORED = 2.5, 0.3
"""Median phase error, rad, of a pair whose sign is wrong; distance from the opposite that says so at once."""
SCALED = math.log(3.0)
"""Logarithm of a factor above which a size is said."""
LEAST_CHI2 = 0.3
"""Mean square of residuals below which the noise is not what coherence and averages say."""
CROSS_TALK = 1e-3
"""Of the largest measured output of an input, above which a response that cannot be is said."""
SAME_FACTOR = 0.01
"""Largest difference of logarithms of factors that are called one."""
WINDOWED = 0.3
"""Standard deviations by which a window that is not named changes a parameter, above which it is said."""
LEAST_DECREASE = 0.01
"""Of amplitudes at the last line of a channel: below it, it is not said."""
COPIED = 1e-4
"""Relative distance of responses that are copies; no two measurements are that near."""
NORMAL = 1.5
"""Largest mean square of noise over that of which its median is."""
SPIKED, MOST_SAID = 0.002, 3
"""Share of spikes that is said, and how many."""
BANDS = 40
FARTHEST_PEAK = 0.5
"""Relative distance beyond which a predicted peak is another one."""
KNOWN_FACTORS = {
    9.80665: "g instead of m/s2",
    1e3: "mm instead of m",
    1e6: "um instead of m",
    2 * math.pi: "rad instead of turns",
}


def refuse_copies(tests: Sequence[VibrationTest]) -> None:
    """Raise `InputError` for a response that is in two tests with the same numbers: it would count twice."""
    seen: list[tuple[ComplexArray, int]] = []
    for t, test in enumerate(tests):
        for one in test.responses:
            first = next((k for H, k in seen if k != t and _is_copy(one.H, H)), t)
            seen.append((one.H, t))
            if first != t:
                what = f"has the same numbers as a response of {tests[first].name}: keep one"
                raise InputError(test.name, one.pair, what)


def _is_copy(a: ComplexArray, b: ComplexArray) -> bool:
    """Whether two responses are the same but for the last digits of their files."""
    return a.shape == b.shape and bool(np.median(np.abs(a - b)) <= COPIED * np.median(np.abs(a)))


def refuse_opposite(
    tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted], nearest: float = math.inf
) -> None:
    """Raise `InputError` for a pair whose phase is opposite to that of the model over its whole band.

    It is refused if it is as near to the opposite of the model as the median of |H + G| / |G| says.
    """
    for line in lines:
        G = predicted[line.test].responses[line.place].G[line.counted]
        error = float(np.median(np.abs(np.angle(line.H / G))))
        if error > OPPOSITE and float(np.median(np.abs(line.H / G + 1))) < nearest:
            pair = line.measured.pair
            what = f"{pair} has the opposite sign of the model: median phase error {math.degrees(error):.0f} deg; "
            what += f"write -{line.measured.output}, or turn the sensor's axis"
            raise InputError(tests[line.test].name, pair, what)


def refuse_wrong(tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]) -> None:
    """Raise `InputError` for pairs that are the opposite of the model, or in another unit, before more is tried."""
    refuse_opposite(tests, lines, predicted, MIRRORED)
    for line, factor in scaled_pairs(lines, predicted):
        if unit := _unit(factor):
            what = f"{_times(factor)}: its unit is wrong, {unit}"
            raise InputError(tests[line.test].name, line.measured.pair, what)


def of_scale(tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]) -> list[str]:
    """Return a line for each pair whose size differs from the model's by one factor over the whole band."""
    return [
        f"{tests[line.test].name}: {line.measured.pair} {_times(factor)}: check its unit"
        for line, factor in scaled_pairs(lines, predicted)
    ]


def scaled_pairs(lines: Sequence[Lines], predicted: Sequence[Predicted]) -> Iterator[tuple[Lines, float]]:
    """Yield lines that are the model's, times a factor."""
    for line in lines:
        G = predicted[line.test].responses[line.place].G[line.counted]
        logs = np.log(np.abs(line.H / G))
        middle = float(np.median(logs))
        if abs(middle) > SCALED and float(np.median(np.abs(logs - middle))) < 0.2 * abs(middle):
            yield line, math.exp(middle)


def _times(factor: float) -> str:
    side = "larger" if factor > 1 else "smaller"
    return f"is {max(factor, 1 / factor):.3g} times {side} than the model over its whole band"


def _unit(factor: float, within: float = 0.06) -> str:
    """Return the mistake that a factor is of, within this logarithm; nothing for any other factor."""
    size = abs(math.log(factor))
    return next((what for x, what in KNOWN_FACTORS.items() if abs(size - math.log(x)) < within), "")


def of_zero_pairs(tests: Sequence[VibrationTest], zero: Sequence[tuple[int, int]]) -> list[str]:
    """Return lines about responses that the model cannot have: left out, cross talk where they were measured."""
    quiet, found = [], []
    for t, k in zero:
        pair = f"{tests[t].name}: {tests[t].responses[k].pair}"
        if is_cross_talk(tests[t], k):
            what = "is zero in the model, and left out: the measurement has cross talk that the model cannot have"
            found.append(f"{pair} {what}")
        else:
            quiet.append(pair)
    return found + ([f"zero in the model, and left out: {', '.join(quiet)}"] if quiet else [])


def is_cross_talk(test: VibrationTest, k: int) -> bool:
    """Whether a response that the model cannot have was measured, beside others of its input."""
    one = test.responses[k]
    largest = max(float(np.median(np.abs(x.H))) for x in test.responses if x.input == one.input)
    return bool(np.median(np.abs(one.H)) > CROSS_TALK * largest)


def of_lost_modes(tests: Sequence[VibrationTest], predicted: Sequence[Predicted]) -> list[str]:
    """Return a line for each test with measured modes that have no partner in the model, which are left out."""
    found = []
    for test, one in zip(tests, predicted, strict=True):
        if test.modes is None or one.modes is None or not (lost := ~np.isfinite(one.modes.f)).any():
            continue
        named = ", ".join(f"{f:.4g} Hz" for f in test.modes.f[lost])
        why = "none of the model is like them, or two are alike" if test.modes.outputs else "the model has fewer modes"
        found.append(
            f"{test.name}: {lost.sum()} of {len(lost)} modes have no partner, and are left out: {named} ({why})"
        )
    return found


@dataclass(frozen=True)
class Band:
    """Frequencies, Hz, between which residuals are large, and their mean square there."""

    low: float
    high: float
    chi2: float


def lacking(lines: Sequence[Lines], fit: Fit) -> list[Band]:
    """Return the bands of the largest residuals, at most two, where chi2 says that the model lacks something."""
    if not (lines and fit.chi2 > fit.far):
        return []
    f = np.concatenate([np.tile(line.f, 2) for line in lines])
    r2 = np.minimum(fit.residuals[: len(f)] ** 2, 1e12)
    if fit.spikes:
        r2[np.concatenate([np.tile(one, 2) for one in fit.spikes])] = 1.0
    edges = np.geomspace(f.min(), f.max() * (1 + 1e-9), BANDS + 1)
    place = np.clip(np.searchsorted(edges, f, side="right") - 1, 0, BANDS - 1)
    count = np.bincount(place, minlength=BANDS)
    means = np.bincount(place, r2, BANDS) / np.maximum(count, 1)
    found: list[Band] = []
    left = means.copy()
    while len(found) < 2 and left.max() > max(LACKING, means.max() / 10):
        low = high = int(left.argmax())
        while low > 0 and left[low - 1] > left[high] / 3 and left[low - 1] > LACKING:
            low -= 1
        peak = float(left[low : high + 1].max())
        while high < BANDS - 1 and left[high + 1] > peak / 3 and left[high + 1] > LACKING:
            high += 1
        found.append(Band(float(edges[low]), float(edges[high + 1]), float(means[low : high + 1].mean())))
        left[max(low - 1, 0) : high + 2] = 0.0
    return found


def verdict_on_model(fit: Fit, bands: Sequence[Band]) -> str:
    """Return chi2 read aloud."""
    if math.isnan(fit.chi2):
        return "the noise is not known (no coherence or no averages): residuals tell it, so chi2 says nothing"
    if fit.chi2 < LEAST_CHI2:
        what = "residuals are smaller than coherence and averages say, so standard deviations are too wide"
        return f"chi2 {fit.chi2:.3g}: {what}: check both"
    if not fit.chi2 > fit.far:
        return f"chi2 {fit.chi2:.3g}: the model explains these tests within their noise{_beside(fit)}"
    if _is_noise(fit):
        what = "residuals are larger than coherence and averages say, alike at all frequencies: check both"
        return f"chi2 {fit.chi2:.3g}: {what}; standard deviations are wider by what residuals say"
    named = " and ".join(f"between {band.low:.4g} and {band.high:.4g} Hz" for band in bands)
    what = f"chi2 {fit.chi2:.3g}: the model lacks something {named or 'over the whole band'}: "
    what += "a body, a spring or a mode that it does not have, masses that are right (--mass-doubt), positions and "
    what += "held motors as they were (at, hold), sensors along their axes, or a nearer start (--factor); "
    what += "standard deviations are lower bounds then"
    low, high = (bands[0].low, bands[0].high) if bands else (0.0, 0.0)
    return f"{what}; --without {low:.4g}:{high:.4g} leaves these lines out" if bands else what


def _is_noise(fit: Fit) -> bool:
    """Whether large residuals are those of noise: neighbours are not alike, and few are far above the median."""
    r = np.abs(fit.residuals)
    return fit.wider == 1.0 and fit.chi2 < NORMAL * (1.4826 * float(np.median(r))) ** 2


def _beside(fit: Fit) -> str:
    """Return what was fitted beside the model, and what it may stand for."""
    without = f"(chi2 {fit.chi2_alone:.3g} without them)"
    found = f", with delays of channels beside it {without}" if fit.delays else ""
    found += f", with factors of channels beside it {without}" if fit.gains else ""
    if not fit.beside:
        return found
    return (
        f"{found}, with smooth terms beside it, up to {100 * fit.beside:.2g} % of a response {without}: modes outside "
        "the band, which standard deviations know of, or masses that are wrong, which they do not know of "
        "(--mass-doubt)"
    )


def of_delays(tests: Sequence[VibrationTest], fit: Fit) -> list[str]:
    """Return a line for each test whose outputs come later than those of the model by more than doubt explains."""
    found: dict[str, list[str]] = {}
    for one in fit.delays:
        if one.shows:
            fall = f", {100 * math.expm1(-one.fall):+.2g} % at its last line" if abs(one.fall) > LEAST_DECREASE else ""
            found.setdefault(tests[one.test].name, []).append(f"{one.output} by {1e3 * one.seconds:.3g} ms{fall}")
    why = "delays, filters or the hold of a command are fitted beside the model; measure input and output alike"
    late = "outputs come later than those of the model"
    return [f"{name}: {late}: {', '.join(outs)}: {why}" for name, outs in found.items()]


def of_gains(tests: Sequence[VibrationTest], fit: Fit) -> list[str]:
    """Return a line for each test with the factors between its responses and those of the model."""
    found: dict[str, list[tuple[str, float]]] = {}
    for one in fit.gains:
        line, size = fit.lines[one.line], math.exp(one.log)
        found.setdefault(tests[line.test].name, []).append((line.measured.pair, size if one.shows else 1.0))
    said = []
    for name, each in found.items():
        sizes = np.array([size for _, size in each])
        if np.ptp(np.log(sizes)) < SAME_FACTOR:
            what = f"responses are {np.median(sizes):.4g} times those of the model"
        else:
            what = "responses are those of the model times "
            what += ", ".join(f"{size:.4g} ({pair})" for pair, size in each if size != 1)
        why = "factors are fitted beside it: check sensitivities and units, or masses of the file"
        said += [f"{name}: {what}: {why}"] if (sizes != 1).any() else []
    return said


def of_spikes(tests: Sequence[VibrationTest], fit: Fit) -> list[str]:
    """Return a line for each test with lines that are far from noise between neighbours that are not."""
    found = []
    for t, test in enumerate(tests):
        own = [(line, one) for line, one in zip(fit.lines, fit.spikes, strict=False) if line.test == t]
        count, of = sum(int(one.sum()) for _, one in own), sum(len(one) for _, one in own)
        if count > SPIKED * of:
            line, one = max(own, key=lambda pair: int(pair[1].sum()))
            where = ", ".join(f"{f:.4g}" for f in line.f[one][:MOST_SAID])
            what = f"{count} of {of} lines are spikes between quiet neighbours"
            where = f"most in {line.measured.pair}, at {where} Hz"
            found.append(f"{test.name}: {what}, {where}: they hardly count")
    return found


def of_neighbours(fit: Fit) -> list[str]:
    """Return a line about residuals of neighbouring lines that are alike."""
    if fit.wider == 1.0:
        return []
    what = "as those of a window (Hann) are, or of a model that lacks something"
    return [f"residuals of neighbouring lines are alike, {what}: standard deviations are {fit.wider:.2g} times wider"]


def of_windows(given: Sequence[VibrationTest], fit: Fit, labels: Sequence[str]) -> list[str]:
    """Return a line about windows that residuals tell, or that may be where none is named, and what they change."""
    std, found = np.sqrt(np.diag(fit.covariance)), []
    taken = [k for k, (a, b) in enumerate(zip(given, fit.tests, strict=True)) if a.window is not b.window]
    for k in taken:
        told = _called(fit.tests[k].window, fit.windows.get(k, 0.0))
        found.append(f"{given[k].name}: {_named(given[k])}, and residuals tell {told}, which is fitted")
    for doubt in fit.under:
        k = int(np.argmax(np.abs(doubt.shift) / std))
        if abs(doubt.shift[k]) > WINDOWED * std[k]:
            known = f"which standard deviations {'' if doubt.counts else 'do not '}know of"
            what = f"under {_called(doubt.window)}, {labels[k]} is {100 * math.expm1(doubt.shift[k]):+.2g} %, {known}"
            names = ", ".join(given[j].name for j in doubt.tests)
            found.append(what if taken else f"{names}: {_named(given[doubt.tests[0]])}; {what}")
    ends = 'write window = "hann", { exponential = 0.12 } or "none"'
    return [f"{'; '.join(found)}: {ends}"] if found else []


def _named(test: VibrationTest) -> str:
    return "no window is named" if test.window is None else f"the list says {_called(test.window)}"


def _called(window: Window | None, std: float = 0.0) -> str:
    """Return a window in words; `std` is of its change."""
    if window is None:
        return "none"
    if window.kind is WindowKind.HANN:
        return f"Hann's of {window.segment:.4g} s"
    if not math.isfinite(window.decay):
        return "none"
    doubt = f" +- {std * window.unit * window.decay**2:.1g}" if std else ""
    return f"an exponential one of {window.decay:.4g}{doubt} s"


def errors(measured: ComplexArray, predicted: ComplexArray) -> float:
    """Return the median distance of two responses, dB."""
    there = (np.abs(measured) > 0) & (np.abs(predicted) > 0)
    return float(np.median(np.abs(20 * np.log10(np.abs(predicted[there]) / np.abs(measured[there])))))


def peak_errors(f: Array, measured: ComplexArray, predicted: ComplexArray) -> float:
    """Return the median relative distance of measured peaks from the nearest predicted ones, NaN without any near."""
    own, other = _peaks(f, measured), _peaks(f, predicted)
    if not len(own) or not len(other):
        return math.nan
    apart = np.abs(other - own[:, None]).min(axis=1) / own
    near = apart[apart < FARTHEST_PEAK]
    return float(np.median(near)) if len(near) else math.nan


def frequency_errors(measured: Array, predicted: Array) -> float:
    """Return the median relative distance of frequencies from those of the modes that belong to them."""
    apart = np.abs(predicted / measured - 1)
    return float(np.median(apart[np.isfinite(apart)])) if np.isfinite(apart).any() else math.nan


def _peaks(f: Array, H: ComplexArray) -> Array:
    """Return the frequencies of peaks of 6 dB, from parabolas through their three highest lines."""
    dB = 20 * np.log10(np.maximum(np.abs(H), np.finfo(float).tiny))
    places, _ = for_vibrations("scipy.signal").find_peaks(dB, prominence=6.0)
    before, here, after = dB[places - 1], dB[places], dB[places + 1]
    shift = 0.5 * (before - after) / (before - 2 * here + after)
    x: Array = np.exp(np.interp(places + shift, np.arange(len(f)), np.log(f)))
    return x
