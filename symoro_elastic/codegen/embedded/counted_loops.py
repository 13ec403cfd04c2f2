"""How often the loops of generated C run at most, by line: read from the text of the C."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

FOR = re.compile(r"\s*for \(size_t (\w+) = [^;]+; \1 < ([^;]+); \1\+\+\)")
DOWN = re.compile(r"\s*for \(size_t (\w+) = (\w+); \1 > 0U; \1--\)")
WHILE = re.compile(r"\s*while \(large > 0U\)")
TERMS = "terms"
LONGEST_SERIES = 14
"""Terms of the polynomials of sines and cosines that are summed in a loop."""


@dataclass(frozen=True)
class LoopBounds:
    """The most passes of loops: by the line of a loop, and of the one around a line that has most; lines from 1."""

    of: Mapping[int, int]
    around: Mapping[int, int] = field(default_factory=dict)


def loop_bounds(source: str, angles: int) -> LoopBounds:
    """Return the bounds of loops; those that have none in the text are left out.

    `angles` are those whose sines and cosines are found together: `count` in the functions that find them.
    """
    known = {"count": angles, TERMS: LONGEST_SERIES}
    found: dict[int, int] = {}
    around: dict[int, int] = {}
    open_loops: list[tuple[str, int]] = []
    for number, line in enumerate(source.split("\n"), start=1):
        while open_loops and line == f"{open_loops[-1][0]}}}":
            open_loops.pop()
        if open_loops:
            around[number] = max(passes for _, passes in open_loops)
        passes = _passes(line, known)
        if passes is not None:
            found[number] = passes
            open_loops.append((line[: len(line) - len(line.lstrip())], passes))
    return LoopBounds(found, around)


def _passes(line: str, known: dict[str, int]) -> int | None:
    """How often the loop that begins in a line runs, which is then `known` of its variable."""
    if WHILE.match(line):
        return known["count"]
    match = FOR.match(line) or DOWN.match(line)
    passes = _product(match[2], known) if match else None
    if match and passes is not None:
        known[match[1]] = passes
    return passes


def _product(text: str, known: Mapping[str, int]) -> int | None:
    """The value of `2U*9U`, or of a variable that is less than one that is known."""
    value = 1
    for factor in text.split("*"):
        digits = factor.strip().removesuffix("U")
        if not digits.isdigit() and digits not in known:
            return None
        value *= int(digits) if digits.isdigit() else known[digits]
    return value
