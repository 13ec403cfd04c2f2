"""Single cells of a TOML machine file: a list of them, replacement of one without other changes, and their lines.

What is written goes through tomlkit, which keeps comments, order and spaces. Cells are data: their new text becomes a
number or a text of TOML, never a table.
"""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

from symoro_elastic.formats.toml.catalogue import TABLES as OF_CATALOGUES
from symoro_elastic.formats.toml.drives import DRIVES
from symoro_elastic.formats.toml.drives import HEADING as OF_MOTORS
from symoro_elastic.formats.toml.flexible.beams import BEAMS
from symoro_elastic.formats.toml.flexible.beams import HEADING as OF_BEAMS
from symoro_elastic.formats.toml.key import Key, Section, schema_of
from symoro_elastic.formats.toml.keys import (
    FRAMES,
    GRAVITY,
    JOINTS,
    LOOPS,
    NAME,
    OF_JOINTS,
    PARAMETERS,
    VALUE,
    WITH_UNIT,
    section_of,
)  # fmt: skip
from symoro_elastic.formats.toml.limits import LIMITS
from symoro_elastic.formats.toml.tables import Number, load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.machine.names import quote

Path = Sequence[str | int]
"""Keys and places in lists that lead to a value: ("bodies", "arm", "inertia", 0)."""

MOST_CHARACTERS = 200_000
"""Of a file that is edited cell by cell."""
MOST_OF_A_CELL = 1000
TRUTHS = ("true", "false")
NUMBER = re.compile(r"[-+]?(?:0|[1-9]\d*)(?:\.\d+)?(?:[eE][-+]?\d+)?")
OF_A_JOINT = re.compile(r"joint (\d+)\b")
OF_A_LINE = re.compile(r"line (\d+)\b")
SECTIONS: Mapping[str, Section] = {
    PARAMETERS.name: WITH_UNIT,
    "limits": LIMITS,
    **{heading: section_of(heading) for heading in OF_JOINTS},
    OF_BEAMS: BEAMS,
    **OF_CATALOGUES,
    "loops": LOOPS,
    "frames": FRAMES,
    OF_MOTORS: DRIVES,
}
"""The tables of named rows."""
PLAIN = re.compile(r"[\w.-]{1,60}")
HERE = "symoro_elastic is here"


def tomlkit() -> Any:
    """Return the package tomlkit; raises `InputError` that says how to install it."""
    return import_optional("tomlkit", "editing a file that keeps its comments", "analysis")


def with_cell(text: str, path: Path, new: str, source: str) -> str:
    """Return the text of a file with one value replaced, or added to a table that is there.

    A number, true and false are written as they are typed, anything else as a text, which formulas are. Raises
    `InputError` for a missing place, and for a file in which the value cannot be replaced alone.
    """
    place = ", ".join(
        str(key + 1) if isinstance(key, int) else key if PLAIN.fullmatch(key) else quote(key) for key in path
    )
    literal = _literal(new, source, place).as_string()
    return with_change(text, source, place, literal, lambda top, value: _set(top, path, value))


def with_change(text: str, source: str, place: str, literal: str, change: Callable[[Any, Any], None]) -> str:
    """Return the text of a file after `change` of its tables by a value, given as TOML text.

    Raises `InputError`, with the place, where the change fails or the text then has other entries than wanted.
    """
    wanted = load(text, source).entries
    try:
        document = tomlkit().parse(text)
        change(wanted, tomllib.loads(f"x = {literal}", parse_float=Number)["x"])
        change(document, tomlkit().value(literal))
        result = str(document.as_string())
        if load(result, source).entries == wanted:
            return result
    except (tomlkit().exceptions.TOMLKitError, LookupError, TypeError, ValueError, RecursionError):
        pass
    raise InputError(source, place, "cannot be written alone here: change it in an editor")


def _literal(text: str, source: str, place: str) -> Any:
    """Return the value of a cell's text as tomlkit writes it."""
    text = text.strip()
    if not text:
        raise InputError(source, place, "is empty: give a number or a formula, 0 for none")
    if len(text) > MOST_OF_A_CELL or not text.isprintable():
        raise InputError(source, place, f"is not one line of up to {MOST_OF_A_CELL} characters")
    kit = tomlkit()
    return kit.value(text) if NUMBER.fullmatch(text) or text in TRUTHS else kit.item(text)


