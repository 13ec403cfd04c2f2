"""Nuisance parameters of a test: gains of its outputs and inputs, delays of channels, terms of modes outside the band.

Where sensitivities of sensors are wrong, responses are the model's times those of output and input, exp(a + b).

The channel of an output, relative to that of the input, is a kernel of a mean delay t and a variance v, to second
order of ln: G exp(-s t + s^2 v/2). That is a delay, a filter below its corner, a skew between channels, or the hold of
a command over T: (1 - exp(-s T))/(s T) has t = T/2 and v = T^2/12. Accelerations that are sampled where the command
changes have a direct part d that is not late: d + (G - d) exp(-s t + s^2 v/2), d real.

A mode above the band adds s^n (a0 + a1 f^2 + a2 f^4 + ...), n = 0, 1, 2 for positions, velocities, accelerations: the
residual terms of modal analysis (Ewins, Modal Testing). Coefficients are complex, for modes are damped, and unknown to
the size of the response; intervals of parameters know of all of them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray

POWERS = (0, 1, 2)  # of (f / f_max)^2
LARGEST_PHASE = 10.0  # prior standard deviation of a delay: phase at the last line, rad
LARGEST_FALL = 1.0  # prior standard deviation of a variance: fall of the last line, Np
ACCELERATION = 2  # how often it is derived
LARGEST_GAIN = 1.0  # prior standard deviation of the logarithm of a factor
LEAST_GAIN = 0.002  # logarithm below which a factor does not show
LEAST_PHASE = 0.01  # of the last line, rad: delays below it do not show
PHASES = np.arange(-40, 41) * 0.25  # that are tried for the last line, rad


@dataclass(frozen=True)
class Channel:
    """The output of a test: its lines by their places, and w of its last line, rad/s."""

    test: int
    output: str
    lines: tuple[int, ...]
    w: float


@dataclass(frozen=True)
class Delay:
    """How late an output is, s, with its standard deviation; what its last line is turned (rad) and lowered (Np) by."""

    test: int
    output: str
    seconds: float
    std: float
    phase: float
    fall: float

    @property
    def shows(self) -> bool:
        """Whether it is more than doubt explains."""
        return abs(self.phase) > LEAST_PHASE and abs(self.seconds) > 3 * self.std


@dataclass(frozen=True)
class Gain:
    """The logarithm of the factor between a line and the model, with its standard deviation."""

    line: int
    log: float
    std: float

    @property
    def shows(self) -> bool:
        """Whether it is more than doubt explains."""
        return abs(self.log) > max(LEAST_GAIN, 3 * self.std)


@dataclass(frozen=True)
class Nuisances:
    """Factors of `gains` by their lines, channels, two coefficients each, `direct` parts of lines, then terms (m, N).

    `u` are s over |s| of the last line, `sizes` the medians of lines, which are the unit of direct parts and terms.
    """

    channels: tuple[Channel, ...] = ()
    direct: tuple[int, ...] = ()
    u: tuple[ComplexArray, ...] = ()
    terms: tuple[ComplexArray, ...] = ()
    sizes: tuple[float, ...] = ()
    gains: tuple[tuple[int, ...], ...] = ()

    @property
    def count(self) -> int:
        """Coefficients of all lines."""
        return len(self.gains) + 2 * len(self.channels) + len(self.direct) + sum(len(term) for term in self.terms)

    @property
    def prior(self) -> Array:
        """Inverse variances of the coefficients."""
        weights, first = np.ones(self.count), len(self.gains)
        weights[:first] = LARGEST_GAIN**-2
        weights[first : first + 2 * len(self.channels)] = np.tile(
            [LARGEST_PHASE**-2, LARGEST_FALL**-2], len(self.channels)
        )
        return weights

    def _of_channel(self, line: int) -> slice | None:
        places = [k for k, channel in enumerate(self.channels) if line in channel.lines]
        first = len(self.gains) + 2 * places[0] if places else 0
        return slice(first, first + 2) if places else None

    def _of_terms(self, line: int) -> slice:
        first = len(self.gains) + 2 * len(self.channels) + len(self.direct)
        first += sum(len(term) for term in self.terms[:line])
        return slice(first, first + len(self.terms[line]))

    def added_to(
        self, line: int, G: ComplexArray, dG: ComplexArray | None, c: Array
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return what is seen of G (N) of a line, and the slopes of that by parameters (p, N) and coefficients c."""
        none = np.zeros((0, len(G)), dtype=complex)
        slopes = none if dG is None else dG
        if not self.count:
            return G, slopes
        own = np.zeros((self.count, len(G)), dtype=complex)
        if of := [k for k, lines in enumerate(self.gains) if line in lines]:
            factor = math.exp(c[of].sum())
            G, slopes = factor * G, factor * slopes
            own[of] = G
        if rows := self._of_channel(line):
            u = self.u[line]
            shape = np.exp(-c[rows][0] * u + c[rows][1] * u**2)
            d = 0.0
            if line in self.direct:
                row = len(self.gains) + 2 * len(self.channels) + self.direct.index(line)
                d = float(c[row]) * self.sizes[line]
                own[row] = self.sizes[line] * (1 - shape)
            own[rows] = -u * (G - d) * shape, u**2 * (G - d) * shape
            G, slopes = d + (G - d) * shape, slopes * shape
        if self.terms:
            rows = self._of_terms(line)
            G = G + c[rows] @ self.terms[line]
            own[rows] = self.terms[line]
        return G, np.concatenate([slopes, own])

    def largest(self, c: Array) -> float:
        """Return the largest root mean square of what terms add to a line, over its median response."""
        terms = ((k, term, self.sizes[k]) for k, term in enumerate(self.terms))
        return max(
            (float(np.sqrt(np.mean(np.abs(c[self._of_terms(k)] @ term) ** 2)) / size) for k, term, size in terms),
            default=0.0,
        )

    def delays(self, c: Array, std: Array) -> tuple[Delay, ...]:
        """Return the delays of channels, from coefficients and their standard deviations."""
        c, std = c[len(self.gains) :], std[len(self.gains) :]
        return tuple(
            Delay(
                channel.test,
                channel.output,
                float(phase / channel.w),
                float(own / channel.w),
                float(phase),
                float(fall),
            )
            for channel, phase, fall, own in zip(self.channels, c[0::2], c[1::2], std[0::2], strict=False)
        )

    def factors(self, c: Array, covariance: Array) -> tuple[Gain, ...]:
        """Return the factors of lines, from coefficients and their covariance."""
        gains = []
        for line in sorted({line for lines in self.gains for line in lines}):
            of = [k for k, lines in enumerate(self.gains) if line in lines]
            gains.append(Gain(line, float(c[of].sum()), math.sqrt(covariance[np.ix_(of, of)].sum())))
        return tuple(gains)

    def start(self, logs: Sequence[ComplexArray]) -> Array:
        """Return coefficients to begin with: factors, and delays that leave least of ln(G/H), its phase wrapped."""
        c = np.zeros(self.count)
        if self.gains:
            belongs = np.array([[float(line in lines) for lines in self.gains] for line in range(len(logs))])
            c[: len(self.gains)] = np.linalg.lstsq(
                belongs, [-np.median(logarithm.real) for logarithm in logs], rcond=None
            )[0]
        for k, channel in enumerate(self.channels):
            distances = [
                sum(float(np.sum(np.abs(_with_wrapped_phase(logs[j] - x * self.u[j])))) for j in channel.lines)
                for x in PHASES
            ]
            c[len(self.gains) + 2 * k] = PHASES[int(np.argmin(distances))]
        return c


