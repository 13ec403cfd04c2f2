"""Steps of encoders are found in positions, and nothing else is taken for one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.analysis.time_series.resolution import resolution_of, staircase

Array = NDArray[np.float64]
T = np.arange(10000) / 500


def motion(period: float = 10.0, size: float = 1.0) -> Array:
    """Return a motion of ten harmonics."""
    rng = np.random.default_rng(5)
    a, b = rng.standard_normal((2, 10)) * size / np.arange(1, 11)
    w = 2 * np.pi / period * np.outer(T, np.arange(1, 11))
    found: Array = np.cos(w) @ a + np.sin(w) @ b
    return found


@pytest.mark.parametrize("bits", [8, 10, 12, 14, 15, 17, 20])
@pytest.mark.parametrize("jitter", [0.0, 0.5])
def test_step_of_an_encoder(bits: int, jitter: float) -> None:
    step = 2 * np.pi / 2**bits
    seen = motion() + 0.3 * step + jitter * step * np.random.default_rng(bits).standard_normal(len(T))
    assert resolution_of(np.round(seen / step) * step - 1.234) == pytest.approx(step, rel=1e-9)


@pytest.mark.parametrize("decimals", [4, 5])
def test_step_of_positions_written_with_few_decimals(decimals: int) -> None:
    """12 bits, 1.5 mrad: the step is found behind the rounding of the file, to its last digit over the range."""
    step = 2 * np.pi / 2**12
    assert resolution_of(np.round(np.round(motion() / step) * step, decimals)) == pytest.approx(step, rel=1e-4)


def test_no_step_where_positions_are_not_rounded() -> None:
    rng = np.random.default_rng(0)
    assert resolution_of(motion()) == 0.0
    assert resolution_of(motion() + 1e-4 * rng.standard_normal(len(T))) == 0.0
    assert resolution_of(np.zeros(100)) == 0.0
    assert resolution_of(np.full(100, 0.3)) == 0.0
    step = 1e-3
    between = np.convolve(np.round(motion() / step) * step, [0.3, 0.7], "valid")
    assert resolution_of(between + 1e-5 * rng.standard_normal(len(between))) == 0.0


def test_staircases_of_all_zeros_have_no_mean_and_the_variance_of_rounding() -> None:
    """Over the zero of an encoder its error is even from -1/2 to 1/2 of a step at every position."""
    phases, some = (np.arange(1000) + 0.5) / 1000, motion()[:50]
    errors = np.array([staircase(some, 0.02, phase) for phase in phases])
    assert abs(errors.mean(axis=0)).max() < 0.02 * 1e-3
    np.testing.assert_allclose(errors.var(axis=0), 0.02**2 / 12, rtol=1e-2)
