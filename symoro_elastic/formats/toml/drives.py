"""The table [drives] of a machine file: the controllers of its motors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from symoro_elastic.formats.toml.key import FORMULA, TEXT, TRUTH, WHOLE, Key, Section, Type, reference_to
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.drives import (
    MOTOR,
    ONE,
    TUNED,
    Average,
    CurrentControl,
    Drive,
    Drives,
    Filter,
    Gain,
    LowPass,
    Notch,
    SetPointFilter,
    fault_of,
    gain_unit,
    why_wrong,
)
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import no_such, quote, undeclared

HEADING = "drives"


def _gain(table: Table, key: str) -> Gain:
    """Gain under a key: a number, a formula, or the word for a gain to be tuned."""
    entry = table.entries[key]
    return TUNED if entry == str(TUNED) and not isinstance(entry, Number) else table.formula(key)


GAIN = Type(f'number, formula, or "{TUNED}"', {"anyOf": [{"const": str(TUNED)}, reference_to("formula")]}, _gain)
LAG, CURRENT_KP, CURRENT_TI, COMPENSATION = (
    Key("lag", FORMULA, "time constant of torque behind its set point", "2e-4", default=ZERO, unit="s"),
    Key(
        "kp",
        FORMULA,
        "gain of the current controller, of a motor with a winding",
        "6",
        otherwise="lag instead",
        unit="V/A",
    ),
    Key("ti", FORMULA, "integral time of the current controller", "2e-3", otherwise="needed with kp", unit="s"),
    Key("compensation", FORMULA, "share of the back-EMF that is compensated", "0.8", default=ZERO),
)
CURRENT = Section(
    "current of [drives]",
    "Current loop: a lag; or a controller kp (1 + 1/(ti s)) of the current of a motor whose resistance, inductance and "
    "torque_constant are in [motors], and whose back-EMF acts on it.",
    (LAG, CURRENT_KP, CURRENT_TI, COMPENSATION),
)
FEED_FORWARD = Section(
    "feed_forward of [drives]",
    "Shares of the set point's rates that are fed forward; the torque of the inverse model, with springs as they are "
    "at the start.",
    (
        Key("velocity", FORMULA, "share of the velocity", "1", default=ONE),
        Key(
            *("acceleration", FORMULA, "torque by the acceleration: the inertia that the motor moves", "0.02"),
            default=ZERO,
            unit="kg m2 or kg",
        ),
        Key(
            *("torque", TRUTH, "whether the torque of the inverse model along all set points is fed forward", "true"),
            default=False,
        ),
    ),
)
NOTCH, DEPTH, WIDTH = (
    Key("notch", FORMULA, "frequency that a notch takes out", "120", otherwise="lowpass instead", unit="Hz"),
    Key("depth", FORMULA, "damping ratio of the zeros of a notch", "0.05", otherwise="needed with notch"),
    Key("width", FORMULA, "damping ratio of its poles", "0.5", otherwise="needed with notch"),
)
LOWPASS, ORDER = (
    Key("lowpass", FORMULA, "frequency of a low-pass filter", "400", otherwise="none", unit="Hz"),
    Key("order", WHOLE, "order of a low-pass filter, 1 or 2", "2", default=1),
)
FILTERS = Section(
    "filters of [drives]",
    "Filters of the torque: notches (s^2 + 2 depth w s + w^2)/(s^2 + 2 width w s + w^2), low-pass filters w/(s + w) or "
    "w^2/(s^2 + sqrt(2) w s + w^2), with w = 2 pi times the frequency.",
    (NOTCH, DEPTH, WIDTH, LOWPASS, ORDER),
    rows=True,
)
TORQUE, WINDUP = (
    Key("torque", FORMULA, "largest torque of the motor, on both sides", "15", otherwise="none", unit="N m or N"),
    Key("windup", FORMULA, "time in which the integral part gives way at the limit", "0.01", otherwise="Tn", unit="s"),
)
CURRENT_LIMIT, VOLTAGE_LIMIT = (
    Key("current", FORMULA, "largest current, of a current loop with kp and ti", "40", otherwise="none", unit="A"),
    Key("voltage", FORMULA, "largest voltage, of a current loop with kp and ti", "48", otherwise="none", unit="V"),
)
LIMITS = Section(
    "limits of [drives]",
    "Limits of torque, current and voltage, where the integral parts give way by back-calculation; linear figures "
    "leave them out.",
    (TORQUE, WINDUP, CURRENT_LIMIT, VOLTAGE_LIMIT),
)
AVERAGE = Key(
    "average", FORMULA, "time of a moving average, of sampled controllers", "2e-3", otherwise="none", unit="s"
)
SET_POINT = Section(
    "set_point of [drives]", "Filter of the set point: low-pass, or mean of its samples.", (LOWPASS, ORDER, AVERAGE)
)
KV, KP, TN = (
    Key("Kv", GAIN, "gain of the position controller", "30", unit="1/s"),
    Key("Kp", GAIN, "gain of the velocity controller", "3.7e4", unit="N m s/rad or N s/m"),
    Key("Tn", GAIN, "integral time of the velocity controller", "0.02", otherwise="no integral part", unit="s"),
)
MEASURED, DEAD_TIME, PERIOD = (
    Key("measured", TEXT, "signal that the position controller reads", '"ram.q"', default=MOTOR),
    Key("dead_time", FORMULA, "time after which torque follows", "1.5e-4", otherwise="the period, else 0", unit="s"),
    Key("period", FORMULA, "period of a sampled controller", "1.25e-4", otherwise="continuous", unit="s"),
)
DRIVES = Section(
    f"[{HEADING}]",
    "Controllers of the motors: a position controller Kv around a velocity controller Kp (1 + 1/(Tn s)) around a "
    "current loop. Gains belong to the variable of the joint: those of the rotor's own axis are Kp/ratio^2. "
    "`control`, `lobes`, `sweep`, `simulate`, `ladder`, time steps and FMUs use them; no model of the machine alone "
    "depends on them.",
    (
        *(KV, KP, TN),
        Key("current", CURRENT.type, CURRENT.meaning, "{ lag = 2e-4 }", otherwise="no lag"),
        Key("feed_forward", FEED_FORWARD.type, FEED_FORWARD.meaning, "{ velocity = 1 }", otherwise="velocity = 1"),
        Key("limits", LIMITS.type, LIMITS.meaning, "{ torque = 15 }", otherwise="none"),
        Key("filters", FILTERS.type, FILTERS.meaning, "[{ lowpass = 400, order = 2 }]", otherwise="none"),
        Key("set_point", SET_POINT.type, SET_POINT.meaning, "{ lowpass = 40 }", otherwise="none"),
        *(MEASURED, DEAD_TIME, PERIOD),
    ),
    "motor",
)
OF_DRIVES = (DRIVES, CURRENT, FEED_FORWARD, LIMITS, FILTERS, SET_POINT)
"""The tables about drives, in the order of the reference."""


# Reading


def drives_of(top: Table, machine: Machine) -> Drives:
    """Read the drives in the top table of a file; raises `InputError`."""
    table = top.table(HEADING)
    return Drives({name: _drive(table, name, machine) for name in table.entries})


def _drive(table: Table, name: str, machine: Machine) -> Drive:
    joints = {joint.name: joint for joint in machine.joints}
    motors = [joint.name for joint in machine.motor_joints]
    if name not in joints:
        raise InputError(table.source, HEADING, no_such("joint", name, motors))
    if name not in motors:
        raise InputError(table.source, f"{HEADING}, {name}", machine.why_no_motor(name))
    _refuse_kind(table.table(name))
    entry = table.table(name).only(DRIVES.names)
    gains = {key.name: replace(key, unit=gain_unit(key.name, joints[name])) for key in (KV, KP, TN)}
    lag, current = _current(entry)
    fed = FEED_FORWARD.within(entry.table("feed_forward"))
    limits = entry.table("limits").only(LIMITS.names)
    drive = Drive(
        Kv=gains["Kv"].read(entry),
        Kp=gains["Kp"].read(entry),
        Tn=gains["Tn"].optional(entry),
        lag=lag,
        velocity_forward=fed["velocity"],
        acceleration_forward=fed["acceleration"],
        torque_forward=fed["torque"],
        filters=tuple(_filters(entry)),
        measured=MEASURED.read(entry),
        dead_time=DEAD_TIME.optional(entry),
        period=PERIOD.optional(entry),
        torque_limit=replace(TORQUE, unit=joints[name].force_unit).optional(limits),
        windup=WINDUP.optional(limits),
        set_point=_set_point(entry) if "set_point" in entry.entries else None,
        current=current,
        current_limit=CURRENT_LIMIT.optional(limits),
        voltage_limit=VOLTAGE_LIMIT.optional(limits),
    )
    key, what = fault_of(drive, joints[name])
    if key:
        raise entry.fail(key, what)
    _refuse_wrong(drive, entry, machine)
    return drive


INSTEAD = {
    "cascade": "every drive is one: leave kind out",
    "torque": "a motor that is left out of [drives] has its torque tau at once; a drive has Kv and Kp, which set the "
    "torque behind them as tau, with its lag",
    "voltage": "not an input: use current = { kp = 6, ti = 2e-3 }, the winding below [motors], and limits = "
    "{ voltage = 48 }",
}
"""Equivalents of the kinds of drives in other tools."""


def _refuse_kind(entry: Table) -> None:
    """Raise `InputError` for a stated kind of a drive, which follows from its keys."""
    if "kind" in entry.entries:
        kind = str(entry.entries["kind"])
        what = INSTEAD.get(kind, f"is none of {', '.join(INSTEAD)}, and follows from the other keys: leave it out")
        raise entry.fail("kind", f"{quote(kind)}: {what}")


def _current(entry: Table) -> tuple[Formula, CurrentControl | None]:
    """Lag of a current loop, or its current controller."""
    of = entry.table("current").only(CURRENT.names)
    if not {CURRENT_KP.name, CURRENT_TI.name, COMPENSATION.name} & of.entries.keys():
        return LAG.read(of), None
    if LAG.name in of.entries:
        raise of.fail(LAG.name, "conflicts with kp and ti: give a lag, or kp and ti")
    missing = [key.name for key in (CURRENT_KP, CURRENT_TI) if key.name not in of.entries]
    if missing:
        raise of.fail(", ".join(missing), "is missing: a current controller has kp and ti, as 6 and 2e-3")
    return ZERO, CurrentControl(CURRENT_KP.read(of), CURRENT_TI.read(of), COMPENSATION.read(of))


def _set_point(entry: Table) -> SetPointFilter:
    of = entry.table("set_point").only(SET_POINT.names)
    kinds = [key.name for key in (LOWPASS, AVERAGE) if key.name in of.entries]
    if len(kinds) != 1:
        raise of.fail("lowpass, average", f"give one of them, not {'both' if kinds else 'none'}")
    if kinds == [LOWPASS.name]:
        return _low_pass(of)
    of.only((AVERAGE.name,))
    return Average(AVERAGE.read(of))


def _filters(entry: Table) -> Iterator[Filter]:
    for k, row in enumerate(entry.tables("filters"), start=1):
        stage = replace(row.only(FILTERS.names), place=f"{entry.place}, filter {k}")
        kinds = [key.name for key in (NOTCH, LOWPASS) if key.name in stage.entries]
        if len(kinds) != 1:
            raise stage.fail("notch, lowpass", f"give one of them, not {'both' if kinds else 'none'}")
        yield _notch(stage) if kinds == [NOTCH.name] else _low_pass(stage)


def _notch(stage: Table) -> Notch:
    of = stage.only((NOTCH.name, DEPTH.name, WIDTH.name))
    missing = next((key.name for key in (DEPTH, WIDTH) if key.name not in of.entries), "")
    if missing:
        raise of.fail(missing, "is missing: a notch has a depth and a width, as 0.05 and 0.5")
    return Notch(NOTCH.read(of), DEPTH.read(of), WIDTH.read(of))


def _low_pass(stage: Table) -> LowPass:
    of = stage.only((LOWPASS.name, ORDER.name))
    return LowPass(LOWPASS.read(of), ORDER.read(of))


def _refuse_wrong(drive: Drive, entry: Table, machine: Machine) -> None:
    """Raise `InputError` for names that are not parameters, and for numbers that are impossible for a drive."""
    declared = machine.parameter_names
    for key, formula in drive.formulas:
        for name in sorted(formula.names - declared):
            raise entry.fail(key, undeclared(name, declared))
        if formula.names:
            continue
        try:
            reason = why_wrong(key, formula.table_value())
        except FormulaError as error:
            reason = str(error)
        if reason:
            raise entry.fail(key, reason)


# Writing


def entries_of_drive(drive: Drive) -> dict[str, Any]:
    """TOML entries of a drive: formulas, texts, integers, tables and lists of them."""
    entries: dict[str, Any] = {"Kv": drive.Kv, "Kp": drive.Kp}
    entries |= {"Tn": drive.Tn} if drive.Tn is not None else {}
    entries |= {"current": {"lag": drive.lag}} if drive.lag != ZERO else {}
    if control := drive.current:
        shared = {"compensation": control.compensation} if control.compensation != ZERO else {}
        entries |= {"current": {"kp": control.kp, "ti": control.ti, **shared}}
    fed = (("velocity", drive.velocity_forward, ONE), ("acceleration", drive.acceleration_forward, ZERO))
    shares = {key: x for key, x, usual in fed if x != usual} | ({"torque": True} if drive.torque_forward else {})
    entries |= {"feed_forward": shares} if shares else {}
    limits = (("torque", drive.torque_limit), ("windup", drive.windup))
    electric = (("current", drive.current_limit), ("voltage", drive.voltage_limit))
    limited = {key: x for key, x in (*limits, *electric) if x is not None}
    entries |= {"limits": limited} if limited else {}
    entries |= {"filters": [_entries_of_filter(stage) for stage in drive.filters]} if drive.filters else {}
    entries |= {"set_point": _entries_of_filter(drive.set_point)} if drive.set_point else {}
    entries |= {"measured": drive.measured} if drive.measured != MOTOR else {}
    timed = (("dead_time", drive.dead_time), ("period", drive.period))
    return entries | {key: x for key, x in timed if x is not None}


def _entries_of_filter(stage: Filter | SetPointFilter) -> Mapping[str, Any]:
    if isinstance(stage, Average):
        return {"average": stage.time}
    if isinstance(stage, Notch):
        return {"notch": stage.frequency, "depth": stage.depth, "width": stage.width}
    return {"lowpass": stage.frequency, **({"order": stage.order} if stage.order != 1 else {})}


def drives_by_motor(drives: Drives) -> Iterable[tuple[str, Mapping[str, Any]]]:
    """TOML entries of all drives, by the names of their motors."""
    return ((name, entries_of_drive(drive)) for name, drive in drives.by_motor.items())
