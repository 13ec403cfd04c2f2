"""Kinds of values that options take: how they are read from the command line and from TOML files."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from symoro_elastic.foundation.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.formats.toml.tables import Table

T = TypeVar("T")
COMMAND = "symoro-elastic"


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of values.

    `parse(text, option)` reads it from the command line, from all texts given where there are `many`; without it the
    text is the value. `read(table, key)` reads it from a TOML file; without it no file holds it. `shape` is what it is
    in Python. `forms` are the suffixes of files that are written.
    """

    parse: Callable[[Any, str], Any] | None = None
    read: Callable[[Table, str], Any] | None = None
    many: bool = False
    shape: str = ""
    forms: Sequence[str] = ()


def number(text: str) -> float:
    """Return a number, or the value of a formula of numbers, read as in a machine file; raises `ValueError`."""
    from symoro_elastic.machine import formula

    try:
        return formula.number(text)
    except ValueError as error:
        raise ValueError(f"is not a number: {error}") from None


def whole_number(text: str) -> int:
    """Return a whole number, of any size; raises `ValueError`."""
    number(text)
    if not text.strip().lstrip("+-").isdecimal():
        raise ValueError("is not a whole number")
    return int(text)


def named(given: Sequence[str], option: str, parse: Callable[[str], T], form: str) -> dict[str, T]:
    """Return values by name, from `NAME=VALUE`.

    Raises `InputError` for what `parse` refuses, and for two values of a name.
    """
    values: dict[str, T] = {}
    for text in given:
        name, _, written = (part.strip() for part in text.rpartition("="))
        try:
            value = parse(written)
        except ValueError as error:
            reason = str(error).removeprefix("is not a number")
            raise InputError(COMMAND, option, f"{text.removeprefix('=')!r}{form}{reason}") from None
        if values.setdefault(name, value) != value:
            what = f"{name or 'the value of all'} is given twice: give it one value"
            raise InputError(COMMAND, option, what)
    return values


def numbers(given: Sequence[str], option: str) -> dict[str, float]:
    """Return numbers by name, from `NAME=X`."""
    form = " is not NAME=NUMBER"
    for text in given:
        if "=" not in text:
            raise InputError(COMMAND, option, f"{text!r}{form}")
    return named(given, option, number, form)


def texts_by_name(given: Sequence[str], option: str) -> dict[str, str]:
    """Return texts by name, from `NAME=TEXT`; raises `InputError` for two texts of a name."""
    values: dict[str, str] = {}
    for text in given:
        name, equals, written = (part.strip() for part in text.partition("="))
        if not (name and equals and written):
            raise InputError(COMMAND, option, f"{text!r} is not NAME=VALUES")
        if name in values:
            raise InputError(COMMAND, option, f"{name} is given twice: give it one value, list or range")
        values[name] = written
    return values


def numbers_or_default(given: Sequence[str], option: str) -> dict[str, float]:
    """Return numbers by name, from `NAME=X` or `X`; a number without name has the name ""."""
    return numbers([text if "=" in text else f"={text}" for text in given], option)


def numbers_or_none(given: Sequence[str], option: str) -> dict[str, float | None]:
    """Return numbers by name, from `NAME=X`, None from `NAME`."""
    valued = numbers([text for text in given if "=" in text], option)
    return {name: valued.get(name) for name in (text.partition("=")[0].strip() for text in given)}


