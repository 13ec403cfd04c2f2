"""Diagnostics of tests and models: bands of misfit, signs, units, cross-talk, windows, delays, spikes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.measured.fitting.corrections import MOST_NAMED
from symoro_elastic.measured.fitting.estimates import ROUNDING, TO_DEVIATION
from symoro_elastic.measured.vibration_tests.listed_tests import WRITTEN, laplace_of
from symoro_elastic.measured.vibration_tests.measured import NO_TEST, VibrationTest, Window, WindowKind
from symoro_elastic.measured.vibration_tests.misfit import Fit
from symoro_elastic.measured.vibration_tests.predictions import Lines, Predicted

LACKING = 3.0  # mean square of residuals in a band above which the model lacks something there
OPPOSITE = 2.5  # median phase error, rad, of a pair whose sign is wrong
MIRRORED = 0.3  # median relative distance from the opposite of the model, below which a pair is refused at once
SCALED = math.log(3.0)  # logarithm of a factor above which a size is reported
LEAST_CHI2 = 0.3  # mean square of residuals below which the noise is not what coherence and averages say
CROSS_TALK = 1e-3
"""Fraction of the largest output of an input, above which a response that is zero in the model is reported."""
SAME_FACTOR = 0.01  # difference of logarithms below which factors are called one, and no decrease is reported
WINDOWED = 0.3  # standard deviations by which an unnamed window changes a parameter, above which it is reported
COPIED = 1e-4  # relative distance of responses that are copies; no two measurements are that near
NORMAL = 1.5  # largest mean square of noise over the square of its deviation by the median
SPIKED = 0.002  # fraction of spikes that is reported
BANDS = 40  # bands of a test, evenly in the logarithm of frequency
FARTHEST_PEAK = 0.5  # relative distance beyond which a predicted peak is another one
FAR_OFF = math.log(300.0)  # logarithm of a factor above which no fit is tried
VANISHED = math.log(3e6)  # logarithm of a factor by which a response is zero
APART = 10.0  # mean square of a pair over the median of the others, above which it does not go with these
EXPLAINED = 0.2  # of the distance of a pair, the most that is left with the correction that is named
KNOWN_FACTORS = {
    9.80665: "g instead of m/s2",
    1e3: "mm instead of m",
    1e6: "um instead of m",
    2 * math.pi: "rad instead of turns",
}


def refuse_copies(tests: Sequence[VibrationTest]) -> None:
    """Raise `InputError` for a response that is in two tests with the same numbers: it would count twice."""
    earlier: list[tuple[ComplexArray, int]] = []
    for t, test in enumerate(tests):
        for response in test.responses:
            least = COPIED * np.median(np.abs(response.H))
            same = (k for H, k in earlier if k != t and H.shape == response.H.shape
                    and np.median(np.abs(response.H - H)) <= least)  # fmt: skip
            first = next(same, t)
            earlier.append((response.H, t))
            if first != t:
                what = f"has the same numbers as a response of {tests[first].name}: keep one"
                raise InputError(test.name, response.pair, what)


def refuse_without_phase(
    tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]
) -> None:
    """Raise `InputError` for a response without imaginary parts where that of the model has some."""
    for line in lines:
        G = line.predicted_by(predicted)
        if not line.H.imag.any() and (np.abs(G.imag) > ROUNDING * np.abs(G)).any():
            what = "has no imaginary part at any frequency, so it cannot show damping: give complex numbers, or "
            raise InputError(tests[line.test].name, line.measured.pair, f"{what}magnitudes headed mag with their phase")


def refuse_opposite(
    tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted], nearest: float = math.inf
) -> None:
    """Raise `InputError` for a pair whose phase is opposite to that of the model over its whole band.

    It is refused if it is as near to the opposite of the model as the median of |H + G| / |G| says.
    """
    for line in lines:
        G = line.predicted_by(predicted)
        error = float(np.median(np.abs(np.angle(line.H / G))))
        if error > OPPOSITE and float(np.median(np.abs(line.H / G + 1))) < nearest:
            pair = line.measured.pair
            what = f"{pair} has the opposite sign of the model: median phase error {math.degrees(error):.0f} deg; "
            what += f"write -{line.measured.output}, or turn the sensor's axis"
            raise InputError(tests[line.test].name, pair, what)


def refuse_wrong(tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]) -> None:
    """Raise `InputError` for pairs of opposite sign or in another unit, before corrections are searched."""
    refuse_opposite(tests, lines, predicted, MIRRORED)
    for line, factor in scaled_pairs(lines, predicted):
        if unit := _unit(factor):
            what = f"{_times(factor)}: its unit is wrong, {unit}"
            raise InputError(tests[line.test].name, line.measured.pair, what)


def refuse_far(tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]) -> None:
    """Raise `InputError` for pairs whose magnitude is far from the model's at any plausible stiffness."""
    for line, factor in scaled_pairs(lines, predicted):
        if abs(math.log(factor)) < FAR_OFF:
            continue
        logs = np.log(line.predicted_by(predicted) / line.H)
        mistake = _mistake(line, logs)
        what = f"is {factor:.3g} times the model over its whole band{mistake}"
        if math.log(factor) < -VANISHED and not mistake:
            what = "hardly moves, and its model does: another axis, body or input is measured, or nothing"
        raise InputError(tests[line.test].name, line.measured.pair, what)


