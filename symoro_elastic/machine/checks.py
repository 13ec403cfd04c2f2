"""Consistency checks of a machine: errors that name joint and column, and warnings.

A fault is a place and what is wrong there. Faults come in stages, names first: each stage relies on those before it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from itertools import chain

from symoro_elastic.foundation.errors import TWICE, refusing
from symoro_elastic.machine.columns import LEAST_ROUNDING, Cell, cells, columns
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.flexible_faults import flexible_faults
from symoro_elastic.machine.format_names import TOML, is_robot
from symoro_elastic.machine.formula import Formula, FormulaError, Tree
from symoro_elastic.machine.formula_units import Doubt, UnitsOfNames
from symoro_elastic.machine.joints import SELECTED
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import (
    NONE,
    Reasons,
    did_you_mean,
    no_such,
    quote,
    undeclared,
    unusable,
    why_no_joint,
    why_no_machine,
    why_reserved,
)
from symoro_elastic.machine.plausibility import warnings
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.quantities.frames import BASE, kind_and_name
from symoro_elastic.quantities.unit_reader import UnitError, read_unit

Fault = tuple[str, str]
"""A place of the machine, or the key of a joint or loop; and what is wrong there."""
BESIDE_MOTORS = ("stiffness", "neutral")
"""Cells of a spring that acts in parallel with a motor."""
MOST_JOINTS = 1000
"""Rows of a table; the models of larger ones need hours."""
SAME = 1e-9
"""Largest difference, rad or m, of positions that are the same but for rounding."""


def check(machine: Machine, reserved: Reasons = NONE, models: Models | None = None) -> list[str]:
    """Return warnings, one line each, about a machine that can be modelled.

    `reserved` are names that generated code uses, with reasons, `models` those that its scene may name; without them
    this is checked where code is generated. Raises `InputError` for a machine that cannot be modelled: its place is
    `joint 3 (bed_x), alpha` or a key.
    """
    described = DescribedMachine.of(machine)
    _refuse(machine, _faults(described, reserved))
    doubts = [*_doubts(machine)]
    _refuse(machine, ((place, doubt.what) for place, doubt in doubts if doubt.is_certain))
    values = parameter_values(machine)
    _refuse(machine, _value_faults(machine, values))
    if described.asked.scene is not None:
        resolve(described.asked.scene, machine, models)
    of_units = () if is_robot(machine.source) else (f"{place}: {doubt.what}" for place, doubt in doubts)
    lines = [*described.origin.remarks, *warnings(machine, values), *of_units]
    return [*lines, *_share_warnings(machine), *_loop_warnings(described)]


def place_of(j: int, joint: Joint, key: str = "") -> str:
    """The name of a joint, or of one of its cells, in messages."""
    name = joint.name if why_reserved(joint.name) is None else quote(joint.name)
    return f"joint {j} ({name}), {key}" if key else f"joint {j} ({name})"


def formulas(machine: Machine) -> Iterator[tuple[str, Formula]]:
    """Every expression of the machine over its parameters, with its place."""
    return ((place, formula) for place, _, _, formula in _cells(machine))


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
        with refusing(machine.label, f"parameters, {parameter.name}"):
            values[parameter.name] = parameter.value.table_value()
    return values


def law_faults(joint: Joint, values: Mapping[str, float]) -> Iterator[Fault]:
    """Faults of values that belong together, with the key of the joint; unknown values are skipped."""
    spring, law = joint.spring, joint.friction
    if not spring.rounding.is_zero and (spring.rounding.names | spring.backlash.names) <= values.keys():
        backlash, rounding = spring.backlash.value(values), spring.rounding.value(values)
        if rounding < LEAST_ROUNDING * backlash:
            yield "rounding", f"{rounding:g} is sharper than {LEAST_ROUNDING:g} of the backlash {backlash:g}: give more"
    if not law.bristle.is_zero and law.coulomb.names <= values.keys() and law.coulomb.value(values) == 0:
        yield "bristle", "the joint has no coulomb friction that it could hold: give coulomb"
    if joint.sharing.names <= values.keys() and joint.sharing.value(values) < 0:
        yield "sharing", f"{quote(joint.sharing)} is negative: {joint.sharing.value(values):g}"


def start_faults(machine: Machine, values: Mapping[str, float]) -> Iterator[Fault]:
    """Positions of loops that have no value, or differ from those of another loop, with their place."""
    before: dict[str, tuple[str, float]] = {}
    for loop in machine.loops:
        for variable, formula in loop.start.items():
            place = f"loop {loop.name}, start, {variable}"
            try:
                value = formula.value(values)
            except KeyError:
                yield place, _without_value(machine, formula, values)
                continue
            except FormulaError as error:
                yield place, str(error)
                continue
            other, first = before.setdefault(variable, (loop.name, value))
            if not math.isclose(first, value, rel_tol=SAME, abs_tol=SAME):
                yield place, f"{value:g} contradicts {first:g} of loop {other}: a joint has one position"


def _refuse(machine: Machine, faults: Iterable[Fault]) -> None:
    """Raise `InputError` for the first fault."""
    for place, what in faults:
        raise machine.error(place, what)


def _faults(machine: DescribedMachine, reserved: Reasons) -> Iterator[Fault]:
    """Faults that need no values of parameters."""
    rows = [(j, place_of(j, joint), joint) for j, joint in enumerate(machine.joints, start=1)]
    yield from _name_faults(machine, reserved)
    for j, place, joint in rows:
        yield from _at(place, _row_faults(j, joint))
    yield from flexible_faults(machine)
    for column, vector in columns(machine.base):
        if machine.floating and column.key != "gravity" and any(not x.is_zero for x in vector):
            yield f"base, {column.key}", "it is an argument where the base floats: leave it out"
    for j, place, joint in rows:
        if not joint.friction.ball.is_zero and not machine.ball(j):
            what = "this row and the two that carry it must be revolute: they make the ball joint"
            yield f"{place}, ball damping", what
    for loop in machine.loops:
        for key, row in (("cut", loop.cut), ("meets", loop.meets)):
            if not 1 <= row <= len(rows):
                yield f"loop {loop.name}, {key}", f"row {row} is missing: the table has {len(rows)}"
    for j, place, joint in rows:
        yield from _at(place, _cut_faults(machine, j, joint))
    yield from _loop_faults(machine, reserved)
    yield from _declaration_faults(machine)
    for j in machine.articulated:
        yield from _at(place_of(j, machine.joint(j)), _following_faults(machine, machine.joint(j)))
    yield from _cycles(machine)
    yield from _parameter_faults(machine)


def _value_faults(machine: Machine, values: Mapping[str, float]) -> Iterator[Fault]:
    """Faults of values of cells, as far as parameters have values."""
    for place, _, cell, formula in _cells(machine):
        if not formula.is_zero and (what := _value_fault(cell, formula, values)):
            yield place, what
    for j in machine.with_backlash:
        if changed_by := ", ".join(sorted(machine.joint(j).spring.stiffness.names & machine.variables.keys())):
            what = f"its stiffness changes with {changed_by}, and a backlash needs a constant one"
            yield place_of(j, machine.joint(j), "backlash"), f"{what}: remove one of the two"
    for j, joint in enumerate(machine.joints, start=1):
        yield from _at(place_of(j, joint), law_faults(joint, values))
    yield from start_faults(machine, values)


def _at(place: str, faults: Iterable[Fault]) -> Iterator[Fault]:
    return ((f"{place}, {key}", what) for key, what in faults)


def _cells(machine: Machine) -> Iterator[tuple[str, Joint | None, Cell, Formula]]:
    """Every cell of the machine, with its place in words, and its joint if it belongs to one."""
    for j, joint in enumerate(machine.joints, start=1):
        place = place_of(j, joint)
        yield from ((f"{place}, {cell.label}", joint, cell, formula) for cell, formula in cells(joint))
    for frame in machine.frames:
        yield from ((f"frame {frame.name}, {cell.label}", None, cell, formula) for cell, formula in cells(frame))
    if machine.floating:
        yield from ((f"base, {cell.label}", None, cell, formula) for cell, formula in cells(machine.floating))
    yield from ((cell.label, None, cell, formula) for cell, formula in cells(machine.base))


def _doubts(machine: Machine) -> Iterator[tuple[str, Doubt]]:
    """Errors and possible errors in the units of formulas, with the place of each."""
    units = UnitsOfNames(machine)
    followers = [machine.joint(j) for j in machine.modal_followers]
    for place, joint, cell, formula in _cells(machine):
        if formula.names and joint not in followers:
            unit = joint.unit_of(cell) if joint else cell.column.dimension.units[0]
            position = joint is not None and cell.column.key == SELECTED.get(joint.sigma)
            yield from ((place, doubt) for doubt in units.doubts(formula, unit, gives_position=position))


def _name_faults(machine: DescribedMachine, reserved: Reasons) -> Iterator[Fault]:
    if not machine.joints and not machine.floating:
        yield "joints", "the machine has no joint: give at least one row of the table"
    if len(machine.joints) > MOST_JOINTS:
        yield "joints", f"{len(machine.joints)} rows: at most {MOST_JOINTS} can be modelled"
    rows = [*enumerate(machine.joints, start=1)]
    joints = [(place_of(j, joint, "name"), joint.name) for j, joint in rows]
    variables = [(place_of(j, x, "joint variable"), x.variable) for j, x in rows if x.variable is not None]
    parameters = [("parameters", parameter.name) for parameter in machine.parameters]
    named = [(why_no_machine, "name", machine.name), *((why_no_joint, *pair) for pair in joints)]
    for why, place, name in [*named, *((why_reserved, *pair) for pair in (*variables, *parameters))]:
        if reason := why(name, reserved):
            origin = f" ({machine.origin.of_name})" if place == "name" and machine.origin.of_name else ""
            yield place, unusable(name, reason, reserved) + origin
    yield from _frame_faults(machine, reserved)
    for names in (joints, [*parameters, *variables]):
        places: dict[str, str] = {}
        for place, name in names:
            if name in places:
                yield place, f"the name {name!r} is taken by {places[name]}: choose another"
            places[name] = place


def _is_carried(machine: Machine, on: str, name: str) -> bool:
    """Whether frame `on` is fixed to the body of the row `name`, directly or by fixed frames and coupled joints."""
    rows = {joint.name: joint for joint in machine.joints}
    while on in rows and on != name and rows[on].kind in (Kind.FIXED, Kind.COUPLED) and rows[on].antecedent:
        on = machine.joint(rows[on].antecedent).name
    return on == name


def _frame_faults(machine: Machine, reserved: Reasons) -> Iterator[Fault]:
    """Faults of named frames: names that cannot be used, and rows that are not there."""
    rows = {joint.name for joint in machine.joints}
    for frame in machine.frames:
        what, name = kind_and_name(frame.name)
        place = f"frame {quote(frame.name)}"
        if reason := why_no_joint(name, reserved):
            yield place, unusable(name, reason, reserved)
        if frame.on and frame.on not in rows:
            yield f"{place}, on", no_such("joint", frame.on, rows)
        if frame.name == BASE or (name in rows and not what and not _is_carried(machine, frame.on, name)):
            owner = "frame 0" if frame.name == BASE else f"the frame of joint {name}, whose body does not carry it"
            yield place, f"{owner} has this name: choose another, or write 'link {name}'"


def _row_faults(j: int, joint: Joint) -> Iterator[Fault]:
    kind, sigma = joint.kind, joint.sigma
    if not 0 <= joint.antecedent < j:
        what = f"{joint.antecedent} must be 0 (the base) or a row above {j}: joints are numbered from the base outwards"
        yield "antecedent", f"{what}; closed loops are written with a row of kind cut, in [loops]"
    if sigma not in (0, 1, 2):
        yield "sigma", f"{sigma} must be 0 (revolute), 1 (prismatic) or 2 (fixed frame)"
    if kind != Kind.CUT and (kind == Kind.FIXED) != (sigma == 2):
        yield "kind", f"{kind.value!r} does not go with sigma = {sigma}: kind fixed means sigma = 2"
    if sigma == 2 and joint.variable is not None:
        yield "joint variable", f"a fixed frame has no variable: remove {joint.variable!r}"
    if kind == Kind.COUPLED and joint.variable is not None:
        yield "joint variable", f"a coupled joint has no variable of its own: remove {joint.variable!r}"
    if sigma != 2 and joint.variable is None and kind != Kind.COUPLED:
        yield SELECTED[sigma], f"the joint variable is missing, sigma = {sigma} puts it here"
    yield from _cells_without_place(joint)
    yield from _law_faults(joint)


def _law_faults(joint: Joint) -> Iterator[Fault]:
    """Faults of springs, friction and motors: cells that lack a companion, such as a ratio without rotor inertia."""
    spring, law, cogging = joint.spring, joint.friction, joint.cogging
    if not joint.sharing.is_zero and joint.kind not in (Kind.MOTOR, Kind.CUT):
        yield "sharing", f"the joint is {joint.kind.value}: only motors share a torque"
    if not joint.ratio.is_zero and joint.rotor_inertia.is_zero:
        yield "ratio", "a ratio needs a rotor_inertia, that of the rotor about its own axis"
    if joint.kind == Kind.ELASTIC and spring.stiffness.is_zero:
        yield "stiffness", "an elastic joint needs a stiffness: give one, or make the joint passive"
    if spring.backlash.is_zero and not spring.rounding.is_zero:
        yield "rounding", "it rounds the edges of a backlash: give backlash, or leave it out"
    if not law.bristle.is_zero and not law.creep.is_zero:
        yield "bristle, creep", "both make dry friction smooth: keep one"
    if not law.bristle.is_zero and law.bristle_damping.is_zero:
        yield "bristle_damping", "give it with bristle; sqrt(bristle times the inertia of the joint) is usual"
    if law.static.is_zero != law.stribeck.is_zero:
        yield "static, stribeck", "give both, or none: friction at rest, and the velocity at which half of it is gone"
    if cogging.amplitude.is_zero and not (cogging.order.is_zero and cogging.phase.is_zero):
        yield "cogging", "is missing, its order is given: give the amplitude of the torque, or leave the order out"
    if cogging.order.is_zero and not cogging.amplitude.is_zero:
        yield "cogging order", "is missing: give the periods of cogging in a turn of the rotor, as 24"


def _cells_without_place(joint: Joint) -> Iterator[Fault]:
    """Cells of springs and motors that this kind of joint cannot have."""
    kind, coupled = joint.kind, "a coupled joint has no variable of its own: add one to the cell, or move the"
    for cell, formula in cells(joint.spring):
        if kind in (Kind.ELASTIC, Kind.CUT) or formula.is_zero:
            continue
        if kind is Kind.COUPLED:
            yield cell.label, f"{coupled} spring to a joint that has"
        elif kind is not Kind.MOTOR or cell.column.key not in BESIDE_MOTORS:
            advice = ": give viscous friction" if kind is Kind.MOTOR and cell.column.key == "damping" else ""
            yield cell.label, f"the joint is {kind.value}: only an elastic one has {cell.label}{advice}"
        elif joint.spring.stiffness.is_zero:
            yield "neutral", "the motor has no spring: give its stiffness, or leave it out"
    if kind is Kind.COUPLED and not joint.sharing.is_zero:
        yield "sharing", f"{coupled} motor to a joint that has"
    for cell, formula in cells(joint.cogging):
        if kind is not Kind.MOTOR and not formula.is_zero:
            yield cell.label, f"the joint is {kind.value}: only a motor has {cell.label}"


def _cut_faults(machine: Machine, j: int, joint: Joint) -> Iterator[Fault]:
    """Faults of row j that is a cut joint, or whose antecedent is one."""
    carrier = machine.joint(joint.antecedent) if joint.antecedent else None
    if carrier and carrier.kind == Kind.CUT:
        where = machine.joint(carrier.antecedent).name if carrier.antecedent else "the base"
        yield "antecedent", f"{carrier.name} is a cut joint, which carries no other: hang it on {where}"
    if joint.kind != Kind.CUT:
        return
    loop = next((loop for loop in reversed(machine.loops) if loop.cut == j), None)
    for what, key in _cells_on_cut_joint(joint):
        around = map(machine.joint, machine.around(loop)) if loop else ()
        passive = ", ".join(str(joint.variable) for joint in around if joint.kind == Kind.PASSIVE)
        elsewhere = f" (passive joints of it: {passive})" if passive else ""
        yield key, f"the cut joint carries no {what}: cut the loop elsewhere{elsewhere}"
    if not loop:
        example = f'[loops] name = {{ cut = "{joint.name}", meets = "..." }}'
        yield "kind", f"no loop is closed by this cut joint: write {example}, or give it another kind"


def _cells_on_cut_joint(joint: Joint) -> Iterator[tuple[str, str]]:
    """Cells with an entry on a cut joint: what they describe, and their key."""
    acting = (pair for pair in cells(joint) if pair[0].column.section in ("springs", "motors"))
    for cell, formula in chain(cells(joint.body), acting):
        if not formula.is_zero:
            yield "motor, spring or body", cell.label
    for what in ("friction", "wrench"):
        for cell, formula in cells(getattr(joint, what)):
            if formula != cell.column.default:
                yield what, cell.label


def _loop_faults(machine: Machine, reserved: Reasons) -> Iterator[Fault]:
    """Faults of the entries of loops."""
    ends: dict[int, str] = {}
    for loop in machine.loops:
        reason = why_reserved(loop.name, reserved)
        if reason or loop.name in (other.name for other in machine.loops if other is not loop):
            yield f"loop {quote(loop.name)}", f"this name cannot be used: {reason or 'two loops have it'}"
        yield from _at(f"loop {loop.name}", _end_faults(machine, loop, ends))
        yield from _at(f"loop {loop.name}", _dependent_faults(machine, loop))
        variables = {joint.variable for joint in machine.joints if joint.variable}
        for name in loop.start:
            if name not in variables:
                what = f"no joint variable {quote(name)}{did_you_mean(name, sorted(variables))}"
                yield f"loop {loop.name}, start", what
        ends |= {loop.cut: loop.name, loop.meets: loop.name}
    named: dict[str, str] = {}
    for loop in machine.loops:
        for name in loop.dependent:
            if named.setdefault(name, loop.name) != loop.name:
                what = f"{name} follows from loop {named[name]} already: name another joint of the loop"
                yield f"loop {loop.name}, dependent", what


def _end_faults(machine: Machine, loop: Loop, ends: Mapping[int, str]) -> Iterator[Fault]:
    """Faults of the two rows that a loop joins; `ends` names the loops of the rows that earlier loops join."""
    cut, meets = machine.joint(loop.cut), machine.joint(loop.meets)
    if loop.cut == loop.meets:
        yield "meets", f"{meets.name} is the cut joint itself: name the fixed frame that it meets"
    if cut.kind != Kind.CUT:
        cuts = [joint.name for joint in machine.joints if joint.kind == Kind.CUT]
        yield "cut", f'{cut.name} is not a cut joint: its row needs kind = "cut"{did_you_mean(cut.name, cuts)}'
    if meets.kind != Kind.FIXED and loop.cut != loop.meets:
        yield "meets", f"{meets.name} is not a fixed frame: the cut joint meets a row of its own, of kind fixed"
    for key, row, joint in (("cut", loop.cut, cut), ("meets", loop.meets, meets)):
        if row in ends:
            what = f"{joint.name} belongs to loop {ends[row]}"
            yield key, f"{what}: each loop has a cut joint and a fixed frame of its own"
    if loop.closes is Closing.POINT and cut.sigma != 2:
        yield "closes", f"a ball joint has no variable in the table: give {cut.name} sigma = 2"
    if not machine.around(loop):
        yield "cut", f"no joint between {cut.name} and {meets.name} moves: all of the loop is fixed"


def _dependent_faults(machine: Machine, loop: Loop) -> Iterator[Fault]:
    """Faults of the dependent joints that a loop names, such as a joint outside of the loop or one named twice."""
    names = machine.rows
    inside = [machine.joint(j).name for j in machine.with_variable_in(loop)]
    for name in loop.dependent:
        if name not in names:
            yield "dependent", no_such("joint", name, inside)
        elif names[name] == loop.cut:
            yield "dependent", f"{name} is the cut joint, whose variable follows anyway: leave it out"
        elif names[name] in machine.articulated and names[name] not in machine.with_variable:
            yield "dependent", f"{name} is coupled and has no variable of its own: name the joint that it follows"
        elif name not in inside:
            yield "dependent", f"{name} is not a joint of the loop: those are {', '.join(inside)}"
    if len(set(loop.dependent)) < len(loop.dependent):
        yield "dependent", f"a joint {TWICE}"
    if not loop.dependent and machine.around(loop) and not machine.dependent_in(loop):
        yield "dependent", "the loop has no passive joint: name those that follow from the others"


def _without_value(machine: Machine, formula: Formula, values: Mapping[str, float]) -> str:
    """Why a formula has no value: a name that is not declared, or a parameter without a value."""
    for name in sorted(formula.names - machine.parameter_names):
        return undeclared(name, machine.parameter_names)
    missing = ", ".join(sorted(formula.names - values.keys()))
    return f"{missing} has no value, but numbers select the branch: give it one, or write a number"


def _declaration_faults(machine: Machine) -> Iterator[Fault]:
    """Names in cells that are not declared, and variables in cells that cannot follow joints."""
    for place, joint, cell, formula in _cells(machine):
        allowed: Collection[str] = machine.parameter_names
        if joint and joint.sigma != 2 and joint.kind is not Kind.CUT and _may_follow(joint, cell):
            allowed = machine.parameter_names.union(machine.variables)
        for name in sorted(formula.names - {*allowed}):
            how = f" (declare it: {name} = 1.5, or nan for a name without value)" if why_reserved(name) is None else ""
            yield place, _of_joint(machine, name) or undeclared(name, allowed) + how


def _may_follow(joint: Joint, cell: Cell) -> bool:
    """Whether a cell of a joint that moves may hold other joints' variables."""
    return cell.label == SELECTED[joint.sigma] or (cell.label == "stiffness" and joint.kind is not Kind.MOTOR)


