"""The next best test: of hammer blows and motor sweeps, the one after which the sought parameters are known best.

A_c = J^T J of a candidate at the present estimate, with the noise seen so far; what counts is the fall of the trace of
the covariance of ln p of the sought (A-optimal).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.updating.measured import MeasuredResponse, VibrationTest
from symoro_elastic.analysis.updating.misfit import Fit, Lines
from symoro_elastic.analysis.updating.predictions import Predictions
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import limits_of
from symoro_elastic.machine.machine import Kind

FRACTIONS = (-0.8, 0.0, 0.8)
"""Places of a motor within its limits, from the middle to an end."""
MOST_PLACES = 9
LINES = 100
"""Of a candidate; its information counts as that of as many lines as tests have."""
LEAST_FALL = 0.01
"""Of the sum of variances: a test that lowers it less is none; of one variance: less tells nothing."""
FLOOR = 0.01
"""Of the median of a response: noise where it is small, as in the tests so far."""


@dataclass(frozen=True)
class Candidate:
    """A test that may come next, how much the sum of variances falls with it, and the parameters that it tells most."""

    test: VibrationTest
    fall: float
    tells: tuple[str, ...]

    @property
    def what(self) -> str:
        """The test in words."""
        at = ", ".join(f"{name} at {x:.4g}" for name, x in self.test.at.items())
        held = f", hold {', '.join(self.test.hold)}" if self.test.hold else ""
        held += f", drives of {', '.join(self.test.drives)}" if self.test.drives else ""
        outs = ", ".join(one.output for one in self.test.responses)
        return f"input {self.test.responses[0].input}, outputs {outs}{f', {at}' if at else ''}{held}"


def next_tests(predictions: Predictions, lines: Sequence[Lines], fit: Fit, count: int = 5) -> list[Candidate]:
    """Return the best candidates, the best one first; what no candidate tells does not count."""
    sought = predictions.sought
    kept = [k for k, one in enumerate(sought.unknowns) if not one.is_nuisance]
    before = np.diag(fit.covariance)[kept]
    present = fit.information + np.diag(sought.prior)
    shares = [line.sd / np.hypot(np.abs(line.H), np.median(np.abs(line.H))) for line in lines]
    noise = float(np.median(np.concatenate(shares))) if lines else FLOOR
    candidates = _candidates(predictions, lines)
    asked = Predictions(sought, candidates)
    x = fit.x
    each: list[tuple[VibrationTest, Array]] = []
    found: list[Candidate] = []
    per = np.median([line.counted.sum() for line in lines]) / LINES if lines else 1.0
    for test in candidates:
        try:
            information = per * information_of(asked, x, test, noise) / max(fit.chi2 if fit.chi2 > 1 else 1.0, 1.0)
        except (InputError, np.linalg.LinAlgError):
            continue
        after = np.diag(np.linalg.inv(present + information))[kept]
        each.append((test, after))
    told = before > np.min([after for _, after in each], axis=0) / (1 - LEAST_FALL) if each else before > 0
    for test, after in each if told.any() else ():
        order = np.argsort(after - before)[:3]
        tells = tuple(sought.labels[kept[k]] for k in order if after[k] < 0.7 * before[k])
        found.append(Candidate(test, float(1 - after[told].sum() / before[told].sum()), tells))
    best: dict[object, Candidate] = {}
    for one in sorted(found, key=lambda one: -one.fall):
        best.setdefault((one.test.responses[0].input, *_setting(one.test)), one)
    return [one for one in best.values() if one.fall > LEAST_FALL][:count]


def information_of(predictions: Predictions, x: Array, test: VibrationTest, noise: float) -> Array:
    """Return J^T J (p, p) of a test without data, whose noise is this share of |G| and of its median."""
    (predicted,) = predictions.at(x, True, [test])
    total = np.zeros((len(x), len(x)))
    for one in predicted.responses:
        if one.slopes is None or not np.isfinite(one.slopes).all():
            continue
        size = np.abs(one.G)
        sd = noise * np.hypot(size, np.median(size))
        J = one.slopes / np.where(sd > 0, sd, np.inf)
        total += (J @ J.conj().T).real
    return total


def _candidates(predictions: Predictions, lines: Sequence[Lines]) -> list[VibrationTest]:
    """Return tests at places within the limits: blows at bodies, measured there and where tests did, and sweeps."""
    motion, tests = predictions.motion, predictions.tests
    lows = min((float(line.f[0]) for line in lines), default=1.0)
    highs = max((float(line.f[-1]) for line in lines), default=1000.0)
    f, nothing = np.geomspace(lows, highs, LINES), np.ones(LINES, dtype=complex)
    known = list(dict.fromkeys(one.output for test in tests for one in test.responses if "at (" not in one.output))
    of_frames = [name for name in known if name.rpartition(".")[0] not in motion.motor_names]
    free = [name for name in motion.motor_names if not any(held in ("all", name) for t in tests for held in t.hold)]
    machine = motion.given
    bodies = [j for j in machine.joints if not j.body.mass.is_zero and j.kind is not Kind.CUT]
    ends = [joint.name for joint in bodies] + [joint.name for joint in machine.joints if joint.sigma == 2][-1:]
    found: list[VibrationTest] = []

    def add(like: VibrationTest, at: dict[str, float], source: str, outs: Sequence[str]) -> None:
        responses = tuple(MeasuredResponse(name, source, f, nothing) for name in dict.fromkeys(outs))
        name = f"candidate {len(found) + 1}"
        found.append(VibrationTest(name, at, like.hold, like.pd, responses=responses, drives=like.drives))

    settings = list({_setting(test): test for test in tests}.values())
    for at in _places(predictions):
        for test in settings:
            for name, axis in itertools.product(dict.fromkeys(ends), "xyz"):
                add(test, at, f"{name}.f{axis}", [f"{name}.a{axis}", *of_frames])
        for motor in free or motion.motor_names:
            add(VibrationTest("free", at), at, f"{motor}.tau", [f"{motor}.qdd", *of_frames])
    return found


def _setting(test: VibrationTest) -> tuple[object, ...]:
    """Return what drives or holds motors in a test."""
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
