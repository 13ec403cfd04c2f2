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
    start = _start(columns, "start", columns.found.extensions.get("start") or {}, joints)
    if start and not said:
        raise columns.fail("start", f"there is no closed loop (NJ = NL = {columns.counts.bodies}): leave it out")
    return tuple(
        _loop(columns, joints, k, name, entries, start) for k, (name, entries) in enumerate(said.items(), start=1)
    )


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


def _loop(
    columns: Columns, joints: Sequence[Joint], k: int, name: str, said: Mapping[str, Any], start: dict[str, Formula]
) -> Loop:
    """Loop number k: the cut joint is row NL + k, the frame that it meets is row NJ + k."""
    closes = said.get("closes", Closing.FRAME.value)
    if closes not in tuple(Closing):
        raise _fail(columns, f"{name}, closes", f"{quoted(closes)} must be one of {', '.join(Closing)}")
    own = _start(columns, f"loops, {name}, start", said["start"] or {}, joints) if "start" in said else start
    return Loop(
        name=name,
        cut=columns.counts.bodies + k,
        meets=columns.counts.joints + k,
        closes=Closing(closes),
        dependent=_dependent(columns, name, said.get("dependent") or [], joints),
        start=own,
    )


def _dependent(columns: Columns, loop: str, said: Any, joints: Sequence[Joint]) -> tuple[str, ...]:
    """Names of joints, which may be called by their variables."""
    if not isinstance(said, list) or not all(map(_is_text, said)):
        raise _fail(columns, f"{loop}, dependent", "must be a list of joints: {th3, th8}")
    by_variable = {joint.variable: joint.name for joint in joints if joint.variable}
    known = {**by_variable, **{name: name for name in columns.names}}
    for name in said:
        if name not in known:
            raise _fail(columns, f"{loop}, dependent", f"no joint {quoted(name)}{did_you_mean(name, map(str, known))}")
    return tuple(known[name] for name in said)


def _start(columns: Columns, key: str, said: Any, joints: Sequence[Joint]) -> dict[str, Formula]:
    """One rough position: values of joint variables."""
    if not isinstance(said, dict) or not all(map(_is_text, said.values())):
        raise columns.fail(key, "must be a table of joint variables: {th2 = -1.0, th3 = pi/2}")
    variables = [joint.variable for joint in joints if joint.variable]
    for name in said:
        if name not in variables:
            raise columns.fail(key, f"no joint variable {quoted(name)}{did_you_mean(name, variables)}")
    return {name: formula(value, columns.source, f"(*! {key} *), {name}") for name, value in said.items()}


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _fail(columns: Columns, place: str, what: str) -> InputError:
    return columns.fail(f"loops, {place}" if place.isprintable() and len(place) < 100 else "loops", what)


def common_start(loops: Sequence[Loop]) -> dict[str, Formula]:
    """The position that all loops start from; empty where they differ."""
    first = loops[0].start if loops else {}
    return first if all(loop.start == first for loop in loops) else {}
