"""Small motions about a state: M, D, K, and the state space of named inputs and outputs.

    M dqdd + D dqd + K dq = F du,    dy = Cq dq + Cv dqd + Ca dqdd

K = dr/dq holds springs, gravity and what velocities, accelerations and wrenches add; D = dr/dqd friction,
dampers and gyroscopic terms; M = A [8].

Derivatives by parameters of M, D, K, F and C, and through them of responses, poles and damping ratios.

    dG/dp = C Z^-1 (dF - dZ Z^-1 F) + dC Z^-1 F,    dZ = s^2 dM + s dD + dK,    Z = s^2 M + s D + K
    d lambda/dp = -psi^T dZ(lambda) phi / psi^T (2 lambda M + D) phi,    Z phi = 0, Z^T psi = 0

All are total: an equilibrium that was solved for moves with p, dq/dp = -K^-1 dr/dp, and M, D, K, F, C with it. They are
exact, by dual numbers over the equations of motion.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array, ComplexArray
from symoro_elastic.foundation.errors import NOT_FINITE, InputError
from symoro_elastic.foundation.results import Result
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.names import no_such
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.independent_joints import line_on_undetermined
from symoro_elastic.numerics.motion.inertia import refuse_singular
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


DISPLACED = 2.0**-40
"""Relative displacement of a frequency at which a dynamic stiffness is singular to the last digit."""
BLOCK = 256
REPEATED = 1e-7
"""Of the largest singular value of Z at a pole, below which the second smallest is that of another pole there."""


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
        """Raise `InputError` for numbers at which eigenvalues would overflow."""
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
        """Notes on the state: that it moves, that motors share torques which nothing determines one by one, that
        springs stand within their backlash, and that bristles of dry friction are in no linear model."""
        motion = self.motion
        loaded = any(self.state.torques[motion.machine.motors.index(j)] for j in motion.followers)
        shared = () if self.unrest or not loaded else line_on_undetermined(motion.machine, motion.followers)
        return (*self.unrest, *shared, *self._play, *self._bristles)

    @property
    def _play(self) -> Iterator[str]:
        """Notes on springs within their backlash, where they are soft."""
        motion = self.motion
        for name, x in zip(motion.names, self.state.q, strict=True):
            joint = next(row for row in motion.machine.joints if row.name == name)
            within = joint.spring.backlash.value(motion.parameters) / 2
            if abs(x - joint.spring.neutral.value(motion.parameters)) < within:
                yield f"{name} stands within its backlash, where its spring hardly acts: loads press it to a side"

    @property
    def _bristles(self) -> Iterator[str]:
        """A note on dry friction with states, which holds nearly motionless joints like a spring."""
        names = [self.motion.given.joint(j).name for j in self.motion.given.bristles]
        if names:
            yield f"bristles of dry friction are left out: {', '.join(names)}; joints that hardly move are stiffer"

    @property
    def notes(self) -> tuple[str, ...]:
        """Lines about the state, and one for each locked motor."""
        return *self.doubts, *(f"{name} is held: its torque and its encoder are not signals" for name in self.held)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the locked motors, and of motors coupled to them."""
        return tuple(name for name, row in zip(self.motion.motor_names, self.motors, strict=True) if not row.any())

    @property
    def is_symmetric(self) -> bool:
        """Whether K is symmetric within rounding, so that a potential energy exists."""
        return bool(np.abs(self.K - self.K.T).max(initial=0.0) <= 1e-12 * np.abs(self.K).max(initial=0.0))

    @cached_property
    def space(self) -> StateSpace:
        """A, B, C, D of the state [dq; dqd]; raises `InputError` if M is not positive definite."""
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

    def displacements(self, s: ComplexArray, forces: AnyArray, transposed: bool = False) -> ComplexArray:
        """Return Z^-1 F (frequencies, n, m), or Z^-T F, at complex rates s, as `moved_by` does."""
        M, D, K = ((x.T if transposed else x) for x in (self.M, self.D, self.K))
        return moved_by(lambda s: s[:, None, None] ** 2 * M + s[:, None, None] * D + K, s, forces)

    @property
    def headline(self) -> str:
        """Machine, coordinates, inputs and outputs."""
        signals = f"{len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return f"Linearization of {self.motion.machine.name}: {len(self.kept)} coordinates, {signals}"


