"""The machine as a TOML file: one line per joint, as in the table of geometric parameters."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.format import Format
from symoro_elastic.formats.joint_cells import OTHER, SELECTED, not_alone, offset_of
from symoro_elastic.formats.toml.drives import drives_of
from symoro_elastic.formats.toml.key import Key
from symoro_elastic.formats.toml.keys import (
    ABOUT_CENTER,
    ABOUT_ORIGIN,
    ANTECEDENT,
    BASE,
    BODY,
    CLOSES,
    CUT,
    DEPENDENT,
    EXTRAS,
    FILE_NAME,
    FLOATING,
    GRAVITY,
    JOINTS,
    KIND,
    KNOWN,
    LOOPS,
    MACHINE,
    MEETS,
    NAME,
    NOTES,
    OF_BASE,
    OF_JOINTS,
    PARAMETER,
    PARAMETERS,
    SIGMA,
    START,
    VARIABLE,
    key_of,
    section_of,
)
from symoro_elastic.formats.toml.limits import limits_of
from symoro_elastic.formats.toml.motions import motions_of, wanted_of
from symoro_elastic.formats.toml.scenes import scene_of
from symoro_elastic.formats.toml.tables import Table, load
from symoro_elastic.formats.toml.writing import BASE_PARAMETERS, GROUPED, write
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import OF_ROTORS, Column, Values, with_columns
from symoro_elastic.machine.described import DescribedMachine, Origin, Request
from symoro_elastic.machine.format_names import TOML
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Base, Body, Floating, Joint, Kind, KnownOfBase, Orientation, Parameter
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.resolve import resolve

NAME_OF_FILE = 'it is made of the name of the file, give another by name = "..."'
__all__ = ["FORMAT", "read", "write"]


def read(text: str, source: str) -> DescribedMachine:
    """The machine in a TOML text; raises `InputError`. Consistency is checked by `checks.check`."""
    return machine_of(load(text, source))


def machine_of(top: Table) -> DescribedMachine:
    """The machine in the top table of a file, as `read` gives it."""
    top, source = top.only(MACHINE.names), top.source
    listed = PARAMETERS.type.read(top, PARAMETERS.name)
    parameters = tuple(Parameter(name, *PARAMETER.read(listed, name)) for name in listed.entries)
    joints = _joints(top, {parameter.name for parameter in parameters})
    extras = EXTRAS.read(top)
    machine = DescribedMachine(
        name=FILE_NAME.read(top, name_of(Path(source).stem)),
        joints=joints,
        loops=loops_of(top, joints),
        parameters=parameters,
        base=_base(top),
        floating=_floating(top.table("base")),
        source=source,
        is_grouped=extras.get(BASE_PARAMETERS) == GROUPED,
        origin=Origin(
            notes=NOTES.read(top),
            extras={key: x for key, x in extras.items() if (key, x) != (BASE_PARAMETERS, GROUPED)},
            of_name="" if FILE_NAME.name in top.entries else NAME_OF_FILE,
        ),
    )
    machine = replace(machine, limits=limits_of(top, machine, listed), drives=drives_of(top, machine))
    scene = resolve(scene_of(top.table("scene")), machine) if "scene" in top.entries else None
    return replace(machine, asked=Request(scene, motions_of(top, machine), wanted_of(top)))


def _base(top: Table) -> Base:
    table = top.table("base").only(BASE.names)
    return replace(with_columns(Base(), _reader(table, "base")), gravity=GRAVITY.read(top))


def _floating(table: Table) -> Floating | None:
    if FLOATING.name not in table.entries:
        for key in (KNOWN.name, OF_BASE.name):
            if key in table.entries:
                raise table.fail(key, 'only a floating base has one: add floating = "rotation"')
        return None
    body = body_of(table.table(OF_BASE.name))
    return Floating(Orientation(FLOATING.read(table)), KnownOfBase(KNOWN.read(table)), body)


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
                raise InputError(top.source, section, f"no joint {quote(name)}{did_you_mean(name, numbers)}")
            j = numbers[name]
            entry = top.table(section).table(name)
            joints[j - 1] = _with_section(joints[j - 1], section, replace(entry, place=rows[j - 1].place))
    return tuple(joints)


def _named(row: Table, j: int) -> Table:
    """The row with the joint's name in its place, which later messages contain."""
    name = replace(row, place=f"joint {j}").text("name")
    shown = name if name.isidentifier() and len(name) < 100 else quote(name)
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
        raise row.fail("antecedent", f"no joint {quote(value)}{did_you_mean(value, numbers)}")
    return numbers[value]


