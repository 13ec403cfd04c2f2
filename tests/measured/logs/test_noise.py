"""Standard deviations say how far estimates are from the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("scipy")

from symoro_elastic.measured.logs.estimation import solve
from symoro_elastic.measured.logs.filtering import Filter, average, shared_noise
from symoro_elastic.measured.logs.noise import Averages, Noise, RowNoise, alike, spectral_density, student_factors
from tests.benchmarks.identification import deviations

Array, BoolArray = NDArray[np.float64], NDArray[np.bool_]
CHOSEN = Filter(1000.0, 5.0, 25.0, window=99, step=33)
SAMPLES = 99 + 33 * 59


def averages(rng: np.random.Generator, joints: int) -> Array:
    """Return 60 rows of averages of white noise."""
    return average(rng.standard_normal((SAMPLES, joints)), CHOSEN)


def slow_columns(rng: np.random.Generator, joints: int, columns: int, rows: int = 60) -> Array:
    """Return columns that change over some rows, as those of a motion do."""
    t = np.arange(rows)[:, None, None]
    period, phase = rng.uniform(10, 60, (1, joints, columns)), rng.uniform(0, 6, (1, joints, columns))
    return np.sin(2 * np.pi * t / period + phase)


def test_covariance_of_scores() -> None:
    """Noise whose correlation is known: the sum over the correlation matrix, row by row."""
    rng = np.random.default_rng(0)
    Y, variance = slow_columns(rng, 2, 3), np.array([2.0, 0.5])
    padded = np.zeros(60)
    padded[: len(CHOSEN.correlation)] = CHOSEN.correlation
    R = padded[abs(np.subtract.outer(np.arange(60), np.arange(60)))]
    wanted = sum(v * Y[:, j].T @ R @ Y[:, j] for j, v in enumerate(variance))
    found = Averages(variance, alike(CHOSEN.correlation, 60, 2))
    np.testing.assert_allclose(found.of_scores(Y), wanted, rtol=1e-10, atol=1e-10)
    assert found.worth == pytest.approx([60**2 / np.sum(R**2)] * 2)


def test_rows_that_miss_samples_share_noise_as_their_windows_do() -> None:
    """Samples left out at random places, against H D H^T of all weights H and a mask D; two rows are left out whole."""
    rng = np.random.default_rng(4)
    counted = np.repeat(rng.uniform(size=(SAMPLES // 25 + 1, 2)) > 0.4, 25, axis=0)[:SAMPLES]
    counted[200:400] = False
    H = np.zeros((60, SAMPLES))
    for row, k in enumerate(CHOSEN.starts(SAMPLES)):
        H[row, k : k + CHOSEN.window] = CHOSEN.weights
    found = shared_noise(counted, CHOSEN)
    for j in range(2):
        R = H * counted[:, j] @ H.T / (CHOSEN.weights @ CHOSEN.weights)
        for lag, each in enumerate(found[:, :, j]):
            np.testing.assert_allclose(each[: 60 - lag], np.diag(R, lag), atol=1e-14)
        assert not np.triu(R, len(found)).any()
    whole = shared_noise(np.ones((SAMPLES, 1), dtype=bool), CHOSEN)
    np.testing.assert_allclose(whole, alike(CHOSEN.correlation, 60, 1), atol=1e-14)


def test_standard_deviations_where_rows_miss_samples() -> None:
    """The covariance of least squares of weight 1 / variance, A W^T R W A with R by all weights H and a mask D."""
    rng = np.random.default_rng(5)
    counted = moving_samples(rng, 1)
    starts = CHOSEN.starts(len(counted))
    H = np.array([np.pad(CHOSEN.weights, (k, len(counted) - CHOSEN.window - k)) for k in starts]) * counted[:, 0]
    R = H @ H.T / (CHOSEN.weights @ CHOSEN.weights)
    scale = 1 / np.sqrt(np.diag(R))
    R *= np.outer(scale, scale)
    correlation = np.zeros((len(CHOSEN.correlation), len(R), 1))
    for lag, rows in enumerate(correlation):
        rows[: len(R) - lag, 0] = np.diag(R, lag)
    Y = slow_columns(rng, 1, 4, len(R))
    found = solve(Y, rng.standard_normal((len(R), 1)), RowNoise(correlation=correlation))
    W = Y[:, 0] / found.sigma[0]
    A = np.linalg.inv(W.T @ W)
    wanted = A @ W.T @ R @ W @ A * student_factors(Y, correlation)[0] ** 2
    np.testing.assert_allclose(found.covariance, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
    whole = solve(Y, found.residuals, RowNoise(correlation=alike(CHOSEN.correlation, len(R), 1)))
    assert not np.allclose(np.diag(whole.covariance), np.diag(wanted), rtol=0.02)


def moving_samples(rng: np.random.Generator, joints: int) -> BoolArray:
    """Return a mask of samples at which joints that turn back every 2 to 5 windows move."""
    samples = CHOSEN.window + CHOSEN.step * 299
    counted = np.ones((samples, joints), dtype=bool)
    for j in range(joints):
        k = 0
        while k < samples:
            k += int(rng.uniform(2, 5) * CHOSEN.window)
            counted[k : k + 60, j] = False
    return counted


@pytest.mark.thorough
def test_few_rows_leave_the_variance_of_noise_in_doubt() -> None:
    """Of 8 rows and 2 columns the truth has Student's distribution; standard deviations are of its variance, 1.5."""
    rng = np.random.default_rng(8)
    Y, none = rng.standard_normal((8, 1, 2)), alike((1.0,), 8, 1)
    found = [solve(Y, rng.standard_normal((8, 1)), rounds=1) for _ in range(500)]
    squares = np.array([x.X[0] ** 2 / x.covariance[0, 0] for x in found])
    assert student_factors(Y, none)[0] ** 2 == pytest.approx(1.5)
    assert squares.mean() == pytest.approx(1.0, abs=0.3)


