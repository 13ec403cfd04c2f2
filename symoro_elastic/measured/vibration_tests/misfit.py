"""Residuals of vibration tests at any values of the unknowns, and the minimum of their sum of squares near a start.

By Levenberg-Marquardt with steps limited in ln p, a prior, and Cauchy weights w = 1/(1 + (r/c)^2), c = 2.5 s with
s = max(1, 1.4826 median |r|). Unknowns are ln p, then the coefficients of nuisances.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.fitting.estimates import CAUCHY, MOST_STEPS, SIGNIFICANT, TO_DEVIATION
from symoro_elastic.measured.fitting.evidence import Evidence, largest_chi2
from symoro_elastic.measured.vibration_tests.measured import MeasuredModes, MeasuredResponse, VibrationTest, Window
from symoro_elastic.measured.vibration_tests.nuisances import Delay, Gain, Nuisances
from symoro_elastic.measured.vibration_tests.predictions import (
    Lines,
    Oscillations,
    Predicted,
    PredictedModes,
    Predictions,
    pairs_of_modes,
)

LEAST_COHERENCE = 0.01  # lower coherences are those of noise
MOST_COHERENCE = 1 - 1e-4  # higher coherences are those of the analyzer's digits
LARGEST_CHI2 = 1.15  # of a right model with many averages
TAIL = 0.9  # more, over the number of averages, by simulation: chi2 of right models is 1.33, 1.22, 1.09 with 3, 5, 10
SELDOM = 1e-5  # probability that noise is beyond the limit of spikes
FAR_LOGARITHM = 0.05  # median |ln(G/H)| above which another minimum is sought where the noise is unknown
USUAL_AVERAGES = 10  # where they are not known
GUESS = 0.01  # noise over |H| and over its median, until residuals determine it
LARGEST_STEP = 0.7  # in ln p: factor 2
LEAST_FALL = 1e-3  # expected fall of the cost below which a fit has ended; the cost is half the sum of squares
MOST_REFUSED = 8  # steps running that lower no cost
SHAPES = 25.0  # cost of a mode with MAC 0: with 1 - MAC = 0.02 it costs 0.5
UNPAIRED = 40.0  # cost of a mode that the model lacks
USUAL_F = 0.002  # relative standard deviation of frequencies without one
USUAL_ZETA = 0.1  # relative standard deviation of damping ratios without one
QUIET = 3.0  # median residual of the neighbours of a spike
NEIGHBOURS = 3  # lines with which residuals may be correlated


@dataclass(frozen=True)
class Residuals:
    """Residuals r (N) and their slopes (p, N) by ln p."""

    r: Array
    J: Array


@dataclass(frozen=True)
class WindowAlternative:
    """An alternative window of tests, the changes (p,) of x under it, and whether standard deviations include them."""

    tests: tuple[int, ...]
    window: Window
    shift: Array
    counts: bool


@dataclass(frozen=True)
class Fit:
    """Logarithms x (p,) of the unknowns, their covariance (p, p), residuals.

    `chi2` is the mean square of residuals but for `spikes` of lines, 1 for a model that is as exact as the data; NaN
    where the noise is unknown.
    `cost` compares minima: the negative log-likelihood of ln H, with the prior. Above `far` chi2 is more than noise;
    where the noise is unknown, `logarithm`, the median of |ln(G/H)|, decides. With nuisances `largest_term` is the
    largest smooth term over the median of its response, `delays` are those of channels, `gains` factors of lines, and
    `chi2_alone` is that of the model alone. Correlated residuals of neighbouring lines make standard deviations `wider`
    by this factor. `tests` are with the windows that they are seen through, `windows` the standard deviations of
    the fitted ones, by test; where they are not determined, `alternatives` are other possible ones.
    """

    x: Array
    covariance: Array
    chi2: float
    residuals: Array
    far: float
    lines: tuple[Lines, ...]
    cost: float
    logarithm: float
    wider: float = 1.0
    largest_term: float = 0.0
    delays: tuple[Delay, ...] = ()
    gains: tuple[Gain, ...] = ()
    chi2_alone: float = math.nan
    tests: tuple[VibrationTest, ...] = ()
    spikes: tuple[BoolArray, ...] = ()
    windows: Mapping[int, float] = field(default_factory=dict)
    alternatives: tuple[WindowAlternative, ...] = ()

    @property
    def is_far(self) -> bool:
        """Whether residuals exceed what noise explains."""
        is_far = self.chi2 > self.far if math.isfinite(self.chi2) else self.logarithm > FAR_LOGARITHM
        return is_far and bool(self.lines)

    @property
    def std(self) -> Array:
        """Standard deviations (p,) of x."""
        return np.sqrt(np.diag(self.covariance))


Of = Callable[[Lines, ComplexArray, ComplexArray], Residuals]
"""Residuals of a line from what it is predicted to be, and the slopes of that."""


@dataclass(frozen=True)
class Misfit:
    """Misfit between tests and predictions: responses, nuisances, and evidence of other data.

    Its unknowns x (p + w + m,) are ln p, changes of windows, and coefficients of nuisances. While it `trusts` evidence,
    the last residuals, these have no outliers: far from a minimum Cauchy's weights would ignore them.
    """

    predictions: Predictions
    lines: tuple[Lines, ...]
    far: float
    robust: bool = True
    nuisances: Nuisances = field(default_factory=Nuisances)
    evidence: Evidence | None = None
    trusts: bool = False

    @property
    def unknowns(self) -> int:
        """Number p of parameters of the machine."""
        return len(self.predictions.sought.unknowns)

    @property
    def first(self) -> int:
        """Number p + w of unknowns of the predictions, before the coefficients of nuisances."""
        return self.unknowns + len(self.predictions.windowed)

    @cached_property
    def start(self) -> Array:
        """Initial values of all unknowns."""
        return np.concatenate([self.predictions.start, np.zeros(len(self.nuisances.prior))])

    @cached_property
    def prior(self) -> Array:
        """Inverse prior variances of all unknowns."""
        return np.concatenate([self.predictions.prior, self.nuisances.prior])

    def response(self, k: int, predicted: list[Predicted], x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Return the predicted response of line k with nuisances, and its slopes (p + w + m, N)."""
        line = self.lines[k]
        response = predicted[line.test].responses[line.place]
        dG = response.slopes[:, line.counted]
        return self.nuisances.added_to(k, response.G[line.counted], dG, x[self.first :])

    def residuals(self, x: Array, of: Of) -> Residuals:
        """Return the residuals of all tests, those of modes last; raises `InputError` without equilibrium."""
        predicted = self.predictions.at(x[: self.first])
        parts = [of(line, *self.response(k, predicted, x)) for k, line in enumerate(self.lines)]
        for test, prediction in zip(self.predictions.tests, predicted, strict=True):
            if test.modes is not None and prediction.modes is not None:
                modal = modal_residuals(test.modes, prediction.modes)
                parts.append(Residuals(modal.r, np.pad(modal.J, ((0, len(self.nuisances.prior)), (0, 0)))))
        if self.evidence is not None:
            r, J = self.evidence.residuals(x[: self.unknowns])
            parts.append(Residuals(r, np.pad(J, ((0, len(x) - self.unknowns), (0, 0)))))
        return Residuals(np.concatenate([part.r for part in parts]), np.concatenate([part.J for part in parts], axis=1))

    def expected_fall(self, x: Array) -> float:
        """Return the fall of the cost in one Gauss-Newton step from x, under a linear model."""
        here = self.residuals(x, differences)
        weighted = here.J * self._weights(here.r, self.scale(here.r))
        b = weighted @ here.r + self.prior * (x - self.start)
        return float(0.5 * b @ np.linalg.solve(weighted @ here.J.T + np.diag(self.prior), b))

    def minimum(self, x: Array, of: Of) -> Array:
        """Return the minimum from x by Levenberg-Marquardt; ends at a small gain or after refused steps."""
        here, damping, refused = self.residuals(x, of), 1e-3, 0
        for _ in range(MOST_STEPS):
            c = self.scale(here.r)
            weights = self._weights(here.r, c)
            A = (here.J * weights) @ here.J.T + np.diag(self.prior)
            b = (here.J * weights) @ here.r + self.prior * (x - self.start)
            newton = np.linalg.solve(A, b)
            least = LEAST_FALL * max(1.0, 2 * self.cost(here.r, x, c) / len(here.r))
            if 0.5 * b @ newton < least:
                break
            step = -np.linalg.solve(A + damping * np.diag(np.diag(A)), b)
            step *= min(1.0, LARGEST_STEP / np.abs(step).max())
            there = self._finite_residuals(x + step, of)
            fall = -1.0 if there is None else self.cost(here.r, x, c) - self.cost(there.r, x + step, c)
            if there is not None and fall > 0:
                x, here, refused = x + step, there, 0
                damping = max(damping / 5, 1e-9)
            else:
                refused += 1
                damping = max(damping * 10, 1e-4)
                if refused > (1 if -(step @ b + 0.5 * step @ A @ step) < least else MOST_REFUSED):
                    break
        return x

    def _finite_residuals(self, x: Array, of: Of) -> Residuals | None:
        """Return the residuals, None where the machine has no equilibrium or a line no finite response."""
        try:
            residuals = self.residuals(x, of)
        except (InputError, np.linalg.LinAlgError):
            return None
        return residuals if np.isfinite(residuals.r).all() and np.isfinite(residuals.J).all() else None

    def scale(self, r: Array) -> float:
        """Return the scale c of Cauchy's weights from the residuals."""
        return CAUCHY * max(1.0, TO_DEVIATION * float(np.median(np.abs(r)))) if len(r) else CAUCHY

    def _may_be_outliers(self, r: Array) -> BoolArray:
        """Return a mask of the residuals that may be outliers."""
        tested: BoolArray = np.full(len(r), self.robust)
        if self.trusts and self.evidence is not None:
            tested[-len(self.evidence.values) :] = False
        return tested

    def _weights(self, r: Array, c: float) -> Array:
        return np.where(self._may_be_outliers(r), 1 / (1 + (r / c) ** 2), 1.0)

    def cost(self, r: Array, x: Array, c: float) -> float:
        """Return half the sum of squares, or its Cauchy form, with the prior."""
        data = np.where(self._may_be_outliers(r), c**2 * np.log1p((r / c) ** 2), r**2)
        return float(0.5 * data.sum() + 0.5 * self.prior @ (x - self.start) ** 2)

    def cost_at(self, x: Array, c: float) -> float:
        """Return the cost of lines and evidence at x, infinite without equilibrium."""
        try:
            predicted = self.predictions.at(x[: self.first], slopes=False)
        except (InputError, np.linalg.LinAlgError):
            return math.inf
        parts = [self.evidence.apart(x[: self.unknowns])] if self.evidence else []
        for k, line in enumerate(self.lines):
            apart = (self.response(k, predicted, x)[0] - line.H) / line.sd
            parts += [apart.real, apart.imag]
        return self.cost(np.concatenate(parts), x, c)

    def with_wider_evidence(self, factor: float) -> Misfit:
        """Return the misfit with trusted evidence, its standard deviations times a factor."""
        evidence = self.evidence and replace(self.evidence, root=self.evidence.root / factor)
        return replace(self, evidence=evidence, trusts=True)

    @property
    def with_all_pairs(self) -> Misfit:
        """The misfit with uncertain pairs of measured and predicted modes included."""
        return replace(self, predictions=self.predictions.with_all_pairs())

    def modal_cost(self, x: Array, oscillations: Sequence[Oscillations] | None = None) -> float:
        """Return the cost of all measured modes, paired or not, and of the prior at ln p.

        `oscillations` is what oscillates in each test there, if that is known.
        """
        own, tests = oscillations or self.predictions.oscillations(x), self.predictions.tests
        pairs = zip(tests, own, strict=True)
        distances = [modal_distance(test.modes, modes) for test, modes in pairs if test.modes]
        return float(sum(distances) + 0.5 * self.prior[: self.unknowns] @ (x - self.predictions.sought.start) ** 2)

    def is_modal_noise(self, cost: float) -> bool:
        """Whether a cost of modes is small enough to result from noise and the prior.

        Cauchy's cost of a normal value is 0.4 +- 0.5; of a start within one deviation of the prior, 0.5 each at most.
        """
        values = sum(2 * len(test.modes.f) for test in self.predictions.tests if test.modes)
        return cost < 0.4 * values + 3 * 0.5 * math.sqrt(values) + 0.5 * self.unknowns

    def with_noise(self, x: Array) -> Misfit:
        """Return the misfit with unknown standard deviations estimated from the residuals at x."""
        if all(line.sd_is_known for line in self.lines):
            return self
        predicted, lines = self.predictions.at(x[: self.first], slopes=False), []
        for k, line in enumerate(self.lines):
            r = (self.response(k, predicted, x)[0] - line.H) / line.sd
            scale = TO_DEVIATION * float(np.median(np.abs(np.concatenate([r.real, r.imag]))))
            lines.append(line if line.sd_is_known else replace(line, sd=line.sd * max(scale, 1e-6)))
        return replace(self, lines=tuple(lines))

    def at_minimum(self, x: Array) -> Fit:
        """Return the fit with its covariance, for noise that is normal but for few lines."""
        here = self.residuals(x, differences)
        weights = self._weights(here.r, self.scale(here.r))
        mean, efficiency = _of_normal_noise() if self.robust else (1.0, 1.0)
        freedom = max(1.0 - len(x) / max(len(here.r), 1), 0.1)
        spikes = self._spikes(here.r) if self.robust else ()
        counted = weights.copy()
        counted[: 2 * sum(map(len, spikes))][np.concatenate([np.zeros(0, bool), *(np.tile(x, 2) for x in spikes)])] = (
            0.0
        )
        chi2 = float(counted @ here.r**2 / max(counted.sum(), 1e-300)) / mean / freedom
        wider = math.sqrt(self._variance_factor(np.sqrt(weights) * here.r))
        information = (here.J * weights) @ here.J.T * efficiency / max(chi2, 1.0) / wider**2
        covariance = np.asarray(np.linalg.inv(information + np.diag(self.prior)), dtype=float)
        p, m, std = self.unknowns, self.first, np.sqrt(np.diag(covariance))
        noise_is_known = all(line.sd_is_known for line in self.lines)
        far = self.far if self.lines else max(self.far, largest_chi2(freedom * len(here.r)))
        of_windows = zip(self.predictions.windowed, std[p:m].tolist(), strict=True)
        return Fit(
            x[:p], covariance[:p, :p], chi2 if noise_is_known else math.nan, here.r, far, self.lines,
            self.cost(here.r, x, CAUCHY) + 2 * sum(float(np.log(x.sd / np.abs(x.H)).sum()) for x in self.lines),
            self._median_logarithm(here.r), wider,
            self.nuisances.largest_term(x[m:]), self.nuisances.delays(x[m:], std[m:]),
            self.nuisances.gains(x[m:], covariance[m:, m:]), tests=self.predictions.tests_at(x[:m]),
            spikes=spikes, windows={k: s for k, s in of_windows if isinstance(k, int)},
        )  # fmt: skip

    def _of_lines(self, r: Array) -> list[ComplexArray]:
        """Return the complex residuals of each response."""
        ends = np.cumsum([2 * len(line.f) for line in self.lines])
        parts = [part.reshape(2, -1) for part in np.split(r[: ends[-1]], ends[:-1])] if self.lines else []
        return [part[0] + 1j * part[1] for part in parts]

    def _spikes(self, r: Array) -> tuple[BoolArray, ...]:
        """Return by response the lines that are far above noise, between neighbours that are not."""
        spikes, noise = [], self.scale(r) / CAUCHY
        for line, residuals in zip(self.lines, self._of_lines(r), strict=True):
            size, limit = np.abs(residuals) / noise, spike_limit(self.predictions.tests[line.test].averages)
            neighbours = np.median([np.roll(size, k) for k in (-2, -1, 1, 2)], axis=0)
            spikes.append((size > limit) & (neighbours < QUIET))
        return tuple(spikes)

    def _median_logarithm(self, r: Array) -> float:
        """Return the median of |ln(G/H)|, estimated from the residuals."""
        ratios = [
            1 + residuals * line.sd / line.H for residuals, line in zip(self._of_lines(r), self.lines, strict=True)
        ]
        return float(np.median(np.abs(np.log(np.concatenate(ratios))))) if ratios else 0.0

    def _variance_factor(self, r: Array) -> float:
        """Return the factor by which correlated lines raise the variance of means: 1 + 2 sum of rho_j.

        Windows correlate neighbouring lines (Hann with a random input: 4/9), and so do errors of a model.
        """
        lines = self._of_lines(r)
        size = sum(float(np.sum(np.abs(residuals) ** 2)) for residuals in lines)
        if size == 0.0:
            return 1.0
        rho = [
            sum(float(np.real(np.vdot(residuals[j:], residuals[:-j]))) for residuals in lines) / size
            for j in range(1, NEIGHBOURS + 1)
        ]
        chance = SIGNIFICANT / math.sqrt(2 * sum(map(len, lines)))
        return 1 + 2 * sum(max(x, 0.0) for x in rho) if rho[0] > chance else 1.0


