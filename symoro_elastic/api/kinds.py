"""Kinds of values that options take: how they are read from the command line and from TOML files."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from symoro_elastic.foundation.errors import NOT_FINITE, TWICE, InputError

if TYPE_CHECKING:
    from symoro_elastic.formats.toml.tables import Table

T = TypeVar("T")
COMMAND = "symoro-elastic"
POINT_SIZE = 3


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of values.

    `parse(text, option)` reads it from the command line, from all texts given where there are `many`; without it the
    text is the value. `read(table, key)` reads it from a TOML file; without it no file holds it. `shape` is what it is
    in Python. `forms` are the suffixes of files that are written. What `has_numbers` may have units; what `is_text` is
    parsed when these are converted.
    """

    parse: Callable[[Any, str], Any] | None = None
    read: Callable[[Table, str], Any] | None = None
    many: bool = False
    shape: str = ""
    forms: Sequence[str] = ()
    has_numbers: bool = False
    is_text: bool = False


def number(text: str, unit: str | None = None, scale: int = 1) -> Any:
    """Return a number, or the value of a formula of numbers, read as in a machine file; raises `ValueError`.

    A number with a unit is converted to `unit`, times `scale`; without, it stays a text, which the machine converts.
    """
    from symoro_elastic.machine import formula
    from symoro_elastic.quantities.unit_reader import in_si, in_two, readings

    try:
        if unit is None and (parts := in_two(text)):
            readings(parts[1])
            return text.strip()
        si = in_si(text, unit or "")
        return formula.number(si if si == text else f"{scale}*({si})")
    except ValueError as error:
        raise ValueError(f"is not a number: {error}") from None


def whole_number(text: str) -> int:
    """Return a whole number, of any size; raises `ValueError`."""
    number(text, "")
    if not text.strip().lstrip("+-").isdecimal():
        raise ValueError("is not a whole number")
    return int(text)


def values_by_name(texts: Sequence[str], option: str, parse: Callable[[str], T], form: str) -> dict[str, T]:
    """Return values by name, from `NAME=VALUE`.

    Raises `InputError` for what `parse` refuses, and for two values of a name.
    """
    values: dict[str, T] = {}
    for text in texts:
        name, _, written = (part.strip() for part in text.rpartition("="))
        try:
            value = parse(written)
        except ValueError as error:
            raise InputError(COMMAND, option, f"{text.removeprefix('=')!r}{form}{_reason(error)}") from None
        if values.setdefault(name, value) != value:
            raise InputError(COMMAND, option, f"{name or 'the value of all'} {TWICE}")
    return values


def _reason(error: ValueError) -> str:
    """Return why a text is not a number, for the end of a message."""
    return str(error).removeprefix("is not a number") if str(error).startswith("is not a number") else ""


def numbers(texts: Sequence[str], option: str) -> dict[str, float]:
    """Return numbers by name, from `NAME=X`."""
    form = " is not NAME=NUMBER"
    for text in texts:
        if "=" not in text:
            raise InputError(COMMAND, option, f"{text!r}{form}")
    return values_by_name(texts, option, number, form)


def texts_by_name(texts: Sequence[str], option: str) -> dict[str, str]:
    """Return texts by name, from `NAME=TEXT`; raises `InputError` for two texts of a name."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, written = (part.strip() for part in text.partition("="))
        if not (name and equals and written):
            raise InputError(COMMAND, option, f"{text!r} is not NAME=VALUES")
        if name in values:
            raise InputError(COMMAND, option, f"{name} {TWICE}")
        values[name] = written
    return values


def numbers_or_default(texts: Sequence[str], option: str) -> dict[str, float]:
    """Return numbers by name, from `NAME=X` or `X`; a number without name has the name ""."""
    return numbers([text if "=" in text else f"={text}" for text in texts], option)


def numbers_or_none(texts: Sequence[str], option: str) -> dict[str, float | None]:
    """Return numbers by name, from `NAME=X`, None from `NAME`."""
    valued = numbers([text for text in texts if "=" in text], option)
    return {name: valued.get(name) for name in (text.partition("=")[0].strip() for text in texts)}


def ranges(texts: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Return ranges by name, from `NAME=LOW:HIGH` or `NAME=X` for -X:X; a range without name has the name ""."""
    return values_by_name(texts, option, _low_high, " is not a limit: X, LOW:HIGH, NAME=X ...")