def of_pairs(tests: Sequence[VibrationTest], fit: Fit, predicted: Sequence[Predicted]) -> list[str]:
    """Return a note for each pair that disagrees with the model much more than the others, with the likely mistake."""
    if len(fit.lines) < 2 or not (math.isnan(fit.chi2) or fit.chi2 > fit.far):
        return []
    logs = [np.log(line.predicted_by(predicted) / line.H) for line in fit.lines]
    weighted = (log * np.abs(line.H) / line.sd for log, line in zip(logs, fit.lines, strict=True))
    sizes = [float(np.median(np.abs(x))) ** 2 for x in weighted]
    notes = []
    for k, line in enumerate(fit.lines):
        usual = float(np.median(sizes[:k] + sizes[k + 1 :]))
        if sizes[k] > APART * max(usual, 1.0):
            times = float(np.median(np.exp(-logs[k].real)))
            way_out = (
                f", and is {times:.3g} times the model in the median: check its columns, unit, place and direction"
            )
            what = f"does not go with the other responses{_mistake(line, logs[k]) or way_out}"
            notes.append(f"{tests[line.test].name}: {line.measured.pair} {what}")
    return notes


def _mistake(line: Lines, logs: ComplexArray) -> str:
    """Return the usual mistake whose correction brings a pair close to the model; empty if none does."""
    G, s = line.H * np.exp(logs), laplace_of(line.f)
    distances = {what: float(np.median(np.abs(np.log(G / of(line.H, s))))) for what, of in WRITTEN.items()}
    best = min(distances, key=distances.__getitem__)
    return f": it is written {best}" if distances[best] < EXPLAINED * float(np.median(np.abs(logs))) else ""


def of_scale(tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]) -> list[str]:
    """Return a line for each pair whose size differs from the model's by one factor over the whole band."""
    return [
        f"{tests[line.test].name}: {line.measured.pair} {_times(factor)}: check its unit"
        for line, factor in scaled_pairs(lines, predicted)
    ]


def scaled_pairs(lines: Sequence[Lines], predicted: Sequence[Predicted]) -> Iterator[tuple[Lines, float]]:
    """Yield the responses that differ from the model by a constant factor, with this factor."""
    for line in lines:
        G = line.predicted_by(predicted)
        logs = np.log(np.abs(line.H / G))
        middle = float(np.median(logs))
        if abs(middle) > SCALED and float(np.median(np.abs(logs - middle))) < 0.2 * abs(middle):
            yield line, math.exp(middle)


def _times(factor: float) -> str:
    side = "larger" if factor > 1 else "smaller"
    return f"is {max(factor, 1 / factor):.3g} times {side} than the model over its whole band"


def _unit(factor: float, within: float = 0.06) -> str:
    """Return the unit mistake that explains a factor within this logarithm; empty for any other factor."""
    size = abs(math.log(factor))
    return next((what for x, what in KNOWN_FACTORS.items() if abs(size - math.log(x)) < within), "")


def of_zero_pairs(tests: Sequence[VibrationTest], zero: Sequence[tuple[int, int]]) -> list[str]:
    """Return notes on omitted responses that are zero in the model, with cross-talk where they were measured."""
    quiet, notes = [], []
    for t, k in zero:
        pair = f"{tests[t].name}: {tests[t].responses[k].pair}"
        if is_cross_talk(tests[t], k):
            what = "is omitted: the model predicts zero, the measurement does not (cross-talk)"
            notes.append(f"{pair} {what}")
        else:
            quiet.append(pair)
    return notes + ([f"omitted, zero in the model: {', '.join(quiet)}"] if quiet else [])


def is_cross_talk(test: VibrationTest, k: int) -> bool:
    """Whether a response, zero in the model, was measured as more than a small part of its input's largest one."""
    response = test.responses[k]
    largest = max(float(np.median(np.abs(x.H))) for x in test.responses if x.input == response.input)
    return bool(np.median(np.abs(response.H)) > CROSS_TALK * largest)


