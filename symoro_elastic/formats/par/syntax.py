"""Syntax of .par files: statements `key = value`, comments, and `(*! key = value *)` lines.

The values of the latter are texts, lists `{a, b}` and tables `{a = b}` of them.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import declared
from symoro_elastic.machine.formats.par_keys import Place, names
from symoro_elastic.machine.machine import Joint
from symoro_elastic.machine.names import did_you_mean, quoted

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
EXTENDED = tuple(key for column in declared(Joint) for key in column.par if key not in LISTS)
"""Cells of joints that are no lists of the format: they stand in extension lines."""
EXTENSIONS = tuple(dict.fromkeys((*names(Place.EXTENSION), *EXTENDED)))
# Headings that writers of .par files put in; they are no remarks about the machine.
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
_EXTENSION = re.compile(r"\s*([A-Za-z_]\w*)\s*=(.*)", re.DOTALL | re.ASCII)
ROBOT = re.compile(r"""\s*Robotname\s*=\s*(['"])(.*)\1\s*""", re.IGNORECASE)
_STRING = re.compile(r'"(?:[^"\\]|\\.)*"')
_SIGN = re.compile(r'[(){}=,"]')
MAX_DEPTH = 5


@dataclass
class ParText:
    """Entries of a .par file by their exact keys, values as written; `robot` is its Robotname."""

    source: str
    numbers: dict[str, str] = field(default_factory=dict)
    lists: dict[str, list[str]] = field(default_factory=dict)
    extensions: dict[str, Any] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    robot: str = ""


def take_apart(text: str, source: str) -> ParText:
    """The entries of a .par text; raises `InputError` naming key or line."""
    found = ParText(source)
    text = _without_comments(text.replace("\r\n", "\n").replace("\r", "\n"), found)
    position = 0
    while text[position:].strip():
        match = _STATEMENT.match(text, position)
        if not match:
            raise _no_statement(text, position, source)
        _store(found, *match.groups())
        position = match.end()
    return found


def _without_comments(text: str, found: ParText) -> str:
    rest, position = [], 0
    while (start := text.find("(*", position)) >= 0:
        end = text.find("*)", start + 2)
        if end < 0:
            what = "a comment is opened here and never closed: add *)"
            raise InputError(found.source, _line(text, start), what)
        comment = text[start + 2 : end]
        _keep(found, comment)
        rest.append(text[position:start] + " " + "\n" * comment.count("\n"))
        position = end + 2
    return "".join(rest) + text[position:]


def _keep(found: ParText, comment: str) -> None:
    if comment.startswith("!"):
        _extension(found, comment[1:])
    elif named := ROBOT.fullmatch(comment):
        found.robot = named[2]
    elif comment.strip() and comment.strip() not in HEADINGS:
        found.comments.append(comment.strip())


def _line(text: str, position: int) -> str:
    return f"line {text.count(chr(10), 0, position) + 1}"


def _no_statement(text: str, position: int, source: str) -> InputError:
    start = position + len(text[position:]) - len(text[position:].lstrip())
    line = text[start:].split("\n", 1)[0]
    opened = re.match(r"([A-Za-z_]\w*)\s*=\s*\{[^{}]*(.?)", text[start:], re.ASCII)
    if opened and opened[2] != "}":
        return InputError(source, opened[1], f"the list opened on {_line(text, start)} is not closed: add }}")
    what = f"{quoted(line)} is no entry: write key = value or key = {{v1, v2, ...}}"
    return InputError(source, _line(text, start), what)


def _store(found: ParText, key: str, listed: str | None, single: str | None) -> None:
    exact = key if key in LISTS or key in NUMBERS else ALIASES.get(key, key)
    if exact not in LISTS and exact not in NUMBERS:
        raise InputError(found.source, key[:60], f"no such key in a .par file{did_you_mean(key, (*LISTS, *NUMBERS))}")
    if exact in found.lists or exact in found.numbers:
        raise InputError(found.source, exact, "is given twice: keep one")
    if exact in NUMBERS:
        if listed is not None or not (single or "").strip():
            raise InputError(found.source, exact, f"must be one number: {exact} = 1")
        found.numbers[exact] = (single or "").strip()
        return
    if listed is None:
        raise InputError(found.source, exact, f"must be a list in braces: {exact} = {{v1, v2, ...}}")
    found.lists[exact] = entries(listed, exact, found.source)


def entries(listed: str, key: str, source: str) -> list[str]:
    """The entries of a list `{a, b}`, a comma after the last one allowed."""
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


def _extension(found: ParText, text: str) -> None:
    match = _EXTENSION.fullmatch(text)
    if not match:
        raise InputError(found.source, "(*! ... *)", f"{quoted(text.strip())} is no entry: write (*! key = value *)")
    key = match[1]
    if key not in EXTENSIONS:
        raise InputError(found.source, f"(*! {key[:60]} *)", f"no such key{did_you_mean(key, EXTENSIONS)}")
    if key in found.extensions:
        raise InputError(found.source, f"(*! {key} *)", "is given twice: keep one")
    found.extensions[key] = _Value(match[2], key, found.source).parse()


class _Value:
    """The value of an extension line: text, `{value, ...}` or `{key = value, ...}`."""

    def __init__(self, text: str, key: str, source: str) -> None:
        self.text, self.key, self.source = text, key, source
        self.position = 0

    def parse(self) -> Any:
        value = self.value(0)
        if self.peek():
            raise self.fail(f"{quoted(self.text[self.position :].strip())} is not expected here")
        return value

    def fail(self, what: str) -> InputError:
        return InputError(self.source, f"(*! {self.key} *)", what)

    def peek(self) -> str:
        while self.position < len(self.text) and self.text[self.position].isspace():
            self.position += 1
        return self.text[self.position : self.position + 1]

    def value(self, depth: int) -> Any:
        if depth > MAX_DEPTH:
            raise self.fail("nested too deeply")
        return self.braces(depth) if self.peek() == "{" else self.word()

    def word(self) -> str:
        quotes = _STRING.match(self.text, self.position) if self.peek() == '"' else None
        end = quotes.end() if quotes else self.end_of_bare_word()
        word = self.text[self.position : end].strip()
        if not word:
            raise self.fail(f"a value is missing before {quoted(self.text[self.position :])}")
        self.position = end
        if not quotes:
            return " ".join(word.split())
        try:
            return str(json.loads(word, strict=False))
        except ValueError:
            raise self.fail(f"{quoted(word)} holds an escape that is not known") from None

    def end_of_bare_word(self) -> int:
        depth = 0
        for sign in _SIGN.finditer(self.text, self.position):
            depth += {"(": 1, ")": -1}.get(sign[0], 0)
            if sign[0] in '{}="' or (sign[0] == "," and depth <= 0):
                return sign.start()
        return len(self.text)

    def braces(self, depth: int) -> Any:
        self.position += 1
        items: list[Any] = []
        table: dict[str, Any] = {}
        while self.peek() != "}":
            item = self.value(depth + 1)
            if self.peek() == "=" and isinstance(item, str):
                self.position += 1
                if item in table:
                    raise self.fail(f"{quoted(item)} is given twice")
                table[item] = self.value(depth + 1)
            else:
                items.append(item)
            if self.peek() == ",":
                self.position += 1
            elif self.peek() != "}":
                raise self.fail("a comma or } is missing")
        self.position += 1
        if items and table:
            raise self.fail("mixes a list and a table")
        return table or items
