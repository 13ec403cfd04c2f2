"""Consistency checks of a machine: errors that name joint and column, and warnings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from symoro_elastic.machine.columns import Cell, Dimension, cells, columns
from symoro_elastic.machine.coupling_checks import cell_faults, row_faults, share_faults, share_warnings
from symoro_elastic.machine.formula import Formula, FormulaError, Tree
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.loop_checks import cut_faults, loop_faults, loop_warnings, missing_rows, start_faults
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import IMPORTED, IN_USE, NONE, Reasons, did_you_mean, free_name, quoted, reserved
from symoro_elastic.machine.plausibility import warnings
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.machine.unit_checks import Doubt, UnitsOfNames, parameter_faults

MOST_JOINTS = 1000
"""Rows of a table; the models of larger ones take hours."""


def check(machine: Machine, taken: Reasons = NONE, models: Models | None = None) -> list[str]:
    """Return warnings, one line each, about a machine that can be modelled.

    `taken` are names that generated code uses, with reasons, `models` those that its scene may name; without them this
    is checked where code is generated. Raises `InputError` for a machine that cannot be modelled: its place is
    `joint 3 (bed_x), alpha` or a key.
    """
    _check_names(machine, taken)
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
    _refuse(machine, share_faults(machine, values), start_faults(machine, values))
    if machine.scene is not None:
        resolve(machine.scene, machine, models)
    of_units = [f"{place}: {doubt.what}" for place, doubt in doubts]
    lines = [*machine.remarks, *warnings(machine, values), *of_units]
    return [*lines, *share_warnings(machine), *loop_warnings(machine)]


def place_of(j: int, joint: Joint, key: str = "") -> str:
    """The name of a joint, or of one of its cells, in messages."""
    name = joint.name if reserved(joint.name) is None else quoted(joint.name)
    return f"joint {j} ({name}), {key}" if key else f"joint {j} ({name})"


def formulas(machine: Machine) -> Iterator[tuple[str, Formula]]:
    """Every expression of the machine over its parameters, with its place."""
    return ((place, formula) for place, _, _, formula in _cells(machine))


def _cells(machine: Machine) -> Iterator[tuple[str, Joint | None, Cell, Formula]]:
    """Every cell of the machine, with its place and its joint, if it is that of one."""
    for j, joint in enumerate(machine.joints, start=1):
        place = place_of(j, joint)
        yield from ((f"{place}, {cell.label}", joint, cell, formula) for cell, formula in cells(joint))
    if machine.floating:
        yield from ((f"base, {cell.label}", None, cell, formula) for cell, formula in cells(machine.floating.body))
    yield from ((cell.label, None, cell, formula) for cell, formula in cells(machine.base))


def _doubts(machine: Machine) -> Iterator[tuple[str, Doubt]]:
    """What is wrong or doubtful about units of formulas, with its place."""
    units = UnitsOfNames(machine)
    for place, joint, cell, formula in _cells(machine):
        if formula.names:
            unit = joint.unit_of(cell) if joint else cell.column.dimension.units[0]
            position = joint is not None and cell.column.key == SELECTED.get(joint.sigma)
            yield from ((place, doubt) for doubt in units.doubts(formula, unit, gives_position=position))


def refuse_floating(machine: Machine, place: str) -> None:
    """Raise `InputError` for a machine on a floating base, where only the models are offered."""
    if machine.floating:
        what = "not offered on a floating base: leave out `floating` for a base whose motion is given"
        raise machine.error(place, what)


def parameter_values(machine: Machine) -> dict[str, float]:
    """Values of the parameters that have one; raises `InputError` for a value that is no number."""
    values = {}
    for parameter in machine.parameters:
        if parameter.value is None:
            continue
        if parameter.value.names:
            what = f"{quoted(parameter.value)} holds names: a value is a number, or a formula of numbers"
            raise machine.error(f"parameters, {parameter.name}", what)
        try:
            values[parameter.name] = parameter.value.table_value()
        except FormulaError as error:
            raise machine.error(f"parameters, {parameter.name}", str(error)) from None
    return values


def _check_names(machine: Machine, taken: Reasons) -> None:
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
        reason = reserved(name, words)
        if reason:
            origin = f" ({machine.name_origin})" if place == "name" and machine.name_origin else ""
            what = f"the name {quoted(name)} cannot be used: {reason}; {free_name(name, words)!r} is free{origin}"
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
        yield "joint variable", f"a fixed frame has none, not {joint.variable!r}"
    if joint.kind == Kind.COUPLED and joint.variable is not None:
        yield "joint variable", f"a coupled joint has none of its own, not {joint.variable!r}"
    if joint.sigma != 2 and joint.variable is None and joint.kind != Kind.COUPLED:
        yield "theta" if joint.sigma == 0 else "r", f"the joint variable is missing, sigma = {joint.sigma} puts it here"
    yield from row_faults(joint)
    yield from _spring_faults(joint)


def _spring_faults(joint: Joint) -> Iterator[tuple[str, str]]:
    if joint.kind == Kind.ELASTIC and joint.spring.stiffness.is_zero:
        yield "stiffness", "an elastic joint needs a stiffness: give one, or make the joint passive"
    for cell, formula in cells(joint.spring):
        if joint.kind not in (Kind.ELASTIC, Kind.CUT) and not formula.is_zero:
            yield cell.label, f"the joint is {joint.kind.value}: only an elastic one has {cell.label}"


def _check_declared(machine: Machine) -> None:
    parameters = {parameter.name for parameter in machine.parameters}
    following, with_variables = _following(machine), parameters.union(machine.variables)
    for place, formula in formulas(machine):
        known = with_variables if place in following else parameters
        for name in sorted(formula.names - known):
            undeclared = f"{quoted(name)} is not declared{did_you_mean(name, known)}"
            if reserved(name) is None:
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
            what = f"{name!r} is the variable of {place_of(j, joint)}: here stand numbers and parameters only"
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
        if value < 0 and cell.column.dimension.is_nonnegative:
            raise machine.error(place, f"{quoted(formula)} is negative: {value:g}")
        if value == 0 and cell.column.dimension is Dimension.CREEP:
            raise machine.error(place, f"{quoted(formula)} is 0: leave it out, then dry friction jumps at rest")


def _check_known_parts(tree: Tree, values: Mapping[str, float]) -> float | None:
    """The value of a tree whose names all have values; raises `FormulaError` where a part has none."""
    parts = [_check_known_parts(part, values) for part in tree[1:] if isinstance(part, tuple)]
    if tree[0] == "name":
        return values.get(tree[1])
    if tree[0] == "/" and parts[1] == 0:
        raise FormulaError("division by zero")
    return None if None in parts else Formula(tree[0], tree).table_value(values)
