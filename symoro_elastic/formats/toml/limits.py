"""The table [limits] of a machine file, and tolerances of its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from symoro_elastic.formats.toml.key import NUMBER, Key, Section, Type, list_of_numbers, reference_to
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import FormulaError, number
from symoro_elastic.machine.limits import (
    LIMITED,
    TORQUE,
    UNITS,
    JointLimits,
    Limits,
    Range,
    unit_of,
    why_no_range,
    why_unlimited,
)
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.names import no_such, quote

HEADING = "limits"
PERCENT = "%"
PAIR = list_of_numbers(2)


def _range(table: Table, key: str) -> Range:
    """Range under a key: a list of two ends, or one number for a symmetric range."""
    if isinstance(table.entries[key], list):
        low, high = PAIR.read(table, key)
    else:
        high = NUMBER.read(table, key)
        if high < 0:
            raise table.fail(key, f"{high:g} is negative: give the largest value both ways, or [low, high]")
        low = -high + 0.0
    if reason := why_no_range(low, high):
        raise table.fail(key, reason)
    return Range(low, high)


def _tolerance(table: Table, key: str) -> float | str:
    """Tolerance under a key: a number, or a text in percent."""
    entry = table.entries[key]
    if isinstance(entry, str) and not isinstance(entry, Number) and entry.rstrip().endswith(PERCENT):
        try:
            number(entry.rstrip().removesuffix(PERCENT))
        except FormulaError as error:
            raise table.fail(key, f"{quote(entry)} is not a percentage: {error}") from None
        return entry
    tolerance: float = NUMBER.read(table, key)
    return tolerance


RANGE = Type("number x for -x to x, or list of 2 numbers", {"anyOf": [NUMBER.schema, PAIR.schema]}, _range)
PERCENTAGE = r"^\s*[0-9.eE+*/() ]+%\s*$"
TOLERANCE = Key(
    "tolerance",
    Type(
        "number, or text in percent",
        {"anyOf": [{"type": "string", "pattern": PERCENTAGE}, reference_to("formula")]},
        _tolerance,
    ),
    "how far the true value may be from it either way, in SI units or in percent of it; a parameter without value has "
    "none",
    '"10 %"',
    otherwise="none",
)
MEANINGS = {
    "position": "range of the joint variable",
    "velocity": "range of its velocity",
    "acceleration": "range of its acceleration",
    TORQUE: "range of the torque or force of its motor, or of its spring",
}
EXAMPLES = {"position": "[-1.5, 2]", "velocity": "3", "acceleration": "20", TORQUE: "[-40, 60]"}
LIMITS = Section(
    f"[{HEADING}]",
    "Limits by joint: of joints with a variable of their own, coupled ones follow others. A number x is the range from "
    "-x to x, a list its two ends. No equation depends on them: `excite`, `view`, `show` and sweeps use them, and "
    "inside of them hold what `check --proven` guarantees and what `--within` leaves out.",
    tuple(
        Key(name, RANGE, MEANINGS[name], EXAMPLES[name], otherwise="none", unit=" or ".join(UNITS[name]))
        for name in LIMITED
    ),
    "joint",
)


# Reading


def limits_of(top: Table, machine: DescribedMachine, listed: Table) -> Limits:
    """Read the limits in the top table of a file; `listed` is the table of parameters. Raises `InputError`."""
    return Limits(_of_joints(top.table(HEADING), machine), dict(_of_parameters(listed, machine.parameters)))


def _of_joints(table: Table, machine: Machine) -> dict[str, JointLimits]:
    numbers = machine.rows
    limits = {}
    for name in table.entries:
        if name not in numbers:
            raise InputError(table.source, HEADING, no_such("joint", name, numbers))
        entry = table.table(name).only(LIMITS.names)
        ranges = {
            key.name: _of_joint(entry, key, machine, numbers[name]) for key in LIMITS.keys if key.name in entry.entries
        }
        limits[name] = JointLimits(**ranges)
    return {name: limit for name, limit in limits.items() if limit}


def _of_joint(entry: Table, key: Key, machine: Machine, j: int) -> Range:
    if reason := why_unlimited(machine, j, key.name):
        raise entry.fail(key.name, reason)
    range_of_joint: Range = replace(key, unit=unit_of(key.name, machine.joint(j))).read(entry)
    return range_of_joint


def _of_parameters(listed: Table, parameters: Sequence[Parameter]) -> Iterator[tuple[str, Range]]:
    for parameter in parameters:
        if isinstance(listed.entries[parameter.name], dict) and TOLERANCE.name in listed.entries[parameter.name]:
            yield parameter.name, _of_parameter(listed.table(parameter.name), parameter)


def _of_parameter(entry: Table, parameter: Parameter) -> Range:
    if parameter.value is None:
        raise entry.fail(TOLERANCE.name, "it has no value, so no tolerance: give it a value")
    tolerance_entry = replace(TOLERANCE, unit=parameter.unit).read(entry)
    with entry.refusing(TOLERANCE.name):
        value = parameter.value.table_value()
        tolerance = _absolute(tolerance_entry, value)
        if not tolerance > 0:
            what = "is not above zero: leave it out where the value is exact"
            raise entry.fail(TOLERANCE.name, f"{tolerance_entry} of {value:g} {what}")
        return Range(value - tolerance, value + tolerance)


def _absolute(tolerance: float | str, value: float) -> float:
    """A tolerance as written, converted to the unit of the value."""
    if isinstance(tolerance, str):
        return abs(value) * number(tolerance.rstrip().removesuffix(PERCENT)) / 100
    return tolerance


# Writing


def _written(interval: Range, both: bool) -> str:
    if interval.is_symmetric and not both:
        return _number(interval.high)
    return f"[{_number(interval.low)}, {_number(interval.high)}]"


def _number(x: float) -> str:
    return repr(x + 0.0).removesuffix(".0")


def written_tolerance(value: float, tolerated: Range) -> str:
    """A tolerance as TOML text: in percent if that is short and exact, else as a number."""
    half = (tolerated.high - tolerated.low) / 2
    share = f"{100 * half / abs(value):.6g} {PERCENT}" if value else ""
    if share and _ranges(value, _absolute(share, value), tolerated):
        return f'"{share}"'
    nearby = (*(float(f"{half:.{digits}g}") for digits in (6, 12)), tolerated.high - value, value - tolerated.low)
    return _number(next((x for x in nearby if _ranges(value, x, tolerated)), half))


def _ranges(value: float, tolerance: float, tolerated: Range) -> bool:
    return (value - tolerance, value + tolerance) == (tolerated.low, tolerated.high)


def limits_by_joint(limits: Limits) -> Mapping[str, list[tuple[str, str]]]:
    """Limit entries of joints as TOML texts by name: one number for a symmetric range."""
    return {
        name: [(key, _written(x, key == LIMITED[0])) for key in LIMITED if (x := getattr(limit, key)) is not None]
        for name, limit in limits.joints.items()
    }
