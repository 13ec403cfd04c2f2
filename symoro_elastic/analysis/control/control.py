"""What drives make of a machine: margins and bandwidth by axis, what limits each gain, compliance with loops closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, cascade_of, laplace
from symoro_elastic.analysis.control.closed_loop import ClosedLoop, closed_loop
from symoro_elastic.analysis.control.largest_gain import LargestGain
from symoro_elastic.analysis.control.loops import (
    AxisLoops,
    Margins,
    crossings,
    influences,
    largest_Kp,
    largest_Kv,
    least,
    loops_of,
    margins,
)
from symoro_elastic.analysis.control.plant import Axis, Plant
from symoro_elastic.analysis.control.tuning import Distances, tuned
from symoro_elastic.analysis.vibration.linearization import Linearization, linearize
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.analysis.vibration.responses import with_modal_damping
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.described import DescribedMachine, drives_of
from symoro_elastic.machine.drives import MOTOR, Drive, Drives
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint, Kind
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs

UNDAMPED = 1e-6
"""Of a pole: a damping ratio below is none."""
EDGE = 2**-0.5
BEHIND = np.exp(-0.5j * np.pi)
"""A phase of -90 degrees."""


@dataclass(frozen=True)
class Limit:
    """The largest gain at a distance from instability, its frequency, Hz, and d ln gain / d ln p by each p."""

    key: str
    distance: float
    largest: LargestGain | None
    influences: Mapping[str, float] = field(default_factory=dict)

    @property
    def strongest(self) -> list[tuple[str, float]]:
        """What it depends on most, first the strongest."""
        return sorted(self.influences.items(), key=lambda pair: -abs(pair[1]))


@dataclass(frozen=True)
class AxisControl:
    """One axis with the others closed: margins of its loops, and what its position does by its set point.

    `bandwidth` is where the position falls to 0.707 of the set point, `in_phase` where it is 90 degrees behind, Hz;
    `velocity_error` the time, s, by which it is behind at a steady velocity.
    """

    joint: Joint
    cascade: Cascade
    velocity: Margins
    position: Margins
    bandwidth: float
    in_phase: float
    velocity_error: float
    limits: tuple[Limit, ...]

    @property
    def motor(self) -> str:
        """Name of its joint."""
        return self.joint.name


@dataclass(frozen=True)
class Compliance:
    """The displacement of an output by a force there: at rest, and its peak with its frequency, Hz."""

    output: str
    static: float
    peak: float
    frequency: float
    unit: str


@dataclass(frozen=True)
class PlaceControl:
    """All axes at one position; `growth` is the largest real part of a pole, 1/s."""

    place: Mapping[str, float]
    axes: tuple[AxisControl, ...]
    compliances: tuple[Compliance, ...]
    growth: float


@dataclass(frozen=True, repr=False)
class Control(Result):
    """Axes at positions of a machine; `plants` and `loops` are what they were computed from."""

    machine: str
    places: tuple[PlaceControl, ...]
    distances: Distances
    damping: float
    plants: tuple[Plant, ...]
    tuned: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def cascades(self) -> tuple[Cascade, ...]:
        """The drives with their gains."""
        return tuple(axis.cascade for axis in self.places[0].axes)

    @property
    def loops(self) -> tuple[ClosedLoop, ...]:
        """All loops closed, as one linear system at each position."""
        return tuple(closed_loop(plant, self.cascades) for plant in self.plants)

    @property
    def headline(self) -> str:
        """Machine, axes and positions."""
        axes = ", ".join(one.motor for one in self.cascades)
        return f"Control of {self.machine}: {axes} at {len(self.places)} position{'s' * (len(self.places) > 1)}"


def control_at(
    motion: EquationsOfMotion,
    states: Sequence[tuple[Mapping[str, float], State]],
    distances: Distances,
    damping: float = 0.0,
    tune: bool = False,
    wanted: Sequence[str] = (),
    progress: Progress = no_progress,
) -> Control:
    """Return what the drives of a machine make of it at some states, with the position of each.

    With `tune` all gains are sought, else those that the file leaves to tuning. `wanted` are outputs whose compliance
    is given. Raises `InputError`.
    """
    drives = _drives(motion.asked, motion.source)
    cascades = [cascade_of(name, one, motion.parameters, motion.source) for name, one in drives.items()]
    if tune:
        cascades = [_sought(one, drives[one.motor]) for one in cascades]
    signals = tuple(wanted) or default_compliances(motion.given)
    plants = [_plant(motion, state, place, drives, damping, signals) for place, state in states]
    found = tuple(f"{one.motor}.{key}" for one in cascades for key in one.sought)
    if found:
        for plant in plants:
            _refuse_undamped(plant)
        cascades = tuned(plants, cascades, distances)
    places = []
    for k, plant in enumerate(plants):
        places.append(_place(plant, cascades, distances, signals))
        progress(k + 1, len(plants))
    name = motion.machine.name
    return Control(name, tuple(places), distances, damping, tuple(plants), found, _notes(motion, plants[0]))


def with_gains(machine: Machine, control: Control) -> Machine:
    """Return a machine whose drives have the gains of a result."""
    described = DescribedMachine.of(machine)
    by_motor = dict(described.drives.by_motor)
    for one in control.cascades:
        gains: dict[str, Any] = {key: Formula.parse(float(f"{getattr(one, key):.6g}")) for key in one.sought}
        by_motor[one.motor] = replace(by_motor[one.motor], **gains)
    return replace(described, drives=Drives(by_motor))


def _drives(machine: Machine, source: str) -> Mapping[str, Drive]:
    drives = drives_of(machine).by_motor
    if not drives:
        motors = [joint.name for joint in machine.motor_joints]
        example = f'{motors[0]} = {{ Kv = "tuned", Kp = "tuned", Tn = "tuned", dead_time = 1.5e-4 }}' if motors else ""
        what = f"no motor has one: write {example} below [drives]" if motors else "the machine has no motor"
        raise InputError(source, "drives", what)
    return drives


def _sought(one: Cascade, drive: Drive) -> Cascade:
    """Return a cascade all of whose gains are sought; it stays without integral part."""
    keys = ("Kp", "Kv") if drive.Tn is None else ("Kp", "Tn", "Kv")
    return replace(one.with_gains(**dict.fromkeys(keys, np.nan)), sought=keys)


def default_compliances(machine: Machine) -> tuple[str, ...]:
    """Return x, y, z of the last fixed frame, else of the last row."""
    fixed = [joint.name for joint in machine.joints if joint.kind is Kind.FIXED]
    frame = (fixed or [machine.joints[-1].name])[-1]
    return tuple(f"{frame}.{axis}" for axis in "xyz")


# The plant


def _plant(
    motion: EquationsOfMotion,
    state: State,
    place: Mapping[str, float],
    drives: Mapping[str, Drive],
    damping: float,
    signals: Sequence[str],
) -> Plant:
    """Return the machine about a state, with the rows of its axes; motors without a drive are held."""
    measured = [one.measured for one in drives.values() if one.measured != MOTOR]
    _refuse_velocities(motion, [*signals, *measured])
    linear = linearize(motion, state, (), [*dict.fromkeys([*signals, *measured])])
    linear = with_modal_damping(linear, damping)
    axes = {}
    for name, velocity in zip(motion.motor_names, linear.motors, strict=True):
        drive = drives.get(name)
        axes[name] = Axis(name, velocity, _position(linear, name, velocity, drive) if drive else velocity)
    held = tuple(name for name in motion.motor_names if name not in drives)
    return Plant(linear, axes, damping, held, place)


def _refuse_velocities(motion: EquationsOfMotion, signals: Sequence[str]) -> None:
    for signal in outputs(motion.given, signals):
        if signal.order:
            what = f"{signal.name} is no position: name one, such as tool.x or motor.q"
            raise InputError(motion.source, "drives, measured, or --output", what)


def _position(linear: Linearization, motor: str, velocity: Array, drive: Drive) -> Array:
    """Return the row of a controlled position, over what it changes with the motor where springs do not deflect."""
    if drive.measured == MOTOR:
        return velocity
    row = linear.Cq[linear.outputs.index(" ".join(drive.measured.split()))]
    ratio = float(row @ velocity) / float(velocity @ velocity)
    if abs(ratio) <= 1e-9 * np.abs(row).max(initial=0.0):
        what = f"{drive.measured} does not move with {motor} here: name a position behind it"
        raise InputError(linear.motion.source, f"drives, {motor}, measured", what)
    position: Array = row / ratio
    return position


def _refuse_undamped(plant: Plant) -> None:
    """Raise `InputError` where a mode has no damping, so that gains would have no meaning."""
    poles = damped_poles(plant.linear)[0]
    swinging = poles[(poles.imag > 0) & (np.abs(poles.real) <= UNDAMPED * np.abs(poles))]
    if len(swinging):
        least_one = float(np.abs(swinging).min()) / (2 * np.pi)
        what = (
            f"{len(swinging)} modes have no damping, the lowest at {least_one:.4g} Hz, and gains depend on it: give "
            "[springs] damping, or a ratio for all modes, as 0.01"
        )
        raise InputError(plant.linear.motion.source, "--damping", what)


def _notes(motion: EquationsOfMotion, plant: Plant) -> tuple[str, ...]:
    held = [f"{name} has no drive and is held" for name in plant.held]
    return (*plant.linear.doubts, *held)


# One position


def _place(plant: Plant, cascades: Sequence[Cascade], distances: Distances, signals: Sequence[str]) -> PlaceControl:
    loop = closed_loop(plant, cascades)
    axes = tuple(_axis(one, loop, cascades, distances) for one in loops_of(plant, cascades))
    compliances = tuple(_compliance(plant, loop, cascades, name) for name in signals)
    return PlaceControl(dict(plant.place), axes, compliances, loop.growth)


def _axis(one: AxisLoops, loop: ClosedLoop, cascades: Sequence[Cascade], distances: Distances) -> AxisControl:
    grid = one.frequencies
    velocity = margins(lambda f: one.open_loops(f)["velocity"], grid)
    position = margins(lambda f: one.open_loops(f)["position"], grid)
    bandwidth, in_phase = _bandwidths(one, cascades, grid)
    motion = one.plant.linear.motion
    joint = motion.machine.motor_joints[motion.motor_names.index(one.cascade.motor)]
    limits = (
        _limit(one, "Kp", largest_Kp(one, distances.velocity), distances.velocity),
        _limit(one, "Kv", largest_Kv(one, distances.position), distances.position),
    )
    error = loop.velocity_error(one.cascade.motor, one.axis.position)
    return AxisControl(joint, one.cascade, velocity, position, bandwidth, in_phase, error, limits)


def _limit(one: AxisLoops, key: str, found: LargestGain | None, distance: float) -> Limit:
    return Limit(key, distance, found, influences(one, key, found) if found else {})


def _bandwidths(one: AxisLoops, cascades: Sequence[Cascade], grid: Array) -> tuple[float, float]:
    """Return where the position falls to 0.707 of its set point, and where it is 90 degrees behind, Hz."""

    def followed(f: Array) -> ComplexArray:
        s = laplace(f)
        moved = one.plant.moved(s, cascades, one.axis.velocity[:, None])[:, :, 0]
        by_torque: ComplexArray = moved @ one.axis.position
        return by_torque * one.cascade.forward(s)

    falls = crossings(lambda f: np.abs(followed(f)) - EDGE, grid)
    turns = [f for f in crossings(lambda f: followed(f).real, grid) if followed(np.array([f]))[0].imag < 0]
    return min(falls, default=np.inf), min(turns, default=np.inf)


def _compliance(plant: Plant, loop: ClosedLoop, cascades: Sequence[Cascade], name: str) -> Compliance:
    row = plant.linear.Cq[plant.linear.outputs.index(" ".join(name.split()))]
    (signal,) = outputs(plant.linear.motion.given, [name])
    turns = isinstance(signal, FrameSignal) and signal.component > 2

    def magnitude(f: Array) -> Array:
        s = laplace(f)
        moved = plant.moved(s, cascades, row[:, None])[:, :, 0]
        found: Array = np.abs(moved @ row)
        return found

    grid = loops_of(plant, cascades)[0].frequencies
    lowest, frequency = least(lambda f: -magnitude(f), grid)
    return Compliance(name, loop.static_compliance(row, row), -lowest, frequency, "rad/(N m)" if turns else "m/N")