def _with_section(joint: Joint, section: str, table: Table) -> Joint:
    """The joint with the entries of one section in its columns."""
    if section == "bodies":
        return replace(joint, body=body_of(table))
    table.only(section_of(section, Joint).names)
    return with_columns(joint, _reader(table, section, joint.sigma))


def _reader(table: Table, section: str, sigma: int | None = None) -> Callable[[Column, Values], Values]:
    """Function that gives columns of the section their values in the table; other columns keep theirs.

    `sigma` is that of the joint; a rotor turns where the joint slides, too.
    """

    def read(column: Column, values: Values) -> Values:
        if column.section != section:
            return values
        key = key_of(column)
        if sigma is not None and column.dimension not in OF_ROTORS:
            key = replace(key, unit=column.dimension.units[int(sigma == 1)])
        found = key.read(table)
        return found if column.parts else (found,)

    return read


def body_of(table: Table) -> Body:
    """The body in a table, about its centre of mass or about the origin of the frame."""
    table.only(BODY.names)
    central, about_origin = (
        [key.name for key in form[1:] if key.name in table.entries] for form in (ABOUT_CENTER, ABOUT_ORIGIN)
    )
    if central and about_origin:
        what = "are two alternatives: give center_of_mass and inertia, or first_moments and inertia_at_origin"
        raise table.fail(f"{central[0]}, {about_origin[0]}", what)
    return with_columns(Body(central=bool(central)), _reader(table, "bodies"))


def loops_of(top: Table, joints: Sequence[Joint]) -> tuple[Loop, ...]:
    """The loops of a file with these joints; raises `InputError`."""
    rows = {joint.name: j for j, joint in reversed([*enumerate(joints, start=1)])}
    by_variable = {joint.variable: joint.name for joint in joints if joint.variable}
    table = top.table("loops")
    entries = {name: replace(table.table(name), place=f"loop {_shown(name)}") for name in table.entries}
    return tuple(_loop(name, entry.only(LOOPS.names), rows, by_variable) for name, entry in entries.items())


def _loop(name: str, entry: Table, rows: Mapping[str, int], by_variable: Mapping[str, str]) -> Loop:
    dependent = DEPENDENT.read(entry)
    for one in dependent:
        if one not in rows and one not in by_variable:
            raise entry.fail(DEPENDENT.name, f"no joint {quote(one)}{did_you_mean(one, [*rows, *by_variable])}")
    return Loop(
        name=name,
        cut=_row(entry, CUT, rows),
        meets=_row(entry, MEETS, rows),
        closes=Closing(CLOSES.read(entry)),
        dependent=tuple(one if one in rows else by_variable[one] for one in dependent),
        start=START.read(entry),
    )


def _row(entry: Table, key: Key, rows: Mapping[str, int]) -> int:
    name = key.read(entry)
    if name not in rows:
        raise entry.fail(key.name, f"no joint {quote(name)}{did_you_mean(name, rows)}")
    return rows[name]


def _shown(name: str) -> str:
    return name if name.isidentifier() and len(name) < 100 else quote(name)


Fail = Callable[[int, str, str], InputError]
"""The error to raise about a joint, by its number, and one of its keys."""


