"""Typed access to the tables of a TOML text; every error names its place and the expected type."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import Any

from symoro_elastic.formats.joint_cells import formula, whole
from symoro_elastic.foundation.errors import InputError, refusing
from symoro_elastic.machine.formula import MAX_LENGTH, ZERO, Formula
from symoro_elastic.machine.machine import NO_VECTOR, Vector3
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.quantities.unit_reader import in_si, number_in_si

MAX_DOTS = 8
QUANTITY = ("value", "unit")
"""Keys of a number with its unit."""
_STRING_OR_COMMENT = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\Z)|' + r"'''.*?(?:'''|\Z)|" + r'"(?:[^"\\\n]++|\\.)*+"?|' + r"'[^'\n]*'?|#[^\n]*",
    re.DOTALL,
)
"""A string that is not closed ends with its line or the text: each character is looked at once."""
_RUN = re.compile(r"[\w\-. \t]+", re.ASCII)


class Number(str):
    """A number with a point or an exponent, kept as its text; also nan and inf."""


def load(text: str, source: str) -> Table:
    """Parse a TOML text to tables; raises `InputError` naming the line."""
    _check_words(text, source)
    try:
        return Table(tomllib.loads(text, parse_float=Number), source)
    except tomllib.TOMLDecodeError as error:
        what, line = re.fullmatch(r"(.*?)(?: \(at (.*)\))?", str(error), re.DOTALL).groups()  # type: ignore[union-attr]
        raise InputError(source, line or "file", f"not TOML: {' '.join(what.split())[:200]}") from None
    except RecursionError:
        raise InputError(source, "file", "nested too deeply: entries need at most four levels") from None


def table_of(entries: Mapping[str, Any], source: str) -> Table:
    """Return the table of a Python mapping, as if it were in a TOML file; raises `InputError`."""
    return Table(_as_written(entries, source), source)


def _as_written(value: Any, source: str) -> Any:
    """Convert a Python value as the TOML reader would give it: numbers with a point as texts, sequences as lists."""
    if isinstance(value, Mapping):
        return {str(key): _as_written(x, source) for key, x in value.items()}
    if isinstance(value, bool | str):
        return value
    if hasattr(value, "tolist"):
        return _as_written(value.tolist(), source)
    if isinstance(value, Sequence):
        return [_as_written(x, source) for x in value]
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return Number(repr(value))
    what = f"{type(value).__name__} is not a value of a table: give numbers, texts, truth values, lists and mappings"
    raise InputError(source, "table", what)


def _check_words(text: str, source: str) -> None:
    """Raise `InputError` for keys of many parts and numbers of many digits before TOML is parsed.

    Its time and memory grow with the square of their number.
    """
    for run in _RUN.finditer(_STRING_OR_COMMENT.sub("s", text)):
        if run[0].count(".") > MAX_DOTS:
            raise InputError(source, "file", f"{quote(run[0].strip())} has more than {MAX_DOTS} dots: keys need fewer")
        for word in run[0].split():
            if len(word) > MAX_LENGTH:
                what = f"{quote(word)} has {len(word)} characters: numbers and keys have at most {MAX_LENGTH}"
                raise InputError(source, "file", what)


@dataclass(frozen=True)
class Table:
    """A table of a file: its entries, the file and its place in it; `units` are those of the entry being read."""

    entries: dict[str, Any]
    source: str
    place: str = ""
    units: str = ""

    def at(self, key: str) -> str:
        """Name of an entry's place for messages."""
        return f"{self.place}, {key}" if self.place else key

    def fail(self, key: str, what: str) -> InputError:
        """The error to raise about one entry."""
        return InputError(self.source, self.at(key), what)

    def refusing(self, key: str) -> AbstractContextManager[None]:
        """Return a context that converts errors of formulas and units to `InputError` about one entry."""
        return refusing(self.source, self.at(key))

    def only(self, allowed: Iterable[str]) -> Table:
        """Return the table; raises `InputError` for keys that are not `allowed`."""
        for key in self.entries:
            if key not in allowed:
                label = key if re.fullmatch(r"\w{1,60}", key) else quote(key)
                raise self.fail(label, f"no such key here{did_you_mean(key, allowed)}")
        return self

    def without(self, key: str) -> Table:
        """The table without one entry."""
        return replace(self, entries={name: x for name, x in self.entries.items() if name != key})

    def table(self, key: str) -> Table:
        """The table under `key`, empty when absent."""
        entries = self.entries.get(key, {})
        if not isinstance(entries, dict):
            raise self.fail(key, "must be a table: { key = value, ... }")
        return Table(entries, self.source, self.at(key), self.units)

    def tables(self, key: str) -> list[Table]:
        """The list of tables under `key`."""
        entries = self.entries.get(key, [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise self.fail(key, "must be a list of tables: [ { key = value, ... }, ... ]")
        return [Table(entry, self.source) for entry in entries]

    def text(self, key: str, default: str | None = None) -> str:
        """Text under `key`; without a default it is required."""
        text = self.entries.get(key, default)
        if text is None:
            raise self.fail(key, "is missing")
        if not isinstance(text, str) or isinstance(text, Number):
            raise self.fail(key, "must be a text in quotes")
        return text

    def texts(self, key: str) -> tuple[str, ...]:
        """The list of texts under `key`."""
        texts = self.entries.get(key, [])
        if not isinstance(texts, list) or not all(isinstance(e, str) and not isinstance(e, Number) for e in texts):
            raise self.fail(key, "must be a list of texts in quotes")
        return tuple(texts)

    def truth(self, key: str) -> bool:
        """The truth value under `key`."""
        truth = self.entries[key]
        if not isinstance(truth, bool):
            raise self.fail(key, "must be true or false")
        return truth

    def whole(self, key: str) -> int:
        """Integer under `key`."""
        value = self.entries[key]
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.fail(key, "must be a whole number")
        return whole(value, self.source, self.at(key))

    def formula(self, key: str, default: Formula = ZERO) -> Formula:
        """The number or formula under `key`."""
        return self.cell(self.entries[key], key) if key in self.entries else default

    def formulas(self, key: str, lengths: tuple[int, ...]) -> tuple[Formula, ...]:
        """The list of numbers or formulas under `key`, with one of the `lengths`."""
        entries = self.entries[key]
        expected = " or ".join(map(str, lengths))
        if not isinstance(entries, list):
            raise self.fail(key, f"must be a list of {expected} numbers or formulas")
        if len(entries) not in lengths:
            raise self.fail(key, f"has {len(entries)} entries, expected {expected}")
        return tuple(self.cell(entry, key) for entry in entries)

    def vector(self, key: str) -> Vector3:
        """The three numbers or formulas under `key`, zero when absent."""
        if key not in self.entries:
            return NO_VECTOR
        x, y, z = self.formulas(key, (3,))
        return x, y, z

    def cell(self, value: Any, key: str) -> Formula:
        """Formula of a cell: a number or a formula, or a table of a value and its unit."""
        if isinstance(value, dict):
            value = self._with_unit(value, key)
        if isinstance(value, bool) or not isinstance(value, int | str):
            raise self.fail(key, "must be a number, or a formula in quotes")
        if is_not_finite(value):
            raise self.fail(key, f"{value} is not finite")
        if isinstance(value, Number):
            value = value.replace("_", "")
        elif isinstance(value, str):
            with self.refusing(key):
                value = in_si(value, self.units)
        return formula(value, self.source, self.at(key))

    def _with_unit(self, entries: dict[str, Any], key: str) -> str:
        """Text of a number with its unit: "350 mm" for { value = 350, unit = "mm" }."""
        entry = Table(entries, self.source, self.at(key)).only(QUANTITY)
        value, unit = entries.get("value"), entry.text("unit")
        if not is_plain_number(value):
            raise entry.fail("value", 'must be a number: write { value = 350, unit = "mm" }, or "350 mm"')
        with entry.refusing("unit"):
            return number_in_si(str(value).replace("_", ""), unit, self.units)


def is_plain_number(value: Any) -> bool:
    """Whether a value from TOML is a finite number, not a text or a formula."""
    return isinstance(value, int | Number) and not isinstance(value, bool) and not is_not_finite(value)


def is_not_finite(value: Any) -> bool:
    """Whether a value from TOML is nan or inf."""
    return isinstance(value, Number) and "n" in value
