"""Residuals of vibration tests at any values of the unknowns, and the minimum of their sum of squares near a start.

By Levenberg-Marquardt with steps limited in ln p, a prior, and Cauchy weights w = 1/(1 + (r/c)^2), c = 2.5 s with
s = max(1, 1.4826 median |r|). Unknowns are ln p, then the coefficients of what is fitted beside the model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import numpy as np

from symoro_elastic.analysis.updating.beside import Beside, Delay, Gain
from symoro_elastic.analysis.updating.measured import MeasuredModes, MeasuredResponse, VibrationTest
from symoro_elastic.analysis.updating.noise import spike_limit
from symoro_elastic.analysis.updating.predictions import Predicted, PredictedModes, Predictions, Swinging, paired
from symoro_elastic.analysis.updating.windows import Window
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import InputError

LARGEST_STEP = 0.7
"""In ln p: factor 2."""
LEAST_FALL = 1e-3
"""Expected fall of the cost below which a fit has ended; the cost is half the sum of squares."""
MOST_STEPS = 60
MOST_REFUSED = 8
CAUCHY = 2.5
SHAPES, UNPAIRED = 25.0, 40.0
"""Costs of a mode whose MAC is 0, so that one whose 1 - MAC is 0.02 costs half of one; of one that the model lacks."""
USUAL_F, USUAL_ZETA = 0.002, 0.1
"""Relative standard deviations of frequencies and damping ratios that no file gives."""
QUIET = 3.0
"""Median residual of the neighbours of a spike."""
NEIGHBOURS, ALIKE, CLEARLY = 3, 0.1, 5.0
"""Lines that are compared with a line; correlation of residuals that counts, and its standard deviations."""


@dataclass(frozen=True)
class Lines:
    """A response as it is fitted: the lines that count, its standard deviations, and whether they are known."""

    measured: MeasuredResponse
    counted: BoolArray
    sd: Array
    sd_is_known: bool
    test: int
    place: int

    @property
    def H(self) -> ComplexArray:
        """The lines that count."""
        H: ComplexArray = self.measured.H[self.counted]
        return H

    @property
    def f(self) -> Array:
        """Their frequencies, Hz."""
        return self.measured.f[self.counted]


@dataclass(frozen=True)
class Residuals:
    """Residuals r (N) and their slopes (p, N) by ln p."""

    r: Array
    J: Array


@dataclass(frozen=True)
class Doubt:
    """A window that tests may be under, the changes (p,) of x under it, whether standard deviations know of it."""

    tests: tuple[int, ...]
    window: Window
    shift: Array
    counts: bool


@dataclass(frozen=True)
class Fit:
    """Logarithms x (p,) of the unknowns, information of the data and covariance (p, p), residuals and weights.

    `chi2` is the mean square of residuals but for `spikes` of lines, 1 for a model that is as exact as the data; NaN
    where the noise is unknown.
    `distance` compares minima: their cost, or the median of |ln(G/H)| where the noise is unknown. Above `far` residuals
    are more than noise. Where more is fitted beside the model, `beside` is the largest smooth term over the median of
    its response, `delays` are those of channels, `gains` factors of lines, and `chi2_alone` is that of the model alone.
    Residuals of neighbouring lines that are alike make standard deviations `wider` by this factor. `tests` are with the
    windows that they are seen through, `windows` the standard deviations of what was fitted of these, by test; where
    they are not known, `under` are others that may be.
    """

    x: Array
    information: Array
    covariance: Array
    chi2: float
    residuals: Array
    weights: Array
    evaluations: int
    far: float
    lines: tuple[Lines, ...]
    distance: float
    wider: float = 1.0
    beside: float = 0.0
    delays: tuple[Delay, ...] = ()
    gains: tuple[Gain, ...] = ()
    chi2_alone: float = math.nan
    tests: tuple[VibrationTest, ...] = ()
    spikes: tuple[BoolArray, ...] = ()
    windows: Mapping[int, float] = field(default_factory=dict)
    under: tuple[Doubt, ...] = ()


@dataclass
class Tally:
    """Evaluations of predictions with slopes, over several fits."""

    evaluations: int = 0


Of = Callable[[Lines, ComplexArray, ComplexArray], Residuals]
"""Residuals of a line from what it is predicted to be, and the slopes of that."""


@dataclass(frozen=True)
class Misfit:
    """What a minimum is sought of: predictions, lines, what is fitted beside them.

    Its unknowns x (p + w + m,) are ln p, changes of windows, and coefficients of what is beside the model.
    """

    predictions: Predictions
    lines: tuple[Lines, ...]
    far: float
    robust: bool = True
    beside: Beside = field(default_factory=Beside)
    tally: Tally = field(default_factory=Tally)

    @property
    def unknowns(self) -> int:
        """Parameters p of the machine."""
        return len(self.predictions.sought.unknowns)

    @property
    def first(self) -> int:
        """Unknowns p + w of predictions."""
        return self.unknowns + len(self.predictions.windowed)

    @cached_property
    def start(self) -> Array:
        """Where all unknowns are before any test."""
        return np.concatenate([self.predictions.start, np.zeros(self.beside.count)])

    @cached_property
    def prior(self) -> Array:
        """Inverse variances of the unknowns before any test."""
        return np.concatenate([self.predictions.prior, self.beside.prior])

    def seen(self, k: int, predicted: list[Predicted], x: Array) -> tuple[ComplexArray, ComplexArray]:
        """Return what line k is predicted to be, and its slopes (p + w + m, N)."""
        line = self.lines[k]
        one = predicted[line.test].responses[line.place]
        dG = None if one.slopes is None else one.slopes[:, line.counted]
        return self.beside.seen(k, one.G[line.counted], dG, x[self.first :])

    def residuals(self, x: Array, of: Of) -> Residuals:
        """Return the residuals of all tests, those of modes last; raises `InputError` without equilibrium."""
        self.tally.evaluations += 1
        predicted = self.predictions.at(x[: self.first])
        parts = [of(line, *self.seen(k, predicted, x)) for k, line in enumerate(self.lines)]
        for test, one in zip(self.predictions.tests, predicted, strict=True):
            if test.modes is not None and one.modes is not None:
                modal = modal_residuals(test.modes, one.modes)
                parts.append(Residuals(modal.r, np.pad(modal.J, ((0, self.beside.count), (0, 0)))))
        return Residuals(np.concatenate([part.r for part in parts]), np.concatenate([part.J for part in parts], axis=1))

    def expected_fall(self, x: Array) -> float:
        """Return by how much the cost of differences falls from x in one step, were they linear."""
        here = self.residuals(x, differences)
        weighted = here.J * self._weights(here.r, self.scale(here.r))
        b = weighted @ here.r + self.prior * (x - self.start)
        return float(0.5 * b @ np.linalg.solve(weighted @ here.J.T + np.diag(self.prior), b))

    def minimum(self, x: Array, of: Of) -> Array:
        """Return where Levenberg-Marquardt ends: little to gain, or two steps running refused."""
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
            there = self._tried(x + step, of)
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

    def _tried(self, x: Array, of: Of) -> Residuals | None:
        """Return the residuals, None where the machine has no equilibrium or a line no finite response."""
        try:
            found = self.residuals(x, of)
        except (InputError, np.linalg.LinAlgError):
            return None
        return found if np.isfinite(found.r).all() and np.isfinite(found.J).all() else None

    def scale(self, r: Array) -> float:
        """Return c of Cauchy's weights."""
        return CAUCHY * max(1.0, 1.4826 * float(np.median(np.abs(r)))) if len(r) else CAUCHY

    def _weights(self, r: Array, c: float) -> Array:
        return 1 / (1 + (r / c) ** 2) if self.robust else np.ones_like(r)

    def cost(self, r: Array, x: Array, c: float) -> float:
        """Return half the sum of squares, or its Cauchy form, with the prior."""
        data = 0.5 * c**2 * np.log1p((r / c) ** 2).sum() if self.robust else 0.5 * (r**2).sum()
        return float(data + 0.5 * self.prior @ (x - self.start) ** 2)

    def cost_at(self, x: Array, c: float, most: float) -> float:
        """Return the cost of lines at x, infinite without equilibrium; that of some tests if it is above `most`."""
        tests = self.predictions.tests_at(x[: self.first])
        predicted: list[Predicted] = [Predicted(())] * len(tests)
        parts, cost = [], 0.0
        for t, test in enumerate(tests):
            try:
                predicted[t : t + 1] = self.predictions.at(x[: self.first], slopes=False, tests=[test])
            except (InputError, np.linalg.LinAlgError):
                return math.inf
            for k, line in enumerate(self.lines):
                if line.test == t:
                    apart = (self.seen(k, predicted, x)[0] - line.H) / line.sd
                    parts += [apart.real, apart.imag]
            cost = self.cost(np.concatenate(parts), x, c) if parts else 0.0
            if cost > most:
                break
        return cost

    @property
    def with_all_pairs(self) -> Misfit:
        """The same, in which pairs of modes count that are in doubt."""
        return replace(self, predictions=self.predictions.with_all_pairs())

    def modal_cost(self, x: Array, swinging: Sequence[Swinging] | None = None) -> float:
        """Return the cost of all measured modes and of the prior at ln p, with or without a sure partner.

        `swinging` is what oscillates in each test there, if that is known.
        """
        own, tests = swinging or self.predictions.swinging(x), self.predictions.tests
        each = [modal_distance(test.modes, one) for test, one in zip(tests, own, strict=True) if test.modes]
        return float(sum(each) + 0.5 * self.prior[: self.unknowns] @ (x - self.predictions.sought.start) ** 2)

    def is_modal_noise(self, cost: float) -> bool:
        """Whether a cost of modes is no more than noise of their values and the doubt of the start explain.

        Cauchy's cost of a normal value is 0.4 +- 0.5; of a start within one deviation of the prior, 0.5 each at most.
        """
        values = sum(2 * len(test.modes.f) for test in self.predictions.tests if test.modes)
        return cost < 0.4 * values + 3 * 0.5 * math.sqrt(values) + 0.5 * self.unknowns

    def with_noise(self, x: Array) -> Misfit:
        """Return the same with the standard deviations of residuals, where none are known."""
        if all(line.sd_is_known for line in self.lines):
            return self
        predicted, found = self.predictions.at(x[: self.first], slopes=False), []
        for k, line in enumerate(self.lines):
            r = (self.seen(k, predicted, x)[0] - line.H) / line.sd
            scale = 1.4826 * float(np.median(np.abs(np.concatenate([r.real, r.imag]))))
            found.append(line if line.sd_is_known else replace(line, sd=line.sd * max(scale, 1e-6)))
        return replace(self, lines=tuple(found))

    def at_minimum(self, x: Array) -> Fit:
        """Return the fit with its covariance, for noise that is normal but for few lines."""
        here = self.residuals(x, differences)
        weights = self._weights(here.r, self.scale(here.r))
        mean, efficiency = _of_normal_noise() if self.robust else (1.0, 1.0)
        freedom = max(1.0 - len(x) / max(len(here.r), 1), 0.1)
        spikes = self._spikes(here.r) if self.robust else ()
        counted = np.ones(len(here.r), dtype=bool)
        counted[: 2 * sum(map(len, spikes))] = ~np.concatenate([counted[:0], *(np.tile(one, 2) for one in spikes)])
        squares = weights[counted] @ here.r[counted] ** 2
        chi2 = float(squares / max(weights[counted].sum(), 1e-300)) / mean / freedom
        wider = math.sqrt(self._alike(np.sqrt(weights) * here.r))
        information = (here.J * weights) @ here.J.T * efficiency / max(chi2, 1.0) / wider**2
        p, m, whole = self.unknowns, self.first, information + np.diag(self.prior)
        covariance = np.asarray(np.linalg.inv(whole), dtype=float)
        if len(x) > p:
            information = whole[:p, :p] - whole[:p, p:] @ np.linalg.solve(whole[p:, p:], whole[p:, :p])
            information -= np.diag(self.prior[:p])
        known = all(line.sd_is_known for line in self.lines)
        return Fit(
            x[:p], information, covariance[:p, :p], chi2 if known else math.nan, here.r, weights,
            self.tally.evaluations, self.far if self.lines else max(self.far, _largest_chi2(freedom * len(here.r))),
            self.lines,
            self.cost(here.r, x, CAUCHY) if known else self._median_logarithm(here.r), wider,
            self.beside.largest(x[m:]), self.beside.delays(x[m:], np.sqrt(np.diag(covariance)[m:])),
            self.beside.factors(x[m:], covariance[m:, m:]), tests=self.predictions.tests_at(x[:m]),
            spikes=spikes,
            windows={
                k: std
                for k, std in zip(self.predictions.windowed, np.sqrt(np.diag(covariance)[p:m]).tolist(), strict=True)
                if isinstance(k, int)
            },
        )  # fmt: skip

    def _of_lines(self, r: Array) -> list[ComplexArray]:
        """Return the residuals of each line, complex."""
        ends = np.cumsum([2 * len(line.f) for line in self.lines])
        parts = [part.reshape(2, -1) for part in np.split(r[: ends[-1]], ends[:-1])] if self.lines else []
        return [part[0] + 1j * part[1] for part in parts]

    def _spikes(self, r: Array) -> tuple[BoolArray, ...]:
        """Return which lines of each response are far above noise, between neighbours that are not."""
        found, noise = [], self.scale(r) / CAUCHY
        for line, one in zip(self.lines, self._of_lines(r), strict=True):
            size, limit = np.abs(one) / noise, spike_limit(self.predictions.tests[line.test].averages)
            beside = np.median([np.roll(size, k) for k in (-2, -1, 1, 2)], axis=0)
            found.append((size > limit) & (beside < QUIET))
        return tuple(found)

    def _median_logarithm(self, r: Array) -> float:
        """Return the median of |ln(G/H)| from residuals."""
        each = [1 + one * line.sd / line.H for one, line in zip(self._of_lines(r), self.lines, strict=True)]
        return float(np.median(np.abs(np.log(np.concatenate(each))))) if each else 0.0

    def _alike(self, r: Array) -> float:
        """Return by how much the variance of means over lines is larger than for independent ones: 1 + 2 sum of rho_j.

        Windows make neighbouring lines alike, by 4/9 those of Hann with a random input, and so do errors of a model.
        """
        lines = self._of_lines(r)
        size = sum(float(np.sum(np.abs(one) ** 2)) for one in lines)
        if size == 0.0:
            return 1.0
        rho = [
            sum(float(np.real(np.vdot(one[j:], one[:-j]))) for one in lines) / size for j in range(1, NEIGHBOURS + 1)
        ]
        clear = max(ALIKE, CLEARLY / math.sqrt(2 * sum(map(len, lines))))
        return 1 + 2 * sum(max(x, 0.0) for x in rho) if rho[0] > clear else 1.0


