"""Small motions and trajectories of elastic machines: linearize, modes, response, compare, feed_forward."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

from symoro_elastic.api.machines import NO_VALUES, MachineLike, Values, the_machine
from symoro_elastic.api.scenes import SceneLike, kept_machine
from symoro_elastic.errors import InputError
from symoro_elastic.progress import Progress, no_progress

if TYPE_CHECKING:
    from symoro_elastic.array_types import Array
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.vibration.comparison import Comparison
    from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
    from symoro_elastic.vibration.feed_forward import FeedForward
    from symoro_elastic.vibration.linearization import Linearization
    from symoro_elastic.vibration.modes import Modes
    from symoro_elastic.vibration.reference_trajectory import ReferenceTrajectory
    from symoro_elastic.vibration.responses import Response
    from symoro_elastic.vibration.tracking import Tracked

Gains = Mapping[str, tuple[float, float]]
ALL = "all"


@dataclass(frozen=True)
class OperatingPoint:
    """Where a machine is linearized.

    Positions `at`, rates and torques by joint, SI units; motors in `hold` do not move, or those in `pd` have
    controllers of these gains. Without `as_given` the machine is in the equilibrium near `at`; a floating base is
    carried by `hover` or by `thrusts` (None where their size is found).
    """

    at: Values = field(default_factory=dict)
    torques: Values = field(default_factory=dict)
    rates: Values = field(default_factory=dict)
    as_given: bool = False
    hold: Sequence[str] = ()
    pd: Gains | None = None
    hover: bool = False
    thrusts: Mapping[str, float | None] | None = None

    def motion(
        self, machine: Machine, values: Values = NO_VALUES, inputs: Sequence[str] = (), outputs: Sequence[str] = ()
    ) -> EquationsOfMotion:
        """Return the equations of motion of a machine, with the points of these signals."""
        from symoro_elastic.vibration.hover import with_thrusts
        from symoro_elastic.vibration.linearization import motion_of

        return motion_of(with_thrusts(machine, self.thrusts or {}), dict(values), inputs, outputs)

    def held(self, motion: EquationsOfMotion) -> list[str]:
        """Return the names of the motors that are held."""
        return [motion.names[k] for k in motion.motors] if ALL in self.hold else list(self.hold)

    def state(self, motion: EquationsOfMotion) -> State:
        """Return the given state, or the equilibrium."""
        from symoro_elastic.vibration.equilibrium import equilibrium, given_state
        from symoro_elastic.vibration.hover import hover

        self._refuse_mixture()
        if self.thrusts and not self.as_given:
            return hover(motion, self.at, self.thrusts)
        if self.as_given:
            return given_state(motion, self.at, self.rates, self.torques)
        if self.rates:
            what = "an equilibrium is at rest: add --as-given, or leave it out"
            raise InputError("symoro-elastic", "--rate", what)
        return equilibrium(motion, self.at, self.torques, self.hover)

    def _refuse_mixture(self) -> None:
        """Raise `InputError` for options that exclude each other."""
        thrusts = self.thrusts or {}
        unknown = [name for name, x in thrusts.items() if x is None]
        for wrong, option, what in (
            (self.hover and (thrusts or self.as_given), "--hover", "leave out --thrust and --as-given, or it"),
            (unknown and self.as_given, "--thrust", f"{unknown} is found for an equilibrium: give its size"),
            (thrusts and self.torques and not self.as_given, "--torque", "motors are held in a hover: leave it out"),
        ):
            if wrong:
                raise InputError("symoro-elastic", option, what)

    def linearization(
        self, machine: Machine, values: Values = NO_VALUES, inputs: Sequence[str] = (), outputs: Sequence[str] = ()
    ) -> Linearization:
        """Return a machine linearized here, with its motors held or controlled."""
        return self.linearized(self.motion(machine, values, inputs, outputs), inputs, outputs)

    def linearized(
        self, motion: EquationsOfMotion, inputs: Sequence[str] = (), outputs: Sequence[str] = ()
    ) -> Linearization:
        """Return equations of motion linearized here, with motors held or controlled."""
        from symoro_elastic.vibration.linearization import linearize, with_motors

        linear = linearize(motion, self.state(motion), inputs or None, outputs or None)
        found = with_motors(linear, self.held(motion), self.pd or {})
        _refuse_held_signals(linear, found, inputs, outputs)
        return found


class Where(TypedDict, total=False):
    """Fields of an operating point that are given by name."""

    at: Values
    torques: Values
    rates: Values
    as_given: bool
    hold: Sequence[str]
    pd: Gains | None
    hover: bool
    thrusts: Mapping[str, float | None] | None


def _refuse_held_signals(
    linear: Linearization, held: Linearization, inputs: Sequence[str], outputs: Sequence[str]
) -> None:
    """Raise `InputError` where an input or output was requested that belongs to a held motor."""
    for option, asked, before, left in (
        ("--input", inputs, linear.inputs, held.inputs),
        ("--output", outputs, linear.outputs, held.outputs),
    ):
        still = [name for name in before if name not in left]
        if asked and still:
            what = f"{still[0]} is of a motor that is held, so nothing moves there: leave out one of the two"
            raise InputError(linear.motion.source, option, what)


def linearize(
    machine: MachineLike,
    point: OperatingPoint | None = None,
    *,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    values: Values = NO_VALUES,
    scene: SceneLike = None,
    **where: Unpack[Where],
) -> Linearization:
    """Return M, D, K of small motions about an equilibrium or a state, and A, B, C, D as `space`.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    point
        The operating point; its fields may also be given by name: `at={"motor_x": 0.1}`, `hold=["all"]`,
        `pd={"motor_x": (1e6, 2e3)}`, `torques`, `rates`, `as_given`, `hover`, `thrusts`.
    inputs
        Signals such as "motor_x.tau", "tool.fx" (default: torques of all motors).
    outputs
        Signals such as "motor_x.q", "tool.ax" (default: encoders of the motors).
    values
        Values of parameters.
    scene
        A scene that locks joints.

    Raises
    ------
    InputError
        For names that are none, without equilibrium, for numbers out of range.
    """
    return operating_point(point, where).linearization(kept_machine(machine, scene), values, inputs, outputs)


def modes(
    machine: MachineLike,
    point: OperatingPoint | None = None,
    *,
    values: Values = NO_VALUES,
    scene: SceneLike = None,
    **where: Unpack[Where],
) -> Modes:
    """Return natural frequencies, mode shapes, the springs and bodies that store their energy, and sensitivities.

    Arguments are those of `linearize`. Raises `InputError`.
    """
    return modes_of(linearize(machine, point, values=values, scene=scene, **where))


def modes_of(linear: Linearization) -> Modes:
    """Return the modes of a linearized machine; raises `InputError` for one without springs."""
    from symoro_elastic.vibration import modes as vibration

    vibration.refuse_rigid(linear)
    return vibration.modes(linear)


def modes_over(
    machine: Machine,
    grid: Mapping[str, Sequence[float]],
    point: OperatingPoint,
    values: Values = NO_VALUES,
    progress: Progress = no_progress,
) -> Tracked:
    """Return the modes at positions of joints, followed from one to the next."""
    from symoro_elastic.vibration.tracking import over_grid

    if point.as_given:
        what = "modes over positions are those of equilibria: leave out --as-given"
        raise InputError("symoro-elastic", "--over", what)
    if point.thrusts:
        raise InputError("symoro-elastic", "--over", "thrusts are found at one position: use --hover, or leave it out")
    motion = point.motion(machine, values)
    lists = {name: list(positions) for name, positions in grid.items()}
    return over_grid(motion, lists, point.at, point.torques, point.held(motion), point.pd or {}, progress, point.hover)


def response(
    machine: MachineLike,
    point: OperatingPoint | None = None,
    *,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
    frequencies: Sequence[float] | Array | None = None,
    damping: float = 0.0,
    values: Values = NO_VALUES,
    scene: SceneLike = None,
    **where: Unpack[Where],
) -> Response:
    """Return frequency responses from motors or forces to encoders or motions, with their poles and zeros.

    `frequencies` in Hz are by default those around all poles; `damping` is a ratio added to every mode. The other
    arguments are those of `linearize`. Raises `InputError`.
    """
    linear = linearize(machine, point, inputs=inputs, outputs=outputs, values=values, scene=scene, **where)
    return response_of(linear, frequencies, damping)


def response_of(
    linear: Linearization,
    frequencies: Sequence[float] | Array | None = None,
    damping: float = 0.0,
    band: tuple[float, float, int] | tuple[()] = (),
) -> Response:
    """Return the frequency responses of a linearized machine at frequencies or in a band (low, high, points), Hz."""
    import numpy as np

    from symoro_elastic.vibration import responses
    from symoro_elastic.vibration.zeros import poles_and_zeros

    linear = responses.with_modal_damping(linear, damping)
    responses.refuse_missing_signals(linear)
    points = responses.frequency_grid(linear, *band) if frequencies is None else np.asarray(frequencies, dtype=float)
    found = responses.frequency_response(linear, points)
    pairs = tuple(poles_and_zeros(linear, i, o) for i in linear.inputs for o in linear.outputs)
    return replace(found, transfers=pairs)


def compare(
    machine: MachineLike,
    motion: str | Path | None = None,
    *,
    at: Values = NO_VALUES,
    values: Values = NO_VALUES,
    ratios: Values = NO_VALUES,
    stroke: float = 0.1,
    duration: float | None = None,
    free: bool = False,
    scene: SceneLike = None,
    progress: Progress = no_progress,
) -> Comparison:
    """Return the errors of Spong's reduced model and of the rigid limit against the full elastic model.

    On a `motion` of a file (.csv, .npz), or on a move of all motors by `stroke` (rad or m) in `duration` (s; default:
    five periods of the first natural frequency). `ratios` are gear ratios by motor; frequencies are those with motors
    held, or `free`. Raises `InputError`.
    """
    from symoro_elastic.vibration import comparison

    found = kept_machine(machine, scene)
    path = None if motion is None else str(motion)
    return comparison.compare(found, values, at, ratios, not free, path, stroke, duration, progress)


@dataclass(frozen=True)
class ReferenceMotion:
    """A reference trajectory: a file, or a move by strokes; degree and sample rate of its splines."""

    motion: str | Path | None = None
    strokes: Values = field(default_factory=dict)
    duration: float | None = None
    at: Values = field(default_factory=dict)
    degree: int | None = None
    rate: float | None = None

    def trajectory(self, machine: Machine) -> ReferenceTrajectory:
        """Return the reference trajectory, as smooth as the machine needs where no degree is given."""
        from symoro_elastic.vibration import reference_trajectory
        from symoro_elastic.vibration.course import usual_duration
        from symoro_elastic.vibration.driven_joints import followed
        from symoro_elastic.vibration.feed_forward import orders, starts

        machine = followed(machine)
        smooth = max(orders(machine).values(), default=0) + 1
        if self.motion:
            return reference_trajectory.read_reference(str(self.motion), machine, self.degree, smooth, self.rate)
        strokes = self.strokes or {"": reference_trajectory.STROKE}
        duration = usual_duration(machine, self.at) if self.duration is None else self.duration
        degree = smooth if self.degree is None else self.degree
        start = {**starts(machine), **self.at}
        return reference_trajectory.move(machine, start, strokes, duration, degree, self.rate)


def feed_forward(
    machine: MachineLike,
    motion: str | Path | None = None,
    *,
    strokes: Values | float = NO_VALUES,
    duration: float | None = None,
    at: Values = NO_VALUES,
    degree: int | None = None,
    rate: float | None = None,
    values: Values = NO_VALUES,
    scene: SceneLike = None,
) -> FeedForward:
    """Return the torques of motors that make the load, beyond the springs, follow a reference trajectory.

    Parameters
    ----------
    machine
        A machine, its file or its tables.
    motion
        File of the reference: .csv or .npz with t, y_<motor>, and derivatives where they are known (default: a move).
        Where motors follow from loops, as in a delta, it has y_<joint> of the independent joints.
    strokes
        Strokes of the move by motor, rad or m, or one for all (default: 0.1).
    duration
        Duration of the move, s (default: five periods of the first natural frequency).
    at
        Start of the move by motor.
    degree, rate
        Degree of the splines, and their sample rate, Hz.
    values
        Values of parameters.
    scene
        A scene that locks joints.

    Raises
    ------
    InputError
        Where springs or joints leave no feed-forward, and for a motion with too few derivatives.
    """
    from symoro_elastic.vibration import feed_forward as vibration

    found = the_machine(kept_machine(machine, scene), values)
    each = {"": float(strokes)} if isinstance(strokes, int | float) else strokes
    reference = ReferenceMotion(motion, each, duration, at, degree, rate)
    return vibration.feed_forward(found, reference.trajectory(found))


def operating_point(point: OperatingPoint | None, where: Where) -> OperatingPoint:
    """Return the operating point, with fields that are given by name; raises `TypeError` for others."""
    fields_ = OperatingPoint.__dataclass_fields__
    if unknown := where.keys() - fields_.keys():
        raise TypeError(f"unexpected argument {min(unknown)!r}: an operating point has {', '.join(fields_)}")
    return replace(point or OperatingPoint(), **where)
