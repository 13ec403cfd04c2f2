"""A changed machine or scene in the text of the file that it came from: comments, order and units of the rest stay.

What changed is the difference of two texts in normal form, as `writing` has them: the file as it is read, and what is
to be saved. The new text is taken if it reads back as exactly that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.toml.editing import MOST_CHARACTERS, tomlkit
from symoro_elastic.formats.toml.keys import NAME
from symoro_elastic.formats.toml.tables import Number, load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.format_names import TOML


def with_changes(text: str, wanted: str, normal: Callable[[str], str]) -> str:
    """Return the text of a file with the contents of `wanted`, which is in normal form.

    `normal` reads a text and returns it in normal form. Raises `InputError` where the contents cannot be written into
    the text, or tomlkit is not installed.
    """
    kit = tomlkit()
    if len(text) > MOST_CHARACTERS:
        raise InputError("file", "text", f"it has more than {MOST_CHARACTERS} characters")
    try:
        document, before, after = kit.parse(text), *(load(one, "file").entries for one in (normal(text), wanted))
        if _names(before) != _names(after):
            raise LookupError("other joints: comments are not about these")
        _change(document, before, after)
        found = str(document.as_string())
        if normal(found) == wanted:
            return found
    except (InputError, kit.exceptions.TOMLKitError, LookupError, TypeError, ValueError, RecursionError):
        pass
    raise InputError("file", "text", "what changed does not fit into its text")


def _change(whole: Any, before: Any, after: Any) -> None:
    """Set in a table or a list of tomlkit what differs between two tables, or between two lists of one length."""
    if isinstance(after, Mapping):
        for key in before.keys() - after.keys():
            if key in whole:
                del whole[key]
        changed = {key: new for key, new in after.items() if key not in before or before[key] != new}
    else:
        changed = {k: new for k, new in enumerate(after) if before[k] != new}
    for key, new in changed.items():
        is_old = isinstance(key, int) or (key in whole and key in before)
        if is_old and _are_alike(whole[key], before[key], new):
            _change(whole[key], before[key], new)
        elif isinstance(new, Mapping) and isinstance(whole, tomlkit().TOMLDocument):
            whole[key] = _filled(tomlkit().table(), new)
        else:
            whole[key] = _item(new)


def _are_alike(*values: Any) -> bool:
    """Whether all are tables, or lists of one length."""
    if all(isinstance(x, Mapping) for x in values):
        return True
    return all(isinstance(x, list) for x in values) and len({len(x) for x in values}) == 1


def _names(top: Mapping[str, Any]) -> list[Any]:
    return [row.get(NAME.name) for row in top.get("joints", ())]


def _item(value: Any) -> Any:
    """What tomlkit writes for a value as `load` gives it."""
    kit = tomlkit()
    if isinstance(value, Number):
        return kit.value(str(value))
    if isinstance(value, list):
        found = kit.array()
        for one in value:
            found.append(_item(one))
        return found
    if isinstance(value, Mapping):
        return _filled(kit.inline_table(), value)
    return kit.item(value)


def _filled(table: Any, values: Mapping[str, Any]) -> Any:
    for key, one in values.items():
        table.append(key, _item(one))
    return table


def in_text_of(like: str | Path | None, wanted: str, normal: Callable[[str], str]) -> tuple[str, str]:
    """Return `wanted` in the text of a file, or as it is where that is no TOML file; and a line on lost comments."""
    if like is None or Path(like).suffix.lower() not in TOML.suffixes:
        return wanted, ""
    text = load_text(like)
    try:
        return with_changes(text, wanted, normal), ""
    except InputError as error:
        return wanted, f"comments and order of {like} are not kept: {error.what}" if "#" in text else ""
