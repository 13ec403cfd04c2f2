"""A machine with its drives: plants at positions, motors without a drive locked, and the drives with their gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.control.cascade import GAINS, Cascade, cascade_of, omitted_limits
from symoro_elastic.analysis.control.optimum import optimum
from symoro_elastic.analysis.control.plant import Axis, Plant, position_row
from symoro_elastic.analysis.control.tuning import Tuning, tuned_cascades
from symoro_elastic.analysis.vibration.linearization import Linearization, linearize
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.analysis.vibration.responses import with_modal_damping
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR, Drive
from symoro_elastic.machine.frames import with_base_coordinates
from symoro_elastic.machine.joints import Kind
from symoro_elastic.machine.machine import NO_MOTOR, Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.signals import positions

UNDAMPED = 1e-6
"""Of a pole: a damping ratio below is none."""
NOTHING = 1e-12
"""Stiffness and damping of a motion, relative to the largest, that are none."""
States = Sequence[tuple[Mapping[str, float], State]]
"""States with the positions that were asked for."""


@dataclass(frozen=True)
class DrivenMachine:
    """Plants at positions, drives with gains; `tuned` names the gains that were computed, as motor.Kp."""

    plants: tuple[Plant, ...]
    cascades: tuple[Cascade, ...]
    tuned: tuple[str, ...]
    notes: tuple[str, ...]


def driven_machine(
    motion: EquationsOfMotion, states: States, tuning: Tuning, damping: float, signals: Sequence[str]
) -> DrivenMachine:
    """Return a machine at some states with its drives, their gains tuned.

    `signals` are outputs that have rows in the linearizations; gains that are tuned together have the least peak of
    their compliances. Raises `InputError`.
    """
    drives = drives_of(motion.driven).by_motor
    joints = {joint.name: joint for joint in motion.driven.joints}
    cascades = [cascade_of(joints[name], drive, motion.numbers, motion.source) for name, drive in drives.items()]
    if tuning.all_gains:
        for k, cascade in enumerate(cascades):
            keys = ("Kp", "Kv") if drives[cascade.motor].Tn is None else GAINS  # without integral part it stays so
            cascades[k] = replace(cascade.with_gains(**dict.fromkeys(keys, np.nan)), tuned_gains=keys)
    plants = tuple(_plant(motion, state, place, drives, damping, signals) for place, state in states)
    for plant in plants:
        _refuse_free(plant)
    tuned_gains = tuple(f"{cascade.motor}.{key}" for cascade in cascades for key in cascade.tuned_gains)
    if tuned_gains:
        for plant in plants:
            refuse_undamped(plant, damped_poles(plant.linear)[0], "Gains depend on it")
        cascades = tuned_cascades(plants, cascades, tuning.distances)
    notes = _notes(plants[0], cascades)
    if tuning.together and tuned_gains:
        best = optimum(plants, cascades, tuning.distances, signals)
        cascades, notes = [*best.cascades], (*notes, best.summary(signals))
    return DrivenMachine(plants, tuple(cascades), tuned_gains, notes)


def refuse_without_drives(motion: EquationsOfMotion) -> None:
    """Raise `InputError` for a machine without drives, with an example of the table."""
    if drives_of(motion.asked):
        return
    motors = [joint.name for joint in motion.asked.motor_joints]
    example = f'{motors[0]} = {{ Kv = "tuned", Kp = "tuned", Tn = "tuned", dead_time = 1.5e-4 }}' if motors else ""
    what = f"no motor has one: write {example} below [drives]" if motors else NO_MOTOR
    raise InputError(motion.source, "drives", what)


def default_compliances(machine: Machine) -> tuple[str, ...]:
    """Return x, y, z of the last fixed frame, else of the last row."""
    fixed = [joint.name for joint in machine.joints if joint.kind is Kind.FIXED]
    frame = (fixed or [machine.joints[-1].name])[-1]
    return tuple(f"{frame}.{axis}" for axis in "xyz")


def _plant(
    motion: EquationsOfMotion,
    state: State,
    place: Mapping[str, float],
    drives: Mapping[str, Drive],
    damping: float,
    signals: Sequence[str],
) -> Plant:
    """Return the machine about a state, with the rows of its axes; motors without a drive are locked."""
    linear = linearize(motion, state, (), [*dict.fromkeys([*signals, *measured_positions(motion.asked)])])
    linear = with_modal_damping(linear, damping)
    axes = {}
    for name, velocity in zip(motion.motor_names, linear.motors, strict=True):
        drive = drives.get(name)
        measured = drive.measured if drive and drive.measured != MOTOR else ""
        axes[name] = Axis(name, velocity, _position(linear, name, velocity, measured), measured)
    locked = tuple(name for name in motion.motor_names if name not in drives)
    return Plant(linear, axes, damping, locked, place)


def measured_positions(machine: Machine) -> tuple[str, ...]:
    """Return the positions that drives measure in place of their motors'; raises `InputError` for other signals."""
    measured = {name: drive.measured for name, drive in drives_of(machine).by_motor.items() if drive.measured != MOTOR}
    for motor, signal in measured.items():
        positions(with_base_coordinates(machine), [signal], f"drives, {motor}, measured")
    return tuple(dict.fromkeys(measured.values()))


