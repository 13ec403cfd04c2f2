"""How often the loops of generated C run at most, by line: read from the text of the C."""

from __future__ import annotations

import re
from collections.abc import Mapping

FOR = re.compile(r"\s*for \(size_t (\w+) = [^;]+; \1 < ([^;]+); \1\+\+\)")
DOWN = re.compile(r"\s*for \(size_t (\w+) = (\w+); \1 > 0U; \1--\)")
WHILE = re.compile(r"\s*while \(large > 0U\)")
TERMS = "terms"
LONGEST_SERIES = 14
"""Terms of the polynomials of sines and cosines that are summed in a loop."""


def loop_bounds(source: str, angles: int) -> dict[int, int]:
    """Return the most passes of each loop by its line, from 1; loops that have no bound in the text are left out.

    `angles` are those whose sines and cosines are found together: `count` in the functions that find them.
    """
    known = {"count": angles, TERMS: LONGEST_SERIES}
    found: dict[int, int] = {}
    for number, line in enumerate(source.split("\n"), start=1):
        if WHILE.match(line):
            found[number] = angles
        elif match := FOR.match(line) or DOWN.match(line):
            passes = _product(match[2], known)
            if passes is not None:
                found[number] = known[match[1]] = passes
    return found


def _product(text: str, known: Mapping[str, int]) -> int | None:
    """The value of `2U*9U`, or of a variable that is less than one that is known."""
    value = 1
    for factor in text.split("*"):
        digits = factor.strip().removesuffix("U")
        if not digits.isdigit() and digits not in known:
            return None
        value *= int(digits) if digits.isdigit() else known[digits]
    return value
