"""Columns of motions and measurements in CSV and NPZ files, by quantity and joint, in SI units.

A CSV file has one header line; its columns are `t` (s), `q_<joint>` (rad or m), `qd_<joint>`, `qdd_<joint>` and
`tau_<motor>` (N m or N); `y_<motor>`, `yd_<motor>` ... are reference trajectories. A joint is called by its name or
by its variable. A unit may follow in brackets: `q_slide [mm]`. An NPZ file holds the same names as arrays of one
axis, or `t` (N), `q` (N x n), `tau` (N x m), `qd`, `qdd`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.reading import Columns, read_arrays
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.names import did_you_mean

COLUMN_UNITS = {
    "s": ("t", 1.0), "ms": ("t", 1e-3), "us": ("t", 1e-6),
    "m": ("slide", 1.0), "mm": ("slide", 1e-3), "um": ("slide", 1e-6),
    "rad": ("turn", 1.0), "mrad": ("turn", 1e-3), "deg": ("turn", math.pi / 180),
    "N": ("force", 1.0), "kN": ("force", 1e3),
    "N m": ("torque", 1.0), "Nm": ("torque", 1.0), "mN m": ("torque", 1e-3), "mNm": ("torque", 1e-3),
}  # fmt: skip
SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_HEADER = re.compile(r"(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")
_QUANTITY = re.compile(r"(?P<quantity>[qy]d*|tau)_(?P<joint>.+)")
POWER, ENERGY = "power_", "energy_"
"""Before the names of columns that simulations write and nobody reads."""
_BLOCK = re.compile("[qy]d*|tau")


def read_columns(path: str | Path, machine: Machine, may_be_empty: bool = False) -> Columns:
    """Return the columns of a .csv or .npz file by header, as they are; cells that `may_be_empty` are NaN.

    Raises `InputError`.
    """
    joints = [joint.name for joint in machine.independent_joints]
    motors = [joint.name for joint in machine.motor_joints]
    columns: Columns = {}
    for name, array in read_arrays(path, may_be_empty).items():
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


def named_columns(
    columns: Mapping[str, Array], machine: Machine, source: str
) -> tuple[dict[tuple[str, str], Array], list[str]]:
    """Return columns by (quantity, joint name) in SI units, and warnings about skipped ones.

    Quantities are t, tau, and q or y with a `d` for each derivative by time. Raises `InputError`.
    """
    named: dict[tuple[str, str], Array] = {}
    warnings = []
    for header, values in columns.items():
        parts = _HEADER.fullmatch(header)
        name, unit = (parts["name"], parts["unit"]) if parts else (header, None)
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
    known = {j.variable: j for j in moving if j.variable is not None} | {j.name: j for j in moving}
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
        motors = ", ".join(joint.name for joint in machine.motor_joints) or "motors, and the machine has none"
        what = f"{joint.name} is {joint.kind} and has no motor: {parts['quantity']} belongs to {motors}"
        raise InputError(source, name, what)
    return parts["quantity"], joint.name


def _factor(unit: str | None, key: tuple[str, str], machine: Machine, source: str, header: str) -> float:
    """Return the factor from the unit of a column to SI units."""
    if unit is None:
        return 1.0
    quantity, name = key
    slides = next((j.sigma == 1 for j in machine.joints if j.name == name), False)
    wanted = "t" if quantity == "t" else ("force" if slides else "torque") if quantity == "tau" else (
        "slide" if slides else "turn"
    )  # fmt: skip
    endings = per_second(quantity.count("d"))
    for ending in endings:
        kind, factor = COLUMN_UNITS.get(unit.strip().removesuffix(ending) if ending else unit.strip(), ("", 0.0))
        if kind == wanted and unit.strip().endswith(ending):
            return factor
    choices = ", ".join(name + endings[0] for name, (kind, _) in COLUMN_UNITS.items() if kind == wanted)
    raise InputError(source, header, f"no unit [{unit}] here: choose from {choices}")


def per_second(order: int) -> tuple[str, ...]:
    """Return the endings of a unit for a derivative by time."""
    if order < 2:
        return ("/s",) if order else ("",)
    return (f"/s{order}", f"/s^{order}", "/s" + str(order).translate(SUPERSCRIPTS))


def with_units(columns: Iterable[str]) -> frozenset[str]:
    """Return the names of columns that state their unit."""
    headers = (_HEADER.fullmatch(header) for header in columns)
    return frozenset(parts["name"] for parts in headers if parts and parts["unit"] is not None)


@dataclass(frozen=True)
class NamedColumn:
    """One kind of column: its name, in which `<joint>` or `<motor>` stands for one, and the kinds of its units."""

    name: str
    meaning: str
    kinds: tuple[str, ...]
    order: int = 0
    """How often it is derived by time."""

    @property
    def units(self) -> tuple[str, ...]:
        """The units that may follow its name in brackets, SI first for each kind."""
        ending = per_second(self.order)[0]
        return tuple(unit + ending for kind in self.kinds for unit, (of, _) in COLUMN_UNITS.items() if of == kind)

    @property
    def example(self) -> str:
        """The name with a unit that is not SI."""
        joint = self.name.replace("<joint>", "elbow").replace("<motor>", "shoulder")
        return f"{joint} [{self.units[-1]}]"


POSITIONS, FORCES = ("slide", "turn"), ("force", "torque")
NAMED_COLUMNS = (
    NamedColumn("t", "time; evenly spaced", ("t",)),
    NamedColumn("q_<joint>", "measured position of a joint", POSITIONS),
    NamedColumn("qd_<joint>", "its velocity", POSITIONS, 1),
    NamedColumn("qdd_<joint>", "its acceleration", POSITIONS, 2),
    NamedColumn("tau_<motor>", "torque or force of a motor", FORCES),
    NamedColumn("y_<motor>", "desired position of a motor's axis, including the springs behind it", POSITIONS),
    NamedColumn("yd_<motor>", "its velocity; ydd, yddd ... are further derivatives by time", POSITIONS, 1),
)
"""Columns of files of motions and measurements, a row each: what the reference of formats says of them."""
