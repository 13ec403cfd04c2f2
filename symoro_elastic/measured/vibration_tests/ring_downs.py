"""Natural frequencies and damping ratios from ring-downs: sums of decaying exponentials by least squares.

    y_c(t) = b_c + sum_k Re(A_ck e^(lambda_k t)) + noise,    lambda = -zeta w + i w sqrt(1 - zeta^2)

A mode is added at the highest peak of the residual, then all poles are fitted together with amplitudes eliminated
(variable projection, Golub and Pereyra 1973; the search is RELAX of Li and Stoica 1996). Another mode is taken while it
lowers Schwarz's criterion. For white noise, of any size in each signal, this is maximum likelihood, and the inverse of
the information matrix is the covariance of the poles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.time_series.column_faults import stays
from symoro_elastic.analysis.time_series.measurements import UNEVEN
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.fitting.estimates import MOST_STEPS, ROUNDING
from symoro_elastic.measured.vibration_tests.measured import MeasuredModes

FEWEST = 50  # samples
MOST = 50_000  # samples
MOST_MODES = 12
STARTS = (0.002, 0.01, 0.03, 0.1)  # damping ratios
PADDED = 4  # times as many lines as samples
CONVERGED = 1e-6  # relative step of poles that ends a fit
SHORTEST = 1e-3  # of a step, which ends a fit
MOST_GROWTH = 300.0  # exponent: more overflows
SURE = 2.0  # standard deviations from zero of the decay of a mode
PERIODS = 2.0  # of a mode in a record
DECAYED = 0.3  # exponent by which a mode falls in a record


@dataclass(frozen=True)
class _Fit:
    """Fit of a ring-down: decay rates and angular frequencies (k, 2) in 1/s, amplitudes (k, C), residuals (N, C), their
    standard deviations (C,), and -2 ln of their likelihood."""

    poles: Array
    amplitudes: ComplexArray
    residuals: Array
    sizes: Array
    misfit: float
    slopes: Array
    """Of the residuals in units of the noise, all signals below each other, by the poles."""


def modes_of_ring_down(
    t: Array, signals: Mapping[str, Array], band: tuple[float, float], source: str
) -> tuple[MeasuredModes, list[str]]:
    """Return the modes of a ring-down with their standard deviations and shapes, and notes about what was left out.

    Signals (N) by output; t (N), s, evenly spaced. Raises `InputError` for records that are no ring-downs: uneven,
    too short, without a vibration above the noise, or without decay.
    """
    _refuse_record(t, signals, source)
    t, signals, notes = _within_range(t, signals)
    _refuse_record(t, signals, source)
    even = np.arange(len(t), dtype=float) * (float(t[-1] - t[0]) / (len(t) - 1))
    fit = _modes(even, np.stack([*signals.values()], axis=1))
    if not len(fit.poles):
        what = "no vibration is above the noise: let the record begin at the stop, or measure closer to the tool"
        raise InputError(source, "t", what)
    modes, std, decay_std = _with_deviations(fit)
    order = np.argsort(modes.f)
    rows = []
    for k in order:
        if why := _why_none(fit.poles[k], decay_std[k], float(t[-1] - t[0]), len(t)):
            notes.append(f"{modes.f[k]:.4g} Hz {why}: it is left out")
        elif band[0] <= modes.f[k] <= band[1]:
            rows.append(k)
    if not rows:
        what = (
            "; ".join(note.removesuffix(": it is left out") for note in notes)
            or f"no mode is within the band, {band[0]:g} to {band[1]:g} Hz"
        )
        raise InputError(source, "t", f"{what}: give a longer record that begins at the stop, or widen the band")
    zeta = modes.zeta
    assert zeta is not None
    of_poles = MeasuredModes(
        modes.f[rows], zeta[rows], std[rows, 0], std[rows, 1], tuple(signals), fit.amplitudes[rows]
    )  # fmt: skip
    return of_poles, notes


def _within_range(t: Array, signals: Mapping[str, Array]) -> tuple[Array, Mapping[str, Array], list[str]]:
    """Return the record after the last saturated sample, and a note on the omitted samples."""
    staying = {name: stays(x) for name, x in signals.items()}
    named = [name for name, where in staying.items() if where.any()]
    if not named:
        return t, signals, []
    first = 1 + max(int(np.flatnonzero(staying[name])[-1]) for name in named)
    what = f"{', '.join(named)}: largest values are repeated, as beyond the range of a sensor"
    note = f"{what}: the first {first} of {len(t)} samples are left out"
    return t[first:], {name: x[first:] for name, x in signals.items()}, [note]


def _refuse_record(t: Array, signals: Mapping[str, Array], source: str) -> None:
    """Raise `InputError` for records that are too short, too long, uneven, or not of numbers."""
    if not signals:
        raise InputError(source, "columns", "there is no signal but t: name a column by an output, such as tool.ax")
    if not FEWEST <= len(t) <= MOST:
        what = f"{len(t)} samples: {FEWEST} to {MOST} are needed, from the stop until the vibration has decayed"
        raise InputError(source, "t", what)
    for name, x in {"t": t, **signals}.items():
        if not np.isfinite(x).all():
            raise InputError(source, name, f"sample {int(np.argmin(np.isfinite(x))) + 1} is not a number")
    even = np.linspace(t[0], t[-1], len(t))
    period = float(t[-1] - t[0]) / (len(t) - 1)
    if (np.diff(t) <= 0).any() or np.abs(t - even).max() > UNEVEN * period:
        raise InputError(source, "t", "does not increase evenly: a ring-down needs an even clock, sample it again")
    for name, x in signals.items():
        if not np.ptp(x):
            raise InputError(source, name, "is constant: remove the column")


def _why_none(pole: Array, std: float, duration: float, samples: int) -> str:
    """Return why a record cannot determine a pole; empty where it can."""
    decay, pulsation = pole
    periods = duration * pulsation / (2 * np.pi)
    if duration * np.hypot(decay, pulsation) > np.pi * (samples - 1):
        return "is above half of the sampling rate, as samples that stand out are"
    if periods < PERIODS:
        return f"has {periods:.1f} periods in the record"
    if not decay > SURE * std or decay * duration < DECAYED:
        return "does not decay in the record, as what is driven does not"
    return ""


def _modes(t: Array, y: Array) -> _Fit:
    """Return the fit with the number of modes that Schwarz's criterion (BIC) selects."""
    best = _refined_fit(t, y, np.zeros((0, 2)))
    price = (2 + 2 * y.shape[1]) * np.log(y.size)
    while len(best.poles) < MOST_MODES:
        starts = (np.vstack([best.poles, start]) for start in _starts(t, best.residuals))
        first = min((_amplitudes_fit(t, y, poles) for poles in starts), key=lambda fit: fit.misfit)
        refit = _refined_fit(t, y, first.poles)
        if not refit.misfit < best.misfit - price:
            return best
        best = refit
    return best


