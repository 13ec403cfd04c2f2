"""Programs partitioned into parts that a C compiler handles in time that grows in proportion.

The time of optimising compilers grows more than linearly with the length of straight code. A part is a function of its
own; variables that later parts need are spilled to an array.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import NamedTuple

from symoro_elastic.symbolic.program import Statement

LONGEST_WHOLE, LONGEST_PART = 1000, 500
"""Statements of an undivided function, and of parts of longer ones: for ARM gcc needs a third longer over parts
of 1000, and makes more instructions of them."""


class Step(NamedTuple):
    """A statement and the names it needs."""

    statement: Statement
    uses: frozenset[str]


@dataclass(frozen=True)
class Part:
    """Consecutive steps; `live_in` and `live_out` are slots of variables read from and written to the spill array."""

    steps: Sequence[Step]
    uses: frozenset[str]
    live_in: dict[str, int]
    live_out: dict[str, int]

    @property
    def spills(self) -> bool:
        """Whether the part uses the spill array."""
        return bool(self.live_in or self.live_out)


def partition(
    steps: Sequence[Step],
    needed_at_end: Iterable[str],
    longest: int = LONGEST_PART,
    whole: int = LONGEST_WHOLE,
    *,
    apart: bool = False,
) -> tuple[list[Part], int]:
    """Return parts of almost equal length, a single one up to `whole` steps, and the slots of the spill array.

    With `apart` no part writes to a slot that it reads, so that it may do both in any order.
    """
    count = ceil(len(steps) / longest) if len(steps) > whole else 1
    bounds = [len(steps) * k // count for k in range(count + 1)]
    pieces = [steps[first:last] for first, last in pairwise(bounds)]
    uses = [set().union(*(step.uses for step in piece)) for piece in pieces]
    uses[-1] |= set(needed_at_end)
    last_use = {name: k for k, names in enumerate(uses) for name in names}
    slots, parts = _Slots(), []
    for k, piece in enumerate(pieces):
        defined = [step.statement.name for step in piece]
        live_in = {name: slots.of[name] for name in sorted(uses[k] & slots.of.keys())}
        done = [name for name in live_in if last_use[name] == k]
        slots.release([] if apart else done)
        live_out = slots.assign([name for name in defined if last_use.get(name, k) > k])
        slots.release(done if apart else [])
        parts.append(Part(piece, frozenset(uses[k]), live_in, live_out))
    return parts, slots.count


class _Slots:
    """Slots of an array, assigned and released."""

    def __init__(self) -> None:
        self.of: dict[str, int] = {}
        self.empty: list[int] = []
        self.count = 0

    def release(self, names: Iterable[str]) -> None:
        self.empty += [self.of.pop(name) for name in names]

    def assign(self, names: Iterable[str]) -> dict[str, int]:
        assigned = {}
        for name in names:
            if not self.empty:
                self.empty.append(self.count)
                self.count += 1
            assigned[name] = self.of[name] = self.empty.pop()
        return assigned
