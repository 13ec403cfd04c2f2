"""Simulated motions as tables, as sentences, as data for JSON, and as columns of a file."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan
from typing import Any

import numpy as np
from rich.table import Table

from symoro_elastic.array_types import Array
from symoro_elastic.models.motor_coordinates import dependent_motors
from symoro_elastic.numerics.own_motion import OwnMotion
from symoro_elastic.numerics.values import given_values
from symoro_elastic.packages import for_vibrations
from symoro_elastic.quantities import ON_BASE
from symoro_elastic.simulation.moving_base import BaseStates
from symoro_elastic.simulation.periods import quantity
from symoro_elastic.simulation.simulated import Simulation
from symoro_elastic.simulation.tolerances import unit_of
from symoro_elastic.time_series.writing import columns_of

UNBALANCED = 1e-2
"""Of the largest energy: what is left over where torques are not exact."""


def simulation_columns(found: Simulation) -> dict[str, Array]:
    """Return the columns t, q_, qd_, qdd_ of joints and tau_ of motors, as records of measurements have them.

    Joints are the independent ones, and those of motors that follow from loops.
    """
    motion = found.motion
    joints = [joint.name for joint in found.reference.machine.moving_joints]
    blocks = (("q", motion.q, joints), ("qd", motion.qd, joints), ("qdd", motion.qdd, joints))
    of_motors = _of_dependent_motors(found)
    of_joints = columns_of(motion.t, *blocks, *of_motors, ("tau", motion.tau, found.reference.motors))
    return of_joints | _base_columns(motion.base)


def _of_dependent_motors(found: Simulation) -> Iterator[tuple[str, Array, list[str]]]:
    """Yield positions, velocities and accelerations of the motors that follow from loops."""
    machine, motion = found.reference.machine, found.motion
    joints = dependent_motors(machine)
    if joints:
        names = [machine.joint(j).name for j in joints]
        blocks = OwnMotion(machine, joints)(motion.q, motion.qd, motion.qdd, motion.q_dep)
        yield from ((quantity, block, names) for quantity, block in zip(("q", "qd", "qdd"), blocks, strict=True))


def _base_columns(base: BaseStates) -> dict[str, Array]:
    """Return a column for each entry of the arrays of a floating base, named as in generated code: P0_x, V0_1 ..."""
    found = [(row.entries, base[row.name]) for row in ON_BASE if row.name in base]
    return {entry: block[:, k] + 0.0 for entries, block in found for k, entry in enumerate(entries)}


def steps_table(found: Simulation) -> Table:
    """Return how a motion was integrated: method, steps, operations and time of a step."""
    table = Table(box=None, padding=(0, 3, 0, 0))
    for title in ("method", "steps", "step", "operations", "time of a step", "of all steps"):
        table.add_column(title, justify="left" if title == "method" else "right")
    run = found.trajectory
    even = f"{run.step:.4g} s" if found.operations else f"{run.step:.2g} s on average"
    operations = f"{found.operations}" if found.operations else "-"
    table.add_row(
        run.method, f"{run.steps}", even, operations, quantity(run.seconds, "s"), quantity(run.seconds * run.steps, "s")
    )
    return table


def errors_table(found: Simulation) -> Table:
    """Return the errors of the outputs: measured, allowed and predicted, and how far they are from the reference."""
    table = Table(box=None, padding=(0, 3, 0, 0))
    for title in ("output", "error measured", "tolerance", "predicted", "largest deviation", ""):
        table.add_column(title, justify="left" if title in ("output", "") else "right")
    for k, name in enumerate(found.names):
        error, limit = found.errors[name], found.tolerance.get(name)
        predicted = found.predicted.get(name)
        table.add_row(
            f"{name}, {unit_of(found.reference.machine, name)}",
            f"{error:.2e}",
            "-" if limit is None else f"{limit:.2e}",
            "-" if predicted is None or isnan(predicted) else f"{predicted:.2e}",
            f"{abs(found.deviation[:, k]).max():.4g}",
            "" if limit is None else "ok" if error <= limit else "above its tolerance",
        )
    return table


def simulation_lines(found: Simulation) -> list[str]:
    """Return sentences about energy, vibrations, periods of a controller and events."""
    energy = found.energy
    lines = [
        f"energy: {energy.put_in:.5g} J put in, {energy.dissipated:.5g} J dissipated, {energy.stored:.5g} J stored; "
        f"{energy.left_over:.1e} J left over, of up to {energy.largest:.4g} J of motion and springs"
    ]
    if abs(energy.left_over) > UNBALANCED * energy.largest:
        lines.append(
            "energies and torques are less exact than the outputs: add torques (<motor>.tau) to the tolerances"
        )
    lines += _creeping(found)
    if found.followed is not None:
        lines.append(f"vibrations above {found.followed:.4g} Hz are damped, not followed")
    if found.largest_step < float("inf"):
        lines.append(f"{found.trajectory.method} is stable up to steps of {found.largest_step:.3g} s here")
    for x in found.crossings:
        lines.append(f"{x.signal} crosses {x.level:g} {'upwards' if x.upwards else 'downwards'} at {x.t:.9g} s")
    return lines


def _creeping(found: Simulation) -> list[str]:
    """Return how far joints creep while dry friction holds them, at less than the speed of its law."""
    machine, motion, values = found.reference.machine, found.motion, given_values(found.reference.machine)
    trapezoid = for_vibrations("scipy.integrate").trapezoid
    lines = []
    for k, joint in enumerate(machine.moving_joints):
        speed, unit = joint.friction.creep.value(values), joint.unit
        if speed and joint.friction.coulomb.value(values):
            rates = np.abs(motion.qd[:, k])
            crept = trapezoid(np.where(rates < speed, rates, 0.0), motion.t)
            what = f"by a creep below {speed:g} {unit}/s: {crept:.2g} {unit} in all"
            lines.append(f"dry friction holds {joint.name} {what}")
    return lines


def simulation_json(found: Simulation) -> dict[str, Any]:
    """Return the figures of a motion."""
    run, energy = found.trajectory, found.energy
    return {
        "motion": found.reference.prescribed.place,
        "method": run.method,
        "steps": run.steps,
        "step": run.step,
        "operations": found.operations or None,
        "seconds_per_step": run.seconds,
        "errors": _finite(found.errors),
        "tolerance": _finite(found.tolerance),
        "predicted": _finite(found.predicted),
        "within_tolerance": found.is_within,
        "largest_deviation": dict(zip(found.names, abs(found.deviation).max(axis=0).tolist(), strict=True)),
        "energy": {
            "put_in": energy.put_in,
            "dissipated": energy.dissipated,
            "stored": energy.stored,
            "left_over": energy.left_over,
            "largest": energy.largest,
        },
        "damped_above": found.followed,
        "largest_step": found.largest_step if found.largest_step < float("inf") else None,
        "steps_of_period": found.steps_of_period or None,
        "events": [{"signal": x.signal, "level": x.level, "t": x.t, "upwards": x.upwards} for x in found.crossings],
    }


def _finite(numbers: Any) -> dict[str, float | None]:
    return {name: x if abs(x) < float("inf") else None for name, x in numbers.items()}
