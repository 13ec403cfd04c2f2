"""The .par text of a machine."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from itertools import zip_longest

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.formats.cells import SELECTED, cell_of
from symoro_elastic.machine.formats.central import about_origin
from symoro_elastic.machine.formats.files import name_of
from symoro_elastic.machine.formats.par_extensions import Declared, extension, extension_lines, listed, word
from symoro_elastic.machine.formats.par_order import order_of, renumbered
from symoro_elastic.machine.formats.par_syntax import BODY, GEOMETRIC, HEADINGS, JOINT, ROBOT, entries
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Given, Joint, Kind, Machine


def layout(machine: Machine, declared: Declared) -> str:
    """The text, with these names declared; raises `InputError` for what .par cannot represent."""
    names = [joint.name for joint in machine.joints]
    machine = renumbered(machine, order_of(machine)) if machine.loops else machine
    ordered = names if names != [joint.name for joint in machine.joints] else []
    notes = _plain_notes(machine.notes)
    own = {*written_extras(machine), *(["Type"] if _type(machine) != structure(machine.joints) else [])}
    blocks = [
        [_name(machine.name), *(f"(* {note} *)" for note in notes)],
        _numbers(machine),
        [f"(* {HEADINGS[0]} *)", *_geometry(machine)],
        [f"(* {HEADINGS[1]} *)", *_bodies(machine)],
        [f"(* {HEADINGS[2]} *)", *_joint_lists(machine)],
        [f"(* {HEADINGS[3]} *)", *_base(machine)],
        [f"(* {HEADINGS[4]} *)", f"G = {_vector(machine.base.gravity)}"],
        extension_lines(machine, notes, own, declared, ordered),
        [f"(* {HEADINGS[6]} *)"],
    ]
    return "\n\n".join("\n".join(block) for block in blocks if block) + "\n"


def kind_flags(joint: Joint) -> tuple[str, str]:
    """mu and eta as SYMORO would set them."""
    return str(int(joint.kind in (Kind.MOTOR, Kind.ELASTIC))), str(int(joint.kind == Kind.ELASTIC))


def structure(joints: Sequence[Joint]) -> str:
    """Type: 0 for a simple chain, 1 for a tree, 2 with closed loops."""
    if any(joint.kind is Kind.CUT for joint in joints):
        return "2"
    return "0" if all(joint.antecedent == j for j, joint in enumerate(joints)) else "1"


def written_extras(machine: Machine) -> dict[str, list[str]]:
    """The extras that can be written as lists of the .par format."""
    bodies, loops = len(machine.joints) - 2 * len(machine.loops), len(machine.loops)
    rows = (bodies, bodies + loops, bodies + 2 * loops)
    found = {}
    for key in ("QP", "QDP", "GAM", "Z", "k", "mu"):
        cells = _as_list(machine.extras.get(key, ""), (16,) if key == "Z" else rows)
        if cells and _fits(key, cells, machine.joints):
            found[key] = cells
    return found


def _as_list(text: str, lengths: Collection[int]) -> list[str]:
    if not re.fullmatch(r"\{[^{}*]*\}", text):
        return []
    try:
        cells = entries(text, "", "")
    except InputError:
        return []
    return cells if len(cells) in lengths and listed(cells) == text else []


def _fits(key: str, cells: list[str], joints: Sequence[Joint]) -> bool:
    elastic = [joint.kind == Kind.ELASTIC for joint in joints]
    if key == "k":
        unused = [cell != "0" for cell in cells]
        here = all(cell == "0" for cell, spring in zip(cells, elastic, strict=False) if spring)
        return any(unused) and here and not any(elastic[len(cells) :])
    if key == "mu":
        usual = [kind_flags(joint)[0] for joint in joints]
        free = [spring or joint.sigma == 2 for spring, joint in zip(elastic, joints, strict=True)]
        cells = [*cells, *["0"] * (len(joints) - len(cells))]
        same = all(cell == mu or (f and cell in ("0", "1")) for cell, mu, f in zip(cells, usual, free, strict=True))
        return same and cells != usual
    return True


def _name(name: str) -> str:
    """The line with the machine's name, as SYMORO writes it where that gives the name back."""
    return f"(* Robotname = '{name}' *)" if name_of(name) == name else extension("name", word(name))


