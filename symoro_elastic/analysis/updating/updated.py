"""From vibration tests to the machine that explains them: fit, verdicts, doubts, unseen tests, the next test."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

from symoro_elastic.analysis.updating import doubts, mistakes
from symoro_elastic.analysis.updating.estimator import Estimator, lines_of
from symoro_elastic.analysis.updating.list_mistakes import STRIKING, refuse_wrong_list, refuse_zero_signals
from symoro_elastic.analysis.updating.measured import VibrationTest
from symoro_elastic.analysis.updating.misfit import Fit
from symoro_elastic.analysis.updating.modal_mistakes import wrong_modes
from symoro_elastic.analysis.updating.next_tests import Candidate, next_tests
from symoro_elastic.analysis.updating.predictions import Predicted, Predictions
from symoro_elastic.analysis.updating.told import Found, Verdict, found_of, untold
from symoro_elastic.analysis.updating.unknowns import Sought, sought_of
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values

DIGITS = 6
"""Of values that are saved."""


@dataclass(frozen=True)
class Settings:
    """How tests are fitted: what is sought, prior factor, doubt of masses, windows left out, robust or not."""

    seek: tuple[str, ...] = ()
    factor: float = 2.0
    mass_doubt: float = 0.0
    without: tuple[tuple[float, float], ...] = ()
    robust: bool = True


@dataclass(frozen=True)
class Shown:
    """How well a response of a test is predicted: median |dB| and relative error of peaks, before and after the fit.

    Of a list of modes, the relative error of frequencies.
    """

    test: str
    output: str
    input: str
    is_fitted: bool
    before: float
    after: float
    peaks_before: float
    peaks_after: float


@dataclass(frozen=True, repr=False)
class Updated(Result):
    """A machine updated by vibration tests: estimates with verdicts, the fit, and lines about what is in doubt.

    `tests` were fitted, `unseen` were only predicted. `untold` are sentences about what these tests cannot tell.
    """

    machine: Machine
    sought: Sought
    tests: tuple[VibrationTest, ...]
    unseen: tuple[VibrationTest, ...]
    settings: Settings
    fit: Fit
    estimates: tuple[Found, ...]
    untold: tuple[str, ...]
    bands: tuple[doubts.Band, ...]
    notes: tuple[str, ...]

    @property
    def headline(self) -> str:
        """Machine, tests and parameters."""
        kept = [one for one in self.estimates if not one.unknown.is_nuisance]
        good = sum(one.verdict is Verdict.IDENTIFIED for one in kept)
        count = f"{len(self.tests)} test{'' if len(self.tests) == 1 else 's'}"
        return f"Update of {self.machine.name}: {good} of {len(kept)} parameters identified from {count}"

    @property
    def values(self) -> Mapping[str, float]:
        """Values by label, as they are saved."""
        return {one.unknown.label: float(f"{one.value:.{DIGITS}g}") for one in self.estimates}

    @property
    def verdict_on_model(self) -> str:
        """chi2 read aloud."""
        return doubts.verdict_on_model(self.fit, self.bands)

    @cached_property
    def predictions(self) -> tuple[tuple[Predicted, ...], tuple[Predicted, ...]]:
        """What the machine predicts of all tests, fitted and unseen ones, before and after."""
        asked = Predictions(self.sought, (*self.tests, *self.unseen))
        return tuple(asked.at(self.sought.start, False)), tuple(asked.at(self.fit.x, False))

    @cached_property
    def shown(self) -> tuple[Shown, ...]:
        """How well each response is predicted, before and after."""
        found = []
        zero = {(line.test, line.place) for line in self.fit.lines}
        for t, (test, before, after) in enumerate(zip((*self.tests, *self.unseen), *self.predictions, strict=True)):
            for k, (one, old, new) in enumerate(zip(test.responses, before.responses, after.responses, strict=True)):
                fitted = t < len(self.tests)
                if fitted and (t, k) not in zero:
                    continue
                numbers = [doubts.errors(one.H, each.G) for each in (old, new)]
                numbers += [doubts.peak_errors(one.f, one.H, each.G) for each in (old, new)]
                found.append(Shown(test.name, one.output, one.input, fitted, *numbers))
            if test.modes is not None and before.modes is not None and after.modes is not None:
                apart = [doubts.frequency_errors(test.modes.f, each.modes.f) for each in (before, after) if each.modes]
                nothing = (math.nan, math.nan)
                found.append(Shown(test.name, "frequencies", "", t < len(self.tests), *nothing, *apart))
        return tuple(found)

    def next_tests(self, count: int = 5) -> list[Candidate]:
        """Return the tests after which the sought parameters are known best, the best one first."""
        return next_tests(Predictions(self.sought, self.tests), self.fit.lines, self.fit, count)

    def saved(self) -> tuple[Machine, list[str]]:
        """Return the machine with the values found, and lines about those that no machine file holds."""
        of_machine = {one.label: not one.is_gain for one in self.sought.unknowns}
        values = {label: x for label, x in self.values.items() if of_machine[label]}
        gains = [f"{label} = {x:.4g}" for label, x in self.values.items() if not of_machine[label]]
        lines = (
            [f"{', '.join(gains)}: of controllers, not of the machine, so the file does not hold them"] if gains else []
        )
        masses = [one.unknown.label for one in self.estimates if one.unknown.is_nuisance]
        if masses:
            lines.append(
                f"{len(masses)} masses and inertias are saved as fitted, within their doubt: stiffness goes with them"
            )
        return with_values(self.sought.machine, values), lines


def update(
    machine: Machine,
    tests: Sequence[VibrationTest],
    settings: Settings,
    step: Announce = announce_nothing,
    notes: Sequence[str] = (),
) -> Updated:
    """Return the machine that explains these tests best, near its file.

    Raises
    ------
    InputError
        For tests without data, signals and parameters that do not exist, a response whose sign is opposite.
    """
    fitted = _those_fitted(machine, tests)
    if not (math.isfinite(settings.factor) and settings.factor > 1):
        raise InputError(machine.label, "--factor", f"{settings.factor:g} is not a factor above 1")
    step("start")
    by = partial(sought_of, machine, seek=settings.seek, factor=settings.factor, mass_doubt=settings.mass_doubt)
    sought = by(fitted)
    predictions = Predictions(sought, fitted)
    lines, zero = lines_of(predictions, settings.without)
    if zero and not lines and not any(test.modes for test in fitted):
        pairs = ", ".join(one.pair for test in fitted for one in test.responses)
        what = f"{pairs}: zero in the model, so nothing is left to fit: check axes, forces or moments, and bodies"
        raise InputError(machine.label, "tests", what)
    step("fit")
    estimator = Estimator(predictions, lines, settings.robust)
    fit = _fitted(estimator, partial(refuse_wrong_list, estimator, machine, by))
    if zero and lines:
        refuse_zero_signals(estimator, machine, zero, fit)
    of_modes = wrong_modes(sought, machine, by, fitted, fit)
    given, fitted = fitted, fit.tests
    after = predictions.at(fit.x, slopes=False, tests=fitted)
    if not fit.delays:
        doubts.refuse_opposite(fitted, fit.lines, after)
    lines_about = [
        *notes, *sought.notes, *_doubts(given, zero, fit, after), *of_modes, *predictions.doubts_at(fit.x),
        *doubts.of_windows(given, fit, sought.labels),
    ]  # fmt: skip
    seen = {a.window: b.window for a, b in zip(given, fitted, strict=True)}
    unseen = tuple(replace(test, window=seen.get(test.window, test.window)) for test in tests if test.validate)
    told = found_of(sought, fit, settings.factor), tuple(untold(sought, fit, settings.factor))
    bands = tuple(doubts.lacking(fit.lines, fit))
    return Updated(machine, sought, fitted, unseen, settings, fit, *told, bands, tuple(lines_about))


def _those_fitted(machine: Machine, tests: Sequence[VibrationTest]) -> tuple[VibrationTest, ...]:
    """Return the tests that are fitted; raises `InputError` where none is left, or one is there twice."""
    fitted = tuple(test for test in tests if not test.validate)
    if not any(test.responses or test.modes for test in fitted):
        raise InputError(machine.label, "tests", "no test is left to fit: at least one without validate is needed")
    doubts.refuse_copies(fitted)
    return fitted


def _doubts(
    tests: Sequence[VibrationTest], zero: Sequence[tuple[int, int]], fit: Fit, after: Sequence[Predicted]
) -> list[str]:
    """Return lines about tests that do not go with the model."""
    return [
        *doubts.of_zero_pairs(tests, zero), *([] if fit.gains else doubts.of_scale(tests, fit.lines, after)),
        *doubts.of_lost_modes(tests, after),
        *([] if fit.delays or fit.gains else mistakes.of_pairs(tests, fit, after)),
        *doubts.of_spikes(tests, fit), *doubts.of_delays(tests, fit), *doubts.of_gains(tests, fit),
        *doubts.of_neighbours(fit),
    ]  # fmt: skip


def _fitted(estimator: Estimator, look: Callable[..., None]) -> Fit:
    """Return the fit; `look` refuses wrong lists of tests, before other hints, and where the model lacks something.

    Raises `InputError` for files and lists whose mistake is known.
    """
    tests, start = estimator.predictions.tests, estimator.predictions.sought.start
    try:
        mistakes.refuse_far(tests, estimator.lines, estimator.predictions.at(start, slopes=False))
    except InputError:
        look(estimator.near(start).fit)
        raise
    fit = estimator.fit(partial(_refuse_wrong, estimator, tests, look))
    look(fit)
    return fit


def _refuse_wrong(
    estimator: Estimator,
    tests: Sequence[VibrationTest],
    look: Callable[..., None],
    fit: Fit,
    predicted: Sequence[Predicted],
) -> None:
    """Raise `InputError` for mistakes in all responses, then of the list, then for pairs of another sign or unit."""
    mistakes.refuse_mistakes(estimator, tests, fit)
    look(fit, STRIKING)
    try:
        doubts.refuse_wrong(tests, fit.lines, predicted)
    except InputError:
        look(fit)
        raise