def _of_joint(machine: Machine, name: str) -> str:
    """Why a cell cannot hold the variable of a joint; empty for other names."""
    for j, joint in enumerate(machine.joints, start=1):
        if joint.variable == name and joint.kind == Kind.CUT:
            return f"{name!r} is the variable of the cut joint {joint.name}, which follows from its loop: leave it out"
        if joint.variable == name:
            what = f"{name!r} is the variable of {place_of(j, joint)}: only numbers and parameters are allowed here"
            return f"{what}; a joint that follows it is coupled, with the formula in theta (sigma = 0) or r (sigma = 1)"
    return ""


def _following_faults(machine: Machine, joint: Joint) -> Iterator[Fault]:
    """Faults of a joint whose variable occurs twice in its cell, and of a coupled joint that follows no variable."""
    key, names = SELECTED[joint.sigma], joint.selected.names
    if joint.variable in names:
        yield key, f"{joint.variable!r} is in the cell twice: a joint is its variable plus other variables"
    if joint.kind == Kind.COUPLED and names.isdisjoint(machine.variables):
        what = f"{quote(joint.selected)} holds no variable of another joint"
        yield key, f"{what}: a joint that does not move is fixed, with sigma = 2"


def _cycles(machine: Machine) -> Iterator[Fault]:
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
        j, *followers = around[first:] + around[:first]
        cell = SELECTED[machine.joint(j).sigma]
        needed = [*(str(machine.joint(other).variable) for other in followers), cell]
        if followers:
            what = f"{cell} needs {', which needs '.join(needed)}: break the cycle"
            yield place_of(j, machine.joint(j), cell), what


