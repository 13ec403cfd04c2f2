"""The .par text of a machine: its lists, and lines of TOML for entries that these cannot hold."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from enum import Enum
from functools import partial
from itertools import zip_longest

from symoro_elastic.formats.central import about_origin
from symoro_elastic.formats.files import name_of
from symoro_elastic.formats.joint_cells import SELECTED, cell_of
from symoro_elastic.formats.par.syntax import BODY, GEOMETRIC, HEADINGS, JOINT, LISTS, MARK, ROBOT, entries
from symoro_elastic.formats.toml.writing import lines_of, text_of
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Cell, cells, with_cells
from symoro_elastic.machine.described import AnyMachine, DescribedMachine
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Base, Body, Floating, Joint, Kind, KnownOfBase, Machine, Orientation


class Declared(Enum):
    """Names that a .par text declares explicitly in addition to their use in cells."""

    NOTHING = 0
    PARAMETERS = 1
    VARIABLES = 2


def layout(machine: DescribedMachine, declared: Declared) -> str:
    """Return the .par text with names declared as stated; raises `InputError` for unsupported entries."""
    table, machine = machine, with_rows_in_order(machine, order_of(machine)) if machine.loops else machine
    notes = _plain_notes(machine.origin.notes)
    blocks = [
        [*_name(machine.name), *(f"(* {note} *)" for note in notes)],
        _numbers(machine),
        [f"(* {HEADINGS[0]} *)", *_geometry(machine)],
        [f"(* {HEADINGS[1]} *)", *_bodies(machine)],
        [f"(* {HEADINGS[2]} *)", *_joint_lists(machine)],
        [f"(* {HEADINGS[3]} *)", *_base(machine)],
        [f"(* {HEADINGS[4]} *)", f"G = {_vector(machine.base.gravity)}"],
        [_in_comment(line) for line in _beside(table, machine, len(notes), declared)],
        [f"(* {HEADINGS[6]} *)"],
    ]
    return "\n\n".join("\n".join(block) for block in blocks if block) + "\n"


def _beside(table: DescribedMachine, machine: DescribedMachine, notes: int, declared: Declared) -> Iterator[str]:
    """Lines of the TOML block for entries that lists cannot represent; `table` has its rows in TOML order.

    The first `notes` stand elsewhere.
    """
    parameters = [p for p in table.parameters if p.value or p.unit or declared is not Declared.NOTHING]
    own = {*written_extras(machine), *(["Type"] if _type(machine) != structure_of(machine) else [])}
    extras = {key: text for key, text in machine.origin.extras.items() if key not in own}
    remainder = replace(
        table,
        joints=tuple(
            replace(with_cells(joint, partial(_without_listed_cell, joint.kind)), body=_central(joint.body))
            for joint in table.joints
        ),
        parameters=tuple(parameters),
        base=Base(),
        floating=_without_listed_base(table.floating),
        loops=() if _is_usual(table, machine) else table.loops,
        origin=replace(table.origin, notes=table.origin.notes[notes:], extras=extras),
    )
    rows = _rows(table, declared is Declared.VARIABLES)
    usual = rows == [[("name", f'"j{j}"')] for j in range(1, len(rows) + 1)]
    yield from lines_of(remainder, name="" if _is_robot(machine.name) else machine.name, rows=[] if usual else rows)


def _without_listed_cell(kind: Kind, cell: Cell, formula: Formula) -> Formula:
    """Return a cell's formula, or zero if a list of the format has it; list k is for elastic joints only."""
    is_listed = cell.par in LISTS and (cell.par != "k" or kind is Kind.ELASTIC)
    return ZERO if is_listed else formula


def _central(body: Body) -> Body:
    """Return a body about its centre of mass, which lists cannot represent; an empty body for others."""
    return body if body.central else Body()


def _without_listed_base(floating: Floating | None) -> Floating | None:
    if floating is None or (floating.orientation is Orientation.ROTATION and not floating.body.central):
        return None
    return replace(floating, body=_central(floating.body))


def _is_usual(table: DescribedMachine, machine: DescribedMachine) -> bool:
    """Return whether the order of rows determines the loops, so that they need no entry."""
    plain = (Loop(f"loop_{k}", loop.cut, loop.meets) for k, loop in enumerate(machine.loops, start=1))
    names = [[joint.name for joint in described.joints] for described in (table, machine)]
    return machine.loops == tuple(plain) and names[0] == names[1]


def _rows(machine: DescribedMachine, variables: bool) -> list[list[tuple[str, str]]]:
    """Entries of rows for the TOML block: joint names, with variables that are ambiguous in their cells."""
    doubts = _ambiguous_variables(machine) if variables else {}
    own = [[("variable", text_of(doubts[joint.name]))] if joint.name in doubts else [] for joint in machine.joints]
    return [[("name", text_of(joint.name)), *entry] for joint, entry in zip(machine.joints, own, strict=True)]


