"""A and H of a small machine from Lagrange's equations, in SymPy.

    d/dt (dT/dqd) - dT/dq + dV/dq = A(q) qdd + H(q, qd)   (frictions and wrenches are left out)

With P_j the 4x4 pseudo-inertia of body j (integral of [r;1][r;1]^T dm) and T_j its frame's 0Tj(q, t):
T = 1/2 sum_j tr(T_j' P_j T_j'^T) + 1/2 Ia qd^2 and V = - sum_j [g 0] T_j P_j [0 0 0 1]^T. No screw, no cross
product, no frame of a body. A moving base is an explicit function of time, T_0 = 1 + T_0' t + T_0'' t^2/2, at t = 0.
Numbers are exact until the resulting functions are called, in 50 digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import mpmath
import sympy as sp

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.tree.once import once_for_each_machine
from tests.references.numbers_of_machine import (
    Arithmetic,
    Array,
    BaseNumbers,
    BodyNumbers,
    JointNumbers,
    Values,
    numbers_of,
    spread,
)

DIGITS = 50

Functions = tuple[Callable[[Sequence[Any]], Any], Callable[[Sequence[Any], Sequence[Any]], Any]]


def _number(value: Any) -> Any:
    exact = Fraction(value)
    return sp.Rational(exact.numerator, exact.denominator)


EXACT = Arithmetic(_number, sp.pi, {"sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "sqrt": sp.sqrt, "atan2": sp.atan2})


def lagrange(machine: Machine, values: Values | None = None) -> Functions:
    """(A, H): A(q) gives n rows of n mpf, H(q, qd) n mpf; for machines of at most 3 or 4 joints."""
    numbers = numbers_of(machine, EXACT, values)
    n = len(numbers.moving)
    time = sp.Symbol("time")
    q, qd = sp.symbols(f"q1:{n + 1}"), sp.symbols(f"qd1:{n + 1}")
    kinetic, potential = sp.Integer(0), sp.Integer(0)
    gravity = sp.Matrix([*numbers.base.gravity, 0])
    frames: list[Any] = []
    for joint, variable in zip(numbers.joints, spread(numbers, q, sp.Integer(0)), strict=True):
        before = frames[joint.antecedent - 1] if joint.antecedent else _base(numbers.base, time)
        frame = before * _transform(joint, variable)
        frames.append(frame)
        masses = _pseudo_inertia(joint.body)
        rate = frame.diff(time) + sum((frame.diff(x) * xd for x, xd in zip(q, qd, strict=True)), sp.zeros(4, 4))
        kinetic += (rate * masses * rate.T).trace() / 2
        potential -= (gravity.T * frame * masses)[3]
    for j, xd in zip(numbers.moving, qd, strict=True):
        kinetic += numbers.joints[j].rotor_inertia * xd**2 / 2

    momenta = [sp.diff(kinetic, xd) for xd in qd]
    inertia = sp.Matrix([[sp.diff(momentum, xd) for xd in qd] for momentum in momenta])
    bias = sp.Matrix(
        [
            sp.diff(momentum, time)
            + sum(sp.diff(momentum, y) * yd for y, yd in zip(q, qd, strict=True))
            - sp.diff(kinetic, x)
            + sp.diff(potential, x)
            for momentum, x in zip(momenta, q, strict=True)
        ]
    )
    inertia_of = _in_many_digits(sp.lambdify([time, q], inertia, modules="mpmath", cse=True))
    bias_of = _in_many_digits(sp.lambdify([time, q, qd], bias, modules="mpmath", cse=True))
    return inertia_of, lambda *state: [row[0] for row in bias_of(*state)]


def inertia_and_bias(machine: Machine, q: Sequence[float], qd: Sequence[float]) -> tuple[Any, Any]:
    """(A, H) at a state."""
    inertia, bias = _lagrange_once(machine)
    return inertia(q), bias(q, qd)


@once_for_each_machine
def _lagrange_once(machine: Machine) -> Functions:
    return lagrange(machine)


def _in_many_digits(function: Callable[..., Any]) -> Callable[..., list[list[Any]]]:
    """The function at time 0, on floats taken exactly, its matrix as rows of mpf."""

    def rows(*arguments: Sequence[Any]) -> list[list[Any]]:
        with mpmath.workdps(DIGITS):
            return list(function(0, *([mpmath.mpf(x) for x in argument] for argument in arguments)).tolist())

    return rows


def _transform(joint: JointNumbers, variable: Any) -> Any:
    """[1]: two screws about z and one about x."""
    theta = joint.theta + (variable if joint.sigma == 0 else 0)
    r = joint.r + (variable if joint.sigma == 1 else 0)
    return _about_z(joint.gamma, joint.b) * _about_x(joint.alpha, joint.d) * _about_z(theta, r)


def _about_z(angle: Any, shift: Any) -> Any:
    c, s = _cos_sin(angle)
    return sp.Matrix([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, shift], [0, 0, 0, 1]])


def _about_x(angle: Any, shift: Any) -> Any:
    c, s = _cos_sin(angle)
    return sp.Matrix([[1, 0, 0, shift], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])


def _cos_sin(angle: Any) -> tuple[Any, Any]:
    """Of constant angles in more digits than are asked for: expressions of numbers are multiplied out."""
    found = sp.cos(angle), sp.sin(angle)
    return tuple(x.evalf(DIGITS + 15) for x in found) if angle.is_number else found


def _pseudo_inertia(body: BodyNumbers) -> Any:
    """Second moments of the mass: integral of r r^T dm = tr(J)/2 I - J."""
    second = sp.eye(3) * sum(body.inertia[i, i] for i in range(3)) / 2 - sp.Matrix(body.inertia.tolist())
    first = sp.Matrix(body.first_moment.tolist())
    return sp.Matrix(sp.BlockMatrix([[second, first], [first.T, sp.Matrix([[body.mass]])]]))


def _base(base: BaseNumbers, time: Any) -> Any:
    spin = _cross_matrix(base.angular_velocity)
    turn = _cross_matrix(base.angular_acceleration) + spin * spin
    first = spin.row_join(sp.Matrix(base.velocity)).col_join(sp.zeros(1, 4))
    second = turn.row_join(sp.Matrix(base.acceleration)).col_join(sp.zeros(1, 4))
    return sp.eye(4) + first * time + second * time**2 / 2


def _cross_matrix(a: Array) -> Any:
    return sp.Matrix([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