def ranges(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Return ranges by name, from `NAME=LOW:HIGH` or `NAME=X` for -X:X; a range without name has the name ""."""
    return named(given, option, _low_high, " is not a limit: X, LOW:HIGH, NAME=X ...")


def _low_high(limits: str) -> tuple[float, float]:
    low, colon, high = limits.partition(":")
    return (number(low), number(high)) if colon else (-number(low), number(low))


def bounds(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Return ranges by name, from `NAME=LOW:HIGH`, of which one end may be left out."""
    return named(given, option, _ends, " is not NAME=LOW:HIGH, NAME=LOW: or NAME=:HIGH")


def _ends(text: str) -> tuple[float, float]:
    """Return the ends of a range, infinite where they are left out; raises `ValueError` where it is none."""
    low, colon, high = (part.strip() for part in text.partition(":"))
    ends = number(low) if low else -math.inf, number(high) if high else math.inf
    if not colon or not (low or high) or not ends[0] <= ends[1]:
        raise ValueError
    return ends


def _ends_in(table: Table, key: str) -> tuple[float, float]:
    """Return a range that is written as LOW:HIGH in a file."""
    text = table.text(key)
    try:
        return _ends(text)
    except ValueError:
        raise table.fail(key, f"{text!r} is not LOW:HIGH, LOW: or :HIGH") from None


def gains(given: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Return proportional and derivative gain by motor, from `MOTOR=KP:KD`."""
    for text in given:
        if ":" not in text:
            what = f"{text!r} is not MOTOR=KP:KD, in N/m and N s/m or N m/rad and N m s/rad"
            raise InputError(COMMAND, option, what)
    return ranges(given, option)


def springs_on_joints(given: Sequence[str], option: str) -> dict[str, tuple[float, ...]]:
    """Return stiffness, and inertia of the rotor where it is given, by joint, from `JOINT=K[:IA]`."""
    form = " is not JOINT=K or JOINT=K:IA, in N m/rad and kg m2 or N/m and kg"
    for text in given:
        if "=" not in text or text.count(":") > 1:
            raise InputError(COMMAND, option, f"{text!r}{form}")
    return named(given, option, lambda written: tuple(map(number, written.split(":"))), form)


def grid(given: Sequence[str], option: str) -> dict[str, list[float]]:
    """Return positions by joint, from `JOINT=LOW:HIGH:COUNT[,log]` or `JOINT=X1,X2,...`.

    Raises `InputError` for too many.
    """
    from symoro_elastic.analysis.sweeps.ranges import Listed, axis
    from symoro_elastic.analysis.vibration.tracking import refuse_grid

    written = texts_by_name(given, option)
    try:
        axes = {name: axis(name, text) for name, text in written.items()}
    except InputError as error:
        raise InputError(COMMAND, option, error.what) from None
    listed = {name: one for name, one in axes.items() if isinstance(one, Listed)}
    for name in axes.keys() - listed.keys():
        raise InputError(COMMAND, option, f"{f'{name}={written[name]}'!r}{LOW_HIGH_COUNT}")
    if listed:
        refuse_grid([one.count for one in listed.values()], COMMAND)
    return {name: one.values() for name, one in listed.items()}


def band(text: str | None, option: str) -> tuple[float, float, int] | None:
    """Return lowest and highest frequency, Hz, and number of points, from `LOW:HIGH[:COUNT]`."""
    if text is None:
        return None
    from symoro_elastic.analysis.vibration.responses import POINTS, refuse_band

    whole = text if text.count(":") > 1 else f"{text}:{POINTS}"
    try:
        low, high, count = _low_high_count(whole)
    except ValueError:
        raise InputError(COMMAND, option, f"{text!r}{LOW_HIGH_COUNT}") from None
    refuse_band(low, high, count, COMMAND)
    return low, high, count


def bands(given: Sequence[str], option: str) -> tuple[tuple[float, float], ...]:
    """Return bands of frequencies, Hz, from `LOW:HIGH`."""
    found = []
    for text in given:
        try:
            low, high = map(number, text.split(":"))
            if not 0 <= low < high:
                raise ValueError
        except ValueError:
            raise InputError(COMMAND, option, f"{text!r}: give LOW:HIGH, two rising numbers of Hz") from None
        found.append((low, high))
    return tuple(found)


def spindle_speeds(text: str | None, option: str) -> tuple[float, float, int] | None:
    """Return lowest and highest speed, turns per minute, and number of speeds, from `LOW:HIGH:COUNT`."""
    if text is None:
        return None
    try:
        low, high, count = _low_high_count(text)
        if not 0 < low <= high or count > MOST_SPEEDS:
            raise ValueError
    except ValueError:
        what = f"{LOW_HIGH_COUNT} to {MOST_SPEEDS}, speeds above zero"
        raise InputError(COMMAND, option, f"{text!r}{what}") from None
    return low, high, count


def _low_high_count(text: str) -> tuple[float, float, int]:
    """Return the numbers of `LOW:HIGH:COUNT`; raises `ValueError` where they are none."""
    low, high, count = map(number, text.split(":"))
    if count != int(count) or count < 1:
        raise ValueError
    return low, high, int(count)


MOST_SPEEDS = 10_000
LOW_HIGH_COUNT = ": give LOW:HIGH:COUNT, numbers and a count from 1"


def bound(given: float | None, option: str) -> float | None:
    """Return a finite bound on an angle, rad, or None."""
    if given is not None and not math.isfinite(given):
        raise InputError(COMMAND, option, f"{given} is not a bound: write the largest angle, rad")
    return given


def requested_outputs(given: Sequence[str], option: str) -> dict[str, tuple[str, ...]]:
    """Return requested outputs by model, from `MODEL=NAME` or `MODEL by NAMES`."""
    from symoro_elastic.machine.scene import BY

    outputs: dict[str, tuple[str, ...]] = {}
    for text in given:
        model, equals, name = (part.strip() for part in text.partition("="))
        if not equals:
            model, by, name = (part.strip() for part in text.partition(BY))
            name = f"{by} {name}".strip()
        if not (model and name):
            what = f"{text!r} is not MODEL=NAME, as in 'jacobian=tool at (0.1, 0, L2) in base'"
            raise InputError(COMMAND, option, what)
        outputs[model] = (*outputs.get(model, ()), name)
    return outputs


def comma_separated(given: Sequence[str], _option: str) -> tuple[str, ...]:
    """Return names, from `NAME` or `NAME,NAME`."""
    return tuple(name.strip() for names in given for name in names.split(","))


def _number_in(table: Table, key: str) -> float:
    """Return the number under a key; raises `InputError` for nan and inf."""
    from symoro_elastic.formats.toml.tables import Number

    given = table.entries[key]
    if isinstance(given, bool) or not isinstance(given, int | Number):
        raise table.fail(key, "must be a number")
    value = float(given)
    if not math.isfinite(value):
        raise table.fail(key, f"{value:g} is not a number to compute with")
    return value


def _list_in(table: Table, key: str) -> tuple[float, ...]:
    """Return the list of numbers under a key."""
    from symoro_elastic.formats.toml.tables import Table

    given = table.entries[key]
    if not isinstance(given, list):
        raise table.fail(key, "must be a list of numbers")
    return tuple(_number_in(Table({key: x}, table.source, table.place), key) for x in given)


def _pair_in(table: Table, key: str) -> tuple[float, ...]:
    """Return the two numbers under a key."""
    pair = _list_in(table, key)
    if len(pair) != 2:
        raise table.fail(key, "must be a list of two numbers")
    return pair


def _axis_in(table: Table, key: str) -> Any:
    """Return the values, or the text, of an axis of a sweep."""
    from symoro_elastic.analysis.sweeps.ranges import axis
    from symoro_elastic.formats.toml.tables import Number

    given = table.entries[key]
    if isinstance(given, str) and not isinstance(given, Number):
        try:
            axis(key, given)
        except InputError as error:
            raise table.fail(key, error.what) from None
        return given
    return _list_in(table, key) if isinstance(given, list) else _number_in(table, key)


def _by_name(read: Callable[[Table, str], Any]) -> Callable[[Table, str], dict[str, Any]]:
    """Return what reads a table of values by name."""
    return lambda table, key: {name: read(table.table(key), name) for name in table.table(key).entries}


def output_file(*forms: str) -> Kind:
    """Return the kind of files that are written, in the format that the suffix says."""
    return Kind(shape="file", forms=forms)


def tolerances(texts: Sequence[str], option: str) -> dict[str, str]:
    """Return tolerances by name, the one without a name for all others; raises `InputError` for a name twice."""
    found: dict[str, str] = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        if name.strip() in found:
            raise InputError(COMMAND, option, f"{name.strip() or 'a tolerance for all'} is given twice: keep one")
        found[name.strip()] = value
    return found


FLAG = Kind(read=lambda table, key: table.truth(key), shape="truth value")
TEXT = Kind(read=lambda table, key: table.text(key), shape="text")
TEXTS = Kind(read=lambda table, key: table.texts(key), many=True, shape="list of texts")
WORDS = Kind(comma_separated, lambda table, key: table.texts(key), many=True, shape="list of texts")
NUMBER = Kind(read=_number_in, shape="number")
BOUND = Kind(bound, _number_in, shape="number")
WHOLE = Kind(read=lambda table, key: table.whole(key), shape="whole number")
LIST = Kind(read=_list_in, many=True, shape="list of numbers")
NUMBERS = Kind(numbers, _by_name(_number_in), many=True, shape="numbers by name")
NUMBERS_OR_DEFAULT = Kind(numbers_or_default, _by_name(_number_in), many=True, shape="numbers by name, or one for all")
NUMBERS_OR_NONE = Kind(numbers_or_none, _by_name(_number_in), many=True, shape="numbers by name, None where unknown")
RANGES = Kind(ranges, _by_name(_pair_in), many=True, shape="(low, high) by name")
BOUNDS = Kind(bounds, _by_name(_ends_in), many=True, shape="(low, high) by name")
LIMITS = Kind(ranges, many=True, shape="one for all, or by name")
GAINS = Kind(gains, _by_name(_pair_in), many=True, shape="(proportional, derivative) by name")
SPRINGS = Kind(springs_on_joints, many=True, shape="stiffness, or stiffness and inertia, by name")
AXES = Kind(texts_by_name, _by_name(_axis_in), many=True, shape="texts or lists of numbers by name")
GRID = Kind(grid, many=True, shape="lists of numbers by name")
BAND = Kind(band, shape="(low, high, count)")
BANDS = Kind(bands, many=True, shape="list of (low, high)")
SPEEDS = Kind(spindle_speeds, shape="(low, high, count)")
TOLERANCES = Kind(tolerances, many=True, shape="percentage or number, or by name")
REQUESTS = Kind(requested_outputs, many=True, shape="lists of texts by name")
SCENE = Kind(shape="file, tables, or `Scene`")
INPUT_FILE, OUTPUT_FOLDER = Kind(shape="file"), Kind(shape="folder")
