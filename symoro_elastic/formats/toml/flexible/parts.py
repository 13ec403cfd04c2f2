"""Flexible parts of a machine file as ordinary rows: cells of six elastic degrees of freedom, and beams.

Rows are expanded as written, before they are read: a cell becomes at most six elastic rows and a fixed one of its name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.formats.robots.joint_tree import about_x, about_z
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.formats.toml.flexible.beams import END, HEADING, beam_of, rows_of
from symoro_elastic.formats.toml.flexible.bodies import HEADING as OF_FLEXIBLE
from symoro_elastic.formats.toml.flexible.bodies import (
    along_rail,
    bodies_of_files,
    body_of_file,
    rows_of_body,
    written_bodies,
)
from symoro_elastic.formats.toml.flexible.coupled_cells import CoupledCell, is_coupled, without_zeros
from symoro_elastic.formats.toml.flexible.modal_rows import (
    CARRIAGE,
    Guideway,
    Rows,
    along_beam,
    body_of_beam,
    rows_of_beam,
)
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.flexible import FlexibleBody
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.joints import SELECTED, Kind
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.names import did_you_mean, no_such, quote

Entries = dict[str, Any]
SIX = 6
"""The sigma of a cell: three slides along x, y, z, then turns about z, y, x."""
DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
"""Order of the six stiffnesses, and ends of the names of their rows."""
IN_SEQUENCE = (("x", 1, 1), ("y", 1, 2), ("z", 1, 0), ("rz", 0, 0), ("ry", 0, 2), ("rx", 0, 1))
"""Rows of a cell: direction, sigma, and the frame's axes: x y z, turned k times in the cycle x -> y -> z -> x."""
CYCLES: tuple[Entries, ...] = ({}, {"gamma": "pi/2", "alpha": "pi/2"}, {"alpha": "-pi/2", "theta": "-pi/2"})
"""Angles of a row whose axes are those of its antecedent, in a cycle turned 0, 1 and 2 times."""
GEOMETRY = ("gamma", "b", "alpha", "d", "theta", "r", "at", "in")
"""Keys of a row that place its frame."""
OF_CELL = ("stiffness", "damping", "neutral")
"""Keys of a spring with an entry for each direction."""
NOT_ON_CELL = ("motors", "friction", "drives", "limits")
"""Tables without a meaning for six variables at once."""
MOST_ALONG = 16
"""Modes of a body that carries a slide: each has a polynomial in six rows of it."""
NEAR = 1e-6
"""Part of a beam's length within which a point is at its end, or on its axis."""


class Slide(NamedTuple):
    """A row that slides along the body `on`, at `start` from its beginning where the row's variable is zero; m."""

    name: str
    on: str
    start: Formula
    length: float

    def doubts(self, limits: Limits, values: Mapping[str, float]) -> list[str]:
        """A warning if the limits let the slide leave the body, beyond which deflections are wrong."""
        here = f"{self.name} slides along {self.on}, which is {self.length:g} m long"
        position = limits.of(self.name).position
        if position is None:
            return [f"{here}: give its position in [limits], deflections beyond are wrong"]
        start = self.start.value(values)
        low, high = start + position.low, start + position.high
        is_within = -NEAR * self.length <= low and high <= (1 + NEAR) * self.length
        beyond = f"[limits] let it be at {low:g} to {high:g} m, where its deflections are wrong"
        return [] if is_within else [f"{here}: {beyond}"]


@dataclass(frozen=True)
class Part:
    """Rows that replace the row `name` of the file; rows on it move to `carrier`, by default the last new row.

    `sections` are new entries of tables by joint, where those of the file win: {} removes one.
    """

    name: str
    rows: tuple[Entries, ...]
    sections: Mapping[str, Mapping[str, Entries]] = field(default_factory=dict)
    carrier: str = ""
    slide: Slide | None = None

    @property
    def end(self) -> str:
        """Name of the new row that carries the rows and frames on the replaced row."""
        return self.carrier or str(self.rows[-1]["name"])