def _low_high(limits: str) -> tuple[Any, Any]:
    low, colon, high = limits.partition(":")
    ends = number(low), number(high if colon else low)
    if colon:
        return ends
    return (f"-{ends[0]}".removeprefix("--") if isinstance(ends[0], str) else -ends[0]), ends[1]


def bounds(texts: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Return ranges by name, from `NAME=LOW:HIGH`, with one end optional."""
    return values_by_name(texts, option, _ends, " is not NAME=LOW:HIGH, NAME=LOW: or NAME=:HIGH")


def _ends(text: str) -> tuple[float, float]:
    """Return the ends of a range, infinite by default; raises `ValueError` for reversed ones."""
    low, colon, high = (part.strip() for part in text.partition(":"))
    ends = number(low, "") if low else -math.inf, number(high, "") if high else math.inf
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


def gains(texts: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Return proportional and derivative gain by motor, from `MOTOR=KP:KD`."""
    for text in texts:
        if ":" not in text:
            what = f"{text!r} is not MOTOR=KP:KD, in N/m and N s/m or N m/rad and N m s/rad"
            raise InputError(COMMAND, option, what)
    return ranges(texts, option)


def springs_on_joints(texts: Sequence[str], option: str) -> dict[str, tuple[float, ...]]:
    """Return stiffness, and rotor inertia if stated, by joint, from `JOINT=K[:IA]`."""
    form = " is not JOINT=K or JOINT=K:IA, in N m/rad and kg m2 or N/m and kg"
    for text in texts:
        if "=" not in text or text.count(":") > 1:
            raise InputError(COMMAND, option, f"{text!r}{form}")
    return values_by_name(texts, option, lambda written: tuple(map(number, written.split(":"))), form)


def grid(texts: Sequence[str], option: str) -> dict[str, Any]:
    """Return positions by joint, from `JOINT=LOW:HIGH:COUNT[,log]` or `JOINT=X1,X2,...`; texts if they have units.

    Raises `InputError` for too many.
    """
    from symoro_elastic.analysis.sweeps.ranges import Listed, axis
    from symoro_elastic.analysis.vibration.tracking import refuse_grid
    from symoro_elastic.api.quantities import has_unit

    written = texts_by_name(texts, option)
    if any(map(has_unit, written.values())):
        return dict(written)
    try:
        axes = {name: axis(name, text) for name, text in written.items()}
    except InputError as error:
        raise InputError(COMMAND, option, error.what) from None
    listed = {name: axis_values for name, axis_values in axes.items() if isinstance(axis_values, Listed)}
    for name in axes.keys() - listed.keys():
        raise InputError(COMMAND, option, f"{f'{name}={written[name]}'!r}{LOW_HIGH_COUNT}")
    if listed:
        refuse_grid([axis_values.count for axis_values in listed.values()], COMMAND)
    return {name: axis_values.values() for name, axis_values in listed.items()}


def band(text: str | None, option: str) -> tuple[float, float, int] | None:
    """Return lowest and highest frequency, Hz, and number of points, from `LOW:HIGH[:COUNT]`."""
    if text is None:
        return None
    from symoro_elastic.analysis.vibration.responses import POINTS, refuse_band

    complete = text if text.count(":") > 1 else f"{text}:{POINTS}"
    try:
        low, high, count = _low_high_count(complete, "Hz")
    except ValueError as error:
        raise InputError(COMMAND, option, f"{text!r}{LOW_HIGH_COUNT}{_reason(error)}") from None
    refuse_band(low, high, count, COMMAND)
    return low, high, count


def bands(texts: Sequence[str], option: str) -> tuple[tuple[float, float], ...]:
    """Return bands of frequencies, Hz, from `LOW:HIGH`."""
    intervals = []
    for text in texts:
        try:
            low, high = (number(part, "Hz") for part in text.split(":"))
            if not 0 <= low < high:
                raise ValueError
        except ValueError as error:
            what = f"{text!r}: give LOW:HIGH, two rising numbers of Hz{_reason(error)}"
            raise InputError(COMMAND, option, what) from None
        intervals.append((low, high))
    return tuple(intervals)


def spindle_speeds(text: str | None, option: str) -> tuple[float, float, int] | None:
    """Return lowest and highest speed, turns per minute, and number of speeds, from `LOW:HIGH:COUNT`."""
    if text is None:
        return None
    try:
        low, high, count = _low_high_count(text, "Hz", 60)
        if not 0 < low <= high or count > MOST_SPEEDS:
            raise ValueError
    except ValueError as error:
        what = f"{LOW_HIGH_COUNT} to {MOST_SPEEDS}, speeds above zero{_reason(error)}"
        raise InputError(COMMAND, option, f"{text!r}{what}") from None
    return low, high, count


def _low_high_count(text: str, unit: str, scale: int = 1) -> tuple[float, float, int]:
    """Return the numbers of `LOW:HIGH:COUNT`, multiplied by `scale` if they have units; raises `ValueError`."""
    *ends, last = text.split(":")
    low, high = (number(end, unit, scale) for end in ends)
    count = number(last, "")
    if count != int(count) or count < 1:
        raise ValueError
    return low, high, int(count)


MOST_SPEEDS = 10_000
LOW_HIGH_COUNT = ": give LOW:HIGH:COUNT, numbers and a count from 1"


def bound(angle: float | None, option: str) -> float | None:
    """Return a finite bound on an angle, rad, or None."""
    if angle is not None and not isinstance(angle, str) and not math.isfinite(angle):
        raise InputError(COMMAND, option, f"{angle} is not a bound: write the largest angle, rad")
    return angle


def requested_outputs(texts: Sequence[str], option: str) -> dict[str, tuple[str, ...]]:
    """Return requested outputs by model, from `MODEL=NAME` or `MODEL by NAMES`."""
    from symoro_elastic.machine.scene import BY

    outputs: dict[str, tuple[str, ...]] = {}
    for text in texts:
        model, equals, name = (part.strip() for part in text.partition("="))
        if not equals:
            model, by, name = (part.strip() for part in text.partition(BY))
            name = f"{by} {name}".strip()
        if not (model and name):
            what = f"{text!r} is not MODEL=NAME, as in 'jacobian=tool at (0.1, 0, L2) in base'"
            raise InputError(COMMAND, option, what)
        outputs[model] = (*outputs.get(model, ()), name)
    return outputs


def point(text: str | None, option: str) -> tuple[float, ...] | None:
    """Return three numbers, from `X,Y,Z`; raises `InputError`."""
    if text is None:
        return None
    parts = [part.strip() for part in str(text).strip("() ").split(",")]
    if len(parts) != POINT_SIZE:
        raise InputError(COMMAND, option, f"{text!r} is not three numbers: give the number alone for each")
    numbers = []
    for part in parts:
        try:
            numbers.append(number(part))
        except ValueError as error:
            raise InputError(COMMAND, option, f"{text!r}: {part!r} {error}") from None
    return tuple(numbers)


def comma_separated(texts: Sequence[str], _option: str) -> tuple[str, ...]:
    """Return names, from `NAME` or `NAME,NAME`."""
    return tuple(name.strip() for names in texts for name in names.split(","))


def _point_in(table: Table, key: str) -> tuple[float, ...]:
    numbers = _list_in(table, key)
    if len(numbers) != POINT_SIZE:
        raise table.fail(key, f"{len(numbers)} numbers are not a point: give three")
    return numbers


def _number_in(table: Table, key: str) -> Any:
    """Return the number under a key, a text if it has a unit; raises `InputError` for nan and inf."""
    from symoro_elastic.formats.toml.tables import Number
    from symoro_elastic.quantities.unit_reader import in_two

    entry = table.entries[key]
    if isinstance(entry, str) and not isinstance(entry, Number) and in_two(entry):
        try:
            return number(entry)
        except ValueError as error:
            raise table.fail(key, f"{entry!r} {error}") from None
    if isinstance(entry, bool) or not isinstance(entry, int | Number):
        raise table.fail(key, "must be a number")
    value = float(entry)
    if not math.isfinite(value):
        raise table.fail(key, f"{value:g} {NOT_FINITE}")
    return value


def _list_in(table: Table, key: str) -> tuple[float, ...]:
    """Return the list of numbers under a key."""
    from symoro_elastic.formats.toml.tables import Table

    entry = table.entries[key]
    if not isinstance(entry, list):
        raise table.fail(key, "must be a list of numbers")
    return tuple(_number_in(Table({key: x}, table.source, table.place), key) for x in entry)


def _pair_in(table: Table, key: str) -> tuple[float, ...]:
    """Return the two numbers under a key."""
    pair = _list_in(table, key)
    if len(pair) != 2:
        raise table.fail(key, "must be a list of two numbers")
    return pair


def _axis_in(table: Table, key: str) -> Any:
    """Return the values, or the text, of an axis of a sweep."""
    from symoro_elastic.analysis.sweeps.ranges import axis
    from symoro_elastic.api.quantities import has_unit
    from symoro_elastic.formats.toml.tables import Number

    entry = table.entries[key]
    if isinstance(entry, str) and not isinstance(entry, Number):
        try:
            if not has_unit(entry):
                axis(key, entry)
        except InputError as error:
            raise table.fail(key, error.what) from None
        return entry
    return _list_in(table, key) if isinstance(entry, list) else _number_in(table, key)


def _by_name(read: Callable[[Table, str], Any]) -> Callable[[Table, str], dict[str, Any]]:
    """Return a reader of tables of values by name."""
    return lambda table, key: {name: read(table.table(key), name) for name in table.table(key).entries}


def output_file(*forms: str) -> Kind:
    """Return the kind of output files, whose suffix determines the format."""
    return Kind(shape="file", forms=forms)


def tolerances(texts: Sequence[str], option: str) -> dict[str, str]:
    """Return tolerances by name, an unnamed one for all others; raises `InputError` for a repeated name."""
    by_name: dict[str, str] = {}
    for text in texts:
        name, _, value = text.rpartition("=")
        if name.strip() in by_name:
            raise InputError(COMMAND, option, f"{name.strip() or 'a tolerance for all'} {TWICE}")
        by_name[name.strip()] = value
    return by_name


FLAG = Kind(read=lambda table, key: table.truth(key), shape="truth value")
TEXT = Kind(read=lambda table, key: table.text(key), shape="text")
TEXTS = Kind(read=lambda table, key: table.texts(key), many=True, shape="list of texts")
TEXTS_BY_NAME = Kind(texts_by_name, many=True, shape="texts by name")
WORDS = Kind(comma_separated, lambda table, key: table.texts(key), many=True, shape="list of texts")
NUMBER = Kind(read=_number_in, shape="number", has_numbers=True)
BOUND = Kind(bound, _number_in, shape="number", has_numbers=True)
WHOLE = Kind(read=lambda table, key: table.whole(key), shape="whole number")
POINT = Kind(point, _point_in, shape="three numbers", has_numbers=True, is_text=True)
LIST = Kind(read=_list_in, many=True, shape="list of numbers", has_numbers=True)
NUMBERS = Kind(numbers, _by_name(_number_in), many=True, shape="numbers by name", has_numbers=True)
NUMBERS_OR_DEFAULT = Kind(
    numbers_or_default, _by_name(_number_in), many=True, shape="numbers by name, or one for all", has_numbers=True
)
NUMBERS_OR_NONE = Kind(
    numbers_or_none, _by_name(_number_in), many=True, shape="numbers by name, None where unknown", has_numbers=True
)
RANGES = Kind(ranges, _by_name(_pair_in), many=True, shape="(low, high) by name", has_numbers=True)
BOUNDS = Kind(bounds, _by_name(_ends_in), many=True, shape="(low, high) by name")
LIMITS = Kind(ranges, many=True, shape="one for all, or by name", has_numbers=True)
GAINS = Kind(gains, _by_name(_pair_in), many=True, shape="(proportional, derivative) by name", has_numbers=True)
SPRINGS = Kind(springs_on_joints, many=True, shape="stiffness, or stiffness and inertia, by name", has_numbers=True)
AXES = Kind(texts_by_name, _by_name(_axis_in), many=True, shape="texts or lists of numbers by name", has_numbers=True)
GRID = Kind(grid, many=True, shape="lists of numbers by name", has_numbers=True, is_text=True)
BAND = Kind(band, shape="(low, high, count)")
BANDS = Kind(bands, many=True, shape="list of (low, high)")
SPEEDS = Kind(spindle_speeds, shape="(low, high, count)")
TOLERANCES = Kind(tolerances, many=True, shape="percentage or number, or by name")
REQUESTS = Kind(requested_outputs, many=True, shape="lists of texts by name")
SCENE = Kind(shape="file, tables, or `Scene`")
INPUT_FILE, OUTPUT_FOLDER = Kind(shape="file"), Kind(shape="folder")
