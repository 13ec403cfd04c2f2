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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.measured.fitting.estimates import SIGNIFICANT
from symoro_elastic.measured.vibration_tests.predictions import Lines

POWERS = (0, 1, 2)  # of (f / f_max)^2
LARGEST_PHASE = 10.0  # prior standard deviation of a delay: phase at the last line, rad
ACCELERATION = 2  # how often it is derived
PHASES = np.arange(-40, 41) * 0.25  # that are tried for the last line, rad


@dataclass(frozen=True)
class Delay:
    """Delay of an output, s, with its standard deviation; phase (rad) and attenuation (Np) of its last line."""

    test: int
    output: str
    seconds: float
    std: float
    phase: float
    fall: float

    @property
    def is_significant(self) -> bool:
        """Whether the delay differs from zero by more than chance."""
        return abs(self.seconds) > SIGNIFICANT * self.std


@dataclass(frozen=True)
class Gain:
    """Logarithm of the factor between a response and the model, with its standard deviation."""

    line: int
    log: float
    std: float

    @property
    def is_significant(self) -> bool:
        """Whether the factor differs from 1 by more than chance."""
        return abs(self.log) > SIGNIFICANT * self.std


Applied = tuple[ComplexArray, Array | ComplexArray, ComplexArray]
"""A line as it is measured (N), its derivatives by that of the model (N) and by coefficients (m, N)."""


@dataclass(frozen=True)
class Nuisance:
    """Nuisance term of some `lines`; `prior` are the inverse prior variances (m) of its coefficients."""

    lines: tuple[int, ...]
    prior: tuple[float, ...]

    def applied(self, line: int, G: ComplexArray, c: Array) -> Applied:
        """Return the model's response `line` with this nuisance, and its derivatives."""
        raise NotImplementedError


class ChannelGain(Nuisance):
    """Gain exp(c) of an output or an input channel of a test."""

    def applied(self, line: int, G: ComplexArray, c: Array) -> Applied:
        """Return exp(c) G."""
        factor = np.full(len(G), math.exp(c[0]))
        return factor * G, factor, (factor * G)[None]


@dataclass(frozen=True)
class ChannelDelay(Nuisance):
    """Delay of an output channel: phase and attenuation at its last line w, rad/s, and terms without delay.

    `u` are s over |s| of the last line, by line.
    """

    test: int
    output: str
    w: float
    u: Mapping[int, ComplexArray]
    direct: Mapping[int, float]

    def applied(self, line: int, G: ComplexArray, c: Array) -> Applied:
        """Return d + (G - d) exp(-s t + s^2 v/2)."""
        u, slopes = self.u[line], np.zeros((len(c), len(G)), dtype=complex)
        shape, d = np.exp(-c[0] * u + c[1] * u**2), 0.0
        if line in self.direct:
            row = 2 + list(self.direct).index(line)
            d = float(c[row]) * self.direct[line]
            slopes[row] = self.direct[line] * (1 - shape)
        slopes[:2] = -u * (G - d) * shape, u**2 * (G - d) * shape
        return d + (G - d) * shape, shape, slopes

    def start(self, logs: Sequence[ComplexArray]) -> float:
        """Return the phase at the last line that explains most of ln(G/H), modulo full turns."""

        def distance(phase: float) -> float:
            apart = (logs[line] - phase * u for line, u in self.u.items())
            return sum(float(np.abs(x.real + 1j * ((x.imag + math.pi) % (2 * math.pi) - math.pi)).sum()) for x in apart)

        return float(min(PHASES, key=distance))


@dataclass(frozen=True)
class OutOfBandModes(Nuisance):
    """Smooth terms (m, N) of out-of-band modes in one response, in units of its median, `size`."""

    terms: ComplexArray
    size: float

    def applied(self, line: int, G: ComplexArray, c: Array) -> Applied:
        """Return G + terms."""
        return G + c @ self.terms, np.ones(len(G)), self.terms