def beams_of(top: Table, values: Mapping[str, float]) -> tuple[Beam, ...]:
    """Read the beams of a file, with values of its parameters; raises `InputError`."""
    table = top.table(HEADING)
    rows = {row.text("name"): row for row in _rows_of_file(top)} if table.entries else {}
    for name in table.entries:
        if name not in rows:
            raise top.fail(HEADING, no_such("joint", name, rows))
        if rows[name].entries.get("kind") == Kind.CUT:
            raise top.fail(HEADING, f"{quote(name)} is a cut joint, which carries nothing: name a fixed row")
    return tuple(_beam(replace(table.table(name), place=f"beam {name}"), name, values) for name in table.entries)


def _beam(table: Table, name: str, values: Mapping[str, float]) -> Beam:
    """Read the beam in an entry whose rows can be generated; raises `InputError`."""
    try:
        beam = beam_of(table, name, values)
        _rows_of_beam(beam, values)
    except (FormulaError, ArithmeticError, np.linalg.LinAlgError) as error:
        what = f"numbers or formulas that are too large or too small: {error}"
        raise InputError(table.source, table.place, what) from None
    return beam


def _rows_of_beam(beam: Beam, values: Mapping[str, float]) -> Rows:
    return rows_of_beam(beam, values) if beam.modes else rows_of(beam)


def with_rows_of_parts(
    top: Table, beams: Iterable[Beam], values: Mapping[str, float]
) -> tuple[Table, tuple[FlexibleBody, ...], list[str], list[Slide]]:
    """Replace six-degree cells, beams and modal bodies of a file by ordinary rows in its top table.

    With it come the bodies that bend by modes, remarks, and slides along them. Raises `InputError`.
    """
    bodies = bodies_of_files(top)
    by_row = {beam.name: _rows_of_beam(beam, values) for beam in beams}
    for name in by_row.keys() & bodies.keys():
        raise top.fail(OF_FLEXIBLE, f"{quote(name)} has a beam: give one of them")
    by_row |= {name: rows_of_body(name, body) for name, body in bodies.items()}
    flexible = [body_of_beam(beam, values) for beam in beams if beam.modes]
    flexible += [body_of_file(name, body) for name, body in bodies.items()]
    for bent in flexible:
        if bent.joint in top.table("bodies").entries:
            raise top.fail("bodies", f"{bent.joint} has the inertia of a body by modes: leave it out")
    flexible += written_bodies(top)
    remarks = [f"beam {beam.name}: {doubt}" for beam in beams for doubt in beam.doubts]
    remarks += [f"flexible {name}: {doubt}" for name, body in bodies.items() for doubt in body.doubts]
    if not by_row and not any(_is_cell(row) or "along" in row.entries for row in top.tables("joints")):
        return top, tuple(flexible), remarks, []
    ways = {beam.name: along_beam(beam, values) for beam in beams if beam.modes}
    ways |= {f"{name}_{key}": along_rail(name, key, body) for name, body in bodies.items() for key in body.rails}
    parts = [
        _with_rows(_part(top, row, ways), by_row.get(name), name in bodies)
        for row in _rows_of_file(top)
        for name in (row.text("name"),)
    ]
    ends = {part.name: part.end for part in parts}
    slides = [part.slide for part in parts if part.slide]
    frames = {slide.name: {"on": ends[slide.name]} for slide in slides}
    frames |= {name: _on_end(entry, ends) for name, entry in top.table("frames").entries.items()}
    new = {"joints": _rows(parts), **({"frames": frames} if frames else {}), **_sections(top, parts)}
    return replace(top, entries={**top.entries, **new}), tuple(flexible), remarks, slides


def _on_end(frame: Any, ends: Mapping[str, str]) -> Any:
    """Return a frame, moved to the end of the beam if its row is replaced by a beam."""
    on = frame.get("on") if isinstance(frame, dict) else None
    return {**frame, "on": ends.get(on, on)} if isinstance(on, str) else frame