def _parameter_faults(machine: Machine) -> Iterator[Fault]:
    """Parameters whose unit is not known or not that of SI: only numbers of files are converted."""
    for parameter in (parameter for parameter in machine.parameters if parameter.unit):
        place = f"parameter {parameter.name}"
        try:
            unit = read_unit(parameter.unit)
        except UnitError as error:
            yield place, str(error)
            continue
        if not unit.is_si:
            what = f"its unit is {quote(parameter.unit)}, but values are not converted: write it in {unit.text or '1'}"
            as_text = f', or value = "X {parameter.unit}"' if machine.source.endswith(TOML.suffixes) else ""
            yield place, what + as_text


def _value_fault(cell: Cell, formula: Formula, values: Mapping[str, float]) -> str:
    """Return the fault of a cell's value, as far as parameters have values; empty for a valid one."""
    try:
        if not formula.names <= values.keys():
            _check_known_parts(formula.tree, values)
            return ""
        what = cell.column.dimension.fault(formula.table_value(values))
    except FormulaError as error:
        return str(error)
    return f"{quote(formula)} {what}" if what else ""


def _check_known_parts(tree: Tree, values: Mapping[str, float]) -> float | None:
    """The value of a tree whose names all have values; raises `FormulaError` where a part has none."""
    parts = [_check_known_parts(part, values) for part in tree[1:] if isinstance(part, tuple)]
    if tree[0] == "name":
        return values.get(tree[1])
    if tree[0] == "/" and parts[1] == 0:
        raise FormulaError("division by zero")
    return None if None in parts else Formula(tree[0], tree).table_value(values)


