"""Machines with couplings and closed loops in many digits: variables, placements, assembly, forces on variables.

Every joint's value is q_j = F_j(x) of the own variables x = (u, d): u independent, d given by the loops. Cells are
formulas of the file, evaluated in power series; frames are products of 4x4 matrices. A loop is closed where its two
frames, or only their origins, coincide. Two references build on this, each with its own mechanics:
`constraint_multipliers` and `virtual_work`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import mp, mpf

from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Closing, Joint, Kind, Loop, Machine
from tests.references.digits import with_digits
from tests.references.elimination import identity, independent_rows, least_squares, solve, zeros
from tests.references.numbers_of_machine import (
    Arithmetic,
    JointNumbers,
    Known,
    MachineNumbers,
    Values,
    names_of,
    numbers_of,
)
from tests.references.series import FUNCTIONS, Series, coefficient, cos, sin

DIGITS = 70
CLOSED = mpf(10) ** -60
"""Largest gap of a loop that counts as closed."""

Array = np.ndarray[Any, Any]
Variables = Mapping[str, Any]
Number = Callable[[Any], Any]
in_many_digits = with_digits(DIGITS)


def exact(value: Any) -> Any:
    """An int, float or Fraction as mpf; decimal text too; a series as it is."""
    if isinstance(value, Series):
        return value
    return mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mpf(value)


def nearest_double(value: Any) -> Any:
    """As `exact`, decimals of the file rounded to double precision."""
    return exact(float(value)) if isinstance(value, Fraction) else exact(value)


@dataclass(frozen=True)
class State:
    """Independent variables and their rates in table order, and a guess of the dependent and cut ones."""

    u: Sequence[Any]
    ud: Sequence[Any]
    guess: Mapping[str, Any]


class Chain:
    """The variables of a machine by name, and its table at given values of them; `number` reads its decimals."""

    @in_many_digits
    def __init__(self, machine: Machine, values: Values | None = None, number: Number = exact) -> None:
        self.machine = replace(machine, joints=tuple(map(_with_reflected_inertia, machine.joints)))
        self.arithmetic = Arithmetic(number, +mp.pi, FUNCTIONS)
        self.values = names_of(self.machine, self.arithmetic, values or {})
        self.own = self._names(machine.with_variable)
        self.independent = self._names(machine.independent)
        self.dependent = self._names(machine.dependent)
        self.motors = self._names(machine.motors)
        self.cuts = [_variable(joint) for joint in machine.joints if joint.kind is Kind.CUT and joint.sigma != 2]
        self.articulated = [j - 1 for j in machine.articulated]
        self.known = self._known()
        self.before = {j: _before_joint(row) for j, row in self.known.rows.items()}

    def _names(self, joints: Sequence[int]) -> list[str]:
        return [_variable(self.machine.joint(j)) for j in joints]

    def numbers(self, variables: Variables) -> MachineNumbers:
        """The table, cells and stiffnesses evaluated at these values; own variables are not added yet."""
        return numbers_of(self.machine, self.arithmetic, {**self.values, **variables}, self.known)

    def _known(self) -> Known:
        """Rows (from 0) of which no cell is a formula of variables, and the cells of others that are none."""
        variables = dict.fromkeys([*self.own, *self.cuts], mpf(0))
        rows = numbers_of(self.machine, self.arithmetic, {**self.values, **variables}).joints
        joints = list(enumerate(self.machine.joints))
        constant = {j: rows[j] for j, joint in joints if not any(x.names & variables.keys() for _, x in cells(joint))}
        owners = (self.machine.base, *(joint for j, joint in joints if j not in constant))
        formulas = [x for owner in owners for _, x in cells(owner) if not x.names & variables.keys()]
        names = {"pi": self.arithmetic.pi, **self.values}
        number = self.arithmetic.number
        return Known(constant, {id(x): x.evaluate(names, self.arithmetic.functions, number) for x in formulas})

    def joint_values(self, numbers: MachineNumbers, variables: Variables) -> list[Any]:
        """q_j = F_j(x) of each row, from the cell that sigma selects; 0 at fixed frames."""
        return [self._joint_value(*pair, variables) for pair in zip(self.machine.joints, numbers.joints, strict=True)]

    def _joint_value(self, joint: Joint, row: JointNumbers, variables: Variables) -> Any:
        if joint.sigma == 2:
            return mpf(0)
        cell = row.r if joint.sigma == 1 else row.theta
        return cell + variables[joint.variable] if joint.variable else cell

    def placements(self, variables: Variables, base: Array | None = None) -> list[Array]:
        """0Tj of every row; cut rows are moved by their variables."""
        numbers = self.numbers(variables)
        frames: list[Array] = []
        for j, (row, q) in enumerate(zip(numbers.joints, self.joint_values(numbers, variables), strict=True)):
            theta, r = (q if row.sigma == 0 else row.theta), (q if row.sigma == 1 else row.r)
            before = self.before[j] if j in self.before else _before_joint(row)
            antecedent = frames[row.antecedent - 1] if row.antecedent else base
            frames.append(_screwed_about_z(before if antecedent is None else antecedent @ before, theta, r))
        return frames

    def gaps(self, variables: Variables) -> list[Any]:
        """Entries of 0T_e - 0T_m of all loops, rotations left out where only points meet; zero where closed."""
        frames = self.placements(variables)
        return [gap for loop in self.machine.loops for gap in _gaps(loop, frames)]

    def gradient(self, function: Callable[[Variables], Sequence[Any]], at: Variables, names: Sequence[str]) -> Array:
        """Derivatives of functions by variables: entry [function][variable]."""
        columns = [[coefficient(f, 1) for f in function(along(at, {name: mpf(1)}))] for name in names]
        return np.array(columns, dtype=object).T if columns else zeros(len(function(at)), 0)

    @in_many_digits
    def assemble(self, state: State) -> dict[str, Any]:
        """All variables where the loops close, by Newton from the guess; `ArithmeticError` where it finds nothing."""
        found = {name: exact(value) for name, value in zip(self.independent, state.u, strict=True)}
        sought = [*self.dependent, *self.cuts]
        found |= {name: exact(state.guess.get(name, 0)) for name in sought}
        for _ in range(30):
            gaps = np.array(self.gaps(found), dtype=object)
            if max(map(abs, gaps), default=mpf(0)) < CLOSED:
                return found
            steps = least_squares(self.gradient(self.gaps, found, sought), gaps)
            found |= {name: found[name] - step for name, step in zip(sought, steps, strict=True)}
        raise ArithmeticError(f"{self.machine.name}: no position near the guess")

    # Forces on own variables

    def spring_energy(self, variables: Variables) -> Any:
        """Sum of k(x) (x - x0)^2 / 2 over elastic joints, and over motors with springs beside them."""
        energy = mpf(0)
        if not self.machine.sprung:
            return energy
        numbers = self.numbers(variables)
        for j in self.machine.sprung:
            row = numbers.joints[j - 1]
            stretch = variables[_variable(self.machine.joint(j))] - row.neutral
            energy = row.stiffness * stretch * stretch / 2 + energy
        return energy

    def spring_forces(self, at: Variables, rates: Sequence[Any]) -> Array:
        """What springs and their dampers exert on the own variables: minus the gradient of the energy, minus d xd."""
        slopes = self.gradient(lambda variables: [self.spring_energy(variables)], at, self.own)[0]
        rows = self.numbers(at).joints
        damping = [rows[j - 1].damping for j in self.machine.with_variable]
        return np.array([-k - d * xd for k, d, xd in zip(slopes, damping, rates, strict=True)], dtype=object)

    def friction(self, at: Variables, rates: Sequence[Any]) -> Array:
        """Coulomb and viscous friction of the joints that own a variable, against its rate."""
        rows = self.numbers(at).joints
        pairs = zip((rows[j - 1] for j in self.machine.with_variable), rates, strict=True)
        return np.array([-row.friction(xd) for row, xd in pairs], dtype=object)

    def spread_motors(self, tau: Sequence[Any]) -> Array:
        """Torques of the motors among the forces on own variables."""
        forces = zeros(len(self.own))
        for name, torque in zip(self.motors, tau, strict=True):
            forces[self.own.index(name)] = exact(torque)
        return forces

    def shared(self, rows: Array, torques: Array) -> Array:
        """Torques of all motors with the same effect through `rows` (of S) as `torques` of independent ones (L31).

        They are w B y: of all such torques those with the least sum of tau^2 / w, w the shares (1 where none is given).
        """
        kept = independent_rows(rows)
        basis = rows[kept]
        mixing = solve(basis @ basis.T, basis @ rows.T).T
        weights = np.diag([self._share(self.machine.joint(j)) for j in self.machine.motors])
        return weights @ mixing @ solve(mixing.T @ weights @ mixing, torques)

    def _share(self, joint: Joint) -> Any:
        names = {"pi": self.arithmetic.pi, **self.values}
        share = joint.sharing.evaluate(names, FUNCTIONS, exact)
        return share if share else mpf(1)


def along(at: Variables, *coefficients: Variables) -> dict[str, Any]:
    """Variables as power series: the value, then the coefficients given by name; as they are where none is given."""
    moving = {name for given in coefficients for name in given}
    return {
        name: Series([value, *(c.get(name, mpf(0)) for c in coefficients)]) if name in moving else value
        for name, value in at.items()
    }


def _with_reflected_inertia(joint: Joint) -> Joint:
    """Inertia of the rotor as the joint feels it: N^2 times its own where a ratio N is given."""
    if joint.ratio.is_zero:
        return joint
    product = Formula("", ("*", ("power", joint.ratio.tree, 2), joint.rotor_inertia.tree))
    return replace(joint, rotor_inertia=product, ratio=ZERO)


def _variable(joint: Joint) -> str:
    assert joint.variable is not None, joint.name
    return joint.variable


def _gaps(loop: Loop, frames: Sequence[Array]) -> list[Any]:
    columns = slice(3, 4) if loop.closes is Closing.POINT else slice(0, 4)
    return list((frames[loop.cut - 1][:3, columns] - frames[loop.meets - 1][:3, columns]).ravel())


def _before_joint(row: JointNumbers) -> Array:
    """Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d)."""
    return _screwed_about_x(_screwed_about_z(identity(4), row.gamma, row.b), row.alpha, row.d)


def _screwed_about_z(frame: Array, angle: Any, shift: Any) -> Array:
    """T Rot(z, angle) Trans(z, shift), by the columns of T."""
    (x, y, z, p), c, s = frame.T, cos(angle), sin(angle)
    return np.array([x * c + y * s, y * c - x * s, z, p + z * shift], dtype=object).T


def _screwed_about_x(frame: Array, angle: Any, shift: Any) -> Array:
    """T Rot(x, angle) Trans(x, shift), by the columns of T."""
    (x, y, z, p), c, s = frame.T, cos(angle), sin(angle)
    return np.array([x, y * c + z * s, z * c - y * s, p + x * shift], dtype=object).T
