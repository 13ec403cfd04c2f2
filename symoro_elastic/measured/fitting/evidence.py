"""Estimates by other data as a block of residuals: r = R (theta(x) - values), R^T R the inverse of their covariance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.measured.fitting.estimates import ALARM

STEP = 1e-5  # of unknowns, for central differences: of a cubic they are off by STEP^2
ROUNDING = 1e-13  # of the largest eigenvalue of correlations: smaller ones are rounding


@dataclass(frozen=True)
class Evidence:
    """Estimates `values` (m) of functions theta of unknowns x (p), and R (m, m), the root of their information."""

    theta: Callable[[Array], Array]
    values: Array
    root: Array

    @classmethod
    def of(cls, theta: Callable[[Array], Array], values: Array, covariance: Array) -> Evidence:
        """Return the evidence of estimates with this covariance (m, m)."""
        return cls(theta, values, information_root(covariance))

    def apart(self, x: Array) -> Array:
        """Return the residuals r (m), each of standard deviation 1."""
        r: Array = self.root @ (self.theta(x) - self.values)
        return r

    def residuals(self, x: Array) -> tuple[Array, Array]:
        """Return the residuals r (m), each of standard deviation 1, and their derivatives (p, m) by x."""
        slopes = [(self.theta(x + h) - self.theta(x - h)) / (2 * STEP) for h in STEP * np.eye(len(x))]
        return self.apart(x), np.array(slopes).reshape(len(x), -1) @ self.root.T

    def contradicts(self, x: Array) -> bool:
        """Whether the sum of squared residuals at x exceeds what correct data exceed once in a thousand."""
        r = self.apart(x)
        return bool(r @ r > len(r) * largest_chi2(len(r)))


@dataclass(frozen=True)
class OtherData:
    """Parameters that other data determine (`informed`), and their evidence by the labels of the unknowns of a fit."""

    informed: tuple[str, ...]
    evidence: Callable[[Sequence[str]], Evidence]


def information_root(covariance: Array) -> Array:
    """Return R (m, m) with R^T R = C^-1, of an estimated covariance C.

    Eigenvalues of its correlations may be negative by its own error: to all of them twice as much is added, which makes
    standard deviations larger.
    """
    std = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(std, std)
    sizes = np.linalg.eigvalsh(correlation)
    least, floor = float(sizes.min(initial=1.0)), ROUNDING * float(sizes.max(initial=1.0))
    error = floor - 2 * min(least, 0.0) if least < floor else 0.0
    root: Array = np.linalg.inv(np.linalg.cholesky(correlation + error * np.eye(len(std)))) / std
    return root


def largest_chi2(freedom: float) -> float:
    """Return the 99.9 % quantile of chi2 over its degrees of freedom, at least one."""
    freedom = max(freedom, 1.0)
    return float(for_vibrations("scipy.special").chdtri(freedom, ALARM)) / freedom
