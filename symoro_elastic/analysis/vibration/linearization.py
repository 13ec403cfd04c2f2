"""Small motions about a state: M, D, K, and the state space of named inputs and outputs.

    M dqdd + D dqd + K dq = F du,    dy = Cq dq + Cv dqd + Ca dqdd

K = dr/dq holds springs, gravity and what velocities, accelerations and wrenches add; D = dr/dqd friction,
dampers and gyroscopic terms; M = A [8].
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.results import Result
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.inertia import refuse_singular
from symoro_elastic.numerics.motion.shared_motors import line_on_undetermined
from symoro_elastic.numerics.motion.signals import (
    FrameSignal,
    Signal,
    default_inputs,
    default_outputs,
    inputs,
    joint_signals,
    outputs,
)

LARGEST = 1e100
"""Of inertia, damping and stiffness, SI units: far above all machines, and far from overflow."""
REST_TOLERANCE = 1e-9
"""A velocity or an acceleration up to here is rounding, SI units."""


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


@dataclass(frozen=True, repr=False)
class Linearization(Result):
    """M, D, K (n, n), F (n, inputs), Cq, Cv, Ca (outputs, n) about a state, SI units, radians.

    `kept` are indices in q of the coordinates, whose names are `coordinates`: motors that are held are left out.
    `motors` (m, n) are the changes of all motors' variables with them, S_m; `gains` (m, 2) are kp and kd of their
    controllers.
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
    motors: Array
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
    def doubts(self) -> tuple[str, ...]:
        """Lines about the state: that it moves, that motors share torques which nothing determines one by one, that
        springs stand within their backlash, and that bristles of dry friction are in no linear model."""
        motion = self.motion
        loaded = any(self.state.torques[motion.machine.motors.index(j)] for j in motion.followers)
        shared = () if self.unrest or not loaded else line_on_undetermined(motion.machine, motion.followers)
        return (*self.unrest, *shared, *self._play, *self._bristles)

    @property
    def _play(self) -> Iterator[str]:
        """Lines about springs that stand within their backlash, which makes them soft."""
        motion = self.motion
        for name, x in zip(motion.names, self.state.q, strict=True):
            joint = next(one for one in motion.machine.joints if one.name == name)
            within = joint.spring.backlash.value(motion.parameters) / 2
            if abs(x - joint.spring.neutral.value(motion.parameters)) < within:
                yield f"{name} stands within its backlash, where its spring hardly acts: loads press it to a side"

    @property
    def _bristles(self) -> Iterator[str]:
        """A line about dry friction with states, which holds joints that hardly move as a spring does."""
        names = [self.motion.given.joint(j).name for j in self.motion.given.bristles]
        if names:
            yield f"bristles of dry friction are left out: {', '.join(names)}; joints that hardly move are stiffer"

    @property
    def notes(self) -> tuple[str, ...]:
        """Lines about the state, and one for each motor that is held."""
        return *self.doubts, *(f"{name} is held: its torque and its encoder are not signals" for name in self.held)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the motors that are held, and of those that move with these."""
        return tuple(name for name, row in zip(self.motion.motor_names, self.motors, strict=True) if not row.any())

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

    @property
    def headline(self) -> str:
        """Machine, coordinates, inputs and outputs."""
        signals = f"{len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return f"Linearization of {self.motion.machine.name}: {len(self.kept)} coordinates, {signals}"


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
    M, D, K = motion.matrices("MDK", state.q, state.qd, state.qdd, state.torques)
    n = len(state.q)
    roots = [root_of(motion, s) for s in (*wanted_in, *wanted_out)]
    by_q, by_qd, by_qdd = motion.jacobians(roots, state)
    F = by_qd[: len(wanted_in)].T
    rows = [_rows(by_q[k], by_qd[k], by_qdd[k], s.order) for k, s in enumerate(wanted_out, start=len(wanted_in))]
    Cq, Cv, Ca = (np.array([row[k] for row in rows]).reshape(len(rows), n) for k in range(3))
    motors = motion.motor_slopes(state.q)
    return Linearization(
        motion, state, (M + M.T) / 2, D, K, F, Cq, Cv, Ca, tuple(s.name for s in wanted_in),
        tuple(s.name for s in wanted_out), tuple(range(n)), motors, np.zeros((len(motors), 2)),
    )  # fmt: skip


def root_of(motion: EquationsOfMotion, signal: Signal, at_rest: bool = False) -> Scalar:
    """Return the expression of the velocity behind a signal, of the acceleration behind one that is an acceleration.

    That of a velocity by qd is the Jacobian J, and J^T a unit wrench on the coordinates, or S_m^T a unit torque (L3).
    `at_rest` it is the velocity for all signals, as the acceleration there is J qdd.
    """
    if isinstance(signal, FrameSignal):
        point = motion.points.index((signal.number, signal.at)) if signal.at else None
        row, blocks = motion.row_of(signal.number, point) + signal.component, motion.frame_motions
    else:
        row, blocks = motion.machine.with_variable.index(signal.number), motion.joint_coordinate_rates
    root: Scalar = blocks[signal.order == 2 and not at_rest][row]
    return root


def _rows(by_q: Array, by_qd: Array, by_qdd: Array, order: int) -> tuple[Array, Array, Array]:
    """Return the rows of Cq, Cv, Ca of an output: a position (0), a velocity (1) or an acceleration (2)."""
    return (by_q, by_qd, by_qdd) if order else (by_qd, 0 * by_qd, 0 * by_qd)


def with_motors(
    linear: Linearization, held: Collection[str] = (), gains: Mapping[str, tuple[float, float]] | None = None
) -> Linearization:
    """Return the linearization with some motors held, others under a controller tau = -kp dq - kd dqd.

    `gains` gives (kp, kd) in N m/rad, N m s/rad or N/m, N s/m. The torque and the encoder of a motor that is held
    are not signals any more. Raises `InputError` for joints without motor.
    """
    motion, kept = linear.motion, list(linear.kept)
    fixed = _held(linear, held)
    K, D, springs = linear.K.copy(), linear.D.copy(), linear.gains.copy()
    for name, (kp, kd) in (gains or {}).items():
        m = motion.motor(name, "--pd")
        if not np.isfinite([kp, kd]).all():
            raise InputError(motion.source, "--pd", f"{name}: gains {kp:g} and {kd:g} are not numbers to compute with")
        row = linear.motors[m]
        if not row[[k not in fixed for k in kept]].any():
            raise InputError(motion.source, "--pd", f"{name} is held: remove --hold or --pd")
        K += kp * np.outer(row, row)
        D += kd * np.outer(row, row)
        springs[m] += kp, kd
    rows = [row for row, k in enumerate(kept) if k not in fixed]
    motors = linear.motors[:, rows]
    still = joint_signals(name for name, row in zip(motion.motor_names, motors, strict=True) if not row.any())
    ins, outs = ([c for c, name in enumerate(names) if name not in still] for names in (linear.inputs, linear.outputs))
    square, seen = np.ix_(rows, rows), np.ix_(outs, rows)
    return replace(
        linear, M=linear.M[square], D=D[square], K=K[square], F=linear.F[np.ix_(rows, ins)], Cq=linear.Cq[seen],
        Cv=linear.Cv[seen], Ca=linear.Ca[seen], kept=tuple(kept[row] for row in rows), motors=motors, gains=springs,
        inputs=tuple(linear.inputs[c] for c in ins), outputs=tuple(linear.outputs[c] for c in outs),
    )  # fmt: skip


def _held(linear: Linearization, names: Collection[str]) -> set[int]:
    """Return the indices in q that are fixed if some motors are; raises `InputError` where a motor still moves."""
    motion = linear.motion
    held = [motion.motor(name, "--hold") for name in names]
    slopes = linear.motors[held]
    fixed = {k for column, k in enumerate(linear.kept) if slopes[:, column].any()}
    if held and len(fixed) > np.linalg.matrix_rank(slopes):
        moving = ", ".join(motion.names[k] for k in sorted(fixed))
        what = f"{', '.join(names)} alone would leave {moving} free to move together: hold them all"
        raise InputError(motion.source, "--hold", what)
    return fixed
