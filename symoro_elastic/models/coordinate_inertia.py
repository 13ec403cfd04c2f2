"""The inertia matrix and velocity forces over the independent variables."""

from __future__ import annotations

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.lagrange import InertiaMatrix, inertia_matrix, of_coordinates
from symoro_elastic.mechanics.mechanism import without_loads
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.rules import held_rules


def coordinate_inertia(bound: Bound) -> InertiaMatrix:
    """A over the independent variables: S^T A S of that of the tree (L21)."""
    found = inertia_matrix(bound.without_tip_angles)
    return of_coordinates(found, bound.coordinates.S, bound.machine.independent) if bound.machine.is_coupled else found


def coordinate_velocity_forces(bound: Bound) -> dict[int, Scalar]:
    """Coriolis and centrifugal forces by independent joint, on a base at rest: S^T of those of the tree (L20)."""
    found = dynamics(without_loads(bound.without_tip_angles), bound.rates(), held_rules(bound))
    return bound.on_independent(found.Gamma)
