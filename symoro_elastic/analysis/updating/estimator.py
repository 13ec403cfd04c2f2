"""The estimator: parameters that vibration tests tell, in two stages, robust against lines that are wrong.

    1. find:    r = ln(G/H), weights 1/max(sd, 0.3 noise)       (insensitive to the height of peaks: a wide basin)
    2. finish:  r = (G - H)/sd, real and imaginary parts        (maximum likelihood)

If residuals stay large, again from the best points on lines along each unknown. Then from the start, with responses
smoothed over frequency at first, less and less: by Poisson's kernel a w/((a w)^2 + (w - v)^2), which is what more
damping does to a response. G and H are smoothed alike, over the lines there are, so that nothing outside the band is
missing. Then from where two springs have exchanged their values, and from a scan within the prior. Before all that,
factors and delays of channels are fitted beside the model, and between, terms of modes outside the band. The first
minimum that leaves no more than noise is taken, else the best one of the model alone, or of the model with factors or
delays if these explain most of the rest.

Balmes 1993 and Lin and Ewins 1994 for residuals of logarithms.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from symoro_elastic.analysis.updating.beside import Beside, Seen, beside_of, gains_of
from symoro_elastic.analysis.updating.measured import MeasuredResponse, VibrationTest, roughly, with_windows
from symoro_elastic.analysis.updating.misfit import CAUCHY, Doubt, Fit, Lines, Misfit, Residuals, differences, in_parts
from symoro_elastic.analysis.updating.noise import deviations, is_known, usual_chi2
from symoro_elastic.analysis.updating.predictions import Predicted, Predictions
from symoro_elastic.analysis.updating.windows import Window, WindowKind
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import outputs

WIDTHS = (0.3, 0.1, 0.03)
"""Of the kernel that smooths responses, over the frequency."""
SCANNED, MOST_SCANNED, MODAL_SCANNED, MOST_MODAL = 100, 3, 60, 8
"""Points within the prior, and of them those that fits begin at; the same for lists of modes."""
LEAST_SPREAD = 0.01
ALONG, APART, MOST_ALONG = np.linspace(-1.5, 1.5, 13), 0.4, 4
"""Points on a line along an unknown, how far apart starts on it are, over its prior, and how many are taken."""
TRIED, CLEAR, SAME = (0.25, 0.5, 1.0), 3.0, 6.0
"""Distances of other values over the prior; deviations at which they should differ; costs that do not."""
EXCHANGES, LEAST_CORRELATED = 3, 0.5
"""Pairs of parameters that are exchanged, and the correlation of their errors."""
FAR_LOGARITHM = 0.05
"""Median |ln(G/H)| above which another minimum is sought where the noise is unknown."""
LEAST_SHARE = 0.3
"""Of a pair's noise, below which a line of stage 1 gets no more weight."""
EXPLAINED, EXPLAINED_UNKNOWN = 0.1, 0.9
"""Of chi2, or of the distance where the noise is unknown, what delays leave at most where they are taken."""
CLEARLY_NOISE = 1.08
"""chi2 below which nothing is left to explain."""
TOLD, SURE, DOUBTED, LEFT_BY_WINDOW = 10.0, 4.5, 1.0, 0.3
"""Fall of the cost that tells a window, another length of that which is named, that leaves this in doubt; the share of
chi2 - 1 that a window leaves at most where the model lacks something, too."""
LONGER = 1.1
"""Times an exponential window, by which it may be named wrongly."""
ZERO = 1e-6
"""Of the largest output of an input: a model response below it is zero."""


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
                raise InputError(test.name, response.pair, what)
            for low, high in without:
                counted &= (response.f < low) | (response.f > high)
            if not counted.any():
                what = f"{response.pair} has no line left: give other windows, or leave the pair out"
                raise InputError(test.name, "--without", what)
            sd = deviations(response, test.averages)[counted]
            found.append(Lines(response, counted, sd, is_known(response, test.averages), t, k))
    return found, zero


