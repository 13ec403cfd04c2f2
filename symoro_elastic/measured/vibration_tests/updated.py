"""From vibration tests to the machine that explains them: fit, verdicts, doubts, unseen tests, the next test."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.results import Result, Table, table_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.measured.fitting.estimates import (
    Estimate,
    Verdict,
    estimates_of_logarithms,
    undetermined_directions,
)
from symoro_elastic.measured.fitting.evidence import OtherData
from symoro_elastic.measured.vibration_tests import diagnostics
from symoro_elastic.measured.vibration_tests.corrections import (
    MUCH_NEARER,
    refuse_mistakes,
    refuse_zero_signals,
    wrong_modes,
)
from symoro_elastic.measured.vibration_tests.estimator import Estimator, lines_of
from symoro_elastic.measured.vibration_tests.measured import VibrationTest
from symoro_elastic.measured.vibration_tests.misfit import Fit
from symoro_elastic.measured.vibration_tests.next_tests import Candidate, next_tests
from symoro_elastic.measured.vibration_tests.predictions import Lines, Predicted, Predictions
from symoro_elastic.measured.vibration_tests.unknowns import Sought, sought_of

DIGITS = 6  # of values that are saved
CONTRADICTION = (
    "the log and the tests contradict each other by more than chance: check positions, held motors, centers of mass "
    "and the torque constant (--gain); fit each alone (identify, update) and compare"
)


@dataclass(frozen=True)
class Settings:
    """Settings of an update: parameters to estimate, prior factor, uncertainty of masses, omitted bands, robustness."""

    seek: tuple[str, ...] = ()
    factor: float = 2.0
    mass_doubt: float = 0.0
    without: tuple[tuple[float, float], ...] = ()
    robust: bool = True


@dataclass(frozen=True)
class Shown:
    """Prediction errors of a test's response: median |dB| and relative error of peaks, before and after the fit.

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
    """A machine updated by vibration tests: estimates with verdicts, the fit, and diagnostic notes.

    `tests` were fitted, `unseen` were only predicted.
    """

    machine: Machine
    sought: Sought
    tests: tuple[VibrationTest, ...]
    unseen: tuple[VibrationTest, ...]
    settings: Settings
    fit: Fit
    notes: tuple[str, ...]

    @cached_property
    def estimates(self) -> tuple[Estimate, ...]:
        """Estimates of all unknowns, with verdicts."""
        return estimates_of_logarithms(self.sought.unknowns, self.fit.x, self.fit.std, self.settings.factor)

    @cached_property
    def undetermined(self) -> tuple[str, ...]:
        """Sentences about parameters and combinations that these tests cannot determine."""
        fit, unknowns = self.fit, self.sought.unknowns
        return tuple(undetermined_directions(unknowns, fit.x, fit.covariance, self.settings.factor))

    @cached_property
    def bands(self) -> tuple[diagnostics.Band, ...]:
        """Bands of large residuals, in which the model is incomplete."""
        return tuple(diagnostics.lacking(self.fit.lines, self.fit))

    @property
    def headline(self) -> str:
        """Machine, tests and parameters."""
        reported = [estimate for estimate in self.estimates if not estimate.unknown.is_nuisance]
        good = sum(estimate.verdict is Verdict.IDENTIFIED for estimate in reported)
        count = f"{len(self.tests)} test{'' if len(self.tests) == 1 else 's'}"
        return f"Update of {self.machine.name}: {good} of {len(reported)} parameters identified from {count}"

    @property
    def values(self) -> Mapping[str, float]:
        """Estimated values by label, in the precision in which they are saved."""
        return {estimate.unknown.label: float(f"{estimate.value:.{DIGITS}g}") for estimate in self.estimates}

    @property
    def verdict_on_model(self) -> str:
        """Verdict of chi2 on the model, in words."""
        return diagnostics.verdict_on_model(self.fit, self.bands)

    @cached_property
    def predictions(self) -> tuple[tuple[Predicted, ...], tuple[Predicted, ...]]:
        """Predictions of all tests, fitted and validation ones: with initial and with estimated values."""
        predictions = Predictions(self.sought, (*self.tests, *self.unseen))
        return tuple(predictions.at(self.sought.start, False)), tuple(predictions.at(self.fit.x, False))

    @cached_property
    def shown(self) -> tuple[Shown, ...]:
        """Prediction errors of each response with initial and with estimated values."""
        rows = []
        zero = {(line.test, line.place) for line in self.fit.lines}
        for t, (test, before, after) in enumerate(zip((*self.tests, *self.unseen), *self.predictions, strict=True)):
            for k, (measured, old, new) in enumerate(
                zip(test.responses, before.responses, after.responses, strict=True)
            ):
                fitted = t < len(self.tests)
                if fitted and (t, k) not in zero:
                    continue
                numbers = [diagnostics.errors(measured.H, response.G) for response in (old, new)]
                numbers += [diagnostics.peak_errors(measured.f, measured.H, response.G) for response in (old, new)]
                rows.append(Shown(test.name, measured.output, measured.input, fitted, *numbers))
            if test.modes is not None and before.modes is not None and after.modes is not None:
                apart = [
                    diagnostics.frequency_errors(test.modes.f, response.modes.f)
                    for response in (before, after)
                    if response.modes
                ]
                nothing = (math.nan, math.nan)
                rows.append(Shown(test.name, "frequencies", "", t < len(self.tests), *nothing, *apart))
        return tuple(rows)

    def next_tests(self, count: int = 5) -> list[Candidate]:
        """Return the next tests that reduce the parameters' variances most, the best one first."""
        return next_tests(Predictions(self.sought, self.tests), self.fit.lines, self.fit, count)

    def table_of_next(self, candidates: Sequence[Candidate]) -> Table:
        """Return the table of next tests."""
        return table_of(Candidate, candidates, f"{self.machine.name}: the next test")

    def saved(self) -> tuple[Machine, list[str]]:
        """Return the machine with the estimated values, and notes on values that its file cannot contain."""
        of_machine = {unknown.label: not unknown.is_gain for unknown in self.sought.unknowns}
        values = {label: x for label, x in self.values.items() if of_machine[label]}
        gains = [f"{label} = {x:.4g}" for label, x in self.values.items() if not of_machine[label]]
        lines = (
            [f"{', '.join(gains)}: of controllers, not of the machine, so the file does not hold them"] if gains else []
        )
        masses = [estimate.unknown.label for estimate in self.estimates if estimate.unknown.is_nuisance]
        if masses:
            lines.append(
                f"{len(masses)} masses and inertias are saved as fitted, within --mass-doubt: stiffnesses go with them"
            )
        return with_values(self.sought.machine, values), lines


