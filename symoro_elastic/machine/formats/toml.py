"""The machine as a TOML file: one line per joint, as in the table of geometric parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import Column, Values, with_columns
from symoro_elastic.machine.formats.files import name_of
from symoro_elastic.machine.formats.format import Format
from symoro_elastic.machine.formats.motions import motions_of, wanted_of
from symoro_elastic.machine.formats.own_variables import with_own_variables
from symoro_elastic.machine.formats.scenes import scene_of
from symoro_elastic.machine.formats.tables import Table, load
from symoro_elastic.machine.formats.toml_keys import (
    ABOUT_CENTER,
    ABOUT_ORIGIN,
    ANTECEDENT,
    BASE,
    BODY,
    EXTRAS,
    FILE_NAME,
    FLOATING,
    GRAVITY,
    JOINTS,
    KIND,
    KNOWN,
    MACHINE,
    NAME,
    NOTES,
    OF_BASE,
    OF_JOINTS,
    PARAMETER,
    PARAMETERS,
    SIGMA,
    VARIABLE,
    key_of,
    section_of,
)
from symoro_elastic.machine.formats.toml_loops import loops_of
from symoro_elastic.machine.formats.toml_writing import write
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Floating,
    Given,
    Joint,
    Kind,
    Machine,
    Orientation,
    Parameter,
)
from symoro_elastic.machine.names import did_you_mean, quoted
from symoro_elastic.machine.resolve import resolve

__all__ = ["FORMAT", "read", "write"]


def read(text: str, source: str) -> Machine:
    """The machine in a TOML text; raises `InputError`. Consistency is checked by `checks.check`."""
    return machine_of(load(text, source))


def machine_of(top: Table) -> Machine:
    """The machine in the top table of a file, as `read` gives it."""
    top, source = top.only(MACHINE.names), top.source
    listed = PARAMETERS.type.read(top, PARAMETERS.name)
    parameters = tuple(Parameter(name, *PARAMETER.read(listed, name)) for name in listed.entries)
    joints = _joints(top, {parameter.name for parameter in parameters})
    machine = Machine(
        name=FILE_NAME.read(top, name_of(Path(source).stem)),
        name_origin=""
        if FILE_NAME.name in top.entries
        else 'it is made of the name of the file, give another by name = "..."',
        joints=joints,
        loops=loops_of(top, joints),
        parameters=parameters,
        base=_base(top),
        floating=_floating(top.table("base")),
        notes=NOTES.read(top),
        extras=EXTRAS.read(top),
        source=source,
    )
    scene = resolve(scene_of(top.table("scene")), machine) if "scene" in top.entries else None
    return replace(machine, scene=scene, motions=motions_of(top, machine), wanted=wanted_of(top))


def _base(top: Table) -> Base:
    table = top.table("base").only(BASE.names)
    return replace(with_columns(Base(), _reader(table, "base")), gravity=GRAVITY.read(top))


def _floating(table: Table) -> Floating | None:
    if FLOATING.name not in table.entries:
        for key in (KNOWN.name, OF_BASE.name):
            if key in table.entries:
                raise table.fail(key, 'only a floating base has one: add floating = "rotation"')
        return None
    body = _body_of(table.table(OF_BASE.name))
    return Floating(Orientation(FLOATING.read(table)), Given(KNOWN.read(table)), body)


def _joints(top: Table, parameters: set[str]) -> tuple[Joint, ...]:
    rows = [_named(row, j) for j, row in enumerate(top.tables("joints"), start=1)]
    numbers: dict[str, int] = {}
    for j, row in enumerate(rows, start=1):
        numbers.setdefault(row.text("name"), j)
    joints = [_joint(row, j, numbers) for j, row in enumerate(rows, start=1)]
    given = {j: VARIABLE.read(row) for j, row in enumerate(rows, start=1) if VARIABLE.name in row.entries}
    joints = [*with_own_variables(joints, given, parameters, lambda j, key, what: rows[j - 1].fail(key, what))]
    for section in OF_JOINTS:
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


def _joint(row: Table, j: int, numbers: dict[str, int]) -> Joint:
    """A row as written, its variable still in its cell."""
    row.only(JOINTS.names)
    kind = Kind(KIND.read(row))
    if SIGMA.name not in row.entries and kind != Kind.FIXED:
        raise row.fail("sigma", "is missing: 0 revolute, 1 prismatic, 2 fixed frame")
    joint = Joint(NAME.read(row), _antecedent(row, j, numbers), kind, SIGMA.read(row, 2))
    return with_columns(joint, _reader(row, "joints"))


def _antecedent(row: Table, j: int, numbers: dict[str, int]) -> int:
    value = ANTECEDENT.read(row, j - 1)
    if isinstance(value, int):
        return value
    if value not in numbers:
        raise row.fail("antecedent", f"no joint {quoted(value)}{did_you_mean(value, numbers)}")
    return numbers[value]


def _with_section(joint: Joint, section: str, table: Table) -> Joint:
    """The joint with the entries of one section in its columns."""
    if section == "bodies":
        return replace(joint, body=_body_of(table))
    table.only(section_of(section, Joint).names)
    return with_columns(joint, _reader(table, section))


def _reader(table: Table, section: str) -> Callable[[Column, Values], Values]:
    """Function that gives columns of the section their values in the table; other columns keep theirs."""

    def read(column: Column, values: Values) -> Values:
        if column.section != section:
            return values
        found = key_of(column).read(table)
        return found if column.parts else (found,)

    return read


def _body_of(table: Table) -> Body:
    table.only(BODY.names)
    central, about_origin = (
        [key.name for key in form[1:] if key.name in table.entries] for form in (ABOUT_CENTER, ABOUT_ORIGIN)
    )
    if central and about_origin:
        what = "one of both: center_of_mass and inertia, or first_moments and inertia_at_origin"
        raise table.fail(f"{central[0]}, {about_origin[0]}", what)
    return with_columns(Body(central=bool(central)), _reader(table, "bodies"))


FORMAT = Format("TOML", (".toml",), read, write)
