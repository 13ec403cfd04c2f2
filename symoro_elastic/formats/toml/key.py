"""Keys of files: their contents, how they are read, and their entries in the reference and the schemas."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from symoro_elastic.formats.toml.tables import QUANTITY, Number, Table
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import NO_INERTIA, NO_VECTOR
from symoro_elastic.machine.names import did_you_mean, quote

Schema = Mapping[str, Any]
"""A part of a JSON Schema."""

FORMULA_CHARACTERS = r"^(?!.*[A-Za-z_]\s*\.)[-+*/^(),.A-Za-z0-9_\s]+$"
NAME = r"^[A-Za-z](_?[A-Za-z0-9])*_?$"
DEFINITIONS: Schema = {
    "formula": {
        "anyOf": [
            {"type": "number"},
            {"type": "string", "pattern": FORMULA_CHARACTERS, "maxLength": 1000},
            {"$ref": "#/$defs/quantity"},
        ],
        "description": "a number, or a formula of numbers, parameters, pi, + - * / ^ and sin cos tan sqrt atan2",
    },
    "nonnegative": {
        "anyOf": [
            {"type": "number", "minimum": 0},
            {"type": "string", "pattern": FORMULA_CHARACTERS, "maxLength": 1000},
            {"$ref": "#/$defs/quantity"},
        ],
        "description": "a number that is not negative, or a formula",
    },
    "quantity": {
        "type": "object",
        "properties": {"value": {"type": "number"}, "unit": {"type": "string"}},
        "required": ["value", "unit"],
        "additionalProperties": False,
        "description": "a number and its unit, which is converted",
    },
    "name": {"type": "string", "pattern": NAME, "maxLength": 63},
    "names": {"type": "array", "items": {"type": "string"}},
}


def reference_to(name: str) -> Schema:
    """Schema that refers to a definition by name."""
    return {"$ref": f"#/$defs/{name}"}


@dataclass(frozen=True, eq=False)
class Type:
    """Type of a key's value: title, JSON schema, and function that reads it from a table."""

    title: str
    schema: Schema
    read: Callable[[Table, str], Any]


@dataclass(frozen=True)
class Key:
    """A key of a table; its default is None if it is required or its default is computed.

    `otherwise` says that value in words where these are others than the value, `example` is one as TOML writes it.
    """

    name: str
    type: Type
    meaning: str
    example: str
    default: Any = None
    otherwise: str = ""
    unit: str = ""

    @property
    def is_required(self) -> bool:
        """Whether a file must have the key."""
        return self.default is None and not self.otherwise

    @property
    def default_in_words(self) -> str:
        """Default value as TOML text, or in words; empty for a required key."""
        if self.otherwise or self.default in (None, ""):
            return self.otherwise
        if isinstance(self.default, str | bool):
            return json.dumps(self.default)
        return str(self.default or ("none" if self.default in ((), {}) else 0))

    def read(self, table: Table, default: Any = None) -> Any:
        """Read the key's value from a table, or the default; raises `InputError` if missing or of another type."""
        if self.name in table.entries:
            return self.type.read(replace(table, units=self.unit), self.name)
        value = self.default if default is None else default
        if value is None:
            raise table.fail(self.name, "is missing")
        return value

    def optional(self, table: Table) -> Any:
        """Read the key's value from a table, None if it is missing; raises `InputError` for another type."""
        return self.read(table) if self.name in table.entries else None


@dataclass(frozen=True)
class Section:
    """A table of a file, by its heading, with its keys; `rules` are additional rules of the schema.

    Where `entries` is not empty, it holds a table with these keys for each of them, whose names the schema `naming`
    describes; `rows`, a list of such tables, at least `least`.
    """

    heading: str
    meaning: str
    keys: tuple[Key, ...]
    entries: str = ""
    rows: bool = False
    least: int = 1
    rules: Schema = field(default_factory=dict)
    naming: Schema = field(default_factory=lambda: reference_to("name"))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the section's keys."""
        return tuple(key.name for key in self.keys)

    def within(self, table: Table) -> Mapping[str, Any]:
        """Read the values of all keys from a table, defaults included; raises `InputError` for unknown keys."""
        table.only(self.names)
        return {key.name: key.read(table) for key in self.keys}

    @property
    def schema(self) -> Schema:
        """Return the JSON schema of the table."""
        table = {
            "type": "object",
            "properties": {key.name: schema_of(key) for key in self.keys},
            "required": [key.name for key in self.keys if key.is_required],
            "additionalProperties": False,
            **self.rules,
        }
        if self.rows:
            return {"type": "array", "items": table, "minItems": self.least}
        by_name = {"type": "object", "propertyNames": self.naming, "additionalProperties": table}
        return by_name if self.entries else table

    @property
    def type(self) -> Type:
        """Type of a key whose value is such a table."""
        if self.rows:
            return Type("list of tables", self.schema, Table.tables)
        return Type("table of tables" if self.entries else "table", self.schema, Table.table)


