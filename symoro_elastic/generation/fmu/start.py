"""Where an FMU starts, and the natural sizes of its states: the static equilibrium, and the linear model there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, placed
from symoro_elastic.generation.fmu.motors import Given, given_of
from symoro_elastic.generation.fmu.rest import AtRest, start_of_states
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.equilibrium import equilibrium, starting_point

ROUNDING = 1e-14
"""Of the largest torque: what is less holds nothing."""
NEAR = 1e-9
"""Distance, rad or m, of a position that is the one that was asked for."""
EARTH = 9.81
"""Acceleration, m/s2, that stands for gravity where a machine has none."""
LEAST_SPEED = 1.0
"""Of the fastest motion, rad/s, where nothing vibrates."""
PERIODS = 10
"""Of the slowest vibration, over which a simulation usually goes."""
MOST_PERIODS = 1000
"""Of the fastest vibration: importers allow solvers some hundred steps between a thousand times of output."""


@dataclass(frozen=True)
class Start:
    """Where an FMU starts: q and nominal positions and velocities (n,), q_dep (d,), torques (m,), SI units, radians.

    `fastest` is the largest magnitude of a pole, rad/s; `duration` a few periods of the slowest vibration, at most
    `MOST_PERIODS` of the fastest, s. `notes`
    say why this is not an equilibrium, where it is none, and which joints do not start where they were asked to.
    `motors` (m,) are positions of motors, `z` states of friction and drives and `states` their nominal values.
    """

    q: Array
    q_dep: Array
    torques: Array
    positions: Array
    velocities: Array
    fastest: float
    duration: float
    notes: tuple[str, ...] = ()
    motors: Array = field(default_factory=lambda: np.zeros(0))
    z: Array = field(default_factory=lambda: np.zeros(0))
    states: Array = field(default_factory=lambda: np.zeros(0))


def start_of(machine: Machine, at: Mapping[str, float]) -> Start:
    """Return the start of a machine whose motors stand `at` positions, rad or m, 0 or that of its motion unless given.

    Torques hold the motors. For other joints `at` is where the search for their equilibrium begins. Where none is
    found, all stand `at` positions, else where their springs are neutral, without torques. Raises `InputError` for
    joints that do not exist.
    """
    motion = EquationsOfMotion(machine)
    motions = DescribedMachine.of(machine).asked.motions
    given = motions[0].start if motions else {}
    known = {name: x for name, x in given.items() if name in motion.names}
    with placed({"--at": "--start"}):
        state, notes = _state(motion, {**known, **at})
    notes += _elsewhere(motion, state, at)
    own = motion.own_positions(state.q)
    M, _, K = motion.matrices("MDK", state.q, state.qd, state.qdd, state.torques)
    size, g = _size(motion), _gravity(motion)
    positions, rates = _natural(motion, (M, K), size, g)
    independent = {j: k for k, j in enumerate(motion.machine.independent)}
    chosen = [
        (positions[independent[j]], rates[independent[j]]) if j in independent else (1.0, 1.0)
        for j in machine.independent
    ]
    speeds = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))))
    fastest, slowest = max(speeds.max(initial=0.0), LEAST_SPEED), speeds[speeds > LEAST_SPEED].min(initial=np.inf)
    duration = PERIODS * 2 * np.pi / slowest if np.isfinite(slowest) else 1.0
    found = Start(
        np.array([own[j] for j in machine.independent]),
        np.array([own[j] for j in machine.dependent]),
        state.torques,
        np.array([x for x, _ in chosen]),
        np.array([x * w for x, w in chosen]),
        float(fastest),
        float(min(duration, MOST_PERIODS * 2 * np.pi / fastest)),
        tuple(notes),
        np.array([own[j] for j in machine.motors]),
    )
    return _with_states(machine, found, own, _torques(machine, M, positions, rates, state))


def _torques(machine: Machine, M: Array, positions: Array, rates: Array, state: State) -> Array:
    """Return natural sizes of the torques of motors: what their own inertia takes, what holds the machine, at least."""
    entries = {j: k for k, j in enumerate(machine.independent)}
    own = [
        abs(M[entries[j], entries[j]]) * positions[entries[j]] * rates[entries[j]] ** 2 if j in entries else 1.0
        for j in machine.motors
    ]
    return np.maximum(own, np.abs(state.torques))


def _with_states(machine: Machine, start: Start, own: Mapping[int, float], natural: Array) -> Start:
    """Return the start with the states of friction, which is bent nowhere, and of drives."""
    bent = machine.largest_deflections
    if not bent and given_of(machine)[0] is Given.TORQUES:
        return start
    if given_of(machine)[0] is Given.TORQUES:
        return replace(start, z=np.zeros(len(bent)), states=np.array(bent))
    z, sizes, is_rest = start_of_states(AtRest(machine, own, start.motors), start.torques, natural)
    sizes[: len(bent)] = bent
    said = () if is_rest else ("the drives do not start at rest: they do not reach the torques that hold the machine",)
    return replace(start, z=z, states=sizes, notes=(*start.notes, *said))


def _state(motion: EquationsOfMotion, at: Mapping[str, float]) -> tuple[State, list[str]]:
    """Return the equilibrium; without one the place where the search began, at rest, and why."""
    q = starting_point(motion, at)
    motion.refuse_open(q)
    try:
        return _rounded(motion, equilibrium(motion, at), q), []
    except InputError as error:
        zero = np.zeros_like(q)
        why = f"it does not start in equilibrium: {error.what.partition(';')[0]}"
        return State(q, zero, zero, zero, np.zeros(len(motion.motor_names))), [why]


def _rounded(motion: EquationsOfMotion, state: State, begun: Array) -> State:
    """Return an equilibrium with passive turns within half a turn of where they began, and no torques of rounding."""
    q = state.q.copy()
    for k, joint in enumerate(motion.joints):
        if joint.kind is Kind.PASSIVE and joint.sigma == 0 and not _is_shared(motion, k):
            q[k] -= 2 * np.pi * np.round((q[k] - begun[k]) / (2 * np.pi))
    torques = np.where(np.abs(state.torques) > ROUNDING * np.abs(state.tau).max(initial=0.0), state.torques, 0.0)
    return replace(state, q=q, torques=torques)


def _is_shared(motion: EquationsOfMotion, k: int) -> bool:
    """Return whether other joints move with a variable, by a ratio that a turn more would not leave as it is."""
    one = motion.joints[k]
    return any(str(one.variable) in joint.selected.names for joint in motion.machine.joints if joint.name != one.name)


def _elsewhere(motion: EquationsOfMotion, state: State, at: Mapping[str, float]) -> list[str]:
    """Return a line for each joint without a motor that starts elsewhere than `at`."""
    found = []
    for name, x in at.items():
        k = motion.index(name, "--start")
        if abs(state.q[k] - x) > NEAR * max(abs(x), 1.0):
            unit = motion.joints[k].unit
            what = f"{name} starts in equilibrium at {state.q[k]:.6g} {unit}, the search began at {x:g} {unit}"
            found.append(f"--start: {what}: only motors are held")
    return found


def _natural(motion: EquationsOfMotion, matrices: tuple[Array, Array], size: float, g: float) -> tuple[Array, Array]:
    """Return natural sizes of positions, rad or m, and rates of their motions, rad/s.

    A spring deflects by what its load does to it under an acceleration of g, or g over the size of the machine for
    turns; other joints turn by a radian or go as far as the machine is large, at the rate of a pendulum of this size.
    """
    sizes = np.array([1.0 if joint.sigma == 0 else size for joint in motion.joints])
    rates = np.full(len(sizes), np.sqrt(g / size))
    for k, joint in enumerate(motion.joints):
        inertia, stiffness = (float(matrix[k, k]) for matrix in matrices)
        if joint.kind is Kind.ELASTIC and stiffness > 0 and inertia > 0:
            acceleration = g if joint.sigma else g / size
            sizes[k], rates[k] = inertia * acceleration / stiffness, np.sqrt(stiffness / inertia)
    return sizes, rates


def _gravity(motion: EquationsOfMotion) -> float:
    return float(np.linalg.norm(motion.values(map(motion.bound.cell, motion.machine.base.gravity)))) or EARTH


def _size(motion: EquationsOfMotion) -> float:
    """Return the longest sum of lengths b, d and r from the base to a frame, m; 1 where there are none."""
    parameters = {parameter.name for parameter in motion.machine.parameters}
    reached = [0.0]
    for joint in motion.machine.joints:
        lengths = [x for x in (joint.b, joint.d, joint.r) if x.names <= parameters]
        total = sum(map(abs, motion.values(map(motion.bound.cell, lengths)).tolist()))
        reached.append(reached[joint.antecedent] + total)
    return max(reached) or 1.0
