"""The next best test: of hammer blows and motor sweeps, the one after which the sought parameters are known best.

A_c = J^T J of a candidate at the present estimate, with the noise seen so far; what counts is the fall of the trace of
the covariance of ln p of the sought (A-optimal).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import limits_of
from symoro_elastic.machine.machine import Kind
from symoro_elastic.measured.vibration_tests.measured import MeasuredResponse, VibrationTest
from symoro_elastic.measured.vibration_tests.misfit import GUESS, Fit
from symoro_elastic.measured.vibration_tests.predictions import Lines, Predictions

FRACTIONS = (-0.8, 0.0, 0.8)  # places of a motor within its limits, from the middle to an end
MOST_PLACES = 9
LINES = 100  # of a candidate; its information counts as that of as many lines as tests have
LEAST_FALL = 0.01
"""Least fraction by which a test lowers the sum of variances; by which it lowers a variance that it determines."""


@dataclass(frozen=True)
class Candidate:
    """A possible next test, the fall of the sum of variances with it, and the parameters that it improves most."""

    test: VibrationTest
    fall: float
    tells: tuple[str, ...]

    @property
    def what(self) -> str:
        """The test in words."""
        at = ", ".join(f"{name} at {x:.4g}" for name, x in self.test.at.items())
        hold = f", hold {', '.join(self.test.hold)}" if self.test.hold else ""
        hold += f", drives of {', '.join(self.test.drives)}" if self.test.drives else ""
        outs = ", ".join(response.output for response in self.test.responses)
        return f"input {self.test.responses[0].input}, outputs {outs}{f', {at}' if at else ''}{hold}"


def next_tests(predictions: Predictions, lines: Sequence[Lines], fit: Fit, count: int = 5) -> list[Candidate]:
    """Return the best candidates, the best one first, by the variances that candidates can lower."""
    sought = predictions.sought
    reported = [k for k, entry in enumerate(sought.unknowns) if not entry.is_nuisance]
    before = np.diag(fit.covariance)[reported]
    present = np.linalg.inv(fit.covariance)
    shares = [line.sd / np.hypot(np.abs(line.H), np.median(np.abs(line.H))) for line in lines]
    noise = float(np.median(np.concatenate(shares))) if lines else GUESS
    candidates = _candidates(predictions, lines)
    of_candidates = Predictions(sought, candidates)
    outcomes: list[tuple[VibrationTest, Array]] = []
    advised: list[Candidate] = []
    per = np.median([line.counted.sum() for line in lines]) / LINES if lines else 1.0
    for test in candidates:
        try:
            information = per * information_of(of_candidates, fit.x, test, noise) / np.fmax(fit.chi2, 1.0)
        except (InputError, np.linalg.LinAlgError):
            continue
        outcomes.append((test, np.diag(np.linalg.inv(present + information))[reported]))
    least = np.min([before, *(after for _, after in outcomes)], axis=0)
    determines = before > least / (1 - LEAST_FALL)
    for test, after in outcomes if determines.any() else ():
        order = np.argsort(after - before)[:3]
        tells = tuple(sought.labels[reported[k]] for k in order if after[k] < 0.7 * before[k])
        advised.append(Candidate(test, float(1 - after[determines].sum() / before[determines].sum()), tells))
    best: dict[object, Candidate] = {}
    for entry in sorted(advised, key=lambda entry: -entry.fall):
        best.setdefault((entry.test.responses[0].input, *_setting(entry.test)), entry)
    return [entry for entry in best.values() if entry.fall > LEAST_FALL][:count]


def information_of(predictions: Predictions, x: Array, test: VibrationTest, noise: float) -> Array:
    """Return J^T J (p, p) of a test without data, whose noise is this share of |G| and of its median."""
    (predicted,) = predictions.at(x, True, [test])
    total = np.zeros((len(x), len(x)))
    for response in predicted.responses:
        if not np.isfinite(response.slopes).all():
            continue
        size = np.abs(response.G)
        sd = noise * np.hypot(size, np.median(size))
        J = response.slopes / np.where(sd > 0, sd, np.inf)
        total += (J @ J.conj().T).real
    return total


def _candidates(predictions: Predictions, lines: Sequence[Lines]) -> list[VibrationTest]:
    """Return candidate tests within the limits: impacts at bodies, and sweeps of motors."""
    motion, tests = predictions.motion, predictions.tests
    lows = min((float(line.f[0]) for line in lines), default=1.0)
    highs = max((float(line.f[-1]) for line in lines), default=1000.0)
    f, nothing = np.geomspace(lows, highs, LINES), np.ones(LINES, dtype=complex)
    outputs_so_far = dict.fromkeys(response.output for test in tests for response in test.responses)
    of_frames = [x for x in outputs_so_far if "at (" not in x and x.rpartition(".")[0] not in motion.motor_names]
    free = [name for name in motion.motor_names if not any(held in ("all", name) for t in tests for held in t.hold)]
    machine = motion.given
    bodies = [j for j in machine.joints if not j.body.mass.is_zero and j.kind is not Kind.CUT]
    ends = [joint.name for joint in bodies] + [joint.name for joint in machine.joints if joint.sigma == 2][-1:]
    tests_to_make: list[VibrationTest] = []

    def add(like: VibrationTest, at: dict[str, float], source: str, outs: Sequence[str]) -> None:
        responses = tuple(MeasuredResponse(name, source, f, nothing) for name in dict.fromkeys(outs))
        name = f"candidate {len(tests_to_make) + 1}"
        tests_to_make.append(VibrationTest(name, at, like.hold, like.pd, responses=responses, drives=like.drives))

    settings = list({_setting(test): test for test in tests}.values())
    for at in _places(predictions):
        for test in settings:
            for name, axis in itertools.product(dict.fromkeys(ends), "xyz"):
                add(test, at, f"{name}.f{axis}", [f"{name}.a{axis}", *of_frames])
        for motor in free or motion.motor_names:
            add(VibrationTest("free", at), at, f"{motor}.tau", [f"{motor}.qdd", *of_frames])
    return tests_to_make


def _setting(test: VibrationTest) -> tuple[object, ...]:
    """Return a key of the motors that a test locks or controls."""
    return test.hold, tuple(sorted(test.pd.items())), test.drives


def _places(predictions: Predictions) -> list[dict[str, float]]:
    """Return positions of motors: those of the tests, and some within the limits of the machine."""
    limits, axes = limits_of(predictions.sought.machine), {}
    for name in predictions.motion.motor_names:
        allowed = limits.of(name).position
        if allowed:
            middle, half = (allowed.low + allowed.high) / 2, (allowed.high - allowed.low) / 2
            axes[name] = [middle + share * half for share in FRACTIONS]
    grid = [dict(zip(axes, x, strict=True)) for x in itertools.product(*axes.values())] if axes else []
    every = [*(dict(test.at) for test in predictions.tests), *grid[:: -(-len(grid) // MOST_PLACES) or 1]]
    return list({tuple(sorted(at.items())): at for at in every}.values())