def _ambiguous_variables(machine: DescribedMachine) -> dict[str, str]:
    """Variables of joints whose cells hold other variables, or that occur in other cells."""
    holders = Counter(name for joint in machine.joints for name in joint.selected.names - machine.parameter_names)
    owners = [joint for joint in machine.joints if joint.variable]
    shared = [joint for joint in owners if joint.variable in holders or joint.selected.names - machine.parameter_names]
    return {joint.name: str(joint.variable) for joint in shared}


def _in_comment(line: str) -> str:
    """Return a line of TOML as a comment, without comment marks inside."""
    line = line.replace("(*", "(\\u002a").replace("*)", "\\u002a)")
    escaped = (x if x.isprintable() else f"\\u{ord(x):04x}" if ord(x) < 0x10000 else f"\\U{ord(x):08x}" for x in line)
    return f"(*{MARK} {''.join(escaped)} *)"


def with_rows_in_order(machine: AnyMachine, rows: Sequence[int]) -> AnyMachine:
    """The machine with its rows, each once, in this order; antecedents and loops follow."""
    number = {old: new for new, old in enumerate(rows, start=1)}
    joints = (replace(machine.joint(j), antecedent=number.get(machine.joint(j).antecedent, 0)) for j in rows)
    loops = (replace(loop, cut=number[loop.cut], meets=number[loop.meets]) for loop in machine.loops)
    return replace(machine, joints=tuple(joints), loops=tuple(loops))


def order_of(machine: Machine) -> tuple[int, ...]:
    """Row numbers in the order of a .par file; raises `InputError` for a machine that the format cannot represent."""
    last = [*(loop.cut for loop in machine.loops), *(loop.meets for loop in machine.loops)]
    times = Counter(last)
    for j in last:
        if times[j] > 1:
            what = "two loops close at this row: give each rows of its own, or write .toml"
            raise machine.error(f"joint {j} ({machine.joint(j).name})", what)
    rows = (*(j for j in range(1, len(machine.joints) + 1) if j not in times), *last)
    place = {j: k for k, j in enumerate(rows)}
    for j in rows:
        antecedent = machine.joint(j).antecedent
        if place.get(antecedent, -1) > place[j]:
            at = f"where a loop closes: a .par file lists {machine.joint(antecedent).name} last"
            what = f"it is carried by the frame {at}; mount it on another one, or write .toml"
            raise machine.error(f"joint {j} ({machine.joint(j).name}), antecedent", what)
    return rows


def kind_flags(kind: Kind) -> tuple[str, str]:
    """Flags mu and eta of a joint kind, as SYMORO sets them."""
    return str(int(kind in (Kind.MOTOR, Kind.ELASTIC))), str(int(kind is Kind.ELASTIC))


def structure(antecedents: Sequence[int], kinds: Collection[Kind]) -> str:
    """Code of the structure (Type): 0 for a simple chain, 1 for a tree, 2 with closed loops."""
    if Kind.CUT in kinds:
        return "2"
    return "0" if all(antecedent == j for j, antecedent in enumerate(antecedents)) else "1"


def structure_of(machine: Machine) -> str:
    """Code of the structure (Type) of a machine."""
    return structure(machine.antecedents, [joint.kind for joint in machine.joints])


def list_text(cells: Iterable[str]) -> str:
    """Text of a list `{...}` of cells."""
    return "{" + ", ".join(cells) + "}"


def written_extras(machine: DescribedMachine) -> dict[str, list[str]]:
    """Extra entries of a machine that can be written as .par lists."""
    bodies, loops = len(machine.joints) - 2 * len(machine.loops), len(machine.loops)
    rows = (bodies, bodies + loops, bodies + 2 * loops)
    extras = {}
    for key in ("QP", "QDP", "GAM", "Z", "k", "mu"):
        cells = _as_list(machine.origin.extras.get(key, ""), (16,) if key == "Z" else rows)
        if cells and _fits(key, cells, machine.joints):
            extras[key] = cells
    return extras


def _as_list(text: str, lengths: Collection[int]) -> list[str]:
    if not re.fullmatch(r"\{[^{}*]*\}", text):
        return []
    try:
        cells = entries(text, "", "")
    except InputError:
        return []
    return cells if len(cells) in lengths and list_text(cells) == text else []


def _fits(key: str, cells: list[str], joints: Sequence[Joint]) -> bool:
    elastic = [joint.kind == Kind.ELASTIC for joint in joints]
    if key == "k":
        unused = [cell != "0" for cell in cells]
        here = all(cell == "0" for cell, spring in zip(cells, elastic, strict=False) if spring)
        return any(unused) and here and not any(elastic[len(cells) :])
    if key == "mu":
        usual = [kind_flags(joint.kind)[0] for joint in joints]
        free = [spring or joint.sigma == 2 for spring, joint in zip(elastic, joints, strict=True)]
        cells = [*cells, *["0"] * (len(joints) - len(cells))]
        same = all(cell == mu or (f and cell in ("0", "1")) for cell, mu, f in zip(cells, usual, free, strict=True))
        return same and cells != usual
    return True


def _is_robot(name: str) -> bool:
    """Return whether the Robotname that SYMORO writes determines the machine's name."""
    return name_of(name) == name


