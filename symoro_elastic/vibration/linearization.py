"""Small motions about a state: M, D, K, and the state space of named inputs and outputs.

    M dqdd + D dqd + K dq = F du,    dy = Cq dq + Cv dqd + Ca dqdd

K = dr/dq holds springs, gravity and what velocities, accelerations and wrenches add; D = dr/dqd friction,
dampers and gyroscopic terms; M = A [8].
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.free_base import with_base_coordinates
from symoro_elastic.machine.machine import Machine
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.vibration.independent_motors import with_independent_motors
from symoro_elastic.vibration.inertia import refuse_singular
from symoro_elastic.vibration.signals import (
    FrameSignal,
    Signal,
    default_inputs,
    default_outputs,
    inputs,
    joint_signals,
    outputs,
    points_of,
)

LARGEST = 1e100
"""Of inertia, damping and stiffness, SI units: far above all machines, and far from overflow."""
REST_TOLERANCE = 1e-9
"""A velocity or an acceleration up to here is rounding, SI units."""
Maps = tuple[tuple[Array, Array, Array], ...]


@dataclass(frozen=True)
class StateSpace:
    """dx' = A dx + B du, dy = C dx + D du, with x = [q; qd] of `states`; SI units, radians."""

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class Linearization:
    """M, D, K (n, n), F (n, inputs), Cq, Cv, Ca (outputs, n) about a state, SI units, radians.

    `kept` are indices in q of the coordinates, whose names are `coordinates`: motors that are held are left out.
    """

    motion: EquationsOfMotion
    state: State
    M: Array
    D: Array
    K: Array
    F: Array
    Cq: Array
    Cv: Array
    Ca: Array
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    kept: tuple[int, ...]
    gains: Array

    def __post_init__(self) -> None:
        """Raise `InputError` for numbers on which the eigenvalues would overflow."""
        for name, matrix in (("M", self.M), ("D", self.D), ("K", self.K)):
            largest = np.abs(matrix).max(initial=0.0)
            if not largest <= LARGEST:
                row = int(np.unravel_index(np.abs(matrix).argmax(), matrix.shape)[0])
                what = f"{largest:g} in {name} is out of range (up to {LARGEST:g}): check units, --value and --pd"
                raise InputError(self.motion.source, self.coordinates[row], what)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of the joints that move."""
        return tuple(self.motion.names[k] for k in self.kept)

    @property
    def unrest(self) -> tuple[str, ...]:
        """A line if the state moves, with the fastest joint and the largest acceleration."""
        moving = []
        for name, values, per in (("qd", self.state.qd, "s"), ("qdd", self.state.qdd, "s2")):
            k = int(np.argmax(np.abs(values))) if len(values) else 0
            if np.abs(values).max(initial=0.0) > REST_TOLERANCE:
                unit = self.motion.joints[k].unit
                moving.append(f"{name} up to {abs(values[k]):.4g} {unit}/{per} at joint {self.motion.names[k]}")
        return (f"not at rest: {', '.join(moving)}",) if moving else ()

    @property
    def notes(self) -> tuple[str, ...]:
        """A line if the state moves, and one for each motor that is held."""
        return *self.unrest, *(f"{name} is held: its torque and its encoder are no signals" for name in self.held)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the motors that are held."""
        return tuple(self.motion.names[k] for k in self.motion.motors if k not in self.kept)

    @property
    def is_symmetric(self) -> bool:
        """Whether K is symmetric to rounding, so that a potential energy exists."""
        return bool(np.abs(self.K - self.K.T).max(initial=0.0) <= 1e-12 * np.abs(self.K).max(initial=0.0))

    @cached_property
    def space(self) -> StateSpace:
        """A, B, C, D of the state [dq; dqd]; raises `InputError` where M is not positive definite."""
        refuse_singular(self.motion, self.M, self.kept)
        n = len(self.kept)
        solved = np.linalg.solve(self.M, np.hstack([-self.K, -self.D, self.F]))
        upper = np.hstack([np.zeros((n, n)), np.eye(n)])
        fed = self.Ca @ solved
        return StateSpace(
            np.vstack([upper, solved[:, : 2 * n]]),
            np.vstack([np.zeros_like(self.F), solved[:, 2 * n :]]),
            np.hstack([self.Cq, self.Cv]) + fed[:, : 2 * n],
            fed[:, 2 * n :],
            (*(f"{name}.q" for name in self.coordinates), *(f"{name}.qd" for name in self.coordinates)),
            self.inputs,
            self.outputs,
        )


def linearize(
    motion: EquationsOfMotion, state: State, ins: Sequence[str] | None = None, outs: Sequence[str] | None = None
) -> Linearization:
    """Return the linearization about a state; torques of motors and their encoders unless signals are named.

    Points of signals must be among those of `motion` (`motion_of` sees to it). Raises `InputError` for
    signals that do not exist.
    """
    wanted_in = inputs(motion.given, default_inputs(motion.given) if ins is None else ins)
    wanted_out = outputs(motion.given, default_outputs(motion.given) if outs is None else outs)
    motion.refuse_open(state.q)
    M, D, K = motion.matrices("MDK", state.q, state.qd, state.qdd)
    n = len(state.q)
    of_frames = any(isinstance(s, FrameSignal) for s in (*wanted_in, *wanted_out))
    maps = _frame_maps(motion, state) if of_frames else ()
    F = np.stack([_column(motion, s, maps, n) for s in wanted_in], axis=1) if wanted_in else np.zeros((n, 0))
    rows = [_rows(motion, s, maps, n) for s in wanted_out]
    Cq, Cv, Ca = (np.array([row[order] for row in rows]).reshape(len(rows), n) for order in range(3))
    return Linearization(
        motion, state, (M + M.T) / 2, D, K, F, Cq, Cv, Ca,
        tuple(s.name for s in wanted_in), tuple(s.name for s in wanted_out), tuple(range(n)), np.zeros(n),
    )  # fmt: skip


