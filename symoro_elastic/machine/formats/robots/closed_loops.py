"""Connections of links as closed loops of the table: a cut row on one link, a fixed row on the other, which meet."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.machine.formats.robots.description import Connection, Placement
from symoro_elastic.machine.formats.robots.rows import Tolerance, number_cell, rows_of
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Joint, Kind, Machine

Place = Callable[[str], tuple[int, Placement]]
"""Number of the row that carries a link, 0 for frame 0, and the placement of the link in the frame of that row."""


def closed(machine: Machine, connections: Sequence[Connection], place: Place, tolerance: Tolerance) -> Machine:
    """Return the machine with a loop for each connection, its rows at the end of the table."""
    joints, loops = list(machine.joints), list[Loop]()
    for one in connections:
        ends = [(place(link), on) for link, on in ((one.first, one.on_first), (one.second, one.on_second))]
        if ends[1][0][0] == 0:
            ends.reverse()
        numbers = []
        for ((antecedent, link), on), kind in zip(ends, (Kind.FIXED, Kind.CUT), strict=True):
            at = link * on
            end = _End(one.name, kind, at if one.weld else Placement(translation=at.translation))
            joints += end.rows(antecedent, len(joints), tolerance)
            numbers.append(len(joints))
        closes = Closing.FRAME if one.weld else Closing.POINT
        loops.append(Loop(one.name, numbers[1], numbers[0], closes, one.dependent))
    found = replace(machine, joints=tuple(joints), loops=(*machine.loops, *loops))
    starts = {one.name: one.start for one in connections}
    return replace(found, loops=tuple(_with_start(found, loop, starts[loop.name]) for loop in found.loops))
