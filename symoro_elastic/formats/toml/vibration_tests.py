"""Lists of vibration tests in TOML: the table [[tests]], its keys, and its entries with the names of a machine."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.toml.key import (
    NUMBER,
    NUMBERS,
    TABLE_OF_TEXTS,
    TEXT,
    TEXTS,
    TRUTH,
    WHOLE,
    Key,
    Section,
    Type,
    list_of_numbers,
)
from symoro_elastic.formats.toml.motion_keys import GAINS as SERVO_GAINS
from symoro_elastic.formats.toml.tables import Table, load
from symoro_elastic.foundation.errors import TWICE, InputError
from symoro_elastic.machine.described import DescribedMachine, drives_of
from symoro_elastic.machine.limits import unit_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import did_you_mean, no_such, quote
from symoro_elastic.machine.resolve import joints_by_any_name

Gains = tuple[float, float] | None
"""Kp and Kd of a motor's position controller, None where they are unknown."""
UNKNOWN = "unknown"
ALL = "all"
EVERY_LINE = (0.0, 1e12)


_PAIR = list_of_numbers(2)
_ONE_GAIN = {"anyOf": [{"const": UNKNOWN}, _PAIR.schema]}
GAINS = Type('table of 2 numbers or "unknown"', {"type": "object", "additionalProperties": _ONE_GAIN}, Table.table)

FILE = Key("file", TEXT, "the measurement, relative to this file: .csv, .npz, .uff or .unv", '"hammer_tool.csv"')
AT = Key(
    *("at", NUMBERS, "positions of motors, and of other joints where the search for equilibrium begins"),
    "{ motor_x = 0.3, motor_y = 0 }",
    default={},
    otherwise="0, the start of loops, neutral positions of springs",
    unit="rad or m",
)
HOLD = Key("hold", TEXTS, 'motors held by brakes; "all"', '["all"]', default=())
PD = Key(
    *("pd", GAINS, "gains kp and kd of position controllers that are on; unknown ones are sought"),
    '{ motor_x = [1.5e7, 4e4], motor_y = "unknown" }',
    default={},
    otherwise="motors are free",
    unit="N m/rad and N m s/rad, or N/m and N s/m",
)
DRIVES = Key(
    "drives",
    TEXTS,
    'motors whose drives of `[drives]` are on; "all"',
    '["all"]',
    default=(),
    otherwise="drives are off",
)
BAND = Key(
    "band", _PAIR, "frequencies that are used", "[10, 600]", default=EVERY_LINE, otherwise="all above 0", unit="Hz"
)
AVERAGES = Key("averages", WHOLE, "averages of each response", "10", otherwise="not known")
NONE, HANN, EXPONENTIAL = "none", "hann", "exponential"


def _window(table: Table, key: str) -> tuple[str, float | None]:
    """Window under a key, and its time, s: length of segments, or time constant of an exponential window."""
    if not isinstance(table.entries[key], Mapping):
        name, times = table.text(key), (NONE, HANN)
        if name == EXPONENTIAL:
            what = "has a time constant, in which it falls to 1/e: a fifth of its length where it falls to 1 %"
            raise table.fail(key, f"{what}; write {key} = {{ exponential = 0.12 }}")
        if name not in times:
            raise table.fail(key, no_such("window", name, times))
        return name, None
    of = table.table(key)
    of.only((HANN, EXPONENTIAL))
    if len(of.entries) != 1:
        raise table.fail(key, f"holds {len(of.entries)} windows: give {HANN} or {EXPONENTIAL}, with its time in s")
    (name,) = of.entries
    time = NUMBER.read(replace(of, units=table.units), name)
    if not time > 0:
        raise of.fail(name, f"{time:g} s: give a time above 0")
    return name, time


_TIMES = [{"type": "object", "properties": {name: NUMBER.schema}, "required": [name], "additionalProperties": False}
          for name in (HANN, EXPONENTIAL)]  # fmt: skip
