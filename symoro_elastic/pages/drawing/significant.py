"""Numbers of pages and pictures with as many digits as are seen: the same text everywhere."""

from __future__ import annotations

from typing import Any

DIGITS = 9


def round_significant(x: Any, digits: int = DIGITS) -> Any:
    """Return a number, or an array as lists, with so many significant digits; numbers that are whole as such."""
    if hasattr(x, "tolist"):
        x = x.tolist()
    if isinstance(x, list):
        return [round_significant(each, digits) for each in x]
    found = float(f"{x:.{digits}g}")
    return int(found) if found.is_integer() and abs(found) < 1e15 else found
