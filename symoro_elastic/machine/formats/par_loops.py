"""Closed loops of a .par file: its last rows, and extension lines with what the format cannot say of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.cells import formula
from symoro_elastic.machine.formats.par_columns import Columns
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Joint
from symoro_elastic.machine.names import did_you_mean, quoted

KEYS = ("closes", "dependent", "start")
"""What the line of loops may say of each."""


def read_loops(columns: Columns, joints: Sequence[Joint]) -> tuple[Loop, ...]:
    """The loops of a file with these joints; raises `InputError`."""
    said = _said(columns)
    names = {joint.variable: joint.name for joint in joints if joint.variable}
    start = _start(columns, "start", columns.found.extensions.get("start") or {}, names)
    if start and not said:
        raise columns.fail("start", f"there is no closed loop (NJ = NL = {columns.counts.bodies}): leave it out")
    numbered = enumerate(said.items(), start=1)
    return tuple(_loop(columns, names, k, name, {"start": start, **entries}) for k, (name, entries) in numbered)


def _said(columns: Columns) -> dict[str, dict[str, Any]]:
    """What the file says of each loop, by its name; the loops are loop_1, loop_2 ... unless it names them."""
    count = columns.counts.loops
    if "loops" not in columns.found.extensions:
        return {f"loop_{k}": {} for k in range(1, count + 1)}
    value = columns.found.extensions["loops"]
    said = {name: {} for name in value} if isinstance(value, list) and all(map(_is_text, value)) else value
    if not isinstance(said, dict):
        raise columns.fail("loops", "must be names, or a table: {left = {closes = point}, right = {}}")
    if len(said) != count or len(said) != len(value):
        raise columns.fail("loops", f"names {len(value)} loops, expected {count} of different names (NJ - NL)")
    for name, entries in said.items():
        if not isinstance(entries or {}, dict) or not set(entries) <= set(KEYS):
            raise _fail(columns, name, f"must be a table with any of {', '.join(KEYS)}: {{closes = point}}")
    return {name: entries or {} for name, entries in said.items()}


def _loop(columns: Columns, names: Mapping[str, str], k: int, name: str, said: Mapping[str, Any]) -> Loop:
    """Loop number k: the cut joint is row NL + k, the frame that it meets is row NJ + k."""
    closes = said.get("closes", Closing.FRAME.value)
    if closes not in tuple(Closing):
        raise _fail(columns, f"{name}, closes", f"{quoted(closes)} must be one of {', '.join(Closing)}")
    return Loop(
        name=name,
        cut=columns.counts.bodies + k,
        meets=columns.counts.joints + k,
        closes=Closing(closes),
        dependent=_dependent(columns, name, said.get("dependent") or [], names),
        start=_start(columns, _place(f"{name}, start"), said["start"] or {}, names),
    )


def _dependent(columns: Columns, loop: str, said: Any, names: Mapping[str, str]) -> tuple[str, ...]:
    """Names of joints, which may be called by their variables."""
    if not isinstance(said, list) or not all(map(_is_text, said)):
        raise _fail(columns, f"{loop}, dependent", "must be a list of joints: {th3, th8}")
    for name in said:
        if name not in columns.numbers and name not in names:
            what = f"no joint {quoted(name)}{did_you_mean(name, [*names, *columns.names])}"
            raise _fail(columns, f"{loop}, dependent", what)
    return tuple(name if name in columns.numbers else names[name] for name in said)


def _start(columns: Columns, key: str, said: Any, names: Mapping[str, str]) -> dict[str, Formula]:
    """One rough position: values of joint variables."""
    if not isinstance(said, dict) or not all(isinstance(value, str | Formula) for value in said.values()):
        raise columns.fail(key, "must be a table of joint variables: {th2 = -1.0, th3 = pi/2}")
    for name in said:
        if name not in names:
            raise columns.fail(key, f"no joint variable {quoted(name)}{did_you_mean(name, names)}")
    place = f"(*! {key} *)"
    return {
        name: formula(value, columns.source, f"{place}, {name}") if isinstance(value, str) else value
        for name, value in said.items()
    }


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _fail(columns: Columns, place: str, what: str) -> InputError:
    return columns.fail(_place(place), what)


def _place(place: str) -> str:
    """The name of an entry of the line of loops in messages."""
    return f"loops, {place}" if place.isprintable() and len(place) < 100 else "loops"


def common_start(loops: Sequence[Loop]) -> dict[str, Formula]:
    """The position that all loops start from; empty where they differ."""
    first = loops[0].start if loops else {}
    return first if all(loop.start == first for loop in loops) else {}