def _with_rows(part: Part, below: Rows | None, carries: bool) -> Part:
    """Return a part with the rows `below` appended to its last row, which still `carries` other rows or not."""
    if below is None:
        return part
    rows, sections = below
    names = part.sections.keys() | sections.keys()
    merged = {name: {**part.sections.get(name, {}), **sections.get(name, {})} for name in names}
    return replace(part, rows=(*part.rows, *rows), sections=merged, carrier=part.end if carries else "")


def _rows_of_file(top: Table) -> list[Table]:
    return [with_name_in_place(row, j) for j, row in enumerate(top.tables("joints"), start=1)]


def with_name_in_place(row: Table, j: int) -> Table:
    """Table of a row whose place in messages has the joint's name."""
    name = replace(row, place=f"joint {j}").text("name")
    label = name if name.isidentifier() and len(name) < 100 else quote(name)
    return replace(row, place=f"joint {j} ({label})")


def _is_cell(row: Table) -> bool:
    return row.entries.get("sigma") == SIX


def _part(top: Table, row: Table, ways: Mapping[str, Guideway]) -> Part:
    if "along" in row.entries:
        return _slide(top, row, ways)
    return _cell(top, row) if _is_cell(row) else Part(row.text("name"), (row.entries,))


def _slide(top: Table, row: Table, ways: Mapping[str, Guideway]) -> Part:
    """Rows of a slide along a beam by modes or a rail; its body follows deflection and slope there."""
    name, on = row.text("name"), row.text("along")
    _refuse_way(row, on, ways)
    if row.entries.get("sigma") != 1 or row.entries.get("kind") not in (Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE):
        raise row.fail("sigma", "a row along a body slides by its own variable: write sigma = 1, and kind motor")
    for key in (*GEOMETRY, "axis", "antecedent"):
        if key in row.entries:
            raise row.fail(key, f"follows from {on}: leave it out; from is the distance from its beginning")
    variable = row.text("variable", name)
    start = replace(row, units="m").formula("from")
    place = variable if start.is_zero else f"{start} + {variable}"
    own = {key: row.entries[key] for key in ("kind", "sigma")} | {"variable": variable}
    rows = ways[on].rows(name, own, place)
    body = top.table("bodies").entries.get(name)
    moved = {"bodies": {name: {}, name + CARRIAGE: body}} if isinstance(body, dict) else {}
    return Part(name, tuple(rows), moved, slide=Slide(name, on, start, ways[on].length))


def _refuse_way(row: Table, on: str, ways: Mapping[str, Guideway]) -> None:
    """Raise `InputError` for a body along which no row can slide."""
    if on not in ways:
        what = f"{quote(on)} is no beam by modes and no rail of a body{did_you_mean(on, ways)}"
        raise row.fail("along", f"{what}: write modes = 3 in its entry of [{HEADING}], or BODY_RAIL")
    is_stiffened = ways[on].is_stiffened
    if is_stiffened or len(ways[on].labels) > MOST_ALONG:
        what = "stiffening, which is not offered with a slide along it: leave it out"
        many = f"{len(ways[on].labels)} modes, more than {MOST_ALONG}: leave out those above a frequency by keep"
        raise row.fail("along", f"{quote(on)} has {what if is_stiffened else many}")


def _rows(parts: Iterable[Part]) -> list[Entries]:
    """Rows of all parts, with antecedents as numbers in the expanded table."""
    numbers, names, rows = [0], dict[str, str](), list[Entries]()
    for part in parts:
        first, *others = part.rows
        for key in ("antecedent", "in"):
            value = first.get(key, len(numbers) - 1 if key == "antecedent" else None)
            if isinstance(value, int) and 0 <= value < len(numbers):
                first = {**first, key: numbers[value]}
            elif isinstance(value, str):
                first = {**first, key: names.get(value, value)}
        names[part.name] = part.end
        numbers.append(len(rows) + 1 + [row["name"] for row in part.rows].index(part.end))
        rows += [first, *others]
    return rows


