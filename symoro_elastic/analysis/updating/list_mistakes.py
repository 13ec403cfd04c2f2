"""Which mistake of a list of tests explains what the model cannot: each is undone, the nearest are fitted.

Near are tests whose smoothed responses are much nearer to the model's, with the values of the file or of the fit. A
mistake is named if tests without it leave no more than noise from the start, and the list as it is does not, from
the values that were found, either.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.analysis.updating.doubts import is_cross_talk
from symoro_elastic.analysis.updating.estimator import WIDTHS, Estimator, Minimum, is_far, lines_of
from symoro_elastic.analysis.updating.listed_tests import Corrected, ListedTests
from symoro_elastic.analysis.updating.measured import VibrationTest
from symoro_elastic.analysis.updating.misfit import Fit
from symoro_elastic.analysis.updating.predictions import Predicted, PredictedResponse, Predictions
from symoro_elastic.analysis.updating.unknowns import Sought
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine

NEAR, STRIKING, MOST_FITTED = 0.9, 0.7, 6
"""Of the distance as it is, what a mistake that is undone leaves of smoothed responses, and leaves before other starts
are tried; how many are fitted."""
LEFT, LEFT_UNKNOWN = 0.6, 0.2
"""Of the distance as it is, what it leaves fitted, at most, where the noise is known and where it is not."""
ALIKE, MOST_SAID = 5.0, 3
"""Difference of costs below which mistakes are not told apart, and how many are said."""
EXPLAINED = 0.1
"""Median |ln(G/H)| of responses that another signal explains at a fit of the others."""
Near = tuple[float, Corrected, Estimator]
SoughtOf = Callable[[Sequence[VibrationTest]], Sought]


def refuse_wrong_list(
    estimator: Estimator, machine: Machine, sought_of: SoughtOf, fit: Fit, most: float = NEAR
) -> None:
    """Raise `InputError` for the mistake of the list that explains what the model does not at a minimum.

    `sought_of` gives the unknowns of tests, which motors that are free or under unknown gains change; `most` is the
    largest share of the distance that is fitted.
    """
    listed = ListedTests(machine, estimator.predictions.tests)
    if not (estimator.lines and is_far(fit)):
        return
    starts = [estimator.start, fit.x]
    as_it_is = [estimator.smoothed_cost(x, WIDTHS[0]) for x in starts]
    every = (one for one in _near(estimator, listed, sought_of, starts, as_it_is) if one[0] < most)
    near = sorted(every, key=lambda one: one[0])[:MOST_FITTED]
    tried = ((one, _explained(estimator, by, fit)) for _, one, by in near)
    found = [(other.fit.distance, one) for one, other in tried if other is not None]
    if not found:
        zeros = _near_zeros(estimator, listed, starts, as_it_is, most)
        tried = (_with_best_zero(estimator, listed, one, fit) for one in zeros)
        found = [(other.fit.distance, one) for one, other in tried if other is not None]
    _refuse(found)


def _refuse(found: Sequence[tuple[float, Corrected]]) -> None:
    """Raise `InputError` for the mistake that leaves least, and for those that leave hardly more."""
    if not found:
        return
    order = sorted(found, key=lambda pair: pair[0])
    least, one = order[0]
    alike = [other for left, other in order if left <= least + ALIKE and other.changed == one.changed]
    if any(other.is_sign for other in alike):
        return
    named = [other.what for other in alike]
    what = f"{', or '.join(named[:MOST_SAID])}: only so does the model explain the tests; correct the list"
    raise InputError(one.files, "list", what)


def refuse_zero_signals(estimator: Estimator, machine: Machine, zero: Sequence[tuple[int, int]], fit: Fit) -> None:
    """Raise `InputError` where responses that the model cannot have are those of another signal, by a fit of others."""
    listed = ListedTests(machine, estimator.predictions.tests)
    places = [(t, k) for t, k in zero if is_cross_talk(listed.tests[t], k)]
    if not places:
        return
    wide, others = _all_signals(estimator, listed)
    predicted, near = wide.at(fit.x, slopes=False), []
    for one in others:
        responses = _chosen(wide.tests, predicted, one.tests)
        new = [(t, k) for t, k in places if one.tests[t].responses[k] is not listed.tests[t].responses[k]]
        each = [_apart(one.tests[t].responses[k].H, responses[t].responses[k].G) for t, k in new]
        if each and max(each) < math.inf:
            near.append((max(each), one))
    near = sorted(near, key=lambda pair: pair[0])[:MOST_FITTED]
    found = [pair for pair in near if pair[0] < EXPLAINED]
    _refuse(found[:1] or [(0.0, one) for _, one in near if _is_explained(estimator, wide.of(one.tests))])


def _is_explained(estimator: Estimator, predictions: Predictions) -> bool:
    """Whether a fit to all responses of other tests leaves no more than noise."""
    lines, _ = lines_of(predictions)
    try:
        return not Estimator(predictions, lines, estimator.alone.robust).near(estimator.start).is_far
    except (InputError, np.linalg.LinAlgError):
        return False


def _apart(H: ComplexArray, G: ComplexArray) -> float:
    return float(np.median(np.abs(np.log(G / H)))) if G.all() and H.all() else math.inf


def _near(
    estimator: Estimator, listed: ListedTests, sought_of: SoughtOf, starts: Sequence[Array], as_it_is: Sequence[float]
) -> Iterator[Near]:
    """Yield tests without a mistake, their share of the distances as they are at `starts`, and their estimator.

    Other positions leave signals and unknowns as they are; other motors that are held do not.
    """

    def of_held(tests: Sequence[VibrationTest]) -> Predictions:
        return Predictions(sought_of(tests), tests)

    others = (
        (one, of)
        for each, of in ((listed.positions(), estimator.predictions.of), (listed.held(), of_held))
        for one in each
    )
    for one, of in others:
        try:
            by = estimator.of(of(one.tests))
        except (InputError, np.linalg.LinAlgError):
            continue
        each = [by.smoothed_cost(_values(by, estimator, x), WIDTHS[0]) for x in starts]
        yield _share(each, as_it_is), one, by
    yield from _near_signals(estimator, listed, starts, as_it_is)


def _near_zeros(
    estimator: Estimator, listed: ListedTests, starts: Sequence[Array], as_it_is: Sequence[float], most: float
) -> list[Corrected]:
    """Return the nearest other zero of each joint with which tests are nearer to the model."""
    found: dict[str, tuple[float, Corrected]] = {}
    for one in listed.zeros():
        by = estimator.of(estimator.predictions.of(one.tests))
        share = _share([by.smoothed_cost(x, WIDTHS[0]) for x in starts], as_it_is)
        if share < found.get(one.joint, (most, one))[0]:
            found[one.joint] = share, one
    return [one for _, one in sorted(found.values(), key=lambda pair: pair[0])]


def _with_best_zero(
    estimator: Estimator, listed: ListedTests, near: Corrected, fit: Fit
) -> tuple[Corrected, Minimum | None]:
    """Return the tests with the best zero of a joint near one, and their minimum where it explains them."""
    given = estimator.predictions
    try:
        other = estimator.of(given.of(near.tests, (near.joint,))).near(estimator.start)
    except (InputError, np.linalg.LinAlgError):
        return near, None
    one = listed.with_zero(near.joint, near.zero + float(other.all[len(other.x)]))
    return one, _explained(estimator, estimator.of(given.of(one.tests)), fit, other.x)


def _values(by: Estimator, estimator: Estimator, x: Array) -> Array:
    """Return the unknowns of an estimator where they are those of another one at x, else at their start."""
    own, other = by.predictions.sought.labels, estimator.predictions.sought.labels
    known = dict(zip(other, x.tolist(), strict=True))
    return np.array([known.get(label, start) for label, start in zip(own, by.start.tolist(), strict=True)])


def _near_signals(
    estimator: Estimator, listed: ListedTests, starts: Sequence[Array], as_it_is: Sequence[float]
) -> Iterator[Near]:
    """Yield tests with other signals that are nearer to the model; all of these are predicted at once."""
    wide, others = _all_signals(estimator, listed)
    found = [wide.at(x, slopes=False) for x in starts]
    for one in others:
        by = estimator.of(wide.of(one.tests))
        each = [by.smoothed_distance(_chosen(wide.tests, predicted, one.tests)) for predicted in found]
        yield _share(each, as_it_is), one, by


def _all_signals(estimator: Estimator, listed: ListedTests) -> tuple[Predictions, list[Corrected]]:
    """Return predictions of all signals that tests may have measured, and the tests with each of them."""
    others, sought = list(listed.signals()), estimator.predictions.sought
    return Predictions(sought, [_with_all(k, listed.tests[k], others) for k in range(len(listed.tests))]), others


def _with_all(k: int, test: VibrationTest, others: Sequence[Corrected]) -> VibrationTest:
    """Return a test with the responses of all signals that it may have measured."""
    more = {one.pair: one for other in others for one in (*test.responses, *other.tests[k].responses)}
    return replace(test, responses=tuple(more.values()))


def _chosen(
    wide: Sequence[VibrationTest], predicted: Sequence[Predicted], tests: Sequence[VibrationTest]
) -> list[Predicted]:
    """Return what is predicted of tests whose responses are among those of wider ones."""
    found = []
    for every, of, test in zip(wide, predicted, tests, strict=True):
        by_pair: dict[str, PredictedResponse] = {
            one.pair: response for one, response in zip(every.responses, of.responses, strict=True)
        }
        found.append(Predicted(tuple(by_pair[one.pair] for one in test.responses)))
    return found


def _share(each: Sequence[float], as_it_is: Sequence[float]) -> float:
    return min(after / before for after, before in zip(each, as_it_is, strict=True))


def _explained(estimator: Estimator, by: Estimator, fit: Fit, x: Array | None = None) -> Minimum | None:
    """Return the minimum of other tests, if it leaves no more than noise, and the tests as they are leave more."""
    try:
        other = by.near(by.start if x is None else x)
        left = LEFT if math.isfinite(fit.chi2) else LEFT_UNKNOWN
        if is_far(other.fit) or not other.fit.distance < left * fit.distance:
            return None
        own = estimator.near(_values(estimator, by, other.x))
    except (InputError, np.linalg.LinAlgError):
        return None
    return other if own.is_far and math.isfinite(other.fit.distance) else None