def of_lost_modes(tests: Sequence[VibrationTest], predicted: Sequence[Predicted]) -> list[str]:
    """Return a note for each test with measured modes that match no mode of the model, which are omitted."""
    notes = []
    for test, prediction in zip(tests, predicted, strict=True):
        if test.modes is None or prediction.modes is None or not (lost := ~np.isfinite(prediction.modes.f)).any():
            continue
        named = ", ".join(f"{f:.4g} Hz" for f in test.modes.f[lost])
        why = "the model has none or two similar" if test.modes.outputs else "the model has fewer modes"
        what = f"{lost.sum()} of {len(lost)} modes have no partner, and are left out: {named} ({why})"
        notes.append(f"{test.name}: {what}")
    return notes


@dataclass(frozen=True)
class Band:
    """Frequencies, Hz, between which residuals are large, and their mean square there."""

    low: float
    high: float
    chi2: float


def lacking(lines: Sequence[Lines], fit: Fit) -> list[Band]:
    """Return at most two bands of large residuals, where chi2 shows that the model is incomplete."""
    if not (lines and fit.chi2 > fit.far):
        return []
    f = np.concatenate([np.tile(line.f, 2) for line in lines])
    r2 = np.minimum(fit.residuals[: len(f)] ** 2, 1e12)
    if fit.spikes:
        r2[np.concatenate([np.tile(is_spike, 2) for is_spike in fit.spikes])] = 1.0
    edges = np.geomspace(f.min(), f.max() * (1 + 1e-9), BANDS + 1)
    place = np.clip(np.searchsorted(edges, f, side="right") - 1, 0, BANDS - 1)
    count = np.bincount(place, minlength=BANDS)
    means = np.bincount(place, r2, BANDS) / np.maximum(count, 1)
    large = np.flatnonzero(means > max(LACKING, means.max() / 10))
    runs = np.split(large, np.flatnonzero(np.diff(large) > 1) + 1) if len(large) else []
    largest = sorted(runs, key=lambda run: -float(means[run].max()))[:2]
    return [Band(float(edges[x[0]]), float(edges[x[-1] + 1]), float(means[x].mean())) for x in largest]


def verdict_on_model(fit: Fit, bands: Sequence[Band]) -> str:
    """Return the verdict of chi2 on the model in words."""
    if math.isnan(fit.chi2):
        return f"no coherence or no averages: {NO_TEST}"
    if fit.chi2 < LEAST_CHI2:
        what = "residuals are smaller than coherence and averages imply, so standard deviations are too wide"
        return f"chi2 {fit.chi2:.3g}: {what}: check both"
    if not fit.chi2 > fit.far:
        return f"chi2 {fit.chi2:.3g}: the model explains these tests within their noise{_nuisances_in_words(fit)}"
    r = np.abs(fit.residuals)
    if fit.wider == 1.0 and fit.chi2 < NORMAL * (TO_DEVIATION * float(np.median(r))) ** 2:
        what = "residuals are larger than coherence and averages imply, equally at all frequencies: check both"
        return f"chi2 {fit.chi2:.3g}: {what}; standard deviations are increased accordingly"
    named = " and ".join(f"between {band.low:.4g} and {band.high:.4g} Hz" for band in bands)
    what = f"chi2 {fit.chi2:.3g}: the model lacks something {named or 'over the whole band'}: "
    what += "a body, a spring or a mode that it does not have, masses that are right (--mass-doubt), positions and "
    what += "held motors as they were (at, hold), sensors along their axes, or a nearer start (--factor); "
    what += "standard deviations are lower bounds then"
    low, high = (bands[0].low, bands[0].high) if bands else (0.0, 0.0)
    return f"{what}; --without {low:.4g}:{high:.4g} leaves these lines out" if bands else what


def _nuisances_in_words(fit: Fit) -> str:
    """Return the nuisance parameters that were fitted, and their possible causes."""
    without = f"(chi2 {fit.chi2_alone:.3g} without them)"
    nuisances = f", with delays of channels {without}" if fit.delays else ""
    nuisances += f", with factors of channels {without}" if fit.gains else ""
    if not fit.largest_term:
        return nuisances
    return (
        f"{nuisances}, with smooth terms, up to {100 * fit.largest_term:.2g} % of a response {without}: "
        "modes outside the band, which standard deviations include, or wrong masses, which they do not (--mass-doubt)"
    )


