"""Syntax of .par files: statements `key = value`, and comments, of which those that begin with `(*toml` hold TOML.

SYMORO skips lines in which a comment begins, and no others: so each line of TOML is a comment of its own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from symoro_elastic.formats.par.keys import Place, names
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.foundation.errors import TWICE, InputError
from symoro_elastic.machine.names import did_you_mean, quote

INERTIAL = names(Place.INERTIAL)
GEOMETRIC = names(Place.GEOMETRIC)
BODY = (*INERTIAL, *names(Place.ACTING))
JOINT = names(Place.JOINT)
VECTORS = names(Place.BASE)
LISTS = (*GEOMETRIC, *BODY, *JOINT, *VECTORS, *names(Place.FRAME))
NUMBERS = names(Place.NUMBER)
ALIASES = {
    **{key.capitalize(): key for key in (*GEOMETRIC, "eta", "k") if key.capitalize() not in LISTS},
    **{key.capitalize(): key for key in ("IA", "FV", "FS")},
    **{"type": "Type", "Nl": "NL", "Nj": "NJ", "Nf": "NF"},
}
MARK = "toml"
"""What follows `(*` where a comment holds TOML."""
# Headings that writers of .par files put in; they are not remarks about the machine.
HEADINGS = (
    "Geometric parameters",
    "Dynamic parameters and external forces",
    "Joint parameters",
    "Velocity and acceleration of the base",
    "Acceleration of gravity",
    "Transformation of 0 frame position fT0",
    "End of definition",
)

_STATEMENT = re.compile(r"\s*([A-Za-z_]\w*)[ \t]*=(?:\s*(\{[^{}]*\})[ \t]*|([^\n;{}]*))(?:[\n;]|\Z)", re.ASCII)
ROBOT = re.compile(r"""\s*Robotname\s*=\s*(['"])(.*)\1\s*""", re.IGNORECASE)


@dataclass
class ParText:
    """Entries of a .par file by their exact keys, values as text; `robot` is its Robotname.

    `block` are the entries of its lines of TOML, `lines` the texts of those of the form `(*! key = value *)`.
    """

    source: str
    numbers: dict[str, str] = field(default_factory=dict)
    lists: dict[str, list[str]] = field(default_factory=dict)
    block: dict[str, Any] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    robot: str = ""


def take_apart(text: str, source: str) -> ParText:
    """Split a .par text into its entries; raises `InputError` naming key or line."""
    par = ParText(source)
    text = _without_comments(text.replace("\r\n", "\n").replace("\r", "\n"), par)
    position = 0
    while text[position:].strip():
        match = _STATEMENT.match(text, position)
        if not match:
            raise _no_statement(text, position, source)
        _store(par, *match.groups())
        position = match.end()
    return par


def _without_comments(text: str, par: ParText) -> str:
    """The text with comments replaced by blanks and stored in `par`; TOML keeps its line numbers."""
    pieces, block, position = [], list[str](), 0
    line = written = 0
    while (start := text.find("(*", position)) >= 0:
        end = text.find("*)", start + 2)
        if end < 0:
            what = "a comment is opened here and never closed: add *)"
            raise InputError(par.source, _line(text, start), what)
        comment = text[start + 2 : end]
        line += text.count("\n", position, start)
        if re.match(rf"{MARK}(\s|$)", comment):
            block.append(
                "\n" * max(line - written, 1 if block else 0) + " " * len("(*" + MARK) + comment.removeprefix(MARK)
            )
            written += block[-1].count("\n")
        else:
            _keep(par, comment)
        inside = comment.count("\n")
        line += inside
        pieces.append(text[position:start] + " " + "\n" * inside)
        position = end + 2
    if block:
        par.block = load("".join(block), par.source).entries
    return "".join(pieces) + text[position:]


def _keep(par: ParText, comment: str) -> None:
    if comment.startswith("!"):
        par.lines.append(comment[1:])
    elif named := ROBOT.fullmatch(comment):
        par.robot = named[2]
    elif comment.strip() and comment.strip() not in HEADINGS:
        par.comments.append(comment.strip())


def _line(text: str, position: int) -> str:
    return f"line {text.count(chr(10), 0, position) + 1}"


def _no_statement(text: str, position: int, source: str) -> InputError:
    start = position + len(text[position:]) - len(text[position:].lstrip())
    line = text[start:].split("\n", 1)[0]
    opened = re.match(r"([A-Za-z_]\w*)\s*=\s*\{[^{}]*(.?)", text[start:], re.ASCII)
    if opened and opened[2] != "}":
        return InputError(source, opened[1], f"the list opened on {_line(text, start)} is not closed: add }}")
    what = f"{quote(line)} is not an entry: write key = value or key = {{v1, v2, ...}}"
    return InputError(source, _line(text, start), what)


def _store(par: ParText, key: str, listed: str | None, single: str | None) -> None:
    exact = key if key in LISTS or key in NUMBERS else ALIASES.get(key, key)
    if exact not in LISTS and exact not in NUMBERS:
        raise InputError(par.source, key[:60], f"no such key in a .par file{did_you_mean(key, (*LISTS, *NUMBERS))}")
    if exact in par.lists or exact in par.numbers:
        raise InputError(par.source, exact, TWICE)
    if exact in NUMBERS:
        if listed is not None or not (single or "").strip():
            raise InputError(par.source, exact, f"must be one number: {exact} = 1")
        par.numbers[exact] = (single or "").strip()
        return
    if listed is None:
        raise InputError(par.source, exact, f"must be a list in braces: {exact} = {{v1, v2, ...}}")
    par.lists[exact] = entries(listed, exact, par.source)


def entries(listed: str, key: str, source: str) -> list[str]:
    """Split a list `{a, b}` into its entries; a comma after the last one is allowed."""
    parts, depth, start = [], 0, 1
    for match in re.finditer(r"[(),]", listed):
        depth += {"(": 1, ")": -1}.get(match[0], 0)
        if match[0] == "," and depth == 0:
            parts.append(listed[start : match.start()])
            start = match.end()
    parts.append(listed[start:-1])
    if len(parts) > 1 and not parts[-1].strip():
        parts.pop()
    parts = [" ".join(part.split()) for part in parts]
    if parts == [""]:
        return []
    if "" in parts:
        raise InputError(source, key, f"entry {parts.index('') + 1} is empty: write 0")
    return parts
