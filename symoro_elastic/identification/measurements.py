"""Measured motion and torques of a machine: CSV or NPZ files, read and checked before anything is computed.

A CSV file has one header line; its columns are `t` (s), `q_<joint>` for every joint that moves (rad or m),
`tau_<motor>` for every motor (N m or N), and where they are measured `qd_<joint>` and `qdd_<joint>`. A joint
is called by its name or by its variable. A unit may follow in brackets: `q_slide [mm]`. An NPZ file holds the
same names as arrays of one axis, or `t` (N), `q` (N x n), `tau` (N x m), `qd`, `qdd`.
"""

from __future__ import annotations

import csv
import math
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import did_you_mean

Array = NDArray[np.float64]
Columns = dict[str, Array]

FEWEST = 50  # samples
LONGEST_SLIDE = 10.0  # m
MOST_TURNS = 20.0
UNEVEN = 0.1  # of a sampling period
SLOPE_RATIO = 3.0
UNITS = {
    "s": ("t", 1.0), "ms": ("t", 1e-3), "us": ("t", 1e-6),
    "m": ("slide", 1.0), "mm": ("slide", 1e-3), "um": ("slide", 1e-6),
    "rad": ("turn", 1.0), "mrad": ("turn", 1e-3), "deg": ("turn", math.pi / 180),
    "N": ("force", 1.0), "kN": ("force", 1e3),
    "N m": ("torque", 1.0), "Nm": ("torque", 1.0), "mN m": ("torque", 1e-3), "mNm": ("torque", 1e-3),
}  # fmt: skip
SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_HEADER = re.compile(r"(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")
_QUANTITY = re.compile(r"(?P<quantity>[qy]d*|tau)_(?P<joint>.+)")
_BLOCK = re.compile("[qy]d*|tau")
MEASURED = ("t", "q", "qd", "qdd", "tau")


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

    @property
    def period(self) -> float:
        """Sampling period, s."""
        return float((self.t[-1] - self.t[0]) / (len(self.t) - 1))


def read_measurements(path: str | Path, machine: Machine) -> Measurements:
    """Read a .csv or .npz file of measurements of a machine.

    Raises `InputError` naming file and column: columns that are missing, unknown or double, cells that are no
    numbers, time that does not increase or has gaps, NaN, too few samples, lengths that are probably mm.
    """
    found = read_columns(path, machine)
    return check(from_columns(found, machine, str(path)), machine, _with_units(found))


def read_columns(path: str | Path, machine: Machine) -> Columns:
    """Columns of a .csv or .npz file by header, as they are. Raises `InputError`."""
    path = Path(path)
    if path.suffix.lower() == ".npz":
        return _read_npz(path, machine)
    if path.suffix.lower() in (".csv", ".txt"):
        return _read_csv(path)
    raise InputError(str(path), "file name", "motions and measurements are .csv or .npz files")


def from_columns(columns: Mapping[str, Array], machine: Machine, source: str) -> Measurements:
    """Measurements from columns by header; raises `InputError` for names that are missing, unknown or double."""
    named, warnings = named_columns(columns, machine, source)
    warnings += [f"column {_header(key)} is passed over" for key in named if key[0] not in MEASURED]
    joints = [machine.joints[j - 1] for j in machine.moving]
    motors = [joint for joint in joints if joint.kind is Kind.MOTOR]
    _refuse_missing(named, joints, motors, source)
    rates = {}
    for quantity in ("qd", "qdd"):
        given = [(quantity, joint.name) in named for joint in joints]
        if any(given) and not all(given):
            missing = ", ".join(f"{quantity}_{j.name}" for j, there in zip(joints, given, strict=True) if not there)
            warnings.append(f"{quantity} is not used: {missing} missing")
        if all(given):
            rates[quantity] = _stacked(named, quantity, joints)
    t = named["t", ""]
    return Measurements(
        t, _stacked(named, "q", joints), _stacked(named, "tau", motors, len(t)), **rates,
        source=source, warnings=tuple(warnings),
    )  # fmt: skip