def update(
    machine: Machine,
    tests: Sequence[VibrationTest],
    settings: Settings,
    step: Announce = announce_nothing,
    notes: Sequence[str] = (),
    other: OtherData | None = None,
) -> Updated:
    """Return the machine that explains these tests best, near its file.

    `other` data of the machine are fitted together with the tests.

    Raises
    ------
    InputError
        For tests without data, signals and parameters that do not exist, a response whose sign is opposite.
    """
    fitted = _tests_to_fit(machine, tests)
    step("start")

    by = partial(sought_of, machine, settings.seek, settings.factor, settings.mass_doubt, other)
    sought = by(fitted)
    predictions = Predictions(sought, fitted)
    lines, zero = lines_of(predictions, settings.without)
    _refuse_zero(machine, fitted, lines)
    step("fit")
    evidence = other.evidence(sought.labels) if other else None
    estimator = Estimator(predictions, lines, settings.robust, evidence)
    fit = _checked_fit(estimator, partial(refuse_mistakes, estimator, machine, by))
    if zero and lines:
        refuse_zero_signals(estimator, machine, zero, fit)
    of_modes = wrong_modes(sought, machine, by, fitted, fit)
    listed, fitted = fitted, fit.tests
    after = predictions.at(fit.x, slopes=False, tests=fitted)
    if not fit.delays:
        diagnostics.refuse_opposite(fitted, fit.lines, after)
    lines_about = [
        *notes, *sought.notes, *_doubts(listed, zero, fit, after), *of_modes, *predictions.doubts_at(fit.x),
        *diagnostics.of_windows(listed, fit, sought.labels),
    ]  # fmt: skip
    if evidence and evidence.contradicts(fit.x):
        lines_about.append(CONTRADICTION)
    return Updated(machine, sought, fitted, _unseen(tests, listed, fitted), settings, fit, tuple(lines_about))


def _unseen(
    tests: Sequence[VibrationTest], listed: Sequence[VibrationTest], fitted: Sequence[VibrationTest]
) -> tuple[VibrationTest, ...]:
    """Return the validation tests, with the windows that were found for the fitted tests."""
    windows = {a.window: b.window for a, b in zip(listed, fitted, strict=True)}
    return tuple(replace(test, window=windows.get(test.window, test.window)) for test in tests if test.validate)


def _refuse_zero(machine: Machine, tests: Sequence[VibrationTest], lines: Sequence[Lines]) -> None:
    """Raise `InputError` where all responses are zero in the model, and no modes are given."""
    if not lines and not any(test.modes for test in tests):
        pairs = ", ".join(response.pair for test in tests for response in test.responses)
        what = f"{pairs}: zero in the model, so nothing is left to fit: check axes, forces or moments, and bodies"
        raise InputError(machine.label, "tests", what)


def _tests_to_fit(machine: Machine, tests: Sequence[VibrationTest]) -> tuple[VibrationTest, ...]:
    """Return the tests to fit; raises `InputError` where there is none, or one occurs twice."""
    fitted = tuple(test for test in tests if not test.validate)
    if not any(test.responses or test.modes for test in fitted):
        raise InputError(machine.label, "tests", "no test to fit: at least one without validate is needed")
    diagnostics.refuse_copies(fitted)
    return fitted


def _doubts(
    tests: Sequence[VibrationTest], zero: Sequence[tuple[int, int]], fit: Fit, after: Sequence[Predicted]
) -> list[str]:
    """Return diagnostic notes on tests that disagree with the model."""
    return [
        *diagnostics.of_zero_pairs(tests, zero), *([] if fit.gains else diagnostics.of_scale(tests, fit.lines, after)),
        *diagnostics.of_lost_modes(tests, after),
        *([] if fit.delays or fit.gains else diagnostics.of_pairs(tests, fit, after)),
        *diagnostics.of_spikes(tests, fit), *diagnostics.of_delays(tests, fit), *diagnostics.of_gains(tests, fit),
        *diagnostics.of_neighbours(fit),
    ]  # fmt: skip


def _checked_fit(estimator: Estimator, look: Callable[..., None]) -> Fit:
    """Return the fit; refuses lists of tests with mistakes, by `look` where residuals are large.

    Raises `InputError` for files and lists whose mistake is known.
    """
    tests, start = estimator.predictions.tests, estimator.predictions.sought.start
    predicted = estimator.predictions.at(start, slopes=False)
    diagnostics.refuse_without_phase(tests, estimator.lines, predicted)
    try:
        diagnostics.refuse_far(tests, estimator.lines, predicted)
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
    """Raise `InputError` for mistakes in responses and their list, then for pairs of another sign or unit."""
    look(fit, MUCH_NEARER)
    try:
        diagnostics.refuse_wrong(tests, fit.lines, predicted)
    except InputError:
        look(fit)
        raise
