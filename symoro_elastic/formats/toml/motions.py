"""Motions, and requirements on them, in the tables [motion] and [wanted] of a machine file or a scene."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.toml.motion_keys import (
    BANDWIDTH,
    BASE,
    BASE_START,
    FORCES,
    GAINS,
    MOTION,
    MOTIONS,
    MOVES,
    SERVO,
    WANTED,
    WOBBLES,
)
from symoro_elastic.formats.toml.tables import Table, load
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import (
    WRENCH,
    AppliedForce,
    Bandwidth,
    BaseStart,
    Gains,
    Move,
    PrescribedMotion,
    Servo,
    Wobble,
)
from symoro_elastic.machine.resolve import refuse_unfulfillable, resolve_motion

Entries = dict[str, Any]
"""A table as it is written: texts, numbers, lists and tables."""


def read_motions(path: str | Path, machine: Machine) -> tuple[PrescribedMotion, ...]:
    """Read the motions in a scene file, with names of joints resolved in `machine`; raises `InputError`."""
    return motions_of(load(load_text(path), str(path)), machine)


def read_wanted(path: str | Path) -> Wanted | None:
    """Read the requirements (accuracy, outputs) in a scene file; raises `InputError`."""
    return wanted_of(load(load_text(path), str(path)))


def motions_of(top: Table, machine: Machine) -> tuple[PrescribedMotion, ...]:
    """Read the motions in the top table of a file, with names of joints of `machine`."""
    if MOTIONS.name not in top.entries:
        return ()
    tables = MOTIONS.type.read(top, MOTIONS.name)
    places = [MOTIONS.name] if len(tables) == 1 else [f"{MOTIONS.name} {k}" for k in range(1, len(tables) + 1)]
    at_places = [replace(table, place=place) for table, place in zip(tables, places, strict=True)]
    return tuple(resolve_motion(_motion(table), machine) for table in at_places)


def wanted_of(top: Table) -> Wanted | None:
    """Read the requirements in the top table of a file; None without such a table."""
    if "wanted" not in top.entries:
        return None
    table = top.table("wanted").only(WANTED.names)
    requirements = {key.name: key.read(table) for key in WANTED.keys if key.name in table.entries}
    wanted = Wanted(**requirements, source=top.source)
    refuse_unfulfillable(wanted)
    return wanted


def _motion(table: Table) -> PrescribedMotion:
    """Read the motion in a table, with names as written."""
    table.only(MOTION.names)
    entries = {key.name: key.read(table) for key in MOTION.keys if key is not BASE}
    moves, wobbles, forces = (_rows(table, key) for key in ("moves", "wobbles", "forces"))
    servos = table.table("servo")
    entries |= {
        "moves": tuple(Move(x["motor"], x["by"], x["from"], x["in"]) for x in map(MOVES.within, moves)),
        "wobbles": tuple(Wobble(**WOBBLES.within(entry)) for entry in wobbles),
        "servo": {name: _servo(servos.table(name)) for name in servos.entries},
        "forces": tuple(
            AppliedForce(x["at"], tuple(x[name] for name in WRENCH), x["from"], x["in"])
            for x in map(FORCES.within, forces)
        ),
        "base": BaseStart(**BASE_START.within(table.table(BASE.name))) if BASE.name in table.entries else None,
    }
    if entries["drives"] and entries["servo"]:
        raise table.fail("drives", "motors have drives or servos: remove one of the two")
    return PrescribedMotion(**entries, source=table.source, place=table.place)


def _rows(table: Table, key: str) -> list[Table]:
    return [replace(entry, place=f"{table.at(key)} {k}") for k, entry in enumerate(table.tables(key), 1)]


def _servo(table: Table) -> Servo:
    """Read a servo: gains kp, kd, or bandwidth and damping; one complete pair."""
    table.only(SERVO.names)
    keys = {*table.entries}
    for pair, law in ((GAINS, Gains), (BANDWIDTH, Bandwidth)):
        if keys == {key.name for key in pair}:
            return law(*(key.type.read(table, key.name) for key in pair))
    raise InputError(table.source, table.place, "give kp and kd, or bandwidth and damping")


# Writing


def entries_of_motion(motion: PrescribedMotion) -> Entries:
    """TOML entries of a motion, defaults omitted."""
    table = {
        "start": motion.start,
        "duration": motion.duration,
        "moves": [{"motor": x.motor, "by": x.by, **_times(x)} for x in motion.moves],
        "wobbles": [{"motor": x.motor, "amplitude": x.amplitude, "frequency": x.frequency} for x in motion.wobbles],
        "file": motion.file,
        "servo": {name: _entries_of_servo(servo) for name, servo in motion.servo.items()},
        "drives": motion.drives,
        "forces": [_entries_of_force(x) for x in motion.forces],
        "base": {}
        if motion.base is None
        else {key.name: list(getattr(motion.base, key.name)) for key in BASE_START.keys},
    }
    return {key: x for key, x in table.items() if x}


def entries_of_wanted(wanted: Wanted) -> Entries:
    """TOML entries of requirements, defaults omitted."""
    table = {name: getattr(wanted, name) for name in WANTED.names}
    return {key: list(x) if isinstance(x, tuple) else x for key, x in table.items() if x}


def _times(x: Move | AppliedForce) -> Entries:
    return {"from": x.begins, "in": x.lasts} if x.begins else {"in": x.lasts}


def _entries_of_servo(servo: Servo) -> Entries:
    keys, values = (GAINS, (servo.kp, servo.kd)) if isinstance(servo, Gains) else (
        BANDWIDTH, (servo.frequency, servo.damping)
    )  # fmt: skip
    return {key.name: x for key, x in zip(keys, values, strict=True)}


def _entries_of_force(force: AppliedForce) -> Entries:
    wrench = {name: x for name, x in zip(WRENCH, force.wrench, strict=True) if x}
    return {"at": force.at, **wrench, **_times(force)}