def _with_wrapped_phase(logs: ComplexArray) -> ComplexArray:
    wrapped: ComplexArray = logs.real + 1j * ((logs.imag + math.pi) % (2 * math.pi) - math.pi)
    return wrapped


@dataclass(frozen=True)
class ChannelResponse:
    """A line: its test, output and input, frequencies and responses, and how often the output is derived."""

    test: int
    output: str
    input: str
    f: Array
    H: ComplexArray
    order: int


def nuisances_of(lines: Sequence[ChannelResponse], channels: bool, terms: bool, gains: bool = False) -> Nuisances:
    """Return the nuisances of lines; direct parts without gains, terms in units of the median response."""
    outs: dict[tuple[int, str], list[int]] = {}
    for k, line in enumerate(lines):
        outs.setdefault((line.test, line.output), []).append(k)
    last = {key: max(float(lines[k].f[-1]) for k in places) for key, places in outs.items()}
    own = [Channel(*key, tuple(places), 2 * math.pi * last[key]) for key, places in outs.items()] if channels else []
    direct = tuple(k for k, line in enumerate(lines) if channels and not gains and line.order == ACCELERATION)
    u = tuple(np.asarray(1j * line.f / last[line.test, line.output], dtype=complex) for line in lines)
    sizes = tuple(float(np.median(np.abs(line.H))) for line in lines)
    shapes: list[ComplexArray] = []
    for line, size in zip(lines, sizes, strict=True) if terms else ():
        v = line.f / line.f[-1]
        powers = np.array([(1j * v) ** line.order * v ** (2 * power) for power in POWERS]) * size
        shapes.append(np.asarray(np.concatenate([powers, 1j * powers]), dtype=complex))
    return Nuisances(tuple(own), direct, u, tuple(shapes), sizes, gain_nuisances(lines).gains if gains else ())


def gain_nuisances(lines: Sequence[ChannelResponse]) -> Nuisances:
    """Return the factors of outputs and inputs of tests, but for those that the others make up."""
    groups: dict[tuple[int, str], list[int]] = {}
    for k, line in enumerate(lines):
        for name in (line.output, line.input):
            groups.setdefault((line.test, name), []).append(k)
    rows, kept = np.zeros((0, len(lines))), []
    for places in groups.values():
        more = np.vstack([rows, np.isin(np.arange(len(lines)), places)])
        if np.linalg.matrix_rank(more) > len(rows):
            rows = more
            kept.append(tuple(places))
    return Nuisances(gains=tuple(kept))
