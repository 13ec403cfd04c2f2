"""The .par text of a machine."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import cells
from symoro_elastic.machine.formats.cells import SELECTED, cell_of
from symoro_elastic.machine.formats.central import about_origin
from symoro_elastic.machine.formats.files import name_of
from symoro_elastic.machine.formats.par_syntax import BODY, EXTENDED, GEOMETRIC, HEADINGS, JOINT, ROBOT, entries
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.machine import Body, Given, Joint, Kind, Machine, Orientation
from symoro_elastic.machine.scene import Scene


def layout(machine: Machine, declare: bool) -> str:
    """The text, with the list of parameters if `declare`; raises `InputError` for what .par cannot represent."""
    notes = _plain_notes(machine.notes)
    blocks = [
        [_name(machine.name), *(f"(* {note} *)" for note in notes)],
        _numbers(machine),
        [f"(* {HEADINGS[0]} *)", *_geometry(machine)],
        [f"(* {HEADINGS[1]} *)", *_bodies(machine)],
        [f"(* {HEADINGS[2]} *)", *_joint_lists(machine)],
        [f"(* {HEADINGS[3]} *)", *_base(machine)],
        [f"(* {HEADINGS[4]} *)", f"G = {_vector(machine.base.gravity)}"],
        _extensions(machine, notes, declare),
        [f"(* {HEADINGS[6]} *)"],
    ]
    return "\n\n".join("\n".join(block) for block in blocks if block) + "\n"


def kind_flags(joint: Joint) -> tuple[str, str]:
    """mu and eta as SYMORO would set them."""
    return "0" if joint.kind in (Kind.PASSIVE, Kind.FIXED) else "1", "1" if joint.kind == Kind.ELASTIC else "0"


def structure(joints: Sequence[Joint]) -> str:
    """Type: 0 for a simple chain, 1 for a tree."""
    return "0" if all(joint.antecedent == j for j, joint in enumerate(joints)) else "1"


def listed(cells: Iterable[str]) -> str:
    """Text of a list."""
    return "{" + ", ".join(cells) + "}"


def written_extras(machine: Machine) -> dict[str, list[str]]:
    """The extras that can be written as lists of the .par format."""
    lengths = {"QP": None, "QDP": None, "GAM": None, "Z": 16, "k": None, "mu": None}
    found = {}
    for key, length in lengths.items():
        cells = _as_list(machine.extras.get(key, ""), length or len(machine.joints))
        if cells and _fits(key, cells, machine.joints):
            found[key] = cells
    return found


def _as_list(text: str, length: int) -> list[str]:
    if not re.fullmatch(r"\{[^{}*]*\}", text):
        return []
    try:
        cells = entries(text, "", "")
    except InputError:
        return []
    return cells if len(cells) == length and listed(cells) == text else []


def _fits(key: str, cells: list[str], joints: Sequence[Joint]) -> bool:
    elastic = [joint.kind == Kind.ELASTIC for joint in joints]
    if key == "k":
        unused = [cell != "0" for cell in cells]
        return any(unused) and all(cell == "0" for cell, spring in zip(cells, elastic, strict=True) if spring)
    if key == "mu":
        usual = [kind_flags(joint)[0] for joint in joints]
        free = [spring or joint.sigma == 2 for spring, joint in zip(elastic, joints, strict=True)]
        same = all(cell == mu or (f and cell in ("0", "1")) for cell, mu, f in zip(cells, usual, free, strict=True))
        return same and cells != usual
    return True


def _name(name: str) -> str:
    """The line with the machine's name, as SYMORO writes it where that gives the name back."""
    return f"(* Robotname = '{name}' *)" if name_of(name) == name else _extension("name", _word(name))


