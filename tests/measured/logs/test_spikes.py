"""Spikes of sensors: found where they are put, none where there are none, named, and estimates without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("scipy")

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.measured.logs.filtering import Filter, smooth
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.outliers import spikes_of, without_spikes
from tests.benchmarks.sensors import Sensing, three_axis

Array = NDArray[np.float64]
CHOSEN = Filter(500.0, 2.5, 12.5, window=100, step=33)
T = np.arange(5000) / 500.0
SLOW = 20 * np.sin(2 * np.pi * 0.6 * T) + 5 * np.cos(2 * np.pi * 2.4 * T)
NOISE = 0.2 * np.random.default_rng(0).standard_normal(len(T))
FRICTION = 3.0 * np.sign(np.cos(2 * np.pi * 1.1 * T))


def found(x: Array) -> tuple[Array, NDArray[np.int_]]:
    """Return the signal without spikes, and where they were."""
    repaired, spikes = spikes_of(x, smooth(x, CHOSEN))
    return repaired, np.flatnonzero(spikes)


@pytest.mark.parametrize("together", [1, 3])
def test_spikes_are_found_where_they_are_put(together: int) -> None:
    """40 std of noise, alone and three in a row, on motion and dry friction; what replaces them is within the noise.

    Next to a jump of friction, three of the seven neighbours away, a spike may look like the other side.
    """
    rng = np.random.default_rng(together)
    places = np.sort(rng.choice(np.arange(10, 4990, 10), 100 // together, replace=False))
    jumps = np.flatnonzero(np.diff(FRICTION))
    places = places[abs(places[:, None] - jumps).min(axis=1) > 7]
    signs = np.repeat(rng.choice([-1.0, 1.0], len(places)), together)
    places = (places[:, None] + np.arange(together)).ravel()
    x = SLOW + FRICTION + NOISE
    spiked = x.copy()
    spiked[places] += 8.0 * signs
    repaired, at = found(spiked)
    np.testing.assert_array_equal(at, places)
    assert abs(repaired - x)[places].max() < 6 * 0.2


SIGNALS: dict[str, Callable[[], Array]] = {
    "without noise": lambda: SLOW + FRICTION,
    "noise": lambda: SLOW + FRICTION + NOISE,
    "steps of a sensor": lambda: np.round((SLOW + FRICTION + NOISE) / 0.5) * 0.5,
    "noise only while it moves": lambda: SLOW + NOISE * (T > 7),
    "noise that is slow": lambda: SLOW + 10 * smooth(NOISE, replace(CHOSEN, cutoff=60.0)),
    "a spring that rings after a stop": lambda: SLOW + 5 * np.exp(-5 * (T - 4)) * np.sin(250 * (T - 4)) * (T > 4),
    "a sensor with a dead band": lambda: np.where(abs(NOISE) > 0.4, NOISE, 0.0),
    "an encoder of 10 bits": lambda: np.round(SLOW / 20 / (2 * np.pi / 1024)) * 2 * np.pi / 1024,
}


def test_spikes_at_rest_are_found() -> None:
    """Of a joint that rests for nine tenths of the record, whose encoder shows one value there; 1 % are spikes."""
    x = np.round(np.where(T > 9, SLOW, SLOW[4500]) / 20 / 1e-3) * 1e-3
    spiked = x.copy()
    spiked[7::100] += 0.1
    repaired, at = found(spiked)
    np.testing.assert_array_equal(at, np.arange(7, 5000, 100))
    assert abs(repaired - x)[at].max() <= 2e-3  # two steps of the encoder, which moves by less than one a sample


@pytest.mark.parametrize("name", SIGNALS)
def test_none_where_there_are_none(name: str) -> None:
    assert not len(found(SIGNALS[name]())[1])


def test_spikes_are_named_and_no_longer_in_the_errors() -> None:
    """Torques and positions; the standard deviations are those of the record without spikes, within a tenth."""
    arm = three_axis()
    clean = arm.record(Sensing(), 3)
    q, tau = clean.q.copy(), clean.tau.copy()
    q[[1000, 4321], 1] += 0.5
    tau[100::40, 2] += 3.0
    records = clean, replace(clean, q=q, tau=tau)
    without, found = (identify(arm.machine, x, LogSettings(offsets="never"), Y=arm.regressor) for x in records)
    said = [line for line in found.notes if "spikes" in line]
    assert len(said) == 2 and not [line for line in without.notes if "spikes" in line]
    assert "positions of lift: 2 of 10000 samples are spikes, the first at t = 2 s" in said[0]
    assert "of 10000 samples are spikes, the first at t = 0.2 s" in said[1] and said[1].startswith("torque of wrist: ")
    assert abs(int(said[1].split()[3]) - 248) <= 3  # one beside a reversal may not be seen, or its neighbour be taken
    assert all("median of their neighbours; look for" in line for line in said)
    ratio = found.estimation.solution.std / without.estimation.solution.std
    assert ratio == pytest.approx(1.0, abs=0.1)
    off = (found.estimation.solution.X - without.estimation.solution.X) / without.estimation.solution.std
    assert abs(off).max() < 0.5


def test_too_many_to_be_spikes() -> None:
    """15 % stay, for they are noise with long tails, and are named."""
    arm = three_axis()
    x = np.stack([SLOW, SLOW, SLOW + NOISE], axis=1)
    x[3::7, 2] += 10.0
    record = Measurements(T, np.stack([SLOW / 20] * 3, axis=1), x)
    kept = without_spikes(record, CHOSEN, arm.machine)
    np.testing.assert_array_equal(kept.tau, x)
    assert len(kept.warnings) == 1 and "torque of wrist: 714 of 5000 samples" in kept.warnings[0]
    assert "too many to be taken out" in kept.warnings[0]


def test_noise_that_is_larger_for_a_while_is_no_spike() -> None:
    """Eight times larger at 15 % of the samples, as where a machine chatters: of 100 000 none is taken out."""
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal(5000)
        noise[np.arange(5000) % 1000 < 150] *= 8
        assert not spikes_of(noise, np.zeros(5000))[1].any()
