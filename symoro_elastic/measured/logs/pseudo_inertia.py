"""Least squares over bodies that exist: pseudo-inertias positive definite, friction and springs positive.

A body whose mass is spread over space has the pseudo-inertia J = [[Sigma, h], [h^T, m]] > 0 with Sigma = tr(I)/2 1 - I,
and each such J has a body (Wensing, Kim and Slotine 2018). Of parameters x, made of bodies and scalars, minimized is

    |R (A x - b)|^2 / 2 + lam sum_j (tr(J0_j^-1 J_j) - ln det J_j) + sum_k w_k (x_k / x0_k - ln x_k)

where the second term is the log-det divergence of Bregman from given bodies J0_j, an entropic distance (Lee, Wensing
and Park 2020). It is also the barrier of the cone, self-concordant (Nesterov and Nemirovskii 1994), so Newton's method
with steps that stay inside solves it from any start, and lam -> 0 gives the constraints alone. What data do not tell
is then where the divergence is least, at the centre; of the solutions on the boundary none is better than others.

Each step is in coordinates in which the point is 1, as in Dikin's ellipsoid: with J = F F^T bodies beside it are
F (1 + S) F^T, S by ten numbers in an orthonormal basis, and scalars x_k (1 + s_k). There the Hessian of the barrier is
lam 1, however thin the bodies, the step is a least-squares problem, and along it the cost is a sum of logarithms of
1 + t sigma, sigma the eigenvalues of S. F becomes F chol(1 + t S), so no J is ever factored.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray

LIFTED = 1e-4  # least eigenvalue of a body, lengths over its radius of gyration, of the largest one
RADIUS = 0.1  # m, of gyration of a body without extent
LARGE = 1e3  # first lam
FASTEST = 8.0  # largest factor by which lam falls from stage to stage
SLOWEST = 1.05  # least factor
NEWTONS = 20  # steps of a stage; one that needs more starts from a nearer lam
CONVERGED = 1e-9  # fall of the cost, over lam, that ends a stage
TO_BOUNDARY = 0.9  # of the way to the boundary of possible bodies: longest step
DECREASE = 0.1  # of the expected fall of the cost: least fall of an accepted step
SHORTEST = 1e-10  # of a step, which ends a stage
PAIRS = tuple((i, k) for i in range(4) for k in range(i, 4))


def _basis() -> Array:
    """Return an orthonormal basis of symmetric matrices, (10, 4, 4)."""
    E = np.zeros((len(PAIRS), 4, 4))
    for a, (i, k) in enumerate(PAIRS):
        E[a, i, k] = E[a, k, i] = 1.0 if i == k else np.sqrt(0.5)
    return E


BASIS = _basis()


def pseudo_inertia(x: Array) -> Array:
    """Return J (..., 4, 4) of XX, XY, XZ, YY, YZ, ZZ, MX, MY, MZ, M (..., 10)."""
    xx, xy, xz, yy, yz, zz, mx, my, mz, m = np.moveaxis(np.asarray(x, dtype=float), -1, 0)
    half = (xx + yy + zz) / 2
    rows = [[half - xx, -xy, -xz, mx], [-xy, half - yy, -yz, my], [-xz, -yz, half - zz, mz], [mx, my, mz, m]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def inertial_parameters(J: Array) -> Array:
    """Return XX, XY, XZ, YY, YZ, ZZ, MX, MY, MZ, M (..., 10) of J (..., 4, 4): I = tr(Sigma) 1 - Sigma."""
    diagonal = [J[..., k, k] for k in range(3)]
    x, y, z = diagonal
    tensor = [y + z, -J[..., 0, 1], -J[..., 0, 2], x + z, -J[..., 1, 2], x + y]
    return np.stack([*tensor, *(J[..., k, 3] for k in range(4))], axis=-1)


def lifted(J: Array, mass: float) -> tuple[Array, bool]:
    """Return the nearest physically consistent pseudo-inertia, and whether it differs from J.

    Eigenvalues are compared with lengths over the radius of gyration. A body without mass has `mass`.
    """
    J = J.copy()
    massless = J[3, 3] <= 0
    J[3, 3] = mass if massless else J[3, 3]
    spread = float(np.trace(J[:3, :3])) / J[3, 3]
    scale = np.diag([*[np.sqrt(spread) if spread > 0 else RADIUS] * 3, 1.0])
    inverse = np.diag(1 / np.diag(scale))
    values, vectors = np.linalg.eigh(inverse @ J @ inverse)
    least = LIFTED * max(float(values[-1]), J[3, 3])
    if values[0] >= least and not massless:
        return J, False
    near = vectors @ np.diag(np.maximum(values, least)) @ vectors.T
    raised: Array = scale @ near @ scale
    return raised, True


@dataclass(frozen=True)
class Prior:
    """Prior: bodies J0 (B, 4, 4) > 0; scalars x0 (S) > 0, and weights of their barrier over lam (S); free values x0 (F)
    and their deviations (F), which are over lam^1/2 where `by_lam` (F). Parameters are ten of each body, then these."""

    bodies: Array
    scalars: Array
    weights: Array
    free: Array
    deviations: Array
    by_lam: BoolArray


@dataclass(frozen=True)
class Nearest:
    """Minimizer x of the cost, the inverse Hessian there, and the data's part of the cost."""

    x: Array
    covariance: Array
    misfit: float