def check(found: Measurements, machine: Machine, with_units: frozenset[str] = frozenset()) -> Measurements:
    """The measurements, with warnings; raises `InputError` for what no identification can use.

    Columns named in `with_units` are trusted to be in their unit.
    """
    joints = [machine.joints[j - 1] for j in machine.moving]
    motors = [joint for joint in joints if joint.kind is Kind.MOTOR]
    _check_numbers(found, joints, motors)
    if len(found.t) < FEWEST:
        what = f"{len(found.t)} samples are too few: at least {FEWEST}, and some seconds of motion"
        raise InputError(found.source, "t", what)
    _check_time(found)
    warnings = [*found.warnings]
    for k, joint in enumerate(joints):
        warnings += _check_range(found, k, joint, f"q_{joint.name}" in with_units)
        _check_slopes(found, k, joint)
    if not np.ptp(found.q, axis=0).any():
        raise InputError(found.source, "q", "no joint moves: nothing can be identified at rest")
    return replace(found, warnings=tuple(warnings))


def write_csv(found: Measurements, machine: Machine, path: str | Path) -> None:
    """Write measurements as a CSV file that `read_measurements` reads."""
    joints = [machine.joints[j - 1].name for j in machine.moving]
    motors = [machine.joints[j - 1].name for j in machine.moving if machine.joints[j - 1].kind is Kind.MOTOR]
    blocks = [("q", found.q, joints), ("qd", found.qd, joints), ("qdd", found.qdd, joints), ("tau", found.tau, motors)]
    header, columns = ["t"], [found.t[:, None]]
    for quantity, block, names in blocks:
        if block is not None:
            header += [f"{quantity}_{name}" for name in names]
            columns.append(block)
    np.savetxt(path, np.hstack(columns), delimiter=",", header=",".join(header), comments="", fmt="%.12g")


def _read_csv(path: Path) -> Columns:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [(number, row) for number, row in enumerate(csv.reader(file), start=1) if any(map(str.strip, row))]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(str(path), "file", f"cannot be read: {_reason(error)}") from None
    if len(lines) < 2:
        raise InputError(str(path), "file", "holds no samples: a header line, then one line a sample")
    header = [name.strip() for name in lines[0][1]]
    if _is_number(header[0]):
        what = "the first line holds numbers: it must name the columns, such as t, q_<joint>, tau_<motor>"
        raise InputError(str(path), "line 1", what)
    if len(set(header)) < len(header):
        double = next(name for name in header if header.count(name) > 1)
        raise InputError(str(path), double, "two columns have this name")
    rows = [_numbers(path, number, row, header) for number, row in lines[1:]]
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def _numbers(path: Path, line: int, row: Sequence[str], header: Sequence[str]) -> list[float]:
    if len(row) != len(header):
        raise InputError(str(path), f"line {line}", f"has {len(row)} cells, the header has {len(header)}")
    for name, cell in zip(header, row, strict=True):
        if not _is_number(cell):
            what = f"{cell.strip()[:30]!r} is no number" if cell.strip() else "is empty: a gap in the data"
            raise InputError(str(path), name, f"line {line}: {what}; cut the record there or measure again")
    return [float(cell) for cell in row]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _reason(error: Exception) -> str:
    return error.strerror or str(error) if isinstance(error, OSError) else str(error)


