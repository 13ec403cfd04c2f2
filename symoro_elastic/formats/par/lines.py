"""Lines `(*! key = value *)` of .par files before version 0.2, converted to TOML.

Values are texts, lists `{a, b}` and tables `{a = b}` of them.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

from symoro_elastic.formats.par.syntax import LISTS
from symoro_elastic.foundation.errors import TWICE, InputError
from symoro_elastic.machine.columns import declared_columns
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.names import did_you_mean, no_such, quote

CELLS = {column.par[0]: column for column in declared_columns(Joint) if column.par[0] not in LISTS}
"""Cells of joints that are not lists of the format, by their keys."""
OF_LOOPS = ("closes", "dependent", "start")
KEYS = (
    *("name", "names", "parameters", "values", "units", "variable", "loops", "start", "order", *CELLS, "central"),
    *("notes", "scene", "motion", "wanted", "extras", "orientation"),
)
_LINE = re.compile(r"\s*([A-Za-z_]\w*)\s*=(.*)", re.DOTALL | re.ASCII)
_STRING = re.compile(r'"(?:[^"\\]|\\.)*"')
_SIGN = re.compile(r'[(){}=,"]')
MAX_DEPTH = 5
Fail = Callable[[str, str], InputError]


def values_of(lines: Iterable[str], source: str) -> dict[str, Any]:
    """Values of extension lines by their keys; raises `InputError`."""
    values: dict[str, Any] = {}
    for line in lines:
        match = _LINE.fullmatch(line)
        if not match:
            raise InputError(source, "(*! ... *)", f"{quote(line.strip())} is not an entry: write (*! key = value *)")
        key = match[1]
        if key not in KEYS:
            raise InputError(source, f"(*! {key[:60]} *)", f"no such key{did_you_mean(key, KEYS)}")
        if key in values:
            raise InputError(source, f"(*! {key} *)", TWICE)
        values[key] = _Value(match[2], key, source).parse()
    return values


def as_toml(lines: Mapping[str, Any], bodies: int, joints: int, source: str) -> dict[str, Any]:
    """Return the TOML entries equivalent to extension lines, in a file with these numbers of bodies and joints.

    Raises `InputError` for a value of another form.
    """

    def fail(key: str, what: str) -> InputError:
        return InputError(source, f"(*! {key} *)", what)

    count = 2 * joints - bodies
    names = _texts(lines, "names", fail) if "names" in lines else [f"j{j}" for j in range(1, count + 1)]
    if len(names) != count:
        raise fail("names", f"must be a list of {count} names, one a joint")
    entries = {key: lines[key] for key in ("name", "motion", "wanted", "extras") if key in lines}
    for keys, entry, make in (
        (("notes",), "notes", lambda: _texts(lines, "notes", fail)),
        (("names", "order", "variable"), "joints", lambda: _rows(lines, names, fail)),
        (("parameters", "values", "units"), "parameters", lambda: _parameters(lines, fail)),
        (("loops", "start", "order"), "loops", lambda: _loops(lines, names, bodies, joints, fail)),
        (("orientation",), "base", lambda: {"floating": lines["orientation"]}),
        (("scene",), "scene", lambda: _scene(lines, fail)),
    ):
        if not lines.keys().isdisjoint(keys):
            entries[entry] = make()
    _add_cells(entries, lines, names, (bodies, joints, count), fail)
    return entries


def _add_cells(
    entries: dict[str, Any], lines: Mapping[str, Any], names: Sequence[str], lengths: Collection[int], fail: Fail
) -> None:
    """Add the joint cells that are lists, and bodies about their centre of mass, to the TOML entries."""
    for key, column in CELLS.items():
        cells = _texts(lines, key, fail)
        if key in lines and len(cells) not in lengths:
            raise fail(key, f"must be a list of {len(names)} entries, one a joint")
        for name, cell in zip(names, cells, strict=False):
            if cell != "0":
                entries.setdefault(column.section, {}).setdefault(name, {})[column.key] = cell
    bodies = lines.get("central") or {}
    for name, cells in bodies.items() if isinstance(bodies, dict) else [("", bodies)]:
        if not isinstance(cells, list) or len(cells) != 9:
            raise fail("central", f"{name} must be a list of 9: x y z XX XY XZ YY YZ ZZ")
        entries.setdefault("bodies", {})[name] = {"center_of_mass": cells[:3], "inertia": cells[3:]}


def _texts(lines: Mapping[str, Any], key: str, fail: Fail) -> list[str]:
    texts = lines.get(key, [])
    if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
        raise fail(key, 'must be a list of texts: {"one", "two"}')
    return texts


def _table(lines: Mapping[str, Any], key: str, fail: Fail) -> dict[str, str]:
    table = lines.get(key) or {}
    if not isinstance(table, dict) or not all(isinstance(x, str) for x in table.values()):
        raise fail(key, "must be a table: {name = value, ...}")
    return table


def _rows(lines: Mapping[str, Any], names: Sequence[str], fail: Fail) -> list[dict[str, str]]:
    order = _texts(lines, "order", fail) if "order" in lines else names
    if sorted(order) != sorted(names):
        raise fail("order", f"must name each of the {len(names)} joints once")
    variables = _table(lines, "variable", fail)
    for name in variables:
        if name not in names:
            raise fail("variable", no_such("joint", name, names))
    return [{"name": name, **({"variable": variables[name]} if name in variables else {})} for name in order]


def _parameters(lines: Mapping[str, Any], fail: Fail) -> dict[str, Any]:
    values, units = _table(lines, "values", fail), _table(lines, "units", fail)
    names = dict.fromkeys([*_texts(lines, "parameters", fail), *values, *units])
    parameters = {name: {"value": values[name]} if name in values else {} for name in names}
    return {name: {"unit": units.get(name, ""), **entry} for name, entry in parameters.items()}


def _loops(lines: Mapping[str, Any], names: Sequence[str], bodies: int, joints: int, fail: Fail) -> dict[str, Any]:
    count, start = joints - bodies, _table(lines, "start", fail)
    if start and not count:
        raise fail("start", f"the machine has no closed loop (NJ = NL = {bodies}): leave it out")
    loops = lines.get("loops", [f"loop_{k}" for k in range(1, count + 1)])
    if isinstance(loops, list) and all(isinstance(name, str) for name in loops):
        loops = {name: {} for name in loops}
    if not isinstance(loops, dict):
        raise fail("loops", "must be names, or a table: {left = {closes = point}, right = {}}")
    if len(loops) != count:
        raise fail("loops", f"names {len(loops)} loops, expected {count} of different names (NJ - NL)")
    by_name = {}
    for k, (name, entries) in enumerate(loops.items()):
        if not isinstance(entries or {}, dict) or not set(entries) <= set(OF_LOOPS):
            raise fail("loops", f"{name} must be a table with any of {', '.join(OF_LOOPS)}: {{closes = point}}")
        ends = {"cut": names[bodies + k], "meets": names[joints + k]}
        by_name[name] = {**ends, "start": start, **(entries or {})}
        by_name[name]["start"] = by_name[name]["start"] or {}
    return by_name


def _scene(lines: Mapping[str, Any], fail: Fail) -> dict[str, Any]:
    entries = lines["scene"] or {}
    if not isinstance(entries, dict):
        raise fail("scene", "must be a table: {models = {...}, ...}")
    entries = {key: value or {} if key in ("outputs", "locked") else value for key, value in entries.items()}
    for key in entries.keys() & {"gravity", "condense"}:
        entries[key] = {"true": True, "false": False}.get(str(entries[key]), entries[key])
    return entries


class _Value:
    """The value of an extension line: text, `{value, ...}` or `{key = value, ...}`."""

    def __init__(self, text: str, key: str, source: str) -> None:
        self.text, self.key, self.source = text, key, source
        self.position = 0

    def parse(self) -> Any:
        value = self.value(0)
        if self.peek():
            raise self.fail(f"{quote(self.text[self.position :].strip())} is not expected here")
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
            raise self.fail(f"a value is missing before {quote(self.text[self.position :])}")
        self.position = end
        if not quotes:
            return " ".join(word.split())
        try:
            return str(json.loads(word, strict=False))
        except ValueError:
            raise self.fail(f"{quote(word)} holds an escape that is not known") from None

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
                    raise self.fail(f"{quote(item)} {TWICE}")
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
