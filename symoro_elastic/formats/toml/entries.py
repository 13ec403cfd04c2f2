"""Rows and keys of a TOML machine file: added with the example of their format, removed with what refers to a joint."""

from __future__ import annotations

from typing import Any

from symoro_elastic.formats.toml.catalogue import TABLES as OF_CATALOGUES
from symoro_elastic.formats.toml.drives import HEADING as OF_MOTORS
from symoro_elastic.formats.toml.editing import SECTIONS, Path, set_entry, tomlkit, with_change
from symoro_elastic.formats.toml.flexible.beams import HEADING as OF_BEAMS
from symoro_elastic.formats.toml.flexible.bodies import HEADING as OF_FLEXIBLE
from symoro_elastic.formats.toml.keys import GRAVITY, JOINTS, NAME, OF_JOINTS
from symoro_elastic.formats.toml.limits import HEADING as OF_LIMITS
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind
from symoro_elastic.machine.names import quote


def with_entry(text: str, path: Path, new: str, source: str) -> str:
    """Return the text of a file with a key added, in a row that is created if it does not exist.

    The path is ("gravity",), a table, a name and a key, or "joints", a new name and "kind", `new` its kind. Values are
    the examples of the format. Raises `InputError` for what is there already.
    """
    entries = load(text, source).entries
    if path == [GRAVITY.name]:
        return with_change(text, source, GRAVITY.name, GRAVITY.example, lambda top, value: _put(top, path, value))
    heading, name, key = path
    if heading == JOINTS.heading:
        if new not in [*Kind]:
            raise InputError(source, "joints, kind", f"no kind {quote(new)}: choose from {', '.join(Kind)}")
        where = "at = [0, 0, 0]" if new == Kind.FIXED else 'sigma = 0, axis = "z"'
        row = f'{{ name = {tomlkit().item(str(name)).as_string()}, kind = "{new}", {where} }}'
        return with_change(text, source, "joints", row, _append)
    examples = {x.name: x.example for x in SECTIONS[str(heading)].keys} if heading in SECTIONS else {}
    if key not in examples:
        raise InputError(source, quote(str(heading)), f"has no key {quote(str(key))}")
    is_new = name not in entries.get(str(heading), {})
    value = f"{{ {key} = {examples[str(key)]} }}" if is_new else examples[str(key)]
    place = path[:2] if is_new else path
    return with_change(text, source, f"{heading}, {name}", value, lambda top, value: _put(top, place, value))


def _put(top: Any, path: Path, value: Any) -> None:
    """Add an entry to a table, which is created if it does not exist."""
    if len(path) > 1 and path[0] not in top:
        top[path[0]] = {}
    for key in path[:-1]:
        top = top[key]
    if path[-1] in top:
        raise LookupError(path)
    set_entry(top, path[-1], value)


def _append(top: Any, row: Any) -> None:
    """Add a joint after the others, as an inline table or a table of its own, as they are."""
    rows = top[JOINTS.heading]
    rows.append(tomlkit().item(row.unwrap()) if isinstance(rows, tomlkit().items.AoT) else row)


def without_entry(text: str, path: Path, new: str, source: str) -> str:
    """Return the text of a file without a row or a key; with a joint, its rows in other tables are removed.

    Raises `InputError` for a joint where others name their antecedents by number; `new` is empty.
    """
    rows = load(text, source).entries.get(JOINTS.heading, [])
    numbers = [row.get("antecedent") for row in rows if isinstance(row, dict)]
    if path[0] == JOINTS.heading and any(isinstance(x, int) and x > 0 for x in numbers):
        raise InputError(source, "joints", "antecedents are row numbers, which would change: write names first")
    return with_change(text, source, ", ".join(map(str, path)), "0", lambda top, _: _drop(top, path))


def _drop(top: Any, path: Path) -> None:
    *front, last = path
    target = top
    for key in front:
        target = target[key]
    if front == [JOINTS.heading]:
        name = target[last].get(NAME.name)
        for heading in (*OF_JOINTS, OF_LIMITS, OF_MOTORS, OF_BEAMS, OF_FLEXIBLE, *OF_CATALOGUES):
            if name in top.get(heading, {}):
                _drop(top, [heading, name])
    del target[last]
    if len(front) == 1 and front != [JOINTS.heading] and not target:
        del top[front[0]]
