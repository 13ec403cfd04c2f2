"""A flexible body of a machine: its modes, rows of the table, and their integrals over the mass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self, TypeAlias

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.coarse_meshes import coarse_mesh

Numbers: TypeAlias = tuple[float, ...]
Rows: TypeAlias = tuple[Numbers, ...]


ROUNDING = 1e-12
"""Of the largest integral of a kind: smaller ones are rounding."""


@dataclass(frozen=True, eq=False)
class Surface:
    """The outer surface of a body by m modes: points (N, 3), m, triangles (M, 3), and modes there (m, N, 3)."""

    points: Array
    triangles: AnyArray
    modes: Array

    def at(self, e: Array) -> Array:
        """Return the points (N, 3) of the surface at deflections e (m,) of the modes."""
        return np.asarray(self.points + np.tensordot(e, self.modes, axes=1))

    def coarse(self, most: int) -> Surface:
        """Return a surface with at most so many triangles, where a coarse grid allows."""
        columns = np.hstack([self.points, self.modes.swapaxes(0, 1).reshape(len(self.points), -1)])
        columns, triangles = coarse_mesh(columns, self.triangles, most)
        return Surface(columns[:, :3], triangles, columns[:, 3:].reshape(len(columns), -1, 3).swapaxes(0, 1))


@dataclass(frozen=True)
class FlexibleBody:
    """The body of a row that bends by m modes about the origin of its frame, at which they and their turns vanish.

    `modes` are names of elastic rows on it, whose variables are the deflections e, m. Mass, first moments and inertia
    of the undeformed body are cells of the row. The others are integrals over the mass, of modes phi_k and their
    foreshortening s_kl: Ct0 (m, 3) of phi_k, Ct1 (m, m, 3) of s_kl, T0 (m, 3, 3) of x phi_k^T,
    T1 (m, m, 3, 3) of phi_l phi_k^T + x s_kl^T, Mee (m, m) of phi_k . phi_l. Units kg, kg m. Drawings show its surface.
    """

    joint: str
    modes: tuple[str, ...]
    Ct0: Rows
    Ct1: tuple[Rows, ...]
    T0: tuple[Rows, ...]
    T1: tuple[tuple[Rows, ...], ...]
    Mee: Rows
    surface: Surface | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(
        cls, joint: str, modes: Sequence[str], integrals: Mapping[str, Array], surface: Surface | None = None
    ) -> Self:
        """The body of a row by its integrals; entries that are rounding only become zero."""
        exact = {
            key: np.where(np.abs(x) > ROUNDING * np.abs(x).max(initial=0.0), x, 0.0) for key, x in integrals.items()
        }
        return cls(joint, tuple(modes), **{key: _tuples(x) for key, x in exact.items()}, surface=surface)


def integrals_of(mass: Array, x: Array, phi: Array, s: Array) -> dict[str, Array]:
    """Return the integrals of a body of n points by its mass (n,), x (n, 3), phi (m, n, 3) and s (m, m, n, 3).

    Mass may be a matrix (n, n), the scalar one of solid elements, which interpolate displacements as coordinates.
    """
    m = np.diag(mass) if mass.ndim == 1 else mass
    weighted, moved = m @ x, np.einsum("ij,kja->kia", m, phi)
    pairs = np.einsum("lia,kib->klab", phi, moved)
    pairs = (pairs + pairs.transpose(1, 0, 3, 2)) / 2
    return {
        "Ct0": moved.sum(axis=1),
        "Ct1": np.einsum("i,klia->kla", m.sum(axis=0), s),
        "T0": np.einsum("ia,kib->kab", x, moved),
        "T1": pairs + np.einsum("ia,klib->klab", weighted, s),
        "Mee": pairs.trace(axis1=2, axis2=3),
    }


def without_rounding(x: Array) -> Array:
    """Return an array whose entries are zero where they are rounding only."""
    return np.where(np.abs(x) > ROUNDING * np.abs(x).max(initial=0.0), x, 0.0)


def _tuples(x: Any) -> Any:
    return tuple(map(_tuples, x)) if np.ndim(x) else float(x)
