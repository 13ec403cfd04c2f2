"""Small motions and trajectories of elastic machines: linearize, modes, response, compare, feed_forward."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from symoro_elastic.api.declaration import in_si_units, operation, part
from symoro_elastic.api.machines import NO_VALUES, the_machine
from symoro_elastic.api.options import (
    Comparing,
    Following,
    Linearizing,
    OperatingPoint,
    Oscillating,
    Responding,
    Sweeping,
)
from symoro_elastic.api.rows import MachineLike, Values
from symoro_elastic.api.scenes import kept_machine
from symoro_elastic.foundation.errors import InputError, reported_places
from symoro_elastic.foundation.progress import Progress, no_progress

if TYPE_CHECKING:
    from symoro_elastic.analysis.vibration.comparison import Comparison
    from symoro_elastic.analysis.vibration.feed_forward import FeedForward
    from symoro_elastic.analysis.vibration.linearization import Linearization
    from symoro_elastic.analysis.vibration.modes import Modes
    from symoro_elastic.analysis.vibration.reference_trajectory import ReferenceTrajectory
    from symoro_elastic.analysis.vibration.responses import Response
    from symoro_elastic.analysis.vibration.tracking import Tracked
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State

ALL = "all"


def motion_at(
    point: OperatingPoint,
    machine: Machine,
    values: Values = NO_VALUES,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
) -> EquationsOfMotion:
    """Return the equations of motion of a machine, with its thrusts and the points of its signals."""
    from symoro_elastic.numerics.motion.equations_of_motion import motion_of
    from symoro_elastic.numerics.motion.equilibrium import with_thrusts

    return motion_of(with_thrusts(machine, point.thrusts or {}), dict(values), inputs, outputs)


def held_motors(point: OperatingPoint, motion: EquationsOfMotion) -> list[str]:
    """Return the names of the motors that are held."""
    return [motion.names[k] for k in motion.motors] if ALL in point.hold else list(point.hold)


def state_at(point: OperatingPoint, motion: EquationsOfMotion) -> State:
    """Return the given state, or the equilibrium."""
    from symoro_elastic.numerics.motion.equilibrium import equilibrium, given_state, hover

    _refuse_mixture(point)
    if point.thrusts and not point.as_given:
        return hover(motion, point.at, point.thrusts)
    if point.as_given:
        return given_state(motion, point.at, point.rates, point.torques)
    if point.rates:
        what = "an equilibrium is at rest: add --as-given, or leave it out"
        raise InputError("symoro-elastic", "--rate", what)
    return equilibrium(motion, point.at, point.torques, point.hover)


def _refuse_mixture(point: OperatingPoint) -> None:
    """Raise `InputError` for conflicting options."""
    thrusts = point.thrusts or {}
    unknown = [name for name, x in thrusts.items() if x is None]
    for wrong, option, what in (
        (point.hover and (thrusts or point.as_given), "--hover", "remove --thrust and --as-given, or --hover"),
        (unknown and point.as_given, "--thrust", f"{unknown} is computed only for an equilibrium: give its value"),
        (thrusts and point.torques and not point.as_given, "--torque", "motors are held in a hover: leave it out"),
    ):
        if wrong:
            raise InputError("symoro-elastic", option, what)


def linearized_at(
    point: OperatingPoint, motion: EquationsOfMotion, inputs: Sequence[str] = (), outputs: Sequence[str] = ()
) -> Linearization:
    """Return equations of motion linearized at a point, with motors held or controlled."""
    from symoro_elastic.analysis.vibration.linearization import linearize, with_motors

    linear = linearize(motion, state_at(point, motion), inputs or None, outputs or None)
    linear_of_free = with_motors(linear, held_motors(point, motion), point.pd or {})
    _refuse_held_signals(linear, linear_of_free, inputs, outputs)
    return linear_of_free


def point_of(options: Linearizing | Oscillating | Responding | Sweeping) -> OperatingPoint:
    """Return the operating point of options: the object, with values that are given by name replaced."""
    own = part(OperatingPoint, options)
    if options.point is None:
        return own
    return replace(options.point, **{name: x for name, x in vars(own).items() if x != getattr(OperatingPoint(), name)})


def _refuse_held_signals(
    linear: Linearization, free: Linearization, inputs: Sequence[str], outputs: Sequence[str]
) -> None:
    """Raise `InputError` for a requested input or output of a held motor."""
    for option, requested, before, still_there in (
        ("--input", inputs, linear.inputs, free.inputs),
        ("--output", outputs, linear.outputs, free.outputs),
    ):
        still = [name for name in before if name not in still_there]
        if requested and still:
            what = f"{still[0]} is of a motor that is held, so nothing moves there: remove one of the two"
            raise InputError(linear.motion.source, option, what)


@operation(Linearizing)
def linearize(machine: MachineLike, options: Linearizing) -> Linearization:
    """Return M, D, K of small motions about an equilibrium or a state, and A, B, C, D as `space`.

    Raises
    ------
    InputError
        For unknown names, without equilibrium, for numbers out of range.
    """
    return _linear(machine, options, options.inputs, options.outputs)


def _linear(
    machine: MachineLike,
    options: Linearizing | Oscillating | Responding,
    inputs: Sequence[str] = (),
    outputs: Sequence[str] = (),
) -> Linearization:
    """Return a machine linearized at the operating point of options, with its motors held or controlled."""
    point = point_of(options)
    motion = motion_at(point, kept_machine(machine, options.scene), options.values, inputs, outputs)
    return linearized_at(point, motion, inputs, outputs)


@operation(Oscillating)
def modes(machine: MachineLike, options: Oscillating) -> Modes:
    """Return natural frequencies, mode shapes, the springs and bodies that store their energy, and sensitivities.

    Raises `InputError`.
    """
    return modes_of(_linear(machine, options))


def modes_of(linear: Linearization) -> Modes:
    """Return the modes of a linearized machine; raises `InputError` for one without springs."""
    from symoro_elastic.analysis.vibration import modes as vibration

    vibration.refuse_rigid(linear)
    return vibration.modes(linear)


def modes_along(
    machine: MachineLike, path: Mapping[str, Sequence[float]], options: Oscillating, progress: Progress = no_progress
) -> Tracked:
    """Return the modes at positions of joints, followed from one to the next."""
    from symoro_elastic.analysis.vibration.tracking import over_grid

    options = in_si_units(machine, options)
    point = point_of(options)
    if point.as_given:
        what = "modes along positions are those of equilibria: leave out --as-given"
        raise InputError("symoro-elastic", "--along", what)
    if point.thrusts:
        what = "thrusts are computed at one position: use --hover, or leave it out"
        raise InputError("symoro-elastic", "--along", what)
    motion = motion_at(point, kept_machine(machine, options.scene), options.values)
    lists = {name: list(positions) for name, positions in path.items()}
    locked = held_motors(point, motion)
    return over_grid(motion, lists, point.at, point.torques, locked, point.pd or {}, progress, point.hover)


@operation(Responding)
def response(machine: MachineLike, options: Responding) -> Response:
    """Return frequency responses from motors or forces to encoders or motions, with their poles and zeros.

    Raises `InputError`.
    """
    import numpy as np

    from symoro_elastic.analysis.vibration import responses
    from symoro_elastic.analysis.vibration.point_stiffness import point_stiffnesses
    from symoro_elastic.analysis.vibration.zeros import poles_and_zeros

    linear = _linear(machine, options, options.inputs, options.outputs)
    linear = responses.with_modal_damping(linear, options.damping)
    responses.refuse_missing_signals(linear)
    points = np.asarray(() if options.frequencies is None else options.frequencies, dtype=float)
    if len(points) and options.band:
        raise InputError("symoro-elastic", "--band", "frequencies are already given: remove --frequency or --band")
    points = points if len(points) else responses.frequency_grid(linear, *(options.band or ()))
    pairs = tuple(poles_and_zeros(linear, i, o) for i in linear.inputs for o in linear.outputs)
    result = responses.frequency_response(linear, points)
    stiffnesses = point_stiffnesses(linear, result)
    return replace(result, transfers=pairs, stiffnesses=stiffnesses, damping=options.damping)


@operation(Comparing)
def compare(machine: MachineLike, options: Comparing) -> Comparison:
    """Return the errors of Spong's reduced model and of the rigid limit against the full elastic model.

    On a motion of a file, or on a move of all motors. Raises `InputError`.
    """
    from symoro_elastic.analysis.vibration import comparison

    return comparison.compare(
        kept_machine(machine, options.scene), options.values, options.at, options.ratios, not options.free_motors,
        str(options.motion) if options.motion else None, options.stroke, options.duration, options.progress,
    )  # fmt: skip


@operation(Following)
def feed_forward(machine: MachineLike, options: Following) -> FeedForward:
    """Return the torques of motors that make the load, beyond the springs, follow a reference trajectory.

    Raises
    ------
    InputError
        Where springs or joints leave no feed-forward, and for a motion with too few derivatives.
    """
    from symoro_elastic.analysis.vibration import feed_forward as vibration

    of_values = the_machine(kept_machine(machine, options.scene), options.values)
    return vibration.feed_forward(of_values, _reference(of_values, options))


def _reference(machine: Machine, options: Following) -> ReferenceTrajectory:
    """Return the reference trajectory, by default as smooth as the machine needs."""
    from symoro_elastic.analysis.vibration import reference_trajectory
    from symoro_elastic.analysis.vibration.comparison import usual_duration
    from symoro_elastic.analysis.vibration.driven_joints import with_motors_on_load_joints
    from symoro_elastic.analysis.vibration.feed_forward import orders, starts

    machine, rate = with_motors_on_load_joints(machine), options.sample_rate
    smooth = max(orders(machine).values(), default=0) + 1
    if options.motion:
        return reference_trajectory.read_reference(str(options.motion), machine, options.degree, smooth, rate)
    strokes = options.strokes
    strokes = {"": float(strokes)} if isinstance(strokes, int | float) else strokes
    with reported_places({"--at": "--start"}):
        duration = usual_duration(machine, options.start) if options.duration is None else options.duration
    degree = smooth if options.degree is None else options.degree
    start = {**starts(machine), **options.start}
    return reference_trajectory.move(
        machine, start, strokes or {"": reference_trajectory.STROKE}, duration, degree, rate
    )
