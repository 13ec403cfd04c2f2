"""Numbers of the table as parameters, so that a frequency has a sensitivity to each of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from symoro_elastic.foundation.errors import InputError, refusing
from symoro_elastic.machine.checks import law_faults, start_faults
from symoro_elastic.machine.columns import Cell, Dimension, with_cells
from symoro_elastic.machine.constants import with_constants
from symoro_elastic.machine.described import AnyMachine, DescribedMachine, drives_of
from symoro_elastic.machine.drives import Drive, Drives, gain_unit, why_wrong
from symoro_elastic.machine.formula import Formula, refuse_range
from symoro_elastic.machine.loops import branches
from symoro_elastic.machine.machine import Joint, Machine, Parameter
from symoro_elastic.machine.names import no_such

GEOMETRY, BODIES = "joints", "bodies"
"""The sections of the file that hold lengths and angles, and inertial parameters."""
OF_TIME = ("lag", "dead_time", "period", "windup", "ti", "time")
UNITS = {"frequency": "Hz", "current_limit": "A", "voltage_limit": "V", "kp": "V/A", **dict.fromkeys(OF_TIME, "s")}
WINDING = ("resistance", "inductance", "torque_constant", "back_emf")
"""Columns of a motor that belong to the drive that controls its current."""


def with_named_cells(machine: AnyMachine) -> AnyMachine:
    """Return the machine with masses, stiffnesses, lengths ... as parameters `<joint>.<quantity>` with values.

    Parameters keep their names. Zeros and angles stay as they are: they are the structure of a machine. So do lengths
    in loops: one that changes alone may open a loop, as two sides of a parallelogram are equal. So do bodies that bend
    by modes: their integrals do not follow.
    """
    named: list[Parameter] = []
    around = {j for loop in machine.loops for branch in branches(machine.antecedents, loop) for j in branch}
    numbered = enumerate(machine.joints, start=1)
    bending, held = machine.flexible_bodies, {*around, *machine.modal_followers}
    sections = ((j, joint, (GEOMETRY,) * (j in held) + (BODIES,) * (j in bending)) for j, joint in numbered)
    joints = tuple(_with_named_numbers(joint, named, untouched) for _, joint, untouched in sections)
    return replace(machine, joints=joints, parameters=(*machine.parameters, *named))


def with_values(machine: AnyMachine, values: Mapping[str, float]) -> AnyMachine:
    """Return the machine with other values of parameters, of the cells named by `with_named_cells`, or of drives.

    Raises `InputError` for names that do not exist, and for values that no file may have, such as a negative mass.
    """
    named = with_named_drives(with_named_cells(machine))
    names = [parameter.name for parameter in named.parameters]
    refuse_values(machine, values, names)
    formulas = {name: Formula.parse(float(x)) for name, x in values.items()}
    parameters = tuple(replace(p, value=formulas.get(p.name, p.value)) for p in named.parameters)
    refuse_wrong_values(named, values, {p.name: p.value.value() for p in parameters if p.value is not None})
    return with_constants(replace(named, parameters=parameters), names[len(machine.parameters) :])


def refuse_values(machine: Machine, values: Mapping[str, float], names: Sequence[str]) -> None:
    """Raise `InputError` for a value of a parameter that does not exist, or that is out of range."""
    source = machine.label
    for name, x in values.items():
        if name not in names:
            raise InputError(source, "--value", no_such("parameter", name, names))
        with refusing(source, f"--value, {name}"):
            refuse_range(x)


def refuse_wrong_values(machine: Machine, names: Collection[str], values: dict[str, float]) -> dict[str, float]:
    """Return the values; raises `InputError` for a cell that they make impossible, such as a negative mass."""
    for name, owner, named in machine.cells_with_names:
        touched = False
        for cell, formula in named:
            if not formula.names.isdisjoint(names) and formula.names <= values.keys():
                _refuse(machine, f"{name}.{cell.name}", cell.column.dimension, formula, values)
                touched = True
        if touched and isinstance(owner, Joint):
            for key, what in law_faults(owner, values):
                raise InputError(machine.label, f"{name}.{key}", what)
    refuse_wrong_drives(machine, names, values)
    for place, what in start_faults(machine, values) if machine.loops else ():
        raise InputError(machine.label, place, what)
    return values


def _refuse(machine: Machine, place: str, dimension: Dimension, formula: Formula, values: Mapping[str, float]) -> None:
    """Raise `InputError` for the value of a cell that depends on parameters, or that has none."""
    with refusing(machine.label, place):
        value = formula.table_value(values)
    causes = ", ".join(f"{name} = {values[name]:g}" for name in sorted(formula.names))
    if what := dimension.fault(value, f" by {causes}"):
        raise InputError(machine.label, place, what)


def _with_named_numbers(joint: Joint, named: list[Parameter], untouched: Collection[str]) -> Joint:
    """The joint with names in place of the numbers that may be tuned, but those of the sections `untouched`.

    Their values are added to `named`.
    """

    def name(cell: Cell, formula: Formula) -> Formula:
        if formula.names or formula.is_zero or not cell.column.tunable or cell.column.section in untouched:
            return formula
        name = f"{joint.name}.{cell.name}"
        named.append(Parameter(name, formula))
        return Formula(name, ("name", name))

    return with_cells(joint, name)


@dataclass(frozen=True)
class DriveNumber:
    """A number of a drive: the joint of its motor, and its place, as `Kp`, `lag`, `filter_1.frequency`."""

    joint: Joint
    place: str

    @property
    def unit(self) -> str:
        """Unit of the number; empty for a number without one."""
        if self.place in ("Kv", "Kp", "Tn"):
            return gain_unit(self.place, self.joint)
        if self.place == "torque_limit":
            return self.joint.force_unit
        if self.place == "acceleration_forward":
            return "kg" if self.joint.sigma == 1 else "kg m2"
        return UNITS.get(self.place.rpartition(".")[2], "")


def with_changed(drive: Drive, change: Callable[[str, Formula], Formula]) -> Drive:
    """Return a drive with every formula changed, by its place: names of fields, and numbers of rows."""
    changed: Drive = _with_changes(drive, "", change)
    return changed


def _with_changes(part: Any, place: str, change: Callable[[str, Formula], Formula]) -> Any:
    if isinstance(part, Formula):
        return change(place, part)
    if isinstance(part, tuple):
        return tuple(_with_changes(x, f"{place.removesuffix('s')}_{k}", change) for k, x in enumerate(part, start=1))
    if not is_dataclass(part) or isinstance(part, type):
        return part
    names = [field.name for field in fields(part)]
    return replace(part, **{x: _with_changes(getattr(part, x), f"{place}.{x}".lstrip("."), change) for x in names})


def with_named_drives(machine: AnyMachine) -> AnyMachine:
    """Return the machine with the numbers of its drives, and of windings that they control, as parameters with values.

    Parameters keep their names. Zeros stay: they are structure.
    """
    drives, named = drives_of(machine).by_motor, list[Parameter]()
    if not drives or not isinstance(machine, DescribedMachine):
        return machine

    def of(joint: Joint) -> Callable[[str, Formula], Formula]:
        def name(place: str, formula: Formula) -> Formula:
            if formula.names or formula.is_zero:
                return formula
            name = f"{joint.name}.{place}"
            named.append(Parameter(name, formula))
            return Formula(name, ("name", name))

        return name

    joints = {joint.name: joint for joint in machine.joints}
    named_drives = {name: with_changed(drive, of(joints[name])) for name, drive in drives.items()}
    windings = {name: _with_winding(joints[name], of(joints[name])) for name, drive in drives.items() if drive.current}
    rows = tuple(windings.get(joint.name, joint) for joint in machine.joints)
    return replace(machine, joints=rows, drives=Drives(named_drives), parameters=(*machine.parameters, *named))


def _with_winding(joint: Joint, change: Callable[[str, Formula], Formula]) -> Joint:
    return with_cells(joint, lambda cell, x: change(cell.name, x) if cell.name in WINDING else x)


def numbers_of_drives(machine: Machine) -> dict[str, DriveNumber]:
    """Return the numbers of drives that `with_named_drives` names, by their names."""
    joints = {joint.name: joint for joint in machine.joints}
    new = with_named_drives(machine).parameters[len(machine.parameters) :]
    parts = ((p.name, *p.name.split(".", 1)) for p in new)
    return {name: DriveNumber(joints[joint], place) for name, joint, place in parts}


def why_no_number(machine: Machine, name: str) -> str:
    """Return why a number of a drive cannot change, with the way out; empty if it can."""
    motor, _, place = name.partition(".")
    drive = drives_of(machine).by_motor.get(motor)
    formula = dict(_places(drive)).get(place) if drive else None
    if isinstance(formula, Formula):
        if formula.names:
            return f"it is {formula}: name {', '.join(sorted(formula.names))} in its place"
        return "it is 0, so the drive has no such part: give it a number above zero"
    if drive is not None and place in {field.name for field in fields(Drive)}:
        return "the drive has no such part: give it a number" if formula is None else f"it is {formula}, no number"
    return ""


def _places(drive: Drive) -> Iterator[tuple[str, Any]]:
    """Yield all fields of a drive, and its formulas by their places."""
    yield from ((field.name, getattr(drive, field.name)) for field in fields(Drive))
    formulas = dict[str, Formula]()
    with_changed(drive, formulas.setdefault)
    yield from formulas.items()


def refuse_wrong_drives(machine: Machine, names: Collection[str], values: Mapping[str, float]) -> None:
    """Raise `InputError` for a number of a drive that these values make impossible."""
    for motor, drive in drives_of(machine).by_motor.items():
        for key, formula in drive.formulas:
            if formula.names.isdisjoint(names) or not formula.names <= values.keys():
                continue
            if reason := why_wrong(key, formula.value(values)):
                raise InputError(machine.label, f"drives, {motor}, {key}", reason)
