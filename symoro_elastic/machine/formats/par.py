"""The machine as a .par file of SYMORO, with `(*! key = {...} *)` lines for entries that the format lacks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import cells, with_cells, with_columns
from symoro_elastic.machine.formats.cells import formula
from symoro_elastic.machine.formats.central import about_origin
from symoro_elastic.machine.formats.files import UTF_8, WESTERN, name_of
from symoro_elastic.machine.formats.format import Format
from symoro_elastic.machine.formats.motions import motions_of, wanted_of
from symoro_elastic.machine.formats.own_variables import with_own_variables
from symoro_elastic.machine.formats.par_columns import Columns
from symoro_elastic.machine.formats.par_extensions import Declared, listed
from symoro_elastic.machine.formats.par_loops import read_loops
from symoro_elastic.machine.formats.par_names import Names
from symoro_elastic.machine.formats.par_order import renumbered
from symoro_elastic.machine.formats.par_syntax import EXTENDED, ParText, take_apart
from symoro_elastic.machine.formats.par_writing import kind_flags, layout, structure
from symoro_elastic.machine.formats.scenes import BESIDE, scene_of
from symoro_elastic.machine.formats.tables import Table
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Floating,
    Joint,
    Kind,
    Machine,
    Orientation,
)
from symoro_elastic.machine.names import did_you_mean, quoted
from symoro_elastic.machine.resolve import coordinates, resolve
from symoro_elastic.machine.scene import Scene


def read(text: str, source: str) -> Machine:
    """The machine in a .par text; raises `InputError`. Consistency is checked by `checks.check`."""
    found = take_apart(text, source)
    columns = Columns(found)
    scene, central, floating = _scene(found), _central_bodies(columns), _floating(columns)
    of_base = [formula for _, formula in cells(floating.body)] if floating else []
    names = Names(columns, [*of_base, *_formulas_of_extensions(columns, scene, central, source)])
    joints = _joints(columns, names, central)
    name, origin = _name(found)
    machine = Machine(
        name=name,
        name_origin=origin,
        joints=joints,
        loops=read_loops(columns, joints),
        parameters=names.parameters(),
        base=_base(columns),
        floating=floating,
        notes=(*found.comments, *_texts(found, "notes")),
        extras=_extras(columns, joints),
        source=source,
    )
    machine = _in_order(columns, machine)
    machine = replace(machine, scene=resolve(scene, machine)) if scene else machine
    beside = Table(_tables(found, BESIDE), source)
    return replace(machine, motions=motions_of(beside, machine), wanted=wanted_of(beside))


def write(machine: Machine) -> str:
    """The .par text that `read` reads back; parameters are listed only if needed to restore their order."""
    for declared in Declared:
        text = layout(machine, declared)
        try:
            again = read(text, machine.source)
        except InputError:
            continue
        if (again.parameters, again.joints, again.loops) == (machine.parameters, machine.joints, machine.loops):
            break
    return text


def _joints(columns: Columns, names: Names, central: Mapping[int, Body]) -> tuple[Joint, ...]:
    """The rows, coupled where their cells hold no variable of their own."""
    rows = range(1, columns.count + 1)
    joints = with_own_variables(
        [_joint(columns, j, j in names.variables) for j in rows],
        names.variables,
        {parameter.name for parameter in names.parameters()},
        lambda j, key, what: InputError(columns.source, columns.place(j, key), what),
    )
    return tuple(_with_central(columns, j, joint, central.get(j)) for j, joint in zip(rows, joints, strict=True))


def _joint(columns: Columns, j: int, owns: bool) -> Joint:
    """A row as written, its variable still in its cell."""
    sigma, kind = columns.whole("sigma", j, 0), columns.kind(j)
    if kind is Kind.PASSIVE and sigma in (0, 1) and not owns:
        kind = Kind.COUPLED
    bare = Joint(columns.names[j - 1], columns.whole("ant", j, 0), kind, sigma)
    return with_cells(bare, lambda cell, _: columns.cell(cell, j))


def _in_order(columns: Columns, machine: Machine) -> Machine:
    """The machine with its rows in the order that the file says, else in that of its lists."""
    order = columns.found.extensions.get("order")
    if order is None:
        return machine
    if not isinstance(order, list) or sorted(map(str, order)) != sorted(columns.names):
        raise columns.fail("order", f"must name each of the {columns.count} joints once")
    for j, joint in enumerate(machine.joints, start=1):
        if not joint.antecedent < j:
            raise InputError(columns.source, columns.place(j, "ant"), f"{joint.antecedent} must be a row above {j}")
    return renumbered(machine, [columns.numbers[name] for name in order])


def _base(columns: Columns) -> Base:
    return with_columns(Base(), lambda column, _: columns.base_vector(column.par[0]))


def _floating(columns: Columns) -> Floating | None:
    """The base that floats or is mobile; its orientation is a rotation matrix unless the file gives another."""
    orientation = columns.found.extensions.get("orientation", Orientation.ROTATION.value)
    if orientation not in tuple(Orientation):
        raise columns.fail("orientation", f"must be one of {', '.join(Orientation)}")
    if columns.known_of_base is None:
        if "orientation" in columns.found.extensions:
            raise columns.fail("orientation", "only a floating base has one: add is_floating = 1")
        return None
    body = with_cells(Body(), lambda cell, _: columns.base_formula(columns.of_base, cell.par))
    return Floating(Orientation(orientation), columns.known_of_base, body)


def _formulas_of_extensions(
    columns: Columns, scene: Scene | None, central: Mapping[int, Body], source: str
) -> Iterator[Formula]:
    for formulas in zip(*map(columns.extension, EXTENDED), strict=True):
        yield from formulas
    for body in central.values():
        yield from (*body.moments, *body.inertia)
    if scene:
        yield from scene.locked.values()
        yield from filter(None, scene.static.values())
        yield from coordinates(scene, source)


def _central_bodies(columns: Columns) -> dict[int, Body]:
    """Bodies given about their centre of mass."""
    table = columns.found.extensions.get("central") or {}
    if not isinstance(table, dict):
        raise columns.fail("central", "must be a table: {joint = {x, y, z, XX, XY, XZ, YY, YZ, ZZ}, ...}")
    bodies = {}
    for name, written in table.items():
        if name not in columns.numbers:
            raise columns.fail("central", f"no joint {quoted(name)}{did_you_mean(name, columns.names)}")
        j = columns.numbers[name]
        bodies[j] = _central_body(columns.formula("M", j), written, columns, j)
    return bodies


def _with_central(columns: Columns, j: int, joint: Joint, body: Body | None) -> Joint:
    """The joint with its body about the centre of mass, which must agree with the columns about the origin."""
    if body is None:
        return joint
    try:
        agree = _trees(about_origin(body)) == _trees(joint.body)
    except FormulaError as error:
        raise InputError(columns.source, columns.place(j, "central"), str(error)) from None
    if not agree:
        what = "does not agree with the columns XX to MZ: change both, or drop the line (*! central *)"
        raise InputError(columns.source, columns.place(j, "central"), what)
    return replace(joint, body=body)


def _central_body(mass: Formula, cells: Any, columns: Columns, j: int) -> Body:
    if not isinstance(cells, list) or len(cells) != 9 or not all(isinstance(cell, str) for cell in cells):
        raise InputError(columns.source, columns.place(j, "central"), "must be a list of 9: x y z XX XY XZ YY YZ ZZ")
    x, y, z, xx, xy, xz, yy, yz, zz = (formula(cell, columns.source, columns.place(j, "central")) for cell in cells)
    return Body(mass, (x, y, z), (xx, xy, xz, yy, yz, zz), central=True)


def _trees(body: Body) -> list[Any]:
    return [formula.tree for formula in (*body.moments, *body.inertia)]


def _extras(columns: Columns, joints: Sequence[Joint]) -> dict[str, str]:
    """Entries that no model uses: unused lists, and flags that differ from those of the kinds of joints."""
    found = columns.found
    extras = dict(columns.extension_table("extras"))
    for key in ("QP", "QDP", "GAM", "Z"):
        if key in found.lists:
            extras[key] = listed(found.lists[key])
    usual = [kind_flags(joint)[0] for joint in joints]
    if columns.lists.get("mu", usual) != usual:
        extras["mu"] = listed(found.lists["mu"])
    if found.numbers.get("Type", structure(joints)) != structure(joints):
        extras["Type"] = _type(found)
    unused = [
        "0" if joint.kind == Kind.ELASTIC else cell
        for joint, cell in zip(joints, found.lists.get("k", []), strict=False)
    ]
    if any(cell != "0" for cell in unused):
        extras["k"] = listed(unused)
    return extras


def _type(found: ParText) -> str:
    text = found.numbers["Type"]
    if text not in ("0", "1", "2"):
        raise InputError(found.source, "Type", f"{quoted(text)} must be 0 (chain), 1 (tree) or 2 (closed loops)")
    return text


def _name(found: ParText) -> tuple[str, str]:
    """The machine's name, and where it comes from unless it is given as such."""
    name = found.extensions.get("name")
    if name is not None and not isinstance(name, str):
        raise InputError(found.source, "(*! name *)", "must be one name")
    if name is not None:
        return name, ""
    instead = "give another by (*! name = ... *)"
    if found.robot.strip():
        return name_of(found.robot), f"it is made of Robotname = {quoted(found.robot)}, {instead}"
    return name_of(Path(found.source).stem), f"it is made of the name of the file, {instead}"


def _texts(found: ParText, key: str) -> tuple[str, ...]:
    texts = found.extensions.get(key, [])
    if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
        raise InputError(found.source, f"(*! {key} *)", 'must be a list of texts: {"one", "two"}')
    return tuple(texts)


def _tables(found: ParText, keys: Iterable[str]) -> dict[str, Any]:
    """The tables that some lines hold."""
    return {key: found.extensions[key] or {} for key in keys if key in found.extensions}


def _scene(found: ParText) -> Scene | None:
    if "scene" not in found.extensions:
        return None
    entries = found.extensions["scene"] or {}
    if not isinstance(entries, dict):
        raise InputError(found.source, "(*! scene *)", "must be a table: {models = {...}, ...}")
    entries = {key: value or {} if key in ("outputs", "locked") else value for key, value in entries.items()}
    for key in entries.keys() & {"gravity", "condense"}:
        entries[key] = {"true": True, "false": False}.get(str(entries[key]), entries[key])
    return scene_of(Table(entries, found.source, "scene"))


FORMAT = Format("SYMORO", (".par",), read, write, (UTF_8, WESTERN))