@dataclass(frozen=True)
class Nuisances:
    """Nuisances of the lines of tests, applied in this order; their coefficients c follow each other."""

    parts: tuple[Nuisance, ...] = ()

    @cached_property
    def _slices(self) -> list[slice]:
        ends = np.cumsum([0, *(len(part.prior) for part in self.parts)]).tolist()
        return [slice(a, b) for a, b in pairwise(ends)]

    @property
    def prior(self) -> Array:
        """Inverse variances of the coefficients."""
        return np.array([weight for part in self.parts for weight in part.prior])

    @property
    def has_delays(self) -> bool:
        """Whether outputs may be late."""
        return any(isinstance(part, ChannelDelay) for part in self.parts)

    def added_to(self, line: int, G: ComplexArray, dG: ComplexArray, c: Array) -> tuple[ComplexArray, ComplexArray]:
        """Return the model's response with all nuisances, its slopes by parameters (p, N) and coefficients (m, N)."""
        slopes = np.pad(dG, ((0, len(c)), (0, 0)))
        for part, own in zip(self.parts, self._slices, strict=True):
            if line in part.lines:
                G, factor, by_own = part.applied(line, G, c[own])
                slopes *= factor
                slopes[len(dG) :][own] = by_own
        return G, slopes

    def largest_term(self, c: Array) -> float:
        """Return the largest ratio of out-of-band terms (RMS) to the median of their response."""
        parts = zip(self.parts, self._slices, strict=True)
        terms = ((part, c[own] @ part.terms) for part, own in parts if isinstance(part, OutOfBandModes))
        return max((float(np.sqrt(np.mean(np.abs(term) ** 2)) / part.size) for part, term in terms), default=0.0)

    def delays(self, c: Array, std: Array) -> tuple[Delay, ...]:
        """Return the delays of channels, from coefficients and their standard deviations."""
        parts = ((part, own.start) for part, own in zip(self.parts, self._slices, strict=True))
        return tuple(
            Delay(part.test, part.output, float(c[k] / part.w), float(std[k] / part.w), float(c[k]), float(c[k + 1]))
            for part, k in parts
            if isinstance(part, ChannelDelay)
        )

    def gains(self, c: Array, covariance: Array) -> tuple[Gain, ...]:
        """Return the gains of responses, from coefficients and their covariance."""
        count = sum(isinstance(part, ChannelGain) for part in self.parts)  # they come first
        gains = []
        for line in sorted({line for part in self.parts[:count] for line in part.lines}):
            of = [k for k, part in enumerate(self.parts[:count]) if line in part.lines]
            gains.append(Gain(line, float(c[of].sum()), math.sqrt(covariance[np.ix_(of, of)].sum())))
        return tuple(gains)

    def start(self, logs: Sequence[ComplexArray]) -> Array:
        """Return initial coefficients: least-squares gains of ln(G/H), and delays that explain most of its phase."""
        c = np.zeros(len(self.prior))
        gains = [part for part in self.parts if isinstance(part, ChannelGain)]
        if gains:
            belongs = np.array([[float(line in part.lines) for part in gains] for line in range(len(logs))])
            medians = [-np.median(logarithm.real) for logarithm in logs]
            c[: len(gains)] = np.linalg.lstsq(belongs, medians, rcond=None)[0]
        for part, own in zip(self.parts, self._slices, strict=True):
            if isinstance(part, ChannelDelay):
                c[own.start] = part.start(logs)
        return c


def channel_gains(lines: Sequence[Lines]) -> Nuisances:
    """Return gains of outputs and inputs of tests, without linearly dependent ones."""
    groups: dict[tuple[int, str], list[int]] = {}
    for k, line in enumerate(lines):
        for name in (line.measured.output, line.measured.input):
            groups.setdefault((line.test, name), []).append(k)
    rows, independent = np.zeros((0, len(lines))), []
    for members in groups.values():
        more = np.vstack([rows, np.isin(np.arange(len(lines)), members)])
        if np.linalg.matrix_rank(more) > len(rows):
            rows = more
            independent.append(ChannelGain(tuple(members), (1.0,)))
    return Nuisances(tuple(independent))


def channel_delays(lines: Sequence[Lines], direct: Sequence[int] = ()) -> Nuisances:
    """Return delays of outputs; responses `direct` also have a term without delay."""
    outputs: dict[tuple[int, str], list[int]] = {}
    for k, line in enumerate(lines):
        outputs.setdefault((line.test, line.measured.output), []).append(k)
    delays = []
    for (test, output), members in outputs.items():
        last = max(float(lines[k].f[-1]) for k in members)
        u = {k: np.asarray(1j * lines[k].f / last, dtype=complex) for k in members}
        sizes = {k: lines[k].size for k in members if k in direct}
        prior = (LARGEST_PHASE**-2, *np.ones(1 + len(sizes)).tolist())
        delays.append(ChannelDelay(tuple(members), prior, test, output, 2 * math.pi * last, u, sizes))
    return Nuisances(tuple(delays))


def out_of_band_modes(lines: Sequence[Lines], orders: Sequence[int]) -> Nuisances:
    """Return out-of-band terms of responses whose outputs are time derivatives of these orders."""
    modes = []
    for k, (line, order) in enumerate(zip(lines, orders, strict=True)):
        v = line.f / line.f[-1]
        powers = np.array([(1j * v) ** order * v ** (2 * power) for power in POWERS]) * line.size
        terms = np.asarray(np.concatenate([powers, 1j * powers]), dtype=complex)
        modes.append(OutOfBandModes((k,), (1.0,) * len(terms), terms, line.size))
    return Nuisances(tuple(modes))
