"""Results of drives around a machine: margins and bandwidths of axes, limits of gains, compliance with loops closed.

How margins and poles of closed loops change with parameters, gains and parts of drives: exact, at their own s.

A margin is that of L(f; p) at a frequency that moves with p, too: at a crossing, g(f; p) = 0, by df/dp =
-(dg/dp)/(dg/df), at the least |1 + L| without effect (envelope). A pole s is where Z(s; p) x = 0 and y^T Z = 0:

    ds/dp = -(y^T dZ/dp x)/(y^T dZ/ds x)

dZ/ds and dL/df are means over a small circle (Cauchy), as all loops are analytic functions of s.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Biquad, Cascade, Element, Hold, is_gain, laplace
from symoro_elastic.analysis.control.closed_loop import ClosedLoop, closed_loop
from symoro_elastic.analysis.control.driven_machine import (
    States,
    default_compliances,
    driven_machine,
    refuse_without_drives,
)
from symoro_elastic.analysis.control.largest_gain import LargestGain
from symoro_elastic.analysis.control.loops import (
    AxisLoops,
    Margins,
    crossings,
    influences,
    largest_Kp,
    largest_Kv,
    least,
    loop_slopes,
    loops_of,
    margins,
    over_gain,
)
from symoro_elastic.analysis.control.optimum import refuse_mixed
from symoro_elastic.analysis.control.plant import Plant, position_row
from symoro_elastic.analysis.control.sampled import sampled_loop
from symoro_elastic.analysis.control.tuning import AT_USUAL_DISTANCES, Distances, Tuning
from symoro_elastic.analysis.vibration.export import labels
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import Drives
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import with_base_coordinates
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.signals import OUTPUT, output_unit, positions

ROUNDING = 1e-12
"""Of the peak of a compliance, below which the one at rest is that of an integral part: zero."""
EDGE = 2**-0.5
SET_POINTS = ("r", "rd", "rdd")
TURNS = np.exp(2j * np.pi * np.arange(8) / 8)
RADIUS = 1e-5
"""Of the circle, by the size of its middle: nearer than any other pole, and wide enough for its values to differ."""
POLISHED = 6
"""Steps from a pole with approximated dead times to that with exact ones; these converge quadratically."""
NEAR = 0.05
"""Of a pole: further than this the two are not the same."""
RULES = {"amount optimum": ("Kessler 1955", np.inf, 2.0), "symmetrical optimum": ("Kessler 1958", 4.0, 4.0)}
"""Source, Tn and T_v over T; Kp is J/(2 T) in both."""


@dataclass(frozen=True)
class Limit:
    """The largest gain at a required modulus margin, its frequency, Hz, and d ln gain / d ln p by each p."""

    key: str
    distance: float
    largest: LargestGain | None
    influences: Mapping[str, float] = field(default_factory=dict)

    @property
    def strongest(self) -> list[tuple[str, float]]:
        """Influences on the largest gain, the strongest first; other gains, which are chosen, come last."""
        return sorted(self.influences.items(), key=lambda pair: (is_gain(pair[0]), -abs(pair[1])))


@dataclass(frozen=True)
class AxisControl:
    """One axis with the others closed: margins of its loops, bandwidths and following error of its position.

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
        """Name of the axis's motor joint."""
        return self.joint.name


@dataclass(frozen=True)
class Compliance:
    """The displacement of an output by a force there: static, and its peak with its frequency, Hz, else NaN."""

    output: str
    static: float
    peak: float
    frequency: float
    unit: str


@dataclass(frozen=True)
class PlaceControl:
    """All axes at one position; `growth` is the fastest growth of a motion, 1/s, negative where all decay, 0 where
    one lasts.

    It is that of the exact map where drives have a `period`, s, else the largest real part of a pole.
    """

    place: Mapping[str, float]
    axes: tuple[AxisControl, ...]
    compliances: tuple[Compliance, ...]
    growth: float
    period: float = 0.0