def moved_by(stiffness: Callable[[ComplexArray], ComplexArray], s: ComplexArray, forces: AnyArray) -> ComplexArray:
    """Return Z(s)^-1 F (frequencies, n, m) of a dynamic stiffness (frequencies, n, n) at complex rates s, F (n, m).

    F may differ by frequency, (frequencies, n, m). On an undamped resonance, where Z is singular, it is that of a
    frequency next to it: finite, and of the right sign. NaN where Z is singular there, too, as of a motion that nothing
    holds back at 0 Hz.
    """
    forces = np.broadcast_to(forces, (len(s), *forces.shape[-2:])).astype(complex)
    for there in (s, s * (1 + DISPLACED)) if len(s) == 1 else (s,):
        try:
            return np.asarray(np.linalg.solve(stiffness(there), forces), dtype=complex)
        except np.linalg.LinAlgError:
            pass
    if len(s) == 1:
        return np.full_like(forces, np.nan)
    half = len(s) // 2
    parts = [moved_by(stiffness, s[part], forces[part]) for part in (slice(half), slice(half, None))]
    return np.concatenate(parts)


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
    none, numbered = 0 * by_qd, [*enumerate(wanted_out, start=len(wanted_in))]
    of_positions = by_qd, none, none  # roots are velocities: their rows by qd are those of positions by q
    rows = [[x[k] for x in ((by_q, by_qd, by_qdd) if s.order else of_positions)] for k, s in numbered]
    Cq, Cv, Ca = (np.array([row[k] for row in rows]).reshape(len(rows), n) for k in range(3))
    motors = motion.motor_slopes(state.q)
    return Linearization(
        motion, state, (M + M.T) / 2, D, K, F, Cq, Cv, Ca, tuple(s.name for s in wanted_in),
        tuple(s.name for s in wanted_out), tuple(range(n)), motors, np.zeros((len(motors), 2)),
    )  # fmt: skip


def root_of(motion: EquationsOfMotion, signal: Signal, at_rest: bool = False) -> Scalar:
    """Return the expression of the velocity of a signal; of its acceleration for a signal of accelerations.

    That of a velocity by qd is the Jacobian J, and J^T a unit wrench on the coordinates, or S_m^T a unit torque (L3).
    `at_rest` it is the velocity for all signals, as the acceleration there is J qdd.
    """
    if isinstance(signal, FrameSignal):
        row, blocks = motion.row_of(signal.number, signal.at) + signal.component, motion.frame_motions
    else:
        row, blocks = motion.machine.with_variable.index(signal.number), motion.joint_coordinate_rates
    root: Scalar = blocks[signal.order == 2 and not at_rest][row]
    return root


def with_motors(
    linear: Linearization, held: Collection[str] = (), gains: Mapping[str, tuple[float, float]] | None = None
) -> Linearization:
    """Return the linearization with some motors held, others under a controller tau = -kp dq - kd dqd.

    `gains` gives (kp, kd) in N m/rad, N m s/rad or N/m, N s/m. The torque and the encoder of a motor that is held
    are not signals any more. Raises `InputError` for joints without motor.
    """
    motion, retained = linear.motion, list(linear.kept)
    fixed = _fixed_entries(linear, held)
    K, D, springs = linear.K.copy(), linear.D.copy(), linear.gains.copy()
    for name, (kp, kd) in (gains or {}).items():
        m = motion.motor(name, "--pd")
        if not np.isfinite([kp, kd]).all():
            raise InputError(motion.source, "--pd", f"{name}={kp:g}:{kd:g} {NOT_FINITE}")
        row = linear.motors[m]
        if not row[[k not in fixed for k in retained]].any():
            raise InputError(motion.source, "--pd", f"{name} is held: remove --hold or --pd")
        K += kp * np.outer(row, row)
        D += kd * np.outer(row, row)
        springs[m] += kp, kd
    rows = [row for row, k in enumerate(retained) if k not in fixed]
    motors = linear.motors[:, rows]
    still = joint_signals(name for name, row in zip(motion.motor_names, motors, strict=True) if not row.any())
    ins, outs = ([c for c, name in enumerate(names) if name not in still] for names in (linear.inputs, linear.outputs))
    square, of_outs = np.ix_(rows, rows), np.ix_(outs, rows)
    return replace(
        linear, M=linear.M[square], D=D[square], K=K[square], F=linear.F[np.ix_(rows, ins)], Cq=linear.Cq[of_outs],
        Cv=linear.Cv[of_outs], Ca=linear.Ca[of_outs], kept=tuple(retained[k] for k in rows), motors=motors,
        gains=springs, inputs=tuple(linear.inputs[c] for c in ins), outputs=tuple(linear.outputs[c] for c in outs),
    )  # fmt: skip