def of_delays(tests: Sequence[VibrationTest], fit: Fit) -> list[str]:
    """Return a note for each test whose outputs have a significant delay relative to the model."""
    outputs: dict[str, list[str]] = {}
    for delay in fit.delays:
        if delay.is_significant:
            percent = f", {100 * math.expm1(-delay.fall):+.2g} % at its last line"
            what = f"{delay.output} by {1e3 * delay.seconds:.3g} ms{percent if abs(delay.fall) > SAME_FACTOR else ''}"
            outputs.setdefault(tests[delay.test].name, []).append(what)
    why = "delays, filters or the hold of a command are fitted with the model; measure input and output the same way"
    late = "outputs come later than those of the model"
    return [f"{name}: {late}: {', '.join(outs)}: {why}" for name, outs in outputs.items()]


def of_gains(tests: Sequence[VibrationTest], fit: Fit) -> list[str]:
    """Return a line for each test with the factors between its responses and those of the model."""
    factors: dict[str, list[tuple[str, float]]] = {}
    for gain in fit.gains:
        line, size = fit.lines[gain.line], math.exp(gain.log)
        factors.setdefault(tests[line.test].name, []).append((line.measured.pair, size if gain.is_significant else 1.0))
    notes = []
    for name, sizes_of_pairs in factors.items():
        sizes = np.array([size for _, size in sizes_of_pairs])
        if np.ptp(np.log(sizes)) < SAME_FACTOR:
            what = f"responses are {np.median(sizes):.4g} times those of the model"
        else:
            what = "responses are those of the model times "
            what += ", ".join(f"{size:.4g} ({pair})" for pair, size in sizes_of_pairs if size != 1)
        why = "factors are fitted with it: check sensitivities and units, or masses of the file"
        notes += [f"{name}: {what}: {why}"] if (sizes != 1).any() else []
    return notes


def of_spikes(tests: Sequence[VibrationTest], fit: Fit) -> list[str]:
    """Return a note for each test with outliers: lines far from noise between neighbours that are not."""
    notes = []
    for t, test in enumerate(tests):
        own = [(line, is_spike) for line, is_spike in zip(fit.lines, fit.spikes, strict=False) if line.test == t]
        count, of = sum(int(is_spike.sum()) for _, is_spike in own), sum(len(is_spike) for _, is_spike in own)
        if count > SPIKED * of:
            line, is_spike = max(own, key=lambda pair: int(pair[1].sum()))
            where = ", ".join(f"{f:.4g}" for f in line.f[is_spike][:MOST_NAMED])
            what = f"{count} of {of} lines are spikes between quiet neighbours"
            where = f"most in {line.measured.pair}, at {where} Hz"
            notes.append(f"{test.name}: {what}, {where}: they are down-weighted")
    return notes


def of_neighbours(fit: Fit) -> list[str]:
    """Return a line about correlated residuals of neighbouring frequencies."""
    if fit.wider == 1.0:
        return []
    what = "as those of a window (Hann) are, or of a model that lacks something"
    wider = f"standard deviations are {fit.wider:.2g} times wider"
    return [f"residuals of neighbouring lines are correlated, {what}: {wider}"]


def of_windows(listed: Sequence[VibrationTest], fit: Fit, labels: Sequence[str]) -> list[str]:
    """Return a line about windows that residuals indicate or allow, and the values under them."""
    std, notes = fit.std, []
    estimated = [k for k, (a, b) in enumerate(zip(listed, fit.tests, strict=True)) if a.window is not b.window]
    for k in estimated:
        indicated = _window_name(fit.tests[k].window, fit.windows.get(k, 0.0))
        what = f"{_window_of_list(listed[k])}, and residuals indicate {indicated}; it is estimated"
        notes.append(f"{listed[k].name}: {what}")
    for doubt in fit.alternatives:
        k = int(np.argmax(np.abs(doubt.shift) / std))
        if abs(doubt.shift[k]) > WINDOWED * std[k]:
            change = f"{labels[k]} is {100 * math.expm1(doubt.shift[k]):+.2g} %"
            included = f"which standard deviations {'' if doubt.counts else 'do not '}include"
            what = f"under {_window_name(doubt.window)}, {change}, {included}"
            names = ", ".join(listed[j].name for j in doubt.tests)
            notes.append(what if estimated else f"{names}: {_window_of_list(listed[doubt.tests[0]])}; {what}")
    ends = 'write window = "hann", { exponential = 0.12 } or "none"'
    return [f"{'; '.join(notes)}: {ends}"] if notes else []


def _window_of_list(test: VibrationTest) -> str:
    return "no window is named" if test.window is None else f"the list says {_window_name(test.window)}"


def _window_name(window: Window | None, std: float = 0.0) -> str:
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