def with_own_variables(
    joints: Sequence[Joint], given: Mapping[int, str], parameters: Collection[str], fail: Fail
) -> tuple[Joint, ...]:
    """The joints with their own variables taken out of the cells that sigma selects.

    `given` are the variables that rows name as their own. Of several names in a cell that are no `parameters`, the own
    one is that which no other row owns. Raises what `fail` gives where that leaves none, or a doubt.
    """
    owning = [j for j, joint in enumerate(joints, start=1) if joint.sigma in SELECTED and joint.kind != Kind.COUPLED]
    for j, variable in given.items():
        if refusal := _not_own(joints[j - 1], variable, j in owning):
            raise fail(j, "variable", refusal)
    new = {j: new_names(joints[j - 1].selected, parameters) for j in owning}
    owned = _owned(joints, new, given)
    split = list(joints)
    for j in owning:
        joint = joints[j - 1]
        if j not in owned:
            raise fail(j, SELECTED[joint.sigma], _no_own(joint, new[j], set(owned.values()), parameters))
        offset = offset_of(joint.selected, owned[j])
        if offset is None:
            raise fail(j, SELECTED[joint.sigma], not_alone(joint.selected, owned[j]))
        split[j - 1] = replace(joint.with_selected(offset), variable=owned[j])
    return tuple(split)


def new_names(cell: Formula, parameters: Collection[str]) -> list[str]:
    """Names in a cell that are not parameters, in the order in which they first occur."""
    found = cell.names.difference(parameters)
    return [word for word in dict.fromkeys(re.findall(r"[A-Za-z_]\w*", cell.text, re.ASCII)) if word in found]


def _owned(joints: Sequence[Joint], new: Mapping[int, list[str]], given: Mapping[int, str]) -> dict[int, str]:
    """Own variables by row: those given, those alone in their cells, and those that others leave over."""
    alone = {j: names[0] for j, names in new.items() if len(names) == 1}
    owned = {j: name for j, name in alone.items() if offset_of(joints[j - 1].selected, name) is not None}
    elsewhere = set(owned.values())
    owned |= {j: name for j, name in alone.items() if name not in elsewhere}
    owned |= given
    _leave_over(new, owned)
    return owned


def _leave_over(new: Mapping[int, list[str]], owned: dict[int, str]) -> None:
    """Add the variables of the rows in whose cells all names but one are owned by others."""
    left = {j: {*names} for j, names in new.items() if j not in owned}
    holding: dict[str, list[int]] = {}
    for j, names in left.items():
        for name in names:
            holding.setdefault(name, []).append(j)
    taken = [*dict.fromkeys(owned.values())]
    for name in taken:
        for j in holding.pop(name, ()):
            left[j].discard(name)
            if len(left[j]) == 1 and j not in owned:
                (owned[j],) = left[j]
                taken.append(owned[j])


def _no_own(joint: Joint, new: Sequence[str], taken: Collection[str], parameters: Collection[str]) -> str:
    """Why a row that needs a variable of its own has none."""
    column, other = SELECTED[joint.sigma], OTHER[joint.sigma]
    left = [name for name in new if name not in taken]
    if left:
        likely = [name for name in left if offset_of(joint.selected, name) is not None] or left
        named = f"{', '.join(left[:-1])} and {left[-1]}"
        new_ones = "both new" if len(left) == 2 else "all new"
        advice = f'write variable = "{likely[-1]}"; parameters are declared in [parameters]'
        return f"the cell holds {named}, {new_ones}: {advice}"
    if new:
        holds = f"the cell holds variables of other joints only ({', '.join(new)})"
        return f'{holds}: add one of its own, or write kind = "coupled"'
    what = f"no joint variable in {quote(getattr(joint, column))}, where sigma = {joint.sigma} expects it"
    elsewhere = sorted(getattr(joint, other).names.difference(parameters))
    if elsewhere:
        what += f"; {elsewhere[0]!r} stands in {other}, which is for sigma = {1 - joint.sigma}"
    return what


def _not_own(joint: Joint, variable: str, owns: bool) -> str:
    """Why a variable that a row names as its own cannot be; empty where it can."""
    if not owns:
        which = "a coupled joint" if joint.kind == Kind.COUPLED else "a fixed frame"
        return f"{which} has no variable of its own: leave it out"
    if variable not in joint.selected.names:
        return f"{quote(variable)} does not stand in {SELECTED[joint.sigma]} = {quote(joint.selected)}"
    return ""


FORMAT = Format(TOML, read, write)