def _fixed_entries(linear: Linearization, names: Collection[str]) -> set[int]:
    """Return the indices in q that locked motors fix; raises `InputError` if a motor still moves."""
    motion = linear.motion
    locked = [motion.motor(name, "--hold") for name in names]
    slopes = linear.motors[locked]
    fixed = {k for column, k in enumerate(linear.kept) if slopes[:, column].any()}
    if locked and len(fixed) > np.linalg.matrix_rank(slopes):
        moving = ", ".join(motion.names[k] for k in sorted(fixed))
        what = f"{', '.join(names)} alone would leave {moving} free to move together: hold them all"
        raise InputError(motion.source, "--hold", what)
    return fixed


@dataclass(frozen=True)
class LinearSlopes:
    """Derivatives of the matrices of a linearization by parameters `names`, which are their first axis.

    M, D, K (p, n, n), F (p, n, inputs), C (3, p, outputs, n) of Cq, Cv, Ca, motors (p, m, n); SI units by the unit of
    the parameter.
    """

    linear: Linearization
    names: tuple[str, ...]
    M: Array
    D: Array
    K: Array
    F: Array
    C: Array
    motors: Array


def linear_slopes(linear: Linearization, names: Sequence[str] = ()) -> LinearSlopes:
    """Return the derivatives of M, D, K, F, Cq, Cv, Ca by parameters, all of them unless some are named.

    Controllers of motors are in D and K; a damping ratio that was added to every mode is not. Raises `InputError` for
    unknown names, and for a state that moves: how a parameter changes its accelerations is not followed.
    """
    motion, k, n = linear.motion, len(linear.kept), len(linear.motion.joints)
    if linear.unrest:
        what = f"derivatives by parameters are those of equilibria, and this state is {linear.unrest[0]}"
        raise InputError(motion.source, "sensitivity", what)
    chosen = chosen_parameters(motion, names)
    roots = _velocities(linear)
    rows, retained = len(roots), np.eye(n)[:, list(linear.kept)]
    # Columns: M, D and K, the changes of r along qdd, qd and q; then those of velocities along qd, their Jacobian.
    adjoint = np.zeros((n + rows, 3 * k * k + rows * k))
    adjoint[:n, : 3 * k * k] = np.tile(np.repeat(retained, k, axis=1), 3)
    adjoint[n:, 3 * k * k :] = np.repeat(np.eye(rows), k, axis=1)
    along, none = np.tile(retained, k), np.zeros((n, k * k))
    nothing, jacobian = np.zeros((n, rows * k)), np.tile(retained, rows)
    dq = np.hstack([along, none, none, nothing])
    dqd = np.hstack([none, along, none, jacobian])
    dqdd = np.hstack([none, none, along, nothing])
    by_name = motion.parameter_slopes(linear.state, adjoint, dq, dqd, dqdd, [*motion.residual, *roots])
    derivatives = np.array([by_name[name] for name in chosen]).reshape(len(chosen), adjoint.shape[1])
    K, D, M = derivatives[:, : 3 * k * k].reshape(len(chosen), 3, k, k).transpose(1, 0, 2, 3)
    F, C, motors = _row_slopes(linear, derivatives[:, 3 * k * k :].reshape(len(chosen), rows, k))
    for row, slopes, (kp, kd) in zip(linear.motors, motors.transpose(1, 0, 2), linear.gains, strict=True):
        if kp or kd:
            both = slopes[:, :, None] * row
            both += both.transpose(0, 2, 1)
            K, D = K + kp * both, D + kd * both
    return LinearSlopes(linear, chosen, (M + M.transpose(0, 2, 1)) / 2, D, K, F, C, motors)


def chosen_parameters(motion: EquationsOfMotion, names: Sequence[str]) -> tuple[str, ...]:
    """Return parameters by name, all unless some are named; raises `InputError` for unknown names."""
    for name in names:
        if name not in motion.parameters:
            raise InputError(motion.source, "sensitivity", no_such("parameter", name, motion.parameters))
    return tuple(names or motion.parameters)


def _velocities(linear: Linearization) -> list[Scalar]:
    """Return the expressions of velocities of inputs and outputs, and of motors."""
    motion = linear.motion
    signals = (*inputs(motion.given, linear.inputs), *outputs(motion.given, linear.outputs))
    of_signals = [root_of(motion, s, at_rest=True) for s in signals]
    return of_signals + [motion.bound.rate(motion.machine.motors[m]) for m in range(len(linear.motors))]


