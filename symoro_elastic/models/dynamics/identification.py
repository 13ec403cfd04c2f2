"""Models that are linear in the parameters: regressors and base parameters, tau = Y X.

Y has a column for every parameter of the machine that is not the number zero: inertial parameters,
rotor inertia IA, friction FV and FS, stiffness K, damping DA, KQ = stiffness times neutral position,
and external wrenches FX ... CZ. Those that no torque depends on are left out. A machine that has
been grouped gives the base regressor. tau is zero where a joint is elastic or passive.

Rows belong to the independent variables: with couplings and loops Y is S^T Y of the tree's joints in the motion
S ud, S udd + gam. Springs, dampers and friction act on joint coordinates, friction of coupled joints on these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.labels import ParameterLabels, named_entries
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.mechanics.base_parameters import ROTOR
from symoro_elastic.mechanics.coordinates import projection
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.regressor import (
    INERTIAL,
    WRENCH,
    Column,
    energies,
    inertial_columns,
    parameters_of,
    wrench_columns,
)
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Joints, Model, Result, Results
from symoro_elastic.models.bound.naming import name_dynamics
from symoro_elastic.models.bound.rules import given_rules
from symoro_elastic.models.parameters.base_parameters import grouping_of_tree
from symoro_elastic.symbolic.arithmetic import ModularAngles
from symoro_elastic.symbolic.expression import Expression, Level
from symoro_elastic.symbolic.program import Section

SEED = 20262
VISCOUS, COULOMB, STIFFNESS, DAMPING, NEUTRAL = "FV", "FS", "K", "DA", "KQ"


@dataclass(frozen=True)
class LinearParameter:
    """A parameter on which torques depend linearly: its label, joint, entry (XX ... KQ) and value."""

    label: str
    joint: int
    entry: str
    value: Scalar


def linear_parameters(bound: Bound) -> list[LinearParameter]:
    """The parameters of a machine that are not the number zero, joint by joint.

    A label is the parameter's own name where its cell is unique, else XX3, FV2 ... or XX_3 where
    XX3 is a name of the machine's own.
    """
    entries = [(j, entry, x) for j in range(1, len(bound.machine.joints) + 1) for entry, x in _values(bound, j)]
    entries = [(j, entry, x) for j, entry, x in entries if isinstance(x, Expression) or x != 0]
    symbols = [named_entries(joint) for joint in bound.machine.joints]
    cells = [symbols[j - 1].get(entry) for j, entry, _ in entries]
    labels = ParameterLabels(bound.machine)
    return [
        LinearParameter(name if name and cells.count(name) == 1 else labels(j, entry), j, entry, x)
        for (j, entry, x), name in zip(entries, cells, strict=True)
    ]


def _values(bound: Bound, j: int) -> Iterator[tuple[str, Scalar]]:
    """Every parameter of joint and body j, with its entry."""
    link, joint = bound.mechanism.links[j - 1], bound.machine.joint(j)
    yield from parameters_of(link.body).items()
    if j in bound.machine.articulated:
        yield ROTOR, link.rotor_inertia
        yield VISCOUS, bound.cell(joint.friction.viscous)
        yield COULOMB, bound.cell(joint.friction.coulomb)
    if joint.has_spring:
        stiffness = bound.cell(joint.spring.stiffness)
        yield STIFFNESS, stiffness
        yield DAMPING, bound.cell(joint.spring.damping)
        yield NEUTRAL, stiffness * bound.cell(joint.spring.neutral)
    yield from zip(WRENCH, link.wrench.entries, strict=True)


def _refuse_other_friction(machine: Machine) -> None:
    """Raise `InputError` for friction that is not linear in its parameters, and for modes."""
    machine.refuse_flexible("a regressor")
    for joint in machine.joints:
        law = joint.friction
        cells = (("static", law.static), ("load", law.load), ("bristle", law.bristle), ("ball", law.ball))
        for key, cell in cells:
            if not cell.is_zero:
                what = "torques are not linear in its parameters: leave it out"
                raise machine.error(f"regressor, friction, {joint.name}, {key}", what)


def _entries_by_link(parameters: Sequence[LinearParameter], entries: Sequence[str]) -> dict[int, list[str]]:
    """The parameters among the given entries, by link."""
    entries_of_joints: dict[int, list[str]] = {}
    for parameter in parameters:
        if parameter.entry in entries:
            entries_of_joints.setdefault(parameter.joint, []).append(parameter.entry)
    return entries_of_joints


def _regressor(bound: Bound, joints: Joints) -> Results:
    refuse_varying_stiffness(bound.machine)
    _refuse_other_friction(bound.machine)
    parameters = linear_parameters(bound)
    recursion = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    columns: dict[tuple[int, str], Column] = {}
    for j, entry, column in inertial_columns(bound.mechanism, recursion, _entries_by_link(parameters, INERTIAL)):
        columns[j, entry] = bound.on_independent(column)
    for j, entry, column in wrench_columns(bound.mechanism, _entries_by_link(parameters, WRENCH)):
        columns[j, entry] = bound.on_independent(column)
    for parameter in parameters:
        j, entry = parameter.joint, parameter.entry
        if entry in JOINT_COLUMNS:
            columns[j, entry] = _of_joint(bound, j, entry)
    rows = _without_zeros([[columns[p.joint, p.entry].get(i, 0) for p in parameters] for i in joints])
    nonzero = [k for k in range(len(parameters)) if any(isinstance(row[k], Expression) or row[k] != 0 for row in rows)]
    _check_any(bound, nonzero)
    used = [parameters[k] for k in nonzero]
    rows = [[row[k] for k in nonzero] for row in rows]
    named = (
        (i, p.joint, p.entry, x) for i, row in zip(joints, rows, strict=True) for p, x in zip(used, row, strict=True)
    )
    _name_regressor(bound, recursion, named)
    entries = tuple(x for row in rows for x in row)
    return {"Y": Result(joints, entries, (len(used),), column_labels=tuple(p.label for p in used))}


def _of_joint(bound: Bound, j: int, entry: str) -> Column:
    """Forces on the independent variables for a unit of a joint's own parameter."""
    on_variable = entry != ROTOR and j in bound.machine.with_variable
    rows = bound.coordinates.S_x if on_variable else bound.coordinates.S
    return projection(rows, {j: JOINT_COLUMNS[entry](bound, j)})


