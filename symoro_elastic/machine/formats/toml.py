"""The machine as a TOML file: one line per joint, as in the table of geometric parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import Column, Values, declared, with_columns
from symoro_elastic.machine.formats.cells import OTHER, SELECTED, split, whole
from symoro_elastic.machine.formats.files import name_of
from symoro_elastic.machine.formats.format import Format
from symoro_elastic.machine.formats.scenes import scene_of
from symoro_elastic.machine.formats.tables import Number, Table, is_not_finite, load
from symoro_elastic.machine.formats.toml_writing import SECTIONS, write
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Floating,
    Given,
    Inertia6,
    Joint,
    Kind,
    Machine,
    Orientation,
    Parameter,
)
from symoro_elastic.machine.names import did_you_mean, quoted
from symoro_elastic.machine.resolve import resolve

__all__ = ["FORMAT", "read", "write"]

JOINT_KEYS = ("name", "antecedent", "kind", "sigma", *(column.key for column in declared(Joint, "joints")))
KEYS = (
    *("name", "notes", "gravity", "joints", "parameters"),
    *SECTIONS,
    *("base", "scene", "extras"),
)
MOTION = tuple(column.key for column in declared(Base, "base"))
FLOATING = ("floating", "known", "body")


def read(text: str, source: str) -> Machine:
    """The machine in a TOML text; raises `InputError`. Consistency is checked by `checks.check`."""
    top = load(text, source).only(KEYS)
    parameters = tuple(_parameter(top.table("parameters"), name) for name in top.table("parameters").entries)
    machine = Machine(
        name=top.text("name", name_of(Path(source).stem)),
        name_origin="" if "name" in top.entries else 'it is made of the name of the file, give another by name = "..."',
        joints=_joints(top, {parameter.name for parameter in parameters}),
        parameters=parameters,
        base=_base(top),
        floating=_floating(top),
        notes=top.texts("notes"),
        extras={key: top.table("extras").text(key) for key in top.table("extras").entries},
        source=source,
    )
    if "scene" not in top.entries:
        return machine
    return replace(machine, scene=resolve(scene_of(top.table("scene")), machine))


def _parameter(table: Table, name: str) -> Parameter:
    value: Any = table.entries[name]
    if isinstance(value, dict):
        entry = table.table(name).only(("value", "unit"))
        if is_not_finite(entry.entries.get("value")):
            raise entry.fail("value", f"{entry.entries['value']} is not finite: leave out what is not known")
        value, unit = entry.entries.get("value", Number("nan")), entry.text("unit", "")
    else:
        unit = ""
    if is_not_finite(value) and "nan" in value:
        return Parameter(name, None, unit)
    return Parameter(name, table.cell(value, name), unit)


def _base(top: Table) -> Base:
    table = top.table("base").only((*MOTION, *FLOATING))
    return replace(with_columns(Base(), _reader(table, "base")), gravity=top.vector("gravity"))


def _floating(top: Table) -> Floating | None:
    table = top.table("base")
    if "floating" not in table.entries:
        for key in FLOATING[1:]:
            if key in table.entries:
                raise table.fail(key, 'only a floating base has one: add floating = "rotation"')
        return None
    return Floating(
        Orientation(_one_of(table, "floating", tuple(Orientation))),
        Given(_one_of(table, "known", tuple(Given), Given.WRENCH)),
        _body_of(table.table("body")),
    )


def _one_of(table: Table, key: str, known: tuple[str, ...], default: str | None = None) -> str:
    text = table.text(key, default)
    if text not in known:
        raise table.fail(key, f"no {key} {quoted(text)}{did_you_mean(text, known)}")
    return text


def _joints(top: Table, parameters: set[str]) -> tuple[Joint, ...]:
    rows = [_named(row, j) for j, row in enumerate(top.tables("joints"), start=1)]
    numbers: dict[str, int] = {}
    for j, row in enumerate(rows, start=1):
        numbers.setdefault(row.text("name"), j)
    joints = [_joint(row, j, numbers, parameters) for j, row in enumerate(rows, start=1)]
    for section in SECTIONS:
        for name in top.table(section).entries:
            if name not in numbers:
                raise InputError(top.source, section, f"no joint {quoted(name)}{did_you_mean(name, numbers)}")
            j = numbers[name]
            entry = top.table(section).table(name)
            joints[j - 1] = _with_section(joints[j - 1], section, replace(entry, place=rows[j - 1].place))
    return tuple(joints)


def _named(row: Table, j: int) -> Table:
    """The row with the joint's name in its place, which later messages contain."""
    name = replace(row, place=f"joint {j}").text("name")
    shown = name if name.isidentifier() and len(name) < 100 else quoted(name)
    return replace(row, place=f"joint {j} ({shown})")


