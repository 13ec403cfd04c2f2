"""Inverse dynamic model where motors are on dependent joints, or more than the freedoms they drive."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.equations.dynamics import dynamics
from symoro_elastic.equations.loops.motors import Driven, driven, shared
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

INDEPENDENT = 1e-8


def inverse_by_motors(bound: Bound) -> Driven:
    """Torques of all motors and accelerations of independent variables for the accelerations of all motors.

    Raises `InputError` where only sums of torques are determined and no motor has a share.
    """
    machine, coordinates = bound.machine, bound.coordinates
    rows = {m: coordinates.S_x[m] for m in bound.motors}
    kept = independent_motors(bound, rows)
    shares = {m: bound.cell(machine.joint(m).sharing) for m in bound.motors}
    if len(kept) < len(rows) and not any(not machine.joint(m).sharing.is_zero for m in rows):
        raise machine.error("inverse_dynamics", _too_many(machine, len(rows), len(kept)))
    wanted = {m: bound.qdd_motor[m] - coordinates.gam_x[m] for m in kept}
    found = driven(_inertia(bound), _rest(bound), {m: rows[m] for m in kept}, wanted)
    if len(kept) == len(rows):
        return found
    named = {m: 1 if machine.joint(m).sharing.is_zero else shares[m] for m in rows}
    return Driven(found.udd, shared(rows, kept, found.tau, named))


def independent_motors(bound: Bound, rows: Mapping[int, Mapping[int, Scalar]]) -> list[int]:
    """Motors whose rows of S are no combination of those before them, at an assembled position of the machine."""
    machine = bound.machine
    if not machine.loops:
        return list(rows)
    plan = plan_of(machine, Bound)
    kept: list[int] = []
    entries = [x for row in rows.values() for x in row.values()]
    for position in plan.positions:
        symbols = {str(machine.joint(j).variable): x for j, x in position.items()}
        value = evaluate(entries, plan.assembly.values | symbols, FLOATS)
        S = {m: np.array([float(value(row.get(k, 0))) for k in machine.moving]) for m, row in rows.items()}
        found: list[int] = []
        for m in rows:
            if np.linalg.matrix_rank(np.array([S[n] for n in (*found, m)]), tol=INDEPENDENT) > len(found):
                found.append(m)
        kept = max(kept, found, key=len)
    return kept


def _too_many(machine: Machine, motors: int, freedoms: int) -> str:
    combinations = "combination" if freedoms == 1 else "combinations"
    return (
        f"{motors} motors drive {freedoms} freedoms: only {freedoms} {combinations} of torques are determined; "
        "give sharing, or make the beam elastic"
    )


def _inertia(bound: Bound) -> dict[int, dict[int, Scalar]]:
    A, independent = coordinate_inertia(bound).A, bound.machine.moving
    return {i: {j: A[i][j] for j in independent} for i in independent}


def _rest(bound: Bound) -> dict[int, Scalar]:
    """H less what springs, dampers and friction exert."""
    held = dynamics(bound.held, bound.rates(), bound.held_rules())
    bias, passive = bound.on_independent(held.Gamma), bound.passive_forces()
    return {k: bias[k] - passive[k] for k in bound.machine.moving}
