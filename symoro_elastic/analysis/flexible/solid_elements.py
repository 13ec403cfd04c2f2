"""Stiffness, mass and geometric stiffness of solid elements.

By the gradients N_i,a of shape functions with Lame's l and mu,

    K_ia,jb = int l N_i,a N_j,b + mu (N_i,b N_j,a + N_i,c N_j,c 1_ab),   m_ij = int rho N_i N_j,
    Kg_ij = int s_ab N_i,a N_j,b   with stresses s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.packages import for_vibrations

ORDER = 4
"""Of quadrature: exact for products of gradients of quadratic shapes, and for all integrals of a rigid body."""
TOGETHER = 256
"""Elements that are computed at once: 13 MB of their matrices."""


@dataclass(frozen=True, eq=False)
class SolidElements:
    """Elements E with N nodes and Q points: values (N, Q) and gradients (E, N, 3, Q) of shapes, weights (E, Q), m3.

    `nodes` (E, N) are indices of n nodes; Lame's constants, Pa.
    """

    nodes: AnyArray
    count: int
    values: Array
    gradients: Array
    weights: Array
    lame: tuple[float, float]

    @classmethod
    def of(cls, basis: Any, lame: tuple[float, float]) -> SolidElements:
        """The elements of a scalar basis of scikit-fem."""
        fields = [basis.basis[i][0] for i in range(basis.Nbfun)]
        values = np.stack([np.broadcast_to(x, basis.dx.shape)[0] for x in fields])
        gradients = np.stack([x.grad for x in fields]).transpose(2, 0, 1, 3)
        return cls(basis.element_dofs.T, basis.N, values, gradients, basis.dx, lame)

    def mass(self, density: float) -> Any:
        """Scalar mass (n, n), kg."""
        weighted = density * self.values * self.weights[:, None]
        return _sparse_sum(self.nodes, weighted @ self.values.T, self.count)

    def stiffness(self) -> Any:
        """Stiffness (3 n, 3 n), N/m."""
        rows = (3 * self.nodes[:, :, None] + np.arange(3)).reshape(len(self.nodes), -1)
        parts = (slice(k, k + TOGETHER) for k in range(0, len(rows), TOGETHER))
        return sum(_sparse_sum(rows[part], self._stiffness(part), 3 * self.count) for part in parts)

    def _stiffness(self, part: slice) -> Array:
        first, mu = self.lame
        gradients = self.gradients[part]
        e, n, _, q = gradients.shape
        flat = gradients.reshape(e, 3 * n, q)
        pairs = ((flat * self.weights[part, None]) @ flat.swapaxes(1, 2)).reshape(e, n, 3, n, 3)
        K = first * pairs + mu * pairs.swapaxes(2, 4)
        K += mu * np.einsum("eicjc,ab->eiajb", pairs, np.eye(3))
        return np.asarray(K.reshape(e, 3 * n, 3 * n))

    def geometric(self, displacements: Array) -> Any:
        """Geometric stiffness (n, n), N/m, of the stresses under displacements (3 n,), m."""
        first, mu = self.lame
        gradient = np.einsum("enc,enaq->ecaq", displacements.reshape(-1, 3)[self.nodes], self.gradients)
        stress = mu * (gradient + gradient.swapaxes(1, 2))
        stress += first * np.einsum("eccq,ab->eabq", gradient, np.eye(3))
        loaded = np.einsum("eabq,enbq->enaq", stress * self.weights[:, None, None], self.gradients)
        flat = (*self.nodes.shape, -1)
        blocks = loaded.reshape(flat) @ self.gradients.reshape(flat).swapaxes(1, 2)
        return _sparse_sum(self.nodes, blocks, self.count)


def _sparse_sum(rows: AnyArray, blocks: Array, count: int) -> Any:
    """The sparse matrix (count, count) of blocks (E, R, R) at rows (E, R)."""
    i, j = (np.broadcast_to(x, blocks.shape).ravel() for x in (rows[:, :, None], rows[:, None]))
    return for_vibrations("scipy.sparse").coo_matrix((blocks.ravel(), (i, j)), shape=(count, count)).tocsc()