def differences(line: Lines, G: ComplexArray, dG: ComplexArray) -> Residuals:
    """Return (G - H)/sd, real and imaginary parts: the residuals of maximum likelihood."""
    return in_parts((G - line.H) / line.sd, dG / line.sd)


def in_parts(r: ComplexArray, J: ComplexArray) -> Residuals:
    """Return complex residuals as real ones: real parts, then imaginary parts."""
    return Residuals(np.concatenate([r.real, r.imag]), np.concatenate([J.real, J.imag], axis=1))


@cache
def _of_normal_noise() -> tuple[float, float]:
    """Return for normal noise the weighted mean square, and the ratio of the information to J^T W J.

    An M-estimator has the variance E[psi^2]/E[psi']^2 times that of the information, psi = w r; E[w] J^T J is J^T W J.
    """
    r = np.linspace(-10, 10, 20001)
    density = np.exp(-(r**2) / 2)
    density /= density.sum()
    weight = 1 / (1 + (r / CAUCHY) ** 2)
    slope = (1 - (r / CAUCHY) ** 2) * weight**2
    mean, of_psi, of_slope = (float(density @ y) for y in (weight, (weight * r) ** 2, slope))
    return float(density @ (weight * r**2)) / mean, of_slope**2 / of_psi / mean


def modal_distance(measured: MeasuredModes, own: Oscillations) -> float:
    """Return the distance of measured modes from the model: Cauchy's cost, 1 - MAC, and a cost of unpaired modes."""
    pairs = pairs_of_modes(measured, own)
    poles, k = own.poles[pairs.columns], len(measured.f)
    f, zeta, nothing = np.full(k, np.nan), np.full(k, np.nan), np.zeros((0, k))
    f[pairs.rows], zeta[pairs.rows] = np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles)
    r = modal_residuals(measured, PredictedModes(f, zeta, nothing, nothing)).r
    shapes = SHAPES * float((1 - pairs.mac).sum())
    return float(0.5 * CAUCHY**2 * np.log1p((r / CAUCHY) ** 2).sum()) + shapes + UNPAIRED * (k - len(pairs.rows))


