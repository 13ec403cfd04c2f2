"""Simulated motions as tables, as sentences, as data for JSON, and as columns of a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.energy_balance import FORMS, EnergyBalance
from symoro_elastic.analysis.simulation.events import Crossing
from symoro_elastic.analysis.simulation.periods import quantity
from symoro_elastic.analysis.simulation.simulated import Simulation, Simulations
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.analysis.time_series import writing
from symoro_elastic.analysis.time_series.named_columns import ENERGY, POWER
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.results import (
    Field,
    Part,
    Table,
    arrays_of,
    columns_of,
    declare,
    json_of,
    parts_of,
    table_of,
)
from symoro_elastic.machine.described import drives_of
from symoro_elastic.models.motor_coordinates import dependent_motors
from symoro_elastic.numerics.closed_positions import JointCoordinates
from symoro_elastic.numerics.values import given_values
from symoro_elastic.quantities import ON_BASE

UNBALANCED = 1e-2
"""Of the largest energy: what is left over where torques are not exact."""


def _step(found: Simulation) -> str:
    step = found.trajectory.step
    return f"{step:.4g} s" if found.operations else f"{step:.2g} s on average"


def _largest_deviation(found: Simulation) -> dict[str, float]:
    return dict(zip(found.names, abs(found.deviation).max(axis=0).tolist(), strict=True))


def _motor_figures(found: Simulation) -> dict[str, dict[str, float]]:
    """Return largest and effective torque, largest speed and power, and work of each motor, N m or N, W, J."""
    _, rates = found.reference.of_motors(found.motion)
    powers, t, figures = found.powers, found.motion.t, {}
    trapezoid = for_vibrations("scipy.integrate").trapezoid
    for m, motor in enumerate(found.reference.motors):
        tau = found.motion.tau[:, m]
        figures[motor] = {
            "largest_torque": float(np.abs(tau).max()),
            "effective_torque": float(np.sqrt(trapezoid(tau**2, t) / t[-1])),
            "largest_speed": float(np.abs(rates[:, m]).max()),
            "largest_power": float(np.abs(powers[:, m]).max()),
            "work": float(trapezoid(powers[:, m], t)),
        }
    return figures


declare(
    Simulation,
    Field("motion", "reference.prescribed.place"),
    Field("method", "trajectory.method", "method"),
    Field("steps", "trajectory.steps", "steps"),
    Field("step", "trajectory.step", "step", text=_step),
    Field("operations", lambda x: x.operations or None, "operations"),
    Field(
        "seconds_per_step", "trajectory.seconds", "time of a step", text=lambda x: quantity(x.trajectory.seconds, "s")
    ),
    Field(
        "seconds",
        head="of all steps",
        text=lambda x: quantity(x.trajectory.seconds * x.trajectory.steps, "s"),
        json=False,
    ),
    Field("errors"),
    Field("tolerance"),
    Field("predicted"),
    Field("within_tolerance", "is_within"),
    Field("largest_deviation", _largest_deviation),
    Field("motors", _motor_figures),
    Field("energy"),
    Field("damped_above", "followed"),
    Field("largest_step"),
    Field("steps_of_period", lambda x: x.steps_of_period or None),
    Field("events", "crossings"),
    Field("beyond_limits", "beyond"),
)
declare(EnergyBalance, *map(Field, ("put_in", "dissipated", "stored", "left_over", "largest")))
declare(Crossing, *map(Field, ("signal", "level", "t", "upwards")))


@parts_of.register
def _(found: Simulation) -> list[Part]:
    title = f"{found.reference.machine.name}: {found.reference.prescribed.place}, {found.motion.t[-1]:g} s"
    if found.is_exact:
        said = (
            f"motors that follow exactly move every joint: torques of the inverse model at {len(found.motion.t)} times"
        )
        return [title, said, _motors_table(found), *_lines(found)]
    return [table_of(Simulation, [found], title), _errors_table(found), _motors_table(found), *_lines(found)]


def _motors_table(found: Simulation) -> Table:
    """Return largest and effective torque, largest power and work of each motor, and its largest speed."""
    table = Table(("motor", "largest torque", "effective", "largest speed", "largest power, W", "work, J"))
    for joint, (torque, effective, speed, power, work) in zip(
        found.reference.machine.motor_joints, map(dict.values, _motor_figures(found).values()), strict=True
    ):
        table.add_row(
            joint.name,
            f"{torque:.4g} {joint.force_unit}",
            f"{effective:.4g}",
            f"{speed:.4g} {joint.unit}/s",
            f"{power:.4g}",
            f"{work:.4g}",
        )
    return table


@arrays_of.register
def _(found: Simulation) -> dict[str, Array]:
    """Return t, q_, qd_, qdd_ of joints and tau_ of motors, a row a step, as records of measurements have them.

    Joints are the independent ones, and those of motors that follow from loops.
    """
    motion = found.motion
    joints = [joint.name for joint in found.reference.machine.independent_joints]
    blocks = (("q", motion.q, joints), ("qd", motion.qd, joints), ("qdd", motion.qdd, joints))
    of_motors = _of_dependent_motors(found)
    of_joints = writing.columns_of(motion.t, *blocks, *of_motors, ("tau", motion.tau, found.reference.motors))
    return of_joints | _base_columns(motion.base)


@columns_of.register
def _(found: Simulation) -> dict[str, Array]:
    """Return the arrays, powers and energies, and the outputs."""
    return {**record(found), **dict(zip(found.names, found.outputs.T, strict=True))}


@parts_of.register
def _(found: Simulations) -> list[Part]:
    return [part for one in found for part in one.parts()]


@json_of.register
def _(found: Simulations) -> dict[str, Any]:
    """Return the name of the machine, and the motions."""
    return {"name": found[0].reference.machine.name if found else "", "motions": [one.as_json() for one in found]}


@arrays_of.register
def _(found: Simulations) -> dict[str, Array]:
    """Return the arrays of all motions, `t_1`, `t_2` and so on where there are several."""
    if len(found) == 1:
        return found[0].arrays()
    return {f"{name}_{k}": x for k, one in enumerate(found, 1) for name, x in one.arrays().items()}


@columns_of.register
def _(found: Simulations) -> dict[str, Any]:
    """Return the columns of all motions below each other, with the number of the `motion` where there are several."""
    parts = [one.columns() for one in found]
    if len(parts) == 1:
        return parts[0]
    numbers = np.repeat(np.arange(1, len(parts) + 1), [len(one["t"]) for one in parts])
    return {"motion": numbers, **{name: np.concatenate([one[name] for one in parts]) for name in parts[0]}}


def record(found: Simulation) -> dict[str, Array]:
    """Return the columns of a file: the arrays, `power_` of the motors, W, and `energy_` of each form, J."""
    powers = {f"{POWER}{motor}": x for motor, x in zip(found.reference.motors, found.powers.T, strict=True)}
    energies = {f"{ENERGY}{form}": x for form, x in zip(FORMS, found.energy.energies.T, strict=True)}
    return {**found.arrays(), **powers, **energies}


def _of_dependent_motors(found: Simulation) -> Iterator[tuple[str, Array, list[str]]]:
    """Yield positions, velocities and accelerations of the motors that follow from loops."""
    machine, motion = found.reference.machine, found.motion
    joints = dependent_motors(machine)
    if joints:
        names = [machine.joint(j).name for j in joints]
        blocks = JointCoordinates(machine, joints)(motion)
        yield from ((quantity, block, names) for quantity, block in zip(("q", "qd", "qdd"), blocks, strict=True))


def _base_columns(base: Mapping[str, Array]) -> dict[str, Array]:
    """Return a column for each entry of the blocks of a base, named as in generated code: P0_x, V0_1 ..."""
    found = [(row.entries, base[row.name]) for row in ON_BASE if row.name in base]
    return {entry: block[:, k] + 0.0 for entries, block in found for k, entry in enumerate(entries)}


def _errors_table(found: Simulation) -> Table:
    """Return the errors of the outputs: measured, allowed and predicted, and how far they are from the reference."""
    table = Table(("output", "error measured", "tolerance", "predicted", "largest deviation", ""))
    for name, deviation in _largest_deviation(found).items():
        error, limit, predicted = found.errors[name], found.tolerance.get(name), found.predicted.get(name)
        table.add_row(
            f"{name}, {unit_of(found.reference.machine, name)}",
            f"{error:.2e}",
            "-" if limit is None else f"{limit:.2e}",
            "-" if predicted is None or np.isnan(predicted) else f"{predicted:.2e}",
            f"{deviation:.4g}",
            "" if limit is None else "ok" if error <= limit else "above its tolerance",
        )
    return table


def _lines(found: Simulation) -> list[str]:
    """Return sentences about energy, limits of joints, vibrations, periods of a controller and events."""
    energy = found.energy
    lines = [
        f"energy: {energy.put_in:.5g} J put in, {energy.dissipated:.5g} J dissipated, {energy.stored:.5g} J stored; "
        f"{energy.left_over:.1e} J left over, of up to {energy.largest:.4g} J of motion and springs"
    ]
    if abs(energy.left_over) > UNBALANCED * energy.largest:
        lines.append(
            "energies and torques are less accurate than the outputs: add torques (<motor>.tau) to the tolerances"
        )
    lines += map(str, found.beyond)
    lines += _not_driven(found)
    lines += _creeping(found)
    if found.followed is not None:
        lines.append(f"vibrations above {found.followed:.4g} Hz are damped, not followed")
    if found.largest_step < float("inf"):
        lines.append(f"{found.trajectory.method} is stable up to steps of {found.largest_step:.3g} s here")
    for x in found.crossings:
        lines.append(f"{x.signal} crosses {x.level:g} {'upwards' if x.upwards else 'downwards'} at {x.t:.9g} s")
    return lines


def _not_driven(found: Simulation) -> list[str]:
    """Return that the drives of the file have no part in a motion, where it has any."""
    driven = {} if found.reference.drives else drives_of(found.reference.machine).by_motor
    way = "exact motions" if found.reference.servo is None else "the servos of the motion"
    return [f"[drives] are not simulated: {', '.join(driven)} with {way}"] if driven else []


def _creeping(found: Simulation) -> list[str]:
    """Return how far joints creep while dry friction holds them, at less than the speed of its law."""
    machine, motion, values = found.reference.machine, found.motion, given_values(found.reference.machine)
    trapezoid = for_vibrations("scipy.integrate").trapezoid
    lines = []
    for k, joint in enumerate(machine.independent_joints):
        speed, unit = joint.friction.creep.value(values), joint.unit
        if speed and joint.friction.coulomb.value(values):
            rates = np.abs(motion.qd[:, k])
            crept = trapezoid(np.where(rates < speed, rates, 0.0), motion.t)
            what = f"by a creep below {speed:g} {unit}/s: {crept:.2g} {unit} in all"
            lines.append(f"dry friction holds {joint.name} {what}")
    return lines