def _joint(row: Table, j: int, numbers: dict[str, int], parameters: set[str]) -> Joint:
    row.only(JOINT_KEYS)
    kind = _kind(row)
    if "sigma" not in row.entries and kind != Kind.FIXED:
        raise row.fail("sigma", "is missing: 0 revolute, 1 prismatic, 2 fixed frame")
    joint = Joint(
        name=row.text("name"),
        antecedent=_antecedent(row, j, numbers),
        kind=kind,
        sigma=_number(row, "sigma") if "sigma" in row.entries else 2,
    )
    joint = with_columns(joint, _reader(row, "joints"))
    return _with_variable(joint, row, parameters) if joint.sigma in (0, 1) else joint


def _kind(row: Table) -> Kind:
    return Kind(_one_of(row, "kind", tuple(Kind)))


def _number(row: Table, key: str) -> int:
    value = row.entries[key]
    if isinstance(value, bool) or not isinstance(value, int):
        raise row.fail(key, "must be a whole number")
    return whole(value, row.source, row.at(key))


def _antecedent(row: Table, j: int, numbers: dict[str, int]) -> int:
    value = row.entries.get("antecedent", j - 1)
    if not isinstance(value, str) or isinstance(value, Number):
        return _number(row, "antecedent") if "antecedent" in row.entries else j - 1
    if value not in numbers:
        raise row.fail("antecedent", f"no joint {quoted(value)}{did_you_mean(value, numbers)}")
    return numbers[value]


def _with_variable(joint: Joint, row: Table, parameters: set[str]) -> Joint:
    """The joint with its variable: the one undeclared name in the cell that sigma selects."""
    column, other = SELECTED[joint.sigma], OTHER[joint.sigma]
    names = sorted(getattr(joint, column).names - parameters)
    if len(names) == 1:
        return split(joint, names[0], row.source, row.place)
    if names:
        what = f"{', '.join(names)} are not declared: one is the joint variable, the others belong in [parameters]"
        raise row.fail(column, what)
    elsewhere = sorted(getattr(joint, other).names - parameters)
    what = f"no joint variable in {quoted(getattr(joint, column))}, where sigma = {joint.sigma} expects it"
    if elsewhere:
        what += f"; {elsewhere[0]!r} stands in {other}, which is for sigma = {1 - joint.sigma}"
    raise row.fail(column, what)


def _with_section(joint: Joint, section: str, table: Table) -> Joint:
    """The joint with the entries of one section in its columns."""
    if section == "bodies":
        return replace(joint, body=_body_of(table))
    table.only(tuple(column.key for column in declared(Joint, section)))
    return with_columns(joint, _reader(table, section))


def _reader(table: Table, section: str) -> Callable[[Column, Values], Values]:
    """Function that gives columns of the section their values in the table; other columns keep theirs."""

    def read(column: Column, values: Values) -> Values:
        if column.section != section:
            return values
        return table.vector(column.key) if column.parts else (table.formula(column.key),)

    return read


def _body_of(table: Table) -> Body:
    keys = ("mass", "center_of_mass", "inertia"), ("mass", "first_moments", "inertia_at_origin")
    table.only((*keys[0], *keys[1][1:]))
    central = [key for key in keys[0][1:] if key in table.entries]
    about_origin = [key for key in keys[1][1:] if key in table.entries]
    if central and about_origin:
        what = "one of both: center_of_mass and inertia, or first_moments and inertia_at_origin"
        raise table.fail(f"{central[0]}, {about_origin[0]}", what)
    moments, inertia = keys[0][1:] if central else keys[1][1:]
    return Body(table.formula("mass"), table.vector(moments), _inertia(table, inertia), bool(central))


def _inertia(table: Table, key: str) -> Inertia6:
    if key not in table.entries:
        return (ZERO,) * 6
    entries = table.formulas(key, (3, 6))
    if len(entries) == 3:
        xx, yy, zz = entries
        entries = (xx, ZERO, ZERO, yy, ZERO, zz)
    return cast(Inertia6, entries)


FORMAT = Format("TOML", (".toml",), read, write)
