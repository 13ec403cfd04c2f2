"""Programs cut into parts that a C compiler handles in time that grows in proportion.

Optimising compilers take more than linear time on one long straight line. A part is a function of its own;
variables that later parts need travel in the array `live`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil

from symoro_elastic.symbolic.program import Statement

LONGEST_PART = 1000


@dataclass(frozen=True)
class Step:
    """A statement and the names it needs."""

    statement: Statement
    uses: frozenset[str]


@dataclass(frozen=True)
class Part:
    """Steps in a row; `taken` and `left` give the places in `live` of what comes from earlier parts and goes on."""

    steps: Sequence[Step]
    uses: frozenset[str]
    taken: dict[str, int]
    left: dict[str, int]


def cut(steps: Sequence[Step], needed_at_end: Iterable[str], longest: int = LONGEST_PART) -> tuple[list[Part], int]:
    """Parts of almost equal length, and how many places `live` has."""
    count = max(1, ceil(len(steps) / longest))
    bounds = [len(steps) * k // count for k in range(count + 1)]
    pieces = [steps[first:last] for first, last in pairwise(bounds)]
    uses = [set().union(*(step.uses for step in piece)) for piece in pieces]
    uses[-1] |= set(needed_at_end)
    last_use = {name: k for k, names in enumerate(uses) for name in names}
    places, parts = _Places(), []
    for k, piece in enumerate(pieces):
        made = [step.statement.name for step in piece]
        taken = {name: places.of[name] for name in sorted(uses[k] & places.of.keys())}
        places.free([name for name in taken if last_use[name] == k])
        left = places.give([name for name in made if last_use.get(name, k) > k])
        parts.append(Part(piece, frozenset(uses[k]), taken, left))
    return parts, places.count


class _Places:
    """Places in an array, given and taken back."""

    def __init__(self) -> None:
        self.of: dict[str, int] = {}
        self.empty: list[int] = []
        self.count = 0

    def free(self, names: Iterable[str]) -> None:
        self.empty += [self.of.pop(name) for name in names]

    def give(self, names: Iterable[str]) -> dict[str, int]:
        given = {}
        for name in names:
            if not self.empty:
                self.empty.append(self.count)
                self.count += 1
            given[name] = self.of[name] = self.empty.pop()
        return given
