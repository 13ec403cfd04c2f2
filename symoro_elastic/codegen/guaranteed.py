"""What a function guarantees where its arguments are in a box, and the function that tells whether they are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class EntryRange:
    """The range of one entry of an argument, its ends included."""

    argument: str
    entry: int
    low: float
    high: float


@dataclass(frozen=True)
class Guaranteed:
    """The box of a function, and what holds there: sentences by the name of the precision."""

    ranges: tuple[EntryRange, ...]
    sentences: Mapping[str, tuple[str, ...]]

    def said(self, precision: str) -> tuple[str, ...]:
        """The sentences on a precision; none where nothing was certified."""
        return self.sentences.get(precision, ())

    def ends(self, argument: str, size: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lower and upper ends of all entries of an argument; infinite where an entry does not count."""
        low, high = [-math.inf] * size, [math.inf] * size
        for one in self.ranges:
            if one.argument == argument:
                low[one.entry], high[one.entry] = one.low, one.high
        return tuple(low), tuple(high)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments of which entries have ranges."""
        return tuple(dict.fromkeys(one.argument for one in self.ranges))


def conditions(ranges: Sequence[EntryRange], cast: str = "") -> list[str]:
    """Comparisons in C, of doubles; all of them hold in the box, and none holds for NaN."""
    entries = [(f"{cast}{one.argument}[{one.entry}]", one) for one in ranges]
    return [text for entry, one in entries for text in (f"{entry} >= {one.low!r}", f"{entry} <= {one.high!r}")]
