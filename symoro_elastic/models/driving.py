"""Inverse dynamic model where motors are on dependent joints, or more than the freedoms they drive."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.loops.motors import Driven, driven_motion, shared_torques
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.coordinate_inertia import coordinate_inertia
from symoro_elastic.models.loops.independent_rows import independent
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.models.rules import held_rules
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate


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
    found = driven_motion(_inertia(bound), _rest(bound), {m: rows[m] for m in kept}, wanted)
    if len(kept) == len(rows):
        return found
    named = {m: 1 if machine.joint(m).sharing.is_zero else shares[m] for m in rows}
    return Driven(found.udd, shared_torques(rows, kept, found.tau, named))


def independent_motors(bound: Bound, rows: Mapping[int, Mapping[int, Scalar]]) -> list[int]:
    """Motors whose rows of S are not a combination of those before them, at an assembled position of the machine."""
    machine = bound.machine
    if not machine.loops:
        return list(rows)
    plan = plan_of(machine)
    entries = [row.get(k, 0) for row in rows.values() for k in machine.independent]
    matrices = []
    for position in plan.positions:
        value = evaluate(entries, plan.assembly.symbols(position), FLOATS)
        matrices.append(np.array([float(value(x)) for x in entries]).reshape(len(rows), -1))
    return [list(rows)[k] for k in independent(matrices)]


def _too_many(machine: Machine, motors: int, freedoms: int) -> str:
    determined = "combination of torques is" if freedoms == 1 else "combinations of torques are"
    return f"{drive(motors, freedoms)}: only {freedoms} {determined} determined; give sharing, or make the beam elastic"


def drive(motors: int, freedoms: int) -> str:
    """How many freedoms motors drive: `2 motors drive 1 freedom`."""
    return f"{motors} motors drive {freedoms} {'freedom' if freedoms == 1 else 'freedoms'}"


def _inertia(bound: Bound) -> dict[int, dict[int, Scalar]]:
    A, independent = coordinate_inertia(bound).A, bound.machine.independent
    return {i: {j: A[i][j] for j in independent} for i in independent}


def _rest(bound: Bound) -> dict[int, Scalar]:
    """H less what springs, dampers and friction exert."""
    held = dynamics(bound.unaccelerated_mechanism, bound.rates(), held_rules(bound))
    bias, passive = bound.on_independent(held.Gamma), bound.passive_forces()
    return {k: bias[k] - passive[k] for k in bound.machine.independent}
