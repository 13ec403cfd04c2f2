"""Windows over the records of responses: scipy's Welch method and integrals of impulse responses are the reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.signal

import symoro_elastic as se
from symoro_elastic.analysis.updating.measured import MeasuredResponse, VibrationTest
from symoro_elastic.analysis.updating.reading import read_tests
from symoro_elastic.analysis.updating.windows import Window, WindowKind, behind

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
    reference = np.array([np.trapezoid(g * np.exp(-2j * np.pi * x * t), t) for x in f])
    of = behind(Window(WindowKind.HANN, T), f)
    assert of is not None
    s = 2j * np.pi * of.f
    G = np.sum([0.5 / (s - x) + 0.5 / (s - x.conjugate()) for x in lam], axis=0)
    assert np.abs(of.seen(G) - reference).max() < 3e-4 * np.abs(reference).max()
    assert len(of.f) == (2 * 30 + 17 if shift == 0 else 31 * 17)


def test_segments_of_welch_are_modelled_and_told() -> None:
    """Peaks of three lines: without the window values are off by five deviations; residuals tell it."""
    one = welch(0.25, 400, 0.02)
    none, named, unnamed = (updated(one, 400, window) for window in (NONE, Window(WindowKind.HANN, 0.25), None))
    assert np.abs(deviations(none)).max() > 4
    for found in (named, unnamed):
        assert np.abs(deviations(found)).max() < 3.5 and found.fit.chi2 < 1.3
    assert not any("window" in line for line in named.notes)
    assert any("shaker: no window is named, and residuals tell Hann's" in line for line in unnamed.notes)


def test_what_residuals_do_not_tell_widens_deviations() -> None:
    """Noise hides which window it was: deviations without it hold the truth less often than they should."""
    one = welch(0.5, 12, 0.4, seed=3)
    none, unnamed = updated(one, 12, NONE), updated(one, 12, None)
    assert set(unnamed.fit.under) == {WindowKind.HANN, WindowKind.EXPONENTIAL} and not none.fit.under
    said = [line for line in unnamed.notes if "no window is named, and none is taken" in line]
    assert len(said) == 1 and "exponential one that falls to 1 %, " in said[0] and ".damping is -" in said[0]
    shift = unnamed.fit.under[WindowKind.HANN]
    for plain, wide, by in zip(none.estimates, unnamed.estimates, shift, strict=True):
        assert wide.value == plain.value and wide.relative == pytest.approx(np.hypot(plain.relative, by))


def test_exponential_windows_of_blows_add_no_damping() -> None:
    f, tau = np.arange(10.0, 180.0, 1.0), 0.2
    H = exact(f - 1j / (2 * np.pi * tau))
    rng, sd = np.random.default_rng(1), 0.01 * np.abs(H)
    H = H + sd * (rng.normal(size=len(f)) + 1j * rng.normal(size=len(f)))
    one = MeasuredResponse(*PAIR, f, H, np.full(len(f), 1 / (1 + 2 * 9 * 1e-4)))
    named, none = updated(one, 10, Window(WindowKind.EXPONENTIAL, decay=tau)), updated(one, 10, NONE)
    assert np.abs(deviations(named)).max() < 3.5 and np.abs(deviations(none)).max() > 15
    assert any("under an exponential one" in line for line in updated(one, 10, None).notes)


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
