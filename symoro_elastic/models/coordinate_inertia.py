"""The inertia matrix over the independent variables."""

from __future__ import annotations

from symoro_elastic.mechanics.lagrange import InertiaMatrix, inertia_matrix, of_coordinates
from symoro_elastic.models.bind import Bound


def coordinate_inertia(bound: Bound) -> InertiaMatrix:
    """A over the independent variables: S^T A S of that of the tree (L21)."""
    found = inertia_matrix(bound.without_tip_angles)
    return of_coordinates(found, bound.coordinates.S, bound.machine.independent) if bound.machine.is_coupled else found
