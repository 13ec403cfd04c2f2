"""Where an FMU starts, and the natural sizes of its states: the static equilibrium, and the linear model there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.vibration.equilibrium import equilibrium, starting_point

EARTH = 9.81
"""Acceleration, m/s2, that stands for gravity where a machine has none."""
LEAST_SPEED = 1.0
"""Of the fastest motion, rad/s, where nothing vibrates."""
PERIODS = 10
"""Of the slowest vibration, over which a simulation usually goes."""


@dataclass(frozen=True)
class Start:
    """Where an FMU starts: q and nominal positions and velocities (n,), q_dep (d,), torques (m,), SI units, radians.

    `fastest` is the largest magnitude of a pole, rad/s; `duration` a few periods of the slowest vibration, s. `note`
    says why this is no equilibrium, where it is none.
    """

    q: Array
    q_dep: Array
    torques: Array
    positions: Array
    velocities: Array
    fastest: float
    duration: float
    note: str = ""


def start_of(machine: Machine, at: Mapping[str, float]) -> Start:
    """Return the start of a machine whose motors stand `at` positions, rad or m, 0 or that of its motion unless given.

    Torques hold the motors. Where nothing supports some joint, all stand where their springs are neutral, without
    torques. Raises `InputError` for joints that do not exist.
    """
    motion = EquationsOfMotion(machine)
    given = machine.motions[0].start if machine.motions else {}
    known = {name: x for name, x in given.items() if name in motion.names}
    state, note = _state(motion, {**known, **at})
    own = motion.own_positions(state.q)
    M, _, K = motion.matrices("MDK", state.q, state.qd, state.qdd, state.torques)
    size, g = _size(motion), _gravity(motion)
    positions, rates = _natural(motion, (M, K), size, g)
    moving = {j: k for k, j in enumerate(motion.machine.moving)}
    chosen = [(positions[moving[j]], rates[moving[j]]) if j in moving else (1.0, 1.0) for j in machine.moving]
    speeds = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))))
    fastest, slowest = max(speeds.max(initial=0.0), LEAST_SPEED), speeds[speeds > LEAST_SPEED].min(initial=np.inf)
    return Start(
        np.array([own[j] for j in machine.moving]),
        np.array([own[j] for j in machine.dependent]),
        state.torques,
        np.array([x for x, _ in chosen]),
        np.array([x * w for x, w in chosen]),
        float(fastest),
        float(PERIODS * 2 * np.pi / slowest) if np.isfinite(slowest) else 1.0,
        note,
    )


def _state(motion: EquationsOfMotion, at: Mapping[str, float]) -> tuple[State, str]:
    """Return the equilibrium; without one the neutral positions at rest, and why."""
    q = starting_point(motion, at)
    motion.refuse_open(q)
    try:
        return equilibrium(motion, at), ""
    except InputError as error:
        zero = np.zeros_like(q)
        return State(q, zero, zero, zero, np.zeros(len(motion.motor_names))), error.what.partition(";")[0]


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