@dataclass(frozen=True)
class _Point:
    """A point in the interior: factors F (B, 4, 4) of pseudo-inertias, positive scalars (S), free values (F)."""

    factors: Array
    scalars: Array
    free: Array

    @property
    def x(self) -> Array:
        """Inertial parameters of bodies, scalars and free values in one vector."""
        bodies = inertial_parameters(self.factors @ self.factors.transpose(0, 2, 1)).ravel()
        return np.concatenate([bodies, self.scalars, self.free])

    def slopes(self) -> Array:
        """Return derivatives of x by the local coordinates: S, relative changes of scalars, changes of free values."""
        bodies = len(self.factors)
        size = 10 * bodies + len(self.scalars) + len(self.free)
        T = np.zeros((size, size))
        for j, F in enumerate(self.factors):
            T[10 * j : 10 * j + 10, 10 * j : 10 * j + 10] = inertial_parameters(F @ BASIS @ F.T).T
        scalars = np.arange(10 * bodies, size)
        T[scalars, scalars] = np.concatenate([self.scalars, np.ones(len(self.free))])
        return T

    def split(self, step: Array) -> tuple[Array, Array, Array]:
        """Return a step as S (B, 4, 4), relative changes of scalars, and changes of free values."""
        bodies, scalars = len(self.factors), len(self.scalars)
        S = np.einsum("ja,aik->jik", step[: 10 * bodies].reshape(bodies, 10), BASIS)
        return S, step[10 * bodies : 10 * bodies + scalars], step[10 * bodies + scalars :]

    def moved(self, step: Array) -> _Point:
        """Return the point after a step that stays in the interior."""
        S, scalars, free = self.split(step)
        factors = self.factors @ np.linalg.cholesky(np.eye(4) + S) if len(S) else self.factors
        return _Point(factors, self.scalars * (1 + scalars), self.free + free)


def nearest(prior: Prior, A: Array, b: Array, lam: float) -> Nearest:
    """Return the minimizer for rows A x = b of unit deviation, following a path of decreasing lam.

    Where lam is large they are the prior's: Newton's method starts there. From one lam to the next the way is short,
    or Newton's steps go along the boundary, a few lam of cost each.
    """
    factors = np.linalg.cholesky(prior.bodies).astype(float) if len(prior.bodies) else prior.bodies
    point, here, ratio = _Point(factors, prior.scalars, prior.free), FASTEST * max(LARGE, lam), FASTEST
    while here > lam:
        near, has_converged = _newton_minimum(prior, A, b, max(here / ratio, lam), point)
        if has_converged or ratio < SLOWEST:
            point, here, ratio = near, max(here / ratio, lam), min(ratio**1.5, FASTEST)
        else:
            ratio = np.sqrt(ratio)
    step = _Step(prior, A, b, lam, point)
    spread = point.slopes() @ np.linalg.inv(step.factored[1])
    return Nearest(point.x, spread @ spread.T, float((step.residual**2).sum()) / 2)