def _row_slopes(linear: Linearization, slopes: Array) -> tuple[Array, Array, Array]:
    """Return the derivatives of F, of C, and of the rows of motors (p, m, n), from those of velocities (p, rows, n)."""
    p, _, k = slopes.shape
    ins, outs = len(linear.inputs), outputs(linear.motion.given, linear.outputs)
    C = np.zeros((3, p, len(outs), k))
    for o, s in enumerate(outs):
        C[s.order, :, o] = slopes[:, ins + o]
    return slopes[:, :ins].transpose(0, 2, 1), C, slopes[:, ins + len(outs) :]


def response_slopes(slopes: LinearSlopes, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return G (f, outputs, inputs) and its derivatives (p, f, outputs, inputs) at frequencies in Hz, SI units.

    Frequencies f - i a/(2 pi) are s = 2 pi i f + a. On an undamped resonance both are those of a frequency next to it.
    """
    s = np.asarray(2j * np.pi * np.asarray(frequencies), dtype=complex)
    parts = [_response_slopes(slopes, s[first : first + BLOCK]) for first in range(0, len(s), BLOCK)]
    return np.concatenate([G for G, _ in parts]), np.concatenate([dG for _, dG in parts], axis=1)


def _response_slopes(slopes: LinearSlopes, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    linear, s_ = slopes.linear, s[:, None, None]
    C = linear.Cq + s_ * linear.Cv + s_ * s_ * linear.Ca
    moved = linear.displacements(s, linear.F)
    G: ComplexArray = C @ moved
    if not slopes.names:
        return G, np.zeros((0, *G.shape), dtype=complex)
    adjoint = linear.displacements(s, C.transpose(0, 2, 1), transposed=True).transpose(0, 2, 1)
    dG = np.zeros((len(slopes.names), *G.shape), dtype=complex)
    for power, changed in enumerate((slopes.K, slopes.D, slopes.M)):
        for k, rows in ((k, np.flatnonzero(matrix.any(axis=1))) for k, matrix in enumerate(changed)):
            columns = np.flatnonzero(changed[k].any(axis=0))
            if len(rows):
                inner = changed[k][np.ix_(rows, columns)] @ moved[:, columns]
                dG[k] -= s_**power * (adjoint[:, :, rows] @ inner)
    for k in np.flatnonzero(slopes.F.any(axis=(1, 2))).tolist():
        dG[k] += adjoint @ slopes.F[k]
    for power, changed in enumerate(slopes.C):
        for k in np.flatnonzero(changed.any(axis=(1, 2))).tolist():
            dG[k] += s_**power * (changed[k] @ moved)
    return G, dG


def pole_slopes(slopes: LinearSlopes, poles: ComplexArray) -> ComplexArray:
    """Return the derivatives (p, k) of simple poles (k,), rad/s; NaN for repeated poles.

    phi and psi are singular vectors of Z, scaled so that M has a diagonal of ones.
    """
    linear, lam = slopes.linear, np.asarray(poles, dtype=complex)[:, None, None]
    scale = 1 / np.sqrt(np.diag(linear.M))
    Z = (lam * lam * linear.M + lam * linear.D + linear.K) * np.outer(scale, scale)
    U, sizes, Vh = np.linalg.svd(Z)
    phi, psi = scale * Vh[:, -1].conj(), scale * U[:, :, -1].conj()
    changed = [np.einsum("ka,pab,kb->pk", psi, matrix, phi, optimize=True) for matrix in (slopes.K, slopes.D, slopes.M)]
    below = np.einsum("ka,kab,kb->k", psi, 2 * lam * linear.M + linear.D, phi)
    if sizes.shape[1] > 1:
        below = np.where(sizes[:, -2] > REPEATED * sizes[:, 0], below, np.nan)
    lam = lam[:, 0, 0]
    return np.asarray(-(changed[0] + lam * changed[1] + lam * lam * changed[2]) / below)


def ratio_slopes(poles: ComplexArray, slopes: ComplexArray) -> tuple[Array, Array]:
    """Return the derivatives of frequencies |lambda| / 2 pi, Hz, and of damping ratios -Re lambda / |lambda|."""
    size = np.abs(poles)
    grown = (poles.conj() * slopes).real / size
    return grown / (2 * np.pi), -(slopes.real - poles.real * grown / size) / size
