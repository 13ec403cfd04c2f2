"""A changed machine or scene written into its file's text: other comments, order and units stay.

What changed is the difference of two texts in normal form, as `writing` has them: the file as it is read, and what is
to be saved. The new text is taken if it reads back as exactly that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.toml.editing import MOST_CHARACTERS, set_entry, tomlkit
from symoro_elastic.formats.toml.keys import NAME
from symoro_elastic.formats.toml.tables import Number, load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.format_names import TOML


def with_changes(text: str, wanted: str, normal: Callable[[str], str]) -> str:
    """Return the text of a file changed to the contents of `wanted`, a text in normal form; comments stay.

    `normal` reads a text and returns it in normal form. Raises `InputError` where the contents cannot be written into
    the text, or tomlkit is not installed.
    """
    kit = tomlkit()
    if len(text) > MOST_CHARACTERS:
        raise InputError("file", "text", f"it has more than {MOST_CHARACTERS} characters")
    try:
        document, before, after = kit.parse(text), *(load(source, "file").entries for source in (normal(text), wanted))
        if _names(before) != _names(after):
            raise LookupError("other joints: comments are not about these")
        _change(document, before, after)
        edited = str(document.as_string())
        if normal(edited) == wanted:
            return edited
    except (InputError, kit.exceptions.TOMLKitError, LookupError, TypeError, ValueError, RecursionError):
        pass
    raise InputError("file", "text", "what changed does not fit into its text")


def _change(target: Any, before: Any, after: Any) -> None:
    """Apply the differences of two tables, or of two lists of equal length, to an object of tomlkit."""
    if isinstance(after, Mapping):
        for key in before.keys() - after.keys():
            if key in target:
                del target[key]
        changed = {key: new for key, new in after.items() if key not in before or before[key] != new}
    else:
        changed = {k: new for k, new in enumerate(after) if before[k] != new}
    for key, new in changed.items():
        is_old = isinstance(key, int) or (key in target and key in before)
        if is_old and _are_alike(target[key], before[key], new):
            _change(target[key], before[key], new)
        elif isinstance(new, Mapping) and isinstance(target, tomlkit().TOMLDocument):
            target[key] = _fill(tomlkit().table(), new)
        else:
            set_entry(target, key, _item(new))


def _are_alike(*values: Any) -> bool:
    """Whether all values are tables, or all are lists of equal length."""
    if all(isinstance(x, Mapping) for x in values):
        return True
    return all(isinstance(x, list) for x in values) and len({len(x) for x in values}) == 1


def _names(top: Mapping[str, Any]) -> list[Any]:
    return [row.get(NAME.name) for row in top.get("joints", ())]


def _item(value: Any) -> Any:
    """Return a value of `load` as tomlkit writes it."""
    kit = tomlkit()
    if isinstance(value, Number):
        return kit.value(str(value))
    if isinstance(value, list):
        array = kit.array()
        for entry in value:
            array.append(_item(entry))
        return array
    if isinstance(value, Mapping):
        return _fill(kit.inline_table(), value)
    return kit.item(value)


def _fill(table: Any, values: Mapping[str, Any]) -> Any:
    for key, entry in values.items():
        table.append(key, _item(entry))
    return table


def in_text_of(like: str | Path | None, wanted: str, normal: Callable[[str], str]) -> tuple[str, str]:
    """Return `wanted` merged into the text of a file, or alone for another format; and a line on lost comments."""
    if like is None or Path(like).suffix.lower() not in TOML.suffixes:
        return wanted, ""
    text = load_text(like)
    try:
        return with_changes(text, wanted, normal), ""
    except InputError as error:
        return wanted, f"comments and order of {like} are not kept: {error.what}" if "#" in text else ""