@dataclass(frozen=True, repr=False)
class Control(Result):
    """Axes of a machine at its positions, with the `plants` and loops that the results were computed from.

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
        """Drives of the axes, with their gains."""
        return tuple(axis.cascade for axis in self.places[0].axes)

    @property
    def loops(self) -> tuple[ClosedLoop, ...]:
        """Closed-loop linear system at each position."""
        return tuple(closed_loop(plant, self.cascades) for plant in self.plants)

    def to_control(self, place: int = 0) -> dict[str, Any]:
        """Return `closed`, a `control.StateSpace`, and open loops as `control.FrequencyResponseData`, by name.

        Of the position of this number. `closed` has set points and their two rates by motor, forces at the outputs;
        positions that are controlled, and outputs; dead times are approximations of Pade of order 2 in it.
        `motor_x velocity` and `motor_x position` are exact. Raises `InputError` without python-control.
        """
        package = import_optional("control", "systems for python-control", "control")
        plant, drives, loop = self.plants[place], self.cascades, self.loops[place]
        names = [compliance.output for compliance in self.places[place].compliances]
        rows = np.array([position_row(plant.linear, name) for name in names]).reshape(len(names), -1)
        columns = [column[:, k] for k in range(len(drives)) for column in loop.by_set_point]
        B = np.column_stack([*columns, loop.by_force @ rows.T])
        output_rows = np.vstack([[plant.axes[drive.motor].position for drive in drives], rows]) @ plant.free
        C = np.hstack([output_rows, np.zeros((len(output_rows), len(loop.A) - output_rows.shape[1]))])
        inputs = [f"{drive.motor}.{key}" for drive in drives for key in SET_POINTS]
        inputs += [f"{name} force" for name in names]
        outputs = [*(f"{drive.motor}.position" for drive in drives), *names]
        D = np.zeros((len(C), B.shape[1]))
        systems = {"closed": package.ss(loop.A, B, C, D, inputs=labels(inputs), outputs=labels(outputs))}
        for loops in loops_of(plant, drives):
            for name, values in loops.open_loops(loops.frequencies).items():
                systems[f"{loops.cascade.motor} {name}"] = package.frd(values, 2 * np.pi * loops.frequencies)
        return systems

    def margin_slopes(self, motor: str, loop: str = "position", place: int = 0) -> MarginSlopes:
        """Return how the margins of a loop, position or velocity, of an axis change with parameters and its drive.

        Exact, with all else as it is: the other axes closed, gains unchanged but those that are named. Names are those
        of parameters, of parts of its own drive (dead time), and Kp, Kv, Tn. Raises `InputError` for other axes, loops.
        """
        axes = {axis.motor: axis for axis in self.places[place].axes}
        for what, value, choices in (("motor", motor, [*axes]), ("loop", loop, ["position", "velocity"])):
            if value not in choices:
                raise InputError(self.machine, what, f"{value} is none of {', '.join(choices)}")
        axis = axes[motor]
        other_drives = [cascade for cascade in self.cascades if cascade.motor != motor]
        loops = AxisLoops.around(self.plants[place], axis.cascade, other_drives)
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
        """Name of the machine, its axes and positions."""
        axes = ", ".join(cascade.motor for cascade in self.cascades)
        return f"Control of {self.machine}: {axes} at {len(self.places)} position{'s' * (len(self.places) > 1)}"


def control_at(
    motion: EquationsOfMotion,
    states: States,
    tuning: Tuning = AT_USUAL_DISTANCES,
    damping: float = 0.0,
    wanted: Sequence[str] = (),
    progress: Progress = no_progress,
) -> Control:
    """Return the results of a machine's drives at some states, each with its position.

    `wanted` are outputs whose compliance is given. Raises `InputError`.
    """
    refuse_without_drives(motion)
    signals = tuple(wanted) or default_compliances(motion.given)
    positions(with_base_coordinates(motion.given), signals, OUTPUT)
    if tuning.together:
        refuse_mixed(motion, signals)
    driven = driven_machine(motion, states, tuning, damping, signals)
    plants, cascades = driven.plants, driven.cascades
    places = []
    for k, plant in enumerate(plants):
        places.append(_place(plant, cascades, tuning.distances, signals))
        progress(k + 1, len(plants))
    name = motion.machine.name
    return Control(name, tuple(places), tuning.distances, damping, plants, driven.tuned, driven.notes)


def with_gains(machine: Machine, control: Control) -> Machine:
    """Return a machine whose drives have the gains of a result."""
    described = DescribedMachine.of(machine)
    by_motor = dict(described.drives.by_motor)
    for drive in control.cascades:
        gains: dict[str, Any] = {key: Formula.parse(float(f"{getattr(drive, key):.6g}")) for key in drive.tuned_gains}
        by_motor[drive.motor] = replace(by_motor[drive.motor], **gains)
    return replace(described, drives=Drives(by_motor))


# One position


def _place(plant: Plant, cascades: Sequence[Cascade], distances: Distances, signals: Sequence[str]) -> PlaceControl:
    loop = closed_loop(plant, cascades)
    by_axis = loops_of(plant, cascades)
    axes = tuple(_axis(loops, loop, distances) for loops in by_axis)
    compliances = tuple(_compliance(plant, loop, cascades, name, by_axis[0].frequencies) for name in signals)
    exact = sampled_loop(plant, cascades)
    growth, period = (exact.growth, exact.period) if exact else (loop.growth, 0.0)
    return PlaceControl(dict(plant.place), axes, compliances, growth, period)


def _axis(loops: AxisLoops, loop: ClosedLoop, distances: Distances) -> AxisControl:
    grid = loops.frequencies
    velocity, position = margins(loops.velocity_loop, grid), margins(loops.position_loop, grid)
    bandwidth, in_phase = _bandwidths(loops, grid)
    motion = loops.plant.linear.motion
    joint = motion.machine.motor_joints[motion.motor_names.index(loops.cascade.motor)]
    gains = (
        ("Kp", distances.velocity, largest_Kp(loops, distances.velocity)),
        ("Kv", distances.position, largest_Kv(loops, distances.position)),
    )
    limits = tuple(Limit(*gain, influences(loops, gain[0], gain[2]) if gain[2] else {}) for gain in gains)
    error = loop.velocity_error(loops.cascade.motor, loops.axis.position) + loops.cascade.set_point_delay
    return AxisControl(joint, loops.cascade, velocity, position, bandwidth, in_phase, error, limits)


def _bandwidths(loops: AxisLoops, grid: Array) -> tuple[float, float]:
    """Return the frequencies at which the position response falls to 0.707, and lags by 90 degrees, Hz."""
    response = loops.position_response
    falls = crossings(lambda f: np.abs(response(f)) - EDGE, grid)
    turns = [f for f in crossings(lambda f: response(f).real, grid) if response(np.array([f]))[0].imag < 0]
    return min(falls, default=np.inf), min(turns, default=np.inf)


def _compliance(
    plant: Plant, loop: ClosedLoop, cascades: Sequence[Cascade], name: str, frequencies: Array
) -> Compliance:
    row = position_row(plant.linear, name)

    def magnitude(f: Array) -> Array:
        return np.asarray(np.abs(plant.response(laplace(f), cascades, row, row)))

    lowest, frequency = least(lambda f: -magnitude(f), frequencies)
    peak, static = -lowest, loop.static_compliance(row, row)
    unit = unit_of_compliance(plant.linear.motion.given, name)
    at_rest = static if abs(static) > ROUNDING * peak else 0.0
    return Compliance(name, at_rest, peak, frequency if peak else np.nan, unit)


def unit_of_compliance(machine: Machine, output: str) -> str:
    """Return the unit of the displacement of an output by a force there."""
    return "rad/(N m)" if output_unit(machine, output) == "rad" else "m/N"


@dataclass(frozen=True)
class MarginSlopes:
    """p d/dp of the margins of an open loop, by name of p: of ln modulus, of the phase in deg, of ln gain.

    Empty for a missing margin. 1 % more of p changes the modulus by so many %, the phase by a hundredth of it.
    """

    modulus: Mapping[str, float]
    phase: Mapping[str, float]
    gain: Mapping[str, float]


def margin_slopes(loops: AxisLoops, key: str, margins: Margins) -> MarginSlopes:
    """Return the slopes of the margins of the loop of Kp or Kv, by parameters, gains and elements of its drive."""
    loop = loops.velocity_loop if key == "Kp" else loops.position_loop

    def at(f: float, of: Callable[[complex, complex, complex], float]) -> dict[str, float]:
        if not np.isfinite(f):
            return {}
        L, by_f, gain = complex(loop(np.array([f]))[0]), _slope(loop, complex(f)), getattr(loops.cascade, key)
        slopes = loop_slopes(loops, key, f, lambda drive, *G: getattr(drive, key) * over_gain(key, drive, *G), gain)
        return {name: of(L, by_f, change) for name, change in slopes.items()}

    def of_phase(L: complex, by_f: complex, change: complex) -> float:
        moved = -(change / L).real / (by_f / L).real
        return float(np.sign(np.angle(-L)) * np.degrees((change / L).imag + (by_f / L).imag * moved))

    def of_gain(L: complex, by_f: complex, change: complex) -> float:
        return -(change.real - by_f.real * change.imag / by_f.imag) / L.real

    return MarginSlopes(
        at(margins.modulus_frequency, lambda L, _, change: (change / (1 + L)).real),
        at(margins.phase_frequency, of_phase),
        at(margins.gain_frequency, of_gain),
    )


def pole_slopes(plant: Plant, cascades: Sequence[Cascade], near: complex) -> tuple[complex, dict[str, complex]]:
    """Return the pole of `closed_loop` next to `near`, with exact dead times, and its p ds/dp by name p, 1/s.

    Gains and parts of drives are named after their motor, as in "motor, Kp". Empty where no pole is as near.
    """
    s, polished = near, near
    for _ in range(POLISHED):
        s = polished
        U, _, right = np.linalg.svd(plant.stiffness_at(np.array([s]), cascades)[0])
        y, x = U[:, -1].conj(), right[-1].conj()  # y^T Z and Z x nearly vanish

        def along(at: ComplexArray, y: ComplexArray = y, x: ComplexArray = x) -> ComplexArray:
            return np.asarray(plant.stiffness_at(at, cascades) @ x @ y)

        by_s = _slope(along, s)
        polished = s - complex(along(np.array([s]))[0]) / by_s
    if not abs(s - near) <= NEAR * abs(near):
        return near, {}
    none = np.zeros(len(plant.free))
    work = plant.work_slopes(s, cascades, plant.free @ y, plant.free @ x, (none, none))
    return s, {name: -change / by_s for name, change in work.items()}


def _slope(of: Callable[[ComplexArray], ComplexArray], middle: complex) -> complex:
    """Return the derivative of an analytic function: the mean of f(m + r e^it) e^-it over a circle, over r."""
    radius = RADIUS * abs(middle)
    return complex((of(middle + radius * TURNS) / TURNS).mean() / radius)


@dataclass(frozen=True)
class RuledAxis:
    """Gains of an axis by a rule, and the least |1 + L| of its loops over all positions; `growth` of all loops, 1/s."""

    rule: str
    source: str
    cascade: Cascade
    inertia: float
    time: float
    velocity: float
    position: float
    growth: float


def gains_by_rules(plants: Sequence[Plant], cascades: Sequence[Cascade]) -> tuple[RuledAxis, ...]:
    """Return the gains of the axes by each published rule, for the largest inertia over all positions.

    Axes without a dead time, period, lag or filter are left as they are, and have no rows.
    """
    axes: list[RuledAxis] = []
    for rule, (source, integral, behind) in RULES.items():
        inertias = [max(inertia(plant, cascade.motor) for plant in plants) for cascade in cascades]
        times = [sum(map(small_time, cascade.path)) for cascade in cascades]
        closed = [
            cascade.with_gains(Kp=J / (2 * T), Tn=integral * T, Kv=1 / (4 * behind * T)) if T else cascade
            for cascade, J, T in zip(cascades, inertias, times, strict=True)
        ]
        growth = max((sampled_loop(plant, closed) or closed_loop(plant, closed)).growth for plant in plants)
        loops = [loops_of(plant, closed) for plant in plants]
        for k, drive in enumerate(closed):
            if times[k]:
                velocity = min(margins(at[k].velocity_loop, at[k].frequencies).modulus for at in loops)
                position = min(margins(at[k].position_loop, at[k].frequencies).modulus for at in loops)
                axes.append(RuledAxis(rule, source, drive, inertias[k], times[k], velocity, position, growth))
    return tuple(axes)


def inertia(plant: Plant, motor: str) -> float:
    """Return the inertia of an axis, kg m2 or kg, with rigid springs: only its own variable moves."""
    velocity = plant.axes[motor].velocity
    return float(velocity @ plant.linear.M @ velocity) / float(velocity @ velocity) ** 2


def small_time(element: Element) -> float:
    """Return the delay of an element at low frequencies, s: -d ln P/ds at 0."""
    if isinstance(element, Biquad):
        return 2 * (element.below - (0.0 if element.low else element.above)) / element.w
    return element.time / 2 if isinstance(element, Hold) else element.time


# Results of drives by name, for sweeps: margins, bandwidth, following error, largest gains, compliances.
def control_figures(control: Control) -> dict[str, float]:
    """Return the results of a machine at its first position, by names as "motor_x: position_modulus".

    Margins are 0 where the loops are unstable. `behind` is in s, frequencies in Hz, `growth` in 1/s.
    """
    place = control.places[0]
    figures: dict[str, float] = {}
    for axis in place.axes:
        figures |= {f"{axis.motor}: {name}": x for name, x in _of_axis(axis, place.growth <= 0)}
    for compliance in place.compliances:
        figures |= {f"{compliance.output}: at_rest": compliance.static, f"{compliance.output}: peak": compliance.peak}
        figures |= {f"{compliance.output}: peak_frequency": compliance.frequency}
    return {**figures, "growth": place.growth}


def _of_axis(axis: AxisControl, is_stable: bool) -> Iterator[tuple[str, float]]:
    for loop, of_loop in (("velocity", axis.velocity), ("position", axis.position)):
        for name in ("modulus", "phase", "gain"):
            yield f"{loop}_{name}", getattr(of_loop, name) if is_stable else 0.0
    yield from (("bandwidth", axis.bandwidth), ("behind", axis.velocity_error))
    for limit in axis.limits:
        yield f"largest_{limit.key}", limit.largest.gain if limit.largest else 0.0


UNITS = {"phase": "deg", "bandwidth": "Hz", "peak_frequency": "Hz", "growth": "1/s", "behind": "s"}
"""Of a figure, by what its name ends with; compliances and gains have that of their output and axis."""


def unit_of(figure: str, machine: Machine) -> str:
    """Return the unit of a result by its name; empty for a pure number."""
    output, _, name = figure.rpartition(": ")
    if name in ("at_rest", "peak"):
        return unit_of_compliance(machine, output)
    return next((unit for end, unit in UNITS.items() if figure.endswith(end)), "")