def _read_npz(path: Path, machine: Machine) -> Columns:
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays: dict[str, Any] = {name: np.asarray(file[name], dtype=float) for name in file.files}
    except (OSError, ValueError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(str(path), "file", f"cannot be read as arrays of numbers: {_reason(error)}") from None
    joints = [machine.joints[j - 1].name for j in machine.moving]
    motors = [machine.joints[j - 1].name for j in machine.moving if machine.joints[j - 1].kind is Kind.MOTOR]
    columns: Columns = {}
    for name, array in arrays.items():
        names = joints if name.startswith("q") else motors
        if _BLOCK.fullmatch(name) and array.ndim == 2:
            if array.shape[1] != len(names):
                what = f"has {array.shape[1]} columns: {len(names)} are wanted, of {', '.join(names)}"
                raise InputError(str(path), name, what)
            columns |= {f"{name}_{joint}": array[:, k] for k, joint in enumerate(names)}
        elif array.ndim == 1:
            columns[name] = array
        else:
            raise InputError(str(path), name, f"has shape {array.shape}: one axis, or samples x joints")
    return columns


def named_columns(
    columns: Mapping[str, Array], machine: Machine, source: str
) -> tuple[dict[tuple[str, str], Array], list[str]]:
    """Columns by (quantity, joint name) in SI units, and warnings about those that are passed over.

    Quantities are t, tau, and q or y with a `d` for each derivative by time. Raises `InputError`.
    """
    named: dict[tuple[str, str], Array] = {}
    warnings = []
    for header, values in columns.items():
        parts = _HEADER.fullmatch(header)
        name, unit = (parts["name"], parts["unit"]) if parts else (header, None)
        key = _key(name, machine, source)
        if key is None:
            warnings.append(f"column {header} is passed over")
            continue
        if key in named:
            raise InputError(source, header, "is given twice, by name and by variable of the joint")
        named[key] = np.asarray(values, dtype=float) * _factor(unit, key, machine, source, header)
    lengths = {len(values) for values in named.values()}
    if len(lengths) > 1:
        short = min(named, key=lambda key: len(named[key]))
        raise InputError(source, _header(short), "columns have different lengths")
    return named, warnings


def _header(key: tuple[str, str]) -> str:
    return "_".join(filter(None, key))


def _key(name: str, machine: Machine, source: str) -> tuple[str, str] | None:
    """(quantity, joint name) of a header; None for columns that are none of ours."""
    if name.lower() in ("t", "time"):
        return "t", ""
    known = {str(j.variable): j for j in machine.joints if j.sigma != 2}
    known |= {j.name: j for j in machine.joints if j.sigma != 2}
    if name in known and known[name].variable == name:
        return "q", known[name].name
    parts = _QUANTITY.fullmatch(name)
    if parts is None:
        return None
    if parts["joint"] not in known:
        what = f"the machine has no moving joint {parts['joint']!r}{did_you_mean(parts['joint'], known)}"
        raise InputError(source, name, what)
    joint = known[parts["joint"]]
    if not parts["quantity"].startswith("q") and joint.kind is not Kind.MOTOR:
        motors = ", ".join(j.name for j in machine.joints if j.kind is Kind.MOTOR)
        what = f"{joint.name} is {joint.kind} and has no motor: {parts['quantity']} belongs to {motors}"
        raise InputError(source, name, what)
    return parts["quantity"], joint.name


def _factor(unit: str | None, key: tuple[str, str], machine: Machine, source: str, header: str) -> float:
    """What turns a column into SI units."""
    if unit is None:
        return 1.0
    quantity, name = key
    slides = next((j.sigma == 1 for j in machine.joints if j.name == name), False)
    wanted = "t" if quantity == "t" else ("force" if slides else "torque") if quantity == "tau" else (
        "slide" if slides else "turn"
    )  # fmt: skip
    per_second = _per_second(quantity.count("d"))
    for ending in per_second:
        kind, factor = UNITS.get(unit.strip().removesuffix(ending) if ending else unit.strip(), ("", 0.0))
        if kind == wanted and unit.strip().endswith(ending):
            return factor
    choices = ", ".join(name + per_second[0] for name, (kind, _) in UNITS.items() if kind == wanted)
    raise InputError(source, header, f"no unit [{unit}] here: choose from {choices}")


def _per_second(order: int) -> tuple[str, ...]:
    """How a unit may end of a derivative by time."""
    if order < 2:
        return ("/s",) if order else ("",)
    return (f"/s{order}", f"/s^{order}", "/s" + str(order).translate(SUPERSCRIPTS))


def _refuse_missing(
    named: Mapping[tuple[str, str], Array], joints: Sequence[Joint], motors: Sequence[Joint], source: str
) -> None:
    wanted = [("t", ""), *(("q", joint.name) for joint in joints), *(("tau", joint.name) for joint in motors)]
    missing = [_header(key) for key in wanted if key not in named]
    if missing:
        there = ", ".join(map(_header, named)) or "none of them"
        what = f"missing; the file has {there}. A joint is called by its name or its variable"
        if any(name.startswith("q_") for name in missing):
            what += "; every moving joint must be measured, elastic ones too: lock a joint that is not (scene, locked)"
        raise InputError(source, ", ".join(missing), what)


def _stacked(named: Mapping[tuple[str, str], Array], quantity: str, joints: Iterable[Joint], samples: int = 0) -> Array:
    columns = [named[quantity, joint.name] for joint in joints]
    return np.stack(columns, axis=1) if columns else np.zeros((samples, 0))


def _with_units(columns: Iterable[str]) -> frozenset[str]:
    """Names of columns that state their unit."""
    found = (_HEADER.fullmatch(header) for header in columns)
    return frozenset(parts["name"] for parts in found if parts and parts["unit"] is not None)


def _check_numbers(found: Measurements, joints: Sequence[Joint], motors: Sequence[Joint]) -> None:
    if not np.isfinite(found.t).all():
        raise InputError(found.source, "t", f"sample {_first(~np.isfinite(found.t))} is no number")
    blocks = (("q", found.q, joints), ("qd", found.qd, joints), ("qdd", found.qdd, joints), ("tau", found.tau, motors))
    for quantity, block, owners in blocks:
        for k, joint in enumerate(owners if block is not None else ()):
            bad = ~np.isfinite(block[:, k])  # type: ignore[index]
            if bad.any():
                first = _first(bad)
                where = (
                    f"NaN or infinity at {bad.sum()} samples, first at sample {first} (t = {found.t[first - 1]:g} s)"
                )
                raise InputError(found.source, f"{quantity}_{joint.name}", f"{where}: cut the record there")


def _first(bad: NDArray[np.bool_]) -> int:
    """Number (from 1) of the first sample that is bad."""
    return int(np.argmax(bad)) + 1


def _check_time(found: Measurements) -> None:
    steps = np.diff(found.t)
    if (steps <= 0).any():
        k = _first(steps <= 0)
        what = f"does not increase from sample {k} ({found.t[k - 1]:g} s) to {k + 1} ({found.t[k]:g} s)"
        raise InputError(found.source, "t", f"{what}: join records only with a common clock, drop repeated lines")
    usual = float(np.median(steps))
    if (steps > 1.5 * usual).any():
        k = _first(steps > 1.5 * usual)
        what = f"gap of {steps[k - 1]:g} s after sample {k} ({found.t[k - 1]:g} s), usually {usual:g} s"
        raise InputError(found.source, "t", f"{what}: filters need even sampling; cut the record there or resample")
    even = found.t[0] + found.period * np.arange(len(found.t))
    worst = int(np.argmax(np.abs(found.t - even)))
    if abs(found.t[worst] - even[worst]) > UNEVEN * found.period:
        what = f"uneven sampling: sample {worst + 1} is {found.t[worst] - even[worst]:.3g} s off an even clock of"
        raise InputError(found.source, "t", f"{what} {found.period:.6g} s; resample it")
    if found.period >= 0.5:
        what = f"one sample every {found.period:g} s is too slow for dynamics: if t is in ms, call the column t [ms]"
        raise InputError(found.source, "t", what)


def _check_range(found: Measurements, k: int, joint: Joint, trusted: bool) -> list[str]:
    """Warnings about the range of a joint; raises `InputError` for a slide of more than some metres."""
    span, name = float(np.ptp(found.q[:, k])), f"q_{joint.name}"
    if trusted:
        return []
    if joint.sigma == 1 and span > LONGEST_SLIDE:
        what = f"moves over {span:.4g} m: these look like mm. Call the column {name} [mm] (or [m] if it is so)"
        raise InputError(found.source, name, what)
    if joint.sigma == 0 and span > 2 * math.pi * MOST_TURNS:
        what = (
            f"turns over {span:.4g} rad, {span / (2 * math.pi):.0f} turns: if these are degrees, call it {name} [deg]"
        )
        return [f"{name}: {what}"]
    return []


def _check_slopes(found: Measurements, k: int, joint: Joint) -> None:
    """Refuse velocities in another unit than positions."""
    if found.qd is None:
        return
    slope, measured = np.gradient(found.q[:, k], found.period), found.qd[:, k]
    power = float(slope @ slope)
    if power == 0.0 or float(np.std(measured)) == 0.0:
        return
    ratio, alike = float(slope @ measured) / power, float(np.corrcoef(slope, measured)[0, 1])
    if abs(alike) > 0.9 and not 1 / SLOPE_RATIO < ratio < SLOPE_RATIO:
        what = f"is {ratio:.3g} times the slope of q_{joint.name}: units or sign differ (rad and deg, m and mm?)"
        raise InputError(found.source, f"qd_{joint.name}", what)