@dataclass(frozen=True)
class Minimum:
    """A minimum of a misfit, with all its unknowns."""

    misfit: Misfit
    all: Array

    @cached_property
    def fit(self) -> Fit:
        """What is known there."""
        return self.misfit.at_minimum(self.all)

    @property
    def x(self) -> Array:
        """Logarithms of the unknowns."""
        return self.fit.x

    @property
    def is_far(self) -> bool:
        """Whether residuals are larger than noise explains, so that another minimum may be better."""
        return is_far(self.fit)

    @cached_property
    def cost(self) -> float:
        """Of differences, with the prior."""
        return self.misfit.cost(self.fit.residuals, self.all, CAUCHY)

    def changed(self, tests: Sequence[VibrationTest]) -> dict[Window | None, Window]:
        """Return the windows that tests name, and those that they are seen through here, where these are others."""
        pairs = ((a.window, b.window) for a, b in zip(tests, self.fit.tests, strict=True))
        return {named: seen for named, seen in pairs if seen is not None and seen is not named}

    def doubt(self, other: Minimum, counts: bool) -> Doubt:
        """Return the doubt that another minimum is, under another window."""
        pairs = enumerate(zip(self.fit.tests, other.fit.tests, strict=True))
        places = tuple(k for k, (own, seen) in pairs if own.window is not seen.window)
        window = other.fit.tests[places[0]].window or Window(WindowKind.NONE)
        return Doubt(places, window, other.x - self.x, counts)

    @property
    def is_of_channels(self) -> bool:
        """Whether factors or delays of channels show."""
        return any(one.shows for one in self.fit.delays) or any(one.shows for one in self.fit.gains)

    @property
    def criterion(self) -> float:
        """Schwarz's criterion, over two: the cost, and what each unknown beside the model would explain of noise."""
        if not math.isfinite(self.fit.chi2):
            return self.fit.distance
        more = len(self.all) - self.misfit.unknowns
        return self.fit.distance + 0.5 * more * math.log(max(len(self.fit.residuals), 1))

    def widened(self) -> Fit:
        """Return the fit with intervals that hold values far off, where these explain the tests as well.

        A mode beyond the band, or one that hardly shows, may sit where it explains some noise: how sharp that minimum
        is says nothing of other values. They are tried with all other unknowns as they are, which can only cost more.
        """
        misfit, fit, x = self.misfit, self.fit, self.all
        p = misfit.unknowns
        std, wide = np.sqrt(np.diag(fit.covariance)), np.ones(p)
        c = misfit.scale(fit.residuals)
        least = misfit.cost(fit.residuals, x, c)
        for k, along in enumerate(np.eye(len(x))[:p] / np.sqrt(misfit.prior)[:, None][:p]):
            for share in TRIED:
                d = share * along[k]
                if d <= CLEAR * std[k]:
                    continue
                most = least + min(SAME, (d / std[k]) ** 2 / 8)
                if min(misfit.cost_at(x + way * share * along, c, most) for way in (1, -1)) > most:
                    break
                wide[k] = d / std[k]
        return replace(fit, covariance=fit.covariance * np.outer(wide, wide))


def is_far(fit: Fit) -> bool:
    """Whether residuals are larger than noise explains."""
    if not fit.lines:
        return False
    return fit.chi2 > fit.far if math.isfinite(fit.chi2) else fit.distance > FAR_LOGARITHM


def _distance(one: Minimum) -> float:
    return one.fit.distance


def _cost(one: Minimum) -> float:
    return one.cost


def _of(tests: Sequence[VibrationTest], line: Lines) -> MeasuredResponse:
    return tests[line.test].responses[line.place]


def _modal_cost(misfit: Misfit, x: Array) -> float:
    """Return the cost of modes at x, infinite without equilibrium."""
    try:
        return misfit.modal_cost(x)
    except (InputError, np.linalg.LinAlgError):
        return math.inf


def _longer(tests: Sequence[VibrationTest]) -> list[VibrationTest]:
    """Return tests with exponential windows that are a little longer than they are named."""
    found = []
    for test in tests:
        if (window := test.window) is not None and window.kind is WindowKind.EXPONENTIAL:
            found.append(replace(test, window=replace(window, decay=LONGER * window.decay)))
        else:
            found.append(test)
    return found


