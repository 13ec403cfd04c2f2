"""Consistency checks of a machine: errors that name joint and column, and warnings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

from symoro_elastic.machine.columns import LEAST_ROUNDING, Cell, cells, columns
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import TOML
from symoro_elastic.machine.formula import Formula, FormulaError, Tree, names_in
from symoro_elastic.machine.formula_units import Mismatch, mismatches
from symoro_elastic.machine.joints import SELECTED, Friction
from symoro_elastic.machine.loop_checks import cut_faults, loop_faults, loop_warnings, missing_rows, start_faults
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import (
    IMPORTED,
    IN_USE,
    NONE,
    Reasons,
    did_you_mean,
    free_name,
    quote,
    why_no_joint,
    why_no_machine,
    why_reserved,
)
from symoro_elastic.machine.plausibility import warnings
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.quantities.units import Powers, in_base_units

MOST_JOINTS = 1000
"""Rows of a table; the models of larger ones take hours."""


def check(machine: Machine, taken: Reasons = NONE, models: Models | None = None) -> list[str]:
    """Return warnings, one line each, about a machine that can be modelled.

    `taken` are names that generated code uses, with reasons, `models` those that its scene may name; without them this
    is checked where code is generated. Raises `InputError` for a machine that cannot be modelled: its place is
    `joint 3 (bed_x), alpha` or a key.
    """
    described = DescribedMachine.of(machine)
    _check_names(described, taken)
    for j, joint in enumerate(machine.joints, start=1):
        _check_joint(machine, j, joint)
    _check_base(machine)
    _refuse(machine, (), missing_rows(machine))
    _refuse(machine, cut_faults(machine), loop_faults(machine, taken))
    _check_declared(machine)
    _refuse(machine, cell_faults(machine))
    _refuse(machine, (), parameter_faults(machine))
    doubts = [*_doubts(machine)]
    _refuse(machine, (), ((place, doubt.what) for place, doubt in doubts if doubt.is_certain))
    values = parameter_values(machine)
    _check_values(machine, values)
    _check_backlash(machine)
    laws = ((j, fault) for j, joint in enumerate(machine.joints, start=1) for fault in law_faults(joint, values))
    _refuse(machine, laws, start_faults(machine, values))
    if described.asked.scene is not None:
        resolve(described.asked.scene, machine, models)
    of_units = [f"{place}: {doubt.what}" for place, doubt in doubts]
    lines = [*described.origin.remarks, *warnings(machine, values), *of_units]
    return [*lines, *share_warnings(machine), *loop_warnings(described)]


def place_of(j: int, joint: Joint, key: str = "") -> str:
    """The name of a joint, or of one of its cells, in messages."""
    name = joint.name if why_reserved(joint.name) is None else quote(joint.name)
    return f"joint {j} ({name}), {key}" if key else f"joint {j} ({name})"


def formulas(machine: Machine) -> Iterator[tuple[str, Formula]]:
    """Every expression of the machine over its parameters, with its place."""
    return ((place, formula) for place, _, _, formula in _cells(machine))


def _cells(machine: Machine) -> Iterator[tuple[str, Joint | None, Cell, Formula]]:
    """Every cell of the machine, with its place and its joint, if it is that of one."""
    for j, joint in enumerate(machine.joints, start=1):
        place = place_of(j, joint)
        yield from ((f"{place}, {cell.label}", joint, cell, formula) for cell, formula in cells(joint))
    for body in machine.free_bodies:
        yield from ((f"base, {cell.label}", None, cell, formula) for cell, formula in cells(body))
    yield from ((cell.label, None, cell, formula) for cell, formula in cells(machine.base))


def _doubts(machine: Machine) -> Iterator[tuple[str, Doubt]]:
    """What is wrong or doubtful about units of formulas, with its place."""
    units = UnitsOfNames(machine)
    for place, joint, cell, formula in _cells(machine):
        if formula.names:
            unit = joint.unit_of(cell) if joint else cell.column.dimension.units[0]
            position = joint is not None and cell.column.key == SELECTED.get(joint.sigma)
            yield from ((place, doubt) for doubt in units.doubts(formula, unit, gives_position=position))


def require_fixed_base(machine: Machine, place: str) -> None:
    """Raise `InputError` for a machine on a floating base, where only the models are offered."""
    if machine.floating:
        what = "not offered on a floating base: leave out `floating` for a base whose motion is given"
        raise machine.error(place, what)


def parameter_values(machine: Machine) -> dict[str, float]:
    """Values of the parameters that have one; raises `InputError` for a value that is not a number."""
    values = {}
    for parameter in machine.parameters:
        if parameter.value is None:
            continue
        if parameter.value.names:
            what = f"{quote(parameter.value)} holds names: a value is a number, or a formula of numbers"
            raise machine.error(f"parameters, {parameter.name}", what)
        try:
            values[parameter.name] = parameter.value.table_value()
        except FormulaError as error:
            raise machine.error(f"parameters, {parameter.name}", str(error)) from None
    return values


def _check_names(machine: DescribedMachine, taken: Reasons) -> None:
    if not machine.joints:
        raise machine.error("joints", "the machine has no joint: give at least one row of the table")
    if len(machine.joints) > MOST_JOINTS:
        raise machine.error("joints", f"{len(machine.joints)} rows: at most {MOST_JOINTS} can be modelled")
    joints = [(place_of(j, joint, "name"), joint.name) for j, joint in enumerate(machine.joints, start=1)]
    variables = [
        (place_of(j, joint, "joint variable"), joint.variable)
        for j, joint in enumerate(machine.joints, start=1)
        if joint.variable is not None
    ]
    parameters = [("parameters", parameter.name) for parameter in machine.parameters]
    for place, name in [("name", machine.name), *joints, *variables, *parameters]:
        words = {**taken, **dict.fromkeys(IMPORTED, IN_USE)} if place == "name" else taken
        why = why_no_machine if place == "name" else why_no_joint if place.endswith(", name") else why_reserved
        if reason := why(name, words):
            origin = f" ({machine.origin.of_name})" if place == "name" and machine.origin.of_name else ""
            what = f"the name {quote(name)} cannot be used: {reason}; {free_name(name, words)!r} is free{origin}"
            raise machine.error(place, what)
    _check_distinct(machine, joints)
    _check_distinct(machine, [*parameters, *variables])


def _check_distinct(machine: Machine, named: list[tuple[str, str]]) -> None:
    places: dict[str, str] = {}
    for place, name in named:
        if name in places:
            raise machine.error(place, f"the name {name!r} is taken by {places[name]}: choose another")
        places[name] = place


def _check_base(machine: Machine) -> None:
    for column, vector in columns(machine.base):
        moved = column.key != "gravity" and any(not x.is_zero for x in vector)
        if machine.floating and moved:
            raise machine.error(f"base, {column.key}", "it is an argument where the base floats: leave it out")


def _refuse(
    machine: Machine, of_joints: Iterable[tuple[int, tuple[str, str]]], of_loops: Iterable[tuple[str, str]] = ()
) -> None:
    """Raise `InputError` for the first fault of a joint, then of a loop."""
    for j, (key, what) in of_joints:
        raise machine.error(place_of(j, machine.joint(j), key), what)
    for place, what in of_loops:
        raise machine.error(place, what)


def _check_joint(machine: Machine, j: int, joint: Joint) -> None:
    for key, what in _faults(j, joint):
        raise machine.error(place_of(j, joint, key), what)


def _faults(j: int, joint: Joint) -> Iterator[tuple[str, str]]:
    if not 0 <= joint.antecedent < j:
        what = f"{joint.antecedent} must be 0 (the base) or a row above {j}: joints are numbered from the base outwards"
        yield "antecedent", f"{what}; closed loops are written with a row of kind cut, in [loops]"
    if joint.sigma not in (0, 1, 2):
        yield "sigma", f"{joint.sigma} must be 0 (revolute), 1 (prismatic) or 2 (fixed frame)"
    if joint.kind != Kind.CUT and (joint.kind == Kind.FIXED) != (joint.sigma == 2):
        yield "kind", f"{joint.kind.value!r} does not go with sigma = {joint.sigma}: kind fixed means sigma = 2"
    if joint.sigma == 2 and joint.variable is not None:
        yield "joint variable", f"a fixed frame has no variable: remove {joint.variable!r}"
    if joint.kind == Kind.COUPLED and joint.variable is not None:
        yield "joint variable", f"a coupled joint has no variable of its own: remove {joint.variable!r}"
    if joint.sigma != 2 and joint.variable is None and joint.kind != Kind.COUPLED:
        yield "theta" if joint.sigma == 0 else "r", f"the joint variable is missing, sigma = {joint.sigma} puts it here"
    yield from row_faults(joint)
    yield from _spring_faults(joint)
    yield from _friction_faults(joint.friction)
    yield from _cogging_faults(joint)


def _spring_faults(joint: Joint) -> Iterator[tuple[str, str]]:
    if joint.kind == Kind.ELASTIC and joint.spring.stiffness.is_zero:
        yield "stiffness", "an elastic joint needs a stiffness: give one, or make the joint passive"
    for cell, formula in cells(joint.spring):
        if joint.kind not in (Kind.ELASTIC, Kind.CUT) and not formula.is_zero:
            yield cell.label, f"the joint is {joint.kind.value}: only an elastic one has {cell.label}"
    if joint.spring.backlash.is_zero and not joint.spring.rounding.is_zero:
        yield "rounding", "it rounds the edges of a backlash: give backlash, or leave it out"


def _cogging_faults(joint: Joint) -> Iterator[tuple[str, str]]:
    for cell, formula in cells(joint.cogging):
        if joint.kind is not Kind.MOTOR and not formula.is_zero:
            yield cell.label, f"the joint is {joint.kind.value}: only a motor has {cell.label}"
    law = joint.cogging
    if law.amplitude.is_zero and not (law.order.is_zero and law.phase.is_zero):
        yield "cogging", "is missing beside its order: give the amplitude of the torque, or leave the order out"
    if law.order.is_zero and not law.amplitude.is_zero:
        yield "cogging order", "is missing: give the periods of cogging in a turn of the rotor, as 24"


def _friction_faults(law: Friction) -> Iterator[tuple[str, str]]:
    if not law.bristle.is_zero and not law.creep.is_zero:
        yield "bristle, creep", "both make dry friction smooth: keep one"
    if not law.bristle.is_zero and law.bristle_damping.is_zero:
        yield "bristle_damping", "give it beside bristle; sqrt(bristle times the inertia of the joint) is usual"
    if law.static.is_zero != law.stribeck.is_zero:
        yield "static, stribeck", "give both, or none: friction at rest, and the velocity at which half of it is gone"


def _check_declared(machine: Machine) -> None:
    parameters = {parameter.name for parameter in machine.parameters}
    following, with_variables = _following(machine), parameters.union(machine.variables)
    for place, formula in formulas(machine):
        known = with_variables if place in following else parameters
        for name in sorted(formula.names - known):
            undeclared = f"{quote(name)} is not declared{did_you_mean(name, known)}"
            if why_reserved(name) is None:
                undeclared += f" (declare it in [parameters]: {name} = 1.5, or nan for a name without value)"
            what = _of_joint(machine, name) or undeclared
            raise machine.error(place, what)


def _following(machine: Machine) -> set[str]:
    """Places of the cells that may hold the variables of joints."""
    joints = [(place_of(j, machine.joint(j)), machine.joint(j)) for j in machine.articulated]
    return {f"{place}, {key}" for place, joint in joints for key in (SELECTED[joint.sigma], "stiffness")}


def _of_joint(machine: Machine, name: str) -> str:
    """Why a cell cannot hold the variable of a joint; empty for other names."""
    for j, joint in enumerate(machine.joints, start=1):
        if joint.variable == name and joint.kind == Kind.CUT:
            return f"{name!r} is the variable of the cut joint {joint.name}, which follows from its loop: leave it out"
        if joint.variable == name:
            what = f"{name!r} is the variable of {place_of(j, joint)}: only numbers and parameters are allowed here"
            return f"{what}; a joint that follows it is coupled, with the formula in theta (sigma = 0) or r (sigma = 1)"
    return ""


def _check_values(machine: Machine, values: Mapping[str, float]) -> None:
    for place, _, cell, formula in _cells(machine):
        if formula.is_zero:
            continue
        try:
            if not formula.names <= values.keys():
                _check_known_parts(formula.tree, values)
                continue
            value = formula.table_value(values)
        except FormulaError as error:
            raise machine.error(place, str(error)) from None
        if what := cell.column.dimension.fault(value):
            raise machine.error(place, f"{quote(formula)} {what}")


def law_faults(joint: Joint, values: Mapping[str, float]) -> Iterator[tuple[str, str]]:
    """Faults of values that go together, with the key of the joint; those that are not known are passed over."""
    spring, law = joint.spring, joint.friction
    if not spring.rounding.is_zero and (spring.rounding.names | spring.backlash.names) <= values.keys():
        backlash, rounding = spring.backlash.value(values), spring.rounding.value(values)
        if rounding < LEAST_ROUNDING * backlash:
            yield "rounding", f"{rounding:g} is sharper than {LEAST_ROUNDING:g} of the backlash {backlash:g}: give more"
    if not law.bristle.is_zero and law.coulomb.names <= values.keys() and law.coulomb.value(values) == 0:
        yield "bristle", "the joint has no coulomb friction that it could hold: give coulomb"
    if joint.sharing.names <= values.keys() and joint.sharing.value(values) < 0:
        yield "sharing", f"{quote(joint.sharing)} is negative: {joint.sharing.value(values):g}"


def _check_backlash(machine: Machine) -> None:
    for j in machine.with_backlash:
        changed_by = ", ".join(sorted(machine.joint(j).spring.stiffness.names & machine.variables.keys()))
        if changed_by:
            what = (
                f"its stiffness changes with {changed_by}, and a backlash needs a constant one: leave one of them out"
            )
            raise machine.error(place_of(j, machine.joint(j), "backlash"), what)


def _check_known_parts(tree: Tree, values: Mapping[str, float]) -> float | None:
    """The value of a tree whose names all have values; raises `FormulaError` where a part has none."""
    parts = [_check_known_parts(part, values) for part in tree[1:] if isinstance(part, tuple)]
    if tree[0] == "name":
        return values.get(tree[1])
    if tree[0] == "/" and parts[1] == 0:
        raise FormulaError("division by zero")
    return None if None in parts else Formula(tree[0], tree).table_value(values)


Fault = tuple[str, str]
"""Key of a joint, and what is wrong with it."""


def row_faults(joint: Joint) -> Iterator[Fault]:
    """Faults of one row: a coupled joint with a spring or a motor, a share or a ratio without its motor."""
    if joint.kind == Kind.COUPLED:
        for what, key in _on_coupled(joint):
            advice = f"add one to the cell, or move the {what} to a joint that has"
            yield key, f"a coupled joint has no variable of its own: {advice}"
    if not joint.sharing.is_zero and joint.kind not in (Kind.MOTOR, Kind.CUT):
        yield "sharing", f"the joint is {joint.kind.value}: only motors share a torque"
    if not joint.ratio.is_zero and joint.rotor_inertia.is_zero:
        yield "ratio", "a ratio needs a rotor_inertia, that of the rotor about its own axis"


def _on_coupled(joint: Joint) -> Iterator[tuple[str, str]]:
    """What stands on a coupled joint and belongs to a variable, with its key."""
    yield from (("spring", cell.label) for cell, formula in cells(joint.spring) if not formula.is_zero)
    if not joint.sharing.is_zero:
        yield "motor", "sharing"


def cell_faults(machine: Machine) -> Iterator[tuple[int, Fault]]:
    """Faults of cells that hold the variables of other joints, with the number of the joint.

    Joint variables that occur twice, coupled joints that follow nothing, and cycles.
    """
    for j in machine.articulated:
        joint = machine.joint(j)
        key, names = SELECTED[joint.sigma], joint.selected.names
        if joint.variable in names:
            yield j, (key, f"{joint.variable!r} stands in the cell twice: a joint is its variable plus those of others")
        if joint.kind == Kind.COUPLED and names.isdisjoint(machine.variables):
            what = f"{quote(joint.selected)} holds no variable of another joint"
            yield j, (key, f"{what}: a joint that does not move is fixed, with sigma = 2")
    yield from _cycle(machine)


def _cycle(machine: Machine) -> Iterator[tuple[int, Fault]]:
    """The first cycle of cells that need each other's variables."""
    needs = {
        j: [machine.variables[name] for name in sorted(machine.joint(j).selected.names) if name in machine.variables]
        for j in machine.articulated
    }
    try:
        TopologicalSorter(needs).prepare()
    except CycleError as error:
        around: list[int] = error.args[1][:0:-1]
        first = around.index(min(around))
        j, *others = around[first:] + around[:first]
        cell = SELECTED[machine.joint(j).sigma]
        needed = [*(str(machine.joint(other).variable) for other in others), cell]
        if others:
            yield j, (cell, f"{cell} needs {', which needs '.join(needed)}: break the cycle")


