"""The table of a machine as numbers, in any arithmetic: floats, 50 digits, or exact SymPy expressions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine

Array = np.ndarray[Any, Any]
Values = Mapping[str, Any]
Scalar = Callable[[Formula], Any]
Vector = Callable[[tuple[Formula, ...]], Array]


@dataclass(frozen=True)
class Arithmetic:
    """How numbers are made (from int, float or Fraction) and which pi and functions go with them."""

    number: Callable[[Any], Any]
    pi: Any
    functions: Mapping[str, Callable[..., Any]]


FLOATS = Arithmetic(
    float, math.pi, {"sin": math.sin, "cos": math.cos, "tan": math.tan, "sqrt": math.sqrt, "atan2": math.atan2}
)


@dataclass(frozen=True)
class BodyNumbers:
    """Inertial parameters about the origin of the frame of the body, whichever way the file gives them."""

    mass: Any
    first_moment: Array
    inertia: Array


@dataclass(frozen=True)
class JointNumbers:
    """One row of the table; `force` and `moment` are exerted by the body on its surroundings, in its frame."""

    antecedent: int
    kind: Kind
    sigma: int
    gamma: Any
    b: Any
    alpha: Any
    d: Any
    theta: Any
    r: Any
    stiffness: Any
    damping: Any
    neutral: Any
    viscous: Any
    coulomb: Any
    creep: Any
    rotor_inertia: Any
    body: BodyNumbers
    force: Array
    moment: Array

    def friction(self, rate: Any) -> Any:
        """Friction against a rate: viscous, and dry that jumps or, with a creep velocity, does not."""
        sense = rate / (rate * rate + self.creep * self.creep) ** 0.5 if self.creep else int(rate > 0) - int(rate < 0)
        return self.viscous * rate + self.coulomb * sense


@dataclass(frozen=True)
class BaseNumbers:
    """Gravity and motion of frame 0, in frame 0."""

    gravity: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array


@dataclass(frozen=True)
class MachineNumbers:
    """Rows in table order, the base, and its body where it floats."""

    joints: list[JointNumbers]
    base: BaseNumbers
    floating: BodyNumbers | None = None

    @property
    def moving(self) -> list[int]:
        """Rows (from 0) that have a variable: the entries of q."""
        return [j for j, joint in enumerate(self.joints) if joint.sigma != 2]

    def among_moving(self, *kinds: Kind) -> list[int]:
        """Indices into q of the joints of these kinds."""
        return [k for k, j in enumerate(self.moving) if self.joints[j].kind in kinds]

    @property
    def motors(self) -> list[int]:
        """Indices into q of the motors."""
        return self.among_moving(Kind.MOTOR)


@dataclass(frozen=True)
class Known:
    """What need not be found again: rows (from 0), and numbers by the `id` of formulas that outlive them."""

    rows: Mapping[int, JointNumbers]
    cells: Mapping[int, Any]


def spread(machine: MachineNumbers, q: Any, zero: Any) -> list[Any]:
    """One entry a row of the table, from one entry a moving joint."""
    entries = iter(q)
    return [next(entries) if joint.sigma != 2 else zero for joint in machine.joints]


def numbers_of(
    machine: Machine, arithmetic: Arithmetic = FLOATS, values: Values | None = None, known: Known = Known({}, {})
) -> MachineNumbers:
    """The machine in numbers; `values` go before those that the machine gives. `ValueError` names what has none."""
    names = names_of(machine, arithmetic, values or {})

    def number(formula: Formula) -> Any:
        found = known.cells.get(id(formula))
        return _evaluate(formula, names, arithmetic) if found is None else found

    def vector(formulas: tuple[Formula, ...]) -> Array:
        return np.array([number(formula) for formula in formulas])

    base = BaseNumbers(*(vector(getattr(machine.base, entry.name)) for entry in fields(Base)))
    floating = _body(machine.floating.body, number, vector) if machine.floating else None
    rows = [known.rows.get(j) or _joint(joint, number, vector) for j, joint in enumerate(machine.joints)]
    return MachineNumbers(rows, base, floating)


def _joint(joint: Joint, number: Scalar, vector: Vector) -> JointNumbers:
    spring, friction = joint.spring, joint.friction
    geometry = (joint.gamma, joint.b, joint.alpha, joint.d, joint.theta, joint.r)
    law = (spring.stiffness, spring.damping, spring.neutral, friction.viscous, friction.coulomb, friction.creep)
    return JointNumbers(
        joint.antecedent,
        joint.kind,
        joint.sigma,
        *[*map(number, (*geometry, *law, joint.rotor_inertia)), _body(joint.body, number, vector)],
        *map(vector, (joint.wrench.force, joint.wrench.moment)),
    )


def _body(body: Body, number: Scalar, vector: Vector) -> BodyNumbers:
    """Moves central inertias to the origin: J = Ic + m (c.c I - c c^T) (Huygens)."""
    xx, xy, xz, yy, yz, zz = vector(body.inertia)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    mass, moments = number(body.mass), vector(body.moments)
    if not body.central:
        return BodyNumbers(mass, moments, inertia)
    identity = np.array([[int(i == j) for j in range(3)] for i in range(3)])
    shift = identity * (moments @ moments) - np.outer(moments, moments)
    return BodyNumbers(mass, moments * mass, inertia + shift * mass)


def names_of(machine: Machine, arithmetic: Arithmetic, values: Values) -> dict[str, Any]:
    """Values of the parameters; those that the machine gives may refer to other parameters."""
    names = {name: arithmetic.number(value) for name, value in values.items()}
    given = {p.name: p.value for p in machine.parameters if p.value is not None and p.name not in names}
    while ready := [name for name, formula in given.items() if formula.names <= names.keys()]:
        for name in ready:
            names[name] = _evaluate(given.pop(name), names, arithmetic)
    return names


def _evaluate(formula: Formula, names: Mapping[str, Any], arithmetic: Arithmetic) -> Any:
    missing = formula.names - names.keys()
    if missing:
        raise ValueError(f"no value for {', '.join(sorted(missing))} in {formula.text!r}")
    return formula.evaluate({"pi": arithmetic.pi, **names}, arithmetic.functions, arithmetic.number)
