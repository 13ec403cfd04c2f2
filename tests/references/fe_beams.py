"""Finite elements of Timoshenko's beam with any section along it, for tests: exact stiffness of uniform elements."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

ELEMENTS = 300


class Properties(NamedTuple):
    """Of a section: EI, N m2; kGA, N, infinite without shear; mass, kg/m; inertia about the axis of bending, kg m."""

    EI: float
    GA: float
    mass: float
    turning: float


class Clamped:
    """A beam that is clamped at x = 0: K and M of deflections and turns at the nodes."""

    def __init__(self, length: float, at: Callable[[float], Properties], ends: tuple[float, ...] = ()) -> None:
        """Nodes are at the `ends` of pieces; sections are those in the middles of elements."""
        places = np.array([0.0, *ends, length])
        counts = np.maximum(1, np.round(ELEMENTS * np.diff(places) / length).astype(int))
        parts = zip(places[:-1], places[1:], counts, strict=True)
        nodes = np.concatenate([*(np.linspace(a, b, n + 1)[:-1] for a, b, n in parts), [length]])
        self.K, self.M = (np.zeros((2 * len(nodes),) * 2) for _ in range(2))
        for k, (a, b) in enumerate(pairwise(nodes)):
            h, s = b - a, at((a + b) / 2)
            c = 12 * s.EI / (s.GA * h**2)
            own = slice(2 * k, 2 * k + 4)
            self.K[own, own] += (s.EI / h**3 / (1 + c)) * np.array(
                [
                    [12, 6 * h, -12, 6 * h],
                    [6 * h, (4 + c) * h**2, -6 * h, (2 - c) * h**2],
                    [-12, -6 * h, 12, -6 * h],
                    [6 * h, (2 - c) * h**2, -6 * h, (4 + c) * h**2],
                ]
            )
            self.M[own, own] += h / 6 * np.kron([[2, 1], [1, 2]], np.diag([s.mass, s.turning]))
        self.K, self.M = self.K[2:, 2:], self.M[2:, 2:]

    def frequencies(self, mass: float, inertia: float, count: int) -> np.ndarray:
        """First frequencies, Hz, with a body at the end."""
        M = self.M.copy()
        M[-2, -2] += mass
        M[-1, -1] += inertia
        squares = eigh(self.K, M, eigvals_only=True, subset_by_index=[0, count - 1])
        return np.asarray(np.sqrt(squares) / (2 * np.pi))

    @property
    def compliance(self) -> np.ndarray:
        """Of deflection and turn at the end under force and moment there."""
        return np.linalg.inv(self.K)[-2:, -2:]