def share_warnings(machine: Machine) -> list[str]:
    """Warnings about shares of motors that turn and of motors that slide."""
    sharing = [machine.joint(j) for j in machine.motors if not machine.joint(j).sharing.is_zero]
    turning, sliding = ([joint.name for joint in sharing if joint.sigma == sigma] for sigma in (0, 1))
    if not turning or not sliding:
        return []
    return [f"sharing: {turning[0]} turns and {sliding[0]} slides: N m and N are weighted alike"]


NOT_SI = {"mm", "cm", "dm", "um", "µm", "km", "inch", "ft", "deg", "degree", "degrees", "°", "rpm", "g", "mg", "lb"}
NOT_SI |= {"Nmm", "Ncm", "kN", "MN", "daN", "ms", "min"}


def parameter_faults(machine: Machine) -> Iterator[tuple[str, str]]:
    """Parameters in units other than SI, with their place: values are not converted."""
    for parameter in machine.parameters:
        if any(word in NOT_SI for word in re.findall(r"[^\W\d_]+|°", parameter.unit)):
            what = f"its unit is {quote(parameter.unit)}, but values are not converted: write it in m, kg, s, rad, N"
            if machine.source.endswith(TOML.suffixes):
                what += f', or value = "X {parameter.unit}"'
            yield f"parameter {parameter.name}", what


