"""Law of the residuals of tau = Y X: spectral densities of the noise of positions and of torques.

Rows are averages, so noise is correlated from one to the next. The noise of torques is white before averaging: its
correlation is that of the samples that two windows share, which differs from row to row where samples are left out; its
size follows from the residuals. The noise of positions is that of its twins (`filtering`). Densities are at the
frequencies of records padded with zeros to `padded_length` rows; their mean over all frequencies is the variance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.packages import for_identification
from symoro_elastic.measured.fitting.estimates import CORRELATED

FEWEST_LAGS = 24  # of the correlation of positions' noise
PART = 4  # of the rows: lags are at most a quarter
MOST_ALIKE = 0.98  # largest correlation of neighbours, of which standard deviations rise tenfold
FEWEST_FREEDOM = 3.0  # degrees of freedom of a variance


Draws = Callable[[Array], Sequence[Array]]
"""From X, draws of what noise of positions makes of Y X, each (rows, n)."""


@dataclass(frozen=True)
class RowNoise:
    """Noise in the rows of tau = Y X (rows, n), as determined before their residuals.

    Noise of the positions is in Y: `columns` are noises of Y (rows, n, c) of the same law, `repeating` where a motion
    that repeats repeats them, as the staircase of an encoder; `draws` give what many of them make of Y X, where noise
    depends on the phase of the motion. `correlation` is that of the noise of torques in each row with the same noise
    0, 1, 2 ... rows later (lags, rows, n), None for independent rows. `systematic` are errors of tau of one standard
    deviation, each with one factor for all rows.
    """

    columns: Sequence[Array] = ()
    correlation: Array | None = None
    repeating: bool = False
    draws: Draws | None = None
    systematic: Sequence[Array] = ()

    def correlation_in(self, Y: Array) -> Array:
        """Return the correlation of the noise of torques in rows of Y (rows, n, c)."""
        return alike((1.0,), *Y.shape[:2]) if self.correlation is None else self.correlation

    def of_columns(self, chosen: Sequence[int], count: int) -> RowNoise:
        """Return the noise of chosen columns among the `count` columns of draws."""
        draws = self.draws

        def of_chosen(X: Array) -> Sequence[Array]:
            values = np.zeros(count)
            values[list(chosen)] = X
            return draws(values) if draws else ()

        columns = [D[:, :, list(chosen)] for D in self.columns]
        return replace(self, columns=columns, draws=of_chosen if draws else None)

    def without(self, used: Array, Y: Array) -> RowNoise:
        """Return the noise of rows of Y of which some are set to zero: `used` is 0 or 1 (rows, n)."""
        draws, columns = self.draws, [D * used[:, :, None] for D in self.columns]
        remaining = None if draws is None else lambda X: [D * used for D in draws(X)]
        correlation = masked_correlation(self.correlation_in(Y), used)
        return replace(self, columns=columns, correlation=correlation, draws=remaining)

    def with_exact(self, columns: int) -> RowNoise:
        """Return the noise of Y with so many further columns without noise."""
        return replace(self, columns=[np.pad(D, ((0, 0), (0, 0), (0, columns))) for D in self.columns])


@dataclass(frozen=True)
class Averages:
    """White noise in the rows of each joint: variances (n), and the correlation of a row with those 0, 1, 2 ... rows
    later, (lags, rows, n), zero for rows left out."""

    variance: Array
    correlation: Array

    def correlations(self, lags: int) -> Array:
        """Return mean E[r_j(t) r_j(t + lag)] for some lags from 0, (lags, n)."""
        correlations = np.zeros((lags, len(self.variance)))
        total = self.correlation[:lags].sum(axis=1)
        correlations[: len(total)] = self.variance * total / np.maximum(self.correlation[0].sum(axis=0), 1.0)
        return correlations

    def with_factors(self, factors: Array) -> Averages:
        """Return the noise with the standard deviations of joints multiplied, (n)."""
        return Averages(self.variance * factors**2, self.correlation)

    def of_scores(self, Y: Array) -> Array:
        """Return the covariance (c, c) of sum over rows and joints of Y (rows, n, c) times the noise."""
        own = self.variance * self.correlation
        total: Array = np.einsum("rjc,rj,rjd->cd", Y, own[0], Y, optimize=True)
        for lag in range(1, min(len(own), len(Y))):
            later = np.einsum("rjc,rj,rjd->cd", Y[:-lag], own[lag, :-lag], Y[lag:], optimize=True)
            total = total + later + later.T
        return total

    @property
    def worth(self) -> Array:
        """Independent rows that determine a variance as well as the rows of a joint, (tr R)^2 / tr R^2, (n)."""
        squares = (self.correlation**2).sum(axis=1)
        own: Array = self.correlation[0].sum(axis=0) ** 2 / np.maximum(2 * squares.sum(axis=0) - squares[0], 1.0)
        return own


def alike(correlation: Sequence[float], rows: int, joints: int) -> Array:
    """Return one correlation function for all rows, (lags, rows, n): with those 0, 1, 2 ... rows later."""
    correlations = np.zeros((len(correlation), rows, joints))
    for lag, x in enumerate(correlation):
        correlations[lag, : max(rows - lag, 0)] = x
    return correlations


def masked_correlation(correlation: Array, factors: Array) -> Array:
    """Return a correlation (lags, rows, n) times factors (rows, n) of both rows."""
    padded = np.pad(factors, ((0, len(correlation)), (0, 0)))
    later = np.array([padded[k : k + len(factors)] for k in range(len(correlation))])
    masked: Array = correlation * factors * later
    return masked


def usual_correlation(correlation: Array) -> tuple[float, ...]:
    """Return the mean correlation of rows with those 0, 1, 2 ... rows later."""
    total = correlation.sum(axis=(1, 2))
    return tuple((total / max(float(total[0]), 1.0)).tolist())


@dataclass(frozen=True)
class Noise:
    """Noise in rows over the sigma of their joint: that of positions by its cross-spectral density
    (frequencies, n, n), and that of torques."""

    density: AnyArray
    rows: int
    torques: Averages | None = None

    @property
    def variance(self) -> Array:
        """Variances of rows by joint, (n)."""
        variance: Array = self.correlations(1)[0]
        return variance

    def correlations(self, lags: int) -> Array:
        """Return E[r_j(t) r_j(t + lag)] for some lags from 0, (lags, n)."""
        own = np.einsum("fjj->fj", self.density)
        both: Array = np.fft.irfft(own, padded_length(self.rows), axis=0)[:lags]
        return both if self.torques is None else both + self.torques.correlations(lags)

    def of(self, joint: int) -> Noise:
        """Return the noise that positions cause in the rows of one joint."""
        return Noise(self.density[:, joint : joint + 1, joint : joint + 1], self.rows)

    def with_factors(self, factors: Array) -> Noise:
        """Return the noise with the standard deviations of joints multiplied, (n)."""
        torques = None if self.torques is None else self.torques.with_factors(factors)
        return Noise(self.density * np.outer(factors, factors), self.rows, torques)

    def of_scores(self, Y: Array) -> Array:
        """Return the covariance (c, c) of sum over rows and joints of Y (rows, n, c) times the noise."""
        both = self._of_positions(Y)
        return both if self.torques is None else both + self.torques.of_scores(Y)

    def _of_positions(self, Y: Array) -> Array:
        if not self.density.any():
            return np.zeros((Y.shape[2], Y.shape[2]))
        spectrum = np.fft.rfft(Y, padded_length(len(Y)), axis=0)
        through = self.density @ spectrum
        through[1:-1] *= 2  # frequencies of both signs
        total: Array = np.tensordot(spectrum.conj(), through, axes=([0, 1], [0, 1])).real / padded_length(len(Y))
        return total


def padded_length(rows: int) -> int:
    """Return the length of records padded with zeros."""
    return int(2 ** np.ceil(np.log2(2 * rows)))


def spectral_density(records: Sequence[Array], used: Array, repeating: bool = False) -> AnyArray:
    """Return the cross-spectral density of noises (rows, n); `used` rows of each joint are not left out (n).

    Noises that are not `repeating` are forgotten after a quarter of the rows, which makes their spectrum smooth.
    """
    rows, joints = len(records[0]), len(used)
    size = np.sqrt(np.maximum(used, 1))
    spectra = [np.fft.rfft(record / size, padded_length(rows), axis=0) for record in records]
    cross = sum(np.einsum("fj,fk->fjk", x, x.conj()) for x in spectra) / len(spectra)
    density: AnyArray = np.asarray(cross).reshape(-1, joints, joints)
    if repeating:
        return density
    correlation = np.fft.irfft(cross, padded_length(rows), axis=0)
    lags = np.minimum(np.arange(padded_length(rows)), padded_length(rows) - np.arange(padded_length(rows)))
    last = min(max(FEWEST_LAGS, rows // PART), rows)
    parzen = for_identification("scipy.signal").windows.parzen(2 * last + 1)  # whose densities are never negative
    window = np.pad(parzen[last:], (0, len(lags)))[lags]
    density = np.fft.rfft(correlation * window[:, None, None], axis=0)
    return density.reshape(-1, joints, joints)


def residual_noise(
    Y: Array, residuals: Array, positions: Sequence[Array], correlation: Array, repeating: bool = False
) -> Noise:
    """Return the noise that leaves such residuals (rows, n), of rows and columns Y (rows, n, c) over sigma.

    `positions` are the noises, perhaps `repeating`, that those of the positions make in the rows; `correlation` is that
    of the torques' noise (lags, rows, n). What positions do not explain is noise of the torques: of least squares with
    H = Q Q^T and variances v_k of the torques' noise,
    E |r_j|^2 = sum_k v_k (delta_jk (tr R - 2 tr Q_j^T R Q_j) + tr Q_k^T R Q_k Q_j^T Q_j), solved for v.
    """
    rows, joints, columns = Y.shape
    used = Y.any(axis=2).sum(axis=0)
    Q = np.linalg.qr(Y.reshape(-1, columns))[0].reshape(Y.shape)
    white = [Averages(np.ones(1), correlation[:, :, [j]]) for j in range(joints)]
    spread = [averages.of_scores(Q[:, [j]]) for j, averages in enumerate(white)]
    shares = [Q[:, j].T @ Q[:, j] for j in range(joints)]
    A = np.array([[float((G * B).sum()) for G in spread] for B in shares])
    A += np.diag([used[j] - 2 * float(np.trace(spread[j])) for j in range(joints)])
    energy = (residuals**2).sum(axis=0)
    density = np.zeros((padded_length(rows) // 2 + 1, joints, joints), dtype=complex)
    if positions:
        density += spectral_density(positions, used, repeating)
        energy = energy - _remaining_squares(Noise(density, rows), Q, used, shares)
    variance, active = np.zeros(joints), np.flatnonzero(used > 0)
    variance[active] = for_identification("scipy.optimize").nnls(A[np.ix_(active, active)], energy[active])[0]
    return Noise(density, rows, Averages(variance, correlation))


def student_factors(Y: Array, correlation: Array) -> Array:
    """Return factors (n) on standard deviations of scores, since the noise variance is estimated from few rows.

    Beside a variance of f degrees of freedom the truth has Student's distribution, whose variance is f / (f - 2) times
    that of the normal one. Columns Y (rows, n, c) take their share of the rows of each joint.
    """
    _, joints, columns = Y.shape
    Q = np.linalg.qr(Y.reshape(-1, columns))[0].reshape(Y.shape)
    used = np.maximum(Y.any(axis=2).sum(axis=0), 1)
    remaining = 1 - (Q**2).sum(axis=(0, 2)) / used
    freedom = np.maximum(Averages(np.ones(joints), correlation).worth * remaining, FEWEST_FREEDOM)
    factors: Array = np.sqrt(freedom / (freedom - 2))
    return factors


def correlation_factors(noise: Noise, residuals: Array) -> Array:
    """Return factors (n) by which correlated residuals raise the standard deviations of scores.

    Neighbours of residuals (rows, n) are more alike than averages of white noise: by e, as in a first-order process,
    whose mean has sqrt((1 + e) / (1 - e)) times the standard deviation. 1 where e may be chance.
    """
    power, together = (residuals**2).sum(axis=0), (residuals[1:] * residuals[:-1]).sum(axis=0)
    usual, alike = noise.correlations(2), together / np.where(power > 0, power, 1.0)
    expected = usual[1] / np.where(usual[0] > 0, usual[0], 1.0)
    excess = np.clip((alike - expected) / (1 - np.minimum(expected, MOST_ALIKE)), 0.0, MOST_ALIKE)
    factors: Array = np.where(excess > CORRELATED, np.sqrt((1 + excess) / (1 - excess)), 1.0)
    return factors


def _remaining_squares(noise: Noise, Q: Array, used: Array, shares: Sequence[Array]) -> Array:
    """Return the squares of a noise that remain after the fit, by joint (n)."""
    total = noise.of_scores(Q)
    own = [float(np.trace(noise.of(j).of_scores(Q[:, [j]]))) for j in range(len(used))]
    fitted = [float((total * B).sum()) for B in shares]
    remaining: Array = noise.variance * used - 2 * np.array(own) + np.array(fitted)
    return np.maximum(remaining, 0.0)
