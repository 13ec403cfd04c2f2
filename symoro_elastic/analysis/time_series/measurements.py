"""Measured motion and torques of a machine, with checks.

A record has `t`, `q_<joint>` for every joint that moves, `tau_<motor>` for every motor, and where they are measured
`qd_<joint>` and `qdd_<joint>`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.time_series.named_columns import header_of, named_columns, read_columns, with_units
from symoro_elastic.analysis.time_series.writing import columns_of, write_columns
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Joint, Machine

FEWEST = 50  # samples
LONGEST_SLIDE = 10.0  # m
MOST_TURNS = 20.0
UNEVEN = 0.1  # of a sampling period
SLOWEST = 0.5  # s
LARGEST = 1e30  # SI units
SLOPE_RATIO = 3.0
MEASURED_QUANTITIES = ("t", "q", "qd", "qdd", "tau")


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
        """Whether no sample is further than a tenth of a step off an even clock."""
        even = self.t[0] + self._mean_step * np.arange(len(self.t))
        return bool(np.abs(self.t - even).max() <= UNEVEN * self._mean_step)

    @property
    def period(self) -> float:
        """Sampling period, s; the usual one where sampling is uneven."""
        return self._mean_step if self.is_even else float(np.median(np.diff(self.t)))

    @property
    def _mean_step(self) -> float:
        return float((self.t[-1] - self.t[0]) / (len(self.t) - 1))


Prepare = Callable[[Measurements, Machine], Measurements]
"""Makes a record ready before it is checked."""


def read_measurements(path: str | Path, machine: Machine, prepare: Prepare | None = None) -> Measurements:
    """Read a .csv or .npz file of measurements of a machine; with `prepare` sampling may be uneven, and cells empty.

    Raises `InputError` naming file and column: columns that are missing, unknown or double, cells that are no
    numbers, time that does not increase or has gaps, NaN, too few samples, lengths that are probably mm.
    """
    return measurements_of(read_columns(path, machine, prepare is not None), machine, str(path), prepare)


def measurements_of(
    columns: Mapping[str, Array], machine: Machine, source: str, prepare: Prepare | None = None
) -> Measurements:
    """Return measurements from columns by header, as `read_measurements` gives those of a file."""
    record = from_columns(columns, machine, source)
    record = prepare(record, machine) if prepare else record
    return check(record, machine, with_units(columns), must_be_even=prepare is None)


def from_columns(columns: Mapping[str, Array], machine: Machine, source: str) -> Measurements:
    """Return measurements from columns by header; raises `InputError` for missing, unknown or double names."""
    named, warnings = named_columns(columns, machine, source)
    warnings += [f"column {header_of(key)} is skipped" for key in named if key[0] not in MEASURED_QUANTITIES]
    joints = machine.independent_joints
    motors = machine.motor_joints
    warnings += _following(named, machine)
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


def _following(named: Iterable[tuple[str, str]], machine: Machine) -> list[str]:
    """Return warnings about columns of joints that follow others, which are computed."""
    independent = {joint.name for joint in machine.independent_joints}
    following = [header_of(key) for key in named if key[0] in ("q", "qd", "qdd") and key[1] not in independent]
    return [f"column {header} is skipped: the joint follows others" for header in following]


def check(
    measured: Measurements, machine: Machine, trusted: frozenset[str] = frozenset(), must_be_even: bool = True
) -> Measurements:
    """Return the measurements with warnings; raises `InputError` for those unfit for identification.

    Columns named in `trusted` are taken to be in their unit. Unless sampling `must_be_even` it may have gaps.
    """
    joints = machine.independent_joints
    motors = machine.motor_joints
    _check_numbers(measured, joints, motors)
    if len(measured.t) < FEWEST:
        what = f"{len(measured.t)} samples are too few: give at least {FEWEST}, and some seconds of motion"
        raise InputError(measured.source, "t", what)
    if must_be_even:
        _check_time(measured)
    _check_rate(measured)
    warnings = [*measured.warnings]
    for k, joint in enumerate(joints):
        warnings += _check_range(measured, k, joint, f"q_{joint.name}" in trusted)
        _check_slopes(measured, k, joint)
    if not np.ptp(measured.q, axis=0).any():
        raise InputError(measured.source, "q", "no joint moves: nothing can be identified at rest")
    return replace(measured, warnings=tuple(warnings))


def write_measurements(measured: Measurements, machine: Machine, path: str | Path) -> None:
    """Write measurements as a .csv or .npz file that `read_measurements` reads; raises `InputError`."""
    joints, motors = ([joint.name for joint in some] for some in (machine.independent_joints, machine.motor_joints))
    blocks = (("q", measured.q, joints), ("qd", measured.qd, joints), ("qdd", measured.qdd, joints))
    given = [(quantity, block, names) for quantity, block, names in blocks if block is not None]
    write_columns(columns_of(measured.t, *given, ("tau", measured.tau, motors)), path)


def _refuse_missing(
    named: Mapping[tuple[str, str], Array], joints: Sequence[Joint], motors: Sequence[Joint], source: str
) -> None:
    wanted = [("t", ""), *(("q", joint.name) for joint in joints), *(("tau", joint.name) for joint in motors)]
    missing = [header_of(key) for key in wanted if key not in named]
    if missing:
        there = ", ".join(map(header_of, named)) or "none of them"
        what = f"missing; the file has {there}. A joint is called by its name or its variable"
        if any(name.startswith("q_") for name in missing):
            what += "; every moving joint must be measured, elastic ones too: lock a joint that is not (scene, locked)"
        raise InputError(source, ", ".join(missing), what)


def _stacked(named: Mapping[tuple[str, str], Array], quantity: str, joints: Iterable[Joint], samples: int = 0) -> Array:
    columns = [named[quantity, joint.name] for joint in joints]
    return np.stack(columns, axis=1) if columns else np.zeros((samples, 0))


def _check_numbers(measured: Measurements, joints: Sequence[Joint], motors: Sequence[Joint]) -> None:
    refuse_unsorted(measured)
    blocks = (
        ("q", measured.q, joints),
        ("qd", measured.qd, joints),
        ("qdd", measured.qdd, joints),
        ("tau", measured.tau, motors),
    )
    for quantity, block, owners in blocks:
        for k, joint in enumerate(owners if block is not None else ()):
            bad = ~np.isfinite(block[:, k])  # type: ignore[index]
            if bad.any():
                first = _first(bad)
                where = (
                    f"NaN or infinity at {bad.sum()} samples, first at sample {first} (t = {measured.t[first - 1]:g} s)"
                )
                raise InputError(measured.source, f"{quantity}_{joint.name}", f"{where}: cut the record there")
            if (most := float(np.abs(block[:, k]).max(initial=0.0))) > LARGEST:  # type: ignore[index]
                what = f"reaches {most:.3g}, which no machine does: check the column and its unit"
                raise InputError(measured.source, f"{quantity}_{joint.name}", what)


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
        raise InputError(
            measured.source,
            "t",
            f"{what}: filters need even sampling; cut the record there, or resample it (identify --resample)",
        )
    even = measured.t[0] + measured.period * np.arange(len(measured.t))
    worst = int(np.argmax(np.abs(measured.t - even)))
    if abs(measured.t[worst] - even[worst]) > UNEVEN * measured.period:
        what = f"uneven sampling: sample {worst + 1} is {measured.t[worst] - even[worst]:.3g} s off an even clock of"
        raise InputError(measured.source, "t", f"{what} {measured.period:.6g} s; resample it (identify --resample)")


def _check_rate(measured: Measurements) -> None:
    if measured.period >= SLOWEST:
        what = f"one sample every {measured.period:g} s is too slow for dynamics: if t is in ms, call the column t [ms]"
        raise InputError(measured.source, "t", what)


def _check_range(measured: Measurements, k: int, joint: Joint, trusted: bool) -> list[str]:
    """Return warnings about the range of a joint; raises `InputError` for a prismatic one of more than some metres."""
    span, name = float(np.ptp(measured.q[:, k])), f"q_{joint.name}"
    if trusted:
        return []
    if joint.sigma == 1 and span > LONGEST_SLIDE:
        what = f"moves over {span:.4g} m: these look like mm. Call the column {name} [mm] (or [m] if it is so)"
        raise InputError(measured.source, name, what)
    if joint.sigma == 0 and span > 2 * math.pi * MOST_TURNS:
        what = (
            f"turns over {span:.4g} rad, {span / (2 * math.pi):.0f} turns: if these are degrees, call it {name} [deg]"
        )
        return [f"{name}: {what}"]
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
