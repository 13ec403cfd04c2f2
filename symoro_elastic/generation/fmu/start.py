"""Start of an FMU, and natural sizes of its states: the static equilibrium, and the linear model there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, reported_places
from symoro_elastic.generation.fmu.programs import Given, given_of
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.steps.closed_dynamics import closed_trace
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.equilibrium import equilibrium, starting_point
from symoro_elastic.symbolic.expression import operand

ROUNDING = 1e-14
"""Of the largest torque: what is less holds nothing."""
NEAR = 1e-9
"""Distance, rad or m, of a position that is the one that was asked for."""
EARTH = 9.81
"""Acceleration, m/s2, in place of gravity where a machine has none."""
LEAST_SPEED = 1.0
"""Of the fastest motion, rad/s, where nothing vibrates."""
PERIODS = 10
"""Of the slowest vibration, over which a simulation usually goes."""
MOST_PERIODS = 1000
"""Of the fastest vibration: importers allow solvers some hundred steps between a thousand times of output."""
STEP = 1e-4
"""Of a state, for slopes: equations are linear, so rounding alone counts."""
ITERATIONS = 3
SOLVED = 1e-6
"""Largest residual of solved equations, relative to the torques."""


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
    """Return the start of a machine with motors `at` positions, rad or m, 0 or that of its motion unless given.

    Torques hold the motors. For other joints `at` is where the search for their equilibrium begins. Without an
    equilibrium all are `at` positions, else where their springs are neutral, without torques. Raises `InputError` for
    joints that do not exist.
    """
    motion = EquationsOfMotion(machine)
    motions = DescribedMachine.of(machine).asked.motions
    start_of_motion = motions[0].start if motions else {}
    positions_of_motion = {name: x for name, x in start_of_motion.items() if name in motion.names}
    with reported_places({"--at": "--start"}):
        state, notes = _state(motion, {**positions_of_motion, **at})
    notes += _elsewhere(motion, state, at)
    own = motion.own_positions(state.q)
    M, _, K = motion.matrices("MDK", state.q, state.qd, state.qdd, state.torques)
    gravity = motion.values(map(motion.bound.cell, motion.machine.base.gravity))
    size, g = _size(motion), float(np.linalg.norm(gravity)) or EARTH
    positions, rates = _natural(motion, (M, K), size, g)
    independent = {j: k for k, j in enumerate(motion.machine.independent)}
    chosen = [
        (positions[independent[j]], rates[independent[j]]) if j in independent else (1.0, 1.0)
        for j in machine.independent
    ]
    speeds = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))))
    fastest, slowest = max(speeds.max(initial=0.0), LEAST_SPEED), speeds[speeds > LEAST_SPEED].min(initial=np.inf)
    duration = PERIODS * 2 * np.pi / slowest if np.isfinite(slowest) else 1.0
    start = Start(
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
    return _with_states(machine, start, own, _torques(machine, M, positions, rates, state))


def _torques(machine: Machine, M: Array, positions: Array, rates: Array, state: State) -> Array:
    """Return nominal torques of the motors: those that accelerate their own inertia, at least the static torques."""
    entries = {j: k for k, j in enumerate(machine.independent)}
    own = [
        abs(M[entries[j], entries[j]]) * positions[entries[j]] * rates[entries[j]] ** 2 if j in entries else 1.0
        for j in machine.motors
    ]
    return np.maximum(own, np.abs(state.torques))


def _with_states(machine: Machine, start: Start, own: Mapping[int, float], natural: Array) -> Start:
    """Return the start with the states of friction, undeflected, and of drives."""
    bent = machine.largest_deflections
    if not bent and given_of(machine)[0] is Given.TORQUES:
        return start
    if given_of(machine)[0] is Given.TORQUES:
        return replace(start, z=np.zeros(len(bent)), states=np.array(bent))
    z, sizes, is_rest = start_of_states(AtRest(machine, own, start.motors), start.torques, natural)
    sizes[: len(bent)] = bent
    note = () if is_rest else ("the drives do not start at rest: they do not reach the torques that hold the machine",)
    return replace(start, z=z, states=sizes, notes=(*start.notes, *note))


def _state(motion: EquationsOfMotion, at: Mapping[str, float]) -> tuple[State, list[str]]:
    """Return the equilibrium; without one the place where the search began, at rest, and why."""
    q = starting_point(motion, at)
    motion.refuse_open(q)
    try:
        return _turns_near_start(motion, equilibrium(motion, at), q), []
    except InputError as error:
        zero = np.zeros_like(q)
        why = f"it does not start in equilibrium: {error.what.partition(';')[0]}"
        return State(q, zero, zero, zero, np.zeros(len(motion.motor_names))), [why]


def _turns_near_start(motion: EquationsOfMotion, state: State, q_start: Array) -> State:
    """Return an equilibrium with passive turns within half a turn of where they began, and no torques of rounding."""
    q = state.q.copy()
    for k, joint in enumerate(motion.joints):
        if joint.kind is Kind.PASSIVE and joint.sigma == 0 and not _is_shared(motion, k):
            q[k] -= 2 * np.pi * np.round((q[k] - q_start[k]) / (2 * np.pi))
    torques = np.where(np.abs(state.torques) > ROUNDING * np.abs(state.tau).max(initial=0.0), state.torques, 0.0)
    return replace(state, q=q, torques=torques)


def _is_shared(motion: EquationsOfMotion, k: int) -> bool:
    """Return whether other joints depend on a joint's variable, so that a full turn of it would move them."""
    moving = motion.joints[k]
    return any(
        str(moving.variable) in joint.selected.names for joint in motion.machine.joints if joint.name != moving.name
    )


