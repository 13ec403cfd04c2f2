"""Guarantees of a function for arguments in a box, and the function that tests whether they are in it."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.templates import LINE


@dataclass(frozen=True)
class EntryRange:
    """The closed range of an entry of an argument."""

    argument: str
    entry: int
    low: float
    high: float


@dataclass(frozen=True)
class Guaranteed:
    """The operating range (box) of a function in a precision, and the sentences on its guarantees."""

    ranges: tuple[EntryRange, ...]
    sentences: tuple[str, ...]

    @property
    def lines(self) -> list[str]:
        """The sentences in lines of a comment."""
        return [line for text in self.sentences for line in textwrap.wrap(text, LINE, subsequent_indent="  ")]

    def ends(self, argument: str, size: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lower and upper bounds of all entries of an argument; infinite for entries without a range."""
        low, high = [-math.inf] * size, [math.inf] * size
        for span in self.ranges:
            if span.argument == argument:
                low[span.entry], high[span.entry] = span.low, span.high
        return tuple(low), tuple(high)

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments with ranges."""
        return tuple(dict.fromkeys(span.argument for span in self.ranges))


def conditions(ranges: Sequence[EntryRange], cast: str = "") -> list[str]:
    """C comparisons of doubles, all true inside the ranges and false for NaN."""
    entries = [(f"{cast}{span.argument}[{span.entry}]", span) for span in ranges]
    return [text for entry, span in entries for text in (f"{entry} >= {span.low!r}", f"{entry} <= {span.high!r}")]
