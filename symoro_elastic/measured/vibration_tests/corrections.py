"""Which correction of vibration tests explains what the model does not: rows of `listed_tests`, refitted.

Tests with responses are screened by their smoothed responses, lists of modes by the cost of modes that are known
roughly. A row explains the tests if no more than noise is left with it, and more without it, near its values, too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache, cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.corrections import MOST_REFITTED, Refit, explanations, names_of
from symoro_elastic.measured.vibration_tests.diagnostics import is_cross_talk
from symoro_elastic.measured.vibration_tests.estimator import WIDE, Estimator, lines_of
from symoro_elastic.measured.vibration_tests.listed_tests import Kind, ListedTests, Row, files
from symoro_elastic.measured.vibration_tests.measured import VibrationTest, roughly
from symoro_elastic.measured.vibration_tests.misfit import Fit, Misfit, differences
from symoro_elastic.measured.vibration_tests.predictions import Predicted, Predictions
from symoro_elastic.measured.vibration_tests.unknowns import Sought

NEARER = 0.9
"""Of the distance of smoothed responses without a correction, the most that is left with one that is refitted."""
MUCH_NEARER = 0.7  # the same, before other starts of the fit are tried
ANOTHER_SIGNAL = 0.1  # median |ln(G/H)| below which a response is that of another signal, at a fit of the others: 10 %
SoughtOf = Callable[[Sequence[VibrationTest]], Sought]
"""The unknowns of tests, which motors that are free or under unknown gains change."""


def refuse_mistakes(
    estimator: Estimator, machine: Machine, sought_of: SoughtOf, fit: Fit, bound: float = NEARER
) -> None:
    """Raise `InputError` for a mistake in responses or their list that explains why the model does not fit.

    `bound` is the largest fraction of the distance that is refitted. Where the noise is unknown, responses alone are
    examined in a fit that looks right.
    """
    if not estimator.lines or (math.isfinite(fit.chi2) and not fit.is_far):
        return
    search = _Search(estimator, machine, sought_of, fit)
    listed = search.listed
    groups: list[Iterable[Row]] = [listed.responses()]
    if fit.is_far:
        groups += [(*listed.positions(), *listed.motors_held(), *listed.signals()), listed.zeros()]
    for rows in groups:
        corrections = explanations(rows, search.distance, search.refit, bound)
        same = [row for row in corrections if row.changed == corrections[0].changed]
        if not any(row.kind is Kind.SIGN for row in same):  # which lines on signs name
            _refuse(same)


def _refuse(rows: Sequence[Row], explained: str = "the tests", place: str = "") -> None:
    """Raise `InputError` for the best of some corrections, naming equally good ones; none without corrections."""
    if rows:
        part = "responses" if rows[0].kind is Kind.RESPONSES else "list"
        what = f"{names_of(rows)}: the model explains {explained} only with this corrected; correct the {part}"
        raise InputError(", ".join(dict.fromkeys(map(files, rows))), place or part, what)


class _Search:
    """Search for corrections of tests with responses, compared with the fit of the uncorrected tests."""

    def __init__(self, estimator: Estimator, machine: Machine, sought_of: SoughtOf, fit: Fit) -> None:
        self.estimator, self.fit, self.sought_of = estimator, fit, sought_of
        self.listed = ListedTests(machine, estimator.predictions.tests)
        self.starts = [estimator.start, fit.x]
        self._of = cache(self._corrected)
        self._at_starts = [estimator.predictions.at(x, slopes=False) for x in self.starts]
        self._uncorrected_distances = [estimator.smoothed_distance(predicted) for predicted in self._at_starts]

    @cached_property
    def _all_signals(self) -> tuple[Predictions, list[list[Predicted]]]:
        """Predictions of all signals that tests may have measured, and their values at the starts."""
        wide = every_signal(self.estimator, self.listed)
        return wide, [wide.at(x, slopes=False) for x in self.starts]

    def _corrected(self, row: Row) -> Estimator:
        """Return the estimator of corrected tests."""
        if row.kind is Kind.MOTORS:
            return self.estimator.of(Predictions(self.sought_of(row.data), row.data))
        wide = row.kind in (Kind.SIGN, Kind.SIGNALS)
        return self.estimator.of((self._all_signals[0] if wide else self.estimator.predictions).of(row.data))

    def distance(self, row: Row) -> float:
        """Return the fraction of the smoothed distance that is left with a correction, at the nearer start."""
        try:
            corrected = self._of(row)
            if row.kind in (Kind.SIGN, Kind.SIGNALS):
                wide, predicted = self._all_signals
                costs = [corrected.smoothed_distance(_chosen(wide.tests, at, row.data)) for at in predicted]
            elif row.kind is Kind.RESPONSES and _same_frequencies(row.data, self.listed.tests):
                costs = [corrected.smoothed_distance(at) for at in self._at_starts]
            else:
                values = (_values(corrected, self.estimator, x) for x in self.starts)
                costs = [corrected.smoothed_cost(x, WIDE) for x in values]
        except (InputError, np.linalg.LinAlgError):
            return math.inf
        return min(cost / before for cost, before in zip(costs, self._uncorrected_distances, strict=True))

    def refit(self, row: Row) -> Refit[tuple[VibrationTest, ...]] | None:
        """Return the minimum with a correction, if the tests fit within noise with it and not without it."""
        fit = self.fit
        try:
            row, x = self._with_best_zero(row) if row.vary else (row, self._of(row).start)
            corrected = self._of(row)
            minimum = corrected.near(x)
            if minimum.is_far or minimum.cost >= fit.cost:
                return None
            uncorrected = self.estimator.near(_values(self.estimator, corrected, minimum.x))
        except (InputError, np.linalg.LinAlgError):
            return None
        if math.isfinite(fit.chi2) and not uncorrected.is_far:
            return None
        return Refit(row, minimum.cost, min(fit.cost, uncorrected.cost))

    def _with_best_zero(self, row: Row) -> tuple[Row, Array]:
        """Return the row with the best zero of a joint near that of a row, and the unknowns there."""
        minimum = self.estimator.of(self.estimator.predictions.of(row.data, (row.family,))).near(self.estimator.start)
        zero = row.number + float(minimum.all[len(minimum.x)])
        return row.vary(zero) if row.vary else row, minimum.x


def refuse_zero_signals(estimator: Estimator, machine: Machine, zero: Sequence[tuple[int, int]], fit: Fit) -> None:
    """Raise `InputError` where responses that are zero in the model match another signal, by a fit of the others."""
    listed = ListedTests(machine, estimator.predictions.tests)
    places = [(t, k) for t, k in zero if is_cross_talk(listed.tests[t], k)]
    if not places:
        return
    wide, near = every_signal(estimator, listed), []
    predicted = wide.at(fit.x, slopes=False)
    for row in listed.signals():
        responses = _chosen(wide.tests, predicted, row.data)
        new = [(t, k) for t, k in places if row.data[t].responses[k] is not listed.tests[t].responses[k]]
        logarithms = [_median_logarithm(row.data[t].responses[k].H, responses[t].responses[k].G) for t, k in new]
        if logarithms and max(logarithms) < math.inf:
            near.append((max(logarithms), row))
    near = sorted(near, key=lambda pair: pair[0])[:MOST_REFITTED]
    same = [row for size, row in near if size < ANOTHER_SIGNAL]
    _refuse((same or [row for _, row in near if _is_explained(estimator, wide.of(row.data))])[:1])


def _is_explained(estimator: Estimator, predictions: Predictions) -> bool:
    """Whether a fit to all responses of other tests leaves no more than noise."""
    lines, _ = lines_of(predictions)
    try:
        return not Estimator(predictions, lines, estimator.alone.robust).near(estimator.start).is_far
    except (InputError, np.linalg.LinAlgError):
        return False


def _median_logarithm(H: ComplexArray, G: ComplexArray) -> float:
    return float(np.median(np.abs(np.log(G / H)))) if G.all() and H.all() else math.inf


def _values(to: Estimator | Misfit, of: Estimator | Misfit, x: Array) -> Array:
    """Return start values for a fit: those of another fit at x for common unknowns, else its own start."""
    values = dict(zip(of.predictions.sought.labels, x.tolist(), strict=True))
    labels = to.predictions.sought.labels
    return np.array([values.get(label, start) for label, start in zip(labels, to.start.tolist(), strict=True)])


def _same_frequencies(tests: Sequence[VibrationTest], other_tests: Sequence[VibrationTest]) -> bool:
    frequencies, of_others = ([r.f for test in some for r in test.responses] for some in (tests, other_tests))
    return all(a is b for a, b in zip(frequencies, of_others, strict=True))


def every_signal(estimator: Estimator, listed: ListedTests) -> Predictions:
    """Return the predictions of all signals that tests may have measured."""
    rows, tests = list(listed.signals()), []
    for k, test in enumerate(listed.tests):
        responses = {r.pair: r for row in rows for r in (*test.responses, *row.data[k].responses)}
        tests.append(replace(test, responses=tuple(responses.values())))
    return Predictions(estimator.predictions.sought, tests)


def _chosen(
    wide: Sequence[VibrationTest], predicted: Sequence[Predicted], tests: Sequence[VibrationTest]
) -> list[Predicted]:
    """Return the predictions of tests, chosen by name from those of tests with all signals."""
    chosen = []
    for test_of_all, prediction, test in zip(wide, predicted, tests, strict=True):
        pairs = (response.pair for response in test_of_all.responses)
        by_pair = dict(zip(pairs, prediction.responses, strict=True))
        chosen.append(Predicted(tuple(by_pair[response.pair] for response in test.responses)))
    return chosen


def wrong_modes(
    sought: Sought, machine: Machine, sought_of: SoughtOf, tests: Sequence[VibrationTest], fit: Fit
) -> list[str]:
    """Return notes on modes that the model cannot explain; raises `InputError` for a mistake in a list of modes.

    With responses, which determine the values, nothing is fitted. A single mode hardly counts in a fit: it is reported.
    """
    modal = [test for test in tests if test.modes is not None]
    if not modal:
        return []
    search = _ModalSearch(sought, machine, sought_of, modal, fit)
    if search.is_explained:
        return []
    listed = search.listed
    kinds = [listed.modes(), listed.single_modes(), listed.positions()]
    for rows in kinds if fit.lines else [*kinds, listed.motors_held()]:
        if corrections := explanations(rows, search.distance, search.refit, math.inf):
            if corrections[0].kind is not Kind.MODE:
                _refuse(corrections, "them", "modes")
            names = ", ".join(dict.fromkeys(map(files, corrections)))
            return [f"{names}: modes: {names_of(corrections)}: without it the model explains the others"]
    return []


class _ModalSearch:
    """Search for corrections of tests with modes, near starts or at values that responses determine.

    The distance of tests from the model is the cost of frequencies, damping ratios, shapes and the prior.
    """

    def __init__(
        self, sought: Sought, machine: Machine, sought_of: SoughtOf, tests: Sequence[VibrationTest], fit: Fit
    ) -> None:
        self.listed, self.sought_of, self.is_fixed = ListedTests(machine, tests), sought_of, bool(fit.lines)
        self._wide = Predictions(sought, [self._with_all_outputs(test) for test in tests])
        self._oscillations = cache(lambda x: self._wide.oscillations(np.frombuffer(x)))
        self._of = cache(self._corrected)
        self._own = Misfit(self._wide.of(tests), (), math.inf)
        starts = (fit.x,) if self.is_fixed else (self._own.start, fit.x)
        self._least, x = min((self._minimum(self._own, x) for x in starts), key=lambda pair: pair[0])
        self._starts = (x,) if self.is_fixed else (self._own.start, x)
        self._uncorrected_distances = [self._rough_cost(self._own, x) for x in self._starts]

    def _with_all_outputs(self, test: VibrationTest) -> VibrationTest:
        """Return a test whose modes have amplitudes, unknown ones, at all outputs that it may have measured."""
        if test.modes is None or not test.modes.outputs:
            return test
        more = [other for name in test.modes.outputs for other in self.listed.other_outputs(name)]
        return replace(test, modes=replace(test.modes, outputs=tuple(dict.fromkeys((*test.modes.outputs, *more)))))

    @property
    def is_explained(self) -> bool:
        """Whether the model explains the modes as they are."""
        return self._own.is_modal_noise(self._least)

    def _corrected(self, row: Row) -> Misfit:
        """Return the misfit of corrected tests; with other locked motors the unknowns may differ."""
        of_others = row.kind is Kind.MOTORS
        predictions = Predictions(self.sought_of(row.data), row.data) if of_others else self._wide.of(row.data)
        return Misfit(predictions, (), math.inf)

    def _cost(self, misfit: Misfit, x: Array) -> float:
        """Return the cost of the modes of all tests at x."""
        pairs = zip(misfit.predictions.tests, self.listed.tests, strict=True)
        is_same_machine = all(a.at is b.at and a.hold is b.hold and a.pd is b.pd for a, b in pairs)
        return misfit.modal_cost(x, self._oscillations(x.tobytes()) if is_same_machine else None)

    def _rough_cost(self, misfit: Misfit, x: Array) -> float:
        """Return the cost of modes with wide standard deviations, for values far from the minimum."""
        predictions = misfit.predictions
        return self._cost(replace(misfit, predictions=predictions.of(list(map(roughly, predictions.tests)))), x)

    def _minimum(self, misfit: Misfit, x: Array) -> tuple[float, Array]:
        """Return the cost at a minimum near x, and its unknowns; x itself where responses fix the values."""
        if not self.is_fixed:
            x = misfit.with_all_pairs.minimum(x, differences)
        return self._cost(misfit, x), x

    def distance(self, row: Row) -> float:
        """Return by how much a correction changes the rough cost, at the nearer start."""
        try:
            misfit = self._of(row)
            starts = (_values(misfit, self._own, x) for x in self._starts)
            costs = [self._rough_cost(misfit, x) for x in starts]
        except (InputError, np.linalg.LinAlgError):
            return math.inf
        return min(cost - before for cost, before in zip(costs, self._uncorrected_distances, strict=True))

    def refit(self, row: Row) -> Refit[tuple[VibrationTest, ...]] | None:
        """Return the minimum with a correction, if it explains the modes within noise."""
        misfit = self._of(row)
        starts = (_values(misfit, self._own, x) for x in self._starts)
        cost, x = min((self._minimum(misfit, x) for x in starts), key=lambda pair: pair[0])
        if not misfit.is_modal_noise(cost):
            return None
        uncorrected = min(self._least, self._minimum(self._own, _values(self._own, misfit, x))[0])
        more = 0.5 * math.log(2 * sum(len(test.modes.f) for test in row.data if test.modes))
        return Refit(row, cost + more * max(misfit.unknowns - self._own.unknowns, 0), uncorrected)
