"""Measured motion and torques of a machine, with checks.

A record has `t`, `q_<joint>` for every joint that moves, `tau_<motor>` for every motor, and where they are measured
`qd_<joint>` and `qdd_<joint>`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.column_faults import wraps_of
from symoro_elastic.analysis.time_series.reading import Columns, name_and_unit, read_arrays
from symoro_elastic.analysis.time_series.writing import columns_of, write_columns
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError, some_of
from symoro_elastic.machine.formula import FormulaError, number
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import no_such
from symoro_elastic.quantities.unit_reader import UnitError, conversion

FEWEST = 50  # samples
LONGEST_SLIDE = 10.0  # m
MOST_TURNS = 20.0
UNEVEN = 0.1  # of a sampling period
SLOWEST = 0.5  # s
LARGEST = 1e30  # SI units
SLOPE_RATIO = 3.0
MEASURED_QUANTITIES = ("t", "q", "qd", "qdd", "tau")
SI_UNITS = {"t": ("s", "s"), "tau": ("N m", "N")}

_QUANTITY = re.compile(r"(?P<quantity>[qy]d*|tau)_(?P<joint>.+)")
POWER, ENERGY = "power_", "energy_"
"""Before the names of columns that simulations write and nobody reads."""
_BLOCK = re.compile("[qy]d*|tau")


@dataclass(frozen=True)
class Measurements:
    """Evenly sampled motion: t (N) s, q (N, n) rad or m of the moving joints, tau (N, m) N m or N of the motors.

    `qd`, `qdd` are None where they are not measured; `warnings` are lines for the user.
    """

    t: Array
    q: Array
    tau: Array
    qd: Array | None = None
    qdd: Array | None = None
    source: str = "measurements"
    warnings: tuple[str, ...] = ()

    @cached_property
    def is_even(self) -> bool:
        """Whether all samples are within a tenth of a step of an even clock."""
        even = self.t[0] + self._mean_step * np.arange(len(self.t))
        return bool(np.abs(self.t - even).max() <= UNEVEN * self._mean_step)

    @property
    def period(self) -> float:
        """Sampling period, s; the median if sampling is uneven."""
        return self._mean_step if self.is_even else float(np.median(np.diff(self.t)))

    @property
    def _mean_step(self) -> float:
        return float((self.t[-1] - self.t[0]) / (len(self.t) - 1))

    def columns(self, machine: Machine) -> dict[str, Array]:
        """Return the columns (N) of joints and motors by header."""
        joints, motors = ([x.name for x in some] for some in (machine.independent_joints, machine.motor_joints))
        blocks = (("q", self.q, joints), ("qd", self.qd, joints), ("qdd", self.qdd, joints), ("tau", self.tau, motors))
        return columns_of(self.t, *((quantity, x, names) for quantity, x, names in blocks if x is not None))


Prepare = Callable[[Measurements, Machine], Measurements]
"""Makes a record ready before it is checked."""


def read_measurements(path: str | Path, machine: Machine, prepare: Prepare | None = None) -> Measurements:
    """Read a .csv or .npz file of measurements of a machine; with `prepare` sampling may be uneven, and cells empty.

    Raises `InputError` naming file and column: columns that are missing, unknown or double, cells that are not
    numbers, time that does not increase or has gaps, NaN, too few samples, lengths that are probably mm.
    """
    return measurements_of(read_columns(path, machine, prepare is not None), machine, str(path), prepare)


def measurements_of(
    columns: Mapping[str, Array], machine: Machine, source: str, prepare: Prepare | None = None
) -> Measurements:
    """Return measurements from columns by header, as `read_measurements` does from a file."""
    record = from_columns(columns, machine, source)
    refuse_wrapped(record, machine)
    record = prepare(record, machine) if prepare else record
    return check(record, machine, with_units(columns), must_be_even=prepare is None)


def from_columns(columns: Mapping[str, Array], machine: Machine, source: str) -> Measurements:
    """Return measurements from columns by header; raises `InputError` for missing, unknown or double names."""
    named, warnings = named_columns(columns, machine, source)
    warnings += [*getattr(columns, "notes", ())]
    warnings += [f"column {header_of(key)} is skipped" for key in named if key[0] not in MEASURED_QUANTITIES]
    joints, motors = machine.independent_joints, machine.motor_joints
    names = [joint.name for joint in joints]
    following = [header_of(key) for key in named if key[0] in ("q", "qd", "qdd") and key[1] not in names]
    warnings += [f"column {header} is skipped: the joint follows others" for header in following]
    _refuse_missing(named, joints, motors, columns, source)
    rates = {}
    for quantity in ("qd", "qdd"):
        absent = [f"{quantity}_{name}" for name in names if (quantity, name) not in named]
        if absent and len(absent) < len(names):
            warnings.append(f"{quantity} is not used: {', '.join(absent)} missing")
        if not absent:
            rates[quantity] = _stack(named, quantity, joints)
    t = named["t", ""]
    return Measurements(
        t, _stack(named, "q", joints), _stack(named, "tau", motors, len(t)), **rates,
        source=source, warnings=tuple(warnings),
    )  # fmt: skip


def check(
    measured: Measurements, machine: Machine, trusted: frozenset[str] = frozenset(), must_be_even: bool = True
) -> Measurements:
    """Return the measurements with warnings added; raises `InputError` for unsuitable ones.

    Columns named in `trusted` are taken to be in their unit. Unless sampling `must_be_even` it may have gaps.
    """
    _check_numbers(measured, machine)
    if len(measured.t) < FEWEST:
        what = f"{len(measured.t)} samples are too few: give at least {FEWEST}, and some seconds of motion"
        raise InputError(measured.source, "t", what)
    if must_be_even:
        _check_time(measured)
    if measured.period >= SLOWEST:
        what = f"one sample every {measured.period:g} s is too slow for dynamics: if t is in ms, call the column t [ms]"
        raise InputError(measured.source, "t", what)
    warnings = [*measured.warnings]
    for k, joint in enumerate(machine.independent_joints):
        warnings += _check_range(measured, k, joint, f"q_{joint.name}" in trusted)
        _check_slopes(measured, k, joint)
    if not np.ptp(measured.q, axis=0).any():
        raise InputError(measured.source, "q", "no joint moves: nothing can be identified at rest")
    return replace(measured, warnings=tuple(warnings))


def refuse_wrapped(record: Measurements, machine: Machine) -> None:
    """Raise `InputError` for positions with jumps of a wrapping counter, or of wrapping angles."""
    for k, joint in enumerate(machine.independent_joints):
        finite = np.isfinite(record.t) & np.isfinite(record.q[:, k])
        if (finite.sum() > FEWEST) and (wraps := wraps_of(record.t[finite], record.q[finite, k])):
            times = "once" if wraps.count == 1 else f"{wraps.count} times"
            first = int(np.flatnonzero(finite)[wraps.first])
            where = f"{times}, first at sample {first + 1} (t = {record.t[first]:g} s)"
            what = f"jumps by {wraps.period:.6g} {joint.unit} {where}, as a counter or an angle that wraps"
            way_out = f"unwrap it, as numpy.unwrap(x, period={wraps.period:.6g}) does"
            raise InputError(record.source, f"q_{joint.name}", f"{what}: {way_out}")


def write_measurements(measured: Measurements, machine: Machine, path: str | Path) -> None:
    """Write measurements as a .csv or .npz file that `read_measurements` reads; raises `InputError`."""
    write_columns(measured.columns(machine), path)


def _refuse_missing(
    named: Iterable[tuple[str, str]],
    joints: Sequence[Joint],
    motors: Sequence[Joint],
    columns: Iterable[str],
    source: str,
) -> None:
    wanted = [("t", ""), *(("q", joint.name) for joint in joints), *(("tau", joint.name) for joint in motors)]
    lacking = [header_of(key) for key in wanted if key not in named]
    if lacking:
        what = f"a joint is called by its name or its variable; --column {lacking[0]}=NAME selects another column"
        if any(name.startswith("q_") for name in lacking):
            what += "; every moving joint must be measured, elastic ones too: lock a joint that is not (scene, locked)"
        raise missing(lacking, columns, source, what)


def _stack(named: Mapping[tuple[str, str], Array], quantity: str, joints: Iterable[Joint], samples: int = 0) -> Array:
    columns = [named[quantity, joint.name] for joint in joints]
    return np.stack(columns, axis=1) if columns else np.zeros((samples, 0))


def _check_numbers(measured: Measurements, machine: Machine) -> None:
    refuse_unsorted(measured)
    for name, x in measured.columns(machine).items():
        bad = ~np.isfinite(x)
        if bad.any():
            first = _first(bad)
            where = f"first at sample {first} (t = {measured.t[first - 1]:g} s): cut the record there"
            raise InputError(measured.source, name, f"NaN or infinity at {bad.sum()} samples, {where}")
        if (most := float(np.abs(x).max(initial=0.0))) > LARGEST:
            what = f"reaches {most:.3g}, which no machine does: check the column and its unit"
            raise InputError(measured.source, name, what)


def _first(bad: BoolArray) -> int:
    """Return the number (from 1) of the first bad sample."""
    return int(np.argmax(bad)) + 1


def refuse_unsorted(measured: Measurements) -> None:
    """Raise `InputError` where time is not a number or does not increase."""
    if not np.isfinite(measured.t).all():
        raise InputError(measured.source, "t", f"sample {_first(~np.isfinite(measured.t))} is not a number")
    steps = np.diff(measured.t)
    if (steps <= 0).any():
        k = _first(steps <= 0)
        what = f"does not increase from sample {k} ({measured.t[k - 1]:g} s) to {k + 1} ({measured.t[k]:g} s)"
        raise InputError(measured.source, "t", f"{what}: join records only with a common clock, drop repeated lines")


def _check_time(measured: Measurements) -> None:
    steps = np.diff(measured.t)
    usual = float(np.median(steps))
    if (steps > 1.5 * usual).any():
        k = _first(steps > 1.5 * usual)
        what = f"gap of {steps[k - 1]:g} s after sample {k} ({measured.t[k - 1]:g} s), usually {usual:g} s"
        way_out = "filters need even sampling; cut the record there, or resample it (identify --resample)"
        raise InputError(measured.source, "t", f"{what}: {way_out}")
    even = measured.t[0] + measured.period * np.arange(len(measured.t))
    worst = int(np.argmax(np.abs(measured.t - even)))
    if abs(measured.t[worst] - even[worst]) > UNEVEN * measured.period:
        what = f"uneven sampling: sample {worst + 1} is {measured.t[worst] - even[worst]:.3g} s off an even clock of"
        raise InputError(measured.source, "t", f"{what} {measured.period:.6g} s; resample it (identify --resample)")


def _check_range(measured: Measurements, k: int, joint: Joint, trusted: bool) -> list[str]:
    """Return warnings about the range of a joint; raises `InputError` for a prismatic one beyond some metres."""
    span, name = float(np.ptp(measured.q[:, k])), f"q_{joint.name}"
    if trusted:
        return []
    if joint.sigma == 1 and span > LONGEST_SLIDE:
        what = f"moves over {span:.4g} m: these look like mm. Call the column {name} [mm] (or [m] if it is so)"
        raise InputError(measured.source, name, what)
    if joint.sigma == 0 and span > 2 * math.pi * MOST_TURNS:
        what = f"turns over {span:.4g} rad, {span / (2 * math.pi):.0f} turns"
        return [f"{name}: {what}: if these are degrees, call it {name} [deg]"]
    return []


def _check_slopes(record: Measurements, k: int, joint: Joint) -> None:
    """Raise `InputError` for velocities in another unit than positions."""
    if record.qd is None:
        return
    slope, measured = np.gradient(record.q[:, k], record.t), record.qd[:, k]
    power = float(slope @ slope)
    if power == 0.0 or float(np.std(measured)) == 0.0:
        return
    ratio, alike = float(slope @ measured) / power, float(np.corrcoef(slope, measured)[0, 1])
    if abs(alike) > 0.9 and not 1 / SLOPE_RATIO < ratio < SLOPE_RATIO:
        what = f"is {ratio:.3g} times the slope of q_{joint.name}: units or sign differ (rad and deg, m and mm?)"
        raise InputError(record.source, f"qd_{joint.name}", what)


def read_columns(path: str | Path, machine: Machine, may_be_empty: bool = False) -> Columns:
    """Return the raw columns of a .csv or .npz file by header; cells that `may_be_empty` are NaN.

    Raises `InputError`.
    """
    joints = [joint.name for joint in machine.independent_joints]
    motors = [joint.name for joint in machine.motor_joints]
    columns, of_file = Columns(), read_arrays(path, may_be_empty)
    columns.notes = of_file.notes
    for name, array in of_file.items():
        names = joints if name.startswith("q") else motors
        if _BLOCK.fullmatch(name) and array.ndim == 2:
            if array.shape[1] != len(names):
                what = f"has {array.shape[1]} columns: {len(names)} are expected, of {', '.join(names)}"
                raise InputError(str(path), name, what)
            columns |= {f"{name}_{joint}": array[:, k] for k, joint in enumerate(names)}
        elif array.ndim == 1:
            columns[name] = array
        else:
            raise InputError(str(path), name, f"has shape {array.shape}: one axis, or samples x joints")
    return columns


def renamed_columns(columns: Mapping[str, Array], names: Mapping[str, str], source: str) -> Mapping[str, Array]:
    """Return columns under other names: `q_elbow` by `Position_2`, by `Position_2 [deg]`, by `2*pi/4096*Counts`.

    A unit replaces that of the file, a factor is that of its numbers. Raises `InputError` for unknown columns.
    """
    renamed, headers = Columns(columns), {name_and_unit(header)[0]: header for header in columns}
    for new, text in names.items():
        name, unit = name_and_unit(text)
        factor, _, name = name.rpartition("*")
        header = name if name in columns else headers.get(name.strip(), "")
        if not header:
            raise missing([name.strip()], columns, f"{source}: --column, {new}", "correct the name of the column")
        try:
            scale = number(factor or "1")
        except FormulaError as error:
            raise InputError(source, f"--column, {new}", f"{factor!r} is not a factor: {error}") from None
        unit = name_and_unit(header)[1] if unit is None else unit
        renamed.pop(header, None)
        renamed[new if unit is None else f"{new} [{unit}]"] = scale * np.asarray(columns[header], dtype=float)
    renamed.notes = getattr(columns, "notes", ())
    return renamed


def missing(names: Iterable[str], columns: Iterable[str], source: str, way_out: str) -> InputError:
    """Return the error about missing columns, with the columns that exist."""
    return InputError(source, ", ".join(names), f"missing; the file has {some_of([*columns])}: {way_out}")


def named_columns(
    columns: Mapping[str, Array], machine: Machine, source: str
) -> tuple[dict[tuple[str, str], Array], list[str]]:
    """Return columns by (quantity, joint name) in SI units, and warnings about skipped ones.

    Quantities are t, tau, and q or y with a `d` for each derivative by time. Raises `InputError`.
    """
    named: dict[tuple[str, str], Array] = {}
    warnings = []
    for header, values in columns.items():
        name, unit = name_and_unit(header)
        key = _key(name, machine, source)
        if key is None:
            warnings += [] if name.startswith((POWER, ENERGY)) else [f"column {header} is skipped"]
            continue
        if key in named:
            raise InputError(source, header, "is given twice, by name and by variable of the joint")
        named[key] = np.asarray(values, dtype=float) * _factor(unit, key, machine, source, header)
    lengths = {len(values) for values in named.values()}
    if len(lengths) > 1:
        short = min(named, key=lambda key: len(named[key]))
        raise InputError(source, header_of(short), "columns have different lengths")
    return named, warnings


def header_of(key: tuple[str, str]) -> str:
    """Return the header of a (quantity, joint name)."""
    return "_".join(filter(None, key))


def _key(name: str, machine: Machine, source: str) -> tuple[str, str] | None:
    """Return (quantity, joint name) of a header; None for other columns."""
    if name.lower() in ("t", "time"):
        return "t", ""
    moving = [machine.joint(j) for j in machine.articulated]
    joints = {j.variable: j for j in moving if j.variable is not None} | {j.name: j for j in moving}
    if name in joints and joints[name].variable == name:
        return "q", joints[name].name
    parts = _QUANTITY.fullmatch(name)
    if parts is None:
        return None
    if parts["joint"] not in joints:
        raise InputError(source, name, no_such("moving joint", parts["joint"], joints))
    joint = joints[parts["joint"]]
    if not parts["quantity"].startswith("q") and joint.kind is not Kind.MOTOR:
        raise InputError(source, name, machine.why_no_motor(joint.name))
    return parts["quantity"], joint.name


def _factor(unit: str | None, key: tuple[str, str], machine: Machine, source: str, header: str) -> float:
    """Return the factor from the unit of a column to SI units."""
    if unit is None:
        return 1.0
    joint = next((joint for joint in machine.joints if joint.name == key[1]), None)
    try:
        return conversion(unit, _si_unit(key[0], joint is not None and joint.sigma == 1)).number
    except UnitError as error:
        raise InputError(source, header, str(error)) from None


def _si_unit(quantity: str, slides: bool) -> str:
    if quantity in SI_UNITS:
        return SI_UNITS[quantity][slides]
    order = quantity.count("d")
    return ("rad", "m")[slides] + (f"/s{order if order > 1 else ''}" if order else "")


def with_units(columns: Iterable[str]) -> frozenset[str]:
    """Return the names of columns that state their unit."""
    return frozenset(name for name, unit in map(name_and_unit, columns) if unit is not None)


@dataclass(frozen=True)
class NamedColumn:
    """A kind of columns: name, with `<joint>` or `<motor>`, meaning, SI unit, an example."""

    name: str
    meaning: str
    unit: str
    example: str


REFERENCE = "desired position of a motor's axis, including the springs behind it"
RATES = "its velocity; ydd, yddd ... are further derivatives by time"
NAMED_COLUMNS = (
    NamedColumn("t", "time; evenly spaced", "s", "t [ms]"),
    NamedColumn("q_<joint>", "measured position of a joint", "rad or m", "q_elbow [deg]"),
    NamedColumn("qd_<joint>", "its velocity", "rad/s or m/s", "qd_elbow [rpm]"),
    NamedColumn("qdd_<joint>", "its acceleration", "rad/s2 or m/s2", "qdd_elbow [deg/s2]"),
    NamedColumn("tau_<motor>", "torque or force of a motor", "N m or N", "tau_shoulder [N cm]"),
    NamedColumn("y_<motor>", REFERENCE, "rad or m", "y_shoulder [deg]"),
    NamedColumn("yd_<motor>", RATES, "rad/s or m/s", "yd_shoulder [deg/s]"),
)
"""Columns of files of motions and measurements, a row each: what the reference of formats says of them."""