def _numbers(machine: Machine) -> list[str]:
    frames, loops = len(machine.joints), len(machine.loops)
    counts = [f"NL = {frames - 2 * loops}", f"NJ = {frames - loops}", f"NF = {frames}"]
    numbers = [*counts, f"Type = {_type(machine)}"]
    if machine.floating is None:
        return numbers
    return [*numbers, "is_mobile = 1" if machine.floating.known is Given.ACCELERATION else "is_floating = 1"]


def _type(machine: Machine) -> str:
    """Type as the file had it, else as the table is."""
    kept = machine.extras.get("Type", "")
    return kept if kept in ("0", "1", "2") else structure(machine.joints)


def _geometry(machine: Machine) -> list[str]:
    rows = [_geometric_cells(joint) for joint in machine.joints]
    mu = written_extras(machine).get("mu")
    return _aligned({**{key: [row[key] for row in rows] for key in GEOMETRIC}, **({"mu": mu} if mu else {})})


def _geometric_cells(joint: Joint) -> dict[str, str]:
    """Geometric columns of one row; the joint variable stands in the cell that sigma selects."""
    texts = {cell.par: formula.text for cell, formula in cells(joint)}
    if joint.variable is not None:
        column = SELECTED[joint.sigma]
        texts[column] = cell_of(joint.variable, getattr(joint, column))
    return {**texts, "ant": str(joint.antecedent), "sigma": str(joint.sigma), "mu": kind_flags(joint)[0]}


def _bodies(machine: Machine) -> list[str]:
    rows = [_body_cells(joint, f"joint {joint.name}", machine) for joint in machine.joints]
    beyond = rows[len(rows) - 2 * len(machine.loops) :]
    if all(row[key].text == "0" for row in beyond for key in BODY):
        del rows[len(rows) - len(beyond) :]
    if machine.floating:
        base = Joint("base", 0, Kind.FIXED, 2, body=machine.floating.body)
        rows.insert(0, _body_cells(base, "base", machine))
    return _aligned({key: [row[key].text for row in rows] for key in BODY})


def _body_cells(joint: Joint, place: str, machine: Machine) -> dict[str, Formula]:
    """Columns of a joint with its body about the origin of the frame, by their keys."""
    return {cell.par: formula for cell, formula in cells(_about_origin(joint, place, machine))}


def _about_origin(joint: Joint, place: str, machine: Machine) -> Joint:
    try:
        return replace(joint, body=about_origin(joint.body))
    except FormulaError as error:
        what = f"its inertia about the origin cannot be written ({error}): write .toml, or give it about the origin"
        raise machine.error(f"{place}, inertia", what) from None


def _joint_lists(machine: Machine) -> list[str]:
    extras = written_extras(machine)
    count = len(machine.joints) - len(machine.loops)
    unused = extras.get("k", ["0"] * count)
    rows = {
        "eta": [kind_flags(joint)[1] for joint in machine.joints[:count]],
        "k": [
            joint.spring.stiffness.text if joint.kind == Kind.ELASTIC else other
            for joint, other in zip(machine.joints, unused, strict=False)
        ],
        **{key: extras[key] for key in JOINT[2:] if key in extras},
    }
    return _aligned(rows)


def _base(machine: Machine) -> list[str]:
    base = machine.base
    lines = [
        f"W0  = {_vector(base.angular_velocity)}",
        f"WP0 = {_vector(base.angular_acceleration)}",
        f"V0  = {_vector(base.velocity)}",
        f"VP0 = {_vector(base.acceleration)}",
    ]
    frame = written_extras(machine).get("Z")
    return [*lines, f"Z = {listed(frame)}"] if frame else lines


def _aligned(rows: dict[str, list[str]]) -> list[str]:
    """Lines of lists with entries aligned in columns."""
    name = max(map(len, rows))
    widths = [max(map(len, column)) for column in zip_longest(*rows.values(), fillvalue="")]
    lines = []
    for key, row in rows.items():
        padded = [f"{cell:>{width}}" for cell, width in zip(row, widths, strict=False)]
        lines.append(f"{key:{name}} = {listed(padded)}")
    return lines


def _vector(formulas: Iterable[Formula]) -> str:
    return listed(formula.text for formula in formulas)


def _plain_notes(notes: Sequence[str]) -> list[str]:
    """The leading notes that can be written as ordinary comments."""
    plain = []
    for note in notes:
        is_text = note == note.strip() and note.replace("\n", "").isprintable() and "*)" not in note
        if not note or not is_text or note[0] == "!" or note in HEADINGS or ROBOT.fullmatch(note):
            break
        plain.append(note)
    return plain
