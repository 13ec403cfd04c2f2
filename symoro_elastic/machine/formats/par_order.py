"""The order of rows in a .par file: those with bodies, then cut joints, then the frames that these meet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from symoro_elastic.machine.machine import Machine


def renumbered(machine: Machine, rows: Sequence[int]) -> Machine:
    """The machine with its rows, each once, in this order; antecedents and loops follow."""
    number = {old: new for new, old in enumerate(rows, start=1)}
    joints = (replace(machine.joint(j), antecedent=number.get(machine.joint(j).antecedent, 0)) for j in rows)
    loops = (replace(loop, cut=number[loop.cut], meets=number[loop.meets]) for loop in machine.loops)
    return replace(machine, joints=tuple(joints), loops=tuple(loops))


def order_of(machine: Machine) -> tuple[int, ...]:
    """Numbers of the rows in the order of a .par file; raises `InputError` for a machine that it cannot hold."""
    last = [*(loop.cut for loop in machine.loops), *(loop.meets for loop in machine.loops)]
    times = Counter(last)
    for j in last:
        if times[j] > 1:
            what = "two loops close at this row: give each rows of its own, or write .toml"
            raise machine.error(f"joint {j} ({machine.joint(j).name})", what)
    rows = (*(j for j in range(1, len(machine.joints) + 1) if j not in times), *last)
    place = {j: k for k, j in enumerate(rows)}
    for j in rows:
        antecedent = machine.joint(j).antecedent
        if place.get(antecedent, -1) > place[j]:
            at = f"where a loop closes: a .par file lists {machine.joint(antecedent).name} last"
            what = f"it is carried by the frame {at}; mount it on another one, or write .toml"
            raise machine.error(f"joint {j} ({machine.joint(j).name}), antecedent", what)
    return rows