def _elsewhere(motion: EquationsOfMotion, state: State, at: Mapping[str, float]) -> list[str]:
    """Return a line for each joint without a motor that starts elsewhere than `at`."""
    lines = []
    for name, x in at.items():
        k = motion.index(name, "--start")
        if abs(state.q[k] - x) > NEAR * max(abs(x), 1.0):
            unit = motion.joints[k].unit
            what = f"{name} starts in equilibrium at {state.q[k]:.6g} {unit}, the search began at {x:g} {unit}"
            lines.append(f"--start: {what}: only motors are held")
    return lines


def _natural(motion: EquationsOfMotion, matrices: tuple[Array, Array], size: float, g: float) -> tuple[Array, Array]:
    """Return nominal sizes of positions, rad or m, and nominal rates of their motions, rad/s.

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


def _size(motion: EquationsOfMotion) -> float:
    """Return the longest sum of lengths b, d and r from the base to a frame, m; 1 where there are none."""
    reached = [0.0]
    for joint in motion.machine.joints:
        lengths = [x for x in (joint.b, joint.d, joint.r) if x.names <= motion.machine.parameter_names]
        total = sum(map(abs, motion.values(map(motion.bound.cell, lengths)).tolist()))
        reached.append(reached[joint.antecedent] + total)
    return max(reached) or 1.0


class AtRest:
    """Rates and torques of a machine at rest at q (n,), motors at x (m,), as functions of states z and torques."""

    def __init__(self, machine: Machine, q: Mapping[int, float], x: Array) -> None:
        bound = Bound(machine)
        trace = closed_trace(bound)
        self._inputs = {argument.name: argument.symbols for argument in trace.inputs}
        self.friction, self.states = len(machine.bristles), len(self._inputs.get("z", ()))
        rates = trace.results["zd"].entries[self.friction :] if "zd" in trace.results else ()
        self._roots = [*map(operand, rates), *map(operand, trace.results["tau_m"].entries)]
        symbols = machine.given_values
        symbols |= dict.fromkeys((name for names in self._inputs.values() for name in names), 0.0)
        symbols |= {str(bound.q[j].operands[0]): value for j, value in q.items() if j in bound.q}
        symbols |= dict(zip(self._inputs["r"], x.tolist(), strict=True))
        self._symbols: dict[str, float] = symbols

    def solution(self, required: Array, fed: Array) -> tuple[Array, bool]:
        """Return z (states,) at which the torques are those required (m,), `fed` included, and whether it is exact.

        Of several solutions it is the smallest.
        """
        z, driven = np.zeros(self.states), self.states - self.friction
        goal = np.concatenate([np.zeros(driven), required])
        if not driven:
            return z, True
        rows, columns = np.ones(len(goal)), np.ones(driven)
        for _ in range(ITERATIONS):
            residual = goal - self._values(z, fed)
            slopes = np.transpose(
                [(self._values(z + STEP * unit, fed) - self._values(z, fed)) / STEP for unit in np.eye(self.states)]
            )[:, self.friction :]
            rows = _over(np.abs(slopes).max(axis=1))
            columns = _over(np.abs(rows[:, None] * slopes).max(axis=0))
            scaled = rows[:, None] * slopes * columns
            z[self.friction :] += columns * np.linalg.lstsq(scaled, rows * residual, rcond=1e-12)[0]
        off = rows * (goal - self._values(z, fed))
        return z, bool(np.abs(off).max() <= SOLVED * max(np.abs(required).max(), np.abs(rows * goal).max()))

    def _values(self, z: Array, fed: Array) -> Array:
        """Return the rates zd of the states of drives, then the torques tau_m, at states z."""
        symbols = self._symbols | dict(zip(self._inputs.get("z", ()), z.tolist(), strict=True))
        symbols |= dict(zip(self._inputs["tau"], fed.tolist(), strict=True))
        return values_along(self._roots, symbols, 1)[:, 0]


def _over(x: Array) -> Array:
    """Return 1/x, 0 where x is 0."""
    reciprocal: Array = np.divide(1.0, x, out=np.zeros_like(x), where=x > 0)
    return reciprocal


def start_of_states(rest: AtRest, torques: Array, natural: Array) -> tuple[Array, Array, bool]:
    """Return z (states,) at the start, natural sizes of the states of drives, and whether the start is at rest.

    `torques` hold the machine, `natural` (m,) are of the size that motors give. A state has the size at which it gives
    such a torque; one that is zero then, that of the torque.
    """
    z, is_rest = rest.solution(torques, torques)
    none = np.zeros_like(natural)
    sizes = np.abs(rest.solution(natural, natural)[0])
    alone, is_solved = rest.solution(natural, none)
    sizes = np.maximum(sizes, np.abs(alone)) if is_solved else sizes
    return z, np.where(sizes > 1e-9 * natural.max(initial=0.0), sizes, natural.max(initial=1.0)), is_rest
