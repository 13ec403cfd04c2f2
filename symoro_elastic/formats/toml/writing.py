"""The TOML text of a machine, aligned as a table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from symoro_elastic.formats.joint_cells import SELECTED, cell_of
from symoro_elastic.formats.toml.drives import HEADING as OF_DRIVES
from symoro_elastic.formats.toml.drives import drives_by_motor
from symoro_elastic.formats.toml.flexible.bodies import entry_of_body
from symoro_elastic.formats.toml.keys import OF_JOINTS
from symoro_elastic.formats.toml.limits import HEADING as OF_LIMITS
from symoro_elastic.formats.toml.limits import TOLERANCE, limits_by_joint, written_tolerance
from symoro_elastic.formats.toml.motions import Entries, entries_of_motion, entries_of_wanted
from symoro_elastic.formats.toml.within import entries_of
from symoro_elastic.machine.columns import Column, Values, columns
from symoro_elastic.machine.described import DescribedMachine, Request, Wanted, drives_of, limits_of
from symoro_elastic.machine.drives import Sought
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import NO_VECTOR, Base, Body, Floating, Joint, Machine, NamedFrame, Parameter
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.scene import Scene

# Numbers that TOML reads back with the same text (`-0` would lose its sign).
_NUMBER = re.compile(r"(?!-0$)-?(0|[1-9]\d*)(\.\d+)?([eE][+-]?\d+)?", re.ASCII)

REQUIRED = ("mass", "center_of_mass")
"""Columns of a body that are written even where they are zero."""
DIAGONAL = ("XX", "YY", "ZZ")
Entry = list[tuple[str, str]]
BASE_PARAMETERS, GROUPED = "base_parameters", "true"
"""The entry of [extras] that says that inertial parameters are base parameters."""


def write(machine: Machine) -> str:
    """Return the TOML text of a machine, which `read` reads back."""
    described = DescribedMachine.of(machine)
    top = [*_top(described, machine.name), f"gravity = {_list(machine.base.gravity)}"]
    return _join_blocks([top, _joints(machine), *_tables(described)])


def lines_of(machine: DescribedMachine, name: str, rows: Sequence[Entry]) -> Iterator[str]:
    """Lines of TOML about a machine, with these rows in the table of its joints; without blank lines."""
    yield from _top(machine, name)
    if rows:
        is_table = len({len(row) for row in rows}) == 1
        yield from _rows(_aligned_rows(rows) if is_table else [_inline(row) for row in rows])
    for block in _tables(machine):
        yield from block


def _top(machine: DescribedMachine, name: str) -> Iterator[str]:
    """Lines at the top of a file: name and notes, if any."""
    if name:
        yield f"name = {text_of(name)}"
    if machine.origin.notes:
        yield from ("notes = [", *(f"  {text_of(note)}," for note in machine.origin.notes), "]")


def _tables(machine: DescribedMachine) -> Iterator[list[str]]:
    """Tables of a machine after those of the joints."""
    yield from ([f"[{title}]", *lines] for title, lines in _sections(machine) if lines)
    yield from _scene_blocks(machine.asked)


def _rows(lines: Iterable[str]) -> list[str]:
    return ["joints = [", *(f"  {line}," for line in lines), "]"]


def write_scene(scene: Scene, motions: Sequence[PrescribedMotion] = (), wanted: Wanted | None = None) -> str:
    """Return the TOML text of a scene file."""
    return _join_blocks(_scene_blocks(Request(scene, tuple(motions), wanted)))


def _scene_blocks(request: Request) -> Iterable[list[str]]:
    if request.scene is not None:
        yield ["[scene]", *_scene(request.scene)]
    heading = "[motion]" if len(request.motions) == 1 else "[[motion]]"
    for motion in request.motions:
        yield [heading, *_plain(entries_of_motion(motion))]
    if request.wanted is not None:
        yield ["[wanted]", *_plain(entries_of_wanted(request.wanted))]


def _join_blocks(blocks: Iterable[Sequence[str]]) -> str:
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def _sections(machine: DescribedMachine) -> Iterable[tuple[str, list[str]]]:
    yield "loops", _lines_by_name((loop.name, _loop(loop, machine)) for loop in machine.loops)
    yield "frames", _lines_by_name((frame.name, _frame(frame)) for frame in machine.frames)
    limits = limits_of(machine)
    valued = ((parameter, limits.parameters.get(parameter.name)) for parameter in machine.parameters)
    yield "parameters", _table((one.name, _parameter(one, tolerated)) for one, tolerated in valued)
    for section in OF_JOINTS:
        owners = [(joint.name, joint.body if section == "bodies" else joint) for joint in machine.joints]
        yield section, _lines_by_name((name, _entry(owner, section)) for name, owner in owners)
    yield "flexible", _lines_by_name((body.joint, entry_of_body(body)) for body in machine.flexible)
    yield "base", _table([*_entry(machine.base, "base"), *_floating(machine.floating)])
    yield OF_LIMITS, _lines_by_name(limits_by_joint(limits).items())
    yield OF_DRIVES, _table((name, _plain_value(entry)) for name, entry in drives_by_motor(drives_of(machine)))
    extras = machine.origin.extras | ({BASE_PARAMETERS: GROUPED} if machine.is_grouped else {})
    yield "extras", _table((key, text_of(value)) for key, value in extras.items())


def _joints(machine: Machine) -> list[str]:
    rows = [_row(joint, machine) for joint in machine.joints]
    unused = {key for key in ("gamma", "b") if all(dict(row)[key] == "0" for row in rows)}
    rows = [[(key, value) for key, value in row if key not in unused] for row in rows]
    own = [_own_variable(joint, machine) for joint in machine.joints]
    lines = [
        line.removesuffix(" }").rstrip() + variable + " }" if variable else line
        for line, variable in zip(_aligned_rows(rows), own, strict=True)
    ]
    return _rows(lines)


def _own_variable(joint: Joint, machine: Machine) -> str:
    """TOML text of a joint's variable, if its cell has several names that are not parameters; else empty."""
    if joint.variable is None or joint.selected.names <= machine.parameter_names:
        return ""
    return f", variable = {text_of(joint.variable)}"


