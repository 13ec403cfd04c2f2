"""Tables as spreadsheets write them: columns between commas, or between semicolons or tabs with decimal commas."""

from __future__ import annotations

import re
from collections.abc import Sequence

COMMA, OTHERS = ",", ";\t"
_WITHIN = re.compile(r'"[^"]*"|\([^()]*\)')
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d*(?:[eE][-+]?\d+)?\s*", re.ASCII)
_POINT = re.compile(r"\s*[-+]?(?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?\s*", re.ASCII)


def separator_of(header: str) -> str:
    """Return what stands between the columns of a table, by its header line: a comma, else a semicolon or a tab.

    Commas of points, `tool at (0.1, 0, 0).ax`, and in quotes separate nothing.
    """
    bare = _WITHIN.sub("", header)
    return next((sign for sign in OTHERS if sign in bare and COMMA not in bare), COMMA)


class Decimals:
    """Numbers of a table whose columns are not separated by commas: with decimal commas or points, not both."""

    def __init__(self) -> None:
        self._has_commas = self._has_points = False

    def with_points(self, cells: Sequence[str]) -> list[str]:
        """Return cells with decimal points; raises `ValueError` where a table has both signs."""
        commas = [bool(_DECIMAL_COMMA.fullmatch(cell)) for cell in cells]
        self._has_commas |= any(commas)
        self._has_points |= any(_POINT.fullmatch(cell) for cell in cells)
        if self._has_commas and self._has_points:
            raise ValueError("numbers with decimal commas and with decimal points: write all of them alike")
        return [cell.replace(",", ".") if has else cell for cell, has in zip(cells, commas, strict=True)]
