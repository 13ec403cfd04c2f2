"""Tables of machine elements by numbers of catalogues, which become the stiffnesses of elastic rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from symoro_elastic.formats.toml import key as keys
from symoro_elastic.formats.toml.flexible.parts import DIRECTIONS, SIX
from symoro_elastic.formats.toml.key import Key, Section, Type, one_of, reference_to
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.machine import catalogue
from symoro_elastic.machine.catalogue import ELEMENTS, CatalogueSpring
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.joints import Kind
from symoro_elastic.machine.machine import NO_VECTOR
from symoro_elastic.machine.names import no_such, quote

AXES = ("x", "y", "z")
MAY_BE_ZERO = ("distance", "moments", "contact_angle", "pitch_diameter")
STEEL = Formula.parse("2.06e11")
"""Modulus of elasticity of screws, Pa."""


def _list(*lengths: int) -> Type:
    """Type of a list with one of these numbers of entries, numbers or formulas."""
    schema = {"type": "array", "items": reference_to("formula"), "minItems": lengths[0], "maxItems": lengths[-1]}
    title = f"{' or '.join(map(str, lengths))} numbers or formulas"
    return Type(title, schema, lambda table, key: table.formulas(key, lengths))


def _section(heading: str, meaning: str, *of_section: Key) -> Section:
    return Section(heading, meaning, of_section, "joint")


POSITIVE, AXIS, PAIR, LIST = keys.NOT_NEGATIVE, one_of(AXES), _list(2), _list(1, 2, 3)
PER_BLOCK = "stiffnesses of a block about the rail, the direction across it and the normal"
GUIDES = _section(
    "[guides]",
    "Profiled rails with runner blocks, by the row with sigma = 6 of the carriage: stiffnesses but along the rails.",
    Key("blocks", keys.WHOLE, "number of blocks, half of them on each rail", "4"),
    Key("distance", PAIR, "of the outer blocks of a rail, of the rails; 0 for one rail", "[0.4, 0.3]", unit="m"),
    Key("radial", POSITIVE, "stiffness of a block normal to the rails' plane", '"900 N/um"', unit="N/m"),
    Key("lateral", POSITIVE, "stiffness of a block across the rails, in their plane", '"700 N/um"', unit="N/m"),
    Key("moments", keys.VECTOR, PER_BLOCK, "[2e4, 3e4, 3e4]", NO_VECTOR, "0", "N m/rad"),
    Key("rails", AXIS, "axis of the row's frame along the rails", '"x"', "x", '"x"'),
    Key("normal", AXIS, "axis of the row's frame normal to their plane", '"z"', "z", '"z"'),
)
BEARINGS = _section(
    "[bearings]",
    "Preloaded pairs of ball bearings, by a row with sigma = 6: its stiffnesses but about their axis.",
    Key("radial", POSITIVE, "radial stiffness of a single bearing", '"300 N/um"', unit="N/m"),
    Key("axial", POSITIVE, "axial stiffness of a single bearing", '"150 N/um"', unit="N/m"),
    Key("distance", POSITIVE, "distance of the two bearings", "0.12", unit="m"),
    Key("arrangement", one_of(("O", "X")), "O, back to back, or X, face to face", '"O"', "O", '"O"'),
    Key("contact_angle", keys.FORMULA, "contact angle", '"25 deg"', ZERO, "0", "rad"),
    Key("pitch_diameter", POSITIVE, "pitch diameter of the balls", "0.06", ZERO, "0", "m"),
    Key("axis", AXIS, "axis of the row's frame along theirs", '"z"', "z", '"z"'),
)
SCREWS = _section(
    "[screws]",
    "Ball screws, by an elastic row, or by one with sigma = 6 that a guide carries, whose stiffness along the rails it "
    "is; of a turning row about the screw, by the lead.",
    Key("nut", POSITIVE, "axial stiffness of the nut", '"800 N/um"', unit="N/m"),
    Key("diameter", POSITIVE, "core diameter of the rod", "0.028", unit="m"),
    Key("modulus", POSITIVE, "modulus of elasticity", "2.06e11", STEEL, STEEL.text, "Pa"),
    Key("position", POSITIVE, "distance of the nut from the fixed bearing", '"0.1 + y"', unit="m"),
    Key("length", POSITIVE, "distance of two fixed bearings", "1.2", None, "one end is fixed", "m"),
    Key("bearing", POSITIVE, "stiffness of a fixed bearing", '"1 kN/um"', None, "rigid", "N/m"),
    Key("torsional", POSITIVE, "torsional stiffness of what drives it", "2e4", None, "rigid", "N m/rad"),
    Key("lead", POSITIVE, "travel of the nut in one turn", "0.01", None, "none", "m"),
)
BELTS = _section(
    "[belts]",
    "Preloaded toothed belts, by an elastic row, or by one with sigma = 6 that a guide or bearings carry.",
    Key("specific", POSITIVE, "specific stiffness: force over relative elongation", "1.2e6", unit="N"),
    Key("strands", PAIR, "lengths of the two strands", '["0.4 + y", "1.6 - y"]', unit="m"),
    Key("radius", POSITIVE, "radius of the pulley, for a turning row", "0.03", None, "none", "m"),
)
COUPLINGS = _section(
    "[couplings]",
    "Couplings and shafts in series, by an elastic row that turns, or by one with sigma = 6 that bearings carry.",
    Key("torsional", LIST, "torsional stiffnesses, in series", "[3e4, 8e4]", unit="N m/rad"),
)
MOUNTS, DRIVES = {"guides": GUIDES, "bearings": BEARINGS}, {"screws": SCREWS, "belts": BELTS, "couplings": COUPLINGS}
TABLES = MOUNTS | DRIVES


@dataclass(frozen=True)
class _Entry:
    """An entry for a catalogue element: values of its keys, None for missing ones."""

    heading: str
    table: Table
    cells: Mapping[str, Any]

    def value_of(self, key: str, what: str) -> Formula:
        """Value of a key that the element requires; raises `InputError`."""
        value: Formula | None = self.cells[key]
        if value is None:
            raise self.table.fail(key, f"is missing: {what}")
        return value


def with_catalogue(top: Table) -> tuple[Table, tuple[CatalogueSpring, ...]]:
    """Replace catalogue elements of a file by stiffnesses; return the top table and the springs; `InputError`."""
    if TABLES.keys().isdisjoint(top.entries):
        return top, ()
    rows = {row.text("name"): row for row in top.tables("joints")}
    by_row: dict[str, list[_Entry]] = {}
    for heading in TABLES:
        for name in top.table(heading).entries:
            if name not in rows:
                raise top.fail(heading, no_such("joint", name, rows))
            by_row.setdefault(name, []).append(_entry(top, heading, name))
    springs, listed = dict(top.table("springs").entries), list[CatalogueSpring]()
    for name, entries in by_row.items():
        stiffnesses = _stiffnesses(rows[name], entries)
        spring = top.table("springs").table(name).entries
        if "stiffness" in spring:
            raise entries[0].table.fail("stiffness", "is given in [springs], too: remove one of the two")
        texts = {x: spring.stiffness.text for x, spring in stiffnesses.items()}
        springs[name] = {"stiffness": texts.get("") or [texts.get(x, Number("inf")) for x in DIRECTIONS], **spring}
        listed += stiffnesses.values()
    remaining = {key: x for key, x in top.entries.items() if key not in TABLES}
    return replace(top, entries=remaining | ({"springs": springs} if springs else {})), tuple(listed)


def _entry(top: Table, heading: str, name: str) -> _Entry:
    section = TABLES[heading]
    table = replace(top.table(heading).table(name), place=f"{heading}, {name}").only(section.names)
    cells = {}
    for key in section.keys:
        is_there = key.name in table.entries or key.is_required or key.default is not None
        cells[key.name] = value = key.read(table) if is_there else None
        for cell in value if isinstance(value, tuple) else (value,):
            number = cell.known_value({}) if isinstance(cell, Formula) else 1
            if number is not None and (number < 0 or (number == 0 and key.name not in MAY_BE_ZERO)):
                raise table.fail(key.name, f"{cell} is not positive")
    return _Entry(heading, table, cells)


def _stiffnesses(row: Table, entries: list[_Entry]) -> dict[str, CatalogueSpring]:
    """Springs of a row by direction, "" if it has one direction only; raises `InputError`."""
    mounts, drives = ([entry for entry in entries if entry.heading in tables] for tables in (MOUNTS, DRIVES))
    fail, name, is_cell = entries[0].table.fail, row.text("name"), row.entries.get("sigma") == SIX
    if row.entries.get("kind") != Kind.ELASTIC:
        raise fail("kind", f'the row has no spring: write kind = "{Kind.ELASTIC}"')
    for same in (mounts, drives):
        if len(same) > 1:
            headings = " and ".join(f"[{entry.heading}]" for entry in same)
            raise fail("element", f"{headings} give the same stiffness: remove one of the two")
    if bool(mounts) != is_cell:
        what = "a single stiffness for six directions: add the row to [guides] or [bearings]"
        raise fail("sigma", what if is_cell else f"the row has one direction: a carriage or spindle has sigma = {SIX}")
    free, turns, springs = "", row.entries.get("sigma") == 0, dict[str, CatalogueSpring]()
    for entry in mounts:
        free, stiffnesses = (_guide if entry.heading == "guides" else _bearings)(entry)
        turns = free.startswith("r")
        springs |= {x: CatalogueSpring(f"{name}_{x}", k, *ELEMENTS[entry.heading]) for x, k in stiffnesses.items()}
    for entry in drives:
        label = f"{name}_{free}" if free else name
        springs[free] = CatalogueSpring(label, _drive(entry, turns), *ELEMENTS[entry.heading])
    return springs


def _guide(entry: _Entry) -> tuple[str, dict[str, Formula]]:
    """Free direction of a linear guide, and its stiffnesses in the other directions."""
    blocks, (a, b), radial, lateral, moments, rails, normal = (entry.cells[key] for key in GUIDES.names)
    in_row, remainder = divmod(blocks, 1 if b.is_zero else 2)
    if in_row < 1 or remainder:
        raise entry.table.fail("blocks", f"{blocks} cannot be divided among the rails: two have 2, 4, 6 ... blocks")
    if rails == normal:
        raise entry.table.fail("normal", f"is along the rails, too: choose another axis than {quote(rails)}")
    is_spread = in_row > 1 and not a.is_zero
    arms = {"roll": not b.is_zero, "pitch": is_spread, "yaw": is_spread}
    for turn, k_m in zip(arms, moments, strict=True):
        if not arms[turn] and k_m.is_zero:
            raise entry.table.fail("moments", f"nothing else holds the {turn}: give those of a block, or more blocks")
    (across,) = {*AXES} - {rails, normal}
    names = {"lateral": across, "normal": normal, "roll": f"r{rails}", "pitch": f"r{across}", "yaw": f"r{normal}"}
    return rails, {names[x]: k for x, k in catalogue.guide(blocks, (a, b), radial, lateral, moments).items()}


def _bearings(entry: _Entry) -> tuple[str, dict[str, Formula]]:
    """Free direction of bearings, and their stiffnesses in the other directions."""
    *cells, axis = (entry.cells[key] for key in BEARINGS.names)
    k = catalogue.bearing_pair(*cells)
    across = [x for x in AXES if x != axis]
    return f"r{axis}", {axis: k["axial"], **dict.fromkeys(across, k["radial"]), **{f"r{x}": k["tilt"] for x in across}}


def _drive(entry: _Entry, turns: bool) -> Formula:
    """Stiffness of a screw, a belt or couplings, along or about the axis of its row."""
    cells = entry.cells
    if entry.heading == "couplings":
        if not turns:
            raise entry.table.fail("torsional", "the row slides: give it to the screw, in [screws]")
        return catalogue.coupling(cells["torsional"])
    is_belt = entry.heading == "belts"
    k = catalogue.belt(cells["specific"], cells["strands"]) if is_belt else _screw(entry)
    if not turns:
        return k
    r = entry.value_of("radius" if is_belt else "lead", "the row turns")
    return catalogue.about_axis(k, r if is_belt else catalogue.formula_of("{h}/(2*pi)", h=r))


def _screw(entry: _Entry) -> Formula:
    nut, diameter, modulus, position, length, bearing, torsional, _ = (entry.cells[key] for key in SCREWS.names)
    if length and not position.names | length.names and position.value() >= length.value():
        raise entry.table.fail("position", f"{position} m is beyond the other bearing, at {length} m")
    twist = (torsional, entry.value_of("lead", "torsion moves the nut by it")) if torsional else None
    return catalogue.screw(nut, (diameter, modulus), position, length, bearing, twist)
