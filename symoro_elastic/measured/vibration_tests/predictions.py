"""What a machine with given parameters predicts of vibration tests, and the exact slopes of that by ln p."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.control.cascade import omitted_limits
from symoro_elastic.analysis.control.response_slopes import Feedback, closed_response_slopes, feedbacks_of
from symoro_elastic.analysis.vibration.linearization import (
    Linearization,
    LinearSlopes,
    linear_slopes,
    linearize,
    pole_slopes,
    ratio_slopes,
    with_motors,
)
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray, IndexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR
from symoro_elastic.machine.names import did_you_mean
from symoro_elastic.measured.vibration_tests.measured import (
    MeasuredModes,
    MeasuredResponse,
    VibrationTest,
    windowed_lines,
)
from symoro_elastic.measured.vibration_tests.unknowns import KD, KP, Sought, gain_label, gains_in, held_in
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.motion.inertia import refuse_singular

LEAST_MAC = 0.5
RIVALS = 0.1  # MAC within which two modes both fit a measured one
LARGEST_CHANGE = 3.0  # prior standard deviation of the change of a window or a zero
STEP = 0.01  # of differences by windows
STEP_OF_ZERO = 1e-4  # of differences by zeros, rad or m


@dataclass(frozen=True)
class PredictedResponse:
    """Predicted response G (N), and its slopes (p, N) by ln p; (0, N) without slopes."""

    G: ComplexArray
    slopes: ComplexArray


@dataclass(frozen=True)
class PredictedModes:
    """Frequencies (k), Hz, and damping ratios (k) predicted for measured modes, NaN without match; slopes (p, k)."""

    f: Array
    zeta: Array
    slopes_f: Array
    slopes_zeta: Array


@dataclass(frozen=True)
class Predicted:
    """Predicted responses and modes of a test."""

    responses: tuple[PredictedResponse, ...]
    modes: PredictedModes | None = None


@dataclass(frozen=True)
class Lines:
    """A response to be fitted: the lines that count, its standard deviations, and whether they are known."""

    measured: MeasuredResponse
    counted: BoolArray
    sd: Array
    sd_is_known: bool
    test: int
    place: int

    @property
    def H(self) -> ComplexArray:
        """Measured response at the lines that count."""
        H: ComplexArray = self.measured.H[self.counted]
        return H

    @property
    def f(self) -> Array:
        """Frequencies of the lines that count, Hz."""
        return self.measured.f[self.counted]

    @property
    def size(self) -> float:
        """Median magnitude of the measured response."""
        return float(np.median(np.abs(self.H)))

    def predicted_by(self, predicted: Sequence[Predicted]) -> ComplexArray:
        """Return the predicted response at the lines that count, from the predictions of all tests."""
        G: ComplexArray = predicted[self.test].responses[self.place].G[self.counted]
        return G


class Predictions:
    """Predictions of tests at any values of the unknowns; traced equations of motion are shared."""

    def __init__(self, sought: Sought, tests: Sequence[VibrationTest]) -> None:
        """Raise `InputError` for signals that the machine or a locked motor lacks, and for modes under drives."""
        self.sought, self.tests = sought, tuple(tests)
        for test in tests:
            if test.modes and test.drives:
                what = "natural frequencies and ring-downs are of motors held, free or under pd: measure responses"
                raise InputError(test.name, "drives", what)
        drives = drives_of(sought.machine).by_motor if any(test.drives for test in tests) else {}
        measured = [loop.measured for loop in drives.values() if loop.measured != MOTOR]
        ins = [loop.input for test in tests for loop in test.responses]
        outs = [*(name for test in tests for name in _outputs(test)), *measured]
        self.motion = motion_of(sought.machine, {}, tuple(dict.fromkeys(ins)), tuple(dict.fromkeys(outs)))
        self.parameters = [name for name in sought.labels if name in self.motion.parameters]
        self._feedbacks = feedbacks_of(self.motion, self.parameters) if drives else {}

        self.windowed: tuple[int | str, ...] = ()
        self.pairs_all = False

    def of(self, tests: Sequence[VibrationTest], windowed: Sequence[int | str] = ()) -> Predictions:
        """Return predictions of other tests with the same signals; windows of tests `windowed` (w) are unknown.

        A name among these is that of a joint whose zero is unknown in all tests.
        """
        other = copy.copy(self)
        other.tests, other.windowed = tuple(tests), tuple(windowed)
        return other

    def with_all_pairs(self) -> Predictions:
        """Return the same predictions with uncertain pairs of modes included, as is needed far from the minimum."""
        other = copy.copy(self)
        other.pairs_all = True
        return other

    @property
    def start(self) -> Array:
        """Initial values of the unknowns (p + w): logarithms of parameters, and zero changes of windows."""
        return np.concatenate([self.sought.start, np.zeros(len(self.windowed))])

    @property
    def prior(self) -> Array:
        """Inverse prior variances (p + w) of the unknowns."""
        return np.concatenate([self.sought.prior, np.full(len(self.windowed), LARGEST_CHANGE**-2)])

    def tests_at(self, x: Array) -> tuple[VibrationTest, ...]:
        """Return the tests with their windows and zeros at unknowns (p + w)."""
        tests = list(self.tests)
        for one, c in zip(self.windowed, x[len(self.sought.unknowns) :].tolist(), strict=True):
            tests = [
                _with_change(test, one, c) if one == k or isinstance(one, str) else test for k, test in enumerate(tests)
            ]
        return tuple(tests)

    def at(self, x: Array, slopes: bool = True, tests: Sequence[VibrationTest] | None = None) -> list[Predicted]:
        """Return the predictions at the unknowns x: logarithms (p,) and w changes of windows, with slopes by both.

        Raises `InputError` without equilibrium.
        """
        p = len(self.sought.unknowns)
        values, motion = self._at_values(x)
        predicted = []
        for k, test in enumerate(self.tests_at(x) if tests is None else tests):
            linear = self.linear_at(motion, test, values)
            refuse_singular(motion, linear.M, linear.kept)
            prediction = self._of(linear, test, values, slopes)
            for row, name in enumerate(self.windowed if slopes else ()):
                if name == k or isinstance(name, str):
                    by_change = self._by_change(linear, test, name, values)
                    for response, slope in zip(prediction.responses, by_change, strict=True):
                        response.slopes[p + row] = slope
            predicted.append(prediction)
        return predicted

    def oscillations(self, x: Array) -> list[Oscillations]:
        """Return the oscillations of each test at logarithms x (p,); raises `InputError` without equilibrium."""
        values, motion = self._at_values(x)
        return [oscillations_of(self.linear_at(motion, test, values)) for test in self.tests]

    def _at_values(self, x: Array) -> tuple[dict[str, float], EquationsOfMotion]:
        """Return the values of the unknowns, and the equations of motion with these values."""
        values = dict(zip(self.sought.labels, np.exp(x[: len(self.sought.unknowns)]).tolist(), strict=True))
        return values, self.motion.at_values({name: values[name] for name in self.parameters})

    def _by_change(
        self, linear: Linearization, test: VibrationTest, name: int | str, values: Mapping[str, float]
    ) -> list[ComplexArray]:
        """Return slopes of responses by the change of a window, or of the zero of a joint, by differences."""
        step, ends = STEP_OF_ZERO if isinstance(name, str) else STEP, []
        for way in (1, -1):
            other = _with_change(test, name, way * step)
            own = self.linear_at(linear.motion, other, values) if isinstance(name, str) else linear
            ends.append(self._of(own, other, values, False).responses)
        return [(after.G - before.G) / (2 * step) for after, before in zip(*ends, strict=True)]

    def linear_at(self, motion: EquationsOfMotion, test: VibrationTest, values: Mapping[str, float]) -> Linearization:
        """Return the machine in a test, linearized, with the controllers of the test."""
        loops = self._feedbacks_of(test)
        ins = tuple(dict.fromkeys([*(response.input for response in test.responses), *(loop.torque for loop in loops)]))
        measured = [name for loop in loops for name in (loop.own, loop.controlled)]
        outs = tuple(dict.fromkeys([*_outputs(test), *measured]))
        linear = linearize(motion, equilibrium(motion, test.at), ins, outs)
        linear = with_motors(linear, held_in(test, motion.motor_names), gains_in(test, values))
        gone = [name for name in (*ins, *outs) if name not in (*linear.inputs, *linear.outputs)]
        if gone:
            what = f"{gone[0]} is of a motor that this test holds, so nothing moves there: change hold or the signals"
            raise InputError(motion.source, test.name, what)
        return linear

    def _feedbacks_of(self, test: VibrationTest) -> list[Feedback]:
        """Return the control loops of the drives that a test switches on; raises `InputError` for a missing drive."""
        for name in test.drives:
            if name not in self._feedbacks:
                what = f"{name} has none{did_you_mean(name, self._feedbacks)}"
                raise InputError(test.name, "drives", what)
        return [self._feedbacks[name] for name in test.drives]

    def doubts_at(self, x: Array) -> list[str]:
        """Return lines on omitted parts of the machine: backlash, bristles of friction, drives that are on."""
        values, motion = self._at_values(x)
        lines: dict[str, list[str]] = {}
        driven = drives_of(self.sought.machine).by_motor
        for test in self.tests:
            excluded = {*test.pd, *test.drives, *held_in(test, motion.motor_names)}
            free = [name for name in driven if name not in excluded]
            way_out = "hold their motors, or give drives or pd, where they were on"
            off = f"the drives of {', '.join(free)} are off: {way_out}"
            said = [*([off] if free else []), *omitted_limits(loop.cascade for loop in self._feedbacks_of(test))]
            for line in (*self.linear_at(motion, test, values).doubts, *said):
                lines.setdefault(line, []).append(test.name)
        return [f"{', '.join(names)}: {line}" for line, names in lines.items()]

    def _of(self, linear: Linearization, test: VibrationTest, values: Mapping[str, float], slopes: bool) -> Predicted:
        changed = self._slopes(linear, test, values) if slopes else _without_slopes(linear)
        responses: dict[int, PredictedResponse] = {}
        for group in _groups(test.responses):
            f = test.responses[group[0]].f
            window = windowed_lines(test.window, f)
            G, dG = closed_response_slopes(changed, f if window is None else window.f, self._feedbacks_of(test))
            for k in group:
                o = linear.outputs.index(test.responses[k].output)
                i = linear.inputs.index(test.responses[k].input)
                both = G[:, o, i], dG[:, :, o, i]
                responses[k] = PredictedResponse(*(both if window is None else map(window.weighted_sum, both)))
        modes = None if test.modes is None else _modes_of(changed, test.modes, self.pairs_all)
        return Predicted(tuple(responses[k] for k in range(len(responses))), modes)

    def _slopes(self, linear: Linearization, test: VibrationTest, values: Mapping[str, float]) -> LinearSlopes:
        """Return slopes of the linearization by all unknowns (p + w): logarithms of parameters and of unknown gains."""
        slopes = linear_slopes(linear, self.parameters)
        n, motion = len(linear.kept), linear.motion
        names = (*self.sought.labels, *map(str, self.windowed))
        place = {label: k for k, label in enumerate(self.sought.labels)}
        rows, size = [place[name] for name in slopes.names], np.array([values[name] for name in slopes.names])
        totals = {}
        for name, axis in (("M", 0), ("D", 0), ("K", 0), ("F", 0), ("C", 1), ("motors", 0)):
            total = np.moveaxis(getattr(slopes, name), axis, 0)
            spread = np.zeros((len(names), *total.shape[1:]))
            spread[rows] = total * size.reshape(-1, *[1] * (total.ndim - 1))
            totals[name] = np.moveaxis(spread, 0, axis)
        for motor in (name for name, given in test.pd.items() if given is None):
            row = linear.motors[motion.motor(motor, "pd")]
            for gain, matrix in ((KP, "K"), (KD, "D")):
                label = gain_label(motor, gain)
                totals[matrix][place[label]] = values[label] * np.outer(row, row).reshape(n, n)
        return LinearSlopes(linear, names, **totals)


def _with_change(test: VibrationTest, name: int | str, c: float) -> VibrationTest:
    """Return a test with a changed window, or with a changed zero of the joint `name`."""
    if isinstance(name, str):
        return test.with_zero(name, c)
    return test if test.window is None else replace(test, window=test.window.changed(c))


def _without_slopes(linear: Linearization) -> LinearSlopes:
    n, i, o = len(linear.kept), len(linear.inputs), len(linear.outputs)
    none = np.zeros((0, n, n))
    rows = (np.zeros((0, n, i)), np.zeros((3, 0, o, n)), np.zeros((0, len(linear.motors), n)))
    return LinearSlopes(linear, (), none, none, none, *rows)


def _outputs(test: VibrationTest) -> list[str]:
    return [*(response.output for response in test.responses), *(test.modes.outputs if test.modes else ())]


def _groups(responses: Sequence[MeasuredResponse]) -> list[list[int]]:
    """Return groups of the indices of responses that have the same frequencies."""
    groups: list[list[int]] = []
    for k, one in enumerate(responses):
        same = [group for group in groups if np.array_equal(responses[group[0]].f, one.f)]
        if same:
            same[0].append(k)
        else:
            groups.append([k])
    return groups


@dataclass(frozen=True)
class Oscillations:
    """Poles (m) of oscillating motions, rad/s, and their amplitudes (m, outputs) at outputs by name."""

    poles: ComplexArray
    amplitudes: ComplexArray
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class Pairs:
    """Pairs of measured modes (`rows`) and poles (`columns`), their MAC (1 where no shape was measured), and whether
    no other pole matches as well, (pairs,) each."""

    rows: IndexArray
    columns: IndexArray
    mac: Array
    sure: BoolArray


def oscillations_of(linear: Linearization) -> Oscillations:
    """Return the oscillating modes of a linearization: poles with their amplitudes at the outputs."""
    poles, vectors = damped_poles(linear)
    places = np.flatnonzero(poles.imag > 1e-6 * np.abs(poles))
    poles, vectors = poles[places], vectors[:, places]
    own = linear.Cq @ vectors + poles * (linear.Cv @ vectors) + poles**2 * (linear.Ca @ vectors)
    return Oscillations(poles, own.T, tuple(linear.outputs))


def pairs_of_modes(measured: MeasuredModes, own: Oscillations) -> Pairs:
    """Return pairs of measured modes and poles, assigned by shape and frequency."""
    apart = np.abs(np.log(np.abs(own.poles) / (2 * np.pi * measured.f[:, None])))
    cost, mac = apart, np.ones_like(apart)
    if measured.shapes is not None:
        places = [own.outputs.index(name) for name in measured.outputs]
        mac = _mac(measured.shapes, own.amplitudes[:, places])
        cost = apart - mac
    rows, columns = for_vibrations("scipy.optimize").linear_sum_assignment(cost)
    alone = len(own.poles) < 2
    nearest = np.sort(mac - apart, axis=1)[rows][:, -2:] if not alone else np.array([[-np.inf, 0.0]] * len(rows))
    sure = (mac[rows, columns] >= LEAST_MAC) & ((nearest[:, 1] - nearest[:, 0] > RIVALS) | (measured.shapes is None))
    return Pairs(rows, columns, mac[rows, columns], sure)


def _modes_of(slopes: LinearSlopes, measured: MeasuredModes, every: bool) -> PredictedModes:
    """Return the predicted modes that match measured ones; uncertain pairs only if `every` counts."""
    own = oscillations_of(slopes.linear)
    pairs = pairs_of_modes(measured, own)
    rows, chosen, sure = pairs.rows, own.poles[pairs.columns], pairs.sure | every
    size, zeta = np.abs(chosen) / (2 * np.pi), -chosen.real / np.abs(chosen)
    by_f, by_zeta = ratio_slopes(chosen, pole_slopes(slopes, chosen))
    k, p = len(measured.f), len(slopes.names)
    modes = PredictedModes(np.full(k, np.nan), np.full(k, np.nan), np.zeros((p, k)), np.zeros((p, k)))
    for one, values in ((modes.f, size), (modes.zeta, zeta)):
        one[rows[sure]] = values[sure]
    modes.slopes_f[:, rows[sure]], modes.slopes_zeta[:, rows[sure]] = by_f[:, sure], by_zeta[:, sure]
    return modes


def _mac(measured: ComplexArray, shapes: ComplexArray) -> Array:
    """Return |a^H b|^2 / (a^H a b^H b) of shapes (k, outputs) and (m, outputs), (k, m)."""
    cross = np.abs(measured.conj() @ shapes.T) ** 2
    sizes = np.sum(np.abs(measured) ** 2, axis=1)[:, None] * np.sum(np.abs(shapes) ** 2, axis=1)
    mac: Array = np.divide(cross, sizes, out=np.zeros_like(cross), where=sizes > 0)
    return mac
