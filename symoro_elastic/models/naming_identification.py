"""Names of the entries of regressors."""

from __future__ import annotations

from collections.abc import Iterable

from symoro_elastic.equations.dynamics import Dynamics
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.naming import name_dynamics
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.program import Section


def name_regressor(bound: Bound, found: Dynamics, entries: Iterable[tuple[int, int, str, Scalar]]) -> None:
    """Name velocities and accelerations, and the entries of Y: (row's joint, column's joint, parameter, entry)."""
    name_dynamics(bound, found, "[15]", "[61]")
    for row, j, parameter, x in entries:
        bound.names.give(x, f"Y{row}_{parameter}{j}", Section("Regressor", j, "[15]"))
