"""The estimator: parameters from vibration tests, in two stages, robust against outlying frequencies.

    1. approach:  r = ln(G/H), weights 1/max(sd, 0.3 noise)       (insensitive to the height of peaks: a wide basin)
    2. finish:    r = (G - H)/sd, real and imaginary parts        (maximum likelihood)

From the initial values, and where residuals stay above noise in three further ways: with nuisance terms (windows that
are not named, gains and delays of channels, modes outside the band), from the best of many points of the prior, and
with nuisance terms there. Points are compared by responses smoothed over frequency, by Poisson's kernel
a w/((a w)^2 + (w - v)^2), which is what more damping does to a response. The first minimum that leaves no more than
noise is returned, else the best of the model alone, or with nuisance terms if these explain most of its residuals.

Balmes 1993 and Lin and Ewins 1994 for residuals of logarithms.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from operator import attrgetter

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.fitting.corrections import MOST_REFITTED, VERY_STRONG
from symoro_elastic.measured.fitting.estimates import SIGNIFICANT
from symoro_elastic.measured.fitting.evidence import Evidence, largest_chi2
from symoro_elastic.measured.vibration_tests.measured import VibrationTest, Window, WindowKind, roughly, with_windows
from symoro_elastic.measured.vibration_tests.misfit import (
    Fit,
    Misfit,
    Residuals,
    WindowAlternative,
    deviations,
    differences,
    in_parts,
    is_known,
    usual_chi2,
)
from symoro_elastic.measured.vibration_tests.nuisances import (
    ACCELERATION,
    Delay,
    Gain,
    Nuisances,
    channel_delays,
    channel_gains,
    out_of_band_modes,
)
from symoro_elastic.measured.vibration_tests.predictions import Lines, Predicted, Predictions
from symoro_elastic.numerics.motion.signals import outputs

WIDE = 0.3  # width of the kernel that smooths responses, over the frequency, to compare them far from a minimum
POINTS = 100  # points drawn within the prior
TRIED = (0.25, 0.5, 1.0)  # distances of other values, over the prior standard deviation, by which intervals are widened
LEAST_SHARE = 0.3  # of a pair's noise, below which a line of stage 1 gets no more weight
EXPLAINED = 0.1  # of chi2, the most that nuisances leave where they are accepted though residuals exceed noise
EXPLAINED_UNKNOWN = 0.9  # of the distance, the same where the noise is unknown
EXPLAINED_BY_WINDOW = 0.3  # of chi2 - 1, the most that a window leaves where the model lacks something, too
WIDER_EVIDENCE = (100.0, 10.0, 1.0)
"""Times the standard deviations of evidence, by which fits approach it: its valleys are narrow and curved."""
ZERO = 1e-6  # of the largest output of an input: a model response below it is zero


def lines_of(
    predictions: Predictions, without: Sequence[tuple[float, float]] = (), least: float = ZERO
) -> tuple[list[Lines], list[tuple[int, int]]]:
    """Return the lines of all responses, and the indices of responses that are zero in the model (by symmetry)."""
    lines: list[Lines] = []
    zero: list[tuple[int, int]] = []
    x = predictions.sought.start
    for t, (test, predicted) in enumerate(zip(predictions.tests, predictions.at(x, slopes=False), strict=True)):
        sizes = [float(np.median(np.abs(response_of_model.G))) for response_of_model in predicted.responses]
        for k, response in enumerate(test.responses):
            same_input = [s for s, other in zip(sizes, test.responses, strict=True) if other.input == response.input]
            if sizes[k] <= least * max(same_input) or sizes[k] == 0:
                zero.append((t, k))
                continue
            counted = np.abs(response.H) > 0
            if not counted.any():
                what = "is zero in every line, and its model is not: measure again, or leave the pair out"
                raise InputError(test.name, response.pair, what)
            for low, high in without:
                counted &= (response.f < low) | (response.f > high)
            if not counted.any():
                what = f"{response.pair} has no line left: give other windows, or leave the pair out"
                raise InputError(test.name, "--without", what)
            sd = deviations(response, test.averages)[counted]
            lines.append(Lines(response, counted, sd, is_known(response, test.averages), t, k))
    return lines, zero


@dataclass(frozen=True)
class Minimum:
    """A minimum of a misfit, with all its unknowns."""

    misfit: Misfit
    all: Array

    @cached_property
    def fit(self) -> Fit:
        """The fit at this minimum: estimates, covariance and chi2."""
        return self.misfit.at_minimum(self.all)

    @property
    def x(self) -> Array:
        """Logarithms of the unknowns."""
        return self.fit.x

    @property
    def is_far(self) -> bool:
        """Whether residuals are larger than noise explains, so that another minimum may be better."""
        return self.fit.is_far

    @property
    def is_clear(self) -> bool:
        """Whether residuals are those of noise, which leaves nothing to explain."""
        return self.fit.chi2 < largest_chi2(len(self.fit.residuals))

    @property
    def cost(self) -> float:
        """Negative log-likelihood, with the prior."""
        return self.fit.cost

    def changed_windows(self, tests: Sequence[VibrationTest]) -> dict[Window | None, Window]:
        """Return the windows that differ at this minimum from those that tests name, by named window."""
        pairs = ((a.window, b.window) for a, b in zip(tests, self.fit.tests, strict=True))
        return {named: window for named, window in pairs if window is not None and window is not named}

    def doubt(self, other: Minimum, counts: bool) -> WindowAlternative:
        """Return another minimum, under another window, as an alternative to this one."""
        pairs = enumerate(zip(self.fit.tests, other.fit.tests, strict=True))
        places = tuple(k for k, (own, tested) in pairs if own.window is not tested.window)
        window = other.fit.tests[places[0]].window or Window(WindowKind.NONE)
        return WindowAlternative(places, window, other.x - self.x, counts)

    @property
    def is_of_channels(self) -> bool:
        """Whether any gain or delay of a channel is significant."""
        nuisances: tuple[Delay | Gain, ...] = (*self.fit.delays, *self.fit.gains)
        return any(nuisance.is_significant for nuisance in nuisances)

    @property
    def criterion(self) -> float:
        """Half of Schwarz's criterion (BIC): the cost with a penalty for each nuisance parameter."""
        more = len(self.all) - self.misfit.unknowns
        return self.cost + 0.5 * more * math.log(max(len(self.fit.residuals), 1))

    def with_wide_intervals(self) -> Fit:
        """Return the fit with standard deviations widened to distant values that explain the tests as well.

        A mode beyond the band, or one that hardly shows, may sit where it explains some noise: how sharp that minimum
        is says nothing of other values. They are tried with all other unknowns as they are, which can only cost more.
        """
        misfit, fit, x = self.misfit, self.fit, self.all
        p = misfit.unknowns
        std, wide = fit.std, np.ones(p)
        c = misfit.scale(fit.residuals)
        least = misfit.cost(fit.residuals, x, c)
        for k, along in enumerate(np.eye(len(x))[:p] / np.sqrt(misfit.prior)[:, None][:p]):
            for share in TRIED:
                d = share * along[k]
                if d <= SIGNIFICANT * std[k]:
                    continue
                most = least + min(VERY_STRONG, (d / std[k]) ** 2 / 8)
                if min(misfit.cost_at(x + way * share * along, c) for way in (1, -1)) > most:
                    break
                wide[k] = d / std[k]
        return replace(fit, covariance=fit.covariance * np.outer(wide, wide))


