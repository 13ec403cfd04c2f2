"""The dynamic model as linear equations in its parameters: tau = Y X, one row for each joint that moves.

Rows of motors hold measured torques; rows of elastic and passive joints have a zero there, for what springs
and dampers exert are columns of Y: 0 = (inertial) + K q + DA qd - KQ [9], [15], KQ = K q0 for the neutral
position q0. Labels are those of the `regressor` model: XX3 .. M3, IA3, FV3, FS3, K3, DA3, KQ3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from typing import Any, Protocol

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.equations.regressor import INERTIA, INERTIAL, MOMENTS
from symoro_elastic.machine.checks import refuse_floating
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.labels import ParameterLabels, named_entries
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine, Parameter, Spring, Wrench
from symoro_elastic.machine.names import did_you_mean
from symoro_elastic.models.catalogue import MODELS, trace
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.program import Program

PARAMETER_UNITS = {**dict.fromkeys(INERTIA, "kg m2"), **dict.fromkeys(MOMENTS, "kg m"), "M": "kg"}


@dataclass(frozen=True)
class RegressorColumn:
    """A parameter of tau = Y X: its label such as ZZ3, K2, what it is and the row of the table that has it, the joint
    (0-based in q), its unit, and the value that the machine gives it (NaN where it gives none)."""

    label: str
    quantity: str
    row: int
    joint: int
    unit: str
    value: float = math.nan


class Regressor(Protocol):
    """Y of tau = Y X."""

    @property
    def columns(self) -> Sequence[RegressorColumn]:
        """The parameters X."""

    def evaluate(self, q: Array, qd: Array, qdd: Array, chosen: Sequence[int]) -> Array:
        """Return columns of Y, (samples, n, chosen), from (samples, n)."""

    def loads(self, q: Array) -> Array:
        """Return the part without X, (samples, n): forces that balance the external wrenches."""


class ByLinearity:
    """Y of a machine, column by column: the inverse dynamic model of rigid joints at unit parameters.

    Y_c = tau(q, qd, qdd; X = e_c) - tau(q, qd, qdd; X = 0), exact, for tau is linear in X. `values` are those
    of the named parameters.
    """

    def __init__(self, machine: Machine, values: Mapping[str, float]) -> None:
        self.machine, self._values = machine, values
        self._joints = machine.moving_joints
        self._units, self._labels = _units(machine), ParameterLabels(machine)
        self._rigid = trace(_rigid(machine), "inverse_dynamics").program

    @cached_property
    def columns(self) -> tuple[RegressorColumn, ...]:
        """Inertial parameters of every body that has any, then IA, friction, springs of every joint."""
        return (*self._inertial(), *(c for k in range(len(self._joints)) for c in self._of_joint(k)))

    def evaluate(self, q: Array, qd: Array, qdd: Array, chosen: Sequence[int]) -> Array:
        """Return columns of Y, (samples, n, chosen)."""
        Y = np.zeros((*q.shape, len(chosen)))
        Y[:, :, :] = self._inertial_part(q, qd, qdd, chosen)
        for k, column in enumerate(self.columns[c] for c in chosen):
            if column.quantity in OF_JOINT:
                Y[:, column.joint, k] = OF_JOINT[column.quantity](*(x[:, column.joint] for x in (q, qd, qdd)))
        return Y

    def _inertial_part(self, q: Array, qd: Array, qdd: Array, chosen: Sequence[int]) -> Array:
        Y = np.zeros((*q.shape, len(chosen)))
        zero = self._torques(q, qd, qdd)
        for k, column in enumerate(self.columns[c] for c in chosen):
            if column.quantity in INERTIAL:
                Y[:, :, k] = self._torques(q, qd, qdd, self._units[column.row, column.quantity]) - zero
        return Y

    def loads(self, q: Array) -> Array:
        """Return forces that balance the external wrenches, (samples, n)."""
        return self._torques(q, np.zeros_like(q), np.zeros_like(q))

    def _torques(self, q: Array, qd: Array, qdd: Array, one: str = "") -> Array:
        return self._run(self._rigid, (q, qd, qdd), {name: float(name == one) for name in self._units.values()})

    def _run(self, program: Program, state: Sequence[Array], parameters: Mapping[str, float]) -> Array:
        """Return the entries of the first result of a program at stacked states, (samples, entries)."""
        symbols: dict[str, Any] = {**self._values, **parameters}
        for argument, array in zip(program.inputs, state, strict=True):
            symbols |= zip(argument.symbols, array.T, strict=True)
        entries = program.outputs[0].entries
        value = evaluate(entries, symbols, arithmetic(float))
        return np.stack([np.broadcast_to(np.asarray(value(x), dtype=float), len(state[0])) for x in entries], axis=1)

    def _inertial(self) -> list[RegressorColumn]:
        moving = {j: k for k, j in enumerate(self.machine.moving)}
        columns = []
        for j, joint in enumerate(self.machine.joints, start=1):
            values = nominal_body(joint.body, self._values) if has_body(joint.body) else {}
            owner = moving[_carrier(self.machine, j)] if _carrier(self.machine, j) else 0
            columns += [self._column(name, j, owner, PARAMETER_UNITS[name], value) for name, value in values.items()]
        return columns

    def _of_joint(self, k: int) -> list[RegressorColumn]:
        joint, j = self._joints[k], self.machine.moving[k]
        force, x = joint.force_unit, joint.unit
        rotor = self._column("IA", j, k, "kg" if joint.sigma == 1 else "kg m2", self._cell(joint.reflected_inertia))
        viscous = self._column("FV", j, k, f"{force} s/{x}", self._cell(joint.friction.viscous))
        coulomb = self._column("FS", j, k, force, self._cell(joint.friction.coulomb))
        if joint.kind is not Kind.ELASTIC:
            return [rotor, viscous, coulomb] if joint.kind is Kind.MOTOR else [viscous, coulomb]
        return [
            *([] if joint.rotor_inertia.is_zero else [rotor]),
            *([] if joint.friction.coulomb.is_zero else [coulomb]),
            *self._of_spring(joint, j, k, force, x),
        ]

    def _of_spring(self, joint: Joint, j: int, k: int, force: str, x: str) -> list[RegressorColumn]:
        """Return k, d and k q0; viscous friction of the joint is part of d."""
        stiffness, neutral = self._cell(joint.spring.stiffness), self._cell(joint.spring.neutral)
        damping = self._cell(joint.spring.damping) + self._cell(joint.friction.viscous)
        return [
            self._column("K", j, k, f"{force}/{x}", stiffness),
            self._column("DA", j, k, f"{force} s/{x}", damping),
            self._column("KQ", j, k, force, stiffness * neutral),
        ]

    def _column(self, quantity: str, row: int, joint: int, unit: str, value: float) -> RegressorColumn:
        return RegressorColumn(self._labels(row, quantity), quantity, row, joint, unit, value)

    def _cell(self, formula: Formula) -> float:
        return _value(formula, self._values)


class ByEquations(ByLinearity):
    """Y of a machine from the `regressor` model, all columns at once."""

    def __init__(self, machine: Machine, values: Mapping[str, float]) -> None:
        super().__init__(machine, values)
        self._traced = trace(without_wrenches(_rigid(machine)), "regressor")
        labels = self._traced.results["Y"].column_labels
        self._place = {label: c for c, label in enumerate(labels)}

    def _inertial_part(self, q: Array, qd: Array, qdd: Array, chosen: Sequence[int]) -> Array:
        flat = self._run(self._traced.program, (q, qd, qdd), {})
        Y = np.concatenate([flat.reshape(*q.shape, len(self._place)), np.zeros((*q.shape, 1))], axis=2)
        units = [self._units.get((self.columns[c].row, self.columns[c].quantity), "") for c in chosen]
        return Y[:, :, [self._place.get(unit, -1) for unit in units]]


OF_JOINT: dict[str, Callable[[Array, Array, Array], Array]] = {
    "IA": lambda q, qd, qdd: qdd,
    "FV": lambda q, qd, qdd: qd,
    "FS": lambda q, qd, qdd: np.sign(qd),
    "K": lambda q, qd, qdd: q,
    "DA": lambda q, qd, qdd: qd,
    "KQ": lambda q, qd, qdd: -np.ones_like(q),
}


def regressor(machine: Machine, values: Mapping[str, float] | None = None) -> ByLinearity:
    """Return Y of a machine; `values` replace those of its parameters.

    Raises `InputError` naming a parameter of the geometry, gravity or motion of the base that has no value.
    """
    refuse_floating(machine, "identification")
    given = {p.name: p.value.value() for p in machine.parameters if p.value is not None} | dict(values or {})
    for j, joint in enumerate(machine.joints, start=1):
        loads = (*joint.wrench.force, *joint.wrench.moment)
        _refuse_unknown(machine, f"joint {j} ({joint.name})", (*_geometry(joint), *loads), given)
    base = machine.base
    motion = (base.gravity, base.velocity, base.angular_velocity, base.acceleration, base.angular_acceleration)
    _refuse_unknown(machine, "gravity and base", [formula for vector in motion for formula in vector], given)
    return (ByEquations if "regressor" in MODELS and _has_inertia(machine) else ByLinearity)(machine, given)


def _has_inertia(machine: Machine) -> bool:
    return any(has_body(joint.body) for joint in machine.joints)


def _geometry(joint: Joint) -> tuple[Formula, ...]:
    return joint.gamma, joint.b, joint.alpha, joint.d, joint.theta, joint.r


def _refuse_unknown(machine: Machine, place: str, formulas: Sequence[Formula], given: Mapping[str, float]) -> None:
    missing = sorted({name for formula in formulas for name in formula.names} - given.keys())
    if missing:
        what = f"{', '.join(missing)} without value: identification finds inertias, friction and springs, not geometry"
        raise machine.error(place, f"{what}; give it a value")


def has_body(body: Body) -> bool:
    """Return whether the table gives the body any inertia; a body without has no columns."""
    return not all(formula.is_zero for formula in (body.mass, *body.moments, *body.inertia))


def nominal_body(body: Body, values: Mapping[str, float]) -> dict[str, float]:
    """Return XX .. M about the origin of the frame, NaN where unknown: J = J_c + M (c.c 1 - c c^T), MS = M c."""
    mass = _value(body.mass, values)
    moments = np.array([_value(formula, values) for formula in body.moments])
    tensor = np.array([_value(formula, values) for formula in body.inertia])
    if body.central:
        rows, columns = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)
        shift = mass * (moments @ moments * np.eye(3) - np.outer(moments, moments))
        tensor, moments = tensor + shift[rows, columns], mass * moments
    return dict(zip(INERTIAL, (*tensor.tolist(), *moments.tolist(), mass), strict=True))


def zero_entries(machine: Machine) -> set[tuple[int, str]]:
    """Return row and quantity of inertial parameters of bodies with inertia that the table gives as zero."""
    found = set()
    for j, joint in enumerate(machine.joints, start=1):
        entries = (*joint.body.inertia, *joint.body.moments, joint.body.mass)
        if has_body(joint.body) and not joint.body.central:
            found |= {(j, name) for name, formula in zip(INERTIAL, entries, strict=True) if formula.is_zero}
    return found


def _value(formula: Formula, values: Mapping[str, float]) -> float:
    if not formula.names <= values.keys():
        return math.nan
    try:
        return formula.value(values)
    except FormulaError:
        return math.nan


def _carrier(machine: Machine, j: int) -> int:
    """Return the nearest joint that moves, from body j towards the base; 0 if there is none."""
    while j and machine.joint(j).sigma == 2:
        j = machine.joint(j).antecedent
    return j


def _units(machine: Machine) -> dict[tuple[int, str], str]:
    """Return by row and quantity a name, free in the machine, for each inertial parameter of bodies with inertia."""
    taken, bodies = ParameterLabels(machine).taken, [j for j, x in enumerate(machine.joints, 1) if has_body(x.body)]
    prefix = next(prefix for k in count(1) if not any(name.startswith(prefix := "X" * k + "_") for name in taken))
    return {(j, name): f"{prefix}{name}{j}" for j in bodies for name in INERTIAL}


def _rigid(machine: Machine) -> Machine:
    """Return the machine with every joint a motor without friction, every body's parameters named."""
    units = _units(machine)
    joints = tuple(_unit_joint(j, joint, units) for j, joint in enumerate(machine.joints, start=1))
    return replace(machine, joints=joints, parameters=(*machine.parameters, *map(Parameter, units.values())))


