"""A machine with its drives: its plants at positions, motors without a drive held, and the drives with their gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, cascade_of
from symoro_elastic.analysis.control.optimum import optimum
from symoro_elastic.analysis.control.plant import Axis, Plant, position_row
from symoro_elastic.analysis.control.tuning import Distances, tuned
from symoro_elastic.analysis.vibration.linearization import Linearization, linearize
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.analysis.vibration.responses import with_modal_damping
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR, Drive
from symoro_elastic.machine.free_base import with_base_coordinates
from symoro_elastic.machine.joints import Kind
from symoro_elastic.machine.machine import Machine
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
    """Plants at positions, drives with gains; `tuned` are the gains that were found, as motor.Kp."""

    plants: tuple[Plant, ...]
    cascades: tuple[Cascade, ...]
    tuned: tuple[str, ...]
    notes: tuple[str, ...]


def driven_machine(
    motion: EquationsOfMotion,
    states: States,
    distances: Distances,
    damping: float,
    tune: bool,
    signals: Sequence[str],
    together: bool = False,
) -> DrivenMachine:
    """Return a machine at some states with its drives; with `tune` all gains are sought, else those left to tuning.

    `signals` are outputs that have rows in the linearizations; gains that are sought `together` have the least peak of
    their compliances. Raises `InputError`.
    """
    drives = drives_of(motion.driven).by_motor
    joints = {joint.name: joint for joint in motion.driven.joints}
    cascades = [cascade_of(joints[name], one, motion.numbers, motion.source) for name, one in drives.items()]
    if tune:
        cascades = [_sought(one, drives[one.motor]) for one in cascades]
    plants = tuple(_plant(motion, state, place, drives, damping, signals) for place, state in states)
    for plant in plants:
        _refuse_free(plant)
    found = tuple(f"{one.motor}.{key}" for one in cascades for key in one.sought)
    if found:
        for plant in plants:
            _refuse_undamped(plant)
        cascades = tuned(plants, cascades, distances)
    notes = _notes(plants[0], cascades)
    if together and found:
        best = optimum(plants, cascades, distances, signals)
        cascades, notes = [*best.cascades], (*notes, best.told(signals))
    return DrivenMachine(plants, tuple(cascades), found, notes)


def refuse_without_drives(motion: EquationsOfMotion) -> None:
    """Raise `InputError` for a machine without drives, with the table to write."""
    if drives_of(motion.asked):
        return
    motors = [joint.name for joint in motion.asked.motor_joints]
    example = f'{motors[0]} = {{ Kv = "tuned", Kp = "tuned", Tn = "tuned", dead_time = 1.5e-4 }}' if motors else ""
    what = f"no motor has one: write {example} below [drives]" if motors else "the machine has no motor"
    raise InputError(motion.source, "drives", what)


def _sought(one: Cascade, drive: Drive) -> Cascade:
    """Return a cascade all of whose gains are sought; it stays without integral part."""
    keys = ("Kp", "Kv") if drive.Tn is None else ("Kp", "Tn", "Kv")
    return replace(one.with_gains(**dict.fromkeys(keys, np.nan)), sought=keys)


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
    """Return the machine about a state, with the rows of its axes; motors without a drive are held."""
    linear = linearize(motion, state, (), [*dict.fromkeys([*signals, *measured_positions(motion.asked)])])
    linear = with_modal_damping(linear, damping)
    axes = {}
    for name, velocity in zip(motion.motor_names, linear.motors, strict=True):
        drive = drives.get(name)
        axes[name] = Axis(name, velocity, _position(linear, name, velocity, drive) if drive else velocity)
    held = tuple(name for name in motion.motor_names if name not in drives)
    return Plant(linear, axes, damping, held, place)


def measured_positions(machine: Machine) -> tuple[str, ...]:
    """Return the positions that drives measure in place of their motors'; raises `InputError` for other signals."""
    measured = {name: one.measured for name, one in drives_of(machine).by_motor.items() if one.measured != MOTOR}
    for motor, signal in measured.items():
        positions(with_base_coordinates(machine), [signal], f"drives, {motor}, measured")
    return tuple(dict.fromkeys(measured.values()))


def _position(linear: Linearization, motor: str, velocity: Array, drive: Drive) -> Array:
    """Return the row of a controlled position, over what it changes with the motor where springs do not deflect."""
    if drive.measured == MOTOR:
        return velocity
    position: Array = position_row(linear, drive.measured) / load_ratio(linear, motor, velocity, drive.measured)
    return position


def load_ratio(linear: Linearization, motor: str, velocity: Array, measured: str) -> float:
    """Return what a measured position changes with its motor where springs do not deflect; raises `InputError`."""
    row = position_row(linear, measured)
    ratio = float(row @ velocity) / float(velocity @ velocity)
    if abs(ratio) <= 1e-9 * np.abs(row).max(initial=0.0):
        what = f"{measured} does not move with {motor} here: name a position behind it"
        raise InputError(linear.motion.source, f"drives, {motor}, measured", what)
    return ratio


def _refuse_free(plant: Plant) -> None:
    """Raise `InputError` for a motion that no motor makes and nothing holds back, whose poles are 0."""
    linear = plant.linear
    laws = [x / (np.linalg.norm(x) or 1.0) for x in (linear.K, linear.D, *linear.motors)]
    _, sizes, motions = np.linalg.svd(np.vstack(laws))
    if len(sizes) and sizes[-1] < NOTHING:
        coordinate = linear.coordinates[int(np.argmax(np.abs(motions[-1])))]
        what = f"nothing holds {coordinate} back, so loops are neither stable nor unstable: give it a spring or a motor"
        raise InputError(linear.motion.source, "drives", what)


def _refuse_undamped(plant: Plant) -> None:
    """Raise `InputError` where a mode has no damping, so that gains would have no meaning."""
    poles = damped_poles(plant.linear)[0]
    swinging = poles[(poles.imag > 0) & (np.abs(poles.real) <= UNDAMPED * np.abs(poles))]
    if len(swinging):
        least_one = float(np.abs(swinging).min()) / (2 * np.pi)
        what = (
            f"modes without damping: {len(swinging)}, the lowest at {least_one:.4g} Hz. Gains depend on it: give "
            "[springs] damping, or a ratio for all modes, as 0.01"
        )
        raise InputError(plant.linear.motion.source, "--damping", what)


def _notes(plant: Plant, cascades: Sequence[Cascade]) -> tuple[str, ...]:
    held = [f"{name} has no drive and is held" for name in plant.held]
    limited = ", ".join(one.motor for one in cascades if one.is_limited)
    what = "limits of torque, current and voltage" if any(one.current for one in cascades) else "limits of torque"
    said = [f"{what} ({limited}) are not in these figures: they are linear"] if limited else []
    return (*plant.linear.doubts, *held, *said)
