"""Closed loops in a TOML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symoro_elastic.machine.formats.keys import Key
from symoro_elastic.machine.formats.tables import Table
from symoro_elastic.machine.formats.toml_keys import CLOSES, CUT, DEPENDENT, LOOPS, MEETS, START
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Joint
from symoro_elastic.machine.names import did_you_mean, quoted


def loops_of(top: Table, joints: Sequence[Joint]) -> tuple[Loop, ...]:
    """The loops of a file with these joints; raises `InputError`."""
    rows = {joint.name: j for j, joint in reversed([*enumerate(joints, start=1)])}
    by_variable = {joint.variable: joint.name for joint in joints if joint.variable}
    table = top.table("loops")
    entries = {name: replace(table.table(name), place=f"loop {_shown(name)}") for name in table.entries}
    return tuple(_loop(name, entry.only(LOOPS.names), rows, by_variable) for name, entry in entries.items())


def _loop(name: str, entry: Table, rows: Mapping[str, int], by_variable: Mapping[str, str]) -> Loop:
    dependent = DEPENDENT.read(entry)
    for one in dependent:
        if one not in rows and one not in by_variable:
            raise entry.fail(DEPENDENT.name, f"no joint {quoted(one)}{did_you_mean(one, [*rows, *by_variable])}")
    return Loop(
        name=name,
        cut=_row(entry, CUT, rows),
        meets=_row(entry, MEETS, rows),
        closes=Closing(CLOSES.read(entry)),
        dependent=tuple(one if one in rows else by_variable[one] for one in dependent),
        start=START.read(entry),
    )


def _row(entry: Table, key: Key, rows: Mapping[str, int]) -> int:
    name = key.read(entry)
    if name not in rows:
        raise entry.fail(key.name, f"no joint {quoted(name)}{did_you_mean(name, rows)}")
    return rows[name]


def _shown(name: str) -> str:
    return name if name.isidentifier() and len(name) < 100 else quoted(name)