def without_wrenches(machine: Machine) -> Machine:
    """Return the machine without external wrenches."""
    return replace(machine, joints=tuple(replace(joint, wrench=Wrench()) for joint in machine.joints))


def _unit_joint(j: int, joint: Joint, units: Mapping[tuple[int, str], str]) -> Joint:
    zero = Formula.parse(0)
    bare = replace(joint, spring=Spring(), friction=Friction(), rotor_inertia=zero, ratio=zero)
    if joint.sigma != 2:
        bare = replace(bare, kind=Kind.MOTOR)
    if not has_body(joint.body):
        return bare
    named = {name: Formula.parse(units[j, name]) for name in INERTIAL}
    mx, my, mz = (named[name] for name in MOMENTS)
    xx, xy, xz, yy, yz, zz = (named[name] for name in INERTIA)
    return replace(bare, body=Body(named["M"], (mx, my, mz), (xx, xy, xz, yy, yz, zz)))


def refuse_unknown_labels(machine: Machine, known: Iterable[str], columns: Sequence[RegressorColumn]) -> None:
    """Raise `InputError` for a label that is none of a column, with those that may be meant."""
    labels = [column.label for column in columns]
    for label in known:
        if label not in labels:
            what = _meant(machine, label, columns) or f"no such parameter{did_you_mean(label, labels)}"
            raise machine.error(f"known {label}", what)


def _meant(machine: Machine, name: str, columns: Sequence[RegressorColumn]) -> str:
    """Return which labels to choose from where a name of the machine is no label."""
    choices = []
    for column in columns:
        joint = machine.joint(column.row)
        if name in (f"{column.quantity}{column.row}", named_entries(joint).get(column.quantity)):
            choices.append(f"{column.label} for {column.quantity} of joint {column.row} ({joint.name})")
    return f"the machine has another quantity of this name: write {' or '.join(choices)}" if choices else ""