def _starts(t: Array, residuals: Array) -> list[Array]:
    """Return candidate poles at the highest peak of the residuals' spectra, each signal scaled by its noise."""
    n = PADDED * len(t)
    spectra = np.abs(np.fft.rfft(residuals / np.sqrt(_powers(residuals, residuals)), n, axis=0)) ** 2
    low = PADDED  # one period in the record
    peak = low + int(np.argmax(spectra[low:].sum(axis=1)))
    w = 2 * np.pi * peak / (n * (t[1] - t[0]))
    return [np.array([[zeta * w, w]]) for zeta in STARTS]


def _refined_fit(t: Array, y: Array, poles: Array) -> _Fit:
    """Return the least-squares fit near given poles, by Gauss-Newton steps with amplitudes eliminated."""
    fit = _amplitudes_fit(t, y, poles)
    for _ in range(MOST_STEPS if len(poles) else 0):
        step = -np.linalg.lstsq(fit.slopes, (fit.residuals / fit.sizes).T.ravel(), rcond=None)[0].reshape(-1, 2)
        share, better = 1.0, fit
        while better is fit and share > SHORTEST:
            moved = fit.poles + share * step
            if (moved[:, 1] > 0).all():
                candidate = _amplitudes_fit(t, y, moved)
                better = candidate if candidate.misfit < fit.misfit else fit
            share /= 2
        done = fit.misfit - better.misfit < CONVERGED * len(t)
        fit = better
        if done:
            break
    return fit


def _powers(residuals: Array, y: Array) -> Array:
    """Return the mean squares of residuals (C,), at least those of rounding."""
    rounding = ROUNDING**2 * np.mean(y**2, axis=0) + np.finfo(float).tiny
    powers: Array = np.maximum(np.mean(residuals**2, axis=0), rounding)
    return powers


def _amplitudes_fit(t: Array, y: Array, poles: Array) -> _Fit:
    """Return the fit of amplitudes and offsets at given poles, and the slopes of its residuals by the poles."""
    growth = np.minimum(np.multiply.outer(t, -poles[:, 0]), MOST_GROWTH)
    k, waves = len(poles), np.exp(growth + 1j * np.multiply.outer(t, poles[:, 1]))
    basis = np.hstack([np.ones((len(t), 1)), waves.real, -waves.imag])
    lengths = np.linalg.norm(basis, axis=0)
    Q, R = np.linalg.qr(basis / lengths)
    solved = np.linalg.lstsq(R, Q.T @ y, rcond=None)[0] / lengths[:, None]
    residuals = y - basis @ solved
    A: ComplexArray = solved[1 : 1 + k] + 1j * solved[1 + k :]
    sizes = np.sqrt(_powers(residuals, y))
    slopes = np.zeros((y.shape[1], len(t), k, 2))
    for c in range(y.shape[1]):
        moved = t[:, None] * waves * A[:, c] / sizes[c]
        for which, change in enumerate((moved.real, moved.imag)):  # minus d/d decay, minus d/d pulsation of the sum
            slopes[c, :, :, which] = change - Q @ (Q.T @ change)
    misfit = len(t) * float(np.log(_powers(residuals, y)).sum())
    return _Fit(poles, A, residuals, sizes, misfit, slopes.reshape(y.size, 2 * k))


@np.errstate(invalid="ignore")  # variances of poles that nothing determines are negative by rounding
def _with_deviations(fit: _Fit) -> tuple[MeasuredModes, Array, Array]:
    """Return frequencies and damping ratios, their standard deviations (k, 2), and those of decay rates (k,).

    f = |lambda| / (2 pi), zeta = decay / |lambda|; the noise has lost a degree of freedom for each unknown.
    """
    samples, signals = fit.residuals.shape
    k = len(fit.poles)
    unknowns = 1 + 2 * k + 2 * k / signals
    covariance = np.linalg.pinv(fit.slopes.T @ fit.slopes) * samples / (samples - unknowns)
    size = np.hypot(*fit.poles.T)
    decay, pulsation = fit.poles.T
    std = np.zeros((k, 2))
    for j in range(k):
        own = covariance[2 * j : 2 * j + 2, 2 * j : 2 * j + 2]
        of_f = np.array([decay[j], pulsation[j]]) / (2 * np.pi * size[j])
        of_zeta = np.array([pulsation[j] ** 2, -decay[j] * pulsation[j]]) / size[j] ** 3
        std[j] = np.sqrt([of_f @ own @ of_f, of_zeta @ own @ of_zeta])
    return MeasuredModes(size / (2 * np.pi), decay / size), std, np.sqrt(np.diag(covariance)[::2])
