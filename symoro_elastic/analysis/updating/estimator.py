"""The estimator: parameters that vibration tests tell, in two stages, robust against lines that are wrong.

    1. find:    r = ln(G/H), weights 1/max(sd, 0.3 noise)       (insensitive to the height of peaks: a wide basin)
    2. finish:  r = (G - H)/sd, real and imaginary parts        (maximum likelihood)

If residuals stay large, again from the best points on lines along each unknown. Then from the start, with responses
smoothed over frequency at first, less and less: by Poisson's kernel a w/((a w)^2 + (w - v)^2), which is what more
damping does to a response. G and H are smoothed alike, over the lines there are, so that nothing outside the band is
missing. Then from where two springs have exchanged their values, and from a scan within the prior. Between them the
best minimum gets terms of modes outside the band. The first minimum that leaves no more than noise is taken, else the
best one of the model alone.

Both by Levenberg-Marquardt with steps limited in ln p, a prior, and Cauchy weights w = 1/(1 + (r/c)^2), c = 2.5 s with
s = max(1, 1.4826 median |r|). Balmes 1993 and Lin and Ewins 1994 for residuals of logarithms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from symoro_elastic.analysis.updating.background import Background, background_of
from symoro_elastic.analysis.updating.measured import MeasuredModes, MeasuredResponse
from symoro_elastic.analysis.updating.noise import deviations, is_known, usual_chi2
from symoro_elastic.analysis.updating.predictions import Predicted, PredictedModes, Predictions
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import outputs

LARGEST_STEP = 0.7
"""In ln p: factor 2."""
LEAST_FALL = 1e-3
"""Expected fall of the cost below which a fit has ended; the cost is half the sum of squares."""
MOST_STEPS = 60
MOST_REFUSED = 8
WIDTHS = (0.3, 0.1, 0.03)
"""Of the kernel that smooths responses, over the frequency."""
SCANNED, MOST_SCANNED = 100, 3
"""Points within the prior, and of them those that fits begin at."""
LEAST_SPREAD = 0.01
ALONG, APART, MOST_ALONG = np.linspace(-1.5, 1.5, 13), 0.4, 4
"""Points on a line along an unknown, how far apart starts on it are, over its prior, and how many are taken."""
TRIED, CLEAR, SAME = (0.25, 0.5, 1.0), 3.0, 6.0
"""Distances of other values over the prior; deviations at which they should differ; costs that do not."""
EXCHANGES, LEAST_CORRELATED = 3, 0.5
"""Pairs of parameters that are exchanged, and the correlation of their errors."""
FAR_LOGARITHM = 0.05
"""Median |ln(G/H)| above which another minimum is sought where the noise is unknown."""
CAUCHY = 2.5
LEAST_SHARE = 0.3
"""Of a pair's noise, below which a line of stage 1 gets no more weight."""
USUAL_F, USUAL_ZETA = 0.002, 0.1
"""Relative standard deviations of frequencies and damping ratios that no file gives."""
ZERO = 1e-6
"""Of the largest output of an input: a model response below it is zero."""


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
class Fit:
    """Logarithms x (p,) of the unknowns, information of the data and covariance (p, p), residuals and weights.

    `chi2` is the mean square of residuals, 1 for a model that is as exact as the data; NaN where the noise is unknown.
    Above `far` residuals are more than noise. Where terms of what is outside the band are fitted beside the model,
    `beside` is the largest of them, over the median of its response, and `chi2_alone` that of the model without them.
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
    beside: float = 0.0
    chi2_alone: float = math.nan


def lines_of(
    predictions: Predictions, without: Sequence[tuple[float, float]] = (), least: float = ZERO
) -> tuple[list[Lines], list[tuple[int, int]]]:
    """Return the lines of all responses, and the places of those that the model cannot have (zero by symmetry)."""
    found: list[Lines] = []
    zero: list[tuple[int, int]] = []
    x = predictions.sought.start
    for t, (test, predicted) in enumerate(zip(predictions.tests, predictions.at(x, slopes=False), strict=True)):
        sizes = [float(np.median(np.abs(one.G))) for one in predicted.responses]
        for k, response in enumerate(test.responses):
            beside = [s for s, other in zip(sizes, test.responses, strict=True) if other.input == response.input]
            if sizes[k] <= least * max(beside) or sizes[k] == 0:
                zero.append((t, k))
                continue
            counted = np.abs(response.H) > 0
            if not counted.any():
                what = "is zero in every line, and its model is not: measure again, or leave the pair out"
                raise InputError(test.name, f"{response.output}/{response.input}", what)
            for low, high in without:
                counted &= (response.f < low) | (response.f > high)
            if not counted.any():
                what = f"{response.output}/{response.input} has no line left: give other windows, or leave the pair out"
                raise InputError(test.name, "--without", what)
            sd = deviations(response, test.averages)[counted]
            found.append(Lines(response, counted, sd, is_known(response, test.averages), t, k))
    return found, zero


class Estimator:
    """Residuals of lines and modes at any values of the unknowns, and their minima."""

    def __init__(self, predictions: Predictions, lines: Sequence[Lines], robust: bool = True) -> None:
        self.predictions, self.lines, self.robust = predictions, tuple(lines), robust
        self._given = self.lines
        self.evaluations, self.unknowns = 0, len(predictions.sought.unknowns)
        self._kernels: dict[tuple[float, bytes], Array] = {}
        self.start, self.prior = predictions.sought.start, predictions.sought.prior
        self.far = usual_chi2([test.averages for test in predictions.tests if test.averages])
        self.beside = Background(())

    def fit(self, check: Callable[[Sequence[Lines], Sequence[Predicted]], None] = lambda *_: None) -> Fit:
        """Return the first minimum that leaves no more than noise, or the best one of the model alone.

        Before others than that near the start are sought, `check` is called with lines and predictions: it may refuse
        the tests.
        """
        alone: list[Fit] = []
        for one in self._minima(check, alone):
            if not self._is_far(one):
                break
        else:
            one = min(alone, key=self._distance)
        has_modes = any(test.modes for test in self.predictions.tests)
        return one if one.beside or has_modes or not one.lines else self._widened(one, one.x)

    def _minima(self, check: Callable[[Sequence[Lines], Sequence[Predicted]], None], alone: list[Fit]) -> Iterator[Fit]:
        """Yield minima in the order in which they are sought; those of the model `alone` are kept there.

        Beside each stands the one with terms of what is outside the band: in a wrong minimum these explain no more.
        """

        def found(x: Array) -> Fit:
            alone.append(self._fit(x))
            return alone[-1]

        yield found(self.start)
        check(alone[0].lines, self.predictions.at(alone[0].x, slopes=False))
        last = None
        for starts in (self._along_axes, self._from_smoothed, self._exchanged, self._scanned):
            yield from map(found, starts(min(alone, key=self._distance)))
            best = min(alone, key=self._distance)
            if best is not last:
                yield self._with_terms(best)
            last = best

    def _with_terms(self, found: Fit) -> Fit:
        """Return the minimum near one of the model alone, with terms of what is outside the band beside it."""
        if not (found.lines and math.isfinite(found.chi2)):
            return found
        machine, alone = self.predictions.motion.given, (self.start, self.prior, self.beside)
        orders = [outputs(machine, [line.measured.output])[0].order for line in self.lines]
        self.beside = background_of([(line.f, line.H, n) for line, n in zip(self.lines, orders, strict=True)])
        m = self.beside.count
        self.start, self.prior = np.concatenate([self.start, np.zeros(m)]), np.concatenate([self.prior, np.ones(m)])
        x = self._minimum(np.concatenate([found.x, np.zeros(m)]), self._differences)
        fit = replace(self._at_minimum(x), chi2_alone=found.chi2)
        fit = fit if self._is_far(fit) else self._widened(fit, x)
        self.start, self.prior, self.beside = alone
        return fit

    def _widened(self, fit: Fit, x: Array) -> Fit:
        """Return the fit with intervals that hold values far off, where these explain the tests as well.

        A mode beyond the band, or one that hardly shows, may sit where it explains some noise: how sharp that minimum
        is says nothing of other values. They are tried with all other unknowns as they are, which can only cost more.
        """
        std, wide = np.sqrt(np.diag(fit.covariance)), np.ones(self.unknowns)
        c = self._scale(fit.residuals)
        least = self._cost(fit.residuals, x, c)
        for k, along in enumerate(np.eye(len(x))[: self.unknowns] / np.sqrt(self.prior)[:, None][: self.unknowns]):
            for share in TRIED:
                d = share * along[k]
                if d <= CLEAR * std[k]:
                    continue
                rise = min(self._cost_at(x + way * share * along, c) for way in (1, -1)) - least
                if rise > min(SAME, (d / std[k]) ** 2 / 8):
                    break
                wide[k] = d / std[k]
        return replace(fit, covariance=fit.covariance * np.outer(wide, wide))

    def _cost_at(self, x: Array, c: float) -> float:
        """Return the cost of lines at x, infinite without equilibrium."""
        try:
            predicted = self.predictions.at(x[: self.unknowns], slopes=False)
        except (InputError, np.linalg.LinAlgError):
            return math.inf
        parts = []
        for line in self.lines:
            apart = (predicted[line.test].responses[line.place].G[line.counted] - line.H) / line.sd
            parts += [apart.real, apart.imag]
        r: Array = np.concatenate(parts)
        if self.beside.count:
            r += x[self.unknowns :] @ self.beside.over([line.sd for line in self.lines])
        return self._cost(r, x, c)

    def _from_smoothed(self, _: Fit) -> Iterator[Array]:
        """Yield the minimum of responses that are smoothed less and less, from the start on."""
        yield self._of_smoothed(self.start)

    def _of_smoothed(self, x: Array) -> Array:
        """Return the minimum of responses that are smoothed less and less."""
        for width in WIDTHS:
            x = self._minimum(x, partial(self._smoothed, width))
        return x

    def _along_axes(self, fit: Fit) -> Iterator[Array]:
        """Yield the best points of lines along each unknown within its prior, through the others of a fit.

        A fit is often wrong in one mode alone, that has hidden between lines with hardly a damping: what is beyond two
        deviations of its prior is where it started.
        """
        std = 1 / np.sqrt(self.prior)
        x = np.where(np.abs(fit.x - self.start) > 2 * std, self.start, fit.x)
        points = np.repeat(x[None], len(x) * len(ALONG), axis=0)
        axes = np.repeat(np.arange(len(x)), len(ALONG))
        rows = np.arange(len(axes))
        points[rows, axes] = self.start[axes] + np.tile(ALONG, len(x)) * std[axes]
        taken: list[int] = []
        for k in np.argsort([self._smoothed_cost(x, WIDTHS[0]) for x in points]).tolist():
            if all(np.abs((points[k] - points[one]) / std).max() > APART for one in taken):
                taken.append(k)
            if len(taken) == MOST_ALONG:
                break
        yield from points[taken]

    def _scanned(self, _: Fit) -> Iterator[Array]:
        """Yield minima of smoothed responses near the best of many points within the prior."""
        rng = np.random.default_rng(0)
        points = self.start + rng.uniform(-1, 1, (SCANNED, len(self.start))) / np.sqrt(self.prior)
        order = np.argsort([self._smoothed_cost(x, WIDTHS[1]) for x in points])
        for k in order[:MOST_SCANNED]:
            yield self._of_smoothed(points[k])

    def _smoothed_cost(self, x: Array, width: float) -> float:
        """Return the mean |ln(G/H)|^2 of smoothed responses, infinite without equilibrium."""
        try:
            predicted = self.predictions.at(x, slopes=False)
        except (InputError, np.linalg.LinAlgError):
            return math.inf
        total = 0.0
        for line in self.lines:
            kernel = self._kernel(width, line)
            G = predicted[line.test].responses[line.place].G[line.counted]
            total += float(np.mean(np.abs(np.log((kernel @ G) / (kernel @ line.H))) ** 2))
        return total if math.isfinite(total) else math.inf

    def _exchanged(self, fit: Fit) -> list[Array]:
        """Return starts in which two parameters have exchanged their values, as springs in a row may have.

        They are the pairs of one unit whose errors are correlated most.
        """
        std = np.sqrt(np.diag(fit.covariance))
        units = np.array([one.unit for one in self.predictions.sought.unknowns])
        correlated = np.where(units[:, None] == units, np.abs(fit.covariance) / np.outer(std, std), 0.0)
        order = np.argsort(-np.triu(correlated, 1), axis=None)[:EXCHANGES]
        found = []
        for i, j in zip(*np.unravel_index(order, correlated.shape), strict=True):
            if correlated[i, j] < LEAST_CORRELATED:
                break
            x = fit.x.copy()
            x[[i, j]] = x[[j, i]]
            found.append(x)
        return found

    def _fit(self, x: Array) -> Fit:
        """Return the minimum near x: stage 1, then stage 2, whose noise is that of the residuals if unknown."""
        self.lines = self._given
        x = self._minimum(x, self._logarithms)
        self.lines = tuple(self._with_noise(line, x) for line in self.lines)
        x = self._minimum(x, self._differences)
        if not all(line.sd_is_known for line in self.lines):
            self.lines = tuple(self._with_noise(line, x) for line in self.lines)
            x = self._minimum(x, self._differences)
        return self._at_minimum(x)

    def _is_far(self, fit: Fit) -> bool:
        """Whether residuals are larger than noise explains, so that another minimum may be better."""
        if not fit.lines:
            return False
        return fit.chi2 > self.far if math.isfinite(fit.chi2) else self._distance(fit) > FAR_LOGARITHM

    def _distance(self, fit: Fit) -> float:
        """Return the cost of a minimum, or the median of |ln(G/H)| where the noise is unknown."""
        if math.isfinite(fit.chi2):
            return self._cost(fit.residuals, fit.x, CAUCHY)
        predicted = self.predictions.at(fit.x, slopes=False)
        every = [predicted[line.test].responses[line.place].G[line.counted] / line.H for line in fit.lines]
        return float(np.median(np.abs(np.log(np.concatenate(every)))))

    def _with_noise(self, line: Lines, x: Array) -> Lines:
        """Return lines with the standard deviation of their residuals, where none is known."""
        if line.sd_is_known:
            return line
        (predicted,) = self.predictions.at(x, False, [self.predictions.tests[line.test]])
        r = (predicted.responses[line.place].G[line.counted] - line.H) / line.sd
        scale = 1.4826 * float(np.median(np.abs(np.concatenate([r.real, r.imag]))))
        return Lines(line.measured, line.counted, line.sd * max(scale, 1e-6), False, line.test, line.place)

    def residuals(self, x: Array, of: Callable[[Lines, Predicted], Residuals]) -> Residuals:
        """Return the residuals of all tests, those of modes last; raises `InputError` without equilibrium."""
        self.evaluations += 1
        p = self.unknowns
        predicted = self.predictions.at(x[:p])
        parts = [of(line, predicted[line.test]) for line in self.lines]
        for test, one in zip(self.predictions.tests, predicted, strict=True):
            if test.modes is not None and one.modes is not None:
                parts.append(_modal(test.modes, one.modes))
        r, J = np.concatenate([part.r for part in parts]), np.concatenate([part.J for part in parts], axis=1)
        if self.beside.count:
            beside = self.beside.over([line.sd for line in self.lines])
            r[: beside.shape[1]] += x[p:] @ beside
            J = np.concatenate([J, np.pad(beside, ((0, 0), (0, len(r) - beside.shape[1])))])
        return Residuals(r, J)

    def _logarithms(self, line: Lines, predicted: Predicted) -> Residuals:
        """Return ln(G/H), its phase wrapped; weights are bounded where lines are exact."""
        one = predicted.responses[line.place]
        G, dG = one.G[line.counted], one.slopes[:, line.counted]  # type: ignore[index]
        sd = line.sd / np.abs(line.H)
        weight = 1 / np.maximum(sd, LEAST_SHARE * np.median(sd))
        r, J = np.log(G / line.H) * weight, dG / G * weight
        return Residuals(np.concatenate([r.real, r.imag]), np.concatenate([J.real, J.imag], axis=1))

    def _smoothed(self, width: float, line: Lines, predicted: Predicted) -> Residuals:
        """Return ln(G/H) of smoothed responses, in units of the noise of lines."""
        one = predicted.responses[line.place]
        kernel = self._kernel(width, line)
        G, dG = kernel @ one.G[line.counted], one.slopes[:, line.counted] @ kernel.T  # type: ignore[index]
        weight = 1 / max(float(np.median(line.sd / np.abs(line.H))), LEAST_SPREAD)
        r, J = np.log(G / (kernel @ line.H)) * weight, dG / G * weight
        return Residuals(np.concatenate([r.real, r.imag]), np.concatenate([J.real, J.imag], axis=1))

    def _kernel(self, width: float, line: Lines) -> Array:
        """Return weights (N, N) of lines, rows that sum to 1; each line stands for the band that is nearest to it."""
        key = (width, line.f.tobytes())
        if key not in self._kernels:
            f = line.f
            share = np.gradient(f) if len(f) > 1 else np.ones(1)
            kernel = share * width * f[:, None] / ((width * f[:, None]) ** 2 + (f[:, None] - f) ** 2)
            self._kernels[key] = kernel / kernel.sum(axis=1, keepdims=True)
        return self._kernels[key]

    def _differences(self, line: Lines, predicted: Predicted) -> Residuals:
        one = predicted.responses[line.place]
        r = (one.G[line.counted] - line.H) / line.sd
        J = one.slopes[:, line.counted] / line.sd  # type: ignore[index]
        return Residuals(np.concatenate([r.real, r.imag]), np.concatenate([J.real, J.imag], axis=1))

    def _minimum(self, x: Array, of: Callable[[Lines, Predicted], Residuals]) -> Array:
        """Return where Levenberg-Marquardt ends: little to gain, or two steps running refused."""
        here, damping, refused = self.residuals(x, of), 1e-3, 0
        for _ in range(MOST_STEPS):
            c = self._scale(here.r)
            weights = self._weights(here.r, c)
            A = (here.J * weights) @ here.J.T + np.diag(self.prior)
            b = (here.J * weights) @ here.r + self.prior * (x - self.start)
            newton = np.linalg.solve(A, b)
            least = LEAST_FALL * max(1.0, 2 * self._cost(here.r, x, c) / len(here.r))
            if 0.5 * b @ newton < least:
                break
            step = -np.linalg.solve(A + damping * np.diag(np.diag(A)), b)
            step *= min(1.0, LARGEST_STEP / np.abs(step).max())
            there = self._tried(x + step, of)
            fall = -1.0 if there is None else self._cost(here.r, x, c) - self._cost(there.r, x + step, c)
            if there is not None and fall > 0:
                x, here, refused = x + step, there, 0
                damping = max(damping / 5, 1e-9)
            else:
                refused += 1
                damping = max(damping * 10, 1e-4)
                if refused > (1 if -(step @ b + 0.5 * step @ A @ step) < least else MOST_REFUSED):
                    break
        return x

    def _tried(self, x: Array, of: Callable[[Lines, Predicted], Residuals]) -> Residuals | None:
        """Return the residuals, None where the machine has no equilibrium or a line no finite response."""
        try:
            found = self.residuals(x, of)
        except (InputError, np.linalg.LinAlgError):
            return None
        return found if np.isfinite(found.r).all() and np.isfinite(found.J).all() else None

    def _scale(self, r: Array) -> float:
        return CAUCHY * max(1.0, 1.4826 * float(np.median(np.abs(r)))) if len(r) else CAUCHY

    def _weights(self, r: Array, c: float) -> Array:
        return 1 / (1 + (r / c) ** 2) if self.robust else np.ones_like(r)

    def _cost(self, r: Array, x: Array, c: float) -> float:
        """Half the sum of squares, or its Cauchy form, with the prior."""
        data = 0.5 * c**2 * np.log1p((r / c) ** 2).sum() if self.robust else 0.5 * (r**2).sum()
        return float(data + 0.5 * self.prior @ (x - self.start) ** 2)

    def _at_minimum(self, x: Array) -> Fit:
        """Return the fit with its covariance, for noise that is normal but for few lines."""
        here = self.residuals(x, self._differences)
        weights = self._weights(here.r, self._scale(here.r))
        mean, efficiency = _of_normal_noise() if self.robust else (1.0, 1.0)
        freedom = max(1.0 - len(x) / max(len(here.r), 1), 0.1)
        chi2 = float((weights * here.r**2).sum() / max(weights.sum(), 1e-300)) / mean / freedom
        information = (here.J * weights) @ here.J.T * efficiency / max(chi2, 1.0)
        p, whole = self.unknowns, information + np.diag(self.prior)
        covariance = np.asarray(np.linalg.inv(whole), dtype=float)[:p, :p]
        if self.beside.count:
            information = whole[:p, :p] - whole[:p, p:] @ np.linalg.solve(whole[p:, p:], whole[p:, :p])
            information -= np.diag(self.prior[:p])
        known = all(line.sd_is_known for line in self.lines)
        return Fit(
            x[:p], information, covariance, chi2 if known else float("nan"), here.r, weights, self.evaluations,
            self.far, self.lines, self.beside.largest(x[p:]),
        )  # fmt: skip


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


def _modal(measured: MeasuredModes, predicted: PredictedModes) -> Residuals:
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