def refuse_varying_stiffness(machine: Machine) -> None:
    """Refuse forces that are not linear in parameters: stiffness that depends on positions, backlash, cogging."""
    for j in machine.motors:
        if not machine.joint(j).cogging.amplitude.is_zero:
            what = "torques are not linear in its order and phase, so no regressor has columns for it: leave it out"
            raise machine.error(place_of(j, machine.joint(j), "cogging"), what)
    for j in machine.with_backlash:
        what = "the force of its spring is not linear in parameters, so no regressor has a column for it: leave it out"
        raise machine.error(place_of(j, machine.joint(j), "backlash"), what)
    for j in machine.elastic:
        stiffness = machine.joint(j).spring.stiffness
        names = ", ".join(sorted(stiffness.names & machine.variables.keys()))
        if names:
            what = f"it varies with {names}, so no regressor has a column for it: give a constant"
            raise machine.error(place_of(j, machine.joint(j), "stiffness"), what)


def _name_regressor(bound: Bound, recursion: Dynamics, entries: Iterable[tuple[int, int, str, Scalar]]) -> None:
    """Name velocities and accelerations, and the entries of Y: (row's joint, column's joint, parameter, entry)."""
    name_dynamics(bound, recursion, "[15]", "[61]")
    for row, j, parameter, x in entries:
        bound.names.give(x, f"Y{row}_{parameter}{j}", Section("Regressor", j, "[15]"))


