"""Tables of spreadsheets and recorders: columns between commas, semicolons, tabs or spaces."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

COMMA, SPACES, OTHERS = ",", " ", ";\t"
NUMBER = re.compile(r"[+-]?((\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?|nan|inf(inity)?)", re.ASCII | re.IGNORECASE)
_WITHIN = re.compile(r'"[^"]*"|\([^()]*\)')
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*,\d*(?:[eE][-+]?\d+)?\s*", re.ASCII)
_POINT = re.compile(r"\s*[-+]?(?:\d+\.\d*|\.\d+)(?:[eE][-+]?\d+)?\s*", re.ASCII)
_BETWEEN_SPACES = re.compile(r"(?:[^\s\[(]+\s*)?(?:\[[^\]]*\]|\([^)]*\))\S*|\S+")
_COMMENT = re.compile(r"\s*(?:#+|%+|//)(?![,;\t])\s*")


def separator_of(header: str) -> str:
    """Return the separator of a table's columns, from its header line: a comma, else a semicolon or a tab.

    Commas of points, `tool at (0.1, 0, 0).ax`, and in quotes separate nothing.
    """
    bare = _WITHIN.sub("", header)
    return next((sign for sign in OTHERS if sign in bare and COMMA not in bare), COMMA)


def separator_of_numbers(line: str) -> str:
    """Return the separator of a line of at least one number; empty for other lines."""
    for sign in (*OTHERS, COMMA, SPACES):
        cells = [cell.strip() for cell in cells_of(line, sign)] if sign in line else [line.strip()]
        filled = [cell for cell in cells if cell]
        if filled and all(NUMBER.fullmatch(x) or (sign != COMMA and _DECIMAL_COMMA.fullmatch(x)) for x in filled):
            return sign if len(cells) > 1 else COMMA
    return ""


def cells_of(line: str, separator: str) -> list[str]:
    """Return the cells of a line; separated by spaces, a name keeps its unit in brackets."""
    if separator == SPACES:
        return _BETWEEN_SPACES.findall(line)
    return next(csv.reader([line], delimiter=separator), [])


def is_comment(line: str) -> bool:
    """Return whether a line is a comment."""
    return bool(_COMMENT.match(line))


def without_mark(line: str) -> str:
    """Return a line without a leading comment mark, which some programs put before the names of columns."""
    return _COMMENT.sub("", line, count=1) if is_comment(line) else line


class Decimals:
    """Number format of a table not separated by commas: decimal commas or decimal points, not both."""

    def __init__(self) -> None:
        self._has_commas = self._has_points = False

    def with_points(self, cells: Sequence[str]) -> list[str]:
        """Return cells with decimal points; raises `ValueError` if a table has decimal commas and points."""
        commas = [bool(_DECIMAL_COMMA.fullmatch(cell)) for cell in cells]
        self._has_commas |= any(commas)
        self._has_points |= any(_POINT.fullmatch(cell) for cell in cells)
        if self._has_commas and self._has_points:
            raise ValueError("numbers with decimal commas and with decimal points: write all in the same way")
        return [cell.replace(",", ".") if has else cell for cell, has in zip(cells, commas, strict=True)]
