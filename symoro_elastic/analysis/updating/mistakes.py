"""What is wrong with files whose responses the model cannot explain: each usual mistake is undone and tried.

A mistake of one pair is seen beside the others, at the values that these tell. A mistake of all of them needs a fit
of its own: where it leaves no more than noise, the files are refused with its name.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from symoro_elastic.analysis.updating.doubts import scaled_pairs
from symoro_elastic.analysis.updating.estimator import Estimator, is_far
from symoro_elastic.analysis.updating.measured import MeasuredResponse, VibrationTest
from symoro_elastic.analysis.updating.misfit import Fit, Lines
from symoro_elastic.analysis.updating.predictions import Predicted
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError

Undone = Callable[[ComplexArray, ComplexArray], ComplexArray]
"""A right response from a wrong one H and s = 2 pi i f."""
ALL: dict[str, Undone] = {
    "with the opposite sign": lambda H, s: -H,
    "with imaginary parts of the opposite sign": lambda H, s: H.conj(),
    "with real and imaginary parts exchanged": lambda H, s: 1j * H.conj(),
    "in g, not in m/s2": lambda H, s: 9.80665 * H,
    "in m/s2, not in g": lambda H, s: H / 9.80665,
    "in mm, not in m, or in N, not in kN": lambda H, s: 1e-3 * H,
    "in m, not in mm, or in kN, not in N": lambda H, s: 1e3 * H,
    "as velocities, not accelerations, or displacements, not velocities": lambda H, s: s * H,
    "as displacements, not accelerations": lambda H, s: s**2 * H,
    "as accelerations, not velocities, or velocities, not displacements": lambda H, s: H / s,
    "as accelerations, not displacements": lambda H, s: H / s**2,
    "as inputs over outputs": lambda H, s: 1 / H,
}
"""How a response may be written, and how that is undone."""
RADIANS = "over frequencies in rad/s, not in Hz"
FAR_OFF, VANISHED = math.log(300.0), math.log(3e6)
"""Logarithms of factors: above the first no fit is tried, by the second a response is zero."""
APART, NEARER, LEFT = 10.0, 0.8, 0.2
"""Mean square of a pair over the median of the others; shares of a distance that a mistake leaves, first and fitted."""


def refuse_far(tests: Sequence[VibrationTest], lines: Sequence[Lines], predicted: Sequence[Predicted]) -> None:
    """Raise `InputError` for pairs whose size is none that springs near those of the start can have."""
    for line, factor in scaled_pairs(lines, predicted):
        if abs(math.log(factor)) < FAR_OFF:
            continue
        logs = np.log(predicted[line.test].responses[line.place].G[line.counted] / line.H)
        mistake = _named(line, logs)
        what = f"is {factor:.3g} times the model over its whole band{mistake}"
        if math.log(factor) < -VANISHED and not mistake:
            what = "hardly moves, and its model does: another axis, body or input is measured, or nothing"
        raise InputError(tests[line.test].name, line.measured.pair, what)


def refuse_mistakes(estimator: Estimator, tests: Sequence[VibrationTest], fit: Fit) -> None:
    """Raise `InputError` where one mistake in all responses explains what the model does not at a minimum.

    Tried are those that bring responses nearer to the start.
    """
    for line in estimator.lines:
        H = line.H
        if not H.imag.any() and ((H.real > 0).all() or (H.real < 0).all()):
            what = (
                "has no imaginary part in any line, and the model does not explain it: head magnitudes mag, with phase"
            )
            raise InputError(tests[line.test].name, line.measured.pair, what)
    for what, others in _undone(tests).items():
        if estimator.nearer(others) < NEARER:
            other = estimator.quickly(others)
            if other is not None and not is_far(other) and other.distance < LEFT * fit.distance:
                of = f"are written {what}: only so does the model explain them; correct the files"
                raise InputError(", ".join(dict.fromkeys(test.name for test in tests)), "responses", of)


def _undone(tests: Sequence[VibrationTest]) -> dict[str, list[VibrationTest]]:
    """Return the tests without each mistake."""
    found = {what: _each(tests, partial(_written, of)) for what, of in ALL.items()}
    found[RADIANS] = _each(tests, lambda one: replace(one, f=one.f / (2 * math.pi)))
    responses = [one for test in tests for one in test.responses]
    for names in ({one.output: None for one in responses}, {one.input: None for one in responses}):
        for a, b in itertools.combinations(names, 2):
            if a[:-1] == b[:-1]:
                found[f"with {a} and {b} exchanged"] = [_exchanged(test, {a: b, b: a}) for test in tests]
    return found


def _exchanged(test: VibrationTest, names: Mapping[str, str]) -> VibrationTest:
    """Return a test whose signals of these names are exchanged; pairs that have no partner stay."""
    by_pair = {(one.output, one.input): one for one in test.responses}
    found = []
    for one in test.responses:
        other = by_pair.get((names.get(one.output, one.output), names.get(one.input, one.input)))
        if other is not None and other is not one and np.array_equal(other.f, one.f):
            found.append(replace(one, H=other.H, coherence=other.coherence))
        else:
            found.append(one)
    return replace(test, responses=tuple(found))


def of_pairs(tests: Sequence[VibrationTest], fit: Fit, predicted: Sequence[Predicted]) -> list[str]:
    """Return a line for each pair that does not go with the others, with its mistake if that is a usual one."""
    if len(fit.lines) < 2 or not (math.isnan(fit.chi2) or fit.chi2 > fit.far):
        return []
    logs = [np.log(predicted[line.test].responses[line.place].G[line.counted] / line.H) for line in fit.lines]
    sizes = [
        float(np.median(np.abs(one * np.abs(line.H) / line.sd))) ** 2 for one, line in zip(logs, fit.lines, strict=True)
    ]
    found = []
    for k, line in enumerate(fit.lines):
        others = float(np.median(sizes[:k] + sizes[k + 1 :]))
        if sizes[k] > APART * max(others, 1.0):
            name = f"{tests[line.test].name}: {line.measured.pair}"
            found.append(f"{name} does not go with the other responses{_why(line, logs[k])}")
    return found


def _why(line: Lines, logs: ComplexArray) -> str:
    """Return the mistake that brings a pair near the model, or what to look at."""
    times = float(np.median(np.exp(-logs.real)))
    return (
        _named(line, logs)
        or f", and is {times:.3g} times the model in the median: check its columns, unit, place and direction"
    )


def _named(line: Lines, logs: ComplexArray) -> str:
    """Return the mistake that brings a pair near the model, nothing if none does."""
    G, s = line.H * np.exp(logs), _s(line.f)
    left = {what: float(np.median(np.abs(np.log(G / of(line.H, s))))) for what, of in ALL.items()}
    best = min(left, key=left.__getitem__)
    return f": it is written {best}" if left[best] < LEFT * float(np.median(np.abs(logs))) else ""


def _each(tests: Sequence[VibrationTest], of: Callable[[MeasuredResponse], MeasuredResponse]) -> list[VibrationTest]:
    return [replace(test, responses=tuple(map(of, test.responses))) for test in tests]


def _written(of: Undone, one: MeasuredResponse) -> MeasuredResponse:
    return replace(one, H=of(one.H, _s(one.f)))


def _s(f: Array) -> ComplexArray:
    return np.asarray(2j * math.pi * f, dtype=complex)