def test_spectral_density_spectral_density() -> None:
    """Estimated from records of two joints that are alike: their correlation, and its sign."""
    rng = np.random.default_rng(1)
    common = average(rng.standard_normal((99 + 33 * 4000, 1)), CHOSEN)
    rows = len(common)
    found = spectral_density([np.hstack([common, -2 * common])], np.array([rows, rows]))
    assert Noise(found, rows).correlations(4)[:, 0] / common.var() == pytest.approx(
        [*CHOSEN.correlation, *[0.0] * (4 - len(CHOSEN.correlation))], abs=0.06
    )
    np.testing.assert_allclose(found[:, 0, 1], -2 * found[:, 0, 0], atol=1e-9 * abs(found).max())


@pytest.mark.sampled(2)
@pytest.mark.parametrize("columns", [2, 20])
def test_few_rows_for_many_columns(columns: int) -> None:
    """The variance of noise is found without bias where a third of the equations is fitted: V 2."""
    rng = np.random.default_rng(2)
    Y, true, runs = slow_columns(rng, 2, columns), np.array([1.0, 3.0]), 60
    truth = rng.standard_normal(columns)
    found, z = [], []
    for _ in range(runs):
        noise = averages(rng, 2) / math.sqrt(float(CHOSEN.weights @ CHOSEN.weights)) * true
        solution = solve(Y, Y @ truth + noise, RowNoise(correlation=alike(CHOSEN.correlation, 60, 2)))
        found.append(solution.sigma**2)
        z.append((solution.X - truth) / solution.std)
    assert np.mean(found, axis=0) == pytest.approx(true**2, rel=0.12)
    assert math.sqrt(float(np.mean(np.square(z)))) == pytest.approx(1.0, abs=0.15)


def test_slow_noise_raises_standard_deviations() -> None:
    """Noise of the torques that lasts for many rows: estimates are as far off as they say, within a half."""
    rng = np.random.default_rng(3)
    t = np.arange(400)
    Y = np.stack([np.ones(400), np.sin(t / 20)], axis=1)[:, None, :]
    z = []
    for _ in range(60):
        noise = np.zeros((400, 1))
        for k in range(1, 400):
            noise[k] = 0.9 * noise[k - 1] + rng.standard_normal()
        solution = solve(Y, noise)
        assert solution.raised[0] > 2
        z.append(solution.X / solution.std)
    assert 0.67 < math.sqrt(float(np.mean(np.square(z)))) < 1.5


@pytest.mark.thorough
def test_truth_lies_within_the_standard_deviations() -> None:
    """10 runs of 16 parameters with dry friction and coarse encoders, and an offset that may hide in one of them.

    Parameters of a run are correlated, so 160 estimates are taken for 53 draws: three standard deviations of their
    binomial shares are 0.19, 0.09 and 0.03. `python -m tests.benchmarks.identification` is the whole check.
    """
    z, _, labels = deviations("cylindrical arm, coarse encoders", 2, 10)
    assert z.shape == (10, 17) and {"FS1", "FS2", "FS3"} <= set(labels)
    inside = [float((abs(z) < k).mean()) for k in (1, 2, 3)]
    assert abs(inside[0] - 0.683) < 0.19 and inside[1] > 0.954 - 0.09 and inside[2] > 0.997 - 0.03
    assert abs(float(z.mean())) < 3 / math.sqrt(53)


@pytest.mark.thorough
def test_noise_of_positions_that_is_itself_in_doubt() -> None:
    """Noise has a share of 0.4 in what tells two columns apart; its law is from 3 draws, and its power from 300 rows.

    Without the doubt of both the root mean square of errors over their standard deviations was 1.22 and 1.25 here.
    """
    true, each = np.array([2.0, -2.0]), []
    for seed in range(100):
        rng, n = np.random.default_rng(seed), 300
        a, b = rng.normal(size=(2, n))
        Y = np.stack([a, a + 0.3 * b], axis=1)[:, None, :]
        *draws, noise = (Y * [0.0, 0.0] + [0.0, 0.24] * rng.normal(size=(n, 1, 1)) for _ in range(4))
        found = solve(Y + noise, Y @ true + 0.05 * rng.normal(size=(n, 1)), RowNoise(draws))
        each.append((found.X - true) / found.std)
    assert found.noise.min() > 0.25
    rms = np.sqrt(np.mean(np.square(each), axis=0))
    assert (rms > 0.75).all() and (rms < 1.05).all()
