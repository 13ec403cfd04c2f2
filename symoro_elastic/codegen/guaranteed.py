"""What a function guarantees where its arguments are in a box, and the function that tells whether they are."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.templates import LINE


@dataclass(frozen=True)
class EntryRange:
    """The range of one entry of an argument, its ends included."""

    argument: str
    entry: int
    low: float
    high: float


@dataclass(frozen=True)
class Guaranteed:
    """The box of a function in one precision, and what holds there in sentences."""

    ranges: tuple[EntryRange, ...]
    sentences: tuple[str, ...]

    @property
    def lines(self) -> list[str]:
        """The sentences in lines of a comment."""
        return [line for text in self.sentences for line in textwrap.wrap(text, LINE, subsequent_indent="  ")]

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