JOINT_COLUMNS: dict[str, Callable[[Bound, int], Scalar]] = {
    ROTOR: lambda bound, j: bound.given_accelerations()[j],
    VISCOUS: lambda bound, j: bound.rate(j),
    COULOMB: lambda bound, j: bound.friction_of(j).sense(),
    STIFFNESS: lambda bound, j: bound.variables[j],
    DAMPING: lambda bound, j: bound.rate(j),
    NEUTRAL: lambda bound, j: -1,
}
"""Force on the joint's variable (for IA on the joint) per unit of a joint's own parameter."""


def _without_zeros(rows: list[list[Scalar]]) -> list[list[Scalar]]:
    """Entries that vanish at every state become the number zero; found modulo a prime."""
    residue = ModularAngles(SEED).values([x for row in rows for x in row])
    return [[x if residue(x) else 0 for x in row] for row in rows]


def _check_any(bound: Bound, columns: Sequence[object]) -> None:
    if not columns:
        source = bound.machine.label
        raise InputError(source, "bodies", "no torque depends on a parameter, so there is no regressor: give masses")


def _energy_regressor(bound: Bound, _: Joints) -> Results:
    refuse_varying_stiffness(bound.machine)
    bound.machine.refuse_flexible("an energy regressor")
    parameters = linear_parameters(bound)
    wanted = _entries_by_link(parameters, INERTIAL)
    energy = {(j, name): x for j, name, x in energies(bound.mechanism, bound.rates(), bound.gravity, wanted)}
    for parameter in parameters:
        j, entry = parameter.joint, parameter.entry
        if entry in JOINT_ENERGIES:
            energy[j, entry] = JOINT_ENERGIES[entry](bound, j)
    columns = [(p.label, energy[p.joint, p.entry]) for p in parameters if (p.joint, p.entry) in energy]
    columns = [(label, x) for label, x in columns if isinstance(x, Expression) and x.level is Level.STATE]
    _check_any(bound, columns)
    entries = tuple(x for _, x in columns)
    return {"h": Result(None, entries, (len(columns),), column_labels=tuple(label for label, _ in columns))}


JOINT_ENERGIES: dict[str, Callable[[Bound, int], Scalar]] = {
    ROTOR: lambda bound, j: bound.rates()[j] * bound.rates()[j] / 2,
    STIFFNESS: lambda bound, j: bound.variables[j] * bound.variables[j] / 2,
    NEUTRAL: lambda bound, j: -bound.variables[j],
}
"""Energy of a unit of a joint's own parameter, up to a constant."""


def _base_parameters(bound: Bound, _: Joints) -> Results:
    grouping = bound.grouping or grouping_of_tree(bound.machine)
    names: dict[str, Scalar] = {"pi": bound.graph.pi}
    names |= {parameter.name: bound.cell(Formula.parse(parameter.name)) for parameter in bound.machine.parameters}
    for name, formula in grouping.composites.items():
        names[name] = bound.cell(formula, names)
    entries = tuple(bound.cell(parameter.formula, names) for parameter in grouping.parameters)
    _check_any(bound, entries)
    labels = tuple(parameter.name for parameter in grouping.parameters)
    return {"X": Result(None, entries, (len(entries),), column_labels=labels)}


IDENTIFICATION = (
    Model(
        "regressor",
        "regressor: torques as a linear function of the parameters",
        "[12], [15]",
        ("q", "qd", "qdd"),
        ("Y",),
        _regressor,
    ),
    Model(
        "energy_regressor",
        "energy as a linear function of the parameters, up to a constant",
        "[3], [13]",
        ("q", "qd"),
        ("h",),
        _energy_regressor,
        Parts.WHOLE,
    ),
    Model(
        "base_parameters",
        "base inertial parameters",
        "[13]",
        (),
        ("X",),
        _base_parameters,
        Parts.WHOLE,
        is_grouped=True,
    ),
)
