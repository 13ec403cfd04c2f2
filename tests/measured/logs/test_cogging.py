"""Cogging by its cosine and sine at a known order: found, saved, and standard deviations on unseen draws."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError

AMPLITUDE, ORDER, PHASE = 12.0, 200.0, 0.7
TRUTH = {"CC1": AMPLITUDE * np.sin(PHASE), "CS1": AMPLITUDE * np.cos(PHASE), "M1": 40.0, "FV1": 60.0, "FS1": 15.0}
AXIS: dict[str, Any] = {
    "name": "axis",
    "gravity": [0, 0, 0],
    "joints": [{"name": "slide", "kind": "motor", "sigma": 1, "r": "x"}],
    "bodies": {"slide": {"mass": 40}},
    "friction": {"slide": {"viscous": 60, "coulomb": 15}},
}
COGGING = {"motors": {"slide": {"cogging": 5, "cogging_order": ORDER, "cogging_phase": 0.1}}}


def record(seed: int, noise: float = 4.0) -> dict[str, Any]:
    """A periodic motion of random phases, and forces by the equations of this page with white noise."""
    source, t = np.random.default_rng(seed), np.arange(0, 4, 1e-3)
    x, v, a = np.zeros((3, len(t)))
    for k in range(1, 5):
        w, size, phase = np.pi * k, source.uniform(0.02, 0.08) / k, source.uniform(0, 2 * np.pi)
        x, v = x + size * np.sin(w * t + phase), v + size * w * np.cos(w * t + phase)
        a = a - size * w**2 * np.sin(w * t + phase)
    force = 40 * a + 60 * v + 15 * np.sign(v) - AMPLITUDE * np.sin(ORDER * x + PHASE)
    return {"t": t, "q_slide": x, "tau_slide": force + noise * source.normal(size=len(t))}


def found(machine: dict[str, Any], seed: int, **options: Any) -> Any:
    noise = options.pop("noise", 4.0)
    return se.identify(se.read(machine, warn=lambda _: None), record(seed, noise), bandwidth=40, **options)


@pytest.mark.thorough
def test_cogging_of_the_file_is_sought_and_saved() -> None:
    result = found(AXIS | COGGING, 1, noise=0.01)
    values = {e.unknown.label: e.value for e in result.found.estimates}
    assert values == {name: pytest.approx(x, rel=2e-2) for name, x in TRUTH.items()} | {
        name: x for name, x in values.items() if name not in TRUTH
    }
    assert any(line.startswith("cogging: residuals") for line in result.found.notes)
    (joint,) = result.saved()[0].joints
    law = [x.value() for x in (joint.cogging.amplitude, joint.cogging.order, joint.cogging.phase)]
    assert law == pytest.approx([AMPLITUDE, ORDER, PHASE], rel=2e-2)
    again = se.load(result.saved()[0])
    assert np.abs(again.inverse_dynamics([0.3], [0.0], [0.0])[0]) > 0


@pytest.mark.thorough
def test_cogging_is_sought_of_an_axis_behind_a_ratio() -> None:
    """The order is that of the rotor: 100 in a turn behind a ratio of 2 rad/m."""
    geared = AXIS | {"motors": {"slide": {"rotor_inertia": 1e-9, "ratio": 2}}}
    values = {e.unknown.label: e.value for e in found(geared, 2, noise=0.01, cogging={"slide": 100}).found.estimates}
    assert [values["CC1"], values["CS1"]] == pytest.approx([TRUTH["CC1"], TRUTH["CS1"]], rel=2e-2)
    assert "CC1" not in {e.unknown.label for e in found(geared, 2).found.estimates}
    with pytest.raises(InputError, match="cogging: slide=-3: give periods per turn"):
        found(geared, 2, cogging={"slide": -3.0})
    with pytest.raises(InputError, match="cogging"):
        found(geared, 2, cogging={"slid": 3.0})


@pytest.mark.thorough
def test_standard_deviations_hold_on_unseen_draws() -> None:
    """Errors over standard deviations of 20 draws: mean square within the 1e-4 quantiles of chi squared."""
    errors = []
    for seed in range(100, 120):
        estimates = {e.unknown.label: e for e in found(AXIS | COGGING, seed).found.estimates}
        errors.append([(estimates[name].value - x) / estimates[name].std for name, x in TRUTH.items()])
    squares = np.square(errors).mean(axis=0)
    assert ((squares > 0.25) & (squares < 2.63)).all(), squares