def _row(joint: Joint, machine: Machine) -> Entry:
    has_row = 0 < joint.antecedent <= len(machine.joints)
    variable = {} if joint.variable is None else {SELECTED[joint.sigma]: joint.variable}
    return [
        ("name", text_of(joint.name)),
        ("antecedent", text_of(machine.joint(joint.antecedent).name) if has_row else str(joint.antecedent)),
        ("kind", text_of(joint.kind.value)),
        ("sigma", str(joint.sigma)),
        *(
            (column.key, _cell(cell_of(variable.get(column.key), formula)))
            for column, (formula, *_) in columns(joint)
            if column.section == "joints"
        ),
    ]


def _loop(loop: Loop, machine: Machine) -> Entry:
    """TOML entries of a loop, defaults omitted."""
    entry = [("cut", text_of(machine.joint(loop.cut).name)), ("meets", text_of(machine.joint(loop.meets).name))]
    if loop.closes is not Closing.FRAME:
        entry.append(("closes", text_of(loop.closes.value)))
    if loop.dependent:
        entry.append(("dependent", _names(loop.dependent)))
    if loop.start:
        start = [(_key(variable), _cell(value.text)) for variable, value in loop.start.items()]
        entry.append(("start", _inline(start)))
    return entry


def _frame(frame: NamedFrame) -> Entry:
    entry = [("on", text_of(frame.on))] if frame.on else []
    return [*entry, ("at", _list(frame.at)), *([("rpy", _list(frame.rpy))] if frame.rpy != NO_VECTOR else [])]


def _aligned_rows(rows: Sequence[Entry]) -> list[str]:
    """Inline tables with entries aligned in columns; all rows have the same keys."""
    widths = [max(len(row[column][1]) for row in rows) for column in range(len(rows[0]))] if rows else []
    return ["{ " + _pad(row, widths) + " }" for row in rows]


def _pad(row: Entry, widths: list[int]) -> str:
    cells = [f"{key} = {value}" for key, value in row]
    pads = [" " * (width - len(value)) for width, (_, value) in zip(widths, row, strict=True)]
    return " ".join([f"{cell},{pad}" for cell, pad in zip(cells[:-1], pads, strict=False)] + [cells[-1] + pads[-1]])


def _table(entries: Iterable[tuple[str, str]]) -> list[str]:
    rows = [(_key(key), value) for key, value in entries]
    width = max((len(key) for key, _ in rows), default=0)
    return [f"{key:{width}} = {value}" for key, value in rows]


def _lines_by_name(entries: Iterable[tuple[str, Entry]]) -> list[str]:
    """A line for each joint with an entry, aligned if all lines have the same keys."""
    rows = [(name, cells) for name, cells in entries if cells]
    same = len({tuple(key for key, _ in cells) for _, cells in rows}) == 1
    lines = _aligned_rows([cells for _, cells in rows]) if same else [_inline(cells) for _, cells in rows]
    return _table((name, line) for (name, _), line in zip(rows, lines, strict=True))


