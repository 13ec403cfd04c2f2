"""What drives make of a machine: margins and bandwidth by axis, what limits each gain, compliance with loops closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.closed_loop import ClosedLoop, closed_loop
from symoro_elastic.analysis.control.driven_machine import (
    States,
    default_compliances,
    driven_machine,
    refuse_without_drives,
)
from symoro_elastic.analysis.control.export import systems_for_control
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
from symoro_elastic.analysis.control.optimum import refuse_mixed
from symoro_elastic.analysis.control.plant import Plant, position_row
from symoro_elastic.analysis.control.rules import RuledAxis
from symoro_elastic.analysis.control.sampled import sampled_loop
from symoro_elastic.analysis.control.slopes import MarginSlopes, margin_slopes, pole_slopes
from symoro_elastic.analysis.control.tuning import Distances
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import Drives
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.free_base import with_base_coordinates
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.signals import OUTPUT, output_unit, positions

ROUNDING = 1e-12
"""Of the peak of a compliance, below which the one at rest is that of an integral part: zero."""
EDGE = 2**-0.5


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
    """The displacement of an output by a force there: at rest, and its peak with its frequency, Hz; NaN without one."""

    output: str
    static: float
    peak: float
    frequency: float
    unit: str


@dataclass(frozen=True)
class PlaceControl:
    """All axes at one position; `growth` is the fastest growth of a motion, 1/s, negative where all decay.

    It is that of the exact map where drives have a `period`, s, else the largest real part of a pole.
    """

    place: Mapping[str, float]
    axes: tuple[AxisControl, ...]
    compliances: tuple[Compliance, ...]
    growth: float
    period: float = 0.0


@dataclass(frozen=True, repr=False)
class Control(Result):
    """Axes at positions of a machine; `plants` and `loops` are what they were computed from.

    `rules` are gains by published rules, where they are wanted.
    """

    machine: str
    places: tuple[PlaceControl, ...]
    distances: Distances
    damping: float
    plants: tuple[Plant, ...]
    tuned: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    rules: tuple[RuledAxis, ...] = ()

    @property
    def cascades(self) -> tuple[Cascade, ...]:
        """The drives with their gains."""
        return tuple(axis.cascade for axis in self.places[0].axes)

    @property
    def loops(self) -> tuple[ClosedLoop, ...]:
        """All loops closed, as one linear system at each position."""
        return tuple(closed_loop(plant, self.cascades) for plant in self.plants)

    def to_control(self, place: int = 0) -> dict[str, Any]:
        """Return `closed`, all loops as a `control.StateSpace`, and open loops as frequency responses, by name.

        Of the position of this number. Raises `InputError` without python-control.
        """
        outputs = [one.output for one in self.places[place].compliances]
        return systems_for_control(self.plants[place], self.cascades, outputs)

    def margin_slopes(self, motor: str, loop: str = "position", place: int = 0) -> MarginSlopes:
        """Return how the margins of a loop, position or velocity, of an axis change with parameters and its drive.

        Exact, with all else as it is: the other axes closed, gains unchanged but those that are named. Names are those
        of parameters, of parts of its own drive (dead time), and Kp, Kv, Tn. Raises `InputError` for other axes, loops.
        """
        axes = {axis.motor: axis for axis in self.places[place].axes}
        for what, given, known in (("motor", motor, [*axes]), ("loop", loop, ["position", "velocity"])):
            if given not in known:
                raise InputError(self.machine, what, f"{given} is none of {', '.join(known)}")
        axis = axes[motor]
        others = [one for one in self.cascades if one.motor != motor]
        loops = AxisLoops.around(self.plants[place], axis.cascade, others)
        is_inner = loop == "velocity"
        return margin_slopes(loops, "Kp" if is_inner else "Kv", axis.velocity if is_inner else axis.position)

    def pole_slopes(self, pole: complex | None = None, place: int = 0) -> tuple[complex, dict[str, complex]]:
        """Return a pole of all closed loops, 1/s, and its derivatives by ln p, 1/s, by name p: exact.

        The one next to `pole`, else the one that decays least; dead times and holds are exact. Gains and parts of
        drives are named after their motor, as in "motor_x, dead time". Empty where the approximated pole is not near.
        """
        poles = self.loops[place].poles
        near = max(poles, key=lambda s: s.real) if pole is None else min(poles, key=lambda s: abs(s - pole))
        return pole_slopes(self.plants[place], self.cascades, complex(near))

    @property
    def headline(self) -> str:
        """Machine, axes and positions."""
        axes = ", ".join(one.motor for one in self.cascades)
        return f"Control of {self.machine}: {axes} at {len(self.places)} position{'s' * (len(self.places) > 1)}"


def control_at(
    motion: EquationsOfMotion,
    states: States,
    distances: Distances,
    damping: float = 0.0,
    tune: bool = False,
    wanted: Sequence[str] = (),
    progress: Progress = no_progress,
    together: bool = False,
) -> Control:
    """Return what the drives of a machine make of it at some states, with the position of each.

    With `tune` all gains are sought, else those that the file leaves to tuning; `together` they have the least peak of
    compliance. `wanted` are outputs whose compliance is given. Raises `InputError`.
    """
    refuse_without_drives(motion)
    signals = tuple(wanted) or default_compliances(motion.given)
    positions(with_base_coordinates(motion.given), signals, OUTPUT)
    if together:
        refuse_mixed(motion, signals)
    whole = driven_machine(motion, states, distances, damping, tune, signals, together)
    plants, cascades = whole.plants, whole.cascades
    places = []
    for k, plant in enumerate(plants):
        places.append(_place(plant, cascades, distances, signals))
        progress(k + 1, len(plants))
    name = motion.machine.name
    return Control(name, tuple(places), distances, damping, plants, whole.tuned, whole.notes)


def with_gains(machine: Machine, control: Control) -> Machine:
    """Return a machine whose drives have the gains of a result."""
    described = DescribedMachine.of(machine)
    by_motor = dict(described.drives.by_motor)
    for one in control.cascades:
        gains: dict[str, Any] = {key: Formula.parse(float(f"{getattr(one, key):.6g}")) for key in one.sought}
        by_motor[one.motor] = replace(by_motor[one.motor], **gains)
    return replace(described, drives=Drives(by_motor))


# One position


def _place(plant: Plant, cascades: Sequence[Cascade], distances: Distances, signals: Sequence[str]) -> PlaceControl:
    loop = closed_loop(plant, cascades)
    each = loops_of(plant, cascades)
    axes = tuple(_axis(one, loop, distances) for one in each)
    compliances = tuple(_compliance(plant, loop, cascades, name, each[0].frequencies) for name in signals)
    exact = sampled_loop(plant, cascades)
    growth, period = (exact.growth, exact.period) if exact else (loop.growth, 0.0)
    return PlaceControl(dict(plant.place), axes, compliances, growth, period)


def _axis(one: AxisLoops, loop: ClosedLoop, distances: Distances) -> AxisControl:
    grid = one.frequencies
    velocity, position = margins(one.velocity_loop, grid), margins(one.position_loop, grid)
    bandwidth, in_phase = _bandwidths(one, grid)
    motion = one.plant.linear.motion
    joint = motion.machine.motor_joints[motion.motor_names.index(one.cascade.motor)]
    limits = (
        _limit(one, "Kp", largest_Kp(one, distances.velocity), distances.velocity),
        _limit(one, "Kv", largest_Kv(one, distances.position), distances.position),
    )
    error = loop.velocity_error(one.cascade.motor, one.axis.position) + one.cascade.set_point_delay
    return AxisControl(joint, one.cascade, velocity, position, bandwidth, in_phase, error, limits)


def _limit(one: AxisLoops, key: str, found: LargestGain | None, distance: float) -> Limit:
    return Limit(key, distance, found, influences(one, key, found) if found else {})


def _bandwidths(one: AxisLoops, grid: Array) -> tuple[float, float]:
    """Return where the position falls to 0.707 of its set point, and where it is 90 degrees behind, Hz."""
    falls = crossings(lambda f: np.abs(one.followed(f)) - EDGE, grid)
    turns = [f for f in crossings(lambda f: one.followed(f).real, grid) if one.followed(np.array([f]))[0].imag < 0]
    return min(falls, default=np.inf), min(turns, default=np.inf)


def _compliance(
    plant: Plant, loop: ClosedLoop, cascades: Sequence[Cascade], name: str, frequencies: Array
) -> Compliance:
    row = position_row(plant.linear, name)

    def magnitude(f: Array) -> Array:
        found: Array = np.abs(plant.response(laplace(f), cascades, row, row))
        return found

    lowest, frequency = least(lambda f: -magnitude(f), frequencies)
    peak, static = -lowest, loop.static_compliance(row, row)
    unit = unit_of_compliance(plant.linear.motion.given, name)
    at_rest = static if abs(static) > ROUNDING * peak else 0.0
    return Compliance(name, at_rest, peak, frequency if peak else np.nan, unit)


def unit_of_compliance(machine: Machine, output: str) -> str:
    """Return the unit of the displacement of an output by a force there."""
    return "rad/(N m)" if output_unit(machine, output) == "rad" else "m/N"
