"""The machine of a TOML file: one line per joint, as in the table of geometric parameters."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from symoro_elastic.formats.files import load_text, name_of
from symoro_elastic.formats.format import Format
from symoro_elastic.formats.joint_cells import OTHER, SELECTED, no_variable, not_alone, offset_of, rows_by_name
from symoro_elastic.formats.toml import keys
from symoro_elastic.formats.toml.catalogue import with_catalogue
from symoro_elastic.formats.toml.drives import drives_of
from symoro_elastic.formats.toml.flexible.auto_joints import with_chosen_joints
from symoro_elastic.formats.toml.flexible.parts import beams_of, refuse_inside, with_name_in_place, with_rows_of_parts
from symoro_elastic.formats.toml.key import Key
from symoro_elastic.formats.toml.keys import SCENE
from symoro_elastic.formats.toml.limits import limits_of
from symoro_elastic.formats.toml.motions import motions_of, wanted_of
from symoro_elastic.formats.toml.tables import Table, load
from symoro_elastic.formats.toml.within import KEYS, within_of
from symoro_elastic.formats.toml.writing import BASE_PARAMETERS, GROUPED, write
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import OF_ROTORS, Column, Values, declared_columns, with_columns
from symoro_elastic.machine.described import DescribedMachine, Origin, Request
from symoro_elastic.machine.format_names import TOML
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import (
    NO_VECTOR,
    Base,
    Body,
    Floating,
    Joint,
    Kind,
    KnownOfBase,
    Machine,
    NamedFrame,
    Orientation,
    Parameter,
    known_values,
)
from symoro_elastic.machine.names import no_such, quote, undeclared
from symoro_elastic.machine.resolve import Models, resolve
from symoro_elastic.machine.scene import Scene

if TYPE_CHECKING:
    from symoro_elastic.formats.toml.axes import Place

WEIGHTLESS = "no gravity is given, so bodies have no weight: write gravity = [0, 0, -9.81], or [0, 0, 0] if meant"
NAME_OF_FILE = 'it is made of the name of the file, give another by name = "..."'
__all__ = ["FORMAT", "read", "write"]
BESIDE = ("motion", "wanted")
"""Tables of a scene file in addition to its scene."""


def read(text: str, source: str) -> DescribedMachine:
    """Read the machine in a TOML text; raises `InputError`. Consistency is checked by `checks.check`."""
    return machine_of(load(text, source))


def machine_of(top: Table) -> DescribedMachine:
    """Read the machine in the top table of a file, as `read` does."""
    machine = _machine_of(top)
    chosen, choices = with_chosen_joints(top, machine, known_values(machine.parameters))
    if not choices:
        return machine
    machine = _machine_of(chosen)
    beams = (replace(beam, choice=choices.get(beam.name, "")) for beam in machine.origin.beams)
    return replace(machine, origin=replace(machine.origin, beams=tuple(beams)))


def _machine_of(top: Table) -> DescribedMachine:
    """Read the machine in the top table of a file, with 4 joints for beams with joints = "auto"."""
    top, catalogue_springs = with_catalogue(top.only(keys.MACHINE.names))
    source = top.source
    listed = keys.PARAMETERS.type.read(top, keys.PARAMETERS.name)
    parameters = tuple(Parameter(name, *keys.PARAMETER.read(listed, name)) for name in listed.entries)
    values = known_values(parameters)
    beams = beams_of(top, values)
    top, flexible, remarks, slides = with_rows_of_parts(top, beams, values)
    joints, frames = _joints_and_frames(top, {parameter.name for parameter in parameters})
    floating = _floating(top.table("base"))
    extras = keys.EXTRAS.read(top)
    machine = DescribedMachine(
        name=keys.FILE_NAME.read(top, name_of(Path(source).stem)),
        joints=joints,
        loops=loops_of(top, joints),
        frames=frames,
        flexible=flexible,
        parameters=parameters,
        base=_base(top),
        floating=floating,
        source=source,
        is_grouped=extras.get(BASE_PARAMETERS) == GROUPED,
        origin=Origin(
            notes=keys.NOTES.read(top),
            extras={key: x for key, x in extras.items() if (key, x) != (BASE_PARAMETERS, GROUPED)},
            of_name="" if keys.FILE_NAME.name in top.entries else NAME_OF_FILE,
            remarks=(
                *((WEIGHTLESS,) if keys.GRAVITY.name not in top.entries and _has_masses(joints, floating) else ()),
                *remarks,
            ),
            beams=beams,
            catalogue_springs=catalogue_springs,
        ),
    )
    refuse_inside(machine, beams, values)
    machine = replace(machine, limits=limits_of(top, machine, listed), drives=drives_of(top, machine))
    doubts = [doubt for slide in slides for doubt in slide.doubts(machine.limits, values)]
    machine = replace(machine, origin=replace(machine.origin, remarks=(*machine.origin.remarks, *doubts)))
    scene = resolve(scene_of(top.table("scene")), machine) if "scene" in top.entries else None
    return replace(machine, asked=Request(scene, motions_of(top, machine), wanted_of(top)))


def _has_masses(joints: Sequence[Joint], floating: Floating | None) -> bool:
    bodies = [joint.body for joint in joints] + ([floating.body] if floating else [])
    return any(not cell.is_zero for body in bodies for cell in (body.mass, *body.moments))


def _frames(top: Table) -> tuple[NamedFrame, ...]:
    table = top.table("frames")
    entries = ((name, replace(table.table(name), place=f"frame {_label(name)}")) for name in table.entries)
    return tuple(
        with_columns(NamedFrame(name, keys.ON.read(entry.only(keys.FRAMES.names))), _reader(entry, "frames"))
        for name, entry in entries
    )


def _base(top: Table) -> Base:
    table = top.table("base").only(keys.BASE.names)
    return replace(with_columns(Base(), _reader(table, "base")), gravity=keys.GRAVITY.read(top))


def _floating(table: Table) -> Floating | None:
    if keys.FLOATING.name not in table.entries:
        for key in (keys.KNOWN.name, keys.OF_BASE.name, *(key.name for key in keys.DAMPING_OF_BASE)):
            if key in table.entries:
                raise table.fail(key, 'only a floating base has one: add floating = "rotation"')
        return None
    body = body_of(table.table(keys.OF_BASE.name))
    damping = (key.read(table) for key in keys.DAMPING_OF_BASE)
    return Floating(Orientation(keys.FLOATING.read(table)), KnownOfBase(keys.KNOWN.read(table)), body, *damping)


def _joints_and_frames(top: Table, parameters: set[str]) -> tuple[tuple[Joint, ...], tuple[NamedFrame, ...]]:
    rows = [with_name_in_place(row, j) for j, row in enumerate(top.tables("joints"), start=1)]
    numbers: dict[str, int] = {}
    for j, row in enumerate(rows, start=1):
        numbers.setdefault(row.text("name"), j)
    joints = [_joint(row, j, numbers, parameters) for j, row in enumerate(rows, start=1)]
    own = {j: keys.VARIABLE.read(row) for j, row in enumerate(rows, start=1) if keys.VARIABLE.name in row.entries}

    def fail(j: int, key: str, what: str) -> InputError:
        return rows[j - 1].fail(key, what)

    joints = [*with_own_variables(joints, own, parameters, fail)]
    body_axes: dict[int, str] = {}
    for section in keys.OF_JOINTS:
        for name in top.table(section).entries:
            if name not in numbers:
                raise InputError(top.source, section, no_such("joint", name, numbers))
            j = numbers[name]
            entry = replace(top.table(section).table(name), place=rows[j - 1].place)
            if section == "bodies" and (axes := keys.BODY_AXES.read(entry.only(keys.BODY.names))):
                body_axes[j] = axes
                entry = entry.without(keys.BODY_AXES.name)
            joints[j - 1] = _with_section(joints[j - 1], section, entry)
    frames = _frames(top)
    if not body_axes and not any(_is_by_axis(row) for row in rows):
        return tuple(joints), frames
    return _by_axes(rows, joints, frames, (numbers, parameters, body_axes))


Names = tuple[Mapping[str, int], Collection[str], Mapping[int, str]]
"""Rows by name, parameters, and axes of bodies by row."""


def _by_axes(
    rows: Sequence[Table], joints: Sequence[Joint], frames: Sequence[NamedFrame], names: Names
) -> tuple[tuple[Joint, ...], tuple[NamedFrame, ...]]:
    """Convert joints given by axis and point to rows of geometric parameters, and the frames on them."""
    from symoro_elastic.formats.toml.axes import TableByAxes, fault_of

    numbers, parameters, body_axes = names
    variables = [joint.variable for joint in joints if joint.variable]
    places = {}
    for j, (row, joint) in enumerate(zip(rows, joints, strict=True), start=1):
        if not _is_by_axis(row):
            continue
        places[j] = _place(row, j, numbers, parameters)
        if joint.kind is Kind.COUPLED and (fault := fault_of(joint.selected, variables)):
            raise row.fail(SELECTED[joint.sigma], fault)
    table = TableByAxes(joints, places, body_axes, lambda j, key, what: rows[j - 1].fail(key, what))
    return table.rows, tuple(table.with_frame(frame, rows[0].source) for frame in frames)


def _is_by_axis(row: Table) -> bool:
    return any(key.name in row.entries for key in keys.BY_AXIS)


def _place(row: Table, j: int, numbers: Mapping[str, int], parameters: Collection[str]) -> Place:
    """Read the axis and the point of a row."""
    from symoro_elastic.formats.toml.axes import Place, fault_of

    within = _row(row, keys.IN, numbers, 0)
    if not 0 <= within < j:
        raise row.fail(
            keys.IN.name, f"row {within} is not above this row: axis and at are given in a frame of a row above, or 0"
        )
    at = keys.AT.read(row, NO_VECTOR)
    for cell in at:
        if unknown := sorted(cell.names.difference(parameters)):
            raise row.fail(keys.AT.name, undeclared(unknown[0], parameters))
        if fault := fault_of(cell):
            raise row.fail(keys.AT.name, fault)
    return Place(keys.AXIS.read(row) if keys.AXIS.name in row.entries else None, at, within)


def _joint(row: Table, j: int, numbers: dict[str, int], parameters: Collection[str]) -> Joint:
    """Read the joint of a row; its variable is in the cell that sigma selects, as written or by axis."""
    row.only(keys.JOINTS.names)
    kind = Kind(keys.KIND.read(row))
    if keys.SIGMA.name not in row.entries and kind != Kind.FIXED:
        raise row.fail("sigma", "is missing: 0 revolute, 1 prismatic, 2 fixed frame")
    joint = Joint(keys.NAME.read(row), _row(row, keys.ANTECEDENT, numbers, j - 1), kind, keys.SIGMA.read(row, 2))
    if not _is_by_axis(row):
        return with_columns(joint, _reader(row, "joints"))
    own = SELECTED.get(joint.sigma, "")
    for column in declared_columns(Joint, "joints"):
        if column.key in row.entries and (kind != Kind.COUPLED or column.key != own):
            by = next(key.name for key in keys.BY_AXIS if key.name in row.entries)
            way = "leave it out (variable names its variable)" if column.key == own else f"leave it out, or {by}"
            raise row.fail(column.key, f"{by} says where the joint is at position zero: {way}")
    if own and keys.AXIS.name not in row.entries and kind != Kind.CUT:
        raise row.fail(keys.AXIS.name, 'is missing: write axis = "x", "y", "z", "-x" ... or a unit vector')
    if kind == Kind.COUPLED:
        return with_columns(joint, _reader(row, "joints"))
    return joint.with_selected(_variable_cell(row, j, parameters)) if own else joint


def _variable_cell(row: Table, j: int, parameters: Collection[str]) -> Formula:
    """Cell of a joint that is given by its axis: the joint variable alone."""
    name = keys.VARIABLE.read(row, f"q{j}")
    cell = row.cell(name, keys.VARIABLE.name)
    if cell.tree[0] != "name":
        raise row.fail(keys.VARIABLE.name, f"{quote(name)} is not a name")
    if name in parameters:
        raise row.fail(keys.VARIABLE.name, f"{quote(name)} is a parameter: give the joint another variable")
    return cell


def _with_section(joint: Joint, section: str, table: Table) -> Joint:
    """Return the joint with the columns of a section read from its table."""
    if section == "bodies":
        return replace(joint, body=body_of(table))
    table.only(keys.section_of(section, Joint).names)
    return with_columns(joint, _reader(table, section, joint.sigma))


def _reader(table: Table, section: str, sigma: int | None = None) -> Callable[[Column, Values], Values]:
    """Return a function that reads the columns of a section from the table; other columns are unchanged.

    `sigma` is that of the joint; a rotor turns where the joint slides, too.
    """

    def read(column: Column, values: Values) -> Values:
        if column.section != section:
            return values
        key = keys.key_of(column)
        if sigma is not None and column.dimension not in OF_ROTORS:
            key = replace(key, unit=column.dimension.units[int(sigma == 1)])
        value = key.read(table)
        return value if column.parts else (value,)

    return read


def body_of(table: Table) -> Body:
    """Read the body in a table, about its centre of mass or about the origin of the frame."""
    table.only([key.name for key in keys.OF_BODY])
    central, about_origin = (
        [key.name for key in form[1:] if key.name in table.entries] for form in (keys.ABOUT_CENTER, keys.ABOUT_ORIGIN)
    )
    if central and about_origin:
        what = "are two alternatives: give center_of_mass and inertia, or first_moments and inertia_at_origin"
        raise table.fail(f"{central[0]}, {about_origin[0]}", what)
    return with_columns(Body(central=bool(central)), _reader(table, "bodies"))


def loops_of(top: Table, joints: Sequence[Joint]) -> tuple[Loop, ...]:
    """Read the loops of a file with these joints; raises `InputError`."""
    rows = {joint.name: j for j, joint in reversed([*enumerate(joints, start=1)])}
    by_variable = {joint.variable: joint.name for joint in joints if joint.variable}
    table = top.table("loops")
    entries = {name: replace(table.table(name), place=f"loop {_label(name)}") for name in table.entries}
    return tuple(_loop(name, entry.only(keys.LOOPS.names), rows, by_variable) for name, entry in entries.items())


def _loop(name: str, entry: Table, rows: Mapping[str, int], by_variable: Mapping[str, str]) -> Loop:
    dependent = keys.DEPENDENT.read(entry)
    for text in dependent:
        if text not in rows and text not in by_variable:
            raise entry.fail(keys.DEPENDENT.name, no_such("joint", text, [*rows, *by_variable]))
    return Loop(
        name=name,
        cut=_row(entry, keys.CUT, rows),
        meets=_row(entry, keys.MEETS, rows),
        closes=Closing(keys.CLOSES.read(entry)),
        dependent=tuple(x if x in rows else by_variable[x] for x in dependent),
        start=keys.START.read(entry),
    )


def _row(entry: Table, key: Key, rows: Mapping[str, int], default: int | None = None) -> int:
    """Number of the row that a key refers to, by name or by number."""
    name = key.read(entry, default)
    if isinstance(name, int):
        return name
    if name not in rows:
        raise entry.fail(key.name, no_such("joint", name, rows))
    return rows[name]


def _label(name: str) -> str:
    return name if name.isidentifier() and len(name) < 100 else quote(name)


Fail = Callable[[int, str, str], InputError]
"""The error to raise about a joint, by its number, and one of its keys."""


def with_own_variables(
    joints: Sequence[Joint], chosen: Mapping[int, str], parameters: Collection[str], fail: Fail
) -> tuple[Joint, ...]:
    """Return the joints with their variables removed from the cells that sigma selects.

    `chosen` are the variables that rows name as their own. Of several names in a cell that are no `parameters`, the own
    one is that which no other row owns. Raises what `fail` gives where that leaves none, or a doubt.
    """
    owning = [j for j, joint in enumerate(joints, start=1) if joint.sigma in SELECTED and joint.kind != Kind.COUPLED]
    for j, variable in chosen.items():
        if refusal := _not_own(joints[j - 1], variable, j in owning):
            raise fail(j, "variable", refusal)
    new = {j: new_names(joints[j - 1].selected, parameters) for j in owning}
    owned = _own_variables(joints, new, chosen)
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
    unknown = cell.names.difference(parameters)
    return [word for word in dict.fromkeys(re.findall(r"[A-Za-z_]\w*", cell.text, re.ASCII)) if word in unknown]


def _own_variables(joints: Sequence[Joint], new: Mapping[int, list[str]], chosen: Mapping[int, str]) -> dict[int, str]:
    """Joint variables by row: stated ones, single names in cells, and the only remaining names."""
    alone = {j: names[0] for j, names in new.items() if len(names) == 1}
    owned = {j: name for j, name in alone.items() if offset_of(joints[j - 1].selected, name) is not None}
    elsewhere = set(owned.values())
    owned |= {j: name for j, name in alone.items() if name not in elsewhere}
    owned |= chosen
    _leave_over(new, owned)
    return owned


def _leave_over(new: Mapping[int, list[str]], owned: dict[int, str]) -> None:
    """Assign variables to rows whose cells have a single name that no other row owns, repeatedly."""
    candidates = {j: {*names} for j, names in new.items() if j not in owned}
    holding = rows_by_name(candidates)
    used = [*dict.fromkeys(owned.values())]
    for name in used:
        for j in holding.pop(name, ()):
            candidates[j].discard(name)
            if len(candidates[j]) == 1 and j not in owned:
                (owned[j],) = candidates[j]
                used.append(owned[j])


def _no_own(joint: Joint, new: Sequence[str], used: Collection[str], parameters: Collection[str]) -> str:
    """Return why a row that needs a variable has none."""
    free = [name for name in new if name not in used]
    if free:
        likely = [name for name in free if offset_of(joint.selected, name) is not None] or free
        named = f"{', '.join(free[:-1])} and {free[-1]}"
        new_ones = "both new" if len(free) == 2 else "all new"
        advice = f'write variable = "{likely[-1]}"; parameters are declared in [parameters]'
        return f"the cell holds {named}, {new_ones}: {advice}"
    if new:
        holds = f"the cell holds variables of other joints only ({', '.join(new)})"
        return f'{holds}: add one of its own, or write kind = "coupled"'
    elsewhere = getattr(joint, OTHER[joint.sigma]).names.difference(parameters)
    return no_variable(joint.selected, joint.sigma, elsewhere)


def _not_own(joint: Joint, variable: str, owns: bool) -> str:
    """Return why a row cannot have the stated variable; empty if it can."""
    if not owns:
        which = "a coupled joint" if joint.kind == Kind.COUPLED else "a fixed frame"
        return f"{which} has no variable of its own: leave it out"
    if variable not in joint.selected.names:
        return f"{quote(variable)} does not occur in {SELECTED[joint.sigma]} = {quote(joint.selected)}"
    return ""


FORMAT = Format(TOML, read, write)


def read_scene(path: str | Path, machine: Machine, models: Models | None = None) -> Scene:
    """Read the scene in a TOML file, with names resolved in `machine`; raises `InputError`.

    Its keys stand under [scene] or at the top; tables of motions beside it are left to `read_motions`.
    """
    return scene_in(load(load_text(path), str(path)), machine, models)


def scene_in(top: Table, machine: Machine, models: Models | None = None) -> Scene:
    """Read the scene in the top table of a file, as `read_scene` does."""
    source, top = top.source, replace(top, entries={key: x for key, x in top.entries.items() if key not in BESIDE})
    if "scene" in top.entries:
        top = top.only(("scene",)).table("scene")
    return resolve(scene_of(top), machine, models, source)


def scene_of(table: Table) -> Scene:
    """Read the scene in a table, with names as written."""
    entries = SCENE.within(table)
    within = within_of(entries)
    return Scene(**{key: x for key, x in entries.items() if key not in KEYS}, within=within)