def _sections(top: Table, parts: Iterable[Part]) -> Mapping[str, Entries]:
    """Tables by joint, with the entries of parts added."""
    tables: dict[str, Entries] = {}
    for part in parts:
        for section, entries in part.sections.items():
            table = tables.setdefault(section, dict(top.table(section).entries))
            for name, entry in entries.items():
                own = table.pop(name, {})
                table.update({name: {**entry, **own} if isinstance(own, dict) else own} if entry else {})
    return tables


def _cell(top: Table, row: Table) -> Part:
    """Six elastic rows at one point, massless in between: exact rotations in sequence, and a frame at their end."""
    name = row.text("name")
    entry, lists = _springs(top, row)
    if is_coupled(lists):
        return _coupled_cell(row, CoupledCell.of(entry, lists))
    stiffness, *others = lists.values()
    is_held = [isinstance(x, Number) and "inf" in x for x in stiffness]
    rows = [{"name": f"{name}_seat", "kind": "fixed", **_seat(row)}] if _seat(row) else []
    springs: dict[str, Entries] = {name: {}}
    axes = 0
    for direction, sigma, turned in IN_SEQUENCE:
        k = DIRECTIONS.index(direction)
        if is_held[k]:
            continue
        label = f"{name}_{direction}"
        angles = CYCLES[(turned - axes) % 3]
        own = {SELECTED[sigma]: label + " - pi/2" * (sigma == 0 and "theta" in angles)}
        rows.append({"name": label, "kind": "elastic", "sigma": sigma, **angles, **own})
        springs[label] = {key: values[k] for key, values in zip(OF_CELL, (stiffness, *others), strict=True)}
        axes = turned
    rows.append({"name": name, "kind": "fixed", "sigma": 2, **CYCLES[-axes % 3]})
    first = {"antecedent": row.entries["antecedent"]} if "antecedent" in row.entries else {}
    return Part(name, ({**rows[0], **first}, *rows[1:]), {"springs": springs})


def _coupled_cell(row: Table, cell: CoupledCell) -> Part:
    """Rows of a cell with coupled springs: its coordinates, and coupled rows that follow them."""
    name, seat = row.text("name"), row.text("name") + "_seat"
    labels = [f"{name}_e{k}" for k in range(1, len(cell.free) + 1)]
    first = {"antecedent": row.entries["antecedent"]} if "antecedent" in row.entries else {}
    rows = [{"name": seat, "kind": "fixed", **_seat(row), **first}]
    for label, leading in zip(labels, cell.leading, strict=True):
        sigma = int(leading < 3)
        rows.append({"name": label, "antecedent": seat, "kind": "elastic", "sigma": sigma, SELECTED[sigma]: label})
    axes, below = 0, {"antecedent": seat}
    for direction, sigma, turned in IN_SEQUENCE:
        if (k := DIRECTIONS.index(direction)) in cell.free:
            angles = CYCLES[(turned - axes) % 3]
            own = {SELECTED[sigma]: cell.motion(k, labels) + " - pi/2" * (sigma == 0 and "theta" in angles)}
            rows.append({"name": f"{name}_{direction}", "kind": "coupled", "sigma": sigma, **angles, **own, **below})
            axes, below = turned, {}
    rows.append({"name": name, "kind": "fixed", "sigma": 2, **CYCLES[-axes % 3]})
    return Part(name, tuple(rows), {"springs": {name: {}, **cell.springs(labels)}})


def _seat(row: Table) -> Entries:
    return {key: row.entries[key] for key in GEOMETRY if key in row.entries and row.entries[key] != 0}