class Estimator:
    """Residuals of lines and modes at any values of the unknowns, and their minima."""

    def __init__(self, predictions: Predictions, lines: Sequence[Lines], robust: bool = True) -> None:
        self.predictions, self.lines = predictions, tuple(lines)
        far = usual_chi2([test.averages for test in predictions.tests if test.averages])
        self.alone = Misfit(predictions, self.lines, far, robust)
        self._kernels: dict[tuple[float, bytes], Array] = {}
        self._at_start: dict[bytes, list[Predicted]] = {}
        self.start, self.prior = predictions.sought.start, predictions.sought.prior

    def of(self, predictions: Predictions) -> Estimator:
        """Return the estimator of the same numbers by other predictions."""
        tests = predictions.tests
        lines = [replace(line, measured=_of(tests, line)) for line in self.lines]
        found = Estimator(predictions, lines, self.alone.robust)
        found._kernels = self._kernels
        return found

    def near(self, x: Array) -> Minimum:
        """Return the minimum of the model alone near x; what is unknown of windows and zeros starts at none."""
        return self._near(self.alone, np.concatenate([x, np.zeros(len(self.predictions.windowed))]))

    def fit(self, check: Callable[[Fit, Sequence[Predicted]], None] = lambda *_: None) -> Fit:
        """Return the first minimum that leaves no more than noise, or the best one of the model alone.

        Before others than that near the start are sought, `check` is called with it and its predictions: it may refuse
        the tests. Of lists of modes alone the best minimum is returned, and nothing is checked.
        """
        if not self.lines:
            return self._of_modes()
        alone: list[Minimum] = []
        beside: list[Minimum] = []
        for one in self._minima(check, alone, beside):
            if not one.is_far:
                break
        else:
            one = min(alone, key=_distance)
        best = min(alone, key=_distance)
        if one is best:
            one = self._explained(best, beside)
        has_modes = any(test.modes for test in self.predictions.tests)
        widens = not (has_modes or (one.is_far and one.fit.beside))
        one, under = self._behind_windows(self._told(one))
        found = replace(one.widened() if widens else one.fit, under=under)
        for doubt in under:
            if doubt.counts:
                found = replace(found, covariance=found.covariance + np.outer(doubt.shift, doubt.shift))
        return found if one is best else replace(found, chi2_alone=best.fit.chi2)

    def _of_modes(self) -> Fit:
        """Return the best minimum of lists of modes alone: of those near the start and near some points of the prior.

        Frequencies often have several: intervals hold those that explain the modes as well.
        """
        points = self._within_prior()[:MODAL_SCANNED]
        rough = replace(self.alone, predictions=self.predictions.of([roughly(test) for test in self.predictions.tests]))
        order = np.argsort([_modal_cost(rough, x) for x in points])
        found = [self._near(self.alone, x) for x in (self.start, *points[order[:MOST_MODAL]])]
        costs = [_modal_cost(self.alone, one.x) for one in found]
        fit = found[int(np.argmin(costs))].fit
        std, seen = np.sqrt(np.diag(fit.covariance)), [fit.x]
        covariance = fit.covariance
        for cost, one in zip(costs, found, strict=True):
            apart = min(float((np.abs(one.x - x) / std).max()) for x in seen)
            if cost < min(costs) + SAME and apart > CLEAR:
                seen.append(one.x)
                covariance = covariance + np.outer(one.x - fit.x, one.x - fit.x)
        return replace(fit, covariance=covariance)

    def _within_prior(self) -> Array:
        """Return points (SCANNED, p) within the prior."""
        rng = np.random.default_rng(0)
        points: Array = self.start + rng.uniform(-1, 1, (SCANNED, len(self.start))) / np.sqrt(self.prior)
        return points

    def _told(self, one: Minimum) -> Minimum:
        """Return a minimum, or that with factors and delays of channels that residuals tell though they are small."""
        if one.is_far or one.misfit.beside.count:
            return one
        found = [one]
        for beside in self._of_usual_channels:
            misfit = replace(one.misfit, beside=beside)
            x = np.concatenate([one.all, np.zeros(beside.count)])
            if misfit.expected_fall(x) > TOLD + beside.count:
                found.append(Minimum(misfit, misfit.minimum(x, differences)))
        return min((other for other in found if other is one or other.is_of_channels), key=_criterion)

    @cached_property
    def _of_usual_channels(self) -> tuple[Beside, ...]:
        """Factors of channels, delays, both."""
        delays, both = (beside_of(self._seen, channels=True, terms=False, gains=gains) for gains in (False, True))
        return gains_of(self._seen), delays, both

    def _others(self) -> Iterator[Predictions]:
        """Yield predictions of the tests under each window that may be in place of one that is named, or of none.

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

    def _behind_windows(self, one: Minimum) -> tuple[Minimum, tuple[Doubt, ...]]:
        """Return a minimum, or that under another window if residuals tell it; windows that are in doubt.

        In doubt are windows where none is named, or another than the one that is found, and residuals do not tell.
        """
        others = list(self._others())
        if not others:
            return one, ()
        tests = self.predictions.tests
        named = one if one.misfit.predictions is self.predictions else self._under(one, self.predictions)
        rest = [self._under(one, predictions) for predictions in others]
        best = min((other for other in rest if self._may_be(other, named)), key=_cost, default=named)
        is_own = best.misfit.predictions.tests is tests
        chosen = best if best.cost < named.cost - (SURE if is_own else TOLD) else named
        near = [other for other in (named, *rest) if other is not chosen and other.cost < chosen.cost + TOLD]
        doubted = [(other, True) for other in near]
        if chosen is named:
            doubted = [doubt for other in near for doubt in self._doubted(other, named)]
        return chosen, tuple(chosen.doubt(other, counts) for other, counts in doubted)

    def _may_be(self, other: Minimum, named: Minimum) -> bool:
        """Whether windows fall, and explain the tests, or most of what those that are named leave."""
        falls = all(window.decay > 0 for window in other.changed(self.predictions.tests).values())
        left = (other.fit.chi2 - 1) / max(named.fit.chi2 - 1, 1e-9)
        return falls and (not other.is_far or left < LEFT_BY_WINDOW)

    def _doubted(self, other: Minimum, named: Minimum) -> Iterator[tuple[Minimum, bool]]:
        """Yield minima under windows that may be though residuals do not tell them, and whether deviations are wider.

        Where none is named, of exponential ones that which falls as fast as tests allow, at most to 1 %. Of exponential
        ones that are named the one that residuals prefer, or else one that is a tenth longer.
        """
        predictions, tests = other.misfit.predictions, self.predictions.tests
        c = other.all[len(other.x) : other.misfit.first]
        if None in other.changed(tests):
            if len(c):
                c = np.clip(c + CLEAR * np.array([*other.fit.windows.values()]), 0.0, 1.0)
                other = self._under(other, self.predictions.of(predictions.tests_at(np.concatenate([other.x, c]))))
            yield other, not len(c)
        elif predictions.tests is tests and (longer := self.predictions.of(_longer(tests))).tests != tests:
            if other.cost < named.cost - DOUBTED:
                yield other, True
            elif (least := self._under(named, longer)).cost < named.cost + TOLD:
                yield least, False

    def _under(self, one: Minimum, predictions: Predictions) -> Minimum:
        """Return the minimum with other predictions near one."""
        misfit = replace(one.misfit, predictions=predictions)
        x = np.concatenate([one.x, np.zeros(len(predictions.windowed)), one.all[one.misfit.first :]])
        return Minimum(misfit, misfit.minimum(x, differences))

    def nearer(self, others: Sequence[VibrationTest]) -> float:
        """Return what is left at the start of the median |ln(G/H)| of responses that other numbers change."""
        given = self.predictions.tests
        changed = [one for one in self.lines if _of(others, one) is not _of(given, one)]
        sizes = []
        for tests in (others, given):
            f = b"".join(one.f.tobytes() for test in tests for one in test.responses)
            if f not in self._at_start:
                self._at_start[f] = self.predictions.at(self.start, slopes=False, tests=tests)
            G = [self._at_start[f][one.test].responses[one.place].G for one in changed]
            each = [np.abs(np.log(x / _of(tests, one).H))[one.counted] for x, one in zip(G, changed, strict=True)]
            sizes.append(float(np.nanmedian(np.concatenate(each))) if each else 1.0)
        return sizes[0] / sizes[1]

    def quickly(self, tests: Sequence[VibrationTest]) -> Fit | None:
        """Return the minimum near the start for other numbers of the same responses; None where none is found."""
        lines = []
        for line in self.lines:
            one = _of(tests, line)
            lines.append(replace(line, measured=one, sd=deviations(one, tests[line.test].averages)[line.counted]))
        try:
            misfit = replace(self.alone, predictions=self.predictions.of(tests), lines=tuple(lines))
            return self._near(misfit, self.start).fit
        except (InputError, np.linalg.LinAlgError):
            return None

    def _explained(self, best: Minimum, beside: list[Minimum]) -> Minimum:
        """Return the best minimum with delays of channels, where they explain most of what the model alone leaves."""
        known = math.isfinite(best.fit.chi2)
        if not known and not beside:
            beside = [one for one in self._of_channels(best) if one.is_of_channels]
        size, least = (_chi2, EXPLAINED) if known else (_distance, EXPLAINED_UNKNOWN)
        one = min(beside, key=size, default=best)
        return one if size(one) < least * size(best) else best

    def _minima(
        self, check: Callable[[Fit, Sequence[Predicted]], None], alone: list[Minimum], beside: list[Minimum]
    ) -> Iterator[Minimum]:
        """Yield minima in the order in which they are sought; those of the model `alone` are kept, and `beside` it.

        Beside each stands the one with terms of what is outside the band: in a wrong minimum these explain no more.
        """

        def found(x: Array) -> Minimum:
            alone.append(self._near(self.alone, x))
            return alone[-1]

        yield found(self.start)
        check(alone[0].fit, self.predictions.at(alone[0].x, slopes=False))
        beside += self._under_others()
        if not any(map(_is_clear, beside)):
            beside += [one for one in self._of_channels(alone[0]) if one.is_of_channels]
        terms = [] if any(map(_is_clear, beside)) else self._with_terms(alone[0])
        yield from sorted([*beside, *terms], key=_criterion)
        last = alone[0]
        for starts in (self._along_axes, self._from_smoothed, self._exchanged, self._scanned):
            yield from map(found, starts(min(alone, key=_distance).fit))
            best = min(alone, key=_distance)
            if best is not last:
                yield from self._with_terms(best)
            last = best

    def _under_others(self) -> Iterator[Minimum]:
        """Yield minima near the start under windows that tests do not name."""
        for predictions in self._others():
            yield self._near(replace(self.alone, predictions=predictions), predictions.start)

    @cached_property
    def _seen(self) -> list[Seen]:
        """The lines as what is beside the model sees them."""
        machine = self.predictions.motion.given
        return [
            Seen(
                *(line.test, line.measured.output, line.measured.input, line.f, line.H),
                outputs(machine, [line.measured.output])[0].order,
            )
            for line in self.lines
        ]

    def _of_channels(self, found: Minimum) -> Iterator[Minimum]:
        """Yield minima with factors, delays, or both of channels, near the best one so far and near the start.

        Factors or delays that are right leave no more than noise; then no more is sought.
        """
        best = found
        for beside in self._of_usual_channels:
            misfit = replace(self.alone, beside=beside)
            for x in (self.start,) if best is found and not beside.channels else (best.x, self.start):
                predicted = self.predictions.at(x, slopes=False)
                each = [
                    np.log(predicted[line.test].responses[line.place].G[line.counted] / line.H) for line in self.lines
                ]
                one = self._near(misfit, np.concatenate([x, misfit.beside.begun(each)]))
                best = min(best, one, key=_distance)
                yield one
                if one.is_of_channels and _is_clear(one):
                    return

    def _with_terms(self, found: Minimum) -> Iterator[Minimum]:
        """Yield the minima near one of the model alone with terms of what is outside the band, and delays as well."""
        if not math.isfinite(found.fit.chi2):
            return
        for channels in (False, True):
            misfit = replace(found.misfit, beside=beside_of(self._seen, channels, terms=True))
            x = np.concatenate([found.x, np.zeros(misfit.beside.count)])
            yield Minimum(misfit, misfit.minimum(x, differences))

    def _near(self, misfit: Misfit, x: Array) -> Minimum:
        """Return the minimum near x: stage 1, then stage 2, whose noise is that of the residuals if unknown.

        Pairs of modes that are in doubt count in stage 1: far from the end none is sure.
        """
        x = misfit.with_all_pairs.minimum(x, _logarithms)
        for _ in range(1 if all(line.sd_is_known for line in misfit.lines) else 2):
            misfit = misfit.with_noise(x)
            x = misfit.minimum(x, differences)
        return Minimum(misfit, x)

    def _from_smoothed(self, _: Fit) -> Iterator[Array]:
        """Yield the minimum of responses that are smoothed less and less, from the start on."""
        yield self._of_smoothed(self.start)

    def _of_smoothed(self, x: Array) -> Array:
        """Return the minimum of responses that are smoothed less and less."""
        for width in WIDTHS:
            x = self.alone.minimum(x, partial(self._smoothed, width))
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
        for k in np.argsort([self.smoothed_cost(x, WIDTHS[0]) for x in points]).tolist():
            if all(np.abs((points[k] - points[one]) / std).max() > APART for one in taken):
                taken.append(k)
            if len(taken) == MOST_ALONG:
                break
        yield from points[taken]

    def _scanned(self, _: Fit) -> Iterator[Array]:
        """Yield minima of smoothed responses near the best of many points within the prior."""
        points = self._within_prior()
        order = np.argsort([self.smoothed_cost(x, WIDTHS[1]) for x in points])
        for k in order[:MOST_SCANNED]:
            yield self._of_smoothed(points[k])

    def smoothed_cost(self, x: Array, width: float) -> float:
        """Return the mean |ln(G/H)|^2 of smoothed responses, infinite without equilibrium."""
        try:
            return self.smoothed_distance(self.predictions.at(x, slopes=False), width)
        except (InputError, np.linalg.LinAlgError):
            return math.inf

    def smoothed_distance(self, predicted: Sequence[Predicted], width: float = WIDTHS[0]) -> float:
        """Return the mean |ln(G/H)|^2 of smoothed responses from what is predicted, infinite where G is zero."""
        total = 0.0
        for line in self.lines:
            kernel = self._kernel(width, line)
            ratio = (kernel @ predicted[line.test].responses[line.place].G[line.counted]) / (kernel @ line.H)
            if not ratio.all():
                return math.inf
            total += float(np.mean(np.abs(np.log(ratio)) ** 2))
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

    def _smoothed(self, width: float, line: Lines, G: ComplexArray, dG: ComplexArray) -> Residuals:
        """Return ln(G/H) of smoothed responses, in units of the noise of lines."""
        kernel = self._kernel(width, line)
        G, dG = kernel @ G, dG @ kernel.T
        weight = 1 / max(float(np.median(line.sd / np.abs(line.H))), LEAST_SPREAD)
        return in_parts(_log(G / (kernel @ line.H)) * weight, dG / G * weight)

    def _kernel(self, width: float, line: Lines) -> Array:
        """Return weights (N, N) of lines, rows that sum to 1; each line stands for the band that is nearest to it."""
        key = (width, line.f.tobytes())
        if key not in self._kernels:
            f = line.f
            share = np.gradient(f) if len(f) > 1 else np.ones(1)
            kernel = share * width * f[:, None] / ((width * f[:, None]) ** 2 + (f[:, None] - f) ** 2)
            self._kernels[key] = kernel / kernel.sum(axis=1, keepdims=True)
        return self._kernels[key]


def _criterion(one: Minimum) -> float:
    return one.criterion


def _chi2(one: Minimum) -> float:
    return one.fit.chi2


def _is_clear(one: Minimum) -> bool:
    return one.fit.chi2 < CLEARLY_NOISE


def _logarithms(line: Lines, G: ComplexArray, dG: ComplexArray) -> Residuals:
    """Return ln(G/H), its phase wrapped; weights are bounded where lines are exact."""
    sd = line.sd / np.abs(line.H)
    weight = 1 / np.maximum(sd, LEAST_SHARE * np.median(sd))
    return in_parts(_log(G / line.H) * weight, dG / G * weight)


def _log(x: ComplexArray) -> ComplexArray:
    return np.asarray(np.log(x), dtype=complex)