WINDOW = Key(
    "window",
    Type('"none", "hann", table of hann or exponential', {"anyOf": [{"enum": [NONE, HANN]}, *_TIMES]}, _window),
    "window over the records of responses: Hann's, of segments of a length, or an exponential one with a time constant",
    "{ exponential = 0.12 }",
    otherwise="not known: none, and its possible effect is reported",
    unit="s",
)
VALIDATE = Key("validate", TRUTH, "whether the test is predicted, and not fitted", "true", default=False)
RENAME = Key(
    *("rename", TABLE_OF_TEXTS, "OUT/IN by the names of the file; a minus turns a direction, a unit may follow"),
    '{ "3:+Z/3:+Z" = "tool.az/-tool.fz [g/N]" }',
    default={},
    otherwise="names of the file are those of the machine",
)
TESTS = Section(
    "[[tests]]",
    "Vibration tests of a machine in equilibrium, by which `update` finds springs and dampers.",
    (FILE, AT, HOLD, PD, DRIVES, BAND, AVERAGES, WINDOW, VALIDATE, RENAME),
    rows=True,
)
TOP = "tests"


@dataclass(frozen=True)
class ListedTest:
    """An entry of a list of vibration tests, with joint names resolved; `place` is its place in the file `source`."""

    file: str
    path: Path
    at: Mapping[str, float]
    hold: tuple[str, ...]
    pd: Mapping[str, Gains]
    drives: tuple[str, ...]
    band: tuple[float, float]
    averages: int | None
    window: tuple[str, float | None] | None
    validate: bool
    rename: Mapping[str, str]
    source: str
    place: str

    def fail(self, key: str, what: str) -> InputError:
        """The error to raise about one key."""
        return InputError(self.source, f"{self.place}, {key}", what)


def read_list(path: str | Path, machine: Machine) -> tuple[ListedTest, ...]:
    """Read the entries of a list of vibration tests; raises `InputError` naming test and key.

    That is for unknown keys, joints and motors, other units, positions outside limits, motors held and driven.
    """
    top = load(load_text(path), str(path)).only((TOP,))
    tables = top.tables(TOP)
    if not tables:
        raise top.fail(TOP, "holds no test: write a table [[tests]] with file = ... for each")
    return tuple(_entry(table, k, Path(path), machine) for k, table in enumerate(tables, start=1))


def _entry(table: Table, number: int, path: Path, machine: Machine) -> ListedTest:
    file = table.entries.get(FILE.name)
    table = replace(table, place=f"test {number}" + (f" ({file})" if isinstance(file, str) and file else ""))
    table.only(TESTS.names)
    entries = {key.name: key.read(table) for key in TESTS.keys if key not in (AT, AVERAGES, WINDOW)}
    if not entries["file"].strip():
        raise table.fail(FILE.name, "is empty: name the file of the measurement")
    averages = AVERAGES.read(table) if AVERAGES.name in table.entries else None
    if averages is not None and averages < 1:
        raise table.fail(AVERAGES.name, f"{averages}: a response has at least 1 average")
    window = WINDOW.read(table) if WINDOW.name in table.entries else None
    low, high = entries["band"]
    if not 0 <= low < high:
        raise table.fail(BAND.name, f"from {low:g} to {high:g} Hz: give 0 <= LOW < HIGH")
    hold = _locked_motors(table, machine, entries["hold"])
    pd = _driven(table, machine, hold)
    drives = _with_drives(table, machine, entries["drives"], {**dict.fromkeys(hold, HOLD), **dict.fromkeys(pd, PD)})
    return ListedTest(
        entries["file"], path.parent / entries["file"], _positions(table, machine), hold, pd, drives, entries["band"],
        averages, window, entries["validate"], entries["rename"], table.source, table.place,
    )  # fmt: skip


