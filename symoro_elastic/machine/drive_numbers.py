"""Numbers of drives as parameters, `motor_x.Kp`: for sweeps, given values, and functional mock-up units."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import with_cells
from symoro_elastic.machine.described import AnyMachine, DescribedMachine, drives_of
from symoro_elastic.machine.drives import Drive, Drives, gain_unit, why_wrong
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine, Parameter

OF_TIME = ("lag", "dead_time", "period", "windup", "ti", "time")
UNITS = {"frequency": "Hz", "current_limit": "A", "voltage_limit": "V", "kp": "V/A", **dict.fromkeys(OF_TIME, "s")}
WINDING = ("resistance", "inductance", "torque_constant", "back_emf")
"""Columns of a motor that belong to the drive that controls its current."""


@dataclass(frozen=True)
class DriveNumber:
    """A number of a drive: the joint of its motor, and its place, as `Kp`, `lag`, `filter_1.frequency`."""

    joint: Joint
    place: str

    @property
    def unit(self) -> str:
        """Its unit; empty for a number without one."""
        if self.place in ("Kv", "Kp", "Tn"):
            return gain_unit(self.place, self.joint)
        if self.place == "torque_limit":
            return self.joint.force_unit
        if self.place == "acceleration_forward":
            return "kg" if self.joint.sigma == 1 else "kg m2"
        return UNITS.get(self.place.rpartition(".")[2], "")


def with_changed(drive: Drive, change: Callable[[str, Formula], Formula]) -> Drive:
    """Return a drive with every formula changed, by its place: names of fields, and numbers of rows."""
    changed: Drive = _changed(drive, "", change)
    return changed


def _changed(part: Any, place: str, change: Callable[[str, Formula], Formula]) -> Any:
    if isinstance(part, Formula):
        return change(place, part)
    if isinstance(part, tuple):
        return tuple(_changed(x, f"{place.removesuffix('s')}_{k}", change) for k, x in enumerate(part, start=1))
    if not is_dataclass(part) or isinstance(part, type):
        return part
    names = [field.name for field in fields(part)]
    return replace(part, **{x: _changed(getattr(part, x), f"{place}.{x}".lstrip("."), change) for x in names})


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
    made = {name: with_changed(one, of(joints[name])) for name, one in drives.items()}
    wound = {name: _with_winding(joints[name], of(joints[name])) for name, one in drives.items() if one.current}
    kept = tuple(wound.get(joint.name, joint) for joint in machine.joints)
    return replace(machine, joints=kept, drives=Drives(made), parameters=(*machine.parameters, *named))


def _with_winding(joint: Joint, change: Callable[[str, Formula], Formula]) -> Joint:
    return with_cells(joint, lambda cell, x: change(cell.name, x) if cell.name in WINDING else x)


def numbers_of_drives(machine: Machine) -> dict[str, DriveNumber]:
    """Return the numbers of drives that `with_named_drives` names, by their names."""
    joints = {joint.name: joint for joint in machine.joints}
    new = with_named_drives(machine).parameters[len(machine.parameters) :]
    parted = ((p.name, *p.name.split(".", 1)) for p in new)
    return {name: DriveNumber(joints[joint], place) for name, joint, place in parted}


def why_no_number(machine: Machine, name: str) -> str:
    """Return why a place of a drive holds no number that may change, with the way out; empty where it is none."""
    motor, _, place = name.partition(".")
    drive = drives_of(machine).by_motor.get(motor)
    found = dict(_places(drive)).get(place) if drive else None
    if isinstance(found, Formula):
        if found.names:
            return f"it is {found}: name {', '.join(sorted(found.names))} in its place"
        return "it is 0, so the drive has no such part: give it a number above zero"
    if drive is not None and place in {field.name for field in fields(Drive)}:
        return "the drive has no such part: give it a number" if found is None else f"it is {found}, no number"
    return ""


def _places(drive: Drive) -> Iterator[tuple[str, Any]]:
    """Yield all fields of a drive, and its formulas by their places."""
    yield from ((field.name, getattr(drive, field.name)) for field in fields(Drive))
    formulas = dict[str, Formula]()
    with_changed(drive, formulas.setdefault)
    yield from formulas.items()


def refuse_wrong_drives(machine: Machine, given: Collection[str], values: Mapping[str, float]) -> None:
    """Raise `InputError` for a number of a drive that no file may say, by one of these values."""
    for motor, drive in drives_of(machine).by_motor.items():
        for key, formula in drive.formulas:
            if formula.names.isdisjoint(given) or not formula.names <= values.keys():
                continue
            if reason := why_wrong(key, formula.value(values)):
                raise InputError(machine.label, f"drives, {motor}, {key}", reason)
