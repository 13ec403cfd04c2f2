"""Tolerances of a scene for reduced models: how they are read and written."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from symoro_elastic.formats.toml.key import NUMBER, Key, Type, one_of
from symoro_elastic.formats.toml.tables import Table
from symoro_elastic.machine.within import ALL_RESULTS, GUARANTEES, Evidence, Keep, Tolerance, Within, tolerance

PERCENTAGE = {"type": "string", "pattern": r"^\s*[0-9.eE+*/() ]+%?\s*$"}
ONE = {"anyOf": [NUMBER.schema, PERCENTAGE]}


def _tolerances(table: Table, key: str) -> dict[str, Tolerance]:
    """Read one tolerance for all results, or a table of tolerances by result or joint."""
    written = table.entries[key]
    if isinstance(written, dict):
        of = table.table(key)
        return {name: _tolerance(of, name, entry) for name, entry in of.entries.items()}
    return {ALL_RESULTS: _tolerance(table, key, written)}


def _tolerance(table: Table, key: str, entry: Any) -> Tolerance:
    if isinstance(entry, bool) or not isinstance(entry, str | int | float):
        raise table.fail(key, 'must be a text in percent, as in "1 %", or a number in the unit of the result')
    with table.refusing(key):
        return tolerance(entry, key)


TOLERANCES = Type(
    "percentage, number, or table of them",
    {"anyOf": [ONE, {"type": "object", "additionalProperties": ONE}]},
    _tolerances,
)
WITHIN = Key(
    *("within", TOLERANCES),
    "how far results may be from those of the whole model while joints are within their limits, of the largest value "
    "or in the unit of the result, for all or by result or joint; terms are left out until only so much is kept; "
    "frequencies are the natural ones, with a tolerance of each or in Hz",
    '{ tau = "1 %", motor_y = 0.5, frequencies = "0.5 %" }',
    default={},
    otherwise="exact",
)
KEEP = Key(
    *("keep", one_of(tuple(Keep))),
    "omitted parts: single terms; terms of the inertia matrix and the potential, from which all else is derived; "
    "or parameters only; with the last two the inertia matrix stays symmetric and the machine passive",
    '"parameters"',
    default=Keep.TERMS.value,
)
GUARANTEED = Key(
    *("guaranteed", one_of(GUARANTEES)),
    "kind of guarantee: a bound at unseen states with 95 % confidence, or a proof for the whole box",
    '"proven"',
    default=Evidence.CONFIDENT.value,
)

TOLERANCES_OF_SCENE = (WITHIN, KEEP, GUARANTEED)
KEYS = tuple(key.name for key in TOLERANCES_OF_SCENE)


def within_of(entries: Mapping[str, Any]) -> Within:
    """Return the tolerances from the three keys of a scene (within, keep, guaranteed)."""
    return Within(entries[WITHIN.name], Keep(entries[KEEP.name]), Evidence(entries[GUARANTEED.name]))


def entries_of(within: Within) -> dict[str, Any]:
    """Values of the scene keys within, keep and guaranteed, as TOML writes them; empty without tolerances."""
    if not within:
        return {}
    written = {name: _written(tolerance) for name, tolerance in within.tolerances.items()}
    entries: dict[str, Any] = {WITHIN.name: written[ALL_RESULTS] if [*written] == [ALL_RESULTS] else written}
    entries |= {KEEP.name: str(within.keep)} if within.keep is not Keep.TERMS else {}
    return entries | ({GUARANTEED.name: str(within.guaranteed)} if within.guaranteed is Evidence.PROVEN else {})


def _written(tolerance: Tolerance) -> str | float:
    return str(tolerance) if tolerance.relative else tolerance.value