def motion_of(
    machine: Machine, values: Mapping[str, float] | None = None, ins: Sequence[str] = (), outs: Sequence[str] = ()
) -> EquationsOfMotion:
    """Return the equations of motion of a machine, with the points of these signals.

    A floating base has six coordinates more: base.x, base.y, base.z, base.rx, base.ry, base.rz.
    """
    machine = with_independent_motors(with_base_coordinates(machine))
    return EquationsOfMotion(machine, values, points_of([*inputs(machine, ins), *outputs(machine, outs)]))


def _frame_maps(
    motion: EquationsOfMotion, state: State
) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """Return derivatives of V and V' of all frames, in axes of frame 0, by q, qd, qdd; dV/dqd is the Jacobian J."""
    v, vd = motion.seen
    both = motion.jacobians([*v, *vd], state)
    velocity = (both[0][: len(v)], both[1][: len(v)], both[2][: len(v)])
    return velocity, (both[0][len(v) :], both[1][len(v) :], both[2][len(v) :])


def _frame_row(motion: EquationsOfMotion, signal: FrameSignal) -> int:
    point = motion.points.index((signal.number, signal.at)) if signal.at else None
    return motion.row_of(signal.number, point) + signal.component


def _column(motion: EquationsOfMotion, signal: Signal, maps: Maps, n: int) -> Array:
    """Return the generalized forces of a unit input: J^T of a wrench."""
    column: Array = maps[0][1][_frame_row(motion, signal)] if isinstance(signal, FrameSignal) else np.eye(n)[signal.k]
    return column


def _rows(motion: EquationsOfMotion, signal: Signal, maps: Maps, n: int) -> tuple[Array, Array, Array]:
    """Return the rows of Cq, Cv, Ca of an output."""
    zero = np.zeros(n)
    if not isinstance(signal, FrameSignal):
        rows = [zero, zero, zero]
        rows[signal.order] = np.eye(n)[signal.k]
        return rows[0], rows[1], rows[2]
    row = _frame_row(motion, signal)
    velocity, acceleration = maps
    if signal.order == 0:
        return velocity[1][row], zero, zero
    by_q, by_qd, by_qdd = (block[row] for block in (velocity if signal.order == 1 else acceleration))
    return by_q, by_qd, by_qdd


def with_motors(
    linear: Linearization, held: Collection[str] = (), gains: Mapping[str, tuple[float, float]] | None = None
) -> Linearization:
    """Return the linearization with some motors held, others under a controller tau = -kp dq - kd dqd.

    `gains` gives (kp, kd) in N m/rad, N m s/rad or N/m, N s/m. The torque and the encoder of a motor that is held
    are no signals any more. Raises `InputError` for joints without motor.
    """
    motion = linear.motion
    fixed = {_motor(motion, name, "--hold") for name in held}
    K, D, springs = linear.K.copy(), linear.D.copy(), linear.gains.copy()
    for name, (kp, kd) in (gains or {}).items():
        k = _motor(motion, name, "--pd")
        if not np.isfinite([kp, kd]).all():
            raise InputError(motion.source, "--pd", f"{name}: gains {kp:g} and {kd:g} are no numbers to compute with")
        if k in fixed or k not in linear.kept:
            raise InputError(motion.source, "--pd", f"{name} is held: leave out one of --hold and --pd")
        row = linear.kept.index(k)
        K[row, row] += kp
        D[row, row] += kd
        springs[row] += kp
    rows = [row for row, k in enumerate(linear.kept) if k not in fixed]
    still = joint_signals(motion.names[k] for k in fixed)
    ins, outs = ([c for c, name in enumerate(names) if name not in still] for names in (linear.inputs, linear.outputs))
    square, seen = np.ix_(rows, rows), np.ix_(outs, rows)
    return replace(
        linear, M=linear.M[square], D=D[square], K=K[square], F=linear.F[np.ix_(rows, ins)], Cq=linear.Cq[seen],
        Cv=linear.Cv[seen], Ca=linear.Ca[seen], kept=tuple(linear.kept[row] for row in rows), gains=springs[rows],
        inputs=tuple(linear.inputs[c] for c in ins), outputs=tuple(linear.outputs[c] for c in outs),
    )  # fmt: skip


def _motor(motion: EquationsOfMotion, name: str, place: str) -> int:
    k = motion.index(name, place)
    if k not in motion.motors:
        motors = ", ".join(motion.names[m] for m in motion.motors) or "this machine has none"
        raise InputError(motion.source, place, f"{name} has no motor; motors are {motors}")
    return k