def modal_residuals(measured: MeasuredModes, predicted: PredictedModes) -> Residuals:
    """Return ln(f/f_measured)/sd and ln(zeta/zeta_measured)/sd of modes that have a partner, zero for others."""
    parts = []
    for own, value, slopes, std, usual in (
        (measured.f, predicted.f, predicted.slopes_f, measured.std_f, USUAL_F),
        (measured.zeta, predicted.zeta, predicted.slopes_zeta, measured.std_zeta, USUAL_ZETA),
    ):
        if own is None:
            continue
        relative = np.full(len(own), usual) if std is None else np.where(np.isfinite(std), std / own, usual)
        there = np.isfinite(value) & np.isfinite(own) & (value > 0) & np.isfinite(slopes).all(axis=0)
        r = np.log(np.where(there, value / np.where(there, own, 1.0), 1.0)) / relative
        J = np.where(there, slopes / np.where(there, value, 1.0), 0.0) / relative
        parts.append(Residuals(r, J))
    return Residuals(np.concatenate([part.r for part in parts]), np.concatenate([part.J for part in parts], axis=1))


def is_known(response: MeasuredResponse, averages: int | None) -> bool:
    """Whether coherence and averages determine the noise, so that chi2 tests the model."""
    return response.coherence is not None and averages is not None and averages > 1


def usual_chi2(averages: Sequence[int]) -> float:
    """Return the largest chi2 of a right model; with few averages the noise is inaccurate in some lines."""
    return LARGEST_CHI2 + TAIL / max(min(averages, default=math.inf) - 1, 1)


def spike_limit(averages: int | None) -> float:
    """Return the size of complex residuals that noise seldom exceeds: P = (1 + r^2/k)^(-k/2), k = 2 (n - 1)."""
    free = 2 * max((averages or USUAL_AVERAGES) - 1, 1)
    return math.sqrt(free * (SELDOM ** (-2 / free) - 1))


def deviations(response: MeasuredResponse, averages: int | None) -> Array:
    """Return the standard deviations (N) of real and imaginary parts; only their shape where these are unknown."""
    size = np.abs(response.H)
    if response.coherence is None:
        shape: Array = GUESS * np.hypot(size, np.median(size))
        return shape
    g2 = np.clip(response.coherence, LEAST_COHERENCE, MOST_COHERENCE)
    sd: Array = size * np.sqrt((1 - g2) / (2 * g2 * max((averages or 1) - 1, 1)))
    return np.maximum(sd, 1e-3 * GUESS * max(float(np.median(size)), np.finfo(float).tiny))