def _springs(top: Table, row: Table) -> tuple[Table, dict[str, list[Any]]]:
    """Entry of a spring cell, and its stiffnesses, dampings and neutral positions by direction, as written."""
    name = row.text("name")
    if row.entries.get("kind") != Kind.ELASTIC:
        raise row.fail("sigma", f'6 is a cell of six springs: write kind = "{Kind.ELASTIC}"')
    for key in ("axis", "variable"):
        if key in row.entries:
            what = "a cell of six springs has the axes of the frame that it is in, and six variables: leave it out"
            raise row.fail(key, what)
    for section in NOT_ON_CELL:
        if name in top.table(section).entries:
            what = "a cell of six springs has stiffness and damping only: give this to a row of its own"
            raise row.fail(section, what)
    entry = replace(top.table("springs").table(name), place=row.place)
    if "stiffness" not in entry.entries:
        what = f"is missing: write {name} = {{ stiffness = [kx, ky, kz, krx, kry, krz] }} in [springs]"
        raise row.fail("stiffness", what)
    for key in entry.entries:
        if key not in OF_CELL:
            raise row.fail(key, f"a cell of six springs has {', '.join(OF_CELL)} only")
    lists = {key: without_zeros(entry, key, _six(entry, key)) for key in OF_CELL}
    if all(isinstance(x, Number) and "inf" in x for x in lists["stiffness"]):
        raise row.fail("stiffness", 'all directions are held: write kind = "fixed", without sigma and spring')
    return entry, lists


def _six(entry: Table, key: str) -> list[Any]:
    """The six entries of a key, as written; zeros where it is missing."""
    values = entry.entries.get(key, [0] * SIX)
    if not isinstance(values, list) or len(values) != SIX or (key == "neutral" and is_coupled({key: values})):
        raise entry.fail(key, "must be a list of six: along x, y, z, about x, y, z; inf where a direction is held")
    return values


def refuse_inside(machine: Machine, beams: Iterable[Beam], values: Mapping[str, float]) -> None:
    """Raise `InputError` for a row or a named frame at a point inside a beam, which carries at its end only."""
    for beam in beams:
        end = next(j for j, joint in enumerate(machine.joints, start=1) if joint.name == beam.name + END)
        length = Formula.parse(beam.length).known_value(values) or 0.0
        axis = "xyz".index(beam.along[-1])
        for place, point in _points_beyond(machine, end, values):
            along = -point[axis] if beam.along[0] != "-" else point[axis]
            across = np.delete(point, axis)
            if NEAR * length < along < (1 - NEAR) * length and np.hypot(*across) < NEAR * length:
                what = f"it is {along:g} m before the end of the beam {beam.name}, which carries at its end only"
                raise machine.error(place, f"{what}: write two beams, with a fixed row between")


def _points_beyond(machine: Machine, end: int, values: Mapping[str, float]) -> Iterator[tuple[str, Array]]:
    """Rows and frames carried by a row, directly or by fixed rows, with their points in its frame, if known."""
    frames = {end: Placement()}
    for j, joint in enumerate(machine.joints, start=1):
        placement = place_of_row(joint, values) if joint.antecedent in frames else None
        if placement is None:
            continue
        frame = frames[joint.antecedent] * placement
        if joint.kind is Kind.FIXED:
            frames[j] = frame
        yield f"joint {j} ({joint.name}), antecedent", frame.translation
    rows = {machine.joint(j).name: frame for j, frame in frames.items()}
    for named in machine.frames:
        point = [cell.known_value(values) for cell in named.at]
        if named.on in rows and None not in point:
            frame = rows[named.on]
            yield f"frame {named.name}, on", frame.translation + frame.rotation @ np.array(point)


def place_of_row(joint: Joint, values: Mapping[str, float]) -> Placement | None:
    """Placement of a row in its antecedent; None if a cell has no value."""
    cells = [getattr(joint, key).known_value(values) for key in GEOMETRY[:6]]
    if None in cells:
        return None
    gamma, b, alpha, d, theta, r = (cell or 0.0 for cell in cells)
    return about_z(gamma, b) * about_x(alpha, d) * about_z(theta, r)
