"""Connections of links as closed loops: a cut row of the table on one link, a fixed row on the other, which meet."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from symoro_elastic.machine.formats.robots.description import Connection, Placement
from symoro_elastic.machine.formats.robots.rows import Tolerance, number_cell, rows_of
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Joint, Kind, Machine

Place = Callable[[str], tuple[int, Placement]]
"""Number of the row that carries a link, 0 for frame 0, and the placement of the link in the frame of that row."""


def closed(machine: Machine, connections: Sequence[Connection], place: Place, tolerance: Tolerance) -> Machine:
    """Return the machine with a loop for each connection, the rows that meet at the end of its table."""
    for connection in connections:
        machine = _closed(machine, connection, place, tolerance)
    return machine


def _closed(machine: Machine, connection: Connection, place: Place, tolerance: Tolerance) -> Machine:
    first, second = (place(link) for link in (connection.first, connection.second))
    ends = [(*first, connection.on_first), (*second, connection.on_second)]
    if second[0] == 0:
        ends.reverse()
    joints, numbers = machine.joints, list[int]()
    for (antecedent, link, on), kind in zip(ends, (Kind.FIXED, Kind.CUT), strict=True):
        at = link * on
        joints += tuple(_rows(connection, kind, at, antecedent, len(joints), tolerance))
        numbers.append(len(joints))
    closes = Closing.FRAME if connection.weld else Closing.POINT
    loop = Loop(connection.name, numbers[1], numbers[0], closes, connection.dependent)
    return _with_start(replace(machine, joints=joints, loops=(*machine.loops, loop)), loop, connection)


def _rows(
    connection: Connection, kind: Kind, at: Placement, antecedent: int, count: int, tolerance: Tolerance
) -> Iterator[Joint]:
    """The rows from a link to the frame that meets another, of which only the last is of this kind."""
    name = f"{connection.name}_{'cut' if kind is Kind.CUT else 'meets'}"
    *seats, last = rows_of(at if connection.weld else Placement(translation=at.translation), tolerance)
    for seat in seats:
        yield seat.put_into(Joint(f"{name}_seat", antecedent, Kind.FIXED, 2), tolerance)
        antecedent = count = count + 1
    yield last.put_into(Joint(name, antecedent, kind, 2), tolerance)


def _with_start(machine: Machine, loop: Loop, connection: Connection) -> Machine:
    """The machine whose loop, its last one, starts where the connection does, if it says so."""
    if not connection.start:
        return machine
    owners = map(machine.joint, machine.owners_in(loop))
    start = {str(joint.variable): number_cell(connection.start.get(joint.name, 0.0)) for joint in owners}
    return replace(machine, loops=(*machine.loops[:-1], replace(loop, start=start)))