def schema_of(key: Key) -> Schema:
    """Return the JSON schema of a key."""
    notes = [key.unit, key.default_in_words and f"default {key.default_in_words}"]
    details = "; ".join(note for note in notes if note)
    return {**key.type.schema, "description": f"{key.meaning} ({details})" if details else key.meaning}


def _by_name(title: str, schema: Schema, read: Callable[[Table, str], Any]) -> Type:
    """Type of a table with values by name."""

    def read_all(table: Table, key: str) -> dict[str, Any]:
        of = table.table(key)
        return {name: read(of, name) for name in of.entries}

    return Type(title, {"type": "object", "additionalProperties": schema}, read_all)


def _number(table: Table, key: str) -> float:
    """Value of a formula without names."""
    return _value(table, key, table.formula(key))


def _value(table: Table, key: str, cell: Formula) -> float:
    for name in sorted(cell.names):
        raise table.fail(key, f"{quote(name)} is a name: only numbers and formulas of numbers are allowed here")
    with table.refusing(key):
        return cell.table_value()


def _number_or_numbers(table: Table, key: str) -> Any:
    value = table.entries[key]
    by_name = isinstance(value, dict) and value.keys() != {*QUANTITY}
    return (NUMBERS if by_name else NUMBER).read(table, key)


def _tensor(table: Table, key: str) -> tuple[Formula, ...]:
    """Six entries of a tensor, from six entries or the three of its diagonal."""
    entries = table.formulas(key, (3, 6))
    if len(entries) == 6:
        return entries
    xx, yy, zz = entries
    return xx, ZERO, ZERO, yy, ZERO, zz


def _list_schema(*lengths: int) -> Schema:
    return {
        "type": "array",
        "items": reference_to("formula"),
        "anyOf": [{"minItems": length, "maxItems": length} for length in lengths],
    }


TEXT = Type("text", {"type": "string"}, Table.text)
NAMED = Type("name", reference_to("name"), Table.text)
TEXTS = Type("list of texts", reference_to("names"), Table.texts)
TRUTH = Type("true or false", {"type": "boolean"}, Table.truth)
WHOLE = Type("whole number", {"type": "integer"}, Table.whole)
FORMULA = Type("number or formula", reference_to("formula"), Table.formula)
NOT_NEGATIVE = Type("number or formula, not negative", reference_to("nonnegative"), Table.formula)
VECTOR = Type("3 numbers or formulas", _list_schema(3), Table.vector)
TENSOR = Type("3 or 6 numbers or formulas", _list_schema(3, 6), _tensor)
FORMULAS = _by_name("table of numbers or formulas", reference_to("formula"), Table.formula)
NUMBER = Type("number, or formula of numbers", reference_to("formula"), _number)
NUMBERS = _by_name("table of numbers", reference_to("formula"), _number)
NUMBER_OR_NUMBERS = Type("number, or table of numbers", {"anyOf": [NUMBER.schema, NUMBERS.schema]}, _number_or_numbers)
LISTS_OF_TEXTS = _by_name("table of lists of texts", reference_to("names"), Table.texts)
TABLE_OF_TEXTS = _by_name("table of texts", {"type": "string"}, Table.text)
NOTHING = {FORMULA: ZERO, NOT_NEGATIVE: ZERO, VECTOR: NO_VECTOR, TENSOR: NO_INERTIA}
"""Zeros of the types of columns."""


def list_of_numbers(*lengths: int) -> Type:
    """Type of a list of numbers with one of the `lengths`."""

    def read(table: Table, key: str) -> tuple[float, ...]:
        return tuple(_value(table, key, cell) for cell in table.formulas(key, lengths))

    return Type(f"{' or '.join(map(str, lengths))} numbers", _list_schema(*lengths), read)


def one_of(words: tuple[str, ...]) -> Type:
    """Type of a text that is one of `words`."""

    def read(table: Table, key: str) -> str:
        text = table.text(key)
        if text not in words:
            raise table.fail(key, f"no {key} {quote(text)}{did_you_mean(text, words)}")
        return text

    return Type(" or ".join(f'"{word}"' for word in words), {"enum": list(words)}, read)


def some_of(words: Iterable[str]) -> Type:
    """Type of a list of some of `words`."""
    return Type("list of texts", {"type": "array", "items": {"enum": list(words)}}, Table.texts)


def is_text(value: Any) -> bool:
    """Return whether a value from TOML is a text, and not a number with a point."""
    return isinstance(value, str) and not isinstance(value, Number)
