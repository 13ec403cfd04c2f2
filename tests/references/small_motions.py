"""Small motions to 50 digits: forces, their central differences, equilibrium by Newton, frequencies.

    r(q, qd, qdd) = A qdd + H(q, qd) + k (q - q0) + d qd, from `multiprecision`

Differences of step h lose h^2 and the rounding over h; with h = 1e-16 some 30 digits stay.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

from symoro_elastic.machine.machine import Machine
from tests.references.multiprecision import _joint_forces, _read, generalized_forces, in_many_digits, inertia_matrix
from tests.references.numbers_of_machine import Values

STEP = mpf(10) ** -16

Numbers = Sequence[Any]


@in_many_digits
def forces(machine: Machine, q: Numbers, qd: Numbers, qdd: Numbers, values: Values | None = None) -> list[Any]:
    """r, n entries."""
    springs = _joint_forces(_read(machine, values), q, qd)
    return [a - b for a, b in zip(generalized_forces(machine, q, qd, qdd, values), springs, strict=True)]


@in_many_digits
def differences(function: Callable[[list[Any]], list[Any]], at: Numbers, size: str | None = None) -> list[list[Any]]:
    """Central differences of a function of several numbers: entry [row][column]."""
    columns, step = [], mpf(size) if size else STEP
    for k in range(len(at)):
        up, down = [mpf(x) for x in at], [mpf(x) for x in at]
        up[k] += step
        down[k] -= step
        columns.append([(a - b) / (2 * step) for a, b in zip(function(up), function(down), strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


@in_many_digits
def equilibrium(machine: Machine, q: Numbers, sought: Sequence[int], values: Values | None = None) -> list[Any]:
    """q at which r of the sought coordinates is zero at rest, by Newton from q."""
    place, rest = [mpf(x) for x in q], [0] * len(q)
    for _ in range(8):
        slopes = differences(lambda x: forces(machine, x, rest, rest, values), place)
        chosen = mpmath.matrix([[slopes[i][j] for j in sought] for i in sought])
        found = forces(machine, place, rest, rest, values)
        step = mpmath.lu_solve(chosen, mpmath.matrix([-found[i] for i in sought]))
        for k, x in zip(sought, step, strict=True):
            place[k] += x
        if max(map(abs, step)) < mpf(10) ** -25:
            break
    return place


@in_many_digits
def frequencies(machine: Machine, q: Numbers, kept: Sequence[int], values: Values | None = None) -> list[Any]:
    """Natural frequencies of the coordinates that are kept, Hz, ascending."""
    rest = [0] * len(q)
    slopes = differences(lambda x: forces(machine, x, rest, rest, values), q)
    inertia = inertia_matrix(machine, q, values)
    K = mpmath.matrix([[slopes[i][j] for j in kept] for i in kept])
    M = mpmath.matrix([[inertia[i][j] for j in kept] for i in kept])
    lower = mpmath.cholesky(M) ** -1
    reduced = lower * K * lower.T
    squared = mpmath.eigsy((reduced + reduced.T) / 2, eigvals_only=True)
    return sorted(mpmath.sqrt(abs(x)) / (2 * mpmath.pi) for x in squared)


def as_floats(numbers: Any) -> Any:
    """mpf entries as doubles."""
    return np.array(numbers, dtype=float)
