"""Every model to 50 digits, by another method than the recursions of the paper.

The frames' positions are products of 4x4 matrices; products of their truncated Taylor series in time
(value, first and second derivative) give velocities and accelerations in frame 0 by direct differentiation.
Geometric Jacobians in frame 0 project inertias and inertial forces on the joints:

    A = sum_j M Jp^T Jp - C - C^T + Jw^T J Jw, C = Jp^T hat(MS) Jw, about the origin of frame j; plus Ia
    H = sum_j Jp^T force + Jw^T moment (inertia at qdd = 0, weight, wrench on the surroundings); plus friction

q, qd, qdd hold the joints with a variable, in table order; tau and qdd_motor the motors. Arguments are ints,
floats (taken exactly), Fractions or mpf; decimals of the file are exact rationals, pi is pi. Results are (nested)
lists of mpf. The base moves as the file says: at the instant considered, world = frame 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
from mpmath import mp, mpf

from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.tree.once import once_for_each_machine
from tests.references.digits import with_digits
from tests.references.elimination import identity, solve, zeros
from tests.references.numbers_of_machine import (
    Arithmetic,
    Array,
    BaseNumbers,
    JointNumbers,
    MachineNumbers,
    Values,
    numbers_of,
    spread,
)

DIGITS = 50

Numbers = Sequence[Any]
in_many_digits = with_digits(DIGITS)


def _number(value: Any) -> Any:
    return mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mpf(value)


def _read(machine: Machine, values: Values | None) -> MachineNumbers:
    return _numbers(machine, values) if values else _own_numbers(machine)


@once_for_each_machine
def _own_numbers(machine: Machine) -> MachineNumbers:
    return _numbers(machine, None)


def _numbers(machine: Machine, values: Values | None) -> MachineNumbers:
    functions = {name: getattr(mpmath, name) for name in ("sin", "cos", "tan", "sqrt", "atan2")}
    return numbers_of(machine, Arithmetic(_number, +mp.pi, functions), values)


# Models


@in_many_digits
def geometric_model(machine: Machine, q: Numbers, values: Values | None = None) -> list[list[list[Any]]]:
    """0Tj [1] of every frame in table order, fixed ones too: 4x4."""
    numbers = _read(machine, values)
    return [_list(frame.transform) for frame in _frames(numbers, q, derivatives=0)]


@in_many_digits
def velocities(machine: Machine, q: Numbers, qd: Numbers, values: Values | None = None) -> list[list[Any]]:
    """V_j = [v ; w] of every frame, linear first, in frame j."""
    frames = _frames(_read(machine, values), q, qd, derivatives=1)
    return [[*(f.rotation.T @ f.v), *(f.rotation.T @ f.w)] for f in frames]


@in_many_digits
def accelerations(
    machine: Machine, q: Numbers, qd: Numbers, qdd: Numbers, values: Values | None = None
) -> list[list[Any]]:
    """dV/dt of every frame without gravity: acceleration of the origin, angular acceleration, in frame j."""
    return [[*(f.rotation.T @ f.a), *(f.rotation.T @ f.wd)] for f in _frames(_read(machine, values), q, qd, qdd)]


@in_many_digits
def inertia_matrix(machine: Machine, q: Numbers, values: Values | None = None) -> list[list[Any]]:
    """A(q) of [8], rotor inertias on the diagonal: n x n."""
    numbers = _read(machine, values)
    return _list(_inertia_matrix(numbers, _frames(numbers, q, derivatives=0)))


@in_many_digits
def generalized_forces(
    machine: Machine, q: Numbers, qd: Numbers, qdd: Numbers, values: Values | None = None
) -> list[Any]:
    """Gamma = A qdd + H without A: inertial wrenches of the motion, projected on the joints. n entries."""
    return _list(_generalized_forces(_read(machine, values), q, qd, qdd))


@in_many_digits
def bias_forces(machine: Machine, q: Numbers, qd: Numbers, values: Values | None = None) -> list[Any]:
    """H(q, qd) of [8]: centrifugal, Coriolis, gravity, base motion, friction, external wrenches; no springs."""
    return _list(_generalized_forces(_read(machine, values), q, qd))


@in_many_digits
def direct_dynamics(machine: Machine, q: Numbers, qd: Numbers, tau: Numbers, values: Values | None = None) -> list[Any]:
    """qdd, n entries, from A qdd = Gamma - H with the motors' tau, the springs' forces, and 0 at passive joints."""
    numbers = _read(machine, values)
    inertia = _inertia_matrix(numbers, _frames(numbers, q, derivatives=0))
    forces = _joint_forces(numbers, q, qd)
    for k, motor_torque in zip(numbers.motors, tau, strict=True):
        forces[k] += _number(motor_torque)
    return _list(solve(inertia, forces - _generalized_forces(numbers, q, qd)))


@in_many_digits
def inverse_dynamics(
    machine: Machine, q: Numbers, qd: Numbers, qdd_motor: Numbers, values: Values | None = None
) -> tuple[list[Any], list[Any]]:
    """(tau of the motors, qdd of all joints) by the partition [11]: Aee qdd_e = Gamma_e - He - Aer qdd_r.

    The torque of a motor is what its axis needs less what a spring beside it gives.
    """
    numbers = _read(machine, values)
    inertia, bias = _inertia_matrix(numbers, _frames(numbers, q, derivatives=0)), _generalized_forces(numbers, q, qd)
    rigid, soft = numbers.motors, numbers.among_moving(Kind.ELASTIC, Kind.PASSIVE)
    qdd = zeros(len(numbers.moving))
    for k, acceleration in zip(rigid, qdd_motor, strict=True):
        qdd[k] = _number(acceleration)
    springs = _joint_forces(numbers, q, qd)
    qdd[soft] = solve(inertia[np.ix_(soft, soft)], (springs - bias - inertia @ qdd)[soft])
    return _list((inertia @ qdd + bias - springs)[rigid]), _list(qdd)


@in_many_digits
def reaction_wrenches(
    machine: Machine, q: Numbers, qd: Numbers, qdd: Numbers, values: Values | None = None
) -> list[list[Any]]:
    """f_j = [force ; moment] on body j through joint j [35], in frame j about its origin: all it carries."""
    numbers = _read(machine, values)
    frames = _frames(numbers, q, qd, qdd)
    needed = [_needed_wrench(joint, f, numbers.base) for joint, f in zip(numbers.joints, frames, strict=True)]
    reactions = []
    for j, frame in enumerate(frames):
        force, moment = zeros(3), zeros(3)
        for i in range(j, len(frames)):
            if j in _path(numbers, i):
                f, m = needed[i]
                force, moment = force + f, moment + m + _cross(frames[i].p - frame.p, f)
        reactions.append([*(frame.rotation.T @ force), *(frame.rotation.T @ moment)])
    return reactions


# Motion of the frames, in frame 0


class _Series(tuple[Array, ...]):
    """A 4x4 matrix and its first derivatives in time, two at most."""

    def __matmul__(self, other: _Series) -> _Series:
        leibniz = (
            lambda: _product(self[0], other[0]),
            lambda: _product(self[1], other[0]) + _product(self[0], other[1]),
            lambda: _product(self[2], other[0]) + 2 * _product(self[1], other[1]) + _product(self[0], other[2]),
        )
        return _Series(leibniz[k]() for k in range(len(self)))


def _product(one: Array, other: Array) -> Array:
    """The product of 4x4 matrices of which the first has a last row of zeros but for its last entry."""
    return np.concatenate([one[:3] @ other, one[3, 3] * other[3:]])


@dataclass(frozen=True)
class _Frame:
    """Position, velocity and acceleration of a frame, everything in frame 0; what was not asked for is not there."""

    transform: Array
    v: Array | None = None
    w: Array | None = None
    a: Array | None = None
    wd: Array | None = None

    @property
    def rotation(self) -> Array:
        return self.transform[:3, :3]

    @property
    def p(self) -> Array:
        return self.transform[:3, 3]


def _frames(
    numbers: MachineNumbers, q: Numbers, qd: Numbers | None = None, qdd: Numbers | None = None, derivatives: int = 2
) -> list[_Frame]:
    """Positions of every frame and their derivatives in time; rates that are not given are zero."""
    still = [0] * len(numbers.moving)
    rows = [[_number(x) for x in _checked(numbers, entries)] for entries in (q, qd or still, qdd or still)]
    rows = [spread(numbers, entries, mpf(0)) for entries in rows]
    base = _Series(_base_motion(numbers.base)[: derivatives + 1])
    series: list[_Series] = []
    for joint, *motion in zip(numbers.joints, *rows, strict=True):
        before = series[joint.antecedent - 1] if joint.antecedent else base
        series.append(before @ _joint_transform(joint, *motion))
    return [_frame(transform) for transform in series]


def _checked(numbers: MachineNumbers, entries: Numbers) -> Numbers:
    if len(entries) != len(numbers.moving):
        raise ValueError(f"{len(entries)} entries for {len(numbers.moving)} joint variables")
    return entries


def _frame(series: _Series) -> _Frame:
    """R'' R^T = hat(wd) + hat(w)^2, whose second term is symmetric."""
    back = series[0][:3, :3].T
    motion = [x for rate in series[1:] for x in (rate[:3, 3], _axial(rate[:3, :3] @ back))]
    return _Frame(series[0], *motion)


def _joint_transform(joint: JointNumbers, q: Any, qd: Any, qdd: Any) -> _Series:
    """Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r) [1] and its derivatives.

    By columns: x' = y theta', y' = -x theta', p' = z r'.
    """
    x, y, z, p = _before_joint(joint).T
    o = zeros(4)
    theta, r = joint.theta + (q if joint.sigma == 0 else 0), joint.r + (q if joint.sigma == 1 else 0)
    c, s = mpmath.cos(theta), mpmath.sin(theta)
    x, y, p = x * c + y * s, y * c - x * s, p + z * r
    first = {0: (y, -x, o, o), 1: (o, o, o, z)}.get(joint.sigma, (o, o, o, o))
    second = (-x, -y, o, o) if joint.sigma == 0 else (o, o, o, o)
    value, slope, curve = (np.array(columns, dtype=object).T for columns in ((x, y, z, p), first, second))
    return _Series((value, slope * qd, slope * qdd + curve * qd**2))


def _before_joint(joint: JointNumbers) -> Array:
    """Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d), multiplied out."""
    (cg, sg), (ca, sa) = ((mpmath.cos(angle), mpmath.sin(angle)) for angle in (joint.gamma, joint.alpha))
    o = mpf(0)
    rows = [
        [cg, -sg * ca, sg * sa, cg * joint.d],
        [sg, cg * ca, -cg * sa, sg * joint.d],
        [o, sa, ca, joint.b],
        [o, o, o, mpf(1)],
    ]
    return np.array(rows, dtype=object)


def _base_motion(base: BaseNumbers) -> _Series:
    value, first, second = identity(4), zeros(4, 4), zeros(4, 4)
    spin = _hat(base.angular_velocity)
    first[:3, :3], first[:3, 3] = spin, base.velocity
    second[:3, :3], second[:3, 3] = _hat(base.angular_acceleration) + spin @ spin, base.acceleration
    return _Series((value, first, second))


# Forces and inertias, in frame 0


def _path(numbers: MachineNumbers, j: int) -> list[int]:
    """Rows (from 0) from row j to the base."""
    path = [j]
    while antecedent := numbers.joints[path[-1]].antecedent:
        path.append(antecedent - 1)
    return path


def _jacobian(numbers: MachineNumbers, frames: list[_Frame], j: int) -> tuple[Array, Array]:
    """(Jp, Jw), 3 x n each: velocity of the origin of frame j and angular velocity, in frame 0."""
    linear, angular = zeros(3, len(numbers.moving)), zeros(3, len(numbers.moving))
    columns, *parts = _columns(numbers, frames, j)
    linear[:, columns], angular[:, columns] = parts
    return linear, angular


def _columns(numbers: MachineNumbers, frames: list[_Frame], j: int) -> tuple[list[int], Array, Array]:
    """Columns of (Jp, Jw) that are not zero, and which of the n they are: joints on the path from the base."""
    path = set(_path(numbers, j))
    columns = [(column, k) for column, k in enumerate(numbers.moving) if k in path]
    linear, angular = zeros(3, len(columns)), zeros(3, len(columns))
    for column, (_, k) in enumerate(columns):
        axis = frames[k].rotation[:, 2]
        if numbers.joints[k].sigma == 1:
            linear[:, column] = axis
        else:
            linear[:, column], angular[:, column] = _cross(axis, frames[j].p - frames[k].p), axis
    return [column for column, _ in columns], linear, angular


def _inertia_matrix(numbers: MachineNumbers, frames: list[_Frame]) -> Array:
    """2 T = sum_j M v.v + 2 v.(w x MS) + w.J w, with v = Jp qd and w = Jw qd, plus Ia qd^2."""
    matrix = np.diag(np.array([numbers.joints[k].rotor_inertia for k in numbers.moving], dtype=object))
    for j, (joint, frame) in enumerate(zip(numbers.joints, frames, strict=True)):
        columns, linear, angular = _columns(numbers, frames, j)
        coupling = linear.T @ _hat(frame.rotation @ joint.body.first_moment) @ angular
        inertia = frame.rotation @ joint.body.inertia @ frame.rotation.T
        part = (linear.T @ linear) * joint.body.mass - coupling - coupling.T + angular.T @ inertia @ angular
        matrix[np.ix_(columns, columns)] += part
    return matrix


def _needed_wrench(joint: JointNumbers, frame: _Frame, base: BaseNumbers) -> tuple[Array, Array]:
    """Force and moment, in frame 0 about the origin of the body, that its motion, weight and surroundings need."""
    moment_of_mass = frame.rotation @ joint.body.first_moment
    inertia = frame.rotation @ joint.body.inertia @ frame.rotation.T
    fall = frame.a - base.gravity
    force = fall * joint.body.mass + _cross(frame.wd, moment_of_mass)
    force = force + _cross(frame.w, _cross(frame.w, moment_of_mass)) + frame.rotation @ joint.force
    moment = inertia @ frame.wd + _cross(frame.w, inertia @ frame.w) + _cross(moment_of_mass, fall)
    return force, moment + frame.rotation @ joint.moment


def _generalized_forces(numbers: MachineNumbers, q: Numbers, qd: Numbers, qdd: Numbers | None = None) -> Array:
    frames = _frames(numbers, q, qd, qdd)
    rows = [numbers.joints[k] for k in numbers.moving]
    rates, accelerations = [_number(x) for x in qd], [_number(x) for x in qdd or [0] * len(qd)]
    forces = np.array(
        [
            joint.friction(rate) + joint.rotor_inertia * acceleration
            for joint, rate, acceleration in zip(rows, rates, accelerations, strict=True)
        ],
        dtype=object,
    )
    for j, (joint, frame) in enumerate(zip(numbers.joints, frames, strict=True)):
        columns, linear, angular = _columns(numbers, frames, j)
        force, moment = _needed_wrench(joint, frame, numbers.base)
        forces[columns] += linear.T @ force + angular.T @ moment
    return forces


def _joint_forces(numbers: MachineNumbers, q: Numbers, qd: Numbers) -> Array:
    """Gamma of the springs [9], -k (q - q0) - d qd, of elastic joints and beside motors; zero elsewhere."""
    forces = zeros(len(numbers.moving))
    for k in numbers.among_moving(Kind.ELASTIC, Kind.MOTOR):
        joint = numbers.joints[numbers.moving[k]]
        forces[k] = -joint.stiffness * (_number(q[k]) - joint.neutral) - joint.damping * _number(qd[k])
    return forces


# Small arrays of mpf


def _list(array: Array) -> list[Any]:
    return list(array.tolist())


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=object)


def _hat(a: Array) -> Array:
    o = mpf(0)
    return np.array([[o, -a[2], a[1]], [a[2], o, -a[0]], [-a[1], a[0], o]], dtype=object)


def _axial(matrix: Array) -> Array:
    """Vector of the antisymmetric part."""
    pairs = ((2, 1), (0, 2), (1, 0))
    return np.array([(matrix[i, j] - matrix[j, i]) / 2 for i, j in pairs], dtype=object)