def _set(target: Any, path: Path, value: Any) -> None:
    """Set a value in tables and lists; only the last key may be new, in its table."""
    if len(path) < 2 or any(isinstance(key, int) and key < 0 for key in path):
        raise LookupError(path)
    for key in path[:-1]:
        target = target[key]
    if isinstance(path[-1], int):
        target[path[-1]]  # nothing is added to a list
    elif not isinstance(target, Mapping) or isinstance(target.get(path[-1]), Mapping | list):
        raise TypeError(path)
    set_entry(target, path[-1], value)


def set_entry(table: Any, key: str | int, value: Any) -> None:
    """Set an entry of a table or a list; a new one in an inline table keeps the blanks before its end."""
    if not isinstance(table, tomlkit().items.InlineTable) or key in table:
        table[key] = value
        return
    body, end = table.value.body, []
    while body and body[-1][0] is None and len(table):
        end.append(body.pop())
    is_first = not len(table)
    table[key] = value
    table.value.item(key).trivia.indent = "" if is_first else " "
    body += end


def tables_of(text: str, source: str) -> list[dict[str, Any]]:
    """Return the tables of a file whose cells can be edited: heading, columns, and rows of cells as JSON has them.

    A cell has the path and the text of a value, or the `parts` of a list or a table, these with a `label`; a missing
    one that may be added has no text. `heads` are unit, meaning and choices of each column, `keys` all keys of
    rows, `names` the names of new rows, empty for any. Raises `InputError` for a text that is not TOML.
    """
    top = load(text, source).entries
    joints = top.get("joints")
    rows = [row for row in joints if isinstance(row, dict)] if isinstance(joints, list) else []
    of_joints = [(str(row.get(NAME.name, k + 1)), ["joints", k], row) for k, row in enumerate(rows)]
    gravity: list[tuple[str, list[Any], Any]] = [(GRAVITY.name, [], top)] if GRAVITY.name in top else []
    names = [name for name, _, _ in of_joints]
    tables = [_table(GRAVITY.name, [GRAVITY], gravity, names=[GRAVITY.name])]
    tables.append(_table("joints", [key for key in JOINTS.keys if key is not NAME], of_joints))
    for heading, section in SECTIONS.items():
        entries = top.get(heading)
        named_rows = entries.items() if isinstance(entries, dict) else ()
        named = [(name, [heading, name], row) for name, row in named_rows]
        tables.append(_table(heading, section.keys, named, names if section.entries == "joint" else []))
    return tables


def _table(
    heading: str, keys: Sequence[Key], rows: Sequence[tuple[str, list[Any], Any]], names: Sequence[str] = ()
) -> dict[str, Any]:
    """An editable table: rows with names and paths; columns are the keys that any row has."""
    by_name = {key.name: key for key in keys}
    tables = [row for _, _, row in rows if isinstance(row, dict)]
    columns = [key for key in by_name if any(key in row for row in tables)]
    if len(tables) < len(rows) and VALUE.name not in columns:
        columns = [VALUE.name, *columns]
    lists = {key for key in columns if any(isinstance(row.get(key), list | dict) for row in tables)}
    cells = [
        {"name": name, "path": path, "cells": [_cell(path, row, key, lists) for key in columns]}
        for name, path, row in rows
    ]
    heads = [_head(by_name[key]) for key in columns]
    more = {"heads": heads, "keys": [*by_name], "names": list(names)}
    return {"heading": heading, "columns": columns, "rows": cells, **more}


def _head(key: Key) -> dict[str, Any]:
    """Head of a column: unit, meaning with default, and choices, empty for a free value."""
    meaning = str(schema_of(key)["description"])
    return {"unit": key.unit, "meaning": meaning, "choices": list(key.type.schema.get("enum", ()))}


