"""Windows over the records of responses: scipy's Welch method and integrals of impulse responses are the reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.signal

import symoro_elastic as se
from symoro_elastic.measured.vibration_tests.measured import (
    MeasuredResponse,
    VibrationTest,
    Window,
    WindowKind,
    windowed_lines,
)
from symoro_elastic.measured.vibration_tests.reading import read_tests

MASSES, SPRINGS = (40.0, 15.0), {"bed": (4e6, 700.0), "table": (3e6, 500.0)}
TABLES: dict[str, Any] = {
    "name": "two_tables",
    "joints": [
        {"name": "bed", "antecedent": 0, "kind": "elastic", "sigma": 1, "r": "a"},
        {"name": "table", "antecedent": "bed", "kind": "elastic", "sigma": 1, "r": "b"},
    ],
    "bodies": {"bed": {"mass": MASSES[0]}, "table": {"mass": MASSES[1]}},
    "springs": {name: {"stiffness": 1.2 * k, "damping": 0.8 * d} for name, (k, d) in SPRINGS.items()},
}
PAIR, BAND, RATE = ("table.az", "table.fz"), (10.0, 180.0), 512.0
NONE = Window(WindowKind.NONE)


def exact(f: Any) -> Any:
    """Acceleration of the upper mass by a force on it, at f (Hz), complex ones too."""
    (M, m), ((K, D), (k, d)) = MASSES, SPRINGS.values()
    s = 2j * np.pi * f
    upper, between = m * s**2 + d * s + k, d * s + k
    return s**2 / (upper - between**2 / (M * s**2 + (D + d) * s + K + k))


def welch(T: float, n: int, noise: float, seed: int = 0) -> MeasuredResponse:
    """H1 and coherence of n half-overlapped segments under Hann's window, from a shaker with white noise."""
    rng, N = np.random.default_rng(seed), round(T * RATE)
    x = rng.normal(size=N * (n // 2 + 6))
    y = np.fft.irfft(exact(np.fft.rfftfreq(len(x), 1 / RATE)) * np.fft.rfft(x), len(x))
    y += noise * np.std(y) * rng.normal(size=len(y))
    x, y = x[: (n + 1) * N // 2], y[: (n + 1) * N // 2]
    f, xy = scipy.signal.csd(x, y, RATE, "hann", N, detrend=False)
    xx, yy = (scipy.signal.welch(z, RATE, "hann", N, detrend=False)[1] for z in (x, y))
    used = (f >= BAND[0]) & (f <= BAND[1])
    return MeasuredResponse(*PAIR, f[used], (xy / xx)[used], (np.abs(xy) ** 2 / xx / yy)[used])


def updated(one: MeasuredResponse, averages: int, window: Window | None) -> Any:
    return se.update(TABLES, [VibrationTest("shaker", {}, averages=averages, responses=(one,), window=window)])


def deviations(found: Any) -> Any:
    """Errors of ln p over standard deviations."""
    keys = ("stiffness", "damping")
    truth = {f"{name}.{key}": x for name, one in SPRINGS.items() for key, x in zip(keys, one, strict=True)}
    return np.array([np.log(one.value / truth[one.unknown.label]) / one.relative for one in found.estimates])


@pytest.mark.parametrize("shift", [0.0, 0.3])
def test_hann_is_the_product_of_the_impulse_response_and_its_correlation(shift: float) -> None:
    """The integral by the trapezoidal rule, of residues of the oscillator that scipy finds; uneven lines too."""
    T, t = 0.25, np.linspace(0, 0.25, 40_001)
    w = scipy.signal.windows.hann(4001, sym=True)
    v = scipy.signal.correlate(w, w)[4000:] / np.sum(w**2)
    lam = np.array([-8 + 300j, -30 + 700j])
    g = np.interp(t, np.linspace(0, T, 4001), v) * np.sum(np.exp(np.outer(lam, t)), axis=0).real
    f = np.arange(10, 41) / T * (1 + shift * np.sin(np.arange(31)) / 40)
    reference = np.array([scipy.integrate.trapezoid(g * np.exp(-2j * np.pi * x * t), t) for x in f])
    of = windowed_lines(Window(WindowKind.HANN, T), f)
    assert of is not None
    s = 2j * np.pi * of.f
    G = np.sum([0.5 / (s - x) + 0.5 / (s - x.conjugate()) for x in lam], axis=0)
    assert np.abs(of.weighted_sum(G) - reference).max() < 3e-4 * np.abs(reference).max()
    assert len(of.f) == (2 * 30 + 17 if shift == 0 else 31 * 17)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("window", "said"),
    [
        (Window(WindowKind.HANN, 0.25), ""),
        (None, "shaker: no window is named, and residuals indicate Hann's of 0.25 s"),
        (NONE, "shaker: the list says none, and residuals indicate Hann's of 0.25 s"),
        (Window(WindowKind.HANN, 0.5), "shaker: the list says Hann's of 0.5 s, and residuals indicate Hann's of 0.25"),
    ],
)
def test_segments_of_welch_are_modelled_and_told(window: Window | None, said: str) -> None:
    """Peaks of three lines: without the window values would be off by five deviations."""
    found = updated(welch(0.25, 400, 0.02), 400, window)
    assert np.abs(deviations(found)).max() < 3.5 and found.fit.chi2 < 1.3
    told = [line for line in found.notes if "residuals indicate" in line]
    assert told[0].startswith(said) if said else not told


@pytest.mark.thorough
def test_what_residuals_do_not_tell_widens_deviations() -> None:
    """Noise hides which window it was: deviations without it hold the truth less often than they should."""
    one = welch(0.5, 12, 0.4, seed=3)
    none, unnamed = updated(one, 12, NONE), updated(one, 12, None)
    hann, falling = unnamed.fit.alternatives
    assert (
        hann.counts
        and not falling.counts
        and falling.window.kind is WindowKind.EXPONENTIAL
        and not none.fit.alternatives
    )
    said = [line for line in unnamed.notes if "no window is named" in line]
    assert len(said) == 1 and "under an exponential one of " in said[0] and ".damping is -" in said[0]
    for plain, wide, by in zip(none.estimates, unnamed.estimates, hann.shift, strict=True):
        assert wide.value == plain.value and wide.relative == pytest.approx(np.hypot(plain.relative, by))


def blow(tau: float = np.inf, late: float = 0.0, factor: float = 1.0) -> MeasuredResponse:
    """A response with noise of 1 %, under an exponential window, by a late sensor of another sensitivity."""
    f, rng = np.arange(10.0, 180.0, 1.0), np.random.default_rng(1)
    H = factor * exact(f - 1j / (2 * np.pi * tau)) * np.exp(-2j * np.pi * f * late)
    H = H + 0.01 * np.abs(H) * (rng.normal(size=len(f)) + 1j * rng.normal(size=len(f)))
    return MeasuredResponse(*PAIR, f, H, np.full(len(f), 1 / (1 + 2 * 9 * 1e-4)))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("window", "said"),
    [
        (Window(WindowKind.EXPONENTIAL, decay=0.2), ""),
        (
            Window(WindowKind.EXPONENTIAL, decay=0.3),
            "the list says an exponential one of 0.3 s, and residuals indicate an ",
        ),
        (NONE, "shaker: the list says none, and residuals indicate an exponential one of 0.1995"),
        (None, "shaker: no window is named, and residuals indicate an exponential one of 0.1995"),
    ],
)
def test_exponential_windows_of_blows_add_no_damping(window: Window | None, said: str) -> None:
    found = updated(blow(tau=0.2), 10, window)
    assert np.abs(deviations(found)).max() < 3.5
    assert said in found.notes[0] if said else not found.notes


@pytest.mark.thorough
def test_factors_and_delays_are_told_together() -> None:
    """Factors alone leave chi2 of 8, delays alone 1.2 with springs 30 deviations off."""
    found = updated(blow(late=1e-4, factor=1.1), 10, NONE)
    assert np.abs(deviations(found)).max() < 3.5 and found.fit.chi2 < 1.15
    assert any("table.az by 0.0" in line or "table.az by 0.1" in line for line in found.notes)
    assert any("responses are 1.099 times" in line for line in found.notes)


@pytest.mark.thorough
def test_noise_that_is_larger_than_coherence_says_is_told_from_a_wrong_model() -> None:
    found = updated(blow(), 100, NONE)
    assert "equally at all frequencies: check both" in found.verdict_on_model
    assert np.abs(deviations(found)).max() < 3.5 and not any("spikes" in line for line in found.notes)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('"han"', "window: no window 'han'; did you mean 'hann'?"),
        ('"exponential"', "window: has a time constant, in which it falls to 1/e"),
        ("{ hann = 0 }", "window, hann: 0 s: give a time above 0"),
        ("{ hann = 1, exponential = 1 }", "window: holds 2 windows: give hann or exponential"),
        ("{ blackman = 1 }", "blackman"),
        ('"hann"', "window: lines are not even: give the length of segments"),
    ],
)
def test_wrong_windows_are_named(entry: str, said: str, tmp_path: Path) -> None:
    rows = "\n".join(f"{x},1,0" for x in np.geomspace(10, 90, 12))
    (tmp_path / "a.csv").write_text("f,re table.az/table.fz,im table.az/table.fz\n" + rows, encoding="utf-8")
    (tmp_path / "tests.toml").write_text(f'[[tests]]\nfile = "a.csv"\nwindow = {entry}\n', encoding="utf-8")
    with pytest.raises(se.InputError) as error:
        read_tests(tmp_path / "tests.toml", se.read(TABLES))
    assert said in str(error.value)