def _newton_minimum(prior: Prior, A: Array, b: Array, lam: float, point: _Point) -> tuple[_Point, bool]:
    """Return the minimum of the cost by Newton's method with steps that stay in the interior and lower the cost, and
    whether it has converged in few steps."""
    for _ in range(NEWTONS):
        step = _Step(prior, A, b, lam, point)
        size = step.size()
        point = point.moved(size * step.direction)
        if size <= SHORTEST or step.fall <= CONVERGED * lam:
            return point, True
    return point, False


@dataclass(frozen=True)
class _Step:
    """Newton's step on the cost of data and prior from a point."""

    prior: Prior
    A: Array
    b: Array
    lam: float
    point: _Point

    @cached_property
    def residual(self) -> Array:
        """Residual A x - b at the point."""
        residual: Array = self.A @ self.point.x - self.b
        return residual

    @cached_property
    def local(self) -> Array:
        """Derivatives of the residual by local coordinates."""
        return self.A @ self.point.slopes()

    @cached_property
    def of_prior(self) -> tuple[Array, Array]:
        """Gradient of the prior without its logarithms, and Hessian with them (diagonal)."""
        prior, point = self.prior, self.point
        weights, free = self.lam * prior.weights, np.where(prior.by_lam, self.lam, 1.0) / prior.deviations**2
        inside = point.factors.transpose(0, 2, 1) @ np.linalg.solve(prior.bodies, point.factors)
        traces = self.lam * np.einsum("jik,aki->ja", inside, BASIS).ravel()
        gradient = np.concatenate([traces, weights * point.scalars / prior.scalars, free * (point.free - prior.free)])
        return gradient, np.concatenate([np.full(traces.size, self.lam), weights, free])

    @property
    def _of_logarithms(self) -> Array:
        """Gradient of the logarithms -lam ln det(1 + S) and -w ln(1 + s)."""
        traces = np.einsum("aii->a", BASIS)
        bodies, weights = len(self.point.factors), self.lam * self.prior.weights
        return -np.concatenate([self.lam * np.tile(traces, bodies), weights, np.zeros(len(self.prior.free))])

    @cached_property
    def gradient(self) -> Array:
        """Gradient of the prior, its logarithms included, by local coordinates."""
        gradient: Array = self.of_prior[0] + self._of_logarithms
        return gradient

    @cached_property
    def factored(self) -> tuple[Array, Array]:
        """Factors Q and R of the rows J with Hessian J^T J."""
        Q, R = np.linalg.qr(np.concatenate([self.local, np.diag(np.sqrt(self.of_prior[1]))]))
        return Q, R

    @cached_property
    def direction(self) -> Array:
        """Newton's step in local coordinates, by least squares."""
        Q, R = self.factored
        right = np.concatenate([-self.residual, -self.gradient / np.sqrt(self.of_prior[1])])
        return np.linalg.solve(R, Q.T @ right)

    @cached_property
    def fall(self) -> float:
        """Negative slope of the cost along Newton's step: twice the fall that a parabola predicts."""
        return float((self.factored[1] @ self.direction) @ (self.factored[1] @ self.direction))

    def size(self) -> float:
        """Return the fraction of the step at which the cost has fallen enough."""
        S, scalars, _ = self.point.split(self.direction)
        sigma = np.concatenate([np.linalg.eigvalsh(S).ravel() if len(S) else np.zeros(0), scalars])
        weights = np.concatenate([np.full(4 * len(S), self.lam), self.lam * self.prior.weights])
        gain, free = self.local @ self.direction, self.of_prior[1][len(self.direction) - len(self.prior.free) :]
        last = self.direction[len(self.direction) - len(self.prior.free) :]
        linear = float(self.residual @ gain + self.of_prior[0] @ self.direction)
        square = float(gain @ gain + free @ last**2) / 2
        least = float(sigma.min(initial=0.0))
        t = min(1.0, TO_BOUNDARY / -least) if least < 0 else 1.0
        while t > SHORTEST and t * linear + t * t * square - weights @ np.log1p(t * sigma) > -DECREASE * t * self.fall:
            t /= 2
        return t