def _numbers(machine: Machine) -> list[str]:
    count = len(machine.joints)
    kind = machine.extras.get("Type", "")
    usual = structure(machine.joints)
    numbers = [f"NL = {count}", f"NJ = {count}", f"NF = {count}", f"Type = {kind if _is_type(kind) else usual}"]
    if machine.floating is None:
        return numbers
    return [*numbers, "is_mobile = 1" if machine.floating.known is Given.ACCELERATION else "is_floating = 1"]


def _is_type(text: str) -> bool:
    return text in ("0", "1", "2")


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
    unused = extras.get("k", ["0"] * len(machine.joints))
    rows = {
        "eta": [kind_flags(joint)[1] for joint in machine.joints],
        "k": [
            joint.spring.stiffness.text if joint.kind == Kind.ELASTIC else other
            for joint, other in zip(machine.joints, unused, strict=True)
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
    count = len(next(iter(rows.values())))
    widths = [max(len(row[j]) for row in rows.values()) for j in range(count)]
    lines = []
    for key, row in rows.items():
        padded = [f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)]
        lines.append(f"{key:{name}} = {listed(padded)}")
    return lines


def _extensions(machine: Machine, notes: list[str], declare: bool) -> list[str]:
    joints, parameters = machine.joints, machine.parameters
    turned = machine.floating and machine.floating.orientation
    usual_names = all(joint.name == f"j{j}" for j, joint in enumerate(joints, start=1))
    own = {*written_extras(machine), *(["Type"] if _is_type(machine.extras.get("Type", "")) else [])}
    cells_by_key = [{cell.par: formula for cell, formula in cells(joint)} for joint in joints]
    values: dict[str, str] = {
        "names": "" if usual_names else listed(_word(joint.name) for joint in joints),
        "parameters": listed(_word(p.name) for p in parameters) if declare else "",
        "values": _entries({p.name: _word(p.value.text) for p in parameters if p.value}),
        "units": _entries({p.name: _word(p.unit) for p in parameters if p.unit}),
        **{key: _joint_list(row[key] for row in cells_by_key) for key in EXTENDED},
        "central": _entries({joint.name: _central(joint.body) for joint in joints if joint.body.central}),
        "orientation": "quaternion" if turned is Orientation.QUATERNION else "",
        "notes": listed(map(_word, machine.notes[len(notes) :])) if machine.notes[len(notes) :] else "",
        "scene": _scene(machine.scene) if machine.scene else "",
        "extras": _entries({key: _word(text) for key, text in machine.extras.items() if key not in own}),
    }
    return [_extension(key, value) for key, value in values.items() if value]


def _extension(key: str, value: str) -> str:
    return f"(*! {key} = {value} *)"


def _entries(table: dict[str, str]) -> str:
    return listed(f"{_word(key)} = {value}" for key, value in table.items()) if table else ""


def _joint_list(formulas: Iterable[Formula]) -> str:
    cells = list(formulas)
    return listed(_word(cell.text) for cell in cells) if any(cell != ZERO for cell in cells) else ""


def _central(body: Body) -> str:
    return listed(_word(formula.text) for formula in (*body.moments, *body.inertia))


def _scene(scene: Scene) -> str:
    parts = {}
    if scene.models:
        parts["models"] = listed(map(_word, scene.models))
    if scene.outputs:
        parts["outputs"] = _entries({model: listed(map(_word, names)) for model, names in scene.outputs.items()})
    if scene.locked:
        parts["locked"] = _entries({joint: _word(value.text) for joint, value in scene.locked.items()})
    if scene.fold:
        parts["fold"] = scene.fold if isinstance(scene.fold, str) else listed(map(_word, scene.fold))
    if not scene.gravity:
        parts["gravity"] = "false"
    return _entries(parts) or "{}"


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


def _word(text: str) -> str:
    """A text in an extension line, quoted where it must be."""
    if re.fullmatch(r"[A-Za-z0-9_.+\-*/^]+( [A-Za-z0-9_.+\-*/^]+)*", text, re.ASCII):
        return text
    return json.dumps(text, ensure_ascii=not text.isprintable()).replace("*)", "*\\u0029")