@dataclass(frozen=True)
class Doubt:
    """What is wrong with the units of a formula, or only may be."""

    what: str
    is_certain: bool


@dataclass(frozen=True)
class UnitsOfNames:
    """Units of the names of a machine: of the parameters that declare one, and of the joint variables."""

    machine: Machine

    @cached_property
    def declared(self) -> dict[str, Powers]:
        """Units of parameters, as exponents of kg, m, s and rad, where they are declared and known."""
        found = {p.name: in_base_units(p.unit) for p in self.machine.parameters}
        return {name: powers for name, powers in found.items() if powers is not None}

    @cached_property
    def of_variables(self) -> dict[str, Powers]:
        """Units of joint variables."""
        units = {name: in_base_units(self.machine.joint(j).unit) for name, j in self.machine.variables.items()}
        return {name: powers for name, powers in units.items() if powers is not None}

    @cached_property
    def known(self) -> dict[str, Powers]:
        """Units of all names that have one."""
        return {**self.declared, **self.of_variables}

    def doubts(self, formula: Formula, unit: str, *, gives_position: bool) -> Iterator[Doubt]:
        """What is doubtful about a formula that needs a unit, and gives the position of a joint or does not.

        Numbers may have units: `8e4/L` is a stiffness in N/m, `1*q1` an arc of radius 1 m. So it is certain only where
        a variable stands alone, or where units are declared. A unit that is only not that of the cell is a warning:
        values are taken in the unit of the cell.
        """
        needed = in_base_units(unit or "1") or {}
        for one in mismatches(formula, self.known, needed):
            if (gives_position or one.is_mixed) and self._is_certain(one):
                yield Doubt(one.message, is_certain=True)
            elif (gives_position and not one.is_of_angles) or one.is_mixed or self._is_declared(one, formula):
                yield Doubt(one.message, is_certain=False)

    def _is_certain(self, one: Mismatch) -> bool:
        names = names_in(one.part)
        stands_alone = one.part[0] == "name" or not names.isdisjoint(self.declared)
        return stands_alone and not one.found.counted and not one.is_of_angles

    def _is_declared(self, one: Mismatch, formula: Formula) -> bool:
        """Whether a declared unit does not fit; beside variables a number may make up for it, but not for rad2."""
        declared = any(name in self.declared for name in formula.names)
        return declared and (one.is_of_angles or formula.names.isdisjoint(self.of_variables))