def differences(line: Lines, G: ComplexArray, dG: ComplexArray) -> Residuals:
    """Return (G - H)/sd, real and imaginary parts: the residuals of maximum likelihood."""
    return in_parts((G - line.H) / line.sd, dG / line.sd)


def in_parts(r: ComplexArray, J: ComplexArray) -> Residuals:
    """Return real parts before imaginary ones."""
    return Residuals(np.concatenate([r.real, r.imag]), np.concatenate([J.real, J.imag], axis=1))


@cache
def _of_normal_noise() -> tuple[float, float]:
    """Return of normal noise with std 1: the weighted mean square, and what J^T W J is short of the information.

    An M-estimator has the variance E[psi^2]/E[psi']^2 times that of the information, psi = w r; E[w] J^T J is J^T W J.
    """
    r = np.linspace(-10, 10, 20001)
    density = np.exp(-(r**2) / 2)
    density /= density.sum()
    weight = 1 / (1 + (r / CAUCHY) ** 2)
    slope = (1 - (r / CAUCHY) ** 2) * weight**2
    mean, of_psi, of_slope = (float(density @ y) for y in (weight, (weight * r) ** 2, slope))
    return float(density @ (weight * r**2)) / mean, of_slope**2 / of_psi / mean


def _largest_chi2(freedom: float) -> float:
    """Return what a mean square of noise exceeds once in a thousand, by degrees of freedom (Wilson and Hilferty)."""
    spread = 2 / (9 * max(freedom, 1.0))
    return float((1 - spread + 3.09 * math.sqrt(spread)) ** 3)


def modal_distance(measured: MeasuredModes, own: Swinging) -> float:
    """Return how far modes are from what oscillates: Cauchy's cost of residuals, 1 - MAC, modes without a partner."""
    pairs = paired(measured, own)
    poles, k = own.poles[pairs.columns], len(measured.f)
    f, zeta, nothing = np.full(k, np.nan), np.full(k, np.nan), np.zeros((0, k))
    f[pairs.rows], zeta[pairs.rows] = np.abs(poles) / (2 * np.pi), -poles.real / np.abs(poles)
    r = modal_residuals(measured, PredictedModes(f, zeta, nothing, nothing)).r
    shapes = SHAPES * float((1 - pairs.likeness).sum())
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
    return Residuals(np.concatenate([one.r for one in parts]), np.concatenate([one.J for one in parts], axis=1))
