"""Tables of machine elements by numbers of catalogues, which become the stiffnesses of elastic rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from symoro_elastic.formats.toml.flexible import DIRECTIONS, SIX
from symoro_elastic.formats.toml.key import (
    FORMULA,
    NOT_NEGATIVE,
    VECTOR,
    WHOLE,
    Key,
    Section,
    Type,
    one_of,
    reference_to,
)
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.machine import catalogue
from symoro_elastic.machine.catalogue import CatalogueSpring, Element, Stiffness
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.joints import Kind
from symoro_elastic.machine.machine import NO_VECTOR
from symoro_elastic.machine.names import did_you_mean, quote

Cells = Mapping[str, Any]
HELD = Number("inf")
"""Stiffness of a direction in which a cell is held."""
AXES = ("x", "y", "z")


def _pair(table: Table, key: str) -> tuple[Formula, ...]:
    return table.formulas(key, (2,))


def _some(table: Table, key: str) -> tuple[Formula, ...]:
    values = table.entries[key]
    return tuple(table.cell(x, key) for x in values) if isinstance(values, list) else (table.formula(key),)


def _list(least: int, most: int) -> Mapping[str, Any]:
    return {"type": "array", "items": reference_to("formula"), "minItems": least, "maxItems": most}


PAIR = Type("2 numbers or formulas", _list(2, 2), _pair)
SOME = Type("number or formula, or list of them", {"anyOf": [NOT_NEGATIVE.schema, _list(1, 9)]}, _some)
AXIS = one_of(AXES)


def _needed(name: str, unit: str, meaning: str, example: str) -> Key:
    return Key(name, NOT_NEGATIVE, meaning, example, unit=unit)


GUIDES = Section(
    "[guides]",
    "Profiled rails with runner blocks, by the row with sigma = 6 of the carriage: stiffnesses but along the rails.",
    (
        Key("blocks", WHOLE, "number of blocks, half of them on each rail", "4"),
        Key(
            "distance", PAIR, "of the outer blocks of a rail, and of the rails; 0 for one rail", "[0.4, 0.3]", unit="m"
        ),
        _needed("radial", "N/m", "stiffness of a block normal to the plane of the rails", '"900 N/um"'),
        _needed("lateral", "N/m", "stiffness of a block across the rails, in their plane", '"700 N/um"'),
        Key(
            *("moments", VECTOR, "stiffnesses of a block about the rail, the direction across and the normal"),
            "[2e4, 3e4, 3e4]",
            default=NO_VECTOR,
            otherwise="0",
            unit="N m/rad",
        ),
        Key("rails", AXIS, "axis of the row's frame along the rails", '"x"', default="x", otherwise='"x"'),
        Key("normal", AXIS, "axis of the row's frame normal to their plane", '"z"', default="z", otherwise='"z"'),
    ),
    "joint",
)
BEARINGS = Section(
    "[bearings]",
    "Preloaded pairs of ball bearings, by a row with sigma = 6: its stiffnesses but about their axis.",
    (
        _needed("radial", "N/m", "radial stiffness of one bearing", '"300 N/um"'),
        _needed("axial", "N/m", "axial stiffness of one bearing", '"150 N/um"'),
        _needed("distance", "m", "distance of the two bearings", "0.12"),
        Key(
            "arrangement", one_of(("O", "X")), "O, back to back, or X, face to face", '"O"', default="O", otherwise="O"
        ),
        Key("contact_angle", FORMULA, "contact angle", '"25 deg"', default=ZERO, otherwise="0", unit="rad"),
        Key(
            "pitch_diameter", NOT_NEGATIVE, "pitch diameter of the balls", "0.06", default=ZERO, otherwise="0", unit="m"
        ),
        Key("axis", AXIS, "axis of the row's frame along theirs", '"z"', default="z", otherwise='"z"'),
    ),
    "joint",
)
SCREWS = Section(
    "[screws]",
    "Ball screws, by an elastic row, or by one with sigma = 6 that a guide carries, whose stiffness along the rails it "
    "is; of a turning row about the screw, by the lead.",
    (
        _needed("nut", "N/m", "axial stiffness of the nut", '"800 N/um"'),
        _needed("diameter", "m", "core diameter of the rod", "0.028"),
        Key("modulus", NOT_NEGATIVE, "of elasticity", "2.06e11", Formula.parse("2.06e11"), "2.06e11", "Pa"),
        Key("position", NOT_NEGATIVE, "distance of the nut from the fixed bearing", '"0.1 + y"', unit="m"),
        Key("length", NOT_NEGATIVE, "distance of two fixed bearings", "1.2", otherwise="one end is fixed", unit="m"),
        Key("bearing", NOT_NEGATIVE, "stiffness of a fixed bearing", '"1 kN/um"', otherwise="rigid", unit="N/m"),
        Key("torsional", NOT_NEGATIVE, "of what drives the screw", "2e4", otherwise="rigid", unit="N m/rad"),
        Key("lead", NOT_NEGATIVE, "travel of the screw in one turn", "0.01", otherwise="none", unit="m"),
    ),
    "joint",
)
BELTS = Section(
    "[belts]",
    "Preloaded toothed belts, by an elastic row, or by one with sigma = 6 that a guide carries.",
    (
        _needed("specific", "N", "specific stiffness: force over relative elongation", "1.2e6"),
        Key("strands", PAIR, "lengths of the two strands", '["0.4 + y", "1.6 - y"]', unit="m"),
        Key("radius", NOT_NEGATIVE, "of the pulley, for a turning row", "0.03", otherwise="none", unit="m"),
    ),
    "joint",
)
COUPLINGS = Section(
    "[couplings]",
    "Couplings and shafts in series, by an elastic row that turns, or by one with sigma = 6 that bearings carry; on a "
    "screw, `torsional` in [screws].",
    (Key("torsional", SOME, "torsional stiffnesses, in series", "[3e4, 8e4]", unit="N m/rad"),),
    "joint",
)


MOUNTS, DRIVES = (GUIDES, BEARINGS), (SCREWS, BELTS, COUPLINGS)
ELEMENTS = {
    GUIDES.heading: catalogue.GUIDE,
    BEARINGS.heading: catalogue.BEARING,
    SCREWS.heading: catalogue.SCREW,
    BELTS.heading: catalogue.BELT,
    COUPLINGS.heading: catalogue.COUPLING,
}
MAY_BE_ZERO = ("distance", "moments", "contact_angle", "pitch_diameter")


# Reading


@dataclass(frozen=True)
class _Entry:
    """An entry of a table: the section, its table and the values of its keys, None where there is none."""

    section: Section
    table: Table
    cells: Cells

    def needed(self, key: str, what: str) -> Formula:
        """The value of a key that the row needs; raises `InputError`."""
        if self.cells[key] is None:
            raise self.table.fail(key, f"is missing: {what}")
        value: Formula = self.cells[key]
        return value


def with_catalogue(top: Table) -> tuple[Table, tuple[CatalogueSpring, ...]]:
    """The top table of a file with stiffnesses in place of elements of catalogues, and these; raises `InputError`."""
    rows = {row.text("name"): row for row in top.tables("joints")}
    entries: dict[str, list[_Entry]] = {}
    for section in (*MOUNTS, *DRIVES):
        for name in top.table(_key(section)).entries:
            if name not in rows:
                raise top.fail(_key(section), f"no joint {quote(name)}{did_you_mean(name, rows)}")
            entries.setdefault(name, []).append(_entry(top, section, name))
    springs, listed = dict(top.table("springs").entries), list[CatalogueSpring]()
    for name, of_row in entries.items():
        found = _stiffnesses(rows[name], of_row)
        spring = top.table("springs").table(name).entries
        if "stiffness" in spring:
            what = "the stiffness of this row is given in [springs], too: leave one of them out"
            raise of_row[0].table.fail(_key(of_row[0].section), what)
        texts = {direction: stiffness.formula.text for direction, (stiffness, _) in found.items()}
        stiffness = [texts.get(x, HELD) for x in DIRECTIONS] if _is_cell(rows[name]) else texts[""]
        springs[name] = {"stiffness": stiffness, **spring}
        listed += [CatalogueSpring(f"{name}_{x}".rstrip("_"), *found[x]) for x in ("", *DIRECTIONS) if x in found]
    removed = {_key(section) for section in (*MOUNTS, *DRIVES)}
    kept = {key: x for key, x in top.entries.items() if key not in removed}
    return replace(top, entries=kept | ({"springs": springs} if springs else {})), tuple(listed)


def _key(section: Section) -> str:
    return section.heading.strip("[]")


def _is_cell(row: Table) -> bool:
    return row.entries.get("sigma") == SIX


def _entry(top: Table, section: Section, name: str) -> _Entry:
    table = replace(top.table(_key(section)).table(name), place=f"{_key(section)}, {name}").only(section.names)
    cells = {}
    for key in section.keys:
        is_there = key.name in table.entries or key.is_required or key.default is not None
        cells[key.name] = value = key.read(table) if is_there else None
        for cell in value if isinstance(value, tuple) else (value,):
            if isinstance(cell, Formula) and not cell.names:
                _refuse_negative(table, key.name, cell)
    return _Entry(section, table, cells)


def _refuse_negative(table: Table, key: str, cell: Formula) -> None:
    try:
        value = cell.table_value()
    except FormulaError as error:
        raise table.fail(key, str(error)) from None
    if value < 0 or (value == 0 and key not in MAY_BE_ZERO):
        raise table.fail(key, f"{cell} is not positive")


def _stiffnesses(row: Table, entries: list[_Entry]) -> dict[str, tuple[Stiffness, Element]]:
    """Stiffnesses of a row by direction, "" where it has one only, with their elements; raises `InputError`."""
    mounts = [entry for entry in entries if entry.section in MOUNTS]
    drives = [entry for entry in entries if entry.section in DRIVES]
    first = entries[0].table
    if row.entries.get("kind") != Kind.ELASTIC:
        raise first.fail("kind", f'the row is no spring: write kind = "{Kind.ELASTIC}"')
    if max(len(mounts), len(drives)) > 1:
        headings = " and ".join(entry.section.heading for entry in (mounts if len(mounts) > 1 else drives))
        raise first.fail("element", f"{headings} give the same stiffness: leave one of them out")
    if mounts and not _is_cell(row):
        raise first.fail("sigma", f"the row has one direction: a carriage or spindle has sigma = {SIX}")
    if not mounts and _is_cell(row):
        raise first.fail("sigma", f"one stiffness for {SIX} directions: add the row to [guides] or [bearings]")
    found: dict[str, tuple[Stiffness, Element]] = {}
    free, turns = "", row.entries.get("sigma") == 0
    for entry in mounts:
        free, by_direction = _guide(entry) if entry.section is GUIDES else _bearings(entry)
        turns = free.startswith("r")
        found = {x: (stiffness, ELEMENTS[entry.section.heading]) for x, stiffness in by_direction.items()}
    for entry in drives:
        found[free] = _drive(entry, turns), ELEMENTS[entry.section.heading]
    return found


def _guide(entry: _Entry) -> tuple[str, dict[str, Stiffness]]:
    """The direction that a guide leaves free, and the stiffnesses of the others."""
    cells, fail = entry.cells, entry.table.fail
    blocks, rails, normal = cells["blocks"], cells["rails"], cells["normal"]
    in_row = blocks if cells["distance"][1].is_zero else blocks / 2
    if blocks < 1 or in_row != int(in_row):
        raise fail("blocks", f"{blocks} cannot be divided among the rails: two rails have an even number, at least 2")
    if rails == normal:
        raise fail("normal", f"is along the rails, too: choose another axis than {quote(rails)}")
    is_spread = in_row > 1 and not cells["distance"][0].is_zero
    arms = {"roll": not cells["distance"][1].is_zero, "pitch": is_spread, "yaw": is_spread}
    for (turn, has_arm), moment in zip(arms.items(), cells["moments"], strict=True):
        if not has_arm and moment.is_zero:
            raise fail("moments", f"nothing else holds the {turn}: give those of a block, or more blocks")
    (lateral,) = {*AXES} - {rails, normal}
    names = {"lateral": lateral, "normal": normal, "roll": f"r{rails}", "pitch": f"r{lateral}", "yaw": f"r{normal}"}
    found = catalogue.guide(blocks, cells["distance"], cells["radial"], cells["lateral"], cells["moments"])
    return rails, {names[x]: stiffness for x, stiffness in found.items()}


def _bearings(entry: _Entry) -> tuple[str, dict[str, Stiffness]]:
    """The direction that bearings leave free, and the stiffnesses of the others."""
    found = catalogue.bearing_pair(*(entry.cells[key] for key in BEARINGS.names[:-1]))
    axis = entry.cells["axis"]
    across = [x for x in AXES if x != axis]
    radial, tilt = ({prefix + x: found[name] for x in across} for prefix, name in (("", "radial"), ("r", "tilt")))
    return f"r{axis}", {**radial, axis: found["axial"], **tilt}


def _drive(entry: _Entry, turns: bool) -> Stiffness:
    """The stiffness of a screw, a belt or couplings, along or about the axis of its row."""
    cells = entry.cells
    if entry.section is BELTS:
        stiffness = catalogue.belt(cells["specific"], cells["strands"])
        return catalogue.about_axis(stiffness, entry.needed("radius", "the row turns")) if turns else stiffness
    if entry.section is COUPLINGS:
        if not turns:
            raise entry.table.fail("torsional", "the row slides: give it to the screw, in [screws]")
        return catalogue.coupling(cells["torsional"])
    return _screw(entry, turns)


def _screw(entry: _Entry, turns: bool) -> Stiffness:
    cells, torsional = entry.cells, entry.cells["torsional"]
    position, length = cells["position"], cells["length"]
    if length and not position.names | length.names and position.value() >= length.value():
        raise entry.table.fail("position", f"{position} m is beyond the other bearing, at {length} m")
    stiffness = catalogue.screw(
        cells["nut"],
        (cells["diameter"], cells["modulus"]),
        position,
        length=length,
        bearing=cells["bearing"],
        torsional=(torsional, entry.needed("lead", "torsion moves the nut by it")) if torsional else None,
    )
    if not turns:
        return stiffness
    return catalogue.about_axis(stiffness, catalogue.formula_of("{h}/(2*pi)", h=entry.needed("lead", "the row turns")))