def _position(linear: Linearization, motor: str, velocity: Array, measured: str) -> Array:
    """Return the row of a controlled position, divided by its change per motor position with rigid springs."""
    if not measured:
        return velocity
    return np.asarray(position_row(linear, measured) / load_ratio(linear, motor, velocity, measured))


def load_ratio(linear: Linearization, motor: str, velocity: Array, measured: str) -> float:
    """Return the change of a measured position per motor position with rigid springs; raises `InputError`."""
    row = position_row(linear, measured)
    ratio = float(row @ velocity) / float(velocity @ velocity)
    if abs(ratio) <= 1e-9 * np.abs(row).max(initial=0.0):
        what = f"{measured} does not move with {motor} here: name a position behind it"
        raise InputError(linear.motion.source, f"drives, {motor}, measured", what)
    return ratio


def _refuse_free(plant: Plant) -> None:
    """Raise `InputError` for a free motion, without motor and spring, whose poles are 0."""
    linear = plant.linear
    laws = [x / (np.linalg.norm(x) or 1.0) for x in (linear.K, linear.D, *linear.motors)]
    _, sizes, motions = np.linalg.svd(np.vstack(laws))
    if len(sizes) and sizes[-1] < NOTHING:
        coordinate = linear.coordinates[int(np.argmax(np.abs(motions[-1])))]
        what = f"nothing holds {coordinate} back, so loops are neither stable nor unstable: give it a spring or a motor"
        raise InputError(linear.motion.source, "drives", what)


def refuse_undamped(plant: Plant, poles: ComplexArray, why: str) -> None:
    """Raise `InputError` if poles, 1/s, oscillate without damping, and say `why` that matters."""
    swinging = np.abs(poles[is_undamped(poles)]) / (2 * np.pi)
    if len(swinging):
        what = (
            f"modes without damping: {len(swinging)}, the lowest at {swinging.min():.4g} Hz. {why}: give "
            "[springs] damping, or a ratio for all modes, as 0.01"
        )
        raise InputError(plant.linear.motion.source, "--damping", what)


def is_undamped(poles: ComplexArray) -> BoolArray:
    """Return which poles oscillate without damping, those with positive imaginary parts."""
    return (poles.imag > 0) & (np.abs(poles.real) <= UNDAMPED * np.abs(poles))


def _notes(plant: Plant, cascades: Sequence[Cascade]) -> tuple[str, ...]:
    notes = [f"{name} has no drive and is held" for name in plant.held]
    return (*plant.linear.doubts, *notes, *omitted_limits(cascades))