def _cell(path: list[Any], row: Any, key: str, lists: Collection[str]) -> dict[str, Any]:
    """An editable cell of a key in a row, or of the row itself; empty if no single value fits."""
    if not isinstance(row, dict):
        return _json_cell(path, row) if key == VALUE.name else {}
    return {} if key in lists and key not in row else _json_cell([*path, key], row.get(key))


def _json_cell(path: list[Any], value: Any) -> dict[str, Any]:
    if isinstance(value, dict) and VALUE.name not in value:
        return {"parts": [{"label": key, **_json_cell([*path, key], part)} for key, part in value.items()]}
    if isinstance(value, dict):
        unit = value.get("unit")
        return {**_json_cell([*path, VALUE.name], value.get(VALUE.name)), "unit": unit if isinstance(unit, str) else ""}
    if isinstance(value, list):
        return {"parts": [_json_cell([*path, k], part) for k, part in enumerate(value)]}
    text = str(value).lower() if isinstance(value, bool) else str(value)
    return {"path": path, "text": "" if value is None else text}


class Lines:
    """Line numbers of the places that messages name in a file."""

    def __init__(self, text: str, source: str) -> None:
        self.text, self.source = text, source

    @cached_property
    def _entries(self) -> Mapping[str, Any]:
        return load(self.text, self.source).entries

    def of(self, place: str) -> int | None:
        """Return the line of a place such as "joint 3 (elbow), alpha"; None if no line has it."""
        if line := OF_A_LINE.match(place):
            return int(line[1])
        if len(self.text) > MOST_CHARACTERS:
            return None
        try:
            path = _first_value(self._entries, _path_of(self._entries, place.split(", ")))
            document = copy.deepcopy(self._document)
            target = document
            for key in path[:-1]:
                target = target[key]
            target[path[-1]] = HERE
            return str(document.as_string()).partition(HERE)[0].count("\n") + 1
        except (InputError, tomlkit().exceptions.TOMLKitError, LookupError, TypeError, ValueError, RecursionError):
            return None

    @cached_property
    def _document(self) -> Any:
        return tomlkit().parse(self.text)


def _row_number(top: Mapping[str, Any], place: str, number: int) -> int:
    """Index of a row in the file, by name, since rows generated for flexible parts are numbered, too."""
    names = [row.get(NAME.name) for row in top["joints"]]
    label = place.partition("(")[2].removesuffix(")")
    return next((names.index(name) for name in (label, label.rpartition("_")[0]) if name in names), number)


def _path_of(top: Mapping[str, Any], pieces: Sequence[str]) -> list[Any]:
    """Return the path of keys to a place that a message names, from its pieces; raises `LookupError`."""
    if joint := OF_A_JOINT.match(pieces[0]):
        number = _row_number(top, pieces[0], int(joint[1]) - 1)
        row = top["joints"][number]
        for piece in reversed(pieces[1:]):
            for key_path in _paths_of_key(top, number, row.get(NAME.name), piece):
                return key_path
        return ["joints", number]
    kind, _, name = pieces[0].partition(" ")
    head = [f"{kind}s", name] if kind in ("loop", "beam") and name else [pieces[0]]
    path: list[Any] = []
    target: Any = top
    for key in [*head, *pieces[1:]]:
        if not isinstance(target, Mapping) or key not in target:
            break
        target = target[key]
        path.append(key)
    if not path:
        raise LookupError(pieces[0])
    return path


def _paths_of_key(top: Mapping[str, Any], number: int, name: Any, key: str) -> Iterator[list[Any]]:
    """Possible paths of a joint's key: in its row, else in a section."""
    if key in top["joints"][number]:
        yield ["joints", number, key]
    for section, entries in top.items():
        entry = entries.get(name) if isinstance(entries, dict) else None
        if isinstance(entry, dict) and key in entry:
            yield [section, name, key]


def _first_value(target: Any, path: list[Any]) -> list[Any]:
    """Path to the first value below a path, as lists and tables are nested."""
    for key in path:
        target = target[key]
    while isinstance(target, dict | list) and target:
        key = next(iter(target)) if isinstance(target, dict) else 0
        target, path = target[key], [*path, key]
    return path
