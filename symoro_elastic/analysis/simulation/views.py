"""Simulated motions as tables, as sentences, as data for JSON, and as columns of a file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.periods import quantity
from symoro_elastic.analysis.simulation.simulated import FORMS, Crossing, EnergyBalance, Simulation, Simulations
from symoro_elastic.analysis.simulation.tolerances import unit_of
from symoro_elastic.analysis.time_series import writing
from symoro_elastic.analysis.time_series.measurements import ENERGY, POWER
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
from symoro_elastic.models.steps.time_steps import dependent_motors
from symoro_elastic.numerics.evaluation.closed_positions import JointCoordinates
from symoro_elastic.numerics.evaluation.values import given_values
from symoro_elastic.quantities import ON_BASE

UNBALANCED = 1e-2
"""Of the largest energy: the error of the balance if torques are not exact."""


def _step(run: Simulation) -> str:
    step = run.trajectory.step
    return f"{step:.4g} s" if run.operations else f"{step:.2g} s on average"


def _largest_deviation(run: Simulation) -> dict[str, float]:
    return dict(zip(run.names, abs(run.deviation).max(axis=0).tolist(), strict=True))


def _motor_figures(run: Simulation) -> dict[str, dict[str, float]]:
    """Return peak and RMS torque (N m or N), peak speed, peak power (W) and work (J) of the motors."""
    _, rates = run.reference.of_motors(run.motion)
    powers, t, figures = run.powers, run.motion.t, {}
    trapezoid = for_vibrations("scipy.integrate").trapezoid
    for m, motor in enumerate(run.reference.motors):
        tau = run.motion.tau[:, m]
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
    *map(Field, ("errors", "tolerance", "predicted")),
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
def _(run: Simulation) -> list[Part]:
    title = f"{run.reference.machine.name}: {run.reference.prescribed.place}, {run.motion.t[-1]:g} s"
    if run.is_exact:
        note = f"motors that follow exactly move every joint: torques of the inverse model at {len(run.motion.t)} times"
        return [title, note, _motors_table(run), *_lines(run)]
    return [table_of(Simulation, [run], title), _errors_table(run), _motors_table(run), *_lines(run)]


def _motors_table(run: Simulation) -> Table:
    """Return peak and RMS torque, peak power, work and peak speed of the motors."""
    table = Table(("motor", "peak torque", "RMS torque", "peak speed", "peak power, W", "work, J"))
    for joint, figures in zip(run.reference.machine.motor_joints, _motor_figures(run).values(), strict=True):
        torque, effective, speed, power, work = (f"{x:.4g}" for x in figures.values())
        torque, speed = f"{torque} {joint.force_unit}", f"{speed} {joint.unit}/s"
        table.add_row(joint.name, torque, effective, speed, power, work)
    return table


@arrays_of.register
def _(run: Simulation) -> dict[str, Array]:
    """Return t, q_, qd_, qdd_ of joints and tau_ of motors, a row a step, as records of measurements have them.

    Joints are the independent ones, and those of motors that follow from loops.
    """
    motion = run.motion
    joints = [joint.name for joint in run.reference.machine.independent_joints]
    blocks = (("q", motion.q, joints), ("qd", motion.qd, joints), ("qdd", motion.qdd, joints))
    of_motors = _of_dependent_motors(run)
    of_joints = writing.columns_of(motion.t, *blocks, *of_motors, ("tau", motion.tau, run.reference.motors))
    of_base = [(row.entries, motion.base[row.name]) for row in ON_BASE if row.name in motion.base]
    return of_joints | {entry: block[:, k] + 0.0 for names, block in of_base for k, entry in enumerate(names)}


@columns_of.register
def _(run: Simulation) -> dict[str, Array]:
    """Return the arrays, powers and energies, and the outputs."""
    return {**record(run), **dict(zip(run.names, run.outputs.T, strict=True))}


@parts_of.register
def _(runs: Simulations) -> list[Part]:
    return [part for run in runs for part in run.parts()]


@json_of.register
def _(runs: Simulations) -> dict[str, Any]:
    """Return the name of the machine, and the motions."""
    return {"name": runs[0].reference.machine.name if runs else "", "motions": [run.as_json() for run in runs]}


@arrays_of.register
def _(runs: Simulations) -> dict[str, Array]:
    """Return the arrays of all motions, `t_1`, `t_2` and so on where there are several."""
    if len(runs) == 1:
        return runs[0].arrays()
    return {f"{name}_{k}": x for k, run in enumerate(runs, 1) for name, x in run.arrays().items()}


@columns_of.register
def _(runs: Simulations) -> dict[str, Any]:
    """Return the columns of all motions below each other, with the number of the `motion` where there are several."""
    parts = [run.columns() for run in runs]
    if len(parts) == 1:
        return parts[0]
    numbers = np.repeat(np.arange(1, len(parts) + 1), [len(columns["t"]) for columns in parts])
    return {"motion": numbers, **{name: np.concatenate([columns[name] for columns in parts]) for name in parts[0]}}


def record(run: Simulation) -> dict[str, Array]:
    """Return the columns of a file: the arrays, `power_` of the motors, W, and `energy_` of the forms, J."""
    powers = {f"{POWER}{motor}": x for motor, x in zip(run.reference.motors, run.powers.T, strict=True)}
    energies = {f"{ENERGY}{form}": x for form, x in zip(FORMS, run.energy.energies.T, strict=True)}
    return {**run.arrays(), **powers, **energies}


def _of_dependent_motors(run: Simulation) -> Iterator[tuple[str, Array, list[str]]]:
    """Yield positions, velocities and accelerations of the motors on dependent joints."""
    machine, motion = run.reference.machine, run.motion
    joints = dependent_motors(machine)
    if joints:
        names = [machine.joint(j).name for j in joints]
        blocks = JointCoordinates(machine, joints)(motion)
        yield from ((quantity, block, names) for quantity, block in zip(("q", "qd", "qdd"), blocks, strict=True))


def _errors_table(run: Simulation) -> Table:
    """Return the errors of the outputs: measured, allowed and predicted, and the largest deviations."""
    table = Table(("output", "error measured", "tolerance", "predicted", "largest deviation", ""))
    for name, deviation in _largest_deviation(run).items():
        error, limit, predicted = (run.errors[name], run.tolerance.get(name), run.predicted.get(name))
        table.add_row(
            f"{name}, {unit_of(run.reference.machine, name)}",
            f"{error:.2e}",
            "-" if limit is None else f"{limit:.2e}",
            "-" if predicted is None or np.isnan(predicted) else f"{predicted:.2e}",
            f"{deviation:.4g}",
            "" if limit is None else "ok" if error <= limit else "above its tolerance",
        )
    return table


def _lines(run: Simulation) -> list[str]:
    """Return sentences about energy, limits of joints, vibrations, periods of a controller and events."""
    energy = run.energy
    lines = [
        f"energy: {energy.put_in:.5g} J put in, {energy.dissipated:.5g} J dissipated, {energy.stored:.5g} J stored; "
        f"balance error {energy.left_over:.1e} J (peak energy of motion and springs {energy.largest:.4g} J)"
    ]
    if abs(energy.left_over) > UNBALANCED * energy.largest:
        what = "energies and torques are less accurate than the outputs"
        lines.append(f"{what}: add torques (<motor>.tau) to the tolerances")
    lines += map(str, run.beyond)
    driven = {} if run.reference.drives else drives_of(run.reference.machine).by_motor
    if driven:
        way = "exact motions" if run.reference.servo is None else "the servos of the motion"
        lines.append(f"[drives] are not simulated: {', '.join(driven)} with {way}")
    lines += _creeping(run)
    if run.followed is not None:
        lines.append(f"vibrations above {run.followed:.4g} Hz are damped, not followed")
    if run.largest_step < float("inf"):
        lines.append(f"{run.trajectory.method} is stable up to steps of {run.largest_step:.3g} s here")
    for x in run.crossings:
        lines.append(f"{x.signal} crosses {x.level:g} {'upwards' if x.upwards else 'downwards'} at {x.t:.9g} s")
    return lines


def _creeping(run: Simulation) -> list[str]:
    """Return lines on the creep of joints that dry friction holds, below the regularization speed."""
    machine, motion, values = (run.reference.machine, run.motion, given_values(run.reference.machine))
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