def _inline(entry: Entry) -> str:
    return "{ " + ", ".join(f"{key} = {value}" for key, value in entry) + " }"


def _entry(owner: Joint | Base | Body | Floating, section: str) -> Entry:
    """TOML entries of a joint, a body or the base in a section: columns that differ from their defaults."""
    cells = [(column, values) for column, values in columns(owner) if column.section == section]
    written = [column.key for column, values in cells if any(x != column.default for x in values)]
    required = REQUIRED if isinstance(owner, Body) and owner != Body() else ()
    return [(column.key, _values(column, values)) for column, values in cells if column.key in (*written, *required)]


def _values(column: Column, values: Values) -> str:
    if not column.parts:
        return _cell(values[0].text)
    diagonal = [value for part, value in zip(column.parts, values, strict=True) if part in DIAGONAL]
    off_diagonal = [value for part, value in zip(column.parts, values, strict=True) if part not in DIAGONAL]
    return _list(diagonal if diagonal and all(value == ZERO for value in off_diagonal) else values)


def _floating(floating: Floating | None) -> Entry:
    if floating is None:
        return []
    body = _entry(floating.body, "bodies")
    entry = [("floating", text_of(floating.orientation.value)), ("known", text_of(floating.known.value))]
    entry += [("body", _inline(body))] if body else []
    return [*entry, *((key, text) for key, text in _entry(floating, "base"))]


def _parameter(parameter: Parameter, tolerated: Range | None) -> str:
    if parameter.unit or tolerated:
        value = [("value", _cell(parameter.value.text))] if parameter.value else []
        unit = [("unit", text_of(parameter.unit))] if parameter.unit else []
        return _inline([*value, *unit, *_tolerance(parameter, tolerated)])
    return _cell(parameter.value.text) if parameter.value else "nan"


def _tolerance(parameter: Parameter, tolerated: Range | None) -> Entry:
    if tolerated is None or parameter.value is None:
        return []
    return [(TOLERANCE.name, written_tolerance(parameter.value.value(), tolerated))]


def _scene(scene: Scene) -> list[str]:
    texts = {
        "models": _names(scene.models),
        "outputs": _inline([(_key(model), _names(names)) for model, names in scene.outputs.items()]),
        "locked": _inline([(_key(joint), _cell(value.text)) for joint, value in scene.locked.items()]),
        "static": _static(scene.static),
        "zero": _names(scene.zero),
        "steps": _names(scene.steps),
        "condense": "true",
        "forces": _names(scene.forces),
        "fold": text_of(scene.fold) if isinstance(scene.fold, str) else _names(scene.fold),
    }
    lines = [f"{key} = {text}" for key, text in texts.items() if getattr(scene, key)]
    lines += [f"{key} = {_plain_value(x)}" for key, x in entries_of(scene.within).items()]
    return lines if scene.gravity else [*lines, "gravity = false"]


def _plain(entries: Entries) -> list[str]:
    """Lines of a TOML table of numbers, texts, lists and tables."""
    return _table((key, _plain_value(x)) for key, x in entries.items())


def _plain_value(x: Any) -> str:
    if isinstance(x, Mapping):
        return _inline([(_key(key), _plain_value(value)) for key, value in x.items()])
    if isinstance(x, Formula):
        return _cell(x.text)
    if isinstance(x, Sought):
        return text_of(str(x))
    if isinstance(x, list):
        return "[" + ", ".join(map(_plain_value, x)) + "]"
    if isinstance(x, bool):
        return str(x).lower()
    return text_of(x) if isinstance(x, str) else repr(x)


def _static(static: Mapping[str, Formula | None]) -> str:
    if None in static.values():
        return _names(static)
    return _inline([(_key(joint), _cell(str(value))) for joint, value in static.items()])


def _list(formulas: Iterable[Formula]) -> str:
    return "[" + ", ".join(_cell(formula.text) for formula in formulas) + "]"


def _names(names: Iterable[str]) -> str:
    return "[" + ", ".join(text_of(name) for name in names) + "]"


def _cell(text: str) -> str:
    """TOML text of a cell: a number without quotes, anything else in quotes."""
    return text if _NUMBER.fullmatch(text) else text_of(text)


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name, re.ASCII) else text_of(name)


def text_of(text: str) -> str:
    """A text in TOML quotes."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + re.sub(r"[\x00-\x1f\x7f]", lambda match: f"\\u{ord(match[0]):04x}", escaped) + '"'