def _positions(table: Table, machine: Machine) -> dict[str, float]:
    """Positions under `at`, by joint; raises `InputError` for values out of range."""
    of, limits = table.table(AT.name), DescribedMachine.of(machine).limits
    moving = {joint.name: joint for joint in machine.independent_joints}
    positions: dict[str, float] = {}
    for key in of.entries:
        name = _name(of, key, machine, moving, "joint")
        unit = unit_of("position", moving[name])
        x = NUMBER.read(replace(of, units=unit), key)
        allowed = limits.of(name).position
        if name in positions:
            raise of.fail(key, f"{name} {TWICE}")
        if allowed and x not in allowed:
            what = f"{x:g} {unit} is outside its limits, {allowed.low:g} to {allowed.high:g} {unit}"
            raise of.fail(key, f"{what}: correct it, or the table [limits] of the machine")
        positions[name] = x
    return positions


def _locked_motors(table: Table, machine: Machine, names: tuple[str, ...]) -> tuple[str, ...]:
    motors = [joint.name for joint in machine.motor_joints]
    locked = motors if ALL in names else [_name(table, name, machine, motors, "motor", HOLD.name) for name in names]
    if len(set(locked)) < len(locked):
        raise table.fail(HOLD.name, f"a motor {TWICE}")
    return tuple(locked)


def _driven(table: Table, machine: Machine, locked: tuple[str, ...]) -> dict[str, Gains]:
    """Read the controller gains kp, kd of a test by motor."""
    of, motors = table.table(PD.name), {joint.name: joint for joint in machine.motor_joints}
    gains: dict[str, Gains] = {}
    for key in of.entries:
        name = _name(of, key, machine, motors, "motor")
        if name in locked:
            raise of.fail(key, f"{name} is held, so its controller does nothing: remove it here or in hold")
        if name in gains:
            raise of.fail(key, f"{name} {TWICE}")
        gains[name] = _gains(of, key, slides=motors[name].sigma == 1)
    return gains


def _with_drives(
    table: Table, machine: Machine, names: tuple[str, ...], otherwise: Mapping[str, Key]
) -> tuple[str, ...]:
    """Motors with active drives, which are neither locked nor under other gains in the test."""
    driven = [*drives_of(machine).by_motor]
    if names and not driven:
        raise table.fail(
            DRIVES.name, "the machine has no [drives]: give it some, or the test pd = { motor = [kp, kd] }"
        )
    under_drives = tuple(
        driven if ALL in names else [_name(table, name, machine, driven, "drive of", DRIVES.name) for name in names]
    )
    for name in under_drives:
        if name in otherwise:
            what = f"{name} is under {otherwise[name].name}, too: remove one of the two"
            raise table.fail(DRIVES.name, what)
    if len(set(under_drives)) < len(under_drives):
        raise table.fail(DRIVES.name, f"a motor {TWICE}")
    return under_drives


def _gains(of: Table, motor: str, slides: bool) -> Gains:
    entry = of.entries[motor]
    if entry == UNKNOWN:
        return None
    if not isinstance(entry, list) or len(entry) != len(SERVO_GAINS):
        raise of.fail(motor, f'must be a list of 2 numbers, kp and kd, or "{UNKNOWN}"')
    gains = []
    for key, x in zip(SERVO_GAINS, entry, strict=True):
        table = Table({key.name: x}, of.source, of.at(motor), key.unit.split(" or ")[slides])
        gains.append(NUMBER.read(table, key.name))
        if gains[-1] < 0:
            raise table.fail(key.name, f"{gains[-1]:g}: a negative gain drives the motor away, give one >= 0")
    return gains[0], gains[1]


def _name(table: Table, name: str, machine: Machine, choices: Collection[str], what: str, place: str = "") -> str:
    """Resolve a joint's name, variable or number; raises `InputError` unless it is one of the choices."""
    joint = joints_by_any_name(machine).get(name, name)
    if joint not in choices:
        raise table.fail(place or name, f"no {what} {quote(name)}{did_you_mean(name, choices)}")
    return joint
