"""Mistakes in responses are named, refused or harmless, whatever the damping and the initial values; right data pass.

Two carts between three springs; responses by the inverse of their dynamic stiffness, of numpy alone.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.measured.vibration_tests.listed_tests import WRITTEN
from symoro_elastic.measured.vibration_tests.measured import MeasuredResponse, VibrationTest
from tests.references.vibrating_tables import with_labels

MASSES, STIFFNESSES = (30.0, 12.0), (4e5, 2.5e5)
F = np.geomspace(4.0, 60.0, 120)
NOISE, AVERAGES = 0.01, 20
OFTEN = 4.0
"""Standard deviations within which right estimates are."""


def carts(ratio: float) -> tuple[dict[str, Any], dict[str, float]]:
    """Two carts in a row, and the parameters that are sought."""
    joints = [
        {"name": name, "kind": "elastic", "sigma": 1, "antecedent": before, "r": variable}
        for name, before, variable in (("first", 0, "a"), ("second", "first", "b"))
    ]
    springs = {
        name: {"stiffness": k, "damping": 2 * ratio * math.sqrt(k * m)}
        for name, k, m in zip(("first", "second"), STIFFNESSES, MASSES, strict=True)
    }
    bodies = {name: {"mass": m} for name, m in zip(("first", "second"), MASSES, strict=True)}
    truth = {f"{name}.{what}": x for name, spring in springs.items() for what, x in spring.items()}
    return {"name": "carts", "gravity": [0, 0, 0], "joints": joints, "springs": springs, "bodies": bodies}, truth


def exact(truth: dict[str, float]) -> np.ndarray:
    """Accelerations (N, output, input) of both carts by forces on both."""
    k, d = (np.array([truth[f"{name}.{what}"] for name in ("first", "second")]) for what in ("stiffness", "damping"))
    between = np.array([[1.0, 0.0], [-1.0, 1.0]])  # elongations of the springs
    s = 2j * np.pi * F[:, None, None]
    Z = s**2 * np.diag(MASSES) + s * (between.T * d) @ between + (between.T * k) @ between
    return s**2 * np.linalg.inv(Z)


def hammer(truth: dict[str, float], seed: int, has_coherence: bool) -> VibrationTest:
    rng, G, responses = np.random.default_rng(seed), exact(truth), []
    for out, name in enumerate(("first", "second")):
        H = G[:, out, 1]
        sd = NOISE * np.hypot(np.abs(H), np.median(np.abs(H))) / math.sqrt(2)
        measured = H + sd * (rng.normal(size=len(F)) + 1j * rng.normal(size=len(F)))
        coherence = 1 / (1 + 2 * (AVERAGES - 1) * (sd / np.abs(measured)) ** 2) if has_coherence else None
        responses.append(MeasuredResponse(f"{name}.az", "second.fz", F, measured, coherence))
    return VibrationTest("hammer", {}, averages=AVERAGES, responses=tuple(responses))


def start(tables: dict[str, Any], truth: dict[str, float], seed: int) -> dict[str, Any]:
    rng = np.random.default_rng([seed, 7])
    return with_labels(tables, {label: x * 2 ** rng.uniform(-1, 1) for label, x in truth.items()})


def laplace() -> np.ndarray:
    return np.asarray(2j * np.pi * F)


def outcome(tables: dict[str, Any], test: VibrationTest, truth: dict[str, float]) -> str:
    """`refused` with the reason, `said` where the model is said to be wrong, `right`, or `wrong in silence`."""
    try:
        updated = se.update(tables, tests=[test])
    except se.InputError as error:
        return f"refused: {error}"
    off = [
        abs(math.log(estimate.value / truth[estimate.unknown.label])) > OFTEN * estimate.relative
        for estimate in updated.estimates
        if estimate.verdict == "identified"
    ]
    if not any(off):
        return "right"
    lacks = updated.fit.chi2 > updated.fit.far or any("does not go with" in note for note in updated.notes)
    return "said" if lacks else f"wrong in silence: {updated}"


def cases(seeds: int, ratios: tuple[float, ...]) -> list[tuple[str, float, bool, int]]:
    return [
        (what, ratio, has_coherence, seed)
        for what in WRITTEN
        for ratio in ratios
        for has_coherence in (True, False)
        for seed in range(seeds)
    ]


@pytest.mark.sampled(36)
@pytest.mark.parametrize(("what", "ratio", "has_coherence", "seed"), cases(2, (0.002, 0.01, 0.05)))
def test_a_mistake_in_all_responses_is_named_refused_or_harmless(
    what: str, ratio: float, has_coherence: bool, seed: int
) -> None:
    """Whether or not the noise is known: `WRITTEN` undoes a mistake, so its inverse makes it."""
    tables, truth = carts(ratio)
    test = hammer(truth, seed, has_coherence)
    wrong = [replace(r, H=inverse(what, r.H)) for r in test.responses]
    result = outcome(start(tables, truth, seed), replace(test, responses=tuple(wrong)), truth)
    assert not result.startswith("wrong"), result


def inverse(what: str, H: np.ndarray) -> np.ndarray:
    """The mistake that a row of `WRITTEN` undoes."""
    ones, s = np.ones_like(H), laplace()
    if "imaginary" in what and "exchanged" in what:
        return 1j * H.conj()
    if "imaginary" in what:
        return H.conj()
    if "inputs over outputs" in what:
        return 1 / H
    return H / WRITTEN[what](ones, s)


@pytest.mark.thorough
def test_conjugated_responses_are_named_at_any_damping() -> None:
    """As of a cross spectrum that was taken in the wrong order, with and without coherence."""
    for ratio in (0.002, 0.01, 0.025):
        for has_coherence in (True, False):
            tables, truth = carts(ratio)
            test = hammer(truth, 0, has_coherence)
            wrong = tuple(replace(r, H=r.H.conj()) for r in test.responses)
            with pytest.raises(se.InputError, match="with imaginary parts of the opposite sign"):
                se.update(start(tables, truth, 1), tests=[replace(test, responses=wrong)])


def test_responses_without_imaginary_parts_are_refused_where_damping_shows() -> None:
    tables, truth = carts(0.01)
    test = hammer(truth, 0, False)
    real = replace(test, responses=tuple(replace(r, H=r.H.real + 0j) for r in test.responses))
    with pytest.raises(se.InputError, match=r"first\.az/second\.fz: has no imaginary part at any frequency"):
        se.update(start(tables, truth, 0), tests=[real])


@pytest.mark.sampled(20)
@pytest.mark.parametrize("seed", range(100))
@pytest.mark.parametrize("has_coherence", [True, False])
def test_right_responses_are_not_accused(seed: int, has_coherence: bool) -> None:
    tables, truth = carts(float(np.geomspace(0.002, 0.05, 100)[seed]))
    assert outcome(start(tables, truth, seed), hammer(truth, seed, has_coherence), truth) == "right"
