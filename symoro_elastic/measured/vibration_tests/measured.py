"""What vibration tests measured: frequency responses and modes of a machine at known positions, in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import lru_cache

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray, IndexArray

ROUGH_F = 0.05  # relative standard deviation of frequencies by which values far off are compared
PER_LINE = 2  # frequencies in the distance 1/T of lines
DAMPED = 4.0  # a T
SIDE = 4  # lines on either side, by which v is right to 1e-4
SAMPLES = 2000  # of the integral of v
EVEN = 0.005  # of the distance of lines: how far even ones are off, by the digits of files
FEWEST = 8  # fewest lines whose distance determines the length of segments
USUAL_FALL = math.log(100.0)  # of exponential windows
NO_TEST = "the noise is estimated from the residuals, so chi2 does not test the model"


class WindowKind(StrEnum):
    """Windows that tests may name."""

    NONE = "none"
    HANN = "hann"
    EXPONENTIAL = "exponential"


@dataclass(frozen=True)
class Window:
    """Window of the FFT: segment length, s, NaN if it has no effect; time constant of an exponential window, s."""

    kind: WindowKind
    segment: float = math.nan
    decay: float = math.inf

    @property
    def unit(self) -> float:
        """Unit of change of an exponential window, 1/s: the rate of a fall to 1 % in a segment, else its own rate."""
        return USUAL_FALL / self.segment if math.isfinite(self.segment) else 1 / self.decay

    def changed(self, c: float) -> Window:
        """Return the window changed by c: Hann segments exp(c) times as long, or a faster decay by c units."""
        if self.kind is WindowKind.HANN:
            return replace(self, segment=self.segment * math.exp(c))
        rate = 1 / self.decay + c * self.unit
        return replace(self, decay=1 / rate if rate else math.inf)


@dataclass(frozen=True)
class WindowedLines:
    """Windowed responses as weighted sums of those at complex f (m,), Hz: indices into f (N, c), weights (c,)."""

    f: ComplexArray
    places: IndexArray
    weights: ComplexArray

    def weighted_sum(self, G: ComplexArray) -> ComplexArray:
        """Return responses (..., N) of lines from those of frequencies (..., m)."""
        responses: ComplexArray = G[..., self.places] @ self.weights
        return responses


def windowed_lines(window: Window | None, f: Array) -> WindowedLines | None:
    """Return the frequencies and weights that give windowed responses at f, Hz; None where the window has no effect.

    The impulse response g is seen through a factor v(t):

        Hann, random excitation, Welch:   v = (1 - x)(2 + cos 2 pi x)/3 + sin 2 pi x/(2 pi),  x = t/T; 0 beyond
        exponential, blows:               v = exp(-t/tau),  so that H(s) = G(s + 1/tau)

    Hann's v is the correlation of a window of length T with itself, over its value at 0: for a white input
    E[Syx] = Sxx sum_t g(t) v(t) exp(-s t). A product in time is a sum over neighbouring frequencies. It is taken to the
    right of the imaginary axis, where it is exact but for exp(-2 DAMPED) of vibrations that go on after two segments:

        H(f) = sum_j c_j G(s + a + i pi j/T),  c_j = 1/(2 T) integral v(|t|) exp(a t + i pi j t/T) dt,  a = DAMPED/T
    """
    if window is None or window.kind is WindowKind.NONE:
        return None
    if window.kind is WindowKind.EXPONENTIAL:
        shifted = np.asarray(f - 1j / (2 * math.pi * window.decay), dtype=complex)
        return WindowedLines(shifted, np.arange(len(f))[:, None], np.ones(1, dtype=complex))
    return _lines_under_hann(window.segment, f.tobytes())


@lru_cache(maxsize=64)
def _lines_under_hann(T: float, lines: bytes) -> WindowedLines:
    f, j = np.frombuffer(lines), np.arange(-PER_LINE * SIDE, PER_LINE * SIDE + 1)
    places = (f - f[0]) * PER_LINE * T
    integers = np.round(places)
    if integers[-1] and (np.abs(places - integers) < EVEN * PER_LINE).all():
        unique, neighbours = np.unique(integers[:, None] + j, return_inverse=True)
        at = f[0] + unique * (f[-1] - f[0]) / integers[-1]
    else:
        at, neighbours = (f[:, None] + j / (PER_LINE * T)).ravel(), np.arange(len(f) * len(j))
    damped = np.asarray(at - 1j * DAMPED / (2 * math.pi * T), dtype=complex)
    return WindowedLines(damped, neighbours.reshape(len(f), len(j)), _weights(j))


def _weights(j: IndexArray) -> ComplexArray:
    """Return the weights c_j of `windowed_lines`, by the trapezoidal rule, scaled to the sum v(0) = 1."""
    x = np.linspace(-1, 1, 2 * SAMPLES + 1)
    v = (1 - np.abs(x)) * (2 + np.cos(2 * np.pi * x)) / 3 + np.sin(2 * np.pi * np.abs(x)) / (2 * np.pi)
    c = np.exp(2j * np.pi / PER_LINE * np.outer(j, x)) @ (v * np.exp(DAMPED * x)) / (PER_LINE * SAMPLES)
    weights: ComplexArray = c / c.sum()
    return weights


def segment_of(f: Array) -> float | None:
    """Return 1/distance of lines, s, where they are multiples of it, as those of a Fourier transform; else None."""
    if len(f) < FEWEST:
        return None
    first = float(np.diff(f).min())
    step = float(f[-1] - f[0]) / max(round(float(f[-1] - f[0]) / first), 1)
    multiples = f / step
    return 1 / step if (np.abs(multiples - np.round(multiples)) < 10 * EVEN).all() else None


def usual_window(kind: WindowKind, f: Array) -> Window | None:
    """Return the window that responses at lines f may be under; None where lines are not those of segments.

    An exponential one falls by nothing.
    """
    T = segment_of(f)
    return None if T is None else Window(kind, T)


@dataclass(frozen=True)
class MeasuredResponse:
    """H (N), complex, from an input to an output, at frequencies f (N) in Hz that increase from above 0.

    Names are those of signals of `response`, without a sign: signs and units of files are in H. Every number is finite.
    `coherence` (N), 0 to 1, is None where it was not measured.
    """

    output: str
    input: str
    f: Array
    H: ComplexArray
    coherence: Array | None = None

    @property
    def pair(self) -> str:
        """Name of the pair, output / input, as in the column heads of files."""
        return f"{self.output}/{self.input}"


@dataclass(frozen=True)
class MeasuredModes:
    """Natural frequencies f (k) in Hz that increase, damping ratios zeta (k), and standard deviations of both.

    `std_f` in Hz and `std_zeta`, (k) each, are None where they are unknown; entries of `zeta`, `std_f` and `std_zeta`
    are NaN where they are unknown for one mode. `shapes` (k, outputs), complex, each mode scaled arbitrarily, are
    amplitudes at `outputs`, names without signs; None where no shape was measured.
    """

    f: Array
    zeta: Array | None = None
    std_f: Array | None = None
    std_zeta: Array | None = None
    outputs: tuple[str, ...] = ()
    shapes: ComplexArray | None = None


@dataclass(frozen=True)
class VibrationTest:
    """One test: responses or modes of a machine in equilibrium at positions `at` (rad or m, by joint).

    Motors in `hold` do not move; those in `pd` are driven by Kp (N m/rad or N/m) and Kv (N m s/rad or N s/m), None
    where the gains are unknown; those in `drives` by their cascades of the machine file; others are free. `averages`
    are those of each response. With `validate` the test is predicted, not fitted. `window` is the one over records that
    responses were made of, None where it is not named.
    """

    name: str
    at: Mapping[str, float]
    hold: tuple[str, ...] = ()
    pd: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    averages: int | None = None
    validate: bool = False
    responses: tuple[MeasuredResponse, ...] = ()
    modes: MeasuredModes | None = None
    drives: tuple[str, ...] = ()
    window: Window | None = None

    def with_zero(self, joint: str, zero: float) -> VibrationTest:
        """Return the test with `zero` added to the position of a joint."""
        return replace(self, at={**self.at, joint: self.at.get(joint, 0.0) + zero})


def roughly(test: VibrationTest) -> VibrationTest:
    """Return a test with large standard deviations of its modes, so that costs differ far from the minimum."""
    if (modes := test.modes) is None:
        return test
    return replace(test, modes=replace(modes, std_f=ROUGH_F * modes.f, std_zeta=None))


def with_windows(
    tests: Sequence[VibrationTest], kind: WindowKind, named: Window | None = None
) -> tuple[VibrationTest, ...] | None:
    """Return the tests with a window of this kind where they named `named`; None where no test can have it."""
    changed = []
    for test in tests:
        usual = usual_window(kind, test.responses[0].f) if test.responses and test.window == named else None
        changed.append(test if usual in (None, test.window) else replace(test, window=usual))
    return tuple(changed) if any(new is not old for new, old in zip(changed, tests, strict=True)) else None


@dataclass(frozen=True)
class VibrationTests:
    """Vibration tests of a machine; `notes` report what was omitted from their files."""

    tests: tuple[VibrationTest, ...]
    notes: tuple[str, ...] = ()
