"""The dynamic model as linear equations in its parameters: tau = Y X, one row for each joint that moves.

Rows of motors hold measured torques; rows of elastic and passive joints have a zero there, for what springs
and dampers exert are columns of Y: 0 = (inertial) + K q + DA qd - KQ [9], [15], KQ = K q0 for the neutral
position q0. Labels are those of the `regressor` model: XX3 .. M3, IA3, FV3, FS3, K3, DA3, KQ3.

With couplings and loops rows and measurements are those of the independent variables; the others follow. The left side
is then S_m^T tau (L3), to which motors on dependent joints add theirs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import count
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import among, without_value
from symoro_elastic.machine.checks import require_fixed_base
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.joints import INERTIAL
from symoro_elastic.machine.labels import ParameterLabels, named_entries
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine, Parameter, Spring, Wrench
from symoro_elastic.machine.names import did_you_mean
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.dynamics.identification import linear_parameters, refuse_varying_stiffness
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.evaluation.closed_positions import with_dependent
from symoro_elastic.numerics.evaluation.random_motion import closed_states
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.program import Program

PARAMETER_UNITS = {cell.par: cell.column.dimension.units[0] for cell, _ in cells(Body())}

OF_JOINTS = ("IA", "FV", "FS", "K", "DA", "KQ")  # quantities of joints on which torques depend linearly
Units = Mapping[tuple[int, str], str]
"""Names by row and quantity."""
EXTENT = (2.0, 3.0, 10.0)  # of random q, qd, qdd
JUMP = 0.3  # of a dependent variable from one sample to the next, rad or m, that is one to another branch


@dataclass(frozen=True)
class RegressorColumn:
    """A parameter of tau = Y X: label such as ZZ3 or K2, quantity, row of the table, unit, and value in the machine,
    NaN where it gives none; `joint` is the name of the joint that moves it."""

    label: str
    quantity: str
    row: int
    joint: str
    unit: str
    value: float = math.nan


class Regressor:
    """Y of tau = Y X of a machine by the `regressor` model, and Y X of an uncoupled one by inverse dynamics.

    tau is linear in X, so Y X = tau(q, qd, qdd; X) - tau(q, qd, qdd; 0) of rigid joints, and what acts on one alone.
    `values` are those of the named parameters.
    """

    def __init__(self, machine: Machine, values: Mapping[str, float]) -> None:
        self.machine, self._values = machine, values
        self._units, self._labels = units_of(machine), ParameterLabels(machine)
        self._rigid = trace(rigid_machine(machine), "inverse_dynamics").program
        self._bound = Bound(machine)

    def __reduce__(self) -> tuple[Any, ...]:
        """Return machine and values: expressions are traced anew where a pickle is read."""
        return type(self), (self.machine, dict(self._values))

    @cached_property
    def columns(self) -> tuple[RegressorColumn, ...]:
        """Inertial parameters of every body that has any, then IA, friction, springs of every joint."""
        return (*self._inertial(), *(c for j in self.machine.articulated for c in self._of_joint(j)))

    @cached_property
    def _traced(self) -> tuple[Program, dict[tuple[int, str], int]]:
        """The program of the `regressor` model, and its columns by row of the table and quantity."""
        unit = machine_of_units(self.machine)
        traced = trace(unit, "regressor")
        places = {label: c for c, label in enumerate(traced.results["Y"].column_labels)}
        labels = {(p.joint, p.entry): p.label for p in linear_parameters(Bound(unit))}
        return traced.program, {key: places[label] for key, label in labels.items() if label in places}

    def evaluate(self, q: Array, qd: Array, qdd: Array, chosen: Sequence[int]) -> Array:
        """Return columns of Y, (samples, n, chosen), from (samples, n)."""
        Y = np.zeros((*q.shape, len(chosen)))
        if not (rows := len(self.machine.independent)):
            return Y
        program, place = self._traced
        entries = program.outputs[0].entries
        width = len(entries) // rows
        places = [place.get((self.columns[c].row, self.columns[c].quantity), -1) for c in chosen]
        wanted = [(i, k, entries[i * width + c]) for i in range(rows) for k, c in enumerate(places) if c >= 0]
        wanted = [(i, k, x) for i, k, x in wanted if isinstance(x, Expression) or x != 0]
        evaluated = _values_at([x for _, _, x in wanted], self._symbols(program, (q, qd, qdd)), len(q))
        Y[:, [i for i, _, _ in wanted], [k for _, k, _ in wanted]] = evaluated
        return Y

    def torques(self, q: Array, qd: Array, qdd: Array, chosen: Sequence[int], X: Array) -> Array:
        """Return Y X of some columns, (samples, n); by inverse dynamics, without Y, if joints are uncoupled."""
        if self.machine.is_coupled:
            coupled: Array = self.evaluate(q, qd, qdd, chosen) @ X
            return coupled
        values, own = dict.fromkeys(self._units.values(), 0.0), np.zeros_like(q)
        for column, x in zip((self.columns[c] for c in chosen), X.tolist(), strict=True):
            if column.quantity in INERTIAL:
                values[self._units[column.row, column.quantity]] = x
            else:
                joint = self.machine.independent.index(column.row)
                own[:, joint] += x * OF_JOINT[column.quantity](*(y[:, joint] for y in (q, qd, qdd)))
        return own + self._run(self._rigid, (q, qd, qdd), values) - self._torques_without_bodies(q, qd, qdd)

    def loads(self, q: Array) -> Array:
        """Return forces that balance the external wrenches, (samples, n)."""
        return self._torques_without_bodies(q, np.zeros_like(q), np.zeros_like(q))

    def joint_torques(self, q: Array, tau: Array) -> Array:
        """Return what torques of motors (samples, m) do on the joints that move, S_m^T tau (samples, n) (L3)."""
        machine, rows = self.machine, self._bound.coordinates.S_x
        symbols = {**self._values, **self._symbols_of(self._closed_state(q))}
        entries = [rows[m].get(k, 0) for m in machine.motors for k in machine.independent]
        slopes = _values_at(entries, symbols, len(q)).reshape(len(q), len(machine.motors), len(machine.independent))
        forces: Array = np.einsum("smk,sm->sk", slopes, tau)
        return forces

    def states(self, states: int, seed: int = 0) -> tuple[Array, Array, Array]:
        """Return random q, qd, qdd (states, n) at which loops close."""
        rng = np.random.default_rng(seed)
        if self.machine.is_coupled:
            states_of_loops = closed_states(self._bound, states, rng, self._values)
            return states_of_loops["q"], states_of_loops["qd"], states_of_loops["qdd"]
        q, qd, qdd = (extent * rng.uniform(-1, 1, (states, len(self.machine.independent))) for extent in EXTENT)
        return q, qd, qdd

    @property
    def start(self) -> Array:
        """Where motions start, (n): a position at which loops close, zero without."""
        return start_of(self.machine).q

    def rates(self, rows: Sequence[int], q: Array, qd: Array) -> Array:
        """Return rates of joints by row of the table, (samples, rows): of joint coordinates, of coupled joints."""
        symbols = {**self._values, **self._symbols_of(self._closed_state(q).with_blocks(qd=qd))}
        return _values_at([self._bound.rate(j) for j in rows], symbols, len(q))

    def closes(self, q: Array) -> BoolArray:
        """Return whether loops close at positions along a record, without a jump from one to the next."""
        moved = self.rates(self.machine.dependent, q, np.ones_like(q))
        good: BoolArray = np.asarray(np.isfinite(moved).all(axis=1))
        good[1:] &= (np.abs(np.diff(self._closed_state(q).q_dep, axis=0)) < JUMP).all(axis=1)
        return good

    def felt_by(self, row: int) -> list[int]:
        """Return the independent variables (0-based in q) that a joint moves with."""
        coordinates = self._bound.coordinates
        of_row = coordinates.S_x[row] if row in self.machine.with_variable else coordinates.S[row]
        return [k for k, j in enumerate(self.machine.independent) if j in of_row]

    def _torques_without_bodies(self, q: Array, qd: Array, qdd: Array) -> Array:
        return self._run(self._rigid, (q, qd, qdd), dict.fromkeys(self._units.values(), 0.0))

    def _run(self, program: Program, state: Sequence[Array], parameters: Mapping[str, float]) -> Array:
        """Return the entries of the first result of a program at stacked states, (samples, entries)."""
        symbols = {**self._symbols(program, state), **parameters}
        return _values_at(program.outputs[0].entries, symbols, len(state[0]))

    def _symbols(self, program: Program, state: Sequence[Array]) -> dict[str, Any]:
        """Values of the parameters, and of the arguments of a program at stacked states."""
        position = self._closed_state(state[0])
        arguments = [argument for argument in program.inputs if argument.name not in position.blocks]
        symbols: dict[str, Any] = {**self._values, **self._symbols_of(position)}
        for argument, array in zip(arguments, state[1:], strict=True):
            symbols |= zip(argument.symbols, array.T, strict=True)
        return symbols

    def _closed_state(self, q: Array) -> State:
        """All blocks of positions, loops without a closed form followed from their start."""
        return with_dependent(self.machine, State({"q": q}), self._values)

    def _symbols_of(self, state: State) -> dict[str, Any]:
        names = self._bound.arguments()
        return {x: column for key, block in state.blocks.items() for x, column in zip(names[key], block.T, strict=True)}

    def _inertial(self) -> list[RegressorColumn]:
        columns = []
        for j, joint in enumerate(self.machine.joints, start=1):
            values = nominal_body(joint.body, self._values) if joint.body.has_inertia else {}
            columns += [self._column(name, j, PARAMETER_UNITS[name], value) for name, value in values.items()]
        return columns

    def _of_joint(self, j: int) -> list[RegressorColumn]:
        joint, force, x = self.machine.joint(j), self.machine.joint(j).force_unit, self.machine.joint(j).unit
        rotor = self._column("IA", j, "kg" if joint.sigma == 1 else "kg m2", self._cell(joint.reflected_inertia))
        viscous = self._column("FV", j, f"{force} s/{x}", self._cell(joint.friction.viscous))
        coulomb = self._column("FS", j, force, self._cell(joint.friction.coulomb))
        if joint.kind is Kind.MOTOR:
            stiffness, _, neutral = self._of_spring(joint, j, force, x)
            return [rotor, viscous, coulomb, *([stiffness, neutral] if joint.has_spring else [])]
        if joint.kind is Kind.PASSIVE and j in self.machine.independent:
            return [viscous, coulomb]
        law = joint.friction
        cells = ((rotor, joint.rotor_inertia), (viscous, law.viscous), (coulomb, law.coulomb))
        nonzero = [column for column, formula in cells if not formula.is_zero]
        if joint.kind is not Kind.ELASTIC:
            return nonzero
        return [*(column for column in nonzero if column is not viscous), *self._of_spring(joint, j, force, x)]

    def _of_spring(self, joint: Joint, j: int, force: str, x: str) -> list[RegressorColumn]:
        """Return k, d and k q0; viscous friction of the joint is part of d."""
        stiffness, neutral = self._cell(joint.spring.stiffness), self._cell(joint.spring.neutral)
        damping = self._cell(joint.spring.damping) + self._cell(joint.friction.viscous)
        return [
            self._column("K", j, f"{force}/{x}", stiffness),
            self._column("DA", j, f"{force} s/{x}", damping),
            self._column("KQ", j, force, stiffness * neutral),
        ]

    def _column(self, quantity: str, row: int, unit: str, value: float) -> RegressorColumn:
        moved = _carrier(self.machine, row) or self.machine.independent[0]
        return RegressorColumn(self._labels(row, quantity), quantity, row, self.machine.joint(moved).name, unit, value)

    def _cell(self, formula: Formula) -> float:
        return _value(formula, self._values)


def _values_at(entries: Sequence[Any], symbols: Mapping[str, Any], samples: int) -> Array:
    with np.errstate(invalid="ignore"):
        value = evaluate(entries, symbols, arithmetic(float))
        entries_of_samples = [np.broadcast_to(np.asarray(value(x), dtype=float), samples) for x in entries]
    return np.stack(entries_of_samples, axis=1) if entries_of_samples else np.zeros((samples, 0))


OF_JOINT: dict[str, Callable[[Array, Array, Array], Array]] = {
    "IA": lambda q, qd, qdd: qdd,
    "FV": lambda q, qd, qdd: qd,
    "FS": lambda q, qd, qdd: np.sign(qd),
    "K": lambda q, qd, qdd: q,
    "DA": lambda q, qd, qdd: qd,
    "KQ": lambda q, qd, qdd: -np.ones_like(q),
}


def regressor(machine: Machine, values: Mapping[str, float] | None = None) -> Regressor:
    """Return Y of a machine; `values` replace those of its parameters.

    Raises `InputError` naming a parameter of the geometry, gravity or motion of the base that has no value, a spring
    whose stiffness varies with positions.
    """
    require_fixed_base(machine, "identification")
    refuse_varying_stiffness(machine)
    values_of_names = machine.given_values | dict(values or {})
    for j, joint in enumerate(machine.joints, start=1):
        loads = (*joint.wrench.force, *joint.wrench.moment)
        _refuse_unknown(machine, f"joint {j} ({joint.name})", (*geometry_of(joint), *loads), values_of_names)
    base = machine.base
    motion = (base.gravity, base.velocity, base.angular_velocity, base.acceleration, base.angular_acceleration)
    _refuse_unknown(machine, "gravity and base", [formula for vector in motion for formula in vector], values_of_names)
    return Regressor(_with_values(machine, values_of_names), values_of_names)


def _with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """Return the machine with these values of its parameters; geometric ones decide where its loops close."""
    formulas = {name: Formula.parse(x) for name, x in values.items()}
    return replace(
        machine, parameters=tuple(replace(p, value=formulas.get(p.name, p.value)) for p in machine.parameters)
    )


def geometry_of(joint: Joint) -> tuple[Formula, ...]:
    """Return the formulas that place a joint."""
    return joint.gamma, joint.b, joint.alpha, joint.d, joint.theta, joint.r


def _refuse_unknown(machine: Machine, place: str, formulas: Sequence[Formula], values: Mapping[str, float]) -> None:
    missing = sorted(
        {name for formula in formulas for name in formula.names} - values.keys() - machine.variables.keys()
    )
    if missing:
        raise machine.error(place, without_value(missing, "--value"))


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
    zeros = set()
    for j, joint in enumerate(machine.joints, start=1):
        if joint.body.has_inertia and not joint.body.central:
            zeros |= {(j, name) for name, formula in joint.body.parameters.items() if formula.is_zero}
    return zeros


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


def others_than(machine: Machine, sought: Sequence[str], columns: Sequence[RegressorColumn]) -> dict[str, float]:
    """Return the values by label of all columns but the `sought` ones, labels or names of bodies; {} if none is sought.

    Raises `InputError` for one that no torque shows.
    """
    bodies = {c.label: machine.joint(c.row).name for c in columns if c.quantity in INERTIAL}
    among(tuple(sought), tuple(dict.fromkeys((*bodies.values(), *(c.label for c in columns)))), "--seek")
    fixed = [c for c in columns if c.label not in sought and bodies.get(c.label) not in sought]
    return {c.label: c.value for c in fixed} if sought else {}


def refuse_unknown_labels(machine: Machine, labels_given: Iterable[str], columns: Sequence[RegressorColumn]) -> None:
    """Raise `InputError` for a label that is not the label of a column, with similar ones."""
    labels = [column.label for column in columns]
    for label in labels_given:
        if label not in labels:
            what = _meant(machine, label, columns) or f"there is no such parameter{did_you_mean(label, labels)}"
            raise machine.error(f"--known, {label}", what)


def _meant(machine: Machine, name: str, columns: Sequence[RegressorColumn]) -> str:
    """Return which labels to choose from where a name of the machine is not a label."""
    choices = []
    for column in columns:
        joint = machine.joint(column.row)
        if name in (f"{column.quantity}{column.row}", named_entries(joint).get(column.quantity)):
            choices.append(f"{column.label} for {column.quantity} of joint {column.row} ({joint.name})")
    return f"the machine has another quantity of this name: write {' or '.join(choices)}" if choices else ""


# Machines whose parameters have names, so that torques by a unit of a parameter can be computed


def units_of(machine: Machine) -> dict[tuple[int, str], str]:
    """Return by row and quantity a name, free in the machine, for each parameter of bodies with inertia and joints."""
    used_names = ParameterLabels(machine).taken
    bodies = [j for j, x in enumerate(machine.joints, 1) if x.body.has_inertia]
    prefix = next(prefix for k in count(1) if not any(name.startswith(prefix := "X" * k + "_") for name in used_names))
    keys = [(j, name) for j in bodies for name in INERTIAL]
    keys += [(j, name) for j in machine.articulated for name in OF_JOINTS]
    return {(j, name): f"{prefix}{name}{j}" for j, name in keys}


def _with_names(machine: Machine, unit_joint: Callable[[int, Joint, Units], Joint]) -> Machine:
    """Return the machine with its parameters named by `units_of`, as `unit_joint` puts them into a row."""
    units = units_of(machine)
    joints = tuple(unit_joint(j, joint, units) for j, joint in enumerate(machine.joints, start=1))
    return replace(machine, joints=joints, parameters=(*machine.parameters, *map(Parameter, units.values())))


def rigid_machine(machine: Machine) -> Machine:
    """Return the machine with every independent joint a motor without friction, every body's parameters named."""
    kinds = dict.fromkeys(machine.independent, Kind.MOTOR) | dict.fromkeys(machine.dependent, Kind.PASSIVE)

    def rigid(j: int, joint: Joint, units: Units) -> Joint:
        zero = Formula.parse(0)
        bare = replace(joint, spring=Spring(), friction=Friction(), rotor_inertia=zero, ratio=zero, sharing=zero)
        return replace(_with_unit_body(j, bare, units), kind=kinds.get(j, joint.kind))

    return _with_names(machine, rigid)


def machine_of_units(machine: Machine) -> Machine:
    """Return the machine without wrenches, all parameters on which torques depend linearly named."""

    def of_units(j: int, joint: Joint, units: Units) -> Joint:
        bare = replace(_with_unit_body(j, joint, units), wrench=Wrench(), ratio=Formula.parse(0))
        if j not in machine.articulated:
            return bare
        cell = {name: Formula.parse(units[j, name]) for name in OF_JOINTS}
        friction = Friction(cell["FV"], cell["FS"], joint.friction.creep)
        spring = Spring(cell["K"], cell["DA"], cell["KQ"])
        if joint.kind is Kind.MOTOR:
            spring = replace(spring, damping=joint.spring.damping)
        spring = spring if joint.has_spring else joint.spring
        return replace(bare, rotor_inertia=cell["IA"], friction=friction, spring=spring)

    return _with_names(machine, of_units)


def _with_unit_body(j: int, joint: Joint, units: Units) -> Joint:
    if not joint.body.has_inertia:
        return joint
    return replace(joint, body=Body.of({name: Formula.parse(units[j, name]) for name in INERTIAL}))