def _name(name: str) -> list[str]:
    return [f"(* Robotname = '{name}' *)"] if _is_robot(name) else []


def _numbers(machine: DescribedMachine) -> list[str]:
    frames, loops = len(machine.joints), len(machine.loops)
    counts = [f"NL = {frames - 2 * loops}", f"NJ = {frames - loops}", f"NF = {frames}"]
    numbers = [*counts, f"Type = {_type(machine)}"]
    if machine.floating is None:
        return numbers
    return [*numbers, "is_mobile = 1" if machine.floating.known is KnownOfBase.ACCELERATION else "is_floating = 1"]


def _type(machine: DescribedMachine) -> str:
    """Return the structure code (Type) as in the file, else from the structure of the table."""
    of_file = machine.origin.extras.get("Type", "")
    return of_file if of_file in ("0", "1", "2") else structure_of(machine)


def _geometry(machine: DescribedMachine) -> list[str]:
    rows = [_geometric_cells(joint) for joint in machine.joints]
    mu = written_extras(machine).get("mu")
    return _aligned_lists({**{key: [row[key] for row in rows] for key in GEOMETRIC}, **({"mu": mu} if mu else {})})


def _geometric_cells(joint: Joint) -> dict[str, str]:
    """Geometric cells of a row by column; the joint variable is in the cell that sigma selects."""
    texts = {cell.par: formula.text for cell, formula in cells(joint)}
    if joint.variable is not None:
        column = SELECTED[joint.sigma]
        texts[column] = cell_of(joint.variable, getattr(joint, column))
    return {**texts, "ant": str(joint.antecedent), "sigma": str(joint.sigma), "mu": kind_flags(joint.kind)[0]}


def _bodies(machine: DescribedMachine) -> list[str]:
    rows = [_body_cells(joint, f"joint {joint.name}", machine) for joint in machine.joints]
    beyond = rows[len(rows) - 2 * len(machine.loops) :]
    if all(row[key].text == "0" for row in beyond for key in BODY):
        del rows[len(rows) - len(beyond) :]
    if machine.floating:
        base = Joint("base", 0, Kind.FIXED, 2, body=machine.floating.body)
        rows.insert(0, _body_cells(base, "base", machine))
    return _aligned_lists({key: [row[key].text for row in rows] for key in BODY})


def _body_cells(joint: Joint, place: str, machine: DescribedMachine) -> dict[str, Formula]:
    """Cells of a joint and of its body about the origin of the frame, by column."""
    return {cell.par: formula for cell, formula in cells(_about_origin(joint, place, machine))}


def _about_origin(joint: Joint, place: str, machine: DescribedMachine) -> Joint:
    try:
        return replace(joint, body=about_origin(joint.body))
    except FormulaError as error:
        what = f"its inertia about the origin cannot be written ({error}): write .toml, or give it about the origin"
        raise machine.error(f"{place}, inertia", what) from None


def _joint_lists(machine: DescribedMachine) -> list[str]:
    extras = written_extras(machine)
    count = len(machine.joints) - len(machine.loops)
    unused = extras.get("k", ["0"] * count)
    rows = {
        "eta": [kind_flags(joint.kind)[1] for joint in machine.joints[:count]],
        "k": [
            joint.spring.stiffness.text if joint.kind == Kind.ELASTIC else other
            for joint, other in zip(machine.joints, unused, strict=False)
        ],
        **{key: extras[key] for key in JOINT[2:] if key in extras},
    }
    return _aligned_lists(rows)


def _base(machine: DescribedMachine) -> list[str]:
    base = machine.base
    lines = [
        f"W0  = {_vector(base.angular_velocity)}",
        f"WP0 = {_vector(base.angular_acceleration)}",
        f"V0  = {_vector(base.velocity)}",
        f"VP0 = {_vector(base.acceleration)}",
    ]
    frame = written_extras(machine).get("Z")
    return [*lines, f"Z = {list_text(frame)}"] if frame else lines


def _aligned_lists(rows: dict[str, list[str]]) -> list[str]:
    """Lines of lists with entries aligned in columns."""
    name = max(map(len, rows))
    widths = [max(map(len, column)) for column in zip_longest(*rows.values(), fillvalue="")]
    lines = []
    for key, row in rows.items():
        padded = [f"{cell:>{width}}" for cell, width in zip(row, widths, strict=False)]
        lines.append(f"{key:{name}} = {list_text(padded)}")
    return lines


def _vector(formulas: Iterable[Formula]) -> str:
    return list_text(formula.text for formula in formulas)


def _plain_notes(notes: Sequence[str]) -> list[str]:
    """The leading notes that can be written as ordinary comments."""
    plain = []
    for note in notes:
        is_text = note == note.strip() and note.replace("\n", "").isprintable() and "*)" not in note
        if (
            not note
            or not is_text
            or note[0] == "!"
            or note.split()[0] == MARK
            or note in HEADINGS
            or ROBOT.fullmatch(note)
        ):
            break
        plain.append(note)
    return plain