class Estimator:
    """Estimator of the unknowns from responses and modes: residuals at any values, and minima of the misfit."""

    def __init__(
        self, predictions: Predictions, lines: Sequence[Lines], robust: bool = True, evidence: Evidence | None = None
    ) -> None:
        self.predictions, self.lines = predictions, tuple(lines)
        far = usual_chi2([test.averages for test in predictions.tests if test.averages])
        self.alone = Misfit(predictions, self.lines, far, robust, evidence=evidence)
        self._kernels: dict[tuple[float, bytes], Array] = {}
        self.start, self.prior = predictions.sought.start, predictions.sought.prior

    def of(self, predictions: Predictions) -> Estimator:
        """Return the estimator of other predictions, whose tests have the same responses or modified ones."""
        tests, lines = predictions.tests, []
        for line in self.lines:
            response = tests[line.test].responses[line.place]
            sd = line.sd if response.H is line.measured.H else deviations(response, tests[line.test].averages)
            lines.append(replace(line, measured=response, sd=sd if len(sd) == len(line.sd) else sd[line.counted]))
        same_unknowns = predictions.sought.labels == self.predictions.sought.labels  # not if other motors are held
        estimator = Estimator(predictions, lines, self.alone.robust, self.alone.evidence if same_unknowns else None)
        estimator._kernels = self._kernels
        return estimator

    def near(self, x: Array) -> Minimum:
        """Return the minimum near x without nuisances; unknown changes of windows and zeros start at 0."""
        return self._near(self.alone, np.concatenate([x, np.zeros(len(self.predictions.windowed))]))

    def fit(self, check: Callable[[Fit, Sequence[Predicted]], None] = lambda *_: None) -> Fit:
        """Return the first minimum that explains the tests within noise, or else the best one without nuisances.

        Before others than that near the start are sought, `check` is called with it and its predictions: it may refuse
        the tests. Of lists of modes alone the best minimum is returned, and nothing is checked.
        """
        if not self.lines:
            return self._of_modes()
        near = self._near(self.alone, self.start)
        check(near.fit, self.predictions.at(near.x, slopes=False))
        best, chosen = self._best_minima(near)
        has_modes = any(test.modes for test in self.predictions.tests)
        widens = not (has_modes or (chosen.is_far and chosen.fit.largest_term))
        chosen, alternatives = self._with_possible_windows(self._with_small_channel_terms(chosen))
        fit = replace(chosen.with_wide_intervals() if widens else chosen.fit, alternatives=alternatives)
        for doubt in alternatives:
            if doubt.counts:
                fit = replace(fit, covariance=fit.covariance + np.outer(doubt.shift, doubt.shift))
        return fit if chosen is best else replace(fit, chi2_alone=best.fit.chi2)

    def _best_minima(self, near: Minimum) -> tuple[Minimum, Minimum]:
        """Return the best minimum without nuisances, and the one that explains the tests, with nuisances if needed."""
        if not near.is_far:
            return near, near
        extended = self._with_nuisances(near)
        if explaining := [minimum for minimum in extended if not minimum.is_far]:
            return near, min(explaining, key=attrgetter("criterion"))
        best = near
        for x in self._nearest(partial(self.smoothed_cost, width=WIDE)):
            other = self._near(self.alone, x)
            if not other.is_far:
                return other, other
            best = min(best, other, key=attrgetter("cost"))
        if best is not near:
            extended += self._with_terms(best)
        size, least = attrgetter("fit.chi2"), EXPLAINED
        if not math.isfinite(best.fit.chi2):
            size, least = attrgetter("fit.logarithm"), EXPLAINED_UNKNOWN
        chosen = min(extended, key=size, default=best)
        return best, chosen if size(chosen) < least * size(best) else best

    def _with_nuisances(self, near: Minimum) -> list[Minimum]:
        """Return minima with windows, channel terms and out-of-band terms, until one explains all but noise."""
        extended: list[Minimum] = []
        windows = (replace(self.alone, predictions=predictions) for predictions in self._other_windows())
        under_others = (self._near(misfit, misfit.predictions.start) for misfit in windows)
        for minima in (under_others, self._with_channel_nuisances(near), self._with_terms(near)):
            extended += minima
            if any(minimum.is_clear for minimum in extended):
                break
        return extended

    def _nearest(self, cost: Callable[[Array], float]) -> Array:
        """Return those random points (few, p) within the prior that have the least cost."""
        rng, costs = np.random.default_rng(0), np.full(POINTS, math.inf)
        points: Array = self.start + rng.uniform(-1, 1, (POINTS, len(self.start))) / np.sqrt(self.prior)
        for k, x in enumerate(points):
            with contextlib.suppress(InputError, np.linalg.LinAlgError):
                costs[k] = cost(x)
        return points[np.argsort(costs)[:MOST_REFITTED]]

    def _of_modes(self) -> Fit:
        """Return the best fit to lists of modes alone, from the start and from random points within the prior.

        Frequencies often have several: intervals hold those that explain the modes as well.
        """
        rough = replace(self.alone, predictions=self.predictions.of([roughly(test) for test in self.predictions.tests]))
        minima = [self._near(self.alone, x) for x in (self.start, *self._nearest(rough.modal_cost))]
        costs = [self.alone.modal_cost(minimum.x) for minimum in minima]
        fit = minima[int(np.argmin(costs))].fit
        std, seen = fit.std, [fit.x]
        covariance = fit.covariance
        for cost, minimum in zip(costs, minima, strict=True):
            apart = min(float((np.abs(minimum.x - x) / std).max()) for x in seen)
            if cost < min(costs) + VERY_STRONG and apart > SIGNIFICANT:
                seen.append(minimum.x)
                covariance = covariance + np.outer(minimum.x - fit.x, minimum.x - fit.x)
        return replace(fit, covariance=covariance)

    def _with_small_channel_terms(self, minimum: Minimum) -> Minimum:
        """Return the minimum, refitted with gains and delays of channels if these are very strongly indicated."""
        if minimum.is_far or minimum.misfit.nuisances.parts:
            return minimum
        minima = [minimum]
        for nuisances in self._channel_nuisances:
            misfit = replace(minimum.misfit, nuisances=nuisances)
            x = np.concatenate([minimum.all, np.zeros(len(nuisances.prior))])
            penalty = 0.5 * len(nuisances.prior) * math.log(sum(2 * len(line.f) for line in self.lines))
            if misfit.expected_fall(x) > VERY_STRONG + penalty:
                minima.append(Minimum(misfit, misfit.minimum(x, differences)))
        return min((other for other in minima if other is minimum or other.is_of_channels), key=attrgetter("criterion"))

    @cached_property
    def _orders(self) -> list[int]:
        """Order of the time derivative that the output of each response measures."""
        machine = self.predictions.motion.given
        return [outputs(machine, [line.measured.output])[0].order for line in self.lines]

    @cached_property
    def _channel_nuisances(self) -> tuple[Nuisances, ...]:
        """Kinds of channel errors: gains; delays, with an undelayed term in accelerations; gains and delays."""
        gains = channel_gains(self.lines)
        accelerations = [k for k, order in enumerate(self._orders) if order == ACCELERATION]
        both = Nuisances((*gains.parts, *channel_delays(self.lines).parts))
        return gains, channel_delays(self.lines, accelerations), both

    def _other_windows(self) -> Iterator[Predictions]:
        """Yield predictions of the tests under the other windows that they may have.

        Of Hann's window that is named the length is unknown, of exponential ones the rate, which is zero without any.
        """
        tests = self.predictions.tests
        for named in dict.fromkeys(test.window for test in tests if test.responses):
            own = None if named is None else named.kind
            for kind in (WindowKind.HANN, WindowKind.EXPONENTIAL, WindowKind.NONE):
                if kind is WindowKind.NONE and own in (None, kind):
                    continue
                places = [k for k, test in enumerate(tests) if test.responses and test.window == named]
                if kind is own:
                    yield self.predictions.of(tests, places)
                usual = with_windows(tests, kind, named) if (kind, own) != (WindowKind.EXPONENTIAL,) * 2 else None
                if usual is not None:
                    yield self.predictions.of(usual, places if kind is WindowKind.EXPONENTIAL else ())

    def _with_possible_windows(self, minimum: Minimum) -> tuple[Minimum, tuple[WindowAlternative, ...]]:
        """Return a minimum, or that under another window if residuals determine it; other possible windows.

        Possible are windows where none is named, or other windows, that residuals do not exclude.
        """
        predictions_of_others = list(self._other_windows())
        if not predictions_of_others:
            return minimum, ()
        named = minimum if minimum.misfit.predictions is self.predictions else self._refit(minimum, self.predictions)
        minima = [self._refit(minimum, predictions) for predictions in predictions_of_others]
        best = min((other for other in minima if self._explains(other, named)), key=attrgetter("cost"), default=named)
        chosen = best if best.cost < named.cost - VERY_STRONG else named
        tests = self.predictions.tests
        near = [other for other in (named, *minima) if other is not chosen and other.cost < chosen.cost + VERY_STRONG]
        doubted = [(other, True) for other in near]
        if chosen is named:
            doubted = [self._possible_window(other) for other in near if None in other.changed_windows(tests)]
        return chosen, tuple(chosen.doubt(other, counts) for other, counts in doubted)

    def _explains(self, other: Minimum, named: Minimum) -> bool:
        """Whether other windows, all decaying, explain the tests, or most of the misfit under the named windows."""
        falls = all(window.decay > 0 for window in other.changed_windows(self.predictions.tests).values())
        remaining = (other.fit.chi2 - 1) / max(named.fit.chi2 - 1, 1e-9)
        return falls and (not other.is_far or remaining < EXPLAINED_BY_WINDOW)

    def _possible_window(self, other: Minimum) -> tuple[Minimum, bool]:
        """Return the minimum under a window that residuals do not exclude, and whether deviations include it.

        Of exponential windows, the one that falls as fast as tests allow, at most to 1 %.
        """
        c = other.all[len(other.x) : other.misfit.first]
        if not len(c):
            return other, True
        c = np.clip(c + SIGNIFICANT * np.array([*other.fit.windows.values()]), 0.0, 1.0)
        tests = other.misfit.predictions.tests_at(np.concatenate([other.x, c]))
        return self._refit(other, self.predictions.of(tests)), False

    def _refit(self, minimum: Minimum, predictions: Predictions) -> Minimum:
        """Return the minimum with other predictions, from the values of this minimum."""
        misfit = replace(minimum.misfit, predictions=predictions)
        x = np.concatenate([minimum.x, np.zeros(len(predictions.windowed)), minimum.all[minimum.misfit.first :]])
        return Minimum(misfit, misfit.minimum(x, differences))

    def _with_channel_nuisances(self, minimum: Minimum) -> Iterator[Minimum]:
        """Yield minima with factors, delays, or both of channels, near the best one so far and near the start.

        Factors or delays that are right leave no more than noise; then no more is sought.
        """
        best = minimum
        for nuisances in self._channel_nuisances:
            for x in (self.start,) if best is minimum and not nuisances.has_delays else (best.x, self.start):
                predicted = self.predictions.at(x, slopes=False)
                logarithms = [np.log(line.predicted_by(predicted) / line.H) for line in self.lines]
                c = nuisances.start(logarithms)
                candidate = self._near(replace(self.alone, nuisances=nuisances), np.concatenate([x, c]))
                best = min(best, candidate, key=attrgetter("cost"))
                if candidate.is_of_channels:
                    yield candidate
                    if candidate.is_clear:
                        return

    def _with_terms(self, minimum: Minimum) -> Iterator[Minimum]:
        """Yield minima with terms of out-of-band modes, then with delays as well, from a minimum without nuisances."""
        if not math.isfinite(minimum.fit.chi2):
            return
        terms = out_of_band_modes(self.lines, self._orders).parts
        for delays in ((), self._channel_nuisances[1].parts):
            misfit = replace(minimum.misfit, nuisances=Nuisances((*delays, *terms)))
            x = np.concatenate([minimum.x, np.zeros(len(misfit.nuisances.prior))])
            yield Minimum(misfit, misfit.minimum(x, differences))

    def _near(self, misfit: Misfit, x: Array) -> Minimum:
        """Return the minimum near x: by stage 1, then stage 2 with the noise of the residuals if it is unknown.

        Uncertain pairs of modes count in stage 1, far from the end. Evidence has outliers only if data contradict it.
        """
        x = misfit.with_all_pairs.with_wider_evidence(WIDER_EVIDENCE[0]).minimum(x, _logarithms)
        for factor in WIDER_EVIDENCE if misfit.evidence else ():
            x = misfit.with_wider_evidence(factor).minimum(x, differences)
        for _ in range(1 if all(line.sd_is_known for line in misfit.lines) else 2):
            misfit = misfit.with_noise(x)
            x = misfit.minimum(x, differences)
        return Minimum(misfit, x)

    def smoothed_cost(self, x: Array, width: float) -> float:
        """Return the mean |ln(G/H)|^2 of smoothed responses; raises `InputError` without equilibrium."""
        return self.smoothed_distance(self.predictions.at(x, slopes=False), width)

    def smoothed_distance(self, predicted: Sequence[Predicted], width: float = WIDE) -> float:
        """Return the mean |ln(G/H)|^2 of smoothed responses from what is predicted, infinite where G is zero."""
        total = 0.0
        for line in self.lines:
            kernel = self._kernel(width, line)
            ratio = (kernel @ line.predicted_by(predicted)) / (kernel @ line.H)
            if not ratio.all():
                return math.inf
            total += float(np.mean(np.abs(np.log(ratio)) ** 2))
        return total if math.isfinite(total) else math.inf

    def _kernel(self, width: float, line: Lines) -> Array:
        """Return weights (N, N) of lines, rows of sum 1; a line represents the band that is nearest to it."""
        key = (width, line.f.tobytes())
        if key not in self._kernels:
            f = line.f
            share = np.gradient(f) if len(f) > 1 else np.ones(1)
            kernel = share * width * f[:, None] / ((width * f[:, None]) ** 2 + (f[:, None] - f) ** 2)
            self._kernels[key] = kernel / kernel.sum(axis=1, keepdims=True)
        return self._kernels[key]


def _logarithms(line: Lines, G: ComplexArray, dG: ComplexArray) -> Residuals:
    """Return ln(G/H), its phase wrapped; weights are bounded where lines are exact."""
    sd = line.sd / np.abs(line.H)
    weight = 1 / np.maximum(sd, LEAST_SHARE * np.median(sd))
    return in_parts(np.asarray(np.log(G / line.H) * weight, dtype=complex), dG / G * weight)
