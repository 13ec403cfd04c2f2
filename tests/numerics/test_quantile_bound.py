"""Bounds on errors that are not drawn yet: their promise is kept, on tails of every weight and on a machine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.precision import SINGLE
from symoro_elastic.formats import read_machine
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.arrays import evaluate_arrays
from symoro_elastic.numerics.evaluation.quantile_bound import (
    CONFIDENCE,
    FITTED,
    bound_of_more,
    bound_of_quotients,
    share_beyond,
)
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.accuracy import Reference, measure, round_states, rounded_values
from symoro_elastic.numerics.verification.states import moderate_states

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[2] / "examples"
RUNS, SHOWN, MORE = 1000, 2000, 10_000


@pytest.mark.thorough
@pytest.mark.parametrize("weight", [1.0, 2.0, 6.0])
def test_a_power_law_is_within_as_often_as_fitted(weight: float) -> None:
    rng = np.random.default_rng(0)
    shown = rng.random((RUNS, SHOWN)) ** (-1 / weight)
    worst = -np.expm1(np.log(rng.random(RUNS)) / MORE)
    kept = [bound_of_more(row, MORE) >= u ** (-1 / weight) for row, u in zip(shown, worst, strict=True)]
    assert np.mean(kept) == pytest.approx(FITTED, abs=4 * math.sqrt(FITTED * (1 - FITTED) / RUNS))


@pytest.mark.parametrize("draw", ["exponential", "uniform", "chisquare"])
def test_lighter_tails_are_within(draw: str) -> None:
    rng = np.random.default_rng(1)
    size = {"df": 1} if draw == "chisquare" else {}
    kept = []
    for _ in range(200):
        errors = getattr(rng, draw)(**size, size=SHOWN + MORE)
        kept.append(errors[SHOWN:].max() <= bound_of_more(errors[:SHOWN], MORE))
    assert np.mean(kept) >= CONFIDENCE


@pytest.mark.parametrize("entries", [1, 2, 4])
def test_errors_of_results_that_cancel_are_within(entries: int) -> None:
    """One result in a million is small in all entries: nothing tells of it in the errors that are drawn."""
    rng = np.random.default_rng(2)
    kept = []
    for _ in range(100):
        results = np.abs(rng.normal(size=(SHOWN + MORE, entries))).max(axis=1)
        errors = rng.uniform(0.5, 1.0, SHOWN + MORE)
        bound = bound_of_quotients(errors[:SHOWN], results[:SHOWN], MORE)
        kept.append((errors / results)[SHOWN:].max() <= bound)
    assert np.mean(kept) >= CONFIDENCE


@pytest.mark.sampled(2)
@pytest.mark.parametrize("judged", [1, 20])
def test_rare_peaks_are_no_more_than_the_share(judged: int) -> None:
    """Peaks beyond a common end, which no tail shows; of several programs the first that shows none is accepted."""
    rng = np.random.default_rng(3)
    shown = rng.binomial(SHOWN, share_beyond(SHOWN, judged), (100 * RUNS, judged))
    accepted = (shown == 0).any(axis=1)
    assert accepted.mean() == pytest.approx(1 - FITTED, rel=0.13)
    with_peak = np.append(rng.uniform(0.9, 1.0, SHOWN - 1), 2.0)
    assert bound_of_more(with_peak, MORE) >= 2.0


@pytest.mark.sampled(2)
@pytest.mark.parametrize("weight", [0.5, 2.0])
def test_no_bound_is_below_what_was_drawn(weight: float) -> None:
    rng = np.random.default_rng(4)
    for _ in range(100):
        errors, results = rng.random(200) ** (-1 / weight), rng.random(200)
        assert bound_of_more(errors, 1) >= errors.max()
        assert bound_of_quotients(errors, results, 1) >= (errors / results).max()


def test_few_and_infinite_errors_have_no_bound() -> None:
    assert bound_of_more(np.ones(39), 1) == math.inf
    assert bound_of_more(np.append(np.ones(400), math.inf), 1) == math.inf
    assert bound_of_more(np.ones(400), 100_000) == bound_of_quotients(np.ones(400), np.ones(400), 100_000) == 1.0


@pytest.mark.thorough
def test_unseen_states_of_a_machine_are_within() -> None:
    """Errors of single precision with inputs in double; `python -m tests.benchmarks.advice` tries 100 000 states."""
    machine, _ = read_machine(EXAMPLES / "planar_2r.toml")
    traced, values = trace(machine, "inverse_dynamics"), parameter_values(machine)
    for seed in range(3):
        states = moderate_states(machine, 8000, seed, values)
        results = evaluate_arrays(traced, round_states(states, SINGLE), rounded_values(values, SINGLE), np.float32)
        seen, unseen = (
            measure(Reference(traced, states[part], values), {name: x[part] for name, x in results.items()}, SINGLE)
            for part in (slice(0, 2000), slice(2000, None))
        )
        assert seen.worst < seen.unseen and unseen.worst <= seen.unseen