def _share_warnings(machine: Machine) -> list[str]:
    """Warnings about shares of motors that turn and of motors that slide."""
    sharing = [machine.joint(j) for j in machine.motors if not machine.joint(j).sharing.is_zero]
    turning, sliding = ([joint.name for joint in sharing if joint.sigma == sigma] for sigma in (0, 1))
    if not turning or not sliding:
        return []
    return [f"sharing: {turning[0]} turns and {sliding[0]} slides: N m and N have equal weights"]


def _loop_warnings(machine: DescribedMachine) -> Iterator[str]:
    """Warnings about two loops around the same joints, and about a SYMORO type that contradicts the loops."""
    loops_around = dict[tuple[int, ...], str]()
    for loop in machine.loops:
        other = loops_around.setdefault(machine.around(loop), loop.name)
        if other != loop.name:
            yield f"loop {loop.name}: it closes around the same joints as loop {other}: closed twice?"
    of_file, count = machine.origin.extras.get("Type", ""), len(machine.loops)
    if of_file == "2" and not count:
        what = "a .par file with closed loops has NJ > NL, with rows for cut joints and for the frames that they meet"
        yield f"Type = 2: the machine has no closed loop and is read as a tree; {what}"
    if of_file in ("0", "1") and count:
        kind = "a chain" if of_file == "0" else "a tree"
        loops = "a closed loop" if count == 1 else f"{count} closed loops"
        what = f"that is {kind}, but NJ > NL: the machine is read with {loops}"
        yield f"Type = {of_file}: {what}; write Type = 2, or leave those rows out"
